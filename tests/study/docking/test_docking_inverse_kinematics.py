"""Branches of an arm, against the library's own answers, and where two of them meet."""

import pytest
import torch
from torch.testing import assert_close

from dexterity import robots, spatial
from dexterity.inverse_kinematics import spherical_wrist
from dexterity_study.docking.inverse_kinematics import experiment, show


def test_three_subproblems_are_enough_for_the_stated_arm():
    arm = robots.docking_arm()
    q = (2 * torch.rand(200, 6, generator=torch.Generator().manual_seed(5), dtype=torch.float64) - 1) * 3
    T = arm.forward(q)
    branches = experiment.by_three_subproblems(arm, T)
    assert branches.shape == (200, 8, 6)
    assert_close(arm.forward(branches), T[:, None].expand(200, 8, 4, 4), rtol=0, atol=1e-7)
    # Eight of them, and not one several times.
    apart = spatial.wrap_to_pi(branches[:, :, None] - branches[:, None]).abs()
    distance = apart.amax(-1) + 10 * torch.eye(8)
    assert distance.amin((1, 2)).median() > 0.1


@pytest.mark.parametrize("name", ["stated", "PUMA 560"])
def test_branches_of_one_wrist_come_first(name):
    arm = experiment.arms()[name]
    branches = show.configurations(arm, arm.forward([0.4, -0.5, 0.6, 0.7, 0.8, -0.4]))
    assert_close(branches[:4, :3], branches[4:, :3], rtol=0, atol=1e-9)
    assert (branches[:4, 3:] - branches[4:, 3:]).abs().amax(1).min() > 0.1


def test_the_two_elbows_meet_at_the_border():
    arm = robots.docking_arm()
    short, elbows = experiment.stretching(arm, steps=50)
    assert elbows.shape == (50, 2, 6)
    positions = arm.forward(elbows)[..., :3, 3]
    shoulder = torch.tensor([0.0, 0.0, 0.1], dtype=torch.float64)
    assert_close((positions - shoulder).norm(dim=-1), (0.8 - short)[:, None].expand(50, 2), rtol=0, atol=1e-9)
    assert (torch.sign(elbows[:-1, 0, 2]) != torch.sign(elbows[:-1, 1, 2])).all()
    assert_close(elbows[-1, 0], elbows[-1, 1], rtol=0, atol=1e-6)


def test_the_skew_arm_has_axes_that_neither_meet_nor_are_parallel():
    arm = experiment.arms()["all axes skew"]
    v, omega = arm.screws[:3, :3], arm.screws[:3, 3:]
    for i, j in ((0, 1), (1, 2)):
        assert torch.linalg.cross(omega[i], omega[j]).norm() > 0.1
        # Two lines meet if and only if their reciprocal product is zero.
        assert abs(float(v[i] @ omega[j] + v[j] @ omega[i])) > 1e-3
    q, valid = spherical_wrist(arm, arm.forward(torch.full((6,), 0.3, dtype=torch.float64)))
    assert valid.any()
    assert torch.isfinite(q).all()


def test_shares_of_branches_sum_to_one_and_limits_only_take_some_away():
    for row in experiment.round_trips(poses=200).where().to_dict("records"):
        shares = [row[f"branches_{n}"] for n in range(9)]
        assert sum(shares) == pytest.approx(1)
        assert row["branches_0"] == 0
        if row["arm"] != "all axes skew":
            within = [row[f"within_{n}"] for n in range(9)]
            assert sum(within) == pytest.approx(1)
            assert sum(n * share for n, share in enumerate(within)) < 8


def test_branches_that_look_the_same_share_a_name():
    arm, puma = robots.docking_arm(), robots.puma560()
    same = show.four_ways("Four ways", arm, arm.forward([0.4, 0.9, -1.3, 0, 1.97, -0.4]))._repr_html_()
    assert "branch 0 and branch 3" in same
    assert "branch 1 and branch 2" in same
    apart = show.four_ways("Four ways", puma, puma.forward([0.5, -0.6, 0.3, 0.7, 0.8, -0.4]))._repr_html_()
    assert all(f">branch {i}<" in apart for i in range(4))
