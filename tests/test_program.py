"""Straight-line programs: what is shared, what is left out, and derivatives against sympy's own."""

import math

import numpy as np
import pytest
import sympy
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal
from sympy import Abs, S, Symbol, cos, sin, sqrt

from dexterity.program import Program, Recorder, copysign, gradient
from program_values import values_of

a, b, c, x, y, z = sympy.symbols("a b c x y z", real=True)


def roots_and_angles() -> Program:
    """Every kind of step that a derivation takes, with an input that nothing needs."""
    record = Recorder()
    s, co = record(sin(record(x + y))), record(cos(record(x + y)))
    length = record(sqrt(record(s**2 + z**2 + 1)))
    scale = record(1 / record(length + Abs(s)))
    return record.program(
        (x, y, z, a), [record(scale * co), -copysign(length, z), record(s * co * length), S(3), y, -s]
    )


def points(rng: np.random.Generator, program: Program) -> dict[Symbol, np.ndarray]:
    return {symbol: rng.uniform(-2, 2, 20) for symbol in program.inputs}


# ---- recording -------------------------------------------------------------------------------------


def test_equal_expressions_share_a_name_and_opposite_ones_share_it_up_to_the_sign():
    record = Recorder()
    assert record(a + b) == record(b + a)
    assert record(a - b) == -record(b - a)
    assert record(-a * b) == -record(a * b)
    assert record(-sin(a)) == -record(sin(a)) == record(sin(-a))
    assert len({record(a + b), record(a - b), record(a * b), record(sin(a))}) == 4


def test_symbols_numbers_and_their_negatives_need_no_name():
    record = Recorder()
    for expression in (a, -a, S(2), S.Half, S.Zero, sympy.Float(-0.25)):
        assert record(expression) == expression
    assert record(0) == S.Zero
    assert record.program((a,), [a, -a, S(2)]) == Program((a,), (), (a, -a, S(2)))


def test_names_are_numbered_behind_their_prefix_in_the_order_of_recording():
    record = Recorder("t")
    assert [str(name) for name in record.all([a + b, a * b, a + b])] == ["t0", "t1", "t0"]


def test_a_step_uses_only_inputs_and_earlier_steps():
    program = roots_and_angles()
    known = set(program.inputs)
    for symbol, expression in program.steps:
        assert expression.free_symbols <= known
        assert symbol not in known
        known.add(symbol)
    assert set().union(*(output.free_symbols for output in program.outputs)) <= known


# ---- programs --------------------------------------------------------------------------------------


def test_steps_that_lead_to_no_output_are_left_out():
    record = Recorder()
    kept, _ = record(sin(record(a + b))), record(cos(record(a * c)))
    program = record.program((a, b, c), [kept])
    assert [expression for _, expression in program.steps] == [a + b, sin(record(a + b))]
    assert program.used_inputs == (a, b)
    assert program.inputs == (a, b, c)
    assert program.leading_to([S.One]) == Program((a, b, c), (), (S.One,))


def test_inputs_are_used_in_their_own_order_whatever_the_order_of_the_steps():
    record = Recorder()
    assert record.program((c, b, a), [record(a + b), -c]).used_inputs == (c, b, a)


def test_a_nested_program_is_the_expression_that_was_recorded():
    record = Recorder()
    s = record(sin(record(a + b)))
    program = record.program((a, b), [record(s**2 + record(s * b)), -s, S(7)])
    assert program.nested() == (sin(a + b) ** 2 + b * sin(a + b), -sin(a + b), 7)


def test_a_nested_program_has_the_values_of_its_steps(rng):
    program = roots_and_angles()
    inputs = points(rng, program)
    nested = Program(program.inputs, (), program.nested())
    assert_allclose(values_of(nested, inputs), values_of(program, inputs), rtol=1e-13, atol=1e-15)


def test_a_program_that_is_replayed_has_its_inputs_replaced_and_shares_what_is_there():
    record = Recorder()
    program = record.program((a, b), [record(sin(record(a + b)))])
    other = Recorder("y")
    known = other(x - y)
    (output,) = other.replay(program, {a: x, b: -y})
    assert other.program((x, y), [output]).nested() == (sin(x - y),)
    assert other.program((x, y), [output]).steps[0] == (known, x - y)
    assert Recorder().replay(program) == [record(sin(record(a + b)))]


# ---- gradients -------------------------------------------------------------------------------------


def test_a_gradient_follows_the_outputs_of_its_program(rng):
    program = roots_and_angles()
    inputs = points(rng, program)
    differentiated = gradient(program)
    assert differentiated.inputs == program.inputs
    assert_array_equal(values_of(differentiated, inputs)[:, :6], values_of(program, inputs))


def test_a_gradient_is_the_one_of_sympy(rng):
    program = roots_and_angles()
    inputs = points(rng, program)
    total = sympy.Add(*program.nested())
    expected = Program(program.inputs, (), tuple(total.diff(symbol) for symbol in program.inputs))
    derivatives = values_of(gradient(program), inputs)[:, 6:]
    assert_allclose(derivatives, values_of(expected, inputs), rtol=1e-12, atol=1e-14)
    assert_array_equal(derivatives[:, 3], 0)


def test_a_gradient_is_the_one_of_finite_differences(rng):
    program = roots_and_angles()
    inputs = points(rng, program)
    derivatives = values_of(gradient(program), inputs)[:, 6:]
    step = 1e-6
    for i, symbol in enumerate(program.inputs):
        above, below = (
            values_of(program, inputs | {symbol: inputs[symbol] + h}).sum(-1) for h in (step, -step)
        )
        assert_allclose(derivatives[:, i], (above - below) / (2 * step), rtol=1e-7, atol=1e-8)


def test_weights_of_a_gradient_count_as_constants(rng):
    """The outputs themselves as weights give half the gradient of the sum of their squares."""
    program = roots_and_angles()
    inputs = points(rng, program)
    weighed = gradient(program, lambda record, outputs: outputs)
    half_squares = sympy.Add(*(output**2 / 2 for output in program.nested()))
    expected = Program(program.inputs, (), tuple(half_squares.diff(symbol) for symbol in program.inputs))
    assert_allclose(values_of(weighed, inputs)[:, 6:], values_of(expected, inputs), rtol=1e-11, atol=1e-13)


def test_weights_may_bring_inputs_along():
    record = Recorder()
    program = record.program((x, y), [record(x * y), record(sin(x))])
    weighed = gradient(program, lambda _, outputs: [a, b], extra=(a, b))
    assert weighed.inputs == (x, y, a, b)
    assert weighed.nested() == (x * y, sin(x), a * y + b * cos(x), a * x)


def test_outputs_without_steps_have_gradients_too():
    assert gradient(Program((x, y), (), (-x, S(2)))).nested() == (-x, 2, -1, 0)


# ---- copysign --------------------------------------------------------------------------------------

numbers = st.floats(-1e3, 1e3)


@given(magnitude=st.floats(0, 1e3), sign=numbers)
def test_copysign_is_that_of_c(magnitude, sign):
    compute = sympy.lambdify((a, b), copysign(a, b), modules=[{"copysign": np.copysign}])
    assert compute(magnitude, sign) == math.copysign(magnitude, sign)


@pytest.mark.parametrize(("sign", "expected"), [(3, a), (0, a), (-3, -a), (S.Half, a), (sympy.Float(-2), -a)])
def test_copysign_of_a_number_as_sign_is_folded(sign, expected):
    assert copysign(a, sign) == expected


def test_copysign_is_differentiated_by_its_magnitude_alone():
    assert copysign(a**2, b).diff(a) == 2 * a * copysign(1, b)
    assert copysign(a, b**3).diff(b) == 0
