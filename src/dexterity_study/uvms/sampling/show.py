"""Figures and tables of the chapter on sampling."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from dexterity import robots
from dexterity.sampling import TaskSector
from dexterity_study.claims.ledger import load_paper
from dexterity_study.engine.evidence import Evidence
from dexterity_study.engine.table import Table
from dexterity_study.page import figures
from dexterity_study.page.markup import Markup
from dexterity_study.page.tables import over_seeds, show
from dexterity_study.uvms.feed_forward.experiment import AS_PRINTED
from dexterity_study.uvms.sampling import experiment
from dexterity_study.uvms.sampling.experiment import CHOICES, FROM_VEHICLE
from dexterity_study.uvms.sampling.verdicts import TURNED

ERRORS = ("testing_error", "between", "fresh")
METHODS = {"grid": "grid", "sobol": "Sobol", "uniform": "uniform"}


def vehicle_parameters() -> Markup:
    """Set Table 2 of the paper, the sizes of vehicle and arm, with our reading of each row."""
    paper, length = load_paper("sotiropoulos2016"), robots.describe("uvms").lengths
    long, wide, high = paper.printed("vehicle-size")
    arm = f"$l_2$ = {length['l2']:g} m and $l_3$ = {length['l3']:g} m"
    rows = {
        "$h_v$, height": (high, "used in pictures"),
        "$l_v$, length": (long, f"the arm's base is at the bow: $y_{{MB}}$ = {length['y_MB']:g} m"),
        "$w_v$, width": (wide, "used in pictures"),
        "$r_{min}$, inner radius": (paper.printed("inner-radius"), f"difference of the links: {arm}"),
        "$r_{max}$, outer radius": (paper.printed("outer-radius"), "sum of both links"),
    }
    table = pd.DataFrame.from_dict(rows, orient="index", columns=["printed [m]", "our reading"])
    return show(table.rename_axis("parameter"), "{:.1f}")


def wider_spaces(stored: Evidence) -> Figure:
    """Draw the largest errors of the paper's networks and of the best ones against the width of their space."""
    rows = _percent(stored["extensions"].where())
    fig, panels = plt.subplots(2, figsize=(figures.WIDTH, 4.6))
    networks = {
        "w": ((AS_PRINTED, 8), (AS_PRINTED, 40)),
        "KCI": ((AS_PRINTED, 25), (FROM_VEHICLE, 40)),
    }
    labels = ("network of the paper", "best network tried")
    for ax, (index, pair) in zip(panels, networks.items(), strict=True):
        for (network, neurons), label in zip(pair, labels, strict=True):
            chosen = (rows["network"] == network) & (rows["neurons"] == neurons) & (rows["index"] == index)
            errors = rows[chosen].groupby("half_width")["fresh"].agg(["median", "min", "max"])
            bars = (errors["median"] - errors["min"], errors["max"] - errors["median"])
            ax.errorbar(errors.index, errors["median"], yerr=bars, fmt="o-", ms=5, label=label)
        ax.axhline(100 * _limit(), color="#1F2933", linestyle=":", label="limit of the paper")
        ax.set(xscale="log", yscale="log", xticks=errors.index, ylabel=f"error of {index} [%]")
        ax.xaxis.set_major_formatter("{x:g}")
        ax.yaxis.set_major_formatter("{x:g}")
        ax.minorticks_off()
    panels[0].set(xlabel="joints within ± [°]", yticks=(0.1, 1, 10, 100))
    panels[1].set(xlabel="vehicle within ± [m]", yticks=(1, 10, 100))
    fig.legend(*panels[0].get_legend_handles_labels(), loc="outside upper center", ncols=2)
    return fig


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
    fig, panels = plt.subplots(1, 2, figsize=(figures.WIDTH, 2.9), sharex=True, sharey=True)
    titles = {"chosen": "before the vehicle turns", TURNED: "after it turns"}
    for ax, (reading, title) in zip(panels, titles.items(), strict=True):
        area = space(reading)
        bases = experiment.base_positions(experiment.draw(area, 600, seed=0))
        ax.plot(*bases[:, :2].T, ".", ms=3, color="#808080")
        ax.plot(*outline(area).T[:2], color="C1")
        ax.plot(*area.task_point[:2], "*", color="C0", ms=12)
        ax.set(title=title, xlabel="x [m]", aspect="equal")
    panels[0].set(ylabel="y [m]")
    return fig


def choices(stored: Evidence) -> Markup:
    """Set KCI and its networks by reading of the search area."""
    rows = _percent(stored["search_area"].where(None)).replace({"reading": CHOICES})
    first = rows.groupby("reading", sort=False).first()
    facts = {"KCI from": first["lowest"], "to": first["highest"]}
    error = over_seeds(rows, "reading", {"fresh": "error of a network [%]"}, "{:.1f}")
    table = pd.DataFrame(facts).join(error).join((100 * first["reachable"]).rename("in reach [%]"))
    return show(table.rename_axis("choice"), "{:.2f}", forms={"in reach [%]": "{:.0f}"})


def tests(stored: Evidence) -> Markup:
    """Set errors of the networks with the largest training sets, by the set that they are tested on."""
    rows = _percent(stored["training_sets"].where()).replace({"method": METHODS})
    most = rows[rows["rows"] == rows["rows"].max()]
    names = (most["index"] + ", " + most["method"]).rename("index, training set")
    heads = {
        "testing_error": "1,000 of the same kind",
        "between": "1,000 uniform",
        "fresh": "50,000 uniform",
    }
    return show(over_seeds(most.assign(name=names), "name", heads, "{:.2f}").rename_axis(names.name))


def error_by_rows(stored: Evidence, live: Table) -> Figure:
    """Draw the largest error on fresh configurations against the rows of the training set, seeds and medians."""
    fig, ax = plt.subplots(figsize=(figures.WIDTH, 3.8))
    groups = _percent(stored["training_sets"].where()).groupby(["index", "method"], sort=False)
    for color, ((index, method), rows) in enumerate(groups):
        ax.plot(rows.groupby("rows")["fresh"].median(), "o-", label=f"{index}, {METHODS[str(method)]}")
        ax.plot(rows["rows"], rows["fresh"], ".", color=f"C{color}", alpha=0.3)
    ax.axhline(100 * _limit(), color="#1F2933", linestyle=":", label="limit of the paper")
    ax.plot(live.rows["rows"], 100 * live.rows["fresh"], "x", color="#1F2933", label="live, seed 0")
    ax.set(xscale="log", yscale="log", yticks=(0.1, 0.2, 0.5, 1, 2, 5), xticks=(300, 1000, 3000, 10_000))
    ax.set(xlabel="rows of the training set", ylabel="largest error [%]")
    ax.xaxis.set_major_formatter("{x:,g}")
    ax.yaxis.set_major_formatter("{x:g}")
    ax.minorticks_off()
    fig.legend(loc="outside upper center", ncols=2)
    return fig


def _limit() -> float:
    return min(load_paper("sotiropoulos2016").printed("feed-forward-testing-error-limit"))


def _percent(rows: pd.DataFrame) -> pd.DataFrame:
    return rows.assign(**{name: 100 * rows[name] for name in ERRORS})
