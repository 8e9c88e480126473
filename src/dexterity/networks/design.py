"""The design loops of Sotiropoulos & Aspragathos (2016): one run, or many at the same time.

Hidden neurons are added one at a time until a network passes the test. The loop of radial-basis networks,
Fig. 6b, is offered here too; it lives in :mod:`dexterity.networks.radial_basis_design`.

Examples
--------
>>> import dexterity as dx
>>> from dexterity.networks import design, network, problem
>>> w = dx.indices.Index("manipulability").bind(dx.robots.uvms())
>>> data = dx.sampling.data_sets(
...     w, dx.sampling.uvms_space("manipulability"), train=200, test=100
... )
>>> learned = problem.DesignProblem(network.View(12, [4, 5, 6, 7, 8, 9, 10]), data)
>>> design.design_feed_forward(learned, progress=False).success
True
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import get_args

import joblib
import numpy as np
from tqdm import tqdm

from dexterity import checks
from dexterity.networks import train
from dexterity.networks.feed_forward import READOUTS, FeedForward, Readout
from dexterity.networks.growth import RadialBasisOptions
from dexterity.networks.levenberg_marquardt import Damping, Options, Stop, Training
from dexterity.networks.network import device_name
from dexterity.networks.problem import DesignProblem, End, Sweep, collected, largest_relative_error
from dexterity.networks.radial_basis_design import RadialBasisDesign, design_radial_basis
from dexterity.networks.rounding import is_sound
from dexterity.networks.threads import one_thread

__all__ = [
    "Design",
    "End",
    "FeedForwardOptions",
    "RadialBasisDesign",
    "RadialBasisOptions",
    "Trial",
    "design_all",
    "design_feed_forward",
    "design_radial_basis",
]


@dataclass(frozen=True)
class FeedForwardOptions:
    """Parameters of the design loop; the defaults are those of the paper's network for w.

    Attributes
    ----------
    testing_error
        E: a network is accepted when its largest relative error on the test set is at most this, and no more
        than a thousandth of it can be rounding.
    training_goal
        :math:`E_{mse}`: mean square error at which a training ends, in units of what is trained on: the
        index itself unless the readout says otherwise.
    neuron_limit
        :math:`L_{iter}`: largest number of neurons.
    first_neurons, neuron_step
        Size that the loop begins with, and how many neurons it adds at a time; 1 and 1 as printed.
    epoch_limit
        :math:`L_{epochs}`: largest number of steps of a training.
    restarts
        Networks of each size, from different initial weights; they are trained together, and the one with
        the smallest testing error stands for its size.
    damping
        Rule of the trainer.
    readout
        How the value is read from the output layer.
    seed
        Of the initial weights, not negative.
    sweep
        Whether to end at the first size that passes or to go through all.

    Raises
    ------
    ValueError
        If a number is out of its range or a name is unknown.

    References
    ----------
    Sotiropoulos & Aspragathos (2016), Table 3 and section 3.3.
    """

    testing_error: float = 0.02
    training_goal: float = 1e-3
    neuron_limit: int = 100
    first_neurons: int = 1
    neuron_step: int = 1
    epoch_limit: int = 100
    restarts: int = 1
    damping: Damping = "gain_ratio"
    readout: Readout = "identity"
    seed: int = 0
    sweep: Sweep = "first"

    def __post_init__(self) -> None:
        checks.fields(
            self,
            testing_error=checks.Real(least=0),
            training_goal=checks.Real(least=0),
            **dict.fromkeys(("epoch_limit", "first_neurons", "neuron_step", "restarts"), checks.Whole(1)),
            neuron_limit=checks.Whole(1),
            damping=checks.Choice(get_args(Damping)),
            seed=checks.Whole(0),
            readout=checks.Choice(tuple(READOUTS)),
            sweep=checks.Choice(get_args(Sweep)),
        )
        if self.neuron_limit < self.first_neurons:
            raise ValueError(
                f"neuron_limit is {self.neuron_limit}; at least {self.first_neurons}, the first, is needed"
            )

    @property
    def sizes(self) -> range:
        """Numbers of neurons that are tried in turn."""
        return range(self.first_neurons, self.neuron_limit + 1, self.neuron_step)

    def training(self) -> Options:
        """Return the options of each training."""
        return Options(goal=self.training_goal, epochs=self.epoch_limit, damping=self.damping)


@dataclass(frozen=True)
class Trial:
    """One network that was trained, in the order of a table's columns.

    Attributes
    ----------
    neurons
        Hidden neurons.
    restart
        Which of the networks of this size, from 0.
    seed
        What its initial weights were drawn from.
    mean_square_error
        Over the training set, Eq. 19.
    epochs, stop
        How many steps were tried, and why the training ended.
    testing_error
        Largest relative error on the test set, Eq. 21, by which the loop decides.
    validation_error
        The same on the validation set, which the loop does not look at.
    history
        (epochs + 1) mean square errors.
    seconds
        How long the trainings of this size took together [s]; no part of what trials are compared by.
    """

    neurons: int
    restart: int
    seed: int
    mean_square_error: float
    epochs: int
    stop: Stop
    testing_error: float
    validation_error: float
    history: tuple[float, ...] = field(repr=False)
    seconds: float = field(compare=False)


@dataclass(frozen=True)
class Design:
    """What a design loop found; two are equal when their trials are.

    Attributes
    ----------
    network
        The smallest network that passed; if none did, that with the smallest testing error.
    best
        Its trial.
    end
        Why the loop ended.
    trials
        All trials by size, and by restart within a size.
    """

    network: FeedForward = field(compare=False)
    best: Trial
    end: End
    trials: tuple[Trial, ...] = field(repr=False)

    @property
    def success(self) -> bool:
        """Whether a network passed."""
        return self.end is End.PASSED


@checks.arguments(
    device=device_name,
    problem=checks.Instance(DesignProblem),
    options=checks.Instance(FeedForwardOptions),
    progress=checks.Flag(),
)
def design_feed_forward(
    problem: DesignProblem,
    options: FeedForwardOptions = FeedForwardOptions(),
    *,
    device: str = "cpu",
    progress: bool = True,
) -> Design:
    """Train networks of one neuron, two, and so on, until one passes.

    An interrupt from the keyboard ends the loop and returns what there is so far.

    Parameters
    ----------
    problem
        What to learn.
    options
        When to stop, and how to train.
    device
        Where to train, such as ``"cuda"``; the networks come back to the processor.
    progress
        Whether to show a bar on stderr.

    Returns
    -------
    The design. A test that no network passes is no error: see `Design.end`.

    Raises
    ------
    ValueError
        If the readout does not fit the values, or an input does not vary in the training set.
    KeyboardInterrupt
        If there is nothing so far.

    References
    ----------
    Sotiropoulos & Aspragathos (2016), section 3.3, Fig. 6a, Table 3.
    """
    found = _Loop(problem, options, device).sizes()
    return _design(*collected(found, len(options.sizes), "size", progress))


@checks.arguments(
    device=device_name,
    runs=checks.Each(checks.Instance(tuple)),
    n_jobs=checks.Whole(),
    progress=checks.Flag(),
)
def design_all(
    runs: Sequence[tuple[DesignProblem, FeedForwardOptions]],
    *,
    n_jobs: int = 1,
    device: str = "cpu",
    progress: bool = True,
) -> tuple[Design, ...]:
    """Do several designs at the same time, such as one for each of many seeds.

    Parameters
    ----------
    runs
        Problems with their options. Where a run goes through all sizes, each size is a job of its own.
    n_jobs
        Jobs that joblib does at the same time, in its current backend: processes of this machine, or those
        of a cluster under ``joblib.parallel_config("dask")``. The result does not depend on it.
    device
        Where to train, such as ``"cuda"``; the networks come back to the processor.
    progress
        Whether to show a bar on stderr.

    Returns
    -------
    The designs in the order of the runs, equal to those of :func:`design_feed_forward`.

    Raises
    ------
    ValueError
        See :func:`design_feed_forward`.
    KeyboardInterrupt
        From the keyboard.
    """
    jobs = [
        (i, neurons)
        for i, (_, options) in enumerate(runs)
        for neurons in (options.sizes if options.sweep == "all" else [None])
    ]
    found: list[list[_Size]] = [[] for _ in runs]
    parallel = joblib.Parallel(n_jobs=n_jobs, return_as="generator")
    loops = [_Loop(problem, options, device) for problem, options in runs]
    results = parallel(joblib.delayed(loops[i].job)(neurons) for i, neurons in jobs)
    for (i, _), sizes in zip(jobs, tqdm(results, total=len(jobs), disable=not progress), strict=True):
        found[i] += sizes
    return tuple(_design(sizes, End.EXHAUSTED) for sizes in found)


# ---- one size --------------------------------------------------------------------------------------


@dataclass(frozen=True)
class _Size:
    """The trials of one size, the network of the best, and whether it passes the test."""

    trials: tuple[Trial, ...]
    network: FeedForward
    passes: bool

    @property
    def best(self) -> Trial:
        return min(self.trials, key=lambda trial: trial.testing_error)

    @property
    def interrupted(self) -> bool:
        return any(trial.stop is Stop.INTERRUPTED for trial in self.trials)


@dataclass(frozen=True)
class _Loop:
    """What the sizes of one design have in common."""

    problem: DesignProblem
    options: FeedForwardOptions
    device: str

    def sizes(self) -> Iterator[_Size]:
        """Yield the sizes in turn, and stop where the loop ends."""
        for neurons in self.options.sizes:
            size = self.size(neurons)
            yield size
            if size.interrupted:
                raise KeyboardInterrupt
            if self.options.sweep == "first" and size.passes:
                return

    def job(self, neurons: int | None) -> list[_Size]:
        """Do one size, or the whole loop if none is given."""
        if neurons is None:
            return list(self.sizes())
        size = self.size(neurons)
        if size.interrupted:
            raise KeyboardInterrupt
        return [size]

    def size(self, neurons: int) -> _Size:
        """Train the networks of one size."""
        rows = self.problem.data.train
        seeds = [_seed(self.options.seed, neurons, restart) for restart in range(self.options.restarts)]
        with one_thread():
            start = time.perf_counter()
            trainings = train.for_seeds(
                self.problem.view,
                neurons,
                rows.q,
                rows.values,
                seeds,
                self.options.training(),
                readout=self.options.readout,
                device=self.device,
            )
            seconds = time.perf_counter() - start
            trials = tuple(
                _trial(self.problem, training, restart, seed, seconds)
                for restart, (training, seed) in enumerate(zip(trainings, seeds, strict=True))
            )
        best = min(range(len(trials)), key=lambda i: trials[i].testing_error)
        return _Size(trials, trainings[best].network, self._passes(trials[best], trainings[best].network))

    def _passes(self, trial: Trial, network: FeedForward) -> bool:
        limit = self.options.testing_error
        # A limit of zero accepts nothing but what is exact, whose rounding is none.
        return trial.testing_error <= limit and (
            limit == 0 or is_sound(network, self.problem.data.test.q, limit)
        )


def _seed(seed: int, neurons: int, restart: int) -> int:
    return int(np.random.SeedSequence([seed, neurons, restart]).generate_state(1, np.uint64)[0] >> 1)


def _trial(problem: DesignProblem, training: Training, restart: int, seed: int, seconds: float) -> Trial:
    return Trial(
        neurons=training.network.neurons,
        restart=restart,
        seed=seed,
        mean_square_error=training.mean_square_error,
        epochs=training.epochs,
        stop=training.stop,
        testing_error=largest_relative_error(training.network, problem.data.test),
        validation_error=largest_relative_error(training.network, problem.data.validation),
        history=training.history,
        seconds=seconds,
    )


# ---- the outcome -----------------------------------------------------------------------------------


def _design(sizes: Sequence[_Size], otherwise: End) -> Design:
    """Return the smallest size that passes, else the size with the smallest test error."""
    passing = [size for size in sizes if size.passes]
    best = passing[0] if passing else min(sizes, key=lambda size: size.best.testing_error)
    end = End.PASSED if passing else otherwise
    return Design(best.network, best.best, end, tuple(trial for size in sizes for trial in size.trials))
