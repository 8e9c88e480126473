"""Numbers as they are typed."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from dexterity.typed import number, numbers, values_of_range


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_what_python_prints_is_read_back_to_the_bit(value):
    assert number(repr(value), "q") == value


@pytest.mark.parametrize(
    ("word", "value"),
    [("pi", math.pi), ("-pi/2", -math.pi / 2), ("3pi/4", 3 * math.pi / 4), ("0.5*pi", math.pi / 2),
     ("+2π", 2 * math.pi), ("90deg", math.pi / 2), ("-30 deg", -math.pi / 6), (" 1e-3 ", 1e-3)],
)  # fmt: skip
def test_multiples_of_pi_and_degrees(word, value):
    assert number(word, "q") == pytest.approx(value, rel=1e-15)


@given(st.text())
def test_any_text_is_a_finite_number_or_an_error_that_names_the_argument(text):
    try:
        value = number(text, "--q")
    except ValueError as error:
        value, message = 0.0, str(error)
        assert message.startswith("--q holds")
    assert math.isfinite(value)


@pytest.mark.parametrize(
    "word", ["", "nan", "inf", "1e999", "pi/0", "pi*pi", "1,2", "0x10", "__import__('os')"]
)
def test_no_number(word):
    with pytest.raises(ValueError, match="--q holds"):
        number(word, "--q")


def test_lists_are_counted():
    assert numbers("1, 2  3,4", "q", 4) == [1, 2, 3, 4]
    assert numbers("", "q") == []
    with pytest.raises(ValueError, match="--q holds 2 numbers; 6 or 7 are needed"):
        numbers("1,2", "--q", (6, 7))


def test_ranges_have_both_ends():
    assert values_of_range("-pi:pi:3", "yaw") == [-math.pi, 0, math.pi]
    assert values_of_range("0.3", "x") == [0.3]
    assert values_of_range("1:2:1", "x") == [1]


@pytest.mark.parametrize("text", ["1:2", "1:2:0", "1:2:3:4", "1:2:1e3", "a:b:3", "1:2:9999999999", ""])
def test_no_range(text):
    with pytest.raises(ValueError, match="--x"):
        values_of_range(text, "--x")
