"""The worst error of an approximation, searched for and not waited for.

Sampling finds a large error only where large errors are common. From the worst of many samples, and from
corners of the space, where approximations are least held in place, a search climbs on the relative error
with the gradients of the approximation and of the index. What it finds is a lower bound of the worst case,
as every sampled maximum is, only a better one.

Examples
--------
>>> import dexterity as dx
>>> from dexterity.networks.worst_case import Search, worst_case
>>> network = dx.networks.load_shipped("uvms-manipulability-feed-forward")
>>> w = dx.indices.Index("manipulability").bind(dx.robots.uvms())
>>> space, few = dx.sampling.uvms_space("manipulability"), Search(256, 16, 8, steps=5)
>>> worst_case(network, w, space, few).error < 0.002
True
"""

from __future__ import annotations

from dataclasses import dataclass

import torch
from jaxtyping import Float64
from torch import Tensor

from dexterity import ascent, checks, sampling, spatial
from dexterity.networks.validation import Function, relative_errors
from dexterity.sampling import DataSet, Space

__all__ = ["Search", "WorstCase", "climb", "worst_case", "worst_points"]


@dataclass(frozen=True)
class Search:
    """How much to search.

    Attributes
    ----------
    samples
        Points of a scrambled Sobol sequence among which starts are chosen.
    corners
        Random corners of the unit cube among which starts are chosen too; all where there are no more.
    starts
        How many of the worst of both to climb from.
    steps
        Steps of the ascent.

    Raises
    ------
    ValueError
        If one is not positive.
    """

    samples: int = 32_768
    corners: int = 2048
    starts: int = 256
    steps: int = 100

    def __post_init__(self) -> None:
        checks.fields(self, **dict.fromkeys(("samples", "corners", "starts", "steps"), checks.Whole(1)))


@dataclass(frozen=True)
class WorstCase:
    """The largest error that was found, relative unless a scale was given.

    Attributes
    ----------
    error
        Its size, never below `sampled`.
    q
        (n,) where it is, [rad] or [m].
    value, exact
        What the approximation and the index say there.
    sampled
        Largest error among the samples and corners, before any step.
    reached
        (starts,) where the climbs ended, worst first: many alike speak for the largest of all.
    evaluations
        How often the error was evaluated, with or without a gradient.
    """

    error: float
    q: tuple[float, ...]
    value: float
    exact: float
    sampled: float
    reached: tuple[float, ...]
    evaluations: int


_searching = checks.arguments(
    f=checks.function,
    index=checks.function,
    space=checks.Instance(Space),
    search=checks.Instance(Search),
    scale=checks.OrNone(checks.positive),
)


@_searching
def worst_case(
    f: Function,
    index: Function,
    space: Space,
    search: Search = Search(),
    seed: int = 0,
    scale: float | None = None,
) -> WorstCase:
    """Search a space for the largest relative error of an approximation.

    Parameters
    ----------
    f, index
        The approximation, and what it should be; torch must be able to differentiate both once.
    space
        Where to search. Nothing outside it is evaluated.
    search
        How much to search.
    seed
        Of the samples and corners.
    scale
        What errors are divided by; the values of the index if none is given.

    Raises
    ------
    ValueError
        If nothing varies in the space, torch cannot differentiate `f`, the index is zero somewhere, or
        what either function returns is not finite or not one value for each configuration.
    """
    u, looked_at = _starts(f, index, space, search, seed, scale)
    climbed = climb(f, index, space, u, search.steps, scale)
    ends = space.from_unit(torch.cat([u[:1], climbed]))
    data = DataSet.of(index, ends, "index")
    errors = relative_errors(f, data, scale).abs()
    best = int(errors.argmax())
    with torch.no_grad():
        value = f(ends[best : best + 1])
    return WorstCase(
        error=float(errors[best]),
        q=tuple(ends[best].tolist()),
        value=float(value),
        exact=float(data.values[best]),
        sampled=float(errors[0]),
        reached=tuple(errors[1:].sort(descending=True).values.tolist()),
        evaluations=looked_at + len(u) * (search.steps + 1),
    )


@_searching
def worst_points(
    f: Function,
    index: Function,
    space: Space,
    search: Search = Search(),
    seed: int = 0,
    scale: float | None = None,
) -> DataSet:
    """Return where the climbs of :func:`worst_case` end, to train on or to look at.

    Its parameters and errors are those of :func:`worst_case`.

    Returns
    -------
    At most `search.starts` configurations with the values of the index; climbs may end in one place.
    """
    u, _ = _starts(f, index, space, search, seed, scale)
    return DataSet.of(index, space.from_unit(climb(f, index, space, u, search.steps, scale)), "index")


@checks.arguments(
    f=checks.function,
    index=checks.function,
    space=checks.Instance(Space),
    steps=checks.Whole(0),
    scale=checks.OrNone(checks.positive),
)
def climb(
    f: Function,
    index: Function,
    space: Space,
    u: Float64[Tensor, "B m"],
    steps: int,
    scale: float | None = None,
) -> Float64[Tensor, "B m"]:
    """Climb on the size of the error from points of the unit cube, all at once; see :mod:`dexterity.ascent`.

    Parameters
    ----------
    f, index, space, scale
        See :func:`worst_case`.
    u
        (B, m) starts.
    steps
        Number of steps.

    Returns
    -------
    (B, m) the worst point on the way from each start, the start included.

    Raises
    ------
    ValueError
        See :func:`worst_case`.
    """
    u = spatial.to_float64(u, "u")
    if u.shape[1:] != (space.dimensions,):
        raise ValueError(f"u has shape {tuple(u.shape)}; (B, {space.dimensions}) is needed")
    best, _ = ascent.climb(lambda u: _height_and_slope(f, index, space, u, scale), u, steps)
    return best


# ---- private ---------------------------------------------------------------------------------------


def _starts(
    f: Function, index: Function, space: Space, search: Search, seed: int, scale: float | None
) -> tuple[Tensor, int]:
    """Points of the unit cube with the largest errors, largest first, and how many were looked at."""
    u = torch.cat([_samples(space, search, seed), ascent.corners(space.dimensions, search.corners, seed)])
    errors = relative_errors(f, DataSet.of(index, space.from_unit(u), "index"), scale).abs()
    return u[errors.argsort(descending=True, stable=True)[: search.starts]], len(u)


def _samples(space: Space, search: Search, seed: int) -> Tensor:
    # The way back from the space may leave the cube by a rounding error.
    return space.to_unit(sampling.sobol(space, search.samples, seed)).clamp(0, 1)


def _height_and_slope(
    f: Function, index: Function, space: Space, u: Tensor, scale: float | None
) -> tuple[Tensor, Tensor]:
    """Sizes of errors (B) and how they rise with the coordinates (B, m)."""

    def height_at(u: Tensor) -> Tensor:
        q = space.from_unit(u)
        value, exact = f(q), index(q)
        if not value.requires_grad:
            raise ValueError("f cannot be differentiated by torch, so nothing can climb on its error")
        return (value / exact - 1).abs() if scale is None else ((value - exact) / scale).abs()

    height, slope = spatial.value_and_gradient(height_at, u)
    # At a kink there may be no slope; what climbs stays there until a coordinate with one leads it away.
    return spatial.to_float64(height, "f(q) / index(q)"), slope.nan_to_num(nan=0.0)
