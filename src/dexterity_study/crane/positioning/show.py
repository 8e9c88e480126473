"""Figures and tables of the chapter on four ways to position."""

from __future__ import annotations

import matplotlib.pyplot as plt
import pandas as pd
from matplotlib.figure import Figure

from dexterity_study.claims.ledger import load_paper
from dexterity_study.crane.positioning.experiment import (
    DIRECT,
    EXACT,
    GENETIC,
    INVERSE,
    MODULAR,
    NONE,
)
from dexterity_study.crane.positioning.verdicts import NAMES
from dexterity_study.engine.evidence import Evidence
from dexterity_study.engine.table import Table
from dexterity_study.page import figures
from dexterity_study.page.markup import Markup
from dexterity_study.page.tables import over_seeds, show

PAPER = load_paper("rouvinen1999")

TITLES = {
    NONE: "no compensation",
    GENETIC: "1 correction, search",
    EXACT: "1 correction, closed form",
    DIRECT: "2 direct network",
    MODULAR: "3 two networks",
    INVERSE: "4 inverse network",
}
"""Names of the methods on the page."""

COLORS = {method: f"C{number}" for number, method in enumerate((GENETIC, EXACT, DIRECT, MODULAR, INVERSE))}


def clouds(stored: Evidence) -> Figure:
    """Draw mean against largest errors of each seed, with the values of the thesis."""
    fig, ax = plt.subplots(figsize=(figures.WIDTH, 3.4))
    for method, color in COLORS.items():
        seeds = stored["methods"].where(method=method)
        ax.loglog(seeds["mean"], seeds["max"], "o", color=color, alpha=0.7, label=TITLES[method])
        if method in NAMES:
            printed = [_printed(method, kind) for kind in ("mean", "max")]
            ax.loglog(*printed, "x", ms=11, mew=2.5, color=color)
    ax.plot([], [], "x", ms=11, mew=2.5, color="#595959", label="thesis")
    ax.set(xlabel="mean error [mm]", ylabel="largest error [mm]")
    fig.legend(loc="outside upper center", ncols=2)
    return fig


def errors(stored: Evidence, live: Table) -> Markup:
    """Set mean and largest distances, printed and ours with one live run, and how often a cylinder is at its end."""
    rows = stored["methods"].where()
    rows["stopped"] *= 100
    ours = over_seeds(rows, "method", {"mean": "mean", "max": "largest", "stopped": "stopped"}, "{:.1f}")
    thesis = {
        kind: pd.Series({method: _printed(method, kind) for method in (NONE, *NAMES)})
        for kind in ("mean", "max")
    }
    columns = {
        ("mean [mm]", "thesis"): thesis["mean"],
        ("mean [mm]", "ours"): ours["mean"],
        ("mean [mm]", "live"): live.where().set_index("method")["mean"],
        ("largest [mm]", "thesis"): thesis["max"],
        ("largest [mm]", "ours"): ours["largest"],
        ("at an end [%]", "ours"): ours["stopped"],
    }
    return show(pd.DataFrame(columns).loc[list(TITLES)].rename(index=TITLES), "{:.1f}")


def _printed(method: str, kind: str) -> float:
    """Return the mean or the largest distance [mm] that the thesis prints for a method."""
    name = "uncompensated" if method == NONE else NAMES[method]
    return float(PAPER.printed(f"crane-{name}-{kind}")[2])
