"""Figures and tables of the chapter on the timing ladder."""

from __future__ import annotations

from itertools import product

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from dexterity.networks import export, load_shipped
from dexterity.scenes.colors import COLORS
from dexterity_study.engine.evidence import Evidence
from dexterity_study.engine.table import Table
from dexterity_study.page import figures
from dexterity_study.page.markup import Markup
from dexterity_study.page.numbers import written
from dexterity_study.page.tables import show
from dexterity_study.uvms.cost.experiment import INDICES
from dexterity_study.uvms.timing import verdicts
from dexterity_study.uvms.timing.experiment import EXACT, FEED_FORWARD, FOOT, IN_KIND, RADIAL_BASIS, SINGLY
from dexterity_study.uvms.timing.verdicts import NETWORKS, advantages, quartiles, savings

_RUNGS = {
    IN_KIND: "as in the paper",
    SINGLY: "numpy, one by one",
    "numpy, a test set at once": "numpy, 1,000 at once",
    "torch, a test set at once": "torch, 1,000 at once",
    "torch, many at once": "torch, 100,000 at once",
    "C from Python, one by one": "C called from Python",
    "C from C, one by one": "C, one by one",
    "C, a test set at once": "C, 1,000 at once",
    FOOT: "C, 100,000 at once",
}
"""Names of the rungs on the page."""

_SIDES = {
    EXACT: "exact index",
    FEED_FORWARD: "feed-forward, printed size",
    RADIAL_BASIS: "radial-basis, printed size",
    f"shipped {FEED_FORWARD}": "feed-forward of the package",
    f"shipped {RADIAL_BASIS}": "radial-basis of the package",
}


def speed_up(stored: Evidence) -> Figure:
    """Draw how many times faster than the exact index both kinds of networks are, rung by rung."""
    fig, panels = plt.subplots(2, 1, figsize=(figures.WIDTH, 6.2), sharex=True)
    times = quartiles(stored["ladder"].where())
    for ax, index in zip(panels, INDICES, strict=True):
        median, lower, upper = (times[name].xs(index) for name in ("median", "lower", "upper"))
        for kind, marker, color in zip(NETWORKS, "os", ("blue", "vermillion"), strict=True):
            factor = median[EXACT] / median[kind]
            ends = factor - lower[EXACT] / upper[kind], upper[EXACT] / lower[kind] - factor
            names = factor.index.map(_RUNGS)
            look = {"ms": 6, "color": COLORS[color], "linestyle": "none"}
            ax.errorbar(factor, names, xerr=np.array(ends), marker=marker, capsize=4, label=kind, **look)
            # The times of the networks in Table 5 are read as those for w.
            if index == "w":
                printed = [verdicts.PRINTED_RATIOS[kind]], [_RUNGS[IN_KIND]]
                ax.plot(*printed, "D", fillstyle="none", mew=2, label=f"{kind}, paper", **{**look, "ms": 10})
        ax.axvline(1, color="#595959", lw=1.5)
        ax.set(xscale="log", title=_head(index))
        ax.set_xticks([0.1, 1, 10, 100, 1000], labels=["0.1", "1", "10", "100", "1000"])
        ax.invert_yaxis()
    panels[1].set(xlabel="times faster than the exact index")
    fig.legend(*panels[0].get_legend_handles_labels(), loc="outside upper center", ncols=2)
    return fig


def times(stored: Evidence) -> Markup:
    """Set the times per configuration [µs] on all rungs, with their quartiles, after those of Table 5."""
    printed = 1e6 / verdicts.ON.printed("timing-inputs")
    columns = {}
    for index, side in product(INDICES, (EXACT, *NETWORKS)):
        claim = verdicts.TABLE_5.get((index, side))
        own = stored["ladder"].where(index=index, side=side)
        rungs = own.set_index(own["rung"].map(_RUNGS))[["median", "lower", "upper"]] * 1e6
        first = {"Table 5 of the paper": f"{printed * verdicts.ON.printed(claim):.3g}" if claim else "–"}
        columns[_head(index), side] = first | rungs.apply(_with_quartiles, axis="columns").to_dict()
    return show(pd.DataFrame(columns))


def agreement(stored: Evidence, live: Table) -> str:
    """Say how the speed-ups of a live run compare with the stored ones."""
    before, now = (advantages(quartiles(rows.where()))[list(NETWORKS)] for rows in (stored["ladder"], live))
    factor = (now / before).to_numpy()
    factor = np.maximum(factor, 1 / factor)
    same = ((before > 1) == (now > 1)).to_numpy()
    return (
        f"In the live run, {same.sum()} of {same.size} speed-ups are on the same side of 1 as the stored ones. They differ "
        f"from the stored ones by a factor of {np.median(factor):.2g} in the median and of {factor.max():.2g} at most."
    )


def heart() -> str:
    """Return the loop over the neurons in the C file of the network for w that comes with the package."""
    text = export.c_source(load_shipped("uvms-manipulability-feed-forward"), "w")
    begin = text.index("  for (int i = 0; i < W_NEURONS")
    return text[begin : text.index("\n  }\n", begin) + 4]


def compiled(stored: Evidence) -> Markup:
    """Set neurons, times and instructions of compiled C, for the exact indices and all networks."""
    counts = stored["instructions"].where().set_index(["index", "side"])
    counts["time"] = stored["ladder"].where(rung=FOOT).set_index(["index", "side"])["median"] * 1e6
    counts["instructions"] = counts["instructions"].map("{:,.0f}".format)
    counts["neurons"] = counts["neurons"].astype(object).where(counts["neurons"] > 0, "–")
    metrics = {"neurons": "neurons", "time": "time [µs]", "instructions": "instructions"}
    columns = {
        (_head(index), name): counts.xs(index)[metric].rename(_SIDES)
        for index in INDICES
        for metric, name in metrics.items()
    }
    return show(pd.DataFrame(columns).rename_axis(None), "{:.4f}")


def planner(stored: Evidence) -> Markup:
    """Set the time [ms] that a feed-forward network for w saves in a cycle of a planner."""
    saved = savings(quartiles(stored["ladder"].where()))["w"]
    of_way = {
        "times of the paper": verdicts.PRINTED_SAVING,
        "our times, as in the paper": saved[IN_KIND],
        "our times, C on both sides": saved[FOOT],
    }
    columns = {
        f"{count} configurations [ms]": 1e3 * count * pd.Series(of_way) for count in verdicts.SEVERAL_HUNDRED
    }
    return show(pd.DataFrame(columns), "{:.2g}")


def _with_quartiles(time: pd.Series) -> str:
    median, lower, upper = (written(time[name], "{:.3g}") for name in ("median", "lower", "upper"))
    return f"{median} ({lower}–{upper})"


def _head(index: str) -> str:
    return "$w$" if index == "w" else index
