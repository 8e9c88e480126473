"""Smallest singular value: the tool speed that unit joint rates guarantee in the worst direction.

Examples
--------
>>> import dexterity as dx
>>> sigma = dx.indices.Index("smallest_singular_value", "geometric", rows="translational")
>>> round(float(sigma(dx.robots.puma560(), [0.0, 0.5, 0.25, 0.0, 0.5, 0.0])), 4)
0.1611
"""

from __future__ import annotations

from sympy import Expr
from torch import Tensor

from dexterity.indices.jacobians import singular_values
from dexterity.indices.measure import Measure, Situation, Spectral

__all__ = ["MEASURE"]


def _evaluate(J: Tensor, _: Situation) -> Tensor:
    return singular_values(J)[..., -1]


def _combine(smallest: Expr, largest: Expr) -> Expr:  # noqa: ARG001
    return smallest


MEASURE = Measure(
    name="smallest_singular_value",
    aliases=("minsingular", "sigma_min", "smin"),
    title="Smallest singular value, σ_m",
    formula=r"\sigma_m",
    unit="1 for a normalised Jacobian, else the rows' unit",
    meaning=(
        "In its worst direction the tool moves at this speed when the norm of the joint rates is 1; twice "
        "the value means half the joint rates for the same motion."
    ),
    references=("Klein & Blaho (1987)",),
    evaluate=_evaluate,
    recorded=Spectral(_combine),
)
