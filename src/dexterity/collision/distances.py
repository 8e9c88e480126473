"""Distances of lines and boxes in closed form, for any batch, which torch can differentiate.

The closest points are found first, and the distance of these points is differentiated with the points held
on their lines. That is the exact first derivative wherever there is one.

References
----------
Ericson (2005), Real-time collision detection, chapters 4 and 5.

Examples
--------
>>> import torch
>>> from dexterity.collision.distances import segment_box
>>> start, along = torch.tensor([[2.0, 0, 0], [2.0, 2, 0]]).double()
>>> half = torch.tensor([1.0, 1.0, 1.0]).double()
>>> [float(segment_box(start, direction, half)) for direction in (along - start, -start)]
[1.0, -1.0]
"""

from __future__ import annotations

import itertools

import torch
from jaxtyping import Float64
from torch import Tensor

__all__ = ["box_box", "segment_box", "segment_segment"]

PARALLEL = 1e-16
"""Square of the sine of an angle below which two edges count as parallel."""


def segment_segment(
    p: Float64[Tensor, "*batch 3"],
    d: Float64[Tensor, "*batch 3"],
    q: Float64[Tensor, "*batch 3"],
    e: Float64[Tensor, "*batch 3"],
) -> Float64[Tensor, "*batch"]:
    """Distance of two lines from p to p + d and from q to q + e [m], one of which may be a point.

    It is the smallest of the distances of both ends of one line from the other line, and of the two points in
    which the common perpendicular meets the lines.
    """
    r = p - q
    with torch.no_grad():
        s, t = _closest(r, d, e)
    return (r + s[..., None] * d - t[..., None] * e).norm(dim=-1)


def _closest(r: Tensor, d: Tensor, e: Tensor) -> tuple[Tensor, Tensor]:
    """Where on two lines (from 0 to 1) the points are that are nearest to each other."""
    a, b, c = _dot(d, d), _dot(d, e), _dot(e, e)
    f, g = _dot(d, r), _dot(e, r)
    per_a, per_c = 1 / torch.where(a > 0, a, 1.0), 1 / torch.where(c > 0, c, 1.0)
    squares = a * c - b * b
    s = ((b * g - c * f) / torch.where(squares > 0, squares, 1.0)).clamp(0, 1)
    t = ((g + b * s) * per_c).clamp(0, 1)
    s = ((b * t - f) * per_a).clamp(0, 1)
    zero, one = torch.zeros_like(a), torch.ones_like(a)
    firsts = torch.stack([s, zero, one, (-f * per_a).clamp(0, 1), ((b - f) * per_a).clamp(0, 1)])
    seconds = torch.stack([t, (g * per_c).clamp(0, 1), ((g + b) * per_c).clamp(0, 1), zero, one])
    between = r + firsts[..., None] * d - seconds[..., None] * e
    best = _dot(between, between).argmin(0, keepdim=True)
    return firsts.gather(0, best)[0], seconds.gather(0, best)[0]


def _dot(a: Tensor, b: Tensor) -> Tensor:
    return (a * b).sum(-1)


def segment_box(
    p: Float64[Tensor, "*batch 3"], d: Float64[Tensor, "*batch 3"], half: Float64[Tensor, "*batch 3"]
) -> Float64[Tensor, "*batch"]:
    """Signed distance of a line from p to p + d from a box about the origin, edges along the axes [m].

    The square of the distance is convex along the line, and quadratic between the points at which the line
    passes a plane of the box: its minimum is exact. Of a line that meets the box it is the depth, below
    zero: the shortest move that brings the line out of the box.

    Parameters
    ----------
    p, d
        (..., 3) start of the line and the way from there to its end [m]; a way of 0 makes it a point.
    half
        (..., 3) half the lengths of the box's edges [m].
    """
    with torch.no_grad():
        t = _lowest(p, d, half)
    apart = _excess(p + t[..., None] * d, half).norm(dim=-1)
    return torch.where(apart > 0, apart, _segment_depth(p + d / 2, d / 2, half).clamp(max=0))


def _lowest(p: Tensor, d: Tensor, half: Tensor) -> Tensor:
    """Where on a line (0 to 1) a box is nearest: the slope of the squared distance grows along the line."""
    per_d = 1 / torch.where(d == 0, 1.0, d)
    t = torch.cat([(-half - p) * per_d, (half - p) * per_d], dim=-1).clamp(0, 1)
    slopes = _slope(p[..., None, :], d[..., None, :], half[..., None, :], t)
    low = torch.where(slopes <= 0, t, 0.0).amax(-1)
    high = torch.where(slopes >= 0, t, 1.0).amin(-1)
    ends = torch.stack([low, high], dim=-1)
    first, last = _slope(p[..., None, :], d[..., None, :], half[..., None, :], ends).unbind(-1)
    rise = last - first
    return (low - (high - low) * first / torch.where(rise > 0, rise, 1.0)).clamp(0, 1)


def _slope(p: Tensor, d: Tensor, half: Tensor, t: Tensor) -> Tensor:
    return _dot(_excess(p + t[..., None] * d, half), d)


def _excess(x: Tensor, half: Tensor) -> Tensor:
    """How far points are beyond a box, along each axis."""
    return x - torch.minimum(torch.maximum(x, -half), half)


def _segment_depth(c: Tensor, m: Tensor, half: Tensor) -> Tensor:
    """Largest gap (or, below zero, smallest overlap) along the axes of a box and across axes and line."""
    size, to = m.abs(), c.abs()
    gaps = [(to - half - size).amax(-1)]
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        width = m[..., j].square() + m[..., k].square()
        gap = (c[..., j] * m[..., k] - c[..., k] * m[..., j]).abs()
        gap = gap - half[..., j] * size[..., k] - half[..., k] * size[..., j]
        # An axis that the line is parallel to says nothing.
        gaps.append(torch.where(width > 0, gap / torch.where(width > 0, width, 1.0).sqrt(), -torch.inf))
    return torch.stack(gaps).amax(0)


def box_box(
    R: Float64[Tensor, "*batch 3 3"],
    c: Float64[Tensor, "*batch 3"],
    half: Float64[Tensor, "*batch 3"],
    other: Float64[Tensor, "*batch 3"],
) -> Float64[Tensor, "*batch"]:
    """Signed distance of two boxes [m].

    Of boxes apart it is the smallest distance of the 12 edges of each box from the other box. Of boxes that
    overlap it is the depth, below zero: the smallest overlap along the 15 separating axes.

    Parameters
    ----------
    R, c
        (..., 3, 3) axes and (..., 3) centre [m] of the one box, seen from the other.
    half, other
        (..., 3) half the lengths of the edges of the one box, and of the other.
    """
    depth = _boxes_depth(R, c, half, other)
    back, seen = R.mT, -(R.mT @ c[..., None])[..., 0]
    edges = torch.minimum(_edges_box(R, c, half, other), _edges_box(back, seen, other, half))
    return torch.where(depth > 0, torch.maximum(edges, torch.zeros_like(edges)), depth)


def _edges_box(R: Tensor, c: Tensor, half: Tensor, other: Tensor) -> Tensor:
    """Smallest distance of a box's edges from another box."""
    arms = R.mT * half[..., None]  # row j: half of an edge along axis j
    corners = torch.tensor(_CORNERS, dtype=R.dtype, device=R.device) @ arms
    along = 2 * arms.repeat_interleave(4, dim=-2)
    start = c[..., None, :] + corners
    return segment_box(start, along, other[..., None, :].expand_as(start)).amin(-1)


_CORNERS = [
    [-1.0 if k == j else float(signs[(k - j) % 3 - 1]) for k in range(3)]
    for j in range(3)
    for signs in itertools.product((-1, 1), repeat=2)
]
"""Where the four edges along each axis begin, in half edges from the centre."""


def _boxes_depth(R: Tensor, c: Tensor, half: Tensor, other: Tensor) -> Tensor:
    size = R.abs()
    seen = (R.mT @ c[..., None])[..., 0]
    gaps = [
        (c.abs() - other - (size @ half[..., None])[..., 0]).amax(-1),
        (seen.abs() - half - (size.mT @ other[..., None])[..., 0]).amax(-1),
    ]
    for i, j in itertools.product(range(3), repeat=2):
        i1, i2, j1, j2 = (i + 1) % 3, (i + 2) % 3, (j + 1) % 3, (j + 2) % 3
        width = R[..., i1, j].square() + R[..., i2, j].square()
        gap = (c[..., i2] * R[..., i1, j] - c[..., i1] * R[..., i2, j]).abs()
        gap = gap - other[..., i1] * size[..., i2, j] - other[..., i2] * size[..., i1, j]
        gap = gap - half[..., j1] * size[..., i, j2] - half[..., j2] * size[..., i, j1]
        crossed = width > PARALLEL
        gaps.append(torch.where(crossed, gap / torch.where(crossed, width, 1.0).sqrt(), -torch.inf))
    return torch.stack(gaps).amax(0)
