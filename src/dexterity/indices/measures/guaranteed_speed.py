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
from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from itertools import combinations

import sympy
import torch
from jaxtyping import Float64
from sympy import Expr, S
from torch import Tensor

from dexterity.elimination import Matrix, dot
from dexterity.indices.measure import Closed, Measure, Situation, Symbols
from dexterity.program import Recorder, select

__all__ = ["MEASURE", "inradius"]

_DEGENERATE = 1e-10  # part of the product of m - 1 lengths below which their columns span no facet
_NEGLIGIBLE = 1e-5  # part of all columns that is added to each length: what is rounding alone spans no facet
_MOST_STEPS = 2500  # that are written out as a program: more make files that take minutes to compile


def inradius(J: Float64[Tensor, "*batch m n"]) -> Float64[Tensor, "*batch"]:
    """Radius of the largest ball in the zonotope that rates of at most 1 reach, 0 where it is flat.

    Columns that span no facet are skipped: no normal is theirs.
    """
    m, n = J.shape[-2:]
    if n < m:
        return torch.zeros_like(J[..., 0, 0])
    at_once = max(1, _ENTRIES // (math.comb(n, m - 1) * m))
    # Tensors of places are made in each call, which torch may be tracing; the numbers in them are not.
    expansions = [tuple(_places(numbers, J) for numbers in step) for step in _expansions(m, n)]
    facets = _places(list(combinations(range(n), m - 1)), J)
    pieces = J.reshape(-1, m, n).permute(1, 2, 0).split(at_once, dim=-1)
    return torch.cat([_inradius(piece, expansions, facets) for piece in pieces]).reshape(J.shape[:-2])


_ENTRIES = 1 << 17  # of normals at a time, so that they stay in the cache


def _inradius(J: Tensor, expansions: Sequence[tuple[Tensor, ...]], facets: Tensor) -> Tensor:
    """Radii (N,) of Jacobians (m, n, N)."""
    normals = _normals(J, expansions)
    squares = torch.stack([normal.square() for normal in normals]).sum(0)
    lengths = J.detach().square().sum(0)
    lengths = (lengths + _NEGLIGIBLE**2 * lengths.sum(0)).sqrt()
    volumes = lengths[facets].prod(1) if facets.shape[-1] else torch.ones_like(squares)
    spans = squares > (_DEGENERATE * volumes) ** 2
    heights = torch.zeros_like(squares)
    for column in J.unbind(1):
        along = [normal * entry for normal, entry in zip(normals, column, strict=True)]
        heights = heights + torch.stack(along).sum(0).abs()
    heights = heights / torch.where(spans, squares, 1.0).sqrt()
    least = torch.where(spans, heights, math.inf).amin(0)
    return torch.where(spans.any(0), least, 0.0)


def _normals(J: Tensor, expansions: Sequence[tuple[Tensor, ...]]) -> list[Tensor]:
    """Generalised cross products of each m - 1 columns, m components (facets, N): as long as their volume.

    Minors of k columns follow from those of k - 1, each computed once, by expansion along the last column.
    """
    m = len(J)
    minors: dict[tuple[int, ...], Tensor] = {
        (): J.new_ones(1, J.shape[-1])
    }  # by choice of rows; (choices of columns, N)
    for k, (last, before) in enumerate(expansions, start=1):
        entries = [row.index_select(0, last) for row in J]
        known = {rows: minor.index_select(0, before) for rows, minor in minors.items()}
        minors = {rows: _expanded(entries, known, rows) for rows in combinations(range(m), k)}
    everything = tuple(range(m))
    return [(-1) ** i * minors[everything[:i] + everything[i + 1 :]] for i in everything]


def _expanded(
    entries: Sequence[Tensor], known: Mapping[tuple[int, ...], Tensor], rows: tuple[int, ...]
) -> Tensor:
    """Expand minors of some rows along their last columns."""
    terms = [
        (-1) ** (len(rows) - 1 + place) * entries[row] * known[rows[:place] + rows[place + 1 :]]
        for place, row in enumerate(rows)
    ]
    return torch.stack(terms).sum(0)


@cache
def _expansions(m: int, n: int) -> list[tuple[list[int], list[int]]]:
    """For choices of 1 … m - 1 columns: the last column of each, and the place of the choice without it."""
    steps = []
    for k in range(1, m):
        columns = list(combinations(range(n), k))
        fewer = {choice: i for i, choice in enumerate(combinations(range(n), k - 1))}
        steps.append(([choice[-1] for choice in columns], [fewer[choice[:-1]] for choice in columns]))
    return steps


def _places(numbers: Sequence[object], J: Tensor) -> Tensor:
    return torch.tensor(numbers, dtype=torch.long, device=J.device)


def _evaluate(J: Tensor, _: Situation) -> Tensor:
    return inradius(J)


# ---- recorded --------------------------------------------------------------------------------------


def _record(record: Recorder, J: Matrix, _: Symbols) -> Expr:
    """Smallest extent along a normal, each normal and each length computed once."""
    columns = [list(column) for column in zip(*J, strict=True)]
    lengths = [record(sympy.Add(*(x**2 for x in column))) for column in columns]
    # No extent reaches this bound, and 0 is left where no columns span a facet: x < x² + 1.
    bound = record(sympy.Add(*lengths) + len(columns))
    negligible = record(sympy.Float(_NEGLIGIBLE**2) * record(sympy.Add(*lengths)))
    lengths = [record(length + negligible) for length in lengths]
    least: Expr = S.Zero
    for facet, normal in _recorded_normals(record, J):
        square = record(sympy.Add(*(x**2 for x in normal)))
        volume = S.One
        for i in facet:
            volume = record(volume * lengths[i])
        spans = _is_positive(record, square - sympy.Float(_DEGENERATE**2) * volume)
        others = [column for i, column in enumerate(columns) if i not in facet]
        height = record(sympy.Add(*(record(sympy.Abs(record(dot(normal, other)))) for other in others)))
        length = record(sympy.sqrt(record(spans * square + record(1 - spans))))
        extent = record(height * record(1 / length))
        takes = _is_positive(record, spans * record(bound - extent))
        leaves, extent = record(1 - takes), record(takes * extent)
        bound, least = record(extent + leaves * bound), record(extent + leaves * least)
    return least


def _is_positive(record: Recorder, x: Expr) -> Expr:
    """1 where it is, else 0: factors in place of branches, which compilers turn into vector instructions."""
    return record(select(record(x), S.One, S.Zero))


def _recorded_normals(record: Recorder, J: Matrix) -> Iterator[tuple[tuple[int, ...], list[Expr]]]:
    """Yield the choices of m - 1 columns with their generalised cross products, without those always zero."""

    @cache
    def minor(rows: tuple[int, ...], columns: tuple[int, ...]) -> Expr:
        if not columns:
            return S.One
        *before, last = columns
        terms = [
            (-1) ** (len(rows) - 1 + place) * J[row][last] * minor(_without(rows, place), tuple(before))
            for place, row in enumerate(rows)
            if J[row][last] != 0
        ]
        return record(sympy.Add(*terms))

    everything = tuple(range(len(J)))
    for facet in combinations(range(len(J[0])), len(J) - 1):
        normal = [(-1) ** i * minor(_without(everything, i), facet) for i in everything]
        if any(component != 0 for component in normal):
            yield facet, normal


def _without(rows: tuple[int, ...], place: int) -> tuple[int, ...]:
    return rows[:place] + rows[place + 1 :]


def _too_many_facets(rows: int, columns: int) -> str:
    facets = math.comb(columns, rows - 1)
    minors = sum(math.comb(columns, k) * math.comb(rows, k) for k in range(2, rows))
    steps = minors + facets * (2 * (columns - rows + 1) + 10)
    if steps <= _MOST_STEPS:
        return ""
    return (
        f"{columns} joints over {rows} rows have {facets} facets, which take about {steps} steps, and at "
        f"most {_MOST_STEPS} are written out"
    )


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
    recorded=Closed(_record, _too_many_facets),
    mixes_columns=False,
)
