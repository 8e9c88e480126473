"""Numbers as people type them: ``0.1``, ``-pi/2``, ``3pi/4``, ``90deg``, and ranges ``-1:1:5``.

Examples
--------
>>> from dexterity.typed import number, numbers, values_of_range
>>> round(number("-pi/2", "q"), 4), round(number("90deg", "q"), 4)
(-1.5708, 1.5708)
>>> numbers("0.1, 0.2, 1e-3", "q")
[0.1, 0.2, 0.001]
>>> values_of_range("-1:1:5", "x")
[-1.0, -0.5, 0.0, 0.5, 1.0]
"""

from __future__ import annotations

import math
import re

__all__ = ["number", "numbers", "values_of_range"]

_PI = re.compile(r"([+-]?)(\d+(?:\.\d*)?|\.\d+)?\*?(?:pi|π)(?:/(\d+(?:\.\d*)?))?", re.IGNORECASE)
MOST_VALUES = 100_000


def number(text: str, name: str) -> float:
    """Read a number.

    Raises
    ------
    ValueError
        If `text` is no finite number; the error names `name`.
    """
    word = text.strip()
    try:
        if match := _PI.fullmatch(word):
            sign, factor, divisor = match.groups()
            value = float(f"{sign}{factor or 1}") * math.pi / float(divisor or 1)
        elif word.lower().endswith("deg"):
            value = math.radians(float(word[:-3]))
        else:
            value = float(word)
    except (ValueError, ZeroDivisionError):
        value = math.nan
    if not math.isfinite(value):
        raise ValueError(f"{name} holds {text!r}; a number such as 0.1, -pi/2 or 90deg is needed")
    return value


def numbers(text: str, name: str, count: int | tuple[int, ...] | None = None) -> list[float]:
    """Read numbers between commas or blanks.

    Parameters
    ----------
    text
        The numbers.
    name
        What errors call them.
    count
        How many there have to be.

    Raises
    ------
    ValueError
        If one is no finite number, or they are not as many as `count` says.
    """
    values = [number(word, name) for word in re.split(r"\s*,\s*|\s+", text.strip()) if text.strip()]
    allowed = (count,) if isinstance(count, int) else count
    if allowed is not None and len(values) not in allowed:
        raise ValueError(f"{name} holds {len(values)} numbers; {' or '.join(map(str, allowed))} are needed")
    return values


def values_of_range(text: str, name: str) -> list[float]:
    """Read one value, or ``first:last:count`` for evenly spaced ones with both ends.

    Raises
    ------
    ValueError
        If it is neither, or the count is not from 1 to 100 000.
    """
    parts = text.split(":")
    if len(parts) == 1:
        return [number(text, name)]
    if (
        len(parts) != 3
        or not re.fullmatch(r"\d{1,9}", parts[2].strip(), re.ASCII)
        or not 1 <= int(parts[2]) <= MOST_VALUES
    ):
        raise ValueError(f"{name} is {text!r}; a number or first:last:count is needed, such as -0.4:0.4:5")
    first, last, count = number(parts[0], name), number(parts[1], name), int(parts[2])
    if count == 1:
        return [first]
    return [first + (last - first) * i / (count - 1) for i in range(count)]
