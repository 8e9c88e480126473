"""Arms with three parallel axes: random ones, those of Universal Robots, and another library's solutions."""

import math

import numpy as np
import pytest
import torch
from arms import UR3, UR5, apart, chain_of, random_configurations, screw

import dexterity as dx
from dexterity import spatial
from dexterity.inverse_kinematics import closed_form, geometric_miss, solve, three_parallel_axes


def random_arm(seed: int, parallel: tuple[int, int, int] = (1, 2, 3)) -> dx.Chain:
    """Arm with three parallel axes, the other two beyond them meeting, all else at random."""
    rng = np.random.default_rng(seed)
    points, directions = rng.normal(size=(6, 3)), rng.normal(size=(6, 3))
    for i in parallel[1:]:
        directions[i] = directions[parallel[0]] * rng.choice([-1, 1])
    meeting = (4, 5) if parallel[0] == 1 else (0, 1)
    points[meeting[1]] = points[meeting[0]]
    home = spatial.exp(np.concatenate([rng.normal(size=3), rng.normal(size=3)]))
    return dx.Chain([screw(p, d) for p, d in zip(points, directions, strict=True)], home)


ARMS = {
    "UR5": UR5,
    "UR3": UR3,
    "UR5e": dx.robots.load("ur5e"),
    **{f"random {seed}": random_arm(seed) for seed in range(3)},
    "random, seen from its tool": random_arm(5, (2, 3, 4)),
}
every_arm = pytest.mark.parametrize("arm", ARMS.values(), ids=ARMS)


@every_arm
def test_every_pose_gives_back_its_configuration(arm):
    q = random_configurations(arm, 2000)
    T = arm.forward(q)
    found, valid = three_parallel_axes(arm, T)
    assert found.shape == (2000, 8, 6)
    assert torch.isfinite(found).all()
    assert (arm.forward(found) - T[:, None]).abs().amax((-2, -1))[valid].max() < 1e-8
    nearest = torch.where(valid, apart(found, q[:, None]), torch.inf).amin(-1)
    assert nearest.max() < 1e-6
    assert nearest.median() < 1e-13


@every_arm
def test_it_is_told_by_its_geometry(arm):
    assert closed_form(arm) == "three parallel axes"
    assert geometric_miss(arm) < 1e-12


ROUND = [
    [0, -45, -90, -90, 90, 0],  # ur-analytic-ik#5
    [180, 180, 180, 180, 180, 180],  # universal_robot#479
    [30, -60, 90, 20, 0, 45],  # universal-robots-kinematics#3: joint 6 arbitrary at joint 5 = 0
    [0, 0, 0, 0, 0, 0],
]


@pytest.mark.parametrize("arm", [UR5, UR3], ids=["UR5", "UR3"])
def test_round_angles(arm):
    multiples = torch.randint(-4, 5, (2000, 6), generator=torch.Generator().manual_seed(0)).double()
    q = torch.cat([torch.tensor(np.radians(ROUND)), multiples * math.pi / 4])
    T = arm.forward(q)
    found, valid = three_parallel_axes(arm, T)
    assert torch.isfinite(found).all()
    assert valid.any(-1).all()
    assert (arm.forward(found) - T[:, None]).abs().amax((-2, -1))[valid].max() < 1e-9
    regular = dx.indices.Index("kinematic_conditioning").bind(arm)(q) > 1e-6
    assert regular.sum() > 500
    nearest = torch.where(valid, apart(found, q[:, None]), torch.inf).amin(-1)
    assert nearest[regular].max() < 1e-9


@pytest.mark.parametrize("bend", [0.0, 1e-12, 1e-9, 8.7e-8, 1e-6])
def test_a_wrist_that_is_almost_straight(bend):
    q = random_configurations(UR5, 200)
    q[:, 4] = math.pi + bend
    T = UR5.forward(q)
    _, valid = three_parallel_axes(UR5, T)
    assert valid.any(-1).all()


def test_out_of_reach_is_flagged_and_complete():
    T = UR5.forward(random_configurations(UR5, 50))
    T[:, :3, 3] += torch.tensor([40.0, -30.0, 50.0])
    q, valid = three_parallel_axes(UR5, T)
    assert not valid.any()
    assert torch.isfinite(q).all()
    assert solve(UR5, T).complete


@pytest.mark.parametrize("name", ["ur5_ik", "ur3e_ik", "ur10e_ik"])
def test_the_solutions_are_those_of_ssik(name):
    import importlib

    peer = importlib.import_module(f"ssik.prebuilt.universal_robots.{name}")
    arm = chain_of(peer.fk, 6)
    for q in random_configurations(arm, 15).numpy():
        T = peer.fk(q)
        theirs = peer.solve(T, respect_limits=False, enumerate_windings=False)
        theirs = torch.tensor(np.array([solution.q for solution in theirs]))
        found, valid = three_parallel_axes(arm, T)
        ours = found[valid]
        distances = apart(theirs[:, None], ours)
        assert distances.amin(1).max() < 1e-6
        assert distances.amin(0).max() < 1e-6


@pytest.mark.parametrize("arm", [UR5, random_arm(1), random_arm(5, (2, 3, 4))], ids=["UR5", "random", "tool"])
def test_descriptions_right_to_six_digits(arm):
    rough = (arm.screws * 1e6).round() / 1e6
    rough = rough + torch.tensor(np.random.default_rng(0).uniform(-1e-6, 1e-6, (6, 6)))
    for screw_ in rough:
        screw_[3:] /= screw_[3:].norm()
        screw_[:3] -= (screw_[:3] @ screw_[3:]) * screw_[3:]
    described = dx.Chain(rough, arm.home)
    assert closed_form(described) == "three parallel axes"
    assert 1e-9 < geometric_miss(described) < 1e-5
    q = random_configurations(described, 300)
    found, valid = three_parallel_axes(described, described.forward(q))
    # Right for the chain as it is described, not for the one that meets the conditions.
    assert (described.forward(found) - described.forward(q)[:, None]).abs().amax((-2, -1))[valid].max() < 1e-8
    nearest = torch.where(valid, apart(found, q[:, None]), torch.inf).amin(-1)
    assert (nearest < 1e-6).double().mean() > 0.99


@pytest.mark.parametrize("digits", [6, 16])
def test_configurations_are_differentiable(digits):
    """Against the inverse of the Jacobian, for a description that is exact and one with six digits."""
    screws = (UR5.screws * 10**digits).round() / 10**digits + (1e-7 if digits == 6 else 0) * torch.eye(6)
    arm = dx.Chain(screws / screws[:, 3:].norm(dim=1, keepdim=True), UR5.home)
    q = torch.tensor([0.3, -1.0, 1.2, -0.5, 0.8, 0.2], dtype=torch.float64)
    twist = torch.zeros(6, dtype=torch.float64, requires_grad=True)
    found, valid = three_parallel_axes(arm, arm.forward(q) @ spatial.exp(twist))
    best = apart(found, q).argmin()
    assert valid[best]
    slopes = torch.stack([torch.autograd.grad(x, twist, retain_graph=True)[0] for x in found[best]])
    torch.testing.assert_close(slopes, torch.linalg.inv(arm.body_jacobian(q)), rtol=0, atol=1e-6)


def test_other_arms_are_refused_with_the_reason():
    for arm, message in [
        (dx.robots.puma560(), "no three parallel axes"),
        (dx.robots.load("panda"), "six revolute ones are needed"),
        (loose(), "do not meet|are not"),
    ]:
        with pytest.raises(ValueError, match=message):
            three_parallel_axes(arm, torch.eye(4, dtype=torch.float64))
    assert closed_form(loose()) is None


def loose() -> dx.Chain:
    """Arm with three parallel axes whose axes 5 and 6, and 1 and 2, do not meet."""
    screws = random_arm(0).screws
    screws[5] = torch.tensor(screw(np.array([3.0, -2, 1]), screws[5, 3:].numpy()))
    return dx.Chain(screws, np.eye(4))
