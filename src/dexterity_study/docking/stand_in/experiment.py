"""A network in place of the area manipulability M_a over a grid of control points.

The question is that of Sotiropoulos, Aspragathos & Geffard (2012). Poses are those that the docking problem allows by
its text and from which all corners are within the length of the arm. Errors are shares of the largest M_a.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
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
from dexterity.timing import Timing, Way, measure
from dexterity_study.docking.area.experiment import BY_ARM, elbow_of
from dexterity_study.docking.cases import OF_DATA, Rows, Values, arm_of
from dexterity_study.engine.experiment import experiment

Rating: TypeAlias = Callable[[Tensor], Tensor]
"""From poses (..., 4) to values (...) [m³]."""

HALF_WIDTH, QUARTER = 0.2, math.pi / 2
FIRST = (1, 10, 100, 1000)
SIDES = (2, 3, 5)
SMALL = {"sides": (2, 3), "per_side": 5, "pool": 1000, "neurons": 4, "rows": 200, "epochs": 5}
BY_ARM = {**BY_ARM, **OF_DATA, "rtol": 1e-3}


@experiment(seeds=5, keys=("way",), smoke=SMALL, **BY_ARM)
def ways(seed: int, reading: Values, sides: tuple[int, ...] = SIDES, **settings: Any) -> Rows:
    """Errors and rankings by a network, and by the exact measure over few points, which does not hang on the seed."""
    own = ground(arm_of(reading), **settings)
    yield {"way": "network", **own.judge(own.taught(seed))}
    for side in sides:
        rating = partial(rated, own.arm, side)
        # The measure over fewer points is a bound: a pose below the best value, but for rounding, is ruled out.
        proven = (rating(own.poses) >= own.values.max() - 1e-12).sum()
        yield {"way": f"{side**2} points", **own.judge(rating), "proven": proven}


@experiment(
    keys=("name",), timed=True, unsteady=("lower", "median", "upper"), smoke={**SMALL, "rounds": 1}, **BY_ARM
)
def times(
    seed: int, reading: Values, sides: tuple[int, ...] = SIDES, rounds: int = 15, **settings: Any
) -> Rows:
    """Seconds to teach a network, and seconds a pose to rate a batch."""
    own, start = ground(arm_of(reading), **settings), time.perf_counter()
    ratings = {"network": own.taught(seed)}
    yield asdict(Timing.from_times("teaching", 1, [time.perf_counter() - start]))
    ratings |= {f"{side**2} points": partial(rated, own.arm, side) for side in (*sides, own.per_side)}
    batch = own.poses[:4096]
    batches = [Way(name, partial(rating, batch), len(batch)) for name, rating in ratings.items()]
    yield from map(asdict, measure(batches, rounds, seconds=0.05))


@dataclass(frozen=True)
class _Ground:
    """A pool of poses on which ways are judged, and how networks for an arm are taught."""

    arm: Chain
    per_side: int = 21
    pool: int = 65_536
    neurons: int = 40
    rows: int = 4096
    epochs: int = 100

    @cached_property
    def poses(self) -> Tensor:
        return draw(self.arm, self.pool, 1000)

    @cached_property
    def values(self) -> Tensor:
        return rated(self.arm, self.per_side, self.poses)

    def taught(self, seed: int) -> Rating:
        poses, random = draw(self.arm, self.rows, seed), torch.Generator().manual_seed(seed)
        x, values = seen(poses), rated(self.arm, self.per_side, poses)
        untrained = FeedForward.untrained(View(4, range(4)), self.neurons, x, values, random)
        training = levenberg_marquardt(untrained, x, values, Options(epochs=self.epochs))
        return partial(stand_in, training.network)

    def judge(self, rating: Rating) -> dict[str, Any]:
        """Errors on all and on good poses, and the best of a ranking's first as a share of the best of all."""
        answers, best = rating(self.poses), self.values.max()
        errors = (answers - self.values).abs() / best
        facts: dict[str, Any] = {}
        for name, chosen in (("all", errors), ("high", errors[self.values > best / 2])):
            median, most, largest = np.quantile(chosen.numpy(), (0.5, 0.99, 1.0))
            facts |= {f"{name}_median": median, f"{name}_most": most, f"{name}_largest": largest}
        kept = self.values[answers.argsort(descending=True)].cummax(0).values / best
        facts |= {f"best_of_{count}": kept[count - 1] for count in FIRST}
        return {**facts, "needed": (kept < 0.99).sum() + 1}


ground = cache(_Ground)
"""The ground of an arm, drawn once for all seeds."""


def draw(arm: Chain, count: int, seed: int) -> Tensor:
    """Draw poses (count, 4) at which a network is asked, from a scrambled Sobol sequence."""
    problem = docking.DockingProblem(arm, region="or")
    # About one in nine is kept; a few more for small counts.
    poses = sampling.sobol(sampling.Box(problem.lower, problem.upper), 16 * count + 100, seed)
    return poses[asked(arm, poses)][:count]


def asked(arm: Chain, poses: Tensor) -> Tensor:
    """Tell at which poses (..., 4) a network is asked: elsewhere M_a is zero or the pose not allowed."""
    elbow, (x, y, z, _) = elbow_of(arm), poses.unbind(-1)
    far = (x.abs() + HALF_WIDTH).square() + (y.abs() + HALF_WIDTH).square()
    # How far a tool point may be from the first axis and the shoulder's height together.
    reach_squared = (elbow.upper_arm + elbow.forearm) ** 2 + elbow.sideways**2
    within = far + (z + elbow.height).square() <= reach_squared
    return within & docking.DockingProblem(arm, region="or").allows(poses)


def seen(poses: Tensor) -> Tensor:
    """Return what a network is told: the middle of the area in the base [m], and ψ modulo a quarter turn [rad]."""
    x, y, z, yaw = poses.unbind(-1)
    cosine, sine = yaw.cos(), yaw.sin()
    folded = (yaw + QUARTER / 2).remainder(QUARTER) - QUARTER / 2
    return torch.stack([-cosine * x - sine * y, sine * x - cosine * y, -z, folded], dim=-1)


def rated(arm: Chain, per_side: int, poses: Tensor) -> Tensor:
    """Rate poses by the exact measure over a grid of control points."""
    return docking.area_manipulability(arm, poses, docking.square(HALF_WIDTH, per_side))


def stand_in(network: FeedForward, poses: Tensor) -> Tensor:
    """Rate poses (N, 4) by a network, [m³]; what it has below zero is zero."""
    with torch.no_grad():
        return torch.cat([network(seen(some)) for some in poses.split(512)]).clamp(min=0)
