"""Order-independent manipulability: the geometric mean of the singular values.

Examples
--------
>>> import dexterity as dx
>>> mean = dx.indices.Index("order_independent_manipulability", "geometric", rows="translational")
>>> w = dx.indices.Index("manipulability", "geometric", rows="translational")
>>> puma, q = dx.robots.puma560(), [0.0, 0.5, 0.25, 0.0, 0.5, 0.0]
>>> bool(abs(mean(puma, q) - w(puma, q) ** (1 / 3)) < 1e-15)
True
"""

from __future__ import annotations

import sympy
import torch
from sympy import Expr, S
from torch import Tensor

from dexterity.elimination import Matrix
from dexterity.indices.measure import Closed, Measure, Situation, Symbols
from dexterity.indices.measures.log_manipulability import NONE, log_of_volume
from dexterity.indices.measures.manipulability import recorded_square
from dexterity.program import Recorder, select

__all__ = ["MEASURE", "recorded_mean"]


def recorded_mean(record: Recorder, J: Matrix, power: int) -> Expr:
    """Power of the geometric mean of the singular values, 0 where one of them is."""
    square = record(recorded_square(record, J))
    decides = record(square - NONE)
    log = record(sympy.log(record(select(decides, square, S.One))))
    mean = record(sympy.exp(record(log * sympy.Rational(power, 2 * len(J)))))
    return record(select(decides, mean, S.Zero))


def _evaluate(J: Tensor, _: Situation) -> Tensor:
    value, holds = log_of_volume(J)
    return torch.where(holds, (value / J.shape[-2]).exp(), 0.0)


def _record(record: Recorder, J: Matrix, _: Symbols) -> Expr:
    return recorded_mean(record, J, power=1)


MEASURE = Measure(
    name="order_independent_manipulability",
    aliases=("mean_singular_value", "w_mean"),
    title="Order-independent manipulability, w^(1/m)",
    formula=r"\sqrt[m]{w} = \sqrt[2m]{\det(J J^\top)}",
    unit="1 for a normalised Jacobian, else the rows' unit",
    meaning=(
        "Twice the value means twice the tool speed on average over the directions, whatever the number of "
        "rows, so that tasks with different rows can be compared; at a singularity the value is zero, its "
        "slope is infinite and the gradient is given as zero."
    ),
    references=("Kim & Khosla (1991)",),
    evaluate=_evaluate,
    recorded=Closed(_record),
    volume=True,
)
