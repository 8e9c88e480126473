"""Figures and tables of the chapter on a network for the area measure."""

from __future__ import annotations

import matplotlib.pyplot as plt
import pandas as pd
from matplotlib.figure import Figure

from dexterity.scenes.colors import COLORS
from dexterity.timing import Timing, ratio
from dexterity_study.docking.cases import ARMS
from dexterity_study.docking.stand_in.experiment import FIRST
from dexterity_study.engine.evidence import Evidence
from dexterity_study.engine.table import Table
from dexterity_study.page.markup import Markup
from dexterity_study.page.tables import over_seeds, show, with_range

SETS = {"all": "all poses", "high": "M_a above half of the largest", "gentle": "neither jump nor steep slope"}
KINDS = {"jump": "near a jump", "slope": "on a steep slope", "zero": "M_a is zero"}
QUANTILES = {"median": "median", "most": "99 %", "largest": "largest"}


def sizes(stored: Evidence, live: Table) -> Markup:
    """Set root mean square errors on the validation set by number of neurons."""
    runs = {f"{arm} arm": stored["networks"].where(reading) for arm, reading in ARMS.items()}
    rows = pd.concat({**runs, "stated arm, live": live.where()}, names=["arm"]).reset_index("arm")
    rows["error"] = 100 * rows["validation"]
    return show(over_seeds(rows, ["arm", "neurons"], {"error": "error [%]"}))


def ways(stored: Evidence, reading: str) -> pd.DataFrame:
    """Return what was judged, by way and seed: networks, then the exact measure over few points."""
    network, few = stored["networks"].where(reading), stored["exact"].where(reading)
    names = few["points"].map("{} points".format)
    rows = pd.concat([network.assign(way="network"), few.assign(way=names)], ignore_index=True)
    return rows.dropna(subset="needed")


def cuts(stored: Evidence) -> Figure:
    """Draw M_a along two lines through the best pose, exact and by networks of all seeds."""
    fig, panels = plt.subplots(2, 2, figsize=(6.8, 5.6), sharey="row")
    for row, (arm, reading) in zip(panels, ARMS.items(), strict=True):
        places, exact = (stored["exact"].array(name, reading)[0] for name in ("places", "cuts"))
        networks = stored["networks"].array("cuts", reading)
        for i, ax in enumerate(row):
            lines = ax.plot(places[i], networks[:, i].T, lw=0.8, color=COLORS["vermillion"])
            lines[0].set_label("networks, one for each seed")
            ax.plot(places[i], exact[1, i], lw=1.2, color=COLORS["sky blue"], label="exact, fewest points")
            ax.plot(places[i], exact[0, i], color=COLORS["black"], label="exact, all points")
            ax.set(title=f"{arm} arm")
        row[0].set(ylabel="$M_a$ [m³]")
    panels[1, 0].set(xlabel="distance from the middle [m]")
    panels[1, 1].set(xlabel="ψ [rad]")
    fig.legend(
        *panels[0, 0].get_legend_handles_labels(), fontsize="small", loc="outside upper center", ncols=3
    )
    return fig


def errors(stored: Evidence) -> Markup:
    """Set errors on fresh poses by arm, set of poses and way."""
    parts = {}
    for arm, reading in ARMS.items():
        rows, facts = ways(stored, reading), stored["exact"].where(reading).iloc[-1]
        for name, title in SETS.items():
            # What is gentle was asked for the sake of the network.
            chosen = rows if name != "gentle" else rows[rows["way"] == "network"]
            percent = chosen.assign(**{of: 100 * chosen[f"{name}_{of}"] for of in QUANTILES})
            part = over_seeds(percent, "way", QUANTILES)
            part.insert(0, "poses", f"{facts[f'poses_{name}']:,.0f}")
            if name == "all":
                part.loc["continuous"] = ["–", "–", "–", f"≥ {50 * facts['jump']:.3g}"]
            parts[f"{arm} arm", title] = part
    return show(pd.concat(parts))


def worst(stored: Evidence) -> Markup:
    """Set at what kinds of places all poses are, and those at which a network is off most."""
    parts = {}
    for arm, reading in ARMS.items():
        facts, network = stored["exact"].where(reading).iloc[-1], ways(stored, reading)
        parts[f"{arm} arm"] = pd.DataFrame(
            {
                title: [f"{100 * facts[f'share_{kind}']:.3g}", with_range(100 * network[f"worst_{kind}"])]
                for kind, title in KINDS.items()
            },
            index=["all poses", "the worst hundredth"],
        )
    return show(pd.concat(parts))


def times(stored: Evidence) -> Markup:
    """Set times to rate poses, and after how many poses a network has saved the time that its teaching took."""
    rows = {}
    for arm, reading in ARMS.items():
        own = {task: stored["times"].where(reading, task=task) for task in ("teach", "rate", "search")}
        pool, teaching = own["search"]["configurations"].max(), own["teach"]["median"].item()
        quartiles = own["rate"][["way", "configurations", "lower", "median", "upper"]]
        timings = [Timing(*one) for one in quartiles.itertuples(index=False)]
        for one in timings:
            slower = ratio(one, timings[0])
            pays = slower.distinguishable and slower.value > 1
            rows[f"{arm} arm", one.name] = {
                "median [μs]": f"{1e6 * one.median:.3g}",
                "quartiles [μs]": f"{1e6 * one.lower:.3g}–{1e6 * one.upper:.3g}",
                "over the network's": "1" if one is timings[0] else f"{slower}",
                "whole pool [ms]": f"{1e3 * one.median * pool:.3g}",
                "poses that pay for teaching": f"{teaching / (one.median - timings[0].median):,.0f}"
                if pays
                else "–",
            }
    return show(pd.DataFrame.from_dict(rows, orient="index"))


def rankings(stored: Evidence) -> Figure:
    """Draw the best exact value among the first poses of a ranking."""
    fig, panels = plt.subplots(1, 2, figsize=(6.8, 3.6), sharey=True)
    for ax, (arm, reading) in zip(panels, ARMS.items(), strict=True):
        colors = iter(("vermillion", "sky blue", "blue", "black"))
        for way, rows in ways(stored, reading).groupby("way", sort=False):
            kept, color = 100 * rows[[f"best_of_{count}" for count in FIRST]], COLORS[next(colors)]
            ax.plot(FIRST, kept.median(), "o-", ms=4, lw=1.5, color=color, label=way)
            ax.fill_between(FIRST, kept.min(), kept.max(), color=color, alpha=0.2)
        ax.set(xscale="log", title=f"{arm} arm", xlabel="poses looked at, k")
    panels[0].set(ylabel="best found [% of best]")
    panels[1].legend(fontsize="small")
    return fig


def searches(stored: Evidence) -> Markup:
    """Set what rankings of the pool are good for, and the times of searches by them."""
    parts = {}
    for arm, reading in ARMS.items():
        rows, times = ways(stored, reading), stored["times"].where(reading, task="search").set_index("way")
        best = {f"best_of_{count}": f"best of {count} [%]" for count in FIRST[::3]}
        part = over_seeds(rows.assign(**{name: 100 * rows[name] for name in best}), "way", best)
        looks = {"needed": "looked at, within 1 %", "proven": "looked at, proof"}
        part = part.join(over_seeds(rows, "way", looks, "{:,.0f}"))
        part["search [ms]"] = (1e3 * times["median"] * times["configurations"]).map("{:.3g}".format)
        parts[f"{arm} arm"] = part
    return show(pd.concat(parts))
