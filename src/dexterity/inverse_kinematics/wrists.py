"""All configurations of six-joint arms three of whose axes meet: a spherical wrist, or a spherical shoulder.

The wrist's centre does not depend on the last three joints: where it is gives the first three, up to four
times; the rest of the pose gives the wrist, twice each (Murray, Li & Sastry 1994, section 3.3; Pieper 1968
for axes that neither meet nor are parallel). An arm whose first three axes meet is such an arm seen from its
tool.

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

from collections.abc import Sequence
from dataclasses import dataclass

import torch
from jaxtyping import Bool, Float64
from torch import Tensor

from dexterity import spatial
from dexterity.chain import Chain
from dexterity.inverse_kinematics.branches import Form
from dexterity.inverse_kinematics.refinement import arm_size
from dexterity.inverse_kinematics.subproblems import Line, Turning, about_two, solved
from dexterity.spatial import TensorLike
from dexterity.spatial.tolerances import ROUNDING, SIX_DIGITS

__all__ = ["SHOULDER", "WRIST", "spherical_shoulder", "spherical_wrist"]

_NO_LEADING = 1e-24  # relative size of a leading coefficient below which a polynomial is of lower degree


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

    Runs on the device of the poses. Values decide about the way, so torch cannot trace or transform it.

    Raises
    ------
    ValueError
        If the arm is not such an arm, or a pose is not rigid or not finite.

    References
    ----------
    Murray, Li & Sastry (1994), section 3.3; Pieper (1968).
    """
    return WRIST(arm, T_base_tool)


def spherical_shoulder(
    arm: Chain, T_base_tool: TensorLike
) -> tuple[Float64[Tensor, "*batch 8 6"], Bool[Tensor, "*batch 8"]]:
    """Return every configuration in which an arm whose first three axes meet has its tool at a pose.

    Parameters
    ----------
    arm
        Six revolute joints; the axes of the first three meet in a point.
    T_base_tool
        (..., 4, 4) wanted tool poses in the arm's world frame.

    Returns
    -------
    `q` (..., 8, 6) and `valid` (..., 8) as of :func:`spherical_wrist`.

    Raises
    ------
    ValueError
        If the arm is not such an arm, or a pose is not rigid or not finite.
    """
    return SHOULDER(arm, T_base_tool)


@dataclass(frozen=True)
class WristGeometry:
    """Axes of an arm at home, the centre (3) of its wrist, its size [m], and what its conditions miss."""

    axes: tuple[Line, ...]
    wrist: Tensor
    size: float
    miss: float

    @classmethod
    def of(cls, arm: Chain, device: torch.device) -> WristGeometry:
        """Check the conditions and measure an arm."""
        if arm.joints != 6 or set(arm.kinds) != {"revolute"}:
            raise ValueError(f"arm has joints that are {', '.join(arm.kinds)}; six revolute ones are needed")
        axes = tuple(Line.of(screw, "arm") for screw in arm.screws.to(device))
        wrist, again = axes[3].meeting(axes[4]), axes[4].meeting(axes[5])
        if wrist is None or again is None or (wrist - again).norm() > SIX_DIGITS * (1 + wrist.norm()):
            raise ValueError("arm has no spherical wrist: the axes of its last three joints do not meet")
        misses = [float((wrist - again).norm()), axes[3].meeting_miss(axes[4]), axes[4].meeting_miss(axes[5])]
        misses += [axes[1].relation_miss(axis) for axis in (axes[0], axes[2])]
        geometry = cls(axes, wrist, arm_size(arm), max(misses))
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
        return bool(torch.linalg.det(moves).abs().max() < ROUNDING * self.size**3)

    def branches(self, moved: Tensor) -> Tensor:
        """All joints (..., 8, 6) for motions (..., 4, 4) of the tool from home."""
        shoulder = self._arm_branches(spatial.apply(moved, self.wrist))
        return self._with_wrist(shoulder, moved[..., None, :, :])

    def _arm_branches(self, centre: Tensor) -> Tensor:
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

    def _with_wrist(self, shoulder: Tensor, moved: Tensor) -> Tensor:
        """All joints (..., 8, 6) where the first three (..., 4, 3) leave a motion to the wrist."""
        four, five, six = (Line(self.wrist, axis.direction) for axis in self.axes[3:])
        on_axis = self.wrist + six.direction
        side = torch.linalg.cross(six.direction, five.direction)
        beside = self.wrist + side / side.norm()
        angles = shoulder.unbind(-1)
        seen, seen_beside = (
            self._turned_back(point, self.axes[:3], angles)
            for point in (spatial.apply(moved, on_axis), spatial.apply(moved, beside))
        )
        pairs = about_two(four, five, on_axis, seen)
        left = self._turned_back(seen_beside[..., None, :], (four, five), pairs.unbind(-1))
        wrist = torch.cat([pairs, six.angle(beside, left)[..., None]], dim=-1)
        arm = shoulder[..., None, :].expand(*wrist.shape[:-1], 3)
        return torch.cat([arm, wrist], dim=-1).flatten(-3, -2)

    @staticmethod
    def _turned_back(p: Tensor, axes: Sequence[Line], angles: Sequence[Tensor]) -> Tensor:
        for axis, angle in zip(axes, angles, strict=True):
            p = axis.turned(p, -angle)
        return p


WRIST = Form("spherical wrist", WristGeometry.of, ("base",))
"""The closed form of arms with a spherical wrist."""
SHOULDER = Form("spherical shoulder", WristGeometry.of, ("tool",))
"""The closed form of arms with a spherical shoulder, which is that of a wrist seen from the tool."""


def _in_turn(simple: Turning, value: Tensor, other: Turning, wanted: Turning) -> tuple[Tensor, Tensor]:
    """Solve one equation for one angle alone, then the other: four pairs (..., 4) of both.

    `simple` must have a value whatever the other angle; `other` must then be what `wanted`, of the first
    angle, has become.
    """
    first = solved(simple, value)
    second = solved(other.spread(), wanted.spread().at(first))
    return first[..., None].expand_as(second).flatten(-2), second.flatten(-2)


def _together(height: tuple[Turning, Turning], distance: tuple[Turning, Turning]) -> tuple[Tensor, Tensor]:
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
    x, y = (Turning(*part).spread().at(third) for part in (cosine, sine))
    return torch.atan2(y, x), third


def _roots_on_circle(highest: Tensor, high: Tensor, middle: Tensor) -> Tensor:
    """Arguments (..., 4) of the roots of a z⁴ + b z³ + c z² + b̄ z + ā, with c real."""
    size = highest.abs() + high.abs() + middle.abs() + 1
    leading = torch.where(highest.abs() < _NO_LEADING * size, _NO_LEADING * size, highest)
    companion = highest.new_zeros(*highest.shape, 4, 4)
    companion[..., 1:, :-1] = torch.eye(3, dtype=companion.dtype, device=companion.device)
    rows = (highest.conj(), high.conj(), torch.complex(middle, torch.zeros_like(middle)), high)
    companion[..., :, 3] = -torch.stack(rows, dim=-1) / leading[..., None]
    return torch.linalg.eigvals(companion).angle()
