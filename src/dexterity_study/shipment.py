"""The networks that come with the package: how they are made, chosen and described.

``python -m dexterity_study.shipment [NAME …]`` trains candidates, chooses among them by the worst case that
a search finds, judges the chosen one on points that nothing was chosen by, and writes it with its card to
``data/networks``. It takes minutes per network, and is no part of building the book.
"""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from dexterity import robots, sampling, store, symbolic
from dexterity.indices import Index
from dexterity.networks import card, files, spaces
from dexterity.networks.growth import RadialBasisOptions, grow
from dexterity.networks.ladder import Effort
from dexterity.networks.learning import for_index, judge_again
from dexterity.networks.network import Network, View
from dexterity.networks.problem import DesignProblem
from dexterity.networks.recipes import Recipe, prepare
from dexterity.networks.threads import one_thread
from dexterity.networks.validation import Function
from dexterity.networks.worst_case import Search, worst_case
from dexterity.sampling import Box, Space

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


@dataclass(frozen=True)
class LearnedPlan:
    """How a network for a robot of the package is made: by :func:`dexterity.networks.for_index`.

    Attributes
    ----------
    robot
        Name of the robot.
    index
        The index.
    middle
        Configuration [rad] in the middle of the space.
    half_range
        How far the joints that the index depends on go to either side [rad].
    goal
        Largest error that is wanted, by points and by ascent.
    seed
        All draws follow from it.
    """

    robot: str
    index: Index
    middle: tuple[float, ...]
    half_range: float = 0.35
    goal: float = 0.005
    seed: int = 0


_READY: Mapping[str, tuple[float, ...]] = {
    "panda": (0.0, -0.7854, 0.0, -2.3562, 0.0, 1.5708, 0.7854),
    "ur5e": (0.0, -1.2, 1.5, -1.87, -1.5708, 0.0),
    "puma560": (0.0, 0.6, -0.9, 0.0, 0.8, 0.0),
    "docking_arm": (0.0, 0.6, -1.1, 0.0, 0.8, 0.0),
    "iiwa14": (0.0, 0.6, 0.0, -1.3, 0.0, 1.2, 0.0),
    "oberon7": (0.0, 0.9, -0.5, 0.0, -1.1, 0.0),
    "reach_bravo7": (0.0, 1.6, 1.2, -1.0, 1.2, 0.0),
    "reach_alpha5": (3.0, 0.8, 0.9, 3.0),
}
"""Postures [rad] in which the arms work, away from their singularities."""

_LEARNED: Sequence[tuple[Index, float, Sequence[str]]] = (
    (
        Index("kinematic_conditioning", "geometric"),
        0.005,
        ("panda", "ur5e", "puma560", "docking_arm", "iiwa14", "oberon7", "reach_bravo7"),
    ),
    (Index("isotropy", "geometric"), 0.005, ("panda", "ur5e")),
    # A cubic polynomial errs by 0.2 to 0.4 % here.
    (Index("isotropy", "geometric"), 0.001, ("iiwa14", "reach_bravo7")),
    (Index("smallest_singular_value", "geometric", rows="translational"), 0.001, ("ur5e",)),
    (
        Index("guaranteed_speed", "geometric", rows="translational"),
        0.02,
        ("panda", "ur5e", "reach_bravo7", "reach_alpha5"),
    ),
    (Index("smallest_singular_value", "geometric", rows="translational"), 0.005, ("reach_alpha5",)),
    (Index("dynamic_manipulability", "geometric"), 0.005, ("iiwa14",)),
)
"""Indices that take longer than a network, with the error that is wanted, and the arms."""


def _learned() -> Mapping[str, LearnedPlan]:
    return {
        f"{robot}-{index.name}".replace("_", "-"): LearnedPlan(robot, index, _READY[robot], goal=goal)
        for index, goal, arms in _LEARNED
        for robot in arms
    }


_OF_THE_PAPER: Mapping[str, FeedForwardPlan | RadialBasisPlan] = {
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

PLANS: Mapping[str, FeedForwardPlan | RadialBasisPlan | LearnedPlan] = {**_OF_THE_PAPER, **_learned()}
"""What is shipped, by name."""


def ship(name: str, folder: Path) -> Network:
    """Make a network with its card and write it to a folder.

    Raises
    ------
    ValueError
        If no network of this name is planned.
    """
    if name not in PLANS:
        raise ValueError(f"name is {name!r}; {list(PLANS)} are planned")
    plan = PLANS[name]
    if isinstance(plan, LearnedPlan):
        return _ship_learned(name, plan, folder)
    index, space = Index(plan.index), sampling.uvms_space(plan.index)
    exact = symbolic.compile_index(robots.uvms(), index, "c")
    with one_thread():
        network = _chosen(_candidates(plan, exact, space), exact, space)
    network.card = card.Card(_about(name, plan, index, space))
    return judge(name, network, folder)


def _ship_learned(name: str, plan: LearnedPlan, folder: Path) -> Network:
    chain = robots.load(plan.robot)
    relevant = sampling.relevant_joints(chain, plan.index)
    space = Box.around(chain, plan.middle, plan.half_range, relevant)
    learned = for_index(
        chain,
        plan.index,
        space,
        plan.goal,
        name=name,
        effort=Effort(seed=plan.seed),
        points=JUDGED,
        progress=True,
    )
    network = learned.network
    network.card = network.card.with_entries(**_ends(name))
    files.save(network, folder / f"{name}.npz")
    return network


def _ends(name: str) -> dict[str, str]:
    return {"retrain": f"python -m dexterity_study.shipment {name}", "licence": "MIT"}


def judge(name: str, network: Network, folder: Path) -> Network:
    """Judge a network anew by what its card says that it is, and write it with a new card to a folder."""
    seed = network.card.get("errors", {}).get("seed", _JUDGED_BY)
    network.card = judge_again(network, points=JUDGED, seed=seed)
    files.save(network, folder / f"{name}.npz")
    return network


def main(arguments: Sequence[str] | None = None) -> int:
    """Make the networks that are named, or all, or write their cards again."""
    parser = argparse.ArgumentParser(prog="python -m dexterity_study.shipment", description=__doc__)
    parser.add_argument("names", nargs="*", metavar="NAME")
    parser.add_argument("--cards", action="store_true", help="keep the networks; judge and time them again")
    chosen = parser.parse_args(arguments)
    folder = store.data_path() / "networks"
    for name in chosen.names or list(PLANS):
        network = judge(name, files.load_shipped(name), folder) if chosen.cards else ship(name, folder)
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
        return [prepare(plan.recipe, view, index, space, (seed,))[0] for seed in range(plan.restarts)]
    q = sampling.sobol(space, plan.rows, 0, plan.overhang)
    # The loop looks at no test set here: it grows to its size.
    test = sampling.DataSet(q[:1], index(q[:1]))
    data = sampling.DataSets(sampling.DataSet(q, index(q)), test, test)
    options = RadialBasisOptions(testing_error=0.0, training_goal=0.0, neuron_limit=plan.neurons)
    return [grow(DesignProblem(view, data), spread, options).network for spread in plan.spreads]


def _chosen(candidates: Sequence[Network], index: Function, space: Space) -> Network:
    """Take the candidate whose worst case is least, as far as a search with a seed of its own tells."""
    return min(candidates, key=lambda one: worst_case(one, index, space, Search(), _CHOSEN_BY).error)


# ---- the card ------------------------------------------------------------------------------------


def _about(name: str, plan: FeedForwardPlan | RadialBasisPlan, index: Index, space: Space) -> dict[str, Any]:
    rows = plan.recipe if isinstance(plan, FeedForwardPlan) else plan
    return {
        "name": name,
        "chain": card.chain_entry(robots.uvms()),
        "index": card.index_entry(index),
        "space": spaces.to_card(space),
        "training": card.plain(plan) | {"rows": rows.rows, "overhang": rows.overhang, "seed": 0},
        "chosen": f"least worst case by ascent, search seed {_CHOSEN_BY}",
        **_ends(name),
    }


if __name__ == "__main__":
    raise SystemExit(main())
