"""Tables of a page: a median with its range, and what is no number."""

import math
import re
from html import escape as html_escape

import pandas as pd
import pytest

from dexterity_study.page import markup, tables
from dexterity_study.page.numbers import readable, with_range, written
from dexterity_study.page.tables import over_seeds


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


@pytest.mark.parametrize(
    ("value", "form", "shown"),
    [
        (1520.0, "{:.3g}", "1,520"),
        (906_000.0, "{:.3g}", "906,000"),
        (6.7e9, "{:.2g}", "6.7\xa0×\xa010⁹"),
        (8.28e-7, "{:.3g}", "8.28\xa0×\xa010⁻⁷"),
        (0.0, "{:.0e}", "0"),
        (-0.0, "{:.1f}", "0.0"),
        (0.0004, "{:.3f}", "< 0.001"),
        (0.00004, "{:.2%}", "< 0.01%"),
        (-0.0004, "{:.3f}", "0.000"),
        (math.nan, "{:.3f}", "–"),
    ],
)
def test_a_number_is_written_for_a_reader(value, form, shown):
    assert written(value, form) == shown


def rows(html):
    return [
        re.findall(r"<t[hd][^>]*>(.*?)</t[hd]>", row) for row in re.findall(r"<tr.*?</tr>", html, flags=re.S)
    ]


def test_a_range_is_small_and_below_its_median():
    html = tables.show(pd.DataFrame({"error": ["2 (1–3)", "see (there – or not)"]})).html
    assert '2 <span class="range">1–3</span>' in html
    assert html.count("<span") == 1


def test_columns_of_numbers_are_aligned_and_the_best_is_bold():
    frame = pd.DataFrame(
        {"error [mm]": ["1,200 (1–3)", "30", "–"], "R": [0.5, 0.25, 0.75], "is": ["a", "b", "c"]}
    )
    html = tables.show(frame, "{:.2f}", best={"error [mm]": "least", "R": "most"}).html
    assert re.findall(r"<strong>(.*?)</strong>", html) == ["30", "0.75"]
    assert html.count('class="number"') == 2 * 4
    with pytest.raises(ValueError, match="no column 'x'"):
        tables.show(frame, best={"x": "least"})


def test_the_first_level_of_an_index_heads_groups_of_rows():
    index = pd.MultiIndex.from_tuples([("w", 8), ("w", 149), ("KCI", 25)], names=["index", "neurons"])
    html = tables.show(pd.DataFrame({"rows": [40960, 1, 2]}, index=index)).html
    assert rows(html) == [["neurons", "rows"], ["w"], ["8", "40,960"], ["149", "1"], ["KCI"], ["25", "2"]]
    assert 'scope="rowgroup" colspan="2"' in html


def test_columns_of_two_levels_have_two_heads():
    columns = pd.MultiIndex.from_product([["w", "KCI"], ["mean", "worst"]])
    html = tables.show(pd.DataFrame([[1, 2, 3, 4]], index=["ours"], columns=columns)).html
    assert rows(html)[:2] == [["", "w", "KCI"], ["", "mean", "worst", "mean", "worst"]]


def test_text_between_dollar_signs_is_a_formula():
    assert r"\(J_s^s\)" in tables.show(pd.Series({"$J_s^s$": 1.0}, name="error")).html


HOSTILE = (
    "<img src=x onerror=run()>",
    "</td></table><script>run()</script>",
    "$\\href{javascript:run()}{x}$",
    "$x$ $\\style{color:red}{y}$ $\\cssId{a}{b}$ $\\require{x}$",
    "\\(\\href{javascript:run()}{x}\\)",
    "\\[\\class{a}{b}\\]",
    "\\begin{math}\\href{javascript:run()}{x}\\end{math}",
    "5\xa0×\xa010⁻⁻⁻",
    "1\xa0×\xa010⁹⁹⁹⁹",
    "9" * 5_000,
)


@pytest.mark.parametrize("name", HOSTILE, ids=range(len(HOSTILE)))
def test_names_are_inert_in_every_place_of_a_table(name):
    frame = pd.DataFrame({name: [name, "b"], "error": [1.0, 2.0]}, index=pd.Index([name, "d"], name=name))
    grouped = pd.DataFrame({(name, "a"): [1.0, 2.0]}, index=pd.MultiIndex.from_tuples([(name, 1), (name, 2)]))
    ledger = markup.table(name, (name, "b"), {"anchor": [markup.Cell(name, name), markup.Cell("x", name)]})
    for html in (tables.show(frame).html, tables.show(grouped).html, ledger, markup.folded(name, "")):
        assert not re.search(r"<(img|script|/td></table)", html)
        formulas = re.findall(r'<span class="math[^>]*>(.*?)</span>', html)
        assert all(not re.search(r"\\(href|style|class|cssId|require)", formula) for formula in formulas)
        rest = re.sub(r'<span class="math[^>]*>.*?</span>', "", html)
        assert not re.search(r"\\(\(|\[|begin)", rest.replace('data-label="' + html_escape(name), ""))


def test_a_dash_stands_for_what_is_no_number():
    assert rows(tables.show(pd.DataFrame({"error": [1.0, math.nan]})).html)[2] == ["–"]


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("-0.000", "0.000"),
        ("-0.00–0.41 m", "0.00–0.41 m"),
        ("(-0, -0.2)", "(0, -0.2)"),
        ("-0.", "0."),
        ("-0.001, ratio-0, w-0.5", "-0.001, ratio-0, w-0.5"),
        ("off by 2.5e-15 m, 3e+00, 0e+00", "off by 2.5\xa0×\xa010⁻¹⁵ m, 3, 0"),
    ],
)
def test_numbers_in_a_text_are_readable(text, shown):
    assert readable(text) == shown
    assert rows(tables.show(pd.DataFrame({"text": [text]})).html)[1] == [shown]
