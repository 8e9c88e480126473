"""Paper C, sections II and IV: what its data are made of, and what their columns can tell.

Liao & Mao (2018), Eqs. 1–12, Tables I–V, Figs. 2–4. The Fanuc arm's differences are compared with its exact
Jacobian; the sets are drawn again at the sizes of Table I; the rule for what is in reach meets all branches
of the inverse kinematics; and each column is shuffled, to see what depends on it.

Thresholds: a printed number of the Fanuc arm is *reproduced* if the exact one rounds to it. A range of a
table is *reproduced* if the columns of all files stay within it, and in each training file fill 97 % of it.
Drawing is uniform where no distribution of a column is farther than 0.01 (Kolmogorov and Smirnov's distance,
and what chance makes of that) from the uniform one. The printed rows of Table VI fit a share of poses in
reach if the rounding of their numbers allows it.
"""

from __future__ import annotations

import functools
import itertools
import math
import tempfile
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import torch
from jaxtyping import Float64
from numpy.typing import NDArray
from scipy import stats
from sklearn.manifold import TSNE
from sklearn.metrics import mutual_info_score
from sklearn.model_selection import cross_val_score
from sklearn.neighbors import KNeighborsRegressor
from torch import Tensor

from dexterity import robots, spatial
from dexterity.chain import Chain
from dexterity.inverse_kinematics import spherical_wrist
from dexterity.report.claims import Acceptance, Outcome, Paper, Verdict, load_paper
from dexterity.report.stored import Tolerance
from dexterity.workspace import dataset, reachability
from dexterity.workspace.dataset import ConfidenceData, JacobianData, Samples, Scaling
from dexterity.workspace.dynamics import DynamicParameters, asada_ratio
from dexterity.workspace.reachability import LINK_NAMES, Branch

__all__ = [
    "CONFIGS",
    "TOLERANCE",
    "Balance",
    "BruteForce",
    "Config",
    "Differences",
    "File",
    "Influence",
    "Map",
    "Result",
    "RoundTrip",
    "acceptance",
    "balance_table",
    "check_table",
    "embedded",
    "fanuc",
    "file_table",
    "implied_shares",
    "influence_table",
    "map_table",
    "range_table",
    "run",
    "uniformity_table",
    "verdicts",
]

TOLERANCE = Tolerance(rtol=1e-5, atol=1e-6)
"""What a probe may miss by, since rounding errors come out a little different on every processor."""

_PAPER = "liao2018"
_ANGLES = "three angles"
_REDRAWN, _PLAIN, _KEPT = "labels", "labels, nothing redrawn", "Jacobians"
_UNIFORM = 0.01
_FILLED = 0.97
_SAME = 1e-9


@dataclass(frozen=True)
class Config:
    """How much is drawn.

    Attributes
    ----------
    share
        Of the sizes of the training sets of Table I; test sets have theirs.
    manipulators, poses
        For brute force: manipulators, and random poses of each.
    smallest_step
        Smallest step [rad] of the differences for the Fanuc arm.
    shuffled
        Samples for what depends on a column; the inertia is looked at in a tenth of them.
    mapped
        Points of a map by t-SNE; none if 0.
    seed
        Of all draws.
    """

    share: float = 0.1
    manipulators: int = 50
    poses: int = 1_000
    smallest_step: float = 1e-14
    shuffled: int = 50_000
    mapped: int = 600
    seed: int = 0


CONFIGS: Mapping[str, Config] = {
    "smoke": Config(0.01, 10, 100, smallest_step=1e-7, shuffled=1_000, mapped=0),
    "book": Config(),
    "full": Config(1.0, 1_000, shuffled=500_000, mapped=2_000),
}
"""What runs at each scale."""


@dataclass(frozen=True)
class Differences:
    """The Fanuc arm at zero, and how far differences are from its Jacobian.

    Attributes
    ----------
    pose
        (4, 4) difference of the pose for joint 1, over the step of the paper.
    jacobian
        (6, 6) exact geometric Jacobian; [m] in the first three rows.
    by_difference
        (6, 6) the same from differences with the paper's step.
    along
        Largest deviation of the sum of the joints' differences, each times its rate, from the derivative of
        the pose along random rates.
    steps
        Steps [rad].
    forward, central
        Largest error of an entry over random configurations, by step, of both kinds of differences.
    """

    pose: NDArray[np.float64]
    jacobian: NDArray[np.float64]
    by_difference: NDArray[np.float64]
    along: float
    steps: NDArray[np.float64]
    forward: NDArray[np.float64]
    central: NDArray[np.float64]


@dataclass(frozen=True)
class File:
    """A pair of files of the data set, features and labels.

    Attributes
    ----------
    targets, varying_targets
        Columns of labels, and how many of them vary.
    features, samples
        Columns of features, and rows.
    is_binary
        Whether labels are 0 and 1 alone.
    constant
        Columns of features that are the same in all rows.
    ranges
        Smallest and largest value of each group of columns.
    """

    targets: int
    varying_targets: int
    features: int
    samples: int
    is_binary: bool
    constant: tuple[int, ...]
    ranges: Mapping[str, tuple[float, float]]


@dataclass(frozen=True)
class Balance:
    """Shares of poses in reach.

    Attributes
    ----------
    redrawn, plain
        With the redraw rule, and without.
    by_arm
        Shares of manipulators that reach up to a tenth of the positions, two tenths, and so on.
    """

    redrawn: float
    plain: float
    by_arm: tuple[float, ...]


@dataclass(frozen=True)
class BruteForce:
    """The rule beside all branches of the inverse kinematics.

    Attributes
    ----------
    tried
        Number of manipulators with a pose each.
    disagreements
        For how many of them the rule and the branches disagree.
    turned
        For how many of them the branches change their answer when the tool is turned.
    eight
        Share of the poses in reach that eight different configurations reach.
    jacobians
        Share of them whose configurations have eight different Jacobians.
    """

    tried: int
    disagreements: int
    turned: int
    eight: float
    jacobians: float


@dataclass(frozen=True)
class RoundTrip:
    """Largest errors over samples in reach.

    Attributes
    ----------
    pose
        Of forward kinematics after inverse kinematics, over all eight branches.
    difference
        Of both Jacobians beside central differences.
    chain
        Of both Jacobians beside those of a chain of screws.
    """

    pose: float
    difference: float
    chain: float


@dataclass(frozen=True)
class Influence:
    """What depends on a group of columns.

    Attributes
    ----------
    label, jacobian, kept
        Shares of the variance that need it, from 0 to 1: of the label, of the Jacobian in the world's frame
        as far as poses are still in reach, and of whether a pose in reach is kept for the inertia. NaN for
        what has no such columns.
    bits
        What a column tells about the label by itself, in the mean, [bit].
    """

    label: float
    jacobian: float
    kept: float
    bits: float


@dataclass(frozen=True)
class Map:
    """Points in the plane by t-SNE.

    Attributes
    ----------
    points
        (n, 2), without a unit.
    links
        (n, 4) d₃, d₄, a₂, a₃ [m] of the points.
    told
        R² with which ten neighbours in the plane tell each of these and x, y, z; NaN where there is no map.
    """

    points: NDArray[np.float64]
    links: NDArray[np.float64]
    told: Mapping[str, float]


@dataclass(frozen=True)
class Result:
    """Everything that the chapter shows.

    Attributes
    ----------
    share
        Of the sizes of the training sets of Table I that was drawn.
    names
        Files that are written for all sets.
    files
        What is in them, by name.
    uniformity
        Distance from the uniform distribution, by set and by group of columns.
    influences
        By group of columns.
    maps
        Of the features and of the Jacobians of test sets, and of uniform random numbers.
    """

    fanuc: Differences
    share: float
    names: tuple[str, ...]
    files: Mapping[str, File]
    balance: Balance
    uniformity: Mapping[str, Mapping[str, float]]
    brute_force: BruteForce
    round_trip: RoundTrip
    influences: Mapping[str, Influence]
    maps: Mapping[str, Map]


def run(config: Config) -> Result:
    """Draw everything, and look at it."""
    test, train = _sets(config)
    plain = dataset.confidence_data(config.shuffled, config.seed + 20, redraw=0.0)
    drawn = {_PLAIN: plain.samples, _REDRAWN: train.conf.samples, _KEPT: train.jacob.samples}
    return Result(
        fanuc=_differences(config),
        share=config.share,
        names=_names(test, train),
        files={
            f"{name}, {part}": _file(*content)
            for part, own in (("test", test), ("train", train))
            for name, content in own.files().items()
        },
        balance=_balance(train.conf_dyna, plain, config),
        uniformity={name: _uniformity(samples) for name, samples in drawn.items()},
        brute_force=_brute_force(config),
        round_trip=_round_trip(plain.samples.rows(plain.reachable), config),
        influences=_influences(plain, config),
        maps={
            "features": _map(dataset.features(test.conf.samples), _asked(test.conf.samples), config),
            "Jacobians": _map(test.jacob.jacobian.flatten(1), _asked(test.jacob.samples), config),
            "noise": _map(*_noise(config), config),
        },
    )


# ---- the Fanuc arm ---------------------------------------------------------------------------------


def fanuc() -> Chain:
    """Return the arm of the paper's Fig. 1, with its flange for a tool."""
    return robots.build(robots.describe("fanuc_am120ib"))


def _differences(config: Config) -> Differences:
    arm, step = fanuc(), _numbers("difference-step")[0]
    zero = torch.zeros(6, dtype=torch.float64)
    pose = (arm.forward(step * torch.eye(6, dtype=torch.float64)[0]) - arm.forward(zero)) / step
    random = torch.Generator().manual_seed(config.seed)
    drawn = 2 * torch.rand(101, 6, generator=random, dtype=torch.float64) - 1
    rates, q = drawn[0], math.pi * drawn[1:]
    decades = round(-math.log10(config.smallest_step))
    steps = torch.logspace(-1, -decades, 4 * (decades - 1) + 1, dtype=torch.float64)
    exact = arm.geometric_jacobian(q)
    forward, central = (
        [(_by_difference(arm.forward, q, h, kind) - exact).abs().max().item() for h in steps.tolist()]
        for kind in (False, True)
    )
    along = (arm.forward(1e-6 * rates) - arm.forward(-1e-6 * rates)) / 2e-6
    parts = [
        (arm.forward(1e-6 * unit) - arm.forward(-1e-6 * unit)) / 2e-6 * rate
        for unit, rate in zip(torch.eye(6, dtype=torch.float64), rates, strict=True)
    ]
    return Differences(
        pose=pose.numpy(),
        jacobian=arm.geometric_jacobian(zero).numpy(),
        by_difference=_by_difference(arm.forward, zero, step, central=False).numpy(),
        along=(along - torch.stack(parts).sum(0)).abs().max().item(),
        steps=steps.numpy(),
        forward=np.array(forward),
        central=np.array(central),
    )


def _by_difference(forward: Callable[[Tensor], Tensor], q: Tensor, step: float, central: bool) -> Tensor:
    """Geometric Jacobian (..., 6, n) by Eqs. 1 and 7."""
    moves = step * torch.eye(q.shape[-1], dtype=torch.float64)
    here = forward(q)[..., None, :, :]
    if central:
        rates = (forward(q[..., None, :] + moves) - forward(q[..., None, :] - moves)) / (2 * step)
    else:
        rates = (forward(q[..., None, :] + moves) - here) / step
    spin = rates[..., :3, :3] @ here[..., :3, :3].mT
    omega = torch.stack(
        [
            spin[..., 2, 1] - spin[..., 1, 2],
            spin[..., 0, 2] - spin[..., 2, 0],
            spin[..., 1, 0] - spin[..., 0, 1],
        ],
        -1,
    )
    return torch.cat([rates[..., :3, 3], omega / 2], -1).mT


# ---- the sets --------------------------------------------------------------------------------------


class _Sets(NamedTuple):
    """Training or test sets; the Jacobians are written in two frames."""

    conf: ConfidenceData
    conf_dyna: ConfidenceData
    jacob: JacobianData

    def files(self) -> dict[str, tuple[Samples, Tensor]]:
        """Return samples and targets (n, columns) of each pair of files."""
        return {
            "conf": (self.conf.samples, self.conf.reachable.double()[:, None]),
            "conf_dyna": (self.conf_dyna.samples, self.conf_dyna.reachable.double()[:, None]),
            "jacob": (self.jacob.samples, self.jacob.in_frame("tool").flatten(1)),
            "jacob0": (self.jacob.samples, self.jacob.jacobian.flatten(1)),
        }


def _sets(config: Config) -> tuple[_Sets, _Sets]:
    """Draw test and training sets, the former as large as the paper's."""
    sizes = _numbers("table-samples")
    tests, trains = ([round(size) for size in part] for part in (sizes[0::2], sizes[1::2]))
    conf, dynamic, _, jacob = (
        test + round(config.share * train) for test, train in zip(tests, trains, strict=True)
    )
    drawn = (
        dataset.confidence_data(conf, config.seed),
        dataset.confidence_data(dynamic, config.seed + 1, dynamics=True),
        dataset.jacobian_data(jacob, config.seed + 2),
    )
    # Jacobians come in the order in which they were found, and the first ones are of arms that reach far.
    orders = _orders(config.seed + 3, conf, dynamic, jacob)
    (conf_test, dynamic_test, _, jacob_test) = tests
    cuts = (conf_test, dynamic_test, jacob_test)
    test = _Sets(*(_rows(d, o[:n]) for d, o, n in zip(drawn, orders, cuts, strict=True)))
    train = _Sets(*(_rows(d, o[n:]) for d, o, n in zip(drawn, orders, cuts, strict=True)))
    return test, train


def _rows(data: Any, where: Tensor) -> Any:
    return type(data)(data.samples.rows(where), data[1][where])


def _names(test: _Sets, train: _Sets) -> tuple[str, ...]:
    """Write a few samples of each set, and tell the files' names."""
    few = torch.arange(5)
    written: list[Path] = []
    with tempfile.TemporaryDirectory() as folder:
        for one, other in zip(train, test, strict=True):
            for frame in ("tool", "world") if isinstance(one, JacobianData) else ("tool",):
                written += dataset.write_csv(folder, _rows(one, few), _rows(other, few), frame)
    return tuple(sorted(path.name for path in written))


def _file(samples: Samples, targets: Tensor) -> File:
    x = dataset.features(samples)
    spread = targets.amax(0) - targets.amin(0)
    return File(
        targets=targets.shape[1],
        # Entries that are the same up to rounding are the same.
        varying_targets=int((spread > _SAME).sum()),
        features=x.shape[1],
        samples=len(x),
        is_binary=bool(((targets == 0) | (targets == 1)).all()),
        constant=tuple((x.amax(0) == x.amin(0)).nonzero()[:, 0].tolist()),
        ranges={
            name: (x[:, own].min().item(), x[:, own].max().item())
            for name, own in _column_groups(samples.dynamics is not None).items()
        },
    )


def _column_groups(dynamic: bool) -> dict[str, list[int]]:
    known = dataset.COLUMNS if dynamic else dataset.KINEMATIC_COLUMNS
    columns = {name: list(range(96))[own] for name, own in known.items()}
    groups = {"links": [*columns.pop("d")[2:4], *columns.pop("a")[1:3]]}
    del columns["alpha"]
    if "coulomb" in columns:
        own = columns.pop("coulomb")
        columns |= {"friction forwards": own[0::2], "friction backwards": own[1::2]}
    return groups | columns


def _balance(redrawn: ConfidenceData, plain: ConfidenceData, config: Config) -> Balance:
    links = plain.samples.links[: min(2_000, config.shuffled // 10), None]
    reach = reachability.reachable(links, plain.samples.position[-500:])
    counts, _ = np.histogram(reach.double().mean(1).numpy(), bins=10, range=(0, 1))
    return Balance(
        redrawn=redrawn.reachable.double().mean().item(),
        plain=plain.reachable.double().mean().item(),
        by_arm=tuple((counts / len(links)).tolist()),
    )


def _uniformity(samples: Samples) -> dict[str, float]:
    """Largest distance of a column of each group, scaled to [0, 1], from the uniform distribution."""
    groups = {
        "d₃, d₄, a₂, a₃": samples.links / dataset.LARGEST_LENGTH,
        "position": (samples.position + 0.4) / 0.8,
        "angles": samples.angles / math.tau,
        # For orientations that are uniform, the sine of the middle angle would be.
        "sine of the middle angle": (samples.angles[:, 1:2].sin() + 1) / 2,
    }
    return {
        name: max(stats.kstest(column, "uniform").statistic.item() for column in columns.mT.numpy())
        for name, columns in groups.items()
    }


# ---- the rule, and the branches --------------------------------------------------------------------


def _brute_force(config: Config) -> BruteForce:
    tried = config.manipulators * config.poses
    samples, _ = dataset.confidence_data(tried, config.seed + 30, redraw=0.0)
    T = spatial.pose(samples.rotation(), samples.position).unflatten(0, (config.manipulators, -1))
    turned_T = spatial.pose(T[..., :3, :3].roll(1, dims=1), T[..., :3, 3])
    disagreements = turned = reached = 0
    eight, different = 0, []
    for number, (links, poses) in enumerate(zip(samples.links[: len(T)], T, strict=True)):
        arm = reachability.arm(links)
        q, valid = spherical_wrist(arm, poses)
        rule, found = reachability.reachable(links, poses[:, :3, 3]), valid.any(-1)
        disagreements += int((rule != found).sum())
        reached += int(found.sum())
        eight += int(_all_apart(q[valid.all(-1)], angles=True).sum())
        # A tenth is enough for what is beside the point.
        if number < max(1, config.manipulators // 10):
            turned += int((spherical_wrist(arm, turned_T[number])[1].any(-1) != found).sum())
            J = arm.geometric_jacobian(q[valid.all(-1)])
            different.append(_all_apart(J.flatten(-2), angles=False))
    return BruteForce(
        tried, disagreements, turned, eight / reached, torch.cat(different).double().mean().item()
    )


def _all_apart(values: Tensor, angles: bool) -> Tensor:
    """Whether no two of eight vectors (n, 8, m) are the same, for each of n."""
    gaps = values[:, :, None] - values[:, None]
    gaps = (spatial.wrap_to_pi(gaps) if angles else gaps).abs().amax(-1)
    return (gaps + torch.eye(8, dtype=values.dtype)).amin((1, 2)) > 1e-6


def _round_trip(samples: Samples, config: Config) -> RoundTrip:
    T = spatial.pose(samples.rotation(), samples.position)
    errors = []
    for branch in itertools.starmap(Branch, itertools.product((True, False), repeat=3)):
        q, _ = reachability.inverse(samples.links, T, branch)
        errors.append((reachability.forward(samples.links, q) - T).abs().max().item())
    few = min(len(T), config.poses)
    links, q = samples.links[:few], reachability.inverse(samples.links[:few], T[:few])[0]
    exact = reachability.geometric_jacobian(links, q)
    body = reachability.body_jacobian(links, q)
    rough = _by_difference(
        lambda joints: reachability.forward(links[:, None] if joints.ndim == 3 else links, joints),
        q, 1e-6, central=True,
    )  # fmt: skip
    rough_body = reachability.in_tool_axes(rough, T[:few, :3, :3])
    arms = [reachability.arm(own) for own in links[: min(50, config.manipulators)]]
    by_chain = torch.stack([arm.geometric_jacobian(own) for arm, own in zip(arms, q, strict=False)])
    body_by_chain = torch.stack([arm.body_jacobian(own) for arm, own in zip(arms, q, strict=False)])
    return RoundTrip(
        pose=max(errors),
        difference=max((rough - exact).abs().max().item(), (rough_body - body).abs().max().item()),
        chain=max(
            (by_chain - exact[: len(arms)]).abs().max().item(),
            (body_by_chain - body[: len(arms)]).abs().max().item(),
        ),
    )


# ---- what depends on a column ----------------------------------------------------------------------


def _influences(plain: ConfidenceData, config: Config) -> dict[str, Influence]:
    """Shuffle each group of columns among the samples, and see what changes.

    Half the mean square of the changes over the variance is the share of the variance that cannot be had
    without these columns, where columns are independent (Jansen 1999).
    """
    samples, label = plain
    dynamic = dataset.confidence_data(config.shuffled, config.seed + 40, dynamics=True, redraw=0.0)
    arms = dynamic.samples.rows(dynamic.reachable.nonzero()[: config.shuffled // 10, 0])
    kept = _is_kept(arms)
    reached = samples.rows(label)
    J = _jacobian(reached)
    order = _orders(config.seed, len(label), len(J), len(kept))
    found = {}
    for name in (*LINK_NAMES, "x", "y", "z", _ANGLES):
        other = _shuffled(reached, name, order[1])
        still = reachability.reachable(other.links, other.position)
        found[name] = Influence(
            label=_needed(label, _is_reachable(_shuffled(samples, name, order[0]))),
            jacobian=_needed(J[still], _jacobian(other.rows(still))),
            kept=_needed(kept, _is_kept(_shuffled(arms, name, order[2]))),
            bits=_bits(_own_columns(samples, name), label),
        )
    drawn = dynamic.samples.dynamics
    for name in DynamicParameters._fields:
        columns = getattr(drawn, name).flatten(1)
        found[name] = Influence(
            # Neither label nor Jacobian is a function of them.
            label=0.0,
            jacobian=0.0,
            kept=_needed(kept, _is_kept(_shuffled(arms, name, order[2]))),
            bits=_bits(columns, dynamic.reachable),
        )
    return found


def _orders(seed: int, *sizes: int) -> list[Tensor]:
    random = torch.Generator().manual_seed(seed + 6)
    return [torch.randperm(size, generator=random) for size in sizes]


def _shuffled(samples: Samples, name: str, order: Tensor) -> Samples:
    if name == _ANGLES:
        return samples._replace(angles=samples.angles[order])
    if name in LINK_NAMES:
        return samples._replace(links=_with_column(samples.links, LINK_NAMES.index(name), order))
    if name in ("x", "y", "z"):
        return samples._replace(position=_with_column(samples.position, "xyz".index(name), order))
    own = {name: getattr(samples.dynamics, name)[order]}
    return samples._replace(dynamics=_dynamics(samples)._replace(**own))


def _with_column(values: Tensor, column: int, order: Tensor) -> Tensor:
    values = values.clone()
    values[:, column] = values[order, column]
    return values


def _own_columns(samples: Samples, name: str) -> Tensor:
    if name == _ANGLES:
        return samples.angles
    if name in LINK_NAMES:
        return samples.links[:, [LINK_NAMES.index(name)]]
    return samples.position[:, ["xyz".index(name)]]


def _is_reachable(samples: Samples) -> Tensor:
    return reachability.reachable(samples.links, samples.position)


def _jacobian(samples: Samples) -> Tensor:
    return reachability.geometric_jacobian(samples.links, _branch(samples)).flatten(1)


def _is_kept(samples: Samples) -> Tensor:
    """Whether poses are in reach and kept for the inertia."""
    ratio = asada_ratio(samples.links, _dynamics(samples), _branch(samples))
    return _is_reachable(samples) & (ratio > 0.03)


def _dynamics(samples: Samples) -> DynamicParameters:
    if samples.dynamics is None:
        raise ValueError("samples have no dynamic parameters")
    return samples.dynamics


def _branch(samples: Samples) -> Tensor:
    return reachability.inverse(samples.links, spatial.pose(samples.rotation(), samples.position))[0]


def _needed(one: Tensor, other: Tensor) -> float:
    """Half the mean square of the changes, over the variance, of all outputs together."""
    one, other = one.double(), other.double()
    both = torch.cat([one, other])
    return (0.5 * (one - other).square().mean(0).sum() / both.var(0, correction=0).sum()).item()


def _bits(columns: Tensor, label: Tensor) -> float:
    """Mutual information of a column, in 20 equal parts of its range, and a label; the mean over columns.

    What chance alone would make of it is taken off, (parts − 1) / 2n (Miller 1955).
    """
    bias = 19 / (2 * len(label))
    low, high = columns.amin(0), columns.amax(0)
    parts = (20 * (columns - low) / (high - low)).clamp(max=19.5).floor()
    told = [mutual_info_score(part, label) - bias for part in parts.mT.numpy()]
    return float(np.mean(told) / math.log(2))


# ---- maps -----------------------------------------------------------------------------------------


_TOLD = (*LINK_NAMES, "x", "y", "z")


def _asked(samples: Samples) -> Tensor:
    """Return what maps are asked for (n, 7), links and position."""
    return torch.cat([samples.links, samples.position], 1)


def _noise(config: Config) -> tuple[Tensor, Tensor]:
    """Ten columns of uniform numbers, as many as features vary, and seven of them for what is asked."""
    random = torch.Generator().manual_seed(config.seed + 50)
    columns = torch.rand(max(1, config.mapped), 10, generator=random, dtype=torch.float64)
    return columns, columns[:, :7]


def _map(rows: Tensor, asked: Tensor, config: Config) -> Map:
    if not config.mapped:
        return Map(np.empty((0, 2)), np.empty((0, 4)), dict.fromkeys(_TOLD, math.nan))
    rows, asked = rows[: config.mapped], asked[: config.mapped]
    points = embedded(rows, config.seed)
    neighbours = KNeighborsRegressor(10)
    told = {
        name: float(cross_val_score(neighbours, points, own, scoring="r2", cv=5).mean())
        for name, own in zip(_TOLD, asked.mT.numpy(), strict=True)
    }
    return Map(points, asked[:, :4].numpy(), told)


def embedded(rows: Float64[Tensor, "n columns"], seed: int) -> NDArray[np.float64]:
    """Lay points in the plane by t-SNE, each column scaled to deviation 1 and constant ones left out.

    Parameters
    ----------
    rows
        Points, more than 30.
    seed
        Of the algorithm.

    Returns
    -------
    (n, 2) places, without a unit.

    References
    ----------
    van der Maaten & Hinton (2008), Visualizing data using t-SNE.
    """
    varying = rows.amax(0) - rows.amin(0) > _SAME
    scaled = Scaling.to_unit_deviation(rows).apply(rows)[:, varying]
    return TSNE(perplexity=30, init="pca", random_state=seed).fit_transform(scaled.numpy()).astype(float)


# ---- tables ----------------------------------------------------------------------------------------


def implied_shares() -> dict[str, tuple[float, float]]:
    """Shares of poses in reach that JSC, precision and recall of the rows of Table VI allow, by method.

    Of right answers in all, JSC is the share; with precision p, recall r and share s of poses in reach,
    1 − JSC = s (1 − 2 r + r / p). What the rounding of the three allows is an interval.
    """
    paper = _paper()
    found = {}
    for claim in paper.claims:
        kind, _, method = claim.id.partition("-")
        if kind == "retrieval":
            right = paper.claim(f"confidence-{method}")
            name = " ".join(_NAMES.get(word, word) for word in method.split("-"))
            found[name] = _implied_share(paper, right.id, claim.id)
    return found


_NAMES = {
    "svm": "SVM",
    "xgboost": "XGBoost",
    "lightgbm": "LightGBM",
    "bayes": "Bayes",
    "gaussian": "Gaussian",
}


def _implied_share(paper: Paper, right: str, retrieval: str) -> tuple[float, float]:
    jsc, (precision, recall) = _numbers(right)[0], _numbers(retrieval)
    jsc_off, off = paper.claim(right).rounding, paper.claim(retrieval).rounding
    corners = itertools.product(
        (jsc - jsc_off, jsc + jsc_off),
        (precision - off, min(1.0, precision + off)),
        (recall - off, min(1.0, recall + off)),
    )
    shares = [(1 - j) / (1 - 2 * r + r / p) for j, p, r in corners]
    return min(shares), max(shares)


def balance_table(result: Result) -> dict[str, float]:
    """Shares of poses in reach [%]."""
    balance = result.balance
    return {
        "nothing redrawn": 100 * balance.plain,
        "redrawn, as assumed": 100 * balance.redrawn,
        "median that Table VI allows": 100 * _median_implied(),
    }


def _median_implied() -> float:
    return float(np.median([sum(bounds) / 2 for bounds in implied_shares().values()]))


def file_table(result: Result) -> dict[str, dict[str, str]]:
    """Table I, with how many targets vary."""
    return {
        name: {
            "targets": str(file.targets),
            "that vary": str(file.varying_targets),
            "features": str(file.features),
            "that vary ": str(file.features - len(file.constant)),
            "samples": f"{file.samples:,}",
            "kind": "classification" if file.is_binary else "regression",
        }
        for name, file in result.files.items()
    }


def range_table(result: Result) -> dict[str, dict[str, str]]:
    """Smallest and largest value of each group of columns, printed and over all our files."""
    rows = {}
    for group in _RANGES:
        printed, found = _printed_range(group), _observed(result, group)
        rows[group] = {
            "printed": "–" if printed is None else _range(printed),
            "ours": _range((min(low for low, _ in found), max(high for _, high in found))),
        }
    return rows


def _range(edges: tuple[float, float]) -> str:
    """Write a range with digits for its width, so that almost nothing is nothing."""
    low, high = edges
    places = 3 - math.floor(math.log10(high - low))
    return f"{round(low, places) + 0.0:g} to {round(high, places):g}"


_RANGES: Mapping[str, str] = {
    "links": "link-range",
    "mass": "mass-range",
    "centre": "centre-range",
    "inertia": "inertia-range",
    "viscous": "viscous-range",
    "friction forwards": "coulomb-range",
    "friction backwards": "coulomb-range",
    "gear": "gear-range",
    "motor": "motor-columns",
    "position": "position-range",
    "angles": "angle-range",
}
"""Claims on the groups of columns."""


def _printed_range(group: str) -> tuple[float, float] | None:
    """Range that the tables print for a group of columns; None for the motors, which have none."""
    if group == "angles":
        return 0.0, math.tau
    if group == "motor":
        return None
    low, high = (
        _numbers(_RANGES[group])[2:4] if group == "friction backwards" else _numbers(_RANGES[group])[:2]
    )
    return low, high


def _observed(result: Result, group: str, part: str = "") -> list[tuple[float, float]]:
    """Ranges of a group of columns in the files that have it."""
    return [
        file.ranges[group]
        for name, file in result.files.items()
        if group in file.ranges and name.endswith(part)
    ]


def _is_filled(result: Result, group: str) -> bool:
    """Whether all files stay in the printed range and the training files fill it."""
    printed = _printed_range(group)
    if printed is None:
        return False
    low, high = printed
    inside = all(low <= least and most <= high for least, most in _observed(result, group))
    filled = all(most - least >= _FILLED * (high - low) for least, most in _observed(result, group, "train"))
    return inside and filled


def uniformity_table(result: Result) -> dict[str, dict[str, float]]:
    """Distances from the uniform distribution."""
    return {name: dict(groups) for name, groups in result.uniformity.items()}


def check_table(result: Result) -> dict[str, str]:
    """Everything that was checked about the rule and the Jacobians."""
    brute, trip = result.brute_force, result.round_trip
    return {
        "poses tried": f"{brute.tried:,}",
        "rule and branches disagree": str(brute.disagreements),
        "answers that change as the tool turns": str(brute.turned),
        "poses in reach with eight configurations": f"{brute.eight:.2%}",
        "and eight different Jacobians": f"{brute.jacobians:.2%}",
        "largest error of a pose, all branches": f"{trip.pose:.0e}",
        "Jacobians beside central differences": f"{trip.difference:.0e}",
        "Jacobians beside those of a chain": f"{trip.chain:.0e}",
    }


def influence_table(result: Result) -> dict[str, dict[str, float]]:
    """Tell what depends on each group of columns [%], and what one of them says by itself [mbit]."""
    return {
        name: {
            "label [%]": 100 * own.label,
            "Jacobian [%]": 100 * own.jacobian,
            "kept [%]": 100 * own.kept,
            "alone [mbit]": round(1e3 * own.bits, 1) + 0.0,
        }
        for name, own in result.influences.items()
    }


def map_table(result: Result) -> dict[str, dict[str, float]]:
    """R² with which neighbours on the maps tell lengths and position."""
    return {name: dict(own.told) for name, own in result.maps.items()}


# ---- verdicts --------------------------------------------------------------------------------------

_SETTING = "Taken over as a setting; nothing can be tested. "


def verdicts(result: Result) -> tuple[Verdict, ...]:
    """Judge the claims of the ledger that this study answers for, by the thresholds named above."""
    return (
        *_on_the_fanuc(result.fanuc),
        *_on_differences(result.fanuc),
        *_on_maps_to_learn(result),
        *_on_the_sampler(result),
        *_on_the_tables(result),
        *_on_the_figures(result),
    )


_VELOCITIES: Mapping[str, tuple[int, slice]] = {
    "fanuc-first-velocity": (0, slice(0, 3)),
    "fanuc-second-velocity": (1, slice(0, 3)),
    "fanuc-third-velocity": (2, slice(0, 2)),
    "fanuc-third-velocity-upwards": (2, slice(2, 3)),
    "fanuc-fifth-velocity": (4, slice(0, 3)),
    "fanuc-first-angular-velocity": (0, slice(3, 6)),
}
"""Joint, and rows of its column of the Jacobian."""


def _on_the_fanuc(fanuc: Differences) -> Iterator[Verdict]:
    paper = _paper()
    for name, (joint, rows) in _VELOCITIES.items():
        claim, ours = paper.claim(name), fanuc.jacobian[rows, joint]
        printed = np.array(_numbers(name))
        holds = bool((np.abs(ours - printed) <= claim.rounding + _SAME).all())
        yield _verdict(
            name, Outcome.of(holds), _listed(np.round(ours, 12) + 0.0), "",
            "Exact, from the published parameters of the arm.",
        )  # fmt: skip
    printed = np.array(_numbers("fanuc-rotation-difference")).reshape(3, 3)
    off = np.argwhere(np.abs(fanuc.pose[:3, :3] - printed) > 1e-6)
    places = ", ".join(f"({row + 1}, {column + 1})" for row, column in off)
    yield _verdict(
        "fanuc-rotation-difference", Outcome.CONTRADICTED if len(off) else Outcome.REPRODUCED,
        f"{len(off)} of 9 entries off" + (f", at {places}" if len(off) else ""), "",
        "The rotation at zero is the identity, whose derivative has nothing on its diagonal: a misprint.",
    )  # fmt: skip
    sideways = np.abs(fanuc.jacobian[[0, 2], 0]).max() < _SAME < abs(fanuc.jacobian[1, 0])
    yield _verdict(
        "fanuc-first-joint-sideways", Outcome.of(bool(sideways)), "along y alone", "",
        "The tool point is straight ahead of the first axis.",
    )  # fmt: skip
    moving = tuple(int(j) + 1 for j in np.flatnonzero(np.abs(fanuc.jacobian[:3]).max(0) > _SAME))
    yield _verdict(
        "fanuc-moving-joints", Outcome.of(moving == (1, 2, 3, 5)), f"joints {_listed(moving)}", "",
        "The axes of joints 4 and 6 pass through the tool point.",
    )  # fmt: skip


def _on_differences(fanuc: Differences) -> tuple[Verdict, ...]:
    error = np.abs(fanuc.by_difference - fanuc.jacobian).max()
    best = fanuc.steps[fanuc.forward.argmin()]
    same = Outcome.of(bool(error < 1e-6))
    return (
        _verdict(
            "pose-difference", same, f"within {error:.0e}", "of the exact Jacobian",
            "With the step of the paper, and to more digits than it prints.",
        ),
        _verdict(
            "difference-step", Outcome.OUT_OF_SCOPE, "", "",
            f"{_SETTING}In double precision forward differences are best near {best:.0e} rad, to "
            f"{fanuc.forward.min():.0e}; central ones near {fanuc.steps[fanuc.central.argmin()]:.0e} rad, to "
            f"{fanuc.central.min():.0e}.",
        ),
        _verdict(
            "angular-velocity", same, f"within {error:.0e}", "of the exact Jacobian",
            "Of the difference only the skew part counts; the rest is of the order of the step.",
        ),
        _verdict(
            "jacobian", same, "", "", "Velocity of the tool point and angular velocity, in the base's axes.",
        ),
        _verdict(
            "sum-of-derivatives", Outcome.IN_SHAPE if fanuc.along < 1e-6 else Outcome.NOT_REPRODUCED,
            f"within {fanuc.along:.0e}", "with each derivative times its rate",
            "It needs the rates, which Eq. 6 has; as printed, Eq. 5 also lacks joint 1 and the row that it "
            "belongs to.",
        ),
    )  # fmt: skip


def _on_maps_to_learn(result: Result) -> tuple[Verdict, ...]:
    brute, plain = result.brute_force, result.balance.plain
    return (
        _verdict(
            "forward-has-left-inverse", Outcome.of(False) if brute.eight == 0 else Outcome.CONTRADICTED,
            f"{brute.eight:.1%} of the poses in reach have eight configurations", "",
            "A left inverse would tell them apart; what there is gives one of them, a right inverse where "
            "poses are in reach.",
        ),
        _verdict(
            "forward-not-onto", Outcome.of(plain < 1), f"{1 - plain:.0%} of the poses are out of reach",
            "of those that the sampler draws", "For this family position decides, and orientation never.",
        ),
        _verdict(
            "jacobian-of-a-pose", Outcome.UNDERSPECIFIED,
            f"{brute.jacobians:.1%} of the poses in reach have eight Jacobians", "",
            "It is a function only once a branch is named, which the sampler does and the paper does not.",
        ),
        _verdict(
            "two-steps", Outcome.IN_SHAPE if brute.disagreements == 0 else Outcome.NOT_REPRODUCED,
            f"{brute.disagreements} disagreements in {brute.tried:,} poses", "of rule and all branches",
            "The first map is an exact rule of two lines. The second as printed is not given the pose, which "
            "it needs.",
        ),
        _verdict("empirical-risk", Outcome.REPRODUCED, "", "", "Holds by definition."),
    )  # fmt: skip


def _on_the_sampler(result: Result) -> tuple[Verdict, ...]:
    names = {name.partition("_")[0] for name in result.names}
    chance = 2 / math.sqrt(result.files["conf, train"].samples)
    plain, redrawn, kept = (max(list(result.uniformity[name].values())[:3]) for name in _DRAWN)
    sine = result.uniformity[_PLAIN]["sine of the middle angle"]
    return (
        _verdict(
            "sampler-settings", Outcome.OUT_OF_SCOPE, "", "",
            f"{_SETTING}The share of test samples is that of Table I, to the sample.",
        ),
        _verdict(
            "sampler-is-uniform", Outcome.IN_SHAPE if plain < _UNIFORM + chance else Outcome.NOT_REPRODUCED,
            f"{plain:.3f} from uniform as drawn, {redrawn:.3f} after the redraw, {kept:.3f} for Jacobians",
            "largest distance of a column",
            "What is drawn is uniform, but what is kept is not; nor are orientations, since the sine of the "
            f"middle angle is {sine:.2f} from uniform.",
        ),
        _verdict(
            "sampler-purposes", Outcome.OUT_OF_SCOPE, "", "",
            "Only the sets that the paper's networks are trained on are made here.",
        ),
        _verdict(
            "file-count", Outcome.of((len(result.names),) == _numbers("file-count")),
            f"{len(result.names)} files", "", "Written with the paper's names on request.",
        ),
        _verdict(
            "file-prefixes", Outcome.of(names == {"conf", "jacob", "jacob0"}), ", ".join(sorted(names)), "",
            "Where the text says that the Jacobians train the confidence network it means the other one.",
        ),
    )  # fmt: skip


_DRAWN = (_PLAIN, _REDRAWN, _KEPT)
_TABLE = tuple(
    f"{name}, {part}" for name in ("conf", "conf_dyna", "jacob", "jacob0") for part in ("test", "train")
)


def _on_the_tables(result: Result) -> Iterator[Verdict]:
    files = [result.files[name] for name in _TABLE]
    targets, features = tuple(file.targets for file in files), tuple(file.features for file in files)
    varying = {name: result.files[f"{name}, train"].varying_targets for name in ("jacob0", "jacob")}
    yield _verdict(
        "table-targets", Outcome.of(targets == _numbers("table-targets")), _listed(targets), "",
        f"Of the 36 entries of a Jacobian {varying['jacob0']} vary in the world's frame and "
        f"{varying['jacob']} in the tool's; the others are zero or one.",
    )  # fmt: skip
    yield _verdict(
        "table-features", Outcome.of(features == _numbers("table-features")), _listed(features), "",
        f"{len(files[0].constant)} of them are constant; {features[2] - features[0]} are dynamic parameters.",
    )  # fmt: skip
    yield _verdict(
        "table-samples", Outcome.OUT_OF_SCOPE, _listed(tuple(file.samples for file in files)), "",
        f"{_SETTING}Training sets are drawn at {result.share:.0%} of their sizes.",
    )  # fmt: skip
    binary = [file.is_binary for file in files]
    yield _verdict(
        "table-kinds", Outcome.of(binary == 4 * [True] + 4 * [False]), "", "",
        "Labels are zero or one; entries of Jacobians are not.",
    )  # fmt: skip
    constant = {file.constant for file in files}
    yield _verdict(
        "constant-columns", Outcome.of(constant == {_numbers("constant-columns")}),
        " or ".join(map(_listed, sorted(constant))), "",
        "Twists, and lengths that are zero.",
    )  # fmt: skip
    yield from _on_ranges(result)


def _on_ranges(result: Result) -> Iterator[Verdict]:
    ours = {group: row["ours"] for group, row in range_table(result).items()}
    for group, claim in _RANGES.items():
        if group not in ("motor", "friction forwards", "friction backwards"):
            yield _verdict(
                claim, Outcome.of(_is_filled(result, group)), ours[group], "", "Over all files that have it."
            )
    both = ("friction forwards", "friction backwards")
    yield _verdict(
        "coulomb-range", Outcome.of(all(_is_filled(result, group) for group in both)),
        " and ".join(ours[group] for group in both), "", "Forwards and backwards, in turn.",
    )  # fmt: skip
    own = dataset.COLUMNS["motor"]
    yield _verdict(
        "motor-columns", Outcome.of((own.start, own.stop - 1) == _numbers("motor-columns")),
        ours["motor"], "range assumed", "The columns are where the table has them.",
    )  # fmt: skip


def _on_the_figures(result: Result) -> tuple[Verdict, ...]:
    implied = implied_shares()
    fit = {
        share: sum(low <= share <= high for low, high in implied.values())
        for share in (result.balance.redrawn, result.balance.plain)
    }
    found = [
        _verdict(
            "class-balance", Outcome.UNDERSPECIFIED,
            f"{result.balance.redrawn:.1%} in reach, {result.balance.plain:.1%} if nothing is redrawn", "",
            f"The figure has no numbers. Of the {len(implied)} rows of Table VI "
            f"{fit[result.balance.redrawn]} and {fit[result.balance.plain]} fit these; most fit "
            f"{_median_implied():.0%}, of which the paper says nothing.",
        )
    ]  # fmt: skip
    by_chance = _told(result.maps["noise"])
    for name, claim in (("features", "map-of-features"), ("Jacobians", "map-of-jacobians")):
        told = _told(result.maps[name])
        found.append(
            _verdict(
                claim, Outcome.UNDERSPECIFIED, told, "R² of ten neighbours on our map" if told else "",
                "No settings are printed, and nothing is said of what is to be seen."
                + (f" A map of uniform noise has {by_chance} for its columns." if told else ""),
            )
        )  # fmt: skip
    return tuple(found)


def _told(shown: Map) -> str:
    """Say how well neighbours on a map tell the links, from worst to best; nothing where there is no map."""
    told = [shown.told[name] for name in LINK_NAMES if not math.isnan(shown.told[name])]
    return f"{min(told):.2f} to {max(told):.2f}" if told else ""


def acceptance(result: Result) -> tuple[Acceptance, ...]:
    """Figures that must hold for the book to be built."""
    brute, trip = result.brute_force, result.round_trip
    dynamic = [result.influences[name] for name in ("viscous", "coulomb")]
    return (
        Acceptance("poses on which rule and branches disagree", brute.disagreements, 0),
        Acceptance("poses that are lost or won as the tool turns", brute.turned, 0),
        Acceptance("largest error of a pose", trip.pose, 1e-12),
        Acceptance("largest error of a Jacobian beside differences", trip.difference, 1e-8),
        Acceptance("largest error of a Jacobian beside a chain's", trip.chain, 1e-12),
        Acceptance("what the label needs of the angles", result.influences[_ANGLES].label, 0.0),
        Acceptance("what being kept needs of friction", max(own.kept for own in dynamic), 0.0),
    )


def _listed(values: Iterable[float]) -> str:
    return ", ".join(f"{value:g}" for value in values)


@functools.cache
def _paper() -> Paper:
    return load_paper(_PAPER)


def _numbers(claim: str) -> tuple[float, ...]:
    value = _paper().claim(claim).value
    if value is None:
        raise ValueError(f"claim {claim} has no value")
    return value if isinstance(value, tuple) else (value,)


def _verdict(claim: str, outcome: Outcome, ours: str, spread: str, sentence: str) -> Verdict:
    return Verdict(_PAPER, claim, outcome, ours, spread, sentence)
