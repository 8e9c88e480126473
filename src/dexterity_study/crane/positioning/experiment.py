"""Four ways to bring the loaded tip of a flexible crane to a point, and what their networks learn.

Source: Rouvinen (1999), sections 2.4.6 and 4.1 to 4.5. Networks are trained anew with each seed, on the data
that linear statics makes, and judged on it. Lengths in rows and arrays are in millimetres.
"""

from __future__ import annotations

import copy
import itertools
import time
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from typing import Any, TypeAlias

import numpy as np
import torch
from torch import Tensor

from dexterity import crane
from dexterity.crane import TrainingSet, positioning
from dexterity.crane.positioning import DescentOptions, GeneticInverseOptions, Placement, Task
from dexterity.networks.feed_forward import FeedForward
from dexterity.networks.levenberg_marquardt import Options, levenberg_marquardt
from dexterity.networks.network import View
from dexterity_study.crane.cases import CRANE, PAPER, Made, Rows, Values, seeded
from dexterity_study.engine.experiment import experiment

METHODS = ("no compensation", "1 genetic", "1 exact", "2 direct", "3 modular", "4 inverse", "4 any extension")
"""Ways to position, in the order of arrays, with the thesis's numbers."""

NONE, GENETIC, EXACT, DIRECT, MODULAR, INVERSE, FREE = METHODS
MM = 1e3
LOOSE = {"rtol": 0.02, "atol": 1e-4}
TRAINED = {"seeds": 10, "assumes": ("crane-epochs",), **PAPER, **LOOSE}
SMALL = {"epochs": 60}

Trainer: TypeAlias = Callable[..., FeedForward]


@experiment(keys=("method",), smoke=SMALL, timed=True, unsteady=("seconds",), **TRAINED)
def training(seed: int, reading: Values, epochs: int = 0) -> Rows:
    """Root mean square that networks miss over their data [mm], and processor time of their training [s].

    For method 3 also what its first network misses of the rigid tip, and of the tip with method 1's network.
    """
    data, networks = training_data(), {}
    for method, (train, x, y) in lessons().items():
        started = time.process_time()
        own = networks[method] = train(data, seeded(seed), epochs=epochs or reading["crane-epochs"])
        row = {"method": method, "seconds": time.process_time() - started}
        with torch.no_grad():
            row["left"] = _rms(own(x) - y)
            if method == MODULAR:
                # The part's output is off by a constant, which the other part's bias makes up for.
                off = half(own, first=True)(x) - (data.tip - data.deflection)
                row["rigid"] = _rms(off - off.mean(0))
                row["apart"] = _rms(off - off.mean(0) - data.deflection + networks[GENETIC](x))
        yield row


@experiment(keys=("method",), arrays=("distance", "near"), smoke={**SMALL, "generations": 60}, **TRAINED)
def methods(seed: int, reading: Values, epochs: int = 0, generations: int = 1000) -> Made:
    """Errors of all methods at the test points; distances by point, and where the search came near enough."""
    task, epochs = positioning.thesis_task(), epochs or reading["crane-epochs"]
    placements = {NONE: positioning.uncompensated(task), **answers(task, seed, epochs)}
    random, options, spent = seeded(seed), GeneticInverseOptions(generations=generations), []

    def search(own: Task, positions: Tensor) -> Placement:
        spent.append(positioning.genetic_inverse(own, positions, random, options))
        return spent[-1]

    sag = positioning.network_sag(trained(GENETIC, seed, epochs))
    placements[GENETIC] = positioning.compensate(task, sag, search)
    rows = [{"method": method, **facts(task, placements[method], method)} for method in METHODS]
    first, second = (each.iterations.double().mean() for each in spent)
    rows[1] |= {"first_search": first, "second_search": second}
    distances = [positioning.errors(task, placements[method]).distance for method in METHODS]
    return rows, {"distance": MM * torch.stack(distances).float(), "near": placements[GENETIC].converged}


@experiment(keys=("method", "tolerance"), smoke=SMALL, **TRAINED)
def descents(seed: int, reading: Values, epochs: int = 0) -> Rows:
    """Distances and steps of a descent by the error of Eq. 59, in scaled outputs, at which it ends."""
    task, epochs = positioning.thesis_task(), epochs or reading["crane-epochs"]
    for method, tolerance in itertools.product((DIRECT, MODULAR), (1e-5, 1e-7, 1e-8)):
        placement = positioning.descend(task, trained(method, seed, epochs), DescentOptions(tolerance))
        own = facts(task, placement, method)
        shown = {name: own[name] for name in ("mean", "max", "steps", "most_steps")}
        yield {"method": method, "tolerance": tolerance, **shown}


@experiment(keys=("given",), seeds=10, smoke={"generations": 60}, **CRANE, **LOOSE)
def branch(seed: int, generations: int = 1000) -> Rows:
    """Median change of a stroke by a search, by the number of individuals that have the present strokes."""
    task = positioning.thesis_task()
    for given in (2, 0):
        options = GeneticInverseOptions(given=given, generations=generations)
        placement = positioning.genetic_inverse(task, task.targets, seeded(seed), options)
        yield {"given": given, "moved": _moved(task, placement)}


@experiment(smoke={"epochs": 5}, **CRANE, **LOOSE)
def formulas(seed: int, epochs: int = 20) -> Rows:
    """Relative deviations of Eqs. 59 to 63 from automatic differentiation, and of Eq. 64 from one network."""
    task, x = positioning.thesis_task(), training_data().rows[:, :4]
    direct, both = trained(DIRECT, seed, epochs), trained(MODULAR, seed, epochs)
    tip, slope = positioning.network_tip(direct)(task.starts, task.payload)
    by_hand = ((tip - task.targets)[:, None] @ slope)[:, 0]
    strokes = task.starts.clone().requires_grad_()
    miss = direct(torch.cat([strokes, task.payload[:, None]], dim=-1)) - task.targets
    (automatic,) = torch.autograd.grad(miss.square().sum() / 2, strokes)
    with torch.no_grad():
        apart = half(both, first=True)(x) + half(both, first=False)(x) - both(x)
        yield {
            "gradient": (by_hand - automatic).abs().max() / automatic.abs().max(),
            "sum": apart.abs().max() / both(x).abs().max(),
        }


@experiment(paper="rouvinen1999", assumes=("crane-what-counts",), readings=("crane-what-counts=five",))
def operations(reading: Values, inverse: int = 19, direct: int = 18) -> Rows:
    """Additions and multiplications of an answer of method 4, and of a step of method 2, by hidden neurons."""
    neuron = 2 * 4 + reading["crane-what-counts"] + 2 * 2
    scaling = 2 * 4 + 2 * 2
    # Back through both layers from the error of two outputs, and the change of three strokes.
    backward = 2 + direct * (2 * 2 - 1 + 2 + 1) + 3 * (2 * direct - 1) + 2 * 3
    yield {"answer": scaling + inverse * neuron, "step": direct * neuron + backward}


training_data = cache(crane.training_set)


@cache
def lessons() -> dict[str, tuple[Trainer, Tensor, Tensor]]:
    """Return for each method what trains its network, and the inputs and outputs that are learned."""
    data = training_data()
    seen, place = data.rows[:, :4], torch.cat([data.tip, data.payload[:, None]], dim=-1)
    given = torch.cat([place, data.strokes[:, 2:]], dim=-1)
    return {
        GENETIC: (positioning.correction_network, seen, data.deflection),
        DIRECT: (positioning.direct_network, seen, data.tip),
        MODULAR: (positioning.modular_network, seen, data.tip),
        INVERSE: (positioning.inverse_network, given, data.strokes[:, :2]),
        FREE: (_unrestricted_network, place, data.strokes),
    }


def _unrestricted_network(_: TrainingSet, generator: torch.Generator, epochs: int) -> FeedForward:
    """Train all three strokes as a function of x, y and payload, with the neurons of method 4 (Fig. 4.15)."""
    x, y = lessons()[FREE][1:]
    start = FeedForward.untrained(View(3, (0, 1, 2)), 19, x, y, generator)
    return levenberg_marquardt(start, x, y, Options(epochs=epochs)).network


@cache
def trained(method: str, seed: int, epochs: int) -> FeedForward:
    """Train the network of a method."""
    return lessons()[method][0](training_data(), seeded(seed), epochs=epochs)


def half(both: FeedForward, first: bool) -> FeedForward:
    """Keep one of the two networks of method 3, whose outputs add up to its own (Eq. 64)."""
    own, middle = copy.deepcopy(both).requires_grad_(False), both.neurons // 2
    own.output_weights[:, slice(middle, None) if first else slice(middle)] = 0.0
    own.output_biases *= first
    own.target_centre *= first
    return own


def answers(task: Task, seed: int, epochs: int) -> dict[str, Placement]:
    """Let all methods answer but the one that searches."""
    own = {method: trained(method, seed, epochs) for method in lessons()}
    with torch.no_grad():
        strokes = own[FREE](torch.cat([task.targets, task.payload[:, None]], dim=-1))
    one = torch.ones(len(task), dtype=torch.long)
    options = DescentOptions(tolerance=1e-7)
    return {
        EXACT: positioning.compensate(task, positioning.network_sag(own[GENETIC])),
        DIRECT: positioning.descend(task, own[DIRECT], options),
        MODULAR: positioning.descend(task, own[MODULAR], options),
        INVERSE: positioning.by_inverse_network(task, own[INVERSE]),
        FREE: Placement(strokes, one.bool(), one),
    }


def facts(task: Task, placement: Placement, method: str) -> dict[str, Any]:
    """Errors of a method, and what it asks of the crane: strokes beyond an end, steps, changes of strokes."""
    own = positioning.errors(task, placement)
    names = [f"{of}{axis}" for of in ("mean", "max") for axis in ("_x", "_y", "")]
    found = dict(zip(names, (MM * torch.cat([own.mean, own.largest])).tolist(), strict=True))
    if method == NONE:
        return found
    place = crane.posture(placement.strokes, task.crane)
    closes = place.lift_closes & place.jib_closes
    # Where a linkage cannot close beyond an end, nothing goes on.
    going_on = replace(placement, strokes=torch.where(closes[:, None], placement.strokes, task.starts))
    unstopped = positioning.errors(task, going_on, end_stops=False).distance[closes]
    return found | {
        "stopped": own.stopped.double().mean(),
        "unstopped_mean": MM * unstopped.mean(),
        "steps": placement.iterations.double().mean(),
        "most_steps": placement.iterations.max(),
        "moved": _moved(task, placement),
    }


def _moved(task: Task, placement: Placement) -> float:
    """Median over the points of the largest change of a stroke."""
    return float(MM * np.median((placement.strokes - task.starts).abs().amax(-1).numpy()))


def _rms(miss: Tensor) -> float:
    return MM * miss.square().sum(-1).mean().sqrt().item()
