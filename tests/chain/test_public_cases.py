"""Cases of users of other packages: frames, prismatic joints, conventions, rows of ellipsoids."""

import math

import numpy as np
import pytest
import torch
from numpy.testing import assert_allclose
from torch.testing import assert_close

import dexterity as dx
from dexterity import indices, spatial

HALF = math.pi / 2


def differences(chain: dx.Chain, q, step: float = 1e-6) -> np.ndarray:
    """Velocity of the tool point and angular velocity, (6, n), from poses alone."""
    q, T = np.asarray(q, dtype=float), chain.forward(q).numpy()
    columns = []
    for joint in np.eye(chain.joints) * step:
        D = (chain.forward(q + joint).numpy() - chain.forward(q - joint).numpy()) / (2 * step)
        turning = D[:3, :3] @ T[:3, :3].T
        columns.append([*D[:3, 3], turning[2, 1], turning[0, 2], turning[1, 0]])
    return np.array(columns).T


# ---- which frame a Jacobian is in (pinocchio#417, #1222, #1455, #1525, #1761, #1974, ----------------
# ---- kinematics_interface#256, kinpy#14, pytorch_kinematics#14, #31) --------------------------------


def test_the_three_jacobians_of_a_planar_arm_by_hand():
    """pinocchio#1222, where the first column of one frame is zero; kinematics_interface#256."""
    arm, root = dx.Chain.from_dh([{"a": 1}, {"a": 1}]), math.sqrt(0.5)
    q = [math.pi / 4, 0]
    spatial_J = [[0, root], [0, -root], [0, 0], [0, 0], [0, 0], [1, 1]]
    assert_allclose(arm.spatial_jacobian(q), spatial_J, atol=1e-15)
    assert_allclose(arm.body_jacobian(q), [[0, 0], [2, 1], [0, 0], [0, 0], [0, 0], [1, 1]], atol=1e-15)
    geometric = [[-2 * root, -root], [2 * root, root], [0, 0], [0, 0], [0, 0], [1, 1]]
    assert_allclose(arm.geometric_jacobian(q), geometric, atol=1e-15)


@pytest.mark.parametrize("robot", ["panda", "bluerov2", "oberon7"])
def test_each_jacobian_is_the_derivative_that_its_name_says(rng, robot):
    """pinocchio#1455, #1525, #1761, #1974: users compare one frame's Jacobian with another's differences."""
    chain = dx.robots.load(robot).with_base(spatial.from_rpy([0.3, -0.2, 0.9], [1, 2, 3]))
    chain = chain.with_tool(spatial.from_rpy([1.0, 0.1, -0.4], [0.1, -0.2, 0.3]))
    q = rng.uniform(-1, 1, chain.joints)
    expected, T = differences(chain, q), chain.forward(q).numpy()
    R, p = T[:3, :3], T[:3, 3]
    assert_allclose(chain.geometric_jacobian(q), expected, rtol=0, atol=1e-8)
    body = np.concatenate([R.T @ expected[:3], R.T @ expected[3:]])
    assert_allclose(chain.body_jacobian(q), body, rtol=0, atol=1e-8)
    about_origin = expected[:3] + np.cross(p, expected[3:], axisb=0).T
    assert_allclose(
        chain.spatial_jacobian(q), np.concatenate([about_origin, expected[3:]]), rtol=0, atol=1e-8
    )


# ---- prismatic joints (pybotics#764, kinpy#5, moveit#1191, ikpy#28) ---------------------------------


def test_three_slides_move_and_do_not_turn():
    """pybotics#764 and kinpy#5 (a Jacobian of zeros), ikpy#28 (a slide that turns): a gantry, by hand."""
    screws = np.zeros((3, 6))
    screws[:, :3] = [[0, 0, 1], [0, -1, 0], [1, 0, 0]]
    turn = spatial.from_rpy([0.1, 0.2, 0.3], [0, 0, 1])
    gantry, q = dx.Chain(screws, turn), [0.1, 0.2, 0.3]
    expected = np.zeros((6, 3))
    expected[:3] = screws[:, :3].T
    for frame in ("spatial", "geometric"):
        assert_allclose(getattr(gantry, f"{frame}_jacobian")(q), expected, rtol=0, atol=1e-15)
    assert_allclose(gantry.forward(q)[:3, 3], [0.3, -0.2, 1.1], rtol=0, atol=1e-15)
    assert_allclose(gantry.forward(q)[:3, :3], turn[:3, :3], rtol=0, atol=1e-15)
    w = indices.Index("w", "geometric", rows="translational")
    assert_allclose(w(gantry, q), 1, rtol=1e-15)


MIXED = [
    {"d": 0.3, "alpha": -HALF}, {"d": 0.1, "alpha": HALF}, {"kind": "prismatic", "theta": -HALF},
    {"alpha": -HALF}, {"alpha": HALF}, {"d": 0.2},
]  # fmt: skip
LEANING = [
    {"kind": "prismatic", "alpha": 0.7, "theta": 0.4}, {"a": 0.3, "alpha": 1.1},
    {"kind": "prismatic", "a": 0.2, "alpha": -0.6}, {"d": 0.1}, {"kind": "prismatic", "theta": 1.0},
]  # fmt: skip


@pytest.mark.parametrize("rows", [MIXED, LEANING], ids=["stanford", "leaning"])
@pytest.mark.parametrize("modified", [False, True], ids=["standard", "modified"])
def test_the_columns_of_slides_have_unit_length(rows, modified):
    """moveit#1191: a prismatic column that was not of unit length."""
    chain = dx.Chain.from_dh(rows, modified)
    q = [0.3, -0.4, 0.5, 0.6, 0.7, 0.8][: chain.joints]
    J = chain.geometric_jacobian(q)
    slides = [kind == "prismatic" for kind in chain.kinds]
    assert_close(J[:3, slides].norm(dim=0), torch.ones(sum(slides), dtype=torch.float64), rtol=0, atol=1e-15)
    assert (J[3:, slides] == 0).all()
    assert_allclose(J, differences(chain, q), rtol=0, atol=1e-8)


# ---- conventions of Denavit and Hartenberg (rtb-matlab#125, mujoco_menagerie#85, EAIK#24, -----------
# ---- rtb-python#290, #429) --------------------------------------------------------------------------


def test_a_ur5_in_standard_rows_stands_where_rtb_matlab_125_prints_it():
    rows = [
        {"d": 0.089459, "alpha": HALF}, {"a": -0.425}, {"a": -0.39225}, {"d": 0.10915, "alpha": HALF},
        {"d": 0.09465, "alpha": -HALF}, {"d": 0.0823},
    ]  # fmt: skip
    T = dx.Chain.from_dh(rows).forward([0.0] * 6)
    assert_allclose(T[:3, :3], [[1, 0, 0], [0, 0, -1], [0, 1, 0]], rtol=0, atol=1e-15)
    assert_allclose(T[:3, 3], [-0.8173, -0.1915, -0.005191], rtol=0, atol=5e-5)


def test_rows_of_one_convention_read_as_the_other_are_another_robot():
    """mujoco_menagerie#85, EAIK#24: the Panda's rows are modified ones; as standard ones it is 0.2 m off."""
    rows = [
        {"d": 0.333}, {"alpha": -HALF}, {"alpha": HALF, "d": 0.316}, {"a": 0.0825, "alpha": HALF},
        {"a": -0.0825, "alpha": -HALF, "d": 0.384}, {"alpha": HALF}, {"a": 0.088, "alpha": HALF},
    ]  # fmt: skip
    flange = spatial.translation(0, 0, 0.107)
    panda = dx.Chain.from_dh(rows, modified=True, tool=flange)
    assert_allclose(panda.home, dx.robots.panda().home, rtol=0, atol=1e-15)
    assert_allclose(
        panda.home, [[1, 0, 0, 0.088], [0, -1, 0, 0], [0, 0, -1, 0.926], [0, 0, 0, 1]], atol=1e-15
    )
    assert (dx.Chain.from_dh(rows, tool=flange).home[:3, 3] - panda.home[:3, 3]).norm() > 0.2


@pytest.mark.parametrize("seed", range(3))
def test_standard_rows_are_modified_rows_moved_by_half_a_row(seed):
    """rtb-python#290, #429: one arm in both conventions, (d, θ) of row i with (a, α) of the row before."""
    rng = np.random.default_rng(seed)
    rows = [dict(zip(("theta", "d", "a", "alpha"), rng.normal(size=4), strict=True)) for _ in range(5)]
    before = [{"a": 0.0, "alpha": 0.0}, *rows[:-1]]
    modified = [
        {"theta": row["theta"], "d": row["d"], "a": last["a"], "alpha": last["alpha"]}
        for row, last in zip(rows, before, strict=True)
    ]
    end = spatial.from_rpy([rows[-1]["alpha"], 0, 0], [rows[-1]["a"], 0, 0])
    q = rng.uniform(-2, 2, 5)
    one, other = dx.Chain.from_dh(rows), dx.Chain.from_dh(modified, modified=True, tool=end)
    assert_close(one.forward(q), other.forward(q), rtol=0, atol=1e-14)


# ---- rows of an ellipsoid (rtb-python#407) ----------------------------------------------------------


def test_a_stretched_arm_moves_across_itself_and_turns_about_its_normal():
    """rtb-python#407: the rows of "trans" and "rot" were exchanged."""
    arm = dx.Chain.from_dh([{"a": 1.0}] * 3)
    J = arm.geometric_jacobian([0.3, 0, 0])
    moving = indices.velocity_ellipsoid(J, "translational")
    assert_allclose(moving.semi_axes, [math.sqrt(14), 0, 0], rtol=0, atol=1e-14)
    across = [math.cos(0.3 + HALF), math.sin(0.3 + HALF), 0]
    assert_allclose(abs(moving.axes[:, 0] @ torch.tensor(across, dtype=torch.float64)), 1, rtol=1e-14)
    turning = indices.velocity_ellipsoid(J, "rotational")
    assert_allclose(turning.semi_axes, [math.sqrt(3), 0, 0], rtol=0, atol=1e-14)
    assert_allclose(turning.axes[:, 0].abs(), [0, 0, 1], rtol=0, atol=1e-14)


@pytest.mark.parametrize(
    "q", [[0, -HALF, 0, 0, HALF, 0], [0.0] * 6, [0.4, -1.0, 1.3, -0.5, 0.8, 0.2]], ids=["407", "flat", "bent"]
)
def test_a_ur3_has_the_axes_of_its_differences(q):
    """rtb-python#407, seen on a stretched UR3; force axes are the reciprocals, infinite where it is stiff."""
    rows = [
        {"d": 0.1519, "alpha": HALF}, {"a": -0.24365}, {"a": -0.21325}, {"d": 0.11235, "alpha": HALF},
        {"d": 0.08535, "alpha": -HALF}, {"d": 0.0819},
    ]  # fmt: skip
    ur3 = dx.Chain.from_dh(rows)
    D, J = differences(ur3, q), ur3.geometric_jacobian(q)
    for part, choice in (("translational", slice(3)), ("rotational", slice(3, 6))):
        ellipsoid = indices.velocity_ellipsoid(J, part)
        assert_allclose(ellipsoid.semi_axes, np.linalg.svd(D[choice])[1], rtol=0, atol=1e-8)
        # An axis is a direction in which the rows stretch by the semi-axis.
        reach = (ellipsoid.axes.T @ J[choice]).norm(dim=1)
        assert_close(reach, ellipsoid.semi_axes, rtol=0, atol=1e-12)
