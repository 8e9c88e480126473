"""Lowest and highest value of an index over a space of configurations, by ascent from many starts.

Starts are the best of a Sobol sequence and of the corners of the space. What is found are bounds from
inside: no value below the lowest or above the highest was met, and the more starts end at one value, the
more it is likely to be the extreme. No grid is laid, so that twelve joints cost little more than three.

Examples
--------
>>> import dexterity as dx
>>> panda = dx.robots.load("panda")
>>> w = dx.indices.Index("manipulability")
>>> found = dx.search.extremes(w, panda, samples=512, starts=8, steps=30)
>>> found.lowest.value < 0.01 < found.highest.value
True
>>> len(found.highest.q), len(found.highest.reached)
(7, 8)
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import torch
from torch import Tensor

from dexterity import checks, sampling, spatial
from dexterity.ascent import climb, corners
from dexterity.chain import Chain
from dexterity.indices import Index
from dexterity.sampling import Box, Space
from dexterity.spatial import TensorLike

__all__ = ["Extreme", "Extremes", "extremes"]

_AT_ONCE = 2**16
_CORNERS = 1024


@dataclass(frozen=True)
class Extreme:
    """The lowest or the highest value that was found.

    Attributes
    ----------
    value
        The value; infinite where the function is.
    q
        (n,) where it is, [rad] or [m].
    sampled
        The best value among the samples and corners, before any step.
    reached
        (starts,) values at which the ascents ended, the best first: many alike speak for the extreme of all.
    """

    value: float
    q: tuple[float, ...]
    sampled: float
    reached: tuple[float, ...] = field(repr=False)


@dataclass(frozen=True)
class Extremes:
    """Lowest and highest value over a space, and how often the function was evaluated."""

    lowest: Extreme
    highest: Extreme
    evaluations: int


def extremes(
    f: Callable[[Tensor], Tensor] | Index,
    space: Space | Chain,
    *,
    samples: int = 8192,
    starts: int = 32,
    steps: int = 100,
    seed: int = 0,
) -> Extremes:
    """Search a space for the lowest and the highest value of an index.

    Parameters
    ----------
    f
        An index, bound or compiled, or any function of joint values (..., n) → (...) that torch can
        differentiate; or an index as it is, where `space` is a chain.
    space
        Where to search: a :class:`dexterity.sampling.Box` or another space, or a chain with limits at all its
        joints.
    samples
        Points of a scrambled Sobol sequence among which starts are chosen, besides corners of the space.
    starts
        From how many of the best to climb, for each of both extremes.
    steps
        Steps of each ascent.
    seed
        Of the sequence and of the corners.

    Raises
    ------
    ValueError
        If a number is not positive, or above 10⁶ (samples: 10⁹), nothing varies in the space, a joint of the
        chain is unlimited, or the function is NaN somewhere, gives another shape, or cannot be
        differentiated.
    TypeError
        If an argument is of another kind.
    """
    samples = checks.whole(samples, "samples", least=1, most=10**9)
    starts = checks.whole(starts, "starts", least=1, most=10**6)
    steps = checks.whole(steps, "steps", least=1, most=10**6)
    seed = checks.seed(seed)
    function, where = _function(f, space), Box.from_chain(space) if isinstance(space, Chain) else space
    if not isinstance(where, Space):
        raise TypeError(f"space is {where!r}; a chain or a space such as dexterity.sampling.Box is needed")
    u = where.to_unit(sampling.sobol(where, samples, seed)).clamp(0, 1)
    with u.device:
        u = torch.cat([u, corners(where.dimensions, _CORNERS, seed)])
    values = torch.cat([_values(function, where.from_unit(some)) for some in u.split(_AT_ONCE)])
    lowest, highest = (_climbed(function, where, u, values, sign, starts, steps) for sign in (-1.0, 1.0))
    return Extremes(lowest, highest, len(u) + 2 * min(starts, len(u)) * (steps + 1))


def _function(f: Callable[[Tensor], Tensor] | Index, space: Space | Chain) -> Callable[[Tensor], Tensor]:
    if isinstance(f, str):
        raise TypeError(f"f is {f!r}; an index is needed, such as dexterity.Index({f!r}, 'geometric')")
    if not isinstance(f, Index):
        return checks.function(f, "f")
    if not isinstance(space, Chain):
        raise TypeError(f"f is {f!r}, which needs a chain; give f.bind(chain), or a chain as space")
    return f.bind(space)


def _climbed(
    f: Callable[[Tensor], Tensor],
    space: Space,
    u: Tensor,
    values: Tensor,
    sign: float,
    starts: int,
    steps: int,
) -> Extreme:
    """Climb on `sign` times a function from the best of points (N, m) of the unit cube."""
    order = (sign * values).argsort(descending=True, stable=True)[:starts]

    def height_and_slope(u: Tensor) -> tuple[Tensor, Tensor]:
        value, slope = _value_and_slope(f, space, u)
        return sign * value, sign * slope

    tops, heights = climb(height_and_slope, u[order], steps)
    best = int(heights.argmax())
    reached = heights.sort(descending=True).values
    return Extreme(
        value=sign * float(heights[best]),
        q=tuple(space.from_unit(tops[best]).tolist()),
        sampled=float(values[order[0]]),
        reached=tuple((sign * reached).tolist()),
    )


def _value_and_slope(f: Callable[[Tensor], Tensor], space: Space, u: Tensor) -> tuple[Tensor, Tensor]:
    """Values (B) of a function, and how they rise with the coordinates of the unit cube (B, m)."""
    own: Any = getattr(f, "value_and_gradient", None)
    if own is None:
        value, slope = spatial.value_and_gradient(lambda u: f(space.from_unit(u)), u)
    else:
        with spatial.differentiation():
            u = u.detach().clone().requires_grad_()
            q = space.from_unit(u)
            value, gradient = own(q.detach())
            (slope,) = torch.autograd.grad(q, u, gradient)
    # At a kink or where the value is infinite there may be no slope: what climbs stays there.
    slope = slope.nan_to_num(nan=0.0, posinf=1.0, neginf=-1.0)
    return spatial.to_extended_float64(value.detach(), "f(q)"), slope


def _values(f: Callable[[Tensor], Tensor], q: Tensor) -> Tensor:
    with torch.no_grad():
        values: TensorLike = f(q)
    checked = spatial.to_extended_float64(values, "f(q)")
    if checked.shape != q.shape[:1]:
        raise ValueError(f"f(q) has shape {tuple(checked.shape)}; ({len(q)},) is needed, one for each q")
    return checked
