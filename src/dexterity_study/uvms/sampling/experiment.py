"""Data sets of paper A, and what networks make of them: as printed, read otherwise, and extended.

All errors are relative, Eq. 21. A training has the paper's limit of epochs, and no goal that would end it earlier.

Source: Sotiropoulos & Aspragathos (2016), sections 3.1 and 4.2, Eqs. 11 and 12, Fig. 7, Tables 2 and 3.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from itertools import product
from typing import Any, TypeAlias, cast

import torch
from torch import Tensor

from dexterity import robots, sampling
from dexterity.networks import train, validation
from dexterity.networks.levenberg_marquardt import Options
from dexterity.networks.network import View
from dexterity.networks.problem import largest_relative_error
from dexterity.sampling import Box, Method, Space, TaskSector
from dexterity_study.engine.experiment import experiment
from dexterity_study.uvms.feed_forward.experiment import AS_PRINTED, INDICES, OF_DATA, Rows, Values, compiled

METHODS: tuple[Method, ...] = ("grid", "sobol", "uniform")
TRAINING_SETS = {"w": (8, (300, 1000, 3000, 10_000)), "KCI": (25, (1000, 3000, 10_000))}
FROM_VEHICLE = "origin seen from the vehicle, cone"
SEED_OF_RANGES, SEED_OF_FRESH = 1000, 1001
SMALL = {"test": 100, "fresh": 500, "epochs": 5}
CHOICES = {
    "chosen": "as assumed",
    "task-point=world-origin": "task point at the world's origin",
    "task-point=farther-ahead": "task point 2 m farther ahead",
    "base-position-without-rotation=turned": "turned base in the area",
    "sector-of-the-base=half-angle": "30° to either side",
    "sector-of-the-base=planar": "area in the x–y plane",
    "base-orientation=upright": "vehicle upright",
}
"""What is chosen about the space of KCI, by reading."""

Case: TypeAlias = tuple[str, str, Sequence[float], Sequence[int]]
CASES: Sequence[Case] = (
    ("w", AS_PRINTED, (15.0, 30.0, 45.0, 90.0, 180.0), (8, 20, 40)),
    ("KCI", AS_PRINTED, (0.5, 1.0, 2.0), (25,)),
    ("KCI", FROM_VEHICLE, (0.5, 1.0, 2.0), (25, 40)),
)
"""Wider spaces: index, network, half widths and numbers of neurons."""

SMALL_CASES = (
    ("w", AS_PRINTED, (15.0, 90.0), (2,)),
    ("KCI", AS_PRINTED, (1.0,), (3,)),
    ("KCI", FROM_VEHICLE, (1.0,), (3,)),
)


@experiment(seeds=(SEED_OF_RANGES,), keys=("index",), data=OF_DATA["data"])
def values() -> Rows:
    """Joints that vary in the space of each index, from 1."""
    for name, index in INDICES.items():
        inputs = varying(sampling.uvms_space(index.name))
        yield {"index": name, "inputs": " ".join(str(joint + 1) for joint in inputs)}


@experiment(
    seeds=3,
    paper="sotiropoulos2016",
    assumes=("task-point", "sector-of-the-base", "base-orientation", "base-position-without-rotation"),
    readings=tuple(CHOICES)[1:],
    smoke={**SMALL, "neurons": 3, "rows": 100, "drawn": 500},
    **OF_DATA,
)
def search_area(
    seed: int, reading: Values, neurons: int = 25, rows: int = 3000, drawn: int = 50_000, **sizes: Any
) -> Rows:
    """KCI and its kinks, distances of the arm's base from the task point [m], reachability, and networks."""
    space = sector(reading)
    q = draw(space, drawn)
    sigma = torch.linalg.svdvals(robots.uvms().spatial_jacobian(q))
    distance = (base_positions(q) - q.new_tensor(space.task_point)).norm(dim=-1)
    yield {
        **_extremes("KCI", space, drawn),
        "kinks": (sigma[..., 4] < 1.02 * sigma[..., 5]).double().mean(),
        "nearest": distance.min(),
        "farthest": distance.max(),
        # The radii are those of the arm's workspace.
        "reachable": ((distance >= space.r_min) & (distance <= space.r_max)).double().mean(),
        **_errors("KCI", space, neurons, rows, seed, **sizes),
    }


@experiment(
    seeds=10,
    keys=("index", "method", "neurons", "rows"),
    smoke={**SMALL, "of": {"w": (2, (50, 100)), "KCI": (3, (100, 200))}},
    **OF_DATA,
)
def training_sets(seed: int, of: Values = TRAINING_SETS, **sizes: Any) -> Rows:
    """Networks of the printed sizes, by kind of draw and rows of the training set."""
    for index, (neurons, counts) in of.items():
        space = sampling.uvms_space(INDICES[index].name)
        for method, rows in product(METHODS if index == "w" else METHODS[:1], counts):
            errors = _errors(index, space, neurons, rows, seed, method=method, **sizes)
            yield {"index": index, "method": method, "neurons": neurons, "rows": rows, **errors}


@experiment(
    seeds=3,
    keys=("index", "network", "half_width", "neurons"),
    smoke={**SMALL, "cases": SMALL_CASES, "rows": 100, "drawn": 500},
    **OF_DATA,
)
def extensions(
    seed: int, cases: Sequence[Case] = CASES, rows: int = 5000, drawn: int = 50_000, **sizes: Any
) -> Rows:
    """Networks for w with joints in wider ranges [°], and for KCI with the vehicle anywhere in a cube [m]."""
    for index, network, half_widths, neurons in cases:
        for width in half_widths:
            wide = sampling.uvms_space("manipulability", width) if index == "w" else _anywhere(width)
            extremes = _extremes(index, wide, drawn)
            for size in neurons:
                errors = _errors(index, wide, size, rows, seed, network=network, **sizes)
                keys = {"index": index, "network": network, "half_width": width, "neurons": size}
                yield {**keys, **extremes, **errors}


def sector(reading: Values) -> TaskSector:
    """Return the space of KCI for a reading of what the paper leaves open about it."""
    space = _sector()
    azimuth, elevation = map(math.radians, reading["sector-of-the-base"])
    turn = (math.radians(reading["base-orientation"]),) * 3
    rest = Box([-x for x in turn] + list(space.rest.lower[3:]), turn + space.rest.upper[3:], 7)
    point, turned = reading["task-point"], reading["base-position-without-rotation"]
    return replace(space, task_point=point, azimuth=azimuth, elevation=elevation, rest=rest, turned=turned)


def _sector() -> TaskSector:
    return cast(TaskSector, sampling.uvms_space("kinematic_conditioning"))


def _anywhere(half_width: float) -> Box:
    rest, cube = _sector().rest, (half_width,) * 3
    return Box([-x for x in cube] + list(rest.lower), cube + rest.upper, (None,) * 3 + rest.levels)


def varying(space: Space) -> list[int]:
    """Return the joints that vary in a space, from 0."""
    q = space.from_unit(torch.stack([torch.zeros(space.dimensions), torch.ones(space.dimensions)]))
    return (q[0] != q[1]).nonzero().flatten().tolist()


def draw(space: Space, configurations: int, seed: int = SEED_OF_RANGES) -> Tensor:
    """Draw configurations (m, n) uniformly."""
    return sampling.uniform(space, configurations, torch.Generator().manual_seed(seed))


def base_positions(q: Tensor) -> Tensor:
    """Return where the arm's base is in the world (..., 3) [m]."""
    chain, arm_at_home = robots.uvms(), q.clone()
    arm_at_home[..., 6:] = 0.0
    T_world_tool = chain.forward(arm_at_home)
    behind = robots.describe("uvms").lengths["y_MB"] - chain.home[1, 3]
    return T_world_tool[..., :3, 3] + behind * T_world_tool[..., :3, 1]


def _extremes(index: str, space: Space, drawn: int) -> dict[str, Any]:
    lowest, highest = compiled(index)[0](draw(space, drawn)).aminmax()
    return {"lowest": lowest, "highest": highest}


def _errors(
    index: str,
    space: Space,
    neurons: int,
    rows: int,
    seed: int,
    *,
    method: Method = "grid",
    network: str = AS_PRINTED,
    test: int = 1000,
    fresh: int = 50_000,
    epochs: int = 100,
) -> dict[str, Any]:
    """Train a network and return its largest errors, and what 99 % of its errors on fresh points stay below."""
    f, chain, inputs = compiled(index)[0], robots.uvms(), varying(space)
    data = sampling.data_sets(f, space, train=rows, test=test, validation=test, seed=seed, method=method)
    learned, once = (data.train.q, data.train.values), Options(epochs=epochs)
    if network == FROM_VEHICLE:  # the origin is an input in place of θ1 … θ4
        view = View(chain.joints, [joint for joint in inputs if joint > 3], chain.screws[:6])
        (trained,) = train.for_seeds(view, neurons, *learned, [seed], once, readout="cone")
    else:
        (trained,) = train.for_seeds(View(chain.joints, inputs), neurons, *learned, [seed], once)
    errors = validation.judge(trained.network, validation.fresh(f, space, fresh, SEED_OF_FRESH, "uniform"))
    return {
        "testing_error": largest_relative_error(trained.network, data.test),
        "between": largest_relative_error(trained.network, data.validation),
        "fresh": errors.maximum,
        "most": errors.percentile_99,
    }
