"""Figures, tables and scenes of the chapter on more points, a tilted vehicle and a wall."""

from __future__ import annotations

import matplotlib.pyplot as plt
import pandas as pd
import torch
from matplotlib.figure import Figure

from dexterity import docking
from dexterity.docking.area import Face
from dexterity.scenes import Scene
from dexterity_study.docking import scenes
from dexterity_study.docking.beyond.experiment import TILTED, genetic
from dexterity_study.docking.cases import ARMS, CASES, arm_of
from dexterity_study.docking.search.experiment import VARIABLES
from dexterity_study.docking.search.show import by_case
from dexterity_study.engine.evidence import Evidence
from dexterity_study.page import figures
from dexterity_study.page.markup import Markup
from dexterity_study.page.tables import show


def weakest_spots(stored: Evidence, steps: int = 401) -> Figure:
    """Draw the largest w along the side of the area next to the base, at the best poses for four and nine points."""
    fig, panels = plt.subplots(2, 1, figsize=(figures.WIDTH, 4.4), sharex=True)
    side = torch.linspace(-0.2, 0.2, steps, dtype=torch.float64)
    line = torch.stack([torch.full_like(side, -0.2), side, torch.zeros_like(side)], dim=1)
    for ax, arm in zip(panels, ARMS, strict=True):
        reading = CASES[f"{arm}, or"]
        best = stored["points"].where(reading).set_index("points")
        for count, style in ((4, "o--"), (9, "s-")):
            pose = best.loc[count, [*VARIABLES]].to_numpy(dtype=float)
            w = docking.largest_manipulability(arm_of(genetic.reading(reading)), pose, line)
            every = (steps - 1) // (round(count**0.5) - 1)
            ax.plot(side, w, style, markevery=every, label=f"best pose for {count} points")
        ax.axhline(best["at_points"][4], color="#595959", ls=":", label="$M_a$ that 4 points report")
        ax.set(title=f"{arm} arm", ylabel="largest w [m³]")
    panels[-1].set(xlabel="y along the side next to the base [m]")
    fig.legend(*panels[0].get_legend_handles_labels(), loc="outside upper center", ncols=1)
    return fig


def best_values(stored: Evidence) -> Markup:
    """Set what the best poses are worth: the weakest spot by number of control points, and M_a of the extensions."""
    finest = stored["points"].where(None).pivot(index="reading", columns="points", values="finest")
    upright = stored["points"].where(None, points=4).set_index("reading")["at_points"]
    best = (
        stored["optimum"]
        .where(None)
        .set_index(["face", "tilt", "reading"])["area_manipulability"]
        .sort_index()
    )
    weakest, corners = "smallest $w$ of the area [m³]", "$M_a$ at four points [m³]"
    columns = {
        (weakest, "pose for 4 points"): finest[4],
        (weakest, "pose for 9 points"): finest[9],
        (corners, "upright"): upright,
        (corners, "tilt to 0.1 rad"): best["top", 0.1],
        (corners, "tilt to 0.3 rad"): best["top", 0.3],
        (corners, "at a side"): best["side", 0.0],
    }
    return show(by_case(pd.DataFrame(columns).astype(float)), "{:.4f}")


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


def rates(stored: Evidence) -> Markup:
    """Set the time to evaluate a pose, by number of control points."""
    time = 1e6 / stored["rates"].where().set_index("points")["rate"].astype(float)
    columns = {"time per pose [μs]": time, "relative to 4 points": time / time.iloc[0]}
    return show(pd.DataFrame(columns).rename_axis("control points"), "{:.1f}")
