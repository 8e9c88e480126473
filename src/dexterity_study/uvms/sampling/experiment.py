"""Data sets of paper A, and what networks make of them: as printed, read otherwise, and extended.

All errors are relative, Eq. 21. A training has the paper's limit of epochs, and no goal that would end it earlier.

Source: Sotiropoulos & Aspragathos (2016), sections 3.1 and 4.2, Eqs. 11 and 12, Fig. 7, Tables 2 and 3.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cache
from typing import Any, TypeAlias, cast

import numpy as np
import torch
from torch import Tensor

from dexterity import robots, sampling, symbolic
from dexterity.chain import Chain
from dexterity.indices import Index
from dexterity.networks.feed_forward import FeedForward
from dexterity.networks.levenberg_marquardt import Options, levenberg_marquardt
from dexterity.networks.network import View
from dexterity.networks.problem import largest_relative_error
from dexterity.sampling import Box, Method, Space, TaskSector
from dexterity_study.engine.experiment import experiment

INDICES: Mapping[str, Index] = {"w": Index("manipulability"), "KCI": Index("kinematic_conditioning")}
"""The two indices of the paper, with unit limits, in the spatial frame."""

METHODS: tuple[Method, ...] = ("grid", "sobol", "uniform")
AS_PRINTED = "as printed"
FROM_VEHICLE = (
    "origin seen from the vehicle, cone"  # the origin as input in place of θ1 … θ4, a cone as readout
)
SHARES = np.linspace(0, 1, 201)
SEED_OF_RANGES, SEED_OF_FRESH = 1000, 1001
OF_DATA = {"data": ("robots/uvms.toml",)}
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
    *(("KCI", network, (1.0,), (3,)) for network in (AS_PRINTED, FROM_VEHICLE)),
)
OF_TRAINING = {"rtol": 1e-3, "atol": 1e-6, **OF_DATA}  # a training carries rounding errors on


@experiment(
    seeds=(SEED_OF_RANGES,),
    keys=("index",),
    arrays=("w_grid", "w_uniform", "KCI_grid", "KCI_uniform"),
    smoke={"drawn": 500},
    **OF_DATA,
)
def values(seed: int, drawn: int = 50_000) -> tuple[list[dict[str, Any]], dict[str, Any]]:
    """Joints that vary in the space of each index, from 1, and quantiles of the index by kind of draw."""
    rows, arrays = [], {}
    for name, index in INDICES.items():
        space = sampling.uvms_space(index.name)
        rows.append({"index": name, "inputs": " ".join(str(joint + 1) for joint in varying(space))})
        on_grid = sampling.on_grid(space, drawn, torch.Generator().manual_seed(seed))
        for kind, q in (("grid", on_grid), ("uniform", draw(space, drawn, seed))):
            arrays[f"{name}_{kind}"] = np.quantile(_exact(name)(q).numpy(), SHARES).astype(np.float32)
    return rows, arrays


@experiment(
    seeds=3,
    paper="sotiropoulos2016",
    assumes=("task-point", "sector-of-the-base", "base-orientation", "base-position-without-rotation"),
    readings=tuple(CHOICES)[1:],
    smoke={**SMALL, "neurons": 3, "rows": 100, "drawn": 500},
    **OF_TRAINING,
)
def search_area(
    seed: int,
    reading: Mapping[str, Any],
    neurons: int = 25,
    rows: int = 3000,
    drawn: int = 50_000,
    **sizes: Any,
) -> Iterator[dict[str, Any]]:
    """KCI and its kinks, distances of the arm's base from the task point [m], reachability, and networks."""
    chain, space = robots.uvms(), sector(reading)
    q = draw(space, drawn)
    sigma = torch.linalg.svdvals(chain.spatial_jacobian(q))
    task = q.new_tensor(space.task_point)
    distance = (base_pose(chain, q)[..., :3, 3] - task).norm(dim=-1)
    reached = reaching(chain, q, space.task_point)
    can = reached.isfinite().all(-1)
    yield {
        **_extremes("KCI", space, drawn),
        "kinks": (sigma[..., 4] < 1.02 * sigma[..., 5]).double().mean(),
        "nearest": distance.min(),
        "farthest": distance.max(),
        "reachable": can.double().mean(),
        "reaching_error": (chain.forward(reached[can])[..., :3, 3] - task).norm(dim=-1).max(),
        **_errors("KCI", space, neurons, rows, seed, **sizes),
    }


@experiment(
    seeds=10,
    keys=("index", "method", "neurons", "rows"),
    smoke={**SMALL, "neurons": (2, 3), "rows": (50, 100), "kci_rows": (100, 200)},
    **OF_TRAINING,
)
def training_sets(
    seed: int,
    neurons: tuple[int, int] = (8, 25),
    rows: Sequence[int] = (300, 1000, 3000, 10_000),
    kci_rows: Sequence[int] = (1000, 3000, 10_000),
    **sizes: Any,
) -> Iterator[dict[str, Any]]:
    """Networks of the printed sizes, by kind of draw and rows of the training set."""
    cases = [("w", method, neurons[0], count) for method in METHODS for count in rows]
    cases += [("KCI", "grid", neurons[1], count) for count in kci_rows]
    for index, method, size, count in cases:
        space = sampling.uvms_space(INDICES[index].name)
        errors = _errors(index, space, size, count, seed, method=method, **sizes)
        yield {"index": index, "method": method, "neurons": size, "rows": count, **errors}


@experiment(
    seeds=3,
    keys=("index", "network", "half_width", "neurons"),
    smoke={**SMALL, "cases": SMALL_CASES, "rows": 100, "drawn": 500},
    **OF_TRAINING,
)
def extensions(
    seed: int, cases: Sequence[Case] = CASES, rows: int = 5000, drawn: int = 50_000, **sizes: Any
) -> Iterator[dict[str, Any]]:
    """Networks for w with joints in wider ranges [°], and for KCI with the vehicle anywhere in a cube [m]."""
    for index, network, half_widths, neurons in cases:
        for half_width in half_widths:
            wide = (
                sampling.uvms_space("manipulability", half_width) if index == "w" else _anywhere(half_width)
            )
            extremes = _extremes(index, wide, drawn)
            for size in neurons:
                errors = _errors(index, wide, size, rows, seed, network=network, **sizes)
                keys = {"index": index, "network": network, "half_width": half_width, "neurons": size}
                yield {**keys, **extremes, **errors}


# ---- spaces ----------------------------------------------------------------------------------------


def sector(reading: Mapping[str, Any]) -> TaskSector:
    """Return the space of KCI for a reading of what the paper leaves open about it."""
    space = _sector(task_point=reading["task-point"], turned=reading["base-position-without-rotation"])
    azimuth, elevation = map(math.radians, reading["sector-of-the-base"])
    turn = (math.radians(reading["base-orientation"]),) * 3
    rest = Box([-x for x in turn] + list(space.rest.lower[3:]), turn + space.rest.upper[3:], 7)
    return replace(space, azimuth=azimuth, elevation=elevation, rest=rest)


def _sector(**choices: Any) -> TaskSector:
    return cast(TaskSector, sampling.uvms_space("kinematic_conditioning", **choices))


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


def reaching(chain: Chain, q: Tensor, task_point: Sequence[float]) -> Tensor:
    """Turn θ7, θ8 and θ9 of (..., 12) joint values until the wrist is at a point in the world [m].

    The shoulder is at the arm's base, l1 = 0; the three are NaN where the point is out of reach.
    """
    T_world_base = base_pose(chain, q)
    out = q.new_tensor(task_point) - T_world_base[..., :3, 3]
    x, y, z = (T_world_base[..., :3, :3].mT @ out[..., None])[..., 0].unbind(-1)
    lengths = robots.describe("uvms").lengths
    upper, lower = lengths["l2"], lengths["l3"]
    elbow = torch.acos((out.square().sum(-1) - upper**2 - lower**2) / (2 * upper * lower))
    beside = torch.atan2(lower * elbow.sin(), upper + lower * elbow.cos())
    shoulder = torch.atan2(-z, torch.hypot(x, y)) - beside
    return torch.cat([q[..., :6], torch.stack([torch.atan2(-x, y), shoulder, elbow], -1), q[..., 9:]], -1)


def base_pose(chain: Chain, q: Tensor) -> Tensor:
    """Return the pose of the arm's base, turned with the vehicle: T_world_base (..., 4, 4)."""
    arm_at_home = q.clone()
    arm_at_home[..., 6:] = 0.0
    T_tool_base = torch.eye(4, dtype=q.dtype)
    T_tool_base[1, 3] = robots.describe("uvms").lengths["y_MB"] - chain.home[1, 3]
    return chain.forward(arm_at_home) @ T_tool_base


# ---- trainings -------------------------------------------------------------------------------------


@cache
def _exact(index: str) -> symbolic.CompiledIndex:
    return symbolic.compile_index(robots.uvms(), INDICES[index], "c")


def _extremes(index: str, space: Space, drawn: int) -> dict[str, Any]:
    lowest, highest = _exact(index)(draw(space, drawn)).aminmax()
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
    f, chain = _exact(index), robots.uvms()
    data = sampling.data_sets(f, space, train=rows, test=test, validation=test, seed=seed, method=method)
    q, y, random = data.train.q, data.train.values, torch.Generator().manual_seed(seed)
    if network == FROM_VEHICLE:
        view = View(chain.joints, [joint for joint in varying(space) if joint > 3], chain.screws[:6])
        untrained = FeedForward.untrained(view, neurons, q, y, random, "cone")
    else:
        untrained = FeedForward.untrained(View(chain.joints, varying(space)), neurons, q, y, random)
    trained = levenberg_marquardt(untrained, q, y, Options(epochs=epochs)).network
    points = draw(space, fresh, SEED_OF_FRESH)
    with torch.no_grad():
        errors = (trained(points) / f(points) - 1).abs()
    return {
        "testing_error": largest_relative_error(trained, data.test),
        "between": largest_relative_error(trained, data.validation),
        "fresh": errors.max(),
        "most": errors.quantile(0.99),
    }
