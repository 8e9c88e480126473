"""Radial-basis networks for w and KCI: growth at many spreads, the printed loop, and what they need.

Sources: Sotiropoulos & Aspragathos (2016), sections 3.2, 3.4, 4.3, 4.4. All errors are relative, Eq. 21.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import torch

from dexterity import robots, sampling
from dexterity.networks import train
from dexterity.networks.growth import Growth, RadialBasisOptions, fit, grow
from dexterity.networks.levenberg_marquardt import Options
from dexterity.networks.network import View
from dexterity.networks.problem import DesignProblem, largest_relative_error
from dexterity.networks.radial_basis import BIAS
from dexterity.networks.radial_basis_design import design_radial_basis
from dexterity.sampling import Box, DataSet, DataSets
from dexterity_study.engine.experiment import experiment
from dexterity_study.uvms.feed_forward.experiment import INDICES, LIMIT, Rows, Values, compiled

LEVELS = (0.05, LIMIT, 0.01, 0.005)
"""Testing errors for which the neurons that they take are counted."""

ROWS = {"w": 5000, "KCI": 10_000}
SPREADS = {
    "w": (0.1, 0.2, 0.3, 0.5, 0.7, 1.0, 1.5, 2.0, 4.0, 8.9),
    "KCI": (0.5, 0.7, 0.8, 0.9, 1.0, 1.5, 3.0, 5.0, 8.9),
}
"""Spreads at which networks grow to the neuron limit, [rad] and [m] alike."""

SMALL = {"rows": {"w": 300, "KCI": 300}, "test": 100, "fresh": 500}
OF_DATA = {"data": ("robots/uvms.toml",)}


def problem(
    index: str, seed: int, rows: Mapping[str, int] = ROWS, test: int = 1000, fresh: int = 20_000
) -> DesignProblem:
    """Draw the data sets of an index as paper A does; the validation set holds fresh points."""
    exact, space = INDICES[index].bind(robots.uvms()), sampling.uvms_space(INDICES[index].name)
    sets = sampling.data_sets(exact, space, train=rows[index], test=test, validation=fresh, seed=seed)
    return DesignProblem(compiled(index)[1], sets)


@experiment(seeds=10, keys=("index",), smoke=SMALL, **OF_DATA)
def constants(seed: int, **sizes: Any) -> Rows:
    """Testing error of the constant whose largest relative error in training is smallest."""
    for index in INDICES:
        data = problem(index, seed, **sizes).data
        lowest, highest = data.train.values.aminmax()
        constant = 2 * lowest * highest / (lowest + highest)
        yield {"index": index, "testing_error": (constant / data.test.values - 1).abs().max()}


@experiment(smoke=SMALL, **OF_DATA)
@torch.no_grad()
def hidden_neurons(seed: int, **sizes: Any) -> Rows:
    """Deviation of hidden neurons from Eqs. 17 and 18 with a norm, and their answer at the spread."""
    own = problem("w", seed, **sizes)
    network = grow(own, 0.3, RadialBasisOptions(neuron_limit=30)).network
    x, centres, spread = own.view(own.data.test.q), network.centres, network.spread
    gamma = BIAS / spread * (x[:, None] - centres).norm(dim=-1)
    deviation = (network.hidden(x) - (-gamma.square()).exp()).abs().max()
    aside = centres[0].clone()
    aside[0] += spread
    yield {"deviation": deviation, "at_spread": network.hidden(aside)[0]}


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
    rows, arrays, at = [], {}, _sizes(neuron_limit, 32)
    for index, of_index in spreads.items():
        own = problem(index, seed, **sizes)
        grown = [grow(own, spread, _to(neuron_limit)) for spread in of_index]
        rows += [{"index": index, "spread": one.spread, **_facts(own, one)} for one in grown]
        arrays[f"{index}_sizes"] = at
        arrays[f"{index}_mse"] = _at(at, [one.mean_square_errors for one in grown])
        arrays[f"{index}_error"] = _at(at, [one.testing_errors for one in grown])
    return rows, arrays


@experiment(
    seeds=10,
    paper="sotiropoulos2016",
    readings=(
        *(f"spread-steps={step}" for step in ("0.05", "0.25", "0.5", "1")),
        "radial-basis-neuron-limit=100",
        "radial-basis-neuron-limit=200",
        "radial-basis-input-scaling=degrees",
    ),
    reading_seeds=3,
    assumes=("spread-steps", "radial-basis-neuron-limit", "radial-basis-input-scaling"),
    smoke=SMALL,
    rtol=1e-4,
    **OF_DATA,
)
def loop(seed: int, reading: Values, **sizes: Any) -> Rows:
    """The printed design loop for w, Fig. 6b, and a network of its size with centres at random inputs."""
    own, printed = problem("w", seed, **sizes), RadialBasisOptions()
    scale, (first, step) = 1.0, reading["spread-steps"]
    if reading["radial-basis-input-scaling"] == "degrees":
        # In degrees only the largest spread of the table is not far below the distances of the inputs.
        scale, first, step = math.degrees(1), printed.spread_limit, printed.spread_limit
    limit = reading["radial-basis-neuron-limit"]
    options = replace(printed, neuron_limit=limit, first_spread=first, spread_step=step, input_scale=scale)
    design = design_radial_basis(own, options, progress=False)
    network, x = design.network, own.view(own.data.train.q)
    rows = torch.randperm(len(x), generator=torch.Generator().manual_seed(seed))[: network.neurons]
    random = fit(own.view, own.data.train, x[rows], network.spread.item(), network.input_scale)
    yield {
        "success": design.success,
        "spread": design.best.spread,
        "neurons": network.neurons,
        "testing_error": largest_relative_error(network, own.data.test),
        "fresh": largest_relative_error(network, own.data.validation),
        "random_centres": largest_relative_error(random, own.data.test),
    }


# Sums of joints are nearly alike, so the fit is ill-conditioned, and its rounding differs between processors.
@experiment(seeds=3, smoke={**SMALL, "spreads": (1.0,), "neuron_limit": 40}, rtol=0.1, **OF_DATA)
def printed_form(
    seed: int, spreads: Sequence[float] = (0.5, 1.0, 3.0), neuron_limit: int = 50, **sizes: Any
) -> Rows:
    """Smallest testing error for w by Eq. 18 without a norm: all that a neuron sees is the sum of the joints."""
    own = problem("w", seed, **sizes)
    parts = (own.data.train, own.data.test, own.data.validation)
    sums = DataSets(*(DataSet(own.view(part.q).sum(-1, keepdim=True), part.values) for part in parts))
    grown = [grow(DesignProblem(View(1, [0]), sums), spread, _to(neuron_limit)) for spread in spreads]
    yield {"testing_error": min(min(one.testing_errors) for one in grown)}


@experiment(keys=("neurons",), smoke={**SMALL, "neuron_limit": 45}, rtol=1e-4, **OF_DATA)
def lifted_limit(seed: int, spread: float = 8.9, neuron_limit: int = 1200, **sizes: Any) -> Rows:
    """Testing error for KCI at the printed spread, with the neuron limit lifted."""
    grown = grow(problem("KCI", seed, **sizes), spread, _to(neuron_limit))
    for size in _sizes(grown.neurons, 60).tolist():
        yield {"neurons": size, "testing_error": grown.testing_errors[size - 1]}


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
) -> Rows:
    """Feed-forward networks on the same data."""
    for index, counts in sizes_of.items():
        own = problem(index, seed, **sizes)
        learned = (own.data.train.q, own.data.train.values)
        for neurons in counts:
            (made,) = train.for_seeds(own.view, neurons, *learned, [seed], Options(epochs=epochs))
            parts = {"testing_error": own.data.test, "fresh": own.data.validation}
            errors = {name: largest_relative_error(made.network, part) for name, part in parts.items()}
            yield {"index": index, "neurons": neurons, **errors}


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
) -> Rows:
    """Fewest neurons for w to a testing error of 1 % at any spread, by range and number of joints; 0 if none."""
    options = replace(_to(neuron_limit), testing_error=0.01, error_threshold=math.inf)
    exact, counts = INDICES["w"].bind(robots.uvms()), {"train": rows, "test": test, "validation": test}
    for half_range_deg, joints in cases:
        view = View(robots.uvms().joints, compiled("w")[1].inputs[:joints])
        half = [math.radians(half_range_deg) if joint in view.inputs else 0.0 for joint in range(view.joints)]
        # Uniform draws: the paper's grid has few rows where there are few joints.
        space = Box([-x for x in half], half)
        own = DesignProblem(view, sampling.data_sets(exact, space, **counts, seed=seed, method="uniform"))
        passing = [one.neurons for one in (grow(own, s, options) for s in spreads) if one.success]
        yield {"half_range_deg": half_range_deg, "joints": joints, "neurons": min(passing, default=0)}


def _to(neuron_limit: int) -> RadialBasisOptions:
    """Grow to a number of neurons, whatever the errors."""
    return RadialBasisOptions(testing_error=0.0, training_goal=0.0, neuron_limit=neuron_limit)


def _sizes(largest: int, count: int) -> np.ndarray:
    return np.unique(np.geomspace(1, largest, count).round().astype(np.int64))


def _at(sizes: np.ndarray, histories: Sequence[Sequence[float]]) -> np.ndarray:
    """Return errors at some sizes; a network that stopped growing earlier keeps its last error."""
    return np.array([np.array(own)[np.minimum(sizes, len(own)) - 1] for own in histories], dtype=np.float32)


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


def _first(history: Sequence[float], level: float) -> int:
    """Return the fewest neurons below a level; 0 if none."""
    return next((k for k, error in enumerate(history, start=1) if error < level), 0)
