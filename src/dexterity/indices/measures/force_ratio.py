"""Force ratio: tool force or torque along a direction per unit norm of the joint efforts.

Examples
--------
A stretched planar arm carries a force along its links without any joint torque:

>>> import dexterity as dx
>>> arm = dx.Chain.from_dh([{"a": 1.0}, {"a": 1.0}])
>>> along_x = dx.indices.Index("force_ratio", "geometric", rows=("vx", "vy"), direction="vx")
>>> along_y = dx.indices.Index("force_ratio", "geometric", rows=("vx", "vy"), direction="vy")
>>> float(along_x(arm, [0.0, 0.0])), round(float(along_y(arm, [0.0, 0.0])), 6)
(inf, 0.447214)
"""

from __future__ import annotations

import math

import sympy
import torch
from jaxtyping import Float64
from sympy import Expr, S
from torch import Tensor

from dexterity.elimination import Matrix
from dexterity.indices.measure import Closed, Measure, Situation, Symbols
from dexterity.program import Recorder, select

__all__ = ["MEASURE", "force_ratio"]

_NONE = 1e-60  # square of joint efforts that counts as none


def force_ratio(
    J: Float64[Tensor, "*batch m n"], direction: Float64[Tensor, " m"]
) -> Float64[Tensor, "*batch"]:
    """Return the force along a unit direction that joint efforts of unit norm balance."""
    square = (direction[:, None] * J).sum(-2).square().sum(-1)
    loaded = square > _NONE
    return torch.where(loaded, torch.where(loaded, square, 1.0).rsqrt(), math.inf)


def _evaluate(J: Tensor, at: Situation) -> Tensor:
    assert at.direction is not None  # noqa: S101  # Index has made sure
    return force_ratio(J, at.direction)


def _record(record: Recorder, J: Matrix, at: Symbols) -> Expr:
    assert at.direction is not None  # noqa: S101
    efforts = [
        record(sympy.Add(*(sympy.Float(u) * x for u, x in zip(at.direction, column, strict=True) if u)))
        for column in zip(*J, strict=True)
    ]
    square = record(sympy.Add(*(effort**2 for effort in efforts)))
    decides = record(square - sympy.Float(_NONE))
    root = record(sympy.sqrt(record(select(decides, square, S.One))))
    return record(select(decides, record(1 / root), S.Infinity))


MEASURE = Measure(
    name="force_ratio",
    aliases=("force_transmission_ratio", "mechanical_advantage"),
    title="Force ratio along a direction",
    formula=r"\alpha = \left(u^\top J J^\top u\right)^{-1/2}",
    unit="1 for a normalised Jacobian, else the reciprocal of the rows' unit",
    meaning=(
        "Force (or torque about an axis) along the direction that joint efforts of unit norm balance; twice "
        "the value means half the effort for a valve, infinite that the structure carries the load alone."
    ),
    references=("Chiu (1988)", "Dubey & Luh (1988)"),
    evaluate=_evaluate,
    recorded=Closed(_record),
    needs=frozenset({"direction"}),
    full_rank=False,
    value_at_zero=math.inf,
)
