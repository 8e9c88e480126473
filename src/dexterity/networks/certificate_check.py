"""Parts of a certificate proved once more, by other arithmetic that shares no line with the compiled one.

The Taylor models here have whole numbers as coefficients, in units of 2⁻⁸⁰, so that sums and products are
exact until they are cut, by less than a unit each. Elementary functions are expanded by Taylor's formula in
mpmath's intervals, where the compiled code interpolates in double precision. Nothing depends on the C
library, a compiler or the rounding of a processor. It takes about fifty times longer.

Examples
--------
>>> import sympy
>>> from dexterity.networks.certificate_check import is_bounded
>>> from dexterity.program import Recorder
>>> x, record = sympy.Symbol("x", real=True), Recorder()
>>> hump = record.program([x], [record(sympy.sin(x) - x)])
>>> is_bounded(hump, [-1.0], [1.0], 0.1586), is_bounded(hump, [-1.0], [1.0], 0.1584)
(True, False)
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from itertools import combinations_with_replacement
from typing import Any, TypeAlias

import numpy as np
import sympy
from mpmath import iv, mp
from numpy.typing import ArrayLike
from sympy import Expr

from dexterity import checks
from dexterity.program import Program

__all__ = ["is_bounded"]

BITS = 80
"""Coefficients are whole numbers of units 2^-BITS."""

UNIT = 1 << BITS

PRECISION = 160
"""Bits of the intervals."""

DEEPEST = 12
"""Bisections of a box after which a proof is given up."""

PIECES = 400
"""Pieces of a polynomial that are bounded before its box is halved."""

Interval: TypeAlias = Any
"""An interval of mpmath."""


def is_bounded(program: Program, lower: ArrayLike, upper: ArrayLike, wanted: float, degree: int = 5) -> bool:
    """Prove that the magnitude of a program's only output is at most a number everywhere in a box.

    Parameters
    ----------
    program
        Sums, products, whole powers, square roots, sines, cosines, exponentials and hyperbolic tangents of
        n inputs.
    lower, upper
        (n) corners of the box.
    wanted
        The bound.
    degree
        Of the Taylor models.

    Returns
    -------
    Whether it was proved. False says that it was not, and nothing else.

    Raises
    ------
    ValueError
        If the corners do not fit, a number is out of range, or the program has several outputs or other
        steps.
    """
    wanted, degree = checks.real(wanted, "wanted", above=0), checks.whole(degree, "degree", least=1)
    inputs = len(program.inputs)
    corners = np.asarray(lower, dtype=float), np.asarray(upper, dtype=float)
    for name, corner in zip(("lower", "upper"), corners, strict=True):
        if corner.shape != (inputs,) or not np.isfinite(corner).all():
            raise ValueError(f"{name} is {corner}; {inputs} finite numbers are needed")
    if len(program.outputs) != 1:
        raise ValueError(f"program has {len(program.outputs)} outputs; one is needed")
    box = [(Fraction(a), Fraction(b)) for a, b in zip(*(c.tolist() for c in corners), strict=True)]
    terms, before = Terms(inputs, degree), (mp.prec, iv.prec)
    mp.prec = iv.prec = PRECISION
    try:
        return _proved(program, box, math.floor(Fraction(wanted) * UNIT), terms, 0)
    finally:
        mp.prec, iv.prec = before


def _proved(
    program: Program, box: list[tuple[Fraction, Fraction]], wanted: int, terms: Terms, depth: int
) -> bool:
    model = _model(program, box, terms)
    if model is not None:
        if terms.is_bounded(model, wanted):
            return True
        if abs(model.coefficients.get(0, 0)) - model.remainder > wanted:
            return False
    if depth == DEEPEST:
        return False
    bent = [b - a for a, b in box] if model is None else terms.bends(model.coefficients)
    i = max(range(len(box)), key=lambda j: bent[j])
    low, high = box[i]
    middle = (low + high) / 2
    parts = ([*box[:i], part, *box[i + 1 :]] for part in ((low, middle), (middle, high)))
    return all(_proved(program, part, wanted, terms, depth + 1) for part in parts)


# ---- polynomials ----


@dataclass(frozen=True)
class Model:
    """A polynomial and what it leaves out, in units; term 0 is the constant."""

    coefficients: dict[int, int]
    remainder: int


class Terms:
    """Terms of polynomials up to a degree, and what can be done with them."""

    def __init__(self, inputs: int, degree: int) -> None:
        self.degree = degree
        self.powers = [
            tuple(chosen.count(i) for i in range(inputs))
            for k in range(degree + 1)
            for chosen in combinations_with_replacement(range(inputs), k)
        ]
        self.degrees = [sum(powers) for powers in self.powers]
        self.numbers = {powers: i for i, powers in enumerate(self.powers)}
        square = [tuple(2 * p for p in self.powers[1 + j]) for j in range(inputs)]
        self.squares = [self.numbers[powers] for powers in square] if degree > 1 else []

    @cache  # noqa: B019  # as long as the terms
    def _products(self, i: int) -> list[int]:
        room = self.degree - self.degrees[i]
        others = (p for p, k in zip(self.powers, self.degrees, strict=True) if k <= room)
        return [self.numbers[tuple(map(int.__add__, self.powers[i], p))] for p in others]

    def add(self, a: Model, b: Model) -> Model:
        """Return the sum, which is exact."""
        coefficients = dict(a.coefficients)
        for i, c in b.coefficients.items():
            coefficients[i] = coefficients.get(i, 0) + c
        return Model(coefficients, a.remainder + b.remainder)

    def scale(self, a: Model, factor: Fraction) -> Model:
        """Return a multiple; each coefficient is cut by less than a unit."""
        p, q = factor.numerator, factor.denominator
        coefficients = {i: c * p // q for i, c in a.coefficients.items()}
        return Model(coefficients, -(-a.remainder * abs(p) // q) + len(coefficients))

    def multiply(self, a: Model, b: Model) -> Model:
        """Return the product; what is of a higher degree joins the remainder by its size."""
        if len(a.coefficients) > len(b.coefficients):
            a, b = b, a
        total: dict[int, int] = {}
        others = sorted(b.coefficients.items())
        for i, x in a.coefficients.items():
            numbers = self._products(i)
            for j, y in others:
                if j >= len(numbers):
                    break
                k = numbers[j]
                total[k] = total.get(k, 0) + x * y
        sizes_a, sizes_b = self._sizes(a), self._sizes(b)
        left_out = sum(
            x * y for k, x in enumerate(sizes_a) for m, y in enumerate(sizes_b) if k + m > self.degree
        )
        left_out += a.remainder * (sum(sizes_b) + b.remainder) + b.remainder * sum(sizes_a)
        coefficients = {k: c >> BITS for k, c in total.items()}
        return Model(coefficients, (left_out >> BITS) + 1 + len(coefficients))

    def _sizes(self, a: Model) -> list[int]:
        sizes = [0] * (self.degree + 1)
        for i, c in a.coefficients.items():
            sizes[self.degrees[i]] += abs(c)
        return sizes

    def range(self, coefficients: dict[int, int]) -> tuple[int, int]:
        """Enclose the values on the cube."""
        low = high = coefficients.get(0, 0)
        inputs = len(self.powers[0])
        for i, c in coefficients.items():
            if i <= inputs or i in self.squares:
                continue
            if any(p % 2 for p in self.powers[i]):
                low, high = low - abs(c), high + abs(c)
            else:
                low, high = low + min(c, 0), high + max(c, 0)
        for j in range(inputs):
            b = abs(coefficients.get(1 + j, 0))
            a = coefficients.get(self.squares[j], 0) if self.squares else 0
            low, high = low - _highest(b, -a), high + _highest(b, a)
        return low, high

    def is_bounded(self, model: Model, wanted: int) -> bool:
        """Show by bisection of the polynomial that a model's magnitude is at most a number."""
        todo = [(model.coefficients, model.remainder)]
        for _ in range(PIECES):
            coefficients, remainder = todo.pop()
            low, high = self.range(coefficients)
            if max(high, -low) + remainder > wanted:
                if abs(coefficients.get(0, 0)) + remainder > wanted:
                    return False
                bends = self.bends(coefficients)
                i = max(range(len(bends)), key=lambda j: bends[j])
                todo += [self._half(coefficients, remainder, i, side) for side in (-1, 1)]
            if not todo:
                return True
        return False

    def bends(self, coefficients: dict[int, int]) -> list[int]:
        """Return by how much the polynomial is bent along each input."""
        bent = [0] * len(self.powers[0])
        for i, c in coefficients.items():
            if self.degrees[i] > 1:
                for j, power in enumerate(self.powers[i]):
                    bent[j] += power * abs(c)
        return bent

    def _half(
        self, coefficients: dict[int, int], remainder: int, i: int, side: int
    ) -> tuple[dict[int, int], int]:
        """Return the polynomial on one half of the cube, scaled to the cube; x is (side + y)/2."""
        half: dict[int, int] = {}
        for number, c in coefficients.items():
            powers = self.powers[number]
            a = powers[i]
            for b in range(a + 1):
                k = self.numbers[(*powers[:i], b, *powers[i + 1 :])]
                half[k] = half.get(k, 0) + (c * math.comb(a, b) * side ** (a - b) >> a)
                remainder += a > 0
        return half, remainder


def _highest(b: int, a: int) -> int:
    """Bound b·x + a·x² from above on [−1, 1], for b of at least 0."""
    return b * b // (-4 * a) + 1 if a < 0 and b < -2 * a else b + a


# ---- programs ----


def _model(program: Program, box: list[tuple[Fraction, Fraction]], terms: Terms) -> Model | None:
    """Enclose the output on a box; None where a function is not defined everywhere in what is known."""
    models: dict[Expr, Model] = {}
    for i, (symbol, (low, high)) in enumerate(zip(program.inputs, box, strict=True)):
        # A little wider than the box, so that nothing is lost.
        centre, half = math.floor((low + high) / 2 * UNIT), math.ceil((high - low) / 2 * UNIT) + 1
        models[symbol] = Model({0: centre, 1 + i: half}, 0)
    try:
        for symbol, expression in program.steps:
            models[symbol] = _evaluated(expression, models, terms)
        return _evaluated(program.outputs[0], models, terms)
    except _NotDefinedError:
        return None


class _NotDefinedError(Exception):
    """A function is not defined everywhere in what is known of its argument."""


def _evaluated(e: Expr, models: dict[Expr, Model], terms: Terms) -> Model:
    if e.is_Symbol:
        return models[e]
    if e.is_Rational or e.is_Float:
        return Model({0: math.floor(_fraction(e) * UNIT)}, 1)
    factor, rest = e.as_coeff_Mul()
    if factor != 1:
        return terms.scale(_evaluated(rest, models, terms), _fraction(factor))
    if e.is_Add or e.is_Mul:
        joined = terms.add if e.is_Add else terms.multiply
        first, *others = (_evaluated(part, models, terms) for part in e.args)
        for other in others:
            first = joined(first, other)
        return first
    if e.is_Pow and e.exp.is_Integer and e.exp > 0:
        base = power = _evaluated(e.base, models, terms)
        for _ in range(int(e.exp) - 1):
            power = terms.multiply(power, base)
        return power
    kind: Any = ("power", e.exp) if e.is_Pow and e.exp in _POWERS else e.func
    if kind not in _EXPANSIONS:
        raise ValueError(f"program has the step {e}, which is not checked here")
    return _composed(_EXPANSIONS[kind], _evaluated(e.base if e.is_Pow else e.args[0], models, terms), terms)


def _fraction(number: Expr) -> Fraction:
    exact = sympy.Rational(number)  # a Float as it is, bit by bit
    return Fraction(int(exact.p), int(exact.q))


def _composed(expansion: Callable[[Interval, int], list[Interval]], a: Model, terms: Terms) -> Model:
    """Taylor's formula about the constant term; the last derivative on all that the argument may be."""
    centre = a.coefficients.get(0, 0)
    rest = {i: c for i, c in a.coefficients.items() if i}
    reach = sum(map(abs, rest.values())) + a.remainder
    order = terms.degree + 1
    middle, size = _interval(centre, centre), _interval(0, reach)
    last = expansion(_interval(centre - reach, centre + reach), order)[order] * size**order
    low, high = _units(last)
    step, result = Model(rest, a.remainder), Model({}, 0)
    for coefficient in reversed(expansion(middle, terms.degree)):
        lowest, highest = _units(coefficient)
        result = terms.multiply(result, step) if result.coefficients else result
        result = terms.add(result, Model({0: lowest}, highest - lowest))
    return Model(result.coefficients, result.remainder + max(abs(low), abs(high)))


def _interval(low: int, high: int) -> Interval:
    return iv.mpf([mp.ldexp(low, -BITS), mp.ldexp(high, -BITS)])


def _units(x: Interval) -> tuple[int, int]:
    low, high = mp.mpf(x.a), mp.mpf(x.b)
    if not (mp.isfinite(low) and mp.isfinite(high)):
        raise _NotDefinedError
    return int(mp.floor(mp.ldexp(low, BITS))), int(mp.ceil(mp.ldexp(high, BITS)))


def _sine(x: Interval, order: int, first: int = 0) -> list[Interval]:
    s, c = iv.sin(x), iv.cos(x)
    cycle = (s, c, -s, -c)
    return [cycle[(first + k) % 4] / math.factorial(k) for k in range(order + 1)]


def _cosine(x: Interval, order: int) -> list[Interval]:
    return _sine(x, order, 1)


def _exponential(x: Interval, order: int) -> list[Interval]:
    e = iv.exp(x)
    return [e / math.factorial(k) for k in range(order + 1)]


def _tanh(x: Interval, order: int) -> list[Interval]:
    """Polynomials of t = tanh x, each about the middle of t."""
    t = 1 - 2 / (iv.exp(2 * x) + 1)
    middle, values = iv.mpf(t.mid), []
    away = t - middle
    for k in range(order + 1):
        p, total, power = (
            [iv.mpf(f.numerator) / f.denominator for f in _tanh_derivative(k)],
            iv.mpf(0),
            iv.mpf(1),
        )
        for i in range(len(p)):
            for j in range(len(p) - 2, i - 1, -1):
                p[j] += middle * p[j + 1]
        for coefficient in p:
            total, power = total + coefficient * power, power * away
        values.append(total)
    return values


@cache
def _tanh_derivative(k: int) -> list[Fraction]:
    """Coefficients of the derivative of order k of tanh over k!, as a polynomial of tanh."""
    if k == 0:
        return [Fraction(0), Fraction(1)]
    slope, nothing = [i * c / k for i, c in enumerate(_tanh_derivative(k - 1))][1:], [Fraction(0)] * 2
    return [a - b for a, b in zip([*slope, *nothing], [*nothing, *slope], strict=True)]


_POWERS = (sympy.S.NegativeOne, sympy.S.Half, -sympy.S.Half)


def _power(exponent: Expr) -> Callable[[Interval, int], list[Interval]]:
    """Binomial series, for positive arguments; a reciprocal takes negative ones too."""
    p = _fraction(exponent)

    def expansion(x: Interval, order: int) -> list[Interval]:
        if not (x.a > 0 or (p == -1 and x.b < 0)):
            raise _NotDefinedError
        factor, values = Fraction(1), []
        lead = 1 / x if p == -1 else iv.sqrt(x) if p > 0 else 1 / iv.sqrt(x)
        for k in range(order + 1):
            values.append(lead * factor.numerator / factor.denominator)
            factor, lead = factor * (p - k) / (k + 1), lead / x
        return values

    return expansion


_EXPANSIONS: dict[Any, Callable[[Interval, int], list[Interval]]] = {
    sympy.sin: _sine,
    sympy.cos: _cosine,
    sympy.exp: _exponential,
    sympy.tanh: _tanh,
    **{("power", exponent): _power(exponent) for exponent in _POWERS},
}
