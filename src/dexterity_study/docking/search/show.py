"""Figures, tables and scenes of the chapter on the genetic search."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import torch
from matplotlib.figure import Figure
from torch import Tensor

from dexterity.docking import Docking, DockingProblem
from dexterity.scenes import Scene
from dexterity.scenes.colors import COLORS
from dexterity.search import GeneticSearch
from dexterity_study.docking import scenes
from dexterity_study.docking.cases import CASES, arm_of
from dexterity_study.docking.search.experiment import ALONE, NEAR, VARIABLES, VEHICLE, genetic
from dexterity_study.docking.search.verdicts import found, optima
from dexterity_study.engine.evidence import Evidence
from dexterity_study.page.markup import Markup
from dexterity_study.page.tables import over_seeds, show

_LINES = (("blue", "-"), ("sky blue", "--"), ("vermillion", "-"), ("orange", "--"))
STYLES: dict[str, Any] = {
    case: {"color": COLORS[name], "ls": ls, "label": case}
    for case, (name, ls) in zip(CASES, _LINES, strict=True)
}
LABELS = {reading: case for case, reading in CASES.items()}
LABELS |= {alone: f"{LABELS[reading]}, b = 0" for reading, alone in ALONE.items()}


def written(row: pd.Series) -> str:
    """Write the numbers of a pose."""
    return ", ".join(f"{number:.3f}" for number in row.dropna())


def optimum(stored: Evidence) -> Markup:
    """Set the true optima, and how far both methods are apart."""
    best = optima(stored)
    columns = {
        "x, y, z [m], ψ [rad]": best[[*VARIABLES]].apply(written, axis="columns"),
        "M_a [m³]": best["area_manipulability"],
        "D [m]": best["distance"],
        "fitness": best["fitness"],
        "methods differ by": (best["evolved"] / best["fitness"] - 1).abs().map("{:.0e}".format),
    }
    return show(pd.DataFrame(columns).rename(LABELS), "{:.4f}")


def shares(stored: Evidence) -> Figure:
    """Draw the fitness of genetic runs beside the true optimum, sorted."""
    fig, ax = plt.subplots(figsize=(6.8, 3.4))
    runs = 100 * found(stored)["share"]
    for case, reading in CASES.items():
        ax.ecdf(runs[reading], orientation="horizontal", **STYLES[case])
    ax.set(xlabel="share of the seeds", ylabel="fitness, of the true optimum [%]")
    ax.legend()
    return fig


def best_pose(run: Docking) -> Markup:
    """Set the pose that one run has found, and what it is worth."""
    facts = dict(zip(("x [m]", "y [m]", "z [m]", "ψ [rad]"), run.pose.tolist(), strict=True))
    facts |= {"M_a [m³]": run.area_manipulability, "D [m]": run.distance, "fitness": run.fitness}
    return show(pd.Series(facts, name="best pose"), "{:.3f}")


def runs(stored: Evidence) -> Markup:
    """Set what genetic runs find, by reading."""
    rows = found(stored).rename(LABELS, level="reading")
    rows = rows.assign(near=rows["share"] >= NEAR)
    rows[["share", "of_lattice", "dead", "near", "on_quarter", "faces"]] *= 100
    spread = {
        "share": "of the optimum [%]",
        "of_lattice": "of the lattice's best [%]",
        "dead": "dead inside [%]",
    }
    told = {"near": "near it [%]", "on_quarter": "nearest quarter [%]", "faces": "facing the area [%]"}
    means = rows.groupby("reading", sort=False)[[*told]].mean().rename(columns=told)
    counts = over_seeds(rows, "reading", {"evaluations": "evaluations"}, "{:.0f}")
    return show(over_seeds(rows, "reading", spread, "{:.1f}").join([means, counts]), "{:.0f}")


def peers(stored: Evidence) -> Markup:
    """Set the fitness that methods find at equal evaluations beside the optimum's."""
    rows = stored["peers"].where(None).set_index("reading").drop(columns="seed")
    rows = 100 * rows.div(optima(stored)["fitness"].loc[rows.index], axis="index")
    return show(over_seeds(rows.rename(LABELS), "reading", {str(name): str(name) for name in rows}, "{:.1f}"))


def gradients(stored: Evidence) -> Markup:
    """Set flat poses, climbs by gradients, and those that take as many evaluations as a genetic run."""
    rows = stored["gradients"].where(None).set_index("reading")
    climbs = found(stored)["evaluations"].groupby("reading").median() / rows["evaluations"]
    columns = {
        "flat poses [%]": 100 * rows["flat"],
        "climbs that come near [%]": 100 * rows["climbed"],
        "evaluations a climb": rows["evaluations"],
        "chance with as many as a genetic run [%]": 100 * (1 - (1 - rows["climbed"]) ** climbs),
    }
    return show(pd.DataFrame(columns, index=rows.index).rename(LABELS), "{:.0f}")


def front(stored: Evidence) -> Figure:
    """Draw the best pose and the quarter that genetic runs end on, as the distance counts more."""
    fig, panels = plt.subplots(1, 3, figsize=(8.4, 3.3))
    heads = {
        "area_manipulability": "M_a of the best pose [m³]",
        "distance": "D of the best pose [m]",
        "on_quarter": "on the nearest quarter",
    }
    for ax, (metric, head) in zip(panels, heads.items(), strict=True):
        for case, reading in CASES.items():
            rows = stored["front"].where(reading)
            ax.plot(rows["ratio"], rows[metric], marker="o", ms=3, **STYLES[case])
        ax.axvline(DockingProblem.distance_weight / DockingProblem.manipulability_weight, color="k", lw=0.8)
        ax.set_xscale("symlog", linthresh=5e-4)
        ax.set(xlabel="b/a [m²]", ylabel=head, xlim=(-1e-4, 0.2), xticks=[0, 1e-3, 1e-2, 1e-1])
    fig.legend(*panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=4)
    return fig


def table_3(stored: Evidence) -> Markup:
    """Set the printed runs, and how far the vehicle's foot has to move to their poses."""
    names = ("x [m]", "y [m]", "z [m]", "ψ [rad]", "M_a printed", "fitness printed")
    claims = (*(f"poses-{name}" for name in VARIABLES), "area-manipulability-of-runs", "fitness-of-runs")
    printed = {name: scenes.PAPER.printed(claim) for name, claim in zip(names, claims, strict=True)}
    distance = stored["table_3"].where().set_index("run")["distance"]
    return show(pd.DataFrame({**printed, "D [m]": distance}, index=distance.index))


def docked_scene(title: str, pose: Tensor, reading: str = "fitted-arm=fitted") -> Scene:
    """Set the block, the hook, the vehicle docked at a pose (4,), and the arm at every corner it reaches."""
    scene = _stage(title)
    scenes.add_docked(scene, arm_of(genetic.reading(reading)), pose)
    return scene


def search_scene(search: GeneticSearch, frames: int = 6) -> Scene:
    """Move the vehicle from the best pose of each generation to the next."""
    scene = _stage("The best pose of each generation, one after the other")
    best = torch.unique_consecutive(search.points, dim=0)
    best[:, 3] = torch.tensor(np.unwrap(best[:, 3].numpy()))
    scene.add_chain(VEHICLE, best[0], name="arm's base", axes=False)
    scene.add_box(scenes.BODY, on="arm's base", joint=4, pose=scenes.body_on_base(), name="vehicle")
    share = torch.linspace(0, 1, frames + 1, dtype=torch.float64)[:frames, None]
    moves = [torch.lerp(a, b, share) for a, b in pairwise(best)]
    scene.animate("arm's base", torch.cat([*moves, best[-1].expand(4 * frames, 4)]), frames_per_second=12)
    scene.add_path(best[:, :3], name="path of the best pose", color="blue")
    scene.look_at((-1.2, -1.2, -0.1), (1.2, 1.2, 0.8))
    return scene


def _stage(title: str) -> Scene:
    """Set the block with the task area and the hook in its middle, that the vehicle holds on to."""
    scene = scenes.stage(title)
    turn = np.linspace(-0.5 * np.pi, np.pi, 13)
    bend = np.stack([0.04 * np.cos(turn), 0 * turn, 0.12 + 0.04 * np.sin(turn)], axis=1)
    hook = np.vstack([np.zeros(3), bend])
    scene.add_bars("hook", np.stack([hook[:-1], hook[1:]], axis=1), radius=0.006, color="black")
    return scene
