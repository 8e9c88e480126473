"""The family of arms against chains, all branches, finite differences and a brute search."""

import itertools
import math

import numpy as np
import pytest
import roboticstoolbox
import torch
from hypothesis import given
from hypothesis import strategies as st
from torch.testing import assert_close

import dexterity as dx
from dexterity import inverse_kinematics, spatial
from dexterity.workspace import dataset, reachability
from dexterity.workspace.reachability import Branch

PUMA = (0.15, 0.4318, 0.4318, 0.0203)
BRANCHES = [Branch(*signs) for signs in itertools.product([True, False], repeat=3)]


def drawn(count: int, seed: int = 0) -> tuple[torch.Tensor, torch.Tensor]:
    """Manipulators, and poses whether in reach or not."""
    samples = dataset.confidence_data(count, seed).samples
    return samples.links, spatial.pose(samples.rotation(), samples.position)


def test_the_puma_is_one_of_the_family():
    arm, puma = reachability.arm(PUMA), dx.robots.puma560()
    q = torch.tensor([0.1, 0.7, -0.4, 0.3, 0.9, -0.2])
    assert_close(arm.forward(q), puma.forward(q), atol=1e-15, rtol=0)


def test_a_batch_is_what_its_chains_are():
    links, _ = drawn(20)
    q = torch.rand(20, 6, generator=torch.Generator().manual_seed(1), dtype=torch.float64) * 6 - 3
    T, Jg, Jb = (
        f(links, q)
        for f in (reachability.forward, reachability.geometric_jacobian, reachability.body_jacobian)
    )
    for i in range(20):
        chain = reachability.arm(links[i])
        assert_close(T[i], chain.forward(q[i]), atol=1e-14, rtol=0)
        assert_close(Jg[i], chain.geometric_jacobian(q[i]), atol=1e-14, rtol=0)
        assert_close(Jb[i], chain.body_jacobian(q[i]), atol=1e-14, rtol=0)


@pytest.mark.parametrize("branch", BRANCHES)
def test_angles_lead_back_to_the_pose(branch):
    links, T = drawn(20_000)
    q, reach = reachability.inverse(links, T, branch)
    assert 0.5 < reach.double().mean() < 0.7
    misses = (reachability.forward(links, q) - T).abs().amax((-1, -2))
    assert misses[reach].max() < 1e-12
    assert misses[~reach].min() > 1e-6
    assert (q.abs() <= math.pi).all()


def test_the_eight_branches_are_those_of_the_subproblems():
    links, T = drawn(60)
    _, reach = reachability.inverse(links, T)
    for i in reach.nonzero()[:, 0].tolist()[:12]:
        every, valid = inverse_kinematics.spherical_wrist(reachability.arm(links[i]), T[i])
        assert valid.all()
        own = torch.stack([reachability.inverse(links[i], T[i], branch)[0] for branch in BRANCHES])
        apart = spatial.wrap_to_pi(own[:, None] - every[None]).abs().amax(-1)
        # Each is one of the others, and no two are the same.
        assert (apart < 1e-9).sum(0).tolist() == [1] * 8
        assert (apart < 1e-9).sum(1).tolist() == [1] * 8


def test_branches_are_named_as_in_the_robotics_toolbox():
    puma = roboticstoolbox.models.DH.Puma560()
    links = (puma.links[2].d, puma.links[3].d, puma.links[1].a, puma.links[2].a)
    pedestal = spatial.pose(torch.eye(3), [0, 0, puma.links[0].d])
    T = reachability.forward(links, [0.3, 0.9, -1.2, 0.4, 0.7, -0.5])
    for branch in BRANCHES:
        config = "rl"[branch.left] + "du"[branch.up] + "nf"[branch.flip]
        theirs = puma.ikine_a((pedestal @ T).numpy(), config=config)
        ours, _ = reachability.inverse(links, T, branch)
        assert theirs.success
        apart = spatial.wrap_to_pi(torch.as_tensor(theirs.q) - ours)
        assert_close(apart, torch.zeros(6).double(), atol=1e-12, rtol=0)


@given(
    st.lists(st.floats(0, 0.5), min_size=4, max_size=4),
    st.lists(st.floats(-0.4, 0.4), min_size=3, max_size=3),
)
def test_what_is_in_reach_is_where_the_arm_gets(links, position):
    T = torch.eye(4, dtype=torch.float64)
    T[:3, 3] = torch.tensor(position)
    q, reach = reachability.inverse(links, T)
    miss = (reachability.forward(links, q) - T).abs().max()
    # At the border itself rounding decides.
    assert miss < 1e-7 if reach else miss > 0


def test_what_is_out_of_reach_is_what_a_search_does_not_find():
    links, T = drawn(40, seed=3)
    reach = reachability.reachable(links, T[:, :3, 3])
    side = torch.linspace(-math.pi, math.pi, 121, dtype=torch.float64)
    grid = torch.cartesian_prod(side, side)
    q = torch.cat([torch.zeros(len(grid), 1), grid, torch.zeros(len(grid), 3)], 1)
    for i in range(40):
        # The first joint turns what the next two reach about z, so the distance from the axis and z are left.
        p = reachability.forward(links[i], q)[:, :3, 3]
        wanted = torch.stack([T[i, :2, 3].norm(), T[i, 2, 3]])
        nearest = (torch.stack([p[:, :2].norm(dim=1), p[:, 2]], 1) - wanted).norm(dim=1).min()
        assert nearest < 0.03 if reach[i] else nearest > 0


def test_jacobians_are_slopes():
    links, _ = drawn(50)
    q = torch.rand(50, 6, generator=torch.Generator().manual_seed(2), dtype=torch.float64) * 6 - 3
    J = reachability.geometric_jacobian(links, q)
    T = reachability.forward(links, q)
    for joint, step in itertools.product(range(6), [1e-6]):
        shift = step * torch.eye(6, dtype=torch.float64)[joint]
        ahead, behind = (reachability.forward(links, q + sign * shift) for sign in (1, -1))
        slope = (ahead - behind) / (2 * step)
        assert_close(J[:, :3, joint], slope[:, :3, 3], atol=1e-9, rtol=0)
        turning = spatial.vee(slope[:, :3, :3] @ T[:, :3, :3].mT)
        assert_close(J[:, 3:, joint], turning, atol=1e-9, rtol=0)


def test_entries_that_vary():
    data = dataset.jacobian_data(2_000, 0, dynamics=False)
    for frame, varying in (("world", 21), ("tool", 23)):
        assert int((data.in_frame(frame).std(0) > 1e-9).sum()) == varying


def test_shapes_are_broadcast():
    links, T = drawn(4)
    q, reach = reachability.inverse(links[:, None], T[None])
    assert q.shape == (4, 4, 6)
    assert reach.shape == (4, 4)
    assert reachability.body_jacobian(PUMA, q).shape == (4, 4, 6, 6)


@pytest.mark.parametrize(
    ("links", "position", "message"),
    [
        ([0.1, 0.2, 0.3], [0, 0, 0], r"links has shape \(3,\)"),
        ([0.1, 0.2, 0.3, -0.1], [0, 0, 0], "links holds -0.1; lengths are at least 0"),
        ([0.1, 0.2, 0.3, math.nan], [0, 0, 0], "links is not finite"),
        ([0.1, 0.2, 0.3, 0.1], [0, 0], r"position has shape \(2,\)"),
    ],
)
def test_bad_input_is_named(links, position, message):
    with pytest.raises(ValueError, match=message):
        reachability.reachable(links, position)


def test_a_pose_must_be_rigid_and_an_arm_one_arm():
    with pytest.raises(ValueError, match="T_base_tool"):
        reachability.inverse(PUMA, np.diag([2.0, 1, 1, 1]))
    with pytest.raises(ValueError, match="one manipulator"):
        reachability.arm([PUMA, PUMA])
