"""Programs printed as statements of languages with C's arithmetic, and the templates that they go into."""

from __future__ import annotations

from collections.abc import Iterator
from importlib.resources import files
from string import Template
from typing import TypeAlias

import sympy
from sympy import Expr, Symbol
from sympy.printing.c import C99CodePrinter
from sympy.printing.jscode import JavascriptCodePrinter
from sympy.printing.precedence import PRECEDENCE

from dexterity.program import Program

__all__ = ["JAVASCRIPT", "C", "Item", "template", "with_angles_paired"]


class _Arithmetic:
    """Squares and reciprocals as products and quotients, not calls of pow; numbers with all their digits."""

    def _print_Float(self, number: Expr) -> str:
        return repr(float(number))

    def _print_Pow(self, expression: Expr) -> str:
        base = self.parenthesize(expression.base, PRECEDENCE["Atom"], strict=True)  # type: ignore[attr-defined]
        if expression.exp == 2:
            return f"({base}*{base})"
        if expression.exp == -1:
            return f"(1.0/{base})"
        return super()._print_Pow(expression)  # type: ignore[misc]


class _CPrinter(_Arithmetic, C99CodePrinter):  # type: ignore[misc]
    pass


class _JavascriptPrinter(_Arithmetic, JavascriptCodePrinter):  # type: ignore[misc]
    pass


C = _CPrinter({"user_functions": {"copysign": "copysign"}})
"""Prints expressions in C99."""

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
