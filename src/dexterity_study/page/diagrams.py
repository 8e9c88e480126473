"""Drawings of programs and networks: flow charts that show where a run was, and the layers of a network."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from math import ceil
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle, FancyBboxPatch, Polygon

from dexterity.scenes.colors import COLORS
from dexterity_study.page import figures

INK, GREY = "#1F2933", "#808080"

Point = tuple[float, float]


@dataclass(frozen=True)
class Box:
    """A box of a flow chart.

    Attributes
    ----------
    text
        What happens there, or what is asked.
    at, width, height
        Centre and size, in inches of the figure.
    asks
        Whether it is a question, drawn with pointed ends.
    """

    text: str
    at: Point
    width: float = 2.4
    height: float = 0.5
    asks: bool = False


@dataclass(frozen=True)
class Arrow:
    """A line from box to box along points in inches, with a word beside it, which begins at a place."""

    points: Sequence[Point]
    word: str = ""
    word_at: Point = (0.0, 0.0)


def flow_chart(
    boxes: Mapping[str, Box], arrows: Sequence[Arrow], passed: Mapping[str, int], last: str, height: float
) -> Figure:
    """Draw a flow chart, with how often a run passed each box, and the box in which it ended.

    Parameters
    ----------
    boxes
        By their names.
    arrows
        Lines between them.
    passed
        How often the run was in a box, by name; a box that is left out was never reached.
    last
        Name of the box where the run ended.
    height
        Of the figure [in]; its width is that of all figures.

    Raises
    ------
    ValueError
        If `passed` or `last` names no box, or the run ended in a box that it never reached.
    """
    if unknown := [name for name in (*passed, last) if name not in boxes]:
        raise ValueError(f"the flow chart has no box {unknown[0]!r}; it has {list(boxes)}")
    if not passed.get(last):
        raise ValueError(f"the run ended in {last!r}, and passed it {passed.get(last, 0)} times")
    fig, ax = _canvas(height)
    for arrow in arrows:
        *line, (x, y) = arrow.points
        ax.plot(*np.transpose(arrow.points), color=INK, lw=1.2, solid_capstyle="round")
        ax.annotate("", (x, y), line[-1], arrowprops={"arrowstyle": "-|>", "color": INK, "lw": 1.2})
        ax.text(*arrow.word_at, arrow.word)
    for name, box in boxes.items():
        count = passed.get(name, 0)
        _draw_box(ax, box, ended=name == last, reached=count > 0)
        if count:
            x, y = box.at[0] + box.width / 2, box.at[1] + box.height / 2 + 0.04
            ax.text(x, y, f"{count:,} ×", color=COLORS["blue"], weight="bold", ha="right")
    return fig


def _draw_box(ax: Axes, box: Box, *, ended: bool, reached: bool) -> None:
    (x, y), w, h = box.at, box.width / 2, box.height / 2
    line: dict[str, Any] = {
        "edgecolor": COLORS["vermillion"] if ended else INK if reached else GREY,
        "linewidth": 3 if ended else 1.4 if reached else 1.0,
        "facecolor": "none",
        "linestyle": "-" if reached else "--",
    }
    if box.asks:
        ends = [(x - w, y), (x - w + h, y + h), (x + w - h, y + h), (x + w, y), (x + w - h, y - h)]
        ax.add_patch(Polygon([*ends, (x - w + h, y - h)], **line))
    else:
        style = "round,pad=0,rounding_size=0.08"
        ax.add_patch(FancyBboxPatch((x - w, y - h), 2 * w, 2 * h, boxstyle=style, **line))
    ax.text(x, y, box.text, ha="center", va="center", linespacing=1.1)


def layers(
    inputs: Sequence[str],
    hidden: int,
    activation: Callable[[np.ndarray], np.ndarray],
    output: str,
    units: str = "neurons",
) -> Figure:
    """Draw a network with one hidden layer: its inputs, its hidden neurons with their curve, and its output.

    Of many inputs or neurons the first two and the last one are drawn, with dots between them.

    Parameters
    ----------
    inputs
        Names of the inputs.
    hidden
        Number of hidden neurons, at least 1.
    activation
        Function that the neurons apply, drawn from −3 to 3.
    output
        Name of the output.
    units
        What the hidden neurons are called.

    Raises
    ------
    ValueError
        If there are no inputs or no neurons.
    """
    if not inputs or hidden < 1:
        raise ValueError(f"a network needs inputs and neurons; there are {len(inputs)} and {hidden}")
    height = 2.5
    fig, ax = _canvas(height)
    left, middle, right = 0.75, 2.3, 3.7
    names = _shown(list(inputs))
    neurons = _shown([f"{n}" for n in range(1, hidden + 1)])
    in_y, hidden_y = (_spread(len(own), height - 0.25) for own in (names, neurons))
    for y, name in zip(in_y, names, strict=True):
        if name is not None:
            for other, neuron in zip(hidden_y, neurons, strict=True):
                if neuron is not None:
                    ax.plot([left + 0.12, middle - 0.26], [y, other], color=GREY, lw=0.8, zorder=1)
            ax.add_patch(Circle((left, y), 0.12, facecolor="none", edgecolor=INK, lw=1.4))
        ax.text(left - 0.2, y, name or "⋮", ha="right", va="center")
    gamma = np.linspace(-3, 3, 61)
    curve = activation(gamma)
    for y, neuron in zip(hidden_y, neurons, strict=True):
        if neuron is None:
            ax.text(middle, y, "⋮", ha="center", va="center")
            continue
        ax.plot([middle + 0.26, right - 0.2], [y, height / 2 - 0.125], color=GREY, lw=0.8, zorder=1)
        ax.add_patch(Circle((middle, y), 0.26, facecolor="none", edgecolor=INK, lw=1.4))
        ax.plot(
            middle + 0.055 * gamma, y + 0.15 * (curve - (curve.max() + curve.min()) / 2), color="C0", lw=2
        )
    ax.add_patch(Circle((right, height / 2 - 0.125), 0.2, facecolor="none", edgecolor=INK, lw=1.4))
    ax.text(right, height / 2 - 0.125, "Σ", ha="center", va="center")
    ax.text(right + 0.27, height / 2 - 0.125, output, va="center")
    for x, text in ((left, f"{len(inputs)} inputs"), (middle, f"{hidden} {units}"), (right, "output")):
        ax.text(x, height - 0.1, text, ha="center", va="center")
    return fig


def _canvas(height: float) -> tuple[Figure, Axes]:
    fig, ax = plt.subplots(figsize=(figures.WIDTH, height))
    ax.set(xlim=(0, figures.WIDTH), ylim=(0, height), aspect="equal")
    ax.axis("off")
    return fig, ax


def _shown(names: list[str]) -> list[str | None]:
    return list(names) if len(names) <= 4 else [*names[:2], None, names[-1]]


def _spread(count: int, height: float) -> np.ndarray:
    """Return heights of items in a column, from the top."""
    pitch = height / ceil(max(count, 4))
    return height / 2 - pitch * (np.arange(count) - (count - 1) / 2)
