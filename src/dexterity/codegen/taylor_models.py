"""Programs in Taylor models: C code that encloses what a program computes on a whole box of its inputs.

A Taylor model is a polynomial with a remainder that covers everything the polynomial leaves out: terms of
higher degree, the error of an elementary function's approximation, and rounding.
The recorded program is walked once and each step becomes a few calls. What comes out encloses the real
number that the program stands for, for all inputs in the box, and not only what some arithmetic makes of it.

Two things are taken on trust: the C compiler, and that sine, cosine, exponential, logarithm and hyperbolic
tangent of the C library err by at most 16 units of the last place.

Examples
--------
The sine between −0.5 and 0.5 as a polynomial of degree 5 in x = 2q:

>>> import sympy
>>> from dexterity.codegen.taylor_models import TaylorModels
>>> from dexterity.program import Recorder
>>> q, record = sympy.Symbol("q", real=True), Recorder()
>>> models = TaylorModels(record.program([q], [sympy.sin(q)]), degree=5)
>>> model = models.on([-0.5], [0.5])
>>> model.powers[1], round(float(model.coefficients[1]), 4), model.remainder < 1e-6
((1,), 0.5, True)

References
----------
Makino & Berz (2003), Taylor models and other validated functional inclusion methods; Moore, Kearfott & Cloud
(2009), Introduction to interval analysis.
"""

from __future__ import annotations

import ctypes
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cache, cached_property
from itertools import combinations_with_replacement
from typing import Any

import numpy as np
import sympy
from jaxtyping import Float64
from numpy.typing import ArrayLike
from sympy import Expr, Symbol

from dexterity import checks
from dexterity.codegen.library import compiled_library
from dexterity.codegen.printing import number, template
from dexterity.program import Program, copysign, select

__all__ = ["LEAF", "OPEN", "Proof", "TaylorModel", "TaylorModels", "exactly"]

LEAF = 255
"""Mark in the tree of a proof for a box that is bounded as wanted."""

OPEN = 254
"""Mark in the tree of a proof for a box that is not."""

MOST_TERMS = 5000
"""Terms that a polynomial may have."""


@dataclass(frozen=True)
class TaylorModel:
    """A polynomial on a box with a bound of what it leaves out.

    Attributes
    ----------
    powers
        For each of t terms the powers of the n scaled inputs, which run from −1 to 1 through the box.
    coefficients
        (t) of the terms.
    remainder
        Largest difference to the function anywhere in the box; infinite if no bound was found.
    """

    powers: tuple[tuple[int, ...], ...]
    coefficients: Float64[np.ndarray, " t"]
    remainder: float


@dataclass(frozen=True)
class Proof:
    """How far a box was bounded.

    Attributes
    ----------
    tree
        (k) the bisections in preorder: number of the input that is halved, lower half first; `LEAF` for a box
        that is bounded as wanted; `OPEN` for one that is not.
    bounds
        (k) of the boxes, where these two stand; else what was known before the box was halved.
    reached
        A magnitude that the output is known to reach somewhere in the box.
    """

    tree: np.ndarray
    bounds: np.ndarray
    reached: float


class TaylorModels:
    """Encloses the only output of a program of n inputs, compiled when first asked.

    Parameters
    ----------
    program
        Sums, products, whole powers, square roots, sines, cosines, exponentials, logarithms, hyperbolic
        tangents, and magnitudes and choices whose sign the box decides.
    degree
        Of the polynomials, in all inputs together.
    parameters
        How many of the program's last inputs are numbers that a box brings along and that do not vary in it.

    Raises
    ------
    ValueError
        If the program has several outputs or steps of another kind, or the polynomials have too many terms.
    """

    def __init__(self, program: Program, degree: int = 5, parameters: int = 0) -> None:
        self.program = program
        self.parameters = checks.whole(parameters, "parameters", least=0)
        self.degree = checks.whole(degree, "degree", least=1)
        if len(program.outputs) != 1:
            raise ValueError(f"program has {len(program.outputs)} outputs; one is needed")
        if (
            not program.inputs
            or math.comb(self.inputs + degree, degree) > MOST_TERMS
            or self.inputs > 16
            or degree > 10
        ):
            raise ValueError(
                f"degree is {degree} for {self.inputs} inputs; polynomials in 1 to 16 inputs of at most "
                f"{MOST_TERMS} terms and degree 10 are needed"
            )
        self.source = _source(program, self.inputs, self.degree)

    @property
    def inputs(self) -> int:
        """Number n of inputs that vary."""
        return len(self.program.inputs) - self.parameters

    @cached_property
    def _library(self) -> ctypes.CDLL:
        return compiled_library(self.source)

    def on(self, lower: ArrayLike, upper: ArrayLike, given: Sequence[float] | np.ndarray = ()) -> TaylorModel:
        """Return the model on the box between two corners (n), with the values of the parameters.

        Raises
        ------
        ValueError
            If the corners are no finite numbers in order, or the parameters are not as many finite numbers.
        """
        low, high = self._corners(lower, upper)
        numbers = self._numbers(given, "given", self.parameters)
        powers = _monomials(self.inputs, self.degree)
        coefficients, remainder = np.empty(len(powers)), ctypes.c_double()
        self._call(
            "taylor_model", _at(low), _at(high), _at(numbers), _at(coefficients), ctypes.byref(remainder)
        )
        return TaylorModel(tuple(powers), coefficients, remainder.value)

    def prove(
        self,
        lower: ArrayLike,
        upper: ArrayLike,
        wanted: float,
        boxes: int = 1000,
        budget: int = 300,
        stop: ctypes.c_int | None = None,
        given: Sequence[float] | np.ndarray = (),
    ) -> Proof:
        """Bisect a box until the magnitude of the output is shown to be at most `wanted` in all parts.

        Threads can work on several boxes at once: Python's lock is not held.

        Parameters
        ----------
        lower, upper
            (n) corners of the box.
        wanted
            The bound.
        boxes
            Models to make at most; what is then left stays open, and so does all once `wanted` is exceeded.
        budget
            Bisections of a model's polynomial, before the box is halved instead.
        stop
            Set to another value than 0 from elsewhere, it ends the work; what is left stays open.
        given
            Values of the parameters.

        Raises
        ------
        ValueError
            If the corners are no finite numbers in order, the parameters are not as many finite numbers, or a
            number is not positive.
        """
        low, high = self._corners(lower, upper)
        numbers = self._numbers(given, "given", self.parameters)
        boxes = checks.whole(boxes, "boxes", least=1)
        budget = checks.whole(budget, "budget", least=0)
        wanted = checks.real(wanted, "wanted", above=0)
        stop = ctypes.c_int(0) if stop is None else stop
        tree, bounds = np.empty(2 * boxes + 1, np.uint8), np.empty(2 * boxes + 1)
        length, reached = ctypes.c_long(), ctypes.c_double()
        self._call(
            "taylor_prove", _at(low), _at(high), _at(numbers), ctypes.c_double(wanted), ctypes.c_long(boxes),
            ctypes.c_long(budget), ctypes.byref(stop), _at(tree), _at(bounds), ctypes.byref(length),
            ctypes.byref(reached),
        )  # fmt: skip
        return Proof(tree[: length.value].copy(), bounds[: length.value].copy(), reached.value)

    def _call(self, name: str, *arguments: Any) -> None:
        if getattr(self._library, name)(*arguments):
            raise MemoryError(f"{name} found no memory")

    def _corners(self, lower: ArrayLike, upper: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
        corners = [
            self._numbers(corner, name, self.inputs) for name, corner in (("lower", lower), ("upper", upper))
        ]
        if not (corners[0] <= corners[1]).all():
            raise ValueError(
                f"lower is {corners[0]} and upper {corners[1]}; lower ones may not exceed upper ones"
            )
        return corners[0], corners[1]

    def _numbers(self, values: ArrayLike | Sequence[float], name: str, count: int) -> np.ndarray:
        numbers = np.array(values, dtype=np.float64)
        if numbers.shape != (count,) or not np.isfinite(numbers).all():
            raise ValueError(f"{name} is {numbers}; {count} finite numbers are needed")
        return numbers


def _at(array: np.ndarray) -> ctypes.c_void_p:
    return ctypes.c_void_p(array.ctypes.data)


# ---- tables of polynomials ----


def _monomials(inputs: int, degree: int) -> list[tuple[int, ...]]:
    """Powers of all terms, by degree."""
    return [
        tuple(chosen.count(i) for i in range(inputs))
        for k in range(degree + 1)
        for chosen in combinations_with_replacement(range(inputs), k)
    ]


def _tables(inputs: int, degree: int) -> dict[str, Any]:
    powers = _monomials(inputs, degree)
    number_of = {term: i for i, term in enumerate(powers)}
    degrees = [sum(term) for term in powers]
    start = [math.comb(inputs + k - 1, inputs) for k in range(degree + 2)]
    rows: list[int] = []
    products: list[int] = []
    for term, own in zip(powers, degrees, strict=True):
        rows.append(len(products))
        others = powers[: start[degree - own + 1]]
        products += [number_of[tuple(a + b for a, b in zip(term, other, strict=True))] for other in others]
    holders, divided = [], []
    for i in range(inputs):
        holding = sorted((j for j, term in enumerate(powers) if term[i]), key=lambda j: -powers[j][i])
        holders.append(holding)
        divided.append([number_of[(*powers[j][:i], powers[j][i] - 1, *powers[j][i + 1 :])] for j in holding])
    odd = [sum((power % 2) << i for i, power in enumerate(term)) for term in powers]
    above = [sum(term[0] > k for term in powers) for k in range(degree)]
    return {
        "variables": inputs, "degree": degree, "terms": len(powers), "holding": len(holders[0]),
        "start": _listed(start), "degrees": _listed(degrees), "powers": _nested(powers),
        "rows": _listed(rows), "products": _listed(products), "holders": _nested(holders),
        "divided": _nested(divided), "above": _listed(above), "odd": _listed(odd),
        **_interpolation(degree),
    }  # fmt: skip


@cache
def _interpolation(degree: int) -> dict[str, str]:
    """Chebyshev's nodes as doubles; weights of values there in the coefficients, exact and then rounded."""
    count = degree + 1
    nodes = [math.cos(math.pi * (2 * j + 1) / (2 * count)) for j in range(count)]
    columns = [_lagrange([Fraction(node) for node in nodes], j) for j in range(count)]
    weights = [[float(column[k]) for column in columns] for k in range(count)]
    return {
        "nodes": _listed(map(number, nodes)),
        "weights": _nested([number(x) for x in row] for row in weights),
        "sum_of_weights": number(1.001 * sum(abs(x) for row in weights for x in row)),
        "tanh": _listed(number(float(x)) for x in _derivative_of_tanh(count)),
    }


def _lagrange(nodes: Sequence[Fraction], j: int) -> list[Fraction]:
    """Coefficients of the polynomial that is 1 at one node and 0 at the others."""
    coefficients = [Fraction(1)]
    for other in (*nodes[:j], *nodes[j + 1 :]):
        scale = 1 / (nodes[j] - other)
        shifted, kept = [Fraction(0), *coefficients], [*coefficients, Fraction(0)]
        coefficients = [scale * (a - other * b) for a, b in zip(shifted, kept, strict=True)]
    return coefficients


def _derivative_of_tanh(order: int) -> list[Fraction]:
    """Coefficients of the derivative over its factorial, as a polynomial of tanh."""
    p = [Fraction(0), Fraction(1)]
    for k in range(1, order + 1):
        slope = [*(i * a / k for i, a in enumerate(p))][1:]
        p = [
            a - b
            for a, b in zip(
                [*slope, Fraction(0), Fraction(0)], [Fraction(0), Fraction(0), *slope], strict=True
            )
        ]
    return p


def _listed(items: Iterable[Any]) -> str:
    return ", ".join(map(str, items))


def _nested(rows: Iterable[Iterable[Any]]) -> str:
    return ",\n    ".join(f"{{{_listed(row)}}}" for row in rows)


# ---- steps ----


def _source(program: Program, inputs: int, degree: int) -> str:
    writer = _Writer(program, inputs)
    return template("taylor_models.c.in").substitute(
        _tables(inputs, degree), steps="\n".join(writer.lines), slots=writer.slots
    )


_FUNCTIONS = {sympy.sin: "SIN", sympy.cos: "COS", sympy.tanh: "TANH_", sympy.exp: "EXP", sympy.log: "LOG"}
_ROOTS = {
    sympy.S.Half: "ROOT",
    -sympy.S.Half: "RECIPROCAL_ROOT",
    sympy.S.NegativeOne: "RECIPROCAL",
}
_SCRATCH = 2
"""Slots at the front that composition uses."""


class _Writer:
    """Writes the steps of a program as calls; a slot is used again when its symbol is needed no more."""

    def __init__(self, program: Program, inputs: int) -> None:
        self.lines: list[str] = []
        self.slots = _SCRATCH
        self._free: list[int] = []
        self._slots: dict[Symbol, int] = {}
        self._last = {
            used: i
            for i, expression in enumerate([*(e for _, e in program.steps), *program.outputs])
            for used in expression.free_symbols
        }
        for i, symbol in enumerate(program.inputs):
            if symbol in self._last:
                self._slots[symbol] = self._new()
                varies = f"variable(s + {self._slots[symbol]}, {i}, centre, half)"
                given = f"exactly(s + {self._slots[symbol]}, given[{i - inputs}])"
                self._line(varies if i < inputs else given)
        for i, (symbol, expression) in enumerate(program.steps):
            slot = self._written(expression)
            for used in expression.free_symbols:
                if self._last[used] == i:
                    self._free.append(self._slots.pop(used))
            self._slots[symbol] = slot
        self._line(f"*out = s[{self._written(program.outputs[0])}]")

    def _new(self) -> int:
        if not self._free:
            self._free.append(self.slots)
            self.slots += 1
        return self._free.pop()

    def _line(self, text: str) -> None:
        self.lines.append(f"    {text};")

    def _call(self, function: str, *arguments: object) -> int:
        slot = self._new()
        self._line(f"{function}(s + {slot}, {', '.join(map(str, arguments))})")
        return slot

    def _joined(self, function: str, parts: Sequence[Expr]) -> int:
        """Slot of all parts, joined two by two."""
        slot = self._written(parts[0])
        for part in parts[1:]:
            other = self._written(part)
            joined = self._call(function, f"s + {slot}", f"s + {other}")
            self._done(slot, other)
            slot = joined
        return slot

    def _done(self, *slots: int) -> None:
        """Free slots that hold no symbol."""
        named = set(self._slots.values())
        self._free += [slot for slot in dict.fromkeys(slots) if slot not in named and slot not in self._free]

    def _of(self, function: str, *parts: Expr, after: Sequence[object] = ()) -> int:
        own = [self._written(part) for part in parts]
        slot = self._call(function, *(f"s + {i}" for i in own), *after)
        self._done(*own)
        return slot

    def _written(self, e: Expr) -> int:
        """Slot that holds an expression."""
        if e.is_Symbol:
            return self._slots[e]
        if e.is_number:
            return self._call("constant", number(float(e)))
        if e.is_Add or e.is_Mul:
            constant, rest = e.as_coeff_Add() if e.is_Add else e.as_coeff_Mul()
            if constant != (0 if e.is_Add else 1):
                return self._of("raised" if e.is_Add else "scaled", rest, after=[number(float(constant))])
            return self._joined("sum" if e.is_Add else "product", e.args)
        if e.is_Pow and e.exp in _ROOTS:
            return self._composed(_ROOTS[e.exp], e.base)
        if e.is_Pow and e.exp.is_Integer:
            base = e.base if e.exp > 0 else e.base**-1
            slot = self._written(base)
            return self._power(slot, abs(int(e.exp)))
        if e.func in _FUNCTIONS:
            return self._composed(_FUNCTIONS[e.func], e.args[0])
        if isinstance(e, sympy.Abs | copysign):
            magnitude, sign = (e.args[0], e.args[0]) if isinstance(e, sympy.Abs) else e.args
            return self._of("chosen", magnitude, -magnitude, sign)
        if isinstance(e, select):
            return self._of("chosen", e.args[1], e.args[2], e.args[0])
        raise ValueError(f"program has the step {e}, which no Taylor model is written for")

    def _composed(self, name: str, argument: Expr) -> int:
        own = self._written(argument)
        slot = self._new()
        self._line(f"composed(s + {slot}, {name}, s + {own}, s)")
        self._done(own)
        return slot

    def _power(self, base: int, exponent: int) -> int:
        slot = base
        for _ in range(exponent - 1):
            raised = self._call("product", f"s + {slot}", f"s + {base}")
            if slot != base:
                self._done(slot)
            slot = raised
        self._done(base)
        return slot


def exactly(x: float) -> sympy.Rational:
    """Return a double as the fraction that it is, so that no symbolic step rounds it."""
    fraction = Fraction(float(x))
    return sympy.Rational(fraction.numerator, fraction.denominator)
