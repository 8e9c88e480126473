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
from collections.abc import Mapping
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
    subsets = torch.tensor(list(combinations(range(n), m - 1)), dtype=torch.long, device=J.device)
    columns = J.mT.index_select(-2, subsets.reshape(-1)).unflatten(-2, (len(subsets), m - 1))
    normals = _normals(columns)
    squares = normals.square().sum(-1)
    spans = squares > (_DEGENERATE * torch.linalg.vector_norm(columns, dim=-1).prod(-1).detach()) ** 2
    lengths = torch.where(spans, squares, 1.0).sqrt()
    heights = (normals @ J).abs().sum(-1) / lengths
    least = torch.where(spans, heights, math.inf).amin(-1)
    return torch.where(spans.any(-1), least, 0.0)


def _normals(columns: Float64[Tensor, "*batch k m_1 m"]) -> Float64[Tensor, "*batch k m"]:
    """Vectors orthogonal to m - 1 others, as long as the volume of these: their generalised cross product."""
    m = columns.shape[-1]
    # Minors of the first vectors, one vector more at each step; each holds the choice of coordinates.
    minors: dict[tuple[int, ...], Tensor] = {(): columns.new_ones(columns.shape[:-2])}
    for size in range(1, m):
        minors = {
            chosen: _expanded(columns[..., size - 1, :], chosen, minors)
            for chosen in combinations(range(m), size)
        }
    everything = tuple(range(m))
    return torch.stack(
        [(-1) ** axis * minors[everything[:axis] + everything[axis + 1 :]] for axis in range(m)], dim=-1
    )


def _expanded(vector: Tensor, chosen: tuple[int, ...], minors: Mapping[tuple[int, ...], Tensor]) -> Tensor:
    """Expand a minor along its last vector."""
    terms = [
        (-1) ** (len(chosen) - 1 + place) * vector[..., axis] * minors[chosen[:place] + chosen[place + 1 :]]
        for place, axis in enumerate(chosen)
    ]
    return torch.stack(terms).sum(0)


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
