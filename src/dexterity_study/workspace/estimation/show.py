"""Figures and tables of the chapter on the networks of paper C, from rows of its experiments."""

from __future__ import annotations

from collections.abc import Sequence

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from dexterity.scenes.colors import COLORS
from dexterity.workspace.jacobian_net import Estimate, JacobianNet
from dexterity_study.claims.ledger import load_paper
from dexterity_study.engine.evidence import Evidence
from dexterity_study.engine.table import Table
from dexterity_study.page.markup import Markup
from dexterity_study.page.tables import over_seeds, show
from dexterity_study.workspace.estimation import experiment as ways
from dexterity_study.workspace.estimation.experiment import HEADS, RATES, THRESHOLDS, WAYS
from dexterity_study.workspace.estimation.verdicts import with_constants


def untrained(network: JacobianNet, estimate: Estimate) -> Markup:
    """Set the size of an untrained network, and of its estimate for some poses."""
    facts = {
        "parameters of the paper's size": network.parameter_count,
        "confidences": tuple(estimate.confidence.shape),
        "Jacobians": tuple(estimate.jacobian.shape),
        "poses that pass": int(estimate.mask.sum()),
    }
    return show(pd.Series(facts, name="untrained network"))


def changes(table: Table) -> Markup:
    """Set the error of the Jacobian that each change of inputs and outputs leaves."""
    rows = table.where().dropna(subset="r2")
    own = rows.assign(left=1 - rows["r2"])
    about = {name: (WAYS[name].inputs, WAYS[name].entries) for name in own["way"].unique()}
    columns = pd.DataFrame.from_dict(about, orient="index", columns=["sees", "predicts"])
    columns["parameters"] = own.groupby("way")["parameters"].first()
    scores = over_seeds(own, "way", {"r2": "R²", "worst_entry": "R² of the worst entry"}, "{:.4f}")
    return show(columns.join(over_seeds(own, "way", {"left": "variance left"}, "{:.2%}")).join(scores))


def entries(stored: Evidence) -> Figure:
    """Draw the variance that is left in each entry of the body Jacobian."""
    fig, ax = plt.subplots(figsize=(6.8, 3.6))
    left = stored["trainings"].array("left_of_entries")
    shown = (ways.COLUMNS, ways.RELEVANT, ways.PLAIN, ways.WORLD, ways.BEST)
    colors = ("black", "orange", "sky blue", "bluish green", "vermillion")
    for name, color in zip(shown, colors, strict=True):
        medians = np.nanmedian(left[: WAYS[name].seeds, list(WAYS).index(name)], axis=0)
        known = medians < 1e-12
        places = np.arange(1, len(medians) + 1)
        ax.semilogy(places[~known], medians[~known], "o", color=COLORS[color], label=name)
    ax.set(xlabel="entry of the body Jacobian, row by row", ylabel="1 − R²")
    fig.legend(loc="outside upper center", ncols=5)
    return fig


def estimation(stored: Evidence) -> Markup:
    """Set the network's row of Table VII, with constant entries counted in two ways besides."""
    rows = stored["trainings"].where().dropna(subset="r2")
    rows = rows[~rows["way"].isin((ways.COLUMNS, ways.RELEVANT, ways.WORLD))]
    rows = rows.assign(nothing=with_constants(rows["r2"], 0), ones=with_constants(rows["r2"], 1))
    names = {"absolute": "MAE", "squared": "MSE", "explained": "EVS", "r2": "R²"}
    names |= {"nothing": "R², constants nothing", "ones": "R², constants one"}
    printed = load_paper("liao2018").printed("estimation-network")
    return show(_below(printed, over_seeds(rows, "way", names, "{:.4f}")))


def confidence(stored: Evidence) -> Markup:
    """Set the network's rows of Table VI, by threshold."""
    paper, parts = load_paper("liao2018"), {}
    rows = stored["trainings"].where().dropna(subset="accuracy_0.5")
    names = {"accuracy": "accuracy", "correlation": "MCC", "precision": "precision", "recall": "recall"}
    for t in THRESHOLDS:
        percent = f"{100 * t:g}"
        score = [*paper.printed(f"confidence-network-{percent}")][::2]
        score += [] if len(score) > 1 else [paper.printed("correlation-network-25")]
        printed = *score, *paper.printed(f"retrieval-network-{percent}")
        ours = over_seeds(rows, "way", {f"{score}_{t:g}": head for score, head in names.items()}, "{:.4f}")
        parts[t] = _below(printed, ours)
    return show(pd.concat(parts, names=["threshold", ""]))


def _below(printed: Sequence[float], ours: pd.DataFrame) -> pd.DataFrame:
    """Return our rows below the printed one, which has the first columns."""
    row = pd.DataFrame([map(str, printed)], ["printed"], ours.columns[: len(printed)])
    return pd.concat([row, ours])


def gate(stored: Evidence) -> Markup:
    """Set the shares of poses that the gate lets pass, and the errors of what passes."""
    rows = stored["trainings"].where().dropna(subset="given")
    shares = {
        "given": "given",
        "wrongly_given": "out of reach, given",
        "wrongly_kept_back": "in reach, kept back",
    }
    errors = {"error": "median error", "worst_error": "99 % below"}
    return show(over_seeds(rows, "way", shares | errors, "{:.2%}"))


def curves(stored: Evidence) -> Figure:
    """Draw the validation losses of both heads with each optimiser, Figs. 6 to 9 of the paper."""
    palette = ("black", "orange", "sky blue", "bluish green", "yellow", "blue", "vermillion")
    fig, panels = plt.subplots(1, 2, figsize=(6.8, 3.6))
    for ax, head in zip(panels, HEADS, strict=True):
        epochs, *losses = stored["optimisers"].array(head)[0]
        for name, color, loss in zip(RATES, palette, losses, strict=True):
            ax.semilogy(epochs, loss, color=COLORS[color], label=name)
        constant = stored["optimisers"].where(head=head)["constant"].iloc[0]
        ax.axhline(constant, linestyle=":", color=COLORS["black"])
        ax.set(xlabel="epoch of the schedule", ylabel=f"validation loss, {head}")
    fig.legend(*panels[0].get_legend_handles_labels(), loc="outside upper center", ncols=4)
    return fig
