"""Paper B, sections III.B to V: docking poses by the genetic algorithm, beside the true optimum.

Sotiropoulos, Aspragathos & Andritsos (2011), Eqs. 3–15, Tables 2 and 3. Everything is done for both arms and
both readings of Eq. 14, with the weights that the ledger states and with b = 0. The true optimum is looked
for twice, by grids and by differential evolution, and believed where both agree.

What decides a verdict was set beforehand. A run is *near* the optimum if its fitness is at least 95 % of it,
and *trapped* if it is below 90 %. A column of Table 3 is *in shape* if in one of the four cases all seven
printed values lie between the smallest and the largest of our runs on the nearest quarter. A run ends at a
pose like the ill-placed one if more than a tenth of the task area is dead. M_a jumps if it changes by more
than a tenth of its largest value between poses 1e-12 apart. A run of less than ten seconds would do on board.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import cma
import numpy as np
import torch
from numpy.typing import NDArray
from scipy.optimize import differential_evolution, linprog, minimize
from torch import Tensor

from dexterity import docking, robots, spatial
from dexterity.chain import Chain
from dexterity.docking import DockingProblem
from dexterity.docking.problem import Region
from dexterity.report.claims import Acceptance, Outcome, Verdict, load_paper
from dexterity.report.ranges import with_range
from dexterity.report.stored import Tolerance
from dexterity.scenes import Scene
from dexterity.search import GeneticOptions, GeneticSearch, ZoomOptions
from dexterity.search.genetic import Chromosome, Stop, genetic_search
from dexterity.studies.docking.area import CORNERS, FITTED, STATED, arms, configuration_at, printed_poses
from dexterity.timing import Way, measure

__all__ = [
    "CONFIGS",
    "PEERS",
    "REGIONS",
    "TOLERANCE",
    "Case",
    "Config",
    "Optimum",
    "Printed",
    "Result",
    "Runs",
    "acceptance",
    "best_weights",
    "climb_table",
    "docked_scene",
    "faces_area",
    "optimum_table",
    "peer_table",
    "printed_table",
    "problems",
    "run",
    "run_table",
    "search_scene",
    "verdicts",
    "with_vehicle",
]

REGIONS: tuple[Region, ...] = ("and", "or")
"""Readings of Eq. 14, beside the task area in both directions or in one."""

PEERS = ("genetic", "differential evolution", "CMA-ES")
"""What is compared at equal evaluations."""

TOLERANCE = Tolerance(rtol=1e-6, atol=1e-6)
"""What a probe may miss by, since rounding errors come out a little different on every processor."""

_PAPER = "sotiropoulos2011"
_NEAR, _TRAPPED, _DEAD = 0.95, 0.90, 0.10
_FINE = docking.square(0.2, 21)
_POPULATION = GeneticOptions().population
_BLOCK, _VEHICLE, _FOOT = (2.0, 2.0, 2.0), (1.5, 1.2, 1.0), DockingProblem.foot
_ARM_COLORS = ("blue", "vermillion", "bluish green", "reddish purple")
_STEP = 0.01  # [m], of the chromosome
_FRAMES = 6  # from one best pose to the next


@dataclass(frozen=True)
class Config:
    """How often, how fine and how wide to look.

    Attributes
    ----------
    seeds
        Of the runs of the genetic algorithm with the stated weights.
    alone_runs, peer_runs, ratio_runs
        How many of these seeds are taken with b = 0, beside the peers, and for each of the ratios.
    step, turn_step
        First grid of the search by grids, [m] and [rad].
    starts, stages, shrink
        How it goes on.
    evolutions
        Runs of differential evolution in each box, for the true optimum.
    climbs
        Climbs by gradients, from random allowed poses.
    generations
        Largest number of generations.
    ratios
        Weights b/a [m²] for which the optimum is found once more.
    timed
        Whether times are taken.
    """

    seeds: tuple[int, ...] = tuple(range(30))
    alone_runs: int = 10
    step: float = 0.05
    turn_step: float = 0.1
    starts: int = 3
    stages: int = 120
    shrink: float = 0.85
    evolutions: int = 2
    peer_runs: int = 3
    climbs: int = 10
    generations: int = 500
    ratios: tuple[float, ...] = ()
    ratio_runs: int = 1
    timed: bool = True


CONFIGS: Mapping[str, Config] = {
    "smoke": Config(
        seeds=(0, 1), alone_runs=1, step=0.2, turn_step=0.4, starts=1, stages=3, peer_runs=1, climbs=1,
        generations=3, ratios=(0.01,), timed=False,
    ),
    "book": Config(),
    "full": Config(
        seeds=tuple(range(100)), alone_runs=30, starts=4, stages=200, evolutions=3, peer_runs=20, climbs=100,
        ratios=(0.0, 0.0005, 0.002, 0.008, 0.032, 0.128), ratio_runs=20,
    ),
}  # fmt: skip
"""What runs at each scale."""


@dataclass(frozen=True)
class Optimum:
    """The best pose there is.

    Attributes
    ----------
    pose
        x, y, z, ψ of the arm's base in G, [m] and [rad].
    fitness, area_manipulability, distance
        What the pose is worth, M_a [m³] and D [m].
    evolved
        Largest fitness that differential evolution finds, each box for itself.
    images
        M_a and D of the pose turned about the middle of the task area by 0, 90, 180 and 270 degrees.
    on_lattice
        Largest fitness of the poses near these that the chromosome has.
    """

    pose: tuple[float, ...]
    fitness: float
    area_manipulability: float
    distance: float
    evolved: float
    images: tuple[tuple[float, float], ...]
    on_lattice: float

    @property
    def disagreement(self) -> float:
        """Difference of the two methods beside the fitness."""
        return abs(self.evolved - self.fitness) / self.fitness


@dataclass(frozen=True)
class Runs:
    """Runs of the genetic algorithm, a seed each.

    Attributes
    ----------
    poses
        (n, 4) poses found.
    allowed
        Share of them that are allowed.
    fitness
        (n) their fitness.
    evaluations
        (n) poses looked at.
    stalled
        Share of the runs that ended before the generations were used up.
    dead
        (n) share of a fine grid over the task area where the arm is dead.
    weakest
        (n) smallest w over that grid beside that at the corners.
    """

    poses: NDArray[np.float64]
    allowed: float
    fitness: NDArray[np.float64]
    evaluations: NDArray[np.int64]
    stalled: float
    dead: NDArray[np.float64]
    weakest: NDArray[np.float64]

    @property
    def in_quarter(self) -> NDArray[np.bool_]:
        """Whether poses (n) are on the nearest quarter of the block, to a step of the chromosome."""
        return np.all(self.poses[:, :2] < _STEP, axis=1)

    @property
    def facing(self) -> float:
        """Share of the poses that face the task area."""
        return float(faces_area(torch.tensor(self.poses)).double().mean())


@dataclass(frozen=True)
class Case:
    """One arm and one reading of Eq. 14.

    Attributes
    ----------
    optimum, alone
        The best pose with the stated weights, and with b = 0, where the fitness is a M_a.
    runs, runs_alone
        What the genetic algorithm finds of both.
    peers
        Fitness found by each of `PEERS` with as many evaluations, over seeds.
    flat
        Share of random allowed poses where M_a is zero, and with it its gradient.
    climbed, climb_evaluations
        Share of climbs by gradients from random allowed poses that end near the optimum, and how many poses
        a climb looks at on average.
    forbidden
        Share of the individuals that are not allowed, in the first generation and in the last ten, on average
        over runs.
    front
        By the weight b/a [m²], M_a [m³] and D [m] of the optimum, and the share of genetic runs that end on
        the quarter of the block that is nearest to the start.
    """

    optimum: Optimum
    alone: Optimum
    runs: Runs
    runs_alone: Runs
    peers: Mapping[str, NDArray[np.float64]]
    flat: float
    climbed: float
    climb_evaluations: float
    forbidden: tuple[float, float]
    front: Mapping[str, tuple[float, float, float]]

    def share(self, runs: Runs) -> NDArray[np.float64]:
        """Fitness of runs beside that of the optimum they look for."""
        best = self.optimum if runs is self.runs else self.alone
        return runs.fitness / best.fitness

    def lattice_share(self, runs: Runs) -> NDArray[np.float64]:
        """Fitness of runs beside the best that their chromosome has."""
        best = self.optimum if runs is self.runs else self.alone
        return runs.fitness / best.on_lattice


@dataclass(frozen=True)
class Printed:
    """What Table 3 says by itself, and what its poses are worth.

    Attributes
    ----------
    distance
        D [m] of the poses.
    misfit
        By how much a M_a − b D misses the printed fitness at least, with the best weights a, b ≥ 0 and the
        best heading at the start, beyond what rounding explains.
    weights
        These weights.
    same_order
        Whether fitness and M_a put the runs in the same order.
    area_manipulability
        M_a [m³] of the printed poses, by arm.
    allowed
        Share of the poses that each reading of Eq. 14 allows.
    """

    distance: tuple[float, ...]
    misfit: float
    weights: tuple[float, float]
    same_order: bool
    area_manipulability: Mapping[str, tuple[float, ...]]
    allowed: Mapping[str, float]


@dataclass(frozen=True)
class Result:
    """All cases, and what does not depend on them.

    Attributes
    ----------
    cases
        By arm and reading, such as "stated, and".
    printed
        About Table 3.
    foot_error
        Largest difference [m] of the foot from that of a kinematic chain with the vehicle's joints.
    group_error
        Share of random poses for which the boxes of the group and its formula disagree.
    jump
        By how much M_a [m³] changes between two poses 1e-12 apart, and its largest value.
    seconds
        Time [s] of a genetic run and of a search by grids, on one core; empty where none was taken.
    """

    cases: Mapping[str, Case]
    printed: Printed
    foot_error: float
    group_error: float
    jump: tuple[float, float]
    seconds: Mapping[str, float]


def run(config: Config) -> Result:
    """Search all cases."""
    printed = _printed()
    any_problem = problems()["stated, or"]
    return Result(
        cases={name: _case(problem, config) for name, problem in problems().items()},
        printed=printed,
        foot_error=_foot_error(any_problem),
        group_error=max(map(_group_error, problems().values())),
        jump=_jump(any_problem),
        seconds=_seconds(any_problem, config) if config.timed else {},
    )


def problems() -> dict[str, DockingProblem]:
    """Return the docking problem of each arm and each reading of Eq. 14, with the ledger's settings."""
    return {
        f"{name}, {region}": DockingProblem(arm, region=region)
        for name, arm in arms().items()
        for region in REGIONS
    }


def with_vehicle(arm: Chain) -> Chain:
    """Return a chain of ten joints, x, y, z, ψ of the arm's base in G and the arm's six."""
    joints = torch.zeros(4, 6, dtype=torch.float64)
    joints[torch.arange(4), [0, 1, 2, 5]] = 1.0
    return Chain(
        torch.cat([joints, arm.screws]), arm.home,
        name="vehicle and arm", joint_names=["x", "y", "z", "ψ", *arm.joint_names],
    )  # fmt: skip


def docked_scene(title: str, arm: Chain, pose: Tensor) -> Scene:
    """Show the block, the hook, the vehicle docked at a pose (4,), and the arm at every corner it reaches."""
    scene = _stage(title)
    base = docking.base_pose(pose)
    scene.add_box(_VEHICLE, pose=base @ _vehicle_on_base(), name="vehicle")
    for (corner, _), color in zip(CORNERS.items(), _ARM_COLORS, strict=True):
        q = configuration_at(arm, pose, corner)
        if q is not None:
            scene.add_chain(docking.on_base(arm, pose), q, name=corner, axes=False, color=color)
    return scene


def search_scene(title: str, search: GeneticSearch) -> Scene:
    """Show the best pose of each generation, one after the other, with the way of the arm's base."""
    scene = _stage(title)
    best = torch.unique_consecutive(search.points, dim=0)
    best[:, 3] = torch.tensor(np.unwrap(best[:, 3].numpy()))
    vehicle = Chain(
        with_vehicle(robots.docking_arm()).screws[:4], torch.eye(4), joint_names=["x", "y", "z", "ψ"]
    )
    scene.add_chain(vehicle, best[0], name="arm's base", axes=False)
    scene.add_box(_VEHICLE, on="arm's base", joint=4, pose=_vehicle_on_base(), name="vehicle")
    share = torch.linspace(0, 1, _FRAMES + 1, dtype=torch.float64)[:_FRAMES, None]
    moves = [a + share * (b - a) for a, b in pairwise(best)]
    rest = best[-1].expand(4 * _FRAMES, 4)
    scene.animate("arm's base", torch.cat([*moves, rest]), frames_per_second=12)
    scene.add_path(best[:, :3], name="way of the best pose")
    return scene


def _stage(title: str) -> Scene:
    """Block, task area and hook."""
    scene = Scene(title, view_from=(-1.0, -0.5, 0.8))
    scene.add_box(_BLOCK, pose=_at(0, 0, -_BLOCK[2] / 2), name="block", color="orange")
    scene.add_path([*CORNERS.values(), CORNERS["K"]], name="task area")
    turn = np.linspace(-0.5 * np.pi, np.pi, 13)
    hook = [(0.04 * np.cos(angle), 0.0, 0.12 + 0.04 * np.sin(angle)) for angle in turn]
    scene.add_path([(0.0, 0.0, 0.0), *hook], name="hook", color="black")
    return scene


def _vehicle_on_base() -> Tensor:
    """Middle of the vehicle as the arm's base sees it: behind it, its bottom as low as the foot."""
    length, _, height = _VEHICLE
    return _at(-length / 2, 0, _FOOT[2] + height / 2)


def _at(x: float, y: float, z: float) -> Tensor:
    return docking.base_pose([x, y, z, 0.0])


def faces_area(pose: Tensor) -> Tensor:
    """Tell whether the ray ahead of the base at poses (..., 4) outside the task area meets the area."""
    corners = pose.new_tensor(list(CORNERS.values()))[:, :2]
    ahead = corners - pose[..., None, :2]
    bearing = spatial.wrap_to_pi(torch.atan2(ahead[..., 1], ahead[..., 0]) - pose[..., 3:])
    left, right = bearing.amax(-1), bearing.amin(-1)
    return (left >= 0) & (right <= 0) & (left - right < math.pi)


# ---- one case --------------------------------------------------------------------------------------


def _case(problem: DockingProblem, config: Config) -> Case:
    alone = dataclasses.replace(problem, distance_weight=0.0)
    optimum = _optimum(problem, config)
    runs = _runs(problem, config.seeds, config)
    poses = _drawn(problem, 20_000)
    climbed, climb_evaluations = _climbed(problem, optimum.fitness, config)
    return Case(
        optimum=optimum,
        alone=_optimum(alone, config),
        runs=runs,
        runs_alone=_runs(alone, config.seeds[: config.alone_runs], config),
        peers=_peers(problem, runs, config),
        flat=(problem.area_manipulability(poses) == 0).double().mean().item(),
        climbed=climbed,
        climb_evaluations=climb_evaluations,
        forbidden=_forbidden(problem, config),
        front={str(ratio): _at_ratio(problem, ratio, config) for ratio in config.ratios},
    )


def _optimum(problem: DockingProblem, config: Config) -> Optimum:
    found = _by_grids(problem, config)
    quarters = torch.stack([_turned(found.pose, k) for k in range(4)])
    return Optimum(
        pose=tuple(found.pose.tolist()),
        fitness=found.fitness,
        area_manipulability=found.area_manipulability,
        distance=found.distance,
        evolved=_evolved(problem, config),
        images=tuple(
            zip(
                problem.area_manipulability(quarters).tolist(),
                problem.distance(quarters).tolist(),
                strict=True,
            )
        ),
        on_lattice=max(_on_lattice(problem, pose) for pose in quarters),
    )


def _on_lattice(problem: DockingProblem, pose: Tensor) -> float:
    """Largest fitness of what the chromosome has within 4 cm and 0.12 rad of a pose, at any height."""
    bits = Chromosome.of(problem.lower, problem.upper, [_STEP] * 4).bits
    last = torch.tensor([2**count - 1 for count in bits])
    step = (problem.upper - problem.lower) / last
    nearest = ((pose - problem.lower) / step).round()
    offsets = torch.cartesian_prod(*(torch.arange(-reach, reach + 1) for reach in (5, 5, 7, 20)))
    numbers = torch.minimum((nearest + offsets).clamp(min=0), last)
    parts = (problem.lower + numbers * step).split(2**15)
    return max(float(problem.fitness(part).max()) for part in parts)


def _by_grids(problem: DockingProblem, config: Config) -> docking.Docking:
    options = ZoomOptions(starts=config.starts, stages=config.stages, shrink=config.shrink)
    return docking.global_docking(problem, [*[config.step] * 3, config.turn_step], options)


def _evolved(problem: DockingProblem, config: Config) -> float:
    """Largest objective over the boxes of the group, by differential evolution in each."""
    values = [
        -differential_evolution(
            _as_cost(problem.objective), list(zip(*(limit.tolist() for limit in box), strict=True)),
            seed=seed, popsize=30, maxiter=config.generations, tol=1e-10, atol=1e-10,
            vectorized=True, updating="deferred", polish=False,
        ).fun
        for box in problem.boxes
        for seed in range(config.evolutions)
    ]  # fmt: skip
    return float(max(values))


def _as_cost(objective: Callable[[Tensor], Tensor]) -> Callable[[NDArray[np.float64]], NDArray[np.float64]]:
    """Return what scipy is to make small, of points (d, N)."""
    return lambda x: -objective(torch.tensor(x.T)).numpy()


def _turned(pose: Tensor, quarters: int) -> Tensor:
    """Turn the base about the middle of the task area."""
    angle = quarters * math.pi / 2
    T = docking.base_pose([0.0, 0.0, 0.0, angle])
    heading = spatial.wrap_to_pi(pose[3:] + angle)
    return torch.cat([spatial.apply(T, pose[:3]), heading])


def _at_ratio(problem: DockingProblem, ratio: float, config: Config) -> tuple[float, float, float]:
    weighed = dataclasses.replace(problem, distance_weight=ratio * problem.manipulability_weight)
    found, runs = _by_grids(weighed, config), _runs(weighed, config.seeds[: config.ratio_runs], config)
    return found.area_manipulability, found.distance, float(runs.in_quarter.mean())


def _runs(problem: DockingProblem, seeds: Sequence[int], config: Config) -> Runs:
    options = GeneticOptions(generations=config.generations)
    found = [docking.genetic_docking(problem, seed, options) for seed in seeds]
    searches = [docked.search for docked in found]
    poses = torch.stack([docked.pose for docked in found])
    over_area = docking.largest_manipulability(problem.arm, poses, _FINE)
    corners = problem.area_manipulability(poses)
    stops = [search.stop is Stop.STALLED for search in searches if isinstance(search, GeneticSearch)]
    return Runs(
        poses=poses.numpy(),
        allowed=problem.allows(poses).double().mean().item(),
        fitness=np.array([docked.fitness for docked in found]),
        evaluations=np.array([search.evaluations for search in searches]),
        stalled=float(np.mean(stops)),
        dead=(over_area == 0).double().mean(-1).numpy(),
        weakest=torch.where(corners > 0, over_area.amin(-1) / corners, 0.0).numpy(),
    )


def _peers(problem: DockingProblem, runs: Runs, config: Config) -> dict[str, NDArray[np.float64]]:
    """Best fitness by each method, with as many evaluations as the genetic run of the same seed."""
    budgets = list(zip(config.seeds, runs.evaluations[: config.peer_runs].tolist(), strict=False))
    return {
        "genetic": runs.fitness[: config.peer_runs],
        "differential evolution": np.array(
            [_by_evolution(problem, budget, seed) for seed, budget in budgets]
        ),
        "CMA-ES": np.array([_by_cma(problem, budget, seed) for seed, budget in budgets]),
    }


def _by_evolution(problem: DockingProblem, evaluations: int, seed: int) -> float:
    per_variable = _POPULATION // len(problem.lower)
    found = differential_evolution(
        _as_cost(problem.fitness), list(zip(problem.lower.tolist(), problem.upper.tolist(), strict=True)),
        seed=seed, popsize=per_variable, maxiter=evaluations // _POPULATION - 1, tol=0.0,
        vectorized=True, updating="deferred", polish=False,
    )  # fmt: skip
    return -float(found.fun)


def _by_cma(problem: DockingProblem, evaluations: int, seed: int) -> float:
    """Start anew from a random pose wherever a run has ended, until the evaluations are used up."""
    random = np.random.default_rng(seed)
    width = problem.upper - problem.lower
    best, left = 0.0, evaluations
    while left >= _POPULATION:
        strategy = cma.CMAEvolutionStrategy(
            random.random(len(width)), 0.3,
            {"bounds": [0, 1], "popsize": _POPULATION, "seed": int(random.integers(1, 2**31)), "verbose": -9},
        )  # fmt: skip
        while left >= _POPULATION and not strategy.stop():
            asked = strategy.ask()
            fitness = problem.fitness(problem.lower + width * torch.tensor(np.array(asked))).numpy()
            strategy.tell(asked, -fitness)
            best, left = max(best, float(fitness.max())), left - _POPULATION
    return best


def _drawn(problem: DockingProblem, count: int) -> Tensor:
    """Random poses of the group, out of so many of the whole box."""
    random = torch.Generator().manual_seed(0)
    unit = torch.rand(count, len(problem.lower), generator=random, dtype=torch.float64)
    poses = problem.lower + (problem.upper - problem.lower) * unit
    return poses[problem.allows(poses)]


def _climbed(problem: DockingProblem, best: float, config: Config) -> tuple[float, float]:
    """Climb the objective by L-BFGS-B, each in a box of the group, and count what it looks at."""
    near, evaluations = [], []
    for start in _drawn(problem, 40 * config.climbs)[: config.climbs]:
        low, high = next(box for box in problem.boxes if (box[0] <= start).all() and (start <= box[1]).all())
        end = minimize(
            lambda x: -float(problem.objective(x)), start.numpy(), jac="2-point",
            bounds=list(zip(low.tolist(), high.tolist(), strict=True)), method="L-BFGS-B",
        )  # fmt: skip
        near.append(-end.fun >= _NEAR * best)
        evaluations.append(end.nfev)
    return float(np.mean(near)), float(np.mean(evaluations))


def _forbidden(problem: DockingProblem, config: Config) -> tuple[float, float]:
    """Count the individuals that Eq. 15 gives zero to, in each generation."""
    first, last = [], []
    for seed in config.seeds[: config.alone_runs]:
        shares: list[float] = []

        def fitness(poses: Tensor, shares: list[float] = shares) -> Tensor:
            shares.append(1 - problem.allows(poses).double().mean().item())
            return problem.fitness(poses)

        genetic_search(
            fitness, problem.lower, problem.upper, [_STEP] * 4, torch.Generator().manual_seed(seed),
            GeneticOptions(generations=config.generations),
        )  # fmt: skip
        first.append(shares[0])
        last.append(float(np.mean(shares[-10:])))
    return float(np.mean(first)), float(np.mean(last))


# ---- what no case decides --------------------------------------------------------------------------


def _printed() -> Printed:
    fitness, dexterity = map(_printed_values, ("fitness-of-runs", "area-manipulability-of-runs"))
    poses = printed_poses()
    by_case = problems()
    facing = by_case["stated, and"]
    misfit, weights = min(
        best_weights(fitness, dexterity, dataclasses.replace(facing, heading=heading).distance(poses).numpy())
        for heading in np.linspace(-math.pi, math.pi, 73).tolist()
    )
    return Printed(
        distance=tuple(facing.distance(poses).tolist()),
        misfit=misfit,
        weights=weights,
        same_order=bool((fitness.argsort() == dexterity.argsort()).all()),
        area_manipulability={
            name: tuple(by_case[f"{name}, and"].area_manipulability(poses).tolist()) for name in arms()
        },
        allowed={
            region: by_case[f"stated, {region}"].allows(poses).double().mean().item() for region in REGIONS
        },
    )


def _printed_values(claim: str) -> NDArray[np.float64]:
    return np.array(load_paper(_PAPER).claim(claim).value, dtype=float)


def best_weights(
    fitness: NDArray[np.float64], dexterity: NDArray[np.float64], distance: NDArray[np.float64]
) -> tuple[float, tuple[float, float]]:
    """Return the least that a M_a − b D misses f by in some run, beyond rounding, and its a, b ≥ 0.

    Parameters
    ----------
    fitness, dexterity, distance
        (n) f, M_a [m³] and D [m] of the runs. Each may be off by half a unit of its last printed digit; for D
        that is what half a unit of the pose moves the foot by at most.
    """
    paper = load_paper(_PAPER)
    off_f, off_m = (
        float(paper.claim(name).rounding) for name in ("fitness-of-runs", "area-manipulability-of-runs")
    )
    off_pose = float(paper.claim("poses-x").rounding)
    off_d = off_pose * (math.sqrt(3) + math.hypot(*problems()["stated, and"].foot[:2]))
    ones = np.ones_like(fitness)
    above = np.stack([dexterity - off_m, -distance - off_d, -ones], axis=1)
    below = np.stack([-dexterity - off_m, distance - off_d, -ones], axis=1)
    solved = linprog(
        [0, 0, 1], A_ub=np.concatenate([above, below]),
        b_ub=np.concatenate([fitness + off_f, -fitness + off_f]),
    )  # fmt: skip
    a, b, t = map(float, solved.x)
    return t, (a, b)


def _foot_error(problem: DockingProblem) -> float:
    poses = _drawn(problem, 1000)
    vehicle = Chain(with_vehicle(problem.arm).screws[:4], torch.eye(4))
    start = poses.new_tensor([*problem.start, problem.heading])
    foot = poses.new_tensor(problem.foot)
    places = [spatial.apply(vehicle.forward(q), foot) for q in (poses, start)]
    return (problem.distance(poses) - (places[0] - places[1]).norm(dim=-1)).abs().max().item()


def _group_error(problem: DockingProblem) -> float:
    unit = torch.rand(20_000, 4, generator=torch.Generator().manual_seed(1), dtype=torch.float64)
    poses = problem.lower + (problem.upper - problem.lower) * unit
    boxed = torch.stack([((low <= poses) & (poses <= high)).all(-1) for low, high in problem.boxes]).any(0)
    return (boxed != problem.allows(poses)).double().mean().item()


def _jump(problem: DockingProblem) -> tuple[float, float]:
    """Follow random poses through a turn, and close in on the largest change of M_a between two steps."""
    poses = _drawn(problem, 40_000)
    values = problem.area_manipulability(poses)
    start = poses[values > 0][:50, None]
    turn = torch.zeros(1, 1001, 4, dtype=torch.float64)
    turn[..., 3] = torch.linspace(-0.5, 0.5, 1001)
    path = start + turn
    along = problem.area_manipulability(path)
    i, j = divmod(int(along.diff(dim=1).abs().argmax()), 1000)
    low, high = path[i, j], path[i, j + 1]
    for _ in range(30):
        middle = (low + high) / 2
        here = problem.area_manipulability(torch.stack([low, middle, high]))
        low, high = (low, middle) if (here[1] - here[0]).abs() > (here[2] - here[1]).abs() else (middle, high)
    here = problem.area_manipulability(torch.stack([low, high]))
    return float((here[1] - here[0]).abs()), float(values.max())


def _seconds(problem: DockingProblem, config: Config) -> dict[str, float]:
    ways = (
        Way("genetic", lambda: docking.genetic_docking(problem, 0), 1),
        Way("grids", lambda: _by_grids(problem, config), 1),
    )
    return {timing.name: timing.median for timing in measure(ways, rounds=3)}


# ---- tables ----------------------------------------------------------------------------------------


def optimum_table(result: Result) -> dict[str, dict[str, str]]:
    """Tabulate the true optima with the stated weights and with b = 0, and how far both methods are apart."""
    rows = {}
    for name, case in result.cases.items():
        for weights, best in (("", case.optimum), (", b = 0", case.alone)):
            rows[f"{name}{weights}"] = {
                "x, y, z [m], ψ [rad]": ", ".join(f"{number:.3f}" for number in best.pose),
                "M_a [m³]": f"{best.area_manipulability:.4f}",
                "D [m]": f"{best.distance:.3f}",
                "fitness": f"{best.fitness:.4f}",
                "methods differ by": f"{best.disagreement:.0e}",
            }
    return rows


def run_table(result: Result) -> dict[str, dict[str, str]]:
    """Tabulate what the genetic algorithm finds: median (smallest–largest) over seeds."""
    rows = {}
    for name, case in result.cases.items():
        for weights, runs in (("", case.runs), (", b = 0", case.runs_alone)):
            rows[f"{name}{weights}"] = {
                "of the optimum [%]": with_range(100 * case.share(runs), "{:.1f}".format),
                "of the lattice's best [%]": with_range(100 * case.lattice_share(runs), "{:.1f}".format),
                "near it [%]": f"{100 * np.mean(case.share(runs) >= _NEAR):.0f}",
                "evaluations": with_range(runs.evaluations, "{:.0f}".format),
                "nearest quarter [%]": f"{100 * runs.in_quarter.mean():.0f}",
                "facing the area [%]": f"{100 * runs.facing:.0f}",
                "dead inside [%]": with_range(100 * runs.dead, "{:.1f}".format),
            }
    return rows


def peer_table(result: Result) -> dict[str, dict[str, str]]:
    """Tabulate fitness beside the optimum's [%] at equal evaluations: median (smallest–largest)."""
    return {
        name: {
            peer: with_range(100 * case.peers[peer] / case.optimum.fitness, "{:.1f}".format) for peer in PEERS
        }
        for name, case in result.cases.items()
    }


def climb_table(result: Result) -> dict[str, dict[str, str]]:
    """Tabulate what gradients do: flat poses, climbs, and climbs with the evaluations of a genetic run."""
    rows = {}
    for name, case in result.cases.items():
        climbs = float(np.median(case.runs.evaluations)) / case.climb_evaluations
        rows[name] = {
            "flat poses [%]": f"{100 * case.flat:.0f}",
            "climbs that come near [%]": f"{100 * case.climbed:.0f}",
            "evaluations a climb": f"{case.climb_evaluations:.0f}",
            "chance with as many as a genetic run [%]": f"{100 * (1 - (1 - case.climbed) ** climbs):.0f}",
        }
    return rows


def printed_table(result: Result) -> dict[str, dict[str, float]]:
    """Set Table 3 beside what its poses are worth to our arms."""
    claims = {
        "x [m]": "poses-x", "y [m]": "poses-y", "z [m]": "poses-z", "ψ [rad]": "poses-psi",
        "M_a printed": "area-manipulability-of-runs", "fitness printed": "fitness-of-runs",
    }  # fmt: skip
    columns = {name: _printed_values(claim).tolist() for name, claim in claims.items()}
    printed = result.printed
    columns |= {f"M_a, {name}": list(values) for name, values in printed.area_manipulability.items()}
    columns["D [m]"] = list(printed.distance)
    return {str(i + 1): {name: values[i] for name, values in columns.items()} for i in range(7)}


# ---- verdicts --------------------------------------------------------------------------------------

_SETTING = "Taken over as a setting; nothing can be tested. "


def verdicts(result: Result) -> tuple[Verdict, ...]:
    """Judge the claims of the ledger that this study answers for."""
    return (
        *_on_formulas(result), *_on_settings(result), *_on_table_3(result), *_on_poses(result),
        *_on_the_search(result),
    )  # fmt: skip


def _on_formulas(result: Result) -> tuple[Verdict, ...]:
    foot = Outcome.of(result.foot_error < 1e-12)
    printed = Outcome.of(min(result.printed.allowed.values()) == 1)
    inside = _by_name("{:.0%} ({})", result.printed.allowed)
    jump, largest = result.jump
    ties = [_tied(case.alone) for case in result.cases.values()]
    nearest = all(_is_nearest(case.optimum) for case in result.cases.values())
    problem = problems()["stated, and"]
    bits = Chromosome.of(problem.lower, problem.upper, [_STEP] * 4).bits
    return (
        _verdict(
            "distance", foot, f"within {result.foot_error:.0e} m", "",
            "Taken over; the same as with a chain of the vehicle's joints.",
        ),
        _verdict("foot", foot, f"within {result.foot_error:.0e} m", "", "The same chain carries the foot."),
        _verdict("objective", Outcome.OUT_OF_SCOPE, "", "", "Taken over; it defines what is searched for."),
        _verdict(
            "bounds", printed, inside, "share of the printed poses that a reading allows",
            "Taken over, with the margin that the assumptions state, which these poses suggested.",
        ),
        _verdict(
            "group", printed, inside, "share of the printed poses that a reading allows",
            "Both readings are searched; the printed poses do not tell them apart.",
        ),
        _verdict("fitness", Outcome.OUT_OF_SCOPE, "", "", "Taken over; it defines what is searched for."),
        _verdict(
            "objective-is-not-continuous", Outcome.of(jump > 0.1 * largest),
            f"{jump:.3f} m³ between poses 1e-12 apart", f"largest value {largest:.3f} m³",
            "A joint limit switches a branch off, and M_a jumps.",
        ),
        _verdict(
            "distance-breaks-the-tie", Outcome.of(min(ties) >= 2 and nearest),
            f"{min(ties)} of four turned poses as good without D", "at least, in every case",
            "A quarter turn about the middle of the area changes M_a by rounding alone, and the optimum is "
            "the nearest of the four. The stated arm's mirror image about the diagonal stays tied.",
        ),
        _verdict(
            "chromosome", Outcome.REPRODUCED, f"{', '.join(map(str, bits))} bits", "for x, y, z and ψ",
            "Built so, with the precision that the assumptions state.",
        ),
        _verdict(
            "probabilities-favour-and-fall", Outcome.UNDERSPECIFIED, "", "",
            "No rule is given; the plainest one is taken, see the assumptions.",
        ),
        _on_penalty(result),
    )  # fmt: skip


def _on_penalty(result: Result) -> Verdict:
    first, last = ({name: case.forbidden[i] for name, case in result.cases.items()} for i in (0, 1))
    flat = {name: case.flat for name, case in result.cases.items()}
    fewer = _of_cases(last[name] < first[name] for name in last)
    return _verdict(
        "penalty-discards", fewer, _by_name("{:.0%} ({})", last),
        f"of the last generations are not allowed, after {_by_name('{:.0%} ({})', first)} of the first",
        f"Zero is more than the fitness −b D of the {min(flat.values()):.0%} to {max(flat.values()):.0%} of "
        "the allowed poses that do not reach all corners, so that it favours what is not allowed over them.",
    )  # fmt: skip


def _tied(best: Optimum) -> int:
    """Count the turned poses that are as good."""
    return sum(abs(dexterity / best.area_manipulability - 1) < 1e-9 for dexterity, _ in best.images)


def _is_nearest(best: Optimum) -> bool:
    """Whether no turned pose is nearer, and some are farther."""
    distances = [distance for _, distance in best.images]
    return best.distance <= min(distances) + 1e-9 and max(distances) > best.distance + 1e-3


def _on_settings(result: Result) -> tuple[Verdict, ...]:
    stalled = [case.runs.stalled for case in result.cases.values()]
    evaluations = np.concatenate([case.runs.evaluations for case in result.cases.values()])
    generations = evaluations / _POPULATION - 1
    said = {
        "stall": f"It ends {100 * min(stalled):.0f} % of the runs at least, in every case.",
        "probabilities": "The one of crossover is read as the mean over a population.",
        "population": "It goes through a generation at once.",
        "generations": f"Runs end after {with_range(generations, '{:.0f}'.format)} of them.",
        "block": "Its height plays no part.",
        "vehicle": "The vehicle's size plays no part in any formula; it is drawn to scale.",
        "start": "It decides which of the tied poses is taken.",
        "foot-position": "It keeps the base above the face.",
    }
    return tuple(
        _verdict(claim, Outcome.OUT_OF_SCOPE, "", "", f"{_SETTING}{sentence}")
        for claim, sentence in said.items()
    )


def _on_table_3(result: Result) -> tuple[Verdict, ...]:
    printed, rows = result.printed, []
    for i, name in enumerate(("x", "y", "z", "psi")):
        values = _printed_values(f"poses-{name}")
        off = float(load_paper(_PAPER).claim(f"poses-{name}").rounding)
        ours = {case: found.runs.poses[found.runs.in_quarter, i] for case, found in result.cases.items()}
        ours = {case: own for case, own in ours.items() if len(own)}
        inside = [
            case
            for case, own in ours.items()
            if own.min() - off <= values.min() and values.max() <= own.max() + off
        ]
        rows.append(
            _verdict(
                f"poses-{name}", Outcome.IN_SHAPE if inside else Outcome.NOT_REPRODUCED,
                "; ".join(f"{with_range(own, '{:.2f}'.format)}, {case}" for case, own in ours.items()),
                "over the seeds that end on the nearest quarter",
                f"The printed values lie between the least and the largest of ours for: {'; '.join(inside)}."
                f"{' The range was assumed from them.' if name == 'z' else ''}"
                if inside else "Some printed values lie outside of what our runs find, in every case.",
            )
        )  # fmt: skip
    a, b = printed.weights
    reached = {name: np.count_nonzero(values) for name, values in printed.area_manipulability.items()}
    return (
        *rows,
        _verdict(
            "fitness-of-runs", Outcome.CONTRADICTED if printed.misfit > 1e-6 else Outcome.UNDERSPECIFIED,
            f"missed by {printed.misfit:.3f} at least", f"with the best weights, a = {a:.3g} and b = {b:.3g}",
            "No weights a, b ≥ 0 and no initial heading make a M_a − b D of the printed fitness.",
        ),
        _verdict(
            "best-run", Outcome.of(printed.same_order and set(_best_runs(printed).values()) == {1.0}),
            _by_name("run {:.0f} is the best ({})", _best_runs(printed)), "by M_a at the printed poses",
            f"The printed columns {'have' if printed.same_order else 'do not have'} one order. Of the seven "
            f"poses {reached[STATED]} reach all corners with the stated arm, {reached[FITTED]} with the "
            "other.",
        ),
    )  # fmt: skip


def _best_runs(printed: Printed) -> dict[str, float]:
    """Return the number of the run with the largest M_a, by arm that reaches all corners from one."""
    return {
        name: float(np.argmax(values) + 1)
        for name, values in printed.area_manipulability.items()
        if max(values) > 0
    }


def _on_poses(result: Result) -> tuple[Verdict, ...]:
    cases = result.cases
    bad = {name: float((case.runs.dead > _DEAD).mean()) for name, case in cases.items()}
    quarter = {name: float(case.runs.in_quarter.mean()) for name, case in cases.items()}
    free = {name: float(case.runs_alone.in_quarter.mean()) for name, case in cases.items()}
    facing = {name: case.runs.facing for name, case in cases.items()}
    return (
        _verdict(
            "high-dexterity", _of_cases(share == 0 for share in bad.values()), _by_name("{:.0%} ({})", bad),
            "share of the runs whose pose is dead over more than a tenth of the area",
            "Four corners do not see what is between them.",
        ),
        _verdict(
            "same-quarter", _of_cases(share == 1 for share in quarter.values()),
            _by_name("{:.0%} ({})", quarter), "share of the runs",
            f"Without D it is {min(free.values()):.0%} to {max(free.values()):.0%}. Where the base may stand "
            "before a side of the area, the best poses are on the border of two quarters and count for both.",
        ),
        _verdict(
            "inside-margins", _of_cases(case.runs.allowed == 1 for case in cases.values()),
            _by_name("{:.0%} ({})", {name: case.runs.allowed for name, case in cases.items()}),
            "share of the runs", "A run whose best fitness is above zero is allowed.",
        ),
        _verdict(
            "face-the-target", _of_cases(share == 1 for share in facing.values()),
            _by_name("{:.0%} ({})", facing), "share of the runs",
            "Facing means that the ray ahead of the base meets the task area.",
        ),
    )  # fmt: skip


def _on_the_search(result: Result) -> tuple[Verdict, ...]:
    shares = {name: case.share(case.runs) for name, case in result.cases.items()}
    told = "; ".join(
        f"{with_range(100 * share, '{:.0f}'.format)} %, {name}" for name, share in shares.items()
    )
    lowest = min(float(share.min()) for share in shares.values())
    seeds = f"of the true optimum, over {len(next(iter(shares.values())))} seeds"
    flat = {name: case.flat for name, case in result.cases.items()}
    climbed = {name: case.climbed for name, case in result.cases.items()}
    genetic = result.seconds.get("genetic", math.nan)
    return (
        _verdict(
            "near-optimal", _of_cases(bool((share >= _NEAR).all()) for share in shares.values()), told, seeds,
            f"Near is {_NEAR:.0%} of the true optimum or more, in every run.",
        ),
        _verdict(
            "no-local-minima", Outcome.of(lowest >= _TRAPPED), f"{lowest:.0%} in the worst run", seeds,
            f"Below {_TRAPPED:.0%} a run counts as trapped. Of climbs by gradients "
            f"{min(climbed.values()):.0%} to {max(climbed.values()):.0%} come near the optimum, since "
            f"{min(flat.values()):.0%} to {max(flat.values()):.0%} of the allowed poses are flat.",
        ),
        _verdict(
            "on-board",
            Outcome.UNDERSPECIFIED if math.isnan(genetic) else Outcome.of(genetic < 10),
            f"{genetic:.1f} s a run", "on one core of the machine that the footer names",
            "Time is no obstacle; what a mission control needs else is not told.",
        ),
    )  # fmt: skip


def _of_cases(holds: Iterable[bool]) -> Outcome:
    """Reproduced where it holds in all cases, in shape where in some."""
    each = list(holds)
    if all(each):
        return Outcome.REPRODUCED
    return Outcome.IN_SHAPE if any(each) else Outcome.NOT_REPRODUCED


def _by_name(form: str, values: Mapping[str, float]) -> str:
    return "; ".join(form.format(value, name) for name, value in values.items())


def acceptance(result: Result) -> tuple[Acceptance, ...]:
    """Figures that must hold for the book to be built."""
    return (
        Acceptance("distance from that of a chain [m]", result.foot_error, 1e-12),
        Acceptance("share of poses whose group is told otherwise by boxes", result.group_error, 0.0),
        *_searched(result),
    )


def _searched(result: Result) -> Iterator[Acceptance]:
    """Hold the optima to each other, unless the run was too short to take times, and to search enough."""
    if result.seconds:
        for name, case in result.cases.items():
            yield Acceptance(f"difference of two methods, {name}", case.optimum.disagreement, 1e-3)
            yield Acceptance(f"difference of two methods, {name}, b = 0", case.alone.disagreement, 1e-3)
            yield Acceptance(
                f"a genetic run above the optimum, {name}", float(case.share(case.runs).max()) - 1, 1e-3
            )


def _verdict(claim: str, outcome: Outcome, ours: str, spread: str, sentence: str) -> Verdict:
    return Verdict(_PAPER, claim, outcome, ours, spread, sentence)
