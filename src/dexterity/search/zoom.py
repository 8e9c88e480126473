"""Global search without luck: a grid over the whole box, then finer and finer ones about its best points.

Neither gradients nor smoothness are asked for, only that the objective is cheap. It finds what the first grid
does not miss, so the answer is to be checked by a finer one.

Examples
--------
>>> from dexterity.search import ZoomOptions, zoom_search
>>> objective = lambda x: -((x - 0.3) ** 2).sum(-1)
>>> found = zoom_search(objective, [0, 0], [1, 1], [0.25, 0.25], ZoomOptions(stages=60))
>>> [round(x, 2) for x in found.point.tolist()]
[0.3, 0.3]
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import torch
from jaxtyping import Float64
from torch import Tensor

from dexterity.search import box
from dexterity.search.box import Objective
from dexterity.spatial import TensorLike

__all__ = ["ZoomOptions", "ZoomSearch", "zoom_search"]

_AT_ONCE = 2**17
_CANDIDATES = 100


@dataclass(frozen=True)
class ZoomOptions:
    """How fine to look.

    Attributes
    ----------
    starts
        Points of the first grid that are zoomed in on, no two of them neighbours.
    levels
        Values of each variable in a finer grid, odd, so that its middle is the point it is about.
    shrink
        Width of a grid relative to the one before, where that has shown nothing better.
    stages
        How many grids are laid about each start, one after the other.

    Raises
    ------
    ValueError
        If a number is out of its range.
    """

    starts: int = 8
    levels: int = 5
    shrink: float = 0.9
    stages: int = 300

    def __post_init__(self) -> None:
        if self.starts < 1 or self.stages < 0:
            raise ValueError(f"starts is {self.starts} and stages {self.stages}; at least 1 and 0 are needed")
        if self.levels < 3 or self.levels % 2 == 0:
            raise ValueError(f"levels is {self.levels}; an odd number of at least 3 is needed")
        if not 0 < self.shrink < 1:
            raise ValueError(f"shrink is {self.shrink}; a number between 0 and 1 is needed")


@dataclass(frozen=True)
class ZoomSearch:
    """The best point, and where else the search ended.

    Attributes
    ----------
    point
        (d,) point with the largest value.
    value
        That value.
    evaluations
        How many points the objective was asked for.
    ends
        (starts, d) where each start led to, the best first.
    values
        (starts) values there.
    """

    point: Float64[Tensor, " d"]
    value: float
    evaluations: int
    ends: Float64[Tensor, "starts d"] = field(repr=False)
    values: Float64[Tensor, " starts"] = field(repr=False)


def zoom_search(
    objective: Objective,
    lower: TensorLike,
    upper: TensorLike,
    steps: TensorLike,
    options: ZoomOptions = ZoomOptions(),
) -> ZoomSearch:
    """Search a box for the point with the largest value.

    Parameters
    ----------
    objective
        Values (N) of points (N, d), larger is better.
    lower, upper
        (d,) limits of the box.
    steps
        (d,) largest distance between neighbours of the first grid, positive.
    options
        How fine to look.

    Raises
    ------
    ValueError
        If the limits or the steps do not fit, or the objective answers with NaN or another shape.
    """
    low, high = box.limits(lower, upper)
    wanted = box.steps(steps, "steps", len(low))
    counts = [math.ceil(n - 1e-9) + 1 for n in ((high - low) / wanted).tolist()]
    values = _on_grid(objective, low, high, counts)
    starts = _apart(values, counts, options.starts)
    points, best = _grid_points(starts, low, high, counts), values[starts]
    spacing = (high - low) / (torch.tensor(counts) - 1).clamp(min=1)
    evaluations = math.prod(counts)
    offsets = torch.cartesian_prod(*[torch.linspace(-1, 1, options.levels, dtype=torch.float64)] * len(low))
    offsets = offsets.reshape(-1, len(low))
    width = torch.ones(len(points), 1, 1, dtype=torch.float64)
    turns = torch.Generator().manual_seed(0)
    for stage in range(options.stages):
        # A crest that runs between the axes is not seen along them, so every other grid is turned.
        turned = offsets @ _random_rotation(len(low), turns) if stage % 2 else offsets
        around = points[:, None] + width * spacing * turned
        around = torch.minimum(torch.maximum(around, low), high)
        seen = box.evaluated(objective, around.flatten(0, 1)).view(len(points), -1)
        evaluations += seen.numel()
        found, at = seen.max(dim=1)
        better = found > best
        best = torch.where(better, found, best)
        points = torch.where(better[:, None], around[torch.arange(len(points)), at], points)
        width = torch.where(better[:, None, None], width, options.shrink * width)
    order = best.argsort(descending=True)
    return ZoomSearch(points[order[0]], best[order[0]].item(), evaluations, points[order], best[order])


def _random_rotation(size: int, generator: torch.Generator) -> Tensor:
    return torch.linalg.qr(torch.randn(size, size, generator=generator, dtype=torch.float64)).Q


def _on_grid(objective: Objective, low: Tensor, high: Tensor, counts: list[int]) -> Tensor:
    """Values of all points of a grid, the last variable fastest."""
    numbers = torch.arange(math.prod(counts)).split(_AT_ONCE)
    return torch.cat([box.evaluated(objective, _grid_points(some, low, high, counts)) for some in numbers])


def _grid_points(numbers: Tensor, low: Tensor, high: Tensor, counts: list[int]) -> Tensor:
    """Points (N, d) of a grid by their numbers (N)."""
    shares = _places(numbers, counts) / (torch.tensor(counts, dtype=torch.float64) - 1).clamp(min=1)
    return low + (high - low) * shares


def _places(numbers: Tensor, counts: list[int]) -> Tensor:
    """Where in the grid (N, d) points are, by their numbers (N)."""
    return torch.stack(torch.unravel_index(numbers, counts), dim=1)


def _apart(values: Tensor, counts: list[int], starts: int) -> Tensor:
    """Numbers of the best points of a grid, leaving out neighbours of those that are taken."""
    candidates = values.topk(min(len(values), _CANDIDATES * starts)).indices
    places = _places(candidates, counts)
    taken: list[int] = []
    for i in range(len(candidates)):
        if len(taken) == starts:
            break
        if not taken or ((places[taken] - places[i]).abs().amax(1) > 1).all():
            taken.append(i)
    return candidates[taken]
