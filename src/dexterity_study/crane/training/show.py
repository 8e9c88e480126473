"""Figures and tables of the chapter on training and sizes."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from dexterity_study.claims.ledger import load_paper
from dexterity_study.crane.training.experiment import BATCH, NETWORKS, PATTERN, SECOND_ORDER, SOME
from dexterity_study.crane.training.verdicts import by_size, history
from dexterity_study.engine.evidence import Evidence
from dexterity_study.engine.table import Table
from dexterity_study.page import figures
from dexterity_study.page.markup import Markup
from dexterity_study.page.tables import over_seeds, show

LOOKS = {
    "training": "training data",
    "test": "test points",
    "fresh": "fresh points",
    "held_out": "held-out poses",
}

TITLES = {
    SECOND_ORDER: "Levenberg–Marquardt",
    BATCH: "gradient, all rows",
    SOME: "gradient, 32 rows",
    PATTERN: "gradient, one row",
}
"""Names of the trainers on the page, of back-propagation by the rows of a step."""


def sizes(stored: Evidence) -> Figure:
    """Draw errors against hidden neurons, with the thesis's size and that of Eq. 57."""
    fig, panels = plt.subplots(1, 2, figsize=(figures.WIDTH, 3.9), sharey=True)
    for ax, name in zip(panels, NETWORKS, strict=True):
        rule = stored["rule_size"].where(network=name)
        for color, (metric, label) in enumerate(LOOKS.items()):
            ax.loglog(by_size(stored).loc[name, metric], f"C{color}o-", ms=3, label=label)
            ax.plot(rule["neurons"].iloc[0], rule[metric].median(), f"C{color}D")
        thesis = load_paper("rouvinen1999").printed(f"crane-{name}-neurons")[0]
        ax.axvline(thesis, color="#595959", linestyle=":", label="size in the thesis")
        ax.set(title=f"{name} network", xlabel="hidden neurons")
    panels[0].set(ylabel="mean distance [mm]")
    fig.legend(*panels[0].get_legend_handles_labels(), loc="outside upper center", ncols=2)
    return fig


def two_sizes(stored: Evidence, live: Table) -> Markup:
    """Set errors at the test points and over the training data, of the sizes of a live run."""
    keys, trained = ["network", "neurons"], live.where()
    rows = stored["sizes"].where().query("neurons in @trained.neurons.values")
    heads = {"training": "training data [mm]", "test": "test points [mm]"}
    medians = over_seeds(rows, keys, {metric: metric for metric in heads}, "{:.1f}")
    columns = {}
    for metric, head in heads.items():
        columns[head, "stored"] = medians[metric]
        columns[head, "live"] = trained.set_index(keys)[metric]
    return show(pd.DataFrame(columns), "{:.1f}")


def descents(stored: Evidence) -> Figure:
    """Draw the error over the data against time, by back-propagation with the gain that is best in the end."""
    fig, ax = plt.subplots(figsize=(figures.WIDTH, 3.2))
    for way, title in TITLES.items():
        times, errors = history(stored, way)
        if way != SECOND_ORDER:
            errors = errors[:, np.median(errors[..., -1], axis=0).argmin()]
        (line,) = ax.loglog(times[1:], np.median(errors, axis=0)[1:], label=title)
        ax.fill_between(times[1:], errors.min(0)[1:], errors.max(0)[1:], color=line.get_color(), alpha=0.2)
    ax.set(xlabel="processor time [s]", ylabel="distance [mm]")
    fig.legend(loc="outside upper center", ncols=2)
    return fig


def rules(stored: Evidence) -> Markup:
    """Evaluate Eqs. 57 and 58 for the thesis's networks."""
    heads = {
        "neurons": "neurons in the thesis",
        "by_rows": "neurons by Eq. 57",
        "by_poses": "by Eq. 57, for poses",
        "rows": "training rows",
        "needed": "rows by Eq. 58",
        "wrong": "wrong share by Eq. 58",
    }
    names = {
        "correction": "1 correction",
        "direct": "2 direct",
        "modular, rigid": "3, first",
        "modular, rest": "3, second",
        "inverse": "4 inverse",
    }
    rows = stored["rules"].where().set_index("network").loc[list(names), list(heads)]
    return show(rows.rename(index=names, columns=heads).rename_axis("network"), "{:.1f}")
