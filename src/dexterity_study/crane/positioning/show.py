"""Figures, tables and the scene of the chapter on four ways to position."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import torch
from matplotlib.figure import Figure
from torch import Tensor

from dexterity.crane import positioning
from dexterity.crane.shape import bars
from dexterity.scenes import Scene
from dexterity_study.claims.ledger import load_paper
from dexterity_study.crane.positioning.experiment import (
    DIRECT,
    EXACT,
    GENETIC,
    INVERSE,
    MODULAR,
    NONE,
    answers,
)
from dexterity_study.crane.positioning.verdicts import NAMES
from dexterity_study.engine.evidence import Evidence
from dexterity_study.engine.table import Table
from dexterity_study.page import figures
from dexterity_study.page.markup import Markup
from dexterity_study.page.tables import over_seeds, show

PAPER = load_paper("rouvinen1999")
MAGNIFIED = 10.0
"""Factor of errors as they are drawn."""

VIEW = (0.3, -1.0, 0.25)
TIP_COLORS = {
    NONE: "black",
    EXACT: "bluish green",
    DIRECT: "blue",
    MODULAR: "orange",
    INVERSE: "vermillion",
}

TITLES = {
    NONE: "no compensation",
    GENETIC: "1 correction, search",
    EXACT: "1 correction, closed form",
    DIRECT: "2 direct network",
    MODULAR: "3 two networks",
    INVERSE: "4 inverse network",
}
"""Names of the methods on the page."""

COLORS = {method: f"C{number}" for number, method in enumerate((GENETIC, EXACT, DIRECT, MODULAR, INVERSE))}


def clouds(stored: Evidence) -> Figure:
    """Draw mean against largest errors of each seed, with the values of the thesis."""
    fig, ax = plt.subplots(figsize=(figures.WIDTH, 3.4))
    for method, color in COLORS.items():
        seeds = stored["methods"].where(method=method)
        ax.loglog(seeds["mean"], seeds["max"], "o", color=color, alpha=0.7, label=TITLES[method])
        if method in NAMES:
            printed = [_printed(method, kind) for kind in ("mean", "max")]
            ax.loglog(*printed, "x", ms=11, mew=2.5, color=color)
    ax.plot([], [], "x", ms=11, mew=2.5, color="#595959", label="thesis")
    ax.set(xlabel="mean error [mm]", ylabel="largest error [mm]")
    fig.legend(loc="outside upper center", ncols=2)
    return fig


def errors(stored: Evidence, live: Table) -> Markup:
    """Set mean and largest distances, printed and ours with one live run, and how often a cylinder is at its end."""
    rows = stored["methods"].where()
    rows["stopped"] *= 100
    ours = over_seeds(rows, "method", {"mean": "mean", "max": "largest", "stopped": "stopped"}, "{:.1f}")
    thesis = {
        kind: pd.Series({method: _printed(method, kind) for method in (NONE, *NAMES)})
        for kind in ("mean", "max")
    }
    columns = {
        ("mean [mm]", "thesis"): thesis["mean"],
        ("mean [mm]", "ours"): ours["mean"],
        ("mean [mm]", "live"): live.where().set_index("method")["mean"],
        ("largest [mm]", "thesis"): thesis["max"],
        ("largest [mm]", "ours"): ours["largest"],
        ("at an end [%]", "ours"): ours["stopped"],
    }
    compared = [head for head in columns if head[1] in ("thesis", "ours") and "end" not in head[0]]
    table = pd.DataFrame(columns).loc[list(TITLES)].rename(index=TITLES)
    return show(table, "{:.1f}", best=dict.fromkeys(compared, "least"))


def four_tips(point: tuple[float, float] = (6.0, 2.0), payload: float = 310.0, epochs: int = 100) -> Scene:
    """Draw the loaded crane at a point [m], and where each way of the first seed puts the tip instead."""
    task = positioning.thesis_task([point], [payload])
    placements = {NONE: positioning.uncompensated(task), **answers(task, 0, epochs)}
    x, y = point
    scene = Scene(f"Where the tip ends that is to be at ({x:g}, {y:g}) m with {payload:g} kg", view_from=VIEW)
    scene.look_at((2.0, 0.0, 0.8), (6.6, 0.0, 3.2))
    scene.add_remark(f"errors drawn {MAGNIFIED:g} : 1")
    shape = bars(placements[EXACT].strokes[0]).loaded(payload)
    scene.add_bars("crane on the target", _upright(shape), radius=0.03)
    for method, color in TIP_COLORS.items():
        miss = positioning.errors(task, placements[method]).each[0]
        ends = torch.stack([task.targets[0], task.targets[0] - MAGNIFIED * miss])
        name = f"{method}, {1e3 * miss.norm():.1f} mm off"
        scene.add_bars(name, _upright(ends)[None], radius=0.03, color=color)
    return scene


def _upright(points: Tensor) -> np.ndarray:
    """Return points (..., 2) of the crane's plane in the world, where the crane's y is z."""
    return np.insert(points.numpy(), 1, 0.0, axis=-1)


def _printed(method: str, kind: str) -> float:
    """Return the mean or the largest distance [mm] that the thesis prints for a method."""
    name = "uncompensated" if method == NONE else NAMES[method]
    return float(PAPER.printed(f"crane-{name}-{kind}")[2])
