"""The printed pipeline under many readings of what paper A leaves unprinted.

A reading gives each factor of `FACTORS` a value. For each the four design loops of the paper are run as printed,
to their end or to their printed limit, beside the networks of the printed sizes. All errors are relative, Eq. 21,
on 1 000 test points.

Sources: Sotiropoulos & Aspragathos (2016), Tables 2 to 4, sections 3.1 to 4.4. The factors and their ranges were
written down on 2026-11-30, before any run of this chapter. What single factors do had been tried by then: a tool
faster than 1.3 m/s takes the kinks out of KCI, and a shoulder of 0.3 m makes w harder.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Literal, TypeAlias, cast

import torch
from scipy.stats import qmc
from torch import Tensor

from dexterity import robots, sampling
from dexterity.chain import Chain
from dexterity.indices import Frame, Index
from dexterity.networks import baselines, train
from dexterity.networks.feed_forward import FeedForward
from dexterity.networks.growth import RadialBasisOptions, grow
from dexterity.networks.levenberg_marquardt import Damping, Options, Training, levenberg_marquardt
from dexterity.networks.network import View
from dexterity.networks.problem import DesignProblem, largest_relative_error
from dexterity.networks.validation import Function
from dexterity.sampling import Box, DataSet, DataSets, Space, TaskSector
from dexterity_study.engine.experiment import experiment
from dexterity_study.uvms.feed_forward.experiment import GOALS, LIMIT, OF_DATA

Level: TypeAlias = float | str
Values: TypeAlias = Mapping[str, Level]
Row: TypeAlias = dict[str, Any]
Rows: TypeAlias = Iterator[Row]


@dataclass(frozen=True)
class Factor:
    """Something that the paper leaves unprinted, and the values that it may have had.

    Attributes
    ----------
    name
        Short name, a column of the rows.
    assumptions
        Ids of the assumptions of the ledger that it stands for.
    chosen
        The value of the chosen reading.
    levels
        Values worth trying one at a time; all that there are, if `scale` is None.
    scale
        How a number is drawn between the smallest and the largest level; None for choices.
    """

    name: str
    assumptions: tuple[str, ...]
    chosen: Level
    levels: tuple[Level, ...]
    scale: Literal["linear", "logarithmic"] | None = None

    def at(self, u: float) -> Level:
        """Return the value at a number from 0 to 1."""
        if self.scale is None:
            return self.levels[min(int(u * len(self.levels)), len(self.levels) - 1)]
        low, high = float(min(self.levels)), float(max(self.levels))
        return low + u * (high - low) if self.scale == "linear" else low * (high / low) ** u


FACTORS = (
    Factor("l1", ("base-link-height",), 0.0, (0.0, 0.1, 0.2, 0.3, 0.4, 0.5), "linear"),
    Factor("l2", ("link-lengths",), 0.6, (0.6, 0.4)),
    Factor("vehicle_speed", ("velocity-limits",), 1.0, (0.25, 0.5, 1.0, 2.0), "logarithmic"),
    Factor("vehicle_rate", ("velocity-limits",), 1.0, (0.2, 0.5, 1.0, 2.0), "logarithmic"),
    Factor("arm_rate", ("velocity-limits",), 1.0, (0.5, 1.0, 2.0, 3.0), "logarithmic"),
    Factor("tool_speed", ("velocity-limits",), 1.0, (0.5, 1.0, 1.25, 1.5, 2.0), "logarithmic"),
    Factor("frame", ("which-jacobian",), "spatial", ("spatial", "geometric")),
    Factor("ahead", ("task-point", "world-origin"), 1.35, (-1.15, -0.4, 0.0, 0.6, 1.35, 3.35), "linear"),
    Factor("azimuth", ("sector-of-the-base",), 15.0, (15.0, 30.0)),
    Factor("elevation", ("sector-of-the-base",), 15.0, (15.0, 0.0)),
    Factor("vehicle_angle", ("base-orientation",), 15.0, (15.0, 0.0)),
    Factor("rows_w", ("training-set-sizes",), 5000.0, (1000.0, 2000.0, 5000.0), "logarithmic"),
    Factor("rows_KCI", ("training-set-sizes",), 10_000.0, (3000.0, 5000.0, 10_000.0), "logarithmic"),
    Factor("test_points", ("test-set-draw",), "grid", ("grid", "uniform")),
    Factor("scaling", ("feed-forward-input-scaling",), "range", ("range", "none")),
    Factor("damping", ("damping-rule",), "factor", ("factor", "gain_ratio")),
    Factor("stopping", ("stopping-rules",), "as printed", ("as printed", "validation")),
    Factor("unit", ("radial-basis-input-scaling",), "radians", ("radians", "degrees", "range")),
)
"""What is varied. A rate of the tool about its axes is 1 rad/s throughout: KCI depends on ratios of rates alone.
A task point ahead of the world's origin by less is the same as an origin that is moved ahead by as much. The first
spread and the neuron limits are varied besides, for each reading: see `SPREADS`."""

CHOSEN: dict[str, Level] = {factor.name: factor.chosen for factor in FACTORS}
BLOCKS, BLOCK, DESIGN_SEED = 24, 4, 20_161_130
"""Runs of the design so far, of 52 that are planned; readings of one run; and what scrambles their sequence."""

ALONE = (
    ("chosen", CHOSEN),
    *(
        (
            f"{factor.name}={level:g}" if isinstance(level, float) else f"{factor.name}={level}",
            CHOSEN | {factor.name: level},
        )
        for factor in FACTORS
        for level in factor.levels
        if level != factor.chosen
    ),
)
"""The chosen reading, and those that change one factor of it, by name."""

HIGH, FAST, SLOW = {"l1": 0.3}, {"tool_speed": 1.5}, {"vehicle_speed": 0.25, "vehicle_rate": 0.2}
NAMED: Mapping[str, Values] = {
    "chosen": CHOSEN,
    "high shoulder": CHOSEN | HIGH,
    "fast tool": CHOSEN | FAST,
    "high shoulder, fast tool": CHOSEN | HIGH | FAST,
    "slow vehicle": CHOSEN | SLOW,
}
"""Readings that are looked at with ten seeds. A shoulder 0.3 m high, a tool of 1.5 m/s and a slow vehicle were known
from trials to move the sizes of networks; they were written down on 2026-12-01, before these runs."""

LOOPS = {"w": ("chosen", "high shoulder"), "KCI": ("chosen", "fast tool", "slow vehicle")}
"""Readings of which both loops are run with every size and every spread."""

TESTED = 1000
PRINTED = {"w": (8, 149), "KCI": (25, 142)}
THRESHOLDS = {"w": 1e-2, "KCI": 1e-4}
SPREAD, MOST_BELLS = 8.9, 300
"""Of Table 3 and section 4.4: test points; neurons and bells of the printed networks; mean square errors below which
bells are tested; the spread for KCI; and an assumed limit of bells."""

SIZES = (*range(1, 17), 18, 20, 22, 25, 30, 40, 60, 100)
"""Feed-forward networks that the loop tries up to the printed limit; above sixteen neurons not every size."""

SPREADS = (0.1, 0.2, 0.3, 0.5, 0.7, 1.0, 1.5, 2.0, 3.0, 4.5, 6.5, SPREAD)
COARSE = {
    "sizes": (*range(1, 11), 12, 14, 17, 20, 25, 32, 40, 60, 100),
    "spreads": (0.1, 0.2, 0.3, 0.5, 1.0, 2.0, 4.0, 6.5, SPREAD),
}
"""Sizes and spreads of the whole design, where a printed number counts as met within a factor of two."""

FIRST = (0.1, 0.3, 0.5, 1.0)
"""Spreads that the radial-basis loop tries in turn, and those that it may begin with."""

SMALL = {
    "repetitions": 1,
    "tested": 60,
    "sizes": (1, 2),
    "spreads": (1.0, SPREAD),
    "bells": 8,
    "epochs": 4,
    "rows": 150,
}


@experiment(seeds=BLOCKS, keys=("number", "repetition"), smoke={"block": 1, **SMALL}, **OF_DATA)
def design(seed: int, block: int = BLOCK, repetitions: int = 3, **effort: Any) -> Rows:
    """A block of readings that fill the space of all factors, each with several draws of data and weights."""
    for number in range(seed * block, (seed + 1) * block):
        for repetition in range(repetitions):
            row = _pipeline(reading(number), 1000 * number + repetition, **{**COARSE, **effort})
            yield {"number": number, "repetition": repetition, **row}


@experiment(seeds=len(ALONE), keys=("change", "repetition"), smoke=SMALL, **OF_DATA)
def alone(seed: int, repetitions: int = 3, **effort: Any) -> Rows:
    """Each factor alone; readings share their draws, so that they differ by the factor and nothing else."""
    name, values = ALONE[seed]
    for repetition in range(repetitions):
        yield {"change": name, "repetition": repetition, **_pipeline(values, repetition, **effort)}


@experiment(
    seeds=10,
    keys=("case",),
    smoke={key: value for key, value in SMALL.items() if key != "repetitions"},
    **OF_DATA,
)
def named(seed: int, **effort: Any) -> Rows:
    """The readings that matter, each with several seeds."""
    for name, values in NAMED.items():
        yield {"case": name, **_pipeline(values, seed, **effort)}


@experiment(
    seeds=10,
    keys=("index", "case", "kind", "step"),
    smoke={"neurons": 2, "epochs": 4, "spread_step": 5.0, "bells": 8, "tested": 60, "rows": 150},
    **OF_DATA,
)
def loops(
    seed: int,
    neurons: int = 100,
    epochs: int = 100,
    spread_step: float = 0.1,
    bells: int = MOST_BELLS,
    tested: int = TESTED,
    rows: int | None = None,
) -> Rows:
    """Figs. 6a and 6b as printed: every size up to 100 and every spread up to 10, to the first network that passes."""
    for index, cases in LOOPS.items():
        for name in cases:
            case = Case(NAMED[name], index, seed, tested, rows)
            both = {
                "feed-forward": _every_size(case, neurons, epochs),
                "radial basis": _every_spread(case, spread_step, bells),
            }
            for kind, steps in both.items():
                for number, step in enumerate(steps, start=1):
                    yield {"index": index, "case": name, "kind": kind, "step": number, **step}
                    if step["passes"]:
                        break


def _every_size(case: Case, neurons: int, epochs: int) -> Rows:
    learning = FeedForwardLearning(case, epochs)
    for size in range(1, neurons + 1):
        error = largest_relative_error(learning.trained(size).network, case.problem.data.test)
        yield {"neurons": size, "spread": math.nan, "testing_error": error, "passes": error <= LIMIT}


def _every_spread(case: Case, step: float, bells: int) -> Rows:
    options = RadialBasisOptions(
        error_threshold=THRESHOLDS[case.name], first_spread=step, spread_step=step, neuron_limit=bells
    )
    for spread in options.spreads:
        grown = grow(case.problem, spread, options)
        found = {"neurons": grown.neurons, "spread": spread, "testing_error": min(grown.testing_errors)}
        yield {**found, "passes": grown.success}


def reading(number: int) -> Values:
    """Return a reading of the space-filling design: a scrambled Sobol sequence of 256 points."""
    point = qmc.Sobol(len(FACTORS), rng=DESIGN_SEED).random_base2(8)[number]
    return {factor.name: factor.at(float(u)) for factor, u in zip(FACTORS, point, strict=True)}


def _pipeline(
    values: Values,
    seed: int,
    *,
    tested: int = TESTED,
    sizes: Sequence[int] = SIZES,
    spreads: Sequence[float] = SPREADS,
    bells: int = MOST_BELLS,
    epochs: int = 100,
    rows: int | None = None,
) -> Row:
    """Draw the data of a reading, run the four loops, and train networks of the printed sizes."""
    found: Row = dict(values)
    for name in GOALS:
        case = Case(values, name, seed, tested, rows)
        learning = FeedForwardLearning(case, epochs)
        parts = (case.facts(), learning.loop(sizes), learning.of_printed_size(), _bells(case, spreads, bells))
        for part in parts:
            found |= {f"{name}_{key}": value for key, value in part.items()}
    return found


@dataclass(frozen=True)
class Case:
    """An index under a reading, with its data."""

    values: Values
    name: str
    seed: int
    tested: int
    rows: int | None

    @cached_property
    def chain(self) -> Chain:
        """The system."""
        l2 = float(self.values["l2"])
        speed, vehicle, arm = (
            float(self.values[key]) for key in ("vehicle_speed", "vehicle_rate", "arm_rate")
        )
        rates = [speed] * 3 + [vehicle] * 3 + [arm] * 6
        return robots.uvms(l1=float(self.values["l1"]), l2=l2, l3=1.0 - l2, rates=rates)

    @cached_property
    def index(self) -> Index:
        """The index."""
        if self.name == "w":
            return Index("manipulability")
        tool = (float(self.values["tool_speed"]),) * 3 + (1.0,) * 3
        frame = cast(Frame, self.values["frame"])
        return Index("kinematic_conditioning", frame=frame, tool_rates=tool)

    @cached_property
    def space(self) -> Space:
        """Where configurations are drawn."""
        space: Box | TaskSector = sampling.uvms_space(self.index.name)
        if isinstance(space, Box):
            if self.values["vehicle_angle"] == 0.0:
                return _with_upright_vehicle(space, range(3, 6))
            return space
        azimuth, elevation = (math.radians(float(self.values[key])) for key in ("azimuth", "elevation"))
        l1, ahead = float(self.values["l1"]), float(self.values["ahead"])
        rest = space.rest
        if self.values["vehicle_angle"] == 0.0:
            rest = _with_upright_vehicle(rest, range(3))
        return replace(
            space,
            task_point=(0.0, ahead, l1),
            base_offset=(0.0, space.base_offset[1], l1),
            azimuth=azimuth,
            elevation=elevation,
            rest=rest,
        )

    @cached_property
    def problem(self) -> DesignProblem:
        """Its data sets, and what networks see."""
        rows = self.rows or round(float(self.values[f"rows_{self.name}"]))
        sets = sampling.data_sets(
            self.index.bind(self.chain),
            self.space,
            train=rows,
            test=self.tested,
            validation=self.tested,
            seed=self.seed,
        )
        if self.values["test_points"] == "uniform":
            sets = DataSets(sets.train, sets.validation, sets.test)
        moving = (sets.train.q.amax(0) > sets.train.q.amin(0)).nonzero().flatten().tolist()
        return DesignProblem(View(self.chain.joints, moving), sets)

    def facts(self) -> Row:
        """What can be said of the index alone: its range, and how far simple answers go."""
        data, view = self.problem.data, self.problem.view
        lowest, highest = data.train.values.aminmax()
        simple: dict[str, Function] = {"constant": baselines.constant(data.train)}
        if len(data.train.q) > _TERMS:
            simple["cubic"] = baselines.polynomial(view, data.train, 3)
        errors = {name: largest_relative_error(answer, data.test) for name, answer in simple.items()}
        return {"lowest": lowest, "highest": highest, **errors, **self._kinks()}

    def _kinks(self) -> Row:
        """Share of configurations where the two smallest singular values nearly meet."""
        if self.name == "w":
            return {}
        q = self.problem.data.train.q
        jacobian = getattr(self.chain, f"{self.values['frame']}_jacobian")(q)
        tool = torch.tensor(self.index.tool_rates, dtype=torch.float64)
        sigma = torch.linalg.svdvals(jacobian * self.chain.rates / tool[:, None])
        return {"kinks": (sigma[..., 4] < 1.02 * sigma[..., 5]).double().mean()}


_TERMS = 400  # of a cubic in eleven inputs there are 364


@dataclass(frozen=True)
class FeedForwardLearning:
    """How feed-forward networks are trained under a reading."""

    case: Case
    epochs: int

    def loop(self, sizes: Sequence[int]) -> Row:
        """Run Fig. 6a to the first network that passes or to the limit; a limit is no end."""
        test, best = self.case.problem.data.test, math.inf
        for neurons in sizes:
            error = largest_relative_error(self.trained(neurons).network, test)
            best = min(best, error)
            if error <= LIMIT:
                break
        return {"ff_neurons": neurons, "ff_passes": error <= LIMIT, "ff_best": best}

    def of_printed_size(self) -> Row:
        """Errors of the printed size with the printed goal and without one."""
        size, data = PRINTED[self.case.name][0], self.case.problem.data
        printed, on = self.trained(size), self.trained(size, goal=0.0)
        return {
            "ff_printed_error": largest_relative_error(printed.network, data.test),
            "ff_printed_epochs": printed.epochs,
            "ff_error": largest_relative_error(on.network, data.test),
            "ff_mse": on.mean_square_error,
        }

    def trained(self, neurons: int, goal: float | None = None) -> Training:
        """Train one network as the reading says."""
        rows, values = self.case.problem.data.train, self.case.values
        kept, held_out = rows, None
        if values["stopping"] == "validation":
            # The toolbox holds back 15 % to stop by and 15 % that it does not look at.
            cut = round(0.7 * len(rows.q)), round(0.85 * len(rows.q))
            kept = DataSet(rows.q[: cut[0]], rows.values[: cut[0]])
            held_out = DataSet(rows.q[cut[0] : cut[1]], rows.values[cut[0] : cut[1]])
        seed = 1000 * self.case.seed + neurons
        (network,) = train.initial_networks(self.case.problem.view, neurons, kept.q, kept.values, [seed])
        if values["scaling"] == "none":
            network = _without_scaling(network)
        options = Options(
            GOALS[self.case.name] if goal is None else goal,
            self.epochs,
            cast(Damping, values["damping"]),
        )
        return levenberg_marquardt(network, kept.q, kept.values, options, held_out=held_out)


def _bells(case: Case, spreads: Sequence[float], bells: int) -> Row:
    """Run Fig. 6b at all spreads, and tell where it ends for each spread that it may begin with."""
    size, threshold = PRINTED[case.name][1], THRESHOLDS[case.name]
    printed = RadialBasisOptions(
        training_goal=0.0, error_threshold=threshold, neuron_limit=bells, input_scale=_input_scale(case)
    )
    tried = [grow(case.problem, spread, printed) for spread in spreads]
    passing = [one for one in tried if one.success]
    found: Row = {
        "rb_best": min(min(one.testing_errors) for one in tried),
        "rb_fewest": min((one.neurons for one in passing), default=0),
    }
    for first in FIRST:
        end = next((one for one in passing if one.spread >= first), None)
        found[f"rb_neurons_from_{first:g}"] = end.neurons if end else 0
        found[f"rb_spread_from_{first:g}"] = end.spread if end else math.nan
    at = grow(case.problem, SPREAD, replace(printed, testing_error=0.0, neuron_limit=min(bells, size)))
    return {
        **found,
        "rb_printed_error": at.testing_errors[-1],
        "rb_printed_mse": at.mean_square_errors[-1],
        "rb_at_printed_spread": tried[-1].neurons if tried[-1].success else 0,
    }


def _input_scale(case: Case) -> float | tuple[float, ...]:
    if case.values["unit"] == "degrees":
        # Translations are in metres whatever the unit of angles.
        return tuple(1.0 if joint < 3 else math.degrees(1) for joint in case.problem.view.inputs)
    if case.values["unit"] == "range":
        x = case.problem.view(case.problem.data.train.q)
        return tuple((2 / (x.amax(0) - x.amin(0))).tolist())
    return 1.0


def _with_upright_vehicle(space: Box, joints: Sequence[int]) -> Box:
    lower, upper = list(space.lower), list(space.upper)
    for joint in joints:
        lower[joint] = upper[joint] = 0.0
    levels = [7] * sum(a < b for a, b in zip(lower, upper, strict=True))
    return Box(lower, upper, levels)


def _without_scaling(network: FeedForward) -> FeedForward:
    """Return a network of the same hidden units whose weights act on joint values and answer in the index itself."""
    state = network.state_dict()
    arrays: dict[str, Tensor] = {name: value for name, value in state.items() if "." not in name}
    weights = arrays["hidden_weights"] / arrays["input_half_range"]
    arrays["hidden_biases"] = arrays["hidden_biases"] - weights @ arrays["input_centre"]
    arrays["hidden_weights"] = weights
    for name, value in {"input_centre": 0.0, "input_half_range": 1.0, "target_centre": 0.0}.items():
        arrays[name] = torch.full_like(arrays[name], value)
    arrays["target_half_range"] = torch.ones_like(arrays["target_half_range"])
    return FeedForward(network.view, network.readout, arrays)
