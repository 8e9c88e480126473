"""Tool deviation: how far the tool is off on average for joint values with noise.

Examples
--------
A planar arm with links of 1 m, and joints that are off by 1 mrad each (one standard deviation):

>>> import dexterity as dx
>>> arm = dx.Chain.from_dh([{"a": 1.0}, {"a": 1.0}])
>>> off = dx.indices.Index("tool_deviation", "geometric", rows="translational", joint_noise=(1e-3, 1e-3))
>>> f"{float(off(arm, [0.0, 0.0])):.6f} m"
'0.002236 m'
"""

from __future__ import annotations

import sympy
import torch
from sympy import Expr
from torch import Tensor

from dexterity.elimination import VANISHING, Matrix
from dexterity.indices.measure import Closed, Measure, Situation, Symbols
from dexterity.program import Recorder

__all__ = ["MEASURE"]


def _evaluate(J: Tensor, _: Situation) -> Tensor:
    square = J.square().sum((-2, -1))
    moves = square > 0
    return torch.where(moves, torch.where(moves, square, 1.0).sqrt(), 0.0)


def _record(record: Recorder, J: Matrix, _: Symbols) -> Expr:
    return record(sympy.sqrt(record(sympy.Add(*(x**2 for row in J for x in row)) + VANISHING)))


MEASURE = Measure(
    name="tool_deviation",
    aliases=("tool_covariance", "accuracy"),
    title="Deviation of the tool under joint noise",
    formula=r"\sqrt{\operatorname{tr}(U J \Sigma J^\top U)}, \quad \Sigma = \operatorname{diag}(s_i^2)",
    unit="as the rows' (m, rad), per unit of noise if no noise is given",
    meaning=(
        "Root mean square distance by which the tool misses its place when each joint is off by its noise; "
        "smaller is better, and half the value is half the error of a weld or a measurement."
    ),
    references=("Angeles (2014), chapter 5", "Cardou, Bouchard & Gosselin (2010)"),
    evaluate=_evaluate,
    recorded=Closed(_record),
    larger_is_better=False,
    columns="noise",
    full_rank=False,
)
