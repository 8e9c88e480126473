"""All indices of the library on eight robots: agreement with autograd and with other packages, time and memory.

Deviations are relative to the largest magnitude over all configurations. Times are per configuration, on one core unless
a name says otherwise.
"""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable, Iterator, Mapping
from dataclasses import asdict, replace
from functools import partial
from typing import Any

import numpy as np
import torch
from torch import Tensor

from dexterity import robots, symbolic
from dexterity.chain import Chain
from dexterity.indices import Index
from dexterity.timing import Way, measure
from dexterity_study.beyond.indices import peer_packages
from dexterity_study.engine.experiment import experiment
from dexterity_study.engine.table import Row

ROBOTS = ("reach_alpha5", "puma560", "ur5e", "oberon7", "panda", "iiwa14", "bluerov2", "uvms")
LENGTH = 0.5
"""Characteristic length of KCI [m], about half the reach of the arms."""

FORMS: Mapping[str, Index] = {
    "w": Index("manipulability", "geometric"),
    "w, translational": Index("manipulability", "geometric", rows="translational"),
    "w, rotational": Index("manipulability", "geometric", rows="rotational"),
    "log w": Index("log_manipulability", "geometric"),
    "order-independent w": Index("order_independent_manipulability", "geometric"),
    "σ min": Index("smallest_singular_value", "geometric"),
    "KCI": Index("kinematic_conditioning", "geometric"),
    "KCI, length-scaled": Index("kinematic_conditioning", "geometric", characteristic_length=LENGTH),
    "isotropy": Index("isotropy", "geometric"),
    "velocity ratio, z": Index("velocity_ratio", "geometric", rows="translational", direction="vz"),
    "force ratio, z": Index("force_ratio", "geometric", rows="translational", direction="vz"),
    "limit-penalised w": Index("limited_manipulability", "geometric"),
    "tool deviation": Index("tool_deviation", "geometric", rows="translational"),
    "guaranteed speed": Index("guaranteed_speed", "geometric", rows="translational"),
    "dynamic w": Index("dynamic_manipulability", "geometric"),
}
"""Forms of the indices, by name. Those of six rows count the three translational rows of an arm with fewer joints."""

OF_ROBOTS = {"data": ("robots",)}
FEW = {
    "only_robots": ("reach_alpha5", "ur5e"),
    "only_forms": ("w, translational", "KCI", "velocity ratio, z"),
}
BRIEF = {"rounds": 1, "seconds": 0.001}
TIMES = {"timed": True, "unsteady": ("configurations", "lower", "median", "upper"), **OF_ROBOTS}


def form(name: str, chain: Chain) -> Index:
    """Return a form of an index for a chain, over rows that its joints can move."""
    index = FORMS[name]
    return replace(index, rows="translational") if chain.joints < len(index.row_numbers) else index


def draws(chain: Chain, count: int, seed: int) -> Tensor:
    """Draw configurations (count, n) within the limits, within ±1 of zero where a joint has none."""
    low, high = chain.lower.clamp(min=-1e9), chain.upper.clamp(max=1e9)
    low, high = torch.where(low < -100, -1.0, low), torch.where(high > 100, 1.0, high)
    unit = torch.rand(count, chain.joints, generator=torch.Generator().manual_seed(seed), dtype=torch.float64)
    return low + unit * (high - low)


def cases(
    only_robots: tuple[str, ...] = ROBOTS, only_forms: tuple[str, ...] = tuple(FORMS)
) -> Iterator[tuple[str, str, Chain, Index]]:
    """Yield robot, name of the form, chain and index, but for indices whose limits or inertias a robot lacks."""
    for robot in only_robots:
        chain = robots.load(robot)
        for name in only_forms:
            index = form(name, chain)
            lacking = {"limits": bool(chain.lower.isinf().all()), "inertias": chain.inertias is None}
            if not any(lacking.get(need, False) for need in index.measure.needs):
                yield robot, name, chain, index


@experiment(keys=("robot", "index", "backend"), smoke={"count": 5, **FEW}, **OF_ROBOTS, atol=1e-9)
def agreement(seed: int, count: int = 200, **only: tuple[str, ...]) -> Iterator[Row]:
    """Largest deviation of compiled values and gradients from singular values and autograd."""
    for robot, name, chain, index in cases(**only):
        q = draws(chain, count, seed).requires_grad_()
        values = index.bind(chain)(q)
        (gradients,) = torch.autograd.grad(values.sum(), q)
        for backend in ("torch", "c") if index.measure.recorded else ("torch",):
            compiled = symbolic.compile_index(chain, index, backend=backend)
            value, gradient = compiled.value_and_gradient(q.detach())
            yield {
                "robot": robot,
                "index": name,
                "backend": backend,
                "value": _deviation(value, values.detach()),
                "gradient": _deviation(gradient, gradients),
            }


@experiment(keys=("package", "robot", "index"), smoke={"count": 3, **FEW}, **OF_ROBOTS, atol=1e-9)
def peers(seed: int, count: int = 50, **only: tuple[str, ...]) -> Iterator[Row]:
    """Largest deviation of the library from other packages, for the indices that they have; all rates are 1."""
    for robot, name, chain, index in cases(**only):
        q = draws(chain, count, seed)
        values = replace(index, joint_rates=(1.0,) * chain.joints).bind(chain)(q)
        for package, compute in peer_packages.indices(chain, index).items():
            others = torch.as_tensor(np.array([compute(row) for row in q.numpy()]))
            yield {
                "package": package,
                "robot": robot,
                "index": name,
                "deviation": _deviation(values, others),
            }


@experiment(keys=("robot", "index", "what"), smoke={"count": 40, **BRIEF, **FEW}, **TIMES)
def times(
    seed: int, count: int = 20_000, rounds: int = 5, seconds: float = 0.02, **only: tuple[str, ...]
) -> Iterator[Row]:
    """Times of compiled C per configuration [s], of values alone and of values with gradients."""
    for robot, name, chain, index in cases(**only):
        if index.measure.recorded is None:
            continue
        q = draws(chain, count, seed)
        compiled = symbolic.compile_index(chain, index, backend="c")
        ways = [
            Way("value", partial(compiled, q), count),
            Way("value and gradient", partial(compiled.value_and_gradient, q), count),
        ]
        for timing in measure(ways, rounds, seconds):
            yield {"robot": robot, "index": name, "what": timing.name, **_quartiles(timing)}


@experiment(keys=("index", "way"), smoke={"count": 200, "singly": 5, **BRIEF}, **TIMES)
def ways(
    seed: int, count: int = 200_000, singly: int = 100, rounds: int = 7, seconds: float = 0.1
) -> Iterator[Row]:
    """Times of w and KCI of the twelve-joint system per configuration [s], in one run with another package."""
    chain = robots.load("uvms")
    q = draws(chain, count, seed)
    for name in ("w", "KCI"):
        index = form(name, chain)
        compiled = symbolic.compile_index(chain, index, backend="c")
        on_two = symbolic.compile_index(chain, index, backend="c", threads=2)
        peer = peer_packages.indices(chain, index)[peer_packages.PINOCCHIO]
        each: dict[str, tuple[Callable[[], Any], int]] = {
            "pinocchio and numpy, one by one": (partial(_one_by_one, peer, q[:singly].numpy()), singly),
            "bound, torch": (partial(index.bind(chain), q), count),
            "compiled, torch": (partial(symbolic.compile_index(chain, index), q), count),
            "compiled, C, one by one from Python": (
                partial(_one_by_one, compiled, q[:singly].numpy()),
                singly,
            ),
            "compiled, C": (partial(compiled, q), count),
            "compiled, C, two cores": (partial(on_two, q), count),
            "compiled, C, with gradient": (partial(compiled.value_and_gradient, q), count),
        }
        for timing in measure([Way(n, f, c) for n, (f, c) in each.items()], rounds, seconds):
            yield {"index": name, "way": timing.name, **_quartiles(timing)}


@experiment(keys=("way",), smoke={"count": 20_000}, unsteady=("bytes",), **OF_ROBOTS)
def memory(count: int = 1_000_000) -> Iterator[Row]:
    """Growth of a process's peak memory per configuration [byte], without the configurations and the values."""
    for way in ("bound, torch", "compiled, torch", "compiled, C"):
        run = subprocess.run(  # noqa: S603
            [sys.executable, "-c", _GROWTH, way, str(count)], capture_output=True, text=True, check=True
        )
        yield {"way": way, "bytes": float(run.stdout)}


_GROWTH = """
import resource, sys, torch
from dexterity import robots, symbolic
from dexterity.indices import Index
way, count = sys.argv[1], int(sys.argv[2])
torch.set_num_threads(1)
chain, index = robots.load("uvms"), Index("kinematic_conditioning", "geometric")
backend = {"compiled, torch": "torch", "compiled, C": "c"}.get(way)
f = symbolic.compile_index(chain, index, backend=backend) if backend else index.bind(chain)
q = torch.rand(count, chain.joints, dtype=torch.float64)
f(q[:1000])
before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
values = f(q)
print(max(0, (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) * 1024 / count - 8))
"""


def _one_by_one(function: Callable[[np.ndarray], Any], rows: np.ndarray) -> None:
    for row in rows:
        function(row)


def _deviation(values: Tensor, reference: Tensor) -> float:
    return float((values - reference).abs().max() / reference.abs().max().clamp(min=1e-300))


def _quartiles(timing: Any) -> Row:
    return {name: value for name, value in asdict(timing).items() if name != "name"}
