"""A figure and a table of times, from rows of their experiments."""

from __future__ import annotations

import matplotlib.pyplot as plt
import pandas as pd
from matplotlib.figure import Figure

from dexterity.scenes.colors import COLORS
from dexterity_study.claims.judge import Judge
from dexterity_study.engine.evidence import Evidence
from dexterity_study.page import figures
from dexterity_study.page.markup import Markup
from dexterity_study.page.tables import show
from dexterity_study.workspace.timing import experiment as of
from dexterity_study.workspace.timing.verdicts import PRINTED, printed_seconds, times

LOOKS = {"analytic": "reddish purple", "numerical": "orange", "exact": "blue", "network": "vermillion"}
SIDES = (10, 20, 50)
UNITS = {"years": 31_557_600.0, "days": 86_400.0, "h": 3_600.0, "min": 60.0, "s": 1.0, "ms": 1e-3, "µs": 1e-6}


def ladder(stored: Evidence) -> Figure:
    """Draw the time of each way for a pose, and printed times of the same kind."""
    fig, ax = plt.subplots(figsize=(figures.WIDTH, 4.2))
    rungs = times(stored)
    order = list(dict.fromkeys(rung for rung, _ in rungs))
    for (rung, way), timing in rungs.items():
        style = "none" if way == of.PAPERS else "full"
        row, color = order.index(rung), _color(way)
        ax.hlines(row, 1e6 * timing.lower, 1e6 * timing.upper, color=color)
        ax.plot(1e6 * timing.median, row, "o", color=color, fillstyle=style)
    on = Judge("liao2018")
    for claim, (_, way) in PRINTED.items():
        ax.plot(1e6 * printed_seconds(on, claim), -1, "D", ms=8, fillstyle="none", color=_color(way))
    for kind in LOOKS:
        ax.plot([], [], "o", color=_color(kind), label=kind)
    ticks = {"yticks": range(-1, len(order)), "yticklabels": ["printed", *order]}
    ax.set(xscale="log", xlabel="time per pose [µs]", xticks=[1e-2, 1, 1e2, 1e4, 1e6], **ticks)
    ax.invert_yaxis()
    fig.legend(loc="outside upper center", ncols=4, columnspacing=1, handletextpad=0.2)
    return fig


def _color(way: str) -> str:
    return COLORS[LOOKS[way.replace(",", "").split()[0]]]


def grids(stored: Evidence) -> Markup:
    """Set how long grids of so many steps a side take, from the times of the ladder for a pose."""
    named = {
        "toolbox, numerical": (of.TOOLBOX, of.NUMERICAL_JACOBIAN),
        "toolbox, analytic": (of.TOOLBOX, of.ANALYTIC_JACOBIAN),
        "network, paper's size": (of.SOME, of.PAPERS),
        "network, small": (of.MANY, of.PLANE),
        "compiled, Jacobian": (of.C_MANY, of.CLOSED),
        "compiled, $w$ alone": (of.C_MANY, of.REACH),
    }
    rungs = times(stored)
    seconds = {name: [rungs[place].median * side**6 for side in SIDES] for name, place in named.items()}
    seconds["compiled, $w$ at positions alone"] = [
        rungs[of.C_MANY, of.REACH].median * side**3 for side in SIDES
    ]
    table = pd.DataFrame.from_dict(seconds, orient="index", columns=[f"{side} steps" for side in SIDES])
    table = table.rename_axis("way")
    return show(table.map(_duration))


def _duration(seconds: float) -> str:
    unit, length = next(((unit, one) for unit, one in UNITS.items() if seconds >= one), ("µs", 1e-6))
    return f"{seconds / length:,.3g} {unit}"
