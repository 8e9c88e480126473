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

from dexterity import docking, robots, spatial
from dexterity.docking import DockingProblem
from dexterity.search import GeneticOptions, ZoomOptions, ZoomSearch, genetic_search, zoom_search
from dexterity.search.box import Objective
from dexterity.timing import Way, measure
from dexterity_study.docking import cases
from dexterity_study.docking.cases import Rows, Values
from dexterity_study.docking.search.experiment import OTHERS, Box, evolved
from dexterity_study.engine.experiment import experiment

BODY = (1.5, 1.2, 0.2)
"""How far the vehicle reaches behind the base, across, and below it [m]."""

Of: TypeAlias = Sequence[tuple[str, float]]
EXTENSIONS: Of = (("top", 0.1), ("top", 0.2), ("top", 0.3), ("side", 0.0))
"""Face of the block, and largest roll and pitch [rad]."""

SIDES = (2, 3, 5, 9, 21)
ASSUMED = ("fitted-arm", "reading-of-the-group")
OF_CASE: dict[str, Any] = {"assumes": ASSUMED, **cases.PAPER, **cases.OF_DATA, **cases.ROUNDING}
SOME = {"some": (("top", 0.2), ("side", 0.0))}
COARSE = {"step": 0.4, "turn_step": 0.8, "starts": 1, "stages": 2, "shrink": 0.85}


@experiment(keys=("points",), readings=OTHERS, smoke={"per_sides": (2, 3), **COARSE}, **OF_CASE)
def points(seed: int, reading: Values, per_sides: Sequence[int] = SIDES, **grids: Any) -> Rows:  # noqa: ARG001
    """The best pose by number of control points: smallest w [m³] there, and on finer grids that have all of them."""
    for per_side in per_sides:
        own = cases.problem_of(reading, points=docking.square(0.2, per_side), distance_weight=0.0)
        pose = _by_grids(own, own.objective, own.boxes[0], **grids).point
        finest = docking.largest_manipulability(own.arm, pose, docking.square(0.2, 161))
        yield {
            "points": per_side**2,
            **_named(pose),
            "at_points": own.area_manipulability(pose),
            "fine": docking.area_manipulability(own.arm, pose, docking.square(0.2, 21)),
            "finest": finest.min(),
            "dead": (finest == 0).double().mean(),
        }


@experiment(
    keys=("face", "tilt"),
    readings=OTHERS,
    smoke={**SOME, **COARSE, "evolutions": 1, "generations": 3},
    **OF_CASE,
)
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
        objective = partial(worth, own)
        boxes = own.boxes if face == "side" else own.boxes[:1]
        best = max((_by_grids(own, objective, box, **grids) for box in boxes), key=lambda one: one.value)
        tries = [(box, one) for box in boxes for one in range(seed, seed + evolutions)]
        yield {
            "face": face,
            "tilt": tilt,
            **_named(best.point),
            "area_manipulability": own.area_manipulability(best.point),
            "value": best.value,
            "evolved": max(evolved(objective, box, one, generations) for box, one in tries),
            "lowest": lowest_point(best.point),
        }


@experiment(seeds=30, keys=("face", "tilt"), readings=OTHERS, smoke={**SOME, "generations": 3}, **OF_CASE)
def genetic(seed: int, reading: Values, some: Of = EXTENSIONS, generations: int = 500) -> Rows:
    """Fitness that a genetic run with the paper's sizes finds."""
    for face, tilt in some:
        own, random = extended(reading, face, tilt), torch.Generator().manual_seed(seed)
        steps, options = [0.01] * len(own.lower), GeneticOptions(generations=generations)

        def fitness(poses: Tensor, own: DockingProblem = own) -> Tensor:
            return torch.where(own.allows(poses), worth(own, poses), 0.0)

        found = genetic_search(fitness, own.lower, own.upper, steps, random, options)
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
    unit = torch.rand(poses, 4, generator=random, dtype=torch.float64)
    drawn = own.lower + (own.upper - own.lower) * unit

    def way(per_side: int) -> Way:
        square, some = docking.square(0.2, per_side), drawn[: poses * 4 // per_side**2]
        return Way(str(per_side**2), lambda: docking.area_manipulability(own.arm, some, square), len(some))

    for timing in measure([way(per_side) for per_side in per_sides]):
        yield {"points": int(timing.name), "rate": 1 / timing.median}


# ---- shared with views and tests -------------------------------------------------------------------


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


# ---- searches --------------------------------------------------------------------------------------


def _named(pose: Tensor) -> dict[str, Tensor]:
    names = ("x", "y", "z", "roll", "pitch", "psi") if len(pose) == 6 else ("x", "y", "z", "psi")
    return dict(zip(names, pose, strict=True))


def _by_grids(
    problem: DockingProblem,
    objective: Objective,
    box: Box,
    step: float = 0.05,
    turn_step: float = 0.1,
    **options: Any,
) -> ZoomSearch:
    """Grids of three values a variable, since there are up to six."""
    tilts = [problem.tilt] * (len(problem.lower) - 4)
    zoom = ZoomOptions(**{"levels": 3, "stages": 200, **options})
    return zoom_search(objective, *box, [step, step, step, *tilts, turn_step], zoom)
