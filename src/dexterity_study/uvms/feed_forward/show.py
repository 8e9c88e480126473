"""Figures and tables of the chapter on feed-forward networks, from rows of its experiments."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from dexterity.networks.design import Design
from dexterity_study.claims.ledger import load_paper
from dexterity_study.engine.evidence import Evidence
from dexterity_study.engine.table import Table
from dexterity_study.page.markup import Markup
from dexterity_study.page.tables import over_seeds, show
from dexterity_study.uvms.feed_forward.experiment import AS_PRINTED, GOALS, LARGER, LIMIT, TRAINED_ON
from dexterity_study.uvms.feed_forward.verdicts import ends


def trials(design: Design) -> Markup:
    """Set the trainings of one design loop."""
    rows = pd.DataFrame(design.trials)
    return show(rows[["neurons", "epochs", "mean_square_error", "testing_error", "validation_error"]])


def error_by_size(stored: Evidence, live: Table) -> Figure:
    """Draw the testing error against neurons, Figs. 10 and 14 of the paper."""
    fig, panels = plt.subplots(1, 2, figsize=(6.8, 3.6))
    loop = stored["loop"].where(index="KCI").assign(kind=AS_PRINTED)
    rows_of = pd.concat([stored["sizes"].where(), loop]).groupby(["index", "kind"]).get_group
    for ax, index, ticks in zip(panels, GOALS, ((0.1, 0.2, 0.5, 1, 2), (2, 5, 10, 20)), strict=True):
        for kind, color in ((AS_PRINTED, "C1"), (TRAINED_ON, "C0")):
            rows = rows_of((index, kind))
            errors = 100 * rows.pivot(index="neurons", columns="seed", values="testing_error")
            ax.plot(errors, color=color, lw=0.7, alpha=0.3)
            ax.plot(errors.median(axis=1), "o-", color=color, ms=4, label=kind)
        rows = live.where(index=index, kind=TRAINED_ON)
        ax.plot(rows["neurons"], 100 * rows["testing_error"], "kx", ms=5, label="live, first seed")
        printed = load_paper("sotiropoulos2016").printed(f"feed-forward-{index.lower()}-neurons")
        ax.plot(printed, 100 * LIMIT, "kD", mfc="none", ms=9, label="paper")
        ax.axhline(100 * LIMIT, color="k", ls=":")
        ax.set(yscale="log", title=index, xlabel="neurons")
        ax.set_yticks(ticks, labels=ticks)
        ax.minorticks_off()
    panels[0].set(ylabel="testing error [%]")
    panels[0].legend(fontsize="small")
    return fig


def loops(stored: Evidence) -> Markup:
    """Set where the printed loop ends, and what the networks that it returns are worth."""
    rows, keys = pd.concat([ends(stored, index) for index in GOALS]), ["index", "reading"]
    groups = rows.groupby(keys, sort=False)
    counts = pd.DataFrame({"loops": groups.size(), "of them passed": groups["passes"].sum()})
    sizes = over_seeds(rows, keys, {"neurons": "neurons at the end"}, "{:g}")
    metrics = {"testing_error": "testing error there", "fresh": "error on fresh points"}
    errors = over_seeds(rows, keys, metrics | {"above": "fresh points above E"}, "{:.2%}")
    return show(counts.join([sizes, errors]).rename_axis([None, None]))


def error_by_epoch(stored: Evidence) -> Figure:
    """Draw the mean square error against epochs without a goal, Figs. 11 and 15 of the paper."""
    fig, panels = plt.subplots(1, 2, figsize=(6.8, 3.4))
    for ax, (index, goal) in zip(panels, GOALS.items(), strict=True):
        for color, rule, label in (("C1", "factor", "toolbox's rule"), ("C0", "gain_ratio", "gain ratio")):
            histories = stored["printed_sizes"].array(f"{index}_{rule}")
            ax.plot(histories.T, color=color, lw=0.7, alpha=0.3)
            ax.plot(np.median(histories, axis=0), color=color, label=label)
        ax.axhline(goal, color="k", ls="--", label="goal of the paper")
        ax.set(yscale="log", title=f"{index}, {LARGER[index][0]} neurons", xlabel="epochs")
    panels[0].set(ylabel="mean square error")
    panels[0].legend(fontsize="small")
    return fig


def judged(stored: Evidence) -> Markup:
    """Set networks of the printed sizes, and larger ones for w, on points that no loop has tested."""
    grid = stored["whole_grid"].where().assign(kind="trained on, whole grid")
    rows = pd.concat([stored["printed_sizes"].where(None), grid]).rename(columns={"kind": "training"})
    # A reading that leaves a network as it is has no row.
    changed = rows.drop_duplicates(["index", "training", "neurons", "seed", "fresh"])
    metrics = {"testing_error": "test set", "between": "between grid points", "fresh": "many more"}
    keys = ["index", "training", "neurons", "rows", "reading"]
    return show(over_seeds(changed, keys, metrics, "{:.2%}").reset_index())
