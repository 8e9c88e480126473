"""The area measure of both arms: its limits, its maps, and which way the tool looks."""

import math

import pytest
import torch
from torch.testing import assert_close

from dexterity import docking, robots
from dexterity_study.docking.area import experiment
from dexterity_study.docking.cases import ARMS, printed, printed_poses

every_arm = pytest.mark.parametrize("reading", ARMS.values(), ids=ARMS)


@every_arm
def test_w_with_the_tool_upright_stays_below_the_product_of_its_factors(reading):
    elbow = experiment.elbow_of(robots.docking_arm("stated" if reading == "chosen" else "fitted"))
    length = elbow.upper_arm
    assert elbow.forearm == length
    # 1.41 l³ at most, as far as the links go.
    cap = experiment.closed_form(0, reading, configurations=10).where(reading)["cap"].item()
    assert cap == pytest.approx(1.41 * length**3, rel=0.01)


@every_arm
def test_w_is_the_same_with_the_tool_down(reading):
    arm = robots.docking_arm("stated" if reading == "chosen" else "fitted")
    points = docking.square(0.2, 5)
    up, down = (
        docking.largest_manipulability(arm, printed_poses(), points, tool)
        for tool in experiment.TOOLS.values()
    )
    assert_close(up, down, rtol=0, atol=1e-12)
    assert up.max() > 0.01


def test_angles_that_a_branch_has_are_found_through_full_turns():
    arm = robots.docking_arm()
    branch = torch.tensor([0.5, 1.0, -1.0, 0.0, -2.5, 0.1], dtype=torch.float64)
    turned = branch + 2 * math.pi * branch.new_tensor([0, 0, 0, 0, 1, 0])
    misses = experiment._misses(arm, turned, torch.stack([branch + 0.3, branch]))
    assert misses == pytest.approx([0.0] * 6, abs=1e-12)


def test_the_ill_placed_pose_is_on_the_quarter_of_the_first_run():
    ill, first = printed("ill-placed-pose"), printed_poses()[0]
    assert (torch.sign(ill[:2]) == torch.sign(first[:2])).all()


def test_more_control_points_leave_fewer_dead_spots():
    dead = experiment.control_points(drawn=20_000, fine_per_side=9).where().set_index("points")["dead"]
    assert (dead.diff().dropna() <= 0).all()
    assert dead[4] > 0
    assert dead[81] == 0
