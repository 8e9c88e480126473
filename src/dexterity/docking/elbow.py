r"""Manipulability of an elbow arm at a point and a tool axis, in closed form, for millions of poses.

With the wrist's centre at the tool point, r ahead and h above the shoulder in the arm's plane,

.. math:: w = l_1 l_2 \, |\sin\theta_3| \, |r| \, |\sin\theta_5|,

and all four branches of the arm follow from square roots alone: a limit of an angle is looked at through its
cosine and sine. The two branches of the wrist have the same w.

Examples
--------
>>> import torch
>>> import dexterity as dx
>>> from dexterity.docking.elbow import ElbowArm
>>> near, far, down = torch.tensor([[0.5, 0, 0], [2.0, 0, 0], [0, 0, -1.0]]).double()
>>> elbow = ElbowArm.of(dx.robots.docking_arm())
>>> [bool(elbow.manipulability(point, axis=down) > 0) for point in (near, far)]
[True, False]
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import torch
from torch import Tensor

from dexterity.chain import Chain
from dexterity.inverse_kinematics.turns import angles_within

__all__ = ["ElbowArm"]

_TOLERANCE = 1e-12
_DIRECTIONS = [[0, 0, 1], [0, -1, 0], [0, -1, 0], [1, 0, 0], [0, -1, 0], [1, 0, 0]]


@dataclass(frozen=True)
class ElbowArm:
    """An arm that stands straight out along x at home, on a first axis along z through the base.

    Attributes
    ----------
    height, sideways
        Where the plane of the arm is at home: its shoulder above the base, and to the left of it, [m].
    upper_arm, forearm
        Lengths l₁ and l₂ [m].
    lower, upper
        Limits of the first three joints [rad].
    """

    height: float
    sideways: float
    upper_arm: float
    forearm: float
    lower: tuple[float, float, float]
    upper: tuple[float, float, float]

    @classmethod
    def of(cls, arm: Chain) -> ElbowArm | None:
        """Return the elbow arm that a chain is; None if it is none, or its wrist has limits that bind."""
        if arm.joints != 6 or set(arm.kinds) != {"revolute"}:
            return None
        v, omega = arm.screws[:, :3], arm.screws[:, 3:]
        # The point of each axis that is nearest to the base: across y for the bends, across x for the rolls.
        feet = torch.linalg.cross(omega, v)
        shoulder, elbow, wrist, height, sideways = (
            float(feet[i, j]) for i, j in ((1, 0), (2, 0), (4, 0), (1, 2), (3, 1))
        )
        expected = [[0, 0, 0], *([x, 0, height] for x in (0, elbow)), [0, sideways, height]]
        expected += [[wrist, 0, height], [0, sideways, height]]
        pairs = [(omega, _DIRECTIONS), (feet, expected), (arm.home[:3, 3], [wrist, sideways, height])]
        alike = all((a - a.new_tensor(b)).abs().max() < _TOLERANCE for a, b in pairs)
        if not alike or not shoulder < elbow < wrist or not _wrist_is_free(arm):
            return None
        lower, upper = (tuple(limit.tolist()[:3]) for limit in (arm.lower, arm.upper))
        return cls(height, sideways, elbow, wrist - elbow, lower, upper)

    def manipulability(self, point: Tensor, axis: Tensor) -> Tensor:
        """Largest w (...) of the branches within the limits, 0 where there is none.

        Parameters
        ----------
        point
            (3, ...) tool points in the base [m].
        axis
            (3, ...) directions of the sixth axis in the base.
        """
        x, y, z = point
        across = x.square() + y.square()
        ahead_squared = across - self.sideways**2
        up = z - self.height
        far = ahead_squared + up.square()
        l1, l2 = self.upper_arm, self.forearm
        cosine = (far - l1**2 - l2**2) / (2 * l1 * l2)
        reached = (ahead_squared >= 0) & (cosine.abs() <= 1)
        ahead = ahead_squared.clamp(min=0).sqrt()
        sine = (1 - cosine.square()).clamp(min=0).sqrt()
        # Over the first axis or the shoulder w is zero, whatever stands for a division by nothing.
        per_across = 1 / torch.where(across > 0, across, 1.0)
        per_far = 1 / torch.where(far > 0, far, 1.0)
        along, beyond = (l1 + l2 * cosine) * per_far, l2 * sine * per_far
        best = torch.full_like(x, math.inf)
        for side in (1.0, -1.0):
            r = side * ahead
            c1, s1 = (r * x + self.sideways * y) * per_across, (r * y - self.sideways * x) * per_across
            forward = c1 * axis[0] + s1 * axis[1]
            first = reached & self._within(0, c1, s1)
            for elbow in (1.0, -1.0):
                bent = elbow * beyond
                c2, s2 = along * r + bent * up, along * up - bent * r
                c23, s23 = (r - l1 * c2) / l2, (up - l1 * s2) / l2
                within = first & self._within(1, c2, s2) & self._within(2, cosine, elbow * sine)
                # cos² θ₅, the smaller the better
                straight = (c23 * forward + s23 * axis[2]).square()
                best = torch.where(within, torch.minimum(best, straight), best)
        wrist = (1 - best).clamp(min=0).sqrt()
        # Out of reach by far, zero times infinity is no number.
        return torch.where(reached, l1 * l2 * sine * ahead * wrist, 0.0)

    def _within(self, joint: int, cosine: Tensor, sine: Tensor) -> Tensor:
        """Whether an angle, by its cosine and sine, is between the limits of a joint."""
        return angles_within(cosine, sine, (self.lower[joint], self.upper[joint]))


def _wrist_is_free(arm: Chain) -> bool:
    """Whether one of the wrist's two branches is within the limits, whatever the first three joints are.

    The fourth and the fifth joint may have any angle then, and of two angles of the sixth, half a turn apart,
    one fits.
    """
    width = arm.upper - arm.lower
    return bool((width[3:5] >= math.tau).all() and width[5] >= math.pi)
