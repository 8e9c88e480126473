"""Positions of reach maps: boxes, balls, and the ball that a tool cannot leave."""

import math

import pytest
import torch
from torch.testing import assert_close

import dexterity as dx
from dexterity import reach


def test_a_box_has_its_corners_and_no_gaps():
    points = reach.box([0, -1, 0.5], [1, 1, 0.5], spacing=0.3)
    assert points.shape == (5 * 8, 3)
    assert_close(points.amin(0), torch.tensor([0, -1, 0.5], dtype=torch.float64))
    assert_close(points.amax(0), torch.tensor([1, 1, 0.5], dtype=torch.float64))
    assert reach.box([0, 0, 0], [0, 0, 0], spacing=1.0).tolist() == [[0, 0, 0]]
    assert reach.box([0, 0, 0], [0.3, 0, 0], spacing=0.1).shape == (4, 3)


def test_a_ball_is_symmetric_about_its_centre():
    points = reach.ball([1.0, 2.0, 3.0], 0.5, spacing=0.1) - torch.tensor([1.0, 2.0, 3.0])
    assert (points.norm(dim=-1) <= 0.5 + 1e-9).all()
    assert len(points) == 515  # lattice points within radius 5: OEIS A000605
    assert_close(points.sum(0), torch.zeros(3, dtype=torch.float64), rtol=0, atol=1e-9)


@pytest.mark.parametrize("name", ["puma560", "ur5e", "panda", "docking_arm"])
def test_no_tool_leaves_its_ball_and_some_come_near_its_surface(name):
    chain = getattr(dx.robots, name)()
    centre, radius = reach.bounds(chain)
    share = torch.rand(20_000, chain.joints, generator=torch.Generator().manual_seed(0), dtype=torch.float64)
    tool = chain.forward(math.pi * (2 * share - 1))[:, :3, 3]
    distance = (tool - centre).norm(dim=-1)
    assert distance.max() <= radius + 1e-9
    assert distance.max() > 0.7 * radius


def test_prismatic_joints_count_with_their_travel():
    rows = [{"d": 0.2, "a": 0.3}, {"kind": "prismatic", "d": 0.1}]
    chain = dx.Chain.from_dh(rows, lower=[-3, -0.5], upper=[3, 0.2])
    centre, radius = reach.bounds(chain)
    q = torch.tensor([[0.0, -0.5], [1.0, 0.2]], dtype=torch.float64)
    assert ((chain.forward(q)[:, :3, 3] - centre).norm(dim=-1) <= radius).all()
    with pytest.raises(ValueError, match="joint 2 without limits"):
        reach.bounds(dx.Chain.from_dh(rows))


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: reach.box([0, 0, 0], [1, 1], 0.1), "upper has shape"),
        (lambda: reach.box([0, 0, 2], [1, 1, 1], 0.1), "exceeds upper"),
        (lambda: reach.box([0, 0, 0], [1, 1, 1], 0.0), "spacing is 0"),
        (lambda: reach.box([0, 0, 0], [1, 1, 1], 1e-4), "spacing is 0.0001"),
        (lambda: reach.ball([0, 0, 0], math.inf, 0.1), "radius is inf"),
        (lambda: reach.ball([0, 0, math.nan], 1.0, 0.1), "centre"),
        (lambda: reach.ball([0, 0, 0], 1.0, 1e-4), "spacing is 0.0001"),
    ],
)
def test_bad_input_is_named(call, message):
    with pytest.raises(ValueError, match=message):
        call()
