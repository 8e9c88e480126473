"""Still picture of a scene, in SVG with the same bytes every time."""

from __future__ import annotations

import io
from collections.abc import Mapping, Sequence
from typing import Any

import matplotlib.style
from matplotlib.figure import Figure

from dexterity.scenes.arguments import Array
from dexterity.scenes.camera import View
from dexterity.scenes.shapes import Shape

__all__ = ["picture"]


def picture(shapes: Sequence[Shape], frames: Mapping[str, Array], view: View) -> bytes:
    """Draw shapes whose frames have poses in the world, what is far painted first."""
    depths = [view.project(shape.places(frames[shape.frame]))[:, 2].mean() for shape in shapes]
    far_first = sorted(range(len(shapes)), key=lambda i: (shapes[i].layer, -depths[i]))
    with matplotlib.style.context(["default", _STYLE]):
        figure = Figure(figsize=(view.width / 72, view.height / 72), dpi=72, facecolor="none")
        axes = figure.add_axes((0, 0, 1, 1), xlim=(0, view.width), ylim=(0, view.height))
        axes.set_axis_off()
        for order, i in enumerate(far_first):
            shapes[i].paint(axes, view, frames[shapes[i].frame], order)
        svg = io.BytesIO()
        figure.savefig(svg, format="svg", metadata=_NO_METADATA)
    return svg.getvalue()


_NO_METADATA = dict.fromkeys(("Creator", "Date", "Format", "Type"))

_STYLE: Any = {
    "font.sans-serif": ["DejaVu Sans"],
    "svg.fonttype": "none",
    "svg.hashsalt": "dexterity",
}
