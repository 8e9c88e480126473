"""Figures and tables of the chapter on the cost of an index."""

from __future__ import annotations

import matplotlib.pyplot as plt
import pandas as pd
import sympy
from matplotlib.figure import Figure

from dexterity import operations, robots, symbolic
from dexterity.program import Program
from dexterity.symbolic import Derivation, SymbolicChain
from dexterity_study.claims.ledger import load_paper
from dexterity_study.engine.evidence import Evidence
from dexterity_study.page.markup import Markup
from dexterity_study.page.tables import show
from dexterity_study.uvms.cost.experiment import INDICES
from dexterity_study.uvms.cost.verdicts import KINDS, Counts

PAPER = load_paper("sotiropoulos2016")
FORMS = ("written out", "terms shared", "reduced")


def derive(robot: str) -> Derivation:
    """Derive w of a described robot with symbols for its lengths."""
    return symbolic.derive(SymbolicChain.from_description(robots.describe(robot)), INDICES["w"])


def steps(program: Program) -> Markup:
    """Set the steps of a program with their operations."""
    rows = [(str(name), str(step), operations.count([step]).total) for name, step in program.steps]
    return show(pd.DataFrame(rows, columns=["name", "is", "operations"]))


def three_forms(program: Program, simplified: sympy.Expr) -> Markup:
    """Set the operations of one number in three forms."""
    forms = {
        "put into one another": operations.count(program.nested()).total,
        "in steps": operations.count_program(program).total,
        "simplified": operations.count([simplified]).total,
    }
    return show(pd.Series(forms, name="operations"))


def jacobian_counts(stored: Evidence) -> Markup:
    """Set the operations of the Jacobian in each form."""
    rows = stored["counts"].where(what="Jacobian").sort_values("operations", ascending=False)
    return show(rows.set_index("form")[["additions", "multiplications", "operations"]].astype(int))


def _printed_and_ours(counts: Counts) -> pd.DataFrame:
    """Return the operations of Appendix A and Table 4, the paper's and ours in three ways of counting.

    The networks are counted as their equations are printed, with the norm in Eq. 18; with what a neuron uses twice
    computed once; and with constants worked into the weights.
    """
    parts = {
        "Jacobian": ("Jacobian", "written out", "written out, terms shared"),
        "JJᵀ": ("gram", "all", "symmetric"),
        "its determinant": ("determinant", "terms", "elimination"),
    }
    rows: dict[str, list[float]] = {}
    for title, (what, *forms) in parts.items():
        printed = sum(PAPER.printed(f"{what.lower()}-{kind}") for kind in KINDS)
        rows[title] = [printed, *(counts(what, form) for form in forms)]
    rows["w in Appendix A"] = [PAPER.printed("w-operations-appendix"), *counts.exact["w"]]
    rows["singular values"] = [PAPER.printed("svd-operations"), *counts.singular_values]
    for name, claim in (("w", "w-operations-table"), ("KCI", "kci-operations")):
        rows[f"exact {name}"] = [PAPER.printed(claim), *counts.exact[name]]
    ways = {"feed-forward": ("printed", "shared", "folded"), "radial-basis": ("norm", "shared", "shared")}
    for kind, of_network in ways.items():
        for name in INDICES:
            printed = PAPER.printed(f"{kind}-{name.lower()}-operations")
            rows[f"{kind} {name}"] = [printed, *(counts(f"{kind} {name}", form) for form in of_network)]
    return pd.DataFrame.from_dict(rows, orient="index", columns=["paper", *FORMS])


def appendix_a_and_table_4(stored: Evidence) -> Markup:
    """Set the operations of Appendix A and Table 4; a part has nothing reduced."""
    table = _printed_and_ours(Counts(stored))
    return show(table.astype("Int64").astype(object).fillna(""))


def table_4_drawn(stored: Evidence) -> Figure:
    """Draw Table 4 on a logarithmic scale."""
    table = _printed_and_ours(Counts(stored))["exact w":]
    fig, ax = plt.subplots(figsize=(6.2, 4))
    for column, marker in zip(table, ("D", *"os^"), strict=True):
        hollow = {"ms": 10, "mfc": "none", "color": "black"} if column == "paper" else {"ms": 7}
        ax.plot(table[column], table.index, marker, label=column, **hollow)
    ax.set(xscale="log", xlim=(80, 50_000), xlabel="operations")
    ax.invert_yaxis()
    ax.legend(fontsize="small", loc="lower left", bbox_to_anchor=(0, 1), ncols=2)
    return fig


def reduced(stored: Evidence) -> Markup:
    """Set the operations of the reduced indices, and the steps that make up KCI."""
    counts = Counts(stored)
    step, kci = counts("Laguerre", "step"), counts.exact["KCI"][-1]
    most = kci + (counts.most_steps - counts.steps) * step
    rows = {
        "w by its closed form": counts("w", "closed form"),
        "w by orthogonal elimination, safe near a singularity": counts("w", "elimination"),
        "KCI, to the bidiagonal form": counts("bidiagonal", "reduced"),
        "KCI, each step of the iteration": step,
        f"KCI in all, with the median of {counts.steps} steps": kci,
        f"KCI in all, with the most steps, {counts.most_steps}": most,
    }
    return show(pd.Series(rows, name="operations"))


def ladder(timed: Evidence) -> Figure:
    """Draw the time per configuration of the exact indices on each rung of the timing ladder, with quartiles."""
    rows = timed["ladder"].where(side="exact")
    fig, ax = plt.subplots(figsize=(6.8, 4.4))
    for marker, name in zip("os", INDICES, strict=True):
        lower, median, upper = 1e9 * rows[rows["index"] == name][["lower", "median", "upper"]].to_numpy().T
        bars = (median - lower, upper - median)
        ax.errorbar(median, rows["rung"].unique(), xerr=bars, fmt=marker, label=name)
    ax.set(xscale="log", xlabel="time per configuration [ns]")
    ax.invert_yaxis()
    ax.legend()
    return fig
