"""Paper A, section 4.5 and Table 5: how long exact indices and networks take.

First as the paper measured it, in kind: the exact index in a Python loop over the Jacobian as a symbolic
toolbox writes it out, a network for all configurations at once. Then like for like: on each rung of a ladder
both sides have the same language and get the same configurations in the same way. Networks have random
weights and the printed sizes, since a trained one takes the same time; those that come with the package
stand beside them, in torch and in C.

What decides a verdict was set beforehand. A time or a factor within the rounding of the printed one is
*reproduced*, one within a factor of three of it is *in shape*. An ordering that holds in kind and on every
rung is *reproduced*; one that holds in kind, and fails on a rung where the quartiles lie apart, is
*contradicted* where it is about networks against exact indices, and *in shape* where it is about networks
alone. Whether times follow operations is judged by Kendall's τ in kind. The time of singular values varies
with the configuration if slowest over quickest, by first quartiles, is at least 1.5 times (*reproduced*) or
1.1 times (*in shape*) what it is among as many copies of one configuration, timed in turn with them. The time
saved in an iteration of a planner is *contradicted* if the paper's own times do not save it with the largest
number of configurations that its words allow.
"""

from __future__ import annotations

import ctypes
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any, TypeAlias

import numpy as np
import torch
from numpy.typing import NDArray
from scipy.stats import kendalltau
from torch import Tensor

from dexterity import networks, robots, sampling, symbolic
from dexterity.codegen.c99 import function_name
from dexterity.codegen.library import compiled_library
from dexterity.indices import Index
from dexterity.networks import export
from dexterity.networks.feed_forward import FeedForward
from dexterity.networks.folding import Bells, folded
from dexterity.networks.network import Network, View
from dexterity.networks.radial_basis import RadialBasis
from dexterity.report.claims import Acceptance, Outcome, Paper, Verdict, load_paper
from dexterity.report.stored import Tolerance
from dexterity.studies.uvms import cost
from dexterity.symbolic import SymbolicChain
from dexterity.timing import Ratio, Timing, Way, measure, ratio
from dexterity.timing.instructions import instructions_per_configuration

__all__ = [
    "CONFIGS",
    "SEVERAL_HUNDRED",
    "TOLERANCE",
    "Config",
    "Result",
    "acceptance",
    "advantages",
    "foot",
    "instruction_table",
    "planner",
    "printed_ratios",
    "run",
    "table_5",
    "verdicts",
]

Array: TypeAlias = NDArray[np.float64]
"""Numbers."""

TOLERANCE = Tolerance(rtol=1e-6, atol=1e-6)
"""What a probe may miss by; it takes no times."""

SEVERAL_HUNDRED = (200, 900)
"""Configurations that a planner evaluates in a cycle, as the paper's words are read."""

EXACT, FEED_FORWARD, RADIAL_BASIS = "exact", "feed-forward", "radial-basis"
_IN_KIND = "as in the paper"


@dataclass(frozen=True)
class Config:
    """What is timed, and how long.

    Attributes
    ----------
    feed_forward_neurons, radial_basis_neurons
        Hidden neurons for w and for KCI. The last one is not printed.
    seed
        Of configurations, within the paper's spaces, and of weights.
    configurations, many
        Sizes of a batch: the paper's test set, and one large enough that nothing but arithmetic counts.
    in_loops
        How many of the configurations a Python loop gets.
    singular_values
        For how many single Jacobians the singular values are timed.
    rounds, seconds
        How often each way gets its turn, and for how long at least [s]; no times without rounds.
    count_instructions
        Whether instructions are counted, where the machine can.
    """

    feed_forward_neurons: tuple[int, int] = (8, 25)
    radial_basis_neurons: tuple[int, int] = (149, 142)
    seed: int = 0
    configurations: int = 1000
    many: int = 100_000
    in_loops: int = 50
    singular_values: int = 30
    rounds: int = 5
    seconds: float = 0.02
    count_instructions: bool = True


CONFIGS: Mapping[str, Config] = {
    "smoke": Config(
        configurations=40, many=60, in_loops=3, singular_values=0, rounds=0, count_instructions=False
    ),
    "book": Config(),
    "full": Config(in_loops=100, rounds=25, seconds=0.01),
}
"""What runs at each scale."""


@dataclass(frozen=True)
class Result:
    """Times and instructions. What belongs to one index stands under `"w"` or `"KCI"`.

    Attributes
    ----------
    sizes
        Neurons and inputs of each network.
    in_kind
        The exact index in a loop and the two networks at once, as the paper had them; empty if no times
        were taken.
    ladder
        By rung, the exact index and the networks in the same language and batches.
    instructions
        Of generated C for each configuration; empty if they were not counted.
    singular_values, same_values
        A time for each Jacobian, one at a time in LAPACK, and as many times for the first of them.
    errors
        Largest relative deviation of a way from the exact index by singular values, or from the network in
        torch.
    """

    sizes: Mapping[str, Mapping[str, tuple[int, int]]]
    in_kind: Mapping[str, tuple[Timing, ...]]
    ladder: Mapping[str, Mapping[str, tuple[Timing, ...]]]
    instructions: Mapping[str, Mapping[str, float]]
    singular_values: tuple[Timing, ...]
    same_values: tuple[Timing, ...]
    errors: Mapping[str, float]


def run(config: Config) -> Result:
    """Build both sides in every language, compare what they compute, time them, and count."""
    symbols = SymbolicChain.from_description(robots.describe("uvms"))
    jacobians = cost.Jacobians(cost.written_out(symbols).flat(), cost.lengths_of(symbols))
    contests = {name: _Contest(name, jacobians, config) for name in cost.INDICES}
    single = _timed(contests["KCI"].single_values(), config)
    return Result(
        sizes={
            name: {side.name: (side.network.neurons, side.network.view.width) for side in contest.networks}
            for name, contest in contests.items()
        },
        in_kind={name: _timed(contest.in_kind(), config) for name, contest in contests.items()},
        ladder={
            name: {rung: _timed(ways, config) for rung, ways in contest.rungs().items()}
            for name, contest in contests.items()
        },
        instructions={
            name: contest.instructions() if config.count_instructions else {}
            for name, contest in contests.items()
        },
        singular_values=single[: config.singular_values],
        same_values=single[config.singular_values :],
        errors={name: contest.error() for name, contest in contests.items()},
    )


def _timed(ways: Sequence[Way], config: Config) -> tuple[Timing, ...]:
    return measure(ways, config.rounds, config.seconds) if config.rounds and ways else ()


# ---- both sides in every language ------------------------------------------------------------------


class _Side(ABC):
    """An exact index or a network, in every language.

    Attributes
    ----------
    name
        Which side it is.
    reference, in_torch, in_c
        Functions of configurations (m, n): what the others are compared with, in torch, and in C.
    source, function
        The C file, and what its functions begin with.
    """

    name: str
    reference: Callable[[Tensor], Tensor]
    in_torch: Callable[[Tensor], Tensor]
    in_c: Callable[[Tensor], Tensor]
    source: str
    function: str

    @abstractmethod
    def one(self, q: Array) -> Any:
        """Value of one configuration (n) in numpy."""

    @abstractmethod
    def at_once(self, q: Array) -> Any:
        """Values of configurations (m, n) in numpy."""


class _Exact(_Side):
    """An exact index: in numpy through its Jacobian, in torch and C generated."""

    def __init__(self, index: Index, jacobians: cost.Jacobians) -> None:
        chain = robots.uvms()
        self.name = EXACT
        self.reference = index.bind(chain)
        self.in_torch = symbolic.compile_index(chain, index, "torch")
        self.in_c = symbolic.compile_index(chain, index, "c")
        self.source = symbolic.cached_c_source(chain, index)
        self.function = function_name(chain.name, index.name)
        self._jacobians = jacobians
        self._of_jacobian = cost.MEASURES[index.name]

    def written_out(self, q: Array) -> Any:
        """Value of one configuration, its Jacobian term by term."""
        return self._of_jacobian(np.reshape(self._jacobians.written(*q), (6, -1)))

    def one(self, q: Array) -> Any:
        return self._of_jacobian(self.jacobian(q))

    def jacobian(self, q: Array) -> Array:
        """Jacobian (6, n) of one configuration, terms shared."""
        return np.reshape(self._jacobians.shared(*q), (6, -1))

    def at_once(self, q: Array) -> Any:
        return self._of_jacobian(self._jacobians.at_once(q))


class _Approximate(_Side):
    """A network: in numpy its equation, in torch and C as it is."""

    def __init__(self, name: str, network: Network) -> None:
        self.name = name
        self.network = network
        self.reference = self.in_torch = torch.no_grad()(network)
        self.in_c = export.compile_network(network)
        self.function = "network"
        self.source = export.c_source(network, self.function)
        self._at_once = _in_numpy(network)

    def one(self, q: Array) -> Any:
        return self._at_once(q)

    def at_once(self, q: Array) -> Any:
        return self._at_once(q)


def _in_numpy(network: Network) -> Callable[[Array], Any]:
    """Equation of a network that sees joints alone and answers with its output itself."""
    inputs, weights = list(network.inputs), folded(network)
    if isinstance(weights, Bells):
        bases, squares = weights.centres.T, (weights.centres**2).sum(1)

        def bells(q: Array) -> Any:
            x = q[..., inputs] * weights.scale
            apart = (x**2).sum(-1)[..., None] + squares - 2 * x @ bases
            return np.exp(-apart) @ weights.output + weights.output_bias

        return bells
    hidden, output = weights.hidden.T, weights.output[0]
    return lambda q: (
        np.tanh(q[..., inputs] @ hidden + weights.hidden_biases) @ output + weights.output_biases[0]
    )


class _Contest:
    """An index and the networks for it, with the configurations that they are given."""

    def __init__(self, name: str, jacobians: cost.Jacobians, config: Config) -> None:
        index, number = cost.INDICES[name], list(cost.INDICES).index(name)
        random = torch.Generator().manual_seed(config.seed)
        q = sampling.uniform(sampling.uvms_space(index.name), config.many, random)
        self._many, self._some, self._few = q, q[: config.configurations], q[: config.in_loops]
        self._single = q[: config.singular_values].numpy()
        self._exact = _Exact(index, jacobians)
        view = View(q.shape[1], sampling.relevant_joints(robots.uvms(), index))
        neurons = config.feed_forward_neurons[number], config.radial_basis_neurons[number]
        self._printed = (
            _Approximate(FEED_FORWARD, _feed_forward(view, neurons[0], self._some, random)),
            _Approximate(RADIAL_BASIS, _radial_basis(view, neurons[1], random)),
        )
        begin = f"uvms-{index.name.replace('_', '-')}-"
        self._shipped = tuple(
            _Approximate(shipped.replace(begin, "shipped "), networks.load_shipped(shipped))
            for shipped in networks.shipped()
            if shipped.startswith(begin)
        )

    @property
    def networks(self) -> tuple[_Approximate, ...]:
        """Networks of the printed sizes, and those that come with the package."""
        return (*self._printed, *self._shipped)

    def in_kind(self) -> tuple[Way, ...]:
        """Ways as the paper had them."""
        exact = _looping(self._exact.written_out, self._few.numpy())
        some = self._some.numpy()
        return (
            Way(EXACT, exact, len(self._few)),
            *(Way(side.name, _calling(side.at_once, some), len(some)) for side in self._printed),
        )

    def rungs(self) -> dict[str, tuple[Way, ...]]:
        """Ways of all sides, from a loop in Python to C on many configurations."""
        few, some, many = self._few, self._some, self._many
        printed: tuple[_Side, ...] = (self._exact, *self._printed)
        every: tuple[_Side, ...] = (self._exact, *self.networks)
        at_once, lots = f"{len(some):,} at once", f"{len(many):,} at once"
        return {
            "numpy, one by one": _ways(printed, lambda side: _looping(side.one, few.numpy()), few),
            f"numpy, {at_once}": _ways(printed, lambda side: _calling(side.at_once, some.numpy()), some),
            f"torch, {at_once}": _ways(every, lambda side: _calling(side.in_torch, some), some),
            f"torch, {lots}": _ways(every, lambda side: _calling(side.in_torch, many), many),
            "C from Python, one by one": _ways(every, lambda side: _looping(side.in_c, few), few),
            "C from C, one by one": _ways(every, lambda side: _in_c_one_by_one(side, some), some),
            f"C, {at_once}": _ways(every, lambda side: _calling(side.in_c, some), some),
            f"C, {lots}": _ways(every, lambda side: _calling(side.in_c, many), many),
        }

    def single_values(self) -> tuple[Way, ...]:
        """Singular values of one Jacobian after the other, and then of the first as often."""
        values = cost.MEASURES["kinematic_conditioning"]
        jacobians = [self._exact.jacobian(q) for q in self._single]
        jacobians += jacobians[:1] * len(jacobians)
        return tuple(Way(f"{i}", _calling(values, J), 1) for i, J in enumerate(jacobians))

    def instructions(self) -> dict[str, float]:
        """Instructions of generated C for each configuration, where they can be counted."""
        sides: tuple[_Side, ...] = (self._exact, *self.networks)
        counts = {side.name: instructions_per_configuration(side.source, side.function) for side in sides}
        return {name: count for name, count in counts.items() if count is not None}

    def error(self) -> float:
        """Largest relative deviation of a way from its side's reference."""
        sides: tuple[_Side, ...] = (self._exact, *self.networks)
        references = {side.name: side.reference(self._many).numpy() for side in sides}
        ways = [*self.in_kind(), *(way for own in self.rungs().values() for way in own)]
        return max(
            float(np.abs(np.asarray(way.compute()) / references[way.name][: way.configurations] - 1).max())
            for way in ways
        )


def _ways(
    sides: Sequence[_Side], computing: Callable[[_Side], Callable[[], object]], q: Tensor
) -> tuple[Way, ...]:
    return tuple(Way(side.name, computing(side), len(q)) for side in sides)


def _feed_forward(view: View, neurons: int, q: Tensor, random: torch.Generator) -> Network:
    values = 1 + torch.rand(len(q), generator=random, dtype=torch.float64)
    return FeedForward.untrained(view, neurons, q, values, random)


def _radial_basis(view: View, neurons: int, random: torch.Generator) -> Network:
    def drawn(*shape: int) -> Tensor:
        return torch.rand(*shape, generator=random, dtype=torch.float64)

    return RadialBasis(view, {
        "centres": drawn(neurons, view.width), "spread": 1.0, "output_weights": drawn(neurons),
        "output_bias": 1.0, "input_scale": torch.ones(view.width, dtype=torch.float64),
    })  # fmt: skip


def _calling(function: Callable[[Any], object], q: Any) -> Callable[[], object]:
    return lambda: function(q)


def _looping(function: Callable[[Any], Any], rows: Any) -> Callable[[], object]:
    return lambda: [float(function(row)) for row in rows]


def _in_c_one_by_one(side: _Side, q: Tensor) -> Callable[[], object]:
    """Return how a loop in C calls the function for one configuration."""
    run = compiled_library(_ONE_BY_ONE).one_by_one
    pointer, size = ctypes.c_void_p, ctypes.c_size_t
    run.argtypes = [pointer, pointer, size, size, pointer]
    function = ctypes.cast(getattr(compiled_library(side.source), side.function), pointer)
    values = q.new_empty(len(q))

    def compute() -> Tensor:
        run(function, q.data_ptr(), len(q), q.shape[1], values.data_ptr())
        return values

    return compute


_ONE_BY_ONE = """
#include <stddef.h>

typedef int (*function)(const double *q, double *value);

void one_by_one(function f, const double *q, size_t count, size_t joints, double *values);
void one_by_one(function f, const double *q, size_t count, size_t joints, double *values)
{
  for (size_t i = 0; i < count; ++i)
    f(q + i*joints, values + i);
}
"""


# ---- what is shown ---------------------------------------------------------------------------------


def table_5(result: Result) -> dict[str, dict[str, float]]:
    """Return the times of Table 5 for a thousand configurations [ms], the paper's and ours in kind.

    The paper's times of the networks are read as those for w.
    """
    claims = {
        "w": {EXACT: "analytical-w-time", **{kind: f"{kind}-time" for kind in (FEED_FORWARD, RADIAL_BASIS)}},
        "KCI": {EXACT: "analytical-kci-time"},
    }
    return {
        f"{name}, {timing.name}": {
            "paper": 1e3 * _printed(claims[name][timing.name]) if timing.name in claims[name] else np.nan,
            "ours": 1e6 * timing.median,
            "first quartile": 1e6 * timing.lower,
            "third quartile": 1e6 * timing.upper,
        }
        for name, timings in result.in_kind.items()
        for timing in timings
    }


def printed_ratios() -> dict[str, float]:
    """How many times faster each kind of network is than the exact w, by the printed times."""
    return {
        side: _printed("analytical-w-time") / _printed(f"{side}-time")
        for side in (FEED_FORWARD, RADIAL_BASIS)
    }


def advantages(result: Result) -> dict[str, dict[str, dict[str, Ratio]]]:
    """How many times faster than the exact index each network is, by index, then by rung.

    The first rung is the paper's, the exact index in a loop and a network at once.
    """
    return {
        name: {
            rung: {timing.name: ratio(timings[0], timing) for timing in timings[1:]}
            for rung, timings in {_IN_KIND: result.in_kind[name], **result.ladder[name]}.items()
            if timings
        }
        for name in result.ladder
    }


def foot(result: Result) -> dict[str, dict[str, float]]:
    """Return medians and quartiles [ns] for a configuration on the last rung."""
    return {
        f"{name}, {timing.name}": {
            "median": 1e9 * timing.median,
            "first quartile": 1e9 * timing.lower,
            "third quartile": 1e9 * timing.upper,
        }
        for name, rungs in result.ladder.items()
        for timing in list(rungs.values())[-1]
    }


def instruction_table(result: Result) -> dict[str, dict[str, float]]:
    """Instructions for each configuration, and how many times more the exact index takes, by side.

    Empty where they were not counted.
    """
    return {
        f"{name}, {side}": {"instructions": count, "exact over it": counts[EXACT] / count}
        for name, counts in result.instructions.items()
        for side, count in counts.items()
    }


def planner(result: Result) -> dict[str, dict[str, float]]:
    """Return the time [ms] that a feed-forward network for w saves in a cycle of a planner."""
    saved = {"by the paper's times": _printed_saving()}
    if result.in_kind["w"]:
        saved["in kind"] = _saving(result.in_kind["w"])
        best = list(result.ladder["w"])[-1]
        saved["like for like, in C"] = _saving(result.ladder["w"][best])
    return {
        way: {f"{count} configurations": 1e3 * count * seconds for count in SEVERAL_HUNDRED}
        for way, seconds in saved.items()
    }


def _saving(timings: Sequence[Timing]) -> float:
    """Seconds saved a configuration by the feed-forward network."""
    medians = {timing.name: timing.median for timing in timings}
    return medians[EXACT] - medians[FEED_FORWARD]


# ---- verdicts --------------------------------------------------------------------------------------

_PAPER = "sotiropoulos2016"
_SHAPE = 3.0
_TIMED = (
    "analytical-w-time", "analytical-kci-time", "feed-forward-time", "radial-basis-time",
    "networks-faster-than-analytical", "feed-forward-hundredfold", "radial-basis-tenfold",
    "ten-to-hundredfold", "feed-forward-fastest", "times-follow-operations", "kci-time-varies",
    "slightest-gain-counts",
)  # fmt: skip


def verdicts(result: Result) -> tuple[Verdict, ...]:
    """Judge the claims of the ledger that this study answers for."""
    settled = (*_on_settings(), *_on_planners())
    if not result.in_kind["w"]:
        untimed = (_verdict(claim, Outcome.UNDERSPECIFIED, "No times were taken.") for claim in _TIMED)
        return (*settled, *untimed)
    return (
        *settled,
        *_on_times(result),
        *_on_factors(result),
        *_on_orderings(result),
        *_on_causes(result),
    )


def _on_settings() -> tuple[Verdict, ...]:
    settings = {
        "timing-runs": "Taken over at full scale; a median and quartiles stand for the mean.",
        "timing-inputs": "Taken over for what is computed at once.",
        "timing-machine": "Another machine and another language here: what counts are ratios within one run.",
    }
    return tuple(_verdict(claim, Outcome.OUT_OF_SCOPE, text) for claim, text in settings.items())


def _on_planners() -> tuple[Verdict, ...]:
    fewest, most = SEVERAL_HUNDRED
    saved, claimed = _printed_saving(), _printed("second-saved-per-iteration")
    return (
        _verdict(
            "hundreds-of-configurations", Outcome.UNDERSPECIFIED,
            "No planner is given; it is taken as a number to calculate with.",
            f"{fewest} to {most} configurations",
        ),
        _verdict(
            "second-saved-per-iteration",
            Outcome.CONTRADICTED if most * saved < claimed else Outcome.REPRODUCED,
            f"By the paper's own times several hundred configurations save {fewest * saved:.2f} to "
            f"{most * saved:.2f} s; a second takes {claimed / saved:,.0f} of them.",
            f"{most * saved:.2f} s at most",
        ),
    )  # fmt: skip


def _on_times(result: Result) -> tuple[Verdict, ...]:
    rows = {
        "analytical-w-time": result.in_kind["w"][0], "analytical-kci-time": result.in_kind["KCI"][0],
        "feed-forward-time": result.in_kind["w"][1], "radial-basis-time": result.in_kind["w"][2],
    }  # fmt: skip
    why = {
        EXACT: "the Jacobian is written out term by term and called in a loop",
        FEED_FORWARD: "all configurations go into one product of matrices, with no toolbox around it",
        RADIAL_BASIS: "all configurations go into one product of matrices, with no toolbox around it",
    }
    return tuple(_on_time(claim, timing, why[timing.name]) for claim, timing in rows.items())


def _on_time(claim: str, timing: Timing, why: str) -> Verdict:
    lower, median, upper = (
        _printed("timing-inputs") * time for time in (timing.lower, timing.median, timing.upper)
    )
    return _verdict(
        claim, _closeness(median, claim),
        f"The printed time is {_printed(claim) / median:.3g} times ours; {why}.",
        f"{median:.3g} s", f"quartiles {lower:.3g} and {upper:.3g} s",
    )  # fmt: skip


def _on_factors(result: Result) -> tuple[Verdict, ...]:
    factors, printed = advantages(result), printed_ratios()
    in_kind = {side: {name: own[_IN_KIND][side].value for name, own in factors.items()} for side in printed}
    alike = {name: list(own.values())[-1] for name, own in factors.items()}
    every = [value for own in in_kind.values() for value in own.values()]
    compiled = [own[side].value for own in alike.values() for side in printed]
    low, high = _printed_span("ten-to-hundredfold")
    span = f"{min(every):,.0f} to {max(every):,.0f}"
    return (
        *(
            _verdict(
                claim, _closeness(in_kind[side]["w"], claim),
                f"In kind {in_kind[side]['w']:,.0f} (w) and {in_kind[side]['KCI']:,.0f} (KCI), where the "
                f"printed times give {printed[side]:.0f}. Like for like, in C and at once: "
                f"{alike['w'][side]} and {alike['KCI'][side]}.",
                f"{in_kind[side]['w']:,.0f} times",
            )
            for claim, side in (
                ("feed-forward-hundredfold", FEED_FORWARD), ("radial-basis-tenfold", RADIAL_BASIS)
            )
        ),
        _verdict(
            "ten-to-hundredfold", Outcome.of(low <= min(every) and max(every) <= high),
            f"The factor is what the languages of the two sides make it: {span} in kind, "
            f"{min(compiled):.2g} to {max(compiled):.2g} in C on both sides. The paper's own times give "
            f"{' and '.join(f'{value:.0f}' for value in printed.values())}.",
            f"{span} times",
        ),
    )  # fmt: skip


def _on_orderings(result: Result) -> tuple[Verdict, ...]:
    kinds = tuple(printed_ratios())
    factors = {(name, rung): own for name, rungs in advantages(result).items() for rung, own in rungs.items()}
    in_kind = all(
        own[kind].value > 1 for (_, rung), own in factors.items() for kind in kinds if rung == _IN_KIND
    )
    rungs = {place: own for place, own in factors.items() if place[1] != _IN_KIND}
    slower = {kind: sum(_is_slower(own[kind]) for own in rungs.values()) for kind in kinds}
    beaten = [place for place, timings in _by_place(result).items() if _is_beaten(timings, FEED_FORWARD)]
    faster = Outcome.CONTRADICTED if any(slower.values()) else Outcome.REPRODUCED
    fastest = Outcome.IN_SHAPE if beaten else Outcome.REPRODUCED
    exceptions = f"; not for {', '.join(' '.join(place) for place in beaten)}" if beaten else ""
    fewer = [
        result.sizes[name][RADIAL_BASIS][0] / result.sizes[name][FEED_FORWARD][0] for name in result.sizes
    ]
    return (
        _verdict(
            "networks-faster-than-analytical", faster if in_kind else Outcome.NOT_REPRODUCED,
            f"{'True' if in_kind else 'Not even true'} as the paper measured it. With one language on both "
            f"sides, of {len(rungs)} rungs the feed-forward network is slower than the exact index on "
            f"{slower[FEED_FORWARD]}, and the radial-basis network on {slower[RADIAL_BASIS]}.",
            f"slower on {slower[FEED_FORWARD]} and {slower[RADIAL_BASIS]} rungs",
        ),
        _verdict(
            "feed-forward-fastest", fastest if in_kind else Outcome.NOT_REPRODUCED,
            f"Not beaten by the other two in {len(factors) - len(beaten)} of {len(factors)} comparisons"
            f"{exceptions}. It has {fewer[0]:.0f} (w) and {fewer[1]:.0f} (KCI) times fewer neurons than the "
            "radial-basis network.",
            f"{len(factors) - len(beaten)} of {len(factors)}",
        ),
    )  # fmt: skip


def _is_slower(advantage: Ratio) -> bool:
    return advantage.distinguishable and advantage.value < 1


def _by_place(result: Result) -> dict[tuple[str, str], tuple[Timing, ...]]:
    """Return times of the exact index and the printed networks, by index and rung."""
    ladders = {name: {_IN_KIND: result.in_kind[name], **own} for name, own in result.ladder.items()}
    return {(name, rung): own[:3] for name, ladder in ladders.items() for rung, own in ladder.items()}


def _is_beaten(timings: Sequence[Timing], name: str) -> bool:
    """Whether another is faster, its quartiles apart."""
    (own,) = (timing for timing in timings if timing.name == name)
    return any(timing.upper < own.lower for timing in timings)


def _on_causes(result: Result) -> tuple[Verdict, ...]:
    compiled = {name: list(own.values())[-1] for name, own in result.ladder.items()}
    in_kind, alike = _follows(result.in_kind), _follows(compiled)
    different, same = _spread(result.singular_values), _spread(result.same_values)
    varies = different / same
    most = SEVERAL_HUNDRED[1]
    gain = 1e6 * most * max(_saving(timings) for timings in compiled.values())
    return (
        _verdict(
            "times-follow-operations", Outcome.of_correlation(in_kind),
            f"Six times against the six counts of Table 4 rank with τ = {in_kind:.2f} in kind, and with "
            f"{alike:.2f} where both sides are compiled: no program then takes the operations that the "
            "table gives the exact indices.",
            f"τ = {in_kind:.2f}",
        ),
        _verdict(
            "kci-time-varies",
            Outcome.REPRODUCED if varies >= 1.5
            else Outcome.IN_SHAPE if varies >= 1.1
            else Outcome.NOT_REPRODUCED,
            f"Of {len(result.singular_values)} configurations the slowest takes {different:.2f} times as "
            f"long as the quickest; as many copies of one configuration differ by {same:.2f} themselves.",
            f"{varies:.2f} times",
        ),
        _verdict(
            "slightest-gain-counts", Outcome.UNDERSPECIFIED,
            "How much of a cycle goes into the index is not said. Between compiled sides a feed-forward "
            f"network saves {gain:.0f} μs over {most} configurations.",
            f"{gain:.0f} μs",
        ),
    )  # fmt: skip


def _spread(timings: Sequence[Timing]) -> float:
    # What else the machine does moves a first quartile least.
    times = [timing.lower for timing in timings]
    return max(times) / min(times)


def _follows(timings: Mapping[str, Sequence[Timing]]) -> float:
    """Kendall's τ between the counts of Table 4 and the times of the exact indices and printed networks."""
    counts, times = [], []
    for name, own in timings.items():
        exact = "w-operations-table" if name == "w" else "kci-operations"
        for timing in own[:3]:
            counts.append(
                _printed(exact if timing.name == EXACT else f"{timing.name}-{name.lower()}-operations")
            )
            times.append(timing.median)
    return float(kendalltau(counts, times).statistic)


def _closeness(value: float, claim: str) -> Outcome:
    printed = _printed(claim)
    if abs(value - printed) <= (_paper().claim(claim).rounding or 0):
        return Outcome.REPRODUCED
    return Outcome.IN_SHAPE if printed / _SHAPE <= value <= printed * _SHAPE else Outcome.NOT_REPRODUCED


def _printed_saving() -> float:
    """Seconds a configuration that a feed-forward network saves, by the printed times."""
    return (_printed("analytical-w-time") - _printed("feed-forward-time")) / _printed("timing-inputs")


def _printed(claim: str) -> float:
    (value,) = _printed_numbers(claim)
    return value


def _printed_span(claim: str) -> tuple[float, float]:
    low, high = _printed_numbers(claim)
    return low, high


def _printed_numbers(claim: str) -> list[float]:
    value = _paper().claim(claim).value
    return [
        float(number) for number in (value if isinstance(value, tuple) else (value,)) if number is not None
    ]


@cache
def _paper() -> Paper:
    return load_paper(_PAPER)


def _verdict(claim: str, outcome: Outcome, sentence: str, ours: str = "", spread: str = "") -> Verdict:
    return Verdict(_PAPER, claim, outcome, ours, spread, sentence)


def acceptance(result: Result) -> tuple[Acceptance, ...]:
    """Figures that must hold for the book to be built."""
    return tuple(
        Acceptance(f"ways to {name} from each other, relative", error, 1e-9)
        for name, error in result.errors.items()
    )
