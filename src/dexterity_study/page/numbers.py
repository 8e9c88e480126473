"""Numbers as a reader meets them: two or three digits, a floor, powers of ten, and a range over seeds."""

import math
import re
from typing import Any

import numpy as np

_SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
_LARGEST_EXPONENT = 5
_NEGATIVE_ZERO = re.compile(r"(?<!\w)-(?=0(?:\.0*)?(?![\d.]))")
_EXPONENT = re.compile(r"(?<![\w.])\d+(?:\.\d+)?e[-+]\d\d+\b")


def readable(text: str) -> str:
    """Write the numbers of a text for a reader: no minus before what reads as zero, powers of ten for exponents."""
    return _EXPONENT.sub(lambda number: power_of_ten(number[0]), _NEGATIVE_ZERO.sub("", text))


def written(value: float, form: str = "{:.3g}") -> str:
    """Write a number by a form.

    A number too small for its form is written with the smallest one that the form can show, as in "< 0.001"; one with
    an exponent in full up to a million, and else with a power of ten; zero without a sign; what is no number, a dash.
    """
    if math.isnan(value):
        return "–"
    text = form.format(value)
    if "e" in text:
        return "0" if value == 0 else power_of_ten(text)
    if value != 0 and not re.search("[1-9]", text) and "inf" not in text:
        return f"< {re.sub(r'0(?=[^0-9.]*$)', '1', text)}" if value > 0 else text.replace("-", "")
    return text.replace("-", "") if value == 0 else text


def power_of_ten(text: str) -> str:
    """Write "1.52e+03" as "1,520", and "8.28e-07" with a power of ten."""
    mantissa, _, exponent = text.partition("e")
    if 0 <= int(exponent) <= _LARGEST_EXPONENT:
        return f"{float(text):,.0f}"
    return f"{mantissa}\N{NO-BREAK SPACE}×\N{NO-BREAK SPACE}10{str(int(exponent)).translate(_SUPERSCRIPTS)}"


def with_range(values: Any, form: str = "{:.3g}") -> str:
    """Write the median of numbers, with the smallest and the largest in brackets where they read otherwise.

    >>> with_range([1.0, 2.0, 3.0]), with_range([-0.5, -0.4, 0.1])
    ('2 (1–3)', '-0.4 (-0.5 to 0.1)')
    """
    array = np.asarray(values, dtype=float)
    array = array[~np.isnan(array)]
    if array.size == 0:
        return "–"
    median, low, high = (written(float(of(array)), form) for of in (np.median, np.min, np.max))
    to = " to " if low.startswith("-") else "–"
    return median if low == high else f"{median} ({low}{to}{high})"
