import dataclasses
import json
import math
from collections.abc import Mapping

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as npst
from jaxtyping import Float
from numpy.typing import NDArray

from dexterity.report.records import from_json, from_plain, to_json, to_plain
from dexterity.store import content_key


@dataclasses.dataclass(frozen=True)
class Inner:
    flag: bool
    number: float | None


@dataclasses.dataclass(frozen=True)
class Everything:
    count: int
    text: str
    numbers: tuple[float, ...]
    pair: tuple[int, str]
    inner: tuple[Inner, ...]
    by_name: Mapping[str, float]
    bare: np.ndarray
    typed: NDArray[np.float64]
    shaped: Float[np.ndarray, "rows 3"]
    either: float | tuple[float, ...] | None = None


everything = st.builds(
    Everything,
    count=st.integers(),
    text=st.text(),
    numbers=st.lists(st.floats()).map(tuple),
    pair=st.tuples(st.integers(), st.text()),
    inner=st.lists(st.builds(Inner, st.booleans(), st.none() | st.floats()), max_size=2).map(tuple),
    by_name=st.dictionaries(st.text(), st.floats(), max_size=2),
    bare=npst.arrays(
        st.sampled_from(["bool", "int8", "uint64", "float16", "float32", "float64"]),
        npst.array_shapes(min_dims=0, min_side=0, max_side=3),
    ),
    typed=npst.arrays("float64", npst.array_shapes(max_side=3)),
    shaped=npst.arrays("float64", st.tuples(st.integers(0, 2), st.just(3))),
    either=st.none() | st.floats() | st.lists(st.floats(), max_size=2).map(tuple),
)


def with_usual_nan(value):
    """Give every NaN of the arrays the same bits, which is all that a record keeps of it."""
    for array in vars(value).values():
        if isinstance(array, np.ndarray) and array.dtype.kind == "f":
            array[np.isnan(array)] = np.nan
    return value


@given(everything)
def test_a_record_comes_back_to_the_bit(value):
    value = with_usual_nan(value)
    assert content_key(from_json(to_json(value), Everything)) == content_key(value)


@given(everything)
def test_a_record_is_strict_json(value):
    def refuse(constant):
        raise AssertionError(constant)

    json.loads(to_json(value), parse_constant=refuse)


@given(st.data())
def test_a_damaged_record_is_not_read(data):
    text = to_json(Inner(flag=True, number=0.1))
    place = data.draw(st.integers(0, len(text) - 1))
    kind = data.draw(st.sampled_from(["cut", "changed"]))
    other = data.draw(st.characters(codec="utf-8").filter(lambda character: character != text[place]))
    damaged = text[:place] if kind == "cut" else text[:place] + other + text[place + 1 :]
    try:
        value = from_json(damaged, Inner)
    except ValueError:
        return
    # What is left are edits of the white space.
    assert json.loads(damaged) == json.loads(text)
    assert value == Inner(flag=True, number=0.1)


@pytest.mark.parametrize(
    "text", ["", "null", "[]", "3", '{"digest": "x"}', '{"digest": "x", "content": 1, "y": 2}']
)
def test_what_is_no_record_is_not_read(text):
    with pytest.raises(ValueError, match=r"digest|Expecting"):
        from_json(text, Inner)


@pytest.mark.parametrize(
    ("change", "place"),
    [
        ({"count": 1.0}, "count"),
        ({"count": True}, "count"),
        ({"text": 1}, "text"),
        ({"numbers": "123"}, "numbers"),
        ({"numbers": [1.0, "2"]}, "numbers"),
        ({"numbers": [True]}, "numbers"),
        ({"pair": [1, "a", 2]}, "pair"),
        ({"inner": [{"flag": 1, "number": None}]}, "flag"),
        ({"inner": [{"flag": True, "number": "x"}]}, "number"),
        ({"bare": [1.0]}, "bare"),
        ({"by_name": {"a": None}}, "by_name"),
        ({"either": "x"}, "either"),
        ({"surplus": 1}, "surplus"),
    ],
)
def test_what_does_not_fit_is_named(change, place):
    array = np.zeros((1, 3))
    value = Everything(1, "a", (), (1, "a"), (), {}, array, array, array)
    with pytest.raises(ValueError, match=place):
        from_plain(to_plain(value) | change, Everything)


def test_what_is_missing_is_named():
    with pytest.raises(ValueError, match="number"):
        from_plain({"flag": True}, Inner)


@pytest.mark.parametrize(
    "value",
    [
        Inner(True, np.float32(0.1)),
        Inner(True, np.float64(0.1)),
        Inner(True, 3),
    ],
)
def test_a_float_by_another_name_becomes_one(value):
    number = from_json(to_json(value), Inner).number
    assert type(number) is float
    assert math.isclose(number, value.number)


@dataclasses.dataclass(frozen=True)
class Anything:
    value: object


@pytest.mark.parametrize(
    "value", [object(), np.array(["a"]), np.array([1j]), {1}], ids=lambda value: type(value).__name__
)
def test_what_has_no_place_in_a_record_is_refused(value):
    with pytest.raises(TypeError):
        to_json(Anything(value))
