"""Figures and tables of the chapter on the indices of the library."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure

from dexterity import indices
from dexterity.codegen.c_file import LANES
from dexterity.timing import Timing, ratio
from dexterity_study.beyond.indices.experiment import FORMS, ROBOTS
from dexterity_study.beyond.indices.footprint import bytes_of, files
from dexterity_study.beyond.indices.peer_packages import PINOCCHIO, TOOLBOX
from dexterity_study.engine.evidence import Evidence
from dexterity_study.page import figures
from dexterity_study.page.markup import Markup
from dexterity_study.page.tables import show

NAMES = {
    "reach_alpha5": "Alpha 5",
    "puma560": "PUMA",
    "ur5e": "UR5e",
    "oberon7": "Oberon 7",
    "panda": "Panda",
    "iiwa14": "iiwa 14",
    "bluerov2": "BlueROV2",
    "uvms": "paper A",
}
"""Robots as the page names them."""

INK = ("#111111", "#ffffff")
"""Colours of numbers on light and on dark cells, the same in both schemes of the page."""


def costs(stored: Evidence, what: str = "value") -> Figure:
    """Draw the time of compiled C per configuration for each index and robot, as numbers on colours."""
    medians = 1e9 * stored["times"].where(what=what).pivot_table("median", "index", "robot", sort=False)
    medians = medians.reindex(index=list(FORMS), columns=list(ROBOTS))
    fig, ax = plt.subplots(figsize=(figures.WIDTH, 5.2))
    scale = LogNorm(np.nanmin(medians), np.nanmax(medians))
    ax.imshow(medians, norm=scale, cmap="cividis_r", aspect="auto")
    for (i, j), value in np.ndenumerate(medians.to_numpy()):
        if not np.isnan(value):
            ax.text(j, i, f"{value:.0f}", ha="center", va="center", color=INK[int(scale(value) > 0.5)])
    ax.set_xticks(range(len(ROBOTS)), [NAMES[robot] for robot in ROBOTS], rotation=60, ha="right")
    ax.set_yticks(range(len(FORMS)), list(FORMS))
    ax.tick_params(length=0)
    ax.grid(visible=False)
    return fig


def dearest(times: pd.DataFrame) -> str:
    """Say which two indices take longest compared with w on the same robot, and what log w takes.

    Parameters
    ----------
    times
        Stored times [s], as the experiment yields them: robot, index, what is computed and the median.
    """
    medians = times[times["what"] == "value"].pivot_table("median", "index", "robot", sort=False)
    factors = (medians / medians.loc["w"]).median(axis="columns").sort_values(ascending=False)
    (first, second), logarithm = factors.index[:2], factors["log w"]
    return (
        f"A value takes {1e9 * np.nanmin(medians):.0f} to {1e9 * np.nanmax(medians):.0f} nanoseconds. Two indices cost the "
        f"most: {first} takes {factors[first]:.1f} times as long as w on the same robot, and {second} takes "
        f"{factors[second]:.1f} times as long (medians over the robots). For comparison, log w takes {logarithm:.1f} times "
        "as long as w."
    )


def measures() -> Markup:
    """List all measures: formula, bounds, which end is better, and what it needs besides the Jacobian."""
    rows = {}
    for name in indices.names():
        one = indices.describe(name)
        low, high = (f"{end:g}".replace("inf", "∞").replace("-", "−") for end in one.bounds)
        rows[one.title] = {
            "Range": f"{low} to {high}",
            "Better": "larger" if one.larger_is_better else "smaller",
            "Needs": ", ".join(one.needs) or "–",
            "Formula": f"${one.formula}$",
        }
    return show(pd.DataFrame.from_dict(rows, orient="index"))


def agreement(stored: Evidence) -> Markup:
    """List the largest deviations over all robots, of compiled code from autograd and of other packages."""
    compiled = stored["agreement"].where().groupby("index", sort=False)[["value", "gradient"]].max()
    peers = stored["peers"].where().pivot_table("deviation", "index", "package", aggfunc="max")
    columns = {
        "Value": compiled["value"],
        "Gradient": compiled["gradient"],
        "pinocchio": peers[PINOCCHIO],
        "roboticstoolbox": peers[TOOLBOX],
    }
    return show(pd.DataFrame(columns).reindex(list(FORMS)), "{:.0e}")


def ways(stored: Evidence) -> Markup:
    """List times of w and KCI of the twelve-joint system, and how many times faster each way is than a peer."""
    frame, columns = stored["ways"].where(), {}
    for index, own in frame.groupby("index", sort=False):
        timings = {row["way"]: Timing(*row[["way", *_FIELDS]]) for _, row in own.iterrows()}
        peer = timings["pinocchio and numpy, one by one"]
        columns[f"{index} [ns]"] = {way: 1e9 * one.median for way, one in timings.items()}
        columns[f"{index}, times faster"] = {
            way: 1.0 if one is peer else ratio(peer, one).value for way, one in timings.items()
        }
    return show(pd.DataFrame(columns), "{:,.3g}")


def memory(stored: Evidence) -> Markup:
    """List the growth of memory per configuration."""
    grown = stored["memory"].where().set_index("way")["bytes"].rename("byte per configuration")
    return show(grown.rename_axis(None), "{:.0f}")


def footprint() -> Markup:
    """List bytes of code, of written data and of stack, of files made and compiled here for this processor."""
    rows = {}
    for (name, double), (_, single) in zip(files("double"), files("float"), strict=True):
        (code, data, stack), (_, _, alone) = (bytes_of(double, lanes) for lanes in (LANES, 1))
        rows[name] = {
            "Code and constants": code,
            "Written data": data,
            "Stack": stack,
            "Stack, one at a time": alone,
            "Code, single precision": bytes_of(single, 1)[0],
        }
    return show(pd.DataFrame.from_dict(rows, orient="index"), "{:,.0f}")


_FIELDS = ("configurations", "lower", "median", "upper")
