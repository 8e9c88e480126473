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

import torch
from torch import Tensor

from dexterity.indices.measure import Measure, Situation
from dexterity.indices.measures.manipulability import volume

__all__ = ["MEASURE"]


def _evaluate(J: Tensor, at: Situation) -> Tensor:
    M = at.chain.mass_matrix(at.q)
    # A locked joint transmits its torque to the base: its row and column are those of a unit matrix.
    free = at.moving[:, None] & at.moving
    M = torch.where(free, M, torch.eye(len(at.moving), dtype=M.dtype, device=M.device))
    return volume(torch.linalg.solve(M, J.mT).mT)


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
    needs=frozenset({"inertias"}),
    columns="unit",
    volume=True,
    mixes_columns=False,
)
