"""Straight-line programs: sympy expressions computed step by step, each value once.

A :class:`Recorder` gives every new expression a name and hands the same name out when the same expression
comes again, up to its sign. What it recorded becomes a :class:`Program`, in the form of sympy's own
common-subexpression elimination, so that one derivation can be counted, differentiated and printed in
several languages.

Examples
--------
>>> import sympy
>>> from dexterity.program import Recorder, gradient
>>> x, y = sympy.symbols("x y")
>>> record = Recorder("t")
>>> program = record.program((x, y), [record(y * record(sympy.sin(x)))])
>>> program.steps, gradient(program).nested()
(((t0, sin(x)), (t1, t0*y)), (y*sin(x), y*cos(x), sin(x)))
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

import sympy
from sympy import Expr, Symbol

__all__ = ["Program", "Recorder", "copysign", "gradient", "select"]


class copysign(sympy.Function):  # type: ignore[misc]  # noqa: N801  # named as in C's math.h
    """First argument, which is not negative, with the sign of the second."""

    nargs = 2

    @classmethod
    def eval(cls, magnitude: Expr, sign: Expr) -> Expr | None:
        """Fold the sign of a number."""
        if sign.is_Number:
            return magnitude if sign >= 0 else -magnitude
        return None

    def fdiff(self, argindex: int = 1) -> Expr:
        """Differentiate; the sign is constant wherever there is a derivative."""
        return copysign(sympy.S.One, self.args[1]) if argindex == 1 else sympy.S.Zero


class select(sympy.Function):  # type: ignore[misc]  # noqa: N801  # as copysign
    """Second argument where the first is positive, else the third; no derivative by the first."""

    nargs = 3

    @classmethod
    def eval(cls, decides: Expr, positive: Expr, otherwise: Expr) -> Expr | None:
        """Decide by a number, or between equals."""
        if positive == otherwise:
            return positive
        if decides.is_Number:
            return positive if decides > 0 else otherwise
        return None

    def fdiff(self, argindex: int = 1) -> Expr:
        """Differentiate; what decides is constant wherever there is a derivative."""
        one, zero = sympy.S.One, sympy.S.Zero
        return {1: zero, 2: select(self.args[0], one, zero), 3: select(self.args[0], zero, one)}[argindex]


@dataclass(frozen=True)
class Program:
    """Values computed one after the other.

    Attributes
    ----------
    inputs
        Symbols that the steps start from.
    steps
        Pairs of a new symbol and an expression of inputs and earlier symbols.
    outputs
        Symbols, numbers, or their negatives.
    """

    inputs: tuple[Symbol, ...]
    steps: tuple[tuple[Symbol, Expr], ...]
    outputs: tuple[Expr, ...]

    @property
    def used_inputs(self) -> tuple[Symbol, ...]:
        """Inputs that an output depends on, in their order."""
        expressions = [*self.outputs, *(expression for _, expression in self.steps)]
        used = set().union(*(expression.free_symbols for expression in expressions))
        return tuple(symbol for symbol in self.inputs if symbol in used)

    def leading_to(self, outputs: Iterable[Expr]) -> Program:
        """Return the steps that lead to these outputs, and no others."""
        outputs = tuple(outputs)
        needed: set[Symbol] = set().union(*(output.free_symbols for output in outputs))
        steps = []
        for symbol, expression in reversed(self.steps):
            if symbol in needed:
                steps.append((symbol, expression))
                needed |= expression.free_symbols
        return Program(self.inputs, tuple(reversed(steps)), outputs)

    def nested(self) -> tuple[Expr, ...]:
        """Return the outputs as expressions of the inputs alone, nothing shared."""
        values: dict[Expr, Expr] = {}
        for symbol, expression in self.steps:
            values[symbol] = expression.xreplace(values)
        return tuple(output.xreplace(values) for output in self.outputs)


class Recorder:
    """Names expressions; equal ones get the same name.

    Parameters
    ----------
    prefix
        What the names begin with; a number follows.
    """

    def __init__(self, prefix: str = "x") -> None:
        self._prefix = prefix
        self._names: dict[Expr, Symbol] = {}

    def __call__(self, expression: Expr | int) -> Expr:
        """Return a symbol, a number or the negative of a symbol that stands for the expression."""
        expression = sympy.sympify(expression)
        if expression.is_Atom:
            return expression
        if expression.could_extract_minus_sign():
            return -self(-expression)
        if expression not in self._names:
            self._names[expression] = Symbol(f"{self._prefix}{len(self._names)}", real=True)
        return self._names[expression]

    def all(self, expressions: Iterable[Expr]) -> list[Expr]:
        """Name each of several expressions."""
        return [self(expression) for expression in expressions]

    def program(self, inputs: Sequence[Symbol], outputs: Iterable[Expr]) -> Program:
        """Return the steps that lead to the outputs, and no others."""
        outputs = self.all(outputs)
        steps = tuple((symbol, expression) for expression, symbol in self._names.items())
        return Program(tuple(inputs), steps, ()).leading_to(outputs)

    def replay(self, program: Program, values: Mapping[Symbol, Expr] | None = None) -> list[Expr]:
        """Record another program's steps, its inputs replaced, and return its outputs."""
        known = self.follow(program, values)
        return [output.xreplace(known) for output in program.outputs]

    def follow(self, program: Program, values: Mapping[Symbol, Expr] | None = None) -> dict[Expr, Expr]:
        """Record another program's steps, its inputs replaced, and return what stands for each symbol now."""
        known: dict[Expr, Expr] = dict(values or {})
        for symbol, expression in program.steps:
            known[symbol] = self(expression.xreplace(known))
        return known


def gradient(
    program: Program,
    weigh: Callable[[Recorder, list[Expr]], list[Expr]] | None = None,
    extra: Sequence[Symbol] = (),
) -> Program:
    """Differentiate the weighted sum of the outputs by all inputs: reverse accumulation through the steps.

    Parameters
    ----------
    program
        Program to differentiate.
    weigh
        Returns the weights, constants of the differentiation, from a recorder and the outputs; all 1 by
        default.
    extra
        Inputs that the weights bring along.

    Returns
    -------
    A program whose outputs are those of the first, followed by one derivative for each of its inputs.

    References
    ----------
    Griewank & Walther (2008), Evaluating Derivatives, section 3.2.
    """
    recorder = Recorder("g")
    known = recorder.follow(program)
    outputs = [output.xreplace(known) for output in program.outputs]
    weights = weigh(recorder, outputs) if weigh else [sympy.S.One] * len(outputs)

    shares: dict[Symbol, list[Expr]] = defaultdict(list)
    for output, weight in zip(program.outputs, weights, strict=True):
        for symbol in output.free_symbols:
            shares[symbol].append(weight * output.diff(symbol))
    for symbol, expression in reversed(program.steps):
        share = recorder(sympy.Add(*shares.pop(symbol, [])))
        # Sorted, so that names and files come out the same in every process.
        for used in sorted(expression.free_symbols, key=str) if share != 0 else ():
            slope = recorder(_derivative(expression, symbol, used).xreplace(known))
            shares[used].append(share * slope)
    derivatives = [sympy.Add(*shares[q]) for q in program.inputs]
    return recorder.program((*program.inputs, *extra), [*outputs, *derivatives])


def _derivative(expression: Expr, value: Symbol, by: Symbol) -> Expr:
    """Differentiate a step; a root, a reciprocal and an exponential through their own, known value.

    At 0, where an absolute value has no derivative, that of one side is taken.
    """
    if isinstance(expression, sympy.Abs):
        return copysign(sympy.S.One, expression.args[0]) * expression.args[0].diff(by)
    if expression.is_Pow and expression.exp == sympy.S.Half:
        return expression.base.diff(by) / (2 * value)
    if expression.is_Pow and expression.exp == -1:
        return -expression.base.diff(by) * value**2
    if isinstance(expression, sympy.exp):
        return expression.args[0].diff(by) * value
    return expression.diff(by)
