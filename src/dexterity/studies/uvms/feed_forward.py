"""Paper A, sections 3.2–4.4: feed-forward networks for w and KCI, and the loop that chooses their size.

Sotiropoulos & Aspragathos (2016), Eqs. 13–16 and 19–21, Figs. 6a, 10, 11, 14 and 15, Table 3. The loop is run
as printed, with each seed drawing its own data and initial weights. Beside it all sizes are trained on,
without the goal that ends the paper's trainings, and networks of the paper's sizes are judged on fresh
configurations that no loop has seen.

As printed means the damping rule of the paper's toolbox and its goal; trained on means the gain-ratio rule
and no goal. All errors are relative, Eq. 21, and E is the paper's limit for them. Thresholds: a formula is
*reproduced* if this package agrees with it, written out, to ten digits, and the limits of damping if the
steps agree within a per cent. That the loop finds the smallest network is *reproduced* if it ends with the
same number of neurons at every seed, *in shape* if the numbers differ by at most a quarter of their median.
A printed number of neurons is *reproduced* if the median of ours equals it, *in shape* within a quarter. A
printed error bound is *reproduced* if the median over the seeds of networks of the printed size, trained as
printed, keeps it on the test set, *in shape* if that of networks trained on does. That four and five neurons
are good is *reproduced* if their median error is within E; that six and seven are worse than eight if it
holds of the medians as long as four and five are also better than both, *in shape* if only the first holds.
Initial weights decide if among restarts on the same data the worst testing error is at least twice the best,
*in shape* from one and a quarter. Eight neurons generalise better if no larger network has a smaller median
error on fresh points, which is *contradicted* if all have. Training time grows if it rises with the rows for
each number of neurons tried and with the neurons for each number of rows, *in shape* if it does from end to
end.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence, Sized
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from dexterity import robots, sampling, symbolic, timing
from dexterity.indices import Index
from dexterity.networks.design import Design, FeedForwardOptions, design_all
from dexterity.networks.feed_forward import FeedForward
from dexterity.networks.levenberg_marquardt import Damping, Options, levenberg_marquardt
from dexterity.networks.network import View
from dexterity.networks.problem import DesignProblem, largest_relative_error
from dexterity.report.claims import Acceptance, Outcome, Verdict, load_paper
from dexterity.report.ranges import with_range
from dexterity.report.stored import Tolerance
from dexterity.sampling import DataSet, DataSets, TaskSector
from dexterity.timing import Timing, Way

__all__ = [
    "AS_PRINTED",
    "AT_THE_ORIGIN",
    "CONFIGS",
    "INDICES",
    "TOLERANCE",
    "TRAINED_ON",
    "WHOLE_GRID",
    "Config",
    "Curve",
    "Judged",
    "Loop",
    "Result",
    "acceptance",
    "judged_table",
    "loop_table",
    "problem",
    "run",
    "smallest_table",
    "time_table",
    "verdicts",
]

INDICES: Mapping[str, Index] = {"w": Index("manipulability"), "KCI": Index("kinematic_conditioning")}
"""The two indices of the paper, with unit limits, in the spatial frame."""

TOLERANCE = Tolerance(rtol=1e-3, atol=1e-6)
"""What a probe may miss by, since a training carries rounding errors on and makes them larger."""

AS_PRINTED = "as printed"
"""Name of trainings with the damping rule of the paper's toolbox that end at the paper's goal."""

TRAINED_ON = "trained on"
"""Name of trainings with the gain-ratio rule and without a goal."""

WHOLE_GRID = "whole grid"
"""Name of trainings on every row of the grid of w, as those that are trained on."""

AT_THE_ORIGIN = "task point at the origin"
"""Name of trainings with the task point at the world's origin, as those that are trained on."""

_TOOLBOX, _ON = "toolbox's rule", "gain ratio"


@dataclass(frozen=True)
class Config:
    """How much is drawn and trained; what comes in pairs is for w and for KCI.

    Attributes
    ----------
    seeds, few_seeds
        Of data and initial weights; the second for what takes longest, the loop of KCI as printed, and for
        another task point.
    seed
        Of the fresh configurations.
    rows, curve_rows
        Sizes of the training sets of networks that are judged, and of those of rising size.
    test, fresh
        Sizes of each test set, the paper's T, and of the sets of fresh configurations.
    testing_error, goals, epochs, neuron_limit
        The paper's E, :math:`E_{mse}`, :math:`L_{epochs}` and :math:`L_{iter}`.
    neurons
        Of the printed networks.
    largest, step
        Largest number of neurons among networks of rising size, and how many are added at a time.
    loop_limit
        Where the loop of KCI is given up, if that is before `neuron_limit`.
    limits
        Testing errors for which the smallest network is looked for.
    larger
        Neurons of networks for w that are larger than the printed one.
    restarts
        Networks of the printed size for w from different initial weights, on the data of the first seed.
    grid_seeds
        Of networks that learn from every row of the grid; none leaves that out.
    timed_rows, timed_neurons, rounds
        Trainings of five epochs that are timed, and how often; none without rounds.
    jobs
        Trainings at the same time.
    resumable
        Whether finished trials are kept until a run has ended.
    """

    seeds: tuple[int, ...] = (0, 1, 2)
    few_seeds: tuple[int, ...] = (0,)
    seed: int = 1000
    rows: tuple[int, int] = (5000, 10_000)
    curve_rows: tuple[int, int] = (5000, 4000)
    test: int = 1000
    fresh: tuple[int, int] = (100_000, 20_000)
    testing_error: float = 0.02
    goals: tuple[float, float] = (1e-3, 5e-6)
    epochs: int = 100
    neuron_limit: int = 100
    neurons: tuple[int, int] = (8, 25)
    largest: tuple[int, int] = (12, 25)
    step: tuple[int, int] = (1, 4)
    loop_limit: int = 26
    limits: tuple[float, ...] = (0.02, 0.01, 0.005, 0.001)
    larger: tuple[int, ...] = (16,)
    restarts: int = 10
    grid_seeds: tuple[int, ...] = ()
    timed_rows: tuple[int, ...] = (1000, 4000, 16_000)
    timed_neurons: tuple[int, ...] = (4, 8, 16)
    rounds: int = 3
    jobs: int = 2
    resumable: bool = False


CONFIGS: Mapping[str, Config] = {
    "smoke": Config(
        seeds=(0, 1), rows=(200, 200), curve_rows=(200, 200), test=100, fresh=(500, 500), epochs=5,
        neurons=(3, 4), largest=(8, 5), step=(1, 2), loop_limit=3, larger=(9,), restarts=3, rounds=0, jobs=1,
    ),
    "book": Config(),
    "full": Config(
        seeds=tuple(range(10)), few_seeds=tuple(range(10)), curve_rows=(5000, 5000), largest=(16, 30),
        step=(1, 1), loop_limit=35, larger=(16, 24, 32), restarts=32, grid_seeds=tuple(range(10)),
        timed_rows=(1000, 2000, 4000, 8000, 16_000), timed_neurons=(4, 8, 16, 32), rounds=10,
        jobs=os.cpu_count() or 1, resumable=True,
    ),
}  # fmt: skip
"""What runs at each scale."""


@dataclass(frozen=True)
class Curve:
    """Networks of rising size, one of each size for each seed.

    Attributes
    ----------
    neurons
        (m) sizes.
    testing, validation
        (seeds, m) largest errors on the test sets, and on as many configurations drawn uniformly.
    """

    neurons: tuple[int, ...]
    testing: NDArray[np.float64]
    validation: NDArray[np.float64]


@dataclass(frozen=True)
class Loop:
    """The loop as printed, one run for each seed.

    Attributes
    ----------
    testing
        Testing error with one neuron, two, and so on, up to where the loop ended.
    passed
        Whether the last one passed the test; if not, the loop was given up.
    fresh, above
        Of the network that passed, or else the best: its largest error on fresh configurations, and the
        share of them where it is above E.
    reached
        Share of all trainings that reached the goal.
    """

    testing: tuple[tuple[float, ...], ...]
    passed: tuple[bool, ...]
    fresh: tuple[float, ...]
    above: tuple[float, ...]
    reached: float

    @property
    def neurons(self) -> tuple[int, ...]:
        """Sizes at which it ended."""
        return tuple(len(errors) for errors in self.testing)


@dataclass(frozen=True)
class Judged:
    """Networks of one size, one for each seed.

    Attributes
    ----------
    neurons, rows
        Size of a network and of its training set.
    testing, validation, fresh
        Largest errors on the test set, on as many configurations drawn uniformly, and on many more of these.
    mean_square_error
        Over the training set.
    history
        (seeds, epochs + 1) the same after each epoch; the last value goes on where a training has ended.
    """

    neurons: int
    rows: int
    testing: tuple[float, ...]
    validation: tuple[float, ...]
    fresh: tuple[float, ...]
    mean_square_error: tuple[float, ...]
    history: NDArray[np.float64]


@dataclass(frozen=True)
class Result:
    """What the loop and its networks came to.

    Attributes
    ----------
    deviations
        Of what this package computes from the printed formulas, relative.
    curves
        Networks of rising size, by index and then by kind of training.
    loops
        The loop as printed, by index.
    judged
        Networks of the printed sizes, by index and then by kind of training.
    damping
        Mean square error of the same networks after each epoch without a goal (seeds, epochs + 1), by index
        and then by damping rule.
    larger
        Networks for w of the printed size and larger ones, trained on.
    restarts
        Testing errors of networks for w on the same data.
    times
        Of trainings by rows and neurons, (rows, neurons); empty if none were taken.
    limits, testing_error
        Those of the config.
    """

    deviations: Mapping[str, float]
    curves: Mapping[str, Mapping[str, Curve]]
    loops: Mapping[str, Loop]
    judged: Mapping[str, Mapping[str, Judged]]
    damping: Mapping[str, Mapping[str, NDArray[np.float64]]]
    larger: tuple[Judged, ...]
    restarts: tuple[float, ...]
    times: Mapping[str, tuple[Timing, ...]]
    limits: tuple[float, ...]
    testing_error: float


def run(config: Config) -> Result:
    """Check the formulas, run the loops, judge their networks, and time trainings."""
    tasks = {name: _Task.of(name, config) for name in INDICES}
    runs = {key: run for task in tasks.values() for key, run in task.runs().items()}
    found = design_all(
        list(runs.values()),
        n_jobs=config.jobs,
        device="cuda" if torch.cuda.is_available() else "cpu",
        progress=config.resumable,
    )
    designs, w = dict(zip(runs, found, strict=True)), tasks["w"]
    return Result(
        deviations=_deviations(w.view, w.data(config.seeds[0], min(300, config.rows[0])).train),
        curves={name: task.curves(designs) for name, task in tasks.items()},
        loops={name: task.loop(designs) for name, task in tasks.items()},
        judged={name: task.judged(designs) for name, task in tasks.items()},
        damping={name: task.damping(designs) for name, task in tasks.items()},
        larger=tuple(w.of_size(designs, neurons) for neurons in (config.neurons[0], *config.larger)),
        restarts=tuple(trial.testing_error for trial in designs[_Key("w", "restarts")].trials),
        times=_times(w, config),
        limits=config.limits,
        testing_error=config.testing_error,
    )


def problem(index: str, seed: int, config: Config) -> DesignProblem:
    """Return what the loop learns from at one seed.

    Parameters
    ----------
    index
        ``"w"`` or ``"KCI"``.
    seed
        Of the draw.
    config
        How much is drawn.
    """
    task = _Task.of(index, config)
    return task.problem(seed, task.curve_rows)


# ---- designs ---------------------------------------------------------------------------------------


@dataclass(frozen=True)
class _Key:
    """Which design of the study one is."""

    index: str
    kind: str
    seed: int = 0
    neurons: int = 0


_Runs = dict[_Key, tuple[DesignProblem, FeedForwardOptions]]


@dataclass(frozen=True)
class _Task:
    """An index with the settings that are its own."""

    name: str
    config: Config
    f: symbolic.CompiledIndex
    space: sampling.Space
    view: View
    rows: int
    curve_rows: int
    goal: float
    neurons: int
    largest: int
    step: int

    @classmethod
    def of(cls, name: str, config: Config) -> _Task:
        chain, which = robots.uvms(), list(INDICES).index(name)
        pairs = (config.rows, config.curve_rows, config.goals, config.neurons, config.largest, config.step)
        rows, curve_rows, goal, neurons, largest, step = (pair[which] for pair in pairs)
        f, space = symbolic.compile_index(chain, INDICES[name], "c"), sampling.uvms_space(INDICES[name].name)
        ends = torch.eye(2, dtype=torch.float64)[:, :1].expand(-1, space.dimensions)
        highest, lowest = space.from_unit(ends)
        view = View(chain.joints, (lowest != highest).nonzero().flatten().tolist())
        return cls(
            name, config, f, space, view, int(rows), int(curve_rows), goal,
            int(neurons), int(largest), int(step),
        )  # fmt: skip

    @property
    def seeds(self) -> tuple[int, ...]:
        return self.config.seeds

    @property
    def loop_seeds(self) -> tuple[int, ...]:
        return self.config.seeds if self.name == "w" else self.config.few_seeds

    def data(self, seed: int, rows: int, space: sampling.Space | None = None) -> DataSets:
        test = self.config.test
        return sampling.data_sets(
            self.f, space or self.space, train=rows, test=test, validation=test, seed=seed
        )

    def problem(self, seed: int, rows: int, space: sampling.Space | None = None) -> DesignProblem:
        return DesignProblem(self.view, self.data(seed, rows, space))

    def options(self, seed: int, damping: Damping, goal: float) -> FeedForwardOptions:
        return FeedForwardOptions(
            testing_error=self.config.testing_error,
            training_goal=goal,
            neuron_limit=self.config.neuron_limit,
            epoch_limit=self.config.epochs,
            damping=damping,
            seed=seed,
        )

    def as_printed(self, seed: int) -> FeedForwardOptions:
        return self.options(seed, "factor", self.goal)

    def trained_on(self, seed: int) -> FeedForwardOptions:
        return self.options(seed, "gain_ratio", 0.0)

    # ---- what is to be trained

    def runs(self) -> _Runs:
        """Return all designs of this index; those that take longest come first."""
        runs: _Runs = {}
        if self.name == "w":
            runs |= self._runs_for_w()
        for seed in self.loop_seeds:
            limit = self.config.neuron_limit if self.name == "w" else self.config.loop_limit
            options = replace(self.as_printed(seed), neuron_limit=limit)
            runs[_Key(self.name, "loop", seed)] = (self.problem(seed, self.curve_rows), options)
        for seed in self.seeds:
            problem, curve_problem = self.problem(seed, self.rows), self.problem(seed, self.curve_rows)
            for kind, options in self._kinds(seed).items():
                own = replace(options, neuron_limit=self.largest, neuron_step=self.step, sweep="all")
                if self.name == "w" or kind == TRAINED_ON:
                    runs[_Key(self.name, f"curve, {kind}", seed)] = (curve_problem, own)
                runs[_Key(self.name, kind, seed)] = (problem, _only(options, self.neurons))
            toolbox = _only(self.options(seed, "factor", 0.0), self.neurons)
            runs[_Key(self.name, _TOOLBOX, seed)] = (problem, toolbox)
        if self.name == "KCI":
            elsewhere = _at_the_origin(self.space)
            for seed in self.config.few_seeds:
                moved = self.problem(seed, self.rows, elsewhere)
                runs[_Key(self.name, AT_THE_ORIGIN, seed)] = (
                    moved,
                    _only(self.trained_on(seed), self.neurons),
                )
        return runs

    def _kinds(self, seed: int) -> dict[str, FeedForwardOptions]:
        return {AS_PRINTED: self.as_printed(seed), TRAINED_ON: self.trained_on(seed)}

    def _runs_for_w(self) -> _Runs:
        runs: _Runs = {}
        if self.config.grid_seeds:
            whole_grid = self.whole_grid()
            for seed in self.config.grid_seeds:
                runs[_Key("w", WHOLE_GRID, seed)] = (whole_grid, _only(self.trained_on(seed), self.neurons))
        for seed in self.seeds:
            problem = self.problem(seed, self.rows)
            for neurons in self.config.larger:
                runs[_Key("w", "larger", seed, neurons)] = (problem, _only(self.trained_on(seed), neurons))
        first = self.seeds[0]
        restarted = replace(_only(self.trained_on(first), self.neurons), restarts=self.config.restarts)
        runs[_Key("w", "restarts")] = (self.problem(first, self.rows), restarted)
        return runs

    def whole_grid(self) -> DesignProblem:
        """Every row of the grid to train on, those of the test set too."""
        q = sampling.grid(self.space)
        return DesignProblem(self.view, replace(self.data(self.config.seed, 1), train=DataSet(q, self.f(q))))

    # ---- what came out

    def curves(self, designs: Mapping[_Key, Design]) -> dict[str, Curve]:
        curves = {}
        for kind in (AS_PRINTED, TRAINED_ON):
            found = self._over_seeds(designs, f"curve, {kind}")
            if found:
                trials = [design.trials for design in found]
                curves[kind] = Curve(
                    tuple(trial.neurons for trial in trials[0]),
                    np.array([[trial.testing_error for trial in own] for own in trials]),
                    np.array([[trial.validation_error for trial in own] for own in trials]),
                )
        return curves

    def loop(self, designs: Mapping[_Key, Design]) -> Loop:
        found = [designs[_Key(self.name, "loop", seed)] for seed in self.loop_seeds]
        errors = [self._errors(design.network) for design in found]
        trials = [trial for design in found for trial in design.trials]
        return Loop(
            testing=tuple(tuple(trial.testing_error for trial in design.trials) for design in found),
            passed=tuple(design.success for design in found),
            fresh=tuple(float(own.max()) for own in errors),
            above=tuple(float((own > self.config.testing_error).double().mean()) for own in errors),
            reached=float(np.mean([trial.mean_square_error <= self.goal for trial in trials])),
        )

    def judged(self, designs: Mapping[_Key, Design]) -> dict[str, Judged]:
        kinds = (AS_PRINTED, TRAINED_ON, WHOLE_GRID, AT_THE_ORIGIN)
        found = {kind: self._over_seeds(designs, kind) for kind in kinds}
        return {kind: self._judge(own, kind) for kind, own in found.items() if own}

    def damping(self, designs: Mapping[_Key, Design]) -> dict[str, NDArray[np.float64]]:
        kinds = {_TOOLBOX: _TOOLBOX, _ON: TRAINED_ON}
        return {rule: self._histories(self._over_seeds(designs, kind)) for rule, kind in kinds.items()}

    def of_size(self, designs: Mapping[_Key, Design], neurons: int) -> Judged:
        if neurons == self.neurons:
            return self._judge(self._over_seeds(designs, TRAINED_ON), TRAINED_ON)
        return self._judge([designs[_Key("w", "larger", seed, neurons)] for seed in self.seeds], TRAINED_ON)

    def _over_seeds(self, designs: Mapping[_Key, Design], kind: str) -> list[Design]:
        return [design for key, design in designs.items() if (key.index, key.kind) == (self.name, kind)]

    def _judge(self, designs: Sequence[Design], kind: str) -> Judged:
        space = _at_the_origin(self.space) if kind == AT_THE_ORIGIN else self.space
        best = [design.best for design in designs]
        return Judged(
            neurons=best[0].neurons,
            rows=sampling.grid_size(self.space) if kind == WHOLE_GRID else self.rows,
            testing=tuple(trial.testing_error for trial in best),
            validation=tuple(trial.validation_error for trial in best),
            fresh=tuple(float(self._errors(design.network, space).max()) for design in designs),
            mean_square_error=tuple(trial.mean_square_error for trial in best),
            history=self._histories(designs),
        )

    def _histories(self, designs: Sequence[Design]) -> NDArray[np.float64]:
        length = self.config.epochs + 1
        histories = [design.best.history for design in designs]
        return np.array([[*own, *[own[-1]] * (length - len(own))] for own in histories])

    def _errors(self, network: FeedForward, space: sampling.Space | None = None) -> Tensor:
        """Relative errors on the fresh configurations."""
        count = self.config.fresh[list(INDICES).index(self.name)]
        q = sampling.uniform(space or self.space, count, torch.Generator().manual_seed(self.config.seed))
        exact = self.f(q)
        with torch.no_grad():
            return ((network(q) - exact) / exact).abs()


def _only(options: FeedForwardOptions, neurons: int) -> FeedForwardOptions:
    return replace(options, first_neurons=neurons, neuron_limit=neurons, sweep="all")


def _at_the_origin(space: sampling.Space) -> TaskSector:
    if not isinstance(space, TaskSector):
        raise TypeError("the KCI of the UVMS no longer depends on where the vehicle is")
    return replace(space, task_point=(0.0, 0.0, 0.0))


# ---- formulas --------------------------------------------------------------------------------------


def _deviations(view: View, rows: DataSet) -> dict[str, float]:
    """Compare with the printed formulas, written out, at a network that is near one which fits."""
    near = FeedForward.untrained(view, 5, rows.q, rows.values, torch.Generator().manual_seed(0))
    values = near(rows.q).detach()
    with torch.no_grad():
        near.output_weights += 0.01
        near.hidden_biases -= 0.01
    written = _Written.of(near, rows.q, values)
    J, e = written.jacobian(), written.residuals()
    errors = (written.values() - values.numpy()) / values.numpy()
    training = levenberg_marquardt(near, rows.q, values, Options(goal=np.finfo(float).max))
    gauss_newton, downhill = -np.linalg.lstsq(J, e, rcond=None)[0], -J.T @ e
    damped = -np.linalg.solve(J.T @ J + np.eye(J.shape[1]), J.T @ e)
    return {
        "values": _deviation(near(rows.q).detach().numpy(), written.values()),
        "mean square error": _deviation(
            training.mean_square_error, float(np.mean((written.values() - values.numpy()) ** 2))
        ),
        "testing error": _deviation(
            largest_relative_error(near, DataSet(rows.q, values)), float(np.abs(errors).max())
        ),
        "step": _deviation(_step(near, rows.q, values, 1.0), damped),
        "step of Gauss and Newton": _deviation(_step(near, rows.q, values, 1e-9), gauss_newton),
        "step down the gradient": _deviation(_step(near, rows.q, values, 1e12) * 1e12, downhill),
    }


def _deviation(ours: Any, written: Any) -> float:
    return float(np.linalg.norm(np.subtract(ours, written)) / np.linalg.norm(written))


def _step(network: FeedForward, q: Tensor, values: Tensor, damping: float) -> NDArray[np.float64]:
    """Return what a step of the trainer adds to the weights, if it is taken."""
    options = Options(epochs=1, damping="factor", initial_damping=damping, largest_damping=1e300)
    trained = levenberg_marquardt(network, q, values, options).network
    return _weights(trained) - _weights(network)


def _weights(network: FeedForward) -> NDArray[np.float64]:
    return np.concatenate([p.detach().numpy().ravel() for p in network.parameters()])


@dataclass(frozen=True)
class _Written:
    """Eqs. 13 to 16 and their derivatives as they are printed, with scaled inputs and targets.

    Attributes
    ----------
    x, targets
        (N, r) and (N).
    layers
        Hidden weights and biases, output weights and bias.
    centre, half_range
        What scaled values are multiplied by and added to.
    """

    x: NDArray[np.float64]
    targets: NDArray[np.float64]
    layers: tuple[NDArray[np.float64], ...]
    centre: float
    half_range: float

    @classmethod
    def of(cls, network: FeedForward, q: Tensor, values: Tensor) -> _Written:
        centre, half_range = network.target_centre.item(), network.target_half_range.item()
        scaled = (network.view(q) - network.input_centre) / network.input_half_range
        layers = tuple(p.detach().numpy() for p in network.parameters())
        return cls(scaled.numpy(), (values.numpy() - centre) / half_range, layers, centre, half_range)

    def hidden(self) -> NDArray[np.float64]:
        gamma = self.x @ self.layers[0].T + self.layers[1]
        return (np.exp(gamma) - np.exp(-gamma)) / (np.exp(gamma) + np.exp(-gamma))

    def outputs(self) -> NDArray[np.float64]:
        return self.hidden() @ self.layers[2][0] + self.layers[3]

    def values(self) -> NDArray[np.float64]:
        return self.outputs() * self.half_range + self.centre

    def residuals(self) -> NDArray[np.float64]:
        return self.outputs() - self.targets

    def jacobian(self) -> NDArray[np.float64]:
        hidden = self.hidden()
        into_hidden = self.layers[2][0] * (1 - hidden**2)
        by_weights = (into_hidden[:, :, None] * self.x[:, None]).reshape(len(hidden), -1)
        return np.hstack([by_weights, into_hidden, hidden, np.ones((len(hidden), 1))])


# ---- times -----------------------------------------------------------------------------------------

_TIMED_EPOCHS = 5


def _times(task: _Task, config: Config) -> dict[str, tuple[Timing, ...]]:
    """Measure trainings by the number of rows, with each number of neurons in turn."""
    if not config.rounds:
        return {}
    ways = [
        _way(task.data(config.seed, rows).train, task.view, neurons)
        for rows in config.timed_rows
        for neurons in config.timed_neurons
    ]
    measured = timing.measure(ways, config.rounds, 0.02)
    sizes = len(config.timed_neurons)
    return {
        f"{rows:,} rows": measured[i * sizes : (i + 1) * sizes] for i, rows in enumerate(config.timed_rows)
    }


def _way(rows: DataSet, view: View, neurons: int) -> Way:
    network = FeedForward.untrained(view, neurons, rows.q, rows.values, torch.Generator().manual_seed(0))
    options = Options(epochs=_TIMED_EPOCHS)
    name = f"{neurons} neurons, {len(rows.q)} rows"
    return Way(name, lambda: levenberg_marquardt(network, rows.q, rows.values, options), _TIMED_EPOCHS)


# ---- tables ----------------------------------------------------------------------------------------


def loop_table(result: Result) -> dict[str, dict[str, str]]:
    """Where the loop as printed ended, and what the networks that it accepted are worth."""
    return {
        name: {
            "runs": str(len(loop.neurons)),
            "neurons at the end": _range_of(loop.neurons),
            "of them passed": str(sum(loop.passed)),
            "testing error at the end [%]": _percent([errors[-1] for errors in loop.testing]),
            "error on fresh points [%]": _percent(loop.fresh),
            "fresh points above E [%]": f"{100 * np.median(loop.above):.2g}",
            "trainings that reached the goal [%]": f"{100 * loop.reached:.0f}",
        }
        for name, loop in result.loops.items()
    }


def smallest_table(result: Result) -> dict[str, dict[str, str]]:
    """Fewest neurons for w with which a testing error is kept, over the seeds."""
    return {
        f"{100 * limit:g} %": {
            kind: _range_of(_smallest(curve, limit)) for kind, curve in result.curves["w"].items()
        }
        for limit in result.limits
    }


def judged_table(result: Result) -> dict[str, dict[str, str]]:
    """Networks of the printed sizes, and larger ones for w, on points that no loop has seen."""
    rows = {f"{name}, {kind}": judged for name, own in result.judged.items() for kind, judged in own.items()}
    rows |= {f"w, {judged.neurons} neurons, {TRAINED_ON}": judged for judged in result.larger[1:]}
    return {
        title: {
            "neurons": str(judged.neurons),
            "rows": f"{judged.rows:,}",
            "test set [%]": _percent(judged.testing),
            "as many between grid points [%]": _percent(judged.validation),
            "many more [%]": _percent(judged.fresh),
            "seeds": str(len(judged.fresh)),
        }
        for title, judged in rows.items()
    }


def time_table(result: Result) -> dict[str, dict[str, str]]:
    """Milliseconds of a step of the training, by rows and neurons."""
    return {
        rows: {own.name.partition(",")[0]: f"{1e3 * own.median:.3g}" for own in timings}
        for rows, timings in result.times.items()
    }


def _smallest(curve: Curve, limit: float) -> list[float]:
    """Fewest neurons with which the testing error is within the limit, infinity if none has, by seed."""
    passes = curve.testing <= limit
    first = np.array(curve.neurons, dtype=float)[passes.argmax(axis=1)]
    return [float(x) for x in np.where(passes.any(axis=1), first, np.inf)]


def _percent(errors: Sequence[float] | NDArray[np.float64]) -> str:
    """Median of errors in per cent, with their range."""
    return with_range(100 * np.asarray(errors), "{:.3g}".format)


def _range_of(neurons: Sequence[float]) -> str:
    """Median of numbers of neurons, with their range."""
    return with_range(neurons, lambda number: "none" if np.isinf(number) else f"{number:g}")


# ---- verdicts --------------------------------------------------------------------------------------

_PAPER = "sotiropoulos2016"
_TEN_DIGITS, _A_PER_CENT = 1e-10, 0.01
_CLOSE = 0.25


def verdicts(result: Result) -> tuple[Verdict, ...]:
    """Judge the claims of the ledger that this study answers for; see above for the thresholds."""
    return (
        *_on_formulas(result),
        *_on_settings(result),
        *_on_the_loop(result),
        *_on_errors(result),
        *_on_sizes(result),
        _on_time(result),
    )


def _on_formulas(result: Result) -> tuple[Verdict, ...]:
    scaled = "with inputs and outputs scaled linearly, which the paper does not mention"
    formulas = {
        "hidden-activation": ("values", "The hyperbolic tangent, whose printed form overflows for large γ."),
        "output-activation": ("values", f"Taken over, {scaled}."),
        "hidden-layer": ("values", f"Taken over, {scaled}."),
        "output-layer": ("values", "Taken over; the D_H of Eq. 16 is the X_H of Eq. 15."),
        "training-error": ("mean square error", "Measured in the index itself and not in scaled outputs."),
        "levenberg-marquardt-step": ("step", "One step, beside the printed one with J written out."),
        "testing-error": ("testing error", "Taken over."),
    }
    exact = (
        _verdict(
            claim, Outcome.of(deviation <= _TEN_DIGITS),
            f"within {deviation:.0e}" if deviation else "to the bit", "", sentence,
        )
        for claim, (what, sentence) in formulas.items()
        for deviation in [result.deviations[what]]
    )  # fmt: skip
    limits = [result.deviations[f"step {way}"] for way in ("of Gauss and Newton", "down the gradient")]
    return (
        *exact,
        _verdict(
            "damping-limits", Outcome.of(max(limits) <= _A_PER_CENT),
            f"within {limits[0]:.0e} and {limits[1]:.0e}", "",
            "The step beside that of Gauss and Newton for very little damping, and beside the scaled "
            "gradient for very much.",
        ),
    )  # fmt: skip


def _on_settings(result: Result) -> tuple[Verdict, ...]:
    w, kci = (result.loops[name] for name in INDICES)
    longest = max(max(loop.neurons) for loop in (w, kci))
    settings = {
        "feed-forward-testing-error-limit": " and ".join(
            f"of the {sum(loop.passed)} networks for {name} that keep it on the test set, {_broken(loop)} "
            "break it on fresh configurations"
            for name, loop in result.loops.items()
        )
        + ".",
        "feed-forward-training-error-goals": f"{100 * w.reached:.0f} % of the trainings for w reach theirs, "
        f"and {100 * kci.reached:.0f} % of those for KCI.",
        "feed-forward-neuron-limit": f"no loop was followed beyond {longest} neurons.",
        "feed-forward-epoch-limit": "in the last tenth of the epochs the error of the printed networks falls "
        + " and ".join(
            f"by {100 * _fall(rules[_TOOLBOX]):.2g} % for {name} with the toolbox's rule for the damping and "
            f"by {100 * _fall(rules[_ON]):.2g} % with the gain ratio"
            for name, rules in result.damping.items()
        )
        + ".",
    }
    return tuple(
        _verdict(claim, Outcome.OUT_OF_SCOPE, "", "", f"A setting, taken over: {sentence}")
        for claim, sentence in settings.items()
    )


def _fall(histories: NDArray[np.float64]) -> float:
    """Median over the seeds of how much of the mean square error goes in the last tenth of the epochs."""
    tenth = -(-(histories.shape[1] - 1) // 10)
    return float(np.median(1 - histories[:, -1] / histories[:, -1 - tenth]))


def _broken(loop: Loop) -> int:
    return sum(passed and above > 0 for passed, above in zip(loop.passed, loop.above, strict=True))


def _on_the_loop(result: Result) -> tuple[Verdict, ...]:
    w, kci = (result.loops[name] for name in INDICES)
    spreads = [_spread_of(loop.neurons) for loop in (w, kci)]
    needs_more = min(kci.neurons) > max(w.neurons)
    return (
        _verdict(
            "feed-forward-design-loop",
            Outcome.REPRODUCED if max(spreads) == 0
            else Outcome.IN_SHAPE if max(spreads) <= _CLOSE
            else Outcome.NOT_REPRODUCED,
            f"{_range_of(w.neurons)} neurons for w, {_range_of(kci.neurons)} for KCI",
            _over(w.neurons),
            "It finds the first network that happens to pass, and which does hangs on the initial weights. "
            f"For w such networks have {_percent(w.fresh)} % on fresh configurations.",
        ),
        _on_end("feed-forward-w-neurons", w),
        _on_end("feed-forward-kci-neurons", kci),
        _verdict(
            "kci-needs-more-neurons", Outcome.of(needs_more),
            f"{_range_of(kci.neurons)} against {_range_of(w.neurons)}", _over(kci.neurons),
            "KCI has eleven inputs, and a kink where its two smallest singular values meet.",
        ),
    )  # fmt: skip


def _on_end(claim: str, loop: Loop) -> Verdict:
    printed, median = _value(claim), float(np.median(loop.neurons))
    if all(loop.passed):
        end = "Every run passed"
    else:
        end = f"{len(loop.passed) - sum(loop.passed)} of {len(loop.passed)} runs were given up there"
    return _verdict(
        claim,
        Outcome.REPRODUCED if median == printed and all(loop.passed)
        else Outcome.IN_SHAPE if abs(median - printed) <= _CLOSE * printed and all(loop.passed)
        else Outcome.NOT_REPRODUCED,
        f"{_range_of(loop.neurons)} neurons", _over(loop.neurons),
        f"{end}; {100 * loop.reached:.0f} % of the trainings reached the printed goal.",
    )  # fmt: skip


def _on_errors(result: Result) -> tuple[Verdict, ...]:
    return tuple(_on_bound(f"feed-forward-{name.lower()}-error", result.judged[name]) for name in INDICES)


def _on_bound(claim: str, judged: Mapping[str, Judged]) -> Verdict:
    bound = _value(claim)
    printed, on = judged[AS_PRINTED], judged[TRAINED_ON]
    return _verdict(
        claim,
        Outcome.REPRODUCED if np.median(printed.testing) < bound
        else Outcome.IN_SHAPE if np.median(on.testing) < bound
        else Outcome.NOT_REPRODUCED,
        f"{_percent(printed.testing)} % as printed", _over(printed.testing),
        f"With {printed.neurons} neurons. Trained on, {_percent(on.testing)} % on the test set and "
        f"{_percent(on.fresh)} % on fresh configurations.",
    )  # fmt: skip


def _on_sizes(result: Result) -> tuple[Verdict, ...]:
    curve = result.curves["w"][AS_PRINTED]
    on = result.curves["w"][TRAINED_ON]
    four, five, six, seven, eight = (_at(curve, n) for n in (4, 5, 6, 7, 8))
    medians = [float(np.median(errors)) for errors in (four, five, six, seven, eight)]
    worse = min(medians[2:4]) > medians[4]
    better = max(medians[:2]) < min(medians[2:4])
    pattern = (np.minimum(six, seven) > eight) & (np.maximum(four, five) < np.minimum(six, seven))
    goal = _value("feed-forward-training-error-goals")[0]
    ended = np.mean(np.array(result.judged["w"][AS_PRINTED].mean_square_error) <= goal)
    rises = (np.diff(on.testing, axis=1) > 0).mean()
    spread = max(result.restarts) / min(result.restarts)
    return (
        _verdict(
            "four-and-five-neurons-good", Outcome.of(max(medians[:2]) <= result.testing_error),
            f"{_percent(four)} % and {_percent(five)} %", _over(four),
            f"As printed; trained on, {_percent(_at(on, 4))} % and {_percent(_at(on, 5))} %.",
        ),
        _verdict(
            "six-and-seven-neurons-worse",
            Outcome.REPRODUCED if worse and better
            else Outcome.IN_SHAPE if worse
            else Outcome.NOT_REPRODUCED,
            f"6: {_percent(six)} %, 7: {_percent(seven)} %, 8: {_percent(eight)} %", _over(six),
            f"With four and five better than both it shows at {pattern.sum()} of {len(pattern)} seeds. The "
            f"printed goal ends {100 * ended:.0f} % of the trainings with eight, and more neurons then gain "
            f"nothing; without a goal eight have {_percent([_median(_at(on, 8))])} %.",
        ),
        _verdict(
            "initial-weights-decide",
            Outcome.REPRODUCED if spread >= 2 else Outcome.IN_SHAPE if spread >= 1.25
            else Outcome.NOT_REPRODUCED,
            f"{_percent(result.restarts)} %", f"{len(result.restarts)} restarts on the same data",
            f"The worst has {spread:.1f} times the error of the best. With one neuron more the error rises "
            f"in {100 * rises:.0f} % of the cases.",
        ),
        _on_generalisation(result),
    )  # fmt: skip


def _on_generalisation(result: Result) -> Verdict:
    eight, *larger = (float(np.median(judged.fresh)) for judged in result.larger)
    better = [error < eight for error in larger]
    listed = ", ".join(f"{judged.neurons}: {_percent(judged.fresh)} %" for judged in result.larger)
    return _verdict(
        "few-neurons-generalise",
        Outcome.CONTRADICTED if all(better) else Outcome.IN_SHAPE if any(better) else Outcome.REPRODUCED,
        listed, _over(result.larger[0].fresh),
        "Errors on fresh configurations by number of neurons, trained on"
        + (": nothing is overfitted at these sizes." if all(better) else "."),
    )  # fmt: skip


def _on_time(result: Result) -> Verdict:
    if not result.times:
        return _verdict("training-time-grows", Outcome.OUT_OF_SCOPE, "", "", "No times were taken.")
    medians = np.array([[own.median for own in timings] for timings in result.times.values()])
    rises = all((np.diff(medians, axis=axis) > 0).all() for axis in (0, 1))
    ends = bool((medians[-1] > medians[0]).all() and (medians[:, -1] > medians[:, 0]).all())
    first, last = next(iter(result.times.values()))[0], [*result.times.values()][-1][-1]
    return _verdict(
        "training-time-grows",
        Outcome.REPRODUCED if rises else Outcome.IN_SHAPE if ends else Outcome.NOT_REPRODUCED,
        f"{1e3 * first.median:.2g} to {1e3 * last.median:.3g} ms a step",
        f"{first.name} to {last.name}",
        f"It grows with both, and is short by now: {100 * last.median:.2g} s for a hundred steps of the "
        "last, on one core.",
    )  # fmt: skip


def _at(curve: Curve, neurons: int) -> NDArray[np.float64]:
    return curve.testing[:, curve.neurons.index(neurons)]


def _spread_of(neurons: Sequence[int]) -> float:
    return float((max(neurons) - min(neurons)) / np.median(neurons))


def _verdict(claim: str, outcome: Outcome, ours: str, spread: str, sentence: str) -> Verdict:
    return Verdict(_PAPER, claim, outcome, ours, spread, sentence)


def _value(claim: str) -> Any:
    return load_paper(_PAPER).claim(claim).value


def _over(values: Sized) -> str:
    return f"over {len(values)} seeds" if len(values) > 1 else "one seed"


def acceptance(result: Result) -> tuple[Acceptance, ...]:
    """Figures that must hold for the book to be built; errors where networks have the printed sizes."""
    figures = [
        Acceptance(f"{what}, against the printed formula", result.deviations[what], _TEN_DIGITS)
        for what in ("values", "mean square error", "testing error", "step")
    ]
    limits = {"w": (0.0015, 0.003), "KCI": (0.022, 0.03)}
    for name, (few, many) in limits.items():
        judged = result.judged[name][TRAINED_ON]
        if judged.neurons == _value(f"feed-forward-{name.lower()}-neurons"):
            title = f"{name}, {judged.neurons} neurons, median of the largest error on"
            figures += [
                Acceptance(f"{title} as many points as the test set has", _median(judged.validation), few),
                Acceptance(f"{title} fresh points", _median(judged.fresh), many),
            ]
    return tuple(figures)


def _median(values: Sequence[float] | NDArray[np.float64]) -> float:
    return float(np.median(values))
