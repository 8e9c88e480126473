"""Subproblems against their statement, branches against forward kinematics and where the pose came from."""

import itertools
import math

import numpy as np
import pytest
import torch
from hypothesis import strategies as st
from torch.testing import assert_close

import dexterity as dx
from dexterity import spatial
from dexterity.inverse_kinematics import closed_form, spherical_shoulder, spherical_wrist

POSES = 20_000
NAMED = ["stated", "fitted", "PUMA"]


def screw(point, direction) -> torch.Tensor:
    direction = np.asarray(direction) / np.linalg.norm(direction)
    return torch.tensor(np.concatenate([np.cross(point, direction), direction]))


def arm_of(points, directions, wrist) -> dx.Chain:
    """Arm with its first three axes through points, and the other three through the wrist's centre."""
    axes = zip([*points, *[wrist] * 3], directions, strict=True)
    return dx.Chain(torch.stack([screw(*axis) for axis in axes]), np.diag([1.0, -1.0, -1.0, 1.0]))


def arm_with(relation: str) -> dx.Chain:
    """Arm at random but for how its first three axes lie to each other."""
    rng = np.random.default_rng(7)
    points, directions = rng.normal(size=(3, 3)), rng.normal(size=(6, 3))
    if "1 meets 2" in relation:
        points[1] = points[0]
    if "2 meets 3" in relation:
        points[2] = points[1] + 0.8 * directions[1] / np.linalg.norm(directions[1])
    if "1 parallel to 2" in relation:
        directions[1] = directions[0]
    if "2 parallel to 3" in relation:
        directions[2] = -directions[1]
    return arm_of(points, directions, rng.normal(size=3))


ARMS = {
    "stated": dx.robots.docking_arm(),
    "fitted": dx.robots.docking_arm("fitted"),
    "PUMA": dx.robots.puma560(),
    **{
        relation: arm_with(relation)
        for relation in (
            "1 meets 2", "2 meets 3", "1 parallel to 2", "2 parallel to 3", "1 meets 2, 2 meets 3",
            "1 meets 2, 2 parallel to 3", "1 parallel to 2, 2 meets 3", "all skew",
        )
    },
}  # fmt: skip

every_arm = pytest.mark.parametrize("arm", ARMS.values(), ids=ARMS)
numbers = st.floats(-2, 2)
points = st.tuples(numbers, numbers, numbers)
angles = st.floats(-math.pi, math.pi)


def generator(seed: int = 0) -> torch.Generator:
    return torch.Generator().manual_seed(seed)


def random_configurations(count: int, seed: int = 0) -> torch.Tensor:
    return (2 * torch.rand(count, 6, generator=generator(seed), dtype=torch.float64) - 1) * math.pi


def turned(axis, angle, p) -> torch.Tensor:
    T = spatial.exp(torch.as_tensor(axis) * torch.as_tensor(angle, dtype=torch.float64)[..., None])
    return (T[..., :3, :3] @ torch.as_tensor(p, dtype=torch.float64)[..., None])[..., 0] + T[..., :3, 3]


def apart(a: torch.Tensor, b: torch.Tensor) -> torch.Tensor:
    """Largest difference (...) of joint values, full turns apart."""
    return dx.spatial.wrap_to_pi(a - b).abs().amax(-1)


def missed(arm, q, T) -> torch.Tensor:
    return (arm.forward(q) - T).abs().amax((-2, -1))


# ---- arms ------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ARMS)
def test_every_pose_gives_back_its_configuration(name):
    arm = ARMS[name]
    q = random_configurations(POSES if name in NAMED else POSES // 10)
    T = arm.forward(q)
    found, valid = spherical_wrist(arm, T)
    assert found.shape == (len(q), 8, 6)
    assert torch.isfinite(found).all()
    assert (found.abs() <= math.pi).all()
    assert missed(arm, found, T[:, None])[valid].max() < 1e-8
    nearest = torch.where(valid, apart(found, q[:, None]), torch.inf).amin(-1)
    # A pose near a singular one knows its configuration only so well.
    assert nearest.max() < 1e-6
    assert nearest.median() < 1e-13


@pytest.mark.parametrize("name", NAMED)
def test_elbow_arms_have_eight_different_branches(name):
    arm = ARMS[name]
    T = arm.forward(random_configurations(POSES, seed=1))
    q, valid = spherical_wrist(arm, T)
    assert valid.all()
    assert missed(arm, q, T[:, None]).max() < 1e-9
    pairs = list(itertools.combinations(range(8), 2))
    closest = torch.stack([apart(q[:, i], q[:, j]) for i, j in pairs]).amin(0)
    assert (closest > 1e-6).all()


def test_branches_are_those_of_a_numerical_search():
    """What a search from random starts converges to is among the branches, for axes all skew."""
    arm = ARMS["all skew"]
    T = arm.forward(random_configurations(1, seed=3)[0])
    q, valid = spherical_wrist(arm, T)
    searched = random_configurations(400, seed=4)
    for _ in range(60):
        twist = spatial.log(spatial.compose(spatial.inverse(arm.forward(searched)), T))
        J = arm.body_jacobian(searched)
        step = torch.linalg.solve(J.mT @ J + 1e-6 * torch.eye(6), (J.mT @ twist[..., None]))[..., 0]
        searched = searched + step.clamp(-0.5, 0.5)
    solutions = searched[missed(arm, searched, T) < 1e-9]
    nearest = apart(solutions[:, None], q[valid]).amin(1)
    assert nearest.max() < 1e-7
    assert (apart(q[valid][:, None], solutions).amin(1) < 1e-7).all()


@every_arm
def test_out_of_reach_is_flagged(arm):
    T = arm.forward(random_configurations(50))
    T[:, :3, 3] += torch.tensor([40.0, -30.0, 50.0])
    q, valid = spherical_wrist(arm, T)
    assert not valid.any()
    assert torch.isfinite(q).all()


@every_arm
@pytest.mark.parametrize("bend", [0.0, 1e-9, 1e-8, 1e-7, 1e-5])
def test_a_wrist_that_is_almost_straight(arm, bend):
    straight = math.atan2(*_straight_wrist(arm))
    q = random_configurations(200)
    q[:, 4] = straight + bend
    T = arm.forward(q)
    found, valid = spherical_wrist(arm, T)
    assert torch.isfinite(found).all()
    assert valid.any(-1).all()
    assert missed(arm, found, T[:, None])[valid].max() < 1e-8


def _straight_wrist(arm) -> tuple[float, float]:
    """Sine and cosine of the fifth joint with the sixth axis nearest to the fourth."""
    four, five, six = arm.screws[3:, 3:]
    across = torch.linalg.cross(five, six)
    return (four @ across).item(), (four @ (six - (six @ five) * five)).item()


@pytest.mark.parametrize("name", NAMED)
def test_a_stretched_arm(name):
    arm = ARMS[name]
    q = random_configurations(200)
    q[:, 2] = 0.0 if name != "PUMA" else math.atan2(-0.0203, 0.4318) + math.pi / 2
    T = arm.forward(q)
    found, valid = spherical_wrist(arm, T)
    assert valid.any(-1).all()
    assert missed(arm, found, T[:, None])[valid].max() < 1e-9


def test_the_wrist_over_the_first_axis():
    arm = ARMS["stated"]
    # Straight up: the first joint turns the tool about itself, and any value will do.
    q = torch.tensor([0.4, math.pi / 2, 0.0, 0.3, 0.5, -0.2], dtype=torch.float64)
    T = arm.forward(q)
    found, valid = spherical_wrist(arm, T)
    assert torch.isfinite(found).all()
    assert valid.any()
    assert missed(arm, found[valid], T).max() < 1e-9


def test_batches(batch_shape):
    arm = ARMS["fitted"]
    q = (torch.rand(*batch_shape, 6, generator=generator(), dtype=torch.float64) - 0.5) * 2
    found, valid = spherical_wrist(arm, arm.forward(q))
    assert found.shape == (*batch_shape, 8, 6)
    assert valid.shape == (*batch_shape, 8)
    for i in np.ndindex(*batch_shape):
        alone, _ = spherical_wrist(arm, arm.forward(q[i]))
        assert_close(found[i], alone, rtol=0, atol=1e-12)


@pytest.mark.parametrize("name", ["PUMA", "1 meets 2", "2 parallel to 3", "all skew"])
def test_a_spherical_shoulder_is_a_wrist_seen_from_the_tool(name):
    wrist = ARMS[name]
    backwards = -(wrist.screws @ spatial.inverse_adjoint(wrist.home).mT).flip(0)
    arm = dx.Chain(backwards, spatial.inverse(wrist.home))
    q = random_configurations(500, seed=2)
    T = arm.forward(q)
    assert_close(T, spatial.inverse(wrist.forward(q.flip(-1))), rtol=0, atol=1e-12)
    found, valid = spherical_shoulder(arm, T)
    assert missed(arm, found, T[:, None])[valid].max() < 1e-8
    assert torch.where(valid, apart(found, q[:, None]), torch.inf).amin(-1).max() < 1e-6
    if name == "all skew":
        assert closed_form(arm) == "spherical shoulder"


# ---- public cases ------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "q", [[0, math.pi / 4, -math.pi, 0, math.pi / 4, 0], [0.3, 0.5, -1.2, 0.4, 0.6, 0.7]]
)
def test_the_tool_is_on_the_right_side(q):
    """rtb-python#491, #640: the tool was taken off on the wrong side, a miss of 0.1414 m."""
    puma = dx.robots.puma560()
    base = spatial.exp([1, -2, 0.5, 0.2, -0.3, 0.4])
    arm = dx.Chain(puma.screws @ spatial.adjoint(base).mT, base @ puma.home @ spatial.translation(0, 0, 0.1))
    T = arm.forward(q)
    found, valid = spherical_wrist(arm, T)
    assert valid.any()
    assert missed(arm, found[valid], T).max() < 1e-9


def test_elbow_up_and_down():
    """rtb-python#171: eight different branches, four shapes of the arm."""
    puma = dx.robots.puma560()
    q = torch.tensor([0.2, math.pi / 4, -math.pi + 0.3, 0.3, math.pi / 4, 0.4], dtype=torch.float64)
    found, valid = spherical_wrist(puma, puma.forward(q))
    assert valid.all()
    assert apart(found, q).min() < 1e-9
    assert len((found * 1e6).round().unique(dim=0)) == 8
    assert len((found[:, :3] * 1e6).round().unique(dim=0)) == 4


@pytest.mark.parametrize("name", ["PUMA", "stated"])
def test_round_angles(name):
    """ur-analytic-ik#5, universal_robot#479, universal-robots-kinematics#3."""
    arm = ARMS[name]
    multiples = torch.randint(-4, 5, (2000, 6), generator=generator()) * (math.pi / 4)
    special = torch.tensor(np.radians([[0, -45, -90, -90, 90, 0], [180.0] * 6]))
    q = torch.cat([special, multiples.double()])
    T = arm.forward(q)
    found, valid = spherical_wrist(arm, T)
    assert valid.any(-1).all()
    assert torch.isfinite(found).all()
    assert missed(arm, found, T[:, None])[valid].max() < 1e-9
    regular = dx.indices.Index("kinematic_conditioning").bind(arm)(q) > 1e-6
    assert torch.where(valid, apart(found, q[:, None]), torch.inf).amin(-1)[regular].max() < 1e-9


def test_a_large_batch_gives_what_its_parts_give():
    """Poses are worked on in pieces, so that memory grows with the answer alone."""
    arm = ARMS["fitted"]
    T = arm.forward(random_configurations(5000, seed=8))
    q, valid = spherical_wrist(arm, T)
    first, last = spherical_wrist(arm, T[:4096]), spherical_wrist(arm, T[4096:])
    assert_close(q, torch.cat([first[0], last[0]]), rtol=0, atol=1e-9)
    assert_close(valid, torch.cat([first[1], last[1]]))


def test_the_chain_must_have_a_spherical_wrist():
    with pytest.raises(ValueError, match="six revolute ones are needed"):
        spherical_wrist(dx.robots.uvms(), torch.eye(4, dtype=torch.float64))
    rng = np.random.default_rng(0)
    points = rng.normal(size=(6, 3))
    loose = dx.Chain(torch.stack([screw(p, d) for p, d in zip(points, rng.normal(size=(6, 3)), strict=True)]),
                     np.eye(4))  # fmt: skip
    with pytest.raises(ValueError, match="no spherical wrist"):
        spherical_wrist(loose, torch.eye(4, dtype=torch.float64))


@pytest.mark.parametrize("flaw", ["one point", "parallel", "wrist on axis"])
def test_the_arm_must_move_the_wrist_in_space(flaw):
    rng = np.random.default_rng(2)
    points, directions, wrist = rng.normal(size=(3, 3)), rng.normal(size=(6, 3)), rng.normal(size=3)
    if flaw == "one point":
        points[:] = points[0]
    elif flaw == "parallel":
        directions[:3] = directions[0]
    else:
        wrist = points[2]
    with pytest.raises(ValueError, match="on a surface only"):
        spherical_wrist(arm_of(points, directions, wrist), torch.eye(4, dtype=torch.float64))


def test_a_pose_must_be_rigid():
    with pytest.raises(ValueError, match="T_base_tool is not a rigid-body pose"):
        spherical_wrist(ARMS["stated"], 2 * torch.eye(4, dtype=torch.float64))
    with pytest.raises(ValueError, match="T_base_tool is not finite"):
        spherical_wrist(ARMS["stated"], torch.full((4, 4), math.nan))


@pytest.mark.parametrize("robot", ["puma560", "docking_arm", "ur5e"])
@pytest.mark.parametrize("size", [1e-6, 1e-3, 0.03, 1e3])
def test_small_and_large_arms_keep_all_branches(rng, robot, size):
    """Tolerances of lengths are in metres: an arm of a millimetre lost six of eight branches."""
    arm = dx.robots.load(robot)
    scale = torch.tensor([size] * 3 + [1.0] * 3, dtype=torch.float64)
    T = arm.forward(rng.uniform(-2, 2, (20, 6)))
    home, scaled = arm.home.clone(), T.clone()
    home[:3, 3] *= size
    scaled[:, :3, 3] *= size
    found = dx.inverse_kinematics.solve(dx.Chain(arm.screws * scale, home), scaled)
    expected = dx.inverse_kinematics.solve(dx.Chain(arm.screws, arm.home), T)
    assert torch.equal(found.valid.sum(-1), expected.valid.sum(-1))
    assert bool(found.reached.all())
    assert found.method == expected.method
    away = (found.chain.forward(found.q) - scaled[:, None])[..., :3, 3].norm(dim=-1)
    assert float(away[found.valid].max()) < 1e-8 * size
