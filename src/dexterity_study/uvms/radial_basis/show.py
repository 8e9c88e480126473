"""Figures and tables of the chapter on radial-basis networks, from rows of its experiments."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from dexterity.networks.radial_basis_design import RadialBasisDesign
from dexterity_study.claims.ledger import load_paper
from dexterity_study.engine.evidence import Evidence
from dexterity_study.engine.table import Table
from dexterity_study.page.markup import Markup
from dexterity_study.page.tables import over_seeds, show, with_range
from dexterity_study.uvms.radial_basis.experiment import INDICES, LEVELS
from dexterity_study.uvms.radial_basis.verdicts import growth_of, needed_by_both

LIMITS = {"w": "radial-basis-w-error", "KCI": "radial-basis-kci-error"}


def design(design: RadialBasisDesign) -> Markup:
    """Set the growths of one design loop."""
    rows = [(one.spread, one.neurons, one.testing_errors[-1], one.stop.value) for one in design.growths]
    return show(pd.DataFrame(rows, columns=["spread", "neurons", "testing error", "growth ended because"]))


def error_by_spread(stored: Evidence, live: Table) -> Figure:
    """Draw the smallest testing error against the spread, Figs. 8 and 12 of the paper."""
    fig, panels = plt.subplots(1, 2, figsize=(6.8, 3.5))
    paper = load_paper("sotiropoulos2016")
    for ax, index in zip(panels, INDICES, strict=True):
        errors = 100 * stored["growth"].by_seed("smallest", over="spread", index=index)
        ax.plot(errors.columns, errors.T, "-", color="C0", lw=0.8, alpha=0.4)
        ax.plot(errors.columns, errors.median(), "o-", label="median")
        if index in set(live.rows["index"]):
            own = live.where(index=index)
            ax.plot(own["spread"], 100 * own["smallest"], "C1x", label="live, first seed")
        ax.axhline(100 * paper.printed(LIMITS[index]), color="k", ls=":", label="E of the paper")
        ax.set(xscale="log", title=index, xlabel="spread [rad, m]")
    spread = paper.printed("radial-basis-kci-spread")
    line = panels[1].axvline(spread, color="C3", ls="--", label="spread of the paper")
    panels[0].set(yscale="log", ylabel="smallest testing error [%]")
    panels[0].yaxis.set_major_formatter("{x:g}")
    panels[0].legend(fontsize="small", loc="lower left")
    panels[1].set(ylim=(0, None))
    panels[1].legend(handles=[line], fontsize="small", loc="lower left")
    return fig


def needed(stored: Evidence) -> Markup:
    """Set the fewest neurons for w to some testing errors, by spread."""
    groups = growth_of(stored, "w").groupby("spread")
    columns = {f"{100 * level:g} %": groups[f"needed_{level:g}"].apply(_reached) for level in LEVELS}
    return show(pd.DataFrame(columns).rename(index="{:g}".format))


def by_spread(stored: Evidence, index: str) -> Markup:
    """Set medians over the seeds of the networks grown to the neuron limit, by spread."""
    medians = growth_of(stored, index).groupby("spread").median(numeric_only=True)
    forms = {
        "smallest": ("smallest testing error", "{:.2%}"),
        "fresh": ("error on fresh points", "{:.2%}"),
        "active": ("neurons that answer a half", "{:.0%}"),
        "condition": ("condition", "{:.0e}"),
        "weight": ("largest weight", "{:.0e}"),
    }
    columns = {title: medians[name].map(form.format) for name, (title, form) in forms.items()}
    return show(pd.DataFrame(columns).rename(index="{:g}".format))


def growth(stored: Evidence) -> Figure:
    """Draw errors against the number of neurons, Figs. 9 and 13 of the paper."""
    fig, panels = plt.subplots(2, 2, figsize=(6.8, 5.4), sharex="col")
    paper = load_paper("sotiropoulos2016")
    goals = paper.printed("radial-basis-training-error-goals")
    for (upper, lower), goal, index in zip(panels.T, goals, INDICES, strict=True):
        medians = growth_of(stored, index).groupby("spread")["smallest"].median()
        best = int(medians.to_numpy().argmin())
        sizes = stored["growth"].array(f"{index}_sizes")[0]
        upper.plot(sizes, stored["growth"].array(f"{index}_mse")[:, best].T, color="C0", alpha=0.5)
        upper.axhline(goal, color="C3", ls="--")
        lower.plot(sizes, 100 * stored["growth"].array(f"{index}_error")[:, best].T, color="C0", alpha=0.5)
        lower.axhline(100 * paper.printed(LIMITS[index]), color="k", ls=":")
        upper.set(xscale="log", yscale="log", title=f"{index}, spread {medians.index[best]:g}")
        lower.set(yscale="log", xlabel="neurons")
        lower.yaxis.set_major_formatter("{x:g}")
        lower.yaxis.set_minor_formatter("")
    panels[1, 0].axvline(paper.printed("radial-basis-w-neurons"), color="C3", ls="--")
    long = stored["lifted_limit"].where()
    panels[1, 1].plot(long["neurons"], 100 * long["testing_error"], color="C1")
    panels[0, 0].set(ylabel="mean square error")
    panels[1, 0].set(ylabel="testing error [%]")
    return fig


def loops(stored: Evidence) -> Markup:
    """Set where the printed loop for w ends, for each reading."""
    rows = stored["loop"].where(None).groupby("reading", sort=False)
    columns = {
        "passes": rows["success"].apply(lambda own: f"{int(own.sum())} of {len(own)}"),
        "spread": rows["spread"].apply(with_range, form="{:g}"),
        "neurons": rows["neurons"].apply(with_range, form="{:g}"),
        "testing error": rows["testing_error"].apply(with_range, form="{:.2%}"),
        "on fresh points": rows["fresh"].apply(with_range, form="{:.2%}"),
    }
    return show(pd.DataFrame(columns).rename(index={"chosen": "as printed, chosen reading"}))


def pruning_curves(stored: Evidence) -> Figure:
    """Draw the testing error for w against neurons, growing and pruned."""
    fig, ax = plt.subplots()
    grown, pruned = stored["growth"], stored["pruned_growth"]
    spreads = growth_of(stored, "w")["spread"].unique().tolist()
    for color, spread in enumerate(pruned.where(index="w")["spread"]):
        errors = grown.array("w_error")[0, spreads.index(spread)]
        ax.plot(grown.array("w_sizes")[0], 100 * errors, f"C{color}--", lw=1)
        ax.plot(
            pruned.array("w_sizes")[0],
            100 * pruned.array("w_error")[0, color],
            f"C{color}-",
            label=f"spread {spread:g}",
        )
    ax.axhline(
        100 * load_paper("sotiropoulos2016").printed(LIMITS["w"]), color="k", ls=":", label="E of the paper"
    )
    ax.set(xscale="log", yscale="log", xlabel="neurons", ylabel="testing error [%]")
    ax.yaxis.set_major_formatter("{x:g}")
    ax.legend(fontsize="small")
    return fig


def pruning(stored: Evidence) -> Markup:
    """Set networks that passed, before and after pruning."""
    loop = stored["pruned_loop"].where().assign(network="w, the printed loop")
    grown = stored["pruned_growth"].where()
    grown["network"] = [
        f"{index}, grown at spread {spread:g}"
        for index, spread in zip(grown["index"], grown["spread"], strict=True)
    ]
    rows = pd.concat([loop, grown])
    rows = rows[rows["passes"]]
    counts = over_seeds(rows, "network", {"before": "neurons", "after": "pruned"}, "{:g}")
    errors = over_seeds(
        rows,
        "network",
        {"fresh_before": "on fresh points", "fresh_after": "pruned, on fresh points"},
        "{:.2%}",
    )
    return show(counts.join(errors))


def comparison(stored: Evidence) -> Markup:
    """Set the fewest neurons of both kinds of networks for w, and their errors for KCI."""
    rows = {
        f"w, neurons to {100 * level:g} %": [with_range(own, "{:g}"), with_range(other, "{:g}")]
        for level, (own, other) in needed_by_both(stored).items()
    }
    radial = growth_of(stored, "KCI").groupby("seed")["smallest"].min()
    trained = stored["feed_forward"].where(index="KCI")
    rows["KCI, testing error"] = [
        with_range(radial, "{:.1%}"),
        with_range(trained["testing_error"], "{:.1%}"),
    ]
    return show(pd.DataFrame.from_dict(rows, orient="index", columns=["radial basis", "feed-forward"]))


def input_spaces(stored: Evidence) -> Markup:
    """Set the fewest neurons for w to a testing error of 1 %, by range and by number of joints."""
    rows = stored["input_spaces"].where().groupby(["joints", "half_range_deg"])["neurons"].apply(_reached)
    return show(rows.rename_axis(["joints", "range [±°]"]).rename("neurons"))


def _reached(counts: pd.Series) -> str:
    """Write counts over seeds, of which 0 stands for none."""
    reached = counts[counts > 0]
    if reached.empty:
        return "none"
    part = f" ({len(reached)} of {len(counts)} seeds)" if len(reached) < len(counts) else ""
    return with_range(np.asarray(reached), "{:g}") + part
