"""Manipulability w: the volume of the velocity ellipsoid, up to a constant factor.

Examples
--------
>>> import torch
>>> from dexterity.indices.measures.manipulability import volume
>>> float(volume(torch.diag(torch.tensor([2.0, 3.0, 0.5], dtype=torch.float64))))
3.0
"""

from __future__ import annotations

import sympy
from jaxtyping import Float64
from sympy import Expr
from torch import Tensor

from dexterity.elimination import VANISHING, Matrix, triangularise
from dexterity.indices.jacobians import singular_values
from dexterity.indices.measure import Closed, Measure, Situation, Symbols
from dexterity.program import Recorder

__all__ = ["MEASURE", "recorded_square", "recorded_volume", "volume"]


def volume(J: Float64[Tensor, "*batch m n"]) -> Float64[Tensor, "*batch"]:
    """Product of all singular values of a Jacobian that is known to be finite."""
    return singular_values(J).prod(-1)


def recorded_square(record: Recorder, J: Matrix) -> Expr:
    """Square of the volume, from an orthogonal elimination of J itself; not yet recorded."""
    _, squares = triangularise(record, J)
    return sympy.Mul(*squares)


def recorded_volume(record: Recorder, J: Matrix) -> Expr:
    """Volume of the rows of a Jacobian."""
    return record(sympy.sqrt(record(recorded_square(record, J) + VANISHING)))


def _evaluate(J: Tensor, _: Situation) -> Tensor:
    return volume(J)


def _record(record: Recorder, J: Matrix, _: Symbols) -> Expr:
    return recorded_volume(record, J)


MEASURE = Measure(
    name="manipulability",
    aliases=("w", "yoshikawa"),
    title="Manipulability w",
    formula=r"w = \sqrt{\det(J J^\top)} = \sigma_1 \cdots \sigma_m",
    unit="1 for a normalised Jacobian, else the product of the rows' units",
    meaning=(
        "Twice the value means twice the volume of tool velocities that the same joint rates reach: more "
        "speed in all directions together, with no word about the worst of them."
    ),
    references=("Yoshikawa (1985)", "Sotiropoulos & Aspragathos (2016), Eqs. 8 and 9"),
    evaluate=_evaluate,
    recorded=Closed(_record),
    volume=True,
)
