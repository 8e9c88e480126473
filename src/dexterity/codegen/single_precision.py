"""C code for numbers of single precision, from the same code for numbers of double precision.

Types, literals and functions of ``math.h`` are exchanged for those of ``float``. Constants that stand for
"nothing" and are too small for single precision become the smallest that its squares can hold.

Examples
--------
>>> from dexterity.codegen.single_precision import in_single_precision
>>> print(in_single_precision("double f(double x) { return sqrt(x + 1e-60)/0.5; } /* 0.5 */"))
float f(float x) { return sqrtf(x + 1e-30f)/0.5f; } /* 0.5 */
"""

from __future__ import annotations

import re

import numpy as np

__all__ = ["in_single_precision"]

_SMALLEST = 1e-30

_FUNCTIONS = (
    "sqrt|cbrt|fabs|copysign|sin|cos|tan|acos|asin|atan|atan2|exp|exp2|expm1|log|log2|log10|log1p|pow|hypot|fmin|"
    "fmax|fma|floor|ceil"
)

_TOKENS = re.compile(
    r"(?P<comment>/\*.*?\*/|\"[^\"\n]*\"|\#\s*(?:include|error|pragma)[^\n]*)"
    r"|(?P<number>(?<![\w.])(?:\d+\.\d*|\.\d+|\d+(?=[eE]))(?:[eE][-+]?\d+)?(?![\w.]))"
    rf"|\b(?P<function>{_FUNCTIONS})(?=\()"
    r"|\b(?P<type>double)\b"
    r"|\b(?P<infinity>HUGE_VAL)\b",
    re.DOTALL,
)


def in_single_precision(code: str) -> str:
    """Return C code with ``float`` in place of ``double``.

    Raises
    ------
    ValueError
        If a constant is too large for single precision.
    """
    return _TOKENS.sub(_exchanged, code)


def _exchanged(token: re.Match[str]) -> str:
    if token["type"]:
        return "float"
    if token["function"]:
        return f"{token['function']}f"
    if token["infinity"]:
        return "HUGE_VALF"
    if token["number"]:
        return _literal(float(token["number"]))
    return token[0]


def _literal(number: float) -> str:
    if number > float(np.finfo(np.float32).max):
        raise ValueError(f"the constant {number!r} is too large for single precision")
    text = str(np.float32(_SMALLEST if 0 < number < _SMALLEST else number))
    return f"{text}f" if re.search(r"[.e]", text) else f"{text}.0f"
