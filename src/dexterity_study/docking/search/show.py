"""Figures, tables and scenes of the chapter on the genetic search."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import torch
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from torch import Tensor

from dexterity.docking import DockingProblem
from dexterity.scenes import Scene
from dexterity.scenes.colors import COLORS
from dexterity.search import GeneticSearch
from dexterity_study.docking import scenes
from dexterity_study.docking.area.show import ARM_COLORS
from dexterity_study.docking.cases import ARMS, CASES, arm_of, printed_poses, quarter_turned
from dexterity_study.docking.search.experiment import NEAR, VARIABLES, VEHICLE, genetic
from dexterity_study.docking.search.verdicts import found, optima, physical
from dexterity_study.engine.evidence import Evidence
from dexterity_study.page import figures
from dexterity_study.page.markup import Markup
from dexterity_study.page.numbers import with_range
from dexterity_study.page.tables import show

_STYLES = (("blue", "-"), ("sky blue", "--"), ("vermillion", "-"), ("orange", "--"))
REGIONS = {"and": "in x and y", "or": "in x or y"}


def names_of(case: str) -> tuple[str, str]:
    """Return a case in words: the arm, and where its base is next to the task area."""
    arm, _, region = case.partition(", ")
    return f"{arm} arm", REGIONS[region]


NAMES = {reading: names_of(case) for case, reading in CASES.items()}
STYLES: dict[str, Any] = {
    reading: {"color": COLORS[name], "ls": ls, "label": ", ".join(NAMES[reading]).replace(" arm", "")}
    for reading, (name, ls) in zip(CASES.values(), _STYLES, strict=True)
}


def by_case(table: pd.DataFrame) -> pd.DataFrame:
    """Return the rows of the four cases, by their readings, under arm and place of the base in words."""
    names = pd.MultiIndex.from_tuples(NAMES.values(), names=["arm", "base next to the area"])
    return table.loc[[*NAMES]].set_axis(names)


def optimum(stored: Evidence) -> Markup:
    """Set the true optima."""
    heads = {
        "x": "$x$ [m]",
        "y": "$y$ [m]",
        "z": "$z$ [m]",
        "psi": "$ψ$ [rad]",
        "area_manipulability": "$M_a$ [m³]",
        "distance": "$D$ [m]",
    }
    best = by_case(optima(stored)).rename(columns=heads)[[*heads.values()]].astype(float)
    return show(best, "{:.2f}", forms={"$M_a$ [m³]": "{:.4f}"})


def around(stored: Evidence) -> Markup:
    """Set what the best poses are worth if the arm goes around the block, and around its vehicle as well."""
    worth = worth_by_bodies(stored)
    heads = {name: ("$M_a$ [m³]", name) for name in worth}
    pose = _nearest_quarter(physical(stored, "block and vehicle"))
    base = {name: ("base, around both [m]", f"${name}$") for name in pose}
    table = pd.concat([worth.rename(columns=heads), pose.rename(columns=base)], axis="columns")
    table.columns = pd.MultiIndex.from_tuples([*heads.values(), *base.values()])
    forms = dict.fromkeys(heads.values(), "{:.4f}")
    return show(by_case(table), "{:.2f}", forms=forms)


def _nearest_quarter(best: pd.DataFrame) -> pd.DataFrame:
    """Return places of the base by reading, turned by quarter turns to where the start is; all are equally good."""
    poses = torch.tensor(best[[*VARIABLES]].astype(float).to_numpy())
    images = torch.stack([quarter_turned(poses, turns) for turns in range(4)])
    nearest = images[images[..., :2].sum(-1).argmin(0), torch.arange(len(poses))]
    return pd.DataFrame(nearest[:, :3].numpy(), best.index, ["x", "y", "z"])


def worth_by_bodies(stored: Evidence) -> pd.DataFrame:
    """Return M_a of the best poses by reading: through all, around the block, and around block and vehicle."""
    columns = {"through all": optima(stored)["area_manipulability"].loc[[*NAMES]]}
    for name in ("block", "block and vehicle"):
        columns[f"around {name}"] = physical(stored, name)["area_manipulability"]
    return pd.DataFrame(columns).astype(float)


def share_left(stored: Evidence) -> str:
    """Return how much of M_a is left for an arm that goes around block and vehicle, from case to case."""
    worth = worth_by_bodies(stored)
    left = 100 * worth["around block and vehicle"] / worth["through all"]
    return f"{left.min():.0f} to {left.max():.0f} %"


def shares(stored: Evidence) -> Figure:
    """Draw the fitness of genetic runs relative to the true optimum, sorted."""
    fig, ax = plt.subplots(figsize=(figures.WIDTH, 3.6))
    runs = 100 * found(stored)["share"]
    for reading, style in STYLES.items():
        ax.ecdf(runs[reading], orientation="horizontal", **style)
    ax.axhline(100 * NEAR, color="#595959", lw=1.2, zorder=0)
    ax.text(0.99, 100 * NEAR - 0.3, "near the optimum", color="#595959", ha="right", va="top")
    ax.set(
        xlabel="share of the runs",
        ylabel="fitness [% of the optimum]",
        ylim=(83, 100.5),
        yticks=[85, 90, 95, 100],
    )
    fig.legend(title="arm, and where its base is next to the area", loc="outside upper center", ncols=2)
    return fig


def methods(stored: Evidence) -> Markup:
    """Set what genetic runs, other methods and climbs by gradients find, relative to the true optimum."""
    runs = found(stored).loc[[*NAMES]]
    groups = runs.assign(near=runs["share"] >= NEAR).groupby("reading", sort=False)
    peers = stored["peers"].where(None).set_index("reading").drop(columns="seed")
    peers = 100 * peers.div(optima(stored)["fitness"].loc[peers.index], axis="index")
    climbs = stored["gradients"].where(None).set_index("reading").astype(float)
    count = groups["evaluations"].median() / climbs["evaluations"]

    def medians(values: pd.Series) -> pd.Series:
        return values.groupby("reading", sort=False).apply(with_range, form="{:.0f}")

    columns = {
        ("genetic runs", "fitness [%]"): medians(100 * runs["share"]),
        ("genetic runs", "near [%]"): 100 * groups["near"].mean(),
        ("genetic runs", "nearest quarter [%]"): 100 * groups["on_quarter"].mean(),
        ("other methods", "differential evolution [%]"): medians(peers["differential evolution"]),
        ("other methods", "CMA-ES [%]"): medians(peers["CMA-ES"]),
        ("other methods", "chance of climbs [%]"): 100 * (1 - (1 - climbs["climbed"]) ** count),
    }
    return show(by_case(pd.DataFrame(columns)), "{:.0f}")


def poses(stored: Evidence) -> Figure:
    """Draw the positions of the base: printed, by genetic runs, and of the true optima."""
    fig, panels = plt.subplots(1, 2, figsize=(figures.WIDTH, 3.0), sharex=True, sharey=True)
    printed, best = printed_poses(), optima(stored)
    for ax, (region, title) in zip(panels, REGIONS.items(), strict=True):
        ax.add_patch(Rectangle((-0.2, -0.2), 0.4, 0.4, color="#E6E6E6"))
        for arm in ARMS:
            reading = CASES[f"{arm}, {region}"]
            runs, color = stored["genetic"].where(reading), ARM_COLORS[arm]
            ax.plot(runs["x"], runs["y"], ".", ms=7, color=color, label=f"genetic, {arm} arm")
            ax.plot(
                *best.loc[reading, ["x", "y"]],
                "D",
                ms=8,
                mfc="none",
                mew=2,
                color=color,
                label=f"optimum, {arm} arm",
            )
        ax.plot(printed[:, 0], printed[:, 1], "x", color=COLORS["black"], label="printed")
        ax.set(title=f"next to it {title}", aspect="equal", xlabel="x [m]", ylabel="y [m]")
        ax.label_outer()
    fig.legend(*panels[0].get_legend_handles_labels(), loc="outside upper center", ncols=2)
    return fig


def front(stored: Evidence) -> Figure:
    """Draw the best pose and the quarter that genetic runs end on, as the distance counts more."""
    fig, panels = plt.subplots(2, 1, figsize=(figures.WIDTH, 4.8), sharex=True)
    heads = {
        "area_manipulability": "$M_a$ of the\nbest pose [m³]",
        "on_quarter": "share of the runs on\nthe nearest quarter",
    }
    for ax, (metric, head) in zip(panels, heads.items(), strict=True):
        for reading, style in STYLES.items():
            rows = stored["front"].where(reading)
            ax.plot(rows["ratio"], rows[metric], marker="o", ms=4, **style)
        ratio = DockingProblem.distance_weight / DockingProblem.manipulability_weight
        ax.axvline(ratio, color="#595959", lw=1.2, ls=":")
        ax.set_xscale("symlog", linthresh=5e-4)
        ax.set(ylabel=head, xlim=(-1e-4, 0.2), xticks=[0, 1e-3, 1e-2, 1e-1])
    panels[-1].set(xlabel="weight of the distance, b/a [m²]")
    handles, labels = panels[0].get_legend_handles_labels()
    fig.legend(
        handles,
        labels,
        loc="outside upper center",
        ncols=2,
        title="arm, and where its base is next to the area",
    )
    return fig


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
