"""HTML that a chapter shows: escaped, accessible, coloured by the book's style sheet and not here."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from html import escape

from dexterity_study.page.numbers import readable


@dataclass(frozen=True)
class Markup:
    """A piece of HTML that a notebook shows when it is the last value of a cell."""

    html: str = field(repr=False)

    def _repr_html_(self) -> str:
        return self.html


@dataclass(frozen=True)
class Cell:
    """A cell of a table: text, a note below it, a class of the text for the style sheet, and a link."""

    text: str
    note: str = ""
    css_class: str = ""
    link: str = ""


_FORMULA = re.compile(r"\$((?:(?!\\(?:href|class|style|cssId|data|require|html\w*|mmlToken)\b)[^$])+)\$")
"""A formula, without the words of MathJax by which a text could become a link, a style or more."""

_DELIMITER = re.compile(r"\\([(\[]|begin\b)")


def inline(text: str) -> str:
    r"""Escape a text; what stands between dollar signs is a formula, which MathJax finds between \( and \).

    Whatever else a text holds is no formula: a tag parts what MathJax would take for the beginning of one.
    """
    parts = _FORMULA.split(escape(readable(text), quote=False))
    return "".join(
        rf'<span class="math notranslate nohighlight">\({part}\)</span>'
        if i % 2
        else _DELIMITER.sub(r"\\<span>\1</span>", part)
        for i, part in enumerate(parts)
    )


def element(tag: str, content: str, **attributes: str) -> str:
    """Enclose HTML in an element; `css_class` is written `class`, an empty attribute is left out."""
    names = {"css_class": "class"}
    written = (f' {names.get(name, name)}="{escape(text)}"' for name, text in attributes.items() if text)
    return f"<{tag}{''.join(written)}>{content}</{tag}>"


def folded(summary: str, content: str) -> str:
    """Fold HTML under a line that opens it."""
    return element("details", f"{element('summary', inline(summary))}\n{content}", css_class="folded")


def table(caption: str, columns: Sequence[str], rows: Mapping[str, Sequence[Cell]]) -> str:
    """Set a ledger, whose first column heads the rows; on a narrow page each row becomes a paragraph.

    Parameters
    ----------
    caption
        What the table shows, as plain text.
    columns
        Headings of the columns, as plain text.
    rows
        Cells of each row, one for each column, under the row's anchor. The note of the first cell has a line of its own
        below the row.

    Raises
    ------
    ValueError
        If a row has not one cell for each column.
    """
    for anchor, cells in rows.items():
        if len(cells) != len(columns):
            raise ValueError(f"row {anchor} has {len(cells)} cells, the table has {len(columns)} columns")
    head = "".join(element("th", inline(column), scope="col") for column in columns)
    body = (element("tbody", _row(columns, cells), id=anchor) for anchor, cells in rows.items())
    parts = (element("caption", inline(caption)), element("thead", element("tr", head)), *body)
    return element(
        "div", element("table", "\n".join(parts), css_class="table ledger"), css_class="table-scroll"
    )


def _row(columns: Sequence[str], cells: Sequence[Cell]) -> str:
    heading, *rest = cells
    row = [element("th", _content(heading), scope="row")]
    # The style sheet shows the label where a narrow page sets the cells of a row below one another.
    row += [
        element(
            "td",
            _content(cell) + (element("small", inline(cell.note)) if cell.note else ""),
            **{"data-label": column},
        )
        for column, cell in zip(columns[1:], rest, strict=True)
    ]
    note = element("tr", element("td", inline(heading.note), colspan=str(len(columns))), css_class="note")
    return element("tr", "".join(row)) + (note if heading.note else "")


def _content(cell: Cell) -> str:
    text = inline(cell.text)
    if cell.css_class:
        text = element("span", text, css_class=cell.css_class)
    return element("a", text, href=cell.link) if cell.link else text
