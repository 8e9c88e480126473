"""The best base between candidates, by a search that needs no gradient.

Around the best base so far others are tried, along random directions of the coordinates that differ between
the candidates; when none is better, they come closer. The worst index over a list of poses has edges, on
which fixed directions would stop.

Examples
--------
>>> import dexterity as dx
>>> from dexterity import reach
>>> seam = reach.seam([-0.1, 0, 0], [0.1, 0, 0], 3, reach.pointing([0, 0, -1]))
>>> placed = reach.place(dx.robots.puma560(), seam, [[0.0, -0.4, 0.0], [0.0, -0.6, 0.0]], "w")
>>> placed.refined.score >= max(placed.scores.tolist()), placed.refined.coordinates[0].item()
(True, 0.0)
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from typing import TypeAlias

import torch
from torch import Tensor

from dexterity import spatial
from dexterity.reach.placements import Placement, Placements, Valued, coordinates_of, score

__all__ = ["refined"]

Values: TypeAlias = Callable[[Tensor, Tensor], Valued]
"""Takes bases (b, 4, 4) and configurations (k, n) at a base near by, and values them."""

_SHRINK = 0.5
_FINEST = 1e-3  # of the first step, where the search ends
_MOST = 60
_EXTRA = 2


def refined(placed: Placements, value: Values, seed: int) -> Placements:
    """Return placements with the best base improved, within the range of the candidates.

    Parameters
    ----------
    placed
        Candidates of which at least one reaches all poses.
    value
        Values bases.
    seed
        Of the directions that are tried.
    """
    coordinates = coordinates_of(placed.bases)
    low, high = coordinates.amin(0), coordinates.amax(0)
    free = (high - low > 1e-9).nonzero()[:, 0]
    if not len(free):
        return placed
    best = placed.candidate(int(placed.order[0]))
    step = _gaps(coordinates[:, free])
    generator, width = torch.Generator().manual_seed(seed), 1.0
    for _ in range(_MOST):
        if width < _FINEST:
            break
        around = best.coordinates.repeat(2 * (len(free) + _EXTRA), 1)
        around[:, free] += width * step * _directions(len(free), generator)
        around = torch.minimum(torch.maximum(around, low), high)
        tried = _best_of(around, best.configurations, value, placed)
        if _is_better(tried.score, best.score, placed.larger_is_better):
            best = tried
        else:
            width *= _SHRINK
    return dataclasses.replace(placed, refined=dataclasses.replace(best, refined=True))


def _gaps(coordinates: Tensor) -> Tensor:
    """Mean distances (d) between neighbouring values of each coordinate of candidates (b, d)."""
    gaps = []
    for values in coordinates.unbind(1):
        different = 1 + int((values.sort().values.diff() > 1e-9).sum())
        gaps.append((values.max() - values.min()) / (different - 1))
    return torch.stack(gaps)


def _directions(size: int, generator: torch.Generator) -> Tensor:
    """Random orthogonal directions both ways, and some more (2 (d + extra), d), none longer than 1."""
    square = torch.linalg.qr(torch.randn(size, size, generator=generator, dtype=torch.float64)).Q
    more = torch.randn(_EXTRA, size, generator=generator, dtype=torch.float64)
    directions = torch.cat([square, more / more.norm(dim=1, keepdim=True)])
    return torch.cat([directions, -directions])


def _best_of(coordinates: Tensor, near: Tensor, value: Values, placed: Placements) -> Placement:
    bases = spatial.from_rpy(coordinates[:, 3:], coordinates[:, :3])
    values, q, followed = value(bases, near)
    scores = torch.where(followed, score(values, placed.by, placed.larger_is_better), math.nan)
    at = int((scores if placed.larger_is_better else -scores).nan_to_num(nan=-math.inf).argmax())
    return Placement(bases[at], coordinates[at], float(scores[at]), values[at], q[at], True)


def _is_better(new: float, old: float, larger_is_better: bool) -> bool:
    return not math.isnan(new) and (new > old if larger_is_better else new < old)
