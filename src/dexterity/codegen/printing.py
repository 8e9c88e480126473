"""Programs printed as statements of languages with C's arithmetic, and the templates that they go into."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import cache
from importlib.resources import files
from string import Template
from typing import TypeAlias

import sympy
from sympy import Expr, Symbol
from sympy.printing.c import C99CodePrinter
from sympy.printing.jscode import JavascriptCodePrinter
from sympy.printing.precedence import PRECEDENCE

from dexterity.program import Program

__all__ = ["JAVASCRIPT", "Item", "c_printer", "number", "template", "with_angles_paired"]


def number(x: float) -> str:
    """Return a number with all its digits, as C, ECMAScript and Python read it.

    Raises
    ------
    ValueError
        If it is not finite: no language has a literal for that.
    """
    if not math.isfinite(x):
        raise ValueError(f"a constant of the generated code is {x}; finite numbers are needed")
    return repr(float(x))


_LARGEST_PRODUCT = 8
"""Whole powers up to this one are printed as products."""


class _Arithmetic:
    """Whole powers as products and quotients, not calls of pow; numbers with all their digits."""

    def _print_Float(self, expression: Expr) -> str:
        return number(float(expression))

    def _print_Rational(self, expression: Expr) -> str:
        return number(float(expression))

    def _print(self, expression: Expr, **options: object) -> str:
        # π and e have names that only some headers define; what is undefined has none at all.
        if isinstance(expression, sympy.NumberSymbol):
            return number(float(expression))
        if expression in (sympy.zoo, sympy.nan):
            return number(math.nan)
        return str(super()._print(expression, **options))  # type: ignore[misc]

    def _print_select(self, expression: Expr) -> str:
        decides, positive, otherwise = map(self._print, expression.args)
        return f"(({decides}) > 0.0 ? ({positive}) : ({otherwise}))"

    def _print_Pow(self, expression: Expr) -> str:
        base = self.parenthesize(expression.base, PRECEDENCE["Atom"], strict=True)  # type: ignore[attr-defined]
        exponent = expression.exp
        if exponent.is_Integer and 0 < abs(exponent) <= _LARGEST_PRODUCT:
            product = "*".join([base] * abs(int(exponent)))
            if exponent > 0:
                return f"({product})"
            return f"(1.0/{base})" if exponent == -1 else f"(1.0/({product}))"
        return super()._print_Pow(expression)  # type: ignore[misc]


class _CPrinter(_Arithmetic, C99CodePrinter):  # type: ignore[misc]
    pass


class _JavascriptPrinter(_Arithmetic, JavascriptCodePrinter):  # type: ignore[misc]
    pass


@cache
def c_printer(prefix: str) -> C99CodePrinter:
    """Return what prints expressions in C99, with exponentials and logarithms of the file itself."""
    own = {"exp": f"{prefix}exponential", "log": f"{prefix}logarithm"}
    return _CPrinter({"user_functions": {"copysign": "copysign", **own}, "math_macros": {}})


JAVASCRIPT = _JavascriptPrinter({"user_functions": {"copysign": "copysign"}})
"""Prints expressions in JavaScript; ``copysign`` is to be defined."""


Item: TypeAlias = tuple[Symbol, Expr] | tuple[Expr, Symbol | None, Symbol | None]
"""A step, or an angle with the symbols of its sine and of its cosine."""


def with_angles_paired(program: Program) -> Iterator[Item]:
    """Yield the steps of a program, those of a sine and a cosine of one angle together.

    Yields
    ------
    Pairs (symbol, expression), or triples (angle, symbol of its sine, symbol of its cosine), where a symbol
    that no step needs is None.
    """
    pairs: dict[Expr, dict[type, Symbol]] = {}
    for symbol, expression in program.steps:
        if isinstance(expression, sympy.sin | sympy.cos):
            pairs.setdefault(expression.args[0], {})[expression.func] = symbol
    for symbol, expression in program.steps:
        if not isinstance(expression, sympy.sin | sympy.cos):
            yield symbol, expression
        elif (pair := pairs.pop(expression.args[0], None)) is not None:
            yield expression.args[0], pair.get(sympy.sin), pair.get(sympy.cos)


def template(name: str) -> Template:
    """Return one of the texts in the folder ``templates``, with places for what is generated."""
    return Template(files("dexterity.codegen").joinpath("templates", name).read_text(encoding="utf-8"))
