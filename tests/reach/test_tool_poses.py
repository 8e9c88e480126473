"""Poses that tasks want of a tool."""

import math

import pytest
import torch
from scipy.spatial.transform import Rotation
from torch.testing import assert_close

from dexterity import reach, spatial

DOWN = reach.pointing([0, 0, -1])


def row(*numbers: float) -> torch.Tensor:
    return torch.tensor(numbers, dtype=torch.float64)


@pytest.mark.parametrize("direction", [[0, 0, -1], [0, 0, 1], [1, 2, 3], [-5, 0, 0], [0, 1e-3, 0]])
def test_a_tool_points_along_a_direction_and_its_x_axis_down(direction):
    R = reach.pointing(direction)
    wanted = row(*direction) / row(*direction).norm()
    assert_close(R[:, 2], wanted)
    assert_close(R @ R.T, torch.eye(3, dtype=torch.float64))
    assert torch.linalg.det(R) > 0
    assert R[2, 0] <= 1e-12
    rolled = reach.pointing(direction, roll=0.3)
    turn = Rotation.from_matrix((R.T @ rolled).numpy()).as_rotvec()
    assert turn.tolist() == pytest.approx([0, 0, 0.3])


def test_a_seam_is_straight_and_even():
    T = reach.seam([-0.25, 0, 0.1], [0.25, 0.5, 0.1], 6, DOWN)
    assert_close(T[0, :3, 3], row(-0.25, 0, 0.1))
    assert_close(T[-1, :3, 3], row(0.25, 0.5, 0.1))
    steps = T[1:, :3, 3] - T[:-1, :3, 3]
    assert_close(steps, steps[:1].expand(5, 3))
    assert_close(T[:, :3, :3], DOWN.expand(6, 3, 3))
    spatial.require_rigid(T, "T")


def test_a_panel_is_before_the_tool_which_looks_into_it():
    T = reach.panel([1.2, 0, 0.8], [-1, 0, 0], 0.6, 0.4, columns=3, rows=2, standoff=0.05)
    spatial.require_rigid(T, "T")
    assert_close(T[:, :3, 2], row(1, 0, 0).expand(6, 3))
    assert_close(T[:, :3, 0], row(0, 0, -1).expand(6, 3))
    assert_close(T[:, 0, 3], torch.full((6,), 1.15, dtype=torch.float64))
    assert_close(T[:, 2, 3], row(0.6, 0.6, 0.6, 1.0, 1.0, 1.0))
    # Seen from the front, against x, the columns run from left to right: from +y to −y.
    assert_close(T[:3, 1, 3], row(0.3, 0, -0.3))
    assert reach.panel([1, 0, 0], [-1, 0, 0], 0, 0, columns=1, rows=1).shape == (1, 4, 4)


def test_planar_bases_are_upright():
    T = reach.planar_bases([0, 1], [0, 1, 2], [0, math.pi / 2], height=0.3)
    assert T.shape == (12, 4, 4)
    assert_close(T[:, :3, 2], row(0, 0, 1).expand(12, 3))
    assert_close(T[7, :3, :3], torch.from_numpy(Rotation.from_rotvec([0, 0, math.pi / 2]).as_matrix()))
    assert_close(T[7, :3, 3], row(1, 0, 0.3))


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: reach.pointing([0, 0, 0]), "direction is zero"),
        (lambda: reach.pointing([0, 0, 1], roll=math.nan), "roll is nan"),
        (lambda: reach.seam([0, 0, 0], [1, 0, 0], 1, DOWN), "count is 1"),
        (lambda: reach.seam([0, 0, 0], [1, 0], 3, DOWN), "end has shape"),
        (lambda: reach.seam([0, 0, 0], [1, 0, 0], 3, torch.eye(4)), "tool_rotation has shape"),
        (lambda: reach.seam([0, 0, 0], [1, 0, 0], 3, 2 * DOWN), "tool_rotation"),
        (lambda: reach.panel([0, 0, 0], [0, 0, 1], 1, 1, columns=2, rows=2), "up is along the normal"),
        (lambda: reach.panel([0, 0, 0], [1, 0, 0], -1, 1, columns=2, rows=2), "width is -1"),
        (lambda: reach.panel([0, 0, 0], [1, 0, 0], 1, 1, columns=0, rows=2), "columns is 0"),
        (lambda: reach.planar_bases([], [0], [0]), "x has shape"),
    ],
)
def test_bad_input_is_named(call, message):
    with pytest.raises(ValueError, match=message):
        call()
