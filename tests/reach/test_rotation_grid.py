"""Grids of rotations: that they are rotations, all different, and leave no rotation far from all."""

import math

import numpy as np
import pytest
import torch
from scipy.spatial.transform import Rotation

from dexterity import reach

COUNTS = {24: 62.80, 60: 44.48, 216: 37.34, 648: 20.84, 1992: 16.19}


@pytest.mark.parametrize("count", COUNTS)
def test_no_rotation_is_further_than_the_covering_radius_that_is_stated(count):
    grid = reach.rotations(count)
    assert len(grid) == count
    measured = math.degrees(reach.covering_radius(grid))
    assert COUNTS[count] - 0.02 < measured <= COUNTS[count]
    # Without the convex hull: random rotations are within, and some come near to the bound.
    grid_quaternions = Rotation.from_matrix(grid.numpy()).as_quat()
    others = Rotation.random(20_000, random_state=0).as_quat()
    nearest = np.abs(others @ grid_quaternions.T).max(axis=1).clip(max=1)
    angles = np.degrees(2 * np.arccos(nearest))
    assert angles.max() <= measured + 1e-6
    assert angles.max() > 0.85 * measured


@pytest.mark.parametrize("count", COUNTS)
def test_they_are_different_rotations(count):
    grid = reach.rotations(count)
    torch.testing.assert_close(grid @ grid.mT, torch.eye(3, dtype=torch.float64).expand(count, 3, 3))
    assert (torch.linalg.det(grid) > 0).all()
    traces = torch.einsum("nij,mij->nm", grid, grid) - 4 * torch.eye(count, dtype=torch.float64)
    smallest_angle = math.acos((float(traces.max()) - 1) / 2)
    assert smallest_angle > math.radians(0.3 * COUNTS[count])


def test_the_finest_grid_is_as_fine_as_is_said():
    assert math.degrees(reach.covering_radius(reach.rotations(7416))) < 9.84


def test_a_radius_chooses_the_smallest_grid():
    assert len(reach.rotations(1)) == 24
    assert len(reach.rotations(25)) == 60
    assert len(reach.rotations(spacing=math.radians(63))) == 24
    assert len(reach.rotations(spacing=math.radians(20))) == 1992
    grid = reach.rotations(24)
    grid.zero_()
    assert reach.rotations(24).abs().max() > 0.9


def test_few_rotations_cover_little():
    eye = torch.eye(3, dtype=torch.float64)[None]
    assert reach.covering_radius(eye) == math.pi
    half_turns = torch.tensor([[1.0, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]).double().diag_embed()
    assert reach.covering_radius(half_turns) == pytest.approx(2 * math.pi / 3)


@pytest.mark.parametrize(
    ("arguments", "error", "message"),
    [
        ({}, TypeError, "count or spacing"),
        ({"count": 10, "spacing": 0.5}, TypeError, "count or spacing"),
        ({"count": 0}, ValueError, "count is 0"),
        ({"count": 10_000}, ValueError, "count is 10000"),
        ({"count": 2.5}, TypeError, "count is 2.5"),
        ({"spacing": 0.1}, ValueError, "the finest grid"),
        ({"spacing": math.nan}, ValueError, "spacing is nan"),
    ],
)
@pytest.mark.usefixtures("annotations_unchecked")
def test_bad_input_is_named(arguments, error, message):
    with pytest.raises(error, match=message):
        reach.rotations(**arguments)
