"""Candidates of the chapter on tasks, what a choice among them costs, and the scenes."""

import math

import pytest
import torch
from torch.testing import assert_close

from dexterity import Chain, robots
from dexterity_study.uvms.tasks import experiment, goals, show, stages
from dexterity_study.uvms.tasks.candidates import SETS, candidates, holding

UVMS = robots.uvms()
DRAWN = candidates(seed=3, count=40)


def test_candidates_hold_the_tool_in_its_pose_at_home() -> None:
    assert_close(UVMS.forward(DRAWN), UVMS.home.expand(40, 4, 4), rtol=0, atol=1e-12)
    assert DRAWN[:, 3:9].std(dim=0).min() > 0.05
    assert_close(holding(DRAWN[:, 3:9]), DRAWN, rtol=0, atol=1e-12)


def test_sets_of_candidates_are_what_their_names_say() -> None:
    drawn = {name: one.draw(0, 200) for name, one in SETS.items()}
    largest = {name: q[:, 3:].abs().max().rad2deg() for name, q in drawn.items()}
    assert 14 < largest["random, ±15°"] <= 15
    assert 59 < largest["random, ±60°"] <= 60
    assert (drawn["arm alone, ±60°"][:, :6] == 0).all()
    assert SETS["arm alone, ±60°"].moves.tolist() == [0.0] * 6 + [1.0] * 6
    assert SETS["tool at rest"].moves.tolist() == [1.0] * 12


def test_the_effect_of_a_perfect_and_of_a_reversed_ranking() -> None:
    cost = torch.tensor([2.0, 3.0, 1.0, 4.0], dtype=torch.float64)
    assert goals.effect(-cost, cost) == goals.Effect(1.0, 1.0, 0.0)
    assert goals.effect(cost, cost) == goals.Effect(-1.0, 4.0, 0.75)
    between = goals.effect(torch.tensor([4.0, 3.0, 2.0, 1.0], dtype=torch.float64), cost)
    assert (between.loss, between.beaten) == (2.0, 0.25)
    assert between.tau == pytest.approx(1 / 3)


def test_costs_that_differ_by_rounding_have_no_ranking() -> None:
    cost = 1 + 1e-14 * torch.arange(5, dtype=torch.float64)
    judged = goals.effect(torch.arange(5, dtype=torch.float64), cost)
    assert math.isnan(judged.tau)
    assert (judged.loss, judged.beaten) == (1.0, 0.0)


def test_an_effect_needs_a_cost_for_each_score() -> None:
    with pytest.raises(ValueError, match="score has shape"):
        goals.effect(torch.ones(3), torch.ones(4))
    with pytest.raises(ValueError, match="not positive"):
        goals.effect(torch.ones(2), torch.tensor([1.0, 0.0]))


def test_effort_and_time_of_a_platform_with_two_motors_along_x() -> None:
    J = torch.cat([torch.eye(6), torch.eye(6)[:, :1]], dim=1).double()[None]
    assert goals.effort_per_force(2 * J, row=0).tolist() == [2.0]
    assert_close(goals.time_per_metre(J, row=0), torch.tensor([0.5]).double())
    assert_close(goals.time_per_metre(J, row=1), torch.tensor([1.0]).double())
    assert goals.time_per_metre(J * torch.tensor([0.0] + [1.0] * 5 + [0.0]), row=0).tolist() == [math.inf]


def test_time_keeps_all_other_rows_still() -> None:
    J = torch.eye(6).double()[None].clone()
    J[0, 1, 0] = 3.0
    # The first joint moves along y too, three times as fast; the second makes up for it.
    assert_close(goals.time_per_metre(J, row=0), torch.tensor([3.0]).double())


def test_the_miss_of_sliding_joints_is_that_of_their_errors() -> None:
    slides = Chain.from_dh([{"kind": "prismatic", "alpha": math.pi / 2}, {"kind": "prismatic"}])
    noise = torch.tensor([0.03, 0.04], dtype=torch.float64)
    missed = goals.root_mean_square_miss(slides, torch.zeros(1, 2).double(), noise, seed=0, draws=1024)
    assert_close(missed, torch.tensor([0.05]).double(), rtol=0.01, atol=0)


def test_kci_about_the_tool_is_the_geometric_one() -> None:
    rows = experiment.candidate_sets(0, "world-origin=tool", count=20)
    spatial, geometric = (
        rows.where(None, set="tool at rest", index=f"{frame} KCI").iloc[0]
        for frame in ("spatial", "geometric")
    )
    assert spatial[["tau", "loss", "beaten"]].tolist() == geometric[["tau", "loss", "beaten"]].tolist()


def test_the_place_of_the_origin_decides_the_sign() -> None:
    rows = experiment.origins(0, step=1.0, count=60).where().set_index("ahead")
    assert rows["tau"][0.25] < -0.2
    assert rows["tau"][3.25] > 0.2
    assert rows["loss"][0.25] > rows["loss"][3.25] >= 1


def test_no_posture_is_better_for_a_valve_on_the_axis_of_the_last_joint() -> None:
    for one in SETS.values():
        J = UVMS.body_jacobian(one.draw(0, 20)) * one.moves
        assert_close(goals.effort_per_force(J, experiment.TOOL_AXIS), torch.ones(20).double())


def test_the_noise_has_metres_and_radians() -> None:
    noise = experiment.joint_noise((0.05, 1.0, 0.1))
    assert_close(noise, torch.tensor([0.05] * 3 + [math.pi / 180] * 3 + [math.pi / 1800] * 6).double())


@pytest.mark.parametrize("task", stages.STAGES)
def test_a_stage_is_drawn_for_each_task(task: str) -> None:
    shown = show.best_and_worst(DRAWN, task).text
    assert shown.count("<iframe") == 2
    body = {"valve turning": "hand wheel", "welding": "seam", "inspection": "places to inspect"}[task]
    assert body in shown


def test_the_animation_passes_every_candidate_once_and_keeps_the_tool() -> None:
    order = show.tour(DRAWN[:, 3:9])
    assert sorted(order.tolist()) == list(range(40))
    frames = show.frames_between(DRAWN, order, per_step=4)
    assert len(frames) == 39 * 4 + 1
    assert_close(frames[::4, 3:9], DRAWN[order, 3:9])
    assert_close(UVMS.forward(frames), UVMS.home.expand(len(frames), 4, 4), rtol=0, atol=1e-12)
    assert frames.diff(dim=0).abs().max() < math.pi
