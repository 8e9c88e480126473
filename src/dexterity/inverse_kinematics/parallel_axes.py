r"""All configurations of six-joint arms with three parallel axes, such as those of Universal Robots.

With axes 2, 3 and 4 along a, and :math:`g = T M^{-1} = e^{\hat S_1 q_1} \cdots e^{\hat S_6 q_6}`, the
motion :math:`P = e^{-\hat S_1 q_1} g\, e^{-\hat S_6 q_6} e^{-\hat S_5 q_5}` is planar: it keeps a, and
heights along a.

1. The point where axes 5 and 6 meet keeps its height: subproblem 4 gives joint 1, twice.
2. P keeps a, so joints 5 and 6 turn :math:`R_g^\top R_1 a` onto a: subproblem 2, twice.
3. Joints 2, 3 and 4 make the planar motion P: subproblem 3 gives joint 3, twice; subproblem 1 gives the
   others.

That makes eight branches. Where axis 6 is parallel to a, joint 6 may have any value; the one nearest to
zero is taken that leaves the rest within reach. Arms whose axes 3, 4 and 5 are parallel, and whose first
two axes meet, are such arms seen from the tool.

References
----------
Murray, Li & Sastry (1994), section 3.3, for the subproblems; Hawkins (2013), Analytic inverse
kinematics for the Universal Robots UR-5/UR-10 arms, for the eight branches.

Examples
--------
>>> import dexterity as dx
>>> ur = dx.robots.load("ur5e")
>>> T = ur.forward([0.3, -1.0, 1.2, -0.5, 0.8, 0.2])
>>> q, valid = dx.inverse_kinematics.three_parallel_axes(ur, T)
>>> int(valid.sum()), bool((ur.forward(q[valid]) - T).abs().max() < 1e-9)
(8, True)
"""

from __future__ import annotations

from dataclasses import dataclass

import torch
from jaxtyping import Bool, Float64
from torch import Tensor

from dexterity import spatial
from dexterity.chain import Chain
from dexterity.inverse_kinematics.branches import Form
from dexterity.inverse_kinematics.refinement import arm_size
from dexterity.inverse_kinematics.subproblems import Line, about_two, solved
from dexterity.spatial import TensorLike
from dexterity.spatial.tolerances import SIX_DIGITS

__all__ = ["PARALLEL_AXES", "three_parallel_axes"]

_FREE = 1e-10  # sine of the angle between axis 6 and the parallel axes below which joint 6 is free
_DOUBLE = 1e-7  # difference of two roots [rad] that rounding makes of a double one


def three_parallel_axes(
    arm: Chain, T_base_tool: TensorLike
) -> tuple[Float64[Tensor, "*batch 8 6"], Bool[Tensor, "*batch 8"]]:
    """Return every configuration in which an arm with three parallel axes has its tool at a pose.

    Parameters
    ----------
    arm
        Six revolute joints. The axes of joints 2, 3 and 4 are parallel and those of 5 and 6 meet; or those of
        3, 4 and 5 are parallel and those of 1 and 2 meet. Its limits play no part here: see `nearest_copy`.
    T_base_tool
        (..., 4, 4) wanted tool poses in the arm's world frame.

    Returns
    -------
    q
        (..., 8, 6) joint values [rad] from −π to π. All are finite.
    valid
        (..., 8) whether they put the tool at the pose, to 1e-9 in metres (relative to the arm's size where it
        is larger) and radians. At a singular pose branches coincide; where a joint could have any value it
        has one.

    Runs on the device of the poses. Values decide about the way, so torch cannot trace or transform it.

    Raises
    ------
    ValueError
        If the arm is not such an arm, or a pose is not rigid or not finite.
    """
    return PARALLEL_AXES(arm, T_base_tool)


@dataclass(frozen=True)
class ParallelGeometry:
    """Axes of an arm at home, points (3) on axes 2 and 4 at one height, and where axes 5 and 6 meet (3).

    `reach` holds the distances [m] of axes 2 and 3, and 3 and 4; `size` is the arm's size [m], `miss`
    what its conditions miss.
    """

    axes: tuple[Line, ...]
    second: Tensor
    fourth: Tensor
    wrist: Tensor
    reach: tuple[float, float]
    size: float
    miss: float

    @classmethod
    def of(cls, arm: Chain, device: torch.device) -> ParallelGeometry:
        """Check the conditions and measure an arm."""
        if arm.joints != 6 or set(arm.kinds) != {"revolute"}:
            raise ValueError(f"arm has joints that are {', '.join(arm.kinds)}; six revolute ones are needed")
        one, two, three, four, five, six = axes = tuple(
            Line.of(screw, "arm") for screw in arm.screws.to(device)
        )
        if not (two.parallel_to(three) and two.parallel_to(four)):
            raise ValueError("arm has no three parallel axes: those of joints 2, 3 and 4 are not")
        wrist, size = five.meeting(six), arm_size(arm)
        if wrist is None:
            raise ValueError("arm has three parallel axes, but those of joints 5 and 6 do not meet")
        fourth = four.point
        second = two.point + ((fourth - two.point) @ two.direction) * two.direction
        third = three.point + ((fourth - three.point) @ two.direction) * two.direction
        reach = float((third - second).norm()), float((fourth - third).norm())
        if one.parallel_to(two) or five.parallel_to(four) or min(reach) < SIX_DIGITS * size:
            raise ValueError("arm has three parallel axes, but joints that repeat each other")
        miss = max(two.parallel_miss(three), two.parallel_miss(four), five.meeting_miss(six))
        return cls(axes, second, fourth, wrist, reach, size, miss)

    def branches(self, g: Tensor) -> Tensor:
        """All joints (..., 8, 6) for motions (..., 4, 4) of the tool from home."""
        one, two, three, four, five, _ = self.axes
        height = one.reversed().component(spatial.apply(g, self.wrist), two.direction)
        first = _merged(solved(height, self.wrist @ two.direction))[..., None].expand(*g.shape[:-2], 2, 2)
        outer = self._outer(g, first)
        joints = [first, *outer.unbind(-1)]
        target = self._seen_from_first(g, joints, self.fourth)
        distance = (target - self.second).square().sum(-1)
        third = solved(three.distance_squared(self.fourth, self.second), distance)
        first, fifth, sixth = (joint[..., None].expand_as(third) for joint in joints)
        second = two.angle(three.turned(self.fourth, third), target[..., None, :])
        beside = self.fourth + torch.linalg.cross(four.direction, five.direction)
        moved = self._seen_from_first(g[..., None, :, :], [first, fifth, sixth], beside)
        fourth = four.angle(beside, three.turned(two.turned(moved, -second), -third))
        return torch.stack([first, second, third, fourth, fifth, sixth], dim=-1).flatten(-4, -2)

    def _outer(self, g: Tensor, first: Tensor) -> Tensor:
        """Joints 5 and 6 (..., 2, 2, 2) for the values (..., 2, 2) of joint 1."""
        one, two, _, _, five, six = self.axes
        origin = torch.zeros_like(self.wrist)
        turned = Line(origin, one.direction).turned(two.direction, first[..., 0])
        away = (g[..., None, :3, :3].mT @ turned[..., None])[..., 0]
        pairs = about_two(Line(origin, five.direction), Line(origin, six.direction), away, two.direction)
        fifth, sixth = pairs.unbind(-1)
        free = torch.linalg.cross(away, six.direction.expand_as(away)).norm(dim=-1) < _FREE
        sixth = torch.where(free[..., None], self._free_sixth(g, first, fifth), sixth)
        return torch.stack([fifth, sixth], dim=-1)

    def _free_sixth(self, g: Tensor, first: Tensor, fifth: Tensor) -> Tensor:
        """Value of joint 6 nearest to zero that leaves joints 2 and 3 within reach, where any keeps a."""
        one, _, _, _, five, six = self.axes
        pivot = spatial.apply(spatial.inverse(g)[..., None, None, :, :], one.turned(self.second, first))
        turning = six.reversed().distance_squared(five.turned(self.fourth, -fifth), pivot)
        (a, b), zero = self.reach, torch.zeros_like(fifth)
        both = solved(turning, turning.at(zero).clamp((a - b) ** 2, (a + b) ** 2))
        return torch.take_along_dim(both, both.abs().argmin(-1, keepdim=True), dim=-1)[..., 0]

    def _seen_from_first(self, g: Tensor, joints: list[Tensor], point: Tensor) -> Tensor:
        """Return a point (3) moved by P, for joints 1, 5 and 6 (..., 2, 2, …)."""
        one, *_, five, six = self.axes
        first, fifth, sixth = joints
        p = six.turned(five.turned(point.expand(*fifth.shape, 3), -fifth), -sixth)
        return one.turned(spatial.apply(g[..., None, None, :, :], p), -first)


PARALLEL_AXES = Form("three parallel axes", ParallelGeometry.of, ("base", "tool"))
"""The closed form of such arms, seen from the base or from the tool."""


def _merged(angles: Tensor) -> Tensor:
    """Replace both roots (..., 2) that differ by rounding alone by their mean, which has all its digits."""
    half = spatial.wrap_to_pi(angles[..., 1] - angles[..., 0]) / 2
    mean = (angles[..., 0] + half)[..., None]
    return torch.where(half.abs()[..., None] < _DOUBLE, mean, angles)
