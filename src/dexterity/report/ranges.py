"""Numbers from several seeds, as a table says them: the median, and in brackets how far they go."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

__all__ = ["with_range"]


def with_range(values: Sequence[float] | NDArray[np.generic], form: Callable[[float], str]) -> str:
    """Return the median of numbers, with the smallest and the largest where they read otherwise.

    Parameters
    ----------
    values
        Numbers, one or more; infinities are allowed. Where none is a number, a dash is told.
    form
        How one of them is written.

    Raises
    ------
    ValueError
        If there are no numbers.
    """
    if len(values) == 0:
        raise ValueError("values is empty; at least one number is needed")
    array = np.asarray(values, dtype=float)
    if np.isnan(array).all():
        return "–"
    median, lowest, highest = (form(float(f(array))) for f in (np.median, np.min, np.max))
    return median if lowest == highest else f"{median} ({lowest}–{highest})"
