"""How the crane's networks are trained, and how large they should be.

Source: Rouvinen (1999), sections 2.4.3 to 2.4.5, Eqs. 49 to 58. Distances are in millimetres.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from functools import cache, partial
from itertools import product
from typing import Any, TypeAlias

import numpy as np
import torch
from scipy.special import lambertw
from torch import Tensor

from dexterity import crane, timing
from dexterity.networks.feed_forward import FeedForward
from dexterity.networks.levenberg_marquardt import Options, levenberg_marquardt
from dexterity.networks.network import View
from dexterity_study.engine.experiment import experiment

SECOND_ORDER, BATCH, SOME, PATTERN = WAYS = ("Levenberg–Marquardt", "batch", "32 rows", "pattern")
AT_ONCE = {BATCH: 0, SOME: 32, PATTERN: 1}
"""Rows that back-propagation sees at a time; 0 stands for all."""

NETWORKS = ("correction", "direct")
ONE, ALL = "one training a size", "the best of all trainings"
SIZES = (5, 8, 11, 14, 17, 18, 20, 26, 32, 40)
CRANE = {"data": ("robots/patu655.toml",), "rtol": 0.02, "atol": 1e-4}
COUNTED = ("crane-weights-counted",)
PAPER = {"paper": "rouvinen1999", **CRANE}
SMALL = {"epochs": 2, "sets": 4}
BRIEF = {"passes": (2, 6, 1, 1)}
SOME_SIZES = {**SMALL, "sizes": (5, 14, 18)}
TENTH = 0.1
GAINS = (0.003, 0.01, 0.03, 0.1, 0.3, 1.0)
Rows: TypeAlias = Iterator[dict[str, Any]]
Values: TypeAlias = Mapping[str, Any]


@experiment(seeds=10, keys=("way",), arrays=WAYS, assumes=("crane-gains",), smoke=BRIEF, **PAPER)
def descent(
    seed: int, reading: Values, passes: Sequence[int] = (200, 2000, 200, 20)
) -> tuple[list[dict[str, Any]], dict[str, np.ndarray]]:
    """Errors of the correction network during trainings from the same weights; of back-propagation by gain."""
    start, x, y = untrained("correction", 14, seed)
    history = levenberg_marquardt(start, x, y, Options(epochs=passes[0])).history
    # A training that stopped stays where it is.
    padded = np.pad(history, (0, passes[0] + 1 - len(history)), mode="edge")
    errors = {SECOND_ORDER: (1e3 * np.sqrt(2 * padded)).astype(np.float32)}
    for (mode, at_once), last in zip(AT_ONCE.items(), passes[1:], strict=True):
        # The rows come in the same orders for all seeds.
        own, random = Descent(start, x, y, reading["crane-gains"]), torch.Generator().manual_seed(0)
        told = [own.error()]
        for number in range(1, last + 1):
            own.go(at_once, random)
            if number in told_after(last):
                told.append(own.error())
        errors[mode] = torch.stack(told, dim=-1).float().numpy()
    return [{"way": way, "passes": last} for way, last in zip(WAYS, passes, strict=True)], errors


@experiment(keys=("way",), timed=True, unsteady=("seconds",), smoke={"rounds": 1}, **CRANE)
def times(seed: int, epochs: int = 20, rounds: int = 5) -> Rows:
    """Times of an epoch, and of a pass of each mode, of one network on one core [s]."""
    start, x, y = untrained("correction", 14, seed)
    train = partial(levenberg_marquardt, start, x, y, Options(epochs=epochs))
    ways, parts = [timing.Way(SECOND_ORDER, train, epochs)], {PATTERN: 10}
    for mode, at_once in AT_ONCE.items():
        # Row by row, a tenth of the rows takes a tenth of the time.
        part, random = parts.get(mode, 1), torch.Generator().manual_seed(0)
        own = Descent(start, x[::part], y[::part], momentum=0.9, gains=(1e-6,))
        ways.append(timing.Way(mode, partial(own.go, at_once, random), 1))
    for found in timing.measure(ways, rounds=rounds, seconds=0.1):
        yield {"way": found.name, "seconds": parts.get(found.name, 1) * found.median}


@experiment(seeds=10, keys=("network", "neurons"), smoke=SOME_SIZES, **CRANE)
def sizes(seed: int, sizes: Sequence[int] = SIZES, epochs: int = 200, sets: int = 400) -> Rows:
    """Errors of networks by size: on their data, the thesis's test, fresh points, and poses held out."""
    for name, neurons in product(NETWORKS, sizes):
        whole, apart = (trained(name, neurons, seed, epochs, out) for out in (False, True))
        inside, (test, *fresh) = distance(whole, *lesson(name)).mean(), set_errors(name, whole, sets)
        row = {"training": inside, "test": test, "fresh": np.mean(fresh)}
        held = distance(apart, *lesson(name))[held_out(seed)].mean()
        yield {"network": name, "neurons": neurons, **row, "held_out": held}


@experiment(seeds=3, keys=("network",), smoke=SMALL, **CRANE)
def rule_size(seed: int, epochs: int = 200, sets: int = 400) -> Rows:
    """The same for the size that Eq. 57 asks for, all of it trained on a share of the poses."""
    neurons, out = round(len(lesson("direct")[0]) / (5 * (4 + 2))), held_out(seed)
    for name in NETWORKS:
        network = trained(name, neurons, seed, epochs, apart=True)
        errors, (test, *fresh) = distance(network, *lesson(name)), set_errors(name, network, sets)
        row = {"training": errors[~out].mean(), "test": test, "fresh": np.mean(fresh)}
        yield {"network": name, "neurons": neurons, **row, "held_out": errors[out].mean()}


@experiment(keys=("network", "by"), smoke={**SOME_SIZES, "starts": 2}, **CRANE)
def lottery(
    seed: int, sizes: Sequence[int] = SIZES, epochs: int = 200, sets: int = 400, starts: int = 10
) -> Rows:
    """What comes of choosing by each of many sets of 25 points, from trainings with several seeds."""
    for name in NETWORKS:
        networks = [trained(name, *both, epochs) for both in product(sizes, range(seed, seed + starts))]
        errors = np.array([set_errors(name, network, sets)[1:] for network in networks])
        for row in draw(errors.reshape(len(sizes), starts, sets), sizes):
            yield {"network": name, **row}


@experiment(keys=("network",), assumes=COUNTED, readings=("crane-weights-counted=with-biases",), **PAPER)
def rules(seed: int, reading: Values, hidden: Sequence[int] = (14, 18, 15, 15, 19)) -> Rows:  # noqa: ARG001 -- nothing is drawn
    """Eqs. 57 and 58 for the thesis's networks, of two outputs each."""
    rows, poses = (len(lesson("direct")[0][:, :columns].unique(dim=0)) for columns in (4, 3))
    for name, neurons in zip(
        ("correction", "direct", "modular, rigid", "modular, rest", "inverse"), hidden, strict=True
    ):
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


# ---- training --------------------------------------------------------------------------------------


@cache
def lesson(name: str) -> tuple[Tensor, Tensor]:
    """Return inputs and outputs of the training data of a network."""
    data = crane.training_set()
    return data.rows[:, :4], data.deflection if name == "correction" else data.tip


def untrained(name: str, neurons: int, seed: int, apart: bool = False) -> tuple[FeedForward, Tensor, Tensor]:
    """Return a network with its initial weights, and what it is to learn."""
    x, y = (own[~held_out(seed)] if apart else own for own in lesson(name))
    random = torch.Generator().manual_seed(seed)
    return FeedForward.untrained(View(4, (0, 1, 2, 3)), neurons, x, y, random), x, y


@cache
def trained(name: str, neurons: int, seed: int, epochs: int, apart: bool = False) -> FeedForward:
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


def told_after(passes: int) -> np.ndarray:
    """Return passes after which an error is told: every one at first, then ever fewer."""
    return np.unique(np.append(0, np.geomspace(1, passes, 40).round())).astype(int)


# ---- sizes -----------------------------------------------------------------------------------------


def held_out(seed: int, share: float = 0.2) -> Tensor:
    """Tell which rows are held out: whole poses, since rows of one pose differ by the payload alone."""
    poses, pose = torch.unique(lesson("direct")[0][:, :3], dim=0, return_inverse=True)
    order = torch.randperm(len(poses), generator=torch.Generator().manual_seed(10_000 + seed))
    return torch.isin(pose, order[: round(share * len(poses))])


def distance(network: FeedForward, x: Tensor, y: Tensor) -> np.ndarray:
    """Distances of answers from the truth."""
    with torch.no_grad():
        return (1e3 * (network(x) - y).norm(dim=-1)).numpy()


@cache
def points(sets: int) -> tuple[Tensor, Mapping[str, Tensor]]:
    """Return inputs and truths at the thesis's test, then at as many points and loads again, drawn, for each set."""
    random, wanted = np.random.default_rng(1000), sets * len(crane.TEST_POINTS)
    found = torch.zeros(0, 2, dtype=torch.float64)
    while len(found) < wanted:
        drawn = torch.from_numpy(random.uniform((0.0, -4.2), (6.6, 7.8), size=(wanted, 2)))
        found = torch.cat([found, drawn[crane.inverse(drawn).within_limits]])
    targets = torch.cat([torch.tensor(crane.TEST_POINTS, dtype=torch.float64), found[:wanted]])
    strokes = crane.inverse(targets).strokes.repeat_interleave(len(crane.TEST_PAYLOADS), dim=0)
    payload = torch.tensor(crane.TEST_PAYLOADS, dtype=torch.float64).repeat(len(targets))
    sag = crane.deflection(strokes, payload)
    truth = {"correction": sag, "direct": crane.tip_position(strokes) + sag}
    return torch.cat([strokes, payload[:, None]], dim=-1), truth


def set_errors(name: str, network: FeedForward, sets: int) -> np.ndarray:
    """Mean distances at the thesis's test and at each fresh set."""
    x, truth = points(sets)
    return distance(network, x, truth[name]).reshape(sets + 1, -1).mean(-1)


def draw(errors: np.ndarray, sizes: Sequence[int]) -> Rows:
    """Let each set choose from errors (sizes, seeds, sets): the size for each seed, or size and seed."""
    _, seeds, sets = errors.shape
    truth, best = errors.mean(-1), errors.reshape(-1, sets).argmin(0)
    choices = {ONE: (errors.argmin(0), np.arange(seeds)[:, None]), ALL: (best // seeds, best % seeds)}
    for by, (size, seed) in choices.items():
        own, neurons = truth[size, seed], np.array(sizes)[size]
        shares = np.quantile(errors[size, seed, np.arange(sets)] / own, [0.1, 0.5, 0.9])
        regret = np.median(own / (truth.min(0)[:, None] if by == ONE else truth.min()))
        row = {
            "neurons": np.median(neurons),
            "fewest": neurons.min(),
            "most": neurons.max(),
            "regret": regret,
        }
        yield {"by": by, **row, **dict(zip(("low", "middle", "high"), shares, strict=True))}
