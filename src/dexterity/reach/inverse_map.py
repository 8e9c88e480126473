"""The inverse of a reach map: where the base may be, so that the tool is at a pose.

Examples
--------
>>> import dexterity as dx
>>> from dexterity import reach
>>> puma = dx.robots.puma560()
>>> grid = reach.box([0.2, -0.4, -0.4], [0.6, 0.4, 0.4], spacing=0.2)
>>> inverse = reach.survey(puma, grid, reach.rotations(24), index="w").inverted()
>>> pose = dx.spatial.pose(reach.pointing([0, 0, -1]), [1.0, 2.0, 0.0])
>>> bases, values = inverse.bases(pose, largest_tilt=0.1)
>>> bases.shape[1:], bool((bases[:, 2, 2] > 0.99).all()), len(bases) == len(values) > 0
(torch.Size([4, 4]), True, True)

References
----------
Vahrenkamp, Asfour & Dillmann (2013), Robot placement based on reachability inversion, ICRA.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import torch
from jaxtyping import Float64
from torch import Tensor

from dexterity import checks, spatial
from dexterity.spatial import TensorLike
from dexterity.spatial.values import on_cpu

if TYPE_CHECKING:
    from dexterity.reach.reach_map import ReachMap

__all__ = ["InverseReachMap"]


class InverseReachMap:
    """Poses of a base from which a tool is where it should be.

    Parameters
    ----------
    forward
        The map that is inverted.
    """

    def __init__(self, forward: ReachMap) -> None:
        from dexterity.reach.reach_map import ReachMap  # which imports this module

        self._forward = checks.instance(forward, "forward", ReachMap)
        self._T_tool_base = spatial.inverse(forward.poses()[forward.reached])
        self._values = forward.best[forward.reached]

    def __repr__(self) -> str:
        return f"InverseReachMap({self._forward.chain.name!r}, {len(self._values)} poses of the base)"

    def bases(
        self, T_world_tool: TensorLike, largest_tilt: float | None = None
    ) -> tuple[Float64[Tensor, "m 4 4"], Float64[Tensor, " m"]]:
        """Return the poses of the base (m, 4, 4) that the map has for a pose of the tool, and their index.

        Parameters
        ----------
        T_world_tool
            (4, 4) pose of the tool.
        largest_tilt
            Largest angle [rad] of the base's z axis from the vertical; any by default.

        Raises
        ------
        ValueError
            If it is not one rigid pose, or the angle is not from 0 to π.
        """
        T = spatial.require_rigid(on_cpu(T_world_tool, "T_world_tool"), "T_world_tool")
        if T.shape != (4, 4):
            raise ValueError(f"T_world_tool has shape {tuple(T.shape)}; one pose (4, 4) is needed")
        bases = T @ self._T_tool_base
        if largest_tilt is None:
            return bases, self._values.clone()
        tilt = checks.real(largest_tilt, "largest_tilt", least=0.0, most=math.pi)
        upright = bases[:, 2, 2] >= math.cos(tilt) - 1e-12
        return bases[upright], self._values[upright]

    def estimate(
        self, T_world_tool: TensorLike, bases: TensorLike, largest_distance: float, largest_angle: float
    ) -> Float64[Tensor, "b k"]:
        """Look up the index of poses of the tool from bases, without inverse kinematics.

        The value is that of the nearest pose of the map; :func:`dexterity.reach.place` has exact ones.

        Parameters
        ----------
        T_world_tool
            (k, 4, 4) poses of the tool.
        bases
            (b, 4, 4) poses of the base, such as :func:`dexterity.reach.planar_bases` makes.
        largest_distance, largest_angle
            How far [m] and [rad] the nearest pose may be.

        Returns
        -------
        (b, k) index; NaN where the nearest pose is out of reach or too far away.

        Raises
        ------
        ValueError
            If a pose is not rigid, a shape does not fit, or a number is negative.
        """
        T, base = (
            spatial.require_rigid(on_cpu(value, name), name).detach()
            for value, name in ((T_world_tool, "T_world_tool"), (bases, "bases"))
        )
        for value, name in ((T, "T_world_tool"), (base, "bases")):
            if value.ndim != 3:
                raise ValueError(
                    f"{name} has shape {tuple(value.shape)}; (…, 4, 4) with one axis in front is needed"
                )
        near = self._forward.nearest(spatial.inverse(base)[:, None] @ T)
        close = near.distance <= checks.real(largest_distance, "largest_distance", least=0.0)
        close &= near.angle <= checks.real(largest_angle, "largest_angle", least=0.0)
        return torch.where(close, self._forward.best[near.position, near.rotation], math.nan)
