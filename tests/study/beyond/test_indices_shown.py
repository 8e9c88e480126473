"""What the chapter on indices says about its stored times."""

import pandas as pd
import pytest

from dexterity_study.beyond.indices.show import dearest

TIMES = {"w": (10, 20), "log w": (15, 30), "KCI": (40, 60), "σ min": (50, 90), "isotropy": (12, 22)}


def times(**changed: tuple[float, float]) -> pd.DataFrame:
    rows = [
        {"index": index, "robot": robot, "what": what, "median": factor * 1e-9 * value}
        for index, values in (TIMES | changed).items()
        for robot, value in zip(("small", "large"), values, strict=True)
        for what, factor in (("value", 1), ("value and gradient", 7))
    ]
    return pd.DataFrame(rows)


def test_the_indices_that_take_longest_are_named_with_their_factors():
    said = dearest(times())
    assert said.startswith("A value takes 10 to 90 nanoseconds.")
    assert "σ min takes 4.8 times as long as w on the same robot, and KCI takes 3.5 times" in said
    assert "log w takes 1.5 times as long" in said


@pytest.mark.parametrize("index", ["isotropy", "log w"])
def test_a_slow_run_of_another_index_changes_the_sentence(index):
    assert f"the most: {index} takes 10.0 times" in dearest(times(**{index: (100, 200)}))


def test_an_index_that_a_robot_lacks_is_left_out_for_it():
    rows = times()
    rows = rows[(rows["index"] != "KCI") | (rows["robot"] != "small")]
    assert "KCI takes 3.0 times" in dearest(rows)
