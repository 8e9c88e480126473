"""Figures and tables of the chapter on which network to use, from rows of its experiments."""

from __future__ import annotations

from collections.abc import Mapping

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from dexterity_study.claims.ledger import load_paper
from dexterity_study.engine.evidence import Evidence
from dexterity_study.page.markup import Markup
from dexterity_study.page.tables import over_seeds, show
from dexterity_study.uvms.choice.verdicts import speeds


def percents(values: Mapping[str, float], title: str) -> Markup:
    """Set a column of shares."""
    return show(pd.Series(values, name=title), "{:.2%}")


def errors_by_way(stored: Evidence) -> Figure:
    """Draw the largest error by way of training, every seed a dot."""
    fig, ax = plt.subplots(figsize=(6.8, 4.8))
    for color, metric, label, marker in (
        ("C0", "sampled", "sampled", "o"),
        ("C1", "worst", "by ascent", "^"),
    ):
        errors = stored["ways"].by_seed(metric, over="way")
        at = np.arange(errors.shape[1])
        dots = ax.plot(100 * errors.T, at, marker, ms=4, alpha=0.6, color=color)
        dots[0].set_label(label)
    limit = load_paper("sotiropoulos2016").printed("all-networks-within-two-per-cent")
    ax.axvline(100 * limit, color="0.4", linestyle="--", label="accepted by the paper")
    ax.set(xscale="log", xlabel="largest relative error [%]", yticks=at, yticklabels=errors.columns)
    ax.invert_yaxis()
    ax.legend(fontsize="small")
    return fig


def judged(stored: Evidence) -> Markup:
    """Set errors of baselines and shipped networks."""
    columns = {"median": "median", "most": "99 % below", "sampled": "largest sampled", "worst": "by ascent"}
    return show(_table(stored, "judged", columns), "{:.2%}")


def cards(stored: Evidence) -> Markup:
    """Set the cards of the shipped networks, in short."""
    rows = speeds(stored)
    rows["largest error"] = [f"{e:.2%} of {n:,}" for e, n in zip(rows["error"], rows["points"], strict=True)]
    rows["worst case found"], rows["exact / network"] = rows["worst"].map("{:.2%}".format), rows["ratio"]
    columns = ["inputs", "neurons", "largest error", "worst case found", "operations", "exact / network"]
    return show(rows[columns].rename_axis([None, None]).T)


def selection(stored: Evidence) -> Markup:
    """Set networks that pass a test, and their errors elsewhere."""
    counts = {"neurons": "neurons", "trained": "networks", "accepted": "pass", "broken": "break E"}
    table = _table(stored, "selection", {**counts, "expected": "pass again"}).round(1)
    errors = {"testing": "test", "grid": "grid", "between": "between", "worst": "by ascent"}
    percent = _table(stored, "selection", errors).map("{:.2%}".format)
    return show(table.join(percent).rename(index="{:.1%}".format).rename_axis("E"))


def pruned(stored: Evidence) -> Markup:
    """Set radial-basis networks before and after pruning."""
    table = _table(stored, "pruned", {"allowed": "limit", "before": "neurons", "after": "after pruning"})
    return show(table.assign(limit=table["limit"].map("{:.1%}".format)))


def elsewhere(stored: Evidence) -> Markup:
    """Set other systems and indices, over the postures."""
    rows = stored["elsewhere"].where()
    sizes = rows.groupby(["system", "index"], sort=False)[["inputs", "neurons"]].first()
    spans = over_seeds(rows, ["system", "index"], {"span": "largest over smallest"}, "{:.2f}")
    errors = over_seeds(rows, ["system", "index"], {"constant": "constant", "error": "network"}, "{:.1%}")
    return show(sizes.join([spans, errors]).rename_axis([None, None]))


def _table(stored: Evidence, experiment: str, columns: dict[str, str]) -> pd.DataFrame:
    """Return columns of an experiment with one seed, under the names of a page."""
    table = stored[experiment]
    return table.where().set_index(list(table.keys))[list(columns)].rename(columns=columns)
