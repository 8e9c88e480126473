"""Kinematic conditioning index: the smallest over the largest singular value.

Examples
--------
>>> import sympy
>>> from dexterity.indices.measures.kinematic_conditioning import MEASURE
>>> MEASURE.recorded.combine(*sympy.symbols("smallest largest"))
smallest/largest
"""

from __future__ import annotations

from sympy import Expr
from torch import Tensor

from dexterity.indices.jacobians import ratio_of_extremes, singular_values
from dexterity.indices.measure import Measure, Situation, Spectral

__all__ = ["MEASURE"]


def _evaluate(J: Tensor, _: Situation) -> Tensor:
    return ratio_of_extremes(singular_values(J))


def _combine(smallest: Expr, largest: Expr) -> Expr:
    return smallest / largest


MEASURE = Measure(
    name="kinematic_conditioning",
    aliases=("kci", "conditioning", "inverse_condition_number", "invcondition"),
    title="Kinematic conditioning index, KCI",
    formula=r"\mathrm{KCI} = \sigma_m / \sigma_1",
    unit="1",
    meaning=(
        "An error of the joint rates may come out up to 1/KCI times as large, in relative terms, as an error "
        "of the tool's velocity: 1 is the same accuracy in all directions, 0 a direction that is lost."
    ),
    references=("Angeles & López-Cajún (1992)", "Sotiropoulos & Aspragathos (2016), Eq. 10"),
    evaluate=_evaluate,
    recorded=Spectral(_combine),
    bounds=(0.0, 1.0),
)
