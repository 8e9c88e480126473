"""The workspace of a PUMA 560, exactly and by two networks, the five notions of a workspace, and a control loop.

Sources: Liao & Mao (2018), sections I, VI.C and VII, Figs. 10 to 12. The networks are trained on the family of arms,
not on the PUMA: one has links, position and rotation matrix for inputs and predicts the body Jacobian, which is the
paper's way without its useless columns; the inputs and outputs of the other are those left in the plane of the arm.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import torch
from torch import Tensor

from dexterity import robots, spatial
from dexterity.chain import Chain
from dexterity.workspace import dataset, maps, reachability, training
from dexterity.workspace.jacobian_net import Architecture, JacobianNet
from dexterity.workspace.maps import ByClosedForm, ByNetwork, Grid, Map
from dexterity.workspace.resolved_rate import Circle, Method, track
from dexterity_study.engine.experiment import experiment

LINKS = (0.15, 0.4318, 0.4318, 0.0203)
"""d₃, d₄, a₂ and a₃ of the PUMA 560 [m]."""

NETWORKS: Mapping[str, tuple[Any, Any, Architecture]] = {
    "rotation": ("rotation", "tool", Architecture(confidence=(192,) * 3, estimation=(256,) * 3)),
    "plane": ("plane", "plane", Architecture(confidence=(64,) * 2, estimation=(128,) * 3)),
}
"""Inputs, entries of the Jacobian and widths of the networks; their two parts share no encoder."""

ALIGNED, RANDOM = "tool along the base", "random"
FEEDBACK, OPEN, FINE, SINGULAR = (
    "feedback",
    "no feedback",
    "fourth order, ten times the step",
    "near a singularity",
)

NOTIONS = ("reachable", "total_orientation", "constant_orientation", "dexterous")
HALF_SIDE = 1.0
"""Half the side of the cube that holds all that the PUMA reaches with a tool [m]."""

# A tool of 0.1 m along the last axis, where the notions are told apart.
_TOOL = spatial.pose(torch.eye(3, dtype=torch.float64), (0.0, 0.0, 0.1))

DOWN = ((1.0, 0.0, 0.0), (0.0, -1.0, 0.0), (0.0, 0.0, -1.0))
CIRCLE = Circle((0.2, 0.2, 0.2), radius=0.1, period=10.0, lean=math.radians(20), orientation=DOWN)
"""Path of the control loop, within the training cube and clear of singularities, with the tool leaning outwards."""

NEAR_SINGULAR = replace(CIRCLE, centre=(0.2, 0.0, 0.2))
"""The same circle where it passes over the shoulder's inner border."""

PATH = {"paper": "liao2018", "assumes": ("rate-control-path",)}
Made = tuple[list[dict[str, Any]], dict[str, Any]]


@experiment(arrays=("slices", "surface"), smoke={"per_side": 9})
def exact(seed: int, per_side: int = 65) -> Made:  # noqa: ARG001
    """The exact map of the training cube with the tool along the base's axes, its border and two slices of w."""
    grid = Grid.cube(maps.TRAINED_HALF_SIDE, per_side)
    found = maps.constant_orientation(ByClosedForm(LINKS), grid, torch.eye(3))
    row = {"largest": found.manipulability.max(), "share_reached": found.reached.double().mean()}
    return [row], {"slices": _slices(found), "surface": _cells(grid, surface(found.reached))}


@experiment(
    keys=("network", "case"),
    arrays=("slices", "invented", "missed", "position_error", "q"),
    smoke={"rows": (2_000, 1_000), "epochs": 1, "per_side": 9, "step": 0.25},
    # A training carries rounding errors on and makes them larger.
    rtol=0.05,
    atol=0.02,
    **PATH,
)
def learned(
    seed: int,
    reading: Mapping[str, Any],
    rows: tuple[int, int] = (297_000, 198_000),
    epochs: int = 40,
    per_side: int = 65,
    step: float | None = None,
) -> Made:
    """Networks trained with rows for confidence and estimation: their maps, and the loop on their Jacobians.

    Cells that a network alone takes for in reach, or for out of it, come with its number in the first column.
    """
    grid = Grid.cube(maps.TRAINED_HALF_SIDE, per_side)
    random = torch.Generator().manual_seed(seed)
    angles = math.tau * torch.rand(*grid.shape, 3, generator=random, dtype=torch.float64)
    orientations = {ALIGNED: torch.eye(3).double(), RANDOM: dataset.rotation(angles)}
    made: list[dict[str, Any]] = []
    parts: dict[str, list[Any]] = {}
    for number, name in enumerate(NETWORKS):
        network = trained(name, seed, rows, epochs)
        jacobian = partial(_estimate, network)
        for case, R in orientations.items():
            T = spatial.pose(R.expand(*grid.shape, 3, 3), grid.points())
            ours, truth = _ask(ByNetwork(network, LINKS), T), _ask(ByClosedForm(LINKS), T)
            made.append({"network": name, "case": case, **agreement(ours, truth)})
            if case == ALIGNED:
                parts.setdefault("slices", []).append(_slices(ours))
                alone = {"invented": ours.reached & ~truth.reached, "missed": truth.reached & ~ours.reached}
                for kind, mask in alone.items():
                    parts.setdefault(kind, []).append(np.insert(_cells(grid, mask), 0, number, axis=1))
        for case in (FEEDBACK, OPEN):
            facts, curves = _loop(jacobian, reading, step, open_loop=case == OPEN)
            made.append({"network": name, "case": case, **facts})
            for kind, curve in curves.items():
                parts.setdefault(kind, []).append(curve)
    arrays = {kind: np.concatenate(parts[kind]) for kind in ("invented", "missed")}
    return made, arrays | {kind: np.stack(parts[kind]) for kind in ("slices", "position_error", "q")}


@experiment(
    keys=("arm",), arrays=("share",), smoke={"per_side": 7, "orientations": 24}, data=("robots/puma560.toml",)
)
def notions(seed: int, per_side: int = 33, orientations: int = 192) -> Made:  # noqa: ARG001
    """Volumes [m³] of the workspaces by what the arm has, and the share of the orientations for y = 0."""
    puma, grid = robots.puma560(), Grid.cube(HALF_SIDE, per_side)
    limits, tool = {"lower": puma.lower, "upper": puma.upper}, {"T_flange_tool": _TOOL}
    arms: dict[str, dict[str, Any]] = {
        "neither": {},
        "limits": limits,
        "tool": tool,
        "limits and tool": limits | tool,
    }
    down = torch.tensor(DOWN, dtype=torch.float64)
    # Straight down is one of them, so that what has all has that one.
    R = torch.cat([down[None], maps.rotations(orientations - 1)])
    near = maps.around(R, (0.0, 0.0, -1.0), math.radians(45))
    cell = (2 * HALF_SIDE / (per_side - 1)) ** 3
    made, shares = [], []
    for name, has in arms.items():
        answer = ByClosedForm(LINKS, None, backend="c", **has)
        found = maps.survey(answer, grid, R, near)
        constant = maps.constant_orientation(answer, grid, down)
        sets = (found.reachable, found.total_orientation, constant.reached, found.dexterous)
        volumes = zip(NOTIONS, (cell * int(cells.sum()) for cells in sets), strict=True)
        made.append({"arm": name, **dict(volumes), "mean_share": found.share[found.reachable].mean()})
        shares.append(found.share[:, per_side // 2].float().numpy())
    return made, {"share": np.stack(shares)}


@experiment(
    keys=("case",),
    arrays=("position_error", "q"),
    readings=("rate-control-path=gain-5", "rate-control-path=gain-10", "rate-control-path=gain-20"),
    smoke={"step": 0.25},
    **PATH,
)
def loops(seed: int, reading: Mapping[str, Any], step: float | None = None) -> Made:  # noqa: ARG001
    """The control loop on the exact Jacobian."""
    J = tracking_arm().geometric_jacobian
    runs = {
        FEEDBACK: _loop(J, reading, step),
        OPEN: _loop(J, reading, step, open_loop=True),
        FINE: _loop(J, reading, step, method="rk4", coarser=10),
        SINGULAR: _loop(J, reading, step, circle=NEAR_SINGULAR),
    }
    kept = [runs[case][1] for case in (FEEDBACK, OPEN)]
    arrays = {kind: np.stack([curves[kind] for curves in kept]) for kind in kept[0]}
    return [{"case": case, **facts} for case, (facts, _) in runs.items()], arrays


# ---- networks and maps -----------------------------------------------------------------------------


def trained(name: str, seed: int, rows: tuple[int, int], epochs: int) -> JacobianNet:
    """Train a network on the family of arms."""
    inputs, entries, architecture = NETWORKS[name]
    jacobians = dataset.jacobian_data(rows[1], 2 * seed + 2, dynamics=False)
    network = training.network_for(architecture, inputs, entries, jacobians, seed)
    learned: dict[training.Head, training.Rows] = {
        "confidence": training.confidence_rows(network, dataset.confidence_data(rows[0], 2 * seed + 1)),
        "estimation": training.estimation_rows(network, jacobians),
    }
    options = training.Options(training.epochs(epochs, epochs), rate=3e-3, batch=512, validation=0.02)
    return training.train(network, learned, options, seed).network


def _ask(answer: maps.Answer, T: Tensor) -> Map:
    replies = [answer(some) for some in T.flatten(0, 2).split(maps.POSES_AT_ONCE)]
    reached, w = (torch.cat(parts).reshape(T.shape[:3]) for parts in zip(*replies, strict=True))
    return Map(reached, w)


def agreement(ours: Map, truth: Map) -> dict[str, float]:
    """Return intersections over union, and errors of w over the cells that both maps have, in shares of its largest."""
    a, b = ours.reached, truth.reached
    missed = (ours.manipulability - truth.manipulability).abs()[a & b] / truth.manipulability.max()
    errors = missed if len(missed) else torch.full((1,), math.inf, dtype=torch.float64)
    return {
        "reached": _overlap(a, b),
        "unreached": _overlap(~a, ~b),
        "right": (a == b).double().mean().item(),
        "median_error": errors.median().item(),
        "ninth_decile": errors.quantile(0.9).item(),
        "largest_error": errors.max().item(),
    }


def _overlap(a: Tensor, b: Tensor) -> float:
    return ((a & b).sum() / (a | b).sum().clamp(min=1)).item()


def _slices(found: Map) -> np.ndarray:
    """Return w [m³] for y = 0 by x and z, and for z = 0 by x and y, NaN out of reach."""
    w = torch.where(found.reached, found.manipulability, math.nan)
    middle = w.shape[0] // 2
    return torch.stack([w[:, middle], w[:, :, middle]]).float().numpy()


def surface(reached: Tensor) -> Tensor:
    """Tell which cells in reach have one of their six neighbours out of reach, or outside of the grid."""
    padded = torch.nn.functional.pad(reached, (1, 1, 1, 1, 1, 1))
    inner = [padded.roll(step, axis)[1:-1, 1:-1, 1:-1] for axis in range(3) for step in (-1, 1)]
    return reached & ~torch.stack(inner).all(0)


def _cells(grid: Grid, mask: Tensor, most: int = 2_000) -> np.ndarray:
    """Positions (k, 3) of a mask's cells; every so many, if they are more than can be drawn."""
    points = grid.points()[mask]
    return points[:: max(1, math.ceil(len(points) / most))].float().numpy()


# ---- arms and the loop -----------------------------------------------------------------------------


def tracking_arm() -> Chain:
    """Return the arm that follows the circle, without limits."""
    return reachability.arm(LINKS, "PUMA 560")


def _estimate(network: JacobianNet, q: Tensor) -> Tensor:
    """Fig. 12: the pose from the joint angles, the Jacobian from the pose."""
    links = torch.tensor(LINKS, dtype=torch.float64)
    return network.answer(links, tracking_arm().forward(q)).jacobian


def _loop(
    jacobian: Callable[[Tensor], Tensor],
    reading: Mapping[str, Any],
    step: float | None,
    *,
    circle: Circle = CIRCLE,
    open_loop: bool = False,
    method: Method = "euler",
    coarser: int = 1,
) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
    """Drive along a circle; curves are told some twenty times a second, NaN where a run had ended."""
    radius, period, rate, gain = reading["rate-control-path"]
    step, arm = min(coarser * (step or 1 / rate), 0.5), tracking_arm()
    path = replace(circle, radius=radius, period=period)
    start, _ = reachability.inverse(LINKS, path(torch.zeros((), dtype=torch.float64)).T_world_tool)
    gain = 0.0 if open_loop else gain
    found = track(path, arm.forward, jacobian, start, duration=period, step=step, gain=gain, method=method)
    estimated, truth = jacobian(found.q), arm.geometric_jacobian(found.q)
    wrong = torch.linalg.matrix_norm(estimated - truth) / torch.linalg.matrix_norm(truth)
    every = max(1, round(0.05 / step))
    curves = {}
    for kind, values in (("position_error", found.position_error), ("q", found.q)):
        curves[kind] = np.full(
            (round(period / step) // every + 1, *values.shape[1:]), np.nan, dtype=np.float32
        )
        told = values[::every]
        curves[kind][: len(told)] = told.numpy()
    return {
        "largest": found.position_error.max(),
        "last": found.position_error[-1],
        "orientation": found.orientation_error.max(),
        "jacobian_error": wrong.median(),
        "ended": found.message or "on time",
    }, curves
