"""Guaranteed speed: what the tool reaches in every direction while each joint keeps its own rate limit.

Joint rates within their limits reach a zonotope of tool velocities. Each of its facets is spanned by m - 1
columns of the Jacobian; along the unit normal n of such a facet the zonotope extends by Σ‖nᵀ J_i‖ r_i. The
smallest of these is the radius of the ball about zero that lies within.

Examples
--------
>>> import torch
>>> from dexterity.indices.measures.guaranteed_speed import inradius
>>> round(inradius(torch.tensor([[1.0, 0.0, 1.0], [0.0, 1.0, 1.0]], dtype=torch.float64)).item(), 6)
1.414214
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import combinations

import torch
from jaxtyping import Float64
from torch import Tensor

from dexterity.indices.measure import Measure, Situation

__all__ = ["MEASURE", "inradius"]

_DEGENERATE = 1e-10  # part of the product of m - 1 lengths below which their columns span no facet


def inradius(J: Float64[Tensor, "*batch m n"]) -> Float64[Tensor, "*batch"]:
    """Radius of the largest ball in the zonotope that rates of at most 1 reach, 0 where it is flat.

    Columns that span no facet are skipped: no normal is theirs.
    """
    m, n = J.shape[-2:]
    if n < m:
        return torch.zeros_like(J[..., 0, 0])
    at_once = max(1, _ENTRIES // (math.comb(n, m - 1) * m))
    radii = [_inradius(piece) for piece in J.reshape(-1, m, n).split(at_once)]
    return torch.cat(radii).reshape(J.shape[:-2])


_ENTRIES = 1 << 17  # of normals at a time, so that they stay in the cache


def _inradius(J: Float64[Tensor, "N m n"]) -> Float64[Tensor, " N"]:
    m, n = J.shape[-2:]
    normals = _normals(J)
    squares = normals.square().sum(-1)
    lengths = torch.linalg.vector_norm(J.detach(), dim=-2)
    chosen = _places(list(combinations(range(n), m - 1)), J)
    volumes = lengths[:, chosen].prod(-1) if m > 1 else torch.ones_like(squares)
    spans = squares > (_DEGENERATE * volumes) ** 2
    heights = (normals @ J).abs().sum(-1) / torch.where(spans, squares, 1.0).sqrt()
    least = torch.where(spans, heights, math.inf).amin(-1)
    return torch.where(spans.any(-1), least, 0.0)


def _normals(J: Float64[Tensor, "N m n"]) -> Float64[Tensor, "N facets m"]:
    """Generalised cross products of all choices of m - 1 columns: orthogonal to them, long as their volume.

    Minors of k columns follow from those of k - 1, each computed once, by expansion along the last column.
    """
    m, n = J.shape[-2:]
    minors = J.new_ones(len(J), 1, 1)  # by choice of columns and choice of rows
    for k in range(1, m):
        columns, rows = list(combinations(range(n), k)), list(combinations(range(m), k))
        fewer_columns = {choice: i for i, choice in enumerate(combinations(range(n), k - 1))}
        fewer_rows = {choice: i for i, choice in enumerate(combinations(range(m), k - 1))}
        last = J.mT.index_select(1, _places([choice[-1] for choice in columns], J))
        before = minors.index_select(1, _places([fewer_columns[choice[:-1]] for choice in columns], J))
        terms = [
            (-1) ** (k - 1 + place)
            * last.index_select(2, _places([choice[place] for choice in rows], J))
            * before.index_select(
                2, _places([fewer_rows[choice[:place] + choice[place + 1 :]] for choice in rows], J)
            )
            for place in range(k)
        ]
        minors = torch.stack(terms).sum(0)
    # Row i is left out in the choice that combinations names as the last but i.
    signs = J.new_tensor([(-1.0) ** i for i in range(m)])
    return minors.flip(-1) * signs


def _places(numbers: Sequence[object], J: Tensor) -> Tensor:
    return torch.tensor(numbers, dtype=torch.long, device=J.device)


def _evaluate(J: Tensor, _: Situation) -> Tensor:
    return inradius(J)


MEASURE = Measure(
    name="guaranteed_speed",
    aliases=("zonotope_inradius", "polytope_inradius"),
    title="Guaranteed tool speed under the joints' rate limits",
    formula=r"\min_{n \in \text{facet normals}} \textstyle\sum_i |n^\top J_i| \, r_i",
    unit="1 for a normalised Jacobian, else the rows' unit",
    meaning=(
        "Speed that the tool reaches in every direction while no joint exceeds its own rate limit; twice the "
        "value means half the time in the worst direction, and no norm of joint rates has to be chosen."
    ),
    references=("Kokkinis & Paden (1989)", "Chiacchio, Bouffard-Vercelli & Pierrot (1996)"),
    evaluate=_evaluate,
    mixes_columns=False,
)
