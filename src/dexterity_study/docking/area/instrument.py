"""The live instrument of the part on docking: drag the vehicle, see where its arm is dexterous."""

from __future__ import annotations

from functools import cache

import torch
from torch import Tensor

from dexterity import docking
from dexterity.chain import Chain
from dexterity.docking import DockingProblem
from dexterity.docking.export import javascript_module
from dexterity_study.claims.ledger import load_paper
from dexterity_study.docking import cases
from dexterity_study.docking.area.experiment import control_points, elbow_of
from dexterity_study.engine.evidence import Evidence
from dexterity_study.page.instrument import Choice, Drawing, Instrument, Readout, Slider, script_beside

PER_SIDE = 41
"""Points a side of the map of w over the task area."""

_NAMES = ("x", "y", "z", "heading")


@cache
def problems() -> dict[str, DockingProblem]:
    """Return the docking problems of both arms by the names that the instrument has for them."""
    return {f"{name} arm": cases.problem_of(control_points.reading(key)) for name, key in cases.ARMS.items()}


def instrument() -> Instrument:
    """Return an instrument for the pose of the vehicle, x, y, z and heading of the arm's base in G."""
    lower, upper = problems()["stated arm"].lower.tolist(), problems()["stated arm"].upper.tolist()
    steps = {"x": 0.01, "y": 0.01, "z": 0.005, "heading": torch.pi / 180}
    units = {"x": "m", "y": "m", "z": "m", "heading": "°"}
    chosen = presets()
    first = next(iter(chosen.values()))
    sliders = [
        Slider(name, name, units[name], low, high, steps[name], float(first[name]))
        for name, low, high in zip(_NAMES, lower, upper, strict=True)
    ]
    length, width, _ = load_paper("sotiropoulos2011").printed("vehicle")
    half = DockingProblem.area / 2
    return Instrument(
        title="Docking pose and dexterity over the task area",
        hint="Drag the vehicle or its bow, or choose a pose. Orange is where the arm's manipulability w is zero.",
        controls=[*sliders, Choice("arm", "arm", list(problems()))],
        readouts={
            "Control points": [
                Readout("area", "area manipulability Mₐ", "m³"),
                *(Readout(corner, f"w at {corner}", "m³") for corner in cases.CORNERS),
            ],
            "Whole area": [
                Readout("dead", "share with w = 0", "%"),
                Readout("place", "middle of it (x, y)"),
                Readout("median", "median w", "m³"),
            ],
            "Docking": [
                Readout("distance", "distance D", "m"),
                Readout("fitness", "fitness", digits=4),
                Readout("allowed", "pose beside the area"),
            ],
        },
        drawings=[
            Drawing(
                "top",
                "Top view: block (grey), task area, and the vehicle with the foot of its arm (blue)",
                (-1.6, 1.1, -1.6, 1.1),
            ),
            Drawing(
                "area",
                "Task area: the darker the green, the larger w; orange where w = 0; ring where w is smallest, if it is not 0",
                (-1.2 * half, 1.2 * half, -1.2 * half, 1.2 * half),
            ),
        ],
        modules={name: javascript_module(problem) for name, problem in problems().items()},
        script=script_beside(__package__),
        presets=chosen,
        data={
            "perSide": PER_SIDE,
            "points": docking.square(half, PER_SIDE).tolist(),
            "half": half,
            "corners": cases.CORNERS,
            "block": [size / 2 for size in DockingProblem.block],
            "vehicle": [[x, y, 0.0] for x in (-length, 0.0) for y in (-width / 2, width / 2)],
            "largest": {name: largest_upright(problem.arm) for name, problem in problems().items()},
        },
    )


def presets() -> dict[str, dict[str, float | str]]:
    """Return poses of the paper, the best one, and one that has a dead spot between good corners."""
    stated = problems()["stated arm"]
    best = Evidence("docking.search")["optimum"].where()[["x", "y", "z", "psi"]]
    found = {
        "First run of the paper": cases.printed_poses()[0],
        "Ill-placed pose of the paper": cases.printed("ill-placed-pose"),
        "Best pose": torch.tensor(best.iloc[0].tolist(), dtype=torch.float64),
        "Good corners, dead spot": dead_spot(stated),
    }
    return {
        name: dict(zip(_NAMES, pose.tolist(), strict=True)) | {"arm": "stated arm"}
        for name, pose in found.items()
    }


def dead_spot(problem: DockingProblem, drawn: int = 20_000, seed: int = 0) -> Tensor:
    """Return the pose, of random ones beside the area, with the best corners of those that have a dead spot."""
    poses = cases.drawn_poses(problem, drawn, seed)
    corners = problem.area_manipulability(poses)
    poses = poses[corners.argsort(descending=True)[:1000]]
    fine = docking.area_manipulability(problem.arm, poses, docking.square(problem.area / 2, 21))
    return poses[(fine == 0).nonzero()[0, 0]]


def largest_upright(arm: Chain) -> float:
    """Return the largest w [m³] that an arm has anywhere with its tool upright, on a grid of 5 mm."""
    reach = elbow_of(arm).upper_arm + elbow_of(arm).forearm
    side = torch.arange(-reach, reach, 0.005, dtype=torch.float64)
    flat = torch.cartesian_prod(side[side > 0], torch.zeros(1, dtype=torch.float64), side)
    return docking.largest_manipulability(arm, [0.0, 0.0, 0.0, 0.0], flat).max().item()
