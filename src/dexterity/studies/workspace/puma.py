"""Paper C, sections I, VI.C and VII: the workspace of a PUMA 560, learned and exactly, and a loop on it.

Liao & Mao (2018), Figs. 10 to 12. Two small networks are trained on the family of arms, not on the PUMA: one
sees links, position and rotation matrix and predicts the body Jacobian, which is what the paper's does
without its useless columns; the other sees and predicts what is left in the plane of the arm. Both map the
PUMA beside the closed form. Then the five notions of a workspace are told apart, and a control loop runs on
the Jacobians.

What decides a verdict was set beforehand. Maps vary slightly if intersection over union is at least 0.95 for
the cells in reach and for those out of reach, and the median error of w, over the cells that both sides take
for reached, is at most 5 % of the largest w; both with the tool along the base's axes and with random
orientations. It is *reproduced* if the first network does it and *in shape* if only the second one does. An
estimated Jacobian is useful in the loop if the first network keeps the tool within a hundredth of the
circle's radius (*reproduced*) or a tenth of it (*in shape*). The stored run is judged, for which training
takes longer.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from dexterity import robots, spatial
from dexterity.chain import Chain
from dexterity.report.claims import Acceptance, Outcome, Verdict
from dexterity.report.stored import Tolerance
from dexterity.scenes import Scene
from dexterity.scenes.colors import COLORS
from dexterity.workspace import dataset, maps, reachability, training
from dexterity.workspace.jacobian_net import Architecture, Entries, Inputs, JacobianNet
from dexterity.workspace.maps import ByClosedForm, ByNetwork, Grid, Map, Survey
from dexterity.workspace.resolved_rate import Circle, Method, Tracking, track

__all__ = [
    "CIRCLE",
    "CONFIGS",
    "EXACT",
    "LINKS",
    "NEAR_SINGULAR",
    "NETWORKS",
    "NOTIONS_HALF_SIDE",
    "TOLERANCE",
    "TOOL_LENGTH",
    "Agreement",
    "Config",
    "Learned",
    "Notions",
    "Result",
    "Run",
    "acceptance",
    "agreement_table",
    "difference_scene",
    "manipulability_scene",
    "notion_table",
    "puma_with_tool",
    "run",
    "run_table",
    "tracking_arm",
    "tracking_scene",
    "verdicts",
]

TOLERANCE = Tolerance(rtol=0.05, atol=0.02)
"""What a probe may miss by, since a training carries rounding errors on and makes them larger."""

JUDGED_AS_STORED = True

EXACT, GENERAL, PLANE = "exact", "rotation", "plane"
"""Who answers, the closed form or the networks of rotation matrices and of the plane of the arm."""

LINKS = (0.15, 0.4318, 0.4318, 0.0203)
"""d₃, d₄, a₂ and a₃ of the PUMA 560 [m]."""

TOOL_LENGTH = 0.1
"""Of a tool along the last axis, where the notions are told apart [m]."""

CIRCLE = Circle(
    centre=(0.2, 0.2, 0.2),
    radius=0.1,
    period=10.0,
    lean=math.radians(20),
    orientation=((1.0, 0.0, 0.0), (0.0, -1.0, 0.0), (0.0, 0.0, -1.0)),
)
"""Path of the control loop, a level circle within the training cube and clear of singularities, with the tool
downwards and leaning outwards."""

NEAR_SINGULAR = Circle(**{**vars(CIRCLE), "centre": (0.2, 0.0, 0.2)})
"""The same circle where it passes over the shoulder's inner border."""

_PAPER = "liao2018"
_HALF_SIDE = maps.TRAINED_HALF_SIDE
_SLIGHT_OVERLAP, _SLIGHT_ERROR = 0.95, 0.05
_CLOSE, _NEAR = 0.01, 0.1


@dataclass(frozen=True)
class Network:
    """What a network sees and predicts, and the widths of its two parts."""

    inputs: Inputs
    entries: Entries
    architecture: Architecture


NETWORKS: Mapping[str, Network] = {
    GENERAL: Network(
        "rotation", "tool", Architecture(confidence=(192, 192, 192), estimation=(256, 256, 256))
    ),
    PLANE: Network("plane", "plane", Architecture(confidence=(64, 64), estimation=(128, 128, 128))),
}
"""The two networks; their parts share no encoder."""


@dataclass(frozen=True)
class Config:
    """How much is trained, mapped and driven.

    Attributes
    ----------
    confidence_rows, estimation_rows
        Of the training sets.
    confidence_epochs, estimation_epochs
        How often these are gone through.
    seed
        Of training sets, weights, and random orientations.
    per_side
        Positions a side of the training cube.
    notions_per_side, orientations
        Of the larger cube in which the five notions are told apart.
    step
        Of the control loop [s].
    """

    confidence_rows: int = 60_000
    estimation_rows: int = 60_000
    confidence_epochs: int = 8
    estimation_epochs: int = 8
    seed: int = 0
    per_side: int = 65
    notions_per_side: int = 21
    orientations: int = 64
    step: float = 0.01


CONFIGS: Mapping[str, Config] = {
    "smoke": Config(
        confidence_rows=2_000,
        estimation_rows=1_000,
        confidence_epochs=1,
        estimation_epochs=1,
        per_side=9,
        notions_per_side=7,
        orientations=24,
        step=0.25,
    ),
    "book": Config(),
    "full": Config(
        confidence_rows=297_000,
        estimation_rows=198_000,
        confidence_epochs=40,
        estimation_epochs=40,
        notions_per_side=33,
        orientations=192,
    ),
}
"""What runs at each scale."""


@dataclass(frozen=True)
class Agreement:
    """A learned map beside the exact one.

    Attributes
    ----------
    reached, unreached
        Intersection over union of the cells in reach and of those out of reach.
    right
        Share of all cells that are taken for what they are.
    median_error, ninth_decile, largest_error
        Of w over the cells that both take for reached, as shares of the largest exact w.
    """

    reached: float
    unreached: float
    right: float
    median_error: float
    ninth_decile: float
    largest_error: float

    @property
    def is_slight(self) -> bool:
        """Whether the maps vary slightly."""
        overlap = min(self.reached, self.unreached)
        return overlap >= _SLIGHT_OVERLAP and self.median_error <= _SLIGHT_ERROR


@dataclass(frozen=True)
class Learned:
    """What a network does on the PUMA.

    Attributes
    ----------
    parameters
        How many numbers were trained.
    aligned, random
        How its map agrees with the exact one, with the tool along the base's axes, and with another random
        orientation in each cell.
    slices
        w [m³] of the aligned map for y = 0 (x, z by rows) and for z = 0 (x, y by rows), NaN out of reach.
    invented, missed
        (k, 3) cells [m] that it alone takes for reached, and that it alone takes for out of reach.
    masked
        Share of the circle on which it gives no Jacobian.
    """

    parameters: int
    aligned: Agreement
    random: Agreement
    slices: Mapping[str, NDArray[np.float64]]
    invented: NDArray[np.float64]
    missed: NDArray[np.float64]
    masked: float


@dataclass(frozen=True)
class Notions:
    """How large the five workspaces are, in cubic metres, and how they look for y = 0.

    Attributes
    ----------
    reachable, total_orientation, constant_orientation, dexterous
        Volumes [m³]: some of the orientations, all within 45° of downwards, straight down alone, all.
    mean_share
        Mean over the reachable positions of the share of orientations that a position has.
    share
        (n, n) share of the orientations for y = 0, x by rows.
    """

    reachable: float
    total_orientation: float
    constant_orientation: float
    dexterous: float
    mean_share: float
    share: NDArray[np.float64]


@dataclass(frozen=True)
class Run:
    """A run of the control loop, told some twenty times a second.

    Attributes
    ----------
    time
        (m,) [s].
    position_error
        (m,) of the tool [m].
    q
        (m, 6) joint angles [rad].
    largest_position_error, last_position_error, largest_orientation_error
        Over all steps [m] and [rad].
    jacobian_error
        Median over the run of ‖Ĵ − J‖ / ‖J‖, Frobenius' norms.
    message
        Why it ended before its time; empty if it did not.
    """

    time: NDArray[np.float64]
    position_error: NDArray[np.float64]
    q: NDArray[np.float64]
    largest_position_error: float
    last_position_error: float
    largest_orientation_error: float
    jacobian_error: float
    message: str


@dataclass(frozen=True)
class Result:
    """Maps, notions and runs.

    Attributes
    ----------
    largest
        Largest w of the exact map [m³].
    share_reached
        Share of the cells that are in reach.
    slices
        Of the exact map, as in :class:`Learned`.
    surface
        (k, 3) cells in reach with a neighbour that is not, or with none [m].
    learned
        What each network does.
    notions
        By what the arm has: neither limits nor a tool, one of them, both.
    runs
        Of the control loop, by the Jacobian that it uses.
    closed_form_error
        Largest difference of the closed form of w from all branches one by one, with limits and tool [m³].
    """

    largest: float
    share_reached: float
    slices: Mapping[str, NDArray[np.float64]]
    surface: NDArray[np.float64]
    learned: Mapping[str, Learned]
    notions: Mapping[str, Notions]
    runs: Mapping[str, Run]
    closed_form_error: float


def run(config: Config) -> Result:
    """Train, map, tell the notions apart, and drive along the circle."""
    grid = Grid.cube(_HALF_SIDE, config.per_side)
    exact = maps.constant_orientation(ByClosedForm(LINKS), grid, torch.eye(3))
    turned = _with_random_orientations(grid, config)
    turned_exact = _ask(ByClosedForm(LINKS), turned)
    networks = {name: _trained(network, config) for name, network in NETWORKS.items()}
    learned = {}
    for name, network in networks.items():
        answer = ByNetwork(network, LINKS)
        aligned = maps.constant_orientation(answer, grid, torch.eye(3))
        learned[name] = Learned(
            parameters=network.parameter_count,
            aligned=_agreement(aligned, exact),
            random=_agreement(_ask(answer, turned), turned_exact),
            slices=_slices(aligned),
            invented=_cells(grid, aligned.reached & ~exact.reached),
            missed=_cells(grid, exact.reached & ~aligned.reached),
            masked=_masked(network),
        )
    return Result(
        largest=exact.manipulability.max().item(),
        share_reached=exact.reached.double().mean().item(),
        slices=_slices(exact),
        surface=_cells(grid, _surface(exact.reached)),
        learned=learned,
        notions=_notions(config),
        runs=_runs(networks, config),
        closed_form_error=_closed_form_error(config),
    )


# ---- networks --------------------------------------------------------------------------------------


def _trained(network: Network, config: Config) -> JacobianNet:
    confidence = dataset.confidence_data(config.confidence_rows, 2 * config.seed + 1)
    jacobians = dataset.jacobian_data(config.estimation_rows, 2 * config.seed + 2, dynamics=False)
    made = training.network_for(network.architecture, network.inputs, network.entries, jacobians, config.seed)
    rows: dict[training.Head, training.Rows] = {
        "confidence": training.confidence_rows(made, confidence),
        "estimation": training.estimation_rows(made, jacobians),
    }
    schedule = training.epochs(config.confidence_epochs, config.estimation_epochs)
    options = training.Options(schedule, rate=3e-3, batch=512, validation=0.02)
    return training.train(made, rows, options, config.seed).network


# ---- maps ------------------------------------------------------------------------------------------


def _with_random_orientations(grid: Grid, config: Config) -> Tensor:
    """Poses (nx, ny, nz, 4, 4), each with an orientation of its own, uniform in three angles as the data."""
    random = torch.Generator().manual_seed(config.seed)
    angles = math.tau * torch.rand(*grid.shape, 3, generator=random, dtype=torch.float64)
    return spatial.pose(dataset.rotation(angles), grid.points())


def _ask(answer: maps.Answer, T: Tensor) -> Map:
    replies = [answer(some) for some in T.flatten(0, 2).split(maps.POSES_AT_ONCE)]
    reached, w = (torch.cat(parts).reshape(T.shape[:3]) for parts in zip(*replies, strict=True))
    return Map(reached, w)


def _agreement(ours: Map, exact: Map) -> Agreement:
    a, b = ours.reached, exact.reached
    both = a & b
    missed = (ours.manipulability - exact.manipulability).abs()[both] / exact.manipulability.max()
    errors = missed if len(missed) else torch.full((1,), math.inf, dtype=torch.float64)
    return Agreement(
        reached=_overlap(a, b),
        unreached=_overlap(~a, ~b),
        right=(a == b).double().mean().item(),
        median_error=errors.median().item(),
        ninth_decile=errors.quantile(0.9).item() if len(errors) < 2**24 else math.nan,
        largest_error=errors.max().item(),
    )


def _overlap(a: Tensor, b: Tensor) -> float:
    """Intersection over union."""
    return ((a & b).sum() / (a | b).sum().clamp(min=1)).item()


def _slices(found: Map) -> dict[str, NDArray[np.float64]]:
    w = torch.where(found.reached, found.manipulability, math.nan)
    middle = w.shape[0] // 2
    return {"y = 0": w[:, middle].numpy().round(5), "z = 0": w[:, :, middle].numpy().round(5)}


def _surface(reached: Tensor) -> Tensor:
    """Cells in reach with one of their six neighbours out of reach, or outside of the grid."""
    padded = torch.nn.functional.pad(reached, (1, 1, 1, 1, 1, 1))
    inner = reached.clone()
    for axis in range(3):
        for start in (0, 2):
            inner &= padded.narrow(axis, start, reached.shape[axis])[
                tuple(slice(None) if other == axis else slice(1, -1) for other in range(3))
            ]
    return reached & ~inner


def _cells(grid: Grid, mask: Tensor, most: int = 2_000) -> NDArray[np.float64]:
    """Positions (k, 3) of a mask's cells; every so many, if they are more than can be drawn."""
    points = grid.points()[mask]
    return points[:: max(1, math.ceil(len(points) / most))].numpy().round(4)


# ---- notions ---------------------------------------------------------------------------------------

NOTIONS_HALF_SIDE = 1.0
"""Half the side of the cube that holds all that the PUMA reaches with the tool [m]."""

_DOWN = (0.0, 0.0, -1.0)
_RANGE = math.radians(45)


def puma_with_tool() -> Chain:
    """Return the PUMA 560 with its published limits and the tool."""
    return maps.with_tool(robots.puma560(), _tool())


def _tool() -> Tensor:
    return spatial.pose(torch.eye(3, dtype=torch.float64), (0.0, 0.0, TOOL_LENGTH))


def _answers() -> dict[str, ByClosedForm]:
    puma = robots.puma560()
    limits, tool = {"lower": puma.lower, "upper": puma.upper}, {"T_flange_tool": _tool()}
    return {
        "neither": ByClosedForm(LINKS, None, backend="c"),
        "limits": ByClosedForm(LINKS, None, backend="c", **limits),
        "tool": ByClosedForm(LINKS, None, backend="c", **tool),
        "limits and tool": ByClosedForm(LINKS, None, backend="c", **limits, **tool),
    }


def _notions(config: Config) -> dict[str, Notions]:
    grid = Grid.cube(NOTIONS_HALF_SIDE, config.notions_per_side)
    down = torch.tensor(CIRCLE.orientation, dtype=torch.float64)
    # Straight down is one of them, so that what has all has that one.
    R = torch.cat([down[None], maps.rotations(config.orientations - 1)])
    chosen = maps.around(R, _DOWN, _RANGE)
    return {
        name: _measured(
            maps.survey(answer, grid, R, chosen), maps.constant_orientation(answer, grid, down), config
        )
        for name, answer in _answers().items()
    }


def _measured(found: Survey, constant: Map, config: Config) -> Notions:
    cell = (2 * NOTIONS_HALF_SIDE / (config.notions_per_side - 1)) ** 3

    def volume(cells: Tensor) -> float:
        return cell * int(cells.sum())

    share, middle = found.share, config.notions_per_side // 2
    return Notions(
        reachable=volume(found.reachable),
        total_orientation=volume(found.total_orientation),
        constant_orientation=volume(constant.reached),
        dexterous=volume(found.dexterous),
        mean_share=share[found.reachable].mean().item(),
        share=share[:, middle].numpy(),
    )


def _closed_form_error(config: Config) -> float:
    """Compare with all branches one by one, where limits and a tool decide."""
    grid = Grid.cube(0.7, 5)
    R = maps.rotations(min(config.orientations, 24))
    one = maps.survey(_answers()["limits and tool"], grid, R)
    other = maps.survey(maps.ByBranches(puma_with_tool()), grid, R)
    if not torch.equal(one.count, other.count):
        return math.inf
    return (one.largest - other.largest).abs().max().item()


# ---- the loop --------------------------------------------------------------------------------------

_OPEN = ", no feedback"
_FINE = ", fourth order, ten times the step"
_SINGULAR = ", near a singularity"


def tracking_arm() -> Chain:
    """Return the arm that follows the circle, without limits."""
    return reachability.arm(LINKS, "PUMA 560")


def _estimating(network: JacobianNet) -> Callable[[Tensor], Tensor]:
    """Fig. 12: the pose from the joint angles, the Jacobian from the pose."""
    arm, links = tracking_arm(), torch.tensor(LINKS, dtype=torch.float64)
    return lambda q: network.answer(links, arm.forward(q)).jacobian


def _runs(networks: Mapping[str, JacobianNet], config: Config) -> dict[str, Run]:
    exact = tracking_arm().geometric_jacobian
    jacobians = {EXACT: exact, **{name: _estimating(network) for name, network in networks.items()}}
    runs = {name: _run(jacobian, config) for name, jacobian in jacobians.items()}
    runs |= {name + _OPEN: _run(jacobian, config, gain=0.0) for name, jacobian in jacobians.items()}
    runs[EXACT + _FINE] = _run(exact, replace(config, step=min(10 * config.step, 0.5)), method="rk4")
    runs[EXACT + _SINGULAR] = _run(exact, config, circle=NEAR_SINGULAR)
    return runs


def _run(
    jacobian: Callable[[Tensor], Tensor],
    config: Config,
    *,
    circle: Circle = CIRCLE,
    gain: float = 1.0,
    method: Method = "euler",
) -> Run:
    arm = tracking_arm()
    start, _ = reachability.inverse(LINKS, circle(torch.zeros((), dtype=torch.float64)).T_world_tool)
    found = track(
        circle, arm.forward, jacobian, start,
        duration=circle.period, step=config.step, gain=gain, method=method,
    )  # fmt: skip
    return _told(found, jacobian(found.q), arm.geometric_jacobian(found.q), config)


def _told(found: Tracking, estimated: Tensor, exact: Tensor, config: Config) -> Run:
    wrong = torch.linalg.matrix_norm(estimated - exact) / torch.linalg.matrix_norm(exact)
    told = slice(None, None, max(1, round(0.05 / config.step)))
    return Run(
        time=found.time[told].numpy(),
        position_error=found.position_error[told].numpy().round(9),
        q=found.q[told].numpy().round(4),
        largest_position_error=found.position_error.max().item(),
        last_position_error=found.position_error[-1].item(),
        largest_orientation_error=found.orientation_error.max().item(),
        jacobian_error=wrong.median().item(),
        message=found.message,
    )


def _masked(network: JacobianNet) -> float:
    times = torch.linspace(0, CIRCLE.period, 200, dtype=torch.float64)
    links = torch.tensor(LINKS, dtype=torch.float64)
    return 1 - network.answer(links, CIRCLE(times).T_world_tool).mask.double().mean().item()


# ---- scenes and tables ----------------------------------------------------------------------------


_PALETTE = ("blue", "sky blue", "bluish green", "yellow", "orange")


def manipulability_scene(per_side: int = 41) -> Scene:
    """Show what the PUMA reaches in three sections, by the w of the best branch, with the tool upright."""
    answer = ByClosedForm(LINKS, None)
    side, middle = torch.linspace(-0.9, 0.9, per_side, dtype=torch.float64), torch.zeros(1).double()
    # The section square to the first one is left out where it would hide that.
    grids = Grid(side, middle, side), Grid(middle, side[side > 0], side), Grid(side, side[side > 0], middle)
    cuts = [maps.constant_orientation(answer, grid, torch.eye(3)) for grid in grids]
    points, w, reached = (
        torch.cat([part.flatten(0, 2) for part in parts])
        for parts in (
            [grid.points() for grid in grids],
            [cut.manipulability for cut in cuts],
            [cut.reached for cut in cuts],
        )
    )
    scene = Scene("Three sections through what the PUMA 560 reaches", view_from=(0.6, -1.0, 0.5))
    scene.add_chain(tracking_arm(), [-1.2, 0.9, -2.2, 0.0, 0.6, 0.0], axes=False)
    classes = (w / w.max() * len(_PALETTE)).long().clamp(max=len(_PALETTE) - 1)
    for i, color in enumerate(_PALETTE):
        low, high = (w.max().item() * step / len(_PALETTE) for step in (i, i + 1))
        inside = points[reached & (classes == i)]
        scene.add_points(inside, name=f"w {low:.3f}–{high:.3f} m³", size=1.8 / per_side, color=color)
    return scene


def difference_scene(result: Result, network: str) -> Scene:
    """Show the surface of what is in reach within the training cube, and where a network is wrong."""
    learned = result.learned[network]
    scene = Scene(f"Where the network ({network}) is wrong about the PUMA", view_from=(0.6, -1.0, 0.5))
    inner = np.abs(result.surface).max(axis=1) < 0.999 * _HALF_SIDE
    for name, points, size, color in (
        ("inner border of what is in reach", result.surface[inner], 0.006, "sky blue"),
        ("out of reach, taken for in reach", learned.invented, 0.014, "vermillion"),
        ("in reach, taken for out of reach", learned.missed, 0.014, "black"),
    ):
        if len(points):
            scene.add_points(points, name=name, size=size, color=color)
    return scene


def tracking_scene(result: Result) -> Scene:
    """Show the arm on its way round the circle, with the exact Jacobian and that of the first network."""
    scene = Scene("Round a circle by resolved rates", view_from=(1.0, 0.3, 0.6))
    for name, color in ((GENERAL, "vermillion"), (EXACT, "blue")):
        frames = result.runs[name].q
        scene.add_chain(tracking_arm(), frames[0], name=f"{name} Jacobian", axes=False, color=COLORS[color])
        if len(frames) > 1:
            scene.animate(f"{name} Jacobian", frames, frames_per_second=20)
        scene.add_path(tracking_arm().forward(frames)[:, :3, 3], name=f"tool, {name} Jacobian", color=color)
    return scene


def agreement_table(result: Result) -> dict[str, dict[str, float]]:
    """Tell how the learned maps agree with the exact one; errors of w in per cent of its largest value."""
    return {
        f"{name}, {kind}": {
            "IoU in reach": found.reached,
            "IoU out of reach": found.unreached,
            "right": found.right,
            "error of w, median [%]": 100 * found.median_error,
            "nine in ten below [%]": 100 * found.ninth_decile,
            "largest [%]": 100 * found.largest_error,
        }
        for name, learned in result.learned.items()
        for kind, found in (("tool along the base", learned.aligned), ("random", learned.random))
    }


def notion_table(result: Result) -> dict[str, dict[str, float]]:
    """Volumes [m³] of four workspaces, and the mean share of the orientations, the measure of the fifth."""
    return {
        name: {
            "reachable": notions.reachable,
            "within 45° of down": notions.total_orientation,
            "straight down": notions.constant_orientation,
            "dexterous": notions.dexterous,
            "mean share of orientations": notions.mean_share,
        }
        for name, notions in result.notions.items()
    }


def run_table(result: Result) -> dict[str, dict[str, float | str]]:
    """Errors of the runs of the control loop."""
    return {
        name: {
            "Jacobian off by [%]": 100 * found.jacobian_error,
            "position, largest [mm]": 1e3 * found.largest_position_error,
            "position, end [mm]": 1e3 * found.last_position_error,
            "orientation, largest [mrad]": 1e3 * found.largest_orientation_error,
            "ended": found.message or "on time",
        }
        for name, found in result.runs.items()
    }


# ---- verdicts --------------------------------------------------------------------------------------


def verdicts(result: Result) -> tuple[Verdict, ...]:
    """Judge the claims of the ledger that this study answers for."""
    return (*_on_notions(result), *_on_maps(result), *_on_control(result))


def _on_notions(result: Result) -> tuple[Verdict, ...]:
    neither, both = result.notions["neither"], result.notions["limits and tool"]
    alike = (
        neither.reachable == neither.total_orientation == neither.dexterous == neither.constant_orientation
    )
    apart = both.reachable > both.total_orientation > both.dexterous
    sizes = ", ".join(f"{size:.2g}" for size in (both.reachable, both.total_orientation, both.dexterous))
    return (
        _verdict(
            "five-notions", Outcome.of(alike and apart),
            "For the paper's arms, which have neither limits nor a tool, the five are one and the same; with "
            f"the PUMA's limits and a tool they are {sizes} m³ (reachable, within 45° of down, dexterous).",
            f"{neither.reachable:.2g} m³, all five" if alike else "not alike",
        ),
        _verdict(
            "six-dimensions-undrawable", Outcome.IN_SHAPE if alike else Outcome.REPRODUCED,
            "True where limits or a tool make orientation matter. The paper's arms have every orientation "
            "wherever they reach, so that one picture in space shows all six dimensions.",
        ),
        _verdict(
            "workspace-functions", Outcome.REPRODUCED,
            "With our functions, in slabs, for all five notions; the paper's library was not run.",
        ),
    )  # fmt: skip


def _on_maps(result: Result) -> tuple[Verdict, ...]:
    slight = {
        name: learned.aligned.is_slight and learned.random.is_slight
        for name, learned in result.learned.items()
    }
    overlaps = {
        name: min(f for part in (own.aligned, own.random) for f in (part.reached, part.unreached))
        for name, own in result.learned.items()
    }
    errors = {
        name: max(part.median_error for part in (own.aligned, own.random))
        for name, own in result.learned.items()
    }
    fits = {name: value >= _SLIGHT_OVERLAP for name, value in overlaps.items()}
    precise = {name: value <= _SLIGHT_ERROR for name, value in errors.items()}
    told = _both(overlaps, "{:.3f}"), _both({name: 100 * e for name, e in errors.items()}, "{:.2g} %")
    return (
        _verdict(
            "puma-maps-alike", _of_two(slight),
            f"{100 * result.share_reached:.0f} % of the cube are in reach, so that the cells out of reach "
            f"tell: smallest intersection over union {told[0]}; median error of w {told[1]} of its largest "
            f"value.",
            told[0], "smallest of both classes and both maps",
        ),
        _verdict(
            "workspace-from-jacobian", _of_two(fits),
            "The confidence draws the workspace, the Jacobian has no part in it. The rule that it stands in "
            "for has two lines and no error.",
            told[0], "intersection over union",
        ),
        _verdict(
            "manipulability-from-estimate", _of_two(precise),
            "Median error of w over the cells in reach, in shares of its largest value; w is a product of "
            "four factors that need no network.",
            told[1], "median, the worse of both maps",
        ),
    )  # fmt: skip


def _on_control(result: Result) -> tuple[Verdict, ...]:
    off = {name: result.runs[name].largest_position_error / CIRCLE.radius for name in (EXACT, *NETWORKS)}
    finished = {name: not result.runs[name].message for name in off}
    in_loop = _closeness(off[GENERAL]) if finished[GENERAL] else Outcome.NOT_REPRODUCED
    told = _both({name: 1e3 * CIRCLE.radius * off[name] for name in NETWORKS}, "{:.2g} mm")
    precise = max(
        part.median_error for part in (result.learned[GENERAL].aligned, result.learned[GENERAL].random)
    )
    useful = in_loop if precise <= _SLIGHT_ERROR else min(in_loop, Outcome.IN_SHAPE, key=_ORDER.index)
    exact = 1e3 * CIRCLE.radius * off[EXACT]
    fine = 1e3 * result.runs[EXACT + _FINE].largest_position_error
    return (
        _verdict(
            "jacobian-is-useful", useful,
            f"The loop stays within {told} of the circle, and w is off by {100 * precise:.2g} % of its "
            "largest value in the median.",
            told, "largest error along the circle",
        ),
        _verdict(
            "rate-control-scheme", Outcome.of(finished[EXACT] and fine < exact),
            f"With the exact Jacobian the tool is off by {exact:.2g} mm at most, all of it from Euler's "
            f"steps: {fine:.1g} mm with a tenth of the steps, of fourth order.",
            f"{exact:.2g} mm",
        ),
        _verdict(
            "rate-control-through-the-pose", in_loop,
            "Forward kinematics in front of the network closes the loop, and feedback holds what the network "
            "gets wrong. But forward kinematics is all that the exact Jacobian needs.",
            told, "largest error along the circle",
        ),
        _verdict(
            "rate-control-by-angles", Outcome.OUT_OF_SCOPE,
            "No such network is made in the paper. With the angles at hand the Jacobian is a product of "
            "known frames: there is nothing left to estimate.",
        ),
    )  # fmt: skip


_ORDER = (Outcome.NOT_REPRODUCED, Outcome.IN_SHAPE, Outcome.REPRODUCED)


def _closeness(share: float) -> Outcome:
    if share <= _CLOSE:
        return Outcome.REPRODUCED
    return Outcome.IN_SHAPE if share <= _NEAR else Outcome.NOT_REPRODUCED


def _of_two(holds: Mapping[str, bool]) -> Outcome:
    if holds[GENERAL]:
        return Outcome.REPRODUCED
    return Outcome.IN_SHAPE if holds[PLANE] else Outcome.NOT_REPRODUCED


def _both(values: Mapping[str, float], form: str) -> str:
    return " and ".join(f"{form.format(value)} ({name})" for name, value in values.items() if name != EXACT)


def _verdict(claim: str, outcome: Outcome, sentence: str, ours: str = "", spread: str = "") -> Verdict:
    return Verdict(_PAPER, claim, outcome, ours, spread, sentence)


def acceptance(result: Result) -> tuple[Acceptance, ...]:
    """Figures that must hold for the book to be built."""
    return (
        Acceptance(
            "closed form of w with limits and tool from all branches [m³]", result.closed_form_error, 1e-9
        ),
    )
