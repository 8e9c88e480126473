"""Logarithm of the manipulability: the sum of the logarithms of the singular values.

Examples
--------
>>> import dexterity as dx
>>> log_w = dx.indices.Index("log_manipulability")
>>> float(log_w(dx.Chain.from_dh([{"a": 1.0}] * 6), [0.1] * 6))
-inf
"""

from __future__ import annotations

import math

import sympy
import torch
from sympy import Expr, S
from torch import Tensor

from dexterity.elimination import Matrix
from dexterity.indices.jacobians import singular_values
from dexterity.indices.measure import Closed, Measure, Situation, Symbols
from dexterity.indices.measures.manipulability import recorded_square
from dexterity.program import Recorder, select

__all__ = ["MEASURE", "NONE", "log_of_volume"]

NONE = sympy.Float(1e-50)
"""Square of a volume that counts as none."""


def log_of_volume(J: Tensor) -> tuple[Tensor, Tensor]:
    """Sum of the logarithms of the singular values, and where it holds: where none of them is zero."""
    sigma = singular_values(J)
    holds = sigma[..., -1] > 0
    return torch.where(holds[..., None], sigma, 1.0).log().sum(-1), holds


def _evaluate(J: Tensor, _: Situation) -> Tensor:
    value, holds = log_of_volume(J)
    return torch.where(holds, value, -math.inf)


def _record(record: Recorder, J: Matrix, _: Symbols) -> Expr:
    square = record(recorded_square(record, J))
    decides = record(square - NONE)
    value = record(sympy.log(record(select(decides, square, S.One))) / 2)
    return record(select(decides, value, -S.Infinity))


MEASURE = Measure(
    name="log_manipulability",
    aliases=("log_w",),
    title="Logarithm of the manipulability, log w",
    formula=r"\log w = \textstyle\sum_i \log \sigma_i",
    unit="1",
    meaning=(
        "A step of 0.69 doubles the volume of tool velocities; the gradient does not fade toward a "
        "singularity, where the value is −∞ and its gradient is given as zero."
    ),
    references=("Yoshikawa (1985)",),
    evaluate=_evaluate,
    recorded=Closed(_record),
    bounds=(-math.inf, math.inf),
    volume=True,
    value_at_zero=-math.inf,
)
