"""Tables of a page: a median with its range, and what is no number."""

import math

import pandas as pd
import pytest

from dexterity_study.page import tables
from dexterity_study.page.markup import without_negative_zeros
from dexterity_study.page.tables import over_seeds, with_range


@pytest.mark.parametrize(
    ("values", "written"),
    [
        ([1.0], "1"),
        ([3, 1, 2], "2 (1–3)"),
        ([1, 2], "1.5 (1–2)"),
        ([0.1001, 0.1002], "0.1"),
        ([1.0, 2.0, math.inf], "2 (1–inf)"),
        ([1.0, math.nan, 3.0], "2 (1–3)"),
        ([math.nan, math.nan], "–"),
        ([], "–"),
    ],
)
def test_the_range_stands_where_it_differs(values, written):
    assert with_range(values) == written


def test_groups_of_rows_have_their_medians_and_ranges():
    rows = pd.DataFrame({"size": [8, 8, 5], "error": [1.0, 3.0, 2.0]})
    table = over_seeds(rows, "size", {"error": "error [mm]"}, "{:.0f}")
    assert table.index.tolist() == [8, 5]
    assert table["error [mm]"].tolist() == ["2 (1–3)", "2"]


def test_a_range_in_a_table_is_not_broken_at_its_dash():
    written = tables.show(pd.DataFrame({"error": ["2 (1–3)", "see (there – or not)"]})).html
    assert '2 <span class="range">(1–3)</span>' in written
    assert written.count("<span") == 1


def test_a_dash_stands_for_what_is_no_number():
    assert "<td>–</td>" in tables.show(pd.DataFrame({"error": [1.0, math.nan]})).html


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("-0.000", "0.000"),
        ("-0.00–0.41 m", "0.00–0.41 m"),
        ("(-0, -0.2)", "(0, -0.2)"),
        ("-0.", "0."),
        ("-0.001, -1e-05, ratio-0, w-0.5", "-0.001, -1e-05, ratio-0, w-0.5"),
    ],
)
def test_a_number_that_reads_as_zero_has_no_minus(text, shown):
    assert without_negative_zeros(text) == shown
    assert f"<td>{shown}</td>" in tables.show(pd.DataFrame({"text": [text]})).html
