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

from dexterity import checks
from dexterity.checks import Real, Whole
from dexterity.search import box
from dexterity.search.box import Objective
from dexterity.spatial import TensorLike

__all__ = ["ZoomOptions", "ZoomSearch", "zoom_search"]

_AT_ONCE = 2**17
_CANDIDATES = 100
_MOST_POINTS = 10**8  # of a grid, whose values then take 0.8 GB


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
    ValueError, TypeError
        If a number is out of its range, or no number.
    """

    starts: int = 8
    levels: int = 5
    shrink: float = 0.9
    stages: int = 300

    def __post_init__(self) -> None:
        checks.fields(
            self,
            starts=Whole(1, 10_000),
            levels=Whole(3, odd=True),
            shrink=Real(above=0, below=1),
            stages=Whole(0),
        )


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
        If the limits or the steps do not fit, a grid would have more than 10⁸ points, or the objective
        answers with NaN or another shape.
    TypeError
        If the objective is no function or does not answer with numbers, or the options are of another kind.
    """
    checks.function(objective, "objective")
    checks.instance(options, "options", ZoomOptions)
    low, high = box.limits(lower, upper)
    counts = grid_counts(low, high, box.steps(steps, "steps", len(low)))
    if options.levels ** len(low) * options.starts > _MOST_POINTS:
        raise ValueError(
            f"levels is {options.levels} and starts {options.starts}, which make more than {_MOST_POINTS:,} "
            f"points at a time in {len(low)} variables; fewer are needed"
        )
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


def grid_counts(low: Tensor, high: Tensor, steps: Tensor) -> list[int]:
    """Numbers of values of each variable in the first grid."""
    lengths = ((high - low) / steps).tolist()
    points = math.prod(length + 1 for length in lengths)
    if not points <= _MOST_POINTS:
        raise ValueError(
            f"steps is {steps.tolist()}, which makes a grid of {points:.3g} points; "
            f"at most {_MOST_POINTS:,} are searched: take longer steps"
        )
    return [math.ceil(length - 1e-9) + 1 for length in lengths]


def _random_rotation(size: int, generator: torch.Generator) -> Tensor:
    return torch.linalg.qr(torch.randn(size, size, generator=generator, dtype=torch.float64)).Q


def _on_grid(objective: Objective, low: Tensor, high: Tensor, counts: list[int]) -> Tensor:
    """Values of all points of a grid, the last variable fastest."""
    count = math.prod(counts)
    pieces = (torch.arange(i, min(i + _AT_ONCE, count)) for i in range(0, count, _AT_ONCE))
    return torch.cat([box.evaluated(objective, _grid_points(some, low, high, counts)) for some in pieces])


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
