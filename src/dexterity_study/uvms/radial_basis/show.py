"""Figures and tables of the chapter on radial-basis networks, from rows of its experiments."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from dexterity.networks.design import RadialBasisDesign, RadialBasisOptions
from dexterity_study.claims.ledger import load_paper
from dexterity_study.engine.evidence import Evidence
from dexterity_study.page import diagrams, figures
from dexterity_study.page.diagrams import Arrow, Box
from dexterity_study.page.markup import Markup
from dexterity_study.page.numbers import with_range
from dexterity_study.page.tables import show
from dexterity_study.uvms.feed_forward.experiment import INDICES
from dexterity_study.uvms.radial_basis.verdicts import growth_of

_READINGS = {
    "chosen": "steps of 0.1, as chosen",
    "spread-steps=0.25": "steps of 0.25",
    "spread-steps=0.5": "steps of 0.5",
    "spread-steps=1": "steps of 1",
    "radial-basis-input-scaling=degrees": "inputs and spread in degrees",
}
"""Readings of the printed loop that end elsewhere than the chosen one, by their names on the page."""


def architecture() -> Figure:
    """Draw the radial-basis network for w of the printed size, Fig. 5 of the paper."""
    units = load_paper("sotiropoulos2016").printed("radial-basis-w-neurons")
    return diagrams.layers(
        [f"θ{n}" for n in range(5, 12)], int(units), lambda x: np.exp(-np.square(x)), "w", "RBF units"
    )


def flow_chart(design: RadialBasisDesign, options: RadialBasisOptions) -> Figure:
    """Draw the design loop, Fig. 6b of the paper, with how often a run passed each box and where it ended."""
    x = 1.6
    boxes = {
        "start": Box("first spread", (x, 6.25), height=0.36),
        "add": Box("add a unit at the largest\nerror; refit", (x, 5.5)),
        "ready": Box("$e_{mse} < E_{th}$ ?", (x, 4.6), asks=True),
        "test": Box("test: $e < E$ ?", (x, 3.7), asks=True),
        "more": Box("$e_{mse} > E_{mse}$ and\nunits left?", (x, 2.75), height=0.6, asks=True),
        "full": Box("spread $L_s$ reached?", (x, 1.8), asks=True),
        "raise": Box("raise the spread by a step,\nbegin without units", (x, 0.95)),
        "pass": Box("return\nthis network", (3.65, 3.7), width=1.2),
        "stop": Box("return the\nbest network", (3.65, 1.8), width=1.2),
    }
    arrows = (
        Arrow([(x, 6.07), (x, 5.75)]),
        Arrow([(x, 5.25), (x, 4.85)]),
        Arrow([(x, 4.35), (x, 3.95)], "yes", (x - 0.36, 4.1)),
        Arrow([(x, 3.45), (x, 3.05)], "no", (x - 0.3, 3.2)),
        Arrow([(x, 2.45), (x, 2.05)], "no", (x - 0.3, 2.2)),
        Arrow([(x, 1.55), (x, 1.2)], "no", (x - 0.3, 1.32)),
        Arrow([(2.8, 3.7), (3.05, 3.7)], "yes", (2.72, 3.5)),
        Arrow([(2.8, 1.8), (3.05, 1.8)], "yes", (2.72, 1.6)),
        Arrow([(0.4, 4.6), (0.24, 4.6), (0.24, 2.75), (0.4, 2.75)], "no", (0.27, 4.7)),
        Arrow([(2.8, 2.75), (4.42, 2.75), (4.42, 5.5), (2.8, 5.5)], "yes", (2.72, 2.5)),
        Arrow([(x, 0.7), (x, 0.5), (0.08, 0.5), (0.08, 5.5), (0.4, 5.5)]),
    )
    return diagrams.flow_chart(boxes, arrows, *passages(design, options), height=6.5)


def passages(design: RadialBasisDesign, options: RadialBasisOptions) -> tuple[dict[str, int], str]:
    """Return how often a run of the loop passed each box of its flow chart, and the box where it ended."""
    units = [len(one.mean_square_errors) for one in design.growths]
    ready = [error < options.error_threshold for one in design.growths for error in one.mean_square_errors]
    passing = sum(one.success for one in design.growths)
    spreads, last = len(units), "pass" if design.success else "stop"
    passed = {
        "start": 1,
        "add": sum(units),
        "ready": sum(units),
        "test": sum(ready),
        "more": sum(units) - passing,
        "full": spreads - passing,
        "raise": spreads - 1,
        last: 1,
    }
    return {name: count for name, count in passed.items() if count}, last


def error_by_spread(stored: Evidence) -> Figure:
    """Draw the smallest testing error against the spread, Figs. 8 and 12 of the paper."""
    fig, panels = plt.subplots(2, 1, figsize=(figures.WIDTH, 4.2), sharex=True)
    paper = load_paper("sotiropoulos2016")
    for ax, index in zip(panels, INDICES, strict=True):
        errors = 100 * stored["growth"].by_seed("smallest", over="spread", index=index)
        ax.plot(errors.columns, errors.T, "-", color="C0", lw=0.8, alpha=0.4)
        ax.plot(errors.columns, errors.median(), "o-", color="C0", label="median of ten seeds")
        limit = 100 * paper.printed(f"radial-basis-{index.lower()}-error")
        ax.axhline(limit, color="#595959", ls=":", label="limit of the paper")
        ax.set(xscale="log", title=_head(index), ylabel="testing error [%]")
    panels[0].set(yscale="log")
    panels[0].yaxis.set_major_formatter("{x:g}")
    spread, limit = paper.printed("radial-basis-kci-spread"), paper.printed("radial-basis-kci-error")
    panels[1].plot(
        spread, 100 * limit, "D", color="C1", fillstyle="none", mew=2, ms=10, label="the paper, for KCI"
    )
    panels[1].set(ylim=(0, None), xlabel="spread [rad, m]")
    panels[1].set_xticks([0.1, 0.2, 0.5, 1, 2, 5, 10], labels=["0.1", "0.2", "0.5", "1", "2", "5", "10"])
    panels[1].minorticks_off()
    fig.legend(*panels[1].get_legend_handles_labels(), loc="outside upper center", ncols=2)
    return fig


def by_spread(stored: Evidence) -> Markup:
    """Set the neurons that w needs for two testing errors, and facts of the networks grown to the limit, by spread."""
    groups = growth_of(stored, "w").groupby("spread")
    medians = groups.median(numeric_only=True)
    columns = {
        "neurons for 2 %": groups["needed_0.02"].apply(_reached),
        "neurons for 1 %": groups["needed_0.01"].apply(_reached),
        "wide units [%]": (100 * medians["active"]).map("{:.0f}".format),
        "condition number": medians["condition"],
        "largest weight": medians["weight"],
    }
    table = pd.DataFrame(columns).rename(index="{:g}".format).rename_axis("spread [rad, m]")
    return show(table, "{:.2g}")


def growth(stored: Evidence) -> Figure:
    """Draw testing errors against the number of neurons, Figs. 9 and 13 of the paper."""
    fig, panels = plt.subplots(2, 1, figsize=(figures.WIDTH, 4.3), sharex=True)
    paper, grown = load_paper("sotiropoulos2016"), stored["growth"]
    for ax, index in zip(panels, INDICES, strict=True):
        medians = growth_of(stored, index).groupby("spread")["smallest"].median()
        best, sizes = int(medians.to_numpy().argmin()), grown.array(f"{index}_sizes")[0]
        errors = 100 * grown.array(f"{index}_error")[:, best].T
        lines = ax.plot(sizes, errors, color="C0", lw=1, alpha=0.6)
        lines[0].set_label("best spread, each seed")
        limit = 100 * paper.printed(f"radial-basis-{index.lower()}-error")
        ax.axhline(limit, color="#595959", ls=":", label="limit of the paper")
        ax.set(xscale="log", yscale="log", title=f"{_head(index)}, spread {medians.index[best]:g}")
        ax.set(ylabel="testing error [%]")
        ax.yaxis.set_major_formatter("{x:g}")
        ax.yaxis.set_minor_formatter("")
        ax.set_xticks([1, 10, 100, 1000], labels=["1", "10", "100", "1000"])
    size, limit = paper.printed("radial-basis-w-neurons"), paper.printed("radial-basis-w-error")
    panels[0].plot(
        size, 100 * limit, "D", color="C1", fillstyle="none", mew=2, ms=10, label="the paper, for $w$"
    )
    lifted = stored["lifted_limit"].where()
    panels[1].plot(lifted["neurons"], 100 * lifted["testing_error"], color="C2", label="no neuron limit")
    panels[1].set_yticks([2, 5, 10, 20, 50], labels=["2", "5", "10", "20", "50"])
    panels[1].set(xlabel="RBF units")
    handles = {
        label: handle for ax in panels for handle, label in zip(*ax.get_legend_handles_labels(), strict=True)
    }
    fig.legend(handles.values(), handles, loc="outside upper center", ncols=2)
    return fig


def growth_by_spread(stored: Evidence) -> Figure:
    """Draw the median testing error over the seeds against the number of units, for the spreads of both indices."""
    fig, panels = plt.subplots(2, 1, figsize=(figures.WIDTH, 4.6), sharex=True)
    paper, grown = load_paper("sotiropoulos2016"), stored["growth"]
    spreads = {index: growth_of(stored, index)["spread"].unique() for index in INDICES}
    common = np.array(sorted(set.intersection(*map(set, spreads.values()))))
    colors = plt.get_cmap("cividis")(np.linspace(0, 0.9, len(common)))
    for ax, index in zip(panels, INDICES, strict=True):
        sizes, errors = grown.array(f"{index}_sizes")[0], grown.array(f"{index}_error")
        for spread, color in zip(common, colors, strict=True):
            (place,) = np.flatnonzero(spreads[index] == spread)
            ax.plot(sizes, 100 * np.median(errors[:, place], axis=0), color=color, label=f"{spread:g}")
        limit = 100 * paper.printed(f"radial-basis-{index.lower()}-error")
        ax.axhline(limit, color="#595959", ls=":")
        ax.set(xscale="log", yscale="log", title=_head(index), ylabel="testing error [%]")
        ax.yaxis.set_major_formatter("{x:g}")
        ax.yaxis.set_minor_formatter("")
        ax.set_xticks([1, 10, 100], labels=["1", "10", "100"])
    panels[1].set_yticks([5, 10, 20, 50], labels=["5", "10", "20", "50"])
    panels[1].set(xlabel="RBF units")
    legend = panels[0].get_legend_handles_labels()
    fig.legend(
        *legend, title="spread [rad, m]", loc="outside upper center", ncols=len(common), columnspacing=1
    )
    return fig


def loops(stored: Evidence) -> Markup:
    """Set where the printed loop for w ends, for each reading with a result of its own."""
    rows = stored["loop"].where(None)
    cases = {name: rows[rows["reading"] == reading] for reading, name in _READINGS.items()}
    forms = {
        "spread": (1, "{:.2g}", "spread [rad, m]"),
        "neurons": (1, "{:.0f}", "neurons"),
        "testing_error": (100, "{:.2f}", "testing error [%]"),
        "fresh": (100, "{:.2f}", "on held-out points [%]"),
    }
    columns = {
        head: {name: with_range(factor * own[metric], form) for name, own in cases.items()}
        for metric, (factor, form, head) in forms.items()
    }
    return show(pd.DataFrame(columns))


def input_spaces(stored: Evidence) -> Markup:
    """Set the fewest neurons for w to a testing error of 1 %, by number of joints and by range, as one row."""
    rows = stored["input_spaces"].where()
    by_joints = (
        rows[rows["half_range_deg"] == 15].groupby("joints")["neurons"].apply(with_range, form="{:.0f}")
    )
    by_range = rows[rows["joints"] == 7].groupby("half_range_deg")["neurons"].apply(with_range, form="{:.0f}")
    cells = {("joints, at ±15°", f"{joints}"): value for joints, value in by_joints.items()}
    cells |= {
        ("range of seven joints", f"±{half:g}°"): value for half, value in by_range.items() if half != 15
    }
    return show(pd.DataFrame(cells, index=["neurons"]))


def units_for_exact(cost: Evidence) -> str:
    """Say how many RBF units for w need as many operations as the exact index, counted by the paper's rules."""
    rows = cost["counts"].where()
    (of_exact,) = rows.loc[(rows["what"] == "w") & (rows["form"] == "closed form"), "operations"]
    networks = rows[(rows["what"] == "radial-basis w") & (rows["form"] == "norm")]
    (of_unit,) = networks["operations"] / networks["neurons"]
    return f"{of_exact / of_unit:.0f}"


def _reached(counts: pd.Series) -> str:
    """Write the median of counts over seeds, of which 0 stands for none."""
    reached = counts[counts > 0]
    if reached.empty:
        return "none"
    part = f" in {len(reached)} of {len(counts)} seeds" if len(reached) < len(counts) else ""
    return f"{reached.median():.0f}{part}"


def _head(index: str) -> str:
    return "$w$" if index == "w" else index
