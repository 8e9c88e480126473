"""Figures and tables of the chapter on the cost of an index."""

from __future__ import annotations

from typing import Any

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
from dexterity_study.uvms.cost.verdicts import KINDS, PRINTED, Counts

PAPER = load_paper("sotiropoulos2016")
FORMS = ("written out", "terms shared", "reduced")


_POINTS = {
    0: "world's origin",
    4: "vehicle's middle",
    8: "shoulder",
    9: "elbow",
    10: "wrist",
}
"""Names of the points of `experiment.places`."""


def in_short(stored: Evidence) -> str:
    """Say what the exact indices take written out and reduced, and what the networks take beside them."""
    counts = Counts(stored)
    parts = []
    for name, title in (("w", "*w*"), ("KCI", "KCI")):
        written, _, reduced = counts.exact[name]
        sigmoids, bells = (counts(f"{kind} {name}", form) for kind, form in PRINTED.items())
        parts.append(
            f"The exact {title} takes {written:,} operations written out and {reduced:,} reduced; the feed-forward network takes "
            f"{sigmoids:,} ({sigmoids / reduced:.2g} times the reduced number) and the radial-basis network {bells:,} "
            f"({bells / reduced:.2g} times)."
        )
    return " ".join(parts)


def places(stored: Evidence) -> Figure:
    """Draw the operations of w by the link whose axes are used, a line for each point that J is taken about."""
    rows = stored["places"].where()
    table = rows.pivot(index="link", columns="point", values="operations")
    fig, ax = plt.subplots(figsize=(figures.WIDTH, 3.4))
    links = [int(link) for link in table.index]
    for (point, name), marker in zip(_POINTS.items(), "osD^v", strict=True):
        ax.plot(range(len(links)), table[point], marker=marker, label=name)
    best = _taken(stored)
    place = links.index(best["link"])
    ax.plot(place, best["operations"], "o", ms=15, mfc="none", mew=2, color="#1F2933")
    ax.annotate(
        f"{best['operations']}",
        (place, best["operations"]),
        (0, -16),
        textcoords="offset points",
        ha="center",
    )
    ax.set_xticks(range(len(links)), ["world" if link == 0 else f"{link}" for link in links])
    ax.set(ylim=(0, None), xlabel="link whose axes are used", ylabel="operations of w")
    fig.legend(loc="outside upper center", ncols=3)
    return fig


def moved(stored: Evidence) -> str:
    """Say what the best axes and point do to the entries of the Jacobian, beside the world's."""
    (world,) = stored["places"].where(link=0, point=0).to_dict("records")
    best = _taken(stored)
    return (
        f"In the world's axes and about its origin, {world['zeros']} of the 72 entries are zero, one entry depends on "
        f"{world['joints']} joint values, and *w* takes {world['operations']} operations. In the axes of link {best['link']} and "
        f"about the {_POINTS[best['point']]}, {best['zeros']} entries are zero, no entry depends on more than {best['joints']} joint "
        f"values, and *w* takes {best['operations']} operations."
    )


def _taken(stored: Evidence) -> dict[str, Any]:
    """Return the row of the link and the point that the derivation takes."""
    rows = stored["places"].where()
    (taken,) = rows[rows["taken"].astype(bool)].to_dict("records")
    return {str(name): value for name, value in taken.items()}


def lengths(stored: Evidence) -> Markup:
    """Set the operations of the Jacobian with l1 as a symbol and with l1 = 0, beside the printed number."""
    counts = Counts(stored)
    printed = PAPER.printed("jacobian-operations")
    forms = {
        "as printed in Eq. 6": "written out, as printed in Eq. 6",
        "with the right adjoint": "written out",
        "the same, terms shared": "written out, terms shared",
    }
    rows = {
        title: {
            "$l_1$ as a symbol": counts("Jacobian", form),
            "$l_1 = 0$": counts("Jacobian", f"{form}, l1 = 0"),
            "paper": printed if form == "written out" else None,
        }
        for title, form in forms.items()
    }
    return show(pd.DataFrame.from_dict(rows, orient="index"), "{:,.0f}")


def neurons(stored: Evidence) -> Markup:
    """Set additions + multiplications per neuron of both radial-basis networks, as printed and by two formulas."""
    counts, rows = Counts(stored), {}
    titles = {
        "norm without its sum, eleven inputs": "$(d + 1) + (d + 5)$, $d = 11$",
        "norm": "whole norm, own $d$",
    }
    for name in INDICES:
        network = f"radial-basis {name}"
        size = counts(network, "norm", "neurons")
        printed = PAPER.printed(f"radial-basis-{name.lower()}-split")
        ours = {title: [counts(network, form, kind) for kind in KINDS] for form, title in titles.items()}
        cells = {
            title: " + ".join(f"{part / size:g}" for part in split)
            for title, split in {"paper": printed, **ours}.items()
        }
        rows[f"{_head(name)}, {size} neurons"] = cells
    return show(pd.DataFrame.from_dict(rows, orient="index"))


def _head(index: str) -> str:
    return "$w$" if index == "w" else index


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


def gain(timed: Evidence) -> str:
    """Say how much faster the last program of the ladder is than its first."""
    rows = timed["ladder"].where(side="exact")
    factors = {name: own["median"].iloc[0] / own["median"].iloc[-1] for name, own in rows.groupby("index")}
    return f"Together they make the exact *w* {factors['w']:,.0f} times and the exact KCI {factors['KCI']:,.0f} times faster."


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
