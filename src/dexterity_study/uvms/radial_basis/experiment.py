"""Radial-basis networks for w and KCI: growth at many spreads, the printed loop, pruning, and what they need.

Sources: Sotiropoulos & Aspragathos (2016), sections 3.2, 3.4, 4.3, 4.4. All errors are relative, Eq. 21.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import torch
from torch import Tensor

from dexterity import robots, sampling
from dexterity.indices import Index
from dexterity.networks.feed_forward import FeedForward
from dexterity.networks.growth import Growth, RadialBasisOptions, fit, grow
from dexterity.networks.levenberg_marquardt import Options, levenberg_marquardt
from dexterity.networks.network import View
from dexterity.networks.problem import DesignProblem, largest_relative_error
from dexterity.networks.pruning import prune
from dexterity.networks.radial_basis import BIAS, RadialBasis
from dexterity.networks.radial_basis_design import RadialBasisDesign, design_radial_basis
from dexterity.sampling import Box, DataSet, DataSets, Space
from dexterity_study.engine.experiment import experiment

INDICES: Mapping[str, Index] = {"w": Index("manipulability"), "KCI": Index("kinematic_conditioning")}
"""The two indices of the paper, with unit limits, in the spatial frame."""

LEVELS = (0.05, 0.02, 0.01, 0.005)
"""Testing errors for which the neurons that they take are counted; the second is the paper's E."""

PASS, NEAR = 0.02, 0.05
ROWS = {"w": 5000, "KCI": 10_000}
SPREADS = {
    "w": (0.1, 0.2, 0.3, 0.5, 0.7, 1.0, 1.5, 2.0, 4.0, 8.9),
    "KCI": (0.5, 0.7, 0.8, 0.9, 1.0, 1.5, 3.0, 5.0, 8.9),
}
"""Spreads at which networks grow to the neuron limit, [rad] and [m] alike."""

SMALL = {"rows": {"w": 300, "KCI": 300}, "test": 100, "fresh": 500}
"""Sizes of the data sets at smoke effort."""

OF_DATA = {"data": ("robots/uvms.toml",)}
PAPER = {"paper": "sotiropoulos2016"}
LIMIT = {"assumes": ("radial-basis-neuron-limit",), **PAPER}


def problem(
    index: str, seed: int, rows: Mapping[str, int] = ROWS, test: int = 1000, fresh: int = 20_000
) -> DesignProblem:
    """Draw the data sets of an index as paper A does; the validation set holds fresh points."""
    sets = sampling.data_sets(
        _exact(index), _space(index), train=rows[index], test=test, validation=fresh, seed=seed
    )
    return DesignProblem(View(robots.uvms().joints, _inputs(index)), sets)


@experiment(seeds=10, keys=("index",), smoke=SMALL, **OF_DATA)
def constants(seed: int, **sizes: Any) -> Iterator[dict[str, Any]]:
    """Testing error of the constant whose largest relative error in training is smallest."""
    for index in INDICES:
        data = problem(index, seed, **sizes).data
        lowest, highest = data.train.values.aminmax()
        constant = 2 * lowest * highest / (lowest + highest)
        yield {"index": index, "testing_error": _error(constant, data.test)}


@experiment(seeds=1, smoke=SMALL, **OF_DATA)
def hidden_neurons(seed: int, **sizes: Any) -> Iterator[dict[str, Any]]:
    """Deviation of hidden neurons from Eqs. 17 and 18 with a norm, and their answer at the spread."""
    own = problem("w", seed, **sizes)
    network = grow(own, 0.3, RadialBasisOptions(neuron_limit=30)).network
    x = own.view(own.data.test.q)
    with torch.no_grad():
        differences = x.numpy()[:, None] - network.centres.numpy()
        gamma = BIAS / network.spread.item() * np.linalg.norm(differences, axis=-1)
        deviation = np.abs(network.hidden(x).numpy() - np.exp(-(gamma**2))).max()
        aside = torch.zeros_like(network.centres[0])
        aside[0] = network.spread
        yield {"deviation": deviation, "at_spread": network.hidden(network.centres[0] + aside)[0]}


@experiment(
    seeds=10,
    keys=("index", "spread"),
    arrays=("w_sizes", "w_mse", "w_error", "KCI_sizes", "KCI_mse", "KCI_error"),
    smoke={**SMALL, "spreads": {"w": (0.3, 1.0), "KCI": (0.5, 2.0)}, "neuron_limit": 40},
    rtol=1e-4,
    atol=1e-8,
    **OF_DATA,
)
def growth(
    seed: int, spreads: Mapping[str, Sequence[float]] = SPREADS, neuron_limit: int = 300, **sizes: Any
) -> tuple[list[dict[str, Any]], dict[str, Any]]:
    """Networks grown to the neuron limit at many spreads, Figs. 8, 9, 12 and 13."""
    rows, arrays = [], {}
    at = np.unique(np.geomspace(1, neuron_limit, 32).round().astype(np.int64))
    for index, of_index in spreads.items():
        own = problem(index, seed, **sizes)
        grown = [grow(own, spread, _to(neuron_limit)) for spread in of_index]
        rows += [{"index": index, "spread": one.spread, **_facts(own, one)} for one in grown]
        arrays[f"{index}_sizes"] = at
        arrays[f"{index}_mse"] = _histories(grown, "mean_square_errors", at)
        arrays[f"{index}_error"] = _histories(grown, "testing_errors", at)
    return rows, arrays


@experiment(
    seeds=10,
    readings=(
        "spread-steps=0.05",
        "spread-steps=0.25",
        "spread-steps=0.5",
        "spread-steps=1",
        "radial-basis-neuron-limit=100",
        "radial-basis-neuron-limit=200",
        "radial-basis-input-scaling=degrees",
    ),
    reading_seeds=3,
    assumes=("spread-steps", "radial-basis-neuron-limit", "radial-basis-input-scaling"),
    smoke=SMALL,
    rtol=1e-4,
    **PAPER,
    **OF_DATA,
)
def loop(seed: int, reading: Mapping[str, Any], **sizes: Any) -> Iterator[dict[str, Any]]:
    """The printed design loop for w, and a network of the same size with centres at random training inputs."""
    own = problem("w", seed, **sizes)
    design = printed_loop(own, reading)
    network = design.network
    yield {
        "success": design.success,
        "spread": design.best.spread,
        "neurons": network.neurons,
        "testing_error": largest_relative_error(network, own.data.test),
        "fresh": largest_relative_error(network, own.data.validation),
        "random_centres": _random_centres(own, network, seed),
    }


def printed_loop(own: DesignProblem, reading: Mapping[str, Any]) -> RadialBasisDesign:
    """Run the loop of Fig. 6b with the settings of Table 3 and the values of a reading."""
    in_degrees = reading["radial-basis-input-scaling"] == "degrees"
    # In degrees only the largest spread of the table is not far below the distances of the inputs.
    widest = RadialBasisOptions().spread_limit
    first, step = (widest, widest) if in_degrees else reading["spread-steps"]
    options = RadialBasisOptions(
        neuron_limit=reading["radial-basis-neuron-limit"],
        first_spread=first,
        spread_step=step,
        input_scale=math.degrees(1) if in_degrees else 1.0,
    )
    return design_radial_basis(own, options, progress=False)


@experiment(seeds=3, smoke={**SMALL, "spreads": (1.0,), "neuron_limit": 40}, rtol=1e-4, **OF_DATA)
def printed_form(
    seed: int, spreads: Sequence[float] = (0.5, 1.0, 3.0), neuron_limit: int = 50, **sizes: Any
) -> Iterator[dict[str, Any]]:
    """Smallest testing error for w by Eq. 18 without a norm: all that a neuron sees is the sum of the joints."""
    own = problem("w", seed, **sizes)

    def summed(part: DataSet) -> DataSet:
        return DataSet(own.view(part.q).sum(-1, keepdim=True), part.values)

    data = DataSets(summed(own.data.train), summed(own.data.test), summed(own.data.validation))
    grown = [grow(DesignProblem(View(1, [0]), data), spread, _to(neuron_limit)) for spread in spreads]
    yield {"testing_error": min(min(one.testing_errors) for one in grown)}


@experiment(keys=("neurons",), smoke={**SMALL, "neuron_limit": 45}, rtol=1e-4, **OF_DATA)
def lifted_limit(
    seed: int, spread: float = 8.9, neuron_limit: int = 1200, **sizes: Any
) -> Iterator[dict[str, Any]]:
    """Testing error for KCI at the printed spread, with the neuron limit lifted."""
    grown = grow(problem("KCI", seed, **sizes), spread, _to(neuron_limit))
    for size in np.unique(np.geomspace(1, grown.neurons, 60).round().astype(np.int64)).tolist():
        yield {"neurons": size, "testing_error": grown.testing_errors[size - 1]}


@experiment(
    seeds=10,
    assumes=("spread-steps", "radial-basis-neuron-limit", "radial-basis-input-scaling"),
    smoke=SMALL,
    rtol=1e-4,
    **PAPER,
    **OF_DATA,
)
def pruned_loop(seed: int, reading: Mapping[str, Any], **sizes: Any) -> Iterator[dict[str, Any]]:
    """The network that the printed loop returns for w, pruned as far as it passes."""
    own = problem("w", seed, **sizes)
    yield _pruned(own, printed_loop(own, reading).network, PASS)[0]


@experiment(
    keys=("index", "spread"),
    arrays=("w_sizes", "w_error", "KCI_sizes", "KCI_error"),
    smoke={**SMALL, "spreads": {"w": (0.3,), "KCI": (0.5,)}, "neuron_limit": 40},
    rtol=1e-4,
    **OF_DATA,
)
def pruned_growth(
    seed: int,
    spreads: Mapping[str, Sequence[float]] = {"w": SPREADS["w"][::3], "KCI": SPREADS["KCI"][::3]},
    neuron_limit: int = 300,
    **sizes: Any,
) -> tuple[list[dict[str, Any]], dict[str, Any]]:
    """Networks grown to the neuron limit, then pruned: w as far as it passes, KCI to five per cent."""
    rows, arrays = [], {}
    for index, level in (("w", PASS), ("KCI", NEAR)):
        own = problem(index, seed, **sizes)
        made = [_pruned(own, grow(own, s, _to(neuron_limit)).network, level) for s in spreads[index]]
        rows += [
            {"index": index, "spread": s, **facts} for s, (facts, _) in zip(spreads[index], made, strict=True)
        ]
        at = np.unique(np.geomspace(1, min(len(errors) for _, errors in made), 40).round().astype(np.int64))
        arrays[f"{index}_sizes"] = at
        arrays[f"{index}_error"] = np.array([np.array(errors)[-at] for _, errors in made], dtype=np.float32)
    return rows, arrays


@experiment(
    seeds=3,
    keys=("index", "neurons"),
    smoke={**SMALL, "sizes_of": {"w": (1, 2), "KCI": (2,)}, "epochs": 5},
    rtol=1e-3,
    **OF_DATA,
)
def feed_forward(
    seed: int,
    sizes_of: Mapping[str, Sequence[int]] = {"w": range(1, 11), "KCI": (25,)},
    epochs: int = 100,
    **sizes: Any,
) -> Iterator[dict[str, Any]]:
    """Feed-forward networks on the same data."""
    for index, counts in sizes_of.items():
        own = problem(index, seed, **sizes)
        train = own.data.train
        for neurons in counts:
            random = torch.Generator().manual_seed(seed)
            network = FeedForward.untrained(own.view, neurons, train.q, train.values, random)
            trained = levenberg_marquardt(network, train.q, train.values, Options(epochs=epochs)).network
            yield {
                "index": index,
                "neurons": neurons,
                "testing_error": largest_relative_error(trained, own.data.test),
                "fresh": largest_relative_error(trained, own.data.validation),
            }


@experiment(
    seeds=3,
    keys=("half_range_deg", "joints"),
    smoke={"cases": ((7.5, 7), (15.0, 3)), "spreads": (1.0,), "rows": 300, "test": 100, "neuron_limit": 40},
    rtol=1e-4,
    **OF_DATA,
)
def input_spaces(
    seed: int,
    cases: Sequence[tuple[float, int]] = ((7.5, 7), (15.0, 7), (22.5, 7), (30.0, 7), (15.0, 3), (15.0, 5)),
    spreads: Sequence[float] = (0.5, 1.0, 3.0),
    rows: int = 5000,
    test: int = 1000,
    neuron_limit: int = 300,
) -> Iterator[dict[str, Any]]:
    """Fewest neurons for w to a testing error of 1 % at any spread, by range and number of joints; 0 if none."""
    options = replace(_to(neuron_limit), testing_error=0.01, error_threshold=math.inf)
    for half_range_deg, joints in cases:
        own = _widened(half_range_deg, joints, seed, rows, test)
        passing = [one.neurons for one in (grow(own, s, options) for s in spreads) if one.success]
        yield {"half_range_deg": half_range_deg, "joints": joints, "neurons": min(passing, default=0)}


# ---- data ------------------------------------------------------------------------------------------


def _exact(index: str) -> Callable[[Tensor], Tensor]:
    return INDICES[index].bind(robots.uvms())


@cache
def _space(index: str) -> Space:
    return sampling.uvms_space(INDICES[index].name)


@cache
def _inputs(index: str) -> tuple[int, ...]:
    return sampling.relevant_joints(robots.uvms(), INDICES[index])


def _widened(half_range_deg: float, joints: int, seed: int, rows: int, test: int) -> DesignProblem:
    """Draw data for w with the first of its joints within a range, and the others at zero."""
    view = View(robots.uvms().joints, _inputs("w")[:joints])
    upper = [math.radians(half_range_deg) if joint in view.inputs else 0.0 for joint in range(view.joints)]
    # Uniform draws: the paper's grid has few rows where there are few joints.
    box = Box([-x for x in upper], upper)
    sets = sampling.data_sets(
        _exact("w"), box, train=rows, test=test, validation=test, seed=seed, method="uniform"
    )
    return DesignProblem(view, sets)


def _error(answer: Tensor, data: DataSet) -> float:
    return ((answer - data.values) / data.values).abs().max().item()


# ---- networks --------------------------------------------------------------------------------------


def _to(neuron_limit: int) -> RadialBasisOptions:
    """Grow to a number of neurons, whatever the errors."""
    return RadialBasisOptions(testing_error=0.0, training_goal=0.0, neuron_limit=neuron_limit)


def _facts(own: DesignProblem, grown: Growth) -> dict[str, Any]:
    with torch.no_grad():
        active = (grown.network.hidden(own.view(own.data.test.q)) >= 0.5).double().mean()
    return {
        **{f"needed_{level:g}": _first(grown.testing_errors, level) for level in LEVELS},
        "smallest": min(grown.testing_errors),
        "fresh": largest_relative_error(grown.network, own.data.validation),
        "goal": _first(grown.mean_square_errors, RadialBasisOptions().training_goal),
        "neurons": grown.neurons,
        "skipped": grown.skipped,
        "condition": grown.condition,
        "weight": grown.largest_weights[-1],
        "active": active,
    }


def _histories(grown: Iterable[Growth], name: str, at: np.ndarray) -> np.ndarray:
    """Errors at some sizes; a network that stopped growing earlier keeps its last error."""
    histories = [np.array(getattr(one, name)) for one in grown]
    return np.array([history[np.minimum(at, len(history)) - 1] for history in histories], dtype=np.float32)


def _first(history: Iterable[float], level: float) -> int:
    """Fewest neurons below a level; 0 if none."""
    return next((k for k, error in enumerate(history, start=1) if error < level), 0)


def _random_centres(own: DesignProblem, network: RadialBasis, seed: int) -> float:
    x = own.view(own.data.train.q)
    rows = torch.randperm(len(x), generator=torch.Generator().manual_seed(seed))[: network.neurons]
    other = fit(own.view, own.data.train, x[rows], network.spread.item(), network.input_scale)
    return largest_relative_error(other, own.data.test)


def _pruned(own: DesignProblem, network: RadialBasis, limit: float) -> tuple[dict[str, Any], Sequence[float]]:
    """Facts before and after pruning, and testing errors from the whole network down to one neuron."""
    pruning = prune(own, network, limit)
    facts = {
        "passes": pruning.testing_errors[0] < limit,
        "before": network.neurons,
        "after": pruning.neurons,
        "fresh_before": largest_relative_error(network, own.data.validation),
        "fresh_after": largest_relative_error(pruning.network, own.data.validation),
    }
    return facts, pruning.testing_errors
