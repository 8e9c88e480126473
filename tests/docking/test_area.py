"""The closed form against determinants and against all branches, and what an area's manipulability is."""

import math

import numpy as np
import pytest
import torch
from scipy.spatial.transform import Rotation
from torch.testing import assert_close

import dexterity as dx
from dexterity import docking, indices, spatial
from dexterity.docking import TOOL_UP, area_manipulability, configurations, largest_manipulability, square
from dexterity.docking.area import _by_branches
from dexterity.docking.elbow import ElbowArm

ARMS = {variant: dx.robots.docking_arm(variant) for variant in ("stated", "fitted")}
CORNERS, NINE = square(0.2), square(0.2, 3)

every_arm = pytest.mark.parametrize("arm", ARMS.values(), ids=ARMS)


def generator(seed: int = 0) -> torch.Generator:
    return torch.Generator().manual_seed(seed)


def poses(*batch: int, tilted: bool = False, seed: int = 0) -> torch.Tensor:
    """Base poses about the task area, most of which reach some of it."""
    unit = 2 * torch.rand(*batch, 6, generator=generator(seed), dtype=torch.float64) - 1
    pose = unit * torch.tensor([0.8, 0.8, 0.4, 0.6, 0.6, math.pi], dtype=torch.float64)
    return pose if tilted else pose[..., [0, 1, 2, 5]]


def turned(seed: int) -> list[list[float]]:
    """Orientation of a tool at random."""
    twist = torch.cat([torch.zeros(3), torch.randn(3, generator=generator(seed))])
    R: list[list[float]] = spatial.exp(twist)[:3, :3].tolist()
    return R


# ---- the closed form -------------------------------------------------------------------------------


@every_arm
def test_the_closed_form_is_the_determinant(arm):
    """At the tool pose of any configuration, the best branch without limits has at least its w."""
    free = dx.Chain(arm.screws, arm.home, lower=[-math.pi] * 6, upper=[math.pi] * 6)
    q = (2 * torch.rand(2000, 6, generator=generator(), dtype=torch.float64) - 1) * math.pi
    T, w = arm.forward(q), indices.manipulability(arm.geometric_jacobian(q))
    q_all, valid, _ = docking.inverse_kinematics(free, T)
    assert valid.all()
    best = indices.manipulability(arm.geometric_jacobian(q_all)).amax(-1)
    elbow = ElbowArm.of(free)
    closed = elbow.manipulability(T[:, :3, 3].mT, T[:, :3, 0].mT)
    assert_close(closed, best, rtol=0, atol=1e-10)
    assert (closed >= w - 1e-10).all()


@every_arm
@pytest.mark.parametrize("tilted", [False, True])
@pytest.mark.parametrize("tool", [TOOL_UP, turned(0), turned(1)], ids=["up", "turned", "otherwise"])
def test_the_closed_form_is_what_all_branches_give(arm, tilted, tool):
    pose = poses(600, tilted=tilted)
    closed = largest_manipulability(arm, pose, NINE, tool)
    branches = _by_branches(arm, pose, NINE, torch.tensor(tool, dtype=torch.float64))
    assert_close(closed, branches, rtol=0, atol=1e-10)
    reached = (closed > 0).double().mean()
    assert 0.3 < reached < 0.8


@pytest.mark.parametrize("limit", [(-2.8, 0.4), (0.5, 2.0), (-0.3, -0.1), (-4.0, 4.0)])
@pytest.mark.parametrize("joint", [0, 1, 2])
def test_limits_of_the_closed_form(joint, limit):
    arm = ARMS["fitted"]
    lower, upper = arm.lower, arm.upper
    lower[joint], upper[joint] = limit
    narrow = dx.Chain(arm.screws, arm.home, lower=lower, upper=upper)
    pose = poses(500, seed=joint)
    closed = largest_manipulability(narrow, pose, CORNERS)
    branches = _by_branches(narrow, pose, CORNERS, torch.tensor(TOOL_UP, dtype=torch.float64))
    assert_close(closed, branches, rtol=0, atol=1e-10)
    assert closed.count_nonzero() > 0


@pytest.mark.parametrize("joint", [3, 4, 5])
def test_a_wrist_whose_limits_bind_has_no_closed_form(joint):
    arm = ARMS["stated"]
    lower, upper = arm.lower, arm.upper
    lower[joint], upper[joint] = -1.0, 1.0
    narrow = dx.Chain(arm.screws, arm.home, lower=lower, upper=upper)
    assert ElbowArm.of(narrow) is None
    wide, less = (largest_manipulability(a, poses(500), CORNERS) for a in (arm, narrow))
    assert (less <= wide + 1e-12).all()
    assert less.count_nonzero() < wide.count_nonzero()


@pytest.mark.parametrize("other", [dx.robots.puma560(), dx.robots.uvms()], ids=["PUMA", "UVMS"])
def test_other_arms_have_no_closed_form(other):
    assert ElbowArm.of(other) is None


def test_other_arms_go_by_their_branches():
    puma = dx.robots.puma560()
    pose = poses(40)
    values = largest_manipulability(puma, pose, CORNERS)
    q, valid, within = configurations(puma, pose, CORNERS)
    w = indices.manipulability(puma.spatial_jacobian(q))
    assert_close(values, torch.where(valid & within, w, 0.0).amax(-1))
    assert values.count_nonzero() > 0


@pytest.mark.parametrize(("arm", "length"), [(ARMS["stated"], 0.4), (ARMS["fitted"], 0.425)])
def test_it_cannot_exceed_a_cap(arm, length):
    """With both links l, w is at most 1.54 l³, and 1.41 l³ where the tool is vertical; both are reached."""
    grid = torch.linspace(-math.pi, math.pi, 361, dtype=torch.float64)
    theta2, theta3 = (part.flatten() for part in torch.meshgrid(grid, grid, indexing="ij"))
    flat, vertical = torch.zeros_like(theta2), math.pi / 2 - theta2 - theta3
    for theta5, cap in ((flat + math.pi / 2, 1.5396), (vertical, 1.4091)):
        q = torch.stack([flat, theta2, theta3, flat, theta5, flat], dim=-1)
        w = indices.manipulability(arm.geometric_jacobian(q))
        assert 0.999 * cap * length**3 < w.max() < 1.0001 * cap * length**3
    assert largest_manipulability(arm, poses(10_000), NINE).max() < 1.4091 * length**3


# ---- areas -----------------------------------------------------------------------------------------


def test_an_area_counts_with_its_worst_point():
    arm = ARMS["stated"]
    pose = poses(5, 7)
    each = largest_manipulability(arm, pose, NINE)
    assert each.shape == (5, 7, 9)
    assert_close(area_manipulability(arm, pose, NINE), each.amin(-1))
    # More points can only lower it.
    assert (area_manipulability(arm, pose, NINE) <= area_manipulability(arm, pose, CORNERS)).all()


@every_arm
def test_configurations_reach_their_points(arm):
    pose = torch.tensor([-0.32, -0.36, 0.24, 0.79], dtype=torch.float64)
    q, valid, within = configurations(arm, pose, CORNERS)
    assert q.shape == (4, 8, 6)
    T = spatial.compose(docking.base_pose(pose), arm.forward(q))
    expected = spatial.pose(TOOL_UP, CORNERS)[:, None].expand_as(T)
    assert_close(T[valid], expected[valid], rtol=0, atol=1e-9)
    inside = ((q >= arm.lower) & (q <= arm.upper)).all(-1)
    assert torch.equal(inside, within)


@pytest.mark.parametrize("quarter", [1, 2, 3])
def test_turning_all_by_a_right_angle_changes_nothing(quarter):
    arm = ARMS["fitted"]
    pose = poses(500)
    angle = quarter * math.pi / 2
    c, s = round(math.cos(angle)), round(math.sin(angle))
    x, y, z, psi = pose.unbind(-1)
    other = torch.stack([c * x - s * y, s * x + c * y, z, psi + angle], dim=-1)
    assert_close(
        area_manipulability(arm, other, CORNERS), area_manipulability(arm, pose, CORNERS), rtol=0, atol=1e-12
    )


def test_a_pose_without_tilt_is_a_pose_with_none():
    flat = poses(100)
    zero = torch.zeros(100, 1, dtype=torch.float64)
    tilted = torch.cat([flat[:, :3], zero, zero, flat[:, 3:]], dim=1)
    assert_close(docking.base_pose(tilted), docking.base_pose(flat))
    one, other = (largest_manipulability(ARMS["stated"], pose, NINE) for pose in (flat, tilted))
    assert_close(one, other, rtol=0, atol=1e-13)


def test_roll_pitch_and_yaw_turn_in_this_order():
    pose = torch.tensor([0.0, 0.0, 0.0, 0.3, -0.2, 1.1], dtype=torch.float64)
    expected = Rotation.from_euler("ZYX", [1.1, -0.2, 0.3]).as_matrix()
    np.testing.assert_allclose(docking.base_pose(pose)[:3, :3], expected, atol=1e-14)


def test_an_arm_on_its_base():
    arm = ARMS["fitted"]
    pose, q = poses(tilted=True), (poses(3, tilted=True, seed=1))
    moved = docking.on_base(arm, pose)
    assert_close(moved.forward(q), spatial.compose(docking.base_pose(pose), arm.forward(q)))
    assert (moved.lower == arm.lower).all()
    with pytest.raises(ValueError, match="one pose is needed"):
        docking.on_base(arm, poses(2))


def test_out_of_reach_it_is_zero():
    assert area_manipulability(ARMS["stated"], [3.0, 0.0, 0.2, 0.0], CORNERS) == 0.0


def test_batches(batch_shape):
    pose = poses(*batch_shape)
    assert area_manipulability(ARMS["stated"], pose, CORNERS).shape == batch_shape
    assert largest_manipulability(ARMS["stated"], pose, NINE).shape == (*batch_shape, 9)


def test_control_points_on_a_square():
    assert square(0.2).tolist() == [[-0.2, -0.2, 0], [-0.2, 0.2, 0], [0.2, -0.2, 0], [0.2, 0.2, 0]]
    assert square(0.1, 21, height=0.3).shape == (441, 3)
    with pytest.raises(ValueError, match="half_width is 0"):
        square(0.0)
    with pytest.raises(ValueError, match="per_side is 1"):
        square(0.2, 1)


# ---- bad input -------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("pose", "points", "tool", "message"),
    [
        ([0.0, 0.0, 0.0], [[0.0, 0, 0]], TOOL_UP, "pose has shape"),
        ([math.nan, 0, 0, 0], [[0.0, 0, 0]], TOOL_UP, "pose is not finite"),
        ([0.0, 0, 0, 0], np.zeros((0, 3)), TOOL_UP, "points has shape"),
        ([0.0, 0, 0, 0], [0.0, 0, 0], TOOL_UP, "points has shape"),
        ([0.0, 0, 0, 0], [[0.0, 0, math.inf]], TOOL_UP, "points is not finite"),
        ([0.0, 0, 0, 0], [[0.0, 0, 0]], 2 * np.eye(3), "not a rigid-body pose|orthonormal"),
    ],
)
def test_bad_input(pose, points, tool, message):
    with pytest.raises(ValueError, match=message):
        area_manipulability(ARMS["stated"], pose, points, tool)


def test_an_arm_without_a_spherical_wrist():
    with pytest.raises(ValueError, match="six revolute ones are needed"):
        area_manipulability(dx.robots.uvms(), [0.0, 0.0, 0.2, 0.0], CORNERS)


def test_far_away_nothing_is_reached_and_nothing_is_nan():
    """Finite poses have finite values, however large they are."""
    for arm in (dx.robots.docking_arm(), dx.robots.puma560()):
        for far in (1e6, 1e154, 1e300):
            pose = torch.tensor([far, far, 0.2, 0.3], dtype=torch.float64)
            assert dx.docking.area_manipulability(arm, pose, dx.docking.square(0.2)) == 0


def test_another_arm_has_the_best_w_of_its_branches():
    puma, corners = dx.robots.puma560(), dx.docking.square(0.1)
    poses = torch.tensor(
        [[-0.4, -0.2, -0.3, 0.5], [0.2, -0.4, -0.2, 1.5], [2.0, 0, 0, 0]], dtype=torch.float64
    )
    q, valid, within = dx.docking.configurations(puma, poses, corners)
    w = torch.where(valid & within, dx.Index("w")(puma, q), 0.0).amax(-1)
    torch.testing.assert_close(dx.docking.largest_manipulability(puma, poses, corners), w)
    torch.testing.assert_close(dx.docking.area_manipulability(puma, poses, corners), w.amin(-1))
    assert w.amin(-1).max() > 0


@pytest.mark.usefixtures("annotations_unchecked")
def test_a_bad_tool_is_blamed_on_the_tool():
    with pytest.raises(ValueError, match=r"^tool"):
        dx.docking.area_manipulability(dx.robots.docking_arm(), [0, 0, 0, 0], [[0, 0, 0]], 2 * torch.eye(3))
