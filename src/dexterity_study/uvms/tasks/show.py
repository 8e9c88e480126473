"""Figures, tables and scenes of the chapter on tasks and indices."""

from __future__ import annotations

from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from torch import Tensor

from dexterity import robots, scenes, tasks
from dexterity.scenes.page import Html
from dexterity_study.engine.evidence import Evidence
from dexterity_study.page import figures
from dexterity_study.page.markup import Markup
from dexterity_study.page.tables import show
from dexterity_study.uvms.kinematics.show import vehicle_scene

SYMBOLS = {"manipulability": "w", "kinematic_conditioning": "KCI", None: ""}


def task_table() -> Markup:
    """Set the tasks under their indices."""
    rows = {
        (f"ranked by {SYMBOLS[task.index]}", task.name): {
            "needs": task.comment,
            "also": SYMBOLS[task.also],
        }
        for task in tasks.TASKS.values()
    }
    return show(pd.DataFrame.from_dict(rows, orient="index").rename_axis(["", "task"]))


def two_rankings(q: Tensor) -> Figure:
    """Draw w against KCI of candidates, with the best ten for each of two tasks."""
    valve, welding = (
        tasks.rank(robots.uvms(), q, task, frame="spatial") for task in ("valve turning", "welding")
    )
    fig, ax = plt.subplots(figsize=(figures.WIDTH, 3.4))
    ax.plot(valve.values, welding.values, ".", color="#808080", label="candidate")
    for ranking, marker, task in ((valve, "s", "valve turning, by w"), (welding, "o", "welding, by KCI")):
        best = ranking.order[:10]
        label = f"best ten for {task}"
        ax.plot(valve.values[best], welding.values[best], marker, ms=9, mfc="none", label=label)
    ax.set(xlabel="w", ylabel="KCI, spatial")
    fig.legend(loc="outside upper center")
    return fig


def best_and_worst(q: Tensor, task: str) -> Html:
    """Set the best and the worst candidate for a task beside each other."""
    ranking = tasks.rank(robots.uvms(), q, task, frame="spatial")
    pair = []
    for which, place in (("best", ranking.order[0]), ("worst", ranking.order[-1])):
        value = f"{SYMBOLS[ranking.task.index]} = {ranking.values[place]:.2g}"
        title = f"{task.capitalize()}: the {which} candidate, {value}"
        scene = vehicle_scene(title, q[place], axes=False, height=380)
        scene.add_letters({"tool": robots.uvms().forward(q[place])[:3, 3]})
        pair.append(scene)
    return scenes.side_by_side(*pair)


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
