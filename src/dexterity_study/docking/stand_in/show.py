"""Figures and tables of the chapter on a network for the area measure."""

from __future__ import annotations

import matplotlib.pyplot as plt
import pandas as pd
import torch
from matplotlib.figure import Figure

from dexterity import robots
from dexterity.timing import Timing, ratio
from dexterity_study.docking.area.show import ARM_COLORS, by_arm
from dexterity_study.docking.cases import ARMS
from dexterity_study.docking.stand_in.experiment import FIRST, Rating, rated
from dexterity_study.engine.evidence import Evidence
from dexterity_study.page import figures
from dexterity_study.page.markup import Markup
from dexterity_study.page.tables import over_seeds, show

_IN_WORDS = {arm: f"{arm} arm" for arm in ARMS}


def errors_and_times(stored: Evidence) -> Figure:
    """Draw the error of 99 % of the good poses against the time per pose, for each way and both arms."""
    fig, ax = plt.subplots(figsize=(figures.WIDTH, 3.6))
    ways = by_arm(stored["ways"])
    for arm, reading in ARMS.items():
        times = 1e6 * stored["times"].where(reading).set_index("name")["median"]
        errors = 100 * ways[ways["arm"] == arm].groupby("way", sort=False)["high_most"].median()
        exact, color = errors.drop("network"), ARM_COLORS[arm]
        ax.plot(times[exact.index], exact, "o-", color=color, label=f"exact measure, {arm} arm")
        ax.plot(times["network"], errors["network"], "*", ms=14, color=color, label=f"network, {arm} arm")
        if arm == "stated":
            for way, time, error in zip(exact.index, times[exact.index], exact, strict=True):
                ax.annotate(
                    way,
                    (time, error),
                    xytext=(-6, -4),
                    textcoords="offset points",
                    ha="right",
                    va="top",
                )
    ax.set(xscale="log", ylim=(-4, 42), xlim=(0.6, 12), yticks=range(0, 41, 10))
    ax.set_xticks([1, 2, 5, 10], ["1", "2", "5", "10"])
    ax.minorticks_off()
    ax.set(xlabel="time per pose [μs]", ylabel="99th percentile\nof the error [%]")
    fig.legend(loc="outside upper center", ncols=1)
    return fig


def cuts(network: Rating) -> Figure:
    """Draw the measure of the stated arm by a network and exactly, along two lines of poses."""
    lines = {
        "x of the base [m], at y = 0.15 m and ψ = 0": (0, (-0.454, -0.2), (0.0, 0.15, 0.2, 0.0)),
        "ψ [rad], at x = −0.5 m and y = 0": (3, (-torch.pi, torch.pi), (-0.5, 0.0, 0.2, 0.0)),
    }
    arm = robots.docking_arm()
    fig, panels = plt.subplots(2, 1, figsize=(figures.WIDTH, 4.6))
    for ax, (label, (variable, ends, pose)) in zip(panels, lines.items(), strict=True):
        poses = torch.tensor(pose, dtype=torch.float64).repeat(801, 1)
        poses[:, variable] = torch.linspace(*ends, 801, dtype=torch.float64)
        ax.plot(poses[:, variable], network(poses), label="network")
        ax.plot(poses[:, variable], rated(arm, 3, poses), "--", label="9 points")
        ax.plot(poses[:, variable], rated(arm, 21, poses), color="#595959", label="441 points", zorder=1)
        ax.set(xlabel=label, ylabel="$M_a$ [m³]")
    fig.legend(*panels[0].get_legend_handles_labels(), loc="outside upper center", ncols=3)
    return fig


def errors(stored: Evidence) -> Markup:
    """Set errors on all poses, and on those where M_a is above half of the largest, by arm and way."""
    rows, of = by_arm(stored["ways"]), {"median": "median", "most": "99 %", "largest": "largest"}
    groups = {"all": "all poses [%]", "high": "good poses [%]"}
    heads = {f"{name}_{size}": (group, title) for name, group in groups.items() for size, title in of.items()}
    rows[[*heads]] *= 100
    table = over_seeds(rows, ["arm", "way"], {name: name for name in heads}, "{:.1f}")
    table.columns = pd.MultiIndex.from_tuples(heads.values())
    return show(table.rename(_IN_WORDS, level="arm").rename_axis(["arm", "method"]))


def times(stored: Evidence) -> Markup:
    """Set times of the exact measure relative to a network's, and the poses after which training has paid off."""
    columns: dict[tuple[str, str], pd.Series] = {}
    for arm, reading in ARMS.items():
        timed = stored["times"].where(reading)[["name", "configurations", "lower", "median", "upper"]]
        training, network, *others = (Timing(*one) for one in timed.itertuples(index=False))
        ratios = {one.name: ratio(one, network) for one in others}
        saved = {one.name: one.median - network.median for one in others}
        columns[f"{arm} arm", "time, relative to the network"] = pd.Series(ratios).map(str)
        columns[f"{arm} arm", "poses that pay for the training [thousands]"] = pd.Series(
            {
                name: training.median / saved[name] / 1e3 if of.distinguishable and saved[name] > 0 else None
                for name, of in ratios.items()
            },
            dtype=float,
        )
    table = pd.DataFrame(columns).rename(lambda name: name.removesuffix(" points"))
    return show(table.rename_axis("control points"), "{:,.0f}")


def searches(stored: Evidence) -> Markup:
    """Set what rankings of the pool are good for."""
    rows = by_arm(stored["ways"])
    best = {f"best_of_{count}": f"best of {count} [%]" for count in FIRST[:3]}
    rows[[*best]] *= 100
    looks = {"needed": "poses to come within 1 %", "proven": "poses to prove the best"}
    by = ["arm", "way"]
    table = over_seeds(rows, by, best, "{:.0f}").join(over_seeds(rows, by, looks, "{:,.0f}"))
    return show(table.rename(_IN_WORDS, level="arm").rename_axis(["arm", "ranked by"]))
