"""Figures and tables of the chapter on the simulated measurements."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from dexterity_study.claims.ledger import load_paper
from dexterity_study.crane.experiment import experiment
from dexterity_study.crane.experiment.verdicts import layout
from dexterity_study.engine.evidence import Evidence
from dexterity_study.engine.table import Table
from dexterity_study.page import figures
from dexterity_study.page.markup import Markup
from dexterity_study.page.numbers import with_range
from dexterity_study.page.tables import show

REFERENCES = dict(zip(experiment.REFERENCES, ("target", "reference"), strict=True))
"""Points from which errors are measured, with the names of their claims."""

WAYS = {
    "nothing, closed form": "no compensation",
    "network, genetic": "network, search",
    "network, closed form": "network, closed form",
    "structure, closed form": "structure, loop",
}
"""Ways to position, with their names on the page."""

ALONE = ("nothing", "misalignment", "play", "stiffness", "sensors", "all")
"""Differences that the page shows."""


def measured(stored: Evidence) -> Figure:
    """Draw mean distances by payload: of the simulated cranes, without and with method 1, and as printed."""
    fig, panels = plt.subplots(1, 2, figsize=(figures.WIDTH, 3.6), sharey=True)
    places = np.arange(len(experiment.PAYLOADS))
    for ax, (reference, name) in zip(panels, REFERENCES.items(), strict=True):
        printed = load_paper("rouvinen1999").printed(f"crane-measured-{name}-rmean")
        means = layout(stored, reference)[:, 5]
        for number, label in enumerate(("without", "with")):
            at, columns = places + 0.3 * number - 0.15, slice(number, 2 * len(places), 2)
            low, median, high = np.quantile(means[:, columns], (0.05, 0.5, 0.95), axis=0)
            ax.vlines(at, low, high, color=f"C{number}", lw=5, alpha=0.4)
            ax.plot(at, median, "o", color=f"C{number}", label=f"{label}, simulated")
            ax.plot(at, printed[columns], "x", ms=9, mew=2.5, color=f"C{number}", label=f"{label}, measured")
        ax.set_xticks(places, [f"{payload:.0f}" for payload in experiment.PAYLOADS])
        ax.set(title=f"from the {reference}", xlabel="payload [kg]", ylim=(-2, None))
    panels[0].set(ylabel="mean distance [mm]")
    fig.legend(*panels[0].get_legend_handles_labels(), loc="outside upper center", ncols=2)
    return fig


def by_difference(stored: Evidence) -> Figure:
    """Draw mean distances by what cranes differ in, for four ways to position."""
    fig, panels = plt.subplots(2, 1, figsize=(figures.WIDTH, 5.2), sharex=True)
    means = 1e3 * np.concatenate(stored["measurements"].array("means"))
    for place, (ax, reference) in enumerate(zip(panels, REFERENCES, strict=True)):
        _draw_differences(ax, means[:, :, place])
        ax.set(title=f"from the {reference}")
    panels[1].set(xlabel="mean distance [mm]")
    fig.legend(*panels[0].get_legend_handles_labels(), loc="outside upper center", ncols=2)
    return fig


def _draw_differences(ax: Axes, means: np.ndarray) -> None:
    """Draw medians and ranges over the cranes of mean distances (cranes, differences, ways)."""
    rows = np.arange(len(ALONE))
    differences = [list(experiment.DIFFERENCES).index(name) for name in ALONE]
    for number, (way, title) in enumerate(WAYS.items()):
        distances = means[:, differences, experiment.WAYS.index(way)]
        low, median, high = np.quantile(distances, (0.05, 0.5, 0.95), axis=0)
        at = rows + 0.18 * (number - 1.5)
        ax.hlines(at, low, high, color=f"C{number}", lw=2.5, alpha=0.4)
        ax.plot(median, at, "o", ms=5, color=f"C{number}", label=title)
    ax.set_yticks(rows, ALONE)
    ax.invert_yaxis()


def networks(stored: Evidence, live: Table) -> Markup:
    """Set the mean distance of networks' sag from the structure's, by payload."""
    columns = {
        title: [with_range(1e3 * errors, "{:.1f}") for errors in table.array("network_error").T]
        for title, table in (("stored networks [mm]", stored["measurements"]), ("live network [mm]", live))
    }
    index = pd.Index([f"{payload:.0f}" for payload in experiment.PAYLOADS], name="payload [kg]")
    return show(pd.DataFrame(columns, index=index))


def points(stored: Evidence) -> Markup:
    """Set for each point where the jib is, what its cylinder holds, and how often compensation harms."""
    model = stored["model"].where()
    force = (model["jib_cylinder"] / 1e3).groupby(model["point"])
    harmed = 100 * stored["measurements"].where().groupby("point")[["all", "play"]].mean()
    columns = {
        "jib angle [°]": np.degrees(model.groupby("point")["jib_angle"].first()),
        "force, empty [kN]": force.first(),
        "force, loaded [kN]": force.last(),
        "harmed, all [%]": harmed["all"],
        "harmed, play [%]": harmed["play"],
    }
    names = {
        i: f"{i}:\N{NO-BREAK SPACE}({x:g},\N{NO-BREAK SPACE}{y:g})"
        for i, (x, y) in enumerate(experiment.POINTS, start=1)
    }
    forms = {"force, empty [kN]": "{:.1f}", "force, loaded [kN]": "{:.1f}"}
    rows = pd.DataFrame(columns).rename(index=names).rename_axis("point [m]")
    return show(rows, "{:.0f}", forms=forms)
