"""Figures and tables of the chapter on the cost of an index."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import sympy
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from sympy import Symbol

from dexterity import operations, robots, symbolic, timing
from dexterity.program import Program, Recorder
from dexterity.scenes.colors import COLORS
from dexterity.symbolic import Derivation, SymbolicChain
from dexterity_study.claims.ledger import load_paper
from dexterity_study.engine.evidence import Evidence
from dexterity_study.page.markup import Markup
from dexterity_study.page.tables import show
from dexterity_study.uvms.cost.experiment import INDICES
from dexterity_study.uvms.cost.verdicts import Counts

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


def graph(derivation: Derivation) -> Figure:
    """Draw the steps from joint values to w², each right of all that it uses."""
    uses, stages = _steps_of(derivation)
    places = _places(uses)
    numbers = {symbol: number for number, symbol in enumerate(uses)}
    arrows = np.array([(numbers[used], numbers[symbol]) for symbol in uses for used in uses[symbol]])
    fig, ax = plt.subplots(figsize=(6.5, 4))
    ax.add_collection(LineCollection(places[arrows], color="0.75", linewidth=0.6, zorder=1))
    of_stage = np.array([stages[symbol] for symbol in uses])
    for stage, color in zip(dict.fromkeys(of_stage), ("black", "orange", "blue", "vermillion"), strict=True):
        ax.plot(*places[of_stage == stage].T, "o", ms=5, color=COLORS[color], label=stage)
    ax.set(xlabel="steps that must come before", yticks=[])
    ax.grid(False)
    ax.legend(loc="upper right", fontsize="small")
    return fig


def jacobian_counts(stored: Evidence) -> Markup:
    """Set the operations of the Jacobian in each form."""
    rows = (
        stored["counts"].where(what="Jacobian").sort_values("operations", ascending=False).set_index("form")
    )
    return show(rows[["additions", "multiplications", "operations"]].astype(int))


def appendix_a(stored: Evidence) -> Markup:
    """Set the operations of the parts of Appendix A, the paper's and ours in three ways of counting."""
    counts = Counts(stored)
    sums = counts.sums()

    def printed(*claims: str) -> int:
        return sum(int(PAPER.printed(claim)) for claim in claims)

    def total(name: str) -> list[int]:
        return [sums[form][name] for form in FORMS]

    rows = {
        "Jacobian": [
            printed("jacobian-operations"),
            counts("Jacobian", "written out"),
            counts("Jacobian", "written out, terms shared"),
        ],
        "JJᵀ": [
            printed("gram-multiplications", "gram-additions"),
            counts("gram", "all"),
            counts("gram", "symmetric"),
        ],
        "its determinant": [
            printed("determinant-multiplications", "determinant-additions"),
            counts("determinant", "terms"),
            counts("determinant", "elimination"),
        ],
        "w in all": [printed("w-operations-appendix"), *total("w")],
        "singular values": [printed("svd-operations"), counts.svd, counts.iterated],
        "KCI in all": [printed("kci-operations"), *total("KCI")],
    }  # a part has one number less than a sum: nothing reduced
    table = pd.DataFrame.from_dict(rows, orient="index", columns=["paper", *FORMS])
    return show(table.astype("Int64").astype(object).fillna(""))


def iteration(stored: Evidence) -> Markup:
    """Set the operations of the reduced KCI, and the steps that make them up."""
    counts = Counts(stored)
    rows = {
        "operations to the bidiagonal form": counts("bidiagonal", "reduced"),
        "operations of a step": counts("Laguerre", "step"),
        "steps for both singular values, median": counts.steps,
        "steps for both singular values, largest": counts.most_steps,
        "operations of KCI in all": counts.sums()["reduced"]["KCI"],
    }
    return show(pd.Series(rows, name="KCI, reduced"))


def table_4(stored: Evidence) -> Markup:
    """Set Table 4."""
    return show(_table_4(stored))


def _table_4(stored: Evidence) -> pd.DataFrame:
    """Return the operations of Table 4, the paper's and ours in three ways of counting.

    The networks are counted as their equations are printed, with the norm in Eq. 18; with what a neuron uses twice
    computed once; and with constants worked into the weights.
    """
    counts = Counts(stored)
    sums = counts.sums()
    claims = {"w": "w-operations-table", "KCI": "kci-operations"}
    rows = {
        f"exact {name}": [PAPER.printed(claim), *(sums[form][name] for form in FORMS)]
        for name, claim in claims.items()
    }
    ways = {"feed-forward": ("printed", "shared", "folded"), "radial-basis": ("norm", "shared", "shared")}
    for kind, forms in ways.items():
        for name in INDICES:
            printed = PAPER.printed(f"{kind}-{name.lower()}-operations")
            rows[f"{kind} {name}"] = [printed, *(counts(f"{kind} {name}", form) for form in forms)]
    return pd.DataFrame.from_dict(rows, orient="index", columns=["paper", *FORMS]).astype(int)


def table_4_drawn(stored: Evidence) -> Figure:
    """Draw Table 4 on a logarithmic scale."""
    table = _table_4(stored)
    fig, ax = plt.subplots(figsize=(6.2, 4))
    rows = np.arange(len(table))
    ax.plot(table["paper"], rows, "Dk", ms=10, mfc="none", label="paper")
    for form, marker in zip(FORMS, "os^", strict=True):
        ax.plot(table[form], rows, marker, ms=7, label=form)
    ax.set(xscale="log", xlim=(80, 50_000), xlabel="operations", yticks=rows, yticklabels=table.index)
    ax.invert_yaxis()
    ax.legend(fontsize="small", loc="lower left", bbox_to_anchor=(0, 1), ncols=2)
    return fig


def other_forms(stored: Evidence) -> Markup:
    """Set the operations in other forms than those of Table 4."""
    counts = Counts(stored)
    more = (counts.most_steps - counts.steps) * counts("Laguerre", "step")
    rows = {
        "w by its closed form": counts("w", "closed form"),
        "w by orthogonal elimination, safe near a singularity": counts("w", "elimination"),
        "KCI with the most steps that were needed": counts.sums()["reduced"]["KCI"] + more,
        "radial-basis KCI, Eq. 18 as printed": counts("radial-basis KCI", "printed"),
        "radial-basis KCI, with the norm": counts("radial-basis KCI", "norm"),
        "radial-basis KCI, without the needless root": counts("radial-basis KCI", "shared"),
    }
    return show(pd.Series(rows, name="operations"))


def ladder(stored: Evidence) -> Figure:
    """Draw the time per configuration of each way, with quartiles."""
    fig, ax = plt.subplots(figsize=(6.8, 4.4))
    tables = _ladders(stored)
    for shift, marker, (name, table) in zip((-0.15, 0.15), "os", tables.items(), strict=True):
        lower, median, upper = table[["lower", "median", "upper"]].to_numpy().T
        bars = (median - lower, upper - median)
        ax.errorbar(median, np.arange(len(median)) + shift, xerr=bars, fmt=marker, label=name)
    ways = tables["w"].index
    ax.set(xscale="log", xlabel="time per configuration [ns]", yticks=range(len(ways)), yticklabels=ways)
    ax.invert_yaxis()
    ax.legend()
    return fig


def ladder_table(stored: Evidence) -> Markup:
    """Set the times of the ladder; ratios of the medians are to the last line."""
    times = {name: timing.readable(table).iloc[:, 2:] for name, table in _ladders(stored).items()}
    return show(pd.concat(times, axis="columns").rename_axis(None))


def _ladders(stored: Evidence) -> dict[str, pd.DataFrame]:
    tables = {}
    for name in INDICES:
        rows = stored["ladder"].where(index=name)[["way", "configurations", "lower", "median", "upper"]]
        timings = [timing.Timing(*row) for row in rows.itertuples(index=False)]
        tables[name] = timing.table(timings, timings[-1].name)
    return tables


def _steps_of(derivation: Derivation) -> tuple[dict[Symbol, list[Symbol]], dict[Symbol, str]]:
    """Return what each step uses, and the stage that it belongs to."""
    record = Recorder("n")
    joints = derivation.joint_values
    jacobian = record.replay(derivation.jacobian)
    program = record.program(joints, record.replay(derivation.squared_manipulability))
    of_jacobian = {symbol for symbol, _ in record.program(joints, jacobian).steps}
    stages: dict[Symbol, str] = dict.fromkeys(program.used_inputs, "joint value")
    uses: dict[Symbol, list[Symbol]] = {symbol: [] for symbol in stages}
    for symbol, expression in program.steps:
        uses[symbol] = sorted(expression.free_symbols & stages.keys(), key=str)
        if isinstance(expression, sympy.sin | sympy.cos):
            stages[symbol] = "sine or cosine"
        else:
            stages[symbol] = "Jacobian" if symbol in of_jacobian else "determinant"
    return uses, stages


def _places(uses: Mapping[Symbol, Sequence[Symbol]]) -> np.ndarray:
    """Place each step at its depth in the graph, at a height near the mean of what it uses."""
    depth: dict[Symbol, int] = {}
    for symbol, used in uses.items():
        depth[symbol] = 1 + max((depth[one] for one in used), default=-1)
    height: dict[Symbol, float] = {}
    for level in range(max(depth.values()) + 1):
        layer = [symbol for symbol in uses if depth[symbol] == level]
        layer.sort(key=lambda symbol: np.mean([height[one] for one in uses[symbol]] or [0.0]))
        height |= dict(zip(layer, np.arange(len(layer)) - (len(layer) - 1) / 2, strict=True))
    return np.array([(depth[symbol], height[symbol]) for symbol in uses], dtype=float)
