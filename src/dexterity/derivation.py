"""Jacobians and dexterity indices of a chain, derived in sines and cosines of its joints.

The lengths of the chain are numbers or symbols. A rotation of the axes changes neither index, and w does
not depend on the reference point either. The Jacobian is therefore written in the axes of the link, and for
w about the point, that give the fewest operations. Neighbouring parallel axes become one rotation by the sum
of their angles. Joints on which the Jacobian does not depend appear in no step. Joints that cancel only by
an identity of sines and cosines are not recognised.

Examples
--------
A planar arm with links of 0.5 m and 0.25 m. Its Jacobian about the tool is shortest in the axes of link 1,
which turn with q1, so that q1 is not needed:

>>> from dexterity.chain import Chain
>>> from dexterity.indices import Index
>>> arm = Chain.from_dh([{"a": 0.5}, {"a": 0.25}])
>>> derivation = derive(arm, Index("kinematic_conditioning", "geometric"))
>>> derivation.link, derivation.reference, derivation.matters
(1, 3, (2,))

The recorded program names each expression once. The vector from joint 2 to the tool is (x4, x5), from
joint 1 it is (x6, x5). x2 and x3 named expressions that no output needs:

>>> for name, expression in derivation.jacobian.steps:
...     print(name, "=", expression.evalf(3))
x0 = sin(q2)
x1 = cos(q2)
x4 = 0.25*x1
x5 = 0.25*x0
x6 = x4 + 0.5

Its outputs are the 6 × 2 Jacobian [v; ω] row by row. Both joints turn about z:

>>> for i in range(0, 12, 2):
...     print(derivation.jacobian.outputs[i : i + 2])
(-x5, -x5)
(x6, x4)
(0, 0)
(0, 0)
(0, 0)
(1, 1)

References
----------
Murray, Li & Sastry (1994), section 3.4; Golub & Van Loan (2013), sections 5.2 and 8.6.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import groupby, pairwise
from typing import TypeAlias

import numpy as np
import sympy
import torch
from sympy import Expr, S, Symbol

from dexterity import operations, robots
from dexterity.chain import Chain, JointKind
from dexterity.elimination import (
    VANISHING,
    Matrix,
    bidiagonal_squares,
    determinant,
    dot,
    gram,
    schur_determinant,
    triangularise,
)
from dexterity.indices import Index, normalise
from dexterity.program import Program, Recorder, gradient

__all__ = ["Derivation", "SymbolicChain", "derive", "exact"]

Vector: TypeAlias = tuple[Expr, Expr, Expr]
"""Three expressions."""


@dataclass(frozen=True)
class SymbolicChain:
    """A chain whose lengths may be symbols.

    Attributes
    ----------
    name, joint_names, kinds
        As of :class:`dexterity.chain.Chain`.
    axes
        Unit vector along each joint at home, in the world frame; numbers.
    points
        A point of each axis at home [m]; numbers or symbols.
    tool
        Origin of the tool at home [m].
    tool_axes
        (3, 3) rotation of the tool at home; numbers.
    rates
        Largest joint rates.
    lower, upper
        Joint limits.
    """

    name: str
    joint_names: tuple[str, ...]
    kinds: tuple[JointKind, ...]
    axes: tuple[Vector, ...]
    points: tuple[Vector, ...]
    tool: Vector
    tool_axes: tuple[Vector, ...]
    rates: tuple[float, ...]
    lower: tuple[float, ...]
    upper: tuple[float, ...]

    @classmethod
    def from_chain(cls, chain: Chain) -> SymbolicChain:
        """Take a chain of numbers; a number within rounding of an integer becomes that integer."""
        return cls._from_parts(chain, exact(chain.screws.numpy()), exact(chain.home.numpy()))

    @classmethod
    def from_description(cls, description: robots.Description) -> SymbolicChain:
        """Take a described robot with its lengths as symbols of their names.

        Screws and home pose are affine in the lengths, so that setting one of them to one at a time gives
        their coefficients.
        """
        zero = dict.fromkeys(description.lengths, 0.0)
        chain = robots.build(description, zero)
        screws, home = chain.screws, chain.home
        symbolic_screws, symbolic_home = exact(screws.numpy()), exact(home.numpy())
        for length in description.lengths:
            unit = robots.build(description, zero | {length: 1.0})
            symbol = Symbol(length, real=True)
            symbolic_screws = symbolic_screws + symbol * exact((unit.screws - screws).numpy())
            symbolic_home = symbolic_home + symbol * exact((unit.home - home).numpy())
        return cls._from_parts(chain, symbolic_screws, symbolic_home)

    @classmethod
    def _from_parts(cls, chain: Chain, screws: np.ndarray, home: np.ndarray) -> SymbolicChain:
        axes, points = [], []
        before = np.array([S.Zero] * 3)
        for kind, screw in zip(chain.kinds, screws, strict=True):
            v, omega = screw[:3], screw[3:]
            if kind == "revolute":
                # Of each axis the point nearest to the point before, for many zeros in the vectors between
                # them: ω × v is nearest to the world's origin, the rest lies along the axis.
                nearest = np.cross(omega, v)
                before = _tidy(nearest + omega * (omega @ (before - nearest)))
            axes.append(tuple(v if kind == "prismatic" else omega))
            points.append(tuple(before))
        return cls(
            chain.name, chain.joint_names, chain.kinds, tuple(axes), tuple(points),
            tuple(home[:3, 3]), tuple(tuple(row) for row in home[:3, :3]),
            *(tuple(values.tolist()) for values in (chain.rates, chain.lower, chain.upper)),
        )  # fmt: skip

    @property
    def joints(self) -> int:
        """Number of joints n."""
        return len(self.kinds)

    @property
    def lengths(self) -> tuple[Symbol, ...]:
        """Symbols that have no value yet."""
        free = set().union(*(x.free_symbols for vector in (*self.points, self.tool) for x in vector))
        return tuple(sorted(free, key=str))

    def require_computable(self, index: str) -> None:
        """Make sure that an index of all six rows can be computed from the joint values alone.

        Raises
        ------
        ValueError
            If lengths have no value, or there are too few joints for six rows.
        """
        if self.lengths:
            raise ValueError(f"{self.name} has lengths without a value: {', '.join(map(str, self.lengths))}")
        if self.joints < 6:
            raise ValueError(
                f"{self.name} has {self.joints} joints; with fewer than 6 the {index.replace('_', ' ')} "
                "of all six rows is zero everywhere"
            )

    def numbers(self) -> tuple[object, ...]:
        """Return what the chain is made of in built-in types, for a content key; lengths must be numbers."""
        vectors = (self.axes, self.points, (self.tool,), self.tool_axes)
        geometry = tuple(tuple(tuple(map(float, v)) for v in group) for group in vectors)
        return (self.name, self.joint_names, self.kinds, geometry, self.rates, self.lower, self.upper)


@dataclass(frozen=True)
class Derivation:
    """What an index of a chain needs, as programs of the joint values.

    Attributes
    ----------
    chain, index
        What was derived.
    joint_rates, tool_rates
        Limits in use, of n joints and of six tool velocities.
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

    @cached_property
    def joint_values(self) -> tuple[Symbol, ...]:
        """Symbols of the joints' values q1 … qn."""
        return _joint_values(self.chain)

    @cached_property
    def jacobian(self) -> Program:
        """Jacobian times the joint rates, 6 × m outputs row by row, linear velocity first.

        Locked joints have no column. Three translations that together weigh all directions alike stand at
        the end as multiples of the axes themselves. Turning the axes and shifting the point gives the
        Jacobian of the index; neither changes the index.
        """
        record = Recorder("x")
        columns = _jacobian_columns(
            record, self.chain, self.joint_rates, self.joint_values, self.link, self.reference
        )
        return record.program(self.joint_values, [x for row in zip(*columns, strict=True) for x in row])

    @cached_property
    def matters(self) -> tuple[int, ...]:
        """Numbers (from 1) of the joints that the Jacobian uses; on no other does the index depend."""
        return tuple(self.joint_values.index(q) + 1 for q in self.jacobian.used_inputs)

    @cached_property
    def squared_manipulability(self) -> Program:
        """w² of the Jacobian times the joint rates, in closed form without tool rates.

        The square of the determinant of six columns; otherwise the determinant of J·Jᵀ, through the Schur
        complement of its first block where translations keep that regular.
        """
        record, rows = self._rows()
        if len(rows[0]) < 6:
            return record.program(self.joint_values, [S.Zero])
        if len(rows[0]) == 6:
            return record.program(self.joint_values, [record(determinant(record, rows) ** 2)])
        JJt = gram(record, rows)
        regular = all(rows[i][i - 3] != 0 and rows[i][i - 3].is_number for i in range(3))
        value = schur_determinant(record, JJt) if regular else determinant(record, JJt)
        return record.program(self.joint_values, [value])

    @cached_property
    def manipulability(self) -> Program:
        """Compute w of the normalised Jacobian, by orthogonal elimination of J itself."""
        record, rows = self._eliminable_rows()
        if rows is None:
            return record.program(self.joint_values, [S.Zero])
        _, squares = triangularise(record, rows)
        root = record(sympy.sqrt(record(sympy.Mul(*squares) + VANISHING)))
        return record.program(self.joint_values, [_number(1 / math.prod(self.tool_rates)) * root])

    @cached_property
    def manipulability_gradient(self) -> Program:
        """Compute w and its n derivatives."""
        return gradient(self.manipulability)

    @cached_property
    def triangle(self) -> Program:
        """Lower triangle with the Jacobian's singular values up to a common factor, 21 outputs row by row.

        Everything is zero where fewer than six columns or rows can move.
        """
        record, rows = self._eliminable_rows()
        if rows is None:
            return record.program(self.joint_values, [S.Zero] * 21)
        L, _ = triangularise(record, rows)
        return record.program(self.joint_values, [x for i, row in enumerate(L) for x in row[: i + 1]])

    @cached_property
    def bidiagonal(self) -> Program:
        """Squares of the eleven entries of L's bidiagonal form, divided by their sum."""
        record = Recorder("x")
        L = _triangle(record.replay(self.triangle))
        squares = bidiagonal_squares(record, L)
        scale = record(1 / record(sympy.Add(*squares) + VANISHING))
        return record.program(self.joint_values, [square * scale for square in squares])

    @cached_property
    def conditioning_gradient(self) -> Program:
        """Compute the n derivatives of KCI from the singular vectors that belong to its two singular values.

        Inputs beyond the joint values are a₁ … a₆ and b₁ … b₆: the left singular vectors (in the row order
        of :attr:`triangle`) of the smallest and the largest singular value, times √KCI and divided by their
        singular value. Then dKCI = aᵀ dJ Jᵀ a − bᵀ dJ Jᵀ b.
        """
        vectors = sympy.symbols("a1:7 b1:7", real=True)
        record, rows = self._eliminable_rows()
        if rows is None:
            return record.program((*self.joint_values, *vectors), [S.Zero] * self.chain.joints)
        m = len(rows[0])

        def weigh(record: Recorder, entries: list[Expr]) -> list[Expr]:
            columns = [entries[j::m] for j in range(m)]
            a_J, b_J = ([record(dot(x, column)) for column in columns] for x in (vectors[:6], vectors[6:]))
            return [
                record(a * a_J[j] - b * b_J[j])
                for a, b in zip(vectors[:6], vectors[6:], strict=True)
                for j in range(m)
            ]

        program = gradient(
            record.program(self.joint_values, [x for row in rows for x in row]), weigh, vectors
        )
        return program.leading_to(program.outputs[6 * m :])

    def _rows(self) -> tuple[Recorder, Matrix]:
        record = Recorder("x")
        entries = record.replay(self.jacobian)
        m = len(entries) // 6
        return record, [entries[i * m : (i + 1) * m] for i in range(6)]

    def _eliminable_rows(self) -> tuple[Recorder, Matrix | None]:
        """Rows of the normalised Jacobian, angular ones first; None where its rank is below six for all q."""
        record, rows = self._rows()
        if len(rows[0]) < 6 or any(not any(row) for row in rows):
            return record, None
        if self.index.name != "manipulability":
            rows = self._scaled_by_tool_rates(record, rows)
        return record, rows[3:] + rows[:3]

    def _scaled_by_tool_rates(self, record: Recorder, rows: Matrix) -> Matrix:
        linear, angular = self.tool_rates[:3], self.tool_rates[3:]
        if len(set(linear)) == len(set(angular)) == 1:
            ratio = _number(linear[0] / angular[0])
            return rows[:3] + [record.all(ratio * x for x in row) for row in rows[3:]]
        if self.index.frame == "body":
            rows = [
                record.all(
                    dot([self.chain.tool_axes[k][i] for k in range(3)], column)
                    for column in zip(*block, strict=True)
                )
                for block in (rows[:3], rows[3:])
                for i in range(3)
            ]
        return [
            record.all(_number(1 / rate) * x for x in row)
            for row, rate in zip(rows, self.tool_rates, strict=True)
        ]


def derive(chain: Chain | SymbolicChain, index: Index) -> Derivation:
    """Derive the Jacobian behind an index, in the axes and about the point that make it shortest.

    Parameters
    ----------
    chain
        A chain, or one with symbols for lengths.
    index
        Name, frame and limits. The tool rates of a frame may differ within a block of three; the axes are
        then those of the frame.

    Raises
    ------
    ValueError
        If the rates do not fit the chain.
    """
    chain = chain if isinstance(chain, SymbolicChain) else SymbolicChain.from_chain(chain)
    known = index.name in ("manipulability", "kinematic_conditioning") and index.rows == "full"
    if not known or index.characteristic_length is not None:
        raise ValueError(f"index is {index!r}; w and KCI of all six rows can be derived so far")
    joint_rates = chain.rates if index.joint_rates is None else index.joint_rates
    tool_rates = (1.0,) * 6 if index.tool_rates is None else index.tool_rates
    normalise(torch.zeros(6, chain.joints), joint_rates, tool_rates)

    everywhere = range(chain.joints + 1)
    if index.name == "manipulability":  # the same about every point and in all axes
        # Two short searches in place of all pairs: the link, with its own two points, then the point.
        beside = [(k, p) for k in everywhere for p in (k, k + 1) if 1 <= p <= chain.joints]
        link, _ = _shortest(chain, joint_rates, beside)
        link, reference = _shortest(chain, joint_rates, [(link, p) for p in range(1, chain.joints + 1)])
    else:
        reference = 0 if index.frame == "spatial" else chain.joints + 1
        own_axes = chain.joints if index.frame == "body" else 0
        turnable = len(set(tool_rates[:3])) == len(set(tool_rates[3:])) == 1
        link, reference = _shortest(
            chain, joint_rates, [(k, reference) for k in (everywhere if turnable else [own_axes])]
        )
    return Derivation(chain, index, joint_rates, tool_rates, link, reference)


def _shortest(
    chain: SymbolicChain, rates: Sequence[float], places: Sequence[tuple[int, int]]
) -> tuple[int, int]:
    """Link and reference point about which the Jacobian takes the fewest operations."""
    q = _joint_values(chain)

    def cost(place: tuple[int, int]) -> int:
        record = Recorder()
        columns = _jacobian_columns(record, chain, rates, q, *place)
        program = record.program(q, [x for column in columns for x in column])
        return operations.count(expression for _, expression in program.steps).total

    return min(places, key=cost)


def _joint_values(chain: SymbolicChain) -> tuple[Symbol, ...]:
    return sympy.symbols(f"q1:{chain.joints + 1}", real=True)


def _jacobian_columns(
    record: Recorder,
    chain: SymbolicChain,
    rates: Sequence[float],
    q: Sequence[Symbol],
    link: int,
    reference: int,
) -> Matrix:
    """Columns [v; ω] times the joint rates; translations that weigh all directions alike come last."""
    geometry = _GeometryInLink(record, chain, q, link)
    turning, sliding, alike = [], [], []
    for i, kind in enumerate(chain.kinds):
        if kind == "revolute" and rates[i]:
            axis = geometry.axes[i]
            # v = ω × (reference − point) = (point − reference) × ω
            linear = _cross(geometry.between(reference, i + 1), axis)
            turning.append(record.all(_number(rates[i]) * record(x) for x in (*linear, *axis)))
    for group in _neighbouring_translations(chain.kinds):
        common = _common_rate([chain.axes[i] for i in group], [rates[i] for i in group])
        if common is not None:
            # Three slides whose JJᵀ is a multiple of the identity have it in all axes: no rotation is needed.
            alike += [[_number(common) * int(i == j) for j in range(6)] for i in range(3)]
        else:
            moving = [i for i in group if rates[i]]
            sliding += [
                record.all(_number(rates[i]) * x for x in geometry.axes[i]) + [S.Zero] * 3 for i in moving
            ]
    return turning + sliding + alike


def _neighbouring_translations(kinds: Sequence[JointKind]) -> list[list[int]]:
    """Prismatic joints, those together that no revolute joint separates."""
    runs = groupby(range(len(kinds)), key=lambda i: kinds[i])
    return [list(run) for kind, run in runs if kind == "prismatic"]


def _common_rate(axes: Sequence[Vector], rates: Sequence[float]) -> float | None:
    """Rate in every direction of translations that weigh all directions alike, else None."""
    weighted = np.array(axes, dtype=float).T * np.array(rates)
    weights = weighted @ weighted.T
    common = float(weights[0, 0])
    alike = np.allclose(weights, common * np.eye(3), rtol=0, atol=_ROUNDING * common)
    return math.sqrt(common) if common > 0 and alike else None


class _GeometryInLink:
    """Axes of all joints, and vectors between their points, in the axes of one link.

    Rotations are multiplied from that link outwards, in both directions. A joint does not turn its own axis,
    so that an axis depends only on the joints between it and the link.
    """

    def __init__(self, record: Recorder, chain: SymbolicChain, q: Sequence[Symbol], link: int) -> None:
        self._record = record
        self._rotations: dict[int, Matrix] = {link: [[S(int(i == j)) for j in range(3)] for i in range(3)]}
        self.axes: dict[int, list[Expr]] = {}
        self._rotate_past(chain, [(i, i, i + 1, q[i]) for i in range(link, chain.joints)])
        self._rotate_past(chain, [(i, i + 1, i, -q[i]) for i in reversed(range(link))])

        points = [(S.Zero,) * 3, *chain.points, chain.tool]
        self._steps = []
        for i, (start, end) in enumerate(pairwise(points)):
            step = _tidy(np.subtract(end, start))
            # A slide carries all that follows it along its axis.
            if i > 0 and chain.kinds[i - 1] == "prismatic":
                step = step + q[i - 1] * np.array(chain.axes[i - 1])
            nearest = self._nearest_link(chain, link, i, list(step))
            self._steps.append(_apply(record, self._rotations[nearest], list(step)))

    @staticmethod
    def _nearest_link(chain: SymbolicChain, link: int, i: int, vector: Sequence[Expr]) -> int:
        """Link nearest to `link` in which a vector of link i is constant too.

        A vector along the axis of a joint is the same in both links of that joint: no rotation is needed.
        """
        while i > link and _parallel(chain.axes[i - 1], vector):
            i -= 1
        while i < link and _parallel(chain.axes[i], vector):
            i += 1
        return i

    def between(self, start: int, end: int) -> list[Expr]:
        """Vector from one point to another: 0 the world's origin, i on joint i, n + 1 the tool."""
        if start > end:
            return [-x for x in self.between(end, start)]
        # Summed from the end, so that the vectors to the tool from different joints share their sums.
        vector = [S.Zero] * 3
        for step in reversed(self._steps[start:end]):
            vector = self._record.all(a + b for a, b in zip(step, vector, strict=True))
        return vector

    def _rotate_past(self, chain: SymbolicChain, joints: Iterable[tuple[int, int, int, Expr]]) -> None:
        """Rotations behind joints (number, link before, link behind, angle), one for parallel neighbours."""
        base: Matrix = []
        along: Sequence[Expr] = ()
        angle = S.Zero
        for i, before, behind, value in joints:
            axis, rotation = chain.axes[i], self._rotations[before]
            self.axes[i] = _apply(self._record, rotation, axis)
            if chain.kinds[i] == "revolute":
                # Parallel to the joint before: its rotation is replaced by one about the sum of the angles.
                if along == axis:
                    angle = angle + value
                elif along == tuple(-x for x in axis):
                    angle = angle - value
                else:
                    base, along, angle = rotation, axis, value
                rotation = _product(self._record, base, _rotation(self._record, along, angle))
            self._rotations[behind] = rotation


def _rotation(record: Recorder, axis: Sequence[Expr], angle: Expr) -> Matrix:
    """Rodrigues' formula; Murray, Li & Sastry (1994), Eq. 2.14."""
    # Of q and −q only q is used, so that both directions of the chain share its sine.
    if angle.could_extract_minus_sign():
        axis, angle = [-x for x in axis], -angle
    x, y, z = axis
    sine, cosine = record(sympy.sin(record(angle))), record(sympy.cos(record(angle)))
    # About an axis of the frame no product of two components is left, and 1 - cos is not needed.
    rest = record(1 - cosine) if sum(a != 0 for a in axis) > 1 else 1 - cosine
    across = [[S.Zero, -z, y], [z, S.Zero, -x], [-y, x, S.Zero]]
    return [
        record.all(int(i == j) * cosine + axis[i] * axis[j] * rest + sine * across[i][j] for j in range(3))
        for i in range(3)
    ]


def _apply(record: Recorder, rotation: Matrix, vector: Sequence[Expr]) -> list[Expr]:
    return record.all(dot(row, vector) for row in rotation)


def _product(record: Recorder, A: Matrix, B: Matrix) -> Matrix:
    return [record.all(dot(row, column) for column in zip(*B, strict=True)) for row in A]


def _cross(a: Sequence[Expr], b: Sequence[Expr]) -> list[Expr]:
    (ax, ay, az), (bx, by, bz) = a, b
    return [ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx]


def _parallel(a: Sequence[Expr], b: Sequence[Expr]) -> bool:
    return all(x == 0 for x in _tidy(_cross(a, b)))


def _triangle(entries: Sequence[Expr]) -> Matrix:
    """Rows of a lower triangle, filled up with zeros."""
    rows, start = [], 0
    for i in range(6):
        rows.append([*entries[start : start + i + 1], *[S.Zero] * (5 - i)])
        start += i + 1
    return rows


def exact(array: np.ndarray) -> np.ndarray:
    """Convert numbers to sympy's; a number within rounding of an integer becomes that integer."""
    return np.array([_number(x) for x in array.ravel()], dtype=object).reshape(array.shape)


def _number(x: float) -> Expr:
    return sympy.Integer(round(x)) if abs(x - round(x)) < _ROUNDING else sympy.Float(x)


def _tidy(vector: Iterable[Expr]) -> np.ndarray:
    return np.array([_number(float(x)) if x.is_number else sympy.expand(x) for x in vector], dtype=object)


_ROUNDING = 1e-14
