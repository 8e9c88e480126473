"""The networks that come with the package: how they are made, chosen and described.

``python -m dexterity.studies.shipment [NAME …]`` trains candidates, chooses among them by the worst case that
a search finds, judges the chosen one on points that nothing was chosen by, and writes it with its card to
``data/networks``. It takes minutes a network, and is no part of building the book.
"""

from __future__ import annotations

import argparse
import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from dexterity import operations, robots, sampling, store, symbolic, timing
from dexterity.indices import Index
from dexterity.networks import feed_forward, files, levenberg_marquardt, normal_equations
from dexterity.networks.export import compile_network
from dexterity.networks.feed_forward import FeedForward
from dexterity.networks.growth import RadialBasisOptions, grow
from dexterity.networks.network import Network, View
from dexterity.networks.problem import DesignProblem
from dexterity.networks.recipes import Recipe, prepare
from dexterity.networks.threads import one_thread
from dexterity.networks.trials import TrialStore, source_key
from dexterity.networks.validation import ErrorDistribution, Function, fresh, judge
from dexterity.networks.worst_case import Search, WorstCase, worst_case
from dexterity.operations import Operations
from dexterity.sampling import Space
from dexterity.timing import Machine, Way

__all__ = [
    "JUDGED",
    "PLANS",
    "FeedForwardPlan",
    "RadialBasisPlan",
    "describe",
    "layer_operations",
    "main",
    "ship",
]

JUDGED = 200_000
"""Configurations that a chosen network is judged on."""

_CHOSEN_BY, _JUDGED_BY = 20_160_001, 20_160_002  # seeds of the validation set and of the untouched one


@dataclass(frozen=True)
class FeedForwardPlan:
    """How a feed-forward network that is shipped is made.

    Attributes
    ----------
    index
        Name of the index.
    carriers
        Joints through which the world's origin is seen instead of through their own values.
    recipe
        How candidates are trained.
    restarts
        Number of candidates.
    """

    index: str
    carriers: int
    recipe: Recipe
    restarts: int


@dataclass(frozen=True)
class RadialBasisPlan:
    """How a radial-basis network that is shipped is made: grown to a size at several spreads.

    Attributes
    ----------
    index, carriers
        See `FeedForwardPlan`.
    neurons
        How many it has.
    rows, overhang
        Of the training set, see :func:`dexterity.sampling.sobol`.
    spreads
        Of the candidates, for inputs in [rad] and [m].
    """

    index: str
    carriers: int
    neurons: int
    rows: int
    overhang: float
    spreads: tuple[float, ...]


PLANS: Mapping[str, FeedForwardPlan | RadialBasisPlan] = {
    "uvms-manipulability-feed-forward": FeedForwardPlan(
        "manipulability", 0, Recipe(8, rows=8192, overhang=0.3, epochs=300), restarts=48
    ),
    "uvms-kinematic-conditioning-feed-forward": FeedForwardPlan(
        "kinematic_conditioning", 6, Recipe(50, "triple", rows=16_384, overhang=0.4, epochs=200), restarts=3
    ),
    "uvms-manipulability-radial-basis": RadialBasisPlan(
        "manipulability", 0, 149, 8192, 0.3, (0.5, 1.0, 1.5, 2.0, 3.0, 4.0)
    ),
    "uvms-kinematic-conditioning-radial-basis": RadialBasisPlan(
        "kinematic_conditioning", 6, 300, 8192, 0.4, (0.5, 0.7, 1.0, 1.5, 2.0, 3.0)
    ),
}
"""What is shipped, by name."""


def ship(name: str, folder: Path) -> Network:
    """Make a network with its card and write it to a folder.

    Raises
    ------
    ValueError
        If no network of this name is planned.
    RuntimeError
        If the package does not run from a source tree.
    """
    if name not in PLANS:
        raise ValueError(f"name is {name!r}; {list(PLANS)} are planned")
    plan = PLANS[name]
    index, space = _index(plan), sampling.uvms_space(plan.index)
    with one_thread():
        network = _chosen(_candidates(plan, index, space), index, space)
    return describe(name, network, folder)


def describe(name: str, network: Network, folder: Path) -> Network:
    """Judge a network that a plan has made, and write it with a new card to a folder."""
    plan = PLANS[name]
    index, space = _index(plan), sampling.uvms_space(plan.index)
    with one_thread():
        distribution = judge(network, fresh(index, space, JUDGED, _JUDGED_BY))
        worst = worst_case(network, index, space, Search(), _JUDGED_BY)
        network.card = _card(name, network, space, distribution, worst)
    files.save(network, folder / f"{name}.npz")
    return network


def _index(plan: FeedForwardPlan | RadialBasisPlan) -> symbolic.CompiledIndex:
    return symbolic.compile_index(robots.uvms(), Index(plan.index), "c")


def layer_operations(network: Network) -> Operations:
    """Count the operations of a network's layers by the paper's rules, its view and its readout left out."""
    width, h = network.view.width, network.neurons
    if not isinstance(network, FeedForward):
        return operations.radial_basis(width, h)
    further_outputs = len(network.output_biases) - 1
    return operations.feed_forward(width, h) + further_outputs * Operations(h, h)


def main(arguments: Sequence[str] | None = None) -> int:
    """Make the networks that are named, or all, or write their cards anew."""
    parser = argparse.ArgumentParser(prog="python -m dexterity.studies.shipment", description=__doc__)
    parser.add_argument("names", nargs="*", metavar="NAME")
    parser.add_argument("--cards", action="store_true", help="keep the networks; judge and time them anew")
    chosen = parser.parse_args(arguments)
    folder = store.data_path() / "networks"
    for name in chosen.names or list(PLANS):
        network = describe(name, files.load_shipped(name), folder) if chosen.cards else ship(name, folder)
        errors = (network.card["errors"]["maximum"], network.card["worst_case"]["error"])
        print(f"{name}: {errors[0]:.2%} sampled, {errors[1]:.2%} by ascent")  # noqa: T201
    return 0


# ---- candidates ------------------------------------------------------------------------------------


def _candidates(plan: FeedForwardPlan | RadialBasisPlan, index: Function, space: Space) -> list[Network]:
    chain = robots.uvms()
    varying = sampling.relevant_joints(chain, Index(plan.index))
    # What turns the vehicle stays in view; the translations are seen through the world's origin alone.
    inputs = [joint for joint in varying if not plan.carriers or joint > 3]
    view = View(chain.joints, inputs, chain.screws[: plan.carriers])
    if isinstance(plan, FeedForwardPlan):
        return [_candidate(plan, view, index, space, seed) for seed in range(plan.restarts)]
    q = sampling.sobol(space, plan.rows, 0, plan.overhang)
    # The loop looks at no test set here: it grows to its size.
    test = sampling.DataSet(q[:1], index(q[:1]))
    data = sampling.DataSets(sampling.DataSet(q, index(q)), test, test)
    options = RadialBasisOptions(testing_error=0.0, training_goal=0.0, neuron_limit=plan.neurons)
    return [grow(DesignProblem(view, data), spread, options).network for spread in plan.spreads]


def _candidate(plan: FeedForwardPlan, view: View, index: Function, space: Space, seed: int) -> Network:
    """Train a candidate, or find it where an earlier call that was interrupted left it."""
    root = store.repository()
    if root is None:
        raise RuntimeError("networks are made in the source tree, and this is an installed package")
    trials = TrialStore(root / ".results" / "trials")
    key = store.content_key(
        "shipment",
        plan.index,
        plan.carriers,
        plan.recipe,
        seed,
        source_key([feed_forward, levenberg_marquardt, normal_equations]),
    )
    network = trials.get(key)
    if network is None:
        (network,) = prepare(plan.recipe, view, index, space, (seed,))
        trials.put(key, network, {})
    return network


def _chosen(candidates: Sequence[Network], index: Function, space: Space) -> Network:
    """Take the candidate whose worst case is least, as far as a search with a seed of its own tells."""
    return min(candidates, key=lambda one: worst_case(one, index, space, Search(), _CHOSEN_BY).error)


# ---- the card --------------------------------------------------------------------------------------


def _card(
    name: str, network: Network, space: Space, distribution: ErrorDistribution, worst: WorstCase
) -> dict[str, Any]:
    plan = PLANS[name]
    index = Index(plan.index)
    return {
        "name": name,
        "chain": {"name": "uvms", "lengths": dict(robots.describe("uvms").lengths)},
        "index": dataclasses.asdict(index) | {"limits": "all joint and tool rates 1"},
        "kind": type(network).__name__,
        "inputs": _inputs(network),
        "neurons": network.neurons,
        "space": {"kind": type(space).__name__} | _plain(space),
        "training": _plain(plan) | {"candidate_seeds": "0, 1, …", "rows_seed": 0},
        "chosen": f"least worst case by ascent, search seed {_CHOSEN_BY}",
        "errors": dataclasses.asdict(distribution) | {"seed": _JUDGED_BY, "points": "fresh, Sobol"},
        "worst_case": {
            "error": worst.error, "q": list(worst.q), "value": worst.value, "exact": worst.exact,
            "evaluations": worst.evaluations, "seed": _JUDGED_BY, "found_by": "multi-start ascent, no bound",
        },
        "operations": _operations(network, index),
        "time": _times(network, index, space),
        "retrain": f"python -m dexterity.studies.shipment {name}",
        "licence": "MIT",
    }  # fmt: skip


def _plain(value: Any) -> dict[str, Any]:
    """Fields in what JSON can say."""

    def listed(field: Any) -> Any:
        if isinstance(field, Mapping):
            return {key: listed(item) for key, item in field.items()}
        return [listed(item) for item in field] if isinstance(field, list | tuple) else field

    return {key: listed(item) for key, item in dataclasses.asdict(value).items()}


def _inputs(network: Network) -> str:
    joints = ", ".join(f"θ{joint + 1}" for joint in network.inputs)
    carriers = len(network.view.carriers)
    return f"world's origin in the link that joints 1 to {carriers} carry; {joints}" if carriers else joints


def _operations(network: Network, index: Index) -> dict[str, int]:
    derivation = symbolic.derive(robots.uvms(), index)
    exact = derivation.squared_manipulability if index.name == "manipulability" else derivation.bidiagonal
    return {
        "layers": layer_operations(network).total,
        "exact, before a root or an iteration": operations.count_program(exact).total,
    }


def _times(network: Network, index: Index, space: Space) -> dict[str, Any]:
    q = sampling.sobol(space, 1000, 0)
    exact = symbolic.compile_index(robots.uvms(), index, "c")
    compiled = compile_network(network)
    ways = [Way("exact", lambda: exact(q), len(q)), Way("network", lambda: compiled(q), len(q))]
    exact_time, network_time = timing.measure(ways, rounds=20, seconds=0.1)
    return {
        "ns_per_configuration": {
            one.name: [round(1e9 * t, 1) for t in (one.lower, one.median, one.upper)]
            for one in (exact_time, network_time)
        },
        "exact_over_network": str(timing.ratio(exact_time, network_time)),
        "both": f"C, {len(q)} configurations at once, one core; quartiles",
        "processor": Machine.present().processor,
    }


if __name__ == "__main__":
    raise SystemExit(main())
