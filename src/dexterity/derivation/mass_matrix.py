"""Mass matrix of a chain, recorded in the axes that its links have at home.

Composite rigid bodies: from the tool to the base, the inertia of all that moves with a joint is carried past
that joint, and so is the momentum that a unit rate of the joint gives to it.

Examples
--------
A uniform rod of 3 kg and 1 m about its end, m l² / 3:

>>> import dexterity as dx
>>> from dexterity.derivation import SymbolicChain
>>> from dexterity.derivation.jacobian import joint_values
>>> from dexterity.derivation.mass_matrix import mass_matrix
>>> from dexterity.program import Recorder
>>> tensor = [[0, 0, 0], [0, 0.25, 0], [0, 0, 0.25]]
>>> rod = dx.Chain.from_dh([{"a": 1.0}], inertias=([3.0], [[0.5, 0, 0]], [tensor]))
>>> symbolic = SymbolicChain.from_chain(rod)
>>> mass_matrix(Recorder(), symbolic, joint_values(symbolic))
[[1]]

References
----------
Featherstone, Rigid Body Dynamics Algorithms (2008), section 6.2.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from sympy import Expr, S, Symbol

from dexterity.derivation.jacobian import joint_rotation
from dexterity.derivation.symbolic_chain import SymbolicChain, cross, exact, number, tidy
from dexterity.elimination import Matrix, dot
from dexterity.program import Recorder

__all__ = ["mass_matrix"]


def mass_matrix(record: Recorder, chain: SymbolicChain, q: Sequence[Symbol]) -> Matrix:
    """Return the n × n mass matrix, all of its entries recorded.

    Raises
    ------
    ValueError
        If the chain has no inertias.
    """
    n = chain.joints
    bodies = _bodies(chain)
    passages = [_Passage(record, chain, q, k) for k in range(n)]
    M = [[S.Zero] * n for _ in range(n)]
    body = None
    for k in reversed(range(n)):
        body = bodies[k] if body is None else bodies[k].with_other(record, passages[k + 1].body(body))
        linear, angular = body.momentum(record, chain, k)
        M[k][k] = _along(record, chain, k, linear, angular)
        for j in reversed(range(k)):
            linear, angular = passages[j + 1].momentum(linear, angular)
            M[j][k] = M[k][j] = _along(record, chain, j, linear, angular)
    return M


def _along(
    record: Recorder, chain: SymbolicChain, joint: int, linear: Sequence[Expr], angular: Sequence[Expr]
) -> Expr:
    """Part of a momentum, taken about a point of a joint's axis, that acts on that joint."""
    return record(dot(chain.axes[joint], angular if chain.kinds[joint] == "revolute" else linear))


@dataclass(frozen=True)
class _Body:
    """A rigid body in the axes of a link.

    Attributes
    ----------
    mass
        [kg].
    moment
        Mass times the vector from a point to the centre of mass [kg m].
    tensor
        3 × 3 inertia about that point [kg m²].
    """

    mass: Expr
    moment: Sequence[Expr]
    tensor: Matrix

    def with_other(self, record: Recorder, other: _Body) -> _Body:
        """Return both together, about the same point."""
        rows = zip(self.tensor, other.tensor, strict=True)
        return _Body(
            self.mass + other.mass,
            record.all(a + b for a, b in zip(self.moment, other.moment, strict=True)),
            [record.all(a + b for a, b in zip(*pair, strict=True)) for pair in rows],
        )

    def momentum(self, record: Recorder, chain: SymbolicChain, joint: int) -> tuple[list[Expr], list[Expr]]:
        """Linear and angular momentum at the unit rate of a joint, about a point of its axis."""
        axis = chain.axes[joint]
        if chain.kinds[joint] == "prismatic":
            return [self.mass * x for x in axis], record.all(cross(self.moment, axis))
        return record.all(cross(axis, self.moment)), record.all(dot(row, axis) for row in self.tensor)


class _Passage:
    """Carries what is in the axes of a link into those of the link before, about a point of its joint."""

    def __init__(self, record: Recorder, chain: SymbolicChain, q: Sequence[Symbol], joint: int) -> None:
        self._record = record
        self._turns = chain.kinds[joint] == "revolute"
        self._rotation = joint_rotation(record, chain.axes[joint], q[joint]) if self._turns else []
        step = tidy(np.subtract(chain.points[joint], chain.points[joint - 1] if joint else (S.Zero,) * 3))
        if not self._turns:
            step = step + q[joint] * np.array(chain.axes[joint])
        self._step = record.all(step)

    def body(self, body: _Body) -> _Body:
        record, step, mass = self._record, self._step, body.mass
        moment = self._rotated(body.moment)
        tensor = body.tensor
        if self._turns:
            columns = [self._rotated(column) for column in zip(*tensor, strict=True)]
            tensor = [self._rotated(row) for row in zip(*columns, strict=True)]
        # Σ m ((r + d)·(r + d) 1 - (r + d)(r + d)ᵀ), of which Σ m (r·r 1 - r rᵀ) is the tensor before.
        both = record.all(mass * d / 2 + h for h, d in zip(moment, step, strict=True))
        twice = record(2 * record(dot(both, step)))
        shifted = [[S.Zero] * 3 for _ in range(3)]
        for i in range(3):
            for j in range(i + 1):
                products = record(both[i] * step[j] + step[i] * both[j])
                shifted[i][j] = shifted[j][i] = record(tensor[i][j] + int(i == j) * twice - products)
        return _Body(mass, record.all(h + mass * d for h, d in zip(moment, step, strict=True)), shifted)

    def momentum(self, linear: Sequence[Expr], angular: Sequence[Expr]) -> tuple[list[Expr], list[Expr]]:
        linear, angular = self._rotated(linear), self._rotated(angular)
        moved = zip(angular, cross(self._step, linear), strict=True)
        return linear, self._record.all(a + b for a, b in moved)

    def _rotated(self, vector: Sequence[Expr]) -> list[Expr]:
        if not self._turns:
            return list(vector)
        return self._record.all(dot(row, vector) for row in self._rotation)


def _bodies(chain: SymbolicChain) -> list[_Body]:
    """Links in the axes of home, each about the point of its own joint."""
    if chain.inertias is None:
        raise ValueError(f"{chain.name} has no inertias, which its mass matrix needs")
    masses, centres, tensors = (exact(np.array(part, dtype=float)) for part in chain.inertias)
    bodies = []
    for mass, centre, tensor, point in zip(masses, centres, tensors, chain.points, strict=True):
        r = tidy(np.subtract(centre, point))
        steiner = mass * (np.dot(r, r) * np.eye(3, dtype=int) - np.outer(r, r))
        about_point = [[_rounded(x) for x in row] for row in tensor + steiner]
        bodies.append(_Body(mass, [_rounded(mass * x) for x in r], about_point))
    return bodies


def _rounded(x: Expr) -> Expr:
    return number(float(x)) if x.is_number else x
