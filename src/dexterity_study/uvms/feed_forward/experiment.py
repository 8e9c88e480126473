"""Feed-forward networks for w and KCI: the printed loop, all sizes, the printed sizes, and what they need.

Sources: Sotiropoulos & Aspragathos (2016), Eqs. 13–16 and 19–21, Figs. 6a, 10, 11, 14 and 15, Table 3. All errors
are relative, Eq. 21. *As printed* means the damping rule of the paper's toolbox, and trainings that end at the
paper's goal; *trained on* means the gain-ratio rule and no goal.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cache, partial
from itertools import product
from typing import Any, TypeAlias, cast

import numpy as np
import torch
from torch import Tensor

from dexterity import robots, sampling, symbolic, timing
from dexterity.indices import Index
from dexterity.networks import train
from dexterity.networks.design import Design, FeedForwardOptions, design_feed_forward
from dexterity.networks.feed_forward import FeedForward
from dexterity.networks.levenberg_marquardt import Damping, Options, levenberg_marquardt
from dexterity.networks.network import View
from dexterity.networks.problem import DesignProblem
from dexterity.sampling import Box, DataSet, TaskSector
from dexterity_study.engine.experiment import experiment

INDICES: Mapping[str, Index] = {"w": Index("manipulability"), "KCI": Index("kinematic_conditioning")}
"""The two indices of the paper, with unit limits, in the spatial frame."""

LIMIT, EPOCHS = 0.02, 100
GOALS = {"w": 1e-3, "KCI": 5e-6}
"""Settings of Table 3: E, the largest number of epochs, and the mean square errors E_mse."""

LIMITS = {"w": 100, "KCI": 35}
"""Sizes at which the loops are given up; for KCI this is before the limit of Table 3."""

ROWS, FRESH = {"w": 5000, "KCI": 10_000}, {"w": 100_000, "KCI": 20_000}
SIZES = {"w": (1, 16), "KCI": (1, 30)}
LARGER = {"w": (8, 16, 24, 32), "KCI": (25,)}
"""Smallest and largest number of neurons tried; neurons of the printed networks, and of larger ones for w."""

TIMED = tuple(product((1000, 2000, 4000, 8000, 16_000), (4, 8, 16, 32)))
"""Rows and neurons of timed trainings."""

QUARTILES = ("lower", "median", "upper")

AS_PRINTED, TRAINED_ON = "as printed", "trained on"

SMALL = {"rows": 200, "test": 100, "epochs": 5}
SMALL_SIZES = {"w": (1, 8), "KCI": (1, 5, 2)}
"""Sizes at smoke effort."""

# A probe may miss by more than rounding, since a training carries rounding on and makes it larger.
OF_DATA = {"data": ("robots/uvms.toml",), "rtol": 1e-3, "atol": 1e-6}
READ = {"paper": "sotiropoulos2016", "seeds": 10, "reading_seeds": 3, **OF_DATA}

Point: TypeAlias = tuple[float, float, float]
Cases: TypeAlias = Sequence[tuple[int, int]]
Values: TypeAlias = Mapping[str, Any]
Rows: TypeAlias = Iterator[dict[str, Any]]

_FRESH_SEED = 1000


def problem(
    index: str, seed: int, *, rows: int = 5000, test: int = 1000, task_point: Point | None = None
) -> DesignProblem:
    """Draw the data sets of an index as paper A does; the validation set has as many points as the test set."""
    (exact, view), at = compiled(index), _space(index, task_point)
    return DesignProblem(
        view, sampling.data_sets(exact, at, train=rows, test=test, validation=test, seed=seed)
    )


def options(kind: str, index: str, seed: int, epochs: int = EPOCHS) -> FeedForwardOptions:
    """Return the settings of Table 3, for trainings as printed or trained on."""
    goal, damping = (GOALS[index], "factor") if kind == AS_PRINTED else (0.0, "gain_ratio")
    return FeedForwardOptions(LIMIT, goal, epoch_limit=epochs, damping=cast(Damping, damping), seed=seed)


@experiment(smoke={"rows": 200}, **OF_DATA)
def formulas(seed: int, rows: int = 300) -> Rows:
    """Relative deviations from Eqs. 13 to 16 and 20, written out, for a network that nearly fits its targets."""
    own = problem("w", seed, rows=rows)
    q = own.data.train.q
    (network,) = train.initial_networks(own.view, 5, q, own.data.train.values, [seed])
    targets = network(q).detach()
    with torch.no_grad():
        network.output_weights += 0.01
        network.hidden_biases -= 0.01
        answers = network(q)
    x = (network.view(q) - network.input_centre) / network.input_half_range

    def output(W_1: Tensor, b_1: Tensor, W_2: Tensor, b_2: Tensor) -> Tensor:
        gamma = x @ W_1.T + b_1
        return (gamma.exp() - (-gamma).exp()) / (gamma.exp() + (-gamma).exp()) @ W_2[0] + b_2

    def step(damping: float) -> Tensor:
        one = Options(epochs=1, damping="factor", initial_damping=damping, largest_damping=1e300)
        after = levenberg_marquardt(network, q, targets, one).network.parameters()
        return torch.cat([(new.detach() - old).ravel() for new, old in zip(after, weights, strict=True)])

    weights = [parameter.detach() for parameter in network.parameters()]
    J = torch.cat([part.flatten(1) for part in torch.func.jacrev(output, (0, 1, 2, 3))(*weights)], 1)
    e = output(*weights) - (targets - network.target_centre) / network.target_half_range
    pairs = {
        "values": (answers, output(*weights) * network.target_half_range + network.target_centre),
        "step": (step(1.0), -torch.linalg.solve(J.T @ J + torch.eye(J.shape[1], dtype=J.dtype), J.T @ e)),
        "small_damping": (step(1e-9), -torch.linalg.lstsq(J, e[:, None], driver="gelsd").solution[:, 0]),
        "large_damping": (1e12 * step(1e12), -J.T @ e),
    }
    yield {name: (ours - written).norm() / written.norm() for name, (ours, written) in pairs.items()}


@experiment(seeds=10, keys=("index", "kind", "neurons"), smoke={"of": SMALL_SIZES, **SMALL}, **OF_DATA)
def sizes(seed: int, of: Values = SIZES, epochs: int = EPOCHS, **sets: Any) -> Rows:
    """Networks of all sizes, Figs. 10 and 14; those for KCI as printed are in its loop."""
    for index, asked in of.items():
        own = problem(index, seed, **sets)
        for kind in (AS_PRINTED, TRAINED_ON) if index == "w" else (TRAINED_ON,):
            for trial in _trained(own, options(kind, index, seed, epochs), *asked).trials:
                key = {"index": index, "kind": kind, "neurons": trial.neurons}
                yield {**key, "testing_error": trial.testing_error}


@experiment(
    keys=("index", "neurons"),
    assumes=("damping-rule",),
    readings=("damping-rule=gain-ratio",),
    smoke={"limits": {"w": 100, "KCI": 3}, "fresh": 500, **SMALL},
    **READ,
)
def loop(
    seed: int, reading: Values, limits: Values = LIMITS, epochs: int = EPOCHS, fresh: int = 0, **sets: Any
) -> Rows:
    """Testing errors in the printed loop, and errors on fresh points of the network that it returns."""
    for index, limit in limits.items():
        printed = options(AS_PRINTED, index, seed, epochs)
        chosen = replace(printed, damping=reading["damping-rule"], neuron_limit=limit)
        design = design_feed_forward(problem(index, seed, **sets), chosen, progress=False)
        errors = _errors(index, design.network, fresh)
        judged = {"fresh": errors.max(), "above": (errors > LIMIT).double().mean()}
        for trial in design.trials:
            returned = judged if trial is design.best else {}
            yield {"index": index, "neurons": trial.neurons, "testing_error": trial.testing_error, **returned}


@experiment(
    keys=("index", "kind", "neurons"),
    assumes=("damping-rule", "initial-weights", "task-point"),
    readings=("damping-rule=gain-ratio", "initial-weights=best-of-ten", "task-point=world-origin"),
    arrays=("w_factor", "w_gain_ratio", "KCI_factor", "KCI_gain_ratio"),
    smoke={"of": {"w": (3, 9), "KCI": (4,)}, "fresh": 500, **SMALL},
    **READ,
)
def printed_sizes(
    seed: int, reading: Values, of: Values = LARGER, epochs: int = EPOCHS, fresh: int = 0, **sets: Any
) -> tuple[list[dict[str, Any]], dict[str, Any]]:
    """Networks of the printed sizes, as printed and trained on, and larger ones; errors by epochs without a goal."""
    facts, histories, point = [], {}, reading["task-point"]
    tries = 10 if reading["initial-weights"] == "best-of-ten" else 1
    for index, counts in of.items():
        own = problem(index, seed, **{"rows": ROWS[index], "task_point": point, **sets})
        printed, on = (options(kind, index, seed, epochs) for kind in (AS_PRINTED, TRAINED_ON))
        read = replace(printed, damping=reading["damping-rule"], restarts=tries)
        trained = [_trained(own, read, counts[0]), *(_trained(own, on, count) for count in counts)]
        for kind, design in zip((AS_PRINTED, *[TRAINED_ON] * len(counts)), trained, strict=True):
            facts.append({"kind": kind, **_facts(index, own, design, fresh, point)})
        toolbox = _trained(own, replace(on, damping="factor"), counts[0])
        for damping, design in (("factor", toolbox), ("gain_ratio", trained[1])):
            error = np.array(design.best.history, np.float32)
            histories[f"{index}_{damping}"] = np.pad(error, (0, epochs + 1 - len(error)), mode="edge")
    return facts, histories


@experiment(
    seeds=10, keys=("index",), smoke={"neurons": 3, "epochs": 2, "test": 100, "fresh": 500}, **OF_DATA
)
def whole_grid(seed: int, neurons: int = 8, epochs: int = EPOCHS, test: int = 1000, fresh: int = 0) -> Rows:
    """Networks for w trained on with every row of the grid, those of the test set too."""
    drawn, q = problem("w", _FRESH_SEED, rows=2, test=test), sampling.grid(_space("w"))
    own = replace(drawn, data=replace(drawn.data, train=DataSet(q, compiled("w")[0](q))))
    yield _facts("w", own, _trained(own, options(TRAINED_ON, "w", seed, epochs), neurons), fresh)


@experiment(keys=("restart",), smoke={"neurons": 3, "restarts": 3, **SMALL}, **OF_DATA)
def restarts(seed: int, neurons: int = 8, restarts: int = 32, epochs: int = EPOCHS, **sets: Any) -> Rows:
    """Networks for w trained on from different initial weights, with the same data."""
    several = replace(options(TRAINED_ON, "w", seed, epochs), restarts=restarts)
    for trial in _trained(problem("w", seed, **sets), several, neurons).trials:
        yield {"restart": trial.restart, "testing_error": trial.testing_error}


@experiment(
    keys=("rows", "neurons"),
    smoke={"cases": [(100, 2)], "rounds": 1},
    unsteady=QUARTILES,
    timed=True,
    **OF_DATA,
)
def training_times(seed: int, cases: Cases = TIMED, rounds: int = 10, epochs: int = 5) -> Rows:
    """Quartiles of the time of a training step for w [s], on one core."""
    ways = []
    for rows, neurons in cases:
        own = problem("w", _FRESH_SEED, rows=rows)
        data = (own.data.train.q, own.data.train.values)
        (network,) = train.initial_networks(own.view, neurons, *data, [seed])
        call = partial(levenberg_marquardt, network, *data, Options(epochs=epochs))
        ways.append(timing.Way(f"{neurons} neurons, {rows} rows", call, epochs))
    for (rows, neurons), took in zip(cases, timing.measure(ways, rounds, 0.02), strict=True):
        yield {"rows": rows, "neurons": neurons, **{name: getattr(took, name) for name in QUARTILES}}


@cache
def compiled(name: str) -> tuple[symbolic.CompiledIndex, View]:
    """Return an index in compiled C, and the joints that it depends on."""
    chain, index = robots.uvms(), INDICES[name]
    view = View(chain.joints, sampling.relevant_joints(chain, index))
    return symbolic.compile_index(chain, index, "c"), view


def _space(index: str, point: Point | None = None) -> Box | TaskSector:
    name = INDICES[index].name
    return sampling.uvms_space(name, task_point=point) if point else sampling.uvms_space(name)


def _errors(index: str, network: FeedForward, fresh: int, point: Point | None = None) -> Tensor:
    """Relative errors on fresh points between those of the grid, the same points for all networks."""
    random = torch.Generator().manual_seed(_FRESH_SEED)
    q = sampling.uniform(_space(index, point), fresh or FRESH[index], random)
    exact = compiled(index)[0](q)
    with torch.no_grad():
        return ((network(q) - exact) / exact).abs()


def _trained(
    own: DesignProblem, of: FeedForwardOptions, first: int, last: int | None = None, step: int = 1
) -> Design:
    """Train networks of one size or more, whether one passes or not."""
    every = replace(of, first_neurons=first, neuron_limit=last or first, neuron_step=step, sweep="all")
    return design_feed_forward(own, every, progress=False)


def _facts(
    index: str, own: DesignProblem, design: Design, fresh: int, point: Point | None = None
) -> dict[str, Any]:
    best, errors = design.best, _errors(index, design.network, fresh, point)
    found = {"testing_error": best.testing_error, "between": best.validation_error, "fresh": errors.max()}
    size = {"index": index, "neurons": best.neurons, "rows": len(own.data.train.q)}
    return {**size, **found, "mean_square_error": best.mean_square_error}
