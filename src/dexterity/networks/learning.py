"""A network for one's own robot: from a chain, an index, a space and an error goal to a judged network.

One call chooses the inputs, the size and the readout, judges the network on points that it was not chosen by
and by a search for its worst case, and compares it with the exact code and with polynomials in one run. Where
the exact code is the better answer it says so.

Examples
--------
>>> import dexterity as dx
>>> from dexterity.networks import Effort, Search
>>> puma, few = dx.robots.puma560(), Search(256, 16, 8, 5)
>>> space = dx.sampling.Box.around(puma, [0.0, 0.6, -0.9, 0.0, 0.8, 0.0], 0.2, joints=(1, 2, 4))
>>> effort = Effort(sizes=(6,), readouts=("identity",), rows=512, epochs=40, restarts=1, search=few)
>>> learned = dx.networks.for_index(puma, "manipulability", space, 0.05, effort=effort, points=2000)
>>> learned.success, learned.network.inputs, learned.card["worst_case"]["error"] < 0.05
(True, (1, 2, 4), True)
"""

from __future__ import annotations

import math
import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, Literal

import torch
from jaxtyping import Float64
from torch import Tensor
from tqdm import tqdm

from dexterity import checks, sampling, symbolic
from dexterity.chain import Chain
from dexterity.codegen.library import CompilationFailed
from dexterity.indices import Index
from dexterity.networks import comparison, files
from dexterity.networks.card import Card, chain_entry, index_entry, plain
from dexterity.networks.comparison import Times
from dexterity.networks.domain import Guarded
from dexterity.networks.judgement import describe
from dexterity.networks.ladder import Candidate, Effort, Report, Task, climb
from dexterity.networks.network import Network, View
from dexterity.networks.validation import Function
from dexterity.networks.worst_case import Search
from dexterity.sampling import Box, DataSet, Space
from dexterity.spatial import TensorLike

__all__ = ["Learned", "fastest", "for_index", "judge_again"]

SMALL = 1e-2
"""Where the smallest value is a smaller share of the largest, errors are divided by the range of values."""

LOOK = 4096
"""Points by which the values of an index are looked at."""


@dataclass(frozen=True)
class Learned:
    """A judged network; called as the network is, inside its space alone.

    Attributes
    ----------
    network
        The network, with its card.
    space
        Where it was trained and judged.
    goal
        Largest error that was wanted.
    candidates
        All that were tried.
    interrupted
        Whether the keyboard ended the search before the goal was reached.
    recommendation
        ``"network"`` or ``"exact"``: the better answer; ``card["advice"]`` gives the reasons.
    """

    network: Network
    space: Space
    goal: float
    candidates: tuple[Candidate, ...]
    interrupted: bool
    recommendation: Literal["network", "exact"]

    @property
    def card(self) -> Card:
        """What is known of the network."""
        return self.network.card

    @property
    def error(self) -> float:
        """Largest error that was found by points and by ascent."""
        return max(self.card["errors"]["maximum"], self.card["worst_case"]["error"])

    @property
    def success(self) -> bool:
        """Whether the largest error that was found keeps the goal."""
        return self.error <= self.goal

    def __call__(self, q: TensorLike) -> Float64[Tensor, "*batch"]:
        """Value of the index as the network approximates it; see :class:`dexterity.networks.Guarded`."""
        return Guarded(self.network, self.space)(q)

    @checks.arguments(path=checks.path)
    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the network with its card to a file; see :func:`dexterity.networks.save`."""
        files.save(self.network, path)

    def __repr__(self) -> str:
        verdict = "keeps" if self.success else "misses"
        return (
            f"<learned: {self.network!r}; largest error {self.error:.2g} {verdict} the goal {self.goal:g}; "
            f"better answer: {self.recommendation}>"
        )


def for_index(
    chain: Chain,
    index: Index | str,
    space: Space | None = None,
    goal: float = 0.01,
    *,
    name: str | None = None,
    effort: Effort | None = None,
    points: int = 50_000,
    relative: bool | None = None,
    progress: bool | Report = False,
) -> Learned:
    """Learn an index of a chain, and judge what was learned.

    An interrupt from the keyboard ends the search; the best network so far is judged and returned.

    Parameters
    ----------
    chain
        The robot.
    index
        An index, or the name of one, in the spatial frame as by default of :class:`dexterity.indices.Index`.
    space
        Where the network is to be used. By default the joints that the index depends on vary by 20° (0.35 m
        for prismatic joints) about the middle of their limits, and the others are held.
    goal
        Largest error that is wanted, of points and by ascent.
    name
        Name for the card; made of chain and index by default.
    effort
        How much to try, and the seed of all draws.
    points
        Fresh points that the network is judged on.
    relative
        Whether errors are relative to the value of the index, or to the range of its values in the space. By
        default they are relative where the smallest value is at least a hundredth of the largest.
    progress
        Whether to show a bar on stderr; or a function of a text, of the number of steps that are done, and
        of the number that there are at most.

    Returns
    -------
    The network with its card. A goal that no network keeps is no error: see `Learned.success`.

    Raises
    ------
    ValueError
        If an argument does not fit the chain, or the index is not finite, zero or constant in the space.
    TypeError
        If an argument is of another kind.
    KeyboardInterrupt
        If there is no network so far.
    """
    checks.instance(chain, "chain", Chain)
    effort = Effort() if effort is None else checks.instance(effort, "effort", Effort)
    index = Index(index) if isinstance(index, str) else checks.instance(index, "index", Index)
    goal = checks.positive(goal, "goal")
    points = checks.whole(points, "points", least=100)
    if name is not None:  # known before minutes of training are lost
        checks.name(name, "name")
    exact, language = fastest(chain, index)
    relevant = sampling.relevant_joints(chain, index)
    if space is None:
        space = Box.around(chain, joints=relevant)
    task = _task(exact, space, chain, relevant, goal, relative)
    with _reporting(progress, effort) as report:
        climbed = climb(task, effort, report)
    title = f"{chain.name}-{index.name}".replace("_", "-").replace(" ", "-") if name is None else name
    about: dict[str, Any] = {
        "name": checks.name(title, "name"),
        "chain": chain_entry(chain),
        "index": index_entry(index),
        "training": plain(effort) | {"goal": goal, "candidates": len(climbed.candidates)},
        "chosen": "smallest network that keeps the goal, by a validation set and by ascent",
    }
    best = climbed.best
    about["training"] |= {"readout": best.readout, "passed": climbed.passed}
    about["validation"] = {"error": best.validation_error, "worst_case": best.worst_error}
    counts = comparison.exact_operations(chain, index)
    # A seed that no draw of the search for the network has.
    seed = JUDGED_BY + effort.seed
    card, better = _compared(best.network, task, effort, about, counts, language, seed, points)
    best.network.card = card
    return Learned(best.network, space, goal, climbed.candidates, climbed.interrupted, better)


@checks.arguments(chain=checks.Instance(Chain), index=checks.Instance(Index))
def fastest(chain: Chain, index: Index) -> tuple[Function, Literal["C", "torch"]]:
    """Return an index of a chain as the fastest exact function that can be made here, and its language.

    It is compiled to C where there is a compiler, else derived for torch, and evaluated from the Jacobian
    where it cannot be derived.
    """
    # A ValueError says that this index cannot be derived, or that it cannot be written in C.
    try:
        return symbolic.compile_index(chain, index, "c"), "C"
    except (CompilationFailed, ValueError):
        pass
    try:
        return symbolic.compile_index(chain, index, "torch"), "torch"
    except ValueError:
        return index.bind(chain), "torch"


@checks.arguments(
    network=checks.Instance(Network), points=checks.Whole(1), search=checks.OrNone(checks.Instance(Search))
)
def judge_again(
    network: Network, *, points: int = 50_000, seed: int = 1, search: Search | None = None
) -> Card:
    """Judge a network anew against the chain, the index and the space on its card, as :func:`for_index` does.

    Parameters
    ----------
    network
        A network whose card has the geometry of its chain. The fits that it is compared with use as many rows
        as its card says that it was trained on.
    points, seed, search
        Fresh points, and the search for the worst case; another seed than that on the card tests the card.

    Returns
    -------
    A new card, with times measured here; that of the network stays.

    Raises
    ------
    ValueError
        If the card does not give the chain, the index or the space.
    """
    old = network.card
    chain, index, space = old.chain(), old.index(), old.space()
    exact, language = fastest(chain, index)
    training = old.get("training")
    training = dict(training) if isinstance(training, Mapping) else {}
    task = Task(
        network.view, exact, space, training.get("goal", math.inf), old.get("errors", {}).get("relative_to")
    )
    effort = Effort(**{key: training[key] for key in ("rows", "overhang", "seed") if key in training})
    counts = comparison.exact_operations(chain, index)
    return _compared(network, task, effort, old, counts, language, seed, points, search)[0]


# ---- the task ----------------------------------------------------------------------------------------


def _task(
    exact: Function,
    space: Space,
    chain: Chain,
    relevant: tuple[int, ...],
    goal: float,
    relative: bool | None,
) -> Task:
    checks.Instance(Space)(space, "space")
    if space.joints != chain.joints:
        raise ValueError(f"space has {space.joints} joints and chain {chain.joints}; as many are needed")
    q = sampling.sobol(space, LOOK, 0)
    varying = (q != q[0]).any(0)
    inputs = [joint for joint in relevant if varying[joint]]
    if not inputs:
        raise ValueError("space holds all joints that the index depends on: there is nothing to learn")
    with torch.no_grad():
        values = torch.as_tensor(exact(q))
    if not torch.isfinite(values).all():
        raise ValueError("the index is infinite or undefined in the space; choose one without singularities")
    low, high = float(values.min()), float(values.max())
    if low == high == 0:
        raise ValueError(
            f"the index is zero everywhere in the space: with {chain.joints} joints choose rows that the "
            "tool can move along, such as rows='translational'"
        )
    if not high - low > 1e-9 * max(abs(low), abs(high)):
        raise ValueError(f"the index is {low:.6g} everywhere in the space: there is nothing to learn")
    if relative is None:
        relative = low > 0 and low >= SMALL * high
    elif checks.flag(relative, "relative") and not low > 0:
        raise ValueError(
            f"the index goes down to {low:.3g} in the space, where no relative error exists; choose another "
            "space, or relative=False"
        )
    return Task(View(chain.joints, inputs), exact, space, goal, None if relative else high - low)


@contextmanager
def _reporting(progress: bool | Report, effort: Effort) -> Iterator[Report | None]:
    if callable(progress):
        yield progress
        return
    hidden = not checks.flag(progress, "progress")
    with tqdm(total=4 * len(effort.sizes), unit="network", disable=hidden) as bar:

        def report(text: str, done: int, most: int) -> None:
            bar.total, bar.n = most, done
            bar.set_postfix_str(text)

        yield report


# ---- the judgement -----------------------------------------------------------------------------------


def _compared(
    network: Network,
    task: Task,
    effort: Effort,
    about: Mapping[str, Any],
    counts: Mapping[str, int],
    language: str,
    seed: int,
    points: int,
    search: Search | None = None,
) -> tuple[Card, Literal["network", "exact"]]:
    """Judge a network, compare it with fits and the exact code, and return its card and the better answer."""
    q = sampling.sobol(task.space, effort.rows, effort.seed, effort.overhang)
    rows = DataSet.of(task.exact, q)
    card = describe(
        network, task.exact, task.space, about, seed=seed, count=points, search=search, scale=task.scale,
        baselines=comparison.fits(task.view, rows, task.scale),
    )  # fmt: skip
    measured = comparison.times(task.exact, network, sampling.sobol(task.space, 1000, 0), language)
    better, reasons = _advice(card, measured, task.goal)
    operations = {**card["operations"], **counts}
    return card.with_entries(operations=operations, time=measured.entry(), advice=reasons), better


JUDGED_BY = 20_160_003
"""Seed of the fresh points and of the search that judge, for the seed 0."""


def _advice(card: Card, times: Times, goal: float) -> tuple[Literal["network", "exact"], str]:
    """Return the better answer, and why in a few sentences."""
    error = max(card["errors"]["maximum"], card["worst_case"]["error"])
    exact, network = (1e9 * timing.median for timing in (times.exact, times.network))
    fits = {name: entry["maximum"] for name, entry in card["baselines"].items()}
    near = [name for name, largest in fits.items() if largest <= card["errors"]["maximum"]]
    measured = (
        f"A configuration takes the exact index {exact:.3g} ns and the network {network:.3g} ns in "
        f"{times.language}, 1000 at once, on one core; the largest error found of the network is {error:.2g}."
    )
    if near:
        return "exact", (
            f"Use the exact index, or the {near[0]} fit, which is no worse than the network. {measured}"
        )
    if times.ratio <= 1:
        return "exact", f"Use the exact index: it is no slower than the network and has no error. {measured}"
    if error > goal:
        return "exact", f"Use the exact index: no network kept the goal of {goal:g}. {measured}"
    return "network", (
        f"Use the network where an error of {error:.2g} is allowed: it is {times.ratio:.2g} times as fast as "
        f"the exact index. {measured}"
    )
