"""Figures and tables of the chapter on the simulated measurements."""

from __future__ import annotations

from collections.abc import Iterable

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from dexterity.scenes.colors import COLORS
from dexterity_study.crane.experiment import experiment
from dexterity_study.crane.experiment.verdicts import ROWS, errors_of, layout
from dexterity_study.engine.evidence import Evidence
from dexterity_study.engine.table import Table
from dexterity_study.page.markup import Markup
from dexterity_study.page.numbers import with_range
from dexterity_study.page.tables import show

LOOKS = (("without", COLORS["sky blue"], 0.24), ("with method 1", COLORS["vermillion"], 0.12))


def errors(stored: Evidence, reference: str) -> Markup:
    """Set errors as Tables 4.2 and 4.3 do: median and range over the cranes, without and with method 1."""
    kinds = [f"{what}, {kind}" for kind in ROWS.values() for what in ("x", "y", "distance")]
    masses = [*(f"{mass:.0f} kg" for mass in experiment.PAYLOADS), "all"]
    columns = [f"{mass}, {how}" for mass in masses for how in ("without", "with")]
    return _ranges(layout(stored, reference), kinds, columns)


def by_difference(stored: Evidence, reference: str) -> Markup:
    """Set the mean distance by what cranes differ in, for all ways."""
    means = 1e3 * np.concatenate(stored["measurements"].array("means"))
    place = experiment.REFERENCES.index(reference)
    return _ranges(means[:, :, place], experiment.DIFFERENCES, experiment.WAYS)


def _ranges(values: np.ndarray, rows: Iterable[str], columns: Iterable[str]) -> Markup:
    written = [[with_range(cell, "{:.1f}") for cell in row] for row in np.moveaxis(values, 0, -1)]
    return show(pd.DataFrame(written, index=list(rows), columns=list(columns)))


def bars(stored: Evidence) -> Figure:
    """Draw errors in x and y at the nine points, as Figs. 4.22 and 4.23 do, for the typical crane."""
    numbers = np.arange(1, len(experiment.POINTS) + 1)
    at = numbers[:, None] + np.linspace(-0.27, 0.27, len(experiment.PAYLOADS))
    fig, panels = plt.subplots(2, 2, figsize=(7, 5), sharex=True, sharey="row")
    for column, reference in zip(panels.T, experiment.REFERENCES, strict=True):
        own = experiment.from_reference(errors_of(stored), reference)[typical(stored)]
        for axis, ax in enumerate(column):
            for missed, (label, color, width) in zip(own[:2, ..., axis], LOOKS, strict=True):
                ax.bar(at.ravel(), missed.ravel(), width, color=color, label=label)
        column[0].set(title=f"from the {reference}")
        column[1].set(xlabel="point", xticks=numbers)
    panels[0, 0].set(ylabel="error in x [mm]")
    panels[1, 0].set(ylabel="error in y [mm]")
    fig.legend(*panels[0, 0].get_legend_handles_labels(), loc="outside upper center", ncols=2)
    return fig


def networks(stored: Evidence, live: Table) -> Markup:
    """Set the mean distance of networks' sag from the structure's, by payload."""
    columns = {
        title: [with_range(1e3 * own, "{:.1f}") for own in table.array("network_error").T]
        for title, table in (("stored networks [mm]", stored["measurements"]), ("live network [mm]", live))
    }
    return show(pd.DataFrame(columns, index=[f"{payload:.0f} kg" for payload in experiment.PAYLOADS]))


def points(stored: Evidence) -> Markup:
    """Set for each point where the jib is, what its cylinder holds, and how often compensation harms."""
    model = stored["model"].where()
    force = (model["jib_cylinder"] / 1e3).groupby(model["point"])
    harmed = 100 * stored["measurements"].where().groupby("point")[["all", "play"]].mean()
    columns = {
        "jib [°]": np.degrees(model.groupby("point")["jib_angle"].first()),
        "cylinder, empty to loaded [kN]": force.apply(lambda own: f"{own.iloc[0]:.1f} to {own.iloc[-1]:.1f}"),
        "better without [% of cranes]": harmed["all"],
        "with play alone [%]": harmed["play"],
    }
    names = {i: f"{i}: {point}" for i, point in enumerate(experiment.POINTS, start=1)}
    return show(pd.DataFrame(columns).rename(index=names), "{:.0f}")


def typical(stored: Evidence) -> int:
    """Return which crane has the median mean distance from the target with method 1; the lower of two."""
    mean = layout(stored, "target")[:, 5, -1]
    return int(np.argsort(mean, kind="stable")[(len(mean) - 1) // 2])
