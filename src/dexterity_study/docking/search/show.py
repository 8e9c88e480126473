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

from dexterity import docking, robots
from dexterity.chain import Chain
from dexterity.docking import DockingProblem
from dexterity.scenes import Scene
from dexterity.scenes.colors import COLORS
from dexterity.search import GeneticSearch
from dexterity_study.claims.ledger import load_paper
from dexterity_study.docking.cases import CASES, CORNERS, arm_of, configuration_at
from dexterity_study.docking.search.experiment import ALONE, NEAR, VARIABLES, genetic, with_vehicle
from dexterity_study.docking.search.verdicts import found, optima
from dexterity_study.engine.evidence import Evidence
from dexterity_study.page.markup import Markup
from dexterity_study.page.tables import over_seeds, show, with_range

_LINES = (("blue", "-"), ("sky blue", "--"), ("vermillion", "-"), ("orange", "--"))
STYLES: dict[str, Any] = {
    case: {"color": COLORS[name], "ls": ls} for case, (name, ls) in zip(CASES, _LINES, strict=True)
}
LABELS = {reading: case for case, reading in CASES.items()}
LABELS |= {alone: f"{LABELS[reading]}, b = 0" for reading, alone in ALONE.items()}
PAPER = load_paper("sotiropoulos2011")
VEHICLE = PAPER.printed("vehicle")


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
    runs = found(stored)["share"]
    for case, reading in CASES.items():
        own = np.sort(100 * runs[reading])
        ax.step(100 * np.arange(1, len(own) + 1) / len(own), own, label=case, **STYLES[case])
    ax.set(xlabel="share of the seeds [%]", ylabel="fitness, of the true optimum [%]")
    ax.legend()
    return fig


def runs(stored: Evidence) -> Markup:
    """Set what genetic runs find, by reading."""
    rows = found(stored).reset_index()
    rows = rows.assign(near=rows["share"] >= NEAR, reading=rows["reading"].map(LABELS))
    rows[["share", "of_lattice", "dead"]] *= 100
    spread = {
        "share": "of the optimum [%]",
        "of_lattice": "of the lattice's best [%]",
        "dead": "dead inside [%]",
    }
    told = {"near": "near it [%]", "on_quarter": "nearest quarter [%]", "faces": "facing the area [%]"}
    groups = rows.groupby("reading", sort=False)
    table = over_seeds(rows, "reading", spread, "{:.1f}")
    table = table.assign(**{head: 100 * groups[metric].mean() for metric, head in told.items()})
    return show(table.assign(evaluations=groups["evaluations"].apply(with_range, form="{:.0f}")), "{:.0f}")


def peers(stored: Evidence) -> Markup:
    """Set the fitness that methods find at equal evaluations beside the optimum's."""
    rows = stored["peers"].where(None).set_index("reading")
    rows = rows.drop(columns="seed").div(optima(stored)["fitness"].loc[rows.index], axis="index") * 100
    names = {str(name): str(name) for name in rows}
    return show(over_seeds(rows.rename(LABELS).reset_index(), "reading", names, "{:.1f}"))


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
            ax.plot(rows["ratio"], rows[metric], marker="o", ms=3, label=case, **STYLES[case])
        ax.axvline(DockingProblem.distance_weight / DockingProblem.manipulability_weight, color="k", lw=0.8)
        ax.set_xscale("symlog", linthresh=5e-4)
        ax.set(xlabel="b/a [m²]", ylabel=head, xlim=(-1e-4, 0.2), xticks=[0, 1e-3, 1e-2, 1e-1])
    fig.legend(*panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=4)
    return fig


def table_3(stored: Evidence) -> Markup:
    """Set the printed runs beside what their poses are worth to our arms."""
    heads = dict(
        zip(("x [m]", "y [m]", "z [m]", "ψ [rad]"), (f"poses-{name}" for name in VARIABLES), strict=True)
    )
    heads |= {"M_a printed": "area-manipulability-of-runs", "fitness printed": "fitness-of-runs"}
    rows = stored["table_3"].where(None).set_index("run")
    table = pd.DataFrame(
        {head: PAPER.printed(claim) for head, claim in heads.items()}, index=rows.index.unique()
    )
    for arm in ("stated", "fitted"):
        table[f"M_a, {arm}"] = rows[rows["reading"] == CASES[f"{arm}, and"]]["area_manipulability"]
    return show(table.assign(**{"D [m]": rows[rows["reading"] == "chosen"]["distance"]}))


def weights(stored: Evidence) -> Markup:
    """Set the weights that come nearest to the printed fitness."""
    found = stored["printed_fitness"].where().iloc[0][["a", "b", "misfit"]]
    return show(found.rename({"misfit": "missed by at least"}).rename("best weights"))


# ---- scenes ----------------------------------------------------------------------------------------


def docked_scene(title: str, pose: Tensor, reading: str = "fitted-arm=fitted") -> Scene:
    """Set the block, the hook, the vehicle docked at a pose (4,), and the arm at every corner it reaches."""
    scene, arm = _stage(title), arm_of(genetic.reading(reading))
    scene.add_box(VEHICLE, pose=docking.base_pose(pose) @ _vehicle_on_base(), name="vehicle")
    for corner, color in zip(CORNERS, ("blue", "vermillion", "bluish green", "reddish purple"), strict=True):
        q = configuration_at(arm, pose, corner)
        if q is not None:
            scene.add_chain(docking.on_base(arm, pose), q, name=corner, axes=False, color=color)
    return scene


def search_scene(search: GeneticSearch, frames: int = 6) -> Scene:
    """Move the vehicle from the best pose of each generation to the next."""
    scene = _stage("The best pose of each generation, one after the other")
    best = torch.unique_consecutive(search.points, dim=0)
    best[:, 3] = torch.tensor(np.unwrap(best[:, 3].numpy()))
    screws = with_vehicle(robots.docking_arm()).screws[:4]
    scene.add_chain(Chain(screws, torch.eye(4)), best[0], name="arm's base", axes=False)
    scene.add_box(VEHICLE, on="arm's base", joint=4, pose=_vehicle_on_base(), name="vehicle")
    share = torch.linspace(0, 1, frames + 1, dtype=torch.float64)[:frames, None]
    moves = [a + share * (b - a) for a, b in pairwise(best)]
    scene.animate("arm's base", torch.cat([*moves, best[-1].expand(4 * frames, 4)]), frames_per_second=12)
    scene.add_path(best[:, :3], name="way of the best pose")
    return scene


def _stage(title: str) -> Scene:
    scene, block = Scene(title, view_from=(-1.0, -0.5, 0.8)), PAPER.printed("block")
    scene.add_box(block, pose=docking.base_pose([0, 0, -block[2] / 2, 0]), name="block", color="orange")
    scene.add_path([*CORNERS.values(), CORNERS["K"]], name="task area")
    turn = np.linspace(-0.5 * np.pi, np.pi, 13)
    hook = [(0.04 * np.cos(angle), 0.0, 0.12 + 0.04 * np.sin(angle)) for angle in turn]
    scene.add_path([(0.0, 0.0, 0.0), *hook], name="hook", color="black")
    return scene


def _vehicle_on_base() -> Tensor:
    """Middle of the vehicle as the arm's base sees it: behind it, its bottom as low as the foot."""
    length, _, height = VEHICLE
    return docking.base_pose([-length / 2, 0, DockingProblem.foot[2] + height / 2, 0])
