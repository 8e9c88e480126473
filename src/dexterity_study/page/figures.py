"""One look for every figure of the book: colours, sizes, and vector output with reproducible bytes."""

from __future__ import annotations

from typing import Any

import matplotlib as mpl
from cycler import cycler
from IPython import get_ipython
from matplotlib_inline.config import InlineBackend

from dexterity.scenes.colors import COLORS


def style() -> None:
    """Make this the style of all figures drawn from now on; a chapter calls it once, in its first cell.

    In a notebook, figures become SVG. The background is white and not transparent, so that a figure
    reads the same on a light and on a dark page. Sizes are chosen for a phone: a figure of the default
    width, shrunk to a screen of 360 pixels, still has letters 11 pixels high.

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
        notebook.print_figure_kwargs = {"bbox_inches": None, "metadata": {"Date": None}}


_CYCLE = ("blue", "vermillion", "bluish green", "reddish purple", "orange", "sky blue", "black")

_STYLE: Any = {
    "axes.axisbelow": True,
    "axes.grid": True,
    "axes.prop_cycle": cycler(color=[COLORS[name] for name in _CYCLE]),
    "axes.spines.right": False,
    "axes.spines.top": False,
    "axes.titlesize": "medium",
    "figure.constrained_layout.use": True,
    "figure.facecolor": "white",
    "figure.figsize": (5.5, 3.6),
    "font.size": 12.0,
    "grid.color": "#D8DDE2",
    "grid.linewidth": 0.8,
    "image.cmap": "cividis",
    "legend.frameon": False,
    "lines.linewidth": 2.0,
    "savefig.facecolor": "white",
    # Letters as outlines: the page then needs no font of ours, and no reader's font moves a label.
    "svg.fonttype": "path",
    "svg.hashsalt": "dexterity",
}
