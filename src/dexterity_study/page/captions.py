"""Numbered captions of what a cell shows: a figure, or a table where the name begins with `tab-`.

A chapter writes caption and name into the cell, as for a figure::

    mystnb:
      figure:
        name: tab-errors
        caption: Errors of ...
"""

from typing import Any

from docutils import nodes
from sphinx.application import Sphinx
from sphinx.transforms import SphinxTransform


class captioned_table(nodes.figure):  # noqa: N801  # docutils finds the visitors of a node by the name of its class
    """A table that a cell shows, with its caption."""


class TableCaptions(SphinxTransform):
    """Counts a figure whose name begins with `tab-` among the tables."""

    default_priority = 210

    def apply(self, **_: Any) -> None:
        """Replace such figures."""
        for figure in list(self.document.findall(nodes.figure)):
            if any(name.startswith("tab-") for name in figure["names"]):
                table = captioned_table("", *figure.children, **figure.attributes)
                table["classes"].append("captioned-table")
                figure.replace_self(table)
                self.document.ids.update(dict.fromkeys(table["ids"], table))


def setup(app: Sphinx) -> None:
    """Add the transform and the node to Sphinx."""
    app.add_transform(TableCaptions)
    app.add_enumerable_node(captioned_table, "table", html=(_visit, _depart))


def _visit(translator: Any, node: nodes.Element) -> None:
    translator.visit_figure(node)


def _depart(translator: Any, node: nodes.Element) -> None:
    translator.depart_figure(node)
