"""The workspace of a PUMA 560, exactly and by two networks, the five notions of a workspace, and a control loop.

Sources: Liao & Mao (2018), sections I, VI.C and VII, Figs. 10 to 12. The networks are trained on the family of arms,
not on the PUMA: one has links, position and rotation matrix for inputs and predicts the body Jacobian, which is the
paper's way without its useless columns; the inputs and outputs of the other are those left in the plane of the arm.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import torch
from scipy import ndimage
from torch import Tensor

from dexterity import robots, spatial
from dexterity.chain import Chain
from dexterity.workspace import dataset, maps, reachability, training
from dexterity.workspace.jacobian_net import Architecture, JacobianNet
from dexterity.workspace.maps import ByClosedForm, ByNetwork, Grid, Map
from dexterity.workspace.resolved_rate import Circle, Method, track
from dexterity_study.engine.experiment import experiment
from dexterity_study.workspace.estimation.experiment import Way, fit

LINKS = (0.15, 0.4318, 0.4318, 0.0203)
"""d₃, d₄, a₂ and a₃ of the PUMA 560 [m]."""

NETWORKS: Mapping[str, Way] = {
    "rotation": Way("rotation", "tool", Architecture(confidence=(192,) * 3, estimation=(256,) * 3)),
    "plane": Way("plane", "plane", Architecture(confidence=(64,) * 2, estimation=(128,) * 3)),
}

ALIGNED, RANDOM = "tool along the base", "random"
FEEDBACK, OPEN = "feedback", "no feedback"
FINE, SINGULAR = "fourth order, ten times the step", "near a singularity"

NOTIONS = ("reachable", "total_orientation", "constant_orientation", "dexterous")
HALF_SIDE = 1.0
"""Half the side of the cube that holds all that the PUMA reaches with a tool [m]."""

# A tool of 0.1 m along the last axis, where the notions are told apart.
_TOOL = spatial.pose(torch.eye(3, dtype=torch.float64), (0.0, 0.0, 0.1))

DOWN = ((1.0, 0.0, 0.0), (0.0, -1.0, 0.0), (0.0, 0.0, -1.0))
CIRCLE = Circle((0.2, 0.2, 0.2), radius=0.1, period=10.0, lean=math.radians(20), orientation=DOWN)
"""Path of the control loop, within the training cube and clear of singularities, with the tool leaning outwards."""

RUNS: Mapping[str, Mapping[str, Any]] = {
    FEEDBACK: {},
    OPEN: {"open_loop": True},
    FINE: {"method": "rk4", "coarser": 10},
    # The same circle where it passes over the shoulder's inner border.
    SINGULAR: {"circle": replace(CIRCLE, centre=(0.2, 0.0, 0.2))},
}
"""Runs of the control loop on the exact Jacobian; networks have the first two."""

PATH = {"paper": "liao2018", "assumes": ("rate-control-path",)}
Made = tuple[list[dict[str, Any]], dict[str, Any]]


@experiment(arrays=("slices", "surface"), smoke={"per_side": 9})
def exact(seed: int, per_side: int = 65) -> Made:  # noqa: ARG001
    """The exact map of the training cube with the tool along the base's axes, its border and two slices of w."""
    grid = Grid.cube(maps.TRAINED_HALF_SIDE, per_side)
    found = maps.constant_orientation(ByClosedForm(LINKS), grid, torch.eye(3))
    row = {"largest": found.manipulability.max(), "share_reached": found.reached.double().mean()}
    border = found.reached & ~torch.as_tensor(ndimage.binary_erosion(found.reached))
    return [row], {"slices": _slices(found), "surface": _cells(grid, border)}


@experiment(
    keys=("network", "case"),
    arrays=("slices", "invented", "missed", "position_error", "q"),
    smoke={"rows": (2_000, 1_000), "epochs": 1, "per_side": 9, "step": 0.25},
    # A training carries rounding errors on and makes them larger.
    rtol=0.05,
    atol=0.02,
    unsteady=("ended",),
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
    confidence = dataset.confidence_data(rows[0], 2 * seed + 1)
    jacobians = dataset.jacobian_data(rows[1], 2 * seed + 2, dynamics=False)
    options = training.Options(training.epochs(epochs, epochs), rate=3e-3, batch=512, validation=0.02)
    made: list[dict[str, Any]] = []
    parts: defaultdict[str, list[Any]] = defaultdict(list)
    for number, (name, way) in enumerate(NETWORKS.items()):
        network = fit(way, (confidence, jacobians), options, seed).network
        for case, R in orientations.items():
            T = spatial.pose(R.expand(*grid.shape, 3, 3), grid.points())
            ours, truth = _ask(ByNetwork(network, LINKS), T), _ask(ByClosedForm(LINKS), T)
            made.append({"network": name, "case": case, **agreement(ours, truth)})
            if case == ALIGNED:
                parts["slices"].append(_slices(ours)[None])
                for kind, a, b in (("invented", ours, truth), ("missed", truth, ours)):
                    alone = _cells(grid, a.reached & ~b.reached)
                    parts[kind].append(np.insert(alone, 0, number, axis=1))
        for case in (FEEDBACK, OPEN):
            facts, curves = _loop(partial(_estimate, network), reading, step, **RUNS[case])
            made.append({"network": name, "case": case, **facts})
            for kind, curve in curves.items():
                parts[kind].append(curve[None])
    return made, {kind: np.concatenate(arrays) for kind, arrays in parts.items()}


@experiment(
    keys=("arm",), arrays=("share",), smoke={"per_side": 7, "orientations": 24}, data=("robots/puma560.toml",)
)
def notions(seed: int, per_side: int = 33, orientations: int = 192) -> Made:  # noqa: ARG001
    """Volumes [m³] of the workspaces by what the arm has, and the share of the orientations for y = 0."""
    puma, grid = robots.puma560(), Grid.cube(HALF_SIDE, per_side)
    limits, tool = {"lower": puma.lower, "upper": puma.upper}, {"T_flange_tool": _TOOL}
    arms: dict[str, Any] = {"neither": {}, "limits": limits, "tool": tool, "limits and tool": limits | tool}
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
    runs = {case: _loop(J, reading, step, **settings) for case, settings in RUNS.items()}
    kept = [runs[case][1] for case in (FEEDBACK, OPEN)]
    arrays = {kind: np.stack([curves[kind] for curves in kept]) for kind in kept[0]}
    return [{"case": case, **facts} for case, (facts, _) in runs.items()], arrays


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


def _cells(grid: Grid, mask: Tensor, most: int = 2_000) -> np.ndarray:
    """Positions (k, 3) of a mask's cells; every so many, if they are more than can be drawn."""
    points = grid.points()[mask]
    return points[:: max(1, math.ceil(len(points) / most))].float().numpy()


def tracking_arm() -> Chain:
    """Return the arm that follows the circle, without limits."""
    return reachability.arm(LINKS, "PUMA 560")


def _estimate(network: JacobianNet, q: Tensor) -> Tensor:
    """Fig. 12: the pose from the joint angles, the Jacobian from the pose."""
    return network.answer(LINKS, tracking_arm().forward(q)).jacobian


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
    frames = round(period / step) // every + 1

    def told(values: Tensor) -> np.ndarray:
        own = values[::every].float().numpy()
        return np.concatenate([own, np.full_like(own, np.nan, shape=(frames - len(own), *own.shape[1:]))])

    return {
        "largest": found.position_error.max(),
        "last": found.position_error[-1],
        "orientation": found.orientation_error.max(),
        "jacobian_error": wrong.median(),
        "ended": found.message or "on time",
    }, {"position_error": told(found.position_error), "q": told(found.q)}
