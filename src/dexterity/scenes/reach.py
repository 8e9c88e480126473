"""Scenes of reach maps and of base placements.

Examples
--------
>>> import dexterity as dx
>>> from dexterity import reach
>>> puma = dx.robots.puma560()
>>> grid = reach.box([0.2, -0.4, -0.4], [0.6, 0.4, 0.4], spacing=0.2)
>>> surveyed = reach.survey(puma, grid, reach.rotations(24), index="w")
>>> dx.scenes.reach.map_scene(surveyed)
Scene('Reach of puma560: share of 24 rotations at each position')
"""

from __future__ import annotations

import numpy as np
import torch
from torch import Tensor

from dexterity.reach.placements import Placements
from dexterity.reach.reach_map import ReachMap
from dexterity.scenes.scene import Scene

__all__ = ["map_scene", "placement_scene"]

_SHARES = (
    (0.0, 0.25, "vermillion"), (0.25, 0.5, "orange"), (0.5, 0.75, "sky blue"), (0.75, 1.0, "blue"),
)  # fmt: skip


def map_scene(reach_map: ReachMap, *, height: int = 420) -> Scene:
    """Return a scene of the positions that a map reaches, coloured by the share of rotations, with the chain.

    Parameters
    ----------
    reach_map
        The map, or a slice of it.
    height
        Height on the page [CSS pixels].

    Raises
    ------
    ValueError
        If the map reaches nothing.
    """
    share = reach_map.share
    if not (share > 0).any():
        raise ValueError(f"reach_map is {reach_map!r}; a map that reaches something is needed")
    turns = len(reach_map.rotations)
    title = f"Reach of {reach_map.chain.name}: share of {turns} rotations at each position"
    scene = Scene(title, height=height)
    at = int(reach_map.best_at_position.nan_to_num(nan=-np.inf).argmax())
    best = reach_map.best[at].nan_to_num(nan=-np.inf).argmax()
    scene.add_chain(reach_map.chain, reach_map.configurations[at, best], axes=False)
    size = _size(reach_map.positions)
    for low, high, color in _SHARES:
        chosen = (share > low) & (share <= high)
        if chosen.any():
            name = f"{100 * low:.0f} to {100 * high:.0f} % of the rotations"
            scene.add_points(reach_map.positions[chosen], name=name, size=size, color=color)
    return scene


def _size(positions: Tensor) -> float:
    """Side of a square [m]: a part of the distance of neighbours, of which there are few along each axis."""
    extent = float((positions.amax(0) - positions.amin(0)).max())
    return max(0.01, 0.25 * extent / max(1.0, len(positions) ** (1 / 3)))


def placement_scene(placements: Placements, *, height: int = 420) -> Scene:
    """Return a scene of the best base, the chain at each pose in turn, all candidates, and the poses.

    Parameters
    ----------
    placements
        Bases compared.
    height
        Height on the page [CSS pixels].

    Raises
    ------
    ValueError
        If no base reaches all poses.
    """
    best = placements.best
    if not placements.ties:
        raise ValueError(f"placements is {placements!r}; a base that reaches all poses is needed")
    scene = Scene(f"Best base of {placements.chain.name} for {len(placements.poses)} poses", height=height)
    arm = placements.chain.with_base(best.T_world_base)
    scene.add_chain(arm, best.configurations[0], axes=False)
    everything = placements.reached == len(placements.poses)
    for chosen, name, color in (
        (everything, "bases that reach all poses", "bluish green"),
        (~everything, "bases that do not", "vermillion"),
    ):
        if chosen.any():
            scene.add_points(placements.bases[chosen, :3, 3], name=name, size=0.03, color=color)
    scene.add_points(placements.poses[:, :3, 3], name="poses of the tool", size=0.02, color="blue")
    if len(placements.poses) > 1:
        share = torch.linspace(0, len(placements.poses) - 1, 24 * len(placements.poses), dtype=torch.float64)
        scene.animate(arm.name, _along(best.configurations, share))
    return scene


def _along(q: Tensor, places: Tensor) -> Tensor:
    """Joint values (m, n) between those of poses (k, n), linear in their number."""
    first = places.floor().long().clamp(max=len(q) - 2)
    return torch.lerp(q[first], q[first + 1], (places - first)[:, None])
