"""Limits with their ends, and the copies of a configuration that differ by full turns."""

import itertools
import math

import numpy as np
import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st
from torch.testing import assert_close

import dexterity as dx
from dexterity.inverse_kinematics import (
    copies_within_limits,
    nearest_copy,
    spherical_wrist,
    within_limits,
)
from dexterity.workspace import reachability

FULL = torch.full((6,), 2 * math.pi, dtype=torch.float64)
PUMA = dx.robots.puma560()
PAPER_C = dx.Chain(
    reachability.arm([0.15, 0.4318, 0.4318, 0.0203]).screws,
    reachability.arm([0.15, 0.4318, 0.4318, 0.0203]).home,
    lower=np.radians([-160, -135, -135, -140, -100, -170]),
    upper=np.radians([160, 135, 135, 140, 100, 170]),
)


def with_limits(chain: dx.Chain, lower, upper) -> dx.Chain:
    return dx.Chain(chain.screws, chain.home, lower=lower, upper=upper)


# ---- ends of limits (moveit#598, predicators#1292, dart#1449) ----------------------------------------


def round_configurations(second) -> torch.Tensor:
    degrees = [(-90, 30, 120), second, (-120, -30, 20), (-60, 45, 90), (100, -100), (0, 45)]
    return torch.tensor(np.radians(list(itertools.product(*degrees))))


def at_limits(arm: dx.Chain, count: int) -> torch.Tensor:
    """Random configurations with one joint or several exactly at a limit."""
    generator = torch.Generator().manual_seed(0)
    lower, upper = arm.lower, arm.upper
    q = lower + (upper - lower) * torch.rand(count, 6, generator=generator, dtype=torch.float64)
    ends = torch.where(torch.rand(count, 6, generator=generator) < 0.5, lower, upper)
    there = torch.rand(count, 6, generator=generator) < 0.3
    there[torch.arange(count), torch.randint(6, (count,), generator=generator)] = True
    return torch.where(there, ends, q)


@pytest.mark.parametrize(
    ("arm", "q"),
    [
        (PUMA, round_configurations((0, 60, 150))),
        (PAPER_C, round_configurations((-100, 60, 120))),
        (PUMA, at_limits(PUMA, 3000)),
        (PAPER_C, at_limits(PAPER_C, 3000)),
    ],
    ids=["PUMA, round", "paper C, round", "PUMA, random", "paper C, random"],
)
def test_a_joint_exactly_at_its_limit_is_within(arm, q):
    branches, valid = spherical_wrist(arm, arm.forward(q))
    moved, within = nearest_copy(arm, branches)
    assert (valid & within).any(-1).all()
    # Away from singular configurations, the configuration itself comes back.
    regular = dx.indices.Index("kinematic_conditioning").bind(arm)(q) > 1e-4
    moved, within = nearest_copy(arm, branches, near=q[:, None])
    same = ((moved - q[:, None]).abs().amax(-1) < 1e-9) & valid & within
    assert same[regular].any(-1).all()
    assert regular.double().mean() > 0.8


def test_the_tolerance_of_limits_can_be_set():
    arm = with_limits(PUMA, -FULL / 6, FULL / 6)
    q = torch.zeros(3, 6, dtype=torch.float64)
    q[:, 2] = math.pi / 3 + torch.tensor([0.0, 5e-10, 1e-6], dtype=torch.float64)
    assert within_limits(arm, q).tolist() == [True, True, False]
    assert within_limits(arm, q, 0.0).tolist() == [True, False, False]
    assert within_limits(arm, q, limit_tolerance=1e-5).all()
    assert nearest_copy(arm, q, limit_tolerance=0.0)[1].tolist() == [True, False, False]
    assert len(copies_within_limits(arm, q[2], limit_tolerance=1e-5)) == 1
    assert len(copies_within_limits(arm, q[1], limit_tolerance=0)) == 0
    for wrong in (-1e-9, math.nan, math.inf):
        with pytest.raises(ValueError, match=r"^limit_tolerance is"):
            within_limits(arm, q, wrong)


# ---- nearest to a seed (ssik#562, ur-analytic-ik#19, tesseract#579) -------------------------------------


def test_the_copy_nearest_to_a_seed():
    arm = with_limits(PUMA, -FULL, FULL)
    solution, seed = (np.radians([0, 30, 40, 50, 60, last]) for last in (-10, 350))
    moved, within = nearest_copy(arm, solution, near=seed)
    assert within
    assert_close(moved, torch.tensor(seed), rtol=0, atol=1e-15)
    assert_close(nearest_copy(arm, solution)[0], torch.tensor(solution), rtol=0, atol=0)


@given(
    st.lists(st.floats(-12, 12), min_size=6, max_size=6), st.lists(st.floats(-9, 9), min_size=6, max_size=6)
)
def test_no_copy_within_the_limits_is_nearer(q, seed):
    arm = with_limits(PUMA, -0.9 * FULL, 1.1 * FULL)
    seed = torch.tensor(seed, dtype=torch.float64)
    moved, within = nearest_copy(arm, q, near=seed)
    assert within
    distances = (copies_within_limits(arm, q) - seed).abs().sum(-1)
    assert_close((moved - seed).abs().sum(-1), distances.min(), rtol=0, atol=1e-8)


def test_seeds_broadcast_and_are_checked():
    moved, _ = nearest_copy(PUMA, torch.zeros(4, 1, 6), near=torch.zeros(3, 6))
    assert moved.shape == (4, 3, 6)
    with pytest.raises(ValueError, match=r"^near has shape \(5,\)"):
        nearest_copy(PUMA, torch.zeros(6), near=torch.zeros(5))
    with pytest.raises(ValueError, match=r"^near has shape \(2, 6\), which does not broadcast"):
        nearest_copy(PUMA, torch.zeros(3, 6), near=torch.zeros(2, 6))


# ---- limits that are not about zero (dart#1449, moveit#571) --------------------------------------------


def one_joint(lower: float, upper: float) -> dx.Chain:
    return dx.Chain([[0, 0, 0, 0, 0, 1.0]], np.eye(4), lower=[lower], upper=[upper])


def test_limits_that_are_not_about_zero():
    moved, within = nearest_copy(one_joint(math.pi / 8, 2 * math.pi), [-math.pi])
    assert within
    assert_close(moved, torch.tensor([math.pi], dtype=torch.float64))
    kr16 = one_joint(*np.radians([-350, 350]))
    assert_close(copies_within_limits(kr16, np.radians([170.0])), torch.tensor(np.radians([[-190.0], [170]])))


# ---- continuous joints (moveit#571, kinova-ros#289, or_urdf#10) ------------------------------------------


def test_one_continuous_joint_keeps_its_value():
    lower, upper = torch.full((6,), -2 * math.pi), torch.full((6,), 2 * math.pi)
    lower[5], upper[5] = -math.inf, math.inf
    q = [0.1, 0.2, 0.3, 0.4, 0.5, 3.0]
    copies = copies_within_limits(with_limits(PUMA, lower, upper), q)
    assert copies.shape == (32, 6)
    assert (copies[:, 5] == 3.0).all()
    assert len(copies.unique(dim=0)) == 32


def test_too_many_copies_are_refused_by_number():
    arm = with_limits(PUMA, torch.full((6,), -1e9), torch.full((6,), 1e9))
    with pytest.raises(ValueError, match=r"^q has \d+ copies within the limits; 1000000 are the most"):
        copies_within_limits(arm, torch.zeros(6))


# ---- full turns ------------------------------------------------------------------------------------


def test_copies_within_limits_are_all_there_are():
    arm = dx.robots.docking_arm()
    q = torch.tensor([0.5, 1.0, -1.0, 2.0, -2.5, 0.1], dtype=torch.float64)
    copies = copies_within_limits(arm, q)
    tau = math.tau
    expected = [[0.5, 1.0, -1.0, a, b, 0.1] for a in (2.0 - tau, 2.0) for b in (-2.5, -2.5 + tau)]
    assert_close(copies, torch.tensor(expected, dtype=torch.float64))
    assert_close(arm.forward(copies), arm.forward(q).expand(4, 4, 4), rtol=0, atol=1e-14)


def test_outside_the_limits_there_is_no_copy():
    arm = dx.robots.docking_arm()
    assert copies_within_limits(arm, [3.0, 0, 0, 0, 0, 0]).shape == (0, 6)
    moved, within = nearest_copy(arm, [[3.0, 0, 0, 0, 0, 0], [math.tau + 0.2, 0, 0, 4.0, 0, 0]])
    assert within.tolist() == [False, True]
    assert_close(moved[1], torch.tensor([0.2, 0, 0, 4.0 - math.tau, 0, 0], dtype=torch.float64))


@given(st.lists(st.floats(-12, 12), min_size=6, max_size=6))
def test_the_nearest_copy_is_within_if_any_is(q):
    arm = dx.robots.docking_arm()
    moved, within = nearest_copy(arm, q)
    copies = copies_within_limits(arm, q)
    assert within.item() == bool(len(copies))
    if len(copies):
        assert (copies - moved).abs().amax(1).min() < 1e-12


def test_limits_on_one_side_and_joints_that_slide():
    screws = [[0, 0, 0, 0, 0, 1.0], [0, 0, 0, 0, 0, 1.0], [0, 0, 1.0, 0, 0, 0]]
    chain = dx.Chain(screws, np.eye(4), lower=[10.0, -math.inf, -8.0], upper=[math.inf, -10.0, 8.0])
    moved, within = nearest_copy(chain, [0.0, 0.0, 7.0])
    assert_close(moved, torch.tensor([2 * math.tau, -2 * math.tau, 7.0], dtype=torch.float64))
    assert within
    with pytest.raises(ValueError, match="no limits at joint 1"):
        copies_within_limits(chain, [0.0, 0.0, 7.0])


def test_one_configuration_at_a_time():
    with pytest.raises(ValueError, match="one configuration"):
        copies_within_limits(dx.robots.docking_arm(), torch.zeros(2, 6))
