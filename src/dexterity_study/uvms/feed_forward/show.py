"""Figures and tables of the chapter on feed-forward networks, from rows of its experiments."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from dexterity.networks.design import Design
from dexterity_study.claims.ledger import load_paper
from dexterity_study.engine.evidence import Evidence
from dexterity_study.page import figures
from dexterity_study.page.markup import Markup
from dexterity_study.page.numbers import with_range
from dexterity_study.page.tables import over_seeds, show
from dexterity_study.uvms.feed_forward.experiment import AS_PRINTED, GOALS, LARGER, LIMIT, TRAINED_ON
from dexterity_study.uvms.feed_forward.verdicts import ends

_KINDS = {AS_PRINTED: "with the goal of the paper", TRAINED_ON: "without a goal"}
_RULES = {"factor": "toolbox rule", "gain_ratio": "gain ratio"}
_READINGS = {
    "initial-weights=best-of-ten": "best of ten initial weights",
    "task-point=world-origin": "task point at the origin",
}
"""Names of kinds of training, damping rules and readings on the page."""


def error_by_size(stored: Evidence) -> Figure:
    """Draw the testing error against neurons, Figs. 10 and 14 of the paper."""
    fig, panels = plt.subplots(2, 1, figsize=(figures.WIDTH, 4.8))
    loop = stored["loop"].where(index="KCI").assign(kind=AS_PRINTED)
    rows_of = pd.concat([stored["sizes"].where(), loop]).groupby(["index", "kind"]).get_group
    for ax, index, ticks in zip(panels, GOALS, ((0.1, 0.2, 0.5, 1, 2), (2, 5, 10, 20)), strict=True):
        for kind, color in ((AS_PRINTED, "C1"), (TRAINED_ON, "C0")):
            errors = 100 * rows_of((index, kind)).pivot(
                index="neurons", columns="seed", values="testing_error"
            )
            ax.plot(errors, color=color, lw=0.7, alpha=0.3)
            ax.plot(errors.median(axis=1), "o-", color=color, ms=4, label=_KINDS[kind])
        printed = load_paper("sotiropoulos2016").printed(f"feed-forward-{index.lower()}-neurons")
        ax.plot(printed, 100 * LIMIT, "D", color="C2", fillstyle="none", mew=2, ms=10, label="the paper")
        ax.axhline(100 * LIMIT, color="#595959", ls=":", label="limit of the paper")
        ax.set(yscale="log", title=_head(index), ylabel="testing error [%]")
        ax.set_yticks(ticks, labels=ticks)
        ax.minorticks_off()
    panels[1].set(xlabel="neurons")
    for ax in panels:
        ax.xaxis.get_major_locator().set_params(integer=True)
    fig.legend(*panels[0].get_legend_handles_labels(), loc="outside upper center", ncols=2)
    return fig


def trials(design: Design, stored: Evidence) -> str:
    """Say where a live run of the printed loop for w ends, next to the stored loops."""
    tried = ", ".join(f"{trial.testing_error:.2%}" for trial in design.trials)
    neurons = with_range(ends(stored, "w").query("reading == 'chosen'")["neurons"], "{:.0f}")
    return (
        f"Testing errors with one, two, … neurons: {tried}. The loop ends at {design.best.neurons} neurons; the stored loops "
        f"end at {neurons} neurons."
    )


def loops(stored: Evidence) -> Markup:
    """Set where the printed loop ends, and what the networks that it returns are worth."""
    rows = pd.concat([ends(stored, index).assign(index=_head(index)) for index in GOALS]).reset_index()
    names = {"chosen": _RULES["factor"], "damping-rule=gain-ratio": _RULES["gain_ratio"]}
    rows = rows.assign(rule=rows["reading"].map(names))
    percents = ["testing_error", "fresh", "above"]
    rows[percents] *= 100
    keys = ["index", "rule"]
    groups = rows.groupby(keys, sort=False)
    passed = groups["passes"].agg(lambda own: f"{own.sum()} of {len(own)}").rename("loops that pass")
    sizes = over_seeds(rows, keys, {"neurons": "neurons"}, "{:.0f}")
    metrics = {"testing_error": "testing error [%]", "fresh": "on held-out points [%]"}
    errors = over_seeds(rows, keys, metrics, "{:.2f}")
    above = over_seeds(rows, keys, {"above": "held-out points above the limit [%]"}, "{:.2f}")
    return show(pd.concat([passed, sizes, errors, above], axis="columns").rename_axis([None, None]))


def error_by_epoch(stored: Evidence) -> Figure:
    """Draw the mean square error against epochs without a goal, Figs. 11 and 15 of the paper."""
    fig, panels = plt.subplots(2, 1, figsize=(figures.WIDTH, 4.4), sharex=True)
    for ax, (index, goal) in zip(panels, GOALS.items(), strict=True):
        for color, (rule, label) in zip(("C1", "C0"), _RULES.items(), strict=True):
            histories = stored["printed_sizes"].array(f"{index}_{rule}")
            ax.plot(histories.T, color=color, lw=0.7, alpha=0.3)
            ax.plot(np.median(histories, axis=0), color=color, label=label)
        ax.axhline(goal, color="#595959", ls="--", label="goal of the paper")
        ax.set(yscale="log", title=f"{_head(index)}, {LARGER[index][0]} neurons", ylabel="mean square error")
    panels[1].set(xlabel="epochs")
    fig.legend(*panels[0].get_legend_handles_labels(), loc="outside upper center", ncols=2)
    return fig


def judged(stored: Evidence) -> Markup:
    """Set networks of the printed sizes, and larger ones for w, on points that no loop has tested."""
    grid = stored["whole_grid"].where().assign(kind="trained on the whole grid")
    rows = pd.concat([stored["printed_sizes"].where(None), grid])
    is_chosen = rows["reading"] == "chosen"
    other = (rows["kind"] == AS_PRINTED) & rows["reading"].isin(_READINGS)
    # The task point moves KCI alone.
    other &= (rows["index"] == "KCI") | (rows["reading"] != "task-point=world-origin")
    rows = rows[(is_chosen | other) & (rows["neurons"] != 24)]
    rows = rows.assign(index=rows["index"].map(_head), name=rows.apply(_name, axis="columns"))
    metrics = {
        "testing_error": "test set",
        "between": "held-out, 1,000",
        "fresh": "held-out, many",
    }
    rows[list(metrics)] *= 100
    table = over_seeds(rows, ["index", "name"], metrics, "{:.2f}")
    ordered = table.loc[[_head(index) for index in GOALS]]
    return show(ordered.rename_axis([None, None]))


def _name(row: pd.Series) -> str:
    kind = _READINGS.get(row["reading"], _KINDS.get(row["kind"], row["kind"]))
    return f"{row['neurons']} neurons, {kind}"


def _head(index: str) -> str:
    return "$w$" if index == "w" else index
