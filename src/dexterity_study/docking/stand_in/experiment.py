"""A network in place of the area manipulability M_a over a grid of control points.

The question is that of Sotiropoulos, Aspragathos & Geffard (2012). Poses are those that the docking problem allows by
its text and from which all corners are within the length of the arm. Errors are shares of the largest M_a.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache, cached_property, partial
from typing import Any, TypeAlias

import numpy as np
import torch
from torch import Tensor

from dexterity import docking, sampling, spatial
from dexterity.chain import Chain
from dexterity.networks.feed_forward import FeedForward
from dexterity.networks.levenberg_marquardt import Options, levenberg_marquardt
from dexterity.networks.network import View
from dexterity.sampling import Box, DataSet
from dexterity.timing import Way, measure
from dexterity_study.docking.area.experiment import BY_ARM, elbow_of
from dexterity_study.docking.cases import OF_DATA, arm_of
from dexterity_study.engine.experiment import experiment

Rating: TypeAlias = Callable[[Tensor], Tensor]
"""From poses (..., 4) to values (...) [m³]."""

HALF_WIDTH, QUARTER = 0.2, math.pi / 2
FIRST = (1, 2, 5, 10, 20, 50, 100, 200, 500, 1000)
SMALL = {"per_side": 5, "fresh": 300, "pool": 500, "first": (1, 10, 100), "cut": 21, "rows": 200, "epochs": 5}
CHEAP = {"sides": (2, 3)}
BY_ARM = {**BY_ARM, **OF_DATA, "rtol": 1e-3}


@experiment(
    seeds=5,
    keys=("neurons",),
    arrays=("cuts",),
    smoke={**SMALL, "sizes": (2, 4), "judged": 4, "validation": 100},
    **BY_ARM,
)
def networks(
    seed: int,
    reading: Mapping[str, Any],
    sizes: tuple[int, ...] = (20, 40, 80),
    judged: int = 80,
    validation: int = 4096,
    **settings: Any,
) -> tuple[list[dict[str, Any]], dict[str, Any]]:
    """Root mean square errors of networks on a validation set, and how well those of one size do."""
    own, rows, cuts = ground(arm_of(reading), **settings), [], []
    checked = own.drawn(validation, 1000)
    for size in sizes:
        rating = own.taught(size, seed)
        error = (rating(checked.q) - checked.values).square().mean().sqrt() / own.largest
        rows.append({"neurons": size, "validation": error})
        if size == judged:
            worst = own.misses(rating).topk(math.ceil(0.01 * own.fresh)).indices
            shares = {f"worst_{kind}": where[worst].double().mean() for kind, where in own.kinds[0].items()}
            rows[-1] |= {**own.judge(rating), **shares}
            cuts = [own.along(rating, poses) for _, poses in own.lines]
    return rows, {"cuts": np.stack(cuts)}


@experiment(keys=("points",), arrays=("places", "cuts"), smoke={**SMALL, **CHEAP}, **BY_ARM)
def exact(
    seed: int,  # noqa: ARG001 -- nothing more is drawn
    reading: Mapping[str, Any],
    sides: tuple[int, ...] = (2, 3, 5),
    **settings: Any,
) -> tuple[list[dict[str, Any]], dict[str, Any]]:
    """The exact measure over few points in the networks' place, and what that over all points is like."""
    own = ground(arm_of(reading), **settings)
    few = {side: partial(rated, own.arm, side) for side in sides}
    rows = []
    for side, rating in few.items():
        # The measure over fewer points is a bound: a pose below the best value, but for rounding, is ruled out.
        proven = (rating(own.pool_set.q) >= own.largest - 1e-12).sum()
        rows.append({"points": side**2, **own.judge(rating), "proven": proven})
    kinds, jump = own.kinds
    shares = {f"share_{kind}": where.double().mean() for kind, where in kinds.items()}
    counts = {f"poses_{name}": where.sum() for name, where in own.sets.items()}
    rows.append({"points": own.per_side**2, "largest": own.largest, "jump": jump, **shares, **counts})
    cuts = [[own.along(rating, poses) for _, poses in own.lines] for rating in (own.rate, few[min(sides)])]
    return rows, {"places": np.stack([place for place, _ in own.lines]), "cuts": np.array(cuts)}


@experiment(
    keys=("task", "way"),
    timed=True,
    unsteady=("lower", "median", "upper"),
    smoke={**SMALL, **CHEAP, "neurons": 4, "batch": 100, "searched": 10, "rounds": 1},
    **BY_ARM,
)
def times(
    seed: int,
    reading: Mapping[str, Any],
    sides: tuple[int, ...] = (2, 3, 5),
    neurons: int = 80,
    batch: int = 4096,
    searched: int = 100,
    rounds: int = 15,
    **settings: Any,
) -> Iterator[dict[str, Any]]:
    """Seconds a pose to rate a batch and to search the pool by way of a ranking, and seconds to teach a network."""
    own = ground(arm_of(reading), **settings)
    poses, pool = own.pool_set.q[:batch], own.pool_set.q
    start = time.perf_counter()
    network = own.taught(neurons, seed)
    yield {"task": "teach", "way": "network", "configurations": 1, "median": time.perf_counter() - start}
    ways: dict[str, Rating] = {"network": network}
    ways |= {f"{side**2} points": partial(rated, own.arm, side) for side in sides}
    every = {**ways, f"{own.per_side**2} points": own.rate}

    def search(rating: Rating) -> Tensor:
        return own.rate(pool[rating(pool).topk(searched).indices]).max()

    tasks = {
        "rate": [Way(name, partial(rating, poses), len(poses)) for name, rating in every.items()],
        "search": [Way(name, partial(search, rating), len(pool)) for name, rating in ways.items()],
    }
    for task, of_task in tasks.items():
        for way in measure(of_task, rounds, seconds=0.05):
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
    cut: int = 361

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

    @cached_property
    def kinds(self) -> tuple[dict[str, Tensor], float]:
        """Fresh poses within a step of a jump or a steep slope, and those where M_a is zero; the largest jump."""
        least = 0.1 * self.largest
        change, jump = steepness(self.rate, self.fresh_set.q, least)
        # A change that is no jump has shrunk to almost nothing by now.
        jumping, zero = jump > least / 2, self.fresh_set.values == 0
        kinds = {"jump": jumping, "slope": (change > least) & ~jumping, "zero": zero}
        return kinds, float(jump.max()) / self.largest

    @property
    def sets(self) -> dict[str, Tensor]:
        values, gentle = self.fresh_set.values, ~(self.kinds[0]["jump"] | self.kinds[0]["slope"])
        return {"all": values >= 0, "high": values > 0.5 * self.largest, "gentle": gentle}

    def misses(self, rating: Rating) -> Tensor:
        return (rating(self.fresh_set.q) - self.fresh_set.values).abs() / self.largest

    def judge(self, rating: Rating) -> dict[str, Any]:
        """Errors by set, and the best among the first poses of a ranking as a share of the best of all."""
        misses, facts = self.misses(rating), {}
        for name, chosen in self.sets.items():
            for title, share in (("median", 0.5), ("most", 0.99), ("largest", 1.0)):
                facts[f"{name}_{title}"] = np.quantile(misses[chosen].numpy(), share)
        ranked = self.pool_set.values[rating(self.pool_set.q).argsort(descending=True)]
        kept = ranked.cummax(0).values / self.largest
        best = {f"best_of_{count}": kept[count - 1] for count in self.first}
        return {**facts, **best, "needed": (kept < 0.99).sum() + 1}

    @property
    def lines(self) -> list[tuple[Tensor, Tensor]]:
        """Places and poses as the base moves away from the middle through the best pose, and turns there."""
        best = self.pool_set.q[self.pool_set.values.argmax()]
        distance = torch.linspace(0, _farthest(self.arm), self.cut, dtype=torch.float64)
        yaw = torch.linspace(-math.pi, math.pi, self.cut, dtype=torch.float64)
        moved, turned = best.repeat(self.cut, 1), best.repeat(self.cut, 1)
        moved[:, :2] = distance[:, None] * best[:2] / best[:2].norm()
        turned[:, 3] = yaw
        return [(distance, moved), (yaw, turned)]

    def along(self, rating: Rating, poses: Tensor) -> np.ndarray:
        """Values along a line; NaN where a network is not asked."""
        return rating(poses).masked_fill(~asked(self.arm, poses), math.nan).float().numpy()


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
    lower, upper = problem.lower.clone(), problem.upper.clone()
    lower[:2], upper[:2] = -_farthest(arm), _farthest(arm)
    # About half of the box is kept; a few more for small counts.
    poses = sampling.sobol(Box(lower, upper), 4 * count + 100, seed)
    return poses[asked(arm, poses)][:count]


def quarter_turned(poses: Tensor, turns: int) -> Tensor:
    """Turn poses (..., 4) by quarter turns about z, base and all; the square area looks the same."""
    x, y, z, yaw = poses.unbind(-1)
    for _ in range(turns % 4):
        x, y = -y, x
    return torch.stack([x, y, z, spatial.wrap_to_pi(yaw + turns * QUARTER)], dim=-1)


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


def _farthest(arm: Chain) -> float:
    """Largest x or y [m] from which all corners are within the length of the arm."""
    lowest = docking.DockingProblem(arm).height[0] + elbow_of(arm).height
    return math.sqrt(_reach_squared(arm) - lowest**2 - HALF_WIDTH**2) - HALF_WIDTH


def rated(arm: Chain, per_side: int, poses: Tensor) -> Tensor:
    """Rate poses by the exact measure over a grid of control points."""
    return docking.area_manipulability(arm, poses, docking.square(HALF_WIDTH, per_side))


def stand_in(network: FeedForward, poses: Tensor) -> Tensor:
    """Rate poses (N, 4) by a network, [m³]; what it has below zero is zero."""
    at_once = max(1, 2**15 // network.neurons)
    with torch.no_grad():
        return torch.cat([network(seen(some)) for some in poses.split(at_once)]).clamp(min=0)


def steepness(rate: Rating, poses: Tensor, least: float) -> tuple[Tensor, Tensor]:
    """Largest changes (N) of M_a to neighbours, and what is a jump of them; 0 where the change is below `least`.

    The way to the most different neighbour is halved again and again. What is left of the change then is a jump;
    that of a continuous function, however steep, vanishes.
    """
    steps = torch.diag(poses.new_tensor([0.01, 0.01, 0.01, 0.02]))
    beside = poses[:, None] + torch.cat([steps, -steps])
    change, which = (rate(beside) - rate(poses)[:, None]).abs().max(1)
    steep, jump = change > least, torch.zeros_like(change)
    near, far = poses[steep], beside[steep, which[steep]]
    low, high = rate(near), rate(far)
    for _ in range(16):
        middle = (near + far) / 2
        between = rate(middle)
        first = (between - low).abs() >= (high - between).abs()
        near, far = torch.where(first[:, None], near, middle), torch.where(first[:, None], middle, far)
        low, high = torch.where(first, low, between), torch.where(first, between, high)
    jump[steep] = (high - low).abs()
    return change, jump
