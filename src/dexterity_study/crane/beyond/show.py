"""Figures and tables of the chapter on what beats the methods of paper D."""

from __future__ import annotations

import matplotlib.pyplot as plt
import pandas as pd
from matplotlib.figure import Figure

from dexterity_study.claims.ledger import load_paper
from dexterity_study.crane.beyond.experiment import (
    COROTATIONAL,
    DESCENT,
    GENETIC,
    NOTHING,
    REGRESSION,
    STRUCTURE,
    THESIS,
)
from dexterity_study.crane.beyond.verdicts import loop, times
from dexterity_study.engine.evidence import Evidence
from dexterity_study.engine.table import Table
from dexterity_study.page import figures
from dexterity_study.page.markup import Markup
from dexterity_study.page.numbers import with_range
from dexterity_study.page.tables import over_seeds, show

FLOOR = 1e-3
"""Error below which a crane is not positioned any better [mm]."""

METHODS = {
    NOTHING: ("the thesis", "no compensation"),
    DESCENT: ("the thesis", "2 direct network, descent"),
    GENETIC: ("the thesis", "1 correction, search"),
    f"{THESIS}, once": ("learned sag in the loop", "network of the thesis, 1 solve"),
    f"{THESIS}, in a loop": ("learned sag in the loop", "network of the thesis"),
    "network of 40 neurons, in a loop": ("learned sag in the loop", "network of 40 neurons"),
    "training grid as a table, in a loop": ("learned sag in the loop", "training grid as a table"),
    "network in angles, in a loop": ("learned sag in the loop", "network in angles"),
    f"{REGRESSION}, in a loop": ("learned sag in the loop", "regression in angles"),
    f"{STRUCTURE}, once": ("structure", "loop, 1 solve"),
    f"{STRUCTURE}, in a loop": ("structure", "loop, 6 solves"),
    f"{STRUCTURE}, Gauss–Newton": ("structure", "Gauss–Newton"),
}
"""Group and name of the methods on the page."""


def loops(stored: Evidence) -> Figure:
    """Draw errors by the number of structural solves, with the mean errors of the thesis."""
    fig, ax = plt.subplots(figsize=(figures.WIDTH, 3.4))
    for structure, color in (("linear", "C0"), ("co-rotational", "C1")):
        errors = 1e3 * loop(stored, structure)[["mean", "largest"]].clip(lower=FLOOR / 1e3)
        ax.semilogy(errors["mean"], f"{color}o-", label=f"{structure}, mean")
        ax.semilogy(errors["largest"], f"{color}s--", mfc="none", label=f"{structure}, largest")
    ax.axhspan(FLOOR / 2, FLOOR, color="#E6E6E6", zorder=0)
    printed = load_paper("rouvinen1999").printed("crane-correction-mean")[2]
    ax.axhline(printed, color="#595959", ls=":", label="thesis, mean")
    ax.set(xlabel="structural solves per target", ylabel="error [mm]", ylim=(FLOOR / 2, 300))
    fig.legend(loc="outside upper center", ncols=2)
    return fig


def methods(stored: Evidence, live: Table) -> Markup:
    """Set errors on linear statics, with one live run, at fresh points, and on the co-rotational structure."""
    every = pd.concat([stored["learned_methods"].where(), stored["exact_methods"].where()])
    heads = {
        "test_mean": ("test [mm]", "mean"),
        "test_largest": ("test [mm]", "largest"),
        "fresh_99": ("fresh points [mm]", "99 %"),
        "fresh_largest": ("fresh points [mm]", "largest"),
        "corotational_mean": ("co-rotational [mm]", "mean"),
    }
    columns = _in_mm(every, {metric: metric for metric in heads})
    columns.columns = pd.MultiIndex.from_tuples(heads.values())
    columns.insert(1, ("test [mm]", "live"), _in_mm(live.where(), {"test_mean": "live"})["live"])
    columns = columns.loc[list(METHODS)].set_index(pd.MultiIndex.from_tuples(METHODS.values()))
    return show(columns.fillna("–"), best=dict.fromkeys(heads.values(), "least"))


def speed(stored: Evidence) -> Markup:
    """Set processor times of a sag and of a point, at once and one by one, with their quartiles."""
    sags = {
        THESIS: "network of the thesis",
        "network in angles": "network in angles",
        STRUCTURE: "structure, linear",
        "co-rotational": "structure, co-rotational",
    }
    points = {
        GENETIC: "1 correction, search",
        f"{THESIS}, once": "network of the thesis, 1 solve",
        "network in angles, in a loop": "network in angles, loop",
        f"{STRUCTURE}, once": "structure, 1 solve",
        f"{STRUCTURE}, in a loop": "structure, 6 solves",
        COROTATIONAL: "co-rotational, 4 solves",
    }
    ways = (("in one batch [µs]", "at once", 1e6), ("one by one [ms]", "one by one", 1e3))
    rows = {
        (group, title): {
            head: _quartiles(times(stored, of, asked), name, factor) for head, asked, factor in ways
        }
        for group, of, titles in (("one sag", "sag", sags), ("one target", "point", points))
        for name, title in titles.items()
    }
    return show(pd.DataFrame.from_dict(rows, orient="index"))


def _in_mm(rows: pd.DataFrame, heads: dict[str, str]) -> pd.DataFrame:
    """Write medians and ranges over the seeds by method [mm]."""
    return over_seeds(rows.assign(**{name: 1e3 * rows[name] for name in heads}), "method", heads, "{:.2f}")


def _quartiles(rows: pd.DataFrame, name: str, factor: float) -> str:
    """Write the median of a time and its quartiles."""
    if name not in rows.index:
        return "–"
    return with_range(factor * rows.loc[name, ["lower", "median", "upper"]].to_numpy(dtype=float), "{:.2g}")
