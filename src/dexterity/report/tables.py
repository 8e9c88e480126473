"""Tables of numbers in a chapter: one look, and the same bytes for the same numbers."""

from __future__ import annotations

import re

import pandas as pd

from dexterity.report.markup import Markup, element

__all__ = ["show"]

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
    written = frame.to_html(float_format=form.format, na_rep="–", index=named, border=0, justify="start")
    unbroken = _RANGE.sub(r'<span class="range">\g<0></span>', written)
    return Markup(element("div", unbroken, css_class="table-scroll"))
