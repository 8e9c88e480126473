"""Networks on points that nothing was chosen by, ways to a better one, the stopping rule, pruning, other systems.

Sources: Sotiropoulos & Aspragathos (2016), sections 4.5 and 5. All errors are relative, Eq. 21.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import product
from typing import NamedTuple

import numpy as np
import torch

from dexterity import operations, robots, sampling
from dexterity.chain import Chain
from dexterity.indices import Index
from dexterity.networks import files, train
from dexterity.networks.growth import RadialBasisOptions, grow
from dexterity.networks.levenberg_marquardt import Options
from dexterity.networks.network import View
from dexterity.networks.pruning import prune
from dexterity.networks.recipes import Recipe, prepare
from dexterity.networks.validation import Function, acceptance_bias, fresh, judge
from dexterity.networks.worst_case import Search, worst_case
from dexterity.sampling import Box, DataSet, Space
from dexterity_study.engine.experiment import experiment
from dexterity_study.uvms.feed_forward.experiment import INDICES, LIMIT, OF_DATA, Rows, compiled, problem

KINDS = ("feed-forward", "radial-basis")
OF_NETWORKS = {**OF_DATA, "data": ("robots/uvms.toml", "networks")}
OF_ROBOTS = {**OF_DATA, "data": ("robots",)}
_FRESH_SEED, _UNTOUCHED_SEED = 4242, 77


class Effort(NamedTuple):
    """Rows of a training set, points that judge what learned it, and a search for the worst of all."""

    rows: int
    points: int = 50_000
    search: Search = Search(samples=32_768, starts=256, steps=100)


WAYS, SELECTION, ELSEWHERE, UNTOUCHED = Effort(4096), Effort(5000), Effort(2000), Effort(5000, 200_000)
SMALL_SEARCH = Search(samples=256, starts=8, steps=5)
SMALL = Effort(100, 500, SMALL_SEARCH)
E = (0.02, 0.01, 0.005)
SIZES = {"w": (149, 8), "KCI": (142, 25)}
"""Neurons of the paper's radial-basis and feed-forward networks."""


def shipped_name(index: str, kind: str) -> str:
    """Return the name of a network that comes with the package."""
    return f"uvms-{INDICES[index].name.replace('_', '-')}-{kind}"


@experiment(seeds=10, keys=("way",), smoke={"neurons": (3, 4), "epochs": 4, "effort": SMALL}, **OF_DATA)
def ways(seed: int, neurons: tuple[int, int] = (25, 50), epochs: int = 60, effort: Effort = WAYS) -> Rows:
    """Networks for KCI by way of training, from the paper's on; a way with + adds to the one before."""
    rows = effort.rows
    plain = Recipe(neurons[0], rows=rows, epochs=epochs)
    logarithm, triple = replace(plain, readout="logarithm"), replace(plain, readout="triple")
    faces = replace(triple, overhang=0.4)
    more = replace(faces, rows=2 * rows)
    recipes = {
        "as the paper": (plain, 0),
        "1/KCI": (replace(plain, readout="reciprocal"), 0),
        "log KCI": (logarithm, 0),
        "log σ1 and log σ6": (logarithm, 0),
        "origin seen from the vehicle": (logarithm, 6),
        "eigenvalue of 2×2": (replace(plain, readout="cone"), 6),
        "eigenvalue of 3×3": (triple, 6),
        "seen from the arm's first link": (triple, 7),
        "+ rows on the faces": (faces, 6),
        "+ twice the rows": (more, 6),
        "+ worst points": (replace(more, rounds=1, worst_points=rows // 4), 6),
        "+ more neurons": (replace(more, neurons=neurons[1]), 6),
    }
    chain, index, space = robots.uvms(), compiled("KCI")[0], sampling.uvms_space(INDICES["KCI"].name)
    points = fresh(index, space, effort.points, _FRESH_SEED)
    for way, (recipe, carriers) in recipes.items():
        # Carriers are joints through which the world's origin is seen, in place of the values of θ1 … θ4.
        view = View(chain.joints, range(4 if carriers else 0, 11), chain.screws[:carriers])
        if way == "log σ1 and log σ6":
            f = _two_outputs(recipe, view, space, seed)
        else:
            f = prepare(recipe, view, index, space, (seed,), rows_seed=seed)[0]
        errors, worst = judge(f, points), worst_case(f, index, space, effort.search, _FRESH_SEED)
        sampled = {"most": errors.percentile_99_9, "sampled": errors.maximum, "worst": worst.error}
        yield {"way": way, "neurons": recipe.neurons, "rows": recipe.rows, **sampled}


def _two_outputs(recipe: Recipe, view: View, space: Space, seed: int) -> Function:
    q = sampling.sobol(space, recipe.rows, seed, recipe.overhang)
    ends = torch.linalg.svdvals(robots.uvms().spatial_jacobian(q))[:, [0, -1]]
    once = Options(epochs=recipe.epochs)
    (training,) = train.for_seeds(view, recipe.neurons, q, ends, [seed], once, readout=recipe.readout)
    return lambda q: training.network(q)[..., 1] / training.network(q)[..., 0]


@experiment(keys=("index", "what"), smoke={"effort": Effort(500, 2000, SMALL_SEARCH)}, **OF_NETWORKS)
def judged(seed: int, effort: Effort = UNTOUCHED) -> Rows:
    """Networks that come with the package and baselines, on points that nothing was chosen by; trees have no gradient."""
    from dexterity.networks.baselines import baselines  # needs scikit-learn, which pages do without

    for name in INDICES:
        (index, view), space = compiled(name), sampling.uvms_space(INDICES[name].name)
        points = fresh(index, space, effort.points, _UNTOUCHED_SEED)
        functions = dict(baselines(view, fresh(index, space, effort.rows, _FRESH_SEED), seed))
        functions |= {kind: files.load_shipped(shipped_name(name, kind)) for kind in KINDS}
        for what, f in functions.items():
            errors = judge(f, points)
            row = {"index": name, "what": what, "median": errors.median, "most": errors.percentile_99}
            if what != "boosted trees":
                found = worst_case(f, index, space, effort.search, _UNTOUCHED_SEED).error
                row["worst"] = max(found, errors.maximum)
            yield {**row, "sampled": errors.maximum}


@experiment(keys=("index", "kind"), **OF_NETWORKS)
def cards() -> Rows:
    """Cards of the networks that come with the package; times are quartiles in C [ns per configuration]."""
    for index, kind in product(INDICES, KINDS):
        card = files.load_shipped(shipped_name(index, kind)).card
        times, counts = card["time"]["ns_per_configuration"], card["operations"]
        facts = {"inputs": card["inputs"], "neurons": card["neurons"], "worst": card["worst_case"]["error"]}
        facts |= {"error": card["errors"]["maximum"], "points": card["errors"]["count"]}
        facts |= {f"{of}_{i}": times[of][i] for of in ("exact", "network") for i in range(3)}
        exact = counts["exact, before a root or an iteration"]
        facts |= {"operations": counts["layers"], "exact_operations": exact}
        yield {"index": index, "kind": kind, **facts}


@experiment(
    keys=("limit",), smoke={"largest": 2, "restarts": 3, "limits": (0.05,), "effort": SMALL}, **OF_DATA
)
def selection(
    seed: int, largest: int = 6, restarts: int = 100, limits: Sequence[float] = E, effort: Effort = SELECTION
) -> Rows:
    """Networks for w of the smallest size of which some pass the paper's test, and their medians elsewhere."""
    (index, view), space, points = compiled("w"), sampling.uvms_space(INDICES["w"].name), effort.points
    data = sampling.data_sets(index, space, train=effort.rows, test=1000, validation=points, seed=_FRESH_SEED)
    q = sampling.on_grid(space, points, torch.Generator().manual_seed(_FRESH_SEED))
    others, learned = DataSet(q, index(q)), (data.train.q, data.train.values)
    pools = {}
    for size in range(1, largest + 1):
        trainings = train.for_seeds(view, size, *learned, range(seed, seed + restarts), Options(epochs=100))
        pools[size] = [training.network for training in trainings]
    for limit in limits:
        biases = {size: acceptance_bias(pool, data.test, others, limit) for size, pool in pools.items()}
        for size in [size for size, bias in biases.items() if bias.accepted.any()][:1]:
            bias = biases[size]
            passing = [pools[size][number] for number in np.flatnonzero(bias.accepted)]
            errors = {
                "testing": bias.testing[bias.accepted],
                "grid": bias.fresh[bias.accepted],
                "between": [judge(network, data.validation).maximum for network in passing],
                # The ascents of ten networks take long enough.
                "worst": [worst_case(network, index, space, effort.search).error for network in passing[:10]],
            }
            broken, expected = round(bias.broken_share * len(passing)), bias.expected_share * restarts
            counts = {"trained": restarts, "accepted": len(passing), "broken": broken, "expected": expected}
            medians = {name: np.median(np.asarray(each)) for name, each in errors.items()}
            yield {"limit": limit, "neurons": size, **counts, **medians}


@experiment(
    keys=("index", "spread"),
    smoke={"sizes": {"w": (20, 2), "KCI": (20, 2)}, "spreads": (3.0,), "rows": 200},
    **OF_DATA,
)
def pruned(
    seed: int,
    sizes: Mapping[str, tuple[int, int]] = SIZES,
    spreads: Sequence[float] = (0.5, 1.0, 2.0, 4.0, 8.0),
    rows: int = 5000,
) -> Rows:
    """Radial-basis networks pruned to E or, where that is not reached, to a tenth more than their testing error."""
    for name, (neurons, feed_forward) in sizes.items():
        own = problem(name, seed, rows=rows)
        options = RadialBasisOptions(testing_error=0.0, training_goal=0.0, neuron_limit=neurons)
        for spread in spreads:
            grown = grow(own, spread, options)
            allowed = max(LIMIT, 1.1 * grown.testing_errors[-1])
            after = prune(own, grown.network, allowed).neurons
            counts = {"before": grown.neurons, "after": after}
            counts["operations"] = operations.radial_basis(own.view.width, after).total
            counts["feed_forward_operations"] = operations.feed_forward(own.view.width, feed_forward).total
            yield {"index": name, "spread": spread, "allowed": allowed, **counts}


@experiment(
    seeds=10,
    keys=("system", "index"),
    smoke={"neurons": (2, 2), "epochs": 3, "effort": SMALL._replace(rows=80)},
    **OF_ROBOTS,
)
def elsewhere(
    seed: int, neurons: tuple[int, int] = (8, 25), epochs: int = 50, effort: Effort = ELSEWHERE
) -> Rows:
    """The paper's pipeline put to other systems and indices, the arm about a random posture, a vehicle at the origin."""
    for claim, system, chain, name, index, held in _systems():
        middle = torch.zeros(chain.joints, dtype=torch.float64)
        random = torch.Generator().manual_seed(seed)
        middle[-6:] = (torch.rand(6, generator=random, dtype=torch.float64) - 0.5) * math.pi
        half = torch.full_like(middle, math.radians(15.0))
        half[list(held)] = 0.0
        f, space = index.bind(chain), Box(middle - half, middle + half)
        points, inputs = fresh(f, space, effort.points, _FRESH_SEED), _that_matter(f, space)
        size = neurons[index.name != "manipulability"]
        recipe, view = Recipe(size, rows=effort.rows, epochs=epochs), View(space.joints, inputs)
        (network,) = prepare(recipe, view, f, space, (seed,), rows_seed=seed)
        low, high = points.values.aminmax()
        constant, error = (high - low) / (high + low), judge(network, points).maximum
        key = {"system": system, "index": name, "claim": claim, "inputs": len(inputs), "neurons": size}
        yield {**key, "error": error, "constant": constant, "span": high / low}


def _systems() -> Iterator[tuple[str, str, Chain, str, Index, tuple[int, ...]]]:
    """Yield claim, system, chain, index with its name, and joints held at zero."""
    uvms, puma, on_vehicle = robots.uvms(), robots.puma560(), torch.eye(4, dtype=torch.float64)
    on_vehicle[1, 3] = robots.describe("uvms").lengths["y_MB"]
    translations, tilts = (0, 1, 2), (3, 4)
    for claim, system, chain, still in (
        ("any-uvms", "UVMS in other postures", uvms, ()),
        ("any-uvms", "docking arm on a vehicle", robots.docking_arm().on_vehicle(on_vehicle), ()),
        ("any-uvms", "UVMS with pitch and roll passive", uvms, tilts),
        ("space-robots", "PUMA 560 on a free base", puma.on_vehicle(on_vehicle), ()),
        ("mobile-robots", "UVMS confined to a plane", uvms, (2, *tilts)),
    ):
        rates = tuple(float(joint not in still) for joint in range(chain.joints))
        for name, index in INDICES.items():
            yield claim, system, chain, name, replace(index, joint_rates=rates), (*translations, *still)
    slow = (0.5,) * 3 + (0.3,) * 3 + (1.0,) * 6
    for name, index in {
        "w, slow vehicle": Index("manipulability", joint_rates=slow),
        "KCI, slow vehicle": Index("kinematic_conditioning", joint_rates=slow),
        "KCI of the tool, body frame": Index("kinematic_conditioning", "body"),
    }.items():
        yield "library-of-indices", "UVMS in other postures", uvms, name, index, translations
    yield "library-of-indices", "PUMA 560, fixed", puma, "w", INDICES["w"], ()


def _that_matter(f: Function, space: Box) -> list[int]:
    """Joints that vary and that the index changes with, from 0."""
    q = sampling.uniform(space, 64, torch.Generator().manual_seed(0)).requires_grad_()
    (slopes,) = torch.autograd.grad(f(q).sum(), q)
    matters = slopes.abs().amax(0) > 1e-9 * slopes.abs().max()
    return [joint for joint in space.free_joints if matters[joint]]
