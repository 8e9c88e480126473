"""Subproblems against their statement."""

import math

import numpy as np
import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st
from torch.testing import assert_close

from dexterity import spatial
from dexterity.inverse_kinematics import subproblem_1, subproblem_2, subproblem_3, subproblem_4

numbers = st.floats(-2, 2)
points = st.tuples(numbers, numbers, numbers)
angles = st.floats(-math.pi, math.pi)


def screw(point, direction) -> torch.Tensor:
    direction = np.asarray(direction) / np.linalg.norm(direction)
    return torch.tensor(np.concatenate([np.cross(point, direction), direction]))


def turned(axis, angle, p) -> torch.Tensor:
    T = spatial.exp(torch.as_tensor(axis) * torch.as_tensor(angle, dtype=torch.float64)[..., None])
    return (T[..., :3, :3] @ torch.as_tensor(p, dtype=torch.float64)[..., None])[..., 0] + T[..., :3, 3]


AXIS = screw([0.3, -0.2, 0.5], [1.0, 2.0, -0.5])
MEETING = screw([0.3, -0.2, 0.5], [-0.3, 0.4, 1.0])


@given(points, angles)
def test_a_point_is_turned_onto_another(p, angle):
    q = turned(AXIS, angle, p)
    assert_close(turned(AXIS, subproblem_1(AXIS, p, q), p), q, rtol=0, atol=1e-12)


def test_a_point_on_the_axis_is_turned_by_nothing():
    on_axis = AXIS[3:] * 0.7 + torch.linalg.cross(AXIS[3:], AXIS[:3])
    assert subproblem_1(AXIS, on_axis, [1.0, 2.0, 3.0]).item() == 0.0
    assert subproblem_1(AXIS, [1.0, 2.0, 3.0], on_axis).item() == 0.0


@given(points, angles, angles)
def test_a_point_is_turned_onto_another_about_two_axes(p, alpha, beta):
    q = turned(AXIS, alpha, turned(MEETING, beta, p))
    for first, second in subproblem_2(AXIS, MEETING, p, q):
        # Where the circles touch, rounding of the last digit moves the angle by its root.
        assert_close(turned(AXIS, first, turned(MEETING, second, p)), q, rtol=0, atol=1e-7)


def test_both_solutions_of_two_axes_are_found():
    p = torch.tensor([1.0, 0.4, -0.3])
    q = turned(AXIS, 0.7, turned(MEETING, -1.1, p))
    found = subproblem_2(AXIS, MEETING, p, q)
    assert torch.hypot(found[:, 0] - 0.7, found[:, 1] + 1.1).min() < 1e-12
    assert (found[0] - found[1]).abs().max() > 0.1


@pytest.mark.parametrize("second", [AXIS, -AXIS, screw([0.0, 0.0, 2.0], [-0.3, 0.4, 1.0])])
def test_two_axes_must_meet(second):
    with pytest.raises(ValueError, match="do not meet, or are parallel"):
        subproblem_2(AXIS, second, [1.0, 0.0, 0.0], [0.0, 1.0, 0.0])


@given(points, points, angles)
def test_a_point_is_brought_to_a_distance(p, q, angle):
    p, q = torch.tensor(p, dtype=torch.float64), torch.tensor(q, dtype=torch.float64)
    distance = (turned(AXIS, angle, p) - q).norm()
    for found in subproblem_3(AXIS, p, q, distance):
        assert_close((turned(AXIS, found, p) - q).square().sum(), distance.square(), rtol=0, atol=1e-12)


@pytest.mark.parametrize(("distance", "nearest"), [(0.0, 0.4), (5.0, 1.6)])
def test_a_distance_out_of_reach_is_missed_by_the_least(distance, nearest):
    z = screw([0.0, 0.0, 0.0], [0.0, 0.0, 1.0])
    found = subproblem_3(z, [0.6, 0.0, 0.0], [0.0, 1.0, 0.0], distance)
    assert_close(found[0], found[1])
    away = (turned(z, found[0], [0.6, 0.0, 0.0]) - torch.tensor([0.0, 1.0, 0.0])).norm()
    assert away.item() == pytest.approx(nearest, abs=1e-12)


def test_a_distance_is_not_negative():
    with pytest.raises(ValueError, match="distance is -1"):
        subproblem_3(AXIS, [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], -1.0)


@given(points, points, angles)
def test_a_point_is_brought_onto_a_plane(p, normal, angle):
    normal = torch.tensor(normal, dtype=torch.float64)
    offset = turned(AXIS, angle, p) @ normal
    for found in subproblem_4(AXIS, p, normal, offset):
        assert_close(turned(AXIS, found, p) @ normal, offset, rtol=0, atol=1e-12)


@pytest.mark.parametrize(
    "axis", [[0.0, 0.0, 1.0, 0.0, 0.0, 0.0], [0, 0, 0, 0, 0, 2.0], [0, 0, 1.0, 0, 0, 1.0]]
)
def test_an_axis_is_a_revolute_screw(axis):
    with pytest.raises(ValueError, match=r"axis is .* a revolute screw"):
        subproblem_1(axis, [1.0, 0.0, 0.0], [0.0, 1.0, 0.0])


def test_points_have_three_coordinates():
    with pytest.raises(ValueError, match=r"p has shape \(2,\)"):
        subproblem_1(AXIS, [1.0, 0.0], [0.0, 1.0, 0.0])
    with pytest.raises(ValueError, match=r"axis has shape \(3,\)"):
        subproblem_1(AXIS[:3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0])


def test_a_screw_right_to_six_digits_is_taken():
    rough = [round(x, 6) for x in AXIS.tolist()]
    p, q = [1.0, 2.0, 3.0], turned(AXIS, 0.7, [1.0, 2.0, 3.0])
    assert abs(subproblem_1(rough, p, q) - 0.7) < 1e-5
