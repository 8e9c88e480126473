"""Bases of a chain compared: which poses it reaches from each, how well, and in which configurations.

Examples
--------
>>> import dexterity as dx
>>> from dexterity import reach
>>> pose = reach.seam([0, 0, 0], [0.1, 0, 0], 2, reach.pointing([0, 0, -1]))
>>> placed = reach.place(dx.robots.ur5e(), pose, [[0.0, -0.5, 0.0], [0.0, -3.0, 0.0]], refine=False)
>>> placed.reached.tolist(), placed.ties, placed.table()[1]["base"]
([2, 0], 1, '1')
"""

from __future__ import annotations

import csv
import io
import math
import os
from dataclasses import dataclass
from typing import Any, NamedTuple

import torch
from jaxtyping import Bool, Float64, Int64
from torch import Tensor

from dexterity import checks, spatial, store
from dexterity.chain import Chain

__all__ = ["Placement", "Placements", "Valued", "coordinates_of", "score"]

_COORDINATES = ("x [m]", "y [m]", "z [m]", "roll [rad]", "pitch [rad]", "yaw [rad]")
_SAME = 1e-9


class Valued(NamedTuple):
    """What bases are worth: index (b, k), configurations (b, k, n), and whether poses are followed (b)."""

    values: Tensor
    q: Tensor
    followed: Tensor


@dataclass(frozen=True, eq=False)
class Placement:
    """A base, and what the chain does from there.

    Attributes
    ----------
    T_world_base
        (4, 4) pose of the chain's world frame.
    coordinates
        (6,) its x, y, z [m] and roll, pitch, yaw [rad].
    score
        Worst or mean index over the poses; NaN where one of them is not reached, or they are not followed.
    values
        (k,) best index at each pose, NaN out of reach.
    configurations
        (k, n) configuration with it, [rad] or [m].
    refined
        Whether the base was improved between the candidates.
    """

    T_world_base: Float64[Tensor, "4 4"]
    coordinates: Float64[Tensor, " 6"]
    score: float
    values: Float64[Tensor, " k"]
    configurations: Float64[Tensor, "k n"]
    refined: bool

    @property
    def largest_step(self) -> float:
        """Largest change of a joint from pose to pose, [rad] or [m]; large where the branch changes."""
        if len(self.configurations) < 2:
            return 0.0
        return float((self.configurations[1:] - self.configurations[:-1]).abs().max())

    def __repr__(self) -> str:
        x, y, z, roll, pitch, yaw = self.coordinates.tolist()
        tilt = f", roll {roll:.4g}, pitch {pitch:.4g}" if max(abs(roll), abs(pitch)) > _SAME else ""
        height = f", z {z:.4g}" if abs(z) > _SAME else ""
        place = f"x {x:.4g}, y {y:.4g}{height}{tilt}, yaw {yaw:.4g}"
        return f"Placement({self.score:.4g} at {place}{', refined' if self.refined else ''})"


@dataclass(frozen=True, eq=False)
class Placements:
    """Bases compared.

    Attributes
    ----------
    chain
        The chain.
    poses
        (k, 4, 4) poses of the tool in the world.
    bases
        (b, 4, 4) candidate poses of the chain's world frame.
    values
        (b, k) best index at each pose, NaN where it is not reached.
    configurations
        (b, k, n) configurations with it.
    examined
        (b,) whether the base was looked at; all unless the search was interrupted.
    by
        What values a base.
    index
        The index, as text.
    larger_is_better
        Whether the best index is the largest.
    complete
        Whether a pose that is not reached is out of reach; after a search for configurations it may not be.
    followed
        (b,) whether the poses can be followed without a jump; the configurations are then those of the path.
        None if that was not asked for.
    refined
        The best base between the candidates; None if none reaches all poses, or it was not asked for.
    """

    chain: Chain
    poses: Float64[Tensor, "k 4 4"]
    bases: Float64[Tensor, "b 4 4"]
    values: Float64[Tensor, "b k"]
    configurations: Float64[Tensor, "b k n"]
    examined: Bool[Tensor, " b"]
    by: str
    index: str | None
    larger_is_better: bool
    complete: bool
    followed: Bool[Tensor, " b"] | None = None
    refined: Placement | None = None

    @property
    def scores(self) -> Float64[Tensor, " b"]:
        """Worst or mean index (b) of each base, NaN where a pose is not reached, or they are not followed."""
        scores = score(self.values, self.by, self.larger_is_better)
        return scores if self.followed is None else torch.where(self.followed, scores, math.nan)

    @property
    def reached(self) -> Int64[Tensor, " b"]:
        """How many of the poses each base reaches (b)."""
        return (~self.values.isnan()).sum(1)

    @property
    def order(self) -> Int64[Tensor, " b"]:
        """Numbers of the bases (b), the best first, then those that do not reach all poses."""
        signed = self.scores if self.larger_is_better else -self.scores
        key = signed.nan_to_num(nan=-math.inf)
        by_score = key.argsort(descending=True, stable=True)
        return by_score[self.reached[by_score].argsort(descending=True, stable=True)]

    @property
    def ties(self) -> int:
        """How many candidates are as good as the best, itself included; 0 if none reaches all poses."""
        scores = self.scores[~self.scores.isnan()]
        if not len(scores):
            return 0
        best = scores.max() if self.larger_is_better else scores.min()
        return int(((scores - best).abs() <= _SAME * (1 + best.abs())).sum())

    @property
    def best(self) -> Placement:
        """Best base, the refined one if there is one, else the best candidate."""
        return self.refined or self.candidate(int(self.order[0]))

    @checks.arguments(number=checks.Whole(0))
    def candidate(self, number: int) -> Placement:
        """Return a candidate by its number from 0."""
        T = self.bases[number]
        return Placement(
            T, coordinates_of(T), float(self.scores[number]), self.values[number],
            self.configurations[number], False,
        )  # fmt: skip

    def __repr__(self) -> str:
        everything = int((self.reached == len(self.poses)).sum())
        best = str(self.best).removeprefix("Placement(").removesuffix(")")
        said = f"best {best}" if everything else f"the best reaches {int(self.reached.max())}"
        if self.followed is not None:
            said = f"{int(self.followed.sum())} follow them; {said}"
        ties = f", {self.ties} are equal" if self.ties > 1 else ""
        return (
            f"Placements({self.chain.name!r}, {len(self.bases)} bases × {len(self.poses)} poses, "
            f"{everything} reach all; {said}{ties})"
        )

    def table(self, count: int | None = None) -> list[dict[str, Any]]:
        """Return rows that compare the bases, the best first, the refined one in front of all.

        Parameters
        ----------
        count
            How many candidates; all by default.
        """
        order = self.order.tolist()
        if count is not None:
            order = order[: checks.whole(count, "count", least=1)]
        rows = [] if self.refined is None else [self._row("refined", self.refined)]
        return rows + [self._row(str(i), self.candidate(i)) for i in order]

    def _row(self, name: str, placement: Placement) -> dict[str, Any]:
        values = placement.values[~placement.values.isnan()]
        return {
            "base": name,
            **dict(zip(_COORDINATES, placement.coordinates.tolist(), strict=True)),
            "poses reached": len(values),
            "worst": _worst(values, self.larger_is_better),
            "mean": float(values.mean()) if len(values) else math.nan,
            "largest joint step": placement.largest_step,
        }

    @checks.arguments(path=checks.path)
    def to_csv(self, path: str | os.PathLike[str]) -> None:
        """Write the table to a file, whole or not at all.

        Raises
        ------
        OSError
            If the file cannot be written.
        """
        rows, text = self.table(), io.StringIO()
        writer = csv.DictWriter(text, fieldnames=list(rows[0]), lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
        store.write_atomically(path, text.getvalue())


def score(values: Tensor, by: str, larger_is_better: bool) -> Tensor:
    """Return the worst or the mean (b) of values (b, k), NaN where one of them is."""
    if by == "mean":
        return values.mean(-1)
    return values.amin(-1) if larger_is_better else values.amax(-1)


def coordinates_of(T_world_base: Tensor) -> Tensor:
    """Return x, y, z [m] and roll, pitch, yaw [rad] (..., 6) of poses (..., 4, 4)."""
    return torch.cat([T_world_base[..., :3, 3], spatial.rpy(T_world_base[..., :3, :3])], -1)


def _worst(values: Tensor, larger_is_better: bool) -> float:
    if not len(values):
        return math.nan
    return float(values.min() if larger_is_better else values.max())
