"""Tasks: Table 1 of paper A, entry by entry, and the ranking of configurations."""

import numpy as np
import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st
from torch.testing import assert_close

import dexterity as dx
from dexterity import symbolic, tasks
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
    assert tasks.index_for(name) == Index("manipulability", "geometric")


@pytest.mark.parametrize("name", CONDITIONING)
def test_tasks_of_accuracy_are_graded_by_conditioning(name):
    assert tasks.TASKS[name].index == "kinematic_conditioning"
    assert "Table 1" in tasks.TASKS[name].where
    assert tasks.index_for(name) == Index("kinematic_conditioning", "geometric")


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
    with pytest.raises(ValueError, match=f"^task is '{name}'; did you mean '{nearest}'"):
        function(name)


KNOWN = {name for task in tasks.TASKS.values() for name in (task.name, *task.aliases)}


@given(name=st.text().filter(lambda name: name.strip().lower() not in KNOWN))
def test_any_unknown_task_is_refused(name):
    with pytest.raises(ValueError, match=r"(?s)^task is .*ne of .*welding"):
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


# ---- what may rank ---------------------------------------------------------------------------------

PUMA = dx.robots.puma560()


def short_arm() -> dx.Chain:
    rows = [{"d": 0.05, "a": 0.02, "alpha": 1.57}, {"a": 0.15}, {"a": 0.02, "alpha": -1.57}]
    return dx.Chain.from_dh([*rows, {"d": 0.18, "alpha": 1.57}, {"d": 0.05}], name="short arm")


def test_tasks_are_ranked_about_the_tool(rng):
    """Not about the world's origin, in which the order is another one."""
    q = rng.uniform(-2, 2, (200, 6))
    ranking = tasks.rank(PUMA, q, "welding")
    assert ranking.index.frame == "geometric"
    assert ranking.order.tolist() == tasks.rank(PUMA, q, "welding", frame="geometric").order.tolist()
    assert ranking.best(50).tolist() != tasks.rank(PUMA, q, "welding", frame="spatial").best(50).tolist()


def test_an_index_a_name_a_task_and_a_compiled_index_rank_alike(rng):
    q = torch.from_numpy(rng.uniform(-2, 2, (50, 6)))
    index = Index("kci", "geometric", rows="translational")
    own = tasks.Task("my weld", "kci", rows="translational")
    rankings = [tasks.rank(PUMA, q, way) for way in (index, own, symbolic.compile_index(PUMA, index))]
    for ranking in rankings:
        assert ranking.order.tolist() == rankings[0].order.tolist()
        assert ranking.index == index
        assert_close(ranking.values, index(PUMA, q), rtol=1e-9, atol=1e-13)
    by_name = tasks.rank(PUMA, q, "KCI")
    assert by_name.index == Index("kci", "geometric")


def test_smaller_is_better_where_the_measure_says_so(rng):
    ranking = tasks.rank(PUMA, rng.uniform(-2, 2, (50, 6)), "tool_deviation")
    assert (ranking.values[ranking.order].diff() >= 0).all()
    assert ranking.effect.over_worst >= ranking.effect.over_median >= 1


def test_the_effect_compares_the_best_with_the_median_and_the_worst():
    q = torch.zeros(3, 2, dtype=torch.float64)
    q[:, 1] = torch.tensor([0.1, 0.9, 0.4], dtype=torch.float64)
    arm = dx.Chain.from_dh([{"a": 1.0}, {"a": 1.0}])
    w = Index("w", "geometric", rows=("vx", "vy"))
    ranking, sine = tasks.rank(arm, q, w), np.sin([0.9, 0.4, 0.1])
    effect = ranking.effect
    np.testing.assert_allclose([effect.best, effect.median, effect.worst], sine, rtol=1e-12)
    np.testing.assert_allclose([effect.over_median, effect.over_worst], sine[0] / sine[1:], rtol=1e-12)
    assert ranking.best().tolist() == [1]
    assert ranking.best(10).tolist() == [1, 2, 0]
    assert repr(ranking).endswith("3 candidates, best 1 (0.7833), 2 (0.3894), 0 (0.09983))")
    text = ranking.explain()
    assert "candidate 1 with 0.7833" in text
    assert w.measure.meaning in text
    logs = tasks.rank(arm, q, Index("log_w", "geometric", rows=("vx", "vy"))).effect
    np.testing.assert_allclose(logs.over_worst, np.log(sine[0] / sine[2]), rtol=1e-12)


@pytest.mark.parametrize("task", ["welding", "cutting", "w", Index("kci"), tasks.Task("mine", "log_w")])
def test_an_index_that_is_zero_everywhere_ranks_nothing(task):
    with pytest.raises(
        ValueError, match=r"^short arm has 5 joints; .* everywhere.*Take rows='translational'"
    ):
        tasks.rank(short_arm(), np.zeros((2, 5)), task)
    position, q = tasks.Task("positioning", "w", rows="translational"), np.full((2, 5), 0.5)
    assert (tasks.rank(short_arm(), q, position).values > 0).all()
    assert tasks.rank(short_arm(), q, "welding", rows="translational").index.rows == "translational"


def test_a_compiled_index_of_another_chain_is_refused(rng):
    compiled = symbolic.compile_index(dx.robots.docking_arm(), "w")
    with pytest.raises(ValueError, match=r"^task is .* compiled for another chain than puma560"):
        tasks.rank(PUMA, rng.uniform(-1, 1, (3, 6)), compiled)


@pytest.mark.usefixtures("annotations_unchecked")
@pytest.mark.parametrize("task", [None, 3, np.nan, ["welding"], len])
def test_what_is_no_task_is_refused(task):
    with pytest.raises(TypeError, match=r"^task is "):
        tasks.rank(PUMA, np.zeros((2, 6)), task)
    with pytest.raises(TypeError, match=r"^task is "):
        tasks.find(task)


def test_an_index_takes_no_frame_beside_its_own():
    with pytest.raises(ValueError, match=r"^frame is 'body'; an index has its own"):
        tasks.rank(PUMA, np.zeros((2, 6)), Index("w"), frame="body")


def test_an_unknown_task_lists_them_all():
    with pytest.raises(ValueError, match=r"^task is 'paint'") as error:
        tasks.find("paint")
    assert all(name in str(error.value) for name in tasks.TASKS)


@pytest.mark.usefixtures("annotations_unchecked")
@pytest.mark.parametrize("k", [0, -1, 1.5, True, "3", None])
def test_the_number_of_the_best_is_a_whole_one(k):
    with pytest.raises((TypeError, ValueError), match=r"^k is "):
        tasks.rank(PUMA, np.zeros((2, 6)), "welding").best(k)


@pytest.mark.usefixtures("annotations_unchecked")
@pytest.mark.parametrize(
    "given", [{"name": ""}, {"name": 3}, {"index": "x"}, {"rows": "x"}, {"also": "x"}, {"direction": "vx"}]
)
def test_a_task_that_means_nothing_is_refused(given):
    with pytest.raises((TypeError, ValueError), match=r" is "):
        tasks.Task(**({"name": "mine", "index": "w"} | given))


def test_an_empty_ranking_has_no_effect():
    with pytest.raises(ValueError, match="empty"):
        _ = tasks.rank(UVMS, np.zeros((0, 12)), "welding").effect
