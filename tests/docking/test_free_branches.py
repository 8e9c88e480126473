"""Docking with bodies: the compiled branches against all branches, and how bodies change the optimum."""

import dataclasses
import math

import pytest
import torch
from torch.testing import assert_close

import dexterity as dx
from dexterity import collision, docking, indices
from dexterity.collision import Bodies, Body, Box, Capsule, in_c
from dexterity.docking import TOOL_UP, area_manipulability, block_and_vehicle, largest_manipulability, square
from dexterity.docking.area import _by_branches
from dexterity.docking.free_branches import FreeBranches

ARMS = {variant: dx.robots.docking_arm(variant) for variant in ("stated", "fitted")}
CORNERS = square(0.2)
THICK = {"radius": 0.03, "hand": 0.1, "excluded": [("hand", "block"), ("link 2", "link 4")]}
UPRIGHT = torch.tensor(TOOL_UP, dtype=torch.float64)

every_arm = pytest.mark.parametrize("arm", ARMS.values(), ids=ARMS)


def poses(count: int, tilted: bool = False, seed: int = 0) -> torch.Tensor:
    """Poses of the base above the block, most of which reach some of the task area."""
    random = torch.Generator().manual_seed(seed)
    unit = 2 * torch.rand(count, 6, generator=random, dtype=torch.float64) - 1
    pose = unit * torch.tensor([0.8, 0.8, 0.05, 0.2, 0.2, math.pi], dtype=torch.float64)
    pose[:, 2] += 0.25
    return pose if tilted else pose[:, [0, 1, 2, 5]]


# ---- the compiled branches -------------------------------------------------------------------------


@every_arm
@pytest.mark.parametrize("tilted", [False, True])
@pytest.mark.parametrize("sizes", [{}, THICK], ids=["lines", "thick"])
def test_it_is_the_best_of_all_branches_without_a_collision(arm, tilted, sizes):
    bodies = block_and_vehicle(arm, **sizes)
    assert FreeBranches.of(arm, bodies) is not None
    points = square(0.2, 3, height=sizes.get("hand", 0.0))
    pose = poses(400, tilted)
    found = largest_manipulability(arm, pose, points, TOOL_UP, bodies)
    assert_close(found, _by_branches(arm, pose, points, UPRIGHT, in_c(bodies)), rtol=0, atol=1e-10)
    assert_close(area_manipulability(arm, pose, points, TOOL_UP, bodies), found.amin(-1), rtol=0, atol=0)
    plain = largest_manipulability(arm, pose, points)
    assert (found <= plain + 1e-12).all()
    # Some branches are lost, and of some points the next best one is left.
    assert ((found == 0) & (plain > 0)).double().mean() > 0.05
    assert ((found > 0) & (found < plain - 1e-9)).double().mean() > 0.05


def test_bodies_that_the_closed_form_cannot_place_go_by_all_branches():
    arm = ARMS["stated"]
    camera = Body(Box((0.1, 0.1, 0.05), centre=(0.6, 0, 0.18)), 4, "camera")
    ring = Body(Capsule((0.8, -0.05, 0.1), (0.8, 0.05, 0.1), 0.02), 5, "ring")
    bodies = block_and_vehicle(arm).bodies
    with_them = Bodies(arm, [*bodies, camera, ring])
    assert FreeBranches.of(arm, with_them) is None
    pose = poses(300)
    found = area_manipulability(arm, pose, CORNERS, TOOL_UP, with_them)
    without = area_manipulability(arm, pose, CORNERS, TOOL_UP, Bodies(arm, bodies))
    assert (found <= without + 1e-10).all()
    assert (found < without - 1e-6).any()


def test_another_arm_goes_by_all_branches():
    puma = dx.robots.puma560()
    table = Body(Box((2, 2, 0.2), centre=(0, 0, -0.1)), "world", "table")
    bodies = Bodies(puma, [*collision.capsules(puma, 0.0), table])
    pose = torch.tensor([[-0.4, -0.2, 0.3, 0.5], [0.2, -0.4, 0.4, 1.5]], dtype=torch.float64)
    q, valid, within = docking.configurations(puma, pose, CORNERS)
    bases = docking.base_pose(pose)[:, None, None].expand(*valid.shape, 4, 4)
    free = valid & within & ~bodies.collides(q, bases)
    w = torch.where(free, indices.manipulability(puma.spatial_jacobian(q)), 0.0).amax(-1)
    assert_close(largest_manipulability(puma, pose, CORNERS, TOOL_UP, bodies), w)
    assert w.amax() > 0


def test_without_collisions_bodies_change_nothing():
    arm = ARMS["fitted"]
    far = Bodies(arm, [*collision.capsules(arm, 0.0), Body(Box((1, 1, 1), (50, 0, 0)), "world", "far")])
    pose = poses(500)
    found, plain = (largest_manipulability(arm, pose, CORNERS, TOOL_UP, b) for b in (far, None))
    assert_close(found, plain, rtol=0, atol=1e-10)


def test_a_vehicle_in_the_block_serves_nothing():
    arm = ARMS["stated"]
    bodies = block_and_vehicle(arm)
    pose = torch.tensor([[-0.38, -0.23, z, 0.82] for z in (0.19, 0.2, 0.24)], dtype=torch.float64)
    values = area_manipulability(arm, pose, CORNERS, TOOL_UP, bodies)
    assert values[0] == 0  # its bottom is 1 cm below the face
    assert values[2] > 0


def test_batches(batch_shape):
    arm = ARMS["stated"]
    pose = poses(1)[0].expand(*batch_shape, 4)
    bodies = block_and_vehicle(arm)
    assert area_manipulability(arm, pose, CORNERS, TOOL_UP, bodies).shape == batch_shape
    assert largest_manipulability(arm, pose, CORNERS, TOOL_UP, bodies).shape == (*batch_shape, 4)


# ---- the problem -----------------------------------------------------------------------------------


def test_a_problem_with_bodies():
    arm = ARMS["stated"]
    free = docking.DockingProblem(arm)
    problem = dataclasses.replace(free, bodies=block_and_vehicle(arm))
    pose = poses(50)
    expected = area_manipulability(arm, pose, CORNERS, TOOL_UP, problem.bodies)
    assert torch.equal(problem.area_manipulability(pose), expected)
    assert_close(problem.objective(pose), 50 * expected - 0.1 * problem.distance(pose))
    with pytest.raises(ValueError, match="problem has bodies"):
        docking.export.javascript_module(problem)


def test_the_optimum_without_bodies_is_in_collision_and_the_one_with_them_is_not():
    arm = ARMS["stated"]
    bodies = block_and_vehicle(arm)
    through = [-0.416, -0.2, 0.2, 0.84]
    around = [-0.379, -0.2323, 0.2395, 0.824]
    assert area_manipulability(arm, through, CORNERS) > 0.026
    assert area_manipulability(arm, through, CORNERS, TOOL_UP, bodies) < 0.012
    assert area_manipulability(arm, around, CORNERS, TOOL_UP, bodies) == pytest.approx(0.0134, abs=2e-4)


# ---- bad input -------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda arm: block_and_vehicle(arm, radius=-0.1), r"radius is -0\.1"),
        (lambda arm: block_and_vehicle(arm, hand=2.0), "hand is 2 m; all links together"),
        (lambda arm: block_and_vehicle(arm, block=(2, 2, 0)), "size is 0"),
        (lambda arm: block_and_vehicle(arm, bottom=math.nan), "bottom is nan"),
        (lambda arm: block_and_vehicle(arm, excluded=[("hand", "block")]), "'hand'"),
        (lambda arm: docking.DockingProblem(arm, bodies=block_and_vehicle(ARMS["fitted"])), "bodies are on"),
        (
            lambda arm: area_manipulability(
                arm, [0, 0, 0.2, 0], CORNERS, TOOL_UP, block_and_vehicle(ARMS["fitted"])
            ),
            "bodies are on",
        ),
        (
            lambda arm: area_manipulability(arm, [math.nan] * 4, CORNERS, TOOL_UP, block_and_vehicle(arm)),
            "pose is not finite",
        ),
    ],
)
@pytest.mark.usefixtures("annotations_unchecked")
def test_bad_input(make, message):
    with pytest.raises(ValueError, match=message):
        make(ARMS["stated"])
