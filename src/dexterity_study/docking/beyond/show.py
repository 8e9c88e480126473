"""Figures, tables and scenes of the chapter on more points, a tilted vehicle and a wall."""

from __future__ import annotations

from collections.abc import Sequence

import matplotlib.pyplot as plt
import pandas as pd
import torch
from matplotlib.figure import Figure

from dexterity import docking, robots
from dexterity.docking import DockingProblem
from dexterity.docking.area import Face
from dexterity.scenes import Scene
from dexterity.scenes.colors import COLORS
from dexterity.search import ZoomOptions
from dexterity_study.docking import scenes
from dexterity_study.docking.area.show import AREA
from dexterity_study.docking.beyond.experiment import TILTED, genetic
from dexterity_study.docking.beyond.verdicts import shares
from dexterity_study.docking.cases import CASES, arm_of
from dexterity_study.docking.search.experiment import VARIABLES
from dexterity_study.docking.search.show import LABELS, written
from dexterity_study.engine.evidence import Evidence
from dexterity_study.page.markup import Markup
from dexterity_study.page.numbers import with_range
from dexterity_study.page.tables import show


def points(stored: Evidence) -> Markup:
    """Set the best pose by number of control points, and what it is worth on finer grids."""
    rows = stored["points"].where(None)
    columns = {
        "x, y, z [m], ψ [rad]": rows[[*VARIABLES]].apply(written, axis="columns"),
        "at the points [m³]": rows["at_points"],
        "on 21 × 21 [m³]": rows["fine"],
        "on 161 × 161 [m³]": rows["finest"],
        "dead [%]": (100 * rows["dead"]).map("{:.2g}".format),
    }
    names = rows["reading"].map(LABELS) + ", " + rows["points"].map("{} points".format)
    return show(pd.DataFrame(columns).set_axis(names.to_numpy()), "{:.4f}")


def weakest_spots(stored: Evidence, per_side: int = 81) -> Figure:
    """Draw the largest w over the area at the best poses for four and for nine points, and its weakest spot."""
    fig, panels = plt.subplots(2, 2, figsize=(6.8, 6), sharex=True, sharey=True)
    square = docking.square(0.2, per_side)
    for row, variant in zip(panels, ("stated", "fitted"), strict=True):
        reading = CASES[f"{variant}, or"]
        best = stored["points"].where(reading).set_index("points")
        for ax, count in zip(row, (4, 9), strict=True):
            pose = best.loc[count, [*VARIABLES]].to_numpy()
            w = docking.largest_manipulability(arm_of(genetic.reading(reading)), pose, square)
            w_map, high = w.reshape(per_side, per_side).mT, 1.5 * best["at_points"].max()
            image = ax.imshow(w_map, origin="lower", extent=AREA, vmin=0, vmax=high)
            ax.plot(*square[w.argmin(), :2], "o", color=COLORS["vermillion"], clip_on=False)
            ax.set(title=f"{variant} arm, {count} points", xlabel="x [m]", ylabel="y [m]")
            ax.label_outer()
        fig.colorbar(image, ax=row, label="largest w [m³]")
    return fig


def rates(stored: Evidence) -> Markup:
    """Set how many poses a second are rated, by number of control points."""
    rate = stored["rates"].where().set_index("points")["rate"].rename("{} points".format)
    return show(pd.DataFrame({"poses a second": rate, "slower than with 4": rate.iloc[0] / rate}), "{:.3g}")


def optimum(stored: Evidence, face: str) -> Markup:
    """Set the best poses of the extensions on a face, and what genetic runs make of them."""
    best = stored["optimum"].where(None, face=face).set_index(["reading", "face", "tilt"])
    runs = 100 * shares(stored)
    columns = {
        "x, y, z [m], (roll, pitch,) ψ [rad]": best.reindex(columns=TILTED).apply(written, axis="columns"),
        "M_a [m³]": best["area_manipulability"],
        "fitness": best["value"],
        "by evolution": best["evolved"],
        "lowest point [mm]": (1e3 * best["lowest"]).map("{:.0f}".format),
        "genetic [% of the best]": [with_range(runs.loc[one], "{:.1f}") for one in best.index],
    }
    table = pd.DataFrame(columns)
    if face == "side":
        names = [LABELS[reading] for reading, _, _ in best.index]
        return show(table.drop(columns="lowest point [mm]").set_axis(names), "{:.4f}")
    # Nothing is weighed against M_a here.
    table["by evolution"] /= DockingProblem.manipulability_weight
    names = [f"{LABELS[reading]}, tilt to {tilt} rad" for reading, _, tilt in best.index]
    return show(table.drop(columns="fitness").set_axis(names), "{:.4f}")


def tilted_scene(stored: Evidence, tilt: float = 0.3) -> Scene:
    """Set the vehicle at its best pose with roll and pitch, and the arm at the four corners."""
    scene = _best_scene(stored, "top", tilt, f"Docked on top with roll and pitch up to {tilt:g} rad")
    scene.look_at((-1.1, -0.5, 0.0), (0.2, 0.3, 0.6))
    return scene


def wall_scene(stored: Evidence) -> Scene:
    """Set the vehicle at its best pose at the side of the block, and the arm at the four corners."""
    return _best_scene(stored, "side", 0.0, "Docked upright at the side of the block")


def _best_scene(stored: Evidence, face: Face, tilt: float, title: str) -> Scene:
    reading, scene = CASES["fitted, or"], scenes.stage(title, face)
    best = stored["optimum"].where(reading, face=face).set_index("tilt").loc[tilt]
    pose = torch.tensor(best.reindex(TILTED).fillna(0.0).to_numpy(dtype=float))
    scenes.add_docked(scene, arm_of(genetic.reading(reading)), pose, face)
    return scene


def room_to_turn(yaws: Sequence[float]) -> Markup:
    """Search the best pose of the fitted arm before a wall, with more and more room to turn [rad]."""
    arm, options, rows = robots.docking_arm("fitted"), ZoomOptions(starts=2, stages=60, shrink=0.8), {}
    for yaw in yaws:
        problem = DockingProblem(arm, region="or", face="side", yaw=(-yaw, yaw), distance_weight=0.0)
        best = docking.global_docking(problem, [0.1, 0.1, 0.1, 0.2], options)
        rows[f"yaw to {yaw} rad"] = {"M_a [m³]": best.area_manipulability, "ψ [rad]": best.pose[3].item()}
    return show(pd.DataFrame.from_dict(rows, orient="index"))
