"""Table 1 used: candidate configurations, ranked for different tasks, and what each ranking costs.

Source: Sotiropoulos & Aspragathos (2016), section 2.3. The candidates stand in front of a panel and differ in
where the vehicle is and how the arm reaches.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
import torch
from torch import Tensor

from dexterity import robots, spatial, tasks
from dexterity.indices import Index, kinematic_conditioning, manipulability, velocity_ellipsoid
from dexterity_study.engine.experiment import experiment
from dexterity_study.engine.table import Row
from dexterity_study.uvms.indices.experiment import VEHICLE_LOCKED, rank_correlations
from dexterity_study.uvms.kinematics.experiment import ROUNDING, largest
from dexterity_study.uvms.tasks import goals
from dexterity_study.uvms.tasks.candidates import SETS, candidates

OF_DATA = {"data": ("robots/uvms.toml", "tasks.toml")}
RANDOM = {"seeds": 50, "smoke": {"count": 20}, **ROUNDING, **OF_DATA}


@experiment(keys=("index",), **OF_DATA)
def table() -> Iterator[Row]:
    """Tasks of Table 1 that go with each index."""
    listed = [task for task in tasks.TASKS.values() if "Table 1" in task.where]
    for index in ("manipulability", "kinematic_conditioning"):
        yield {"index": index, "tasks": sum(task.index == index for task in listed)}


@experiment(
    keys=("pair",),
    paper="sotiropoulos2016",
    assumes=("candidate-configurations",),
    readings=("candidate-configurations=300",),
    reading_seeds=10,
    **RANDOM,
)
def agreement(seed: int, reading: Mapping[str, Any], count: int | None = None) -> Iterator[Row]:
    """Kendall's τ between two rankings of the same candidates."""
    chain = robots.uvms()
    q = candidates(seed, count or reading["candidate-configurations"])
    w, kci = (tasks.rank(chain, q, task, frame="spatial").values for task in ("valve turning", "welding"))
    J = chain.geometric_jacobian(q)
    tool_axis = chain.forward(q)[:, :3, 1]
    push, torque = (1 / (tool_axis[:, None] @ rows).norm(dim=-1)[:, 0] for rows in (J[:, :3], J[:, 3:]))
    accuracy = -largest_error(J)
    about_tool = kinematic_conditioning(J)
    pairs = {
        "w, KCI": (w, kci),
        "w: free, locked vehicle": (w, Index("manipulability", joint_rates=VEHICLE_LOCKED).bind(chain)(q)),
        "w, largest speed": (w, velocity_ellipsoid(J, "translational").semi_axes[:, 0]),
        "w, torque about the tool": (w, torque),
        "w, push along the tool": (w, push),
        "KCI: spatial, geometric": (kci, about_tool),
        "spatial KCI, accuracy": (kci, accuracy),
        "geometric KCI, accuracy": (about_tool, accuracy),
    }
    yield from rank_correlations(pairs)


@experiment(**RANDOM)
def choice(seed: int, count: int = 100) -> Iterator[Row]:
    """Deviation of the candidates from their common tool pose, and how much they differ in w and KCI."""
    chain = robots.uvms()
    q = candidates(seed, count)
    w, kci = (tasks.rank(chain, q, task, frame="spatial").values for task in ("valve turning", "welding"))
    yield {
        "pose": largest(chain.forward(q) - chain.home),
        "w_ratio": w.max() / w.min(),
        "kci_ratio": kci.max() / kci.min(),
    }


@experiment(
    keys=("ahead",),
    arrays=("ahead", "across", "tau", "loss", "beaten"),
    seeds=10,
    smoke={"count": 20, "step": 0.75},
    **ROUNDING,
    **OF_DATA,
)
def origins(seed: int, count: int = 100, step: float = 0.25) -> tuple[list[Row], dict[str, Any]]:
    """Rank candidates that hold the tool at rest by KCI about many places of the world's origin.

    Places are given in metres from the centre of gravity at the reference configuration. The rows are those straight
    ahead; the arrays (2, across, ahead) are planes through the vehicle and the tool, level and upright.
    """
    chain = robots.uvms()
    q = candidates(seed, count)
    J, error = chain.spatial_jacobian(q), largest_error(chain.geometric_jacobian(q))
    ahead, across = np.arange(-0.75, 3.25 + step / 2, step), np.arange(-1.5, 1.5 + step / 2, step)

    def judged(aside: float, along: float, above: float) -> goals.Effect:
        return goals.effect(_kci_about((aside, along, above), J), error)

    level = [[dataclasses.astuple(judged(x, y, 0.0)) for y in ahead] for x in across]
    upright = [[dataclasses.astuple(judged(0.0, y, z)) for y in ahead] for z in across]
    maps = np.array([level, upright], dtype=np.float32)
    rows: list[Row] = [{"ahead": y, **dataclasses.asdict(judged(0.0, y, 0.0))} for y in ahead]
    named = {name: maps[..., i] for i, name in enumerate(("tau", "loss", "beaten"))}
    return rows, {"ahead": ahead, "across": across, **named}


@experiment(
    keys=("set", "index"),
    paper="sotiropoulos2016",
    assumes=("world-origin",),
    readings=("world-origin=arm-base", "world-origin=tool", "world-origin=beyond-the-tool"),
    seeds=10,
    reading_seeds=10,
    smoke={"count": 20},
    **ROUNDING,
    **OF_DATA,
)
def candidate_sets(seed: int, reading: Mapping[str, Any], count: int = 100) -> Iterator[Row]:
    """Rank candidates of each set by indices, against the largest tool error that joint errors of unit norm cause."""
    chain = robots.uvms()
    for name, candidate_set in SETS.items():
        q, moves = candidate_set.draw(seed, count), candidate_set.moves
        about_origin, about_tool = chain.spatial_jacobian(q) * moves, chain.geometric_jacobian(q) * moves
        error = largest_error(about_tool)
        scores = {
            "w": manipulability(about_tool),
            "spatial KCI": _kci_about(reading["world-origin"], about_origin),
            "geometric KCI": kinematic_conditioning(about_tool),
            "tool deviation": -Index("tool_deviation", "geometric", candidate_set.joint_rates)(chain, q),
        }
        for index, score in scores.items():
            yield {"set": name, "index": index, **_judged(score, error)}


@experiment(
    keys=("task", "set", "index"),
    paper="sotiropoulos2016",
    assumes=("tool-noise",),
    readings=("tool-noise=docked", "tool-noise=drifting"),
    seeds=10,
    reading_seeds=3,
    smoke={"count": 20, "draws": 64},
    **ROUNDING,
    **OF_DATA,
)
def task_indices(seed: int, reading: Mapping[str, Any], count: int = 100, draws: int = 1024) -> Iterator[Row]:
    """Rank candidates of each set for three tasks, by the indices of the paper and by one that means the task."""
    chain = robots.uvms()
    for name, candidate_set in SETS.items():
        q, moves = candidate_set.draw(seed, count), candidate_set.moves
        noise = joint_noise(reading["tool-noise"]) * moves
        J, rates = chain.body_jacobian(q) * moves, candidate_set.joint_rates
        means_the_task = task_index(rates, noise)
        costs = {
            "valve, on its axis": goals.effort_per_force(J, TOOL_AXIS),
            "valve, at its rim": goals.effort_per_force(J, ACROSS),
            "seam": goals.time_per_metre(J, ACROSS),
            "panel": goals.root_mean_square_miss(chain, q, noise, seed, draws),
        }
        paper = {
            "w": manipulability(J),
            "spatial KCI": kinematic_conditioning(chain.spatial_jacobian(q) * moves),
            "geometric KCI": kinematic_conditioning(J),
        }
        for task, cost in costs.items():
            index = means_the_task[task]
            own = index(chain, q) * (1 if index.measure.larger_is_better else -1)
            for title, score in {**paper, OWN_INDEX: own}.items():
                yield {"task": task, "set": name, "index": title, **_judged(score, cost)}


OWN_INDEX = "the task's own"
"""Name of the index that means the task."""

TOOL_AXIS, ACROSS = 4, 0
"""Rows of the body Jacobian: the rotation about the tool's y, which points ahead, and the velocity along its x.

The x axis is the direction of the seam, and that of the force at the rim of a valve.
"""


def task_index(joint_rates: tuple[float, ...], noise: Tensor) -> Mapping[str, Index]:
    """Return the indices that mean the tasks, by task, for joint rates and noise (12,) of each joint."""
    return {
        "valve, on its axis": Index("force_ratio", "body", joint_rates, direction="wy"),
        "valve, at its rim": Index("force_ratio", "body", joint_rates, direction="vx"),
        "seam": Index("velocity_ratio", "body", joint_rates, direction="vx"),
        "panel": Index(
            "tool_deviation", "body", joint_rates, rows="translational", joint_noise=tuple(noise.tolist())
        ),
    }


def joint_noise(noise: tuple[float, float, float]) -> Tensor:
    """Return standard deviations (12,) [m] and [rad] for those of the vehicle [m], [degree] and of the arm [degree]."""
    metres, vehicle_deg, arm_deg = noise
    return torch.tensor([metres] * 3 + [*np.radians([vehicle_deg] * 3 + [arm_deg] * 6)], dtype=torch.float64)


def _judged(score: Tensor, cost: Tensor) -> Row:
    """Return the effect of a ranking, and how much the largest cost is above the least."""
    return {**dataclasses.asdict(goals.effect(score, cost)), "spread": cost.max() / cost.min()}


def largest_error(J: Tensor) -> Tensor:
    """Return the largest tool error (m,) that joint errors of unit norm cause, for geometric Jacobians."""
    return velocity_ellipsoid(J).semi_axes[:, 0]


def _kci_about(place: tuple[float, ...], J: Tensor) -> Tensor:
    """Return KCI (m,) of spatial Jacobians as if the world's origin were at a place [m]."""
    shift = spatial.pose(torch.eye(3, dtype=torch.float64), -torch.tensor(place, dtype=torch.float64))
    return kinematic_conditioning(spatial.adjoint(shift) @ J)
