"""What a stand-in for the area measure is told, where it is asked, and what its study shows."""

import math
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
import torch
from torch.testing import assert_close

from dexterity import docking
from dexterity.studies.docking import stand_in as study
from dexterity.studies.docking.area import arms
from dexterity.timing import Timing

ARMS = arms()
SMOKE = study.CONFIGS["smoke"]

every_arm = pytest.mark.parametrize("arm", ARMS.values(), ids=ARMS)


@pytest.fixture(scope="module")
def result():
    return study.run(SMOKE)


@every_arm
@pytest.mark.parametrize("turns", [1, 2, 3, -1])
def test_quarter_turns_change_neither_the_measure_nor_what_is_seen(arm, turns):
    poses = study.draw(arm, 300, seed=3)
    turned = study.quarter_turned(poses, turns)
    points = docking.square(0.2, 5)
    assert_close(
        docking.area_manipulability(arm, turned, points),
        docking.area_manipulability(arm, poses, points),
        rtol=0,
        atol=1e-12,
    )
    assert_close(study.seen(turned), study.seen(poses), rtol=0, atol=1e-12)
    assert (study.asked(arm, turned) == study.asked(arm, poses)).all()


def test_an_eighth_of_a_turn_changes_the_measure():
    arm = ARMS["stated"]
    poses = study.draw(arm, 300, seed=3)
    x, y, z, yaw = poses.unbind(-1)
    c = math.sqrt(0.5)
    turned = torch.stack([c * (x - y), c * (x + y), z, yaw + math.pi / 4], dim=-1)
    points = docking.square(0.2, 5)
    change = docking.area_manipulability(arm, turned, points) - docking.area_manipulability(
        arm, poses, points
    )
    assert change.abs().max() > 0.01


def test_what_is_seen_is_the_middle_of_the_area_in_the_base():
    poses = study.draw(ARMS["fitted"], 100, seed=4)
    middle = torch.linalg.inv(docking.base_pose(poses))[:, :3, 3]
    seen = study.seen(poses)
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
    asked = study.asked(arm, poses)
    assert (problem.area_manipulability(poses[~asked]) == 0).all()
    assert problem.area_manipulability(poses[asked]).median() > 0


@every_arm
def test_as_many_poses_are_drawn_as_were_wanted(arm):
    for count in (1, 100, 1000):
        poses = study.draw(arm, count, seed=count)
        assert poses.shape == (count, 4)
        assert study.asked(arm, poses).all()


def test_a_steep_slope_is_no_jump():
    def rate(poses):
        # A jump by 0.3 at x = 0, and a slope that is steep but continuous at x = 1.
        x = poses[..., 0]
        return 0.3 * (x > 0).double() + (x - 1).clamp(min=0).sqrt()

    x = torch.tensor([-0.5, -0.004, 0.007, 0.5, 0.999], dtype=torch.float64)
    poses = torch.stack([x, 0 * x, 0 * x, 0 * x], dim=-1)
    change, jump = study.steepness(rate, poses, least=0.05)
    assert_close(change, x.new_tensor([0.0, 0.3, 0.3, 0.0, math.sqrt(0.009)]), rtol=0, atol=1e-12)
    assert_close(jump, x.new_tensor([0.0, 0.3, 0.3, 0.0, 0.0]), rtol=0, atol=1e-3)


def test_shapes_of_a_run(result):
    seeds = len(SMOKE.seeds)
    assert result.arms.keys() == ARMS.keys()
    for arm in result.arms.values():
        assert arm.neurons in SMOKE.neurons
        assert arm.errors.keys() == arm.screens.keys() == {"network", "4 points", "9 points"}
        assert arm.screens["network"].kept.shape == (seeds, len(SMOKE.first))
        assert all(screen.kept.max() <= 1 for screen in arm.screens.values())
        assert all((np.diff(screen.kept, axis=1) >= 0).all() for screen in arm.screens.values())
        assert len(arm.errors["network"]["all"].largest) == seeds
        assert all(cut.network.shape == (seeds, SMOKE.cut) for cut in arm.cuts.values())
        assert arm.times == arm.searches == ()
        assert arm.teaching is None


def test_fewer_points_are_a_bound_and_prove_the_best(result):
    for arm in result.arms.values():
        for way in ("4 points", "9 points"):
            assert arm.screens[way].proven >= max(arm.screens[way].needed)
        assert arm.screens["network"].proven is None
        assert arm.screens["9 points"].proven <= arm.screens["4 points"].proven
    assert study.verdicts(result) == ()
    assert all(figure.holds for figure in study.acceptance(result))


def test_tables_without_and_with_times(result):
    assert study.time_table(result) == {}
    assert {row["search [ms]"] for row in study.screen_table(result).values()} == {"–"}
    timings = tuple(
        Timing(name, 100, 0.9 * t, t, 1.1 * t)
        for name, t in (("network", 1e-6), ("4 points", 1e-7), ("25 points", 3e-6))
    )
    timed = {
        name: replace(arm, times=timings, searches=timings[:2], teaching=2.0)
        for name, arm in result.arms.items()
    }
    timed = study.Result(timed)
    rows = study.time_table(timed)
    assert rows["stated arm", "4 points"]["poses that pay for teaching"] == "–"
    assert rows["stated arm", "25 points"]["poses that pay for teaching"] == f"{2 / 2e-6:,.0f}"
    assert study.screen_table(timed)["fitted arm", "network"]["search [ms]"] == "0.1"
    for table in (study.size_table, study.error_table, study.worst_table, study.screen_table):
        frame = pd.DataFrame.from_dict(table(result), orient="index")
        assert not frame.isna().any(axis=None)
        assert len(frame) >= 2
