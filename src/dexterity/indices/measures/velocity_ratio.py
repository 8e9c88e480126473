"""Velocity ratio: tool speed along a direction per unit norm of the joint rates.

Examples
--------
The two links of a stretched planar arm move its tool across the arm, and not along it:

>>> import dexterity as dx
>>> arm = dx.Chain.from_dh([{"a": 1.0}, {"a": 1.0}])
>>> along_y = dx.indices.Index("velocity_ratio", "geometric", rows=("vx", "vy"), direction="vy")
>>> along_x = dx.indices.Index("velocity_ratio", "geometric", rows=("vx", "vy"), direction="vx")
>>> round(float(along_y(arm, [0.0, 0.0])), 6), float(along_x(arm, [0.0, 0.0]))
(2.236068, 0.0)
"""

from __future__ import annotations

import sympy
import torch
from jaxtyping import Float64
from sympy import Expr, S
from torch import Tensor

from dexterity.elimination import VANISHING, Matrix, dot, triangularise
from dexterity.indices.measure import Closed, Measure, Situation, Symbols
from dexterity.program import Recorder, copysign

__all__ = ["MEASURE", "velocity_ratio"]

_MISSED = 1e-6  # part of a unit vector beyond the reach of all joint rates that counts as rounding


def velocity_ratio(
    J: Float64[Tensor, "*batch m n"], direction: Float64[Tensor, " m"]
) -> Float64[Tensor, "*batch"]:
    """Return the speed along a unit direction, without motion along other rows, per norm of joint rates."""
    rates = torch.linalg.pinv(J) @ direction
    missed = torch.linalg.vector_norm((J @ rates[..., None])[..., 0].detach() - direction, dim=-1)
    reached = (missed < _MISSED) & (rates.detach() != 0).any(-1)
    squares = torch.where(reached, rates.square().sum(-1), 1.0)
    return torch.where(reached, squares.rsqrt(), 0.0)


def _evaluate(J: Tensor, at: Situation) -> Tensor:
    assert at.direction is not None  # noqa: S101  # Index has made sure
    return velocity_ratio(J, at.direction)


def _record(record: Recorder, J: Matrix, at: Symbols) -> Expr:
    """Solve L y = u for the triangle L of J: the joint rates of least norm have the norm of y."""
    assert at.direction is not None  # noqa: S101
    # A row that is zero at all configurations holds what cannot move anyway, or the direction itself.
    chosen = [i for i, row in enumerate(J) if any(row) or at.direction[i]]
    J, direction = [J[i] for i in chosen], [at.direction[i] for i in chosen]
    if not all(any(row) for row in J):
        return S.Zero
    if len(J[0]) < len(J):
        raise ValueError(
            f"a direction among {len(J)} rows cannot be compiled for {len(J[0])} moving joints: choose rows"
        )
    L, _ = triangularise(record, J)
    # Row i is multiplied by the diagonal before it, so that nothing is divided by what may vanish.
    y: list[Expr] = []
    scales = [record(L[i][i]) for i in range(len(J))]
    before: Expr = S.One
    for i, row in enumerate(L):
        rest = record(before * sympy.Float(direction[i]) - dot(row[:i], y))
        # All earlier components are brought to the common denominator, the product of the diagonal so far.
        y = [record(scales[i] * x) for x in y] + [rest]
        before = record(before * scales[i])
    norm = record(sympy.Add(*(x**2 for x in y)) + VANISHING)
    # Written so, the absolute value has a derivative of one side where it is zero.
    absolute = record(before * record(copysign(S.One, before)))
    return record(absolute / record(sympy.sqrt(norm)))


MEASURE = Measure(
    name="velocity_ratio",
    aliases=("velocity_transmission_ratio", "mvr_along"),
    title="Velocity ratio along a direction",
    formula=r"\beta = \left(u^\top (J J^\top)^{-1} u\right)^{-1/2}",
    unit="1 for a normalised Jacobian, else the rows' unit",
    meaning=(
        "Tool speed along the direction, with no motion along the other rows, per unit norm of the joint "
        "rates; twice the value means twice the speed along a seam or a cut."
    ),
    references=("Chiu (1988)", "Dubey & Luh (1988)"),
    evaluate=_evaluate,
    recorded=Closed(_record),
    needs=frozenset({"direction"}),
    full_rank=False,
)
