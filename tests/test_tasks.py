"""Tasks: Table 1 of paper A, entry by entry, and the ranking of configurations."""

import numpy as np
import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st
from torch.testing import assert_close

import dexterity as dx
from dexterity import tasks
from dexterity.indices import Index

UVMS = dx.robots.uvms()

# Table 1, in its order; names as the package gives them.
MANIPULABILITY = [
    "valve and lever manipulation",
    "structural component installation",
    "object recovery",
    "debris removal",
    "multiple task execution",
    "cutting",
    "cleaning",
]
CONDITIONING = [
    "precise manipulation",
    "high-precision cutting",
    "welding",
    "small component replacement",
    "non-destructive testing",
]


# ---- Table 1 ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", MANIPULABILITY)
def test_tasks_of_speed_and_force_are_graded_by_manipulability(name):
    assert tasks.TASKS[name].index == "manipulability"
    assert "Table 1" in tasks.TASKS[name].where
    assert tasks.index_for(name) == Index("manipulability")


@pytest.mark.parametrize("name", CONDITIONING)
def test_tasks_of_accuracy_are_graded_by_conditioning(name):
    assert tasks.TASKS[name].index == "kinematic_conditioning"
    assert "Table 1" in tasks.TASKS[name].where
    assert tasks.index_for(name) == Index("kinematic_conditioning")


def test_table_1_is_complete_and_in_order():
    in_table = [task.name for task in tasks.TASKS.values() if "Table 1" in task.where]
    assert in_table == MANIPULABILITY + CONDITIONING


def test_what_the_text_adds_is_marked_as_such():
    (added,) = [task for task in tasks.TASKS.values() if "Table 1" not in task.where]
    assert added.name == "fragile object recovery"
    assert added.index == "kinematic_conditioning"
    assert added.where == "section 2.3"
    assert "not in the table" in added.comment
    both = [task.name for task in tasks.TASKS.values() if task.also is not None]
    assert both == ["high-precision cutting"]
    assert tasks.TASKS["high-precision cutting"].also == "manipulability"


def test_each_task_has_a_comment_and_a_place():
    for name, task in tasks.TASKS.items():
        assert task.name == name == name.lower()
        assert task.comment
        assert "section 2.3" in task.where or "Table 1" in task.where


def test_no_two_tasks_share_a_name():
    names = [name for task in tasks.TASKS.values() for name in (task.name, *task.aliases)]
    assert len(set(names)) == len(names)


def test_the_mapping_cannot_be_changed():
    with pytest.raises(TypeError):
        tasks.TASKS["welding"] = tasks.TASKS["cutting"]


# ---- finding a task --------------------------------------------------------------------------------


def test_a_task_is_found_by_each_of_its_names_whatever_their_case():
    for task in tasks.TASKS.values():
        for name in (task.name, *task.aliases):
            assert tasks.find(name) is task
            assert tasks.find(f"  {name.upper()} ") is task


def test_valve_turning_is_an_alias():
    assert tasks.find("valve turning").name == "valve and lever manipulation"


@pytest.mark.parametrize(
    "function", [tasks.find, tasks.index_for, lambda task: tasks.rank(UVMS, np.zeros((1, 12)), task)]
)
@pytest.mark.parametrize(
    ("name", "nearest"),
    [
        ("weldin", "welding"),
        ("valve turnin", "valve turning"),
        ("nondestructive test", "nondestructive testing"),
    ],
)
def test_an_unknown_task_is_refused_with_the_nearest_names(function, name, nearest):
    with pytest.raises(ValueError, match=f"^task is '{name}'.*Nearest: {nearest}"):
        function(name)


KNOWN = {name for task in tasks.TASKS.values() for name in (task.name, *task.aliases)}


@given(name=st.text().filter(lambda name: name.strip().lower() not in KNOWN))
def test_any_unknown_task_is_refused(name):
    with pytest.raises(ValueError, match=r"(?s)^task is .*Nearest: [a-z]"):
        tasks.find(name)


def test_an_index_for_a_task_takes_frame_and_rates():
    index = tasks.index_for("welding", frame="body", joint_rates=(1,) * 12, tool_rates=(2,) * 6)
    assert index == Index("kinematic_conditioning", "body", (1.0,) * 12, (2.0,) * 6)


# ---- ranking ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("task", ["welding", "valve turning"])
def test_candidates_are_ranked_from_the_best_to_the_worst(rng, task):
    q = torch.from_numpy(rng.uniform(-2, 2, (50, 12)))
    ranking = tasks.rank(UVMS, q, task)
    assert ranking.task is tasks.find(task)
    assert ranking.index == tasks.index_for(task)
    assert_close(ranking.values, ranking.index.bind(UVMS)(q), rtol=0, atol=0)
    assert sorted(ranking.order.tolist()) == list(range(50))
    assert (ranking.values[ranking.order].diff() <= 0).all()


def test_equal_candidates_keep_their_order(rng):
    a, b = rng.uniform(-2, 2, (2, 12))
    order = tasks.rank(UVMS, [a.tolist(), b.tolist()] * 20, "welding").order.tolist()
    first, second = order[:20], order[20:]
    assert first == sorted(first)
    assert second == sorted(second)
    assert {i % 2 for i in first} != {i % 2 for i in second}


def test_welding_and_valve_turning_rank_differently(rng):
    q = rng.uniform(-2, 2, (50, 12))
    assert (
        tasks.rank(UVMS, q, "welding").order.tolist() != tasks.rank(UVMS, q, "valve turning").order.tolist()
    )


def test_frame_and_rates_of_a_ranking_are_those_of_its_index(rng):
    q = rng.uniform(-2, 2, (50, 12))
    given = {"frame": "body", "joint_rates": (0.5,) * 6 + (1.0,) * 6, "tool_rates": (0.5,) * 3 + (1.0,) * 3}
    ranking = tasks.rank(UVMS, q, "welding", **given)
    assert ranking.index == tasks.index_for("welding", **given)
    assert_close(ranking.values, ranking.index.bind(UVMS)(q), rtol=0, atol=0)


def test_no_candidates_have_an_empty_ranking():
    ranking = tasks.rank(UVMS, np.zeros((0, 12)), "welding")
    assert ranking.order.shape == ranking.values.shape == (0,)


@pytest.mark.parametrize("shape", [(), (12,), (2, 3, 12)])
def test_candidates_of_the_wrong_shape_are_refused(shape):
    with pytest.raises(ValueError, match=r"^q has shape .*\(candidates, 12\) is needed"):
        tasks.rank(UVMS, np.zeros(shape), "welding")


def test_candidates_of_the_wrong_number_of_joints_are_refused():
    with pytest.raises(ValueError, match=r"^q has shape \(3, 11\); the chain has 12 joints"):
        tasks.rank(UVMS, np.zeros((3, 11)), "welding")


@pytest.mark.parametrize("poison", [np.nan, np.inf])
def test_candidates_that_are_not_finite_are_refused(poison):
    q = np.zeros((3, 12))
    q[1, 4] = poison
    with pytest.raises(ValueError, match=r"^q is not finite"):
        tasks.rank(UVMS, q, "welding")
