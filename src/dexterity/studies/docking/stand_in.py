"""Beyond paper B: a network in place of the area manipulability where that is dear, over many control points.

Sotiropoulos, Aspragathos & Andritsos (2011) take four control points, Eq. 1, and more make the exact measure
slower. Here it is taken over a grid of 441, and a network is trained to answer for it. It is judged by its
error, by its speed beside that of the exact measure over many points and over few, and by what it is for: to
rank many poses, so that the dear measure has to look at the first of them alone. Everything is done for the
arm as stated and for the fitted one. The question is that of Sotiropoulos, Aspragathos & Geffard (2012); no
claim of a ledger is judged.

Chosen beforehand: poses are those that the docking problem allows by its text and from which all corners are
within the length of the arm, since the rest is told by a distance. The network sees the middle of the area
from the base, because limits of joints stand still there, and the yaw modulo a quarter turn, which the area
looks the same after. Its size is the one with the smallest error on a validation set.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple, TypeAlias

import numpy as np
import torch
from jaxtyping import Bool, Float64
from numpy.typing import NDArray
from torch import Tensor

from dexterity import docking, indices, sampling, spatial
from dexterity.chain import Chain
from dexterity.docking.elbow import ElbowArm
from dexterity.networks.feed_forward import FeedForward
from dexterity.networks.levenberg_marquardt import Options, levenberg_marquardt
from dexterity.networks.network import View
from dexterity.networks.threads import one_thread
from dexterity.report.claims import Acceptance, Verdict
from dexterity.report.ranges import with_range
from dexterity.report.stored import Tolerance
from dexterity.sampling import Box, DataSet
from dexterity.studies.docking.area import arms
from dexterity.timing import Timing, Way, measure, ratio

__all__ = [
    "CONFIGS",
    "NETWORK",
    "TOLERANCE",
    "Arm",
    "Config",
    "Cut",
    "Errors",
    "Rating",
    "Result",
    "Screen",
    "Steepness",
    "Worst",
    "acceptance",
    "asked",
    "draw",
    "error_table",
    "quarter_turned",
    "run",
    "screen_table",
    "seen",
    "size_table",
    "stand_in",
    "steepness",
    "time_table",
    "verdicts",
    "worst_table",
]

NETWORK = "network"
"""Name of the stand-in among the ways to rate a pose; exact ways are named for their number of points."""

Rating: TypeAlias = Callable[[Tensor], Tensor]
"""From poses (..., 4) to values (...) [m³]."""

TOLERANCE = Tolerance(rtol=1e-3, atol=1e-6)
"""What a probe may miss by, since a training carries rounding errors on and makes them larger."""

_HALF_WIDTH = 0.2  # [m], of the task area
_QUARTER = math.pi / 2
_HIGH = 0.5  # of the largest value
_WORST = 0.01  # share of the poses
_NEAR = 0.99  # of the best value
_STEPS = (0.01, 0.01, 0.01, 0.02)  # [m] and [rad], to neighbours of a pose
_STEEP = 0.1  # of the largest value, within a step
_ROUNDING = 1e-12  # [m³]
_HALVINGS = 16  # to less than a μm or μrad
_NUMBERS_AT_ONCE = 2**15
_SHOWN = (1, 10, 100, 1000)


@dataclass(frozen=True)
class Config:
    """How much is drawn, trained and timed.

    Attributes
    ----------
    per_side
        Control points a side of the measure that is stood in for.
    screens
        Control points a side of the cheaper measures.
    neurons
        Sizes that are tried.
    rows, epochs
        Of each training.
    seeds
        Of training sets and initial weights.
    validation, fresh, pool
        Poses by which a size is chosen, by which networks are judged, and among which the best is looked for.
    seed
        Of these three sets.
    first
        How many poses of a ranking the exact measure looks at, from one on.
    searched
        The same for the searches that are timed.
    cut
        Poses of each cut.
    branches
        Poses at which all branches are looked at one by one.
    timed, rounds, seconds
        Poses in a batch, how often each way gets its turn, and for how long at least [s]; no times without
        rounds.
    """

    per_side: int = 21
    screens: tuple[int, ...] = (2, 3, 5)
    neurons: tuple[int, ...] = (10, 20, 40)
    rows: int = 2048
    epochs: int = 60
    seeds: tuple[int, ...] = (0, 1, 2, 3, 4)
    validation: int = 2048
    fresh: int = 2048
    pool: int = 16_384
    seed: int = 1000
    first: tuple[int, ...] = (1, 2, 5, 10, 20, 50, 100, 200, 500, 1000)
    searched: int = 100
    cut: int = 361
    branches: int = 200
    timed: int = 2048
    rounds: int = 5
    seconds: float = 0.05


CONFIGS: Mapping[str, Config] = {
    "smoke": Config(
        per_side=5, screens=(2, 3), neurons=(2, 4), rows=200, epochs=5, seeds=(0, 1), validation=100,
        fresh=300, pool=500, first=(1, 10, 100), searched=10, cut=21, branches=20, timed=100, rounds=0,
    ),
    "book": Config(),
    "full": Config(
        neurons=(20, 40, 80), rows=4096, epochs=100, validation=4096, fresh=16_384, pool=65_536,
        timed=4096, rounds=15,
    ),
}  # fmt: skip
"""What runs at each scale."""


# ---- results ---------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Errors:
    """How far a way to rate poses is off, as a share of the largest M_a; one for each seed.

    Attributes
    ----------
    poses
        How many it was judged on.
    median, most, largest
        Of the absolute errors: half and 99 % of the poses stay below, and the largest.
    """

    poses: int
    median: tuple[float, ...]
    most: tuple[float, ...]
    largest: tuple[float, ...]


@dataclass(frozen=True)
class Worst:
    """Where a network is worst; shares of poses by the kind of their place.

    Kinds are `"jump"` and `"slope"`, where M_a changes by more than a tenth of its largest value within a
    step of 1 cm or 0.02 rad, by a jump or without one, and `"zero"`, where it is zero.

    Attributes
    ----------
    everywhere
        Among all poses.
    worst
        Among the hundredth of the poses at which a network is off most; one for each seed.
    jump
        Largest jump that was found, as a share of the largest M_a.
    """

    everywhere: Mapping[str, float]
    worst: Mapping[str, tuple[float, ...]]
    jump: float


@dataclass(frozen=True)
class Screen:
    """How well a way ranks the poses of the pool; one for each seed.

    Attributes
    ----------
    first
        How many poses of the ranking are looked at, from one on.
    kept
        (seeds, k) best M_a among as many, as a share of the best of all.
    needed
        How many poses from the first on have to be looked at to come within 1 % of the best.
    proven
        Poses that are rated at least as high as the best one is worth. Where ratings are bounds no other
        can be the best; None where they are not.
    """

    first: tuple[int, ...]
    kept: NDArray[np.float64]
    needed: tuple[int, ...]
    proven: int | None


@dataclass(frozen=True)
class Cut:
    """M_a [m³] along a line through the best pose.

    Attributes
    ----------
    place
        (n,) where on the line, [m] or [rad].
    exact, few
        (n,) over all control points, and over the fewest; NaN where the network is not asked.
    network
        (seeds, n) as the networks know it.
    """

    place: NDArray[np.float64]
    exact: NDArray[np.float64]
    few: NDArray[np.float64]
    network: NDArray[np.float64]


@dataclass(frozen=True)
class Arm:
    """What stands in for the measure of one of the arms.

    Attributes
    ----------
    largest
        Largest M_a of the pool [m³].
    turning
        Largest change of M_a by quarter turns about z [m³].
    tool_turning
        Largest change of w, over all branches one by one, as the tool is turned about its own axis [m³].
    rising
        By how much M_a over all points is at most above that over fewer of them [m³].
    sizes
        Root mean square error on the validation set, as a share of the largest M_a, by number of neurons;
        one for each seed.
    neurons
        The number that was chosen.
    errors
        By way, then by set of poses.
    worst
        Where the networks are worst.
    screens
        By way.
    cuts
        Along the distance of the base from the middle of the area, and along ψ.
    times, searches
        To rate a batch of poses, by way, and to find a pose of the pool by way of a ranking; empty if no
        times were taken.
    teaching
        Seconds that one network took, exact values and training; None if no times were taken.
    """

    largest: float
    turning: float
    tool_turning: float
    rising: float
    sizes: Mapping[str, tuple[float, ...]]
    neurons: int
    errors: Mapping[str, Mapping[str, Errors]]
    worst: Worst
    screens: Mapping[str, Screen]
    cuts: Mapping[str, Cut]
    times: tuple[Timing, ...]
    searches: tuple[Timing, ...]
    teaching: float | None


@dataclass(frozen=True)
class Result:
    """Both arms, by name."""

    arms: Mapping[str, Arm]


def run(config: Config) -> Result:
    """Train networks for both arms and put them beside the exact measure."""
    with one_thread():
        return Result({name: _Contest(arm, config).result() for name, arm in arms().items()})


# ---- poses -----------------------------------------------------------------------------------------


def asked(arm: Chain, poses: Tensor) -> Bool[Tensor, "*batch"]:
    """Tell at which poses (..., 4) a stand-in is asked: elsewhere M_a is zero or the pose not allowed.

    Raises
    ------
    ValueError
        If the arm is no elbow arm.
    """
    elbow = _elbow(arm)
    x, y, z, _ = poses.unbind(-1)
    far = (x.abs() + _HALF_WIDTH).square() + (y.abs() + _HALF_WIDTH).square()
    within = far + (z + elbow.height).square() <= _reach_squared(elbow)
    return within & docking.DockingProblem(arm, region="or").allows(poses)


def draw(arm: Chain, count: int, seed: int) -> Float64[Tensor, "count 4"]:
    """Draw poses at which a stand-in is asked, from a scrambled Sobol sequence.

    Raises
    ------
    ValueError
        If `count` is not positive, or the arm is no elbow arm.
    """
    problem = docking.DockingProblem(arm, region="or")
    lower, upper = problem.lower.clone(), problem.upper.clone()
    lower[:2], upper[:2] = -_farthest(arm), _farthest(arm)
    # About half of the box is kept; a few more for small counts.
    poses = sampling.sobol(Box(lower, upper), 4 * count + 100, seed)
    return poses[asked(arm, poses)][:count]


def quarter_turned(poses: Tensor, turns: int) -> Float64[Tensor, "*batch 4"]:
    """Turn poses (..., 4) by quarter turns about z, base and all; the square area looks the same."""
    x, y, z, yaw = poses.unbind(-1)
    for _ in range(turns % 4):
        x, y = -y, x
    return torch.stack([x, y, z, spatial.wrap_to_pi(yaw + turns * _QUARTER)], dim=-1)


def seen(poses: Tensor) -> Float64[Tensor, "*batch 4"]:
    """Return what a network is told of poses (..., 4), the same after a quarter turn.

    Returns
    -------
    The middle of the area in the base [m], and ψ modulo a quarter turn, −π/4 ≤ ψ < π/4 [rad].
    """
    x, y, z, yaw = poses.unbind(-1)
    cosine, sine = yaw.cos(), yaw.sin()
    folded = yaw - _QUARTER * (yaw / _QUARTER + 0.5).floor()
    return torch.stack([-cosine * x - sine * y, sine * x - cosine * y, -z, folded], dim=-1)


def stand_in(network: FeedForward, poses: Tensor) -> Float64[Tensor, " N"]:
    """Rate poses (N, 4) by a network, [m³]; what it has below zero is zero."""
    at_once = max(1, _NUMBERS_AT_ONCE // network.neurons)
    with torch.no_grad():
        return torch.cat([network(seen(some)) for some in poses.split(at_once)]).clamp(min=0)


class Steepness(NamedTuple):
    """How M_a changes about poses.

    Attributes
    ----------
    change
        (N,) largest change to a neighbour [m³].
    jump
        (N,) what is a jump of it [m³]; 0 where the change is too small to be looked into.
    """

    change: Tensor
    jump: Tensor


def steepness(rate: Rating, poses: Tensor, least: float) -> Steepness:
    """Compare poses (N, 4) with neighbours 1 cm or 0.02 rad away, forth and back along each coordinate.

    The way to the most different one is halved again and again. What is left of the change then is a jump;
    that of a continuous function, however steep, vanishes.

    Parameters
    ----------
    rate
        Exact measure of poses (..., 4).
    poses
        Where to look.
    least
        Smallest change that is looked into [m³].
    """
    steps = torch.diag(poses.new_tensor(_STEPS))
    beside = poses[:, None] + torch.cat([steps, -steps])
    change, which = (rate(beside) - rate(poses)[:, None]).abs().max(1)
    steep = change > least
    jump = torch.zeros_like(change)
    if steep.any():
        jump[steep] = _halved(rate, poses[steep], beside[steep, which[steep]])
    return Steepness(change, jump)


def _halved(rate: Rating, near: Tensor, far: Tensor) -> Tensor:
    """Change (n) that is left on the steepest piece of the ways between poses (n, 4)."""
    low, high = rate(near), rate(far)
    for _ in range(_HALVINGS):
        middle = (near + far) / 2
        between = rate(middle)
        first = (between - low).abs() >= (high - between).abs()
        near, far = torch.where(first[:, None], near, middle), torch.where(first[:, None], middle, far)
        low, high = torch.where(first, low, between), torch.where(first, between, high)
    return (high - low).abs()


def _elbow(arm: Chain) -> ElbowArm:
    elbow = ElbowArm.of(arm)
    if elbow is None:
        raise ValueError(f"arm is {arm}; an elbow arm is needed")
    return elbow


def _reach_squared(elbow: ElbowArm) -> float:
    """Square of how far a tool point may be from the first axis and the shoulder's height together [m²]."""
    return (elbow.upper_arm + elbow.forearm) ** 2 + elbow.sideways**2


def _farthest(arm: Chain) -> float:
    """Largest x or y [m] from which all corners are within the length of the arm."""
    elbow = _elbow(arm)
    lowest = docking.DockingProblem(arm).height[0] + elbow.height
    return math.sqrt(_reach_squared(elbow) - lowest**2 - _HALF_WIDTH**2) - _HALF_WIDTH


# ---- one arm ---------------------------------------------------------------------------------------


class _Contest:
    """One arm, the sets of poses with their exact values, and the networks of the size that was chosen."""

    def __init__(self, arm: Chain, config: Config) -> None:
        self.arm, self.config = arm, config
        validation, self.fresh, self.pool = (
            self.drawn(count, config.seed + i)
            for i, count in enumerate((config.validation, config.fresh, config.pool))
        )
        self.largest = float(self.pool.values.max())
        start = time.perf_counter()
        sets = [self.drawn(config.rows, seed) for seed in config.seeds]
        drawing = time.perf_counter() - start
        trained = {neurons: _trained(neurons, sets, config) for neurons in config.neurons}
        self.sizes = {
            neurons: tuple(self.root_mean_square(network, validation) for network in networks)
            for neurons, (networks, _) in trained.items()
        }
        self.neurons = min(config.neurons, key=lambda neurons: float(np.median(self.sizes[neurons])))
        self.networks, training = trained[self.neurons]
        self.teaching = (drawing + training) / len(config.seeds)

    def result(self) -> Arm:
        """Judge the networks beside the exact measure over fewer points."""
        kinds, jump = self.kinds()
        misses = {name: self.misses(own) for name, own in self.ways().items()}
        return Arm(
            largest=self.largest,
            turning=max(self.turning(turns) for turns in (1, 2, 3)),
            tool_turning=self.tool_turning(),
            rising=max(self.rising(per_side) for per_side in self.config.screens),
            sizes={str(neurons): own for neurons, own in self.sizes.items()},
            neurons=self.neurons,
            errors={name: self.errors(own, kinds) for name, own in misses.items()},
            worst=self.worst(misses[NETWORK], kinds, jump),
            screens={name: self.screen(name, own) for name, own in self.ways().items()},
            cuts=self.cuts(),
            times=self.times(),
            searches=self.searches(),
            teaching=self.teaching if self.config.rounds else None,
        )

    def rate(self, poses: Tensor) -> Tensor:
        """Exact M_a of poses (..., 4) over all control points."""
        return _rated(self.arm, self.config.per_side, poses)

    def drawn(self, count: int, seed: int) -> DataSet:
        """Draw poses with their exact values."""
        poses = draw(self.arm, count, seed)
        return DataSet(poses, self.rate(poses))

    def root_mean_square(self, network: FeedForward, data: DataSet) -> float:
        """Error of a network as a share of the largest M_a."""
        miss = stand_in(network, data.q) - data.values
        return float(miss.square().mean().sqrt()) / self.largest

    def ways(self) -> dict[str, tuple[Rating, ...]]:
        """Functions that rate poses: a network for each seed, and the exact measure over fewer points."""
        exact = {
            _points(per_side): (partial(_rated, self.arm, per_side),) for per_side in self.config.screens
        }
        return {NETWORK: tuple(partial(stand_in, network) for network in self.networks), **exact}

    # What must not change the measure.

    def turning(self, turns: int) -> float:
        """Largest change of M_a by quarter turns [m³]."""
        turned = self.rate(quarter_turned(self.fresh.q, turns))
        return float((turned - self.fresh.values).abs().max())

    def tool_turning(self) -> float:
        """Largest change of w by turns of the tool about its axis, over all branches [m³]."""
        poses = self.fresh.q[: self.config.branches]
        straight, *turned = (self.by_branches(poses, angle) for angle in (0.0, 0.7, 2.0, 4.0))
        return max(float((values - straight).abs().max()) for values in turned)

    def by_branches(self, poses: Tensor, angle: float) -> Tensor:
        """Largest w (N, 4) at the corners, with the tool turned about its axis [rad]."""
        twist = torch.tensor([0, 0, 0, angle, 0, 0], dtype=torch.float64)
        tool = torch.tensor(docking.TOOL_UP, dtype=torch.float64) @ spatial.exp(twist)[:3, :3]
        corners = docking.square(_HALF_WIDTH)
        q, valid, within = docking.configurations(self.arm, poses, corners, tool)
        w = indices.manipulability(self.arm.geometric_jacobian(q))
        return torch.where(valid & within, w, 0.0).amax(-1)

    def rising(self, per_side: int) -> float:
        """By how much M_a over all points is at most above that over fewer of them [m³]."""
        return float((self.fresh.values - _rated(self.arm, per_side, self.fresh.q)).max())

    # How far off a way is, and where.

    def misses(self, ratings: Sequence[Rating]) -> Tensor:
        """Absolute errors (seeds, N) on the fresh poses, as shares of the largest M_a."""
        misses = torch.stack([rating(self.fresh.q) - self.fresh.values for rating in ratings])
        return misses.abs() / self.largest

    def kinds(self) -> tuple[dict[str, Tensor], float]:
        """Tell which fresh poses (N) are of each kind, and the largest jump as a share of the largest M_a."""
        least = _STEEP * self.largest
        change, jump = steepness(self.rate, self.fresh.q, least)
        # A change that is no jump has shrunk to almost nothing by now.
        jumping = jump > least / 2
        kinds = {"jump": jumping, "slope": (change > least) & ~jumping, "zero": self.fresh.values == 0}
        return kinds, float(jump.max()) / self.largest

    def errors(self, misses: Tensor, kinds: Mapping[str, Tensor]) -> dict[str, Errors]:
        """Sum up errors (seeds, N) over sets of poses."""
        sets = {
            "all": torch.ones_like(kinds["zero"]),
            "high": self.fresh.values > _HIGH * self.largest,
            "gentle": ~(kinds["jump"] | kinds["slope"]),
        }
        return {name: _errors(misses[:, chosen]) for name, chosen in sets.items()}

    def worst(self, misses: Tensor, kinds: Mapping[str, Tensor], jump: float) -> Worst:
        """Tell where errors (seeds, N) are largest."""
        worst = misses.topk(math.ceil(_WORST * misses.shape[1])).indices
        return Worst(
            everywhere={kind: _share(where) for kind, where in kinds.items()},
            worst={kind: tuple(_share(where[own]) for own in worst) for kind, where in kinds.items()},
            jump=jump,
        )

    # What a ranking is good for.

    def screen(self, name: str, ratings: Sequence[Rating]) -> Screen:
        """Look at the poses of the pool in the order in which each function rates them."""
        scores = [rating(self.pool.q) for rating in ratings]
        ranked = torch.stack([self.pool.values[own.argsort(descending=True)] for own in scores])
        kept = ranked.cummax(1).values / self.largest
        return Screen(
            first=self.config.first,
            kept=kept[:, [count - 1 for count in self.config.first]].numpy(),
            needed=tuple((kept < _NEAR).sum(1).add(1).tolist()),
            proven=None if name == NETWORK else int((scores[0] >= self.largest - _ROUNDING).sum()),
        )

    def cuts(self) -> dict[str, Cut]:
        """Move the base from the middle of the area through the best pose, and turn it at the best pose."""
        best = self.pool.q[self.pool.values.argmax()]
        distance = torch.linspace(0, _farthest(self.arm), self.config.cut, dtype=torch.float64)
        yaw = torch.linspace(-math.pi, math.pi, self.config.cut, dtype=torch.float64)
        moved, turned = (best.repeat(self.config.cut, 1) for _ in range(2))
        moved[:, :2] = distance[:, None] * best[:2] / best[:2].norm()
        turned[:, 3] = yaw
        return {"distance": self.cut(distance, moved), "ψ": self.cut(yaw, turned)}

    def cut(self, place: Tensor, poses: Tensor) -> Cut:
        """Rate poses (n, 4) along a line."""
        outside = ~asked(self.arm, poses)

        def shown(rating: Rating) -> NDArray[np.float64]:
            return rating(poses).masked_fill(outside, math.nan).numpy()

        few = partial(_rated, self.arm, min(self.config.screens))
        networks = np.stack([shown(rating) for rating in self.ways()[NETWORK]])
        return Cut(place.numpy(), shown(self.rate), shown(few), networks)

    # How long it takes.

    def one_of_each(self) -> dict[str, Rating]:
        """Return the first network, the exact measure over fewer points, and that over all."""
        first = {name: ratings[0] for name, ratings in self.ways().items()}
        return first | {_points(self.config.per_side): self.rate}

    def times(self) -> tuple[Timing, ...]:
        batch = self.pool.q[: self.config.timed]
        ways = [Way(name, partial(rating, batch), len(batch)) for name, rating in self.one_of_each().items()]
        return _timed(ways, self.config)

    def searches(self) -> tuple[Timing, ...]:
        pool = self.pool.q
        ways = [
            Way(name, partial(self.search, ratings[0], pool), len(pool))
            for name, ratings in self.ways().items()
        ]
        return _timed(ways, self.config)

    def search(self, rating: Rating, poses: Tensor) -> Tensor:
        """Return the best M_a of the poses that a rating puts first."""
        return self.rate(poses[rating(poses).topk(self.config.searched).indices]).max()


def _rated(arm: Chain, per_side: int, poses: Tensor) -> Tensor:
    return docking.area_manipulability(arm, poses, docking.square(_HALF_WIDTH, per_side))


def _trained(neurons: int, sets: Sequence[DataSet], config: Config) -> tuple[list[FeedForward], float]:
    """Train a network for each seed; return them and the seconds that it took."""
    start = time.perf_counter()
    x, values = torch.stack([seen(own.q) for own in sets]), torch.stack([own.values for own in sets])
    randoms = [torch.Generator().manual_seed(seed) for seed in config.seeds]
    view = View(4, range(4))
    untrained = [
        FeedForward.untrained(view, neurons, rows, answers, random)
        for rows, answers, random in zip(x, values, randoms, strict=True)
    ]
    trainings = levenberg_marquardt(untrained, x, values, Options(epochs=config.epochs))
    return [training.network for training in trainings], time.perf_counter() - start


def _errors(misses: Tensor) -> Errors:
    sizes = misses.numpy()
    median, most, largest = np.quantile(sizes, (0.5, 0.99, 1.0), axis=1).tolist()
    return Errors(sizes.shape[1], tuple(median), tuple(most), tuple(largest))


def _share(where: Tensor) -> float:
    return float(where.double().mean())


def _points(per_side: int) -> str:
    return f"{per_side**2} points"


def _timed(ways: Sequence[Way], config: Config) -> tuple[Timing, ...]:
    return measure(ways, config.rounds, config.seconds) if config.rounds else ()


# ---- what is shown ---------------------------------------------------------------------------------

_SETS = {
    "all": "all poses",
    "high": "M_a above half of the largest",
    "gentle": "neither jump nor steep slope",
}


def size_table(result: Result) -> dict[str, dict[str, str]]:
    """Root mean square errors on the validation set by number of neurons [% of the largest M_a]."""
    return {
        f"{name} arm": {f"{neurons} neurons": with_range(own, _percent) for neurons, own in arm.sizes.items()}
        | {"chosen": f"{arm.neurons}"}
        for name, arm in result.arms.items()
    }


def error_table(result: Result) -> dict[tuple[str, str, str], dict[str, str]]:
    """Errors on fresh poses [% of the largest M_a], by arm, set of poses and way."""
    rows = {}
    for name, arm in result.arms.items():
        for kind, title in _SETS.items():
            # What is gentle was asked for the sake of the network.
            ways = arm.errors if kind != "gentle" else {NETWORK: arm.errors[NETWORK]}
            for way, errors in ways.items():
                rows[f"{name} arm", title, way] = _error_row(errors[kind])
            if kind == "all":
                rows[f"{name} arm", title, "continuous"] = _bound_row(arm.worst.jump / 2)
    return rows


def _bound_row(largest: float) -> dict[str, str]:
    """Tell what the largest error of a continuous function is at least, wherever it is."""
    return {"poses": "–", "median": "–", "99 %": "–", "largest": f"≥ {_percent(largest)}"}


def _error_row(errors: Errors) -> dict[str, str]:
    return {
        "poses": f"{errors.poses:,}",
        "median": with_range(errors.median, _percent),
        "99 %": with_range(errors.most, _percent),
        "largest": with_range(errors.largest, _percent),
    }


def worst_table(result: Result) -> dict[tuple[str, str], dict[str, str]]:
    """Tell at what kinds of places all poses are, and those at which a network is off most [%]."""
    return {
        (f"{name} arm", place): {title: with_range(shares[kind], _percent) for kind, title in _KINDS.items()}
        for name, arm in result.arms.items()
        for place, shares in (
            ("all poses", {kind: (share,) for kind, share in arm.worst.everywhere.items()}),
            ("the worst hundredth", arm.worst.worst),
        )
    }


_KINDS = {"jump": "near a jump", "slope": "on a steep slope", "zero": "M_a is zero"}


def time_table(result: Result) -> dict[tuple[str, str], dict[str, str]]:
    """Show times to rate poses, and how many pay for teaching a network; empty if none were taken."""
    return {
        (f"{name} arm", timing.name): {
            "median [μs]": f"{1e6 * timing.median:.3g}",
            "quartiles [μs]": f"{1e6 * timing.lower:.3g}–{1e6 * timing.upper:.3g}",
            "over the network's": "1" if timing is arm.times[0] else f"{ratio(timing, arm.times[0])}",
            "whole pool [ms]": f"{1e3 * timing.median * arm.searches[0].configurations:.3g}",
            "poses that pay for teaching": _poses_that_pay(arm, timing),
        }
        for name, arm in result.arms.items()
        for timing in arm.times
    }


def _poses_that_pay(arm: Arm, timing: Timing) -> str:
    """After how many poses teaching a network took less time than the network saved, if it saves any."""
    slower = ratio(timing, arm.times[0])
    if arm.teaching is None or not slower.distinguishable or slower.value <= 1:
        return "–"
    return f"{arm.teaching / (timing.median - arm.times[0].median):,.0f}"


def screen_table(result: Result) -> dict[tuple[str, str], dict[str, str]]:
    """Tell what rankings of the pool are good for, and the times of searches by them where there are any."""
    return {
        (f"{name} arm", way): {
            **{
                f"best of {count} [%]": with_range(screen.kept[:, i], _percent)
                for i, count in enumerate(screen.first)
                if count in _SHOWN
            },
            "looked at, within 1 %": with_range(screen.needed, "{:,.0f}".format),
            "looked at, proof": "–" if screen.proven is None else f"{screen.proven:,}",
            "search [ms]": _milliseconds(arm.searches, way),
        }
        for name, arm in result.arms.items()
        for way, screen in arm.screens.items()
    }


def _milliseconds(searches: Sequence[Timing], way: str) -> str:
    """Time of a whole search [ms]; a dash where it was not taken."""
    found = [timing.median * timing.configurations for timing in searches if timing.name == way]
    return f"{1e3 * found[0]:.3g}" if found else "–"


def _percent(share: float) -> str:
    return f"{100 * share:.3g}"


# ---- verdicts --------------------------------------------------------------------------------------


def verdicts(result: Result) -> tuple[Verdict, ...]:  # noqa: ARG001 -- what every study offers
    """Judge nothing: no claim of a ledger belongs to this study."""
    return ()


def acceptance(result: Result) -> tuple[Acceptance, ...]:
    """Figures that must hold for the book to be built."""
    return tuple(
        Acceptance(f"{what}, {name} arm [m³]", value, _ROUNDING)
        for name, arm in result.arms.items()
        for what, value in (
            ("change of M_a by quarter turns", arm.turning),
            ("change of w as the tool turns about its axis", arm.tool_turning),
            ("rise of M_a with more control points", arm.rising),
        )
    )
