"""Figures and tables of the chapter on the cost of an index."""

from __future__ import annotations

import matplotlib.pyplot as plt
import pandas as pd
import sympy
from matplotlib.figure import Figure

from dexterity import operations
from dexterity.program import Program
from dexterity_study.claims.ledger import load_paper
from dexterity_study.engine.evidence import Evidence
from dexterity_study.engine.table import Table
from dexterity_study.page import figures
from dexterity_study.page.markup import Markup
from dexterity_study.page.tables import show, stored_and_live
from dexterity_study.uvms.cost.experiment import INDICES
from dexterity_study.uvms.cost.verdicts import Counts

PAPER = load_paper("sotiropoulos2016")
FORMS = ("written out", "terms shared", "reduced")


def forms(stored: Evidence, program: Program, simplified: sympy.Expr) -> Markup:
    """Set the operations of w of a small arm, and of the Jacobian of the UVMS, in several forms."""
    of_arm = {
        "written out": operations.count(program.nested()),
        "terms shared": operations.count_program(program),
        "simplified by hand": operations.count([simplified]),
    }
    titles = {
        "written out": "written out",
        "multiplied out, terms shared": "multiplied out, then terms shared",
        "written out, terms shared": "terms shared",
        "reduced, for KCI": "reduced, in axes for KCI",
        "reduced, for w": "reduced, in axes for $w$",
    }
    counts = Counts(stored)
    rows = {("$w$ of a six-joint arm", form): count.total for form, count in of_arm.items()}
    rows |= {
        ("Jacobian of the vehicle with its arm", title): counts("Jacobian", form)
        for form, title in titles.items()
    }
    return show(pd.Series(rows, name="operations").rename_axis(["", "form"]))


def table_4(stored: Evidence) -> Figure:
    """Draw Table 4 on a logarithmic scale.

    The networks are counted as their equations are printed, with the norm in Eq. 18; with what a neuron uses twice
    computed once; and with constants worked into the weights.
    """
    counts, networks = (
        Counts(stored),
        {"feed-forward": "printed shared folded", "radial-basis": "norm shared shared"},
    )
    totals = {"w": "w-operations-table", "KCI": "kci-operations"}
    rows = {}
    for name in INDICES:
        rows[f"{name}, exact"] = [PAPER.printed(totals[name]), *counts.exact[name]]
        for kind, ways in networks.items():
            printed = PAPER.printed(f"{kind}-{name.lower()}-operations")
            rows[f"{name}, {kind}"] = [printed, *(counts(f"{kind} {name}", way) for way in ways.split())]
    table = pd.DataFrame.from_dict(rows, orient="index", columns=["paper", *FORMS])
    fig, ax = plt.subplots(figsize=(figures.WIDTH, 3.4))
    for column, marker in zip(table, ("D", *"os^"), strict=True):
        hollow = {"ms": 11, "mfc": "none", "color": "#1F2933"} if column == "paper" else {"ms": 7}
        ax.plot(table[column], table.index, marker, label=column, **hollow)
    ax.set(xscale="log", xlim=(80, 50_000), xlabel="operations")
    ax.invert_yaxis()
    fig.legend(loc="outside upper center", ncols=2)
    return fig


def checks(stored: Table, live: Table) -> Markup:
    """Set the deviations of the programs that are counted, with their range over the stored seeds, and of one live run."""
    titles = {
        "written": "written-out Jacobian − spatial Jacobian",
        "closed": "closed-form $w$ / $w$ − 1",
        "laguerre": "KCI by iteration / KCI − 1",
    }
    return show(stored_and_live(stored.where(), live.where(), titles, "{:.0e}"))


def ladder(timed: Evidence) -> Figure:
    """Draw the time per configuration of the exact indices by program and batch, with quartiles."""
    rows = timed["ladder"].where(side="exact")
    fig, ax = plt.subplots(figsize=(figures.WIDTH, 3.4))
    for marker, name in zip("os", INDICES, strict=True):
        lower, median, upper = 1e6 * rows[rows["index"] == name][["lower", "median", "upper"]].to_numpy().T
        bars = (median - lower, upper - median)
        ax.errorbar(median, rows["rung"].unique(), xerr=bars, fmt=marker, label=name)
    ax.set(xscale="log", xticks=[0.01, 0.1, 1, 10, 100], xlabel="time per configuration [µs]")
    ax.xaxis.set_major_formatter("{x:g}")
    ax.invert_yaxis()
    fig.legend(loc="outside upper center", ncols=2)
    return fig
