"""Figures and tables of the chapter on the networks of paper C, from rows of its experiments."""

from __future__ import annotations

from typing import Literal

import matplotlib.pyplot as plt
import pandas as pd
from matplotlib.figure import Figure

from dexterity.scenes.colors import COLORS
from dexterity_study.claims.ledger import load_paper
from dexterity_study.engine.evidence import Evidence
from dexterity_study.engine.table import Table
from dexterity_study.page import figures
from dexterity_study.page.markup import Markup
from dexterity_study.page.numbers import written
from dexterity_study.page.tables import show
from dexterity_study.workspace.estimation import experiment as ways
from dexterity_study.workspace.estimation import logs
from dexterity_study.workspace.estimation.experiment import THRESHOLDS

CHANGES = {
    ways.LONGER: "narrow copy of the paper's",
    ways.UNDROPPED: "no dropout",
    ways.COLUMNS: "separate networks",
    ways.RELEVANT: "no dynamic columns",
    ways.PLAIN: "rotation matrix",
    ways.WORLD: "base axes",
    ways.BEST: "plane of the arm",
}
"""Ways to learn, each with one thing changed, by what has changed."""

FLOOR = 1e-4  # where bars begin on a logarithmic axis


def changes(stored: Evidence, live: Table) -> Figure:
    """Draw the share of the Jacobian's variance that each change leaves, stored and live."""
    fig, ax = plt.subplots(figsize=(figures.WIDTH, 3.3))
    for row, way in enumerate(CHANGES):
        left = 1 - stored["trainings"].values("r2", way=way).dropna()
        low, median, high = left.min(), left.median(), left.max()
        ax.barh(row, median - FLOOR, left=FLOOR, height=0.6, color=COLORS["sky blue"])
        ax.hlines(row, low, high, color=COLORS["black"])
        percent = f"{written(100 * median, '{:.2g}')} %"
        ax.text(1.02, row, percent, transform=ax.get_yaxis_transform(), va="center")
    small = 1 - live.where().set_index("way")["r2"]
    rows = [list(CHANGES).index(way) for way in small.index]
    ax.plot(small, rows, "d", color=COLORS["vermillion"], label="live, fewer rows")
    # The two constant entries count nothing in the printed mean.
    share = ways.ENTRIES / (ways.ENTRIES + ways.CONSTANT_ENTRIES)
    printed = 1 - load_paper("liao2018").printed("estimation-network")[-1] / share
    ax.axvline(printed, linestyle="--", color=COLORS["black"], label="printed")
    ax.set_yticks(range(len(CHANGES)), list(CHANGES.values()))
    ax.invert_yaxis()
    ax.grid(visible=False, axis="y")
    ax.set(xscale="log", xlim=(FLOOR, 2), xlabel="variance left, 1 − R²")
    fig.legend(loc="outside upper center", ncols=2)
    return fig


PRINTED: dict[str, dict[str, str]] = {
    "confidence": {
        "Adam": "unsteady, converges badly",
        "Adamax": "ends best, acceptable",
        "Nadam": "unsteady, converges badly; did well",
        "RMSprop": "unsteady, converges badly",
        "Adagrad": "did well",
        "SGD": "ends worst, acceptable; did well",
    },
    "estimation": {
        "Adam": "converges",
        "Adamax": "converges",
        "Nadam": "does not converge",
        "RMSprop": "converges, steadiest",
        "Adagrad": "does not converge",
        "SGD": "does not converge",
    },
}
"""What the paper says of an optimiser, by head, in our words."""

STAGES = {
    "combined-pretraining": "estimation, before the cycles",
    "combined-confidence-1": "confidence, first cycle",
    "combined-confidence-15": "confidence, last cycle",
    "combined-estimation-15": "estimation, last cycle",
}
"""Stages of the combined model, by the ids of their logs."""

SHARES = {"training [%]": "left", "validation [%]": "left_in_validation"}


def logged() -> Markup:
    """Set the last losses that the authors logged for each optimiser, beside what the paper says of it."""
    rows = {
        (f"{head} network", name): {"the paper says": PRINTED[head][name], **_shares(log)}
        for head in ways.HEADS
        for name, log in logs.by_optimiser(head).items()
    }
    frame = pd.DataFrame.from_dict(rows, orient="index").rename_axis([None, "optimiser"])
    return show(frame, "{:.0f}")


def stages() -> Markup:
    """Set the last losses that the authors logged for stages of the combined model, and those of single networks."""
    known = logs.load()
    rows = {title: _shares(known[name]) for name, title in STAGES.items()}
    best = known["estimation-750"]
    rows["estimation alone, Table VII"] = _shares(best)
    return show(pd.DataFrame.from_dict(rows, orient="index").rename_axis("what was trained"), "{:.0f}")


def course() -> Figure:
    """Draw the logged losses of the estimation network of Table VII over the epochs."""
    fig, ax = plt.subplots(figsize=(figures.WIDTH, 3.0))
    log = logs.load()["estimation-750"]
    for name, curve, color in (
        ("training", log.training, "blue"),
        ("validation", log.validation, "vermillion"),
    ):
        ax.loglog(*zip(*curve, strict=True), ".-", color=COLORS[color], label=name)
    printed = load_paper("liao2018").printed("estimation-network")[1]
    ax.axhline(log.constant, linestyle=":", color=COLORS["black"], label="best constant")
    ax.axhline(printed, linestyle="--", color=COLORS["black"], label="printed, test rows")
    ax.set(xlabel="epoch", ylabel="mean squared error")
    fig.legend(loc="outside upper center", ncols=2)
    return fig


def _shares(log: logs.Log) -> dict[str, float]:
    return {head: 100 * getattr(log, name) for head, name in SHARES.items()}


def thresholds(stored: Evidence) -> Markup:
    """Set the accuracy by threshold below the printed one, and the errors of the Jacobians that the gate passes."""
    paper = load_paper("liao2018")
    accuracies = {f"accuracy_{t:g}": f"accuracy at {t:g} [%]" for t in THRESHOLDS}
    errors = {"error": "error: median [%]", "worst_error": "99th percentile [%]"}
    heads = accuracies | errors
    printed = [100 * paper.printed(f"confidence-network-{100 * t:g}")[0] for t in THRESHOLDS]
    rows = stored["trainings"].where().dropna(subset="accuracy_0.5").set_index("way")
    titles = {**CHANGES, ways.CONFIDENCE_ALONE: "confidence head alone"}
    medians = 100 * rows.groupby(level=0)[list(heads)].median()
    known = [way for way in titles if way in medians.index]
    ours = medians.loc[known].set_axis([titles[way] for way in known])
    top = pd.DataFrame([printed], ["printed"], list(accuracies))
    best: dict[str, Literal["least", "most"]] = dict.fromkeys(accuracies.values(), "most")
    best |= dict.fromkeys(errors.values(), "least")
    return show(pd.concat([top, ours]).rename(columns=heads), "{:.1f}", best=best)
