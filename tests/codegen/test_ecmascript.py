"""Modules of any programs: values, shapes, bad input, and names that would break out."""

import pytest
import sympy

from dexterity.codegen.ecmascript import Exported, program_module
from dexterity.program import Program, Recorder
from run_in_node import called, needs_node

X, Y = sympy.symbols("x y", real=True)


def polar() -> Program:
    record = Recorder()
    return record.program((X, Y), [sympy.sqrt(X**2 + Y**2), sympy.atan2(Y, X), sympy.S.Zero, Y])


def module(shape: tuple[int, ...] = (2, 2), name: str = "polar", heading: str = "A test.") -> str:
    return program_module([heading], {}, {name: Exported(polar(), shape, "Polar coordinates.")})


@needs_node
def test_numbers_come_in_their_shape(tmp_path):
    ((rows),) = called(tmp_path, module(), "polar", [[[3, 4]]])
    assert rows == [[5, pytest.approx(0.9272952180016122, rel=1e-15)], [0, 4]]


@needs_node
def test_one_number_is_no_array(tmp_path):
    record = Recorder()
    source = program_module([], {}, {"sum": Exported(record.program((X, Y), [X + Y]), (), "A sum.")})
    assert called(tmp_path, source, "sum", [[[1, 2]], [[[3], 4]]]) == [3, 7]


@needs_node
@pytest.mark.parametrize(
    ("given", "message"),
    [
        ([1], "input has 1 numbers, 2 are needed"),
        ([1, 2, 3], "input has 3 numbers, 2 are needed"),
        ([1, "NaN"], "input is not finite: it holds NaN or an infinity"),
        (["Infinity", 1], "input is not finite: it holds NaN or an infinity"),
        ([None, 1], "input is not finite: it holds NaN or an infinity"),
    ],
)
def test_bad_input_is_a_range_error(tmp_path, given, message):
    assert called(tmp_path, module(), "polar", [[given]]) == [{"error": "RangeError", "message": message}]


@needs_node
def test_no_heading_breaks_out(tmp_path):
    source = module(heading="two\nthrow 1;\u2028throw 2; */ throw 3;")
    assert called(tmp_path, source, "polar", [[[0, 1]]])[0][0][0] == 1


def test_a_shape_must_hold_the_outputs():
    with pytest.raises(ValueError, match=r"^polar has the shape \(3,\), and its program has 4 outputs"):
        module((3,))


@pytest.mark.parametrize("name", ["", "2a", "a b", "a;throw", "ä"])
def test_a_name_must_be_one(name):
    with pytest.raises(ValueError, match=r"a letter first, are needed$"):
        module(name=name)
