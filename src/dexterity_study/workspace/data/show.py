"""Figures, tables and scenes of the chapter on the data of paper C, from rows of its experiments."""

from __future__ import annotations

from typing import TypeAlias

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import torch
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from dexterity import scenes, spatial, workspace
from dexterity.scenes.colors import COLORS
from dexterity.scenes.page import Html
from dexterity.workspace import reachability
from dexterity_study.claims.ledger import load_paper
from dexterity_study.engine.evidence import Evidence
from dexterity_study.engine.table import Table
from dexterity_study.page.markup import Markup
from dexterity_study.page.tables import show
from dexterity_study.workspace.data import verdicts
from dexterity_study.workspace.data.experiment import fanuc_arm

Links: TypeAlias = tuple[float, float, float, float]

LENGTHS = ("d₃", "d₄", "a₂", "a₃")
ARMS: dict[str, Links] = {"PUMA 560": (0.15, 0.4318, 0.4318, 0.0203), "a shorter arm": (0.1, 0.15, 0.3, 0.05)}
"""Lengths d₃, d₄, a₂, a₃ [m] of two arms of the family."""

HALF_SIDE = 0.4
"""Half the side of the cube from which positions are drawn [m]."""

CHECKS = {
    "tried": ("poses tried", "{:,}"),
    "disagreements": ("rule and branches disagree", "{:,}"),
    "turned": ("answers that change as the tool turns", "{:,}"),
    "eight": ("poses in reach with eight configurations", "{:.2%}"),
    "jacobians": ("and eight different Jacobians", "{:.2%}"),
}


def fanuc_jacobian() -> Markup:
    """Set the exact Jacobian of the Fanuc arm at zero."""
    J = fanuc_arm().geometric_jacobian([0, 0, 0, 0, 0, 0]).round(decimals=6) + 0.0
    rows = ("vx", "vy", "vz", "ωx", "ωy", "ωz")
    return show(pd.DataFrame(J.numpy(), rows, [f"joint {joint}" for joint in range(1, 7)]))


def step_errors(stored: Evidence) -> Figure:
    """Draw the errors of Jacobians by differences against the step."""
    fig, ax = plt.subplots()
    for kind in ("forward", "central"):
        ax.loglog(stored["fanuc"].array("steps")[0], stored["fanuc"].array(kind)[0], label=kind)
    step = load_paper("liao2018").printed("difference-step")
    ax.axvline(step, color=COLORS["black"], linestyle=":", label="the paper's step")
    ax.set(xlabel="step [rad]", ylabel="largest error of an entry")
    ax.legend()
    return fig


def reach_in_a_plane() -> Figure:
    """Draw what two arms reach in a vertical plane through the first axis."""
    side = torch.linspace(-0.9, 0.9, 361, dtype=torch.float64)
    x, z = torch.meshgrid(side, side, indexing="xy")
    fig, panels = plt.subplots(1, 2, figsize=(6.8, 3.5), sharey=True)
    for ax, (name, links) in zip(panels, ARMS.items(), strict=True):
        reach = workspace.reachable(links, torch.stack([x, 0 * x, z], -1))
        ax.contourf(x, z, reach, levels=[0.5, 1.5], colors=[COLORS["sky blue"]])
        ax.add_patch(
            Rectangle((-HALF_SIDE, -HALF_SIDE), 2 * HALF_SIDE, 2 * HALF_SIDE, fill=False, linestyle="--")
        )
        ax.set(title=name, xlabel="x [m]", aspect="equal")
    panels[0].set(ylabel="z [m]")
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


def file_table(stored: Evidence) -> Markup:
    """Set Table I, with how many targets and features vary."""
    rows = stored["files"].where(columns="all").set_index("file")
    rows["kind"] = rows["is_binary"].map({True: "classification", False: "regression"})
    rows["samples"] = rows["samples"].map("{:,.0f}".format)
    heads = {"varying_targets": "that vary", "varying_features": "that vary "}
    columns = ["targets", "varying_targets", "features", "varying_features", "samples", "kind"]
    return show(rows[columns].rename(columns=heads).rename_axis(None))


def implied_shares(stored: Evidence) -> Figure:
    """Draw the shares of poses in reach that the rows of Table VI allow, beside those of our sets."""
    shares, ours = verdicts.implied_shares(), 100 * verdicts.in_reach(stored)
    fig, ax = plt.subplots(figsize=(5.5, 4.6))
    low, high = 100 * np.array(list(shares.values())).T
    ax.hlines(range(len(shares)), low, high, color=COLORS["black"], linewidth=4, label="Table VI allows")
    ax.axvline(ours["redraw=0"], color=COLORS["blue"], label="as drawn")
    ax.axvline(ours["chosen"], color=COLORS["vermillion"], linestyle="--", label="redrawn")
    ax.set_yticks(range(len(shares)), list(shares))
    ax.invert_yaxis()
    ax.set(xlabel="poses in reach [%]")
    ax.legend(loc="lower center", bbox_to_anchor=(0.3, 1), ncols=3, columnspacing=1, handlelength=1.2)
    return fig


def uniformity(stored: Evidence) -> Markup:
    """Set distances from the uniform distribution."""
    table = verdicts.uniformity(stored).rename(columns={"links": ", ".join(LENGTHS)})
    return show(table.rename_axis(columns=None))


def influence(stored: Evidence) -> Markup:
    """Set what depends on each group of columns."""
    rows = stored["influence"].where().set_index("columns").rename_axis(None)
    return show(
        pd.DataFrame({f"{head} [%]": 100 * rows[head.lower()] for head in ("label", "Jacobian", "kept")})
    )


def map_by_length(stored: Evidence, name: str) -> Figure:
    """Draw a map by t-SNE, coloured by each of the four lengths."""
    points, links = (stored["maps"].array(array)[0] for array in (name, f"{name}_links"))
    fig, panels = plt.subplots(2, 2, figsize=(6.4, 5.6), sharex=True, sharey=True)
    for ax, length, values in zip(panels.flat, LENGTHS, links.T, strict=True):
        dots = ax.scatter(*points.T, c=values, s=6, vmin=0, vmax=0.5)
        ax.set(title=length, xticks=[], yticks=[])
    fig.colorbar(dots, ax=panels, label="length [m]")
    return fig


def maps(stored: Evidence) -> Markup:
    """Set R² with which neighbours on the maps predict lengths and position."""
    rows = stored["maps"].where()
    table = rows.pivot(index="map", columns="quantity", values="determination")
    table = table.loc[rows["map"].unique(), rows["quantity"].unique()]
    return show(table.rename_axis(index=None, columns=None))
