"""The second proof of a part: bounds that hold are shown, bounds that do not hold are not."""

import math

import mpmath
import numpy as np
import pytest
import sympy

import dexterity as dx
from dexterity.networks.certificate import relative_error
from dexterity.networks.certificate_check import is_bounded
from dexterity.program import Program, Recorder

X, Y = sympy.symbols("x y", real=True)

LARGEST: dict[str, tuple[sympy.Expr, float, float, float]] = {
    "sine": (sympy.sin(X), -0.3, 0.9, math.sin(0.9)),
    "cosine": (sympy.cos(X), 0.4, 0.9, math.cos(0.4)),
    "tanh": (sympy.tanh(X), -0.6, 1.4, math.tanh(1.4)),
    "exponential": (sympy.exp(X), -1.0, 0.3, math.exp(0.3)),
    "root": (sympy.sqrt(X), 2.0, 3.0, math.sqrt(3)),
    "reciprocal root": (1 / sympy.sqrt(X), 2.0, 3.0, 1 / math.sqrt(2)),
    "reciprocal": (1 / X, 2.0, 3.0, 0.5),
    "negative reciprocal": (1 / X, -3.0, -2.0, 0.5),
    "power": (X**3 / 7, -3.0, 2.0, 27 / 7),
    "double": (sympy.Float(0.1) * X + sympy.Float(1e-60), -1.0, 1.0, 0.1),
}


def program(expression: sympy.Expr, *inputs: sympy.Symbol) -> Program:
    record = Recorder()
    return record.program(inputs, [record(expression)])


@pytest.mark.parametrize("name", LARGEST)
@pytest.mark.parametrize("degree", [2, 5])
def test_the_largest_value_is_bounded_from_above_only(name: str, degree: int) -> None:
    expression, lower, upper, largest = LARGEST[name]
    one = program(expression, X)
    assert is_bounded(one, [lower], [upper], 1.0001 * largest, degree)
    assert not is_bounded(one, [lower], [upper], 0.9999 * largest, degree)


def test_two_inputs_and_cancellation() -> None:
    identity = program(sympy.sin(X) ** 2 + sympy.cos(X) ** 2 - 1 + X * Y - Y * X / 2, X, Y)
    assert is_bounded(identity, [-1, -1], [1, 1], 0.501)
    assert not is_bounded(identity, [-1, -1], [1, 1], 0.499)


def test_what_is_not_defined_is_not_bounded() -> None:
    for expression in (1 / X, sympy.sqrt(X)):
        assert not is_bounded(program(expression, X), [-1.0], [1.0], 100.0, degree=2)


def test_the_shipped_network_on_parts_of_its_box() -> None:
    network = dx.networks.load_shipped("uvms-manipulability-feed-forward")
    box, worst = network.card.space(), network.card["worst_case"]
    error = relative_error(network, dx.robots.uvms(), network.card.index(), box)
    joints = [int(symbol.name[1:]) - 1 for symbol in error.inputs]
    lower, upper, q = (np.array(row)[joints] for row in (box.lower, box.upper, worst["q"]))
    assert is_bounded(error, lower, lower + (upper - lower) / 6, 0.002, degree=4)
    near = (np.maximum(lower, q - 0.002), np.minimum(upper, q + 0.002))
    assert is_bounded(error, *near, 1.002 * worst["error"], degree=3)
    assert not is_bounded(error, *near, 0.99 * worst["error"], degree=3)


def test_bad_arguments_and_precision_left_as_it_was() -> None:
    before = mpmath.mp.prec, mpmath.iv.prec
    one = program(sympy.sin(X), X)
    with pytest.raises(ValueError, match="lower is"):
        is_bounded(one, [0.0, 1.0], [1.0], 1.0)
    with pytest.raises(ValueError, match="upper is"):
        is_bounded(one, [0.0], [math.inf], 1.0)
    with pytest.raises(ValueError, match="wanted"):
        is_bounded(one, [0.0], [1.0], 0.0)
    with pytest.raises(ValueError, match="2 outputs"):
        is_bounded(Program((X,), (), (X, -X)), [0.0], [1.0], 1.0)
    with pytest.raises(ValueError, match="acos"):
        is_bounded(program(sympy.acos(X), X), [0.0], [0.5], 2.0)
    assert (mpmath.mp.prec, mpmath.iv.prec) == before
