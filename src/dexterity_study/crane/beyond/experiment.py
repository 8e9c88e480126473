"""What beats the methods of paper D: structures and learned sags in a loop, how fast, and its remedies tried.

Source: Rouvinen (1999), sections 1.1, 1.2, 4.1, 4.2 and 4.5, chapter 5. All methods get the thesis's 125 tasks, and
fresh points all over the working area. What has to be chosen of a learned sag is chosen by poses of the training
data that are held out, never by the test. Lengths are in [m], times in [s].
"""

from __future__ import annotations

import itertools
import math
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
import torch
from torch import Tensor

from dexterity import crane
from dexterity.crane import TrainingSet, positioning
from dexterity.crane.description import Crane
from dexterity.crane.positioning import Placement, Task
from dexterity.crane.positioning.task import SagModel
from dexterity.timing import Way, measure
from dexterity_study.crane.cases import CRANE, PAPER, Rows, Values, seeded
from dexterity_study.engine.experiment import experiment

NOTHING, GENETIC, DESCENT = "no compensation", "thesis's method 1, genetic", "thesis's method 2, descent"
THESIS, REGRESSION, STRUCTURE = "thesis's network", "regression in angles", "structure"
COROTATIONAL = "co-rotational structure, in a loop"
SLOW = ("co-rotational", COROTATIONAL, GENETIC, DESCENT)

CORRECTIONS, COROTATIONAL_CORRECTIONS = 6, 4
EXACT = 5e-5
"""Error beyond which a loop has not settled on itself."""

DEGREES, ANGLE_NEURONS = range(1, 9), (10, 20, 30, 40)
GRID, PAYLOADS = (9, 9, 5), tuple(float(mass) for mass in range(50, 501, 50))
"""Strokes and payloads [kg] of the thesis's training data."""

Method = Callable[[Task], Placement]

STEADY = {"rtol": 1e-4, "atol": 1e-7}
OF_SIZE: Mapping[str, Any] = {"assumes": ("crane-smaller-crane",), **PAPER, **STEADY}
FEW = {"fresh": 60, "every": 13}
LITTLE = {"angle_neurons": (5, 8), "folds": 1, "epochs": 8, "generations": 20, "descent": 50}
"""Points and learning at smoke effort."""


@experiment(keys=("points", "structure", "solves"), smoke={"corotational": 3, **FEW}, **CRANE, **STEADY)
def loops(seed: int, corotational: int = COROTATIONAL_CORRECTIONS, fresh: int = 5000, every: int = 1) -> Rows:
    """Errors of structures in a loop, on themselves, by the number of structural solves."""
    test, linear = positioning.thesis_task(), positioning.linear_sag()
    for points, structure, task, sag, corrections in (
        ("test", "linear", test, linear, CORRECTIONS),
        ("fresh", "linear", fresh_task(fresh, seed), linear, CORRECTIONS),
        ("test", "co-rotational", _every(test, every), positioning.corotational_sag(), corotational),
    ):
        for solves in range(corrections + 1):
            rigid = positioning.exact_inverse(task, task.targets)
            answer = positioning.compensate(task, sag, corrections=solves) if solves else rigid
            misses = positioning.errors(task, answer, sag, end_stops=False).distance
            row = {"points": points, "structure": structure, "solves": solves, **_two(misses)}
            yield row | {"unsettled": (misses > EXACT).double().mean()}


@experiment(smoke={"every": 13}, **CRANE, **STEADY)
def models_apart(every: int = 1) -> Rows:
    """Distance of the co-rotational sag from the linear one in the test."""
    task = _every(positioning.thesis_task(), every)
    linear, turned = (_ask(sag, task) for sag in (positioning.linear_sag(), positioning.corotational_sag()))
    yield _two((linear - turned).norm(dim=-1))


@experiment(keys=("method",), smoke={"degrees": (3, 4), "folds": 2, **FEW}, **CRANE, **STEADY)
def exact_methods(
    seed: int, degrees: Sequence[int] = DEGREES, folds: int = 5, fresh: int = 5000, every: int = 1
) -> Rows:
    """Errors of the methods without chance."""
    points = fresh_task(fresh, seed)
    for name, method in _exact(degrees, folds)[1].items():
        yield {"method": name, **_judged(method, points, every)}


# A training carries rounding errors on, which differ between processors.
@experiment(seeds=10, keys=("method",), smoke={"neurons": (16,), **FEW, **LITTLE}, rtol=1e-3, **CRANE)
def learned_methods(
    seed: int, neurons: Sequence[int] = (28, 40, 80), fresh: int = 5000, every: int = 1, **learning: Any
) -> Rows:
    """Errors of the methods that rest on networks: the thesis's, larger ones, and one in angles."""
    points = fresh_task(fresh)
    for name, method in _learned(seed, neurons, **learning)[1].items():
        yield {"method": name, **_judged(method, None if name == GENETIC else points, every)}


@experiment(
    seeds=10, keys=("data",), smoke={"epochs": 3}, assumes=("crane-lighter-payloads",), **PAPER, **STEADY
)
def lighter_payloads(seed: int, reading: Values, epochs: int = 200) -> Rows:
    """Errors of the thesis's first method with lighter payloads in its data and without."""
    task = positioning.thesis_task()
    light = task.payload == 30
    lighter = grid_data(GRID, (*reading["crane-lighter-payloads"], *PAYLOADS))
    for name, data in (("thesis's payloads", crane.training_set()), ("lighter ones besides", lighter)):
        network = positioning.correction_network(data, seeded(seed), epochs=epochs)
        placement = positioning.compensate(task, positioning.network_sag(network))
        distance = positioning.errors(task, placement).distance
        spot = distance[light & (task.targets == 2).all(-1)].mean()
        yield {"data": name, "spot": spot, "light": distance[light].mean(), "mean": distance.mean()}


@experiment(seeds=10, keys=("method", "data"), smoke={"epochs": 3, "descent": 50}, **CRANE, **STEADY)
def even_data(seed: int, epochs: int = 200, descent: int = 10_000) -> Rows:
    """Errors of methods 2 and 3 with data that covers the working area more evenly."""
    task, options = positioning.thesis_task(), positioning.DescentOptions(iterations=descent)
    grid, fine = grid_data(GRID), grid_data([2 * count - 1 for count in GRID])
    poses = fine.strokes[:: len(PAYLOADS)]
    evenly = farthest(crane.tip_position(poses), len(grid) // len(PAYLOADS))
    sets = {
        "thesis's grid": grid,
        "as many, evenly": TrainingSet(fine.rows.unflatten(0, (len(poses), -1))[evenly].flatten(0, 1)),
        "a denser grid": grid_data((13, 13, 7)),
    }
    for method, name in itertools.product(("method 2", "method 3"), sets):
        train = positioning.direct_network if method == "method 2" else positioning.modular_network
        network = train(sets[name], seeded(seed), epochs=epochs)
        distance = positioning.errors(task, positioning.descend(task, network, options)).distance
        yield {"method": method, "data": name, **_two(distance)}


@experiment(seeds=10, keys=("size",), smoke={"epochs": 3}, **OF_SIZE)
def smaller_crane(seed: int, reading: Values, epochs: int = 200) -> Rows:
    """Errors of method 4 by size of the crane, and largest movement of the tip by movement of a cylinder."""
    test = positioning.thesis_task()
    for size in (1.0, reading["crane-smaller-crane"]):
        model, payloads = crane.scaled(test.crane, size), [size**3 * mass for mass in PAYLOADS]
        task = Task(size * test.targets, size**3 * test.payload, size * test.starts, model)
        network = positioning.inverse_network(grid_data(GRID, payloads, model), seeded(seed), epochs=epochs)
        distance = positioning.errors(task, positioning.by_inverse_network(task, network)).distance
        amplification = torch.linalg.matrix_norm(crane.tip_jacobian(task.starts, model), ord=2).max()
        yield {"size": size, **_two(distance), "amplification": amplification}


@experiment(keys=("size", "entries"), smoke={"refinements": (1, 2), "looked_up": 500}, **OF_SIZE)
def tables(
    seed: int, reading: Values, refinements: Sequence[int] = (1, 2, 3, 4, 6, 8), looked_up: int = 100_000
) -> Rows:
    """Largest error of tables of the sag at random poses, with the steps of the training grid refined."""
    unit = torch.rand(looked_up, 4, generator=seeded(seed), dtype=torch.float64)
    for size in (1.0, reading["crane-smaller-crane"]):
        model = crane.scaled(crane.patu655(), size)
        strokes = unit[:, :3] * unit.new_tensor(model.upper)
        payload = size**3 * (PAYLOADS[0] + (PAYLOADS[-1] - PAYLOADS[0]) * unit[:, 3])
        ahead = crane.tip_position(strokes, model)[:, 0] >= 0
        exact = crane.deflection(strokes[ahead], payload[ahead], model)
        for refinement in refinements:
            table = positioning.TableSag.of([refinement * (count - 1) + 1 for count in GRID], model)
            largest = (table(strokes[ahead], payload[ahead]) - exact).norm(dim=-1).max()
            yield {"size": size, "entries": table.entries, "largest": largest}


@experiment(
    keys=("of", "points", "way"),
    smoke={"sizes": (2, 4, 50), "measuring": (1, 1e-4), "degrees": (3,), **LITTLE},
    timed=True,
    unsteady=("lower", "median", "upper"),
    **CRANE,
    **STEADY,
)
def times(
    seed: int,
    sizes: tuple[int, int, int] = (5, 20, 1000),
    measuring: tuple[int, float] = (15, 0.02),
    degrees: Sequence[int] = DEGREES,
    **learning: Any,
) -> Rows:
    """Processor times of a sag alone and of a point from target to strokes, one by one and at once; and of all data."""
    (sags, methods), (others, exact) = _learned(seed, (), **learning), _exact(degrees)
    turned, test = positioning.corotational_sag(), positioning.thesis_task()
    sags |= others | {"co-rotational": turned}
    methods |= exact | {COROTATIONAL: _loop(turned, COROTATIONAL_CORRECTIONS)}
    del methods[NOTHING]
    asked: dict[str, Mapping[str, Callable[[Task], object]]] = {
        "sag": {name: partial(_ask, sag) for name, sag in sags.items()},
        "point": methods,
    }
    small, slow, fast = sizes[0], fresh_task(sizes[1]), fresh_task(sizes[2])
    ones = [_every(test, len(test), start) for start in range(2, len(test), len(test) // small)]
    ways = {("training data", "at once"): [Way("training data", crane.training_set, 1)]}
    for of, askings in asked.items():
        many = {name: slow if name in SLOW else fast for name in askings if name != GENETIC}
        ways[of, "one by one"] = [
            Way(name, partial(_each, ask, ones), len(ones)) for name, ask in askings.items()
        ]
        ways[of, "at once"] = [
            Way(name, partial(askings[name], task), len(task)) for name, task in many.items()
        ]
    for (of, points), group in ways.items():
        for timing in measure(group, *measuring, time.process_time):
            quartiles = {name: getattr(timing, name) for name in ("lower", "median", "upper")}
            yield {"of": of, "points": points, "way": timing.name, **quartiles}


def fresh_task(count: int, seed: int = 0) -> Task:
    """Draw points all over the working area, with loads within those of the training data.

    Kept are those that the loaded crane, by linear statics, reaches with 2 cm to spare, ahead of its pillar.
    """
    model = crane.patu655()
    unit = torch.rand(6 * count, 3, generator=seeded(seed), dtype=torch.float64)
    low, high = unit.new_tensor([0.0, -4.5, PAYLOADS[0]]), unit.new_tensor([7.0, 8.0, PAYLOADS[-1]])
    drawn = low + (high - low) * unit
    reach = crane.inverse(drawn[:, :2])
    drawn, starts = drawn[reach.within_limits], reach.strokes[reach.within_limits]
    starts = ((100 * starts).round() / 100).clamp(min=0).minimum(starts.new_tensor(model.upper))
    targets, payload = drawn[:, :2], drawn[:, 2]
    strokes, well = starts, torch.ones(len(starts), dtype=torch.bool)
    around = torch.tensor([[0, 0], [1, 0], [-1, 0], [0, 1], [0, -1]], dtype=torch.float64) * 0.02
    for _ in range(6):
        aims = (targets - crane.deflection(strokes, payload))[:, None] + around
        found = crane.inverse(aims, torch.maximum(starts[:, None, 2], crane.least_extension(aims)))
        well = found.within_limits.all(-1)
        strokes = torch.where(well[:, None], found.strokes[:, 0], starts)
    kept = well.nonzero()[:count, 0]
    return Task(targets[kept], payload[kept], starts[kept], model)


def grid_data(
    counts: Sequence[int], payloads: Sequence[float] = PAYLOADS, model: Crane | None = None
) -> TrainingSet:
    """Return training data on a grid of strokes whose tips are ahead of the pillar, all payloads at each pose."""
    model = model or crane.patu655()
    ends = zip(model.lower, model.upper, counts, strict=True)
    strokes = torch.cartesian_prod(*(torch.linspace(*own, dtype=torch.float64) for own in ends))
    strokes = strokes[crane.tip_position(strokes, model)[:, 0] >= 0]
    sag, mass = crane.deflection(strokes[:, None], payloads, model), strokes.new_tensor(payloads)[:, None]
    tip = crane.tip_position(strokes, model)[:, None] + sag
    rows = [strokes[:, None].expand(-1, len(mass), -1), mass.expand(len(strokes), -1, -1), tip, sag]
    return TrainingSet(torch.cat(rows, dim=-1).flatten(0, 1))


def fifths(data: TrainingSet) -> Iterator[tuple[TrainingSet, TrainingSet]]:
    """Split poses, with all their payloads, into what is learned from and what is held out, five times."""
    poses, pose = data.strokes.unique(dim=0, return_inverse=True)
    fifth = (torch.randperm(len(poses), generator=seeded(0)) % 5)[pose]
    for number in range(5):
        yield TrainingSet(data.rows[fifth != number]), TrainingSet(data.rows[fifth == number])


def farthest(points: Tensor, count: int) -> Tensor:
    """Pick points (N, 2), each as far as possible from those before; the first is the first."""
    chosen, away = [0], (points - points[0]).norm(dim=-1)
    while len(chosen) < count:
        chosen.append(int(away.argmax()))
        away = away.minimum((points - points[chosen[-1]]).norm(dim=-1))
    return torch.tensor(chosen)


def _exact(degrees: Sequence[int] = DEGREES, folds: int = 5) -> tuple[dict[str, SagModel], dict[str, Method]]:
    """Sags and methods without chance."""
    fit, linear = positioning.TrigonometricSag.fit, positioning.linear_sag()
    regression = fit(crane.training_set(), least_held_out(degrees, folds, fit))
    table = positioning.TableSag.of(GRID)
    sags: dict[str, SagModel] = {REGRESSION: regression, "training grid as a table": table, STRUCTURE: linear}
    return sags, {
        NOTHING: positioning.uncompensated,
        **{f"{name}, in a loop": _loop(sag) for name, sag in sags.items()},
        f"{REGRESSION}, Gauss–Newton": _newton(regression),
        f"{STRUCTURE}, once": _loop(linear, 1),
        f"{STRUCTURE}, Gauss–Newton": _newton(linear),
    }


def _learned(
    seed: int,
    neurons: Sequence[int],
    angle_neurons: Sequence[int] = ANGLE_NEURONS,
    folds: int = 5,
    epochs: int = 200,
    generations: int = 1000,
    descent: int = 10_000,
) -> tuple[dict[str, SagModel], dict[str, Method]]:
    """Sags and methods that rest on networks."""
    data, fit = crane.training_set(), positioning.AngleNetworkSag.fit
    train = partial(positioning.correction_network, data, epochs=epochs)
    sags: dict[str, SagModel] = {THESIS: positioning.network_sag(train(seeded(seed)))}
    sags |= {f"network of {n} neurons": positioning.network_sag(train(seeded(seed), n)) for n in neurons}
    size = least_held_out(angle_neurons, folds, lambda rest, size: fit(rest, size, seeded(0), epochs))
    sags["network in angles"] = fit(data, size, seeded(seed), epochs)
    direct = positioning.direct_network(data, seeded(seed), epochs=epochs)
    search = positioning.genetic(seeded(seed), positioning.GeneticInverseOptions(generations=generations))
    options = positioning.DescentOptions(iterations=descent)
    return sags, {
        GENETIC: lambda task: positioning.compensate(task, sags[THESIS], search),
        DESCENT: lambda task: positioning.descend(task, direct, options),
        f"{THESIS}, once": _loop(sags[THESIS], 1),
        **{f"{name}, in a loop": _loop(sag) for name, sag in sags.items()},
        "direct network, Gauss–Newton": partial(
            positioning.gauss_newton, tip=positioning.network_tip(direct)
        ),
    }


def least_held_out(sizes: Sequence[int], folds: int, fit: Callable[[TrainingSet, int], SagModel]) -> int:
    """Return the size whose fits leave the least error, by root mean squares over poses that are held out."""
    errors = {}
    for size in sizes:
        parts = itertools.islice(fifths(crane.training_set()), folds)
        misses = [fit(rest, size)(held.strokes, held.payload) - held.deflection for rest, held in parts]
        errors[size] = math.sqrt(np.mean([miss.square().sum(-1).mean().item() for miss in misses]))
    return min(errors, key=lambda size: errors[size])


def _loop(sag: SagModel, corrections: int = CORRECTIONS) -> Method:
    return lambda task: positioning.compensate(task, sag, corrections=corrections)


def _newton(sag: SagModel) -> Method:
    return lambda task: positioning.gauss_newton(task, positioning.sagging_tip(task, sag))


def _judged(method: Method, fresh: Task | None, every: int) -> dict[str, Tensor]:
    """Errors on the test, on the co-rotational structure in a part of it, and at fresh points."""
    test = positioning.thesis_task()
    answer = method(test)
    part = Placement(answer.strokes[::every], answer.converged[::every], answer.iterations[::every])
    turned = positioning.errors(_every(test, every), part, positioning.corotational_sag()).distance
    metrics = {**_two(positioning.errors(test, answer).distance, "test_"), **_two(turned, "corotational_")}
    if fresh is not None:
        distance = positioning.errors(fresh, method(fresh)).distance
        metrics |= {**_two(distance, "fresh_"), "fresh_99": distance.quantile(0.99)}
    return metrics


def _two(distance: Tensor, of: str = "") -> dict[str, Tensor]:
    return {f"{of}mean": distance.mean(), f"{of}largest": distance.max()}


def _ask(sag: SagModel, task: Task) -> Tensor:
    return sag(task.starts, task.payload)


def _each(ask: Callable[[Task], object], tasks: Sequence[Task]) -> list[object]:
    return [ask(task) for task in tasks]


def _every(task: Task, step: int, start: int = 0) -> Task:
    return Task(task.targets[start::step], task.payload[start::step], task.starts[start::step], task.crane)
