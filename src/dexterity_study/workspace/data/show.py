"""Figures, tables and scenes of the chapter on the data of paper C, from rows of its experiments."""

from __future__ import annotations

from typing import TypeAlias

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import torch
from matplotlib.figure import Figure
from matplotlib.patches import Patch, Rectangle

from dexterity import scenes, spatial, workspace
from dexterity.scenes.colors import COLORS
from dexterity.scenes.page import Html
from dexterity.workspace import reachability
from dexterity_study.engine.evidence import Evidence
from dexterity_study.engine.table import Table
from dexterity_study.page import figures
from dexterity_study.page.markup import Markup
from dexterity_study.page.tables import show
from dexterity_study.workspace.data import verdicts

Links: TypeAlias = tuple[float, float, float, float]

LENGTHS = ("d₃", "d₄", "a₂", "a₃")
ARMS: dict[str, Links] = {"PUMA 560": (0.15, 0.4318, 0.4318, 0.0203), "a shorter arm": (0.1, 0.15, 0.3, 0.05)}
"""Lengths d₃, d₄, a₂, a₃ [m] of two arms of the family."""

HALF_SIDE = 0.4
"""Half the side of the cube from which positions are drawn [m]."""

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
    side = torch.linspace(-0.9, 0.9, 361, dtype=torch.float64)
    x, z = torch.meshgrid(side, side, indexing="xy")
    fig, panels = plt.subplots(1, 2, figsize=(figures.WIDTH, 2.7), sharey=True)
    for ax, (name, links) in zip(panels, ARMS.items(), strict=True):
        reach = workspace.reachable(links, torch.stack([x, 0 * x, z], -1))
        ax.contourf(x, z, reach, levels=[0.5, 1.5], colors=[COLORS["sky blue"]])
        cube = ax.add_patch(
            Rectangle((-HALF_SIDE, -HALF_SIDE), 2 * HALF_SIDE, 2 * HALF_SIDE, fill=False, linestyle="--")
        )
        ax.set(title=name, xlabel="x [m]", aspect="equal", xticks=(-0.5, 0, 0.5), yticks=(-0.5, 0, 0.5))
    panels[0].set(ylabel="z [m]")
    entries = {"in reach": Patch(color=COLORS["sky blue"]), "positions are drawn from here": cube}
    fig.legend(entries.values(), entries, loc="outside upper center", ncols=2)
    return fig


def family(tool: tuple[float, float, float] = (0.3, 0.1, 0.25)) -> Html:
    """Set two arms with the tool at one place [m], their four lengths, and what they reach in a plane."""
    return scenes.side_by_side(*(_arm_scene(name, links, tool) for name, links in ARMS.items()))


def _arm_scene(name: str, links: Links, tool: tuple[float, float, float]) -> scenes.Scene:
    T = spatial.pose(torch.eye(3, dtype=torch.float64), torch.tensor(tool, dtype=torch.float64))
    placed = reachability.frames(links, reachability.inverse(links, T)[0])
    _, shoulder, elbow, forearm, wrist = placed.origins[:5]
    beside = elbow + links[0] * placed.rotations[2, :, 2]
    ends = {"a₂": (shoulder, elbow), "d₃": (elbow, beside), "a₃": (beside, forearm), "d₄": (forearm, wrist)}
    scene = scenes.Scene(name, height=400, view_from=(0.4, -1.0, 0.5))
    for (length, bar), color in zip(ends.items(), ("blue", "vermillion", "black", "orange"), strict=True):
        title = f"{length} = {links[LENGTHS.index(length)]:g} m"
        scene.add_bars(title, torch.stack(bar)[None], radius=0.018, color=color)
    axis = [(0.0, 0.0, -HALF_SIDE), (0.0, 0.0, HALF_SIDE)]
    scene.add_path(axis, name="first axis", color="bluish green")
    scene.add_points([tool], name="tool", size=0.05, color="reddish purple")
    scene.add_box([2 * HALF_SIDE] * 3, name="cube of positions", color="#64748B")
    side = torch.linspace(-HALF_SIDE, HALF_SIDE, 33, dtype=torch.float64)
    plane = torch.stack(torch.meshgrid(side, side.new_zeros(1), side, indexing="ij"), dim=-1).reshape(-1, 3)
    reached = plane[workspace.reachable(links, plane)]
    scene.add_points(reached, name="in reach, in the plane y = 0", size=0.012, color="sky blue")
    return scene


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
