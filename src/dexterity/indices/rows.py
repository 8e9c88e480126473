"""Rows of a Jacobian that an index counts, and a direction among them.

Examples
--------
>>> from dexterity.indices.rows import row_numbers
>>> row_numbers("translational"), row_numbers(("vx", "wz"))
((0, 1, 2), (0, 5))
"""

from __future__ import annotations

import math
import operator
from typing import Literal, TypeAlias

from dexterity.spatial import TensorLike
from dexterity.spatial.values import on_cpu

__all__ = ["ROW_NAMES", "Rows", "direction_of", "one_dimensional", "row_numbers", "shortest_name"]

ROW_NAMES = ("vx", "vy", "vz", "wx", "wy", "wz")
"""Names of the six rows [v; ω] of a Jacobian: velocity and angular velocity along the axes of the frame."""

Rows: TypeAlias = Literal["full", "translational", "rotational"] | tuple[int | str, ...]
"""All six rows, the first or the last three, or a selection by numbers from 0 or names."""

_NAMED: dict[str, tuple[int, ...]] = {
    "full": (0, 1, 2, 3, 4, 5),
    "translational": (0, 1, 2),
    "rotational": (3, 4, 5),
}


def row_numbers(rows: Rows) -> tuple[int, ...]:
    """Return the numbers of rows, from 0, in the order in which they are named.

    Raises
    ------
    TypeError
        If `rows` is neither a word nor a sequence of numbers and names.
    ValueError
        If a row is unknown or occurs twice, or there is none.
    """
    if isinstance(rows, str):
        if rows in _NAMED:
            return _NAMED[rows]
        if rows in ROW_NAMES:
            return (ROW_NAMES.index(rows),)
        raise ValueError(f"rows is {rows!r}; {_KNOWN}")
    if not isinstance(rows, list | tuple):
        raise TypeError(f"rows is {rows!r}; {_KNOWN}")
    numbers = tuple(_number(row, rows) for row in rows)
    if not numbers or len(set(numbers)) != len(numbers):
        raise ValueError(f"rows is {rows!r}; at least one row is needed, and none twice")
    return numbers


_KNOWN = f"{', '.join(map(repr, _NAMED))}, or a sequence of {', '.join(ROW_NAMES)} or 0 to 5 is needed"


def _number(row: int | str, rows: Rows) -> int:
    if isinstance(row, str):
        if row in ROW_NAMES:
            return ROW_NAMES.index(row)
    elif not isinstance(row, bool):
        try:
            number = operator.index(row)
        except TypeError as error:
            raise TypeError(f"rows holds {row!r}; {_KNOWN}") from error
        if 0 <= number < 6:
            return number
    raise ValueError(f"rows is {rows!r}; {_KNOWN}")


def shortest_name(numbers: tuple[int, ...]) -> Rows:
    """Return the word for a selection of rows, or their names."""
    for name, known in _NAMED.items():
        if numbers == known:
            return name  # type: ignore[return-value]
    return tuple(ROW_NAMES[number] for number in numbers)


def direction_of(direction: TensorLike | str, rows: tuple[int, ...]) -> tuple[float, ...]:
    """Return a direction in the space of some rows, at unit length.

    Parameters
    ----------
    direction
        One number for each of the rows, of any length but 0, or the name of one of them.
    rows
        Numbers of the rows.

    Raises
    ------
    ValueError
        If the direction does not fit the rows or has no length.
    """
    names = [ROW_NAMES[row] for row in rows]
    if isinstance(direction, str):
        if direction not in names:
            raise ValueError(f"direction is {direction!r}; the rows are {', '.join(names)}")
        return tuple(float(name == direction) for name in names)
    numbers = one_dimensional(direction, "direction")
    if len(numbers) != len(rows):
        raise ValueError(
            f"direction has {len(numbers)} numbers; one for each row is needed: {', '.join(names)}"
            + (' (for a direction in space take rows="translational")' if len(numbers) == 3 else "")
        )
    length = math.hypot(*numbers)
    if not 0 < length < math.inf:
        raise ValueError(f"direction is {numbers}; its length must not be zero, and be finite")
    return tuple(number / length for number in numbers)


def one_dimensional(values: TensorLike, name: str) -> tuple[float, ...]:
    """Return finite real numbers in a row as floats.

    Raises
    ------
    TypeError
        If they are no sequence of real numbers: texts, sets, truth values and complex numbers are refused.
    ValueError
        If they are not in one row, or one is not finite.
    """
    if isinstance(values, str | bytes | dict | set | frozenset):
        raise TypeError(f"{name} is {values!r}; a sequence of numbers is needed")
    if isinstance(values, list | tuple) and any(isinstance(value, bool | str | bytes) for value in values):
        raise TypeError(f"{name} is {values!r}; a sequence of numbers is needed")
    numbers = on_cpu(values, name)
    if numbers.ndim != 1:
        raise ValueError(f"{name} has shape {tuple(numbers.shape)}; one row of numbers is needed")
    return tuple(numbers.tolist())
