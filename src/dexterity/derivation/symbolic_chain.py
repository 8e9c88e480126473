"""A chain whose lengths may be symbols, for derivations.

Examples
--------
>>> import dexterity as dx
>>> from dexterity.derivation import SymbolicChain
>>> chain = SymbolicChain.from_description(dx.robots.describe("docking_arm"))
>>> chain.lengths
(l0, l1, l2, sideways)
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
import sympy
from sympy import Expr, S, Symbol

from dexterity import checks, robots
from dexterity.chain import Chain, JointKind

__all__ = ["ROUNDING", "SymbolicChain", "Vector", "cross", "exact", "number", "tidy"]

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
    inertias
        As of :class:`dexterity.chain.Chain`, in nested tuples.
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
    inertias: tuple[object, ...] | None = None

    @classmethod
    def of(cls, chain: object) -> SymbolicChain:
        """Take a chain of numbers or of symbols.

        Raises
        ------
        TypeError
            If it is neither.
        """
        if isinstance(chain, SymbolicChain):
            return chain
        if not isinstance(chain, Chain):
            raise TypeError(f"chain is {chain!r}; a Chain is needed")
        return cls.from_chain(chain)

    @classmethod
    @checks.arguments(chain=checks.Instance(Chain))
    def from_chain(cls, chain: Chain) -> SymbolicChain:
        """Take a chain of numbers; a number within rounding of an integer becomes that integer."""
        return cls._from_parts(chain, exact(chain.screws.numpy()), exact(chain.home.numpy()))

    @classmethod
    @checks.arguments(description=checks.Instance(robots.Description))
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
                before = tidy(nearest + omega * (omega @ (before - nearest)))
            axes.append(tuple(v if kind == "prismatic" else omega))
            points.append(tuple(before))
        return cls(
            chain.name, chain.joint_names, chain.kinds, tuple(axes), tuple(points),
            tuple(home[:3, 3]), tuple(tuple(row) for row in home[:3, :3]),
            tuple(chain.rates.tolist()), tuple(chain.lower.tolist()), tuple(chain.upper.tolist()),
            _inertias(chain),
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

    def require_numbers(self) -> None:
        """Make sure that all lengths have values.

        Raises
        ------
        ValueError
            If one has none.
        """
        if self.lengths:
            raise ValueError(f"{self.name} has lengths without a value: {', '.join(map(str, self.lengths))}")

    def numeric(self) -> Chain:
        """Return the chain of numbers.

        Raises
        ------
        ValueError
            If lengths have no value.
        """
        self.require_numbers()
        screws = []
        for kind, axis, point in zip(self.kinds, self.axes, self.points, strict=True):
            omega, p = np.array(axis, dtype=float), np.array(point, dtype=float)
            screws.append([*omega, 0, 0, 0] if kind == "prismatic" else [*np.cross(p, omega), *omega])
        home = np.eye(4)
        home[:3, :3], home[:3, 3] = np.array(self.tool_axes, dtype=float), np.array(self.tool, dtype=float)
        with_inertias: dict[str, Any] = {} if self.inertias is None else {"inertias": self.inertias}
        return Chain(
            np.array(screws), home, name=self.name, joint_names=self.joint_names,
            lower=self.lower, upper=self.upper, rates=self.rates, **with_inertias,
        )  # fmt: skip

    def numbers(self) -> tuple[object, ...]:
        """Return what the chain is made of in built-in types, for a content key; lengths must be numbers."""
        vectors = (self.axes, self.points, (self.tool,), self.tool_axes)
        geometry = tuple(tuple(tuple(map(float, v)) for v in group) for group in vectors)
        limits = (self.rates, self.lower, self.upper)
        return (self.name, self.joint_names, self.kinds, geometry, *limits, self.inertias)


def _inertias(chain: Chain) -> tuple[object, ...] | None:
    if chain.inertias is None:
        return None
    return tuple(_nested(values.tolist()) for values in chain.inertias)


def _nested(values: Any) -> Any:
    return tuple(map(_nested, values)) if isinstance(values, list) else values


def cross(a: Sequence[Expr], b: Sequence[Expr]) -> list[Expr]:
    """Cross product, not yet recorded."""
    (ax, ay, az), (bx, by, bz) = a, b
    return [ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx]


def exact(array: np.ndarray) -> np.ndarray:
    """Convert numbers to sympy's; a number within rounding of an integer becomes that integer."""
    return np.array([number(x) for x in array.ravel()], dtype=object).reshape(array.shape)


def number(x: float) -> Expr:
    """Return a number; one within rounding of an integer becomes that integer."""
    return sympy.Integer(round(x)) if abs(x - round(x)) < ROUNDING else sympy.Float(x)


def tidy(vector: Iterable[Expr]) -> np.ndarray:
    """Expand expressions, and take the rounding off numbers."""
    return np.array([number(float(x)) if x.is_number else sympy.expand(x) for x in vector], dtype=object)


ROUNDING = 1e-14
