"""A search over sizes and readouts for the smallest network whose worst error keeps a goal.

Sizes are gone through from the smallest. At each size networks with several readouts are trained, and the
validation set decides which stands for the size; a search by ascent then decides whether it keeps the goal. A
readout that falls behind at one size is not tried at the next.

Examples
--------
>>> import torch
>>> from dexterity.networks import ladder, network
>>> from dexterity.sampling import Box
>>> space, effort = Box([-1, -1], [1, 1]), ladder.Effort(sizes=(4, 8), rows=256, epochs=40)
>>> task = ladder.Task(network.View(2, [0, 1]), lambda q: 2 + q[..., 0].sin(), space, goal=0.01)
>>> climbed = ladder.climb(task, effort)
>>> climbed.passed, climbed.best.neurons
(True, 4)
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import TypeAlias

import numpy as np

from dexterity import checks, sampling
from dexterity.networks import train
from dexterity.networks.feed_forward import READOUTS, FeedForward, Readout
from dexterity.networks.levenberg_marquardt import Options, Stop, Training
from dexterity.networks.network import View
from dexterity.networks.rounding import rounding
from dexterity.networks.threads import one_thread
from dexterity.networks.validation import Function, judge
from dexterity.networks.worst_case import Search, worst_case
from dexterity.sampling import DataSet, Space

__all__ = ["Candidate", "Climbed", "Effort", "Report", "Task", "climb"]

Report: TypeAlias = Callable[[str, int, int], None]
"""Is told what was done, how many steps are done, and how many there are at most."""


@dataclass(frozen=True)
class Effort:
    """How much a search for a network may take.

    Attributes
    ----------
    sizes
        Numbers of neurons, in rising order.
    readouts
        Readouts that are tried; by default those that fit the values.
    rows, overhang
        Of the training set, see :func:`dexterity.sampling.sobol`.
    epochs
        Of each training.
    restarts
        Networks of each size and readout.
    validation
        Points that choose among them.
    search
        Effort of the search that decides whether a network keeps the goal.
    seed
        All draws follow from it.

    Raises
    ------
    TypeError, ValueError
        If a number is no number or out of its range, or a readout is unknown.
    """

    sizes: tuple[int, ...] = (4, 8, 12, 20, 30, 45)
    readouts: tuple[Readout, ...] | None = None
    rows: int = 4096
    overhang: float = 0.3
    epochs: int = 120
    restarts: int = 3
    validation: int = 16_384
    search: Search = field(default_factory=lambda: Search(8192, 1024, 64, 60))
    seed: int = 0

    def __post_init__(self) -> None:
        sizes = checks.Each(checks.Whole(1))(self.sizes, "sizes")
        if not sizes or list(sizes) != sorted(set(sizes)):
            raise ValueError(f"sizes is {sizes}; different numbers in rising order are needed")
        object.__setattr__(self, "sizes", sizes)
        if self.readouts is not None:
            readouts = checks.Each(checks.Choice(tuple(READOUTS)))(self.readouts, "readouts")
            if not readouts:
                raise ValueError("readouts is empty; at least one is needed")
            object.__setattr__(self, "readouts", readouts)
        checks.fields(
            self,
            **dict.fromkeys(("rows", "epochs", "restarts", "validation"), checks.Whole(1)),
            overhang=checks.Real(least=0),
            search=checks.Instance(Search),
            seed=checks.Whole(0),
        )


@dataclass(frozen=True)
class Task:
    """What is to be learned, and how well.

    Attributes
    ----------
    view
        What the networks see.
    exact
        The index; torch must be able to differentiate it once.
    space
        Where.
    goal
        Largest error that is wanted.
    scale
        What errors are divided by; the values of the index if none is given.
    """

    view: View
    exact: Function
    space: Space
    goal: float
    scale: float | None = None


@dataclass(frozen=True)
class Candidate:
    """A network that stands for its size and readout.

    Attributes
    ----------
    network
        The network with the smallest validation error among the restarts.
    neurons, readout
        What it is.
    validation_error
        Largest error over the validation set.
    worst_error
        Largest error that the search by ascent found; None where it was not searched.
    single_precision
        Largest difference of answers in single precision.
    sound
        Whether its answers are more than rounding, in double and in single precision.
    """

    network: FeedForward = field(repr=False)
    neurons: int
    readout: Readout
    validation_error: float
    worst_error: float | None
    single_precision: float
    sound: bool

    @property
    def error(self) -> float:
        """Larger of the errors that are known."""
        return max(self.validation_error, self.worst_error or 0.0)


@dataclass(frozen=True)
class Climbed:
    """Outcome of a search.

    Attributes
    ----------
    best
        The smallest network that keeps the goal; if none does, that with the smallest error.
    passed
        Whether it keeps the goal.
    interrupted
        Whether the keyboard ended the search.
    candidates
        All, in the order in which they were trained.
    """

    best: Candidate
    passed: bool
    interrupted: bool
    candidates: tuple[Candidate, ...] = field(repr=False)


@checks.arguments(
    task=checks.Instance(Task), effort=checks.Instance(Effort), report=checks.OrNone(checks.function)
)
def climb(task: Task, effort: Effort, report: Report | None = None) -> Climbed:
    """Go through sizes until a network keeps the goal.

    An interrupt from the keyboard ends the search and returns what there is so far.

    Parameters
    ----------
    task
        What to learn.
    effort
        How much to try.
    report
        Is called after each step.

    Raises
    ------
    ValueError
        If the values do not fit the readouts, or no network has an answer that is more than rounding.
    KeyboardInterrupt
        If there is nothing so far.
    """
    found: list[Candidate] = []
    interrupted = False
    with one_thread():
        try:
            for candidate in _in_turn(task, effort, report):
                # What was searched takes the place of what was trained only.
                found = [one for one in found if one.network is not candidate.network] + [candidate]
                if _keeps(candidate, task.goal):
                    break
        except KeyboardInterrupt:
            interrupted = True
            if not found:
                raise
    sound = [candidate for candidate in found if candidate.sound]
    if not sound:
        raise ValueError("no network was found whose answers are more than rounding")
    best = min(sound, key=lambda candidate: (not _keeps(candidate, task.goal), candidate.error))
    return Climbed(best, _keeps(best, task.goal), interrupted, tuple(found))


PROMISED = 1e-9
"""Largest rounding error of an answer in double precision, relative."""

BEHIND = 1.5
"""A readout whose error is so many times that of the best is not tried at the next size."""


def _keeps(candidate: Candidate, goal: float) -> bool:
    return candidate.sound and candidate.worst_error is not None and candidate.error <= goal


def _in_turn(task: Task, effort: Effort, report: Report | None) -> Iterator[Candidate]:
    train_seed, validation_seed, search_seed = _seeds(effort.seed, 3)
    q = sampling.sobol(task.space, effort.rows, train_seed, effort.overhang)
    rows = DataSet.of(task.exact, q)
    validation = DataSet.of(task.exact, sampling.sobol(task.space, effort.validation, validation_seed))
    readouts: Sequence[Readout] = effort.readouts or _fitting(task, rows, validation)
    done, most = 0, len(effort.sizes) * len(readouts)
    for neurons in effort.sizes:
        tried = []
        for readout in readouts:
            candidate = _trained(task, effort, neurons, readout, rows, validation)
            tried.append(candidate)
            yield candidate
            done += 1
            if report is not None:
                error = candidate.validation_error
                report(f"{neurons} neurons, {readout}: {error:.2g} on the validation set", done, most)
        tried.sort(key=lambda candidate: (not candidate.sound, candidate.validation_error))
        promising = [candidate for candidate in tried if candidate.validation_error <= task.goal]
        # Readouts are in the order of their cost, and the cheapest that keeps the goal will do.
        for candidate in sorted(promising, key=_cost) or tried[:1]:
            yield _searched(task, effort, candidate, search_seed)
        limit = BEHIND * tried[0].validation_error
        readouts = [candidate.readout for candidate in tried if candidate.validation_error <= limit]
        most = done + (len(effort.sizes) - 1 - effort.sizes.index(neurons)) * len(readouts)


def _cost(candidate: Candidate) -> int:
    return list(READOUTS).index(candidate.readout)


def _trained(
    task: Task, effort: Effort, neurons: int, readout: Readout, rows: DataSet, validation: DataSet
) -> Candidate:
    seeds = _seeds(effort.seed, effort.restarts, neurons, sorted(READOUTS).index(readout))
    options = Options(epochs=effort.epochs)
    trainings = train.for_seeds(task.view, neurons, rows.q, rows.values, seeds, options, readout=readout)
    if any(training.stop is Stop.INTERRUPTED for training in trainings):
        raise KeyboardInterrupt
    errors = [_error(task, training, validation) for training in trainings]
    best = int(np.argmin(errors))
    network = trainings[best].network
    found = rounding(network, validation.q[:2048])
    # A tenth of the error, so that what is said of the network is true in single precision as well.
    sound = found.double <= PROMISED and found.single <= 0.1 * max(task.goal, errors[best])
    return Candidate(network, neurons, readout, errors[best], None, found.single, sound)


def _error(task: Task, training: Training, validation: DataSet) -> float:
    """Largest error of the network that a training returns."""
    try:
        return judge(training.network, validation, task.scale).maximum
    except ValueError:  # an answer that is not finite
        return math.inf


def _searched(task: Task, effort: Effort, candidate: Candidate, seed: int) -> Candidate:
    if candidate.validation_error == math.inf:
        return candidate
    worst = worst_case(candidate.network, task.exact, task.space, effort.search, seed, task.scale)
    return Candidate(**{**vars(candidate), "worst_error": worst.error})


def _fitting(task: Task, *sets: DataSet) -> tuple[Readout, ...]:
    """Readouts that have targets for the values, and that suit what errors are divided by."""
    if task.scale is not None or min(float(data.values.min()) for data in sets) <= 0:
        return ("identity",)
    return ("identity", "logarithm", "cone", "triple")


def _seeds(*numbers: int) -> list[int]:
    """As many seeds as the second number says; they follow from all the other numbers."""
    seed, count, *further = numbers
    states = np.random.SeedSequence([seed, *further]).generate_state(count, np.uint64)
    return [int(state >> np.uint64(2)) for state in states]
