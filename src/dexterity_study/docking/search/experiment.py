"""Genetic runs, the true optimum that grids and differential evolution find, and what Table 3 says by itself.

Source: Sotiropoulos, Aspragathos & Andritsos (2011), Eqs. 3–15, Tables 2 and 3.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Any, TypeAlias

import numpy as np
import torch
from scipy.optimize import Bounds, differential_evolution, linprog, minimize
from torch import Tensor

from dexterity import docking, robots, spatial
from dexterity.chain import Chain
from dexterity.collision import Bodies
from dexterity.docking import DockingProblem
from dexterity.search import GeneticOptions, ZoomOptions, genetic_search, zoom_search
from dexterity.search.box import Objective
from dexterity.search.genetic import Chromosome
from dexterity_study.docking import cases
from dexterity_study.docking.cases import Rows, Values
from dexterity_study.engine.experiment import experiment

NEAR = 0.95
"""Share of the true optimum from which a pose is near it."""

Box: TypeAlias = tuple[Tensor, Tensor]
VARIABLES = ("x", "y", "z", "psi")
OTHERS = tuple(cases.CASES.values())[1:]
ALONE = {"chosen": "weights=ratio-0"} | {one: f"{one}+weights=ratio-0" for one in OTHERS}
"""Readings of the four cases without a weight on the distance, by those with it."""

ASSUMED = ("fitted-arm", "reading-of-the-group", "heading", "margin", "range-of-psi", "weights", "precision")
OF_CASE: dict[str, Any] = {"assumes": ASSUMED, **cases.PAPER, **cases.OF_DATA, **cases.ROUNDING}
RATIOS = (0.0, 0.0005, 0.002, 0.008, 0.032, 0.128)
COARSE: dict[str, Any] = {"step": 0.2, "turn_step": 0.4, "starts": 1, "stages": 3}
SHORT: dict[str, Any] = {"generations": 3}
FINE = docking.square(0.2, 21)
POPULATION = GeneticOptions().population
VEHICLE = Chain(torch.eye(6, dtype=torch.float64)[[0, 1, 2, 5]], torch.eye(4))
"""The vehicle's joints, x, y, z and ψ of the arm's base in G."""


@experiment(
    seeds=100, readings=(*OTHERS, *list(ALONE.values())[:2]), reading_seeds=20, smoke=SHORT, **OF_CASE
)
def genetic(seed: int, reading: Values, generations: int = 500) -> Rows:
    """The pose that a genetic run finds, and the share of a fine grid over the area that is dead there."""
    problem, options = problem_of(reading), GeneticOptions(generations=generations)
    found = docking.genetic_docking(problem, seed, options, reading["precision"])
    yield {
        **dict(zip(VARIABLES, found.pose, strict=True)),
        "fitness": found.fitness,
        "evaluations": found.search.evaluations,
        "allowed": problem.allows(found.pose),
        "faces": faces_area(found.pose),
        "dead": (docking.largest_manipulability(problem.arm, found.pose, FINE) == 0).double().mean(),
    }


@experiment(readings=OTHERS, smoke={"runs": 1, **SHORT}, **OF_CASE)
def penalty(seed: int, reading: Values, runs: int = 30, generations: int = 500) -> Rows:
    """Share of the individuals that are not allowed, in the first generation and in the last ten, over runs."""
    problem, options = problem_of(reading), GeneticOptions(generations=generations)
    steps, forbidden = [reading["precision"]] * 4, []
    for run in range(runs):
        shares: list[float] = []

        def fitness(poses: Tensor, shares: list[float] = shares) -> Tensor:
            shares.append(1 - problem.allows(poses).double().mean().item())
            return problem.fitness(poses)

        random = torch.Generator().manual_seed(seed + run)
        genetic_search(fitness, problem.lower, problem.upper, steps, random, options)
        forbidden.append((shares[0], np.mean(shares[-10:])))
    first, last = np.array(forbidden).mean(axis=0)
    yield {"first": first, "last": last}


@experiment(readings=(*OTHERS, *ALONE.values()), smoke={"evolutions": 2, **SHORT, **COARSE}, **OF_CASE)
def optimum(seed: int, reading: Values, evolutions: int = 3, generations: int = 500, **grids: Any) -> Rows:
    """The best pose by grids, by evolution and on the lattice, and its images by quarter turns about the middle."""
    problem = problem_of(reading)
    best = by_grids(problem, **grids)
    images = torch.stack([cases.quarter_turned(best.pose, turns) for turns in range(4)])
    worth, distances = problem.area_manipulability(images), problem.distance(images)
    seeds = range(seed, seed + evolutions)
    yield {
        **dict(zip(VARIABLES, best.pose, strict=True)),
        "fitness": best.fitness,
        "area_manipulability": best.area_manipulability,
        "distance": best.distance,
        "evolved": evolved(problem.objective, problem.boxes, seeds, maxiter=generations),
        "on_lattice": max(_on_lattice(problem, image, reading["precision"]) for image in images),
        "tied": ((worth / best.area_manipulability - 1).abs() < 1e-9).sum(),
        "nearest_image": distances.min(),
        "farthest_image": distances.max(),
    }


@experiment(
    keys=("bodies",),
    readings=OTHERS,
    smoke={"evolutions": 1, **SHORT, **COARSE},
    **{**OF_CASE, **cases.OF_LEDGER},
)
def physical(seed: int, reading: Values, evolutions: int = 1, generations: int = 500, **grids: Any) -> Rows:
    """The most dexterous pose whose arm goes around the block and, in the second row, around its vehicle as well.

    The vehicle is behind the base, its bottom as low as the foot. Links are lines. The distance has no weight.
    """
    free = replace(problem_of(reading), manipulability_weight=1.0, distance_weight=0.0)
    for name, bodies in bodies_about(free).items():
        problem, seeds = replace(free, bodies=bodies), range(seed, seed + evolutions)
        best = by_grids(problem, **grids)
        yield {
            "bodies": name,
            **dict(zip(VARIABLES, best.pose, strict=True)),
            "area_manipulability": best.area_manipulability,
            "evolved": evolved(problem.objective, problem.boxes, seeds, maxiter=generations),
        }


@experiment(
    keys=("ratio",), readings=OTHERS, smoke={"ratios": (0.01,), "runs": 1, **SHORT, **COARSE}, **OF_CASE
)
def front(
    seed: int,
    reading: Values,
    ratios: Sequence[float] = RATIOS,
    runs: int = 20,
    generations: int = 500,
    **grids: Any,
) -> Rows:
    """The best pose by the weight b/a [m²], and the share of genetic runs that end on the nearest quarter."""
    options, step = GeneticOptions(generations=generations), reading["precision"]
    for ratio in ratios:
        problem = problem_of(reading)
        problem = replace(problem, distance_weight=ratio * problem.manipulability_weight)
        best = by_grids(problem, **grids)
        found = [docking.genetic_docking(problem, one, options, step) for one in range(seed, seed + runs)]
        yield {
            "ratio": ratio,
            "area_manipulability": best.area_manipulability,
            "distance": best.distance,
            "on_quarter": np.mean([bool((one.pose[:2] < step).all()) for one in found]),
        }


# Where a climb ends depends on rounding, which differs between processors.
@experiment(readings=OTHERS, smoke={"climbs": 1, **COARSE}, unsteady=("evaluations",), **OF_CASE)
def gradients(seed: int, reading: Values, climbs: int = 100, **grids: Any) -> Rows:
    """Share of allowed poses that are flat, and climbs by L-BFGS-B in a box of the group from random ones."""
    problem = problem_of(reading)
    best = by_grids(problem, **grids).fitness
    ends = []

    def cost(x: np.ndarray) -> float:
        return -float(problem.objective(x))

    for start in cases.drawn_poses(problem, 40 * climbs, seed)[:climbs]:
        box = next(box for box in problem.boxes if (box[0] <= start).all() and (start <= box[1]).all())
        ends.append(minimize(cost, start, jac="2-point", bounds=_bounds(box), method="L-BFGS-B"))
    flat = problem.area_manipulability(cases.drawn_poses(problem, 20_000, seed)) == 0
    yield {
        "flat": flat.double().mean(),
        "climbed": np.mean([-end.fun >= NEAR * best for end in ends]),
        "evaluations": np.mean([end.nfev for end in ends]),
    }


@experiment(seeds=20, readings=OTHERS, reading_seeds=10, smoke=SHORT, **OF_CASE)
def peers(seed: int, reading: Values, generations: int = 500) -> Rows:
    """Fitness that other methods find with as many evaluations as the genetic run of the same seed."""
    problem, options = problem_of(reading), GeneticOptions(generations=generations)
    found = docking.genetic_docking(problem, seed, options, reading["precision"])
    count, everywhere = found.search.evaluations, [(problem.lower, problem.upper)]
    own = {"maxiter": count // POPULATION - 1, "popsize": POPULATION // len(problem.lower)}
    yield {
        "genetic": found.fitness,
        "differential evolution": evolved(problem.fitness, everywhere, [seed], **own, tol=0.0, atol=0.0),
        "CMA-ES": _by_cma(problem, count, seed),
    }


@experiment(keys=("run",), readings=OTHERS, **{**OF_CASE, **cases.OF_LEDGER})
def table_3(reading: Values) -> Rows:
    """What the seven printed poses are worth."""
    problem, poses = problem_of(reading), cases.printed_poses()
    columns = (problem.area_manipulability(poses), problem.distance(poses), problem.allows(poses))
    for run, (dexterity, distance, allowed) in enumerate(zip(*columns, strict=True), start=1):
        yield {"run": run, "area_manipulability": dexterity, "distance": distance, "allowed": allowed}


@experiment(**cases.OF_LEDGER, **cases.ROUNDING)
def printed_fitness(headings: int = 73) -> Rows:
    """Weights that come nearest to the printed fitness, whatever the heading at the start."""
    fitness, dexterity = map(cases.printed, ("fitness-of-runs", "area-manipulability-of-runs"))
    poses, arm = cases.printed_poses(), robots.docking_arm()
    turns = np.linspace(-math.pi, math.pi, headings).tolist()
    distances = [DockingProblem(arm, heading=heading).distance(poses).numpy() for heading in turns]
    misfit, a, b = min(best_weights(fitness.numpy(), dexterity.numpy(), one) for one in distances)
    yield {"misfit": misfit, "a": a, "b": b}


@experiment(**cases.OF_DATA, **cases.ROUNDING)
def geometry(seed: int) -> Rows:
    """Deviation of D from that of a chain of the vehicle's joints [m], and the largest jump of M_a on a turn."""
    problem = DockingProblem(robots.docking_arm(), region="or")
    poses = cases.drawn_poses(problem, 1000, seed)
    start, foot = poses.new_tensor([*problem.start, problem.heading]), poses.new_tensor(problem.foot)
    moved = spatial.apply(VEHICLE.forward(poses), foot) - spatial.apply(VEHICLE.forward(start), foot)
    jump, largest = _jump(problem, seed)
    deviation = (problem.distance(poses) - moved.norm(dim=-1)).abs().max()
    yield {"deviation": deviation, "jump": jump, "largest": largest}


def problem_of(reading: Values) -> DockingProblem:
    """Return the docking problem of a reading, with all that the chapter assumes."""
    settings = {"heading": reading["heading"], "height": reading["margin"], "yaw": reading["range-of-psi"]}
    a, b = reading["weights"]
    return cases.problem_of(reading, **settings, manipulability_weight=a, distance_weight=b)


def bodies_about(problem: DockingProblem) -> dict[str, Bodies]:
    """Return the bodies that the arm goes around: the block alone, or block and vehicle."""
    both = docking.block_and_vehicle(
        problem.arm, _printed_size("block"), _printed_size("vehicle"), bottom=problem.foot[2]
    )
    block = Bodies(problem.arm, [body for body in both.bodies if body.name != "vehicle"])
    return {"block": block, "block and vehicle": both}


def _printed_size(name: str) -> tuple[float, float, float]:
    x, y, z = cases.printed(name).tolist()
    return x, y, z


def faces_area(pose: Tensor) -> Tensor:
    """Tell whether the ray ahead of the base at poses (..., 4) outside the task area meets the area."""
    ahead = pose.new_tensor(list(cases.CORNERS.values()))[:, :2] - pose[..., None, :2]
    bearing = spatial.wrap_to_pi(torch.atan2(ahead[..., 1], ahead[..., 0]) - pose[..., 3:])
    left, right = bearing.amax(-1), bearing.amin(-1)
    return (left >= 0) & (right <= 0) & (left - right < math.pi)


def best_weights(fitness: np.ndarray, dexterity: np.ndarray, distance: np.ndarray) -> tuple[float, ...]:
    """Return the least that a M_a − b D misses f by in some run, beyond rounding, and its a, b ≥ 0.

    All numbers may be off by half a unit of their last digit; D [m] by what half a unit of a pose moves the foot.
    """
    claims = ("fitness-of-runs", "area-manipulability-of-runs", "poses-x")
    off_f, off_m, off_pose = (cases.printed(claim, "rounding").item() for claim in claims)
    off_d = off_pose * (math.sqrt(3) + math.hypot(*DockingProblem.foot[:2]))
    ones = np.ones_like(fitness)
    above = np.stack([dexterity - off_m, -distance - off_d, -ones], axis=1)
    below = np.stack([-dexterity - off_m, distance - off_d, -ones], axis=1)
    bounds = np.concatenate([fitness + off_f, -fitness + off_f])
    a, b, misfit = map(float, linprog([0, 0, 1], A_ub=np.concatenate([above, below]), b_ub=bounds).x)
    return misfit, a, b


def by_grids(
    problem: DockingProblem,
    objective: Objective | None = None,
    boxes: Iterable[Box] = (),
    step: float = 0.05,
    turn_step: float = 0.1,
    **options: Any,
) -> docking.Docking:
    """Search boxes, by default all, from a grid of these steps [m] and [rad], and of three values of a tilt."""
    steps = [step, step, step, *[problem.tilt] * (len(problem.lower) - 4), turn_step]
    zoom = ZoomOptions(**{"starts": 4, "stages": 200, "shrink": 0.85, **options})
    objective = objective or problem.objective
    searches = [zoom_search(objective, *box, steps, zoom) for box in boxes or problem.boxes]
    return docking.Docking.at(problem, max(searches, key=lambda search: search.value))


def evolved(objective: Objective, boxes: Iterable[Box], seeds: Iterable[int], **options: Any) -> float:
    """Return the largest objective in some boxes that differential evolution finds."""
    defaults = {"popsize": 30, "tol": 1e-10, "atol": 1e-10, "updating": "deferred", "polish": False}

    def cost(x: np.ndarray) -> np.ndarray:
        return -objective(torch.tensor(x.T)).numpy()

    tries = [(_bounds(box), {**defaults, "seed": seed, **options}) for box in boxes for seed in seeds]
    return max(-float(differential_evolution(cost, box, vectorized=True, **own).fun) for box, own in tries)


def _bounds(box: Box) -> Bounds:
    return Bounds(*(limit.numpy() for limit in box))


def _by_cma(problem: DockingProblem, evaluations: int, seed: int) -> float:
    """Start anew from a random pose wherever a run has ended, until the evaluations are used up."""
    import cma  # no page needs it

    random, width = np.random.default_rng(seed), problem.upper - problem.lower
    options = {"bounds": [0, 1], "popsize": POPULATION, "verbose": -9}
    best, left = 0.0, evaluations
    while left >= POPULATION:
        start = random.random(len(width))
        own = cma.CMAEvolutionStrategy(start, 0.3, {**options, "seed": int(random.integers(1, 2**31))})
        while left >= POPULATION and not own.stop():
            asked = own.ask()
            fitness = problem.fitness(problem.lower + width * torch.tensor(np.array(asked))).numpy()
            own.tell(asked, -fitness)
            best, left = max(best, float(fitness.max())), left - POPULATION
    return best


def _on_lattice(problem: DockingProblem, pose: Tensor, precision: float) -> float:
    """Return the largest fitness of what the chromosome has within 4 cm and 0.12 rad of a pose, at any height."""
    bits = Chromosome.of(problem.lower, problem.upper, [precision] * 4).bits
    last = torch.tensor([2**count - 1 for count in bits])
    step = (problem.upper - problem.lower) / last
    offsets = torch.cartesian_prod(*(torch.arange(-reach, reach + 1) for reach in (5, 5, 7, 20)))
    nearest = ((pose - problem.lower) / step).round()
    numbers = torch.minimum((nearest + offsets).clamp(min=0), last)
    return float(problem.fitness(problem.lower + numbers * step).max())


def _jump(problem: DockingProblem, seed: int) -> tuple[float, float]:
    """Close in on the largest change of M_a between two steps of a turn, from random poses; and its largest value."""
    poses = cases.drawn_poses(problem, 40_000, seed)
    values = problem.area_manipulability(poses)
    turn = torch.zeros(1, 1001, 4, dtype=torch.float64)
    turn[..., 3] = torch.linspace(-0.5, 0.5, 1001)
    path = poses[values > 0][:50, None] + turn
    steps = problem.area_manipulability(path).diff(dim=1).abs()
    i, j = divmod(int(steps.argmax()), 1000)
    ends = path[i, j : j + 2]
    for _ in range(30):
        halves = torch.stack([ends[0], ends.mean(0), ends[1]])
        first, second = problem.area_manipulability(halves).diff().abs()
        ends = halves[:2] if first > second else halves[1:]
    return float(problem.area_manipulability(ends).diff().abs()), float(values.max())
