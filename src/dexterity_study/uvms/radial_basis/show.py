"""Figures and tables of the chapter on radial-basis networks, from rows of its experiments."""

from __future__ import annotations

import matplotlib.pyplot as plt
import pandas as pd
from matplotlib.figure import Figure

from dexterity.networks.radial_basis_design import RadialBasisDesign
from dexterity_study.claims.ledger import load_paper
from dexterity_study.engine.evidence import Evidence
from dexterity_study.engine.table import Table
from dexterity_study.page.markup import Markup
from dexterity_study.page.numbers import with_range
from dexterity_study.page.tables import over_seeds, show
from dexterity_study.uvms.feed_forward.experiment import INDICES
from dexterity_study.uvms.radial_basis.experiment import LEVELS
from dexterity_study.uvms.radial_basis.verdicts import growth_of, needed_by_both


def design(design: RadialBasisDesign) -> Markup:
    """Set the growths of one design loop."""
    rows = [(one.spread, one.neurons, one.testing_errors[-1], one.stop.value) for one in design.growths]
    return show(pd.DataFrame(rows, columns=["spread", "neurons", "testing error", "growth ended because"]))


def error_by_spread(stored: Evidence, live: Table) -> Figure:
    """Draw the smallest testing error against the spread, Figs. 8 and 12 of the paper; the live run is for w."""
    fig, panels = plt.subplots(1, 2, figsize=(6.8, 3.5))
    paper = load_paper("sotiropoulos2016")
    for ax, index in zip(panels, INDICES, strict=True):
        errors = 100 * stored["growth"].by_seed("smallest", over="spread", index=index)
        ax.plot(errors.columns, errors.T, "-", color="C0", lw=0.8, alpha=0.4)
        ax.plot(errors.columns, errors.median(), "o-", label="median")
        limit = paper.printed(f"radial-basis-{index.lower()}-error")
        ax.axhline(100 * limit, color="k", ls=":", label="E of the paper")
        ax.set(xscale="log", title=index, xlabel="spread [rad, m]")
    panels[0].plot(live.rows["spread"], 100 * live.rows["smallest"], "C1x", label="live, first seed")
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
    paper, grown = load_paper("sotiropoulos2016"), stored["growth"]
    goals = paper.printed("radial-basis-training-error-goals")
    for (upper, lower), goal, index in zip(panels.T, goals, INDICES, strict=True):
        medians = growth_of(stored, index).groupby("spread")["smallest"].median()
        best, sizes = int(medians.to_numpy().argmin()), grown.array(f"{index}_sizes")[0]
        upper.plot(sizes, grown.array(f"{index}_mse")[:, best].T, color="C0", alpha=0.5)
        upper.axhline(goal, color="C3", ls="--")
        lower.plot(sizes, 100 * grown.array(f"{index}_error")[:, best].T, color="C0", alpha=0.5)
        lower.axhline(100 * paper.printed(f"radial-basis-{index.lower()}-error"), color="k", ls=":")
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
    rows = stored["loop"].where(None)
    success = rows.groupby("reading", sort=False)["success"]
    passes = success.apply(lambda own: f"{own.sum()} of {len(own)}").to_frame("passes")
    sizes = over_seeds(rows, "reading", {"spread": "spread", "neurons": "neurons"}, "{:g}")
    metrics = {"testing_error": "testing error", "fresh": "on fresh points"}
    table = passes.join([sizes, over_seeds(rows, "reading", metrics, "{:.2%}")])
    return show(table.rename(index={"chosen": "as printed, chosen reading"}))


def comparison(stored: Evidence) -> Markup:
    """Set the fewest neurons of both kinds of networks for w, by testing error."""
    pairs = needed_by_both(stored)
    rows = {f"{100 * level:g} %": [with_range(own, "{:g}") for own in pair] for level, pair in pairs.items()}
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
    return with_range(reached, "{:g}") + part
