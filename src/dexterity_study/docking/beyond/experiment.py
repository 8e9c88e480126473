"""The best poses with more control points, for a hovering vehicle and at the side of the block.

Source: Sotiropoulos, Aspragathos & Andritsos (2011), sections IV to VI. Nothing is weighed against distance (b = 0)
except at the side. A quarter turn about the middle of the task area maps the boxes of the group onto each other and
leaves M_a alone, so that one box is enough on top.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Any, TypeAlias

import torch
from torch import Tensor

from dexterity import docking, robots, sampling, spatial
from dexterity.docking import DockingProblem
from dexterity.search import GeneticOptions, genetic_search
from dexterity.timing import Way, measure
from dexterity_study.docking import cases
from dexterity_study.docking.cases import Rows, Values
from dexterity_study.docking.search.experiment import OTHERS, VARIABLES, by_grids, evolved
from dexterity_study.engine.experiment import experiment

BODY = (1.5, 1.2, 0.2)
"""How far the vehicle reaches behind the base, across, and below it [m]."""

Of: TypeAlias = Sequence[tuple[str, float]]
EXTENSIONS: Of = (("top", 0.1), ("top", 0.2), ("top", 0.3), ("side", 0.0))
"""Face of the block, and largest roll and pitch [rad]."""

TILTED = ("x", "y", "z", "roll", "pitch", "psi")
SIDES = (2, 3, 5, 9, 21)
OF_CASE: dict[str, Any] = {
    "assumes": ("fitted-arm", "reading-of-the-group"),
    "readings": OTHERS,
    **cases.PAPER,
    **cases.OF_DATA,
    **cases.ROUNDING,
}
GRIDS = {"levels": 3, "starts": 8, "shrink": 0.9}
"""Grids of three values a variable, since there are up to six."""

COARSE = {"step": 0.4, "turn_step": 0.8, "starts": 1, "stages": 2, "shrink": 0.85}
SMALL = {"some": (("top", 0.2), ("side", 0.0)), "generations": 3}


@experiment(keys=("points",), smoke={"per_sides": (2, 3), **COARSE}, **OF_CASE)
def points(seed: int, reading: Values, per_sides: Sequence[int] = SIDES, **grids: Any) -> Rows:  # noqa: ARG001
    """The best pose by number of control points: smallest w [m³] there, and on finer grids that have all of them."""
    for per_side in per_sides:
        own = cases.problem_of(reading, points=docking.square(0.2, per_side), distance_weight=0.0)
        best = by_grids(own, boxes=own.boxes[:1], **{**GRIDS, **grids})
        finest = docking.largest_manipulability(own.arm, best.pose, docking.square(0.2, 161))
        yield {
            "points": per_side**2,
            **dict(zip(VARIABLES, best.pose, strict=True)),
            "at_points": best.area_manipulability,
            "fine": docking.area_manipulability(own.arm, best.pose, docking.square(0.2, 21)),
            "finest": finest.min(),
            "dead": (finest == 0).double().mean(),
        }


@experiment(keys=("face", "tilt"), smoke={**SMALL, **COARSE, "evolutions": 1}, **OF_CASE)
def optimum(
    seed: int,
    reading: Values,
    some: Of = EXTENSIONS,
    evolutions: int = 3,
    generations: int = 500,
    **grids: Any,
) -> Rows:
    """The best pose of each extension, by grids and by differential evolution."""
    for face, tilt in some:
        own = extended(reading, face, tilt)
        objective, boxes = partial(worth, own), own.boxes if face == "side" else own.boxes[:1]
        seeds = range(seed, seed + evolutions)
        best = by_grids(own, objective, boxes, **{**GRIDS, **grids})
        yield {
            "face": face,
            "tilt": tilt,
            **dict(zip(TILTED if own.tilt else VARIABLES, best.pose, strict=True)),
            "area_manipulability": best.area_manipulability,
            "value": best.search.value,
            "evolved": evolved(objective, boxes, seeds, maxiter=generations),
            "lowest": lowest_point(best.pose),
        }


@experiment(seeds=30, keys=("face", "tilt"), smoke=SMALL, **OF_CASE)
def genetic(seed: int, reading: Values, some: Of = EXTENSIONS, generations: int = 500) -> Rows:
    """Fitness that a genetic run with the paper's sizes finds."""
    for face, tilt in some:
        own, random = extended(reading, face, tilt), torch.Generator().manual_seed(seed)
        steps, options = [0.01] * len(own.lower), GeneticOptions(generations=generations)
        found = genetic_search(partial(fitness, own), own.lower, own.upper, steps, random, options)
        yield {"face": face, "tilt": tilt, "fitness": found.value}


@experiment(
    keys=("points",),
    timed=True,
    unsteady=("rate",),
    smoke={"per_sides": (2, 3), "poses": 20},
    **cases.OF_DATA,
)
def rates(seed: int, per_sides: Sequence[int] = SIDES, poses: int = 20_000) -> Rows:
    """Random poses rated a second on one core, by number of control points; the fewer poses the more points."""
    own, random = DockingProblem(robots.docking_arm()), torch.Generator().manual_seed(seed)
    drawn = sampling.uniform(sampling.Box(own.lower, own.upper), poses, random)

    def way(per_side: int) -> Way:
        square, some = docking.square(0.2, per_side), drawn[: poses * 4 // per_side**2]
        return Way(str(per_side**2), lambda: docking.area_manipulability(own.arm, some, square), len(some))

    for timing in measure([way(per_side) for per_side in per_sides]):
        yield {"points": int(timing.name), "rate": 1 / timing.median}


def extended(reading: Values, face: str, tilt: float) -> DockingProblem:
    """Return the problem of a hovering vehicle, or that of docking upright at the side of the block.

    There the vehicle comes from 2 m before the middle, and holds on with a foot 0.2 m ahead of the arm's base. It may
    turn by 0.3 rad to either side, so that its bow stays clear.
    """
    if face == "top":
        return cases.problem_of(reading, tilt=tilt, height=(0.2, 0.5), distance_weight=0.0)
    before = {"start": (-2.0, 0.0, 0.0), "heading": 0.0, "foot": (0.2, 0.0, -0.3), "yaw": (-0.3, 0.3)}
    return cases.problem_of(reading, face="side", **before)


def lowest_point(pose: Tensor) -> Tensor:
    """Return z [m] (...) of the lowest corner of the vehicle's body, from poses (..., 4) or (..., 6)."""
    x, y, z = BODY
    corners = pose.new_tensor([(behind, across, -z) for behind in (-x, 0) for across in (-y / 2, y / 2)])
    return spatial.apply(docking.base_pose(pose)[..., None, :, :], corners)[..., 2].amin(-1)


def worth(problem: DockingProblem, pose: Tensor) -> Tensor:
    """Return the objective (...) of poses; where a tilted body is in the block, how deep it is, below zero."""
    if problem.face == "side":
        return problem.objective(pose)
    depth = lowest_point(pose).clamp(max=0)
    return torch.where(depth < -1e-9, depth, problem.objective(pose))


def fitness(problem: DockingProblem, pose: Tensor) -> Tensor:
    """Return the worth (...) of poses that are allowed, as Eq. 15 has it, and 0 for others."""
    return torch.where(problem.allows(pose), worth(problem, pose), 0.0)
