"""The descent to poses: where it arrives, that it keeps limits, and what it says where it does not arrive."""

import math

import pytest
import torch
from torch.testing import assert_close

import dexterity as dx
from dexterity import spatial
from dexterity.descent import descend, length_scale

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


def test_bad_input_is_named():
    T = torch.eye(4, dtype=torch.float64)[None]
    with pytest.raises(ValueError, match="start has shape"):
        descend(UR5E, T, torch.zeros(2, 6, dtype=torch.float64))
    with pytest.raises(ValueError, match="chain has 6"):
        descend(UR5E, T, torch.zeros(1, 7, dtype=torch.float64))
    with pytest.raises(ValueError, match="T_world_tool"):
        descend(UR5E, 2 * T, torch.zeros(1, 6, dtype=torch.float64))
