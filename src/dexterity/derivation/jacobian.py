"""Jacobians of a chain, recorded in the axes of one link and about one point.

A rotation is multiplied from that link outwards, and neighbouring parallel axes become one rotation by the
sum of their angles.

Examples
--------
>>> import dexterity as dx
>>> from dexterity.derivation import SymbolicChain
>>> from dexterity.derivation.jacobian import joint_values, jacobian_rows
>>> from dexterity.program import Recorder
>>> arm = SymbolicChain.from_chain(dx.Chain.from_dh([{"a": 1}, {"a": 1}]))
>>> record = Recorder()
>>> rows = jacobian_rows(record, arm, (1.0, 1.0), joint_values(arm), link=1, reference=3)
>>> program = record.program(joint_values(arm), rows[0])
>>> program.steps, program.outputs
(((x0, sin(q2)),), (-x0, -x0))
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from itertools import groupby, pairwise

import numpy as np
import sympy
from sympy import Expr, S, Symbol

from dexterity.chain import JointKind
from dexterity.derivation.symbolic_chain import ROUNDING, SymbolicChain, Vector, cross, number, tidy
from dexterity.elimination import Matrix, dot
from dexterity.program import Recorder

__all__ = ["columns_of_joints", "jacobian_rows", "joint_rotation", "joint_values"]


def joint_values(chain: SymbolicChain) -> tuple[Symbol, ...]:
    """Symbols q1 … qn of the values of the joints."""
    return sympy.symbols(f"q1:{chain.joints + 1}", real=True)


def jacobian_rows(
    record: Recorder,
    chain: SymbolicChain,
    weights: Sequence[float],
    q: Sequence[Symbol],
    link: int,
    reference: int,
    mix: bool = True,
) -> Matrix:
    """Six rows [v; ω] of the Jacobian, one column for each joint that is not locked.

    Parameters
    ----------
    record
        What records.
    chain
        The robot.
    weights
        What the n columns are multiplied by, such as the largest joint rates; 0 leaves a column out.
    q
        Symbols of the joint values.
    link
        Number of the link whose axes are used: 0 the base, n the tool's.
    reference
        Point that velocities are taken at: 0 the world's origin, i a point of the axis of joint i, n + 1 the
        tool's.
    mix
        Whether translations that weigh all directions alike may be replaced by others with the same J·Jᵀ,
        which need no rotation. They stand last.
    """
    geometry = _GeometryInLink(record, chain, q, link)
    turning, sliding, alike = [], [], []
    for i, kind in enumerate(chain.kinds):
        if kind == "revolute" and weights[i]:
            axis = geometry.axes[i]
            # v = ω × (reference − point) = (point − reference) × ω
            linear = cross(geometry.between(reference, i + 1), axis)
            turning.append(record.all(number(weights[i]) * record(x) for x in (*linear, *axis)))
    for group in _neighbouring_translations(chain.kinds):
        common = _common_rate([chain.axes[i] for i in group], [weights[i] for i in group])
        if mix and common is not None:
            alike += [[number(common) * int(i == j) for j in range(6)] for i in range(3)]
        else:
            moving = [i for i in group if weights[i]]
            sliding += [
                record.all(number(weights[i]) * x for x in geometry.axes[i]) + [S.Zero] * 3 for i in moving
            ]
    columns = turning + sliding + alike
    return [[column[row] for column in columns] for row in range(6)]


def columns_of_joints(chain: SymbolicChain, weights: Sequence[float]) -> list[int]:
    """Numbers, from 0, of the joints whose columns :func:`jacobian_rows` returns, where it mixes none."""
    return [
        i
        for wanted in ("revolute", "prismatic")
        for i, kind in enumerate(chain.kinds)
        if kind == wanted and weights[i]
    ]


def _neighbouring_translations(kinds: Sequence[JointKind]) -> list[list[int]]:
    """Prismatic joints, those together that no revolute joint separates."""
    runs = groupby(range(len(kinds)), key=lambda i: kinds[i])
    return [list(run) for kind, run in runs if kind == "prismatic"]


def _common_rate(axes: Sequence[Vector], rates: Sequence[float]) -> float | None:
    """Rate in every direction of translations that weigh all directions alike, else None."""
    weighted = np.array(axes, dtype=float).T * np.array(rates)
    weights = weighted @ weighted.T
    common = float(weights[0, 0])
    alike = np.allclose(weights, common * np.eye(3), rtol=0, atol=ROUNDING * common)
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
            step = tidy(np.subtract(end, start))
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
                rotation = _product(self._record, base, joint_rotation(self._record, along, angle))
            self._rotations[behind] = rotation


def joint_rotation(record: Recorder, axis: Sequence[Expr], angle: Expr) -> Matrix:
    """Rotation about an axis by Rodrigues' formula; Murray, Li & Sastry (1994), Eq. 2.14."""
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


def _parallel(a: Sequence[Expr], b: Sequence[Expr]) -> bool:
    return all(x == 0 for x in tidy(cross(a, b)))
