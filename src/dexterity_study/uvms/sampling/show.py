"""Figures, tables and the scene of the chapter on sampling."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from dexterity import robots
from dexterity.sampling import TaskSector
from dexterity.scenes import Scene
from dexterity_study.claims.ledger import load_paper
from dexterity_study.engine.evidence import Evidence
from dexterity_study.engine.table import Table
from dexterity_study.page.markup import Markup
from dexterity_study.page.tables import over_seeds, show
from dexterity_study.uvms.sampling import experiment
from dexterity_study.uvms.sampling.experiment import CHOICES, INDICES, SHARES

TURNED = "base-position-without-rotation=turned"
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
        own = space(reading)
        ax.plot(
            *experiment.base_pose(robots.uvms(), experiment.draw(own, 600, seed=0))[:, :2, 3].T,
            ".",
            ms=3,
            color="0.55",
        )
        ax.plot(*outline(own).T[:2], color="C1")
        ax.plot(*own.task_point[:2], "*", color="k", ms=12)
        ax.set(title=CHOICES[reading], xlabel="x [m]", aspect="equal")
    panels[0].set(ylabel="y [m]")
    return fig


def reached() -> Scene:
    """Show three vehicles whose arms reach the task point."""
    uvms, own = robots.uvms(), space(TURNED)
    size = robots.describe("uvms").vehicle_size or ()
    scene = Scene("Three vehicles that reach one task point", view_from=(1.0, -0.4, 0.9))
    poses = experiment.reaching(uvms, experiment.draw(own, 3, seed=4), own.task_point)
    for number, pose in enumerate(poses, start=1):
        scene.add_chain(uvms, pose, name=f"uvms {number}", axes=False)
        scene.add_box(size, on=f"uvms {number}", joint=6, name=f"vehicle {number}")
    scene.add_path(outline(own), name="search area")
    return scene


def values(stored: Evidence) -> Figure:
    """Draw the share of the configurations below a value of each index."""
    fig, panels = plt.subplots(1, 2, figsize=(6.5, 3.2), sharey=True)
    for ax, name in zip(panels, INDICES, strict=True):
        for kind, dashes in (("grid", "-"), ("uniform", "--")):
            ax.plot(stored["values"].array(f"{name}_{kind}")[0], 100 * SHARES, dashes, label=kind)
        ax.set(xlabel=name)
    panels[0].set(ylabel="configurations below [%]")
    panels[0].legend()
    return fig


def choices(stored: Evidence) -> Markup:
    """Set KCI and its networks by reading of the search area."""
    rows = _percent(stored["search_area"].where(None)).replace({"reading": CHOICES})
    first = rows.groupby("reading", sort=False).first()
    low, high = first["lowest"], first["highest"]
    facts = {"KCI from": low, "to": high, "error of a constant [%]": 100 * (high - low) / (high + low)}
    facts |= {"σ5 ≈ σ6 [%]": 100 * first["kinks"], "within reach [%]": 100 * first["reachable"]}
    errors = over_seeds(rows, "reading", {"fresh": "largest error [%]", "most": ERRORS["most"]}, "{:.3g}")
    return show(pd.DataFrame(facts).join(errors).rename_axis(None))


def training_sets(stored: Evidence) -> Markup:
    """Set errors of networks by kind of draw and rows, medians over the seeds with their ranges."""
    rows = _percent(stored["training_sets"].where())
    return show(over_seeds(rows, ["index", "method", "rows"], ERRORS, "{:.3g}"))


def extension(stored: Evidence, index: str) -> Markup:
    """Set the range of an index over wider spaces, and errors of networks there."""
    unit, keys = {"w": ("°", ["space"]), "KCI": (" m", ["network", "space"])}[index]
    rows = _percent(stored["extensions"].where(index=index))
    rows["space"] = [f"±{width:g}{unit}" for width in rows["half_width"]]
    rows["values"] = [
        f"{low:.3g}–{high:.3g}" for low, high in zip(rows["lowest"], rows["highest"], strict=True)
    ]
    return show(over_seeds(rows, [*keys, "values", "neurons"], ERRORS, "{:.3g}"))


def error_by_rows(stored: Evidence, live: Table) -> Figure:
    """Draw the largest error on fresh configurations against the rows of the training set."""
    fig = _errors_over(stored["training_sets"].where(), "rows", ["index", "method"])
    fig.axes[0].plot(live.rows["rows"], 100 * live.rows["fresh"], "kx", label="live, first seed")
    fig.axes[0].set(xlabel="rows of the training set", yticks=(0.1, 0.2, 0.5, 1, 2, 5))
    fig.axes[0].legend(fontsize="small")
    return fig


def error_by_range(stored: Evidence) -> Figure:
    """Draw the largest error of networks for w against the range of the joints."""
    rows = stored["extensions"].where(index="w")
    fig = _errors_over(rows.assign(of="neurons"), "half_width", ["neurons", "of"])
    fig.axes[0].set_xticks(rows["half_width"].unique(), [f"{deg:g}" for deg in rows["half_width"].unique()])
    fig.axes[0].set(xlabel="range of the joints to either side [°]")
    return fig


def _errors_over(rows: pd.DataFrame, over: str, by: list[str]) -> Figure:
    """Draw medians and seeds of the largest error, a line for each group."""
    fig, ax = plt.subplots()
    for color, (name, own) in enumerate(_percent(rows).groupby(by, sort=False)):
        ax.plot(own.groupby(over)["fresh"].median(), "o-", label=" ".join(map(str, name)))
        ax.plot(own[over], own["fresh"], ".", color=f"C{color}", alpha=0.3)
    limit = min(load_paper("sotiropoulos2016").printed("feed-forward-testing-error-limit"))
    ax.axhline(100 * limit, color="k", linestyle=":", label="E of the paper")
    ax.set(xscale="log", yscale="log", ylabel="largest error [%]")
    ax.yaxis.set_major_formatter("{x:g}")
    ax.minorticks_off()
    ax.legend(fontsize="small")
    return fig


def _percent(rows: pd.DataFrame) -> pd.DataFrame:
    return rows.assign(**{name: 100 * rows[name] for name in ERRORS})
