"""Figures and tables of the chapter on training and sizes."""

from __future__ import annotations

import math

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from dexterity_study.claims.ledger import load_paper
from dexterity_study.crane.training.experiment import ALL, NETWORKS, ONE, SECOND_ORDER, WAYS
from dexterity_study.crane.training.verdicts import by_size, history, left, memory, picked
from dexterity_study.engine.evidence import Evidence
from dexterity_study.engine.table import Table
from dexterity_study.page.markup import Markup
from dexterity_study.page.tables import over_seeds, show, with_range

LOOKS = {"training": "training data", "test": "test points", "fresh": "fresh points"}
LOOKS["held_out"] = "held-out poses"


def equal_time(stored: Evidence) -> Markup:
    """Set errors after a tenth of the time of Levenberg–Marquardt, after all of it, and in the end."""
    whole, rows = history(stored, SECOND_ORDER)[0][-1], {}
    for way in WAYS:
        errors = [with_range(left(stored, way, time), "{:.2f}") for time in (whole / 10, whole, math.inf)]
        last = history(stored, way)[0][-1] / whole
        seconds = stored["times"].where(way=way)["seconds"].item()
        rows[way] = [f"{1e3 * seconds:.2g}", *errors, f"{last:.2g} times as long"]
    after = ("after a tenth of the time", "after the same time", "in the end", "which is after")
    return show(pd.DataFrame.from_dict(rows, orient="index", columns=["a pass or epoch [ms]", *after]))


def descents(stored: Evidence) -> Figure:
    """Draw the error over the data against time, by back-propagation with the gain that is best in the end."""
    fig, ax = plt.subplots()
    for way in WAYS:
        times, errors = history(stored, way)
        if way != SECOND_ORDER:
            errors = errors[:, np.median(errors[..., -1], axis=0).argmin()]
        (line,) = ax.loglog(times[1:], np.median(errors, axis=0)[1:], label=way)
        ax.fill_between(times[1:], errors.min(0)[1:], errors.max(0)[1:], color=line.get_color(), alpha=0.2)
    ax.set(xlabel="processor time [s]", ylabel="distance [mm]")
    fig.legend(loc="outside upper center", ncols=2)
    return fig


def memory_table(stored: Evidence) -> Markup:
    """Set the numbers that each way keeps."""
    return show(memory(stored).map("{:,}".format))


def sizes(stored: Evidence, live: Table) -> Figure:
    """Draw errors against hidden neurons, with the thesis's size and that of Eq. 57."""
    fig, panels = plt.subplots(1, 2, figsize=(7.2, 3.8))
    for ax, name in zip(panels, NETWORKS, strict=True):
        rule, own = stored["rule_size"].where(network=name), live.where(network=name)
        for color, (metric, label) in enumerate(LOOKS.items()):
            ax.loglog(by_size(stored).loc[name, metric], f"C{color}o-", ms=3, label=label)
            ax.plot(rule["neurons"].iloc[0], rule[metric].median(), f"C{color}D")
            ax.plot(own["neurons"], own[metric], f"C{color}x", ms=8)
        thesis = load_paper("rouvinen1999").printed(f"crane-{name}-neurons")[0]
        ax.axvline(thesis, color="k", linestyle=":", label="thesis")
        ax.set(title=name, xlabel="hidden neurons")
    panels[0].set(ylabel="mean distance [mm]")
    fig.legend(*panels[0].get_legend_handles_labels(), loc="outside upper center", ncols=3)
    return fig


def size_table(stored: Evidence, network: str) -> Markup:
    """Set mean distances from the truth by the number of neurons."""
    rows = [stored[name].where(network=network) for name in ("sizes", "rule_size")]
    tried, rule = (over_seeds(own, "neurons", LOOKS, "{:.2f}") for own in rows)
    return show(pd.concat([tried, rule.rename(index="{} (Eq. 57)".format)]))


def choices(stored: Evidence) -> Markup:
    """Set what comes of choosing sizes by the thesis's test, by held-out poses, and by other 25 points."""
    rows, lottery = {}, stored["lottery"].where().set_index(["network", "by"])
    for name in NETWORKS:
        for metric in ("test", "held_out"):
            own = picked(stored, name, metric)
            errors = [with_range(own[which], "{:.2f}") for which in ("reported", "fresh")]
            rows[f"{name}, by {LOOKS[metric]}"] = [with_range(own["neurons"]), *errors, own["over"].median()]
        for by in (ONE, ALL):
            many = lottery.xs((name, by))
            reported = f"{many['middle']:.2f} ({many['low']:.2f}–{many['high']:.2f}) of the next column"
            neurons = with_range(many[["neurons", "fewest", "most"]])
            rows[f"{name}, by other 25 points, {by}"] = [neurons, reported, "–", many["regret"]]
    heads = ["neurons", "reported [mm]", "on fresh points [mm]", "over the best there is"]
    return show(pd.DataFrame.from_dict(rows, orient="index", columns=heads), "{:.2f}")


def rules(stored: Evidence) -> Markup:
    """Evaluate Eqs. 57 and 58 for the thesis's networks."""
    heads = {
        "neurons": "neurons of the thesis",
        "rows": "different rows",
        "by_rows": "neurons by Eq. 57",
        "by_poses": "by Eq. 57, counting poses",
        "needed": "rows by Eq. 58, a tenth wrong",
        "wrong": "share wrong for these rows",
    }
    return show(stored["rules"].where().set_index("network")[list(heads)].rename(columns=heads), "{:.1f}")
