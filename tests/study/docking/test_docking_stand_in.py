"""What a network for the area measure is told, where it is asked, and what bounds are worth."""

import math

import pytest
import torch
from torch.testing import assert_close

from dexterity import docking, indices, robots, spatial
from dexterity_study.docking import cases
from dexterity_study.docking.stand_in import experiment

ARMS = {name: robots.docking_arm(name) for name in ("stated", "fitted")}
every_arm = pytest.mark.parametrize("arm", ARMS.values(), ids=ARMS)


@every_arm
@pytest.mark.parametrize("turns", [1, 2, 3, -1])
def test_quarter_turns_change_neither_the_measure_nor_what_is_seen(arm, turns):
    poses = experiment.draw(arm, 300, seed=3)
    turned = cases.quarter_turned(poses, turns)
    assert_close(experiment.rated(arm, 5, turned), experiment.rated(arm, 5, poses), rtol=0, atol=1e-12)
    assert_close(experiment.seen(turned), experiment.seen(poses), rtol=0, atol=1e-12)
    assert (experiment.asked(arm, turned) == experiment.asked(arm, poses)).all()


def test_an_eighth_of_a_turn_changes_the_measure():
    arm = ARMS["stated"]
    poses = experiment.draw(arm, 300, seed=3)
    x, y, z, yaw = poses.unbind(-1)
    c = math.sqrt(0.5)
    turned = torch.stack([c * (x - y), c * (x + y), z, yaw + math.pi / 4], dim=-1)
    change = experiment.rated(arm, 5, turned) - experiment.rated(arm, 5, poses)
    assert change.abs().max() > 0.01


@every_arm
def test_turns_of_the_tool_about_its_axis_change_no_w(arm):
    poses, values = experiment.draw(arm, 20, seed=3), []
    for angle in (0.0, 0.7, 2.0, 4.0):
        turn = spatial.exp(torch.tensor([0, 0, 0, angle, 0, 0], dtype=torch.float64))[:3, :3]
        tool = torch.tensor(docking.TOOL_UP, dtype=torch.float64) @ turn
        q, valid, within = docking.configurations(arm, poses, docking.square(0.2), tool)
        w = indices.manipulability(arm.geometric_jacobian(q))
        values.append(torch.where(valid & within, w, 0.0).amax(-1))
    assert values[0].max() > 0.01
    for turned in values[1:]:
        assert_close(turned, values[0], rtol=0, atol=1e-12)


def test_what_is_seen_is_the_middle_of_the_area_in_the_base():
    poses = experiment.draw(ARMS["fitted"], 100, seed=4)
    middle = torch.linalg.inv(docking.base_pose(poses))[:, :3, 3]
    seen = experiment.seen(poses)
    assert_close(seen[:, :3], middle, rtol=0, atol=1e-12)
    folded = seen[:, 3]
    assert (folded >= -math.pi / 4).all()
    assert (folded < math.pi / 4).all()
    quarters = (poses[:, 3] - folded) / (math.pi / 2)
    assert_close(quarters, quarters.round(), rtol=0, atol=1e-12)


@every_arm
def test_where_it_is_not_asked_nothing_is_lost(arm):
    problem = docking.DockingProblem(arm, region="or")
    unit = torch.rand(20_000, 4, generator=torch.Generator().manual_seed(0), dtype=torch.float64)
    poses = problem.lower + (problem.upper - problem.lower) * unit
    poses = poses[problem.allows(poses)]
    asked = experiment.asked(arm, poses)
    assert (problem.area_manipulability(poses[~asked]) == 0).all()
    assert problem.area_manipulability(poses[asked]).median() > 0


@every_arm
def test_as_many_poses_are_drawn_as_were_wanted(arm):
    for count in (1, 100, 1000):
        poses = experiment.draw(arm, count, seed=count)
        assert poses.shape == (count, 4)
        assert experiment.asked(arm, poses).all()


@every_arm
def test_fewer_points_are_a_bound(arm):
    poses = experiment.draw(arm, 500, seed=5)
    assert (experiment.rated(arm, 2, poses) >= experiment.rated(arm, 5, poses)).all()


def test_a_bound_proves_the_best_and_more_points_prove_it_sooner():
    rows = experiment.ways.probe().where().set_index("way")
    few = rows.loc[["4 points", "9 points"]]
    assert (few["proven"] >= few["needed"]).all()
    assert few["proven"].is_monotonic_decreasing
    best = rows[["best_of_1", "best_of_10", "best_of_100"]].to_numpy()
    assert (best[:, 1:] >= best[:, :-1]).all()
    assert best.max() <= 1
