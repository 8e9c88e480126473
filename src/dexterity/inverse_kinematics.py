"""All inverse-kinematic branches of six-joint arms with a spherical wrist, by Paden–Kahan subproblems.

A subproblem turns a point about one or two axes to where it is wanted. The wrist's centre does not know of
the last three joints: where it is gives the first three, up to four times; the rest of the pose gives the
wrist, twice each (Murray, Li & Sastry 1994, section 3.3; Pieper 1968 for axes that neither meet nor are
parallel). Axes are screws [v; ω] with ‖ω‖ = 1, as those of a chain.

Examples
--------
>>> import dexterity as dx
>>> puma = dx.robots.puma560()
>>> T = puma.forward([0.0, 0.5, 0.25, 0.0, 0.5, 0.0])
>>> q, valid = dx.inverse_kinematics.spherical_wrist(puma, T)
>>> q.shape, int(valid.sum())
(torch.Size([8, 6]), 8)
>>> bool((puma.forward(q[valid]) - T).abs().max() < 1e-9)
True
"""

from __future__ import annotations

import functools
import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass

import torch
from jaxtyping import Bool, Float64
from torch import Tensor

from dexterity import spatial
from dexterity.chain import Chain
from dexterity.spatial import TensorLike

__all__ = [
    "copies_within_limits",
    "nearest_copy",
    "spherical_wrist",
    "subproblem_1",
    "subproblem_2",
    "subproblem_3",
    "subproblem_4",
]

_TOLERANCE = 1e-9
_ROUNDING = 1e-12


# ---- subproblems -----------------------------------------------------------------------------------


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
    line = _Line.of(axis, "axis")
    return line.angle(_points(p, "p"), _points(q, "q"))


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
    one, two = _Line.of(first, "first"), _Line.of(second, "second")
    if one.meeting(two) is None:
        raise ValueError("first and second are axes that do not meet, or are parallel")
    return _about_two(one, two, _points(p, "p"), _points(q, "q"))


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
    line = _Line.of(axis, "axis")
    p, q, wanted = _points(p, "p"), _points(q, "q"), spatial.to_float64(distance, "distance")
    if (wanted < 0).any():
        raise ValueError(f"distance is {wanted.min().item()} at least; 0 or a positive number is needed")
    return _solved(line.distance_squared(p, q), wanted.square())


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
    line, normal = _Line.of(axis, "axis"), _points(normal, "normal")
    return _solved(line.component(_points(p, "p"), normal), spatial.to_float64(offset, "offset"))


@dataclass(frozen=True)
class _Turning:
    """A quantity a cos θ + b sin θ + c of a point that turns by θ, each part with axes (...)."""

    a: Tensor
    b: Tensor
    c: Tensor

    def at(self, angle: Tensor) -> Tensor:
        return self.a * angle.cos() + self.b * angle.sin() + self.c

    def spread(self) -> _Turning:
        """Return the same with an axis behind, for several angles each."""
        return _Turning(self.a[..., None], self.b[..., None], self.c[..., None])


@dataclass(frozen=True)
class _Line:
    """An axis: a point on it (3) and its direction (3)."""

    point: Tensor
    direction: Tensor

    @classmethod
    def of(cls, screw: TensorLike, name: str) -> _Line:
        screw = spatial.to_float64(screw, name)
        if screw.shape != (6,):
            raise ValueError(f"{name} has shape {tuple(screw.shape)}; (6,) is needed")
        v, omega = screw[:3], screw[3:]
        if abs(float(omega.norm()) - 1) > _TOLERANCE or abs(float(v @ omega)) > _TOLERANCE * (1 + v.norm()):
            raise ValueError(f"{name} is {screw.tolist()}; a revolute screw [v; ω] is needed")
        return cls(torch.linalg.cross(omega, v), omega)

    def reversed(self) -> _Line:
        """Return the same axis, about which a turn is one back about this."""
        return _Line(self.point, -self.direction)

    def parts(self, p: Tensor) -> tuple[Tensor, Tensor, Tensor]:
        """Split a point (..., 3) into its foot on the axis, its arm, and the arm turned by a right angle."""
        foot = self.point + ((p - self.point) @ self.direction)[..., None] * self.direction
        arm = p - foot
        return foot, arm, torch.linalg.cross(self.direction.expand_as(arm), arm)

    def turned(self, p: Tensor, angle: Tensor) -> Tensor:
        foot, arm, side = self.parts(p)
        return foot + angle.cos()[..., None] * arm + angle.sin()[..., None] * side

    def angle(self, p: Tensor, q: Tensor) -> Tensor:
        _, arm, side = self.parts(p)
        _, other, _ = self.parts(q)
        cosine, sine = (arm * other).sum(-1), (side * other).sum(-1)
        scale = arm.norm(dim=-1) + other.norm(dim=-1) + self.point.norm()
        anywhere = torch.minimum(arm.norm(dim=-1), other.norm(dim=-1)) <= _ROUNDING * scale
        return torch.where(anywhere, 0.0, torch.atan2(sine, cosine))

    def component(self, p: Tensor, normal: Tensor) -> _Turning:
        """Component along a vector (3) of a point that turns about this axis."""
        foot, arm, side = self.parts(p)
        return _Turning(arm @ normal, side @ normal, foot @ normal)

    def distance_squared(self, p: Tensor, q: Tensor) -> _Turning:
        """Squared distance from q of a point p that turns about this axis."""
        foot, arm, side = self.parts(p)
        away = foot - q
        constant = away.square().sum(-1) + arm.square().sum(-1)
        return _Turning(2 * (away * arm).sum(-1), 2 * (away * side).sum(-1), constant)

    def parallel_to(self, other: _Line) -> bool:
        return float(torch.linalg.cross(self.direction, other.direction).norm()) < _TOLERANCE

    def foot_towards(self, other: _Line) -> Tensor:
        """Point on this axis that is nearest to one that is not parallel to it."""
        normal = torch.linalg.cross(self.direction, other.direction)
        across = torch.linalg.cross(other.direction, normal)
        return self.point + ((other.point - self.point) @ across) / (self.direction @ across) * self.direction

    def meeting(self, other: _Line) -> Tensor | None:
        """Point at which another axis meets this one."""
        if self.parallel_to(other):
            return None
        here, there = self.foot_towards(other), other.foot_towards(self)
        return here if (here - there).norm() < _TOLERANCE * (1 + here.norm()) else None


def _solved(turning: _Turning, value: Tensor) -> Tensor:
    """Angles (..., 2) at which a quantity has a value, or comes nearest to it."""
    amplitude = torch.hypot(turning.a, turning.b)
    cosine = value - turning.c
    sine = ((amplitude - cosine) * (amplitude + cosine)).clamp(min=0).sqrt()
    middle, half = torch.atan2(turning.b, turning.a), torch.atan2(sine, cosine)
    return spatial.wrap_to_pi(torch.stack([middle + half, middle - half], dim=-1))


def _about_two(one: _Line, two: _Line, p: Tensor, q: Tensor) -> Tensor:
    """Pairs of angles (..., 2, 2) about axes that meet: the second lifts p along the first as high as q."""
    second = _solved(two.component(p, one.direction), q @ one.direction)
    first = one.angle(two.turned(p[..., None, :], second), q[..., None, :])
    return torch.stack([first, second], dim=-1)


def _points(p: TensorLike, name: str) -> Tensor:
    p = spatial.to_float64(p, name)
    if p.shape[-1:] != (3,):
        raise ValueError(f"{name} has shape {tuple(p.shape)}; (..., 3) is needed")
    return p


# ---- arms with a spherical wrist -------------------------------------------------------------------


def spherical_wrist(
    arm: Chain, T_base_tool: TensorLike
) -> tuple[Float64[Tensor, "*batch 8 6"], Bool[Tensor, "*batch 8"]]:
    """Return every configuration in which an arm with a spherical wrist has its tool at a pose.

    Parameters
    ----------
    arm
        Six revolute joints; the axes of the last three meet in a point, and neighbours among them are not
        parallel. Its limits play no part here: see `nearest_copy`.
    T_base_tool
        (..., 4, 4) wanted tool poses in the arm's world frame.

    Returns
    -------
    q
        (..., 8, 6) joint values [rad] from −π to π: up to four branches of the arm, each with the two of the
        wrist side by side. All are finite.
    valid
        (..., 8) whether they put the tool at the pose, to 1e-9 in metres (relative to the arm's size where it
        is larger) and radians. At a singular pose branches coincide; where a joint could have any value it
        has one.

    Raises
    ------
    ValueError
        If the arm is not such an arm, or a pose is not rigid or not finite.

    References
    ----------
    Murray, Li & Sastry (1994), section 3.3; Pieper (1968).
    """
    geometry = _geometry(arm)
    T = spatial.require_rigid(T_base_tool, "T_base_tool")
    moved = T @ spatial.inverse(arm.home)
    shoulder = geometry.arm_branches(spatial.apply(moved, geometry.wrist))
    q = geometry.with_wrist(shoulder, moved[..., None, :, :])
    return _polished(arm, q, T[..., None, :, :], geometry.size)


@functools.lru_cache(maxsize=8)
def _geometry(arm: Chain) -> _Geometry:
    return _Geometry.of(arm)


@dataclass(frozen=True)
class _Geometry:
    """Axes of an arm at home, the centre (3) of its wrist, and its size [m]."""

    axes: tuple[_Line, ...]
    wrist: Tensor
    size: float

    @classmethod
    def of(cls, arm: Chain) -> _Geometry:
        if arm.joints != 6 or set(arm.kinds) != {"revolute"}:
            raise ValueError(f"arm has joints that are {', '.join(arm.kinds)}; six revolute ones are needed")
        axes = tuple(_Line.of(screw, "arm") for screw in arm.screws)
        wrist, again = axes[3].meeting(axes[4]), axes[4].meeting(axes[5])
        if wrist is None or again is None or (wrist - again).norm() > _TOLERANCE * (1 + wrist.norm()):
            raise ValueError("arm has no spherical wrist: the axes of its last three joints do not meet")
        geometry = cls(axes, wrist, max(1.0, float(arm.link_transforms[:, :3, 3].norm(dim=-1).sum())))
        if geometry._moves_on_a_surface():
            raise ValueError("arm moves the centre of its wrist on a surface only, which leaves a joint free")
        return geometry

    def _moves_on_a_surface(self) -> bool:
        """Whether the first three joints never move the wrist's centre in three directions."""
        one, two, three = self.axes[:3]
        second, third = torch.linspace(0.3, 6.1, 16, dtype=torch.float64).view(2, 8)
        outer = three.turned(self.wrist, third)
        middle = two.turned(outer, second)
        # What each joint does to the centre, seen before the joints inside of it.
        by_third = two.turned(outer + three.parts(outer)[2], second) - middle
        moves = torch.stack([one.parts(middle)[2], two.parts(middle)[2], by_third], dim=-1)
        return bool(torch.linalg.det(moves).abs().max() < _TOLERANCE * self.size**3)

    def arm_branches(self, centre: Tensor) -> Tensor:
        """First three joints (..., 4, 3) that bring the wrist's centre to points (..., 3).

        With e₁ to the other side, the centre turned about axis 3 and the point turned back about axis 1
        must go over into each other about axis 2: as high along it, and as far from a point on it.
        """
        one, two, three = self.axes[0].reversed(), self.axes[1], self.axes[2]
        inner, outer = one.meeting(two), three.meeting(two)
        pivot = outer if inner is None else inner
        if pivot is None:
            pivot = two.point if two.parallel_to(one) else two.foot_towards(one)
        height = one.component(centre, two.direction), three.component(self.wrist, two.direction)
        distance = one.distance_squared(centre, pivot), three.distance_squared(self.wrist, pivot)
        if two.parallel_to(three):
            first, third = _in_turn(height[0], height[1].c, distance[1], distance[0])
        elif inner is not None:
            third, first = _in_turn(distance[1], distance[0].c, height[0], height[1])
        elif two.parallel_to(one):
            third, first = _in_turn(height[1], height[0].c, distance[0], distance[1])
        elif outer is not None:
            first, third = _in_turn(distance[0], distance[1].c, height[1], height[0])
        else:
            first, third = _together(height, distance)
        start = three.turned(self.wrist, third)
        second = two.angle(start, one.turned(centre[..., None, :], first))
        return torch.stack([first, second, third.expand_as(first)], dim=-1)

    def with_wrist(self, shoulder: Tensor, moved: Tensor) -> Tensor:
        """All joints (..., 8, 6) where the first three (..., 4, 3) leave a motion to the wrist."""
        four, five, six = (_Line(self.wrist, axis.direction) for axis in self.axes[3:])
        on_axis = self.wrist + six.direction
        side = torch.linalg.cross(six.direction, five.direction)
        beside = self.wrist + side / side.norm()
        angles = shoulder.unbind(-1)
        seen, seen_beside = (
            self._turned_back(point, self.axes[:3], angles)
            for point in (spatial.apply(moved, on_axis), spatial.apply(moved, beside))
        )
        pairs = _about_two(four, five, on_axis, seen)
        left = self._turned_back(seen_beside[..., None, :], (four, five), pairs.unbind(-1))
        wrist = torch.cat([pairs, six.angle(beside, left)[..., None]], dim=-1)
        arm = shoulder[..., None, :].expand(*wrist.shape[:-1], 3)
        return torch.cat([arm, wrist], dim=-1).flatten(-3, -2)

    @staticmethod
    def _turned_back(p: Tensor, axes: Sequence[_Line], angles: Sequence[Tensor]) -> Tensor:
        for axis, angle in zip(axes, angles, strict=True):
            p = axis.turned(p, -angle)
        return p


def _in_turn(simple: _Turning, value: Tensor, other: _Turning, wanted: _Turning) -> tuple[Tensor, Tensor]:
    """Solve one equation for one angle alone, then the other: four pairs (..., 4) of both.

    `simple` must have a value whatever the other angle; `other` must then be what `wanted`, of the first
    angle, has become.
    """
    first = _solved(simple, value)
    second = _solved(other.spread(), wanted.spread().at(first))
    return first[..., None].expand_as(second).flatten(-2), second.flatten(-2)


def _together(
    height: tuple[_Turning, _Turning], distance: tuple[_Turning, _Turning]
) -> tuple[Tensor, Tensor]:
    """Solve both equations at once where neither has one angle alone: four pairs (..., 4) of angles.

    They are linear in the cosine and sine of the first angle, whose squares add up to one. That leaves a
    trigonometric polynomial of the third, four roots on the unit circle at most.
    """
    (h, h3), (d, d3) = height, distance
    determinant = h.a * d.b - h.b * d.a
    inverse = torch.where(determinant == 0, 0.0, 1 / torch.where(determinant == 0, 1.0, determinant))
    # Cosine and sine of the first angle as x₁ cos θ₃ + x₂ sin θ₃ + x₃.
    raised = [(h3.a, d3.a), (h3.b, d3.b), (h3.c - h.c, d3.c - d.c)]
    cosine = [inverse * (u * d.b - v * h.b) for u, v in raised]
    sine = [inverse * (v * h.a - u * d.a) for u, v in raised]
    # With z = exp(iθ₃) each is w z + c + w̄/z, and the sum of the squares is one.
    w = [torch.complex(part[0], -part[1]) / 2 for part in (cosine, sine)]
    c = [part[2] for part in (cosine, sine)]
    highest = w[0].square() + w[1].square()
    high = 2 * (w[0] * c[0] + w[1] * c[1])
    middle = 2 * (w[0].abs().square() + w[1].abs().square()) + c[0].square() + c[1].square() - 1
    third = _roots_on_circle(highest, high, middle)
    x, y = (_Turning(*part).spread().at(third) for part in (cosine, sine))
    return torch.atan2(y, x), third


def _roots_on_circle(highest: Tensor, high: Tensor, middle: Tensor) -> Tensor:
    """Arguments (..., 4) of the roots of a z⁴ + b z³ + c z² + b̄ z + ā, with c real."""
    size = highest.abs() + high.abs() + middle.abs() + 1
    leading = torch.where(highest.abs() < _ROUNDING**2 * size, _ROUNDING**2 * size, highest)
    companion = highest.new_zeros(*highest.shape, 4, 4)
    companion[..., 1:, :-1] = torch.eye(3, dtype=companion.dtype, device=companion.device)
    rows = (highest.conj(), high.conj(), torch.complex(middle, torch.zeros_like(middle)), high)
    companion[..., :, 3] = -torch.stack(rows, dim=-1) / leading[..., None]
    return torch.linalg.eigvals(companion).angle()


def _polished(arm: Chain, q: Tensor, T: Tensor, size: float) -> tuple[Tensor, Tensor]:
    """Take rounding near double roots off with a step of Newton, and tell which are at the pose."""
    q, T = spatial.wrap_to_pi(q), T.expand(*q.shape[:-1], 4, 4)
    miss = _miss(arm, q, T, size)
    near = (miss > _ROUNDING) & (miss < math.sqrt(_TOLERANCE))
    q[near] = spatial.wrap_to_pi(q[near] + _newton_step(arm, q[near], T[near]))
    miss[near] = _miss(arm, q[near], T[near], size)
    return q, miss <= _TOLERANCE


def _miss(arm: Chain, q: Tensor, T: Tensor, size: float) -> Tensor:
    """Largest miss (...) of a pose, positions relative to the size of the arm."""
    away = (arm.forward(q) - T).abs()
    return torch.maximum(away[..., :3, :3].amax((-2, -1)), away[..., :3, 3].amax(-1) / size)


def _newton_step(arm: Chain, q: Tensor, T: Tensor) -> Tensor:
    J = arm.body_jacobian(q)
    twist = spatial.log(spatial.compose(spatial.inverse(arm.forward(q)), T))
    # Damped, since the wrist is singular where branches coincide.
    damping = _ROUNDING * torch.eye(6, dtype=J.dtype, device=J.device)
    return torch.linalg.solve(J.mT @ J + damping, (J.mT @ twist[..., None]))[..., 0]


# ---- full turns ------------------------------------------------------------------------------------


def nearest_copy(chain: Chain, q: TensorLike) -> tuple[Float64[Tensor, "*batch n"], Bool[Tensor, "*batch"]]:
    """Move joint values by full turns to the middle of their limits, and tell whether they are within.

    Parameters
    ----------
    chain
        A chain with limits. Prismatic joints are left as they are.
    q
        (..., n) joint values, [rad] or [m].

    Returns
    -------
    The values of the same pose that are nearest to the middle of the limits, or above a lower and below an
    upper limit that stands alone; and whether all joints are within their limits (...), ends included. If no
    copy of a configuration is within the limits, this one is not.

    Raises
    ------
    ValueError
        If the last axis of `q` is not the number of joints, or `q` is not finite.
    """
    q = spatial.require_joints(spatial.to_float64(q, "q"), chain.joints, "chain")
    lower, upper = chain.lower.to(q.device), chain.upper.to(q.device)
    middle = torch.where(
        lower.isinf(), upper - math.pi, torch.where(upper.isinf(), lower + math.pi, (lower + upper) / 2)
    )
    middle = torch.where(lower.isinf() & upper.isinf(), 0.0, middle)
    turns = torch.round((q - middle) / (2 * math.pi))
    revolute = torch.tensor([kind == "revolute" for kind in chain.kinds], device=q.device)
    moved = torch.where(revolute, q - 2 * math.pi * turns, q)
    return moved, ((moved >= lower) & (moved <= upper)).all(-1)


def copies_within_limits(chain: Chain, q: TensorLike) -> Float64[Tensor, "copies n"]:
    """Return all values of one configuration that differ by full turns and are within the limits.

    Parameters
    ----------
    chain
        A chain whose revolute joints have finite limits.
    q
        (n,) joint values, [rad] or [m].

    Returns
    -------
    (copies, n), in rising order of the first joint, then of the second, and so on; none if a joint has none.

    Raises
    ------
    ValueError
        If `q` is not (n,) or not finite, or a revolute joint has no limit, and so infinitely many copies.
    """
    q = spatial.require_joints(spatial.to_float64(q, "q"), chain.joints, "chain")
    if q.ndim != 1:
        raise ValueError(f"q has shape {tuple(q.shape)}; one configuration, ({chain.joints},), is needed")
    each = []
    limits = zip(q.tolist(), chain.kinds, chain.lower.tolist(), chain.upper.tolist(), strict=True)
    for i, (value, kind, lower, upper) in enumerate(limits):
        if kind == "prismatic":
            each.append([value] if lower <= value <= upper else [])
        elif math.isinf(upper - lower):
            raise ValueError(f"chain has no limits at {chain.joint_names[i]}, and so infinitely many copies")
        else:
            first, last = (math.ceil((lower - value) / math.tau), math.floor((upper - value) / math.tau))
            each.append([value + math.tau * k for k in range(first, last + 1)])
    return q.new_tensor(list(itertools.product(*each))).reshape(-1, chain.joints)
