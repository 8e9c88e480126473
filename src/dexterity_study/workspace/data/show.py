"""Figures and tables of the chapter on the data of paper C, from rows of its experiments."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import torch
from matplotlib.figure import Figure
from matplotlib.patches import Patch, Rectangle

from dexterity import workspace
from dexterity.scenes.colors import COLORS
from dexterity_study.engine.evidence import Evidence
from dexterity_study.engine.table import Table
from dexterity_study.page import figures
from dexterity_study.page.markup import Markup
from dexterity_study.page.tables import show
from dexterity_study.workspace.data import verdicts

CHECKS = {
    "tried": ("poses tried", "{:,}"),
    "disagreements": ("poses on which rule and branches disagree", "{:,}"),
    "turned": ("poses whose answer changes as the tool turns", "{:,}"),
    "eight": ("poses in reach with eight configurations", "{:.1%}"),
    "jacobians": ("poses in reach with eight different Jacobians", "{:.1%}"),
}
COLUMNS = {
    "d3": "$d_3$",
    "d4": "$d_4$",
    "a2": "$a_2$",
    "a3": "$a_3$",
    "x": "$x$",
    "y": "$y$",
    "z": "$z$",
    "three angles": "angles of the tool",
    "centre": "centres of mass",
    "viscous": "viscous friction",
    "coulomb": "Coulomb friction",
    "motor": "motor inertia",
    "gear": "gear ratios",
}
"""Names of groups of columns as a figure has them, where they differ from those of the rows."""


def reach_in_a_plane() -> Figure:
    """Draw what two arms reach in a vertical plane through the first axis."""
    arms = {"PUMA 560": (0.15, 0.4318, 0.4318, 0.0203), "a shorter arm": (0.1, 0.15, 0.3, 0.05)}
    side = torch.linspace(-0.9, 0.9, 361, dtype=torch.float64)
    x, z = torch.meshgrid(side, side, indexing="xy")
    fig, panels = plt.subplots(1, 2, figsize=(figures.WIDTH, 2.7), sharey=True)
    for ax, (name, links) in zip(panels, arms.items(), strict=True):
        reach = workspace.reachable(links, torch.stack([x, 0 * x, z], -1))
        ax.contourf(x, z, reach, levels=[0.5, 1.5], colors=[COLORS["sky blue"]])
        cube = ax.add_patch(Rectangle((-0.4, -0.4), 0.8, 0.8, fill=False, linestyle="--"))
        ax.set(title=name, xlabel="x [m]", aspect="equal", xticks=(-0.5, 0, 0.5), yticks=(-0.5, 0, 0.5))
    panels[0].set(ylabel="z [m]")
    entries = {"in reach": Patch(color=COLORS["sky blue"]), "positions are drawn from here": cube}
    fig.legend(entries.values(), entries, loc="outside upper center", ncols=2)
    return fig


def checks(stored: Evidence, live: Table) -> Markup:
    """Set all that was checked about the rule, beside a live run."""
    rows = {"stored": stored["rule"].where().iloc[0], "live": live.where().iloc[0]}
    columns = {
        run: [form.format(row[name]) for name, (_, form) in CHECKS.items()] for run, row in rows.items()
    }
    return show(pd.DataFrame(columns, [title for title, _ in CHECKS.values()]))


def implied_shares(stored: Evidence) -> Figure:
    """Draw the shares of poses in reach that the rows of Table VI allow, beside those of our sets."""
    shares, ours = verdicts.implied_shares(), 100 * verdicts.in_reach(stored)
    names = [name.replace("network ", "network, threshold 0.") for name in shares]
    fig, ax = plt.subplots(figsize=(figures.WIDTH, 3.5))
    low, high = 100 * np.array(list(shares.values())).T
    ax.hlines(range(len(shares)), low, high, color=COLORS["black"], linewidth=4, label="Table VI")
    ax.axvline(ours["redraw=0"], color=COLORS["blue"], label="as drawn")
    ax.axvline(ours["chosen"], color=COLORS["vermillion"], linestyle="--", label="redrawn")
    ax.set_yticks(range(len(shares)), names)
    ax.invert_yaxis()
    ax.set(xlabel="poses in reach [%]")
    fig.legend(loc="outside upper center", ncols=3)
    return fig


def influence(stored: Evidence) -> Figure:
    """Draw the share of the variance of each answer that needs a group of columns."""
    rows = stored["influence"].where().set_index("columns")
    titles = {"label": "in reach", "jacobian": "Jacobian", "kept": "kept"}
    fig, ax = plt.subplots(figsize=(figures.WIDTH, 4.0))
    places = np.arange(len(rows))
    for shift, (name, title) in zip((-0.27, 0, 0.27), titles.items(), strict=True):
        ax.barh(places + shift, 100 * rows[name], height=0.25, label=title)
    ax.set_yticks(places, [COLUMNS.get(name, name) for name in rows.index])
    ax.invert_yaxis()
    ax.grid(visible=False, axis="y")
    ax.set(xlabel="variance that needs the column [%]")
    fig.legend(loc="outside upper center", ncols=3)
    return fig
