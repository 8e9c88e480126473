"""Scalar operations in the order in which they are computed, each of them once.

Examples
--------
>>> from dexterity.codegen.tape import Tape
>>> tape = Tape()
>>> tape.value(tape.apply("add", tape.constant(1.0), tape.constant(2.0)))
3.0
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np

__all__ = ["ELEMENT", "INPUT", "OPERATORS", "SOLVE", "Number", "Recording", "Tape"]

Number: TypeAlias = float | int | bool
"""Value of a constant."""

SOLVE, ELEMENT, INPUT = "solve", "element", "input"
"""A linear system, with its number of unknowns, its matrix and its right-hand sides, row by row; one number
of its solution; and one of the numbers that a function is given."""

OPERATORS: Mapping[str, Callable[..., Any]] = {
    "add": np.add, "sub": np.subtract, "mul": np.multiply, "div": np.divide, "pow": np.power,
    "remainder": np.mod, "neg": np.negative, "abs": np.abs, "sign": np.sign, "floor": np.floor,
    "round": np.round, "number": float, "sqrt": np.sqrt, "exp": np.exp, "tanh": np.tanh, "sin": np.sin,
    "cos": np.cos, "acos": np.arccos, "atan2": np.arctan2, "hypot": np.hypot, "min": np.minimum,
    "max": np.maximum, "eq": operator.eq, "ne": operator.ne, "lt": operator.lt, "le": operator.le,
    "gt": operator.gt, "ge": operator.ge, "and": np.logical_and, "or": np.logical_or, "not": np.logical_not,
    "where": np.where,
}  # fmt: skip
"""Operators by their name, as they are worked out where all arguments are constants."""


@dataclass(frozen=True)
class Recording:
    """A function of numbers as scalar operations.

    Attributes
    ----------
    inputs
        How many numbers it takes.
    tape
        The operations.
    conditions
        Places on the tape with the values that they must have; elsewhere the function is another one, or
        raises an error.
    outputs
        Places of the results, row by row.
    shape
        Of the tensor of results.
    """

    inputs: int
    tape: Tape
    conditions: tuple[tuple[int, Number], ...]
    outputs: tuple[int, ...]
    shape: tuple[int, ...]


class Tape:
    """Operations on numbers; equal ones have one place.

    A number times a constant zero is zero, and one plus it is the number, whatever the number is.

    Attributes
    ----------
    rows
        Operator and arguments of each place: a constant has its value, and no operator.
    """

    def __init__(self) -> None:
        self.rows: list[tuple[Any, ...]] = []
        self._places: dict[tuple[Any, ...], int] = {}

    def constant(self, value: Number) -> int:
        """Return the place of a constant."""
        # 0, 0.0, -0.0 and False are equal, and are not the same.
        return self._place((None, value), (None, repr(value)))

    def input(self, number: int) -> int:
        """Return the place of the input with this number."""
        return self._place((INPUT, number))

    def apply(self, name: str, *arguments: int) -> int:
        """Return the place of an operation on other places."""
        values = [self.value(place) for place in arguments]
        if None not in values:
            with np.errstate(all="ignore"):
                return self.constant(np.asarray(OPERATORS[name](*values)).item())
        simpler = self._simplified(name, arguments, values)
        return self._place((name, *arguments)) if simpler is None else simpler

    def solve(self, matrix: list[int], right: list[int], unknowns: int) -> list[int]:
        """Return the places of the solution of a linear system, row by row as the right-hand sides are."""
        system = self._place((SOLVE, unknowns, *matrix, *right))
        return [self._place((ELEMENT, system, number)) for number in range(len(right))]

    def value(self, place: int) -> Number | None:
        """Return the value of a constant, None for all else."""
        name, *arguments = self.rows[place]
        return arguments[0] if name is None else None

    def _place(self, row: tuple[Any, ...], key: tuple[Any, ...] | None = None) -> int:
        key = key or row
        if key not in self._places:
            self._places[key] = len(self.rows)
            self.rows.append(row)
        return self._places[key]

    def _simplified(self, name: str, places: tuple[int, ...], values: list[Number | None]) -> int | None:
        """Place of an operation that a constant among its arguments settles; None if none does."""
        if name == "where" and values[0] is not None:
            return places[1 if values[0] else 2]
        if len(places) != 2:
            return None
        (a, b), (x, y) = places, values
        if name in ("add", "mul", "and", "or") and x is not None:
            (a, b), (x, y) = (b, a), (y, x)
        if (name == "add" and y == 0) or (name == "sub" and y == 0) or (name in ("mul", "div") and y == 1):
            return a
        if name == "sub" and x == 0:
            return self.apply("neg", b)
        if name == "mul" and y == -1:
            return self.apply("neg", a)
        if (name == "mul" and y == 0) or (name == "div" and x == 0):
            return self.constant(0.0)
        if name in ("and", "or") and y is not None:
            return a if bool(y) == (name == "and") else self.constant(name == "or")
        return None
