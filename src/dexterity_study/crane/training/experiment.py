"""How the crane's networks are trained, and how large they should be.

Source: Rouvinen (1999), sections 2.4.3 to 2.4.5, Eqs. 49 to 58. Distances are in millimetres.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cache, partial
from itertools import product
from typing import Any

import numpy as np
import torch
from scipy.special import lambertw
from torch import Tensor

from dexterity import crane, timing
from dexterity.networks.feed_forward import FeedForward
from dexterity.networks.levenberg_marquardt import Options, levenberg_marquardt
from dexterity.networks.network import View
from dexterity_study.crane.cases import BOX, CRANE, PAPER, Made, Rows, Values, seeded
from dexterity_study.engine.experiment import experiment

SECOND_ORDER, BATCH, SOME, PATTERN = WAYS = ("Levenberg–Marquardt", "batch", "32 rows", "pattern")
AT_ONCE = {BATCH: 0, SOME: 32, PATTERN: 1}
"""Rows that back-propagation sees at a time; 0 stands for all."""

NETWORKS = ("correction", "direct")
SIZES = (5, 8, 11, 14, 17, 18, 20, 26, 32, 40)
LOOSE = {"rtol": 0.02, "atol": 1e-4}
SMALL = {"epochs": 2, "sets": 4}
TENTH = 0.1
GAINS = (0.003, 0.01, 0.03, 0.1, 0.3, 1.0)


@experiment(
    seeds=10,
    keys=("way",),
    arrays=WAYS,
    assumes=("crane-gains",),
    smoke={"passes": (2, 6, 1, 1)},
    **PAPER,
    **LOOSE,
)
def descent(seed: int, reading: Values, passes: Sequence[int] = (200, 2000, 200, 20)) -> Made:
    """Errors of the correction network during trainings from the same weights; of back-propagation by gain."""
    start, x, y = untrained("correction", 14, seed)
    history = levenberg_marquardt(start, x, y, Options(epochs=passes[0])).history
    # A training that stopped stays where it is.
    padded = np.pad(history, (0, passes[0] + 1 - len(history)), mode="edge")
    errors = {SECOND_ORDER: (1e3 * np.sqrt(2 * padded)).astype(np.float32)}
    for (mode, at_once), last in zip(AT_ONCE.items(), passes[1:], strict=True):
        # The rows come in the same orders for all seeds.
        training, random = Descent(start, x, y, reading["crane-gains"]), seeded(0)
        reported = [training.error()]
        for number in range(1, last + 1):
            training.go(at_once, random)
            if number in reported_after(last):
                reported.append(training.error())
        errors[mode] = torch.stack(reported, dim=-1).float().numpy()
    return [{"way": way, "passes": last} for way, last in zip(WAYS, passes, strict=True)], errors


@experiment(keys=("way",), timed=True, unsteady=("seconds",), smoke={"rounds": 1}, **CRANE, **LOOSE)
def times(seed: int, epochs: int = 20, rounds: int = 5) -> Rows:
    """Times of an epoch, and of a pass of each mode, of one network on one core [s]."""
    start, x, y = untrained("correction", 14, seed)
    train = partial(levenberg_marquardt, start, x, y, Options(epochs=epochs))
    # Row by row, a tenth of the rows takes a tenth of the time.
    ways, parts = [timing.Way(SECOND_ORDER, train, epochs)], {PATTERN: 10}
    for mode, at_once in AT_ONCE.items():
        some = slice(None, None, parts.get(mode, 1))
        training = Descent(start, x[some], y[some], momentum=0.9, gains=(1e-6,))
        ways.append(timing.Way(mode, partial(training.go, at_once, seeded(0)), 1))
    for way in timing.measure(ways, rounds=rounds, seconds=0.1):
        yield {"way": way.name, "seconds": parts.get(way.name, 1) * way.median}


@experiment(seeds=10, keys=("network", "neurons"), smoke={**SMALL, "sizes": (5, 14, 18)}, **CRANE, **LOOSE)
def sizes(seed: int, sizes: Sequence[int] = SIZES, epochs: int = 200, sets: int = 400) -> Rows:
    """Errors of networks by size: on their data, the thesis's test, fresh points, and poses held out."""
    for name, neurons in product(NETWORKS, sizes):
        whole, apart = (trained(name, neurons, seed, epochs, out) for out in (False, True))
        row = {"training": distance(whole, *lesson(name)).mean(), **test_errors(name, whole, sets)}
        held = distance(apart, *lesson(name))[held_out(seed)].mean()
        yield {"network": name, "neurons": neurons, **row, "held_out": held}


@experiment(seeds=3, keys=("network",), smoke=SMALL, **CRANE, **LOOSE)
def rule_size(seed: int, epochs: int = 200, sets: int = 400) -> Rows:
    """The same for the size that Eq. 57 asks for, all of it trained on a share of the poses."""
    neurons, out = round(len(lesson("direct")[0]) / (5 * (4 + 2))), held_out(seed)
    for name in NETWORKS:
        network = trained(name, neurons, seed, epochs, apart=True)
        errors = distance(network, *lesson(name))
        row = {"training": errors[~out].mean(), **test_errors(name, network, sets)}
        yield {"network": name, "neurons": neurons, **row, "held_out": errors[out].mean()}


@experiment(
    keys=("network",),
    assumes=("crane-weights-counted",),
    readings=("crane-weights-counted=with-biases",),
    **PAPER,
    **LOOSE,
)
def rules(reading: Values, hidden: Sequence[int] = (14, 18, 15, 15, 19)) -> Rows:
    """Eqs. 57 and 58 for the thesis's networks, of two outputs each."""
    rows, poses = (len(lesson("direct")[0][:, :columns].unique(dim=0)) for columns in (4, 3))
    names = ("correction", "direct", "modular, rigid", "modular, rest", "inverse")
    for name, neurons in zip(names, hidden, strict=True):
        inputs = 3 if name == "modular, rigid" else 4
        weights = neurons * (inputs + 2) + (neurons + 2) * reading["crane-weights-counted"]
        yield {
            "network": name,
            "neurons": neurons,
            "rows": poses if inputs == 3 else rows,
            "by_rows": round(rows / (5 * (inputs + 2))),
            "by_poses": round(poses / (5 * (inputs + 2))),
            "needed": round(32 * weights / TENTH * math.log(32 * neurons / TENTH)),
            # The share for which Eq. 58 asks for the rows that there are, solved by Lambert's function.
            "wrong": 32 * neurons / math.exp(lambertw(neurons * rows / weights).real),
        }


@cache
def lesson(name: str) -> tuple[Tensor, Tensor]:
    """Return inputs and outputs of the training data of a network."""
    data = crane.training_set()
    return data.rows[:, :4], data.deflection if name == "correction" else data.tip


def untrained(name: str, neurons: int, seed: int, apart: bool = False) -> tuple[FeedForward, Tensor, Tensor]:
    """Return a network with its initial weights, and what it is to learn."""
    x, y = (rows[~held_out(seed)] if apart else rows for rows in lesson(name))
    return FeedForward.untrained(View(4, (0, 1, 2, 3)), neurons, x, y, seeded(seed)), x, y


def trained(name: str, neurons: int, seed: int, epochs: int, apart: bool) -> FeedForward:
    """Train a network, on all data or apart from what is held out."""
    start, x, y = untrained(name, neurons, seed, apart)
    return levenberg_marquardt(start, x, y, Options(epochs=epochs)).network


class Descent:
    """Gradient descent with momentum from one network, with several gains side by side (Eqs. 49 to 54)."""

    def __init__(
        self, network: FeedForward, x: Tensor, y: Tensor, momentum: float, gains: Sequence[float] = GAINS
    ) -> None:
        self.x = (x - network.input_centre) / network.input_half_range
        self.y = (y - network.target_centre) / network.target_half_range
        self.half_range, self.gain = network.target_half_range, torch.tensor(gains, dtype=torch.float64)
        names = ("hidden_weights", "hidden_biases", "output_weights", "output_biases")
        started = [torch.stack([getattr(network, name).detach()] * len(gains)) for name in names]
        self.weights = [weights.requires_grad_() for weights in started]
        # A gain on the error is a gain on the step, momentum included, so that one optimiser serves them all.
        self.optimiser = torch.optim.SGD(self.weights, lr=1.0, momentum=momentum)

    def squares(self, rows: Any = slice(None)) -> Tensor:
        """Squared distances (gains, rows) of scaled outputs from scaled targets."""
        inner, inner_biases, outer, outer_biases = self.weights
        hidden = torch.tanh(self.x[rows] @ inner.mT + inner_biases[:, None])
        return (hidden @ outer.mT + outer_biases[:, None] - self.y[rows]).square().sum(-1)

    def error(self) -> Tensor:
        """Root mean square distance (gains); infinite if it is not finite."""
        with torch.no_grad():
            error = 1e3 * self.half_range * self.squares().mean(-1).sqrt()
        return torch.where(error.isfinite(), error, torch.inf)

    def go(self, at_once: int, random: torch.Generator) -> None:
        """Pass over the data once, in a new order."""
        parts = torch.randperm(len(self.x), generator=random).split(at_once) if at_once else [slice(None)]
        for rows in parts:
            self.optimiser.zero_grad()
            (self.gain * self.squares(rows).mean(-1) / 2).sum().backward()
            self.optimiser.step()


def reported_after(passes: int) -> np.ndarray:
    """Return passes after which an error is reported: every one at first, then ever fewer."""
    return np.unique(np.append(0, np.geomspace(1, passes, 40).round())).astype(int)


def held_out(seed: int, share: float = 0.2) -> Tensor:
    """Tell which rows are held out: whole poses, since rows of one pose differ by the payload alone."""
    poses, pose = torch.unique(lesson("direct")[0][:, :3], dim=0, return_inverse=True)
    order = torch.randperm(len(poses), generator=seeded(10_000 + seed))
    return torch.isin(pose, order[: round(share * len(poses))])


def distance(network: FeedForward, x: Tensor, y: Tensor) -> np.ndarray:
    """Distances of answers from the truth."""
    with torch.no_grad():
        return (1e3 * (network(x) - y).norm(dim=-1)).numpy()


@cache
def points(sets: int) -> tuple[Tensor, Values]:
    """Return inputs and truths at the thesis's test, then at some times as many points and loads, drawn."""
    random, wanted = np.random.default_rng(1000), sets * len(crane.TEST_POINTS)
    low, high = np.transpose(BOX)
    targets = torch.zeros(0, 2, dtype=torch.float64)
    while len(targets) < wanted:
        drawn = torch.from_numpy(random.uniform(low, high, size=(wanted, 2)))
        targets = torch.cat([targets, drawn[crane.inverse(drawn).within_limits]])
    targets = torch.cat([torch.tensor(crane.TEST_POINTS, dtype=torch.float64), targets[:wanted]])
    strokes = crane.inverse(targets).strokes.repeat_interleave(len(crane.TEST_PAYLOADS), dim=0)
    payload = torch.tensor(crane.TEST_PAYLOADS, dtype=torch.float64).repeat(len(targets))
    sag = crane.deflection(strokes, payload)
    truth = {"correction": sag, "direct": crane.tip_position(strokes) + sag}
    return torch.cat([strokes, payload[:, None]], dim=-1), truth


def test_errors(name: str, network: FeedForward, sets: int) -> dict[str, float]:
    """Mean distances at the thesis's test and at fresh points."""
    x, truth = points(sets)
    errors, tested = distance(network, x, truth[name]), len(crane.TEST_POINTS) * len(crane.TEST_PAYLOADS)
    return {"test": errors[:tested].mean(), "fresh": errors[tested:].mean()}
