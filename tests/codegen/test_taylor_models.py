"""Taylor models enclose what a program computes, and not much more."""

import ctypes
import shutil
from collections.abc import Callable
from fractions import Fraction
from itertools import product

import mpmath
import numpy as np
import pytest
import sympy

from dexterity.codegen.taylor_models import LEAF, OPEN, TaylorModel, TaylorModels, exactly
from dexterity.program import Program, Recorder, copysign, select

pytestmark = pytest.mark.skipif(
    not any(map(shutil.which, ("cc", "gcc", "clang"))), reason="there is no C compiler"
)

X, Y = sympy.symbols("x y", real=True)


def program(*expressions: sympy.Expr, inputs: tuple[sympy.Symbol, ...] = (X,)) -> Program:
    record = Recorder()
    return record.program(inputs, [record(expression) for expression in expressions])


def exact_value(model: TaylorModel, at: tuple[Fraction, ...]) -> Fraction:
    """The polynomial without rounding."""
    total = Fraction(0)
    for powers, coefficient in zip(model.powers, model.coefficients, strict=True):
        term = Fraction(float(coefficient))
        for x, power in zip(at, powers, strict=True):
            term *= x**power
        total += term
    return total


FUNCTIONS: dict[str, tuple[sympy.Expr, Callable, float, float]] = {
    "sine": (sympy.sin(X), mpmath.sin, -0.3, 0.9),
    "cosine": (sympy.cos(X), mpmath.cos, 2.0, 2.7),
    "tanh": (sympy.tanh(X), mpmath.tanh, -0.6, 0.4),
    "tanh far out": (sympy.tanh(X), mpmath.tanh, 3.0, 4.0),
    "exponential": (sympy.exp(X), mpmath.exp, -2.0, -1.2),
    "logarithm": (sympy.log(X), mpmath.log, 2.0, 3.0),
    "root": (sympy.sqrt(X), mpmath.sqrt, 2.0, 3.0),
    "reciprocal root": (1 / sympy.sqrt(X), lambda x: 1 / mpmath.sqrt(x), 2.0, 3.0),
    "reciprocal": (1 / X, lambda x: 1 / x, 2.0, 3.0),
    "negative reciprocal": (1 / X, lambda x: 1 / x, -3.0, -2.0),
    "power": (X**3, lambda x: x**3, 2.0, 3.0),
    "negative power": (X**-2, lambda x: x**-2, 2.0, 3.0),
    "magnitude": (sympy.Abs(X), abs, -3.0, -2.0),
    "sign": (copysign(sympy.exp(X), X), lambda x: -mpmath.exp(x), -0.9, -0.5),
    "choice": (select(X, sympy.sin(X), sympy.cos(X)), mpmath.sin, 0.5, 0.9),
    "rational factor": (X / 3 + sympy.Rational(1, 7), lambda x: x / 3 + mpmath.mpf(1) / 7, 0.1, 0.2),
    "irrational factor": (sympy.sqrt(2) * X + sympy.pi, lambda x: mpmath.sqrt(2) * x + mpmath.pi, 0.1, 0.2),
}


@pytest.mark.parametrize("name", FUNCTIONS)
def test_a_function_is_enclosed(name: str) -> None:
    expression, function, lower, upper = FUNCTIONS[name]
    model = TaylorModels(program(expression), degree=6).on([lower], [upper])
    low, high = Fraction(lower), Fraction(upper)
    with mpmath.workdps(40):
        for i in range(101):
            x = Fraction(2 * i - 100, 100)
            q = (low + high) / 2 + x * (high - low) / 2
            exact = function(mpmath.mpf(q.numerator) / q.denominator)
            polynomial = exact_value(model, (x,))
            error = abs(mpmath.mpf(polynomial.numerator) / polynomial.denominator - exact)
            assert error <= model.remainder
    assert model.remainder <= 1e-4


@pytest.mark.parametrize("degree", [1, 2, 3, 5, 8])
def test_the_remainder_vanishes_with_the_box_as_the_degree_says(degree: int) -> None:
    models = TaylorModels(program(sympy.tanh(X) / sympy.sqrt(2 + Y), inputs=(X, Y)), degree)
    remainders = [models.on([0.2 - h, -h], [0.2 + h, h]).remainder for h in (0.2, 0.1)]
    assert remainders[1] < remainders[0] / 1.6 ** (degree + 1)


def test_products_of_high_degree_are_enclosed_exactly() -> None:
    """Terms that are cut are in the remainder, and so is rounding: all is compared in fractions."""
    random = np.random.default_rng(0)
    for _ in range(2):
        a, b, c = (exactly(number) for number in random.normal(size=3))
        expression = (X + a * Y + b) ** 2 * (X - Y * c) ** 2
        model = TaylorModels(program(expression, inputs=(X, Y)), degree=3).on([-1, -1], [1, 1])
        a, b, c = (Fraction(int(number.p), int(number.q)) for number in (a, b, c))
        for x, y in product([Fraction(i, 3) for i in range(-3, 4)], repeat=2):
            exact = (x + a * y + b) ** 2 * (x - y * c) ** 2
            assert abs(exact - exact_value(model, (x, y))) <= Fraction(model.remainder)


def test_rounding_is_in_the_remainder() -> None:
    """(x + a)² − x² − 2ax − a² is zero, and computed in doubles it is not."""
    record = Recorder()
    shift = exactly(1e8 / 3)
    square = record(record(X + shift) ** 2)
    difference = record(record(square - record(X**2)) - record(2 * shift * X))
    zero = record.program((X,), [record(difference - shift**2)])
    model = TaylorModels(zero, degree=2).on([-1 / 3], [2 / 3])
    sizes = abs(model.coefficients).sum()
    assert 0 < sizes <= model.remainder


def test_what_the_box_does_not_decide_is_unknown() -> None:
    for expression in (sympy.Abs(X), sympy.sqrt(X), 1 / X, sympy.log(X), select(X, X, -X)):
        assert TaylorModels(program(expression), degree=3).on([-1], [1]).remainder == np.inf


def test_a_box_without_width() -> None:
    model = TaylorModels(program(sympy.sin(X) / X), degree=3).on([0.5], [0.5])
    assert abs(model.coefficients[0] - np.sin(0.5) / 0.5) <= model.remainder < 1e-12


def test_functions_of_the_c_library_err_by_less_than_is_taken_on_trust() -> None:
    library = ctypes.CDLL(None)
    random = np.random.default_rng(0)
    with mpmath.workdps(40):
        for name in ("sin", "cos", "tanh", "exp", "log"):
            function, exact = getattr(library, name), getattr(mpmath, name)
            function.restype, function.argtypes = ctypes.c_double, [ctypes.c_double]
            for x in random.uniform(0.01 if name == "log" else -5, 5, 2000):
                value = function(x)
                assert abs(exact(mpmath.mpf(x)) - value) <= 16 * np.spacing(abs(value))


def test_parameters_are_numbers_of_a_box() -> None:
    models = TaylorModels(program(X * Y - X, inputs=(X, Y)), degree=2, parameters=1)
    model = models.on([1], [3], given=[1.5])
    np.testing.assert_allclose(model.coefficients, [1.0, 0.5, 0.0], atol=model.remainder)
    assert model.powers == ((0,), (1,), (2,))
    assert models.prove([1], [3], 1.6, given=[1.5]).tree.tolist() == [LEAF]
    with pytest.raises(ValueError, match=r"given is .*; 1 finite"):
        models.on([1], [3])


# ---- proofs ----

HUMP = program(X - X**2 + Y / 4 - Y**2 / 4, inputs=(X, Y))
"""Its largest value on the unit square is 5/16, in the middle."""


def test_a_bound_is_proved_where_it_holds_and_only_there() -> None:
    models = TaylorModels(HUMP, degree=3)
    assert models.prove([0, 0], [1, 1], 0.3126).tree.tolist() == [LEAF]
    refused = models.prove([0, 0], [1, 1], 0.3124)
    assert (refused.tree == OPEN).any()
    assert 0.3124 < refused.reached <= 0.3125
    assert refused.bounds[refused.tree >= OPEN].max() >= 0.3125


def test_the_polynomial_is_bisected_before_the_box() -> None:
    saddle = program(sympy.sin(3 * X) * sympy.cos(3 * Y) - X * Y, inputs=(X, Y))
    models = TaylorModels(saddle, degree=8)
    many, few = (models.prove([0, 0], [1, 1], 1.58, budget=budget) for budget in (0, 1000))
    assert not (many.tree == OPEN).any()
    assert not (few.tree == OPEN).any()
    assert len(few.tree) < len(many.tree)


def test_the_work_can_be_limited_and_stopped() -> None:
    models = TaylorModels(HUMP, degree=1)
    limited = models.prove([0, 0], [1, 1], 0.3126, boxes=3, budget=0)
    assert len(limited.tree) <= 7
    assert (limited.tree == OPEN).any()
    assert np.isfinite(limited.bounds).all()
    stopped = models.prove([0, 0], [1, 1], 0.3126, stop=ctypes.c_int(1))
    assert stopped.tree.tolist() == [OPEN]
    assert stopped.bounds.tolist() == [np.inf]


def test_bad_arguments() -> None:
    with pytest.raises(ValueError, match="2 outputs"):
        TaylorModels(program(X, X**2))
    with pytest.raises(ValueError, match="degree is 11"):
        TaylorModels(HUMP, 11)
    with pytest.raises(ValueError, match="acos"):
        TaylorModels(program(sympy.acos(X)))
    models = TaylorModels(HUMP, 2)
    with pytest.raises(ValueError, match=r"lower is .*; 2 finite"):
        models.on([0], [1, 1])
    with pytest.raises(ValueError, match=r"upper is .*; 2 finite"):
        models.on([0, 0], [1, np.nan])
    with pytest.raises(ValueError, match="may not exceed"):
        models.on([0, 2], [1, 1])
    with pytest.raises(ValueError, match="wanted"):
        models.prove([0, 0], [1, 1], 0.0)
