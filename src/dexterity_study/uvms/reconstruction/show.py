"""Figures and tables of the chapter on unprinted settings, from rows of its experiments."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from scipy.stats import kruskal

from dexterity_study.claims.design import CHANCE, levels
from dexterity_study.claims.ledger import load_paper
from dexterity_study.claims.scorecard import chapter_verdicts
from dexterity_study.engine.evidence import Evidence
from dexterity_study.page import figures
from dexterity_study.page.markup import Markup
from dexterity_study.page.numbers import with_range
from dexterity_study.page.tables import show
from dexterity_study.uvms.cost.verdicts import Counts
from dexterity_study.uvms.reconstruction.experiment import (
    ALONE,
    FACTORS,
    FIRST,
    NAMED,
    PRINTED,
    SPREAD,
    Level,
)
from dexterity_study.uvms.reconstruction.printed_results import (
    RESULTS,
    Rows,
    all_at_once,
    come_out,
    units_at_printed_spread,
)
from dexterity_study.uvms.unprinted import design, ends_of_growth, ends_of_loops, factors

WORDS: Mapping[str, str] = {
    "l1": "shoulder height [m]",
    "l2": "upper arm [m]",
    "vehicle_speed": "vehicle's rate [m/s]",
    "vehicle_rate": "vehicle's rate [rad/s]",
    "arm_rate": "arm's rate [rad/s]",
    "tool_speed": "tool's rate [m/s]",
    "frame": "Jacobian of KCI",
    "ahead": "task point ahead [m]",
    "azimuth": "half sector [deg]",
    "elevation": "out of plane [deg]",
    "vehicle_angle": "vehicle's angle [deg]",
    "rows_w": "rows for w",
    "rows_KCI": "rows for KCI",
    "test_points": "test points",
    "scaling": "inputs of sigmoids",
    "damping": "damping rule",
    "stopping": "trainings stop",
    "unit": "inputs of RBF units",
    "first_spread": "first spread",
}
"""Factors in the words of the page."""

QUANTITIES: Mapping[str, tuple[float, Callable[[Rows], pd.Series], str]] = {
    "w: sigmoids": (PRINTED["w"][0], lambda rows: ends_of_loops("w", rows), "{:.0f}"),
    "w: RBF units": (PRINTED["w"][1], lambda rows: ends_of_growth("w", rows=rows), "{:.0f}"),
    "KCI: sigmoids": (PRINTED["KCI"][0], lambda rows: ends_of_loops("KCI", rows), "{:.0f}"),
    "KCI: units at 8.9": (PRINTED["KCI"][1], units_at_printed_spread, "{:.0f}"),
    "KCI: spread": (SPREAD, lambda rows: ends_of_growth("KCI", "spread", rows), "{:.1f}"),
    "KCI: error of 25 [%]": (2, lambda rows: 100 * rows["KCI_ff_error"], "{:.1f}"),
}
"""What is compared with a printed number: the number, what a row gives, and its form."""


def shares_of_results() -> Figure:
    """Draw the share of readings in which each printed result comes out, and all of them."""
    rows = design()
    found = come_out(rows).mean().to_dict() | {"all nine at once": all_at_once(rows).share}
    fig, ax = plt.subplots(figsize=(figures.WIDTH, 3.9))
    places = np.arange(len(found))[::-1]
    ax.barh(places, [100 * share for share in found.values()], height=0.35)
    for place, (title, share) in zip(places, found.items(), strict=True):
        ax.text(0.5, place + 0.18, f"{title}: {share:.0%}", va="bottom")
    ax.set(xlim=(0, 100), ylim=(-0.5, len(found) - 0.1), yticks=[], xlabel="share of the readings [%]")
    ax.grid(visible=False, axis="y")
    return fig


def varied() -> Markup:
    """Set what is varied: the chosen value and the values that are drawn."""
    rows = {
        WORDS[factor.name]: {"chosen": _level(factor.chosen), "drawn": _drawn(factor.levels, factor.scale)}
        for factor in FACTORS
    }
    rows[WORDS["first_spread"]] = {"chosen": f"{FIRST[0]:g}", "drawn": ", ".join(f"{one:g}" for one in FIRST)}
    return show(pd.DataFrame.from_dict(rows, orient="index"))


def _drawn(levels: tuple[Level, ...], scale: str | None) -> str:
    if scale is None:
        return ", ".join(_level(level) for level in levels)
    low, high = min(map(float, levels)), max(map(float, levels))
    return f"{low:g} to {high:g}"


def _level(level: Level) -> str:
    return f"{level:g}" if isinstance(level, float) else level.replace("_", " ")


def one_at_a_time(stored: Evidence) -> Markup:
    """Set what each change of one factor makes of the printed numbers, medians over draws."""
    rows = stored["alone"].where().assign(first_spread=FIRST[0]).set_index(["change", "repetition"])
    stored_changes = set(rows.index.get_level_values("change"))
    order = [name for name, _ in ALONE if name in stored_changes]
    columns = {}
    for title, (_, values, form) in QUANTITIES.items():
        medians = values(rows).groupby(level="change").median().reindex(order)
        columns[title] = [_or_none(value, form) for value in medians]
    table = pd.DataFrame(columns, index=[_change(name) for name in order])
    printed = {title: form.format(value) for title, (value, _, form) in QUANTITIES.items()}
    return show(pd.concat([pd.DataFrame(printed, index=["printed"]), table]))


def _change(name: str) -> str:
    if "=" not in name:
        return name
    factor, _, level = name.partition("=")
    return f"{WORDS[factor]}: {level.replace('_', ' ')}"


def _or_none(value: float, form: str) -> str:
    return form.format(value) if math.isfinite(value) else "none"


def named(stored: Evidence) -> Markup:
    """Set the printed numbers beside those of the readings that matter, medians and ranges over seeds."""
    rows = stored["named"].where().assign(first_spread=FIRST[0])
    columns: dict[str, list[str]] = {
        "printed": [form.format(value) for value, _, form in QUANTITIES.values()]
    }
    for name in NAMED:
        own = rows[rows["case"] == name]
        columns[name] = [_range(values(own), form) for _, values, form in QUANTITIES.values()]
    return show(pd.DataFrame(columns, index=list(QUANTITIES)))


def _range(values: pd.Series, form: str) -> str:
    """Return median and range of the runs that end, and how many do not."""
    ended = values[np.isfinite(values)]
    if ended.empty:
        return "none"
    missing = len(values) - len(ended)
    return with_range(ended, form) + (f"; {missing} none" if missing else "")


def loops(stored: Evidence) -> Figure:
    """Draw the testing errors of both loops for KCI, step by step to their end, every seed a line."""
    rows = stored["loops"].where(index="KCI")
    fig, panels = plt.subplots(2, 1, figsize=(figures.WIDTH, 5.0))
    colors = plt.rcParams["axes.prop_cycle"].by_key()["color"]
    for ax, kind, over in zip(panels, ("feed-forward", "radial basis"), ("neurons", "spread"), strict=True):
        own = rows[rows["kind"] == kind]
        for color, (name, of_name) in zip(colors, own.groupby("case", sort=False), strict=False):
            for number, (_, run) in enumerate(of_name.groupby("seed")):
                label = name if number == 0 else None
                ax.plot(run[over], 100 * run["testing_error"], color=color, alpha=0.5, lw=1, label=label)
                if run["passes"].iloc[-1]:
                    ax.plot(run[over].iloc[-1], 100 * run["testing_error"].iloc[-1], "o", color=color, ms=5)
        ax.axhline(2, color="#595959", ls="--")
        ax.set(yscale="log", ylabel="testing error [%]", xlabel=f"{over} ({kind})")
        ax.set_yticks([2, 5, 10, 20], ["2", "5", "10", "20"])
        ax.minorticks_off()
    fig.legend(*panels[0].get_legend_handles_labels(), loc="outside upper center", ncols=3)
    return fig


def ends(stored: Evidence) -> Markup:
    """Set where both loops end: seeds in which they do, neurons, and spread."""
    rows = stored["loops"].where()
    last = rows.groupby(["index", "case", "kind", "seed"], sort=False).tail(1)
    found = {}
    for key, own in last.groupby(["index", "case", "kind"], sort=False):
        passed = own[own["passes"]]
        best = rows.set_index(["index", "case", "kind"]).loc[[key]].groupby("seed")["testing_error"].min()
        found[key] = {
            "ends": f"{len(passed)} of {len(own)}",
            "neurons": with_range(passed["neurons"], "{:.0f}") if len(passed) else "none",
            "spread": with_range(passed["spread"], "{:.1f}")
            if len(passed) and key[2] == "radial basis"
            else "",
            "smallest error [%]": with_range(100 * best, "{:.1f}"),
        }
    table = pd.DataFrame.from_dict(found, orient="index")
    table.index = pd.MultiIndex.from_tuples([(f"{i}, {c}", k) for i, c, k in found], names=[None, None])
    return show(table)


def what_decides() -> Figure:
    """Draw, for each printed result and each setting, how far the shares of its levels lie apart."""
    rows, limit = design(), CHANCE / len(WORDS)
    shares, matters = {}, {}
    for one in RESULTS:
        by_level = one.share(rows).by_factor().groupby(level="factor")
        shares[one.title] = 100 * (by_level["share"].max() - by_level["share"].min())
        matters[one.title] = by_level["chance"].first() < limit
    table, marks = pd.DataFrame(shares).loc[list(WORDS)], pd.DataFrame(matters).loc[list(WORDS)]
    fig, ax = plt.subplots(figsize=(figures.WIDTH, 7.5))
    mesh = ax.imshow(table.where(marks), aspect="auto", cmap="cividis", vmin=0, vmax=100)
    ax.set_facecolor("#D9D9D9")
    for row, column in np.argwhere(marks.to_numpy()):
        value = table.iloc[row, column]
        color = "white" if value < 60 else figures.ON_COLOR
        ax.text(column, row, f"{value:.0f}", ha="center", va="center", color=color)
    ax.set_xticks(range(len(RESULTS)), list(shares), rotation=60, ha="right", rotation_mode="anchor")
    ax.set_yticks(range(len(WORDS)), list(WORDS.values()))
    ax.grid(visible=False)
    fig.colorbar(mesh, ax=ax, location="top", label="largest minus smallest share [%]")
    return fig


def closest(count: int = 5) -> Markup:
    """Set the readings that bear out most printed results."""
    met, settings = come_out(design()).sum(axis=1), factors().to_dict("index")
    best = met.sort_values(ascending=False, kind="stable").head(count)
    columns = {
        f"reading {number}: {results} of {len(RESULTS)}": [_value(settings[number][name]) for name in WORDS]
        for number, results in best.items()
    }
    return show(pd.DataFrame(columns, index=list(WORDS.values())))


def _value(value: object) -> str:
    return f"{value:.3g}" if isinstance(value, float) else str(value).replace("_", " ")


def most_probable() -> Markup:
    """Set how many printed results readings bear out on average, by level of the settings that matter for it."""
    met, settings = come_out(design()).sum(axis=1), factors()
    found = []
    for name in WORDS:
        level = levels(settings[name])
        groups = [own for _, own in met.groupby(level)]
        # Where all readings bear out equally many there is nothing to compare.
        chance = kruskal(*groups).pvalue if len(groups) > 1 and met.min() < met.max() else 1.0
        if chance < CHANCE / len(WORDS):
            found.append((chance, WORDS[name], met.groupby(level).mean()))
    found.sort(key=lambda one: one[0])
    if not found:
        found = [(1.0, "no setting matters beyond chance", met.groupby(lambda _: "all readings").mean())]
    rows = {(title, level): mean for _, title, means in found for level, mean in means.items()}
    return show(pd.Series(rows, name="results that come out", dtype=float), "{:.1f}")


def finding() -> str:
    """Say in how many readings everything comes out, and what never does."""
    rows = design()
    every, shares = all_at_once(rows).count, come_out(rows)
    never = "; ".join(shares.columns[~shares.any()])
    seldom = "; ".join(shares.columns[shares.any() & (shares.mean() < _SELDOM)])
    parts = (
        f"Of {len(shares)} readings, {every or 'none'} {'bears' if every < 2 else 'bear'} out all {len(RESULTS)} results "
        f"at once. The best bears out {shares.sum(axis=1).max()}.",
        f"No reading explains: {never}." if never else "",
        f"Fewer than one reading in twenty explains: {seldom}." if seldom else "",
    )
    return " ".join(filter(None, parts))


_SELDOM = 0.05


def two_sizes(stored: Evidence) -> str:
    """Say at which sizes two loops end when one setting is changed."""
    kci, w = (
        stored["loops"].where(index=index, case=case, kind=kind).query("passes")["neurons"]
        for index, case, kind in (
            ("KCI", "fast tool", "feed-forward"),
            ("w", "high shoulder", "radial basis"),
        )
    )
    tool, shoulder = NAMED["fast tool"]["tool_speed"], NAMED["high shoulder"]["l1"]
    return (
        f"Single changes bring out two printed sizes. With a tool of {tool:g} m/s, and nothing else changed, the "
        f"feed-forward loop for KCI ends at {with_range(kci, '{:.0f}')} neurons in {len(kci)} runs; the paper has "
        f"{PRINTED['KCI'][0]}. With a shoulder {shoulder:g} m above the base, the radial-basis loop for *w* ends at "
        f"{with_range(w, '{:.0f}')} in {len(w)}; the paper has {PRINTED['w'][1]}. Both values were chosen because they fit the "
        "radial-basis networks. The sizes of feed-forward networks were not fitted."
    )


def height_by_operations() -> str:
    """Say what the printed count of operations tells about the height of the shoulder."""
    counts = Counts(Evidence("uvms.cost"))
    printed = load_paper("sotiropoulos2016").printed("jacobian-operations")
    raised, flat = (counts("Jacobian", f"written out{height}") for height in ("", ", l1 = 0"))
    closer = "a raised shoulder" if abs(raised - printed) < abs(flat - printed) else "the height of the base"
    return (
        f"One printed number takes no network: the Jacobian has {printed:,.0f} operations in the paper. We count {raised:,} with a "
        f"shoulder above the base ({raised / printed - 1:+.1%}), and {flat:,} with one at its height ({flat / printed - 1:+.1%}). "
        f"This speaks for {closer}."
    )


def claims_in_the_design() -> Markup:
    """Set the claims that are judged in the design, and in which share of the readings each holds."""
    paper = load_paper("sotiropoulos2016")
    rows = {
        paper.claim(verdict.claim).says: {"holds": verdict.design}
        for chapter in ("uvms.feed_forward", "uvms.radial_basis", "uvms.choice")
        for verdict in chapter_verdicts(chapter)
        if verdict.design
    }
    return show(pd.DataFrame.from_dict(rows, orient="index"))
