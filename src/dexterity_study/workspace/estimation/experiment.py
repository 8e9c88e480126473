"""The networks of paper C trained as the paper does, at a smaller size, and with one thing changed after the other.

Sources: Liao & Mao (2018), sections V and VI, Tables VI and VII, Figs. 5 to 9. Errors and scores of Jacobians are
those of the 23 entries of the body Jacobian that vary, each scaled to [−1, 1] by the training set.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import lru_cache, partial
from typing import Any, NamedTuple

import numpy as np
import torch
from sklearn import metrics

from dexterity import spatial
from dexterity.workspace import dataset, reachability, training
from dexterity.workspace.dataset import ConfidenceData, JacobianData, Scaling
from dexterity.workspace.jacobian_net import Architecture, Entries, Inputs, JacobianNet, encode
from dexterity.workspace.training import OPTIMISERS, Head, Loss, Options, Training, cycles, epochs
from dexterity_study.engine.experiment import experiment

THRESHOLDS = (0.25, 0.5, 0.75)
"""Confidences from which on a Jacobian is given, those of Table VI."""

ENTRIES, CONSTANT_ENTRIES = 23, 2
"""Entries of the body Jacobian that vary, and those that are constant and not zero."""

SCORES = {
    "accuracy": metrics.accuracy_score,
    "jaccard": partial(metrics.jaccard_score, zero_division=0),
    "precision": partial(metrics.precision_score, zero_division=0),
    "recall": partial(metrics.recall_score, zero_division=0),
    "correlation": metrics.matthews_corrcoef,
}
"""Scores of a confidence head at a threshold."""

PAPERS_WAY, LONGER = "the paper's way", "the paper's way, more steps"
UNDROPPED, CONFIDENCE_ALONE = "more steps, without dropout", "confidence alone"
COLUMNS, RELEVANT, PLAIN, WORLD, BEST = "columns", "relevant", "rotation", "world", "plane"
HEADS: tuple[Head, ...] = ("confidence", "estimation")

_WIDE = Architecture(confidence=(128, 128), estimation=(256,) * 4)
_NARROW = Architecture(confidence=(128, 128), estimation=(128,) * 3)
SMALL_COPY = Architecture((128,) * 8 + (256,), (64,) * 7, (64,) * 7, normalised=(5, 4), dropout=0.5)
"""The paper's network with as many layers, and narrower ones."""


class Way(NamedTuple):
    """A way to learn: what a network sees, which entries it predicts, its size, and how its heads are trained."""

    inputs: Inputs
    entries: Entries
    architecture: Architecture = _WIDE
    heads: tuple[Head, ...] = HEADS
    batch: int | None = None  # rows per step in the paper's way, by cycles; None for one head after the other
    dynamics: bool = False  # whether the confidence data have dynamic parameters
    seeds: int = 2  # with so many, from the first on, it is trained


_PAPERS = Way("columns", "tool", SMALL_COPY, batch=4096, dynamics=True)
WAYS: Mapping[str, Way] = {
    PAPERS_WAY: _PAPERS,
    LONGER: _PAPERS._replace(batch=256),
    UNDROPPED: _PAPERS._replace(architecture=replace(SMALL_COPY, dropout=0.0), batch=256, seeds=1),
    COLUMNS: Way("columns", "tool", dynamics=True),
    RELEVANT: Way("relevant", "tool"),
    PLAIN: Way("rotation", "tool", heads=("estimation",), seeds=10),
    WORLD: Way("rotation", "world", heads=("estimation",)),
    BEST: Way("plane", "plane", _NARROW, seeds=10),
    CONFIDENCE_ALONE: _PAPERS._replace(heads=("confidence",), dynamics=False),
}
"""The ways that are compared; those from the columns to the plane have one thing changed each."""

RATES = dict(zip(OPTIMISERS, (0.01, 0.001, 0.002, 0.002, 0.001, 0.01, 1.0), strict=True))
"""Learning rate of each optimiser, Keras's default of the time."""

# A training carries rounding errors on and makes them larger.
TOLERANCES = {"rtol": 0.05, "atol": 0.02}
Made = tuple[list[dict[str, Any]], dict[str, Any]]


@experiment(
    seeds=10,
    keys=("way",),
    arrays=("left_of_entries",),
    smoke={"rows": (3_000, 2_000), "tests": (2_000, 1_000), "counts": (2, 1), "paper_epochs": 4},
    assumes=("epoch-count",),
    paper="liao2018",
    **TOLERANCES,
)
def trainings(
    seed: int,
    reading: Mapping[str, Any],
    names: Sequence[str] = tuple(WAYS),
    rows: tuple[int, int] = (297_000, 198_000),
    tests: tuple[int, int] = (100_000, 20_000),
    counts: tuple[int, int] = (16, 32),
    paper_epochs: int | None = None,
) -> Made:
    """Ways to learn, judged on fresh samples; rows, tests and epochs (`counts`) are for confidence and for estimation."""
    made, left = [], np.full((len(WAYS), ENTRIES), np.nan, dtype=np.float32)
    for name in names:
        way = WAYS[name]
        if seed >= way.seeds:
            continue
        sets, (confidence, jacobians) = _sets(rows, 0, way.dynamics), _sets(tests, 2, way.dynamics)
        options = options_of(way, counts, paper_epochs or reading["epoch-count"])
        network, losses, *_ = fit(way, sets, options, seed)
        row: dict[str, Any] = {"way": name, "parameters": network.parameter_count}
        if "confidence" in way.heads:
            row |= sureness(network, confidence)
        if "estimation" in way.heads:
            scaling = Scaling.to_range(encode(sets[1].jacobian, sets[1].samples, "tool"))
            pair = jacobians.jacobian, network.estimate(jacobians.samples).jacobian
            scaled = (scaling.apply(encode(J, jacobians.samples, "tool")).numpy() for J in pair)
            scores, left[list(WAYS).index(name)] = errors(*scaled)
            row |= scores
        if way.heads == HEADS:
            row |= combined(network, confidence) | (cycle_facts(losses) if way.batch else {})
        made.append(row)
    return made, {"left_of_entries": left}


# A curve of one epoch rises or not by rounding, which differs between processors.
@experiment(
    keys=("optimiser", "head"),
    arrays=HEADS,
    smoke={"rows": 300, "count": 1},
    unsteady=("rises",),
    **TOLERANCES,
)
def optimisers(seed: int, rows: int = 20_000, count: int = 12) -> Made:
    """The paper's way with each optimiser; arrays have the epochs of a head, then its validation losses."""
    sets = confidence, jacobians = _sets((rows, rows), 0, dynamics=True)
    share = confidence.reachable.double().mean().item()
    y = encode(jacobians.jacobian, jacobians.samples, "tool")
    entropy = -share * math.log(share) - (1 - share) * math.log(1 - share)
    constants = {"confidence": entropy, "estimation": Scaling.to_range(y).apply(y).var(0).mean().item()}
    made: list[dict[str, Any]] = []
    curves: dict[str, Any] = {}
    for optimiser, rate in RATES.items():
        options = Options(cycles(count, count), optimiser, rate, decay=False, batch=512)
        losses = fit(_PAPERS, sets, options, seed).losses
        for head, constant in constants.items():
            curve = [loss.validation for loss in losses if loss.head == head]
            places = [k for k, loss in enumerate(losses, start=1) if loss.head == head]
            curves.setdefault(head, [places]).append(curve)
            left = {"left": curve[-1] / constant, "constant": constant}
            made.append({"optimiser": optimiser, "head": head, **left, "rises": rises(curve)})
    return made, {head: np.array(own, dtype=np.float32) for head, own in curves.items()}


_confidence_set = lru_cache(maxsize=4)(dataset.confidence_data)
_jacobian_set = lru_cache(maxsize=4)(dataset.jacobian_data)


def _sets(rows: tuple[int, int], seed: int, dynamics: bool) -> tuple[ConfidenceData, JacobianData]:
    """Draw data for both heads; Jacobians are kept by the inertia of their arms in any case."""
    jacobians = _jacobian_set(rows[1], seed + 2)
    if not dynamics:
        jacobians = jacobians._replace(samples=jacobians.samples._replace(dynamics=None))
    return _confidence_set(rows[0], seed + 1, dynamics), jacobians


def fit(way: Way, sets: tuple[ConfidenceData, JacobianData], options: Options, seed: int) -> Training:
    """Train a network on data for both heads."""
    network = training.network_for(way.architecture, way.inputs, way.entries, sets[1], seed)
    rows = training.confidence_rows(network, sets[0]), training.estimation_rows(network, sets[1])
    return training.train(network, {head: rows[HEADS.index(head)] for head in way.heads}, options, seed)


def options_of(way: Way, counts: tuple[int, int], paper_epochs: int) -> Options:
    """Return how a way is trained; a ninth of the paper's epochs, or a little more, come before its cycles."""
    if way.batch is None:
        schedule = epochs(*(n if head in way.heads else 0 for head, n in zip(HEADS, counts, strict=True)))
        return Options(schedule, rate=2e-3, batch=256)
    n = paper_epochs * 8 // 9 // 3
    schedule = cycles(paper_epochs - 3 * n, n) if way.heads == HEADS else epochs(confidence=paper_epochs)
    return Options(schedule, rate=1e-3, decay=False, batch=way.batch)


def sureness(network: JacobianNet, data: ConfidenceData) -> dict[str, float]:
    """Return the scores of a confidence head at all thresholds."""
    confidence, reach = network.estimate(data.samples).confidence.numpy(), data.reachable.numpy()
    pairs = [(f"{name}_{t:g}", t, score) for t in THRESHOLDS for name, score in SCORES.items()]
    return {name: score(reach, confidence >= t) for name, t, score in pairs}


def errors(truth: np.ndarray, guess: np.ndarray) -> tuple[dict[str, float], np.ndarray]:
    """Return errors, means over the entries of explained variance and R², and the variance left of each entry."""
    missed = guess - truth
    left = np.square(missed).mean(0) / truth.var(0)
    return {
        "absolute": np.abs(missed).mean(),
        "squared": np.square(missed).mean(),
        "explained": (1 - missed.var(0) / truth.var(0)).mean(),
        "r2": 1 - left.mean(),
        "worst_entry": 1 - left.max(),
    }, left


def combined(network: JacobianNet, data: ConfidenceData) -> dict[str, float]:
    """Return shares of poses that the gate lets pass, and relative errors of the Jacobians rightly given."""
    _, J, given = network.estimate(data.samples)
    reach = data.reachable
    rows = data.samples.rows(given & reach)
    q, _ = reachability.inverse(rows.links, spatial.pose(rows.rotation(), rows.position))
    exact = reachability.geometric_jacobian(rows.links, q)
    error = torch.linalg.matrix_norm(J[given & reach] - exact) / torch.linalg.matrix_norm(exact)
    return {
        "given": given.double().mean().item(),
        "wrongly_given": given[~reach].double().mean().item(),
        "wrongly_kept_back": (~given[reach]).double().mean().item(),
        "error": error.median().item() if len(error) else math.nan,
        "worst_error": error.quantile(0.99).item() if len(error) else math.nan,
    }


def rises(validation: Sequence[float]) -> float:
    """Return all rises of a loss together, over its fall from the first epoch to the best one."""
    falls = validation[0] - min(validation)
    return np.diff(validation).clip(min=0).sum() / falls if falls > 0 else math.inf


def cycle_facts(losses: Sequence[Loss]) -> dict[str, float]:
    """Return the loss before the cycles, the epochs to half of each head's fall, and how often a cycle shows.

    A cycle shows if the confidence head, after a step of the encoder, begins above the loss that it had ended with.
    """
    first = next(k for k, loss in enumerate(losses) if loss.head == "confidence")
    train = [loss.train for loss in losses if loss.head == "confidence"]
    returns = np.greater(train[2::2], train[1:-1:2])
    shown = returns.mean() if len(returns) else 0.0
    facts = {"before_cycles": losses[first - 1].validation, "returns": shown}
    for head in HEADS:
        curve = np.array([loss.validation for loss in losses if loss.head == head])
        facts[f"{head}_to_half"] = int(np.argmax(curve <= (curve[0] + curve.min()) / 2)) + 1
    return facts
