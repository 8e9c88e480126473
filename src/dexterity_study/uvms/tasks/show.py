"""Figures, tables and scenes of the chapter on tasks and indices."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import torch
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from torch import Tensor

from dexterity import robots, scenes, tasks
from dexterity.indices import velocity_ellipsoid
from dexterity.scenes.page import Html
from dexterity_study.engine.evidence import Evidence
from dexterity_study.engine.readings import Reading
from dexterity_study.engine.table import Table
from dexterity_study.page import figures
from dexterity_study.page.markup import Markup
from dexterity_study.page.numbers import with_range
from dexterity_study.page.tables import over_seeds, show
from dexterity_study.uvms.tasks import stages
from dexterity_study.uvms.tasks.candidates import holding

SYMBOLS = {"manipulability": "w", "kinematic_conditioning": "KCI", None: ""}


def task_table() -> Markup:
    """Set the tasks of Table 1, and those that the text of the paper adds, beside their indices."""
    rows = {}
    for name, needs in (("manipulability", "speed or force"), ("kinematic_conditioning", "accuracy")):
        listed = [task for task in tasks.TASKS.values() if task.index == name]
        told = [
            task.name
            + ("" if "Table 1" in task.where else " (text only)")
            + (f" (also {SYMBOLS[task.also]})" if task.also else "")
            for task in listed
        ]
        rows[SYMBOLS[name]] = {"needs": needs, "tasks": ", ".join(told)}
    return show(pd.DataFrame.from_dict(rows, orient="index").rename_axis("index"))


def best_and_worst(q: Tensor, task: str) -> Html:
    """Set the best and the worst candidate for a task beside each other, with what the tool works on."""
    ranking = tasks.rank(robots.uvms(), q, task, frame="spatial")
    pair = []
    for which, place in (("best", ranking.order[0]), ("worst", ranking.order[-1])):
        value = f"{SYMBOLS[ranking.task.index]} = {ranking.values[place]:.2g}"
        scene = _stage(f"{task.capitalize()}: the {which} candidate, {value}", task, q[place], height=360)
        scene.add_letters({"tool": robots.uvms().forward(q[place])[:3, 3]})
        pair.append(scene)
    return scenes.side_by_side(*pair)


def through_candidates(q: Tensor, frames: int = 8, shown: int = 10) -> scenes.Scene:
    """Move the vehicle through candidates that hold the tool in one pose, from each to a near one.

    Parameters
    ----------
    q
        (m, 12) candidates of :func:`~dexterity_study.uvms.tasks.candidates.candidates` [m] and [rad].
    frames
        Frames from one candidate to the next. The tool rests in all of them, and nearly so in between.
    shown
        How many of the most and of the least accurate candidates are marked.
    """
    moving = frames_between(q, tour(q[:, 3:9]), frames)
    scene = _stage("A hundred postures, one tool pose", "inspection", moving[0], height=420)
    scene.animate("uvms", moving, frames_per_second=12)
    by_error = velocity_ellipsoid(robots.uvms().geometric_jacobian(q)).semi_axes[:, 0].argsort()
    for name, places, color in (
        ("vehicle's centre, most accurate tenth", by_error[:shown], "bluish green"),
        ("vehicle's centre, least accurate tenth", by_error[-shown:], "reddish purple"),
    ):
        scene.add_points(q[places, :3], name=name, size=0.05, color=color)
    return scene


def frames_between(q: Tensor, order: Tensor, per_step: int) -> Tensor:
    """Return configurations (k, 12) that lead through candidates (m, 12) in an order, with the tool at rest in each."""
    share = torch.linspace(0, 1, per_step + 1, dtype=torch.float64)[:per_step, None]
    angles = q[order, 3:9]
    steps = [torch.lerp(before, after, share) for before, after in pairwise(angles)]
    return torch.as_tensor(np.unwrap(holding(torch.cat([*steps, angles[-1:]])).numpy(), axis=0))


def _stage(title: str, task: str, q: Tensor, height: int) -> scenes.Scene:
    """Set the UVMS in a configuration, and what its tool works on."""
    scene = scenes.Scene(title, height=height, view_from=stages.VIEW)
    scene.add_chain(robots.uvms(), q, name="uvms", axes=False)
    scene.add_box(robots.describe("uvms").vehicle_size or (), on="uvms", joint=6, name="vehicle")
    stages.STAGES[task](scene)
    scene.look_at(*stages.REGION)
    return scene


def tour(angles: Tensor) -> Tensor:
    """Order postures (m, k) so that each is followed by the nearest one that is left."""
    left = list(range(1, len(angles)))
    order = [0]
    while left:
        distances = (angles[left] - angles[order[-1]]).norm(dim=-1)
        order.append(left.pop(int(distances.argmin())))
    return torch.tensor(order)


SMOOTH = {"shading": "gouraud", "rasterized": True}


def origin_map(stored: Evidence) -> Figure:
    """Draw how KCI ranks against accuracy as the world's origin moves, and what its choice costs on a line ahead."""
    table = stored["origins"]
    ahead, across = (table.array(name)[0] for name in ("ahead", "across"))
    tau = np.median(table.array("tau"), axis=0)
    fig, axes = plt.subplots(3, figsize=(figures.WIDTH, 5.6), sharex=True, height_ratios=(1, 1, 0.7))
    for ax, of_plane, title in zip(axes, tau, ("aside", "above"), strict=False):
        image = ax.pcolormesh(ahead, across, of_plane, cmap="PuOr", vmin=-0.6, vmax=0.6, **SMOOTH)
        ax.contour(ahead, across, of_plane, levels=[0.0], colors=figures.ON_COLOR, linewidths=1)
        _outline(ax, title)
        ax.set(aspect="equal", ylabel=f"{title} [m]", ylim=(-1, 1))
        ax.grid(visible=False)
    fig.colorbar(image, ax=axes[:2], label="Kendall's τ", ticks=[-0.5, 0, 0.5])
    _cost_ahead(axes[2], table)
    axes[2].set(xlabel="world's origin ahead of the vehicle's centre [m]")
    return fig


def _outline(ax: Axes, plane: str) -> None:
    """Draw the vehicle with its arm stretched ahead, and mark the tool and the origin that is assumed."""
    width, length, height = robots.describe("uvms").vehicle_size or (0.0, 0.0, 0.0)
    size = {"aside": width, "above": height}[plane]
    home = robots.uvms().joint_frames(torch.zeros(12, dtype=torch.float64))[6:, 1, 3].tolist()
    ink = figures.ON_COLOR
    ax.add_patch(Rectangle((-length / 2, -size / 2), length, size, fill=False, edgecolor=ink, linewidth=1.5))
    tool = float(robots.uvms().home[1, 3])
    ax.plot([home[0], tool], [0, 0], color=ink, linewidth=2)
    ax.plot(tool, 0, "o", color=ink, ms=7)
    ax.plot(0, 0, "X", color=ink, ms=9)
    if plane == "aside":
        ax.annotate("tool", (tool, 0), (4, 7), textcoords="offset points", color=ink)
        ax.annotate("assumed", (0, 0), (0, 8), textcoords="offset points", ha="center", color=ink)


def _cost_ahead(ax: Axes, table: Table) -> None:
    """Draw by how much the error of the candidate that KCI prefers is above the least, with its range over draws."""
    loss = 100 * (table.by_seed("loss", over="ahead") - 1)
    ax.fill_between(loss.columns, loss.min(), loss.max(), alpha=0.25, linewidth=0)
    ax.plot(loss.columns, loss.median())
    ax.set(ylabel="error above\nthe least [%]", ylim=(0, None))


PLACES = {
    "chosen": "vehicle's centre (assumed)",
    "world-origin=arm-base": "base of the arm",
    "world-origin=tool": "tool at home",
    "world-origin=beyond-the-tool": "beyond the tool",
}
"""Places of the world's origin, by reading."""

TAU, LOSS, BEATEN = "Kendall's τ", "cost / least", "better ones [%]"
WORST = "the worst posture"


def origin_table(stored: Evidence) -> Markup:
    """Set what the spatial KCI's choice costs, for each reading of the world's origin."""
    rows = stored["candidate_sets"].where(None, set="tool at rest", index="spatial KCI")
    table = _effects(rows, "reading")
    places = {name: Reading.of("sotiropoulos2016", name)["world-origin"] for name in PLACES}
    ahead = pd.DataFrame.from_dict(places, orient="index", columns=["x", "y", "z"])["y"]
    table.insert(0, "ahead [m]", ahead)
    return show(table.rename(index=PLACES).rename_axis("world's origin"), "{:.2f}")


def set_table(stored: Evidence) -> Markup:
    """Set how indices rank against the tool's largest error, for each set of candidates, and what their choice costs."""
    rows = stored["candidate_sets"].where()
    effects = _with_worst(rows, _effects(rows, ["set", "index"]), "set")
    parts = {head: effects[head].unstack(level=0, sort=False) for head in (TAU, LOSS, BEATEN)}
    table = pd.concat(parts)
    ranked = [head == LOSS or index != WORST for head, index in table.index]
    return show(table[ranked].rename_axis(["", "chosen by"]))


def task_effects(stored: Evidence, candidate_set: str) -> Markup:
    """Set what the choice by each index costs for the tasks, for one set of candidates."""
    rows = stored["task_indices"].where(set=candidate_set)
    table = _with_worst(rows, _effects(rows, ["task", "index"]), "task")
    # Where all candidates cost the same, no index ranks them.
    equal = {task: bool(of_task["tau"].isna().all()) for task, of_task in rows.groupby("task")}
    return show(table[[not equal[task] or index == WORST for task, index in table.index]])


def _effects(rows: pd.DataFrame, index: str | list[str]) -> pd.DataFrame:
    """Return median and range over the draws of what a choice costs."""
    rows = rows.assign(beaten=100 * rows["beaten"])
    parts = (("tau", TAU, "{:.2f}"), ("loss", LOSS, "{:.2f}"), ("beaten", BEATEN, "{:.0f}"))
    return pd.concat([over_seeds(rows, index, {name: head}, form) for name, head, form in parts], axis=1)


def _with_worst(rows: pd.DataFrame, table: pd.DataFrame, group: str) -> pd.DataFrame:
    """Return a table of effects with a row for the worst candidate at the end of each group."""
    parts = []
    for name, of_group in table.groupby(level=0, sort=False):
        spread = with_range(rows.loc[rows[group] == name, "spread"], "{:.2f}")
        worst = pd.DataFrame({TAU: "–", LOSS: spread, BEATEN: "–"}, [(name, WORST)])
        parts.append(pd.concat([of_group, worst]))
    return pd.concat(parts).rename_axis(["", "chosen by"])


def agreement(stored: Evidence) -> Figure:
    """Draw Kendall's τ between pairs of rankings: each draw, the median, and that with three hundred candidates."""
    titles = {
        "w, KCI": "w and KCI",
        "w, largest speed": "w and the largest speed of the tool",
        "w, torque about the tool": "w and the torque about the tool axis",
        "w, push along the tool": "w and the force along the tool axis",
        "w: free, locked vehicle": "w with a free and with a locked vehicle",
        "KCI: spatial, geometric": "spatial and geometric KCI",
        "spatial KCI, accuracy": "spatial KCI and accuracy of the tool",
        "geometric KCI, accuracy": "geometric KCI and accuracy of the tool",
    }
    taus = stored["agreement"].by_seed("tau", over="pair")
    of_300 = stored["agreement"].where("candidate-configurations=300").groupby("pair")["tau"].median()
    fig, ax = plt.subplots(figsize=(figures.WIDTH, 4.6))
    ax.axvline(0, color="#595959", linewidth=1)
    for row, (pair, title) in enumerate(titles.items()):
        marks: tuple[tuple[Any, str, dict[str, Any], str], ...] = (
            (taus[pair], "oC0", {"alpha": 0.25, "mec": "none"}, "draw of 100"),
            ([taus[pair].median()], "|", {"color": "#1F2933", "ms": 13, "mew": 2.5}, "median"),
            ([of_300[pair]], "DC1", {"ms": 7, "mfc": "none"}, "median (300)"),
        )
        for values, form, style, label in marks:
            ax.plot(values, np.full(len(values), row), form, label=None if row else label, **style)
        ax.text(-1, row - 0.35, title, va="center")
    ax.set(xlim=(-1, 1), ylim=(7.4, -0.8), yticks=[], xticks=np.linspace(-1, 1, 5))
    ax.set(xlabel="Kendall's τ between two rankings")
    ax.spines["left"].set_visible(False)
    fig.legend(loc="outside upper center", ncols=3, columnspacing=1)
    return fig
