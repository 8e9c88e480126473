"""Figures and tables of the chapter on sampling."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from dexterity.sampling import TaskSector
from dexterity_study.claims.ledger import load_paper
from dexterity_study.engine.evidence import Evidence
from dexterity_study.engine.table import Table
from dexterity_study.page.markup import Markup
from dexterity_study.page.tables import over_seeds, show
from dexterity_study.uvms.sampling import experiment
from dexterity_study.uvms.sampling.experiment import CHOICES
from dexterity_study.uvms.sampling.verdicts import TURNED

ERRORS = {
    "testing_error": "on the test set [%]",
    "between": "between its points [%]",
    "fresh": "on fresh ones [%]",
    "most": "99 % below [%]",
}


def inputs(stored: Evidence) -> Markup:
    """Set the inputs of each index as its derivation finds them."""
    return show(stored["values"].where().set_index("index")["inputs"].rename_axis(None))


def space(reading: str) -> TaskSector:
    """Return the space of KCI for a reading."""
    return experiment.sector(experiment.search_area.reading(reading))


def outline(of: TaskSector) -> np.ndarray:
    """Return the border of the search area in the plane z = task point's z, (m, 3) [m], once around."""
    turn = np.linspace(-of.azimuth, of.azimuth, 30)
    inner, outer = ([r * np.sin(turn), r * np.cos(turn), 0 * turn] for r in (of.r_min, of.r_max))
    border = np.array(of.task_point)[:, None] - np.concatenate([inner, np.flip(outer, 1)], axis=1)
    return np.concatenate([border, border[:, :1]], axis=1).T


def areas() -> Figure:
    """Draw where the arm's base is, for the two readings of the search area."""
    fig, panels = plt.subplots(1, 2, figsize=(6.5, 4), sharex=True, sharey=True)
    for ax, reading in zip(panels, ("chosen", TURNED), strict=True):
        area = space(reading)
        bases = experiment.base_positions(experiment.draw(area, 600, seed=0))
        ax.plot(*bases[:, :2].T, ".", ms=3, color="0.55")
        ax.plot(*outline(area).T[:2], color="C1")
        ax.plot(*area.task_point[:2], "*", color="k", ms=12)
        ax.set(title=CHOICES[reading], xlabel="x [m]", aspect="equal")
    panels[0].set(ylabel="y [m]")
    return fig


def choices(stored: Evidence) -> Markup:
    """Set KCI and its networks by reading of the search area."""
    rows = _percent(stored["search_area"].where(None)).replace({"reading": CHOICES})
    first = rows.groupby("reading", sort=False).first()
    low, high = first["lowest"], first["highest"]
    facts = {"KCI from": low, "to": high, "error of a constant [%]": 100 * (high - low) / (high + low)}
    facts |= {"σ5 ≈ σ6 [%]": 100 * first["kinks"], "within reach [%]": 100 * first["reachable"]}
    errors = over_seeds(rows, "reading", {"fresh": "largest error [%]", "most": ERRORS["most"]})
    return show(pd.DataFrame(facts).join(errors).rename_axis(None))


def training_sets(stored: Evidence) -> Markup:
    """Set errors of networks by kind of draw and rows, medians over the seeds with their ranges."""
    rows = _percent(stored["training_sets"].where())
    return show(over_seeds(rows, ["index", "method", "rows"], ERRORS))


def error_by_rows(stored: Evidence, live: Table) -> Figure:
    """Draw the largest error on fresh configurations against the rows of the training set, seeds and medians."""
    fig, ax = plt.subplots()
    groups = _percent(stored["training_sets"].where()).groupby(["index", "method"], sort=False)
    for color, (name, rows) in enumerate(groups):
        ax.plot(rows.groupby("rows")["fresh"].median(), "o-", label=" ".join(map(str, name)))
        ax.plot(rows["rows"], rows["fresh"], ".", color=f"C{color}", alpha=0.3)
    limit = min(load_paper("sotiropoulos2016").printed("feed-forward-testing-error-limit"))
    ax.axhline(100 * limit, color="k", linestyle=":", label="E of the paper")
    ax.plot(live.rows["rows"], 100 * live.rows["fresh"], "kx", label="live, first seed")
    ax.set(xscale="log", yscale="log", yticks=(0.1, 0.2, 0.5, 1, 2, 5))
    ax.set(xlabel="rows of the training set", ylabel="largest error [%]")
    ax.yaxis.set_major_formatter("{x:g}")
    ax.minorticks_off()
    ax.legend(fontsize="small")
    return fig


def extension(stored: Evidence, index: str) -> Markup:
    """Set the range of an index over wider spaces, and errors of networks there."""
    unit, keys = {"w": ("°", ["space"]), "KCI": (" m", ["network", "space"])}[index]
    rows = _percent(stored["extensions"].where(index=index))
    rows["space"] = rows["half_width"].map(f"±{{:g}}{unit}".format)
    rows["values"] = rows["lowest"].map("{:.3g}–".format) + rows["highest"].map("{:.3g}".format)
    return show(over_seeds(rows, [*keys, "values", "neurons"], ERRORS))


def _percent(rows: pd.DataFrame) -> pd.DataFrame:
    return rows.assign(**{name: 100 * rows[name] for name in ERRORS})
