"""A median with its range, as tables say it."""

import math

import pandas as pd
import pytest

from dexterity.report import tables
from dexterity.report.ranges import with_range


@pytest.mark.parametrize(
    ("values", "told"),
    [
        ([1.0], "1"),
        ([3, 1, 2], "2 (1–3)"),
        ([1, 2], "1.5 (1–2)"),
        ([0.1001, 0.1002], "0.1"),
        ([1.0, 2.0, math.inf], "2 (1–inf)"),
        ([math.nan, math.nan], "–"),
    ],
)
def test_the_range_stands_where_it_differs(values, told):
    assert with_range(values, "{:.3g}".format) == told


def test_nothing_has_no_median():
    with pytest.raises(ValueError, match="values is empty"):
        with_range([], str)


def test_a_range_in_a_table_is_not_broken_at_its_dash():
    written = tables.show(pd.DataFrame({"error": ["2 (1–3)", "see (there – or not)"]})).html
    assert '2 <span class="range">(1–3)</span>' in written
    assert written.count("<span") == 1


def test_a_dash_stands_for_what_is_no_number():
    assert "<td>–</td>" in tables.show(pd.DataFrame({"error": [1.0, math.nan]})).html
