"""Inverse reach maps, and maps compared."""

import math

import pytest
import torch
from torch.testing import assert_close

import dexterity as dx
from dexterity import reach, spatial

PUMA = dx.robots.puma560()
GRID = reach.box([-0.6, -0.6, -0.4], [0.6, 0.6, 0.4], spacing=0.4)
MAP = reach.survey(PUMA, GRID, reach.rotations(24), index="w")
INVERSE = MAP.inverted()
WANTED = spatial.pose(reach.pointing([0, 0, -1]), [1.0, 2.0, 0.3])


def test_from_each_base_the_tool_is_reached_as_the_map_says():
    bases, values = INVERSE.bases(WANTED)
    assert len(bases) == int(MAP.reached.sum()) > 100
    again = reach.place(PUMA, WANTED[None], bases[:40], "w", refine=False)
    assert_close(again.values[:, 0], values[:40], rtol=1e-6, atol=1e-9)


def test_upright_bases_are_upright():
    bases, values = INVERSE.bases(WANTED, largest_tilt=0.2)
    everything, _ = INVERSE.bases(WANTED)
    assert 0 < len(bases) == len(values) < len(everything)
    assert (bases[:, 2, 2] >= math.cos(0.2) - 1e-9).all()
    assert len(INVERSE.bases(WANTED, largest_tilt=math.pi)[0]) == len(everything)


def test_looking_up_bases_is_near_to_inverse_kinematics():
    poses = reach.seam([0.9, 2.0, 0.2], [1.1, 2.0, 0.2], 2, reach.pointing([0, 0, -1]))
    bases = reach.planar_bases([0.5, 1.0, 1.5], [1.3, 1.6, 1.9], [0, math.pi / 2])
    estimate = INVERSE.estimate(poses, bases, 0.35, 1.1)
    exact = reach.place(PUMA, poses, bases, "w", refine=False).values
    assert estimate.shape == exact.shape == (18, 2)
    agree = estimate.isnan() == exact.isnan()
    assert agree.double().mean() > 0.6
    assert INVERSE.estimate(poses, bases, 0.0, 0.0).isnan().all()


def test_a_map_compared():
    same = MAP.compared(MAP)
    assert same["reached here only"] == same["reached there only"] == 0
    assert same["median ratio of the index, there to here"] == 1
    narrow = PUMA.with_limits(lower=PUMA.lower / 2, upper=PUMA.upper / 2)
    other = MAP.compared(reach.survey(narrow, GRID, reach.rotations(24), index="w"))
    assert other["reached there only"] == 0 < other["reached here only"]
    assert sum(list(other.values())[:4]) == MAP.reached.numel()
    with pytest.raises(ValueError, match="same positions"):
        MAP.compared(MAP.where([1]))


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: INVERSE.bases(WANTED[None]), "T_world_tool has shape"),
        (lambda: INVERSE.bases(2 * WANTED), "T_world_tool"),
        (lambda: INVERSE.bases(WANTED, -0.1), "largest_tilt is -0.1"),
        (lambda: INVERSE.estimate(WANTED, WANTED[None], 0.1, 0.1), "T_world_tool has shape"),
        (lambda: INVERSE.estimate(WANTED[None], WANTED[None], -1.0, 0.1), "largest_distance is -1"),
        (lambda: reach.ball([0, 0, 0], 1e300, 0.1), "spacing is 0.1"),
        (lambda: reach.box([0, 0, 0], [1e300, 1, 1], 0.1), "spacing is 0.1"),
    ],
)
def test_bad_input_is_named(call, message):
    with pytest.raises(ValueError, match=message):
        call()


def test_directions_of_any_length_are_directions():
    assert_close(reach.pointing([0, 0, -1e300]), reach.pointing([0, 0, -1]))
    assert_close(reach.pointing([0, 0, -1e-300]), reach.pointing([0, 0, -1]))
    assert torch.isfinite(reach.panel([0, 0, 0], [1e300, 0, 0], 1, 1, columns=2, rows=2)).all()
