"""Paper D, section 2.4: how networks are trained, and how large they should be, tried on the crane's data.

Rouvinen (1999), Eqs. 49 to 58. Back-propagation with momentum is torch's gradient descent, all rows at once,
a few at a time and one by one; Levenberg–Marquardt is the package's. Sizes are chosen as the thesis does, by
the error at its test points, and beside that by poses that are held out.

What decides a verdict was set beforehand. Levenberg–Marquardt is better if it leaves a smaller error than
the best back-propagation in the same time with every seed, for *in shape* in the median. A size is where the
test error is least if its median over the seeds is within a tenth of the smallest one of all sizes; for both
networks that is *reproduced*, for one *in shape*. The rule for the size is *reproduced* if the network that
it asks for has a held-out error within a tenth of the smallest one, and *in shape* if its error is smaller
than that of the thesis's size. The bound is *contradicted* if the data does not meet it even where every
answer may be wrong, and networks answer held-out poses with less than a tenth of their spread as error.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TypeAlias

import numpy as np
import torch
from numpy.typing import NDArray
from scipy.optimize import brentq
from torch import Tensor

from dexterity import crane, timing
from dexterity.networks.feed_forward import FeedForward
from dexterity.networks.levenberg_marquardt import Options, levenberg_marquardt
from dexterity.networks.network import View
from dexterity.report.claims import Acceptance, Outcome, Verdict, load_paper
from dexterity.report.ranges import with_range
from dexterity.report.stored import Tolerance

__all__ = [
    "CONFIGS",
    "JUDGED_AS_STORED",
    "LEVENBERG_MARQUARDT",
    "MODES",
    "NETWORKS",
    "TOLERANCE",
    "Choice",
    "Config",
    "Descent",
    "Result",
    "Sizes",
    "acceptance",
    "choice_table",
    "equal_time_table",
    "history",
    "memory_table",
    "rule_table",
    "run",
    "size_table",
    "verdicts",
]

JUDGED_AS_STORED = True
"""Verdicts go by ten seeds, and a book is built with fewer."""

TOLERANCE = Tolerance(rtol=0.02, atol=1e-4)
"""What a probe may miss by, since a training carries rounding errors on and makes them larger."""

LEVENBERG_MARQUARDT = "Levenberg–Marquardt"
"""What the package's own training is called in tables."""

BATCH, SOME, PATTERN = "batch", "32 rows", "pattern"

MODES: Mapping[str, int] = {BATCH: 0, SOME: 32, PATTERN: 1}
"""Rows that back-propagation sees at a time, by mode; 0 stands for all."""

NETWORKS: Mapping[str, str] = {"correction": "crane-correction-neurons", "direct": "crane-direct-neurons"}
"""Networks whose sizes are tried, with the claim that has the thesis's size."""

Array: TypeAlias = NDArray[np.float64]

_PAPER = "rouvinen1999"
_GAINS = (0.003, 0.01, 0.03, 0.1, 0.3, 1.0)
_MOMENTUM = 0.9
_SEES = View(4, (0, 1, 2, 3))


@dataclass(frozen=True)
class Config:
    """How much is trained.

    Attributes
    ----------
    seeds
        Of initial weights, splits and orders.
    epochs
        Of each training by Levenberg–Marquardt.
    batch_passes, some_passes, pattern_passes
        Passes of back-propagation over the data, by mode.
    sizes
        Hidden neurons that are tried.
    rule_seeds
        How many of the seeds are used with the size of Eq. 57, which takes long.
    held_out
        Share of the poses.
    sets
        Fresh sets of as many points and payloads as the thesis's.
    fresh_seed
        What they are drawn from.
    timed
        Whether times are taken.
    """

    seeds: tuple[int, ...] = (0, 1, 2)
    epochs: int = 20
    batch_passes: int = 150
    some_passes: int = 20
    pattern_passes: int = 1
    sizes: tuple[int, ...] = (8, 14, 26)
    rule_seeds: int = 1
    held_out: float = 0.2
    sets: int = 100
    fresh_seed: int = 1000
    timed: bool = True


CONFIGS: Mapping[str, Config] = {
    "smoke": Config(
        seeds=(0, 1), epochs=2, batch_passes=6, some_passes=1, pattern_passes=1, sizes=(5, 14, 18), sets=4,
        timed=False,
    ),
    "book": Config(),
    "full": Config(
        seeds=tuple(range(10)), epochs=200, batch_passes=2_000, some_passes=200, pattern_passes=20,
        sizes=(5, 8, 11, 14, 17, 18, 20, 26, 32, 40), rule_seeds=3, sets=400,
    ),
}  # fmt: skip
"""What runs at each scale."""


@dataclass(frozen=True)
class Descent:
    """How the error of the correction network falls, for the thesis's number of neurons.

    Attributes
    ----------
    second_order
        (seeds, epochs + 1) root mean square distance over the data [mm], by Levenberg–Marquardt.
    passes
        By mode, the passes (p) after which an error is told.
    first_order
        By mode, (seeds, gains, p) the same by back-propagation; infinite where it diverges.
    seconds
        For an epoch or a pass of one network on one core, by name [s]; empty if no times were taken.
    parameters
        Weights and biases of the network.
    gradient_error
        Largest difference of Eqs. 51 to 53, written out for a linear output, from torch's gradient.
    """

    second_order: Array
    passes: Mapping[str, Array]
    first_order: Mapping[str, Array]
    seconds: Mapping[str, float]
    parameters: int
    gradient_error: float


@dataclass(frozen=True)
class Sizes:
    """Errors of a network by its size: mean distances from the truth [mm], (sizes, seeds) each.

    Attributes
    ----------
    training, test, fresh
        Trained on all data: over the data, the thesis's test, and all fresh sets.
    share, held_out
        Trained on a share of the poses: over these, and over the others.
    rule_neurons
        What Eq. 57 asks for.
    rule
        (4, rule seeds) training, test, fresh and held-out error of a network of that size, all of it trained
        on a share of the poses.
    lottery
        What comes of choosing the size by each of the fresh sets.
    spread
        Mean distance of the truth from its mean over the data [mm].
    """

    training: Array
    test: Array
    fresh: Array
    share: Array
    held_out: Array
    rule_neurons: int
    rule: Array
    lottery: Mapping[str, Choice]
    spread: float


@dataclass(frozen=True)
class Choice:
    """What comes of choosing by a test set of a few points, over many such sets.

    Attributes
    ----------
    counts
        How often each size is chosen, over sets and seeds.
    reported
        First decile, median and last decile of the error on the set that chose, over that on all fresh sets.
    regret
        Median of the error of the chosen network on all fresh sets, over that of the best network.
    """

    counts: tuple[int, ...]
    reported: tuple[float, float, float]
    regret: float


@dataclass(frozen=True)
class Result:
    """What training and sizes come to.

    Attributes
    ----------
    sizes
        Hidden neurons that were tried.
    descent
        Both algorithms on one task.
    networks
        Errors by size, of each network.
    rows, poses
        Of the training data.
    """

    sizes: tuple[int, ...]
    descent: Descent
    networks: Mapping[str, Sizes]
    rows: int
    poses: int


def run(config: Config) -> Result:
    """Train by both algorithms, then networks of all sizes, and let test sets choose."""
    data = crane.training_set()
    fresh = _fresh(config)
    return Result(
        sizes=config.sizes,
        descent=_descent(data, config),
        networks={name: _by_size(name, data, fresh, config) for name in NETWORKS},
        rows=len(data),
        poses=len(torch.unique(data.strokes, dim=0)),
    )


# ---- two ways to train -----------------------------------------------------------------------------


def _descent(data: crane.TrainingSet, config: Config) -> Descent:
    x, y = data.rows[:, :4], data.deflection
    starts = [_untrained(_printed_neurons("correction"), x, y, seed) for seed in config.seeds]
    trainings = levenberg_marquardt(starts, x, y, Options(epochs=config.epochs))
    passes = {BATCH: config.batch_passes, SOME: config.some_passes, PATTERN: config.pattern_passes}
    told = {mode: _told(passes[mode]) for mode in MODES}
    return Descent(
        second_order=np.stack([_padded(training.history, config.epochs + 1) for training in trainings]),
        passes={mode: moments.astype(np.float64) for mode, moments in told.items()},
        first_order={
            mode: _back_propagation(starts, x, y, MODES[mode], told[mode], config.seeds[0]) for mode in MODES
        },
        seconds=_seconds(starts[0], x, y, config) if config.timed else {},
        parameters=sum(weights.numel() for weights in starts[0].parameters()),
        gradient_error=_gradient_error(starts[0], x, y),
    )


def _untrained(neurons: int, x: Tensor, y: Tensor, seed: int) -> FeedForward:
    return FeedForward.untrained(_SEES, neurons, x, y, torch.Generator().manual_seed(seed))


def _padded(history: Sequence[float], length: int) -> Array:
    """Root mean square distances [mm] of two coordinates; a training that stopped stays where it is."""
    squares = np.array([*history, *[history[-1]] * (length - len(history))])
    return 1e3 * np.sqrt(2 * squares)


def _told(passes: int) -> NDArray[np.int64]:
    """Return passes after which an error is told: every one at first, then ever fewer."""
    return np.unique(np.append(0, np.geomspace(1, passes, 40).round())).astype(np.int64)


class _Stack(torch.nn.Module):
    """Networks of one size with a gain each, which one optimiser trains side by side."""

    hidden_weights: Tensor
    hidden_biases: Tensor
    output_weights: Tensor
    output_biases: Tensor

    def __init__(self, networks: Sequence[FeedForward], gains: Sequence[float]) -> None:
        super().__init__()
        self.gain = torch.tensor(gains, dtype=torch.float64).repeat(len(networks))
        first = networks[0]
        self.centre, self.half_range = first.input_centre, first.input_half_range
        self.target_centre, self.target_half = first.target_centre, first.target_half_range
        for name in ("hidden_weights", "hidden_biases", "output_weights", "output_biases"):
            stacked = torch.stack([getattr(network, name).detach() for network in networks])
            self.register_parameter(name, torch.nn.Parameter(stacked.repeat_interleave(len(gains), dim=0)))

    def scaled(self, x: Tensor, y: Tensor) -> tuple[Tensor, Tensor]:
        """Scale inputs and targets as the networks have them."""
        return (x - self.centre) / self.half_range, (y - self.target_centre) / self.target_half

    def squares(self, x: Tensor, y: Tensor) -> Tensor:
        """Squared distances (B, rows) of scaled outputs from scaled targets."""
        hidden = torch.tanh(x @ self.hidden_weights.mT + self.hidden_biases[:, None])
        return (hidden @ self.output_weights.mT + self.output_biases[:, None] - y).square().sum(-1)

    def error(self, x: Tensor, y: Tensor) -> Tensor:
        """Root mean square distance (B) [mm]; infinite if it is not finite."""
        with torch.no_grad():
            error = 1e3 * self.target_half * self.squares(x, y).mean(-1).sqrt()
        return torch.where(error.isfinite(), error, torch.inf)


def _back_propagation(
    networks: Sequence[FeedForward], x: Tensor, y: Tensor, at_once: int, told: NDArray[np.int64], seed: int
) -> Array:
    """Train by Eqs. 49 to 54 with each gain; return errors (networks, gains, told)."""
    stack = _Stack(networks, _GAINS)
    x, y = stack.scaled(x, y)
    descend = _descender(stack)
    random = torch.Generator().manual_seed(seed)
    errors = [stack.error(x, y)]
    for number in range(1, told[-1] + 1):
        _pass(descend, x, y, at_once, random)
        if number in told:
            errors.append(stack.error(x, y))
    return torch.stack(errors, dim=-1).reshape(len(networks), len(_GAINS), -1).numpy()


_Descend: TypeAlias = "partial[None]"


def _descender(stack: _Stack) -> _Descend:
    # A gain on the error is a gain on the step, momentum included, so that one optimiser serves them all.
    optimiser = torch.optim.SGD(stack.parameters(), lr=1.0, momentum=_MOMENTUM)
    return partial(_step, stack, optimiser)


def _step(stack: _Stack, optimiser: torch.optim.Optimizer, x: Tensor, y: Tensor) -> None:
    """Go down the gradient of Eq. 49, which is averaged over the rows that are seen at once."""
    optimiser.zero_grad()
    (stack.gain * stack.squares(x, y).mean(-1) / 2).sum().backward()
    optimiser.step()


def _pass(descend: _Descend, x: Tensor, y: Tensor, at_once: int, random: torch.Generator) -> None:
    if not at_once:
        descend(x, y)
        return
    for rows in torch.randperm(len(x), generator=random).split(at_once):
        descend(x[rows], y[rows])


def _gradient_error(network: FeedForward, x: Tensor, y: Tensor) -> float:
    """Compare Eqs. 51 to 53 with torch, for one row; with a linear output the factor y(1 − y) is 1."""
    stack = _Stack([network], [1.0])
    inputs, targets = stack.scaled(x[:1], y[:1])
    (stack.squares(inputs, targets).sum() / 2).backward()
    weights = {name: value.detach()[0] for name, value in stack.named_parameters()}
    hidden = torch.tanh(weights["hidden_weights"] @ inputs[0] + weights["hidden_biases"])
    output = weights["output_weights"] @ hidden + weights["output_biases"]
    delta = targets[0] - output
    delta_hidden = (1 - hidden.square()) * (delta @ weights["output_weights"])
    written = {
        "hidden_weights": delta_hidden[:, None] * inputs[0], "hidden_biases": delta_hidden,
        "output_weights": delta[:, None] * hidden, "output_biases": delta,
    }  # fmt: skip
    misses = [(value + getattr(stack, name).grad[0]).abs().max() for name, value in written.items()]
    return max(miss.item() for miss in misses)


def _seconds(network: FeedForward, x: Tensor, y: Tensor, config: Config) -> dict[str, float]:
    """Measure an epoch, and a pass of each mode, of one network on one core."""
    epochs = min(config.epochs, 20)
    ways = [
        timing.Way(
            LEVENBERG_MARQUARDT, partial(levenberg_marquardt, network, x, y, Options(epochs=epochs)), epochs
        )
    ]
    # Row by row, a tenth of the rows takes a tenth of the time.
    parts = {mode: 10 if at_once == 1 else 1 for mode, at_once in MODES.items()}
    for mode, at_once in MODES.items():
        stack = _Stack([network], [1e-6])
        scaled = stack.scaled(x[:: parts[mode]], y[:: parts[mode]])
        random = torch.Generator().manual_seed(0)
        ways.append(timing.Way(mode, partial(_pass, _descender(stack), *scaled, at_once, random), 1))
    found = timing.measure(ways, rounds=5, seconds=0.1)
    return {own.name: parts.get(own.name, 1) * own.median for own in found}


# ---- sizes -----------------------------------------------------------------------------------------


@dataclass(frozen=True)
class _Fresh:
    """Poses (N, 3) with payloads (N), N being sets × points × payloads; the first set is the thesis's."""

    inputs: Tensor
    deflection: Tensor
    tip: Tensor


def _fresh(config: Config) -> _Fresh:
    """Points in the working area as the thesis reaches them, with the least extension and its payloads."""
    points = [torch.tensor(crane.TEST_POINTS, dtype=torch.float64), *_drawn_points(config)]
    strokes = crane.inverse(torch.cat(points)).strokes.repeat_interleave(len(crane.TEST_PAYLOADS), dim=0)
    payload = torch.tensor(crane.TEST_PAYLOADS, dtype=torch.float64).repeat(sum(map(len, points)))
    sag = crane.deflection(strokes, payload)
    return _Fresh(torch.cat([strokes, payload[:, None]], dim=-1), sag, crane.tip_position(strokes) + sag)


def _drawn_points(config: Config) -> list[Tensor]:
    """Draw points that the rigid crane reaches, ahead of its pillar."""
    random = np.random.default_rng(config.fresh_seed)
    wanted, found = config.sets * len(crane.TEST_POINTS), torch.zeros(0, 2, dtype=torch.float64)
    while len(found) < wanted:
        drawn = torch.from_numpy(random.uniform((0.0, -4.2), (6.6, 7.8), size=(wanted, 2)))
        found = torch.cat([found, drawn[crane.inverse(drawn).within_limits]])
    return [found[:wanted]]


def _by_size(name: str, data: crane.TrainingSet, fresh: _Fresh, config: Config) -> Sizes:
    x = data.rows[:, :4]
    y, truth = (data.deflection, fresh.deflection) if name == "correction" else (data.tip, fresh.tip)
    sets = _per_set(fresh)
    all_rows, share = [], []
    errors = np.zeros((len(config.sizes), len(config.seeds), sets))
    for i, neurons in enumerate(config.sizes):
        whole = _trained(neurons, x, y, config.epochs, config.seeds)
        all_rows.append([_distance(network, x, y).mean().item() for network in whole])
        errors[i] = [_set_errors(network, fresh.inputs, truth, sets) for network in whole]
        share.append([_held_out(neurons, x, y, config, seed)[1:] for seed in config.seeds])
    by_share = np.array(share).transpose(2, 0, 1)
    rule_neurons = round(_size_rule(len(data), 4, 2))
    return Sizes(
        training=np.array(all_rows),
        test=errors[..., 0],
        fresh=errors[..., 1:].mean(-1),
        share=by_share[0],
        held_out=by_share[1],
        rule_neurons=rule_neurons,
        rule=_of_the_rule(rule_neurons, x, y, fresh, truth, config),
        lottery=_lotteries(errors[..., 1:]),
        spread=1e3 * (y - y.mean(0)).norm(dim=-1).mean().item(),
    )


def _trained(neurons: int, x: Tensor, y: Tensor, epochs: int, seeds: Sequence[int]) -> list[FeedForward]:
    starts = [_untrained(neurons, x, y, seed) for seed in seeds]
    return [training.network for training in levenberg_marquardt(starts, x, y, Options(epochs=epochs))]


def _held_out(
    neurons: int, x: Tensor, y: Tensor, config: Config, seed: int
) -> tuple[FeedForward, float, float]:
    """Train on a share of the poses; return the network, and its errors on these and on the others [mm]."""
    out = _out(x, config.held_out, seed)
    (network,) = _trained(neurons, x[~out], y[~out], config.epochs, [seed])
    inside, outside = (_distance(network, x[rows], y[rows]).mean().item() for rows in (~out, out))
    return network, inside, outside


def _out(x: Tensor, share: float, seed: int) -> Tensor:
    """Tell which rows (N) are held out: whole poses, since rows of one pose differ by the payload alone."""
    poses, pose = torch.unique(x[:, :3], dim=0, return_inverse=True)
    order = torch.randperm(len(poses), generator=torch.Generator().manual_seed(10_000 + seed))
    out = torch.zeros(len(poses), dtype=torch.bool)
    out[order[: round(share * len(poses))]] = True
    return out[pose]


def _distance(network: FeedForward, x: Tensor, y: Tensor) -> Tensor:
    """Distances (N) of answers from the truth [mm]."""
    with torch.no_grad():
        return 1e3 * (network(x) - y).norm(dim=-1)


def _per_set(fresh: _Fresh) -> int:
    return len(fresh.inputs) // (len(crane.TEST_POINTS) * len(crane.TEST_PAYLOADS))


def _set_errors(network: FeedForward, x: Tensor, y: Tensor, sets: int) -> Array:
    return _distance(network, x, y).reshape(sets, -1).mean(-1).numpy()


def _of_the_rule(neurons: int, x: Tensor, y: Tensor, fresh: _Fresh, truth: Tensor, config: Config) -> Array:
    rows = []
    for seed in config.seeds[: config.rule_seeds]:
        network, training, held_out = _held_out(neurons, x, y, config, seed)
        by_set = _set_errors(network, fresh.inputs, truth, _per_set(fresh))
        rows.append((training, by_set[0], by_set[1:].mean(), held_out))
    return np.array(rows).T


ONE, ALL = "one training a size", "the best of all trainings"


def _lotteries(errors: Array) -> dict[str, Choice]:
    """Let each fresh set choose, from errors (sizes, seeds, sets): the size for a seed, or size and seed."""
    sizes, seeds, sets = errors.shape
    truth = errors.mean(-1)
    by_seed = np.broadcast_to(errors.argmin(0)[..., None], (seeds, sets, 1))[..., 0]
    seed = np.broadcast_to(np.arange(seeds)[:, None], (seeds, sets))
    of_all = errors.reshape(sizes * seeds, sets).argmin(0)
    return {
        ONE: _choice(errors, truth, by_seed, seed, truth.min(0)[:, None]),
        ALL: _choice(errors, truth, of_all // seeds, of_all % seeds, truth.min()),
    }


def _choice(
    errors: Array, truth: Array, size: NDArray[np.int64], seed: NDArray[np.int64], best: Array | np.float64
) -> Choice:
    sets = np.broadcast_to(np.arange(errors.shape[-1]), size.shape)
    own = truth[size, seed]
    low, middle, high = np.quantile(errors[size, seed, sets] / own, [0.1, 0.5, 0.9]).tolist()
    return Choice(
        counts=tuple(np.bincount(size.ravel(), minlength=len(errors)).tolist()),
        reported=(low, middle, high),
        regret=float(np.median(own / best)),
    )


# ---- rules -----------------------------------------------------------------------------------------


def _size_rule(rows: int, inputs: int, outputs: int) -> float:
    """Eq. 57: hidden neurons."""
    return rows / (5 * (inputs + outputs))


def _size_bound(weights: int, neurons: int, share: float) -> float:
    """Eq. 58: training vectors for a permitted share of errors."""
    return 32 * weights / share * math.log(32 * neurons / share)


def _permitted(rows: int, weights: int, neurons: int) -> float:
    """Share of errors for which Eq. 58 asks for just so many rows; it may be more than one."""
    return float(brentq(lambda share: _size_bound(weights, neurons, share) - rows, 1e-3, 31.9 * neurons))


def _printed_neurons(name: str) -> int:
    return _sizes_of(NETWORKS[name])[0]


def _sizes_of(claim: str) -> tuple[int, ...]:
    value = load_paper(_PAPER).claim(claim).value
    numbers = value if isinstance(value, tuple) else (value or 0.0,)
    return tuple(round(number) for number in numbers)


def _of_the_thesis() -> dict[str, tuple[int, int, int]]:
    """Return inputs, hidden neurons and outputs of each of the thesis's networks."""
    rigid, rest, outputs = _sizes_of("crane-modular-neurons")
    return {
        "correction": (4, _printed_neurons("correction"), 2),
        "direct": (4, _printed_neurons("direct"), 2),
        "modular, rigid": (3, rigid, outputs),
        "modular, rest": (4, rest, outputs),
        "inverse": (4, _sizes_of("crane-inverse-neurons")[0], 2),
    }


# ---- tables ----------------------------------------------------------------------------------------


def history(result: Result, name: str) -> tuple[Array, Array]:
    """Return times [s], or passes if no times were taken, and errors (seeds, times) [mm] of a training.

    Back-propagation has the gain that is best in the end. An epoch of Levenberg–Marquardt counts as two
    passes: one for the normal equations, one for the step that is tried.

    Parameters
    ----------
    result
        What was trained.
    name
        `LEVENBERG_MARQUARDT` or one of `MODES`.
    """
    descent = result.descent
    if name == LEVENBERG_MARQUARDT:
        passes, errors = 2.0 * np.arange(descent.second_order.shape[1]), descent.second_order
        return passes * descent.seconds.get(name, 2.0) / 2, errors
    ends = np.median(descent.first_order[name][..., -1], axis=0)
    errors = descent.first_order[name][:, int(ends.argmin())]
    return descent.passes[name] * descent.seconds.get(name, 1.0), errors


def _at(result: Result, name: str, time: float) -> Array:
    """Errors (seeds) [mm] that a training has after a time, or in the end if that is sooner."""
    if name == LEVENBERG_MARQUARDT:
        times, errors = history(result, name)
        return errors[:, min(int(np.searchsorted(times, time)), len(times) - 1)]
    descent = result.descent
    times = descent.passes[name] * descent.seconds.get(name, 1.0)
    there = descent.first_order[name][..., min(int(np.searchsorted(times, time)), len(times) - 1)]
    return there[:, int(np.median(there, axis=0).argmin())]


def _whole(result: Result) -> float:
    """Time that all epochs of Levenberg–Marquardt take."""
    return float(history(result, LEVENBERG_MARQUARDT)[0][-1])


def equal_time_table(result: Result) -> dict[str, dict[str, str]]:
    """Errors [mm] after a tenth of the time of Levenberg–Marquardt, after all of it, and in the end."""
    whole, seconds = _whole(result), result.descent.seconds
    rows = {}
    for name in (LEVENBERG_MARQUARDT, *MODES):
        last = _whole(result) if name == LEVENBERG_MARQUARDT else float(history(result, name)[0][-1])
        rows[name] = {
            "a pass or epoch [ms]": f"{1e3 * seconds[name]:.2g}" if seconds else "–",
            "after a tenth of the time": with_range(_at(result, name, whole / 10), "{:.2f}".format),
            "after the same time": with_range(_at(result, name, whole), "{:.2f}".format),
            "in the end": with_range(_at(result, name, math.inf), "{:.2f}".format),
            "which is after": f"{last / whole:.2g} times as long",
        }
    return rows


def memory_table(result: Result) -> dict[str, dict[str, int]]:
    """Numbers that each way keeps besides the data and the weights."""
    size, neurons = result.descent.parameters, _printed_neurons("correction")
    return {
        "back-propagation, row by row": {"numbers": 2 * size + neurons + 2},
        "back-propagation, all rows at once": {"numbers": 2 * size + result.rows * (neurons + 2)},
        "Levenberg–Marquardt, sums alone": {"numbers": 2 * size**2 + 2 * size},
        "Levenberg–Marquardt, Jacobian kept": {"numbers": 2 * result.rows * size + 2 * size**2 + 2 * size},
    }


def size_table(result: Result, name: str) -> dict[str, dict[str, str]]:
    """Mean distances [mm] by the number of neurons, over the seeds."""
    own = result.networks[name]
    columns = {
        "training data": own.training, "test points": own.test, "fresh points": own.fresh,
        "held-out poses": own.held_out,
    }  # fmt: skip
    rows = {
        str(neurons): {column: with_range(errors[i], "{:.2f}".format) for column, errors in columns.items()}
        for i, neurons in enumerate(result.sizes)
    }
    rows[f"{own.rule_neurons} (Eq. 57)"] = {
        column: with_range(errors, "{:.2f}".format) for column, errors in zip(columns, own.rule, strict=True)
    }
    return rows


def choice_table(result: Result) -> dict[str, dict[str, str]]:
    """Tell what comes of choosing sizes by the thesis's test, by held-out poses, and by other 25 points."""
    rows = {}
    for name, own in result.networks.items():
        seeds = np.arange(own.test.shape[1])
        for label, chooser in (("test points", own.test), ("held-out poses", own.held_out)):
            size = chooser.argmin(0)
            rows[f"{name}, by {label}"] = {
                "neurons": with_range([result.sizes[i] for i in size], "{:.0f}".format),
                "reported [mm]": with_range(chooser[size, seeds], "{:.2f}".format),
                "on fresh points [mm]": with_range(own.fresh[size, seeds], "{:.2f}".format),
                "over the best there is": f"{_regret(own, chooser):.2f}",
            }
        for label, choice in own.lottery.items():
            low, middle, high = choice.reported
            often = [result.sizes[i] for i, count in enumerate(choice.counts) for _ in range(count)]
            rows[f"{name}, by other 25 points, {label}"] = {
                "neurons": with_range(often, "{:.0f}".format),
                "reported [mm]": f"{middle:.2f} ({low:.2f}–{high:.2f}) of the next column",
                "on fresh points [mm]": "–",
                "over the best there is": f"{choice.regret:.2f}",
            }
    return rows


def rule_table(result: Result) -> dict[str, dict[str, float]]:
    """Evaluate Eqs. 57 and 58 for the thesis's networks."""
    rows = {}
    for name, (inputs, neurons, outputs) in _of_the_thesis().items():
        count = result.poses if inputs == 3 else result.rows
        weights = neurons * (inputs + outputs)
        rows[name] = {
            "neurons of the thesis": neurons,
            "different rows": count,
            "neurons by Eq. 57": round(_size_rule(result.rows, inputs, outputs)),
            "by Eq. 57, counting poses": round(_size_rule(result.poses, inputs, outputs)),
            "rows by Eq. 58, a tenth wrong": round(_size_bound(weights, neurons, 0.1)),
            "share wrong for these rows": _permitted(result.rows, weights, neurons),
        }
    return rows


# ---- verdicts --------------------------------------------------------------------------------------


def verdicts(result: Result) -> tuple[Verdict, ...]:
    """Judge the claims of the ledger that this study answers for."""
    return (_on_training(result), _on_choosing(result), _on_rule(result), _on_bound(result))


def _on_training(result: Result) -> Verdict:
    whole = _whole(result)
    second, first = (_at(result, LEVENBERG_MARQUARDT, whole), _best_first_order(result, whole))
    later = _best_first_order(result, math.inf)
    memory = {name: row["numbers"] for name, row in memory_table(result).items()}
    more = memory["Levenberg–Marquardt, Jacobian kept"] / memory["back-propagation, all rows at once"]
    if (second < first).all() and more > 1:
        outcome = Outcome.REPRODUCED
    else:
        outcome = Outcome.IN_SHAPE if np.median(second) < np.median(first) else Outcome.NOT_REPRODUCED
    return _verdict(
        "crane-lm-is-better", outcome,
        f"Left after the same {'time' if result.descent.seconds else 'passes'} is "
        f"{with_range(second, '{:.2f}'.format)} mm, against {with_range(first, '{:.2f}'.format)} mm by the "
        f"best back-propagation, and {with_range(later, '{:.2f}'.format)} mm if that goes on. With the "
        f"Jacobian kept it needs {more:.0f} times the numbers of back-propagation in a batch; summed up row "
        f"by row it needs {memory['Levenberg–Marquardt, sums alone']:,} numbers, whatever the data.",
        f"{np.median(first / second):.1f} times less error", "in the same time, median over the seeds",
    )  # fmt: skip


def _best_first_order(result: Result, time: float) -> Array:
    """Errors (seeds) of the mode of back-propagation that is best after a time."""
    candidates = [_at(result, mode, time) for mode in MODES]
    return min(candidates, key=lambda errors: float(np.median(errors)))


def _on_choosing(result: Result) -> Verdict:
    beyond = {name: _beyond_the_least(result, name) for name in NETWORKS}
    outcome = (Outcome.NOT_REPRODUCED, Outcome.IN_SHAPE, Outcome.REPRODUCED)[
        sum(ratio <= 1.1 for ratio in beyond.values())
    ]
    least = {name: result.sizes[_median(result.networks[name].test).argmin()] for name in NETWORKS}
    lucky = {name: own.lottery[ALL].reported[1] for name, own in result.networks.items()}
    regret = {name: own.lottery[ONE].regret for name, own in result.networks.items()}
    held_out = {name: _regret(own, own.held_out) for name, own in result.networks.items()}
    larger = {
        name: float(np.median(own.rule[1]) / _median(own.test).min()) for name, own in result.networks.items()
    }
    neurons = max(own.rule_neurons for own in result.networks.values())
    return _verdict(
        "crane-size-by-test-error", outcome,
        f"Of the sizes tried, up to {max(result.sizes)}, the test error is least with {_both(least, '{}')} "
        f"neurons; with {neurons} it is {_both(larger, '{:.2f}')} times that. A size chosen by 25 points has "
        f"{_both(regret, '{:.2f}')} times the error on fresh points of the best size, one chosen by "
        f"held-out poses {_both(held_out, '{:.2f}')}. But the best of all trainings by 25 points is "
        f"reported with {_both(lucky, '{:.2f}')} of its error elsewhere.",
        _both(beyond, "{:.2f}"), "test error with the thesis's size over the least, medians over the seeds",
    )  # fmt: skip


def _regret(own: Sizes, chooser: Array) -> float:
    """Error on fresh points of the size that a seed's errors choose, over that of its best size; median."""
    seeds = np.arange(own.fresh.shape[1])
    return float(np.median(own.fresh[chooser.argmin(0), seeds] / own.fresh.min(0)))


def _beyond_the_least(result: Result, name: str) -> float:
    """Test error of the size nearest to the thesis's, over the least one; medians over the seeds."""
    median = _median(result.networks[name].test)
    return float(median[_nearest(result, name)] / median.min())


def _nearest(result: Result, name: str) -> int:
    return int(np.abs(np.array(result.sizes) - _printed_neurons(name)).argmin())


def _on_rule(result: Result) -> Verdict:
    outcomes, ratios = [], {}
    for name, own in result.networks.items():
        ours, least = float(np.median(own.rule[3])), _median(own.held_out)
        ratios[name] = ours / least[_nearest(result, name)]
        if ours <= 1.1 * least.min():
            outcomes.append(Outcome.REPRODUCED)
        else:
            outcomes.append(Outcome.IN_SHAPE if ratios[name] < 1 else Outcome.NOT_REPRODUCED)
    order = [Outcome.NOT_REPRODUCED, Outcome.IN_SHAPE, Outcome.REPRODUCED]
    neurons = {name: own.rule_neurons for name, own in result.networks.items()}
    printed = {name: _printed_neurons(name) for name in NETWORKS}
    poses = round(_size_rule(result.poses, 4, 2))
    return _verdict(
        "crane-size-rule", min(outcomes, key=order.index),
        f"It asks for {_both(neurons, '{}')} neurons where the thesis has {_both(printed, '{}')}. Counting "
        f"poses, since rows of one pose differ by a payload that acts linearly, it asks for {poses}.",
        _both(ratios, "{:.2f}"), "held-out error with its size over that with the thesis's",
    )  # fmt: skip


def _on_bound(result: Result) -> Verdict:
    shares = {name: row["share wrong for these rows"] for name, row in rule_table(result).items()}
    off = {
        name: float(_median(own.held_out)[_nearest(result, name)] / own.spread)
        for name, own in result.networks.items()
    }
    wrong = min(shares.values()) > 1 and max(off.values()) < 0.1
    return _verdict(
        "crane-size-bound", Outcome.CONTRADICTED if wrong else Outcome.NOT_REPRODUCED,
        f"None of the thesis's networks meets it: their rows would do for a share of errors of "
        f"{min(shares.values()):.1f} to {max(shares.values()):.1f}, which is more than all. They answer "
        f"held-out poses all the same, with errors of {_both(off, '{:.2g}')} of the spread. The bound is "
        "meant for answers of yes and no, and for the worst of all tasks.",
        f"{min(shares.values()):.1f} to {max(shares.values()):.1f}", "share of errors for these rows",
    )  # fmt: skip


def _median(errors: Array) -> Array:
    return np.median(errors, axis=1)


def _both(values: Mapping[str, float], form: str) -> str:
    return ", ".join(f"{form.format(value)} ({name})" for name, value in values.items())


def acceptance(result: Result) -> tuple[Acceptance, ...]:
    """Figures that must hold for the book to be built."""
    return (
        Acceptance("gradient written out from torch's", result.descent.gradient_error, 1e-12),
        Acceptance("training rows less those of the thesis", abs(result.rows - _printed_rows()), 0),
    )


def _printed_rows() -> int:
    value = load_paper(_PAPER).claim("crane-training-vectors").value
    return 0 if isinstance(value, tuple) or value is None else round(value)


def _verdict(claim: str, outcome: Outcome, sentence: str, ours: str = "", spread: str = "") -> Verdict:
    return Verdict(_PAPER, claim, outcome, ours, spread, sentence)
