"""Figures and tables of the chapter on training and sizes."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

from dexterity_study.claims.ledger import load_paper
from dexterity_study.crane.training.experiment import NETWORKS, SECOND_ORDER, WAYS
from dexterity_study.crane.training.verdicts import by_size, history, memory
from dexterity_study.engine.evidence import Evidence
from dexterity_study.engine.table import Table
from dexterity_study.page.markup import Markup
from dexterity_study.page.tables import show

LOOKS = {
    "training": "training data",
    "test": "test points",
    "fresh": "fresh points",
    "held_out": "held-out poses",
}


def descents(stored: Evidence) -> Figure:
    """Draw the error over the data against time, by back-propagation with the gain that is best in the end."""
    fig, ax = plt.subplots()
    for way in WAYS:
        times, errors = history(stored, way)
        if way != SECOND_ORDER:
            errors = errors[:, np.median(errors[..., -1], axis=0).argmin()]
        (line,) = ax.loglog(times[1:], np.median(errors, axis=0)[1:], label=way)
        ax.fill_between(times[1:], errors.min(0)[1:], errors.max(0)[1:], color=line.get_color(), alpha=0.2)
    ax.set(xlabel="processor time [s]", ylabel="distance [mm]")
    fig.legend(loc="outside upper center", ncols=2)
    return fig


def memory_table(stored: Evidence) -> Markup:
    """Set the numbers that each way keeps."""
    return show(memory(stored).map("{:,}".format))


def sizes(stored: Evidence, live: Table) -> Figure:
    """Draw errors against hidden neurons, with the thesis's size and that of Eq. 57."""
    fig, panels = plt.subplots(1, 2, figsize=(7.2, 3.8))
    for ax, name in zip(panels, NETWORKS, strict=True):
        rule, own = stored["rule_size"].where(network=name), live.where(network=name)
        for color, (metric, label) in enumerate(LOOKS.items()):
            ax.loglog(by_size(stored).loc[name, metric], f"C{color}o-", ms=3, label=label)
            ax.plot(rule["neurons"].iloc[0], rule[metric].median(), f"C{color}D")
            ax.plot(own["neurons"], own[metric], f"C{color}x", ms=8)
        thesis = load_paper("rouvinen1999").printed(f"crane-{name}-neurons")[0]
        ax.axvline(thesis, color="k", linestyle=":", label="thesis")
        ax.set(title=name, xlabel="hidden neurons")
    panels[0].set(ylabel="mean distance [mm]")
    fig.legend(*panels[0].get_legend_handles_labels(), loc="outside upper center", ncols=3)
    return fig


def rules(stored: Evidence) -> Markup:
    """Evaluate Eqs. 57 and 58 for the thesis's networks."""
    heads = {
        "neurons": "neurons of the thesis",
        "rows": "different rows",
        "by_rows": "neurons by Eq. 57",
        "by_poses": "by Eq. 57, counting poses",
        "needed": "rows by Eq. 58, a tenth wrong",
        "wrong": "share wrong for these rows",
    }
    return show(stored["rules"].where().set_index("network")[list(heads)].rename(columns=heads), "{:.1f}")
