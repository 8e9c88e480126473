"""Figures and tables of the chapter on the timing ladder."""

from __future__ import annotations

import matplotlib.pyplot as plt
import pandas as pd
from matplotlib.figure import Figure

from dexterity.networks import export, load_shipped
from dexterity.scenes.colors import COLORS
from dexterity_study.engine.evidence import Evidence
from dexterity_study.engine.table import Table
from dexterity_study.page.markup import Markup
from dexterity_study.page.tables import show
from dexterity_study.uvms.cost.experiment import INDICES
from dexterity_study.uvms.timing import verdicts
from dexterity_study.uvms.timing.experiment import EXACT, FOOT, IN_KIND
from dexterity_study.uvms.timing.verdicts import NETWORKS, advantages, quartiles, savings


def source() -> str:
    """Return the heart of the C file of the network for w that comes with the package."""
    text = export.c_source(load_shipped("uvms-manipulability-feed-forward"), "w")
    return text[text.index("static inline void answer") : text.index("static int finite")]


def table_5(live: Table) -> Markup:
    """Set the times of Table 5 for its test set [ms]; the paper's times of the networks are read as those for w."""
    table = 1000 * verdicts.ON.printed("timing-inputs") * _times(live, IN_KIND, "ours")
    printed = {place: 1000 * verdicts.ON.printed(claim) for place, claim in verdicts.TABLE_5.items()}
    table.insert(0, "paper", [printed.get(place, "not printed") for place in table.index])
    return show(table)


def foot(stored: Evidence) -> Markup:
    """Set the times per configuration [ns] in compiled C, many at once."""
    return show(1e9 * _times(stored["ladder"], FOOT, "median"))


def _times(table: Table, rung: str, median: str) -> pd.DataFrame:
    rows = table.where(rung=rung).set_index(["index", "side"])[["median", "lower", "upper"]]
    return rows.set_axis([median, "first quartile", "third quartile"], axis="columns")


def speed_up(stored: Evidence, live: Table) -> Figure:
    """Draw how many times faster than the exact index both kinds of networks are, rung by rung."""
    runs = {"live": (live.where(), "full", 5), "stored": (stored["ladder"].where(), "none", 11)}
    fig, panels = plt.subplots(2, 1, figsize=(6.8, 7.2), sharex=True)
    for ax, index in zip(panels, INDICES, strict=True):
        for kind, marker, color in zip(NETWORKS, "os", ("blue", "vermillion"), strict=True):
            style = {"linestyle": "none", "color": COLORS[color]}
            for run, (rows, fill, size) in runs.items():
                factors = advantages(quartiles(rows)).xs(index)[kind]
                look = {"marker": marker, "ms": size, "fillstyle": fill, "label": f"{kind}, {run}"}
                ax.plot(factors, factors.index, **look, **style)
            printed = {"marker": "D", "ms": 11, "fillstyle": "none", "label": f"{kind}, paper"}
            ax.plot([verdicts.PRINTED_RATIOS[kind]], [IN_KIND], **printed, **style)
        ax.axvline(1, color="black", lw=1)
        ax.set(xscale="log", title=index)
        ax.invert_yaxis()
    panels[1].set(xlabel="times faster than the exact index")
    fig.legend(*panels[0].get_legend_handles_labels(), fontsize="small", loc="outside upper center", ncols=2)
    return fig


def instructions(stored: Evidence) -> Markup:
    """Set the instructions per configuration, and how many times more the exact index takes."""
    counts = stored["instructions"].where().set_index(["index", "side"])[["instructions"]]
    exact = counts["instructions"].xs(EXACT, level="side")
    counts["exact over it"] = exact.reindex(counts.index, level="index") / counts["instructions"]
    return show(counts, "{:,.4g}")


def planner(stored: Evidence) -> Markup:
    """Set the time [ms] that a feed-forward network for w saves in a cycle of a planner."""
    saved = savings(quartiles(stored["ladder"].where()))["w"]
    of_way = {
        "by the paper's times": verdicts.PRINTED_SAVING,
        IN_KIND: saved[IN_KIND],
        "like for like, in C": saved[FOOT],
    }
    columns = {
        f"{count} configurations": 1e3 * count * pd.Series(of_way) for count in verdicts.SEVERAL_HUNDRED
    }
    return show(pd.DataFrame(columns))
