"""Tables of numbers in a chapter: one look, and the same bytes for the same numbers."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pandas as pd

from dexterity_study.page.markup import Markup, element, without_negative_zeros

_RANGE = re.compile(r"\([^\s()<]+–[^\s()<]+\)")
"""A range in brackets, which is not to be broken at its dash."""


def show(data: pd.DataFrame | pd.Series, form: str = "{:.3g}") -> Markup:
    """Set a table in a frame that scrolls sideways on a narrow page.

    Parameters
    ----------
    data
        The table; a series is one column under its name. A plain range as index is left out.
    form
        How its floats are written; one that is not a number is a dash.

    Notes
    -----
    :attr:`pandas.DataFrame.style` would draw a random name for each table.
    """
    frame = data.to_frame() if isinstance(data, pd.Series) else data
    named = not isinstance(frame.index, pd.RangeIndex)
    if frame.index.nlevels == frame.columns.nlevels == 1:
        # The name of the rows heads their column, instead of a line of its own.
        name = frame.index.name
        frame = frame.rename_axis(index=None).rename_axis(columns=None if name is None else str(name))
    written = frame.to_html(float_format=form.format, na_rep="–", index=named, border=0, justify="start")
    unbroken = _RANGE.sub(r'<span class="range">\g<0></span>', without_negative_zeros(written))
    return Markup(element("div", unbroken, css_class="table-scroll"))


def with_range(values: Any, form: str = "{:.3g}") -> str:
    """Write the median of numbers, with the smallest and the largest in brackets where they read otherwise."""
    array = np.asarray(values, dtype=float)
    array = array[~np.isnan(array)]
    if array.size == 0:
        return "–"
    median, low, high = (form.format(float(of(array))) for of in (np.median, np.min, np.max))
    return median if low == high else f"{median} ({low}–{high})"


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
