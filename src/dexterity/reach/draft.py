"""A reach map in the making: arrays that a survey fills pose by pose.

Examples
--------
>>> import torch
>>> import dexterity as dx
>>> from dexterity.reach.draft import Draft
>>> draft = Draft(dx.robots.puma560(), torch.zeros(2, 3).double(), torch.eye(3).double()[None])
>>> draft.reached.shape, draft.examined.any().item()
(torch.Size([2, 1]), False)
"""

from __future__ import annotations

import math

import torch
from torch import Tensor

from dexterity import spatial
from dexterity.chain import Chain
from dexterity.descent import TwistRows
from dexterity.reach.configurations import Found, different
from dexterity.reach.judgement import Judge
from dexterity.reach.missed import Missed
from dexterity.reach.reach_map import ReachMap

__all__ = ["Draft"]


class Draft:
    """Arrays of a :class:`~dexterity.reach.reach_map.ReachMap`, empty or those of an unfinished one."""

    def __init__(
        self, chain: Chain, positions: Tensor, rotations: Tensor, unfinished: ReachMap | None = None
    ) -> None:
        self.chain, self.positions, self.rotations = chain, positions, rotations
        shape = (len(positions), len(rotations))
        if unfinished is None:
            self.reached, self.examined = (torch.zeros(shape, dtype=torch.bool) for _ in range(2))
            self.count, self.hits = (torch.zeros(shape, dtype=torch.int64) for _ in range(2))
            self.best = torch.full(shape, math.nan, dtype=torch.float64)
            self.configurations = torch.full((*shape, chain.joints), math.nan, dtype=torch.float64)
        else:
            for name in ("reached", "examined", "count", "hits", "best", "configurations"):
                setattr(self, name, getattr(unfinished, name).clone())

    def poses(self, at: Tensor) -> Tensor:
        """Return poses (k, 4, 4) by their numbers (k), the rotation fastest."""
        position, rotation = self._places(at)
        return spatial.pose(self.rotations[rotation], self.positions[position])

    def _places(self, at: Tensor) -> tuple[Tensor, Tensor]:
        rotations = len(self.rotations)
        return torch.div(at, rotations, rounding_mode="floor"), at % rotations

    def record(self, at: Tensor, found: Found, judge: Judge, *, independent: bool = True) -> int:
        """Write what was found at poses by their numbers (k), and return how many are new.

        Parameters
        ----------
        at
            (k,) numbers of poses none of which is in reach so far.
        found
            Their configurations.
        judge
            Chooses the best.
        independent
            Whether the starts were drawn independently, and so count as hits.
        """
        place = self._places(at)
        best, q = judge.best(found)
        reached = found.allowed.any(-1)
        self.examined[place] = True
        self.reached[place] = reached
        self.count[place] = different(self.chain, found).sum(-1)
        self.best[place], self.configurations[place] = best, q
        if independent:
            self.hits[place] = found.allowed.sum(-1)
        return int(reached.sum())

    def finished(
        self, judge: Judge, method: str, rows: TwistRows, missed: Missed,
        cell: tuple[float, float] = (0.0, 0.0),
    ) -> ReachMap:  # fmt: skip
        """Return the map."""
        return ReachMap(
            self.chain, self.positions, self.rotations, self.reached, self.examined, self.count, self.hits,
            self.best, self.configurations, method, rows.numbers, rows.frame, cell, judge.label,
            judge.larger_is_better, missed,
        )  # fmt: skip
