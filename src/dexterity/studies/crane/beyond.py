"""Paper D, what beats its methods: structures and learned sags in a loop, how fast, and its remedies tried.

Rouvinen (1999), sections 1.1, 1.2, 4.1, 4.2 and 4.5, chapter 5. All methods get the thesis's 125 tasks, and
fresh points all over the working area. They are judged on linear statics, which made the training data, and
apart from that on the co-rotational structure. What has to be chosen of a learned sag is chosen by poses of
the training data that are held out, and never by the test.

What decides a verdict was set beforehand. A remedy *works* if it lowers the error in at least three quarters
of the seeds, and is *contradicted* if it raises it in as many. The structure is in real time if it takes less
than 10 ms of the processor for a point, by the upper quartile. Points that come at once tell the arithmetic,
points that come one by one an interpreter's calls besides: if both are within it the claim against it is
*contradicted*, if only the former are it is *not reproduced*. A time is shorter than another if their
quartiles lie apart. A table grows greatly if a tenth of the error takes more than ten times the entries.
"""

from __future__ import annotations

import dataclasses
import itertools
import math
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Literal, NamedTuple, TypeAlias

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from dexterity import crane
from dexterity.crane import TrainingSet, positioning
from dexterity.crane.description import Crane
from dexterity.crane.positioning import (
    AngleNetworkSag,
    DescentOptions,
    GeneticInverseOptions,
    Placement,
    TableSag,
    Task,
    TrigonometricSag,
)
from dexterity.crane.positioning.inversion import TipModel
from dexterity.crane.positioning.task import SagModel
from dexterity.networks.feed_forward import FeedForward
from dexterity.networks.threads import one_thread
from dexterity.report.claims import Acceptance, Outcome, Verdict, load_paper
from dexterity.report.ranges import with_range
from dexterity.report.stored import Tolerance
from dexterity.timing import Timing, Way, measure, ratio

__all__ = [
    "CONFIGS",
    "JUDGED_AS_STORED",
    "TOLERANCE",
    "Config",
    "Inverted",
    "Judged",
    "Result",
    "acceptance",
    "approach",
    "choice_table",
    "corotational_table",
    "fresh_task",
    "inversion_table",
    "loop_table",
    "method_table",
    "refusals",
    "remedy_table",
    "run",
    "size_table",
    "speed_table",
    "table_table",
    "trade",
    "verdicts",
]

JUDGED_AS_STORED = True
"""Verdicts go by ten seeds, since two or three decide otherwise what more data would do."""

TOLERANCE = Tolerance(rtol=1e-4, atol=1e-7)
"""What a probe may miss by; training carries rounding errors on, and there are no times in it."""

_PAPER = "rouvinen1999"

NOTHING = "no compensation"
THESIS, THESIS_LOOP = "thesis's network, once", "thesis's network, in a loop"
ANGLES, REGRESSION = "network in angles, in a loop", "regression in angles, in a loop"
REGRESSION_NEWTON = "regression, Gauss–Newton"
DIRECT = "direct network, Gauss–Newton"
TABLE = "training grid as a table, in a loop"
STRUCTURE_ONCE, STRUCTURE = "structure, once", "structure, in a loop"
STRUCTURE_NEWTON = "structure, Gauss–Newton"
COROTATIONAL = "co-rotational structure, in a loop"
GENETIC, DESCENT = "thesis's method 1, genetic", "thesis's method 2, descent"

SAG_SINGLE, SAG_BATCH = "sag alone, one by one", "sag alone, at once"
POINT_SINGLE, POINT_BATCH = "a point, one by one", "a point, at once"

_GRID = (9, 9, 5)  # strokes of the thesis's training grid
_PAYLOADS = tuple(float(mass) for mass in range(50, 501, 50))
_REAL_TIME = 0.01  # [s] for a point
_MOST = 0.75  # of the seeds
_EXACT = 5e-5  # [m]: as exact as a structure in a loop has to be on itself
_FAILED = 1e-5  # [m]: an inversion that ends farther off by its own model has failed

_AS_THESIS, _LIGHTER = "thesis's payloads", "lighter ones besides"
_SECOND, _THIRD = "method 2", "method 3"
_THESIS_GRID, _EVEN, _DENSER = "thesis's grid", "as many, evenly", "a denser grid"


@dataclass(frozen=True)
class Config:
    """How much is trained, judged and timed.

    Attributes
    ----------
    seeds
        Of everything random.
    epochs, remedy_epochs
        Of the rivals' training, and of that of the thesis's methods with its remedies.
    neurons
        Of larger networks of strokes and payload.
    generations, descent
        Largest numbers of generations of method 1, and of steps of methods 2 and 3.
    angle_neurons, degrees
        Among which the network in angles and the regression are chosen.
    folds, network_folds
        How many fifths of the poses are held out, one after the other, to choose a degree, and neurons.
    fresh
        How many points all over the working area are drawn.
    every
        The co-rotational structure judges one test task in so many, no multiple of five, for all payloads.
    corrections, corotational_corrections
        Of the structure in a loop.
    refinements
        Tables have the steps of the training grid over each of these.
    looked_up
        Random poses at which tables are compared with the structure.
    small, few, batch
        Tasks that are timed one by one, tasks at once for what is slow, and for what is fast.
    rounds, seconds
        How often each way gets its turn, and for how long at least [s]; no times without rounds.
    """

    seeds: tuple[int, ...] = (0, 1)
    epochs: int = 100
    remedy_epochs: int = 40
    neurons: tuple[int, ...] = (28,)
    generations: int = 1000
    descent: int = 1000
    angle_neurons: tuple[int, ...] = (10, 20, 30)
    degrees: tuple[int, ...] = (1, 2, 3, 4, 5, 6)
    folds: int = 5
    network_folds: int = 1
    fresh: int = 1000
    every: int = 7
    corrections: int = 6
    corotational_corrections: int = 4
    refinements: tuple[int, ...] = (1, 2, 3, 4)
    looked_up: int = 20_000
    small: int = 2
    few: int = 4
    batch: int = 1000
    rounds: int = 2
    seconds: float = 0.02


CONFIGS: Mapping[str, Config] = {
    "smoke": Config(
        seeds=(0,), epochs=8, remedy_epochs=3, neurons=(16,), generations=20, descent=50,
        angle_neurons=(5, 8), degrees=(3, 4), folds=2, fresh=60, every=13, corotational_corrections=3,
        refinements=(1, 2), looked_up=500, rounds=0,
    ),
    "book": Config(),
    "full": Config(
        seeds=tuple(range(10)), epochs=200, remedy_epochs=200,
        neurons=(28, 40, 80), descent=10_000,
        angle_neurons=(10, 20, 30, 40), degrees=(1, 2, 3, 4, 5, 6, 7, 8), network_folds=5, fresh=5000,
        every=1, refinements=(1, 2, 3, 4, 6, 8), looked_up=100_000, small=5, few=20, rounds=15,
    ),
}  # fmt: skip
"""What runs at each scale."""


@dataclass(frozen=True)
class Judged:
    """How far off a method is.

    Attributes
    ----------
    test
        (seeds, 2) mean and largest error on the thesis's test [m], on linear statics.
    fresh
        (seeds, 3) mean, 99th percentile and largest error at fresh points [m], likewise.
    corotational
        (seeds, 2) mean and largest error on the test [m], or on a part of it, on the co-rotational structure.
    """

    test: NDArray[np.float64]
    fresh: NDArray[np.float64]
    corotational: NDArray[np.float64]


@dataclass(frozen=True)
class Inverted:
    """How often an inversion fails, plain and damped.

    Attributes
    ----------
    plain, damped
        Shares of the test's tasks that are missed by the model that is inverted.
    plain_worst, damped_worst
        Largest of these misses [m].
    """

    plain: float
    damped: float
    plain_worst: float
    damped_worst: float


@dataclass(frozen=True)
class Result:
    """All rivals and remedies.

    Attributes
    ----------
    methods
        How far off each method is.
    loop, corotational_loop
        (corrections + 1, 2) mean and largest error [m] of a structure in a loop, on itself.
    unsettled
        Share of the fresh points where the structure in a loop is still 0.05 mm off, on itself.
    choices
        Root mean squares [m] over poses held out, by degree and by neurons.
    inverted
        Gauss–Newton by model, and by where it sets out from.
    payloads
        (seeds, 3) errors [m] of the thesis's first method, with lighter payloads in its data and without: at
        (2, 2) with 30 kg, mean with 30 kg, mean of all.
    spread
        (seeds, 2) mean and largest errors [m] of methods 2 and 3, by data.
    sizes
        (seeds, 2) mean and largest errors [m] of method 4, by size of the crane.
    amplification
        Largest movement of the tip by movement of a cylinder over the test, by size.
    tables
        (refinements, 2) entries of a table and its largest error [m], by size.
    apart
        (2) mean and largest distance [m] of the co-rotational sag from the linear one in the test.
    times
        Of sags alone and of whole points, one by one and at once; empty if none were taken.
    data_seconds
        For the whole training data; NaN if no times were taken [s].
    """

    methods: Mapping[str, Judged]
    loop: NDArray[np.float64]
    corotational_loop: NDArray[np.float64]
    unsettled: float
    choices: Mapping[str, Mapping[str, float]]
    inverted: Mapping[str, Mapping[str, Inverted]]
    payloads: Mapping[str, NDArray[np.float64]]
    spread: Mapping[str, Mapping[str, NDArray[np.float64]]]
    sizes: Mapping[str, NDArray[np.float64]]
    amplification: Mapping[str, float]
    tables: Mapping[str, NDArray[np.float64]]
    apart: NDArray[np.float64]
    times: Mapping[str, tuple[Timing, ...]]
    data_seconds: float


_Method: TypeAlias = Callable[[Task], Placement]


def run(config: Config) -> Result:
    """Train, choose, judge and time."""
    with one_thread():
        return _run(config)


def _run(config: Config) -> Result:
    task, data = positioning.thesis_task(), crane.training_set()
    chosen = slice(None, None, config.every)
    part = _part(task, chosen)
    choices = _choices(data, config)
    sags = [_Sags.trained(data, choices, seed, config) for seed in config.seeds]
    methods = _methods(sags, config)
    fresh = fresh_task(config.fresh)
    judge = _Judge(task, chosen, fresh)
    linear, turned = positioning.linear_sag(), positioning.corotational_sag()
    nonlinear_loop = approach(part, turned, config.corotational_corrections)
    judged = {name: judge.judged(by_seed, name != GENETIC) for name, by_seed in methods.items()}
    judged[COROTATIONAL] = _on_itself(nonlinear_loop[-1])
    times = _times(sags[0], methods, task, config) if config.rounds else {}
    by_size = _other_sizes(task, config)
    return Result(
        methods=judged,
        loop=_mean_and_largest(approach(task, linear, config.corrections)),
        corotational_loop=_mean_and_largest(nonlinear_loop),
        unsettled=(approach(fresh, linear, config.corrections)[-1] > _EXACT).double().mean().item(),
        choices=choices,
        inverted=_inverted(task, sags[0].direct),
        payloads=_lighter(task, data, config),
        spread=_spread(task, config),
        sizes=by_size.sizes,
        amplification=by_size.amplification,
        tables=by_size.tables,
        apart=_mean_and_largest(
            (linear(part.starts, part.payload) - turned(part.starts, part.payload)).norm(dim=-1)[None]
        )[0],
        times=times,
        data_seconds=_data_seconds(config),
    )


def approach(task: Task, sag: SagModel, corrections: int) -> Tensor:
    """Return errors (corrections + 1, N) [m] of the rigid crane that is aimed off by a sag, on that sag.

    They are those of :func:`~dexterity.crane.positioning.compensation.compensate` with 0, 1, 2 … corrections,
    from one run.
    """
    strokes = positioning.exact_inverse(task, task.targets).strokes
    misses = []
    for _ in range(corrections + 1):
        deflection = sag(strokes, task.payload)
        misses.append((crane.tip_position(strokes, task.crane) + deflection - task.targets).norm(dim=-1))
        current = dataclasses.replace(task, starts=strokes)
        strokes = positioning.exact_inverse(current, task.targets - deflection).strokes
    return torch.stack(misses)


def fresh_task(count: int, seed: int = 0) -> Task:
    """Draw points all over the working area, with loads within those of the training data.

    Kept are those that the loaded crane, by linear statics, reaches with 2 cm to spare, ahead of its pillar.
    """
    model = crane.patu655()
    random = torch.Generator().manual_seed(seed)
    kept: list[tuple[Tensor, Tensor, Tensor]] = []
    while sum(len(points) for points, _, _ in kept) < count:
        unit = torch.rand(2 * count, 3, generator=random, dtype=torch.float64)
        low, high = unit.new_tensor([0.0, -4.5, _PAYLOADS[0]]), unit.new_tensor([7.0, 8.0, _PAYLOADS[-1]])
        kept.append(_reached(low + (high - low) * unit, model))
    targets, payload, starts = (torch.cat(columns)[:count] for columns in zip(*kept, strict=True))
    return Task(targets, payload, starts, model)


def _reached(drawn: Tensor, model: Crane) -> tuple[Tensor, Tensor, Tensor]:
    """Targets, payloads and starts of what is reached of drawn points and loads (N, 3)."""
    reach = crane.inverse(drawn[:, :2])
    drawn, starts = drawn[reach.within_limits], reach.strokes[reach.within_limits]
    limit = starts.new_tensor(model.upper)
    starts = ((100 * starts).round() / 100).clamp(min=0).minimum(limit)
    targets, payload = drawn[:, :2], drawn[:, 2]
    strokes, well = starts, torch.ones(len(starts), dtype=torch.bool)
    around = torch.tensor([[0, 0], [1, 0], [-1, 0], [0, 1], [0, -1]], dtype=torch.float64) * 0.02
    for _ in range(6):
        aims = targets - crane.deflection(strokes, payload)
        extension = torch.maximum(starts[:, None, 2], crane.least_extension(aims[:, None] + around))
        found = crane.inverse(aims[:, None] + around, extension)
        well = found.within_limits.all(-1)
        strokes = torch.where(well[:, None], found.strokes[:, 0], starts)
    return targets[well], payload[well], starts[well]


# ---- the rivals ------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class _Sags:
    """What was learned with one seed."""

    thesis: FeedForward
    larger: Mapping[int, FeedForward]
    angles: AngleNetworkSag
    regression: TrigonometricSag
    direct: FeedForward

    @classmethod
    def trained(
        cls, data: TrainingSet, choices: Mapping[str, Mapping[str, float]], seed: int, config: Config
    ) -> _Sags:
        train = partial(positioning.correction_network, data, epochs=config.epochs)
        return cls(
            train(_seeded(seed)),
            {neurons: train(_seeded(seed), neurons) for neurons in config.neurons},
            AngleNetworkSag.fit(data, _best(choices["neurons"]), _seeded(seed), config.epochs),
            TrigonometricSag.fit(data, _best(choices["degree"])),
            positioning.direct_network(data, _seeded(seed), epochs=config.epochs),
        )


def _seeded(seed: int) -> torch.Generator:
    return torch.Generator().manual_seed(seed)


def _best(errors: Mapping[str, float]) -> int:
    return int(min(errors, key=lambda choice: errors[choice]))


def _choices(data: TrainingSet, config: Config) -> dict[str, dict[str, float]]:
    """Root mean squares over held-out poses."""

    def regression(degree: int) -> Callable[[TrainingSet], SagModel]:
        return lambda rest: TrigonometricSag.fit(rest, degree)

    def network(neurons: int) -> Callable[[TrainingSet], SagModel]:
        return lambda rest: AngleNetworkSag.fit(rest, neurons, _seeded(0), config.epochs)

    degrees = {str(n): _held_out(data, config.folds, regression(n)) for n in config.degrees}
    neurons = {str(n): _held_out(data, config.network_folds, network(n)) for n in config.angle_neurons}
    return {"degree": degrees, "neurons": neurons}


def _held_out(data: TrainingSet, folds: int, fit: Callable[[TrainingSet], SagModel]) -> float:
    squares = []
    for rest, held in itertools.islice(_fifths(data), folds):
        misses = fit(rest)(held.strokes, held.payload) - held.deflection
        squares.append(misses.square().sum(-1).mean().item())
    return math.sqrt(float(np.mean(squares)))


def _fifths(data: TrainingSet) -> Iterator[tuple[TrainingSet, TrainingSet]]:
    """Split poses, with all their payloads, into what is learned from and what is held out."""
    poses, pose = data.strokes.unique(dim=0, return_inverse=True)
    fifth = (torch.randperm(len(poses), generator=_seeded(0)) % 5)[pose]
    for number in range(5):
        yield TrainingSet(data.rows[fifth != number]), TrainingSet(data.rows[fifth == number])


def _methods(sags: Sequence[_Sags], config: Config) -> dict[str, list[_Method]]:
    """All methods that are judged on linear statics, by seed; those without chance have one."""
    loop = partial(_compensated, corrections=config.corrections)
    linear, table = positioning.linear_sag(), TableSag.of(_GRID)
    learned = {
        THESIS: [_compensated(positioning.network_sag(own.thesis), 1) for own in sags],
        THESIS_LOOP: [loop(positioning.network_sag(own.thesis)) for own in sags],
        **{
            f"network of {neurons} neurons, in a loop": [
                loop(positioning.network_sag(own.larger[neurons])) for own in sags
            ]
            for neurons in config.neurons
        },
        ANGLES: [loop(own.angles) for own in sags],
        DIRECT: [_newton_on(positioning.network_tip(own.direct)) for own in sags],
    }
    return {
        NOTHING: [positioning.uncompensated],
        GENETIC: [
            _genetic(positioning.network_sag(own.thesis), seed, config)
            for seed, own in zip(config.seeds, sags, strict=True)
        ],
        DESCENT: [_descent(own.direct, config) for own in sags],
        **learned,
        REGRESSION: [loop(sags[0].regression)],
        REGRESSION_NEWTON: [_newton(sags[0].regression)],
        TABLE: [loop(table)],
        STRUCTURE_ONCE: [_compensated(linear, 1)],
        STRUCTURE: [loop(linear)],
        STRUCTURE_NEWTON: [_newton(linear)],
    }


def _compensated(sag: SagModel, corrections: int) -> _Method:
    return lambda task: positioning.compensate(task, sag, corrections=corrections)


def _genetic(sag: SagModel, seed: int, config: Config) -> _Method:
    options = GeneticInverseOptions(generations=config.generations)
    return lambda task: positioning.compensate(task, sag, positioning.genetic(_seeded(seed), options))


def _descent(network: FeedForward, config: Config) -> _Method:
    options = DescentOptions(iterations=config.descent)
    return lambda task: positioning.descend(task, network, options)


def _newton(sag: SagModel) -> _Method:
    return lambda task: positioning.gauss_newton(task, positioning.sagging_tip(task, sag))


def _newton_on(tip: TipModel) -> _Method:
    return lambda task: positioning.gauss_newton(task, tip)


@dataclass(frozen=True, eq=False)
class _Judge:
    test: Task
    part: slice
    fresh: Task

    def judged(self, by_seed: Sequence[_Method], at_fresh: bool) -> Judged:
        answers = [method(self.test) for method in by_seed]
        test = _stacked(positioning.errors(self.test, answer) for answer in answers)
        part, turned = _part(self.test, self.part), positioning.corotational_sag()
        corotational = _stacked(
            positioning.errors(part, _part_of(answer, self.part), turned) for answer in answers
        )
        fresh = np.full((1, 3), np.nan)
        if at_fresh:
            found = _stacked(positioning.errors(self.fresh, method(self.fresh)) for method in by_seed)
            mean, largest = _mean_and_largest(found).T
            fresh = np.stack([mean, np.quantile(found.numpy(), 0.99, axis=1), largest], axis=1)
        return Judged(_mean_and_largest(test), fresh, _mean_and_largest(corotational))


def _stacked(errors: Iterable[positioning.Errors]) -> Tensor:
    return torch.stack([error.distance for error in errors])


def _on_itself(misses: Tensor) -> Judged:
    """Judgement of the co-rotational loop, which is asked on its own structure only."""
    unknown = np.full((1, 3), np.nan)
    return Judged(unknown[:, :2], unknown, _mean_and_largest(misses[None]))


def _mean_and_largest(distances: Tensor) -> NDArray[np.float64]:
    """Of each row (n, N): (n, 2)."""
    found: NDArray[np.float64] = torch.stack([distances.mean(-1), distances.amax(-1)], dim=-1).numpy()
    return found


def _part(task: Task, which: slice) -> Task:
    return Task(task.targets[which], task.payload[which], task.starts[which], task.crane)


def _part_of(answer: Placement, which: slice) -> Placement:
    return Placement(answer.strokes[which], answer.converged[which], answer.iterations[which])


# ---- Gauss–Newton, plain and damped ----------------------------------------------------------------


def _inverted(task: Task, direct: FeedForward) -> dict[str, dict[str, Inverted]]:
    upper = task.starts.new_tensor(task.crane.upper)
    drawn = upper * torch.rand(len(task), 3, generator=_seeded(0), dtype=torch.float64)
    starts = {
        "rigid solution, rounded": task.starts,
        "another point's": task.starts.roll(5, 0).minimum(upper),
        "anywhere": drawn,
    }
    models = {
        "structure": positioning.sagging_tip(task, positioning.linear_sag()),
        "direct network": positioning.network_tip(direct),
    }
    return {
        model: {
            name: _compared(dataclasses.replace(task, starts=begin), tip) for name, begin in starts.items()
        }
        for model, tip in models.items()
    }


def _compared(task: Task, tip: TipModel) -> Inverted:
    plain, damped = _plain_gauss_newton(task, tip), positioning.gauss_newton(task, tip).strokes
    misses = [(tip(strokes, task.payload)[0] - task.targets).norm(dim=-1) for strokes in (plain, damped)]
    failing = [(miss > _FAILED).double().mean().item() for miss in misses]
    return Inverted(*failing, *(miss.max().item() for miss in misses))


def _plain_gauss_newton(task: Task, tip: TipModel, steps: int = 30) -> Tensor:
    """Strokes (N, 3) after whole steps of least length, each cut off at the cylinders' ends."""
    strokes = task.starts
    for _ in range(steps):
        position, slope = tip(strokes, task.payload)
        move = torch.linalg.pinv(slope) @ (task.targets - position)[..., None]
        strokes = (strokes + move[..., 0]).maximum(task.lower).minimum(task.upper)
    return strokes


# ---- the thesis's remedies -------------------------------------------------------------------------


def _data(strokes: Tensor, payloads: Sequence[float], model: Crane) -> TrainingSet:
    """Training data at poses (P, 3), each with all payloads."""
    response, rigid = crane.load_response(strokes, model), crane.tip_position(strokes, model)
    mass = torch.tensor(payloads, dtype=torch.float64)[:, None]
    sag = response.own_weight[:, None] + mass * response.per_kilogram[:, None]
    rows = [strokes[:, None].expand(-1, len(mass), -1), mass.expand(len(strokes), -1, -1)]
    return TrainingSet(torch.cat([*rows, rigid[:, None] + sag, sag], dim=-1).flatten(0, 1))


def _poses(counts: Sequence[int], model: Crane) -> Tensor:
    """Grid of strokes (P, 3) whose tips are ahead of the pillar."""
    steps = [
        torch.linspace(low, high, n, dtype=torch.float64)
        for low, high, n in zip(model.lower, model.upper, counts, strict=True)
    ]
    strokes = torch.cartesian_prod(*steps)
    return strokes[crane.tip_position(strokes, model)[:, 0] >= 0]


def _lighter(task: Task, data: TrainingSet, config: Config) -> dict[str, NDArray[np.float64]]:
    poses = _poses(_GRID, task.crane)
    sets = {_AS_THESIS: data, _LIGHTER: _data(poses, (10.0, 20.0, 40.0, *_PAYLOADS), task.crane)}
    light = task.payload == 30
    spot = light & (task.targets == 2).all(-1)

    def errors(own: TrainingSet, seed: int) -> list[float]:
        network = positioning.correction_network(own, _seeded(seed), epochs=config.remedy_epochs)
        placement = positioning.compensate(task, positioning.network_sag(network))
        distance = positioning.errors(task, placement).distance
        return [distance[which].mean().item() for which in (spot, light, slice(None))]

    return {name: np.array([errors(own, seed) for seed in config.seeds]) for name, own in sets.items()}


def _spread(task: Task, config: Config) -> dict[str, dict[str, NDArray[np.float64]]]:
    model = task.crane
    poses = _poses(_GRID, model)
    fine = _poses([2 * count - 1 for count in _GRID], model)
    sets = {
        _THESIS_GRID: _data(poses, _PAYLOADS, model),
        _EVEN: _data(fine[_farthest(crane.tip_position(fine, model), len(poses))], _PAYLOADS, model),
        _DENSER: _data(_poses((13, 13, 7), model), _PAYLOADS, model),
    }
    options = DescentOptions(iterations=config.descent)

    def errors(method: str, data: TrainingSet, seed: int) -> Tensor:
        train = positioning.direct_network if method == _SECOND else positioning.modular_network
        network = train(data, _seeded(seed), epochs=config.remedy_epochs)
        return positioning.errors(task, positioning.descend(task, network, options)).distance

    return {
        method: {
            name: _mean_and_largest(torch.stack([errors(method, data, seed) for seed in config.seeds]))
            for name, data in sets.items()
        }
        for method in (_SECOND, _THIRD)
    }


def _farthest(points: Tensor, count: int) -> Tensor:
    """Pick points (N, 2), each as far as possible from those before; the first is the first."""
    chosen = [0]
    away = (points - points[0]).norm(dim=-1)
    while len(chosen) < count:
        chosen.append(int(away.argmax()))
        away = away.minimum((points - points[chosen[-1]]).norm(dim=-1))
    return torch.tensor(chosen)


_SIZES = {"the crane": 1.0, "half its size": 0.5}


def _other_sizes(task: Task, config: Config) -> _BySize:
    found = _BySize({}, {}, {})
    for name, size in _SIZES.items():
        model = crane.scaled(task.crane, size)
        own = Task(size * task.targets, size**3 * task.payload, size * task.starts, model)
        payloads = [size**3 * mass for mass in _PAYLOADS]
        data = _data(_poses(_GRID, model), payloads, model)
        answers = [
            positioning.by_inverse_network(
                own, positioning.inverse_network(data, _seeded(seed), epochs=config.remedy_epochs)
            )
            for seed in config.seeds
        ]
        distances = torch.stack([positioning.errors(own, answer).distance for answer in answers])
        found.sizes[name] = _mean_and_largest(distances)
        slopes = crane.tip_jacobian(own.starts, model)
        found.amplification[name] = torch.linalg.matrix_norm(slopes, ord=2).max().item()
        found.tables[name] = _table_errors(model, payloads, config)
    return found


class _BySize(NamedTuple):
    sizes: dict[str, NDArray[np.float64]]
    amplification: dict[str, float]
    tables: dict[str, NDArray[np.float64]]


def _table_errors(model: Crane, payloads: Sequence[float], config: Config) -> NDArray[np.float64]:
    unit = torch.rand(config.looked_up, 4, generator=_seeded(0), dtype=torch.float64)
    strokes = unit[:, :3] * unit.new_tensor(model.upper)
    payload = payloads[0] + (payloads[-1] - payloads[0]) * unit[:, 3]
    ahead = crane.tip_position(strokes, model)[:, 0] >= 0
    strokes, payload = strokes[ahead], payload[ahead]
    exact = crane.deflection(strokes, payload, model)
    rows = []
    for refinement in config.refinements:
        table = TableSag.of([refinement * (count - 1) + 1 for count in _GRID], model)
        rows.append((table.entries, (table(strokes, payload) - exact).norm(dim=-1).max().item()))
    return np.array(rows, dtype=np.float64)


# ---- times -----------------------------------------------------------------------------------------


def _times(
    sags: _Sags, methods: Mapping[str, Sequence[_Method]], task: Task, config: Config
) -> dict[str, tuple[Timing, ...]]:
    few = _part(task, slice(2, None, len(task) // config.small))
    many, batch = fresh_task(config.few), fresh_task(config.batch)
    linear, turned = positioning.linear_sag(), positioning.corotational_sag()
    fast: dict[str, SagModel] = {
        "thesis's network": positioning.network_sag(sags.thesis),
        "network in angles": sags.angles,
        "regression in angles": sags.regression,
        "table": TableSag.of(_GRID),
        "structure": linear,
    }
    quick = {
        name: methods[name][0]
        for name in (
            THESIS,
            THESIS_LOOP,
            ANGLES,
            REGRESSION,
            STRUCTURE_ONCE,
            STRUCTURE,
            STRUCTURE_NEWTON,
            DIRECT,
        )
    }
    slow: dict[str, _Method] = {
        COROTATIONAL: _compensated(turned, config.corotational_corrections),
        GENETIC: methods[GENETIC][0],
        DESCENT: methods[DESCENT][0],
    }
    ones = [_part(few, slice(i, i + 1)) for i in range(len(few))]

    def asked(sag: SagModel, tasks: Sequence[Task]) -> Callable[[], object]:
        return lambda: [sag(own.starts, own.payload) for own in tasks]

    def positioned(method: _Method, tasks: Sequence[Task]) -> Callable[[], object]:
        return lambda: [method(own) for own in tasks]

    ways = {
        SAG_SINGLE: [
            Way(name, asked(sag, ones), len(ones)) for name, sag in (fast | {"co-rotational": turned}).items()
        ],
        SAG_BATCH: [
            *(Way(name, asked(sag, [batch]), len(batch)) for name, sag in fast.items()),
            Way("co-rotational", asked(turned, [many]), len(many)),
        ],
        POINT_SINGLE: [
            Way(name, positioned(method, ones), len(ones)) for name, method in (quick | slow).items()
        ],
        POINT_BATCH: [
            *(Way(name, positioned(method, [batch]), len(batch)) for name, method in quick.items()),
            *(Way(name, positioned(slow[name], [many]), len(many)) for name in (COROTATIONAL, DESCENT)),
        ],
    }
    return {kind: _processor_time(own, config) for kind, own in ways.items()}


def _data_seconds(config: Config) -> float:
    if not config.rounds:
        return math.nan
    (timing,) = _processor_time([Way("training data", crane.training_set, 1)], config)
    return timing.median


def _processor_time(ways: Sequence[Way], config: Config) -> tuple[Timing, ...]:
    return measure(ways, config.rounds, config.seconds, time.process_time)


# ---- bad input -------------------------------------------------------------------------------------


def refusals() -> dict[str, str]:
    """Ask for what cannot be had, and return what the package answers."""
    task = positioning.thesis_task([(3.0, 2.0)], [100.0])
    beyond = Placement(task.starts + 0.5, torch.ones(1, dtype=torch.bool), torch.ones(1, dtype=torch.long))
    far = crane.inverse([9.0, 9.0])
    flags = {
        "strokes beyond their ends": f"within_limits is {crane.within_limits(beyond.strokes)[0].tolist()}",
        "such strokes as an answer": f"stopped is {_one(positioning.errors(task, beyond).stopped)}",
        "a point out of reach, of the rigid crane": f"within_limits is {_one(far.within_limits)}",
        "a point out of reach, of Gauss–Newton": f"converged is {_far_converges(task)}",
    }
    asked: dict[str, Callable[[], object]] = {
        "a point out of reach, as a task": lambda: positioning.thesis_task([(9.0, 9.0)]),
        "a load beyond the rating, of the structure": lambda: crane.deflection(task.starts, 600.0),
        "a load beyond the rating, as a task": lambda: positioning.thesis_task([(3.0, 2.0)], [600.0]),
        "a lift linkage that cannot close": lambda: crane.tip_position([1.5, 0.3, 0.2]),
        "a jib linkage that cannot close": lambda: crane.tip_position([0.2, 1.5, 0.2]),
        "an extension that leaves the jib": lambda: crane.deflection([0.2, 0.3, 2.5], 100.0),
        "a stroke that is no number": lambda: crane.tip_position([0.2, math.nan, 0.2]),
    }
    return flags | {name: _refusal(question) for name, question in asked.items()}


def _far_converges(task: Task) -> bool:
    far = dataclasses.replace(task, targets=task.targets + 9.0)
    return _one(_newton(positioning.linear_sag())(far).converged)


def _one(flag: Tensor) -> bool:
    return bool(flag.item())


def _refusal(question: Callable[[], object]) -> str:
    try:
        question()
    except ValueError as error:
        return f"{type(error).__name__}: {error}"
    return "no objection"


# ---- tables ----------------------------------------------------------------------------------------


def method_table(result: Result) -> dict[str, dict[str, str]]:
    """Tabulate errors [mm], median and range over seeds: linear statics on the test and at fresh points."""
    return {
        name: {
            "mean": _millimetres(judged.test[:, 0]),
            "largest": _millimetres(judged.test[:, 1]),
            "fresh, mean": _millimetres(judged.fresh[:, 0]),
            "fresh, 99 %": _millimetres(judged.fresh[:, 1]),
            "fresh, largest": _millimetres(judged.fresh[:, 2]),
        }
        for name, judged in result.methods.items()
        if name != COROTATIONAL
    }


def corotational_table(result: Result) -> dict[str, dict[str, str]]:
    """Tabulate errors [mm] on the co-rotational structure."""
    return {
        name: {
            "mean": _millimetres(judged.corotational[:, 0]),
            "largest": _millimetres(judged.corotational[:, 1]),
        }
        for name, judged in result.methods.items()
    }


def loop_table(result: Result) -> dict[str, dict[str, float]]:
    """Tabulate errors [mm] by the number of structural solves that were made for the strokes."""
    rows = {}
    for count, (mean, largest) in enumerate(1e3 * result.loop):
        rows[str(count)] = {"mean": mean, "largest": largest, "co-rotational, mean": math.nan}
        rows[str(count)] |= {"co-rotational, largest": math.nan}
    for count, (mean, largest) in enumerate(1e3 * result.corotational_loop):
        rows[str(count)] |= {"co-rotational, mean": mean, "co-rotational, largest": largest}
    return rows


def choice_table(result: Result) -> dict[str, dict[str, str]]:
    """Tabulate what was chosen by poses held out, root mean squares in [mm]."""
    return {
        {"degree": "degree of the regression", "neurons": "neurons in angles"}[kind]: {
            "tried": ", ".join(f"{choice}: {1e3 * error:.3g}" for choice, error in errors.items()),
            "chosen": str(_best(errors)),
        }
        for kind, errors in result.choices.items()
    }


def inversion_table(result: Result) -> dict[tuple[str, str], dict[str, str]]:
    """Tabulate how often Gauss–Newton fails, plain and damped, and the largest miss [mm]."""
    return {
        (model, start): {
            "plain fails": f"{found.plain:.0%}",
            "worst miss": _millimetre(found.plain_worst),
            "damped fails": f"{found.damped:.0%}",
            "its worst miss": _millimetre(found.damped_worst),
        }
        for model, by_start in result.inverted.items()
        for start, found in by_start.items()
    }


def remedy_table(result: Result) -> dict[tuple[str, str], dict[str, str]]:
    """Tabulate errors [mm] with the data that the thesis wishes for, median and range over seeds."""
    rows = {
        ("method 1", name): {
            "(2, 2), 30 kg": _millimetres(found[:, 0]),
            "mean with 30 kg": _millimetres(found[:, 1]),
            "mean": _millimetres(found[:, 2]),
            "largest": "–",
        }
        for name, found in result.payloads.items()
    }
    for method, by_data in result.spread.items():
        for name, found in by_data.items():
            rows[method, name] = {
                "(2, 2), 30 kg": "–",
                "mean with 30 kg": "–",
                "mean": _millimetres(found[:, 0]),
                "largest": _millimetres(found[:, 1]),
            }
    return rows


def size_table(result: Result) -> dict[str, dict[str, str]]:
    """Tabulate errors of method 4 by size of the crane."""
    return {
        name: {
            "mean [mm]": _millimetres(found[:, 0]),
            "largest [mm]": _millimetres(found[:, 1]),
            "mean, of the first crane's size [mm]": _millimetres(found[:, 0] / _SIZES[name]),
            "amplification": f"{result.amplification[name]:.3g}",
        }
        for name, found in result.sizes.items()
    }


def table_table(result: Result) -> dict[str, dict[str, str]]:
    """Tabulate the largest error of tables [mm] by the number of their entries, and by size of the crane."""
    columns = {
        name: {f"{int(entries):,}": _millimetre(error) for entries, error in rows}
        for name, rows in result.tables.items()
    }
    entries = next(iter(columns.values()))
    return {f"{count} entries": {name: own[count] for name, own in columns.items()} for count in entries}


def speed_table(result: Result, of: Literal["sag", "point"]) -> dict[str, dict[str, str]]:
    """Tabulate processor times [µs] with quartiles, at once and one by one; empty where none were taken."""
    kinds = (SAG_BATCH, SAG_SINGLE) if of == "sag" else (POINT_BATCH, POINT_SINGLE)
    at_once, alone = (_by_name(result, kind) for kind in kinds)
    return {
        name: {
            "at once [µs]": _microseconds(at_once.get(name)),
            "one by one [µs]": _microseconds(timing),
            "a second, at once": f"{1 / at_once[name].median:,.0f}" if name in at_once else "–",
        }
        for name, timing in alone.items()
    }


def trade(result: Result) -> dict[str, dict[str, float]]:
    """Return times for a point [ms] and the mean error on the test [mm] by method, each on its structure."""
    errors = {name: float(np.median(judged.test[:, 0])) for name, judged in result.methods.items()}
    errors[COROTATIONAL] = float(result.corotational_loop[-1, 0])
    at_once, alone = (_by_name(result, kind) for kind in (POINT_BATCH, POINT_SINGLE))
    return {
        name: {
            "at once": 1e3 * at_once.get(name, timing).median,
            "one by one": 1e3 * timing.median,
            "error": 1e3 * errors[name],
        }
        for name, timing in alone.items()
    }


def _told(value: float) -> str:
    return f"{value:,.0f}" if value >= 100 else f"{value:.3g}"


def _by_name(result: Result, kind: str) -> dict[str, Timing]:
    return {timing.name: timing for timing in result.times.get(kind, ())}


def _microseconds(timing: Timing | None) -> str:
    if timing is None:
        return "–"
    median, lower, upper = (_told(1e6 * value) for value in (timing.median, timing.lower, timing.upper))
    return f"{median} ({lower}–{upper})"


def _millimetres(values: NDArray[np.float64]) -> str:
    return with_range(1e3 * values, "{:.3g}".format)


def _millimetre(value: float) -> str:
    return f"{1e3 * value:.3g}"


# ---- verdicts --------------------------------------------------------------------------------------


def verdicts(result: Result) -> tuple[Verdict, ...]:
    """Judge the claims of the ledger that this study answers for."""
    return (*_on_remedies(result), *_on_solving(result), *_on_speed(result), _on_tables(result))


def _on_remedies(result: Result) -> tuple[Verdict, ...]:
    before, after = (result.payloads[name][:, 0] for name in (_AS_THESIS, _LIGHTER))
    light = [result.payloads[name][:, 1] for name in (_AS_THESIS, _LIGHTER)]
    largest = {
        method: {name: found[:, 1] for name, found in by_data.items()}
        for method, by_data in result.spread.items()
    }
    even = {method: _worked(own[_EVEN] < own[_THESIS_GRID]) for method, own in largest.items()}
    told = "; ".join(
        f"{method}: {_millimetres(own[_THESIS_GRID])} mm with the thesis's grid, "
        f"{_millimetres(own[_EVEN])} mm with as many poses spread evenly, "
        f"{_millimetres(own[_DENSER])} mm with a denser grid"
        for method, own in largest.items()
    )
    first, half = (result.sizes[name] for name in _SIZES)
    share = float(np.median(half[:, 0]) / _SIZES["half its size"] / np.median(first[:, 0]))
    amplification = list(result.amplification.values())
    return (
        _verdict(
            "crane-lighter-payloads-would-help", _worked(after < before),
            f"{_millimetres(after)} mm beside {_millimetres(before)} mm", _seeds(before),
            f"With 10, 20 and 40 kg in the data the error at (2, 2) with 30 kg falls in "
            f"{_share(after < before)} of the seeds; the mean of all points with 30 kg goes from "
            f"{_millimetres(light[0])} to {_millimetres(light[1])} mm.",
        ),
        _verdict(
            "crane-denser-data-would-help", _all_of(even.values()),
            ", ".join(
                f"{_share(own[_EVEN] < own[_THESIS_GRID])} of the seeds ({method})"
                for method, own in largest.items()
            ),
            _seeds(before), f"Largest errors, {told}.",
        ),
        _verdict(
            "crane-smaller-would-help",
            _by_share(share, float(np.median(half[:, 0]) / np.median(first[:, 0]))),
            f"{_millimetres(half[:, 0])} mm beside {_millimetres(first[:, 0])} mm", _seeds(first),
            f"With half the size the mean error is, as a share of the size, {share:.2f} times what it was: "
            f"it shrinks with the crane. The amplification, which is blamed, is a ratio and stays as it is "
            f"({amplification[0]:.3g} and {amplification[1]:.3g}).",
        ),
    )  # fmt: skip


def _worked(better: NDArray[np.bool_]) -> Outcome:
    """Judge a remedy by the seeds in which it lowers an error."""
    if better.mean() >= _MOST:
        return Outcome.REPRODUCED
    return Outcome.CONTRADICTED if better.mean() <= 1 - _MOST else Outcome.NOT_REPRODUCED


def _all_of(outcomes: Iterable[Outcome]) -> Outcome:
    """Judge a claim on several methods: in shape if it holds of some."""
    found = set(outcomes)
    if len(found) == 1:
        return found.pop()
    return Outcome.IN_SHAPE if Outcome.REPRODUCED in found else Outcome.NOT_REPRODUCED


def _by_share(share: float, absolute: float) -> Outcome:
    """Judge a smaller crane: better beside its size, or in millimetres alone."""
    if share < 0.9:
        return Outcome.REPRODUCED
    return Outcome.IN_SHAPE if absolute < 1 else Outcome.NOT_REPRODUCED


def _on_solving(result: Result) -> tuple[Verdict, ...]:
    once, looped = result.loop[1], result.loop[-1]
    printed = _printed("crane-correction-mean")[2] / 1e3
    solved = once[0] < printed and looped[1] <= _EXACT
    measured, simulated = _printed("crane-measured-target-rmean")[-1], _printed("crane-correction-mean")[2]
    minutes = _printed("crane-training-time")[0]
    quick = result.data_seconds < 60 * minutes
    accurate = measured <= simulated + _printed("crane-measured-accuracy")[0]
    outcome = (Outcome.REPRODUCED if accurate else Outcome.IN_SHAPE) if quick else Outcome.NOT_REPRODUCED
    timed = math.isfinite(result.data_seconds)
    speed = f"{result.data_seconds:.2g} s for all of the training data" if timed else ""
    return (
        _verdict(
            "crane-analytical-impossible", Outcome.CONTRADICTED if solved else Outcome.REPRODUCED,
            f"{_millimetre(once[0])} mm once, {_millimetre(looped[1])} mm in a loop",
            "mean after one correction; largest after the last",
            f"Rigid inverse and deflection have closed forms both. One put into the other once, without any "
            f"iteration, misses by {_millimetre(once[0])} mm on average, and {len(result.loop) - 1} times by "
            f"{_millimetre(looped[1])} mm at most. At {result.unsettled:.1%} of fresh points that does not "
            f"settle, where the jib is folded, and Gauss–Newton takes over.",
        ),
        _verdict(
            "crane-simulation-suffices", outcome if timed else Outcome.UNDERSPECIFIED, speed,
            "on one core" if timed else "",
            f"{f'Quickly: {speed}. ' if timed else 'No times were taken. '}Accurately as far as models go: a "
            f"co-rotational structure differs by {_millimetre(result.apart[0])} mm on average, "
            f"{_millimetre(result.apart[1])} mm at most. The real crane, compensated so, is measured "
            f"{measured} mm off on average in the thesis, where simulation has {simulated:.3g} mm.",
        ),
    )  # fmt: skip


def _on_speed(result: Result) -> tuple[Verdict, ...]:
    if not result.times:
        claims = ("crane-iterative-is-expensive", "crane-networks-are-cheaper")
        return tuple(
            _verdict(claim, Outcome.UNDERSPECIFIED, "", "", "No times were taken.") for claim in claims
        )
    single, batch = (_timing(result, kind, STRUCTURE) for kind in (POINT_SINGLE, POINT_BATCH))
    turned = [_timing(result, kind, COROTATIONAL) for kind in (POINT_BATCH, POINT_SINGLE)]
    network, structure = (_timing(result, SAG_BATCH, name) for name in ("thesis's network", "structure"))
    alone = [_timing(result, SAG_SINGLE, name) for name in ("thesis's network", "structure")]
    outcome = Outcome.REPRODUCED
    if batch.upper < _REAL_TIME:
        outcome = Outcome.CONTRADICTED if single.upper < _REAL_TIME else Outcome.NOT_REPRODUCED
    cheaper = all(a.upper < b.lower for a, b in ((network, structure), (alone[0], alone[1])))
    minutes, vectors = _printed("crane-training-time")[0], 4000
    then = 60 * minutes / vectors * (len(result.loop) - 1)
    return (
        _verdict(
            "crane-iterative-is-expensive", outcome,
            f"{1e3 * batch.median:.2g} ms a point at once, {1e3 * single.median:.2g} ms one by one",
            f"{_quartiles(batch)}; {_quartiles(single)}",
            f"That is {len(result.loop) - 1} solves of the structure, and one by one it is mostly calls from "
            f"Python, which a controller does without. The co-rotational structure takes "
            f"{1e3 * turned[0].median:.2g} ms at once and {1e3 * turned[1].median:.2g} ms one by one. With "
            f"the analyses of 1999, of which {vectors:,} took {minutes:g} min, a point would "
            f"have taken {then:.1f} s, and the claim was right then.",
        ),
        _verdict(
            "crane-networks-are-cheaper", Outcome.of(cheaper),
            f"{ratio(structure, network)} times as fast", "at once, on one core",
            f"{1 / network.median:,.0f} network evaluations a second beside {1 / structure.median:,.0f} "
            f"structural solves. One by one the ratio is {ratio(alone[1], alone[0])}.",
        ),
    )  # fmt: skip


def _on_tables(result: Result) -> Verdict:
    powers = {name: _power(rows) for name, rows in result.tables.items()}
    needed = {name: _needed(rows) for name, rows in result.tables.items()}
    big, small = powers
    grows = powers[big] > 1 and needed[big] > needed[small]
    first, finest = result.tables[big][0], result.tables[big][-1]
    return _verdict(
        "crane-tables-grow", Outcome.of(grows), f"error^(−{powers[big]:.2f})", "entries, fitted",
        f"{first[0]:,.0f} entries leave {_millimetre(first[1])} mm, {finest[0]:,.0f} leave "
        f"{_millimetre(finest[1])} mm. A millimetre takes about {needed[big]:,.0f} entries, and with a crane "
        f"of half the size {needed[small]:,.0f}.",
    )  # fmt: skip


def _power(rows: NDArray[np.float64]) -> float:
    """By what power of one over the error the entries grow."""
    entries, errors = np.log(rows).T
    return -float(np.polyfit(errors, entries, 1)[0])


def _needed(rows: NDArray[np.float64], goal: float = 1e-3) -> float:
    """Entries for a largest error [m], by the fitted power."""
    entries, errors = np.log(rows).T
    return float(np.exp(np.polyval(np.polyfit(errors, entries, 1), math.log(goal))))


def _timing(result: Result, kind: str, name: str) -> Timing:
    return _by_name(result, kind)[name]


def _quartiles(timing: Timing) -> str:
    return f"quartiles {1e3 * timing.lower:.2g} and {1e3 * timing.upper:.2g} ms"


def _printed(claim: str) -> tuple[float, ...]:
    value = load_paper(_PAPER).claim(claim).value
    if value is None:
        raise ValueError(f"the claim {claim} has no value")
    return value if isinstance(value, tuple) else (value,)


def _share(better: NDArray[np.bool_]) -> str:
    return f"{better.sum()} of {len(better)}"


def _seeds(values: NDArray[np.float64]) -> str:
    return f"{len(values)} seed" + ("s" if len(values) > 1 else "")


def _verdict(claim: str, outcome: Outcome, ours: str, spread: str, sentence: str) -> Verdict:
    return Verdict(_PAPER, claim, outcome, ours, spread, sentence)


def acceptance(result: Result) -> tuple[Acceptance, ...]:
    """Return the figures that must hold, in [mm] and in [µs]."""
    learned = 1e3 * result.methods[REGRESSION].test[0]
    figures = [
        Acceptance(
            "largest error of the structure in a loop [mm]", 1e3 * float(result.loop[-1, 1]), 1e3 * _EXACT
        ),
        Acceptance(
            "largest error of the co-rotational structure in a loop [mm]",
            1e3 * float(result.corotational_loop[-1, 1]),
            1e3 * _EXACT,
        ),
        Acceptance("mean error of the learned sag [mm]", float(learned[0]), 0.1),
        Acceptance("largest error of the learned sag [mm]", float(learned[1]), 0.5),
    ]
    if result.times:
        network = _timing(result, SAG_BATCH, "thesis's network")
        figures.append(Acceptance("time of a network evaluation, at once [µs]", 1e6 * network.median, 2.0))
    return tuple(figures)
