"""Dynamic manipulability: the volume of tool accelerations that joint torques of unit norm reach from rest.

Examples
--------
A uniform rod of 3 kg and 1 m about its end: a torque of 1 N m turns it at 1 rad/s², the tool at 1 m/s².

>>> import dexterity as dx
>>> tensor = [[0, 0, 0], [0, 0.25, 0], [0, 0, 0.25]]
>>> rod = dx.Chain.from_dh([{"a": 1.0}], inertias=([3.0], [[0.5, 0, 0]], [tensor]))
>>> index = dx.indices.Index("dynamic_manipulability", "geometric", rows=("vy",))
>>> round(float(index(rod, [0.0])), 9)
1.0
"""

from __future__ import annotations

import sympy
import torch
from sympy import Expr, S
from torch import Tensor

from dexterity.elimination import Matrix, dot
from dexterity.indices.measure import Closed, Measure, Situation, Symbols
from dexterity.indices.measures.manipulability import recorded_volume, volume
from dexterity.program import Recorder

__all__ = ["MEASURE"]


def _evaluate(J: Tensor, at: Situation) -> Tensor:
    M = at.chain.mass_matrix(at.q)
    # A locked joint transmits its torque to the base: its row and column are those of a unit matrix.
    free = at.moving[:, None] & at.moving
    M = torch.where(free, M, torch.eye(len(at.moving), dtype=M.dtype, device=M.device))
    return volume(torch.linalg.solve(M, J.mT).mT)


def _record(record: Recorder, J: Matrix, at: Symbols) -> Expr:
    """Volume of J·M⁻¹, with M = L·D·Lᵀ; of as many joints as rows it is that of J over det M."""
    L, reciprocals = _factors(record, at.mass_matrix())
    if len(J) == len(L):
        return record(recorded_volume(record, J) * record(sympy.Mul(*reciprocals)))
    return recorded_volume(record, [_solved(record, L, reciprocals, row) for row in J])


def _factors(record: Recorder, M: Matrix) -> tuple[Matrix, list[Expr]]:
    """Return the unit lower triangle L, and the reciprocals of D; Golub & Van Loan (2013), section 4.1."""
    n = len(M)
    L = [[S(int(i == j)) for j in range(n)] for i in range(n)]
    reciprocals: list[Expr] = []
    scaled = [[S.Zero] * n for _ in range(n)]  # L·D
    for i in range(n):
        for j in range(i):
            scaled[i][j] = record(M[i][j] - dot(scaled[i][:j], L[j][:j]))
            L[i][j] = record(scaled[i][j] * reciprocals[j])
        pivot = record(M[i][i] - dot(scaled[i][:i], L[i][:i]))
        if pivot == 0:
            raise ValueError("inertias of the links are missing: a joint moves no mass at all")
        reciprocals.append(record(1 / pivot))
    return L, reciprocals


def _solved(record: Recorder, L: Matrix, reciprocals: list[Expr], right: list[Expr]) -> list[Expr]:
    """Solve L·D·Lᵀ x = right."""
    n, x = len(L), list(right)
    for i in range(n):
        x[i] = record(x[i] - dot(L[i][:i], x[:i]))
    x = [record(a * b) for a, b in zip(x, reciprocals, strict=True)]
    for i in reversed(range(n)):
        x[i] = record(x[i] - dot([L[k][i] for k in range(i + 1, n)], x[i + 1 :]))
    return x


MEASURE = Measure(
    name="dynamic_manipulability",
    aliases=("dynamic_w",),
    title="Dynamic manipulability",
    formula=r"w_d = \sqrt{\det\left(J M^{-1} M^{-\top} J^\top\right)}",
    unit="the product of the rows' units over s and the joint efforts' units",
    meaning=(
        "Twice the value means twice the volume of tool accelerations that the same joint torques reach from "
        "rest; gravity and the water are left out."
    ),
    references=("Yoshikawa (1985), Dynamic manipulability of robot manipulators",),
    evaluate=_evaluate,
    recorded=Closed(_record),
    needs=frozenset({"inertias"}),
    columns="unit",
    volume=True,
    mixes_columns=False,
)
