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
from dexterity_study.uvms.timing.experiment import EXACT, FOOT, IN_KIND
from dexterity_study.uvms.timing.verdicts import (
    NETWORKS,
    ON,
    PRINTED_RATIOS,
    PRINTED_SAVING,
    SEVERAL_HUNDRED,
    advantages,
    saving,
    timings,
)


def source() -> str:
    """Return the heart of the C file of the network for w that comes with the package."""
    text = export.c_source(load_shipped("uvms-manipulability-feed-forward"), "w")
    return text[text.index("static inline void answer") : text.index("static int finite")]


def table_5(live: Table) -> Markup:
    """Set the times of Table 5 for its test set [ms]; the paper's times of the networks are read as those for w."""
    claims = {("w", EXACT): "analytical-w-time", ("KCI", EXACT): "analytical-kci-time"}
    claims |= {("w", network): f"{network}-time" for network in NETWORKS}
    rows = live.where(rung=IN_KIND).set_index(["index", "side"])[["median", "lower", "upper"]]
    table = (
        1000
        * ON.printed("timing-inputs")
        * rows.set_axis(["ours", "first quartile", "third quartile"], axis=1)
    )
    printed = [
        1000 * ON.printed(claims[place]) if place in claims else "not printed" for place in table.index
    ]
    table.insert(0, "paper", printed)
    return show(table)


def speed_up(stored: Evidence, live: Table) -> Figure:
    """Draw how many times faster than the exact index both kinds of networks are, rung by rung."""
    fig, panels = plt.subplots(2, 1, figsize=(6.8, 7.2), sharex=True)
    for ax, index in zip(panels, INDICES, strict=True):
        for kind, marker, color in zip(NETWORKS, "os", ("blue", "vermillion"), strict=True):
            style = {"linestyle": "none", "color": COLORS[color]}
            for run, table, size, fill in (
                ("live", live, 5, "full"),
                ("stored", stored["ladder"], 11, "none"),
            ):
                own = advantages(timings(table.where(index=index)))
                ax.plot(
                    [rung[kind].value for rung in own.values()],
                    range(len(own)),
                    marker,
                    ms=size,
                    fillstyle=fill,
                    label=f"{kind}, {run}",
                    **style,
                )
            ax.plot(PRINTED_RATIOS[kind], 0, "D", ms=11, fillstyle="none", label=f"{kind}, paper", **style)
        ax.axvline(1, color="black", lw=1)
        ax.set(xscale="log", title=index, yticks=range(len(own)), yticklabels=[rung for _, rung in own])
        ax.invert_yaxis()
    panels[1].set(xlabel="times faster than the exact index")
    fig.legend(*panels[0].get_legend_handles_labels(), fontsize="small", loc="outside upper center", ncols=2)
    return fig


def advantage(stored: Evidence) -> Markup:
    """Set how many times faster than the exact index each network is."""
    factors = pd.DataFrame.from_dict(advantages(timings(stored["ladder"].where())), orient="index")
    return show(factors.map(str, na_action="ignore").fillna("not in numpy"))


def foot(stored: Evidence) -> Markup:
    """Set the times per configuration [ns] in compiled C, many at once."""
    rows = stored["ladder"].where(rung=FOOT).set_index(["index", "side"])[["median", "lower", "upper"]]
    return show(1e9 * rows.set_axis(["median", "first quartile", "third quartile"], axis="columns"))


def instructions(stored: Evidence) -> Markup:
    """Set the instructions per configuration, and how many times more the exact index takes."""
    counts = stored["instructions"].where().set_index(["index", "side"])[["instructions"]]
    exact = counts["instructions"].xs(EXACT, level="side")
    counts["exact over it"] = exact.reindex(counts.index, level="index") / counts["instructions"]
    return show(counts, "{:,.4g}")


def planner(stored: Evidence) -> Markup:
    """Set the time [ms] that a feed-forward network for w saves in a cycle of a planner."""
    times = timings(stored["ladder"].where())
    saved = {
        "by the paper's times": PRINTED_SAVING,
        IN_KIND: saving(times["w", IN_KIND]),
        "like for like, in C": saving(times["w", FOOT]),
    }
    columns = {f"{count} configurations": 1e3 * count * pd.Series(saved) for count in SEVERAL_HUNDRED}
    return show(pd.DataFrame(columns))
