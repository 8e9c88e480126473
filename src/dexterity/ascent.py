"""Ascent of many points of the unit cube at once, by the signs of slopes.

Every coordinate has a step of its own, which grows while the slope keeps its sign and shrinks when it
changes; a point that would leave the cube stays on its face. Only signs of slopes count, so kinks and
heights of any size are no trouble.

Examples
--------
>>> import torch
>>> from dexterity.ascent import climb, corners
>>> hill = lambda u: (-((u - 0.3) ** 2).sum(1), -2 * (u - 0.3))
>>> tops, heights = climb(hill, torch.tensor([[0.9, 0.1]], dtype=torch.float64), steps=60)
>>> [round(x, 3) for x in tops[0].tolist()]
[0.3, 0.3]
>>> corners(2, most=10, seed=0).tolist()
[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]]

References
----------
Riedmiller & Braun (1993), A direct adaptive method for faster backpropagation learning: the RPROP algorithm;
Igel & Hüsken (2000) for the forgotten slope after a change of sign.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

import torch
from jaxtyping import Float64
from torch import Tensor

__all__ = ["HeightAndSlope", "climb", "corners"]

HeightAndSlope: TypeAlias = Callable[[Tensor], tuple[Tensor, Tensor]]
"""Heights (B) at points (B, m) of the unit cube, and how they rise with the coordinates (B, m)."""

_FIRST_STEP, _LARGEST_STEP = 0.02, 0.25


def climb(
    height_and_slope: HeightAndSlope, u: Float64[Tensor, "B m"], steps: int
) -> tuple[Float64[Tensor, "B m"], Float64[Tensor, " B"]]:
    """Climb from points of the unit cube, all at once.

    Parameters
    ----------
    height_and_slope
        What is climbed. A slope of zero lets a coordinate stay.
    u
        (B, m) starts.
    steps
        Number of steps.

    Returns
    -------
    The highest point (B, m) on the way from each start, the start included, and its height (B).
    """
    length = torch.full_like(u, _FIRST_STEP)
    before = torch.zeros_like(u)
    best, highest = u, torch.full_like(u[:, 0], -torch.inf)
    for _ in range(steps + 1):
        height, slope = height_and_slope(u)
        higher = height > highest
        best, highest = torch.where(higher[:, None], u, best), torch.where(higher, height, highest)
        agreement = slope * before
        length = torch.where(agreement > 0, 1.2 * length, torch.where(agreement < 0, 0.5 * length, length))
        length = length.clamp(max=_LARGEST_STEP)
        before = torch.where(agreement < 0, 0.0, slope)
        u = (u + length * before.sign()).clamp(0, 1)
    return best, highest


def corners(m: int, most: int, seed: int) -> Float64[Tensor, "corners m"]:
    """Return all corners of the unit cube, or random ones where there are more than `most`."""
    if 2**m <= most:
        chosen = (torch.arange(2**m)[:, None] >> torch.arange(m)) & 1
    else:
        chosen = torch.randint(2, (most, m), generator=torch.Generator().manual_seed(seed))
    return chosen.to(torch.float64)
