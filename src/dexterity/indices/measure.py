"""Description of a measure: all that the package needs to know about one dexterity index, in one object.

A measure is evaluated in torch from the normalised Jacobian, which serves ``Index.bind``. To be compiled into
any language it also says how its value is recorded: as a closed form in the entries of the Jacobian
(:class:`Closed`), or from the smallest and the largest singular value (:class:`Spectral`). A measure that
says neither is compiled by the torch backend alone.

Examples
--------
>>> import dexterity as dx
>>> measure = dx.indices.describe("kinematic_conditioning")
>>> measure.title, measure.bounds, measure.larger_is_better
('Kinematic conditioning index, KCI', (0.0, 1.0), True)
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal, TypeAlias

from jaxtyping import Float64
from sympy import Expr, Symbol
from torch import Tensor

from dexterity.chain import Chain
from dexterity.elimination import Matrix
from dexterity.program import Recorder

__all__ = ["Closed", "Frame", "Measure", "Need", "Situation", "Spectral", "Symbols"]

Frame: TypeAlias = Literal["spatial", "body", "geometric"]
"""Name of one of the three Jacobians of :class:`dexterity.chain.Chain`."""

Need: TypeAlias = Literal["direction", "limits", "inertias"]
"""What a measure needs besides the Jacobian."""


@dataclass(frozen=True)
class Situation:
    """What a measure may use besides the normalised Jacobian when it is evaluated.

    Attributes
    ----------
    chain
        The robot.
    q
        (..., n) joint values, [rad] or [m].
    moving
        (n,) whether a joint may move.
    direction
        (m,) unit vector in the space of the rows, for a measure that needs one.
    """

    chain: Chain
    q: Float64[Tensor, "*batch n"]
    moving: Tensor
    direction: Float64[Tensor, " m"] | None = None


@dataclass(frozen=True)
class Symbols:
    """What a measure may use besides the entries of the normalised Jacobian when it is recorded.

    Attributes
    ----------
    joint_values
        Symbols of the n joint values.
    lower, upper
        Joint limits, infinite where there are none.
    moving
        Numbers, from 0, of the joints that may move.
    direction
        Unit vector in the space of the rows, in the order of the rows.
    mass_matrix
        Returns the recorded mass matrix [kg m², kg m, kg] of the joints that have a column, in the order of
        the columns, where these are not mixed.
    """

    joint_values: Sequence[Symbol]
    lower: Sequence[float]
    upper: Sequence[float]
    moving: Sequence[int]
    mass_matrix: Callable[[], Matrix]
    direction: Sequence[float] | None = None


def _never_too_large(rows: int, joints: int) -> str:  # noqa: ARG001  # a lambda could not be pickled
    return ""


@dataclass(frozen=True)
class Closed:
    """A measure in closed form.

    Attributes
    ----------
    record
        Takes a recorder, the m rows of the normalised Jacobian as expressions, and what else there is;
        returns the recorded value. It is differentiated by itself.
    too_large
        Takes the numbers of rows and of joints that may move, and says why the program would be too large for
        them; nothing where it is not.
    """

    record: Callable[[Recorder, Matrix, Symbols], Expr]
    too_large: Callable[[int, int], str] = _never_too_large


@dataclass(frozen=True)
class Spectral:
    """A measure that is a function of the smallest and the largest singular value.

    Attributes
    ----------
    combine
        Takes both as symbols and returns the value.
    """

    combine: Callable[[Expr, Expr], Expr]


@dataclass(frozen=True)
class Measure:
    """One dexterity index: what it is, what it means, and how it is computed.

    Attributes
    ----------
    name, aliases
        Its name in lower case, and others it is found under.
    title
        Name in full, for headings.
    formula
        In LaTeX; J is the normalised Jacobian of m rows, σ₁ ≥ … ≥ σ_m are its singular values.
    unit
        Of the value, where all rates are 1.
    meaning
        What a larger or smaller value means for a task, in one sentence.
    references
        Where it comes from.
    evaluate
        Takes normalised Jacobians (..., m, n) and the situation, and returns values (...).
    recorded
        How it is recorded for compilation, if it can be.
    bounds
        Least and largest value that it can take.
    larger_is_better
        Which end is the good one.
    needs
        What it needs besides the Jacobian.
    columns
        What the columns of the Jacobian are multiplied by: the largest rates of the joints, the noise of
        the joints, or 1 for each joint that may move (``"unit"``).
    full_rank
        Whether it is zero (or worse) wherever the tool cannot move along all rows.
    volume
        Whether it depends on the volume of the rows' ellipsoid alone, which is the same in all axes and, for
        all six rows, about every point.
    mixes_columns
        Whether it depends on J·Jᵀ alone, so that columns may be replaced by others with the same product.
    same_in_all_axes
        Whether it is the same in axes that are turned, for whole blocks of three rows with one scale.
    value_at_zero
        What a measure of full rank is where the tool cannot move along all rows.
    """

    name: str
    title: str
    formula: str
    unit: str
    meaning: str
    references: tuple[str, ...]
    evaluate: Callable[[Tensor, Situation], Tensor]
    recorded: Closed | Spectral | None = None
    aliases: tuple[str, ...] = ()
    bounds: tuple[float, float] = (0.0, math.inf)
    larger_is_better: bool = True
    needs: frozenset[Need] = frozenset()
    columns: Literal["rates", "noise", "unit"] = "rates"
    full_rank: bool = True
    volume: bool = False
    mixes_columns: bool = True
    same_in_all_axes: bool = True
    value_at_zero: float = 0.0
