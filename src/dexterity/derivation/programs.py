"""What an index of a chain needs, as programs of the joint values.

Examples
--------
>>> import dexterity as dx
>>> from dexterity.derivation import derive
>>> planar = dx.Chain.from_dh([{"a": 1}, {"a": 1}])
>>> derivation = derive(planar, dx.indices.Index("w", "geometric", rows=("vx", "vy")))
>>> derivation.kind, derivation.size, derivation.matters
('closed', 2, (1, 2))
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Literal

import sympy
from sympy import Expr, S, Symbol

from dexterity import operations
from dexterity.chain import Chain
from dexterity.derivation.jacobian import columns_of_joints, jacobian_rows, joint_values
from dexterity.derivation.mass_matrix import mass_matrix
from dexterity.derivation.symbolic_chain import SymbolicChain, number
from dexterity.elimination import (
    VANISHING,
    Matrix,
    bidiagonal_squares,
    determinant,
    dot,
    gram,
    in_columns_of_rows,
    schur_determinant,
    triangularise,
)
from dexterity.indices import Closed, Index, Measure, Spectral, Symbols, require_not_zero_everywhere
from dexterity.program import Program, Recorder, gradient

__all__ = ["Derivation", "derive"]


@dataclass(frozen=True)
class Derivation:
    """What an index of a chain needs, as programs of the joint values.

    Attributes
    ----------
    chain, index
        What was derived.
    joint_rates, tool_rates
        Weights in use: of the n columns of the Jacobian, which are the largest joint rates or the joints'
        noise, and of its six rows.
    link
        Number of the link whose axes the Jacobian is written in: 0 the base, n the tool's.
    reference
        Point that it is taken about: 0 the world's origin, i a point on the axis of joint i, n + 1 the
        tool's.
    """

    chain: SymbolicChain
    index: Index
    joint_rates: tuple[float, ...]
    tool_rates: tuple[float, ...]
    link: int
    reference: int

    @property
    def measure(self) -> Measure:
        """Measure of the index."""
        return self.index.measure

    @cached_property
    def kind(self) -> Literal["closed", "spectral", "numeric"]:
        """How the index is computed, by :attr:`value`, from :attr:`bidiagonal`, or by torch alone."""
        if self.not_recorded:
            return "numeric"
        return "closed" if isinstance(self.measure.recorded, Closed) else "spectral"

    @cached_property
    def not_recorded(self) -> str:
        """Why the index is not recorded as a program; nothing where it is."""
        recorded, name = self.measure.recorded, self.measure.name
        if recorded is None:
            return f"{name} is not recorded as a program"
        moving = sum(weight != 0 for weight in self.joint_rates)
        reason = recorded.too_large(self.size, moving) if isinstance(recorded, Closed) else ""
        return reason and f"{name} is not recorded as a program: {reason}"

    @property
    def size(self) -> int:
        """Number m of rows that count."""
        return len(self.index.row_numbers)

    @cached_property
    def joint_values(self) -> tuple[Symbol, ...]:
        """Symbols of the joints' values q1 … qn."""
        return joint_values(self.chain)

    @cached_property
    def values_as_given(self) -> tuple[Symbol, ...]:
        """Symbols of the joints' values for joint limits; unlike q1 … qn they may not be reduced to a turn.

        Empty for a measure that depends on no limits. They are inputs of :attr:`value` and of
        :attr:`value_and_gradient` after the joint values.
        """
        if "limits" not in self.measure.needs:
            return ()
        return sympy.symbols(f"p1:{self.chain.joints + 1}", real=True)

    def require_computable(self) -> None:
        """Make sure that the index can be computed from the joint values alone, and is not zero everywhere.

        Raises
        ------
        ValueError
            If lengths have no value, or the index is zero (or infinite) at all configurations.
        """
        require_not_zero_everywhere(self.index, self.chain.numeric())

    @cached_property
    def jacobian(self) -> Program:
        """Rows of the Jacobian that count, times the joint rates, m × n' outputs row by row.

        Locked joints have no column. Three translations that together weigh all directions alike stand at
        the end as multiples of the axes themselves. Turning the axes and shifting the point gives the
        Jacobian of the index; neither changes the index.
        """
        record = Recorder("x")
        rows = _rows(record, self.chain, self.index, self.joint_rates, self.link, self.reference)
        return record.program(self.joint_values, [x for row in rows for x in row])

    @cached_property
    def matters(self) -> tuple[int, ...]:
        """Numbers (from 1) of the joints that the index may depend on; on no other does it depend."""
        used = {self.joint_values.index(q) + 1 for q in self.jacobian.used_inputs}
        if self.kind == "closed" and self.values_as_given:
            places = (*self.joint_values, *self.values_as_given)
            used |= {places.index(p) % self.chain.joints + 1 for p in self.value.used_inputs}
        if "inertias" in self.measure.needs:
            used = {self.joint_values.index(q) + 1 for q in self.value.used_inputs}
        return tuple(sorted(used))

    # ---- closed forms ----

    @cached_property
    def value(self) -> Program:
        """Compute a measure in closed form, one output, from the joint values, and again as they are given.

        Raises
        ------
        ValueError
            If the measure has no closed form, or a direction needs more joints than can move.
        """
        recorded = self.measure.recorded
        if not isinstance(recorded, Closed):
            raise ValueError(f"{self.measure.name} has no closed form")
        inputs = (*self.joint_values, *self.values_as_given)
        record, rows, direction = self._usable_rows()
        if rows is None:
            return record.program(inputs, [sympy.nsimplify(self.measure.value_at_zero)])
        moving = [i for i, weight in enumerate(self.joint_rates) if weight]
        limits = (self.values_as_given or self.joint_values, self.chain.lower, self.chain.upper)
        symbols = Symbols(*limits, moving, lambda: self._mass_matrix(record), direction)
        return record.program(inputs, [recorded.record(record, rows, symbols)])

    def _mass_matrix(self, record: Recorder) -> Matrix:
        """Rows and columns of the mass matrix of the joints that have a column."""
        M = mass_matrix(record, self.chain, self.joint_values)
        columns = columns_of_joints(self.chain, self.joint_rates)
        return [[M[i][j] for j in columns] for i in columns]

    @cached_property
    def value_and_gradient(self) -> Program:
        """Compute a measure in closed form and its n derivatives."""
        program, n = gradient(self.value), self.chain.joints
        if not self.values_as_given:
            return program
        record = Recorder("g")
        outputs = record.replay(program)
        derivatives = [a + b for a, b in zip(outputs[1 : n + 1], outputs[n + 1 :], strict=True)]
        return record.program(program.inputs, [outputs[0], *derivatives])

    @property
    def manipulability(self) -> Program:
        """Compute w of the normalised Jacobian, by orthogonal elimination of J itself."""
        return self.value

    @cached_property
    def squared_manipulability(self) -> Program:
        """w² of the Jacobian times the joint rates, in closed form without tool rates.

        The square of the determinant of as many columns as rows; otherwise the determinant of J·Jᵀ, for six
        rows through the Schur complement of its first block where translations keep that regular.
        """
        record, rows = self._rows()
        if len(rows[0]) < self.size:
            return record.program(self.joint_values, [S.Zero])
        if len(rows[0]) == self.size:
            return record.program(self.joint_values, [record(determinant(record, rows) ** 2)])
        JJt = gram(record, rows)
        regular = self.size == 6 and all(rows[i][i - 3] != 0 and rows[i][i - 3].is_number for i in range(3))
        value = schur_determinant(record, JJt) if regular else determinant(record, JJt)
        return record.program(self.joint_values, [value])

    # ---- from singular values ----

    @cached_property
    def triangle(self) -> Program:
        """Lower triangle with the Jacobian's singular values, m (m + 1)/2 outputs row by row.

        For a measure that does not depend on the scale they are those up to a common factor. Everything is
        zero where fewer than m columns or rows can move.
        """
        record, rows, _ = self._usable_rows()
        if rows is None:
            return record.program(self.joint_values, [S.Zero] * (self.size * (self.size + 1) // 2))
        L, _ = triangularise(record, rows)
        return record.program(self.joint_values, [x for i, row in enumerate(L) for x in row[: i + 1]])

    @cached_property
    def bidiagonal(self) -> Program:
        """Squares of the 2m − 1 entries of L's bidiagonal form, divided by their sum."""
        program = self.bidiagonal_with_sum
        return program.leading_to(program.outputs[:-1])

    @cached_property
    def bidiagonal_with_sum(self) -> Program:
        """Outputs of :attr:`bidiagonal`, and the sum of the squares."""
        record = Recorder("x")
        L = _triangle(record.replay(self.triangle), self.size)
        squares = bidiagonal_squares(record, L)
        total = record(sympy.Add(*squares) + VANISHING)
        scale = record(1 / total)
        return record.program(self.joint_values, [*(square * scale for square in squares), total])

    @cached_property
    def combination(self) -> Program:
        """Compute the value and its derivatives by the smallest and by the largest singular value.

        Raises
        ------
        ValueError
            If the measure is no function of the two.
        """
        combine = self._spectral().combine
        smallest, largest = sympy.symbols("smallest largest", real=True)
        value = combine(smallest, largest)
        record = Recorder("t")
        outputs = [value, value.diff(smallest), value.diff(largest)]
        return record.program((smallest, largest), [record(sympy.sympify(x)) for x in outputs])

    @cached_property
    def spectral_gradient(self) -> Program:
        """Compute n derivatives from the singular vectors of the smallest and the largest singular value.

        Inputs beyond the joint values are a₁ … a_m, b₁ … b_m, c₁ … c_m, d₁ … d_m: of the triangle's smallest
        singular value the left vector times the derivative of the index by that singular value, and the
        right vector; then the same of the largest. With the orthogonal Q of J = L·Qᵀ the derivatives are
        aᵀ dJ Q b + cᵀ dJ Q d: nothing is divided by a small singular value.
        """
        m = self.size
        vectors = [sympy.symbols(f"{name}1:{m + 1}", real=True) for name in "abcd"]
        extra = [symbol for vector in vectors for symbol in vector]
        record, rows, _ = self._usable_rows()
        if rows is None:
            return record.program((*self.joint_values, *extra), [S.Zero] * self.chain.joints)
        columns = len(rows[0])
        a, b, c, d = vectors

        def weigh(record: Recorder, entries: list[Expr]) -> list[Expr]:
            J = [entries[i * columns : (i + 1) * columns] for i in range(m)]
            right_b, right_d = in_columns_of_rows(record, J, [b, d])
            return [record(a[i] * right_b[j] + c[i] * right_d[j]) for i in range(m) for j in range(columns)]

        entries = record.program(self.joint_values, [x for row in rows for x in row])
        program = gradient(entries, weigh, extra)
        return program.leading_to(program.outputs[columns * m :])

    def _spectral(self) -> Spectral:
        if not isinstance(self.measure.recorded, Spectral):
            raise ValueError(f"{self.measure.name} is no function of the extreme singular values")
        return self.measure.recorded

    # ---- rows ----

    def _rows(self) -> tuple[Recorder, Matrix]:
        record = Recorder("x")
        entries = record.replay(self.jacobian)
        m = len(entries) // self.size
        return record, [entries[i * m : (i + 1) * m] for i in range(self.size)]

    def _usable_rows(self) -> tuple[Recorder, Matrix | None, tuple[float, ...] | None]:
        """Rows of the normalised Jacobian and the direction, of six rows the angular ones first.

        None in place of the rows where a measure of full rank cannot have it: because too few joints can
        move, or a row is zero.
        """
        record, rows = self._rows()
        rows = self._scaled(record, rows)
        direction = self.index.direction if isinstance(self.index.direction, tuple) else None
        if self.size == 6 and self.index.rows == "full":
            rows = rows[3:] + rows[:3]
            direction = direction and direction[3:] + direction[:3]
        deficient = len(rows[0]) < self.size or not all(any(row) for row in rows)
        return record, None if deficient and self.measure.full_rank else rows, direction

    def _scaled(self, record: Recorder, rows: Matrix) -> Matrix:
        """Divide the rows by the tool rates."""
        rates = [self.tool_rates[row] for row in self.index.row_numbers]
        if _turnable(self.index) and self.measure.volume:
            # Whichever axes the rows are in, their volume is divided by the product.
            return [record.all(number(1 / math.prod(rates)) * x for x in rows[0]), *rows[1:]]
        return [record.all(number(1 / rate) * x for x in row) for row, rate in zip(rows, rates, strict=True)]


def derive(chain: Chain | SymbolicChain, index: Index) -> Derivation:
    """Derive the Jacobian behind an index, in the axes and about the point that make it shortest.

    Parameters
    ----------
    chain
        A chain, or one with symbols for lengths.
    index
        Name, frame, rows and limits. The tool rates of a frame may differ within a block of three; the axes
        are then those of the frame, as they are for a selection of rows and for a direction.

    Raises
    ------
    ValueError
        If the rates do not fit the chain.
    TypeError
        If `chain` is no chain or `index` no index.
    """
    if not isinstance(index, Index):
        raise TypeError(f"index is {index!r}; an Index is needed, such as Index('manipulability')")
    return _derived(SymbolicChain.of(chain), index)


# Of an index, torch and C, value and gradient, file and costs are often wanted one after the other.
@lru_cache(maxsize=16)
def _derived(chain: SymbolicChain, index: Index) -> Derivation:
    weights = index.column_weights(chain.rates)

    everywhere = range(chain.joints + 1)
    tool = chain.joints + 1
    point = 0 if index.frame == "spatial" else tool
    own_axes = chain.joints if index.frame == "body" else 0
    links = everywhere if _turnable(index) else [own_axes]
    if _shiftable(index):
        # Two short searches in place of all pairs: the link, with its own two points, then the point.
        beside = [(k, p) for k in links for p in (k, k + 1) if 1 <= p <= chain.joints]
        link, _ = _shortest(chain, index, weights, beside)
        places = [(link, p) for p in range(1, chain.joints + 1)]
    else:
        places = [(k, point) for k in links]
    link, reference = _shortest(chain, index, weights, places)
    return Derivation(chain, index, weights, index.row_scales, link, reference)


def _turnable(index: Index) -> bool:
    """Whether the index is the same in all axes: for whole blocks of rows with one scale in each of them."""
    if not isinstance(index.rows, str) or index.direction is not None or not index.measure.same_in_all_axes:
        return False
    blocks = ({index.row_scales[row] for row in index.row_numbers if row // 3 == block} for block in (0, 1))
    return index.measure.volume or all(len(scales) <= 1 for scales in blocks)


def _shiftable(index: Index) -> bool:
    """Whether the index is the same about every point."""
    return _turnable(index) and (
        index.rows == "rotational" or (index.measure.volume and index.rows == "full")
    )


def _shortest(
    chain: SymbolicChain, index: Index, weights: Sequence[float], places: Sequence[tuple[int, int]]
) -> tuple[int, int]:
    """Link and reference point about which the Jacobian takes the fewest operations."""
    q = joint_values(chain)

    def cost(place: tuple[int, int]) -> int:
        record = Recorder()
        rows = _rows(record, chain, index, weights, *place)
        program = record.program(q, [x for column in zip(*rows, strict=True) for x in column])
        return operations.count(expression for _, expression in program.steps).total

    return min(places, key=cost)


def _rows(
    record: Recorder,
    chain: SymbolicChain,
    index: Index,
    weights: Sequence[float],
    link: int,
    reference: int,
) -> Matrix:
    """Rows of the weighed Jacobian that count, in the axes of a link or, where these matter, of the frame."""
    mix = index.measure.mixes_columns
    rows = jacobian_rows(record, chain, weights, joint_values(chain), link, reference, mix)
    if index.frame == "body" and not _turnable(index):
        # The last link at home lies on the world's axes; the tool may be turned in it.
        turned = [[chain.tool_axes[k][i] for k in range(3)] for i in range(3)]
        rows = [
            record.all(dot(axis, column) for column in zip(*block, strict=True))
            for block in (rows[:3], rows[3:])
            for axis in turned
        ]
    return [rows[row] for row in index.row_numbers]


def _triangle(entries: Sequence[Expr], size: int) -> Matrix:
    """Rows of a lower triangle, filled up with zeros."""
    rows, start = [], 0
    for i in range(size):
        rows.append([*entries[start : start + i + 1], *[S.Zero] * (size - 1 - i)])
        start += i + 1
    return rows
