"""Declared checks: what is taken, and that an error names the argument and what would do."""

import dataclasses
import fractions

import numpy as np
import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st

from dexterity import checks
from dexterity.checks import Choice, Flag, Instance, Name, OrNone, Real, Whole

pytestmark = pytest.mark.usefixtures("annotations_unchecked")


@pytest.mark.parametrize("value", [3, np.int8(3), np.uint64(3), torch.tensor(3), np.array(3)])
def test_a_whole_number_of_any_library_is_an_int(value):
    assert checks.whole(value, "count", least=3, most=3) == 3
    assert type(checks.whole(value, "count")) is int


@pytest.mark.parametrize(
    "value",
    [
        *(2.5, 3.0, float("nan"), float("inf"), True, np.True_, torch.tensor(True), "3", None, [3], 3j),
        *(np.float64(3), np.ones(1, int), torch.zeros(1, dtype=torch.int64), torch.zeros((), device="meta")),
    ],
)
def test_what_is_no_whole_number_is_refused_by_name(value):
    with pytest.raises(TypeError, match=r"^count is .*; a whole number of at least 1 is needed$"):
        checks.whole(value, "count", least=1)


@pytest.mark.parametrize(
    ("value", "check", "needed"),
    [
        (0, Whole(1), "a whole number of at least 1"),
        (7, Whole(1, 6), "a whole number of at least 1 and at most 6"),
        (7, Whole(most=6), "a whole number of at most 6"),
        (4, Whole(3, odd=True), "an odd number of at least 3"),
        (0, Real(above=0), "a finite number above 0"),
        (float("nan"), Real(), "a finite number"),
        (float("nan"), Real(infinite=True), "a number"),
        (float("inf"), Real(least=0), "a finite number at least 0"),
        (10**400, Real(least=0), "a finite number at least 0"),
        (1.0, Real(least=0, below=1), "a finite number at least 0 and below 1"),
        (np.float32(1.5), Real(most=1), "a finite number at most 1"),
        ("\n", Name(), "printable text that is not blank"),
    ],
    ids=lambda value: checks.shown(value),
)
def test_a_value_out_of_range_is_refused_with_the_range(value, check, needed):
    with pytest.raises(ValueError, match=f"^rate is .*; {needed} is needed$"):
        check(value, "rate")


@pytest.mark.parametrize("value", [True, np.False_, "1", b"1", None, 1j, [1.0], np.ones(1), torch.ones(2)])
def test_what_is_no_real_number_is_refused_by_name(value):
    with pytest.raises(TypeError, match=r"^rate is .*; a finite number above 0 is needed$"):
        checks.positive(value, "rate")


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_a_real_number_comes_back_as_it_was(value):
    for same in (value, np.float64(value), torch.tensor(value, dtype=torch.float64)):
        checked = checks.real(same, "rate")
        assert type(checked) is float
        assert checked == value


def test_other_real_numbers():
    assert checks.real(fractions.Fraction(1, 2), "rate") == 0.5
    assert checks.real(np.float32(0.1), "rate") == float(np.float32(0.1))
    assert checks.real(float("inf"), "rate", infinite=True) == float("inf")


@given(st.text(st.characters(codec=None), max_size=8))
def test_a_name_is_printable(text):
    # Cc control, Cf invisible, Cs surrogates, Cn no character: none of them can be drawn.
    if text.strip() and text.isprintable():
        assert checks.name(text, "title") == text
    else:
        with pytest.raises(ValueError, match=r"^title is .*printable"):
            checks.name(text, "title")


@pytest.mark.parametrize("text", ["a\x00b", "\x07", "\uffff", "\ud800", "\u2028", "\u202e", "", " ", "a\n"])
def test_public_specimens_of_names_that_cannot_be_drawn(text):
    with pytest.raises(ValueError, match=r"^joint_names"):
        checks.names([text], "joint_names")


@pytest.mark.parametrize(
    ("value", "error"),
    [
        ("abcdef", "joint_names is 'abcdef'; a sequence of names is needed"),
        (None, "joint_names is None; a sequence of names is needed"),
        (["a", None], r"joint_names\[1\] is None; text is needed"),
        (range(2), r"joint_names\[0\] is 0; text is needed"),
        (["a", "a"], "joint_names holds 'a' more than once"),
        (["a"], "joint_names holds 1 names; 2 are needed"),
    ],
)
def test_names_are_a_sequence_of_different_ones(value, error):
    with pytest.raises((TypeError, ValueError), match=f"^{error}$"):
        checks.names(value, "joint_names", 2)
    assert checks.names(iter(["a", "b"]), "joint_names", 2) == ("a", "b")


@pytest.mark.parametrize("value", [None, 3, ["a"], b"a", np.ones(3), float("nan")])
def test_a_choice_is_text(value):
    with pytest.raises(TypeError, match=r"^frame is .*; one of spatial, body is needed$"):
        checks.choice(value, "frame", ["spatial", "body"])


def test_a_choice_tells_the_nearest():
    with pytest.raises(ValueError, match=r"did you mean 'spatial'"):
        checks.choice("spacial", "frame", ("spatial", "body"))
    with pytest.raises(ValueError, match=r"^frame is 'x'; one of spatial, body is needed$"):
        checks.choice("x", "frame", ("spatial", "body"))


def test_flags_and_instances():
    assert checks.flag(np.True_, "progress") is True
    for value in (1, None, "yes", np.ones(2, bool)):
        with pytest.raises(TypeError, match=r"^progress is .*; True or False is needed$"):
            checks.flag(value, "progress")
    assert checks.instance("a", "path", str) == "a"
    with pytest.raises(TypeError, match=r"^path is 3; str or bytes is needed$"):
        Instance((str, bytes))(3, "path")


@dataclasses.dataclass(frozen=True)
class Options:
    count: int = 1
    rate: float = 1.0
    patience: int | None = None
    frame: str = "spatial"
    fast: bool = False

    def __post_init__(self) -> None:
        checks.fields(
            self,
            count=Whole(1),
            rate=Real(above=0),
            patience=OrNone(Whole(1)),
            frame=Choice(("spatial", "body")),
            fast=Flag(),
        )


def test_declared_fields_become_plain():
    options = Options(np.int64(2), np.float32(0.5), np.int8(3), fast=np.True_)
    assert options == Options(2, 0.5, 3, fast=True)
    assert [type(value) for value in dataclasses.astuple(options)] == [int, float, int, str, bool]


@pytest.mark.parametrize("field", [field.name for field in dataclasses.fields(Options)])
@pytest.mark.parametrize("value", [float("nan"), np.ones(3), "x", [], object(), 1e400])
def test_an_error_of_a_field_names_it(field, value):
    with pytest.raises((TypeError, ValueError), match=f"^{field} is "):
        Options(**{field: value})


@given(st.recursive(st.integers() | st.text() | st.binary(), st.lists, max_leaves=30))
def test_what_an_error_shows_is_one_short_line(value):
    shown = checks.shown(value)
    assert "\n" not in shown
    assert len(shown) < 1000
    assert checks.shown(10**5000) == "a whole number of 16610 bits"


@pytest.mark.parametrize("value", [10**400, -(10**5000), 2**63], ids=checks.shown)
def test_a_whole_number_beyond_64_bits_is_refused(value):
    with pytest.raises(ValueError, match=r"^count is .*; a whole number is needed, in 64 bits$"):
        checks.whole(value, "count")


@pytest.mark.parametrize("wrap", [lambda x: x, lambda x: [x], lambda x: {"a": x}, lambda x: (1, {2: [x]})])
def test_an_error_shows_any_number_however_deep_it_stands(wrap):
    assert "a whole number of 16610 bits" in checks.shown(wrap(10**5000))


# ---- several values, paths, arguments of a function --------------------------------------------------


@pytest.mark.parametrize(
    ("check", "value", "error", "message"),
    [
        (checks.Each(checks.Whole(1)), (1, 0), ValueError, r"^n\[1\] is 0; a whole number of at least 1"),
        (checks.Each(checks.Whole(1)), "12", TypeError, r"^n is '12'; a sequence is needed"),
        (checks.Each(checks.Whole(1)), 3, TypeError, r"^n is 3; a sequence is needed"),
        (checks.Named(checks.Whole(1)), {"a": 0}, ValueError, r"^n\['a'\] is 0"),
        (checks.Named(checks.Whole(1)), {1: 1}, TypeError, r"^n is \{1: 1\}; a mapping from texts"),
        (checks.path, "a\0b", ValueError, "^n is .*; a path is needed"),
        (checks.path, "", ValueError, "^n is ''; a path is needed"),
        (checks.path, b"a", TypeError, "^n is b'a'; a path is needed"),
    ],
)
def test_sequences_mappings_and_paths_are_checked(check, value, error, message):
    with pytest.raises(error, match=message):
        check(value, "n")


def test_what_is_good_comes_back_plain():
    assert checks.Each(checks.Whole(1))([np.int64(1), 2], "n") == (1, 2)
    assert checks.Named(checks.Whole(1))({"a": np.int64(1)}, "n") == {"a": 1}
    assert checks.path("a/b", "n") == "a/b"


def test_declared_arguments_are_checked_wherever_they_stand():
    @checks.arguments(count=checks.Whole(1), rest=checks.Each(checks.Whole()))
    def repeated(text, count=1, *rest):
        return text * count, rest

    assert repeated("a") == ("a", ())
    assert repeated("a", np.int64(2), 3) == ("aa", (3,))
    with pytest.raises(ValueError, match=r"^count is 0"):
        repeated("a", count=0)
    with pytest.raises(TypeError, match=r"^rest\[0\] is 'x'"):
        repeated("a", 1, "x")


def test_the_hint_knows_no_case_and_lists_all():
    assert checks.hint("y_mb", ["y_MB", "l1"]) == "did you mean 'y_MB'? One of y_MB, l1 is needed"
    assert checks.hint("?", ["y_MB"], ["some"]) == "one of some is needed"
    assert checks.hint("?", []) == "one of (there are none) is needed"
