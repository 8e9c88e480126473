import importlib.metadata
import io
import itertools
import re
import time

import numpy as np
import pandas as pd
import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st

from dexterity import store, timing
from dexterity.timing import Timing, Way, processor

PEERS = {"processor": "a processor", "threads": "1", "numpy": "2.0"}


def timed(name, lower, median, upper, configurations=1):
    return Timing(name, configurations, lower, median, upper)


def three_timings():
    return (
        timed("ours", 90e-9, 100e-9, 110e-9, 1_000),
        timed("near | by", 105e-9, 120e-9, 130e-9, 1_000),
        timed("far", 12.34e-6, 23.4e-6, 34.56e-6, 1),
    )


# ---- measuring -------------------------------------------------------------------------------------


def test_all_ways_take_turns_after_a_first_call_of_each():
    calls = []
    ways = [Way(name, lambda name=name: calls.append(name) or time.sleep(1e-3), 1) for name in "abc"]
    timing.measure(ways, rounds=4, seconds=1e-3)
    turns = [name for name, _ in itertools.groupby(calls)]
    assert turns == list("abc") * 5


def test_turns_last_as_long_as_asked_and_what_takes_longer_ends():
    lasted = {"short": [], "long": []}

    def sleep(name, seconds):
        start = time.perf_counter()
        time.sleep(seconds)
        lasted[name].append(time.perf_counter() - start)

    ways = [Way("short", lambda: sleep("short", 1e-3), 1), Way("long", lambda: sleep("long", 0.05), 1)]
    timing.measure(ways, rounds=2, seconds=0.02)
    assert sum(lasted["short"]) >= 2 * 0.02
    assert 1 + 2 * 1 <= len(lasted["long"]) <= 1 + 2 * 2  # a turn may begin with a trial


def test_processor_time_leaves_out_what_only_waits():
    ways = [Way("waits", lambda: time.sleep(0.02), 1)]
    (by_wall,) = timing.measure(ways, rounds=2, seconds=1e-3)
    (by_processor,) = timing.measure(ways, rounds=2, seconds=1e-4, clock=time.process_time)
    assert by_wall.median > 0.019
    assert by_processor.median < 0.01


def test_times_are_those_of_one_configuration():
    one, ten = timing.measure(
        [Way("one", lambda: time.sleep(0.01), 1), Way("ten", lambda: time.sleep(0.01), 10)],
        rounds=2,
        seconds=0.01,
    )
    assert 0.01 <= one.lower <= one.median <= one.upper
    assert 0.001 <= ten.lower <= ten.median <= ten.upper
    assert ten.lower < 0.01
    assert (one.configurations, ten.configurations) == (1, 10)


def test_ways_run_on_one_thread_and_the_number_of_threads_is_restored():
    before = torch.get_num_threads()
    torch.set_num_threads(3)
    seen = set()
    try:
        timing.measure([Way("a", lambda: seen.add(torch.get_num_threads()), 1)], rounds=1, seconds=1e-4)
        assert seen == {1}
        assert torch.get_num_threads() == 3
        with pytest.raises(ZeroDivisionError):
            timing.measure([Way("a", lambda: 1 / 0, 1)])
        assert torch.get_num_threads() == 3
    finally:
        torch.set_num_threads(before)


@pytest.mark.parametrize(
    ("names", "configurations", "options", "message"),
    [
        ([], 1, {}, r"\[\]"),
        (["a", "b", "a"], 1, {}, "name of its own"),
        (["a"], 0, {}, "'a' has 0 configurations"),
        (["a"], 1, {"rounds": 0}, "rounds is 0"),
        (["a"], 1, {"seconds": 0.0}, r"seconds is 0\.0"),
        (["a"], 1, {"seconds": float("nan")}, "seconds is nan"),
    ],
)
def test_what_cannot_be_measured_is_named(names, configurations, options, message):
    ways = [Way(name, lambda: None, configurations) for name in names]
    with pytest.raises(ValueError, match=message):
        timing.measure(ways, **options)


# ---- quartiles and ratios --------------------------------------------------------------------------


@given(st.permutations(range(1, 10)), st.integers(1, 1_000))
def test_quartiles_of_known_times(times, configurations):
    measured = Timing.from_times("a", configurations, [float(t) for t in times])
    quartiles = [measured.lower, measured.median, measured.upper]
    np.testing.assert_allclose(quartiles, np.array([3, 5, 7]) / configurations, rtol=1e-15)


@pytest.mark.parametrize("times", [[], [1.0, float("nan")], [float("inf")], [-1.0]])
def test_what_is_no_time_is_refused(times):
    with pytest.raises(ValueError, match="'a'"):
        Timing.from_times("a", 1, times)
    with pytest.raises(ValueError, match="configurations is 0"):
        Timing.from_times("a", 0, [1.0])


def test_a_ratio_is_one_of_medians():
    assert timing.ratio(timed("a", 5, 6, 7), timed("b", 1, 2, 3)).value == 3


quartiles = st.lists(st.integers(1, 20), min_size=3, max_size=3).map(sorted)


@given(quartiles, quartiles)
def test_times_are_distinguishable_when_no_value_lies_within_the_quartiles_of_both(a, b):
    shared = set(range(a[0], a[2] + 1)) & set(range(b[0], b[2] + 1))
    found = timing.ratio(timed("a", *a), timed("b", *b))
    assert found.distinguishable == (not shared)
    assert (str(found) == "indistinguishable") == bool(shared)


def test_nothing_is_divided_by_a_time_of_zero():
    with pytest.raises(ValueError, match="'b'"):
        timing.ratio(timed("a", 1, 1, 1), timed("b", 0, 0, 0))


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.001234, "0.00123"),
        (0.5, "0.500"),
        (1.0, "1.00"),
        (12.34, "12.3"),
        (100, "100"),
        (1234567, "1,234,567"),
    ],
)
def test_a_ratio_is_written_with_three_digits_or_all_before_the_point(value, text):
    assert str(timing.Ratio(value, distinguishable=True)) == text


# ---- tables ----------------------------------------------------------------------------------------


def test_a_table_is_in_nanoseconds_beside_its_reference():
    table = timing.table(three_timings(), "ours")
    assert list(table.index) == ["ours", "near | by", "far"]
    np.testing.assert_allclose(table.loc["far", ["lower", "median", "upper"]], [12340, 23400, 34560])
    np.testing.assert_allclose(table["ratio"], [1, 1.2, 234])
    assert list(table["distinguishable"]) == [False, False, True]
    assert list(table["configurations"]) == [1_000, 1_000, 1]


@pytest.mark.parametrize("reference", ["theirs", "twice"])
def test_a_reference_that_is_not_one_of_the_timings_is_named(reference):
    twice = timed("twice", 1, 1, 1)
    with pytest.raises(ValueError, match=f"'{reference}'"):
        timing.table((twice, twice), reference)


def test_a_page_says_which_ratios_tell_nothing():
    written = timing.readable(timing.table(three_timings(), "ours"))
    assert list(written["ratio"]) == ["1", "indistinguishable", "234"]
    assert list(written["median [ns]"]) == ["100", "120", "23,400"]
    assert list(written["quartiles [ns]"]) == ["90.0–110", "105–130", "12,340–34,560"]
    assert list(written["configurations"]) == ["1,000", "1,000", "1"]


def grouped():
    table = timing.table(three_timings(), "ours")
    return pd.concat({("w", 1): table, ("KCI", 1_000): table}, names=["index", "batch"])


@pytest.mark.parametrize("table", [timing.table(three_timings(), "ours"), grouped()], ids=["one", "grouped"])
def test_a_csv_file_is_read_back_by_pandas_and_begins_with_its_conditions(table):
    text = timing.to_csv(table, PEERS)
    assert text.startswith("# processor: a processor\n# threads: 1\n# numpy: 2.0\n")
    read = pd.read_csv(io.StringIO(text), comment="#", index_col=table.index.names)
    pd.testing.assert_frame_equal(read, table, rtol=1e-6, check_dtype=False)


def test_a_csv_file_does_not_lose_what_stands_after_a_hash():
    with pytest.raises(ValueError, match="#"):
        timing.to_csv(timing.table([timed("C#", 1, 1, 1)], "C#"), PEERS)


def test_a_markdown_table_holds_every_cell_under_its_heading():
    table = grouped()
    title, _, *rows, _, measured = timing.to_markdown(table, PEERS, "Two indices").splitlines()
    assert title == "Two indices"
    cells = [[cell.strip() for cell in re.split(r"(?<!\\)\|", row)[1:-1]] for row in rows]
    heading, rule, *body = cells
    assert set(rule) == {"---"}
    read = pd.DataFrame(body, columns=heading).replace({r"\\\|": "|"}, regex=True)
    expected = timing.readable(table).reset_index().astype(str)
    pd.testing.assert_frame_equal(read, expected, check_dtype=False)
    assert all(f"{key} {value}" in measured for key, value in PEERS.items())


@pytest.mark.parametrize("name", ["=cmd|' /C calc'!A0", "+1", "-1", "@sum(a)"])
def test_no_name_becomes_a_formula(name):
    with pytest.raises(ValueError, match="which a spreadsheet would compute"):
        timing.to_csv(timing.table([timed(name, 1, 1, 1)], name), PEERS)


def test_names_and_conditions_are_inert_in_both_files():
    hostile = "<img src=x onerror=run()> | a\\"
    table = timing.table([timed(hostile, 1, 1, 1)], hostile)
    text = timing.to_markdown(table, {"processor": "x\n\n<script>run()</script>"}, "<b>Title</b>")
    assert "<" not in text
    assert len(text.splitlines()) == 7
    row = text.splitlines()[4]
    assert len(re.findall(r"(?<!\\)(?:\\\\)*\|", row)) == 6
    assert timing.to_csv(table, {"processor": "x\nway,y"}).splitlines()[0] == "# processor: x way,y"


def test_both_files_are_written(tmp_path):
    table = timing.table(three_timings(), "ours")
    stem = tmp_path / "new" / "v1.5"
    timing.write(stem, table, PEERS, "Three")
    assert set(store.read_set(stem.parent, "v1.5.sha256")) == {"v1.5.csv", "v1.5.md"}
    assert {file.name for file in stem.parent.iterdir()} == {"v1.5.csv", "v1.5.md", "v1.5.sha256"}
    assert (stem.parent / "v1.5.csv").read_text(encoding="utf-8") == timing.to_csv(table, PEERS)
    assert (stem.parent / "v1.5.md").read_text(encoding="utf-8") == timing.to_markdown(table, PEERS, "Three")


def test_conditions_name_the_processor_the_threads_and_what_is_installed():
    found = timing.conditions("pandas")
    assert found["processor"] == processor() != ""
    assert found["threads"] == "1"
    assert found["pandas"] == pd.__version__
    assert list(found) == ["processor", "threads", "Python", "torch", "numpy", "pandas"]
    with pytest.raises(importlib.metadata.PackageNotFoundError):
        timing.conditions("no such distribution")
