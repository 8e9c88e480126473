"""Chains on vehicles, planar bases and wheels, with joints locked, on another base, with another tool."""

import math

import numpy as np
import pytest
import torch
from torch.testing import assert_close

import dexterity as dx
from dexterity import spatial
from dexterity.sampling import Box
from serial_chains import random_pose, random_robot

ARM = dx.robots.docking_arm()
MOUNT = spatial.from_rpy([0.1, -0.2, 0.3], [0.2, 0.1, -0.15])
Q = torch.tensor([0.3, -0.5, 0.7, 0.2, 0.9, -0.4], dtype=torch.float64)


def turn(axis: int, angle: float) -> torch.Tensor:
    twist = torch.zeros(6, dtype=torch.float64)
    twist[3 + axis] = angle
    return spatial.exp(twist)


# ---- which joints, in which order -------------------------------------------------------------------


def test_chosen_degrees_of_freedom_are_the_vehicle_with_the_others_at_zero():
    free, chosen = ARM.on_vehicle(MOUNT), ARM.on_vehicle(MOUNT, joints=("x", "y", "z", "rz"))
    assert chosen.joint_names == ("x", "y", "z", "rz", *ARM.joint_names)
    q = torch.cat([torch.tensor([0.4, -0.3, 0.2, 0, 0, 1.1], dtype=torch.float64), Q])
    keep = [0, 1, 2, 5, *range(6, 12)]
    assert_close(chosen.forward(q[keep]), free.forward(q), rtol=0, atol=1e-15)
    assert_close(chosen.geometric_jacobian(q[keep]), free.geometric_jacobian(q)[:, keep], rtol=0, atol=1e-15)
    # The joints that are left out are those that `lock` fixes at zero.
    locked = free.lock(["θx", "θy"])
    assert_close(locked.screws, chosen.screws, rtol=0, atol=1e-15)
    assert free.lock(["rx", "pitch"]).joint_names == locked.joint_names
    assert chosen.lock({"θz": 0.5}).joints == 9


@pytest.mark.parametrize(
    "names", [("rx", "ry", "rz"), ("roll", "pitch", "yaw"), ("θx", "θy", "θz")], ids=lambda names: names[0]
)
def test_rotations_have_names_that_can_be_typed(names):
    vehicle = ARM.on_vehicle(MOUNT, joints=("surge", "sway", "heave", *names))
    assert vehicle.joint_names[:6] == ("surge", "sway", "heave", *names)
    assert_close(vehicle.screws, ARM.on_vehicle(MOUNT).screws, rtol=0, atol=0)


def test_rates_and_limits_follow_the_order_in_which_the_joints_are_asked_for():
    vehicle = ARM.on_vehicle(
        MOUNT, joints=("rz", "x"), rates=[3, 4], lower=[-1, -2], upper=[1, 2], prefix="ship ", name="ship"
    )
    assert vehicle.name == "ship"
    assert vehicle.joint_names[:2] == ("ship x", "ship rz")
    assert vehicle.rates[:2].tolist() == [4, 3]
    assert vehicle.lower[:2].tolist() == [-2, -1]
    assert vehicle.upper[:2].tolist() == [2, 1]


def test_a_vehicle_with_limits_makes_a_box():
    limits = torch.tensor([5, 5, 2, 0.3, 0.3, math.pi])
    box = Box.from_chain(ARM.on_vehicle(MOUNT, lower=-limits, upper=limits))
    assert box.joints == 12


def test_a_vehicle_on_a_vehicle_needs_a_prefix():
    once = ARM.on_vehicle(MOUNT)
    with pytest.raises(ValueError, match=r"^the arm has joints named x, y, z, .* too; prefix="):
        once.on_vehicle(MOUNT)
    twice = once.on_vehicle(MOUNT, prefix="ship ")
    assert twice.joint_names[:2] == ("ship x", "ship y")
    assert twice.joints == 18


# ---- along the vehicle's own axes --------------------------------------------------------------------


def test_body_axes_turn_with_the_vehicle():
    vehicle = ARM.on_vehicle(MOUNT, joints=("x", "y", "z", "rx", "ry", "rz"), axes="body")
    assert vehicle.joint_names[:6] == ("rx", "ry", "rz", "x", "y", "z")
    q = torch.cat([torch.tensor([0.2, -0.3, 1.2, 0, 0, 0], dtype=torch.float64), Q])
    R = (turn(0, 0.2) @ turn(1, -0.3) @ turn(2, 1.2))[:3, :3]
    J = vehicle.geometric_jacobian(q)
    assert_close(J[:3, 3:6], R, rtol=0, atol=1e-15)
    assert_close(J[3:, 3:6], torch.zeros(3, 3, dtype=torch.float64), rtol=0, atol=0)
    # Where the vehicle turns and does not move, both kinds of axes say the same.
    world = ARM.on_vehicle(MOUNT)
    same = world.geometric_jacobian(q[[3, 4, 5, 0, 1, 2, *range(6, 12)]])
    assert_close(J[:, :3], same[:, 3:6], rtol=0, atol=1e-15)
    assert_close(vehicle.forward(q), world.forward(q[[3, 4, 5, 0, 1, 2, *range(6, 12)]]), rtol=0, atol=1e-15)


def test_a_turned_vehicle_that_can_only_surge_moves_the_tool_ahead():
    """An underwater vehicle without side thrusters: rates along the world's axes cannot describe it."""
    rov = ARM.on_vehicle(MOUNT, joints=("x", "y", "yaw"), axes="body", rates=[1, 0, 0])
    q = torch.cat([torch.tensor([math.pi / 2, 0, 0], dtype=torch.float64), Q])
    scaled = rov.geometric_jacobian(q) * rov.rates
    assert_close(scaled[:3, :3].sum(1), torch.tensor([0, 1, 0], dtype=torch.float64), rtol=0, atol=1e-15)


# ---- planar and wheeled bases ------------------------------------------------------------------------


def test_a_planar_base_moves_by_x_y_and_yaw():
    base = ARM.on_planar_base(MOUNT, lower=[-1, -1, -3], upper=[1, 1, 3], rates=[0.5, 0.5, 1])
    assert base.joint_names[:3] == ("x", "y", "yaw")
    assert base.name == "docking_arm on a planar base"
    q = torch.cat([torch.tensor([0.4, -0.3, 1.1], dtype=torch.float64), Q])
    expected = spatial.translation(0.4, -0.3, 0) @ turn(2, 1.1) @ MOUNT @ ARM.forward(Q)
    assert_close(base.forward(q), expected, rtol=0, atol=1e-15)


def test_wheels_drive_ahead_and_turn_wherever_the_base_stands():
    base = ARM.on_wheels(MOUNT, rates=[0.8, 1.5])
    assert base.joint_names[:4] == ("x", "y", "yaw", "forward")
    assert base.rates[:4].tolist() == [0, 0, 1.5, 0.8]
    assert (base.lower[3], base.upper[3]) == (0, 0)
    x, y, yaw = 3.0, -2.0, 0.7
    q = torch.cat([torch.tensor([x, y, yaw, 0], dtype=torch.float64), Q])
    tool = spatial.translation(x, y, 0) @ turn(2, yaw) @ MOUNT @ ARM.forward(Q)
    assert_close(base.forward(q), tool, rtol=0, atol=1e-15)
    # The unicycle: ahead along (cos yaw, sin yaw), and a turn about the base's own origin.
    J = base.geometric_jacobian(q)
    ahead = torch.tensor([math.cos(yaw), math.sin(yaw), 0, 0, 0, 0], dtype=torch.float64)
    about = torch.tensor([-(tool[1, 3] - y), tool[0, 3] - x, 0, 0, 0, 1], dtype=torch.float64)
    assert_close(J[:, 3], ahead, rtol=0, atol=1e-15)
    assert_close(J[:, 2], about, rtol=0, atol=1e-15)
    assert Box.from_chain(
        ARM.on_wheels(MOUNT, lower=[-1, -1, -math.pi], upper=[1, 1, math.pi])
    ).dimensions == 9  # fmt: skip


# ---- locked, moved, with a tool ----------------------------------------------------------------------


def test_locked_joints_are_the_chain_at_these_values(rng):
    for joints in (3, 6, 9):
        chain = random_robot(rng, joints).chain()
        values = {chain.joint_names[0]: 0.3, chain.joint_names[joints // 2]: -0.7}
        locked = chain.lock(values, name="less")
        free = [i for i, name in enumerate(chain.joint_names) if name not in values]
        q = torch.from_numpy(rng.uniform(-1, 1, (4, joints)))
        for name, value in values.items():
            q[:, chain.joint_names.index(name)] = value
        assert locked.name == "less"
        assert locked.joint_names == tuple(chain.joint_names[i] for i in free)
        assert_close(locked.forward(q[:, free]), chain.forward(q), rtol=0, atol=1e-14)
        assert_close(
            locked.spatial_jacobian(q[:, free]), chain.spatial_jacobian(q)[..., free], rtol=0, atol=1e-13
        )


def test_a_locked_joint_keeps_the_limits_and_rates_of_the_others():
    panda = dx.robots.panda().lock({"panda_joint3": 0.1})
    assert_close(panda.lower, dx.robots.panda().lower[[0, 1, 3, 4, 5, 6]], rtol=0, atol=0)
    assert_close(panda.rates, dx.robots.panda().rates[[0, 1, 3, 4, 5, 6]], rtol=0, atol=0)


@pytest.mark.usefixtures("annotations_unchecked")
@pytest.mark.parametrize(
    ("joints", "error", "message"),
    [
        ({"elbow": 1.0}, ValueError, "joints is 'elbow'; .*panda_joint1"),
        ({"panda_joint4": 0.0}, ValueError, r"joints\['panda_joint4'\] is 0; the joint's limits are -3.07"),
        ({"panda_joint1": math.nan}, ValueError, r"joints\['panda_joint1'\] is nan"),
        ({"panda_joint1": "0"}, TypeError, r"joints\['panda_joint1'\] is '0'"),
        ({3: 0.0}, TypeError, "joints is 3"),
        (["panda_joint4"], ValueError, r"joints\['panda_joint4'\] is 0"),
        ("panda_joint1", TypeError, "joints is 'panda_joint1'"),
        (None, TypeError, "joints is None"),
        (dict.fromkeys([f"panda_joint{i + 1}" for i in range(7)], 0.0) | {"panda_joint4": -1.0}
         | {"panda_joint6": 1.0}, ValueError, "joints holds all 7 joints"),
    ],
)  # fmt: skip
def test_what_cannot_be_locked_is_refused(joints, error, message):
    with pytest.raises(error, match=f"^{message}"):
        dx.robots.panda().lock(joints)


def test_a_base_and_a_tool_stand_before_and_behind(rng):
    T_world_base, T_tool_new = (torch.from_numpy(random_pose(rng)) for _ in range(2))
    moved = ARM.with_base(T_world_base).with_tool(T_tool_new, name="long arm")
    assert moved.name == "long arm"
    assert_close(moved.forward(Q), T_world_base @ ARM.forward(Q) @ T_tool_new, rtol=0, atol=1e-15)
    assert_close(
        moved.body_jacobian(Q),
        spatial.inverse_adjoint(T_tool_new) @ ARM.body_jacobian(Q),
        rtol=0,
        atol=1e-14,
    )
    assert moved.upper.tolist() == ARM.upper.tolist()


# ---- bad input ---------------------------------------------------------------------------------------


@pytest.mark.usefixtures("annotations_unchecked")
@pytest.mark.parametrize(
    ("options", "error", "message"),
    [
        ({"joints": ("x", "w")}, ValueError, "joints is 'w'; .*x, y, z"),
        ({"joints": ("x", "surge")}, ValueError, "joints is .*more than once"),
        ({"joints": ("rz", "yaw")}, ValueError, "joints is .*θz more than once"),
        ({"joints": ()}, ValueError, "joints is empty"),
        ({"joints": "xyz"}, TypeError, "joints is 'xyz'; a sequence of names"),
        ({"joints": (1,)}, TypeError, r"joints\[0\] is 1"),
        ({"joints": ("x", "y"), "rates": [1]}, ValueError, r"rates has shape \(1,\); \(2,\) is needed"),
        ({"lower": [0] * 5}, ValueError, r"lower has shape \(5,\); \(6,\) is needed"),
        ({"upper": ["a"] * 6}, TypeError, "upper "),
        ({"lower": [1] * 6, "upper": [0] * 6}, ValueError, "lower exceeds upper at joint 1: 1 and 0"),
        ({"axes": "tool"}, ValueError, "axes is 'tool'; .*world, body"),
        ({"axes": None}, TypeError, "axes is None"),
        ({"prefix": 3}, TypeError, "prefix is 3"),
        ({"name": 3}, TypeError, "name is 3"),
        ({"inertia": (1, [0, 0, 0], np.eye(3))}, ValueError, "inertia is given, but docking_arm has no"),
    ],
)
def test_bad_options_of_a_vehicle_are_refused(options, error, message):
    with pytest.raises(error, match=f"^{message}"):
        ARM.on_vehicle(MOUNT, **options)


@pytest.mark.parametrize("method", ["on_vehicle", "on_planar_base", "on_wheels", "with_base", "with_tool"])
@pytest.mark.parametrize("T", [np.eye(3), 2 * np.eye(4), [0, 0, 0.1]], ids=["3 × 3", "scaled", "offset"])
def test_a_mount_that_is_no_pose_is_refused(method, T):
    with pytest.raises(ValueError, match=r"^T_\w+ (has shape|is not a rigid)"):
        getattr(ARM, method)(T)
