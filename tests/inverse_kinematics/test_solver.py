"""Solutions of any chain: reach, limits, rows, redundancy, seeds, and other libraries."""

import math
import sysconfig
from pathlib import Path

import numpy as np
import pytest
import torch
from arms import IIWA, PANDA, PLANAR, SCARA, UR5, apart, chain_of, random_configurations
from hypothesis import given
from hypothesis import strategies as st
from torch.testing import assert_close

import dexterity as dx
from dexterity import spatial
from dexterity.inverse_kinematics import closed_form, solve
from warm_process import WarmProcess

READY = [0, -math.pi / 4, 0, -3 * math.pi / 4, 0, math.pi / 2, math.pi / 4]


# ---- what a UR5 and a Panda reach (sampled_reachability_maps#2, #3, reach#52, reuleaux#55) ------------


@pytest.mark.parametrize("chain", [UR5, PANDA], ids=["UR5", "Panda"])
def test_twenty_poses_are_reached_and_one_is_not(chain):
    free = dx.Chain(chain.screws, chain.home)
    q = 4 * torch.rand(20, chain.joints, generator=torch.Generator().manual_seed(0), dtype=torch.float64) - 2
    found = solve(free, free.forward(q))
    assert found.reached.all()
    assert (free.forward(found.q) - free.forward(q)[:, None]).abs().amax((-2, -1))[found.valid].max() < 1e-8
    away = solve(free, spatial.translation(3.0, 0, 0))
    assert not away.reached
    assert away.q.isfinite().all()
    # Only a closed form says that a pose is out of reach.
    assert away.complete == (chain is UR5)


@pytest.mark.parametrize("chain", [PANDA, IIWA, UR5], ids=lambda chain: chain.name)
def test_a_search_reaches_what_can_be_reached(chain):
    q = random_configurations(chain, 300)
    found = solve(chain, chain.forward(q), method="search", enough=1)
    assert found.reached.double().mean() >= 0.99
    assert found.residual[found.usable].max() < 1e-9
    assert ((found.q >= chain.lower - 1e-9) & (found.q <= chain.upper + 1e-9))[found.usable].all()
    assert found.seeds.tried.double().mean() < 16


@pytest.mark.parametrize("chain", [UR5, dx.robots.puma560()], ids=["UR5", "PUMA"])
def test_a_search_finds_what_the_closed_form_finds(chain):
    T = chain.forward(random_configurations(chain, 20, seed=3))
    exact, searched = solve(chain, T), solve(chain, T, method="search")
    assert exact.complete
    assert not searched.complete
    assert (searched.count > exact.count).sum() == 0
    assert (searched.count == exact.count).double().mean() > 0.9
    for ours, theirs, n in zip(searched.q, exact.q, searched.count.tolist(), strict=True):
        assert apart(ours[:n, None], theirs).amin(1).max() < 1e-6


def test_seven_joints_against_ssik():
    from ssik.prebuilt.franka import panda_ik

    arm = chain_of(panda_ik.fk, 7)
    arm = dx.Chain(arm.screws, arm.home, lower=PANDA.lower, upper=PANDA.upper)
    T = arm.forward(random_configurations(PANDA, 5))
    found = solve(arm, T, seeds=16)
    for pose, q, usable in zip(T, found.q, found.usable, strict=True):
        assert usable.any()
        for one in q[usable].numpy():
            np.testing.assert_allclose(panda_ik.fk(one), pose.numpy(), atol=1e-8)


def test_forward_kinematics_of_pinocchio_agree():
    import pinocchio

    folder = Path(sysconfig.get_paths()["purelib"]) / "cmeel.prefix/share/example-robot-data/robots"
    path = str(folder / "panda_description/urdf/panda.urdf")
    chain = dx.Chain.from_urdf(path, tip="panda_link8")
    model = pinocchio.buildModelFromUrdf(path)
    T = chain.forward(random_configurations(chain, 5))
    found = solve(chain, T, seeds=8)
    data, frame = model.createData(), model.getFrameId("panda_link8")
    for pose, q in zip(T, found.q[:, 0], strict=True):
        full = np.concatenate([q.numpy(), np.zeros(model.nq - 7)])
        pinocchio.framesForwardKinematics(model, data, full)
        np.testing.assert_allclose(data.oMf[frame].homogeneous, pose.numpy(), atol=1e-8)


# ---- any number of joints, and chosen rows ------------------------------------------------------------


def test_one_joint():
    one = dx.Chain.from_dh([{"a": 0.5}], lower=[-1.0], upper=[1.0])
    found = solve(one, one.forward([0.3]))
    assert_close(found.q, torch.tensor([[0.3]], dtype=torch.float64))
    assert not solve(one, one.forward([1.5])).reached
    assert solve(one, one.forward([1.5])).seeds.at_limits == 64


def test_a_planar_arm_has_two_configurations():
    q = random_configurations(PLANAR, 20)
    found = solve(PLANAR, PLANAR.forward(q))
    # Closed form: the elbow and its mirror image, with the same direction of the last link.
    radius = torch.hypot(0.5 + 0.4 * q[:, 1].cos(), 0.4 * q[:, 1].sin())
    other = torch.stack(
        [q[:, 0] + 2 * torch.atan2(0.4 * q[:, 1].sin(), 0.5 + 0.4 * q[:, 1].cos()), -q[:, 1]], -1
    )
    assert (radius > 0).all()
    assert (found.count == 2).all()
    for expected in (q[:, :2], other):
        assert apart(found.q[..., :2], expected[:, None]).amin(1).max() < 1e-6


def test_a_sliding_joint_and_four_rows():
    q = random_configurations(SCARA, 20)
    found = solve(SCARA, SCARA.forward(q), rows=("vx", "vy", "vz", "wz"))
    assert found.reached.all()
    assert (SCARA.forward(found.q) - SCARA.forward(q)[:, None]).abs().amax((-2, -1))[
        found.usable
    ].max() < 1e-8
    assert torch.where(found.usable, apart(found.q, q[:, None]), torch.inf).amin(-1).max() < 1e-6


@pytest.mark.parametrize(
    "rows", ["full", "translational", "rotational", ("vx", "vy", "vz", "wx", "wy"), (0, 1), ("wz",)]
)
def test_chosen_rows_vanish_along_the_axes_of_the_tool(rows):
    T = PANDA.forward(random_configurations(PANDA, 10))
    found = solve(PANDA, T, rows=rows, seeds=8)
    assert found.reached.all()
    numbers = dx.indices.rows.row_numbers(rows)
    actual = PANDA.forward(found.q)
    away = spatial.inverse(actual) @ T[:, None]
    turn = spatial.log(away)[..., 3:]
    remaining = torch.cat([away[..., :3, 3], turn], -1)[..., list(numbers)]
    assert remaining.abs().amax(-1)[found.usable].max() < 1e-8


ROWS_OF_THE_WORLD = [
    "translational",
    ("vx", "vy", "wz"),
    ("vx", "vy", "vz", "wx", "wy"),
    ("vz",),
    ("wx", "vy"),
]


@pytest.mark.parametrize("rows", ROWS_OF_THE_WORLD)
def test_chosen_rows_vanish_along_the_axes_of_the_world(rows):
    T = PANDA.forward(random_configurations(PANDA, 10))
    found = solve(PANDA, T, rows=rows, frame="geometric", seeds=8)
    assert found.reached.all()
    actual, wanted = PANDA.forward(found.q), T[:, None]
    turn = spatial.log(spatial.pose(wanted[..., :3, :3] @ actual[..., :3, :3].mT, [0, 0, 0]))[..., 3:]
    remaining = torch.cat([wanted[..., :3, 3] - actual[..., :3, 3], turn], -1)
    numbers = dx.indices.rows.row_numbers(rows)
    assert remaining[..., list(numbers)].abs().amax(-1)[found.usable].max() < 1e-8
    if len(numbers) < 5:  # and what is free is used
        assert remaining.abs().amax(-1)[found.usable].max() > 0.1


def test_the_axis_of_the_tool_alone_or_the_heading_alone():
    """Five rows: the spin about the tool's z axis is free, or that about the vertical."""
    rows = ("vx", "vy", "vz", "wx", "wy")
    T = UR5.forward(random_configurations(UR5, 10))
    spun, turned = solve(UR5, T, rows=rows, seeds=16), solve(UR5, T, rows=rows, frame="geometric", seeds=16)
    for found, column in (
        (spun, UR5.forward(spun.q)[..., :3, 2]),
        (turned, UR5.forward(turned.q)[..., 2, :3]),
    ):
        wanted = (T[:, None, :3, 2] if found is spun else T[:, None, 2, :3]).expand_as(column)
        assert found.reached.all()
        assert_close(column[found.usable], wanted[found.usable], rtol=0, atol=1e-8)
        assert ((UR5.forward(found.q) - T[:, None]).abs().amax((-2, -1))[found.usable] > 0.1).any()


def test_a_planar_task_of_the_world_whatever_the_tool_looks_like():
    """Three links in a plane with a tool that is tilted: its own axes say nothing about the plane."""
    tilted = PLANAR.with_tool(spatial.from_rpy([0.7, 0.4, 0.2]))
    q = random_configurations(PLANAR, 10)
    T = spatial.compose(spatial.translation(0, 0, 0.3), tilted.forward(q))
    found = solve(tilted, T, rows=("vx", "vy", "wz"), frame="geometric", seeds=16)
    assert (found.count == 2).all()
    assert apart(found.q, q[:, None]).amin(-1).max() < 1e-6


def test_full_rows_are_the_same_along_all_axes():
    T = PANDA.forward(random_configurations(PANDA, 5))
    body, world = (solve(PANDA, T, seeds=4, frame=frame) for frame in ("body", "geometric"))
    assert_close(body.q, world.q, rtol=0, atol=1e-6)


def test_a_free_rotation_is_used():
    """A tool whose rotation about its axis is free reaches more."""
    T = PANDA.forward(random_configurations(PANDA, 60))
    turned = T @ spatial.from_rpy([2.5, 0, 0])
    full = solve(PANDA, turned, enough=1).reached
    free = solve(PANDA, turned, rows=("vx", "vy", "vz", "wy", "wz"), enough=1).reached
    assert free.all()
    assert not full.all()


def test_a_vehicle_far_away():
    """Joints without limits, metres and radians mixed."""
    uvms = dx.robots.uvms()
    q = random_configurations(uvms, 10)
    q[:, :3] *= 30
    found = solve(uvms, uvms.forward(q), seeds=16)
    assert found.reached.all()
    assert found.residual[found.usable].max() < 1e-9


# ---- redundant chains -----------------------------------------------------------------------------------


@pytest.mark.parametrize("engine", ["index", "bound", "compiled"])
def test_a_secondary_objective_is_climbed_in_the_null_space(engine):
    index = dx.indices.Index("manipulability")
    w = index.bind(PANDA)
    secondary = {"index": index, "bound": w, "compiled": dx.symbolic.compile_index(PANDA, index)}[engine]
    T = PANDA.forward(random_configurations(PANDA, 6))
    plain, climbed = solve(PANDA, T, seeds=12), solve(PANDA, T, seeds=12, secondary=secondary)
    assert climbed.reached.all()
    assert (PANDA.forward(climbed.q) - T[:, None]).abs().amax((-2, -1))[climbed.usable].max() < 1e-8
    best = torch.where(plain.usable, w(plain.q), 0.0).amax(-1)
    assert (w(climbed.q[:, 0]) >= best - 1e-9).all()
    assert (w(climbed.q[:, 0]) > 1.02 * best).any()
    values = torch.where(climbed.usable, w(climbed.q), -1.0)
    assert (values.diff(dim=-1) <= 1e-12).all()


def test_joints_are_centred():
    T = IIWA.forward(random_configurations(IIWA, 4))

    def cost(q):
        return (q / IIWA.upper).square().sum(-1)

    plain, centred = solve(IIWA, T, seeds=12), solve(IIWA, T, seeds=12, secondary="centre")
    best = torch.where(plain.usable, cost(plain.q), torch.inf).amin(-1)
    assert (cost(centred.q[:, 0]) < best).all()


def test_representatives_of_a_redundant_chain_differ():
    found = solve(PANDA, PANDA.forward(READY))
    q = found.q[found.usable]
    assert len(q) > 3
    pairs = apart(q[:, None], q) + 10 * torch.eye(len(q))
    assert pairs.min() >= 0.5


# ---- near to where the robot is (ssik#562, ur-analytic-ik#19, rtb-python#260) ------------------------------


@pytest.mark.parametrize("chain", [UR5, PANDA, dx.robots.puma560()], ids=["UR5", "Panda", "PUMA"])
def test_the_first_solution_is_the_nearest(chain):
    q = random_configurations(chain, 20, seed=5)
    found = solve(chain, chain.forward(q), near=q, seeds=16)
    assert_close(found.q[:, 0], q, rtol=0, atol=1e-6)
    distances = torch.where(found.usable, (found.q - q[:, None]).norm(dim=-1), torch.inf)
    assert (distances[:, :-1] <= distances[:, 1:]).all()
    nearest, any_ = found.nearest(q)
    assert any_.all()
    assert_close(nearest, found.q[:, 0], rtol=0, atol=1e-12)


def test_a_seed_a_turn_away_is_met():
    q = torch.tensor(np.radians([0, 30, 40, 50, 60, -10]))
    seed = torch.tensor(np.radians([0, 30, 40, 50, 60, 350]))
    found = solve(UR5, UR5.forward(q), near=seed)
    assert_close(found.q[0], seed, rtol=0, atol=1e-9)
    assert_close(solve(UR5, UR5.forward(q)).nearest(seed)[0], seed, rtol=0, atol=1e-9)


def test_nearest_without_any_says_so():
    q, any_ = solve(UR5, spatial.translation(3.0, 0, 0)).nearest(torch.zeros(6))
    assert q.shape == (6,)
    assert not any_


def test_every_winding_is_that_of_ssik():
    """ssik#562, EAIK#26: all solutions within the limits, every full turn."""
    from ssik.prebuilt.universal_robots import ur5_ik

    arm = chain_of(ur5_ik.fk, 6)
    # Their limits: a full turn to either side, half a turn at the elbow.
    limits = torch.tensor([2, 2, 1, 2, 2, 2], dtype=torch.float64) * math.pi
    arm = dx.Chain(arm.screws, arm.home, lower=-limits, upper=limits)
    T = ur5_ik.fk(np.array([0.3, -1, 1.2, -0.5, 0.8, 0.2]))
    theirs = torch.tensor(np.array([solution.q for solution in ur5_ik.solve(T)]))
    found = solve(arm, T)
    copies = found.copies()
    assert len(copies) == len(theirs) == 8 * 2**5
    assert (copies[:, None] - theirs).abs().amax(-1).amin(0).max() < 1e-6
    assert dx.inverse_kinematics.within_limits(arm, copies).all()
    assert solve(arm, spatial.translation(3.0, 0, 0)).copies().shape == (0, 6)
    with pytest.raises(ValueError, match=r"^solutions are those of poses \(2,\)"):
        solve(arm, arm.home[None].expand(2, 4, 4)).copies()


# ---- limits, locked joints, counts ---------------------------------------------------------------------


@pytest.mark.parametrize("chain", [PANDA, IIWA, dx.robots.puma560()], ids=["Panda", "iiwa", "PUMA"])
def test_a_joint_exactly_at_its_limit(chain):
    q = random_configurations(chain, 20, seed=7)
    ends = torch.stack([chain.lower, chain.upper])
    for row, joint in enumerate(torch.arange(20) % chain.joints):
        q[row, joint] = ends[row % 2, joint]
    found = solve(chain, chain.forward(q), near=q)
    assert found.reached.all()
    assert apart(found.q[:, 0], q).max() < 1e-5


def test_a_joint_with_rate_zero_keeps_its_value():
    chain = dx.Chain(
        PANDA.screws, PANDA.home, lower=PANDA.lower, upper=PANDA.upper, rates=[1, 1, 0, 1, 1, 1, 1]
    )
    q = random_configurations(chain, 5)
    q[:, 2] = 0.3
    found = solve(chain, chain.forward(q), near=[0, 0, 0.3, -1.5, 0, 1.5, 0], seeds=32)
    assert found.reached.all()
    assert (found.q[..., 2][found.usable] == 0.3).all()
    locked = dx.Chain(UR5.screws, UR5.home, rates=[1, 1, 1, 1, 1, 0])
    assert closed_form(locked) is not None
    assert solve(locked, UR5.forward([0.1, -1, 1, 0.3, 0.4, 0.0])).method == "search"
    with pytest.raises(ValueError, match=r"^method is 'closed form', but chain .* locked"):
        solve(locked, UR5.home, method="closed form")


def test_every_seed_is_counted():
    T = PANDA.forward(random_configurations(PANDA, 10))
    T[5:, 0, 3] += 5.0
    seeds = solve(PANDA, T, seeds=20).seeds
    assert (seeds.tried == 20).all()
    assert_close(seeds.converged + seeds.at_limits + seeds.stuck, seeds.tried)
    assert (seeds.converged[5:] == 0).all()
    assert (seeds.converged[:5] > 0).all()
    few = solve(PANDA, T, seeds=20, enough=1).seeds
    assert (few.tried[5:] == 20).all()
    assert (few.tried[:5] < 20).any()


def test_batches_and_repetition(batch_shape):
    q = random_configurations(PANDA, math.prod(batch_shape)).reshape(*batch_shape, 7)
    found = solve(PANDA, PANDA.forward(q), seeds=8)
    assert found.q.shape[:-2] == batch_shape
    assert found.reached.shape == found.seeds.tried.shape == batch_shape
    again = solve(PANDA, PANDA.forward(q), seeds=8)
    assert_close(found.q, again.q, rtol=0, atol=0)


def test_solutions_serve_after_inference_mode():
    with torch.inference_mode():
        dx.inverse_kinematics.spherical_wrist(dx.robots.docking_arm(), torch.eye(4))
        solve(UR5, UR5.home)
    arm = dx.robots.docking_arm()
    T = arm.forward(torch.full((6,), 0.3, dtype=torch.float64)).requires_grad_()
    q, valid = dx.inverse_kinematics.spherical_wrist(arm, T)
    (slope,) = torch.autograd.grad(q[valid].sum(), T)
    assert slope.isfinite().all()


DEFAULT_DEVICE = """
import torch, dexterity as dx
arms = dx.robots.load("ur5e"), dx.robots.puma560(), dx.robots.load("panda")
torch.set_default_device("meta")
with torch.device("cpu"):
    T = [arm.forward(torch.full((3, arm.joints), 0.5)) for arm in arms]
for arm, poses in zip(arms, T):
    found = dx.inverse_kinematics.solve(arm, poses, enough=1)
    assert found.q.device.type == "cpu" and found.reached.all(), found
    q, within = dx.inverse_kinematics.nearest_copy(arm, found.q[:, 0])
    assert q.device.type == "cpu" and within.all()
"""


def test_results_are_where_the_poses_are_whatever_the_default_device():
    """pytorch_kinematics#39: constants on another device. The device without values stands for it."""
    ended, printed = WarmProcess(DEFAULT_DEVICE).end()
    assert ended == 0, printed


def test_it_says_what_it_is():
    assert repr(solve(UR5, UR5.home[None].expand(3, 4, 4))) == (
        "Solutions(3 poses by three parallel axes (complete): 3 reached within the limits)"
    )
    assert "by search (not complete)" in repr(solve(PANDA, PANDA.forward(READY), seeds=4))


def test_what_values_decide_about_is_refused_where_there_are_none():
    T = UR5.forward(random_configurations(UR5, 3))
    calls = [
        lambda T: solve(UR5, T).q,
        lambda T: dx.inverse_kinematics.three_parallel_axes(UR5, T)[0],
        lambda T: dx.inverse_kinematics.spherical_wrist(dx.robots.puma560(), T)[0],
    ]
    for call in calls:
        with pytest.raises(TypeError, match=r"^T_\w+_tool has no values here"):
            torch.func.vmap(call)(T)
        with pytest.raises(TypeError, match=r"^T_\w+_tool has no values here"):
            call(T.to("meta"))
    # Derivatives leave the values as they are.
    slopes = torch.func.jacrev(calls[1])(T[0])
    assert slopes.shape == (8, 6, 4, 4)
    assert_close(slopes, torch.autograd.functional.jacobian(calls[1], T[0]))


# ---- what goes in -----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("options", "error", "message"),
    [
        ({"rows": "linear"}, ValueError, r"^rows is 'linear'"),
        ({"rows": 3}, TypeError, r"^rows is 3"),
        ({"rows": ()}, ValueError, r"^rows is \(\)"),
        ({"frame": "spatial"}, ValueError, r"^frame is 'spatial'"),
        ({"frame": 3}, (TypeError, ValueError), r"^frame is 3"),
        ({"seeds": 0}, ValueError, r"^seeds is 0"),
        ({"seeds": 2.5}, TypeError, r"^seeds is 2.5"),
        ({"enough": 0}, ValueError, r"^enough is 0"),
        ({"tolerance": 0.0}, ValueError, r"^tolerance is 0"),
        ({"tolerance": math.nan}, ValueError, r"^tolerance is nan"),
        ({"limit_tolerance": -1.0}, ValueError, r"^limit_tolerance is -1"),
        ({"limit_tolerance": "1"}, TypeError, r"^limit_tolerance is '1'"),
        ({"near": [0.0] * 6}, ValueError, r"^near has shape \(6,\)"),
        ({"near": [math.nan] * 7}, ValueError, r"^near is not finite"),
        ({"near": torch.zeros(2, 7)}, ValueError, r"^near has shape \(2, 7\)"),
        ({"secondary": "middle"}, ValueError, r"^secondary is 'middle'"),
        ({"secondary": 3.0}, TypeError, r"^secondary is 3.0"),
        ({"method": "magic"}, ValueError, r"^method is 'magic'"),
        ({"method": "closed form"}, ValueError, r"^method is 'closed form', but chain 'Panda' has none"),
        ({"seed": -1}, ValueError, r"^seed is -1"),
    ],
    ids=str,
)
def test_bad_options_are_refused_by_name(options, error, message, annotations_unchecked):
    with pytest.raises(error, match=message):
        solve(PANDA, PANDA.home, **options)


@given(
    T=st.one_of(
        st.lists(st.floats(), min_size=16, max_size=16).map(lambda x: np.reshape(x, (4, 4))),
        st.sampled_from([np.eye(3), np.zeros((4, 4)), "pose", None, np.diag([1.0, 1, -1, 1])]),
    )
)
def test_bad_poses_are_refused_by_name(T):
    import jaxtyping

    jaxtyping.config.update("jaxtyping_disable", True)
    try:
        with pytest.raises((ValueError, TypeError), match=r"^T_world_tool "):
            solve(PANDA, T)
        with pytest.raises(TypeError, match=r"^chain is "):
            solve(T, np.eye(4))
    finally:
        jaxtyping.config.update("jaxtyping_disable", False)


ROBOTS = [name for name in dx.robots.names() if dx.robots.load(name).lower.isfinite().any()]


@pytest.mark.parametrize("name", ROBOTS)
def test_a_search_finds_configurations_in_corners_of_the_limits(name):
    """Of the kind of dart#1449 and moveit#598: one joint, half of them, and all exactly at a limit."""
    chain = dx.robots.load(name)
    random = np.random.default_rng(3)
    lower, upper = chain.lower.clamp(min=-math.pi).numpy(), chain.upper.clamp(max=math.pi).numpy()
    q = random.uniform(lower, upper, (18, chain.joints))
    for row, at_limits in zip(q, [1, chain.joints // 2, chain.joints] * 6, strict=True):
        for joint in random.permutation(chain.joints)[:at_limits]:
            row[joint] = random.choice([lower[joint], upper[joint]])
    q[:, (chain.rates == 0).numpy()] = 0
    rows = "full" if chain.joints >= 6 else "translational"
    # Singular configurations are among them, where a search comes to its pose slowly.
    found = solve(chain, chain.forward(q), rows=rows, method="search")
    assert found.reached.all()
    best = found.q[..., 0, :]
    assert ((best >= chain.lower - 1e-9) & (best <= chain.upper + 1e-9)).all()


# ---- other kinds of limits, seeds and poses -----------------------------------------------------------


@pytest.mark.parametrize("chain", [UR5, PANDA], ids=["closed form", "search"])
def test_no_poses_give_no_solutions(chain):
    for shape in ((0,), (2, 0), (0, 3)):
        found = solve(chain, torch.zeros(*shape, 4, 4), seeds=4)
        assert found.reached.shape == found.count.shape == shape
        assert found.q.shape == (*shape, found.q.shape[-2], chain.joints)
        assert solve(chain, torch.zeros(*shape, 4, 4), near=chain.home.new_zeros(chain.joints)).q.numel() == 0


@pytest.mark.parametrize("chain", [UR5, PANDA], ids=["closed form", "search"])
def test_poses_in_single_precision_and_right_to_six_digits(chain):
    T = chain.forward(random_configurations(chain, 4))
    printed = T.clone()
    printed[:, :3] = (T[:, :3] * 1e6).round() / 1e6
    for rough in (T.float(), T.float().numpy(), printed, printed.tolist()):
        found = solve(chain, rough, seeds=16)
        assert found.reached.all()
        assert (chain.forward(found.q) - T[:, None]).abs().amax((-2, -1))[found.usable].max() < 5e-6


@pytest.mark.parametrize("method", ["auto", "search"])
def test_limits_that_leave_one_value_or_less_than_the_tolerance(method):
    q = torch.tensor([0.3, -1.0, 1.2, -0.5, 0.8, 0.2], dtype=torch.float64)
    for width in (0.0, 1e-12):
        lower, upper = UR5.lower.clone(), UR5.upper.clone()
        lower[2], upper[2] = q[2] - width, q[2] + width
        narrow = dx.Chain(UR5.screws, UR5.home, lower=lower, upper=upper)
        found = solve(narrow, narrow.forward(q), method=method)
        assert found.reached
        assert apart(found.q[found.usable], q).amin() < 1e-6
        assert (found.q[found.usable][:, 2] - q[2]).abs().max() < 2e-9


@pytest.mark.parametrize("chain", [UR5, PANDA], ids=["closed form", "search"])
def test_a_seed_beyond_the_limits_is_one_to_be_near_to(chain):
    q = random_configurations(chain, 3)
    far = q + 20 * math.tau
    found = solve(chain, chain.forward(q), near=far, seeds=16)
    assert found.reached.all()
    assert dx.inverse_kinematics.within_limits(chain, found.q[:, 0]).all()
    distances = torch.where(found.usable, (found.q - far[:, None]).norm(dim=-1), torch.inf)
    assert (distances[:, 0] == distances.amin(-1)).all()


def test_limits_away_from_zero_and_windings_in_a_search():
    """KUKA's ±350°, and limits that hold several turns, none of them about zero."""
    lower = UR5.lower + torch.tensor([10.0, 0, 20, -9, 0, 3])
    chain = dx.Chain(UR5.screws, UR5.home, lower=lower, upper=lower + 4 * math.pi)
    q = torch.tensor([0.3, -1.0, 1.2, -0.5, 0.8, 0.2], dtype=torch.float64)
    exact, searched = solve(chain, chain.forward(q)), solve(chain, chain.forward(q), method="search")
    assert exact.count == searched.count == 8
    assert dx.inverse_kinematics.within_limits(chain, searched.q[searched.usable]).all()
    assert len(exact.copies()) == len(searched.copies()) == 8 * 2**6


def test_the_nearest_by_weighted_distance():
    q = torch.tensor([0.3, -1.0, 1.2, -0.5, 0.8, 0.2], dtype=torch.float64)
    found, seed = solve(UR5, UR5.forward(q)), q + 0.9
    for joint in range(6):
        weights = torch.full((6,), 1e-9)
        weights[joint] = 1.0
        nearest, some = found.nearest(seed, weights)
        assert some
        away = spatial.wrap_to_pi(found.q[found.usable][:, joint] - seed[joint]).abs()
        assert (nearest[joint] - seed[joint]).abs() == pytest.approx(float(away.min()), abs=1e-6)
    for wrong in ([1.0] * 5, [-1.0] + [1.0] * 5, [math.nan] * 6):
        with pytest.raises(ValueError, match=r"^weights is"):
            found.nearest(seed, wrong)


def test_solutions_become_arrays():
    found = solve(PANDA, PANDA.forward(READY), seeds=4)
    for name in ("q", "valid", "within_limits", "residual", "usable", "count", "reached"):
        array = np.asarray(getattr(found, name))
        assert array.shape == tuple(getattr(found, name).shape)


def test_a_locked_joint_stays_where_it_is_though_a_pose_is_out_of_reach():
    panda = dx.robots.panda()
    rates = panda.rates.clone()
    rates[2] = 0
    locked = dx.Chain(panda.screws, panda.home, lower=panda.lower, upper=panda.upper, rates=rates)
    found = dx.inverse_kinematics.solve(locked, dx.spatial.translation(3.0, 0, 0), seeds=8)
    assert not found.reached
    assert (found.q[:, 2] == 0).all()
