"""Readings: values by name, what is refused, and what the papers' own assumptions hold."""

import pickle
from datetime import UTC, datetime

import pytest

from dexterity import store
from dexterity_study.engine import readings
from dexterity_study.engine.readings import Reading

ENTRY = """
[[assumptions]]
id = "limit"
where = "Table 1"
missing = "The limit."
chapter = "part.chapter"
chosen = "Ten."
why = "It is round."
origin = "toolbox"
set = 2026-01-31T10:00:00Z
by = "declared"
value = 10

[[assumptions.alternatives]]
name = "twenty"
value = 20
origin = "fitted"
why = "it fits"

[[assumptions.alternatives]]
name = "1.5"
value = [1.5, 2]
origin = "text"
why = "it is printed elsewhere"
"""
OTHER = ENTRY.replace('"limit"', '"way"').replace("value = 10", 'value = "out"')
SPOKEN = ENTRY.replace('"limit"', '"spoken"').replace("value = 10\n", "").split("[[assumptions.alt")[0]


@pytest.fixture
def write_paper(tmp_path, monkeypatch):
    """Return a function that writes the assumptions of the only paper."""
    folder = tmp_path / "papers" / "paper"
    folder.mkdir(parents=True)
    monkeypatch.setattr(store, "data_path", lambda *parts: tmp_path.joinpath(*parts))

    def write(text):
        readings.assumptions.cache_clear()
        readings._variables.cache_clear()
        (folder / "assumptions.toml").write_text(text, encoding="utf-8")

    yield write
    readings.assumptions.cache_clear()
    readings._variables.cache_clear()


@pytest.fixture
def paper(write_paper):
    write_paper(ENTRY + OTHER + SPOKEN)
    return "paper"


def test_an_assumption_is_what_its_entry_says(paper):
    limit = readings.assumptions(paper)[0]
    at = datetime(2026, 1, 31, 10, tzinfo=UTC)
    assert (limit.id, limit.value, limit.set, limit.by) == ("limit", 10, at, "declared")
    assert [(other.name, other.value) for other in limit.alternatives] == [("twenty", 20), ("1.5", (1.5, 2))]


def test_the_chosen_reading_has_the_chosen_values_of_what_has_values(paper):
    reading = Reading.chosen(paper)
    assert dict(reading) == {"limit": 10, "way": "out"}
    assert reading.name == "chosen"
    assert reading == Reading.of(paper, "chosen")


def test_a_reading_has_the_values_that_its_name_says_and_a_sorted_name(paper):
    reading = Reading.of(paper, "way=twenty+limit=1.5")
    assert dict(reading) == {"limit": (1.5, 2), "way": 20}
    assert reading.name == "limit=1.5+way=twenty"
    assert reading == Reading.of(paper, reading.name)
    assert reading.only("way") == {"way": 20}


def test_a_reading_is_a_value_that_cannot_be_changed(paper):
    reading = Reading.of(paper, "way=twenty")
    assert {reading: 1}[pickle.loads(pickle.dumps(reading))] == 1
    assert reading != Reading.chosen(paper)
    with pytest.raises(AttributeError):
        reading.paper = "other"
    with pytest.raises(TypeError):
        reading["way"] = 1


def test_without_a_paper_there_is_one_reading_and_nothing_in_it():
    assert dict(Reading.chosen(None)) == {}
    with pytest.raises(ValueError, match="no assumption with a value 'way'"):
        Reading.of(None, "way=twenty")


@pytest.mark.parametrize("name", ["limt", "spoken"])
def test_an_unknown_assumption_is_answered_with_the_nearest(paper, name):
    with pytest.raises(KeyError, match=f"{name}.*nearest are.*limit"):
        Reading.chosen(paper)[name]
    with pytest.raises(ValueError, match=f"{name}.*nearest are.*limit"):
        Reading.of(paper, f"{name}=twenty")


@pytest.mark.parametrize(
    ("name", "complaint"),
    [
        ("limit=twelve", "limit has no alternative 'twelve'; the nearest are twenty"),
        ("limit=chosen", "limit has no alternative 'chosen'"),
        ("limit", "must be 'chosen' or"),
        ("limit=twenty=1.5", "must be 'chosen' or"),
        ("", "must be 'chosen' or"),
        ("limit=twenty+limit=1.5", "limit occurs more than once"),
    ],
)
def test_a_name_that_is_none_is_refused(paper, name, complaint):
    with pytest.raises(ValueError, match=complaint):
        Reading.of(paper, name)


@pytest.mark.parametrize(
    ("old", "new", "complaint"),
    [
        ('id = "limit"', 'id = "Limit"', "entry 'Limit': .*small letters"),
        ('missing = "The limit."', "", "entry 'limit': .*missing"),
        ('missing = "The limit."', 'missing = " "', "entry 'limit': .*missing must not be empty"),
        ("value = 10", "value = 10\nvalues = 3", "entry 'limit': .*values"),
        ("value = 10", "value = 2026-01-31", "entry 'limit': .*is none of"),
        ("value = 10\n", "", "entry 'limit': .*or none has"),
        ("value = 10", "value = 20", "entry 'limit': .*the value 20 occurs more than once"),
        ("set = 2026-01-31T10:00:00Z", 'set = "2026-01-31"', "entry 'limit': .*is not of type datetime"),
        ("set = 2026-01-31T10:00:00Z", "set = 2026-01-31T10:00:00", "entry 'limit': .*needs a time zone"),
        ('by = "declared"', 'by = "taste"', "entry 'limit': .*taste"),
        (
            'by = "declared"',
            'by = "declared"\nbasis = "So."',
            "entry 'limit': .*all but what is declared needs one",
        ),
        ('by = "declared"', 'by = "known"', "entry 'limit': .*all but what is declared needs one"),
        ('by = "declared"', 'by = "fitted"\nbasis = "So."', "entry 'limit': .*what is fitted has the origin"),
        ('origin = "fitted"', 'origin = "taste"', "entry 'limit': .*taste"),
        ('name = "1.5"', 'name = "twenty"', "entry 'limit': .*twenty occurs more than once"),
        ('name = "1.5"', 'name = "a+b"', "entry 'limit': .*'a\\+b'; it must be letters"),
        ('name = "1.5"', 'name = "chosen"', "entry 'limit': .*not 'chosen'"),
        ("[[assumptions]]", "more = 1\n[[assumptions]]", "has the keys more, assumptions"),
        ("[[assumptions]]", "[[assumptions", "Expected"),
    ],
)
def test_a_malformed_entry_is_refused_by_file_and_name(write_paper, old, new, complaint):
    write_paper(ENTRY.replace(old, new, 1))
    with pytest.raises(ValueError, match=f"(?s)^paper/assumptions.toml: .*{complaint}"):
        readings.assumptions("paper")


def test_two_assumptions_of_one_id_are_refused(write_paper):
    write_paper(ENTRY + ENTRY)
    with pytest.raises(ValueError, match=r"paper/assumptions.toml: limit occurs more than once"):
        readings.assumptions("paper")


PAPERS = sorted(file.parent.name for file in store.data_path("papers").glob("*/assumptions.toml"))


@pytest.mark.parametrize("key", PAPERS)
def test_the_assumptions_of_a_paper_have_values_that_readings_find(key):
    entries = [entry for entry in readings.assumptions(key) if entry.value is not None]
    assert entries
    assert dict(Reading.chosen(key)) == {entry.id: entry.value for entry in entries}
    for entry in entries:
        for other in entry.alternatives:
            reading = Reading.of(key, f"{entry.id}={other.name}")
            changed = {name for name, value in Reading.chosen(key).items() if reading[name] != value}
            assert changed == {entry.id}
            assert reading[entry.id] == other.value


@pytest.mark.parametrize("key", PAPERS)
def test_an_assumption_has_few_alternatives(key):
    assert all(len(entry.alternatives) <= 6 for entry in readings.assumptions(key))
