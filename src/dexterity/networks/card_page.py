"""Cards as pages: HTML with the pictures inside, which needs nothing beside it.

Examples
--------
>>> from dexterity.networks import card_page
>>> "<h1>mine</h1>" in card_page.html({"name": "mine"}, whole_page=True)
True
"""

from __future__ import annotations

import io
from collections.abc import Iterable, Mapping, Sequence
from html import escape
from typing import Any

import numpy as np

from dexterity.networks.card_text import facts, limits, rows_of_errors

__all__ = ["error_histogram", "html", "worst_case_slices"]

_STYLE = """
body { font: 16px/1.5 system-ui, sans-serif; max-width: 46rem; margin: 2rem auto; padding: 0 1rem;
       color: #1b1b1b; background: #fff; }
table { border-collapse: collapse; margin: 0.5rem 0 1.5rem; }
th, td { border-bottom: 1px solid #ccc; padding: 0.25rem 0.75rem 0.25rem 0;
         text-align: left; vertical-align: top; }
figure { margin: 0 0 1.5rem; } svg { max-width: 100%; height: auto; background: #fff; }
figcaption { font-size: 0.9rem; } .advice { border-left: 4px solid #0072b2; padding-left: 0.75rem; }
"""


def html(card: Mapping[str, Any], whole_page: bool) -> str:
    """Return a card as a page, or as what stands in the body of a page."""
    name = escape(str(card.get("name", "A network")))
    parts = [f"<h1>{name}</h1>"]
    if advice := card.get("advice"):
        parts.append(f'<p class="advice">{escape(str(advice))}</p>')
    parts.append(_table((), facts(card)))
    if errors := rows_of_errors(card):
        parts += ["<h2>Errors</h2>", _table(("error", "size", "found"), errors)]
    parts += _figures(card)
    if joints := limits(card):
        parts += ["<h2>Space</h2>", _table(("coordinate", "from", "to"), joints)]
    body = "\n".join(parts)
    if not whole_page:
        return body
    return (
        '<!doctype html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>{name}</title>\n<style>{_STYLE}</style>\n</head>\n<body>\n{body}\n</body>\n</html>\n"
    )


def _table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    first = "".join(f"<th>{escape(cell)}</th>" for cell in head)
    body = "".join(f"<tr>{''.join(f'<td>{escape(cell)}</td>' for cell in row)}</tr>\n" for row in rows)
    return f"<table>\n{f'<tr>{first}</tr>' if head else ''}\n{body}</table>"


def _figures(card: Mapping[str, Any]) -> list[str]:
    figures = []
    if histogram := card.get("histogram"):
        caption = "Sizes of the error at the fresh points; the dashed line is the worst case that was found."
        figures.append(_figure(error_histogram(histogram, card.get("worst_case", {}).get("error")), caption))
    if slices := card.get("slices"):
        caption = (
            "The network (line) and the exact index (dots) through the worst configuration (vertical line), "
            "one joint moved at a time."
        )
        figures.append(_figure(worst_case_slices(slices), caption))
    return figures


def _figure(picture: str, caption: str) -> str:
    return f"<figure>\n{picture}\n<figcaption>{escape(caption)}</figcaption>\n</figure>"


def error_histogram(histogram: Mapping[str, Any], worst: float | None = None) -> str:
    """Draw a histogram of errors, an entry with the edges of its bins and their counts, as SVG."""
    from matplotlib.figure import Figure

    edges, counts = histogram["edges"], histogram["counts"]
    figure = Figure(figsize=(6, 2.6), layout="constrained")
    axes = figure.subplots()
    axes.stairs(counts, edges, fill=True, color="#56b4e9")
    if worst:
        axes.axvline(worst, color="#d55e00", linestyle="--")
    axes.set(xscale="log", yscale="log", xlabel="size of the error", ylabel="configurations")
    return _svg(figure)


def worst_case_slices(slices: Sequence[Mapping[str, Any]]) -> str:
    """Draw the network and the exact index along each joint through the worst configuration, as SVG."""
    from matplotlib.figure import Figure

    columns = min(3, len(slices))
    rows = -(-len(slices) // columns)
    figure = Figure(figsize=(2.4 * columns, 1.9 * rows), layout="constrained")
    axes = figure.subplots(rows, columns, squeeze=False, sharey=True).flatten()
    for axis, line in zip(axes, slices, strict=False):
        q = np.linspace(line["from"], line["to"], len(line["exact"]))
        axis.plot(q, line["exact"], ".", color="#1b1b1b", markersize=3)
        axis.plot(q, line["network"], color="#0072b2")
        axis.axvline(line["worst"], color="#d55e00", linewidth=0.8)
        axis.set_xlabel(_label(str(line["joint"])), fontsize=9)
        axis.tick_params(labelsize=8)
    for axis in axes[len(slices) :]:
        axis.set_visible(False)
    return _svg(figure)


def _label(name: str) -> str:
    """Return a name as matplotlib writes it: no formula, and letters that its font has."""
    letters = "".join(c if c.isprintable() and ord(c) < 0x500 else "?" for c in name)
    return letters.replace("$", r"\$")


def _svg(figure: Any) -> str:
    """Return a figure as an element of SVG whose bytes depend on the figure alone."""
    from matplotlib import rc_context

    buffer = io.StringIO()
    with rc_context({"svg.hashsalt": "dexterity", "svg.fonttype": "path"}):
        figure.savefig(buffer, format="svg", metadata={"Date": None, "Creator": None})
    text = buffer.getvalue()
    return text[text.index("<svg") :]
