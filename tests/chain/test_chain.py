"""Chains: scipy's matrix exponential, finite differences, autograd, the relations between the Jacobians."""

import copy
import math
import pickle
import re

import numpy as np
import pytest
import scipy.linalg
import torch
from hypothesis import given
from hypothesis import strategies as st
from torch.testing import assert_close

import dexterity as dx
from dexterity import spatial
from serial_chains import random_pose, random_robot

UVMS = dx.robots.uvms()
CHAINS = {"uvms": UVMS, "docking_arm": dx.robots.docking_arm(), "puma560": dx.robots.puma560()} | {
    f"random, {joints} joints": random_robot(np.random.default_rng(joints), joints).chain()
    for joints in (2, 4, 6, 7, 9)
}
KINEMATICS = ("forward", "joint_frames", "spatial_jacobian", "body_jacobian", "geometric_jacobian")


@pytest.fixture(params=CHAINS)
def chain(request: pytest.FixtureRequest) -> dx.Chain:
    return CHAINS[request.param]


def configurations(rng: np.random.Generator, chain: dx.Chain, shape: tuple[int, ...]) -> torch.Tensor:
    return torch.from_numpy(rng.uniform(-2, 2, (*shape, chain.joints)))


def exponential(screw: torch.Tensor, q: torch.Tensor) -> torch.Tensor:
    """Return scipy's exponential of a screw, written without the package."""
    vx, vy, vz, x, y, z = screw.tolist()
    return torch.from_numpy(
        scipy.linalg.expm(float(q) * np.array([[0, -z, y, vx], [z, 0, -x, vy], [-y, x, 0, vz], [0, 0, 0, 0]]))
    )


def exponentials(chain: dx.Chain, q: torch.Tensor) -> list[torch.Tensor]:
    """Products of exponentials up to and with each joint, at one configuration."""
    products = [torch.eye(4, dtype=torch.float64)]
    for screw, value in zip(chain.screws, q, strict=True):
        products.append(products[-1] @ exponential(screw, value))
    return products[1:]


def pose_derivatives(chain: dx.Chain, q: torch.Tensor) -> torch.Tensor:
    """Derivatives (n, 4, 4) of the tool pose by each joint, from a five-point difference."""
    h = 1e-3
    steps = h * torch.eye(chain.joints, dtype=torch.float64)
    far, near = (chain.forward(q + k * steps) - chain.forward(q - k * steps) for k in (2, 1))
    return (8 * near - far) / (12 * h)


def twist_columns(matrices: torch.Tensor) -> torch.Tensor:
    """Columns (6, n) read out of twist matrices (n, 4, 4)."""
    return torch.cat([matrices[:, :3, 3], matrices[:, [2, 0, 1], [1, 2, 0]]], dim=1).T


# ---- forward kinematics ----------------------------------------------------------------------------


def test_the_tool_pose_is_scipys_product_of_exponentials(rng, chain):
    for q in configurations(rng, chain, (5,)):
        assert_close(chain.forward(q), exponentials(chain, q)[-1] @ chain.home, rtol=0, atol=2e-14)


def test_home_is_the_pose_at_zero(chain):
    assert_close(chain.forward(torch.zeros(chain.joints)), chain.home, rtol=0, atol=1e-15)


def test_links_and_motions_along_z_make_up_the_tool_pose(rng, chain):
    q = configurations(rng, chain, ())
    first, *others = chain.link_transforms
    T = first
    for kind, value, link in zip(chain.kinds, q, others, strict=True):
        z_axis = torch.tensor([0.0, 0, 1, 0, 0, 0] if kind == "prismatic" else [0.0, 0, 0, 0, 0, 1])
        T = T @ exponential(z_axis, value) @ link
    assert len(others) == chain.joints
    assert_close(T, chain.forward(q), rtol=0, atol=1e-14)


def test_joint_frames_have_z_along_the_axis(rng, chain):
    q = configurations(rng, chain, ())
    frames = chain.joint_frames(q)
    z, p = frames[:, :3, 2], frames[:, :3, 3]
    prismatic = torch.tensor([kind == "prismatic" for kind in chain.kinds])[:, None]
    linear = torch.where(prismatic, z, torch.linalg.cross(p, z))
    angular = torch.where(prismatic, torch.zeros_like(z), z)
    assert_close(chain.spatial_jacobian(q), torch.cat([linear, angular], dim=1).T, rtol=0, atol=1e-14)


def test_joint_frames_move_with_their_joints(rng, chain):
    q = configurations(rng, chain, ())
    at_home = chain.joint_frames(torch.zeros(chain.joints))
    for moved, home, product in zip(chain.joint_frames(q), at_home, exponentials(chain, q), strict=True):
        assert_close(moved, product @ home, rtol=0, atol=2e-14)


def test_joint_frames_lie_at_home_nearest_to_the_frame_before(chain):
    frames = chain.joint_frames(torch.zeros(chain.joints))
    steps = torch.diff(frames[:, :3, 3], dim=0, prepend=torch.zeros(1, 3, dtype=torch.float64))
    assert_close(
        (steps * frames[:, :3, 2]).sum(-1), torch.zeros(chain.joints, dtype=torch.float64), rtol=0, atol=1e-14
    )


# ---- the three Jacobians ---------------------------------------------------------------------------


def test_jacobians_are_finite_differences_of_the_tool_pose(rng, chain):
    for q in configurations(rng, chain, (3,)):
        T, dT = chain.forward(q), pose_derivatives(chain, q)
        spatial_columns = twist_columns(dT @ torch.linalg.inv(T))
        assert_close(chain.spatial_jacobian(q), spatial_columns, rtol=0, atol=5e-11)
        assert_close(chain.body_jacobian(q), twist_columns(torch.linalg.inv(T) @ dT), rtol=0, atol=5e-11)
        geometric_columns = torch.cat([dT[:, :3, 3].T, spatial_columns[3:]])
        assert_close(chain.geometric_jacobian(q), geometric_columns, rtol=0, atol=5e-11)


def test_jacobians_are_autograds_of_the_tool_pose(rng, chain):
    q = configurations(rng, chain, ())
    T, dT = chain.forward(q), torch.func.jacrev(chain.forward)(q).permute(2, 0, 1)
    spatial_columns = twist_columns(dT @ torch.linalg.inv(T))
    assert_close(chain.spatial_jacobian(q), spatial_columns, rtol=0, atol=2e-14)
    assert_close(chain.body_jacobian(q), twist_columns(torch.linalg.inv(T) @ dT), rtol=0, atol=2e-14)
    geometric_columns = torch.cat([dT[:, :3, 3].T, spatial_columns[3:]])
    assert_close(chain.geometric_jacobian(q), geometric_columns, rtol=0, atol=2e-14)


def test_the_adjoint_of_the_tool_pose_turns_the_body_jacobian_into_the_spatial_one(rng, chain, batch_shape):
    q = configurations(rng, chain, batch_shape)
    moved = spatial.adjoint(chain.forward(q)) @ chain.body_jacobian(q)
    assert_close(moved, chain.spatial_jacobian(q), rtol=0, atol=2e-13)


def test_the_geometric_jacobian_is_the_body_one_in_world_axes(rng, chain, batch_shape):
    q = configurations(rng, chain, batch_shape)
    T = chain.forward(q).clone()
    T[..., :3, 3] = 0
    assert_close(spatial.adjoint(T) @ chain.body_jacobian(q), chain.geometric_jacobian(q), rtol=0, atol=2e-14)


def test_the_first_spatial_column_is_the_first_screw_and_the_last_joint_does_not_matter(rng, chain):
    q = configurations(rng, chain, ())
    J = chain.spatial_jacobian(q)
    assert_close(J[:, 0], chain.screws[0], rtol=0, atol=2e-15)
    q[-1] += 1
    assert_close(chain.spatial_jacobian(q), J, rtol=0, atol=1e-14)


# ---- batches and gradients -------------------------------------------------------------------------


@pytest.mark.parametrize("method", KINEMATICS)
def test_a_batch_is_its_configurations_one_by_one(rng, chain, batch_shape, method):
    q = configurations(rng, chain, batch_shape)
    function = getattr(chain, method)
    single_shape = function(torch.zeros(chain.joints)).shape
    batch = function(q)
    assert batch.shape == (*batch_shape, *single_shape)
    assert batch.dtype == torch.float64
    singles = [function(one) for one in q.reshape(-1, chain.joints)]
    for one, single in zip(batch.reshape(-1, *single_shape), singles, strict=True):
        assert_close(one, single, rtol=0, atol=1e-14)


@pytest.mark.parametrize("method", KINEMATICS)
def test_a_batch_that_is_worked_on_in_pieces_is_its_configurations_one_by_one(rng, method):
    q = configurations(rng, UVMS, (2, 3001))
    function = getattr(UVMS, method)
    batch = function(q)
    for i in (0, 1, 2046, 2047, 2048, 2049, 3000):
        assert_close(batch[:, i], function(q[:, i]), rtol=0, atol=1e-14)
    assert_close(
        batch.reshape(-1, *batch.shape[2:])[4095:4098],
        function(q.reshape(-1, 12)[4095:4098]),
        rtol=0,
        atol=1e-14,
    )


@pytest.mark.parametrize("method", KINEMATICS)
@pytest.mark.parametrize("name", ["puma560", "random, 4 joints"])
def test_gradients_flow_to_the_joint_values(rng, name, method):
    chain = CHAINS[name]
    q = configurations(rng, chain, ()).requires_grad_()
    torch.autograd.gradcheck(getattr(chain, method), q)


def test_gradients_flow_through_pieces_and_from_float32(rng):
    q = configurations(rng, UVMS, (5000,)).float().requires_grad_()
    UVMS.geometric_jacobian(q).square().sum().backward()
    alone = q[4321].detach().clone().requires_grad_()
    UVMS.geometric_jacobian(alone).square().sum().backward()
    assert q.grad.dtype == torch.float32
    assert_close(q.grad[4321], alone.grad)


@pytest.mark.parametrize("method", KINEMATICS)
def test_results_are_on_the_device_of_the_joint_values(rng, method):
    q = configurations(rng, UVMS, (3,))
    for device in ("cpu", "cuda")[: 1 + torch.cuda.is_available()]:
        result = getattr(UVMS, method)(q.to(device))
        assert result.device.type == device
        assert_close(result.cpu(), getattr(UVMS, method)(q), rtol=0, atol=1e-13)


# ---- Denavit–Hartenberg rows -----------------------------------------------------------------------


def turn(axis: int, angle: float) -> torch.Tensor:
    T = torch.eye(4, dtype=torch.float64)
    i, j = (axis + 1) % 3, (axis + 2) % 3
    T[i, i] = T[j, j] = math.cos(angle)
    T[j, i] = math.sin(angle)
    T[i, j] = -math.sin(angle)
    return T


def shift(axis: int, distance: float) -> torch.Tensor:
    T = torch.eye(4, dtype=torch.float64)
    T[axis, 3] = distance
    return T


@pytest.mark.parametrize("modified", [False, True], ids=["standard", "modified"])
@pytest.mark.parametrize("kinds", ["RRRRRR", "PPPR", "RPRPRP", "P"])
def test_denavit_hartenberg_rows_multiply(rng, modified, kinds):
    X, Z = 0, 2
    rows = [
        dict(zip(("theta", "d", "a", "alpha"), rng.normal(size=4), strict=True))
        | {"kind": "revolute" if kind == "R" else "prismatic"}
        for kind in kinds
    ]
    base, tool = (torch.from_numpy(random_pose(rng)) for _ in range(2))
    chain = dx.Chain.from_dh(rows, modified, base=base, tool=tool)
    q = configurations(rng, chain, ())
    T = base
    for row, value in zip(rows, q.tolist(), strict=True):
        theta = row["theta"] + (value if row["kind"] == "revolute" else 0)
        d = row["d"] + (value if row["kind"] == "prismatic" else 0)
        about_z = turn(Z, theta) @ shift(Z, d)
        about_x = shift(X, row["a"]) @ turn(X, row["alpha"])
        T = T @ (about_x @ about_z if modified else about_z @ about_x)
    assert_close(chain.forward(q), T @ tool, rtol=0, atol=1e-14)
    assert chain.kinds == tuple(row["kind"] for row in rows)


def test_denavit_hartenberg_entries_are_zero_and_revolute_where_left_out():
    chain = dx.Chain.from_dh(
        [{}, {"a": 1}], joint_names=["a", "b"], rates=[1, 2], lower=[-1, -2], upper=[1, 2]
    )
    assert chain.kinds == ("revolute", "revolute")
    assert_close(chain.home, shift(0, 1), rtol=0, atol=0)
    assert chain.joint_names == ("a", "b")
    assert [values.tolist() for values in (chain.rates, chain.lower, chain.upper)] == [
        [1, 2],
        [-1, -2],
        [1, 2],
    ]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"rows": []}, "rows is empty"),
        ({"rows": [{}, {"offset": 1}]}, r"rows\[1\] holds \['offset'\]"),
        ({"rows": [{"kind": "helical"}]}, r"rows\[0\] has kind 'helical'"),
        ({"rows": [{"alpha": "90"}]}, r"rows\[0\].alpha is '90'; a finite number is needed"),
        ({"rows": [{"a": math.nan}]}, r"rows\[0\].a is nan; a finite number is needed"),
        ({"rows": [{"d": True}]}, r"rows\[0\].d is True; a finite number is needed"),
        ({"rows": [{"alpha": 90}]}, r"rows\[0\].alpha is 90 rad, more than a full turn.*math.radians\(90\)"),
        ({"rows": [{}, {"theta": -7}]}, r"rows\[1\].theta is -7 rad"),
        ({"rows": [(0, 0.3, 0, 1.57)]}, r"rows\[0\] is \(0, 0.3, 0, 1.57\); a mapping is needed, such as"),
        ({"rows": np.zeros((2, 4))}, r"rows\[0\] is an array of shape \(4,\); a mapping is needed"),
        ({"rows": {"a": 1}}, r"rows is {'a': 1}; a sequence of mappings"),
        ({"rows": 3}, r"rows is 3; a sequence of mappings"),
        ({"rows": [{}], "modified": "yes"}, "modified is 'yes'; True or False"),
        ({"rows": [{}], "tool": [0, 0, 0.1]}, r"tool has shape \(3,\); .*dexterity.spatial.translation"),
        ({"rows": [{}], "base": 2 * np.eye(4)}, "base is not a rigid-body pose"),
        ({"rows": [{}], "tool": np.eye(3)}, "tool has shape"),
        ({"rows": [{}], "base": np.stack([np.eye(4)] * 2)}, r"base has shape \(2, 4, 4\)"),
        ({"rows": [{}], "tool": np.stack([np.eye(4)] * 2)}, r"tool has shape \(2, 4, 4\)"),
        ({"rows": [{}], "rates": [-1]}, "rates must be finite and not negative"),
    ],
)
@pytest.mark.usefixtures("annotations_unchecked")
def test_bad_denavit_hartenberg_rows_are_refused(arguments, message):
    with pytest.raises((TypeError, ValueError), match=f"^{message}"):
        dx.Chain.from_dh(**arguments)


# ---- on a vehicle ----------------------------------------------------------------------------------


def test_a_chain_on_a_vehicle_is_the_vehicle_times_the_chain(rng, chain):
    T_vehicle_arm = torch.from_numpy(random_pose(rng))
    arm = chain
    if {"x", "y", "z"} & set(chain.joint_names):  # a vehicle on a vehicle needs other joint names
        arm = dx.Chain(chain.screws, chain.home)
    mounted = arm.on_vehicle(T_vehicle_arm)
    q = configurations(rng, mounted, ())
    x, y, z, roll, pitch, yaw = q[:6].tolist()
    T_world_vehicle = shift(0, x) @ shift(1, y) @ shift(2, z) @ turn(0, roll) @ turn(1, pitch) @ turn(2, yaw)
    expected = T_world_vehicle @ T_vehicle_arm @ arm.forward(q[6:])
    assert_close(mounted.forward(q), expected, rtol=0, atol=2e-14)


def test_a_chain_on_a_vehicle_keeps_its_names_and_limits():
    arm = dx.Chain.from_dh(
        [{"a": 1}, {}], name="arm", joint_names=["a", "b"], lower=[-1, -2], upper=[1, 2], rates=[3, 4]
    )
    mounted = arm.on_vehicle(np.eye(4), rates=[0.5, 0.5, 0.5, 0.3, 0.3, 0])
    assert mounted.name == "arm on a vehicle"
    assert mounted.joint_names == ("x", "y", "z", "θx", "θy", "θz", "a", "b")
    assert mounted.kinds == ("prismatic",) * 3 + ("revolute",) * 5
    assert mounted.rates.tolist() == [0.5, 0.5, 0.5, 0.3, 0.3, 0, 3, 4]
    assert mounted.lower.tolist() == [-math.inf] * 6 + [-1, -2]
    assert mounted.upper.tolist() == [math.inf] * 6 + [1, 2]
    assert arm.on_vehicle(np.eye(4), name="rover").name == "rover"
    assert arm.on_vehicle(np.eye(4)).rates.tolist() == [1] * 6 + [3, 4]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"T_vehicle_arm": 2 * np.eye(4)}, "T_vehicle_arm is not a rigid-body pose"),
        ({"T_vehicle_arm": np.stack([np.eye(4)] * 2)}, r"T_vehicle_arm has shape \(2, 4, 4\)"),
        ({"T_vehicle_arm": np.eye(4), "rates": [1] * 5}, r"rates has shape \(5,\); \(6,\) is needed"),
        ({"T_vehicle_arm": np.eye(4), "rates": [-1] * 6}, "rates must be finite and not negative"),
    ],
)
def test_a_bad_mount_is_refused(arguments, message):
    with pytest.raises(ValueError, match=f"^{message}"):
        dx.robots.docking_arm().on_vehicle(**arguments)


# ---- a chain does not change -----------------------------------------------------------------------


def test_what_a_chain_was_made_of_can_be_changed_without_changing_it():
    arguments = {
        "screws": torch.tensor([[0.0, 0, 0, 0, 0, 1], [1, 0, 0, 0, 0, 0]], dtype=torch.float64),
        "home": torch.eye(4, dtype=torch.float64),
        "lower": np.array([-1.0, -1]),
        "upper": np.array([1.0, 1]),
        "rates": torch.ones(2, dtype=torch.float64),
    }
    chain = dx.Chain(**arguments)
    before = {key: getattr(chain, key).clone() for key in arguments}
    T = chain.forward([0.5, 0.5])
    for values in arguments.values():
        values[...] = 7
    for key, values in before.items():
        assert_close(getattr(chain, key), values, rtol=0, atol=0)
    assert_close(chain.forward([0.5, 0.5]), T, rtol=0, atol=0)


@pytest.mark.parametrize("key", ["screws", "home", "lower", "upper", "rates", "link_transforms"])
def test_what_a_chain_returns_can_be_changed_without_changing_it(chain, key):
    before = getattr(chain, key).clone()
    T = chain.forward(torch.ones(chain.joints))
    getattr(chain, key)[...] = 7
    assert_close(getattr(chain, key), before, rtol=0, atol=0)
    assert_close(chain.forward(torch.ones(chain.joints)), T, rtol=0, atol=0)


def test_results_share_no_memory_with_the_chain(chain):
    zero = torch.zeros(chain.joints)
    for method in KINEMATICS:
        before = getattr(chain, method)(zero).clone()
        getattr(chain, method)(zero)[...] = 7
        assert_close(getattr(chain, method)(zero), before, rtol=0, atol=0)


@pytest.mark.parametrize("key", ["home", "name", "_screws", "colour"])
def test_setting_an_attribute_is_refused(chain, key):
    with pytest.raises(AttributeError, match=f"a Chain cannot be changed; {key} "):
        setattr(chain, key, None)


def test_a_copy_is_the_same_chain(rng, chain):
    q = configurations(rng, chain, (2,))
    for twin in (copy.copy(chain), copy.deepcopy(chain), pickle.loads(pickle.dumps(chain))):
        assert (twin.name, twin.joint_names, twin.kinds) == (chain.name, chain.joint_names, chain.kinds)
        assert_close(twin.forward(q), chain.forward(q), rtol=0, atol=0)


def test_a_chain_says_what_it_is():
    arm = dx.Chain.from_dh(
        [{"a": 0.5}, {"kind": "prismatic"}, {}], name="arm", lower=[-1, 0, -math.inf], upper=[1, 0.25, 2],
        rates=[2, 1, 0],
    )  # fmt: skip
    assert repr(arm).splitlines() == [
        "Chain('arm', 3 joints, tool at (0.5, 0, 0) m)",
        "  joint 1  revolute   -1 to 1 rad    2 rad/s",
        "  joint 2  prismatic  0 to 0.25 m    1 m/s",
        "  joint 3  revolute   -inf to 2 rad  locked (rate 0)",
    ]
    assert repr(dx.Chain.from_dh([{}])).splitlines() == [
        "Chain('chain', 1 joint, tool at (0, 0, 0) m)",
        "  joint 1  revolute  without limits  1 rad/s",
    ]
    assert dx.Chain.from_dh([{}]).rates.tolist() == [1]


# ---- bad input, each with an error that names the argument -----------------------------------------


@pytest.mark.parametrize("method", KINEMATICS)
@given(joints=st.integers(0, 30).filter(lambda n: n != 12), batch=st.lists(st.integers(0, 3), max_size=2))
def test_a_wrong_number_of_joints_is_refused(method, joints, batch):
    shape = (*batch, joints)
    with pytest.raises(ValueError, match=re.escape(f"q has shape {shape}; the chain has 12 joints")):
        getattr(UVMS, method)(np.zeros(shape))


@pytest.mark.parametrize("method", KINEMATICS)
def test_a_single_number_is_refused(method):
    with pytest.raises(ValueError, match=r"^q has shape \(\); the chain has 12 joints"):
        getattr(UVMS, method)(0.0)


@pytest.mark.parametrize("method", KINEMATICS)
@given(
    row=st.integers(0, 4), joint=st.integers(0, 11), poison=st.sampled_from([math.nan, math.inf, -math.inf])
)
def test_joint_values_that_are_not_finite_are_refused(method, row, joint, poison):
    q = np.zeros((5, 12))
    q[row, joint] = poison
    with pytest.raises(ValueError, match=r"^q is not finite"):
        getattr(UVMS, method)(q)


@pytest.mark.parametrize("method", KINEMATICS)
@pytest.mark.parametrize("q", [[True] * 12, [1j] * 12, np.array(["0"] * 12)], ids=["bool", "complex", "text"])
def test_joint_values_that_are_no_real_numbers_are_refused(method, q):
    with pytest.raises(TypeError, match=r"^q "):
        getattr(UVMS, method)(q)


off_unit = st.floats(0.01, 100).filter(lambda length: abs(length - 1) > 1.1e-5)


@given(joint=st.integers(0, 11), length=off_unit)
def test_an_axis_that_is_not_of_unit_length_is_refused(joint, length):
    screws = UVMS.screws
    screws[joint] *= length
    with pytest.raises(ValueError, match=rf"^screws\[{joint}\] .*length .*; 1 is needed"):
        dx.Chain(screws, np.eye(4))


@given(joint=st.integers(0, 11))
def test_a_screw_of_zeros_is_refused(joint):
    screws = UVMS.screws
    screws[joint] = 0
    with pytest.raises(ValueError, match=rf"^screws\[{joint}\] .*length 0; 1 is needed"):
        dx.Chain(screws, np.eye(4))


@given(joint=st.integers(3, 11), pitch=st.floats(-10, 10).filter(lambda pitch: abs(pitch) > 3e-5))
def test_a_helical_pitch_is_refused(joint, pitch):
    screws = UVMS.screws
    screws[joint, :3] += pitch * screws[joint, 3:]
    with pytest.raises(ValueError, match=rf"^screws\[{joint}\] has a pitch of"):
        dx.Chain(screws, np.eye(4))


@given(
    entry=st.sampled_from([(i, j) for i in range(4) for j in range(4) if i == 3 or j < 3]),
    change=st.floats(-2, 2).filter(lambda change: abs(change) > 2e-5),
)
def test_a_home_pose_that_is_not_rigid_is_refused(entry, change):
    home = np.eye(4)
    home[entry] += change
    with pytest.raises(ValueError, match=r"^home is not a rigid-body pose"):
        dx.Chain([[0, 0, 0, 0, 0, 1]], home)


@given(joint=st.integers(0, 11), rate=st.floats(max_value=0, exclude_max=True, allow_infinity=True))
def test_a_negative_rate_is_refused(joint, rate):
    rates = UVMS.rates
    rates[joint] = rate
    with pytest.raises(ValueError, match=r"^rates must be finite and not negative"):
        dx.Chain(UVMS.screws, UVMS.home, rates=rates)


def test_a_rate_of_zero_locks_a_joint():
    assert dx.Chain([[0, 0, 0, 0, 0, 1]], np.eye(4), rates=[0]).rates.tolist() == [0]


@pytest.mark.parametrize("key", ["lower", "upper", "rates"])
@pytest.mark.parametrize(
    ("values", "error", "message"),
    [
        ([1.0], ValueError, r"has shape \(1,\); \(2,\) is needed"),
        ([[1.0, 1.0]], ValueError, r"has shape \(1, 2\)"),
        ([1.0, math.nan], ValueError, "holds NaN"),
        ([1j, 1], TypeError, "holds torch.complex"),
        (torch.tensor([1j, 1]), TypeError, "holds torch.complex"),
        ([True, False], TypeError, "holds torch.bool"),
        (np.array(["1", "1"]), TypeError, "cannot be read"),
    ],
    ids=["shape", "matrix", "NaN", "complex list", "complex tensor", "bool", "text"],
)
def test_bad_limits_are_refused(key, values, error, message):
    with pytest.raises(error, match=f"^{key} {message}"):
        dx.Chain([[0, 0, 0, 0, 0, 1], [1, 0, 0, 0, 0, 0]], np.eye(4), **{key: values})


def test_a_lower_limit_above_the_upper_one_is_refused():
    with pytest.raises(ValueError, match=r"^lower exceeds upper at joint 2"):
        dx.Chain([[0, 0, 0, 0, 0, 1]] * 3, np.eye(4), lower=[0, 1, 2], upper=[0, 0.5, 0])


@pytest.mark.parametrize("screws", [np.zeros((0, 6)), np.zeros(6), np.zeros((2, 5)), np.zeros((1, 2, 6))])
def test_screws_of_the_wrong_shape_are_refused(screws):
    with pytest.raises(ValueError, match=r"^screws has shape"):
        dx.Chain(screws, np.eye(4))


@pytest.mark.parametrize("home", [np.eye(3), np.stack([np.eye(4)] * 2)])
def test_a_home_pose_of_the_wrong_shape_is_refused(home):
    with pytest.raises(ValueError, match=r"^home has shape .*\(4, 4\) is needed"):
        dx.Chain([[0, 0, 0, 0, 0, 1]], home)


@pytest.mark.parametrize("names", [["a"], ["a", "b", "c"], ["a", "a"]])
def test_joint_names_that_do_not_name_each_joint_are_refused(names):
    with pytest.raises(ValueError, match=r"^joint_names holds"):
        dx.Chain([[0, 0, 0, 0, 0, 1]] * 2, np.eye(4), joint_names=names)


@pytest.mark.parametrize("key", ["screws", "home"])
@pytest.mark.parametrize("poison", [math.nan, math.inf])
def test_a_description_that_is_not_finite_is_refused(key, poison):
    arguments = {"screws": np.array([[0, 0, 0, 0, 0, 1.0]]), "home": np.eye(4)}
    arguments[key][0, 3] = poison
    with pytest.raises(ValueError, match=f"^{key} is not finite"):
        dx.Chain(**arguments)
