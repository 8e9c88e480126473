"""Figures, tables and the scene of the chapter on four ways to position."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import torch
from matplotlib.figure import Figure
from torch import Tensor

from dexterity.crane import TEST_PAYLOADS, TEST_POINTS, positioning
from dexterity.crane.shape import bars
from dexterity.scenes import Scene
from dexterity_study.claims.ledger import load_paper
from dexterity_study.crane.positioning.experiment import (
    DIRECT,
    EXACT,
    INVERSE,
    METHODS,
    MODULAR,
    NONE,
    answers,
)
from dexterity_study.crane.positioning.verdicts import LEFT_OUT, NAMES, TOLERANCES, at, distance, named
from dexterity_study.engine.evidence import Evidence
from dexterity_study.engine.table import Table
from dexterity_study.page.markup import Markup
from dexterity_study.page.tables import over_seeds, show, with_range

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


def means(errors: Tensor) -> Markup:
    """Set mean errors along x, along y and in distance (3) [m] in millimetres."""
    millimetres = 1e3 * errors.numpy()
    return show(pd.Series(millimetres, ["along x", "along y", "distance"], name="mean error [mm]"), "{:.1f}")


def errors(stored: Evidence, live: Table) -> Markup:
    """Set mean and largest distances as the thesis's Table 4.1 has them, ours, and those of a live run."""
    rows = stored["methods"].where()
    ours = over_seeds(rows, "method", {"mean": "mean, ours", "max": "largest, ours"})
    names = {NONE: "uncompensated", **NAMES}
    for place, (kind, head) in enumerate((("mean", "mean, thesis"), ("max", "largest, thesis"))):
        own = {method: PAPER.printed(f"crane-{name}-{kind}")[2] for method, name in names.items()}
        ours.insert(2 * place, head, pd.Series(own).map("{:.1f}".format))
    columns = {"mean": "mean, live", "max": "largest, live"}
    ours = ours.join(live.where().set_index("method")[list(columns)].rename(columns=columns))
    asked = {"stopped": "beyond an end, %", "unstopped_mean": "mean if cylinders went on"}
    return show(ours.join(over_seeds(rows.assign(stopped=100 * rows["stopped"]), "method", asked)))


def clouds(stored: Evidence) -> Figure:
    """Draw mean against largest errors of each seed, with the values of the thesis."""
    fig, ax = plt.subplots(figsize=(6.8, 4.2))
    for color, method in enumerate(METHODS[1:6]):
        own = stored["methods"].where(method=method)
        (dots,) = ax.loglog(own["mean"], own["max"], f"C{color}o", alpha=0.7, label=method)
        if method in NAMES:
            printed = [PAPER.printed(f"crane-{NAMES[method]}-{kind}")[2] for kind in ("mean", "max")]
            ax.loglog(*printed, "x", ms=11, mew=2.5, color=dots.get_color())
    ax.set(xlabel="mean error [mm]", ylabel="largest error [mm]")
    fig.legend(loc="outside upper center", ncols=3)
    return fig


def missed(stored: Evidence) -> str:
    """Say how many searches end farther away than the tolerance, and where most often."""
    far = ~stored["methods"].array("near").astype(bool)
    hardest = named([far.mean(0).argmax() // len(TEST_PAYLOADS)])
    return f"{np.median(far.mean(1)):.0%} of the points end farther away than the tolerance, most often {hardest}"


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


def by_point(stored: Evidence) -> Figure:
    """Draw the errors of the four methods at each test point and load."""
    fig, panels = plt.subplots(4, 1, figsize=(6.8, 9), sharex=True)
    places = np.arange(len(TEST_POINTS) * len(TEST_PAYLOADS)) / len(TEST_PAYLOADS)
    none = distance(stored, NONE)[0].ravel()
    for ax, method in zip(panels, NAMES, strict=True):
        own = distance(stored, method).reshape(-1, len(places))
        ax.semilogy(places, none, ".", color="C4", label="without compensation")
        ax.vlines(places, own.min(0), own.max(0), color="C5", label="range over the seeds")
        ax.semilogy(places, np.median(own, axis=0), "C0.", label="median")
        ax.set(ylabel=f"{method} [mm]")
    panels[-1].set_xticks(np.arange(25) + 0.4, [f"{x:g}, {y:g}" for x, y in TEST_POINTS], rotation=90)
    panels[-1].set(xlabel="test point x, y [m]; five loads each, the lightest first")
    fig.legend(*panels[0].get_legend_handles_labels(), loc="outside upper center", ncols=3)
    return fig


def without(stored: Evidence) -> Markup:
    """Set mean and largest distances with all points, without the thesis's worst two, and without ours."""
    rows = {}
    for method, points in LEFT_OUT.items():
        own = distance(stored, method)
        order = np.argsort(own.max(2), axis=1)[:, :-2, None]
        for which, left in (
            ("all points", own),
            (f"without {named(np.flatnonzero(at(*points)))}", own[:, ~at(*points)]),
            ("without the two worst of each seed", np.take_along_axis(own, order, axis=1)),
        ):
            rows[f"{method}, {which}"] = with_range(left.mean((1, 2))), with_range(left.max((1, 2)))
    return show(pd.DataFrame.from_dict(rows, orient="index", columns=["mean", "largest"]))


def sweep(stored: Evidence) -> Markup:
    """Set errors and steps of a descent by its tolerance, with the thesis's steps."""
    rows, keys = stored["descents"].where(), ["method", "tolerance"]
    errors, steps = (
        {"mean": "mean error", "max": "largest error"},
        {"steps": "steps, mean", "most_steps": "steps, most"},
    )
    found = over_seeds(rows, keys, errors).join(over_seeds(rows, keys, steps, "{:.0f}"))
    printed = {one.id: one.printed for one in PAPER.claims}
    ends = [f"crane-{NAMES[method]}-iterations{TOLERANCES[tolerance]}" for method, tolerance in found.index]
    found["thesis, mean and most"] = [printed.get(claim, "–") for claim in ends]
    return show(found.rename(index="{:g}".format, level="tolerance"))


def training(stored: Evidence) -> Markup:
    """Set what networks miss over their data, and the time of their training."""
    heads = {"left": "what is left [mm]", "seconds": "training [s]"}
    return show(over_seeds(stored["training"].where(), "method", heads))
