"""A network in place of the area manipulability M_a over a grid of control points.

The question is that of Sotiropoulos, Aspragathos & Geffard (2012). Poses are those that the docking problem allows by
its text and from which all corners are within the length of the arm. Errors are shares of the largest M_a.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, cached_property, partial
from typing import Any, TypeAlias

import numpy as np
import torch
from torch import Tensor

from dexterity import docking, sampling
from dexterity.chain import Chain
from dexterity.networks.feed_forward import FeedForward
from dexterity.networks.levenberg_marquardt import Options, levenberg_marquardt
from dexterity.networks.network import View
from dexterity.sampling import Box, DataSet
from dexterity.timing import Way, measure
from dexterity_study.docking.area.experiment import BY_ARM, elbow_of
from dexterity_study.docking.cases import OF_DATA, Rows, Values, arm_of
from dexterity_study.engine.experiment import experiment

Rating: TypeAlias = Callable[[Tensor], Tensor]
"""From poses (..., 4) to values (...) [m³]."""

HALF_WIDTH, QUARTER = 0.2, math.pi / 2
FIRST = (1, 10, 100, 1000)
SIDES = (2, 3, 5)
SMALL = {"per_side": 5, "fresh": 300, "pool": 500, "first": (1, 10, 100), "rows": 200, "epochs": 5}
BY_ARM = {**BY_ARM, **OF_DATA, "rtol": 1e-3}


@experiment(
    seeds=5, keys=("neurons",), smoke={**SMALL, "sizes": (2, 4), "judged": 4, "validation": 100}, **BY_ARM
)
def networks(
    seed: int,
    reading: Values,
    sizes: tuple[int, ...] = (20, 40, 80),
    judged: int = 80,
    validation: int = 4096,
    **settings: Any,
) -> Rows:
    """Root mean square errors of networks on a validation set, and how well those of one size do."""
    own = ground(arm_of(reading), **settings)
    checked = own.drawn(validation, 1000)
    for size in sizes:
        rating = own.taught(size, seed)
        error = (rating(checked.q) - checked.values).square().mean().sqrt() / own.largest
        yield {"neurons": size, "validation": error, **(own.judge(rating) if size == judged else {})}


@experiment(keys=("points",), smoke={**SMALL, "sides": (2, 3)}, **BY_ARM)
def exact(seed: int, reading: Values, sides: tuple[int, ...] = SIDES, **settings: Any) -> Rows:  # noqa: ARG001
    """The exact measure over few points in the networks' place; and how many poses it does not rule out."""
    own = ground(arm_of(reading), **settings)
    for side in sides:
        rating = partial(rated, own.arm, side)
        # The measure over fewer points is a bound: a pose below the best value, but for rounding, is ruled out.
        proven = (rating(own.pool_set.q) >= own.largest - 1e-12).sum()
        yield {"points": side**2, **own.judge(rating), "proven": proven}


@experiment(
    keys=("task", "way"),
    timed=True,
    unsteady=("lower", "median", "upper"),
    smoke={**SMALL, "sides": (2, 3), "neurons": 4, "batch": 100, "searched": 10, "rounds": 1},
    **BY_ARM,
)
def times(
    seed: int,
    reading: Values,
    sides: tuple[int, ...] = SIDES,
    neurons: int = 80,
    batch: int = 4096,
    searched: int = 100,
    rounds: int = 15,
    **settings: Any,
) -> Rows:
    """Seconds a pose to rate a batch and to search the pool by way of a ranking, and seconds to teach a network."""
    own = ground(arm_of(reading), **settings)
    pool, start = own.pool_set.q, time.perf_counter()
    rankings = {"network": own.taught(neurons, seed)}
    yield {"task": "teach", "way": "network", "configurations": 1, "median": time.perf_counter() - start}
    rankings |= {f"{side**2} points": partial(rated, own.arm, side) for side in sides}
    ratings = {**rankings, f"{own.per_side**2} points": own.rate}

    def search(rating: Rating) -> Tensor:
        return own.rate(pool[rating(pool).topk(searched).indices]).max()

    tasks = {
        "rate": [Way(name, partial(rating, pool[:batch]), batch) for name, rating in ratings.items()],
        "search": [Way(name, partial(search, rating), len(pool)) for name, rating in rankings.items()],
    }
    for task, ways in tasks.items():
        for way in measure(ways, rounds, seconds=0.05):
            quartiles = {"lower": way.lower, "median": way.median, "upper": way.upper}
            yield {"task": task, "way": way.name, "configurations": way.configurations, **quartiles}


@dataclass(frozen=True)
class _Ground:
    """Fresh poses to judge on, a pool among which the best is looked for, and how networks for an arm are taught."""

    arm: Chain
    per_side: int = 21
    fresh: int = 16_384
    pool: int = 65_536
    rows: int = 4096
    epochs: int = 100
    first: tuple[int, ...] = FIRST

    def rate(self, poses: Tensor) -> Tensor:
        return rated(self.arm, self.per_side, poses)

    def drawn(self, count: int, seed: int) -> DataSet:
        poses = draw(self.arm, count, seed)
        return DataSet(poses, self.rate(poses))

    def taught(self, neurons: int, seed: int) -> Rating:
        train, random = self.drawn(self.rows, seed), torch.Generator().manual_seed(seed)
        x = seen(train.q)
        untrained = FeedForward.untrained(View(4, range(4)), neurons, x, train.values, random)
        training = levenberg_marquardt(untrained, x, train.values, Options(epochs=self.epochs))
        return partial(stand_in, training.network)

    @cached_property
    def fresh_set(self) -> DataSet:
        return self.drawn(self.fresh, 1001)

    @cached_property
    def pool_set(self) -> DataSet:
        return self.drawn(self.pool, 1002)

    @property
    def largest(self) -> float:
        return float(self.pool_set.values.max())

    def judge(self, rating: Rating) -> dict[str, Any]:
        """Errors on all and on good fresh poses, and the best of a ranking's first as a share of the best of all."""
        values = self.fresh_set.values
        errors = (rating(self.fresh_set.q) - values).abs() / self.largest
        facts: dict[str, Any] = {}
        for name, chosen in (("all", errors), ("high", errors[values > 0.5 * self.largest])):
            median, most, largest = np.quantile(chosen.numpy(), (0.5, 0.99, 1.0))
            facts |= {f"{name}_median": median, f"{name}_most": most, f"{name}_largest": largest}
        ranked = self.pool_set.values[rating(self.pool_set.q).argsort(descending=True)]
        kept = ranked.cummax(0).values / self.largest
        best = {f"best_of_{count}": kept[count - 1] for count in self.first}
        return {**facts, **best, "needed": (kept < 0.99).sum() + 1}


ground = cache(_Ground)
"""The ground of an arm, drawn once for all seeds."""


def asked(arm: Chain, poses: Tensor) -> Tensor:
    """Tell at which poses (..., 4) a network is asked: elsewhere M_a is zero or the pose not allowed."""
    x, y, z, _ = poses.unbind(-1)
    far = (x.abs() + HALF_WIDTH).square() + (y.abs() + HALF_WIDTH).square()
    within = far + (z + elbow_of(arm).height).square() <= _reach_squared(arm)
    return within & docking.DockingProblem(arm, region="or").allows(poses)


def draw(arm: Chain, count: int, seed: int) -> Tensor:
    """Draw poses (count, 4) at which a network is asked, from a scrambled Sobol sequence."""
    problem = docking.DockingProblem(arm, region="or")
    lowest = problem.height[0] + elbow_of(arm).height
    farthest = math.sqrt(_reach_squared(arm) - lowest**2 - HALF_WIDTH**2) - HALF_WIDTH
    lower, upper = problem.lower.clone(), problem.upper.clone()
    lower[:2], upper[:2] = -farthest, farthest
    # About half of the box is kept; a few more for small counts.
    poses = sampling.sobol(Box(lower, upper), 4 * count + 100, seed)
    return poses[asked(arm, poses)][:count]


def seen(poses: Tensor) -> Tensor:
    """Return what a network is told: the middle of the area in the base [m], and ψ modulo a quarter turn [rad]."""
    x, y, z, yaw = poses.unbind(-1)
    cosine, sine = yaw.cos(), yaw.sin()
    folded = yaw - QUARTER * (yaw / QUARTER + 0.5).floor()
    return torch.stack([-cosine * x - sine * y, sine * x - cosine * y, -z, folded], dim=-1)


def _reach_squared(arm: Chain) -> float:
    """Square of how far a tool point may be from the first axis and the shoulder's height together [m²]."""
    elbow = elbow_of(arm)
    return (elbow.upper_arm + elbow.forearm) ** 2 + elbow.sideways**2


def rated(arm: Chain, per_side: int, poses: Tensor) -> Tensor:
    """Rate poses by the exact measure over a grid of control points."""
    return docking.area_manipulability(arm, poses, docking.square(HALF_WIDTH, per_side))


def stand_in(network: FeedForward, poses: Tensor) -> Tensor:
    """Rate poses (N, 4) by a network, [m³]; what it has below zero is zero."""
    at_once = max(1, 2**15 // network.neurons)
    with torch.no_grad():
        return torch.cat([network(seen(some)) for some in poses.split(at_once)]).clamp(min=0)
