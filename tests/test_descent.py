"""The descent to poses: where it arrives, that it keeps limits, and what it says where it does not arrive."""

import math

import pytest
import torch
from torch.testing import assert_close

import dexterity as dx
from dexterity import spatial
from dexterity.descent import TwistRows, descend, length_scale

PANDA, UR5E = dx.robots.panda(), dx.robots.ur5e()
SCARA = dx.Chain.from_dh(
    [{"d": 0.4, "a": 0.3}, {"a": 0.25, "alpha": math.pi}, {"kind": "prismatic"}, {}],
    lower=[-2.5, -2.5, 0.0, -math.pi],
    upper=[2.5, 2.5, 0.3, math.pi],
)


def within(chain: dx.Chain, count: int, seed: int) -> torch.Tensor:
    share = torch.rand(
        count, chain.joints, generator=torch.Generator().manual_seed(seed), dtype=torch.float64
    )
    return chain.lower + (chain.upper - chain.lower) * share


@pytest.mark.parametrize(
    ("chain", "least"), [(PANDA, 0.3), (UR5E, 0.5), (dx.robots.puma560(), 0.4)], ids=["panda", "ur5e", "puma"]
)
def test_from_random_starts_many_arrive_within_the_limits(chain, least):
    T = chain.forward(within(chain, 500, seed=1))
    q, miss = descend(chain, T, within(chain, 500, seed=2))
    arrived = miss < 1e-9
    assert arrived.double().mean() > least
    assert_close(chain.forward(q[arrived]), T[arrived], rtol=0, atol=2e-9)
    assert ((q >= chain.lower) & (q <= chain.upper)).all()


def test_what_is_missing_is_the_distance_at_the_values_returned():
    T = PANDA.forward(within(PANDA, 200, seed=1))
    q, miss = descend(PANDA, T, within(PANDA, 200, seed=3), steps=3)
    twist = spatial.log(spatial.inverse(PANDA.forward(q)) @ T)
    rotation = twist[:, 3:].norm(dim=-1)
    shift = (PANDA.forward(q)[:, :3, 3] - T[:, :3, 3]).norm(dim=-1) / length_scale(PANDA)
    assert_close(miss, torch.hypot(rotation, shift), rtol=1e-6, atol=1e-9)
    assert (miss > 1e-3).any()


def test_half_a_turn_away_is_no_dead_end():
    T = PANDA.forward(PANDA.lower.lerp(PANDA.upper, 0.5)[None])
    for axis in torch.eye(3, dtype=torch.float64):
        turned = T @ spatial.exp(torch.cat([torch.zeros(3), math.pi * axis]))
        _, miss = descend(PANDA, turned.expand(64, 4, 4), within(PANDA, 64, seed=4))
        assert (miss < 1e-9).any()


def test_out_of_reach_is_never_said_to_be_reached():
    T = torch.eye(4, dtype=torch.float64).repeat(50, 1, 1)
    T[:, 0, 3] = 3.0
    _, miss = descend(UR5E, T, within(UR5E, 50, seed=5))
    assert (miss > 1.0).all()


def test_rows_below_six_joints():
    wanted = SCARA.forward(within(SCARA, 100, seed=1))
    tilted = wanted @ spatial.exp([0, 0, 0, 0.1, 0, 0])
    q, miss = descend(SCARA, tilted, within(SCARA, 100, seed=2), rows=(0, 1, 2))
    arrived = miss < 1e-9
    assert arrived.double().mean() > 0.3
    assert_close(SCARA.forward(q[arrived])[:, :3, 3], tilted[arrived][:, :3, 3], rtol=0, atol=1e-9)
    assert (descend(SCARA, tilted, within(SCARA, 100, seed=2))[1] > 0.05).all()


def test_the_turn_about_the_tool_may_be_left_free():
    wanted = UR5E.forward(within(UR5E, 100, seed=1)) @ spatial.exp([0, 0, 0, 0, 0, 1.0])
    q, miss = descend(UR5E, wanted, within(UR5E, 100, seed=2), rows=range(5))
    arrived = miss < 1e-9
    assert arrived.double().mean() > 0.3
    assert_close(UR5E.forward(q[arrived])[:, :3, 2], wanted[arrived][:, :3, 2], rtol=0, atol=1e-8)


@pytest.mark.parametrize("frame", ["body", "geometric"])
@pytest.mark.parametrize("rows", [(0,), (3, 5), (0, 1, 5), (0, 1, 2, 3, 4), (2, 4, 5)])
def test_rows_have_the_jacobian_of_finite_differences(rows, frame):
    counted, step = TwistRows(rows, frame), 1e-6
    q, wanted = within(PANDA, 20, seed=1), PANDA.forward(within(PANDA, 20, seed=2))
    J = counted.jacobian(PANDA, q, counted.remaining(PANDA.forward(q), wanted))
    for joint in range(7):
        ahead, behind = q.clone(), q.clone()
        ahead[:, joint] += step
        behind[:, joint] -= step
        change = counted.remaining(PANDA.forward(ahead), wanted) - counted.remaining(
            PANDA.forward(behind), wanted
        )
        far = counted.remaining(PANDA.forward(q), wanted)[:, 3:].norm(dim=-1) < 3.0  # no jump at half a turn
        measured = -change[:, rows] / (2 * step)
        exact = J[..., joint]
        if set(rows) >= {0, 1, 2}:  # a block that counts in full has the Jacobian without the rotation
            measured, exact = measured[:, 3:], exact[:, 3:]
        assert_close(exact[far], measured[far], rtol=1e-4, atol=1e-6)


def test_limits_that_are_approached_are_met_from_both_sides():
    q = within(PANDA, 100, seed=1)
    outside = q + 0.5 * torch.randn(100, 7, generator=torch.Generator().manual_seed(0), dtype=torch.float64)
    ends, miss = descend(PANDA, PANDA.forward(q), outside, limits="approached")
    arrived = miss < 1e-9
    assert arrived.double().mean() > 0.7
    assert ((ends >= PANDA.lower - 1e-9) & (ends <= PANDA.upper + 1e-9))[arrived].all()
    assert_close(PANDA.forward(ends[arrived]), PANDA.forward(q[arrived]), rtol=0, atol=1e-8)


def test_bad_input_is_named():
    T = torch.eye(4, dtype=torch.float64)[None]
    with pytest.raises(ValueError, match="start has shape"):
        descend(UR5E, T, torch.zeros(2, 6, dtype=torch.float64))
    with pytest.raises(ValueError, match="chain has 6"):
        descend(UR5E, T, torch.zeros(1, 7, dtype=torch.float64))
    with pytest.raises(ValueError, match="T_world_tool"):
        descend(UR5E, 2 * T, torch.zeros(1, 6, dtype=torch.float64))
