"""Manipulability with a penalty near joint limits.

Examples
--------
>>> import dexterity as dx
>>> arm = dx.Chain.from_dh([{"a": 1.0}, {"a": 1.0}], lower=[-1, -1], upper=[1, 2])
>>> index = dx.indices.Index("limited_manipulability", "geometric", rows=("vx", "vy"))
>>> values = index(arm, [[0.0, 0.5], [0.0, 1.99], [0.0, 2.0], [0.0, 2.1]])
>>> values.round(decimals=3).tolist()
[0.479, 0.116, 0.0, 0.0]
"""

from __future__ import annotations

import math

import sympy
import torch
from sympy import Expr, S
from torch import Tensor

from dexterity.elimination import Matrix
from dexterity.indices.measure import Closed, Measure, Situation, Symbols
from dexterity.indices.measures.manipulability import recorded_volume, volume
from dexterity.program import Recorder, select

__all__ = ["MEASURE", "SHARPNESS"]

SHARPNESS = 10.0
"""Factor k of the exponent: at a tenth of the product in the middle of the limits, 63 % of w are left."""


def _evaluate(J: Tensor, at: Situation) -> Tensor:
    lower, upper = at.chain.lower.to(at.q.device), at.chain.upper.to(at.q.device)
    limited = at.moving & torch.isfinite(lower) & torch.isfinite(upper) & (upper > lower)
    low, high = torch.where(limited, lower, 0.0), torch.where(limited, upper, 1.0)
    factors = torch.where(limited, 4 * (at.q - low) * (high - at.q) / (high - low) ** 2, 1.0)
    product = factors.clamp(min=0).prod(-1)
    return volume(J) * torch.expm1(-SHARPNESS * product) / math.expm1(-SHARPNESS)


def _record(record: Recorder, J: Matrix, at: Symbols) -> Expr:
    product: Expr = S.One
    for i in at.moving:
        low, high = at.lower[i], at.upper[i]
        if math.isfinite(low) and math.isfinite(high) and high > low:
            low_, high_, q = sympy.Float(low), sympy.Float(high), at.joint_values[i]
            room = record(4 / (high_ - low_) ** 2 * record(record(q - low_) * record(high_ - q)))
            product = record(product * record(select(room, room, S.Zero)))
    w = recorded_volume(record, J)
    left = record(1 - record(sympy.exp(record(-sympy.Float(SHARPNESS) * product))))
    return record(sympy.Float(-1 / math.expm1(-SHARPNESS)) * record(w * left))


MEASURE = Measure(
    name="limited_manipulability",
    aliases=("limited_w", "joint_limit_manipulability"),
    title="Manipulability penalised near joint limits",
    formula=(
        r"w \, \frac{1 - e^{-k p}}{1 - e^{-k}}, \quad"
        r" p = \prod_i \frac{4 (q_i - l_i)(u_i - q_i)}{(u_i - l_i)^2}, \quad k = 10"
    ),
    unit="as that of w",
    meaning=(
        "The manipulability w where all joints are in the middle of their limits, less toward a limit, and "
        "zero at and beyond it: a configuration with a high value has speed and room to use it. A joint "
        "with no limits, or a limit on one side only, does not count."
    ),
    references=("Tsai (1986)", "Vahrenkamp et al. (2012)"),
    evaluate=_evaluate,
    recorded=Closed(_record),
    needs=frozenset({"limits"}),
    volume=True,
)
