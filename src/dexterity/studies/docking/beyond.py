"""Paper B, sections IV and V, what it leaves for later: more points, a hovering vehicle, a vertical surface.

Sotiropoulos, Aspragathos & Andritsos (2011). The best pose is looked for with ever more control points, and
judged by the smallest w over a fine grid; then with roll and pitch set free; then at the side of the block.
Nothing is weighed against distance here (b = 0), except at the side. A tilted vehicle must keep its body off
the block, so that its poses are judged by `hovering_worth` and not by the problem alone. A quarter turn about
the middle of the task area maps the boxes of the group onto each other and leaves M_a alone, so that one box
is enough.

What decides a verdict was set beforehand: the method *extends easily* if genetic runs with the paper's sizes
come to 95 % of the true optimum in the median, and *in shape* if to 80 %.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
import torch
from numpy.typing import NDArray
from scipy.optimize import differential_evolution
from torch import Tensor

from dexterity import docking, robots, spatial
from dexterity.chain import Chain
from dexterity.docking import DockingProblem
from dexterity.docking.problem import Region
from dexterity.report.claims import Acceptance, Outcome, Verdict
from dexterity.report.ranges import with_range
from dexterity.report.stored import Tolerance
from dexterity.search import GeneticOptions, ZoomOptions, genetic_search, zoom_search
from dexterity.search.box import Objective
from dexterity.search.zoom import ZoomSearch
from dexterity.timing import Way, measure

__all__ = [
    "CONFIGS",
    "TOLERANCE",
    "Best",
    "Config",
    "OnPoints",
    "Result",
    "acceptance",
    "at_side",
    "hover_table",
    "hovering_worth",
    "lowest_point",
    "point_table",
    "run",
    "side_table",
    "speed_table",
    "verdicts",
]

TOLERANCE = Tolerance(rtol=1e-6, atol=1e-6)
"""What a probe may miss by, since rounding errors come out a little different on every processor."""

_REGIONS: tuple[Region, ...] = ("and", "or")
_BODY = (1.5, 1.2, 0.2)  # [m], how far the vehicle reaches behind the base, across, and below it
_ROUNDING = 1e-9
_FINE, _FINEST = 21, 161  # a side; the finest has all points of the coarser ones


@dataclass(frozen=True)
class Config:
    """How many points, how far to tilt, and how much to search.

    Attributes
    ----------
    per_sides
        Control points a side of the task area, for which the best pose is found.
    tilts
        Largest roll and pitch [rad].
    steps, turn_step
        First grid of the search [m] and [rad].
    starts, stages, shrink
        Of the search by grids.
    evolutions
        Runs of differential evolution that confirm a hovering or a side optimum.
    seeds
        Of the runs of the genetic algorithm.
    generations
        Largest number of its generations.
    timed
        Whether times are taken.
    """

    per_sides: tuple[int, ...] = (2, 3, 5)
    tilts: tuple[float, ...] = (0.2,)
    steps: float = 0.1
    turn_step: float = 0.2
    starts: int = 4
    stages: int = 120
    shrink: float = 0.85
    evolutions: int = 1
    seeds: tuple[int, ...] = (0, 1, 2, 3, 4)
    generations: int = 500
    timed: bool = True


CONFIGS: Mapping[str, Config] = {
    "smoke": Config(
        per_sides=(2, 3), steps=0.4, turn_step=0.8, starts=1, stages=2, seeds=(0,),
        generations=3, timed=False,
    ),
    "book": Config(),
    "full": Config(
        per_sides=(2, 3, 5, 9, 21), tilts=(0.1, 0.2, 0.3), steps=0.05, turn_step=0.1, starts=8,
        stages=200, shrink=0.9, evolutions=3, seeds=tuple(range(30)),
    ),
}  # fmt: skip
"""What runs at each scale."""


@dataclass(frozen=True)
class OnPoints:
    """The best pose for a number of control points.

    Attributes
    ----------
    pose
        x, y, z, ψ [m] and [rad].
    at_points, fine, finest
        Smallest w [m³] over the control points, over 21 × 21 points, and over 161 × 161.
    dead
        Share of the finest grid where the arm is dead.
    """

    pose: tuple[float, ...]
    at_points: float
    fine: float
    finest: float
    dead: float


@dataclass(frozen=True)
class Best:
    """The best pose of a problem, and what the genetic algorithm makes of it.

    Attributes
    ----------
    pose
        x, y, z, roll, pitch, ψ, or without the two in the middle, [m] and [rad].
    area_manipulability
        M_a there [m³].
    value
        Objective there.
    evolved
        Largest objective that differential evolution finds.
    genetic
        (seeds) fitness of genetic runs.
    """

    pose: tuple[float, ...]
    area_manipulability: float
    value: float
    evolved: float
    genetic: NDArray[np.float64]

    @property
    def lowest(self) -> float:
        """Height z [m] of the lowest point of the vehicle's body."""
        return lowest_point(torch.tensor(self.pose, dtype=torch.float64)).item()

    @property
    def share(self) -> NDArray[np.float64]:
        """Fitness of the genetic runs beside the best."""
        return self.genetic / max(self.value, self.evolved)


@dataclass(frozen=True)
class Result:
    """All extensions, by case such as "stated, and".

    Attributes
    ----------
    points
        The best pose by number of control points.
    hover
        The best pose by largest tilt [rad].
    side
        The best pose at the side of the block.
    rates
        Poses a second on one core by number of control points; empty where no times were taken.
    """

    points: Mapping[str, Mapping[str, OnPoints]]
    hover: Mapping[str, Mapping[str, Best]]
    side: Mapping[str, Best]
    rates: Mapping[str, float]


def run(config: Config) -> Result:
    """Look for the best poses of every extension."""
    cases = {
        f"{name}, {region}": (arm, region)
        for name, arm in (("stated", robots.docking_arm()), ("fitted", robots.docking_arm("fitted")))
        for region in _REGIONS
    }
    return Result(
        points={
            name: {str(n**2): _on_points(arm, region, n, config) for n in config.per_sides}
            for name, (arm, region) in cases.items()
        },
        hover={
            name: {str(tilt): _hovering(arm, region, tilt, config) for tilt in config.tilts}
            for name, (arm, region) in cases.items()
        },
        side={name: _at_side(arm, region, config) for name, (arm, region) in cases.items()},
        rates=_rates() if config.timed else {},
    )


def at_side(arm: Chain, region: Region) -> DockingProblem:
    """Return the problem of docking upright at the side of the block, straight ahead of the start.

    The vehicle comes from 2 m before the side, and holds on to it with a foot 0.2 m ahead of the arm's base.
    It may turn by 0.3 rad to either side, so that its bow stays clear.
    """
    return DockingProblem(
        arm, region=region, face="side", start=(-2.0, 0.0, 0.0), heading=0.0, foot=(0.2, 0.0, -0.3),
        yaw=(-0.3, 0.3),
    )  # fmt: skip


def _on_points(arm: Chain, region: Region, per_side: int, config: Config) -> OnPoints:
    points = docking.square(0.2, per_side)
    problem = DockingProblem(arm, region=region, points=points, distance_weight=0.0)
    pose = _by_grids(problem, problem.objective, problem.boxes[0], config).point
    finest = docking.largest_manipulability(arm, pose, docking.square(0.2, _FINEST))
    return OnPoints(
        pose=tuple(pose.tolist()),
        at_points=problem.area_manipulability(pose).item(),
        fine=docking.area_manipulability(arm, pose, docking.square(0.2, _FINE)).item(),
        finest=finest.min().item(),
        dead=(finest == 0).double().mean().item(),
    )


def lowest_point(pose: Tensor) -> Tensor:
    """Return z [m] (...) of the lowest corner of the vehicle's body, from poses (..., 4) or (..., 6)."""
    x, y, z = _BODY
    corners = torch.cartesian_prod(
        pose.new_tensor([-x, 0]), pose.new_tensor([-y / 2, y / 2]), pose.new_tensor([-z])
    )
    return spatial.apply(docking.base_pose(pose)[..., None, :, :], corners)[..., 2].amin(-1)


def hovering_worth(problem: DockingProblem, pose: Tensor) -> Tensor:
    """Return the objective (...) of poses; where the body is in the block, how deep it is, below zero."""
    depth = lowest_point(pose).clamp(max=0)
    return torch.where(depth < -_ROUNDING, depth, problem.objective(pose))


def _hovering(arm: Chain, region: Region, tilt: float, config: Config) -> Best:
    problem = DockingProblem(arm, region=region, tilt=tilt, height=(0.2, 0.5), distance_weight=0.0)

    def fitness(pose: Tensor) -> Tensor:
        return torch.where(problem.allows(pose), hovering_worth(problem, pose), 0.0)

    return _best(problem, partial(hovering_worth, problem), fitness, problem.boxes[:1], config)


def _at_side(arm: Chain, region: Region, config: Config) -> Best:
    problem = at_side(arm, region)
    return _best(problem, problem.objective, problem.fitness, problem.boxes, config)


def _best(
    problem: DockingProblem,
    objective: Objective,
    fitness: Objective,
    boxes: Sequence[tuple[Tensor, Tensor]],
    config: Config,
) -> Best:
    """Search boxes for the largest objective, and the whole range by genetic runs for the largest fitness."""
    found = max(
        (_by_grids(problem, objective, box, config) for box in boxes), key=lambda search: search.value
    )
    return Best(
        pose=tuple(found.point.tolist()),
        area_manipulability=problem.area_manipulability(found.point).item(),
        value=found.value,
        evolved=max(
            _evolved(objective, box, seed, config) for box in boxes for seed in range(config.evolutions)
        ),
        genetic=np.array([_genetic(problem, fitness, seed, config) for seed in config.seeds]),
    )


def _by_grids(
    problem: DockingProblem, objective: Objective, box: tuple[Tensor, Tensor], config: Config
) -> ZoomSearch:
    """Grids of three values a variable, since there are up to six."""
    tilts = [problem.tilt] * (len(problem.lower) - 4)
    options = ZoomOptions(starts=config.starts, levels=3, shrink=config.shrink, stages=config.stages)
    return zoom_search(objective, *box, [*[config.steps] * 3, *tilts, config.turn_step], options)


def _evolved(objective: Objective, box: tuple[Tensor, Tensor], seed: int, config: Config) -> float:
    found = differential_evolution(
        lambda x: -objective(torch.tensor(x.T)).numpy(),
        list(zip(*(limit.tolist() for limit in box), strict=True)),
        seed=seed, popsize=30, maxiter=config.generations, tol=1e-10, atol=1e-10,
        vectorized=True, updating="deferred", polish=False,
    )  # fmt: skip
    return -float(found.fun)


def _genetic(problem: DockingProblem, fitness: Objective, seed: int, config: Config) -> float:
    options = GeneticOptions(generations=config.generations)
    generator = torch.Generator().manual_seed(seed)
    precision = [0.01] * len(problem.lower)
    return genetic_search(fitness, problem.lower, problem.upper, precision, generator, options).value


def _rates() -> dict[str, float]:
    """Evaluate random poses, the fewer the more control points."""
    problem = DockingProblem(robots.docking_arm())
    random = torch.Generator().manual_seed(0)
    unit = torch.rand(20_000, 4, generator=random, dtype=torch.float64)
    poses = problem.lower + (problem.upper - problem.lower) * unit

    def way(per_side: int) -> Way:
        points = docking.square(0.2, per_side)
        some = poses[: len(poses) * 4 // per_side**2]
        return Way(
            str(per_side**2), lambda: docking.area_manipulability(problem.arm, some, points), len(some)
        )

    return {timing.name: 1 / timing.median for timing in measure([way(n) for n in (2, 3, 5, 9, 21)])}


# ---- tables ----------------------------------------------------------------------------------------


def point_table(result: Result) -> dict[str, dict[str, str]]:
    """Tabulate the best pose by number of control points, and what it is worth on finer grids."""
    return {
        f"{name}, {count} points": {
            "x, y, z [m], ψ [rad]": _told(best.pose),
            "at the points [m³]": f"{best.at_points:.4f}",
            "on 21 × 21 [m³]": f"{best.fine:.4f}",
            "on 161 × 161 [m³]": f"{best.finest:.4f}",
            "dead [%]": f"{100 * best.dead:.2g}",
        }
        for name, by_count in result.points.items()
        for count, best in by_count.items()
    }


def hover_table(result: Result) -> dict[str, dict[str, str]]:
    """Tabulate the best M_a by largest tilt."""
    return {
        f"{name}, tilt to {tilt} rad": {
            "x, y, z [m], (roll, pitch,) ψ [rad]": _told(best.pose),
            "M_a [m³]": f"{best.area_manipulability:.4f}",
            "by evolution": f"{best.evolved / DockingProblem.manipulability_weight:.4f}",
            "lowest point [mm]": f"{1e3 * best.lowest:.0f}",
            "genetic [% of the best]": with_range(100 * best.share, "{:.1f}".format),
        }
        for name, by_tilt in result.hover.items()
        for tilt, best in by_tilt.items()
    }


def side_table(result: Result) -> dict[str, dict[str, str]]:
    """Tabulate the best pose at the side of the block."""
    return {
        name: {
            "x, y, z [m], ψ [rad]": _told(best.pose),
            "M_a [m³]": f"{best.area_manipulability:.4f}",
            "fitness": f"{best.value:.4f}",
            "by evolution": f"{best.evolved:.4f}",
            "genetic [% of the best]": with_range(100 * best.share, "{:.1f}".format),
        }
        for name, best in result.side.items()
    }


def speed_table(result: Result) -> dict[str, dict[str, float]]:
    """Tabulate how many poses a second are evaluated, by number of control points."""
    first = result.rates.get("4", math.nan)
    return {
        f"{count} points": {"poses a second": rate, "slower than with 4": first / rate}
        for count, rate in result.rates.items()
    }


def _told(pose: tuple[float, ...]) -> str:
    return ", ".join(f"{number:.3f}" for number in pose)


# ---- verdicts --------------------------------------------------------------------------------------


def verdicts(result: Result) -> tuple[Verdict, ...]:
    """Judge the claims of the ledger that this study answers for."""
    hover = [np.median(best.share) for by_tilt in result.hover.values() for best in by_tilt.values()]
    side = [np.median(best.share) for best in result.side.values()]
    lowest = float(min(*hover, *side))
    outcome = Outcome.IN_SHAPE if 0.8 <= lowest < 0.95 else Outcome.of(lowest >= 0.95)
    slower = result.rates.get("4", math.nan) / result.rates.get("441", math.nan)
    return (
        _verdict(
            "more-points-are-slower", Outcome.of(slower > 1) if result.rates else Outcome.UNDERSPECIFIED,
            f"{slower:.0f} times with 441 points" if result.rates else "", "beside 4, on one core",
            "Slower in proportion to their number at most, and with few points still far from a limit.",
        ),
        _verdict(
            "hovering-and-vertical",
            outcome,
            f"{min(hover):.0%} of the best (roll and pitch), {min(side):.0%} (side)",
            f"median of {len(next(iter(result.side.values())).genetic)} genetic runs, in the worst case",
            "Two more variables, or another face with its own limits, are all that has to be added.",
        ),
    )  # fmt: skip


def acceptance(result: Result) -> tuple[Acceptance, ...]:
    """Return the figures that must hold; a run that takes no times searches too little to be held to them."""
    if not result.rates:
        return ()
    bests = {
        f"{name}, tilt to {tilt} rad": best
        for name, by_tilt in result.hover.items()
        for tilt, best in by_tilt.items()
    }
    bests |= {f"{name}, side": best for name, best in result.side.items()}
    return tuple(
        Acceptance(f"difference of the two methods, {name}", abs(best.evolved / best.value - 1), 0.02)
        for name, best in bests.items()
    )


def _verdict(claim: str, outcome: Outcome, ours: str, spread: str, sentence: str) -> Verdict:
    return Verdict("sotiropoulos2011", claim, outcome, ours, spread, sentence)
