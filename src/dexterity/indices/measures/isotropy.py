"""Isotropy: geometric over arithmetic mean of the squares of the singular values.

Examples
--------
>>> import torch
>>> from dexterity.indices.measures.isotropy import isotropy
>>> isotropy(torch.diag(torch.tensor([2.0, 2.0, 2.0], dtype=torch.float64))).item()
1.0
"""

from __future__ import annotations

import sympy
import torch
from jaxtyping import Float64
from sympy import Expr
from torch import Tensor

from dexterity.elimination import VANISHING, Matrix
from dexterity.indices.measure import Closed, Measure, Situation, Symbols
from dexterity.indices.measures.log_manipulability import log_of_volume
from dexterity.indices.measures.order_independent_manipulability import recorded_mean
from dexterity.program import Recorder

__all__ = ["MEASURE", "isotropy"]


def isotropy(J: Float64[Tensor, "*batch m n"]) -> Float64[Tensor, "*batch"]:
    """Geometric over arithmetic mean of the squares of the singular values, 0 where one of them is zero."""
    log, holds = log_of_volume(J)
    mean = torch.where(holds, J.square().sum((-2, -1)) / J.shape[-2], 1.0)
    return torch.where(holds, (2 * log / J.shape[-2]).exp() / mean, 0.0).clamp(max=1.0)


def _evaluate(J: Tensor, _: Situation) -> Tensor:
    return isotropy(J)


def _record(record: Recorder, J: Matrix, _: Symbols) -> Expr:
    total = record(sympy.Add(*(x**2 for row in J for x in row)) + VANISHING)
    return record(recorded_mean(record, J, power=2) * record(len(J) * record(1 / total)))


MEASURE = Measure(
    name="isotropy",
    aliases=("relative_manipulability", "gm_am"),
    title="Isotropy, geometric over arithmetic mean",
    formula=r"\Delta = \sqrt[m]{\det(J J^\top)} \,/\, \tfrac{1}{m}\operatorname{tr}(J J^\top)",
    unit="1",
    meaning=(
        "How round the ellipsoid of tool velocities is, all directions counted and not only the extremes: 1 "
        "is the same speed in all directions, 0 a direction that is lost, with a gradient given as zero."
    ),
    references=("Kim & Khosla (1991)",),
    evaluate=_evaluate,
    recorded=Closed(_record),
    bounds=(0.0, 1.0),
)
