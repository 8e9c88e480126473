"""Tidy rows: what is refused, and files that say what the table said, in the same bytes."""

import numpy as np
import pandas as pd
import pytest

from dexterity_study.engine.table import Table, from_csv, from_npz, summaries, to_csv, to_npz

ROWS = [
    {"index": "w", "size": 3, "error": 0.1, "passes": True, "stop": "goal"},
    {"index": "w", "size": 5, "error": 1e-13, "passes": False, "stop": "limit"},
    {"index": "KCI", "size": 3, "error": np.float64(2 / 3), "passes": np.True_},
]


def table(rows=ROWS, arrays=None, reading="chosen", seed=0):
    return Table.of_run(rows, arrays or {}, keys=("index", "size"), reading=reading, seed=seed)


def test_rows_survive_their_file():
    read = from_csv(to_csv(table()))
    assert read.keys == ("index", "size")
    own = read.where(index="KCI")
    assert own["error"].item() == pytest.approx(2 / 3, rel=1e-11)
    assert own["passes"].item() is True or own["passes"].item() == np.True_
    assert read.where(index="w")["stop"].tolist() == ["goal", "limit"]
    assert read.where(index="w", size=5)["error"].item() == 1e-13


def test_a_file_read_and_written_again_has_the_same_bytes():
    text = to_csv(table())
    assert to_csv(from_csv(text)) == text


def test_a_row_of_the_file_is_one_number():
    lines = to_csv(table()).splitlines()
    assert lines[0] == "reading,seed,index,size,metric,value"
    assert lines[1] == "chosen,0,w,3,error,0.1"


@pytest.mark.parametrize(
    ("rows", "complaint"),
    [
        ([{"index": "w", "error": 1}], "lacks the keys"),
        ([{"index": "w", "size": 1, "error": 1}] * 2, "two rows have the keys"),
        ([{"index": "w", "size": 1, "error": [1, 2]}], "numbers, truth values and texts"),
    ],
)
def test_rows_that_are_not_tidy_are_refused(rows, complaint):
    with pytest.raises(ValueError, match=complaint):
        table(rows)


def test_values_are_a_series_over_readings_and_seeds():
    joined = Table.joined([table(seed=0), table(seed=1), table(reading="step=1")])
    errors = joined.values("error", index="w", size=3)
    assert errors.index.tolist() == [("chosen", 0), ("chosen", 1), ("step=1", 0)]
    with pytest.raises(ValueError, match="several rows for a seed"):
        joined.values("error", index="w")
    assert joined.seeds == [0, 1]
    assert joined.by_seed("error", over="size", index="w").shape == (2, 2)


def test_a_wrong_key_and_an_empty_choice_are_named():
    with pytest.raises(ValueError, match="'name' is not a key"):
        table().where(name="w")
    with pytest.raises(ValueError, match="no row"):
        table().where(index="σ")


def test_arrays_survive_without_pickle_and_are_stacked():
    arrays = {"b": np.arange(3, dtype=np.float32), "a": np.array([[True]])}
    content = to_npz(arrays)
    assert content == to_npz(dict(reversed(arrays.items())))
    assert from_npz(content)["b"].dtype == np.float32
    with pytest.raises(ValueError, match=r"[Oo]bject arrays"):
        to_npz({"a": np.array([object()])})
    joined = Table.joined([table(arrays=arrays, seed=seed) for seed in range(2)])
    assert joined.array("b").shape == (2, 3)
    with pytest.raises(ValueError, match="no array 'c'"):
        joined.array("c")


def test_a_summary_notices_a_change_of_an_array():
    one, other = (summaries(table(arrays={"a": np.array(values)})) for values in ([1.0, 2.0], [1.0, 2.5]))
    assert to_csv(one) != to_csv(other)
    row = from_csv(to_csv(one)).rows.set_index("array").loc["a"]
    assert (row["size"].tolist()[-1] if isinstance(row["size"], pd.Series) else row["mean"]) is not None
    assert row["mean"] == 1.5
