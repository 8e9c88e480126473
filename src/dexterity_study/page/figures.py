"""One look for every figure of the book: colours, sizes, and vector output with reproducible bytes."""

from __future__ import annotations

import io
import re
from typing import Any

import matplotlib as mpl
from cycler import cycler
from IPython import get_ipython
from matplotlib.figure import Figure
from matplotlib_inline.config import InlineBackend

from dexterity.scenes.colors import COLORS

WIDTH = 4.5
"""Width of a figure [in]: shrunk to a screen of 360 pixels, its letters are 11 pixels high. Panels are stacked."""

ON_COLOR = "#1C2630"
"""Ink on a coloured ground, which is the same on a light and on a dark page."""

_LETTERS = 11.0  # size of all letters [pt]

_IN_THE_DARK = {
    "#1f2933": "#e4e7eb",
    "#000000": "#e4e7eb",
    "#d8dde2": "#3e4c59",
    "#e6e6e6": "#323f4b",
    "#595959": "#b8c2cc",
    "#808080": "#9aa5b1",
    "#0072b2": "#4aa8e0",
}
"""Ink, grid, greys and the darkest line, and what they become on a dark page."""


def style() -> None:
    """Make this the style of all figures drawn from now on; a chapter calls it once, in its first cell.

    In a notebook, figures become SVG without a ground, whose ink follows the colour scheme of the page. A figure has
    the width :data:`WIDTH` and letters of one size, so that it can be read on a phone.

    References
    ----------
    Okabe, M. & Ito, K. (2008), Color Universal Design; yellow is left out of the cycle because lines
    in it vanish on white.
    """
    mpl.rcParams.update(_STYLE)
    shell = get_ipython()
    if shell is not None:
        notebook: Any = InlineBackend.instance(parent=shell)
        notebook.figure_formats = {"svg"}
        shell.display_formatter.formatters["image/svg+xml"].for_type(Figure, themed_svg)


def themed_svg(figure: Figure) -> str:
    """Return a figure as SVG whose ink is light where the page is dark."""
    file = io.StringIO()
    figure.savefig(file, format="svg", metadata={"Date": None})
    rules = "".join(
        f'[style*="{name}: {light}"] {{ {name}: {dark} !important; }}\n'
        for light, dark in _IN_THE_DARK.items()
        for name in ("fill", "stroke")
    )
    sheet = f"<style>@media (prefers-color-scheme: dark) {{\n{rules}}}</style>"
    return re.sub(r"(<svg [^>]*>)", rf"\1\n{sheet}", file.getvalue(), count=1)


_CYCLE = ("blue", "vermillion", "bluish green", "reddish purple", "orange", "sky blue", "black")
_INK = "#1F2933"

_STYLE: Any = {
    "axes.axisbelow": True,
    "axes.edgecolor": _INK,
    "axes.facecolor": "none",
    "axes.grid": True,
    "axes.labelcolor": _INK,
    "axes.labelsize": _LETTERS,
    "axes.prop_cycle": cycler(color=[COLORS[name] for name in _CYCLE]),
    "axes.spines.right": False,
    "axes.spines.top": False,
    "axes.titlesize": _LETTERS,
    "figure.constrained_layout.use": True,
    "figure.facecolor": "none",
    "figure.figsize": (WIDTH, 3.2),
    "figure.titlesize": _LETTERS,
    "font.size": _LETTERS,
    "grid.color": "#D8DDE2",
    "grid.linewidth": 0.8,
    "image.cmap": "cividis",
    "legend.fontsize": _LETTERS,
    "legend.frameon": False,
    "legend.title_fontsize": _LETTERS,
    "lines.linewidth": 2.0,
    "savefig.facecolor": "none",
    # Letters as outlines: the page then needs no font of ours, and no reader's font moves a label.
    "svg.fonttype": "path",
    "svg.hashsalt": "dexterity",
    "text.color": _INK,
    "xtick.color": _INK,
    "xtick.labelsize": _LETTERS,
    "ytick.color": _INK,
    "ytick.labelsize": _LETTERS,
}
