"""Times of exact indices and networks: as paper A measured them, and like for like in several languages.

Networks have the printed sizes and random weights, since a trained one takes the same time; the networks that come
with the package stand beside them in torch and C. The size of the radial-basis network for KCI is not printed.

Source: Sotiropoulos & Aspragathos (2016), section 4.5 and Table 5.
"""

from __future__ import annotations

import ctypes
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from typing import Any

import numpy as np
import torch
from torch import Tensor

from dexterity import networks, robots, sampling, symbolic
from dexterity.codegen.c99 import function_name
from dexterity.codegen.library import compiled_library
from dexterity.derivation import SymbolicChain
from dexterity.networks import export
from dexterity.networks.feed_forward import FeedForward
from dexterity.networks.folding import Bells, folded
from dexterity.networks.network import Network, View
from dexterity.networks.radial_basis import RadialBasis
from dexterity.timing import Timing, Way, measure
from dexterity.timing.instructions import instructions_per_configuration
from dexterity_study.engine.experiment import experiment
from dexterity_study.engine.table import Row
from dexterity_study.uvms.cost.experiment import (
    INDICES,
    Function,
    Jacobians,
    joint_symbols,
    lengths_of,
    symbolic_uvms,
    written_out,
)
from dexterity_study.uvms.timing import octave

EXACT, FEED_FORWARD, RADIAL_BASIS = "exact", "feed-forward", "radial-basis"
IN_KIND, SINGLY, FOOT = "as in the paper", "numpy, one by one", "C, many at once"
NEURONS = {"w": (8, 149), "KCI": (25, 142)}
OF_DATA = {"data": ("robots/uvms.toml", "networks")}
TIMES = {"timed": True, "unsteady": ("configurations", "lower", "median", "upper"), **OF_DATA}
SMALL = {"configurations": 40, "many": 60, "in_loops": 3}
BRIEF = {"rounds": 1, "seconds": 0.001}


@experiment(keys=("index", "rung", "side"), smoke=SMALL, atol=1e-6, **OF_DATA)
def agreement(seed: int, **sizes: int) -> Iterator[Row]:
    """Largest relative deviation of each way from the exact index by singular values, or the network in torch."""
    for index in INDICES:
        contest = Contest(index, seed, **sizes)
        references = {side.name: side.reference(contest.many).numpy() for side in contest.sides}
        for rung, ways in contest.rungs().items():
            for way in ways:
                values = np.asarray(way.compute()) / references[way.name][: way.configurations]
                yield {"index": index, "rung": rung, "side": way.name, "deviation": np.abs(values - 1).max()}


@experiment(keys=("index", "rung", "side"), smoke={**SMALL, **BRIEF}, **TIMES)
def ladder(seed: int, rounds: int = 15, seconds: float = 0.01, **sizes: int) -> Iterator[Row]:
    """Times per configuration [s] of the exact index and of networks, from the paper's kind of program to C."""
    for index in INDICES:
        for rung, ways in Contest(index, seed, **sizes).rungs().items():
            for own in measure(ways, rounds, seconds):
                yield {"index": index, "rung": rung, "side": own.name, **_times(own)}


@experiment(keys=("number", "copy"), smoke={"count": 2, **BRIEF}, **TIMES)
def singular_values(seed: int, count: int = 30, rounds: int = 15, seconds: float = 0.01) -> Iterator[Row]:
    """Times of KCI from single Jacobians [s], in turn with as many copies of the first of them."""
    contest = Contest("KCI", seed)
    jacobians = [contest.jacobian(q) for q in contest.many[:count].numpy()]
    jacobians += jacobians[:1] * count
    ways = [Way(f"{i}", partial(_index, "KCI", J), 1) for i, J in enumerate(jacobians)]
    for i, own in enumerate(measure(ways, rounds, seconds)):
        yield {"number": i % count, "copy": i >= count, **_times(own)}


@experiment(keys=("index", "side"), smoke={"counted": False}, unsteady=("instructions",), **OF_DATA)
def instructions(seed: int, counted: bool = True) -> Iterator[Row]:
    """Neurons, and instructions of generated C per configuration where the machine can count them."""
    for index in INDICES:
        for side in Contest(index, seed).sides:
            count = instructions_per_configuration(side.source, side.function) if counted else None
            yield {"index": index, "side": side.name, "neurons": side.neurons, "instructions": count}


@experiment(
    keys=("index", "rung", "side"),
    smoke={"runs": 0},
    timed=True,
    unsteady=("mean", "error", "lower", "median", "upper", "deviation"),
    data=("robots/uvms.toml",),
    versions=octave.versions,
)
def in_octave(seed: int, runs: int = 100, configurations: int = 1000, every: int = 10) -> Iterator[Row]:
    """Processor times per configuration [s] in GNU Octave: mean over runs, its standard error, and quartiles.

    Each run evaluates all configurations; the Jacobian written out takes its turn in one run out of `every`.
    Without runs the files are written and not run.
    """
    for index in INDICES:
        case = OctaveCase(index, seed, configurations, every)
        answers = octave.run(case.files, case.ways, case.q.numpy(), runs) if runs else {}
        deviations = {way: case.deviation(way, answer.values) for way, answer in answers.items()}
        for rung, of_sides in case.rungs().items():
            for side, way in of_sides.items():
                times = answers[way].times / configurations if runs else np.array([])
                row = {"index": index, "rung": rung, "side": side, "way": way, "characters": case.length(way)}
                row |= {"runs": len(times), "configurations": configurations}
                yield {**row, "deviation": deviations.get(way), **_mean_of(times)}


def _mean_of(times: np.ndarray) -> dict[str, float | None]:
    """Return the mean of times, its standard error, and the quartiles; nothing of no times."""
    if not len(times):
        return dict.fromkeys(("mean", "error", "lower", "median", "upper"))
    lower, median, upper = np.quantile(times, [0.25, 0.5, 0.75])
    error = times.std(ddof=1) / np.sqrt(len(times)) if len(times) > 1 else np.nan
    return {"mean": times.mean(), "error": error, "lower": lower, "median": median, "upper": upper}


def _times(timing: Timing) -> Row:
    return {name: value for name, value in asdict(timing).items() if name != "name"}


def _index(name: str, J: np.ndarray) -> Any:
    """Return w by LU, or KCI by singular values, of Jacobians (..., 6, n) in numpy."""
    if name == "w":
        return np.sqrt(np.linalg.det(J @ np.swapaxes(J, -1, -2)))
    sigma = np.linalg.svd(J, compute_uv=False)
    return sigma[..., -1] / sigma[..., 0]


@dataclass(frozen=True)
class Side:
    """An exact index (without neurons) or a network, as functions of configurations (m, n), and its C file.

    In numpy `one` takes a single configuration (n). The others are compared with `reference`.
    """

    name: str
    neurons: int
    reference: Function
    one: Function
    at_once: Function
    in_torch: Function
    in_c: Function
    source: str
    function: str


class Contest:
    """An index and the networks for it, with the configurations that they are given."""

    def __init__(
        self, name: str, seed: int, configurations: int = 1000, many: int = 100_000, in_loops: int = 100
    ) -> None:
        index, chain = INDICES[name], robots.uvms()
        random = torch.Generator().manual_seed(seed)
        self.many = sampling.uniform(sampling.uvms_space(index.name), many, random)
        self.some, self.few = self.many[:configurations], self.many[:in_loops]
        jacobians = Jacobians()
        self.jacobian = jacobians.shared
        self.in_kind: Function = lambda q: _index(name, jacobians.written(q))
        exact = Side(
            EXACT,
            0,
            index.bind(chain),
            lambda q: _index(name, jacobians.shared(q)),
            lambda q: _index(name, jacobians.at_once(q)),
            symbolic.compile_index(chain, index, "torch"),
            symbolic.compile_index(chain, index, "c"),
            symbolic.cached_c_source(chain, index),
            function_name(SymbolicChain.from_chain(chain), index),
        )
        view = View(chain.joints, sampling.relevant_joints(chain, index))
        feed_forward, radial_basis = _of_printed_sizes(name, view, self.some, random)
        self.printed = (exact, _network(FEED_FORWARD, feed_forward), _network(RADIAL_BASIS, radial_basis))
        begin = f"uvms-{index.name.replace('_', '-')}-"
        shipped = [network for network in networks.shipped() if network.startswith(begin)]
        ours = (_network(one.replace(begin, "shipped "), networks.load_shipped(one)) for one in shipped)
        self.sides = (*self.printed, *ours)

    def rungs(self) -> Mapping[str, Sequence[Way]]:
        """Ways of all sides, from the paper's kind of program to C on many configurations."""
        few, some, many = self.few, self.some, self.many

        def ways(sides: Sequence[Side], computing: Callable[[Side], Any], q: Tensor) -> list[Way]:
            return [Way(side.name, computing(side), len(q)) for side in sides]

        in_loop = Way(EXACT, _looping(self.in_kind, few.numpy()), len(few))
        in_numpy = ways(self.printed, lambda side: partial(side.at_once, some.numpy()), some)
        return {
            IN_KIND: [in_loop, *in_numpy[1:]],
            SINGLY: ways(self.printed, lambda side: _looping(side.one, few.numpy()), few),
            "numpy, a test set at once": in_numpy,
            "torch, a test set at once": ways(self.sides, lambda side: partial(side.in_torch, some), some),
            "torch, many at once": ways(self.sides, lambda side: partial(side.in_torch, many), many),
            "C from Python, one by one": ways(self.sides, lambda side: _looping(side.in_c, few), few),
            "C from C, one by one": ways(self.sides, lambda side: _in_c_one_by_one(side, some), some),
            "C, a test set at once": ways(self.sides, lambda side: partial(side.in_c, some), some),
            FOOT: ways(self.sides, lambda side: partial(side.in_c, many), many),
        }


OCTAVE_IN_KIND = "Octave, as in the paper"
OCTAVE_RUNGS: Mapping[str, tuple[str, str]] = {
    OCTAVE_IN_KIND: ("written", "simulated_at_once"),
    "Octave, simulated one by one": ("written", "simulated"),
    "Octave, one by one": ("written", "plain"),
    "Octave, one by one, terms shared": ("shared", "plain"),
    "Octave, one by one, closed form": ("closed", "plain"),
    "Octave, a test set at once": ("at_once", "at_once"),
}
"""How the exact index and the networks are evaluated on each rung in Octave; only w has a closed form."""


class OctaveCase:
    """The files of an index and of the printed networks in Octave, and the configurations that they are given.

    The Jacobian written out is timed in one run out of `every`.
    """

    def __init__(self, name: str, seed: int, configurations: int, every: int) -> None:
        index, chain = INDICES[name], robots.uvms()
        random = torch.Generator().manual_seed(seed)
        self.q = sampling.uniform(sampling.uvms_space(index.name), configurations, random)
        view = View(chain.joints, sampling.relevant_joints(chain, index))
        kinds = (FEED_FORWARD, RADIAL_BASIS)
        networks_of = dict(zip(kinds, _of_printed_sizes(name, view, self.q, random), strict=True))
        uvms = symbolic_uvms()
        entries = written_out(uvms).xreplace(lengths_of(uvms)).flat()
        self.files = octave.jacobian_files(name, joint_symbols(uvms), entries)
        self._exact = {"written": "exact_written", "shared": "exact_shared", "at_once": "exact_at_once"}
        if name == "w":
            program = symbolic.derive(SymbolicChain.from_chain(chain), index).squared_manipulability
            self.files |= octave.closed_form_files(program)
            self._exact |= {"closed": "exact_closed", "at_once": "exact_closed_at_once"}
        self.ways = dict.fromkeys(self._exact.values(), octave.OctaveWay())
        self.ways[self._exact["written"]] = octave.OctaveWay(every=every)
        self._references = dict.fromkeys(self.ways, index.bind(chain))
        for kind, network in networks_of.items():
            side = kind.replace("-", "_")
            self.files |= octave.network_files(side, network)
            ways = [f"{side}_{way}" for way in octave.WAYS_OF_NETWORK]
            self.ways |= dict.fromkeys(ways, octave.OctaveWay(f"weights_of_{side}"))
            self._references |= dict.fromkeys(ways, network)

    def rungs(self) -> Mapping[str, Mapping[str, str]]:
        """Return the function of each side on each rung."""
        return {
            rung: {EXACT: self._exact[exact]}
            | {kind: f"{kind.replace('-', '_')}_{network}" for kind in (FEED_FORWARD, RADIAL_BASIS)}
            for rung, (exact, network) in OCTAVE_RUNGS.items()
            if exact in self._exact
        }

    def deviation(self, way: str, values: np.ndarray) -> float:
        """Return the largest relative deviation of values from those of the package.

        Raises
        ------
        ValueError
            If it is more than rounding: then the times are those of something else.
        """
        with torch.no_grad():
            deviation = float(np.abs(values / self._references[way](self.q).numpy() - 1).max())
        if not deviation < TOLERANCE:
            raise ValueError(f"{way} in Octave is off by {deviation:.2g}; less than {TOLERANCE:g} is needed")
        return deviation

    def length(self, way: str) -> int:
        """Return the number of characters of the function files that a way runs, without weights."""
        reached = [way]
        for name in reached:
            words = set(re.findall(r"\w+", self.files[name]))
            reached += [other for other in self.files if other in words and other not in reached]
        return sum(len(self.files[name]) for name in reached)


TOLERANCE = 1e-9
"""Relative deviation from the package below which a program in Octave computes the same."""


def _of_printed_sizes(
    name: str, view: View, q: Tensor, random: torch.Generator
) -> tuple[FeedForward, RadialBasis]:
    sigmoids, bells = NEURONS[name]

    def unit(*shape: int) -> Tensor:
        return torch.rand(*shape, generator=random, dtype=torch.float64)

    feed_forward = FeedForward.untrained(view, sigmoids, q, 1 + unit(len(q)), random)
    arrays = {"centres": unit(bells, view.width), "output_weights": unit(bells)}
    scale: dict[str, Any] = {
        "input_scale": torch.ones(view.width).double(),
        "spread": 1.0,
        "output_bias": 1.0,
    }
    return feed_forward, RadialBasis(view, {**arrays, **scale})


def _network(name: str, network: Network) -> Side:
    """Return a network: in numpy its equation, in torch and C as it is."""
    in_torch, in_numpy = torch.no_grad()(network), _in_numpy(network)
    source, in_c = export.c_source(network, "network"), export.compile_network(network)
    return Side(name, network.neurons, in_torch, in_numpy, in_numpy, in_torch, in_c, source, "network")


def _in_numpy(network: Network) -> Function:
    """Return the equation of a network that takes joints alone and whose output is the index itself."""
    inputs, weights = list(network.inputs), folded(network)
    if isinstance(weights, Bells):
        bases, squares = weights.centres.T, (weights.centres**2).sum(1)

        def bells(q: np.ndarray) -> Any:
            x = q[..., inputs] * weights.scale
            apart = (x**2).sum(-1)[..., None] + squares - 2 * x @ bases
            return np.exp(-apart) @ weights.output + weights.output_bias

        return bells
    hidden, biases = weights.hidden.T, weights.hidden_biases
    output, bias = weights.output[0], weights.output_biases[0]
    return lambda q: np.tanh(q[..., inputs] @ hidden + biases) @ output + bias


def _looping(function: Function, rows: Any) -> Callable[[], object]:
    return lambda: [float(function(row)) for row in rows]


def _in_c_one_by_one(side: Side, q: Tensor) -> Callable[[], object]:
    """Return how a loop in C calls the function for one configuration."""
    run = compiled_library(_LOOP).one_by_one
    pointer, size = ctypes.c_void_p, ctypes.c_size_t
    run.argtypes = [pointer, pointer, size, size, pointer]
    function = ctypes.cast(getattr(compiled_library(side.source), side.function), pointer)
    values = q.new_empty(len(q))

    def compute() -> Tensor:
        run(function, q.data_ptr(), len(q), q.shape[1], values.data_ptr())
        return values

    return compute


_LOOP = """
#include <stddef.h>

typedef int (*function)(const double *q, double *value);

void one_by_one(function f, const double *q, size_t count, size_t joints, double *values);
void one_by_one(function f, const double *q, size_t count, size_t joints, double *values)
{
  for (size_t i = 0; i < count; ++i)
    f(q + i*joints, values + i);
}
"""
