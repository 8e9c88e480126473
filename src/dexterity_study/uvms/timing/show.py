"""Figures and tables of the chapter on the timing ladder."""

from __future__ import annotations

from collections.abc import Mapping
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
from dexterity_study.uvms.timing.experiment import (
    EXACT,
    FEED_FORWARD,
    FOOT,
    IN_KIND,
    OCTAVE_IN_KIND,
    RADIAL_BASIS,
    SINGLY,
)
from dexterity_study.uvms.timing.verdicts import NETWORKS, Times, advantages, measured, quartiles, savings

_RUNGS = {
    IN_KIND: "numpy, as in the paper",
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

_DRAWN = [
    SINGLY,
    "numpy, a test set at once",
    "C from C, one by one",
    "C, a test set at once",
    FOOT,
]
"""Rungs of the picture below those in Octave: one language, with equal batches on both sides."""

_OCTAVE = {
    OCTAVE_IN_KIND: "Octave, as in the paper",
    "Octave, simulated one by one": "networks called one by one",
    "Octave, one by one": "networks without checks",
    "Octave, one by one, terms shared": "terms shared",
    "Octave, one by one, closed form": "closed form of $w$",
    "Octave, a test set at once": "Octave, 1,000 at once",
}
"""Names of the rungs in Octave; each keeps what the rung above it changed."""

_ALOUD = {
    OCTAVE_IN_KIND: "The same pair of programs in Octave, which interprets each operation",
    "Octave, simulated one by one": "One call per configuration on the network's side too, with the checks of a toolbox",
    "Octave, one by one": "The network as matrix operations alone, without checks",
    "Octave, one by one, terms shared": "Each repeated term of the Jacobian computed once",
    "Octave, one by one, closed form": "The closed form of *w* in place of Jacobian and LU",
    "Octave, a test set at once": "All 1,000 configurations in one call on both sides",
    "numpy, a test set at once": "The same in Python, with the Jacobian and LU again",
    "C, a test set at once": "Compiled C with the closed form",
    FOOT: "Batches of 100,000, so that a call costs next to nothing",
}
"""What each rung changes, in the order in which the ladder is read."""

_SIDES = {
    EXACT: "exact index",
    FEED_FORWARD: "feed-forward, printed size",
    RADIAL_BASIS: "radial-basis, printed size",
    f"shipped {FEED_FORWARD}": "feed-forward of the package",
    f"shipped {RADIAL_BASIS}": "radial-basis of the package",
}


def in_short(stored: Evidence) -> str:
    """Say by how much both kinds of networks are faster or slower, at the top of the ladder and at its foot."""
    times = measured(stored)
    top, foot = (_compared(times, ("w", rung)) for rung in (OCTAVE_IN_KIND, FOOT))
    kci = _compared(times, ("KCI", FOOT))
    return (
        f"In the paper's own language, run as the paper ran it, the feed-forward network for *w* is {top[FEED_FORWARD]} than the "
        f"exact index. In C with equal batches it is {foot[FEED_FORWARD]} for *w* and {kci[FEED_FORWARD]} for KCI; the radial-basis "
        f"network is {foot[RADIAL_BASIS]} and {kci[RADIAL_BASIS]}."
    )


def speed_up(stored: Evidence) -> Figure:
    """Draw how many times faster than the exact index both kinds of networks are, rung by rung."""
    fig, panels = plt.subplots(2, 1, figsize=(figures.WIDTH, 6.2), sharex=True)
    times, drawn = measured(stored), [*_OCTAVE, *_DRAWN]
    for ax, index in zip(panels, INDICES, strict=True):
        median, lower, upper = (
            times[name].xs(index).filter(drawn, axis="index") for name in ("median", "lower", "upper")
        )
        for kind, marker, color in zip(NETWORKS, "os", ("blue", "vermillion"), strict=True):
            factor = median[EXACT] / median[kind]
            ends = factor - lower[EXACT] / upper[kind], upper[EXACT] / lower[kind] - factor
            names = factor.index.map(_OCTAVE | _RUNGS)
            look = {"ms": 6, "color": COLORS[color], "linestyle": "none"}
            ax.errorbar(factor, names, xerr=np.array(ends), marker=marker, capsize=4, label=kind, **look)
            # The times of the networks in Table 5 are read as those for w.
            if index == "w":
                printed = [verdicts.PRINTED_RATIOS[kind]], [_OCTAVE[OCTAVE_IN_KIND]]
                ax.plot(*printed, "D", fillstyle="none", mew=2, label=f"{kind}, paper", **{**look, "ms": 10})
        ax.axvline(1, color="#595959", lw=1.5)
        ax.set(xscale="log", title=_head(index))
        ax.set_xticks([0.1, 1, 10, 100, 1e3, 1e4, 1e5], labels=["0.1", "1", "10", "10²", "10³", "10⁴", "10⁵"])
        ax.invert_yaxis()
    panels[1].set(xlabel="exact time / network time")
    fig.legend(*panels[0].get_legend_handles_labels(), loc="outside upper center", ncols=2)
    return fig


def aloud(stored: Evidence) -> str:
    """Read the ladder for w aloud: what each rung changes, the times for 1,000 configurations, and the ratio."""
    times = measured(stored)
    printed = {side: verdicts.ON.printed(verdicts.TABLE_5["w", side]) for side in (EXACT, *NETWORKS)}
    words = {side: f"{printed[EXACT] / printed[side]:,.0f} times faster" for side in NETWORKS}
    lines = [_sentence("MATLAB, as the paper prints it", printed, words)]
    for rung, change in _ALOUD.items():
        taken = 1000 * times["median"].T["w", rung]
        lines.append(_sentence(change, taken, _compared(times, ("w", rung))))
    return "\n".join(f"{number}. {line}" for number, line in enumerate(lines, 1))


def _sentence(change: str, taken: Mapping[str, float] | pd.Series, words: Mapping[str, str]) -> str:
    return (
        f"**{change}**: {_duration(taken[EXACT])} for the exact index and {_duration(taken[FEED_FORWARD])} for the feed-forward "
        f"network, which is {words[FEED_FORWARD]}; the radial-basis network is {words[RADIAL_BASIS]}."
    )


def _compared(times: Times, place: tuple[str, str]) -> dict[str, str]:
    """Return how the networks compare with the exact index in one place, in words."""
    lower, median, upper = (times[name].T[place] for name in ("lower", "median", "upper"))
    words = {}
    for side in NETWORKS:
        factor = median[EXACT] / median[side]
        if lower[EXACT] <= upper[side] and lower[side] <= upper[EXACT]:
            words[side] = "equally fast within the quartiles"
        elif factor > 1:
            words[side] = f"{_two_digits(factor)} times faster"
        else:
            words[side] = f"{_two_digits(1 / factor)} times slower"
    return words


def _two_digits(value: float) -> str:
    return f"{float(f'{value:.2g}'):,.10g}"


def _duration(seconds: float) -> str:
    for unit, size in (("s", 1.0), ("ms", 1e-3)):
        if seconds >= size:
            return f"{_two_digits(seconds / size)} {unit}"
    return f"{_two_digits(seconds / 1e-6)} µs"


def octave(stored: Evidence) -> Markup:
    """Set the mean times per configuration [µs] in Octave, rung by rung."""
    rows = stored["in_octave"].where()
    rows["mean"] *= 1e6
    columns = {
        (_head(str(index)), side): own.set_index(own["rung"].map(_OCTAVE))["mean"].map(_two_digits)
        for (index, side), own in rows.groupby(["index", "side"], sort=False)
    }
    return show(pd.DataFrame(columns).reindex(list(_OCTAVE.values())).fillna("–").rename_axis(None))


def means(stored: Evidence) -> str:
    """Say how many runs the means in Octave have, and how far they are from steady."""
    rows = stored["in_octave"].where()
    error = rows["error"] / rows["mean"]
    long = rows["way"] == "exact_written"
    printed = verdicts.ON.printed("timing-runs")
    return (
        f"Each mean is over {rows['runs'].max()} runs of {rows['configurations'].max():,} configurations, and over {rows['runs'][long].min()} runs for the "
        f"Jacobian written out, because 1,000 configurations take it {_duration(1000 * rows['mean'][long].max())}; the paper has "
        f"{printed:.0f} runs of {verdicts.ON.printed('timing-inputs'):,.0f}. "
        f"The standard error of a mean is {100 * error[long].max():.2g} % at most for the Jacobian written out, and "
        f"{100 * error[~long].median():.2g} % in the median for all other programs. All programs in Octave agree with the package "
        f"to a relative deviation of {written(rows['deviation'].max(), '{:.0e}')}."
    )


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


def instructions(stored: Evidence) -> str:
    """Say how many instructions the printed and the accurate networks need beside the exact indices."""
    counts = stored["instructions"].where().pivot(index="index", columns="side", values="instructions")
    share = counts.div(counts[EXACT], axis="index")
    printed, accurate = share[FEED_FORWARD], share[f"shipped {FEED_FORWARD}"]
    return (
        f"The instructions confirm the times. The printed feed-forward network needs {printed['w']:.0%} (w) and "
        f"{printed['KCI']:.0%} (KCI) of the instructions of the exact index, and the accurate network for KCI {accurate['KCI']:.0%}."
    )


def planner(stored: Evidence) -> Markup:
    """Set the time [ms] that a feed-forward network for w saves in a cycle of a planner."""
    saved = savings(measured(stored))["w"]
    of_way = {
        "times of the paper": verdicts.PRINTED_SAVING,
        "Octave, as in the paper": saved[OCTAVE_IN_KIND],
        "numpy, as in the paper": saved[IN_KIND],
        "C on both sides": saved[FOOT],
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
