"""Figures, tables and scenes of the chapter on tasks and indices."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from torch import Tensor

from dexterity import robots, scenes, tasks
from dexterity.scenes.page import Html
from dexterity_study.engine.evidence import Evidence
from dexterity_study.page.markup import Markup
from dexterity_study.page.tables import show
from dexterity_study.uvms.kinematics.show import vehicle_scene

SYMBOLS = {"manipulability": "w", "kinematic_conditioning": "KCI", None: ""}


def task_table() -> Markup:
    """Set the tasks and their indices."""
    rows = [
        (task.name, SYMBOLS[task.index], SYMBOLS[task.also], task.comment, task.where)
        for task in tasks.TASKS.values()
    ]
    return show(
        pd.DataFrame(rows, columns=["task", "index", "also", "what it asks of the tool", "printed in"])
    )


def two_rankings(q: Tensor) -> Figure:
    """Draw w against KCI of candidates, with the best ten for each of two tasks."""
    valve, welding = (tasks.rank(robots.uvms(), q, task) for task in ("valve turning", "welding"))
    fig, ax = plt.subplots()
    ax.plot(valve.values, welding.values, ".", color="0.6", label="candidates")
    for ranking, marker in ((valve, "s"), (welding, "o")):
        best = ranking.order[:10]
        label = f"best ten for {ranking.task.name}"
        ax.plot(valve.values[best], welding.values[best], marker, ms=9, mfc="none", label=label)
    ax.set(xlabel="w", ylabel="KCI, spatial")
    ax.legend(loc="upper left", fontsize="small")
    return fig


def best_and_worst(q: Tensor, task: str) -> Html:
    """Set the best and the worst candidate for a task beside each other."""
    ranking = tasks.rank(robots.uvms(), q, task)
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
    pairs = stored["agreement"].by_seed("tau", over="pair")
    of_300 = stored["agreement"].where("candidate-configurations=300").groupby("pair")["tau"].median()
    fig, ax = plt.subplots(figsize=(7, 3.6))
    ax.axvline(0, color="0.5", linewidth=1)
    for row, name in enumerate(map(str, pairs)):
        ax.plot(pairs[name], np.full(len(pairs), row), "o", color="C0", alpha=0.4)
        ax.plot(pairs[name].median(), row, "|k", ms=16, mew=2.5)
        ax.plot(of_300[name], row, "Dk", ms=9, mfc="none")
    ax.set(yticks=range(pairs.shape[1]), yticklabels=pairs.columns, xlabel="Kendall's τ between two rankings")
    ax.set(xlim=(-1, 1), xticks=np.linspace(-1, 1, 5))
    ax.invert_yaxis()
    return fig
