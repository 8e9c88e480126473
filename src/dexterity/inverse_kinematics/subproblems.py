"""Angles that turn points about one or two axes to where they are wanted: Paden–Kahan subproblems.

Axes are screws [v; ω] with ‖ω‖ = 1, as those of a chain. The closed forms of this package are made of them.

Examples
--------
>>> import math
>>> from dexterity.inverse_kinematics import subproblem_1, subproblem_3
>>> z = [0, 0, 0, 0, 0, 1.0]
>>> round(float(subproblem_1(z, [1, 0, 0], [0, 2, 0])), 6) == round(math.pi / 2, 6)
True
>>> [round(abs(x), 6) for x in subproblem_3(z, [1, 0, 0], [0, 1, 0], 2**0.5).tolist()]
[0.0, 3.141593]
"""

from __future__ import annotations

from dataclasses import dataclass

import torch
from jaxtyping import Float64
from torch import Tensor

from dexterity import spatial
from dexterity.spatial import TensorLike
from dexterity.spatial.tolerances import ROUNDING, SIX_DIGITS
from dexterity.spatial.values import on_one_device, require_values

__all__ = ["Line", "Turning", "subproblem_1", "subproblem_2", "subproblem_3", "subproblem_4"]

_ON_AXIS = 1e-12  # relative distance of a point from an axis below which every angle is as good


def subproblem_1(axis: TensorLike, p: TensorLike, q: TensorLike) -> Float64[Tensor, "*batch"]:
    """Angle [rad] that turns a point onto another, or as near to it as it gets.

    Parameters
    ----------
    axis
        (6,) screw [v; ω] to turn about.
    p, q
        (..., 3) points [m], from and to. Where one is on the axis every angle is as good, and 0 is taken.

    Raises
    ------
    ValueError
        If a shape does not fit, something is not finite, or the axis is no revolute screw.

    References
    ----------
    Murray, Li & Sastry (1994), section 3.3.2, Subproblem 1.
    """
    line = Line.of(axis, "axis")
    _, p, q = on_one_device(axis=line.point, p=points_of(p, "p"), q=points_of(q, "q"))
    return line.on(p.device).angle(p, q)


def subproblem_2(
    first: TensorLike, second: TensorLike, p: TensorLike, q: TensorLike
) -> Float64[Tensor, "*batch 2 2"]:
    """Angles that turn a point onto another about two axes that meet, the second axis first.

    Parameters
    ----------
    first, second
        (6,) screws [v; ω] whose axes meet at an angle.
    p, q
        (..., 3) points [m], from and to.

    Returns
    -------
    Two pairs of angles [rad] about the first and the second axis. They are the same where the circles
    touch, and come as near as they can where these do not meet.

    Raises
    ------
    ValueError
        If a shape does not fit, something is not finite, an axis is no revolute screw, or the axes are
        parallel or do not meet.

    References
    ----------
    Murray, Li & Sastry (1994), section 3.3.2, Subproblem 2.
    """
    one, two = Line.of(first, "first"), Line.of(second, "second")
    if one.meeting(two) is None:
        raise ValueError("first and second are axes that do not meet, or are parallel")
    _, p, q = on_one_device(first=one.point, p=points_of(p, "p"), q=points_of(q, "q"))
    return about_two(one.on(p.device), two.on(p.device), p, q)


def subproblem_3(
    axis: TensorLike, p: TensorLike, q: TensorLike, distance: TensorLike
) -> Float64[Tensor, "*batch 2"]:
    """Angles [rad] that bring a point to a distance from another.

    Parameters
    ----------
    axis
        (6,) screw [v; ω] to turn about.
    p, q
        (..., 3) points [m], the one that is turned and the other.
    distance
        (...) wanted distance [m], not negative.

    Returns
    -------
    Two angles; the same where there is one, and the nearest miss where there is none.

    Raises
    ------
    ValueError
        If a shape does not fit, something is not finite, a distance is negative, or the axis is no revolute
        screw.

    References
    ----------
    Murray, Li & Sastry (1994), section 3.3.2, Subproblem 3.
    """
    wanted = spatial.to_float64(distance, "distance")
    if spatial.are_readable(wanted) and (wanted < 0).any():
        raise ValueError(f"distance is {wanted.min().item()} at least; 0 or a positive number is needed")
    line = Line.of(axis, "axis")
    _, p, q, wanted = on_one_device(
        axis=line.point, p=points_of(p, "p"), q=points_of(q, "q"), distance=wanted
    )
    return solved(line.on(p.device).distance_squared(p, q), wanted.square())


def subproblem_4(
    axis: TensorLike, p: TensorLike, normal: TensorLike, offset: TensorLike
) -> Float64[Tensor, "*batch 2"]:
    """Angles [rad] that bring a point onto a plane, which subproblem 3 becomes as its distance grows.

    Parameters
    ----------
    axis
        (6,) screw [v; ω] to turn about.
    p
        (..., 3) point [m] that is turned.
    normal, offset
        (3,) normal n and (...) offset d [m] of the plane n · x = d.

    Returns
    -------
    Two angles; the same where there is one, and the nearest miss where there is none.

    Raises
    ------
    ValueError
        If a shape does not fit, something is not finite, or the axis is no revolute screw.
    """
    normal = points_of(normal, "normal")
    if normal.ndim != 1:
        raise ValueError(f"normal has shape {tuple(normal.shape)}; (3,) is needed")
    line = Line.of(axis, "axis")
    _, p, normal, height = on_one_device(
        axis=line.point, p=points_of(p, "p"), normal=normal, offset=spatial.to_float64(offset, "offset")
    )
    return solved(line.on(p.device).component(p, normal), height)


@dataclass(frozen=True)
class Turning:
    """A quantity a cos θ + b sin θ + c of a point that turns by θ, each part with axes (...)."""

    a: Tensor
    b: Tensor
    c: Tensor

    def at(self, angle: Tensor) -> Tensor:
        """Return its values at angles."""
        return self.a * angle.cos() + self.b * angle.sin() + self.c

    def spread(self) -> Turning:
        """Return the same with an axis behind, for several angles each."""
        return Turning(self.a[..., None], self.b[..., None], self.c[..., None])


@dataclass(frozen=True)
class Line:
    """An axis: a point on it (3) and its direction (3)."""

    point: Tensor
    direction: Tensor

    @classmethod
    def of(cls, screw: TensorLike, name: str) -> Line:
        """Return the axis of a revolute screw (6), taken if it is right to six digits."""
        screw = spatial.to_float64(screw, name)
        if screw.shape != (6,):
            raise ValueError(f"{name} has shape {tuple(screw.shape)}; (6,) is needed")
        v, omega = require_values(screw, name).split(3)
        length, pitch = float(omega.norm()), float(v @ omega) / (1 + float(v.norm()))
        if abs(length - 1) > SIX_DIGITS or abs(pitch) > SIX_DIGITS:
            raise ValueError(f"{name} is {screw.tolist()}; a revolute screw [v; ω] is needed")
        if abs(length - 1) > ROUNDING:
            v, omega = v / length, omega / length
        return cls(torch.linalg.cross(omega, v), omega)

    def on(self, device: torch.device) -> Line:
        """Return the axis on a device."""
        return Line(self.point.to(device), self.direction.to(device))

    def reversed(self) -> Line:
        """Return the same axis, about which a turn is one back about this."""
        return Line(self.point, -self.direction)

    def parts(self, p: Tensor) -> tuple[Tensor, Tensor, Tensor]:
        """Split a point (..., 3) into its foot on the axis, its arm, and the arm turned by a right angle."""
        foot = self.point + ((p - self.point) @ self.direction)[..., None] * self.direction
        arm = p - foot
        return foot, arm, torch.linalg.cross(self.direction.expand_as(arm), arm)

    def turned(self, p: Tensor, angle: Tensor) -> Tensor:
        """Return points (..., 3) turned about the axis."""
        foot, arm, side = self.parts(p)
        return foot + angle.cos()[..., None] * arm + angle.sin()[..., None] * side

    def angle(self, p: Tensor, q: Tensor) -> Tensor:
        """Return angles that turn points p onto q, or as near as they get."""
        _, arm, side = self.parts(p)
        _, other, _ = self.parts(q)
        cosine, sine = (arm * other).sum(-1), (side * other).sum(-1)
        scale = arm.norm(dim=-1) + other.norm(dim=-1) + self.point.norm()
        anywhere = torch.minimum(arm.norm(dim=-1), other.norm(dim=-1)) <= _ON_AXIS * scale
        return torch.where(anywhere, 0.0, torch.atan2(sine, cosine))

    def component(self, p: Tensor, normal: Tensor) -> Turning:
        """Component along a vector (3) of a point that turns about this axis."""
        foot, arm, side = self.parts(p)
        return Turning(arm @ normal, side @ normal, foot @ normal)

    def distance_squared(self, p: Tensor, q: Tensor) -> Turning:
        """Squared distance from q of a point p that turns about this axis."""
        foot, arm, side = self.parts(p)
        away = foot - q
        constant = away.square().sum(-1) + arm.square().sum(-1)
        return Turning(2 * (away * arm).sum(-1), 2 * (away * side).sum(-1), constant)

    def parallel_to(self, other: Line) -> bool:
        """Whether another axis is parallel to this one, to six digits."""
        return self.parallel_miss(other) < SIX_DIGITS

    def parallel_miss(self, other: Line) -> float:
        """Sine of the angle to another axis."""
        return float(torch.linalg.cross(self.direction, other.direction).norm())

    def foot_towards(self, other: Line) -> Tensor:
        """Point on this axis that is nearest to one that is not parallel to it."""
        normal = torch.linalg.cross(self.direction, other.direction)
        across = torch.linalg.cross(other.direction, normal)
        return self.point + ((other.point - self.point) @ across) / (self.direction @ across) * self.direction

    def meeting(self, other: Line) -> Tensor | None:
        """Point at which another axis meets this one."""
        if self.parallel_to(other):
            return None
        here = self.foot_towards(other)
        return here if self.meeting_miss(other) < SIX_DIGITS * (1 + here.norm()) else None

    def relation_miss(self, other: Line) -> float:
        """By how much a relation to another axis that is taken to hold, parallel or meeting, is missed."""
        if self.parallel_to(other):
            return self.parallel_miss(other)
        return 0.0 if self.meeting(other) is None else self.meeting_miss(other)

    def meeting_miss(self, other: Line) -> float:
        """Distance [m] to an axis that is not parallel to this one."""
        return float((self.foot_towards(other) - other.foot_towards(self)).norm())


def solved(turning: Turning, value: Tensor) -> Tensor:
    """Angles (..., 2) at which a quantity has a value, or comes nearest to it."""
    amplitude = torch.hypot(turning.a, turning.b)
    cosine = value - turning.c
    sine = ((amplitude - cosine) * (amplitude + cosine)).clamp(min=0).sqrt()
    middle, half = torch.atan2(turning.b, turning.a), torch.atan2(sine, cosine)
    return spatial.wrap_to_pi(torch.stack([middle + half, middle - half], dim=-1))


def about_two(one: Line, two: Line, p: Tensor, q: Tensor) -> Tensor:
    """Pairs of angles (..., 2, 2) about axes that meet: the second lifts p along the first as high as q."""
    second = solved(two.component(p, one.direction), q @ one.direction)
    first = one.angle(two.turned(p[..., None, :], second), q[..., None, :])
    return torch.stack([first, second], dim=-1)


def points_of(p: TensorLike, name: str) -> Tensor:
    return spatial.batch_of(p, name, (3,))
