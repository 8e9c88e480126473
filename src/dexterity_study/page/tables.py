"""Tables of numbers in a chapter: one look, made for comparing, and the same bytes for the same numbers."""

from __future__ import annotations

import re
from collections.abc import Hashable, Iterator, Mapping
from itertools import groupby
from typing import Any, Literal

import numpy as np
import pandas as pd

from dexterity_study.page.markup import Markup, element, inline
from dexterity_study.page.numbers import with_range, written

_RANGE = re.compile(r"(?P<median>.*\d.*?) \((?P<range>[^()]*\d[^()]*–[^()]*)\)")
_NUMBER = re.compile(
    r"[<>]? ?-?(?P<digits>[\d,]*\.?\d+)(?:\xa0×\xa010(?P<power>⁻?[⁰¹²³⁴⁵⁶⁷⁸⁹]+))?(?P<unit>[ %].*)?"
)
_DIGITS = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")


def show(
    data: pd.DataFrame | pd.Series,
    form: str = "{:.3g}",
    *,
    forms: Mapping[Any, str] | None = None,
    best: Mapping[Any, Literal["least", "most"]] | None = None,
) -> Markup:
    """Set a table in a frame that scrolls sideways on a narrow page, its first column fixed.

    Columns of numbers are aligned at the right, so that forms with equal decimals align their points. A range that
    follows a median is small. Where the rows have an index of several levels, the first level heads groups of rows.
    Text between dollar signs is a formula. The caption belongs to the cell that shows the table.

    Parameters
    ----------
    data
        The table; a series is one column under its name. A plain range as index is left out.
    form
        How its floats are written, see :func:`~dexterity_study.page.numbers.written`.
    forms
        Other forms, by column.
    best
        Columns whose least or largest number is bold.

    Raises
    ------
    ValueError
        If `forms` or `best` name a column that the table does not have.
    """
    frame = data.to_frame() if isinstance(data, pd.Series) else data
    for name in (*(forms or {}), *(best or {})):
        if name not in frame.columns:
            raise ValueError(f"the table has no column {name!r}; it has {list(frame.columns)}")
    columns = [
        _column(
            [_text(value, (forms or {}).get(name, form)) for value in frame.iloc[:, i]],
            (best or {}).get(name),
        )
        for i, name in enumerate(frame.columns)
    ]
    named = not isinstance(frame.index, pd.RangeIndex)
    names: list[tuple[Hashable, ...]] = [_levels(label) if named else () for label in frame.index]
    # A name of the columns alone heads the rows.
    heads = list(frame.index.names) if named else []
    if len(heads) == 1 == frame.columns.nlevels and heads[0] is None:
        heads = list(frame.columns.names)
    grouped = frame.index.nlevels > 1 and len({name[0] for name in names}) < len(names)
    head = _head(heads[grouped:], [_levels(name) for name in frame.columns], [css for css, _ in columns])
    rows = list(zip(*(cells for _, cells in columns), strict=True))
    body = "\n".join(_rows(names, rows, grouped))
    table = element("table", f"{element('thead', head)}\n{element('tbody', body)}", css_class="table numbers")
    return Markup(element("div", table, css_class="table-scroll"))


def _levels(label: Hashable) -> tuple[Hashable, ...]:
    return label if isinstance(label, tuple) else (label,)


def _text(value: Any, form: str) -> str:
    if value is None or value is pd.NA:
        return "–"
    if isinstance(value, bool | np.bool_):
        return "yes" if value else "no"
    if isinstance(value, float):
        return written(value, form)
    return f"{value:,}" if hasattr(value, "__index__") else str(value)


def _column(texts: list[str], best: str | None) -> tuple[str, list[str]]:
    """Return the class of a column, and its cells."""
    values = [_value(text) for text in texts]
    css = (
        "number"
        if all(value is not None or text in ("–", "") for value, text in zip(values, texts, strict=True))
        else ""
    )
    known = [value for value in values if value is not None]
    target = None if best is None or not known else min(known) if best == "least" else max(known)
    return css, [
        element("td", _bold(_with_small_range(text), target is not None and value == target), css_class=css)
        for text, value in zip(texts, values, strict=True)
    ]


def _value(text: str) -> float | None:
    """Return the number that a cell begins with; None if it is not a number, with its range and its unit."""
    split = _RANGE.fullmatch(text)
    match = _NUMBER.fullmatch(split["median"] if split else text)
    if match is None:
        return None
    sign = -1 if "-" in text.partition(match["digits"])[0] else 1
    power = (match["power"] or "0").translate(_DIGITS)
    return sign * float(f"{match['digits'].replace(',', '')}e{power}")


def _with_small_range(text: str) -> str:
    split = _RANGE.fullmatch(text)
    if split is None:
        return inline(text)
    return f"{inline(split['median'])} {element('span', inline(split['range']), css_class='range')}"


def _bold(html: str, bold: bool) -> str:
    return element("strong", html) if bold else html


def _head(rows: list[Any], columns: list[tuple[Hashable, ...]], css: list[str]) -> str:
    *upper, _ = zip(*columns, strict=True) if columns else [()]
    lines = []
    for level, titles in enumerate(upper):
        start = element("td", "", colspan=str(len(rows))) if rows else ""
        spans = [(title, sum(1 for _ in same)) for title, same in groupby(titles)]
        cells = (element("th", inline(str(title)), scope="colgroup", colspan=str(n)) for title, n in spans)
        lines.append(element("tr", start + "".join(cells), css_class=f"level-{level}"))
    start = "".join(_heading(name) for name in rows)
    cells = (
        element("th", inline(str(name[-1])), scope="col", css_class=own)
        for name, own in zip(columns, css, strict=True)
    )
    return "\n".join([*lines, element("tr", start + "".join(cells))])


def _heading(name: Any) -> str:
    return element("td", "") if name in (None, "") else element("th", inline(str(name)), scope="col")


def _rows(names: list[tuple[Hashable, ...]], rows: list[tuple[str, ...]], grouped: bool) -> Iterator[str]:
    group: Hashable = None
    for name, cells in zip(names, rows, strict=True):
        if grouped and name[0] != group:
            group = name[0]
            width = len(name) - 1 + len(cells)
            head = element("th", inline(_text(group, "{:g}")), scope="rowgroup", colspan=str(width))
            yield element("tr", head, css_class="group")
        heads = (element("th", inline(_text(part, "{:g}")), scope="row") for part in name[grouped:])
        yield element("tr", "".join((*heads, *cells)))


def over_seeds(
    rows: pd.DataFrame, index: str | list[str], metrics: dict[str, str], form: str = "{:.3g}"
) -> pd.DataFrame:
    """Return a table with the median and the range over the seeds of each group of rows.

    Parameters
    ----------
    rows
        Tidy rows of an experiment.
    index
        Key columns whose values name the rows of the table.
    metrics
        Headings of the columns by the metrics that they show.
    form
        Form of a number.
    """
    groups = rows.groupby(index, sort=False)
    columns = {head: groups[metric].apply(with_range, form=form) for metric, head in metrics.items()}
    return pd.DataFrame(columns)


def stored_and_live(
    stored: pd.DataFrame, live: pd.DataFrame, titles: Mapping[str, str], form: str = "{:.3g}"
) -> pd.DataFrame:
    """Return a table of metrics, under their titles: median and range over the stored seeds, and one live run."""
    return pd.DataFrame(
        {
            head: {title: with_range(rows[metric], form) for metric, title in titles.items()}
            for head, rows in (("stored", stored), ("live", live))
        }
    )
