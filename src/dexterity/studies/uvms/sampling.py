"""Paper A, sections 3.1 and 4.2: where the data sets come from, and how much hangs on that.

Sotiropoulos & Aspragathos (2016), Eqs. 11 and 12, Fig. 7, Tables 2 and 3. Inputs are found from the
derivation, the search area is drawn, and what the paper leaves open (task point, turned base, width of the
sector, rows, kind of draw) is varied, with networks of the paper's sizes as judges. Then the data are
extended as the paper says they could be: to wider joint ranges, and to vehicles farther off.

All errors are relative, Eq. 21, and E is the paper's limit for them. A training has the paper's limit of
epochs, and no goal that would end it earlier. Thresholds: the data sets are *reproduced* if exactly the
printed joints are found, and the search area if the arm reaches the task point from every configuration whose
base is in it. That KCI needs more data is *reproduced* if it needs at least twice the rows of w, *in shape*
if it needs more at all; needed are the fewest rows tried whose median error is within a quarter of that for
the most rows. That the whole space is possible is *reproduced* if some network keeps its median error over
fresh points within E for joints that turn all the way, *in shape* if one does for ±90° or more, else *not
reproduced*. Any task point is *reproduced* if some network of either index keeps within E wherever the
vehicle is, *in shape* if that holds for one of the two, else *not reproduced*.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
import torch
from jaxtyping import Float64
from numpy.typing import NDArray
from torch import Tensor

from dexterity import robots, sampling, symbolic
from dexterity.chain import Chain
from dexterity.indices import Index
from dexterity.networks.feed_forward import FeedForward, Readout
from dexterity.networks.levenberg_marquardt import Options, levenberg_marquardt
from dexterity.networks.network import View
from dexterity.report.claims import Acceptance, Outcome, Verdict, load_paper
from dexterity.report.ranges import with_range
from dexterity.report.stored import Tolerance
from dexterity.sampling import Box, DataSet, DataSets, Method, Space, TaskSector

__all__ = [
    "ASSUMED",
    "AS_PRINTED",
    "CONFIGS",
    "FROM_VEHICLE",
    "INDICES",
    "METHODS",
    "TOLERANCE",
    "TURNED",
    "Choice",
    "Config",
    "Extension",
    "Result",
    "Trained",
    "acceptance",
    "base_positions",
    "choice_table",
    "choices",
    "error_table",
    "extension_table",
    "input_table",
    "reaching",
    "run",
    "sector_outline",
    "verdicts",
]

INDICES: Mapping[str, Index] = {"w": Index("manipulability"), "KCI": Index("kinematic_conditioning")}
"""The two indices of the paper, with unit limits, in the spatial frame."""

TOLERANCE = Tolerance(rtol=1e-3, atol=1e-6)
"""What a probe may miss by, since a training carries rounding errors on and makes them larger."""

METHODS: tuple[Method, ...] = ("grid", "sobol", "uniform")
"""Ways to draw a training set."""

ASSUMED = "as assumed"
"""Name of the choice that the other chapters build on."""

TURNED = "turned base in the area"
"""Name of the other reading of Fig. 7."""

AS_PRINTED = "as printed"
"""Name of networks that see the joints of Eq. 11 and answer as Eqs. 13 to 16 do."""

FROM_VEHICLE = "origin seen from the vehicle, cone"
"""Name of networks that see the world's origin from the vehicle in place of θ1 … θ4.

They answer with a cone; see :class:`dexterity.networks.feed_forward.FeedForward`.
"""

_STEP_DEG = 5.0


@dataclass(frozen=True)
class Config:
    """How much is drawn and trained.

    Attributes
    ----------
    drawn, fresh, seed
        Configurations behind each range of an index, those that judge a network, and the seed of both.
    test
        Configurations of each test set, the paper's T.
    seeds, few_seeds
        Of training sets and initial weights: for networks of the paper's sizes, and where a training takes
        seconds or there are many of them.
    epochs
        Of each training.
    neurons
        Of the networks for w and for KCI, as printed.
    rows, kci_rows
        Sizes of the training sets that are compared.
    choice_rows
        Rows for KCI where an assumption is varied.
    half_ranges_deg, wide_neurons, wide_rows
        Greatest angles of the joints to either side, and the networks for w there.
    half_widths_m, wide_kci_neurons
        How far the vehicle may be to either side of the middle along x, y and z, and the better networks for
        KCI there; `wide_rows` are theirs too.
    """

    drawn: int = 20_000
    fresh: int = 50_000
    seed: int = 1000
    test: int = 1000
    seeds: tuple[int, ...] = (0, 1, 2)
    few_seeds: tuple[int, ...] = (0,)
    epochs: int = 100
    neurons: tuple[int, int] = (8, 25)
    rows: tuple[int, ...] = (300, 1000, 3000)
    kci_rows: tuple[int, ...] = (1000, 6000)
    choice_rows: int = 1500
    half_ranges_deg: tuple[float, ...] = (15.0, 30.0, 45.0, 90.0, 180.0)
    wide_neurons: tuple[int, ...] = (8, 20)
    wide_rows: int = 2000
    half_widths_m: tuple[float, ...] = (0.5, 2.0)
    wide_kci_neurons: tuple[int, ...] = (25,)


CONFIGS: Mapping[str, Config] = {
    "smoke": Config(
        drawn=500, fresh=500, test=100, seeds=(0, 1), epochs=5, neurons=(2, 3), rows=(50, 100),
        kci_rows=(100, 200), choice_rows=100, half_ranges_deg=(15.0, 90.0), wide_neurons=(2,), wide_rows=100,
        half_widths_m=(1.0,), wide_kci_neurons=(3,),
    ),
    "book": Config(),
    "full": Config(
        drawn=50_000, seeds=tuple(range(10)), few_seeds=(0, 1, 2), rows=(300, 1000, 3000, 10_000),
        kci_rows=(1000, 3000, 10_000), choice_rows=3000, wide_neurons=(8, 20, 40),
        wide_rows=5000, half_widths_m=(0.5, 1.0, 2.0), wide_kci_neurons=(25, 40),
    ),
}  # fmt: skip
"""What runs at each scale."""


@dataclass(frozen=True)
class Trained:
    """Networks that differ by their seed alone; relative errors, one for each seed.

    Attributes
    ----------
    neurons, rows
        Size of a network and of its training set.
    test
        Largest error over a test set that was drawn as the training set was.
    between
        Largest over as many configurations drawn uniformly.
    fresh, most
        Largest over many more of these, and what 99 % of them stay below.
    """

    neurons: int
    rows: int
    test: tuple[float, ...]
    between: tuple[float, ...]
    fresh: tuple[float, ...]
    most: tuple[float, ...]


@dataclass(frozen=True)
class Choice:
    """KCI over the space that one choice among the paper's open ones gives.

    Attributes
    ----------
    lowest, highest
        KCI among the configurations drawn.
    kinks
        Share of them whose two smallest singular values are within 2 % of each other.
    nearest, farthest
        Distances of the arm's base, with the vehicle turned as it is, from the task point [m].
    reachable
        Share of them from which the arm reaches the task point.
    reaching_error
        How far the wrist then is from it at most [m].
    trained
        Networks.
    """

    lowest: float
    highest: float
    kinks: float
    nearest: float
    farthest: float
    reachable: float
    reaching_error: float
    trained: Trained


@dataclass(frozen=True)
class Extension:
    """An index over a space that is wider than the paper's.

    Attributes
    ----------
    half_width
        How far the joints [deg] or the vehicle along x, y and z [m] go to either side.
    lowest, highest
        The index among the configurations drawn.
    grid_rows
        Rows of the space's whole grid at the paper's step, without what has no grid.
    trained
        Networks, by their size.
    """

    half_width: float
    lowest: float
    highest: float
    grid_rows: int
    trained: tuple[Trained, ...]


@dataclass(frozen=True)
class Result:
    """What the data are, and what networks make of them.

    Attributes
    ----------
    inputs
        Joints that w and KCI depend on by their derivation, from 1: those that vary in their spaces.
    shares, values
        Parts of the configurations, and the value that an index stays below in so many of them: by index,
        then by kind of draw.
    by_method
        Networks for w, by kind of draw and size of the training set.
    kci_by_rows
        Networks for KCI, by size of the training set.
    choices
        KCI for each of :func:`choices`.
    ranges
        w for wider and wider ranges of the joints.
    places
        KCI for wider and wider ranges of the vehicle's place, by networks :data:`AS_PRINTED` and
        :data:`FROM_VEHICLE`.
    """

    inputs: Mapping[str, tuple[int, ...]]
    shares: NDArray[np.float64]
    values: Mapping[str, Mapping[str, NDArray[np.float64]]]
    by_method: Mapping[str, tuple[Trained, ...]]
    kci_by_rows: tuple[Trained, ...]
    choices: Mapping[str, Choice]
    ranges: tuple[Extension, ...]
    places: Mapping[str, tuple[Extension, ...]]


def run(config: Config) -> Result:
    """Draw the data of every choice, and train on them."""
    chain = robots.uvms()
    w, kci = (_Problem.of(chain, name, config) for name in INDICES)
    w_neurons, kci_neurons = config.neurons
    better = replace(kci, readout="cone", carriers=chain.screws[:6], first_seen=4)
    w_space, sectors = sampling.uvms_space("manipulability"), choices()
    assumed = sectors[ASSUMED]
    shares = np.linspace(0, 1, 201)
    return Result(
        inputs={"w": _varying(w_space), "KCI": _varying(assumed)},
        shares=shares,
        values={"w": w.quantiles(w_space, shares), "KCI": kci.quantiles(assumed, shares)},
        by_method={
            method: tuple(w.trained(w_space, w_neurons, rows, config.seeds, method) for rows in config.rows)
            for method in METHODS
        },
        kci_by_rows=tuple(kci.trained(assumed, kci_neurons, rows, config.seeds) for rows in config.kci_rows),
        choices={name: _choice(chain, kci, sector) for name, sector in sectors.items()},
        ranges=tuple(
            w.extension(deg, _turning(w_space, deg), config.wide_neurons) for deg in config.half_ranges_deg
        ),
        places={
            name: tuple(
                judge.extension(width, _anywhere(assumed, width), sizes) for width in config.half_widths_m
            )
            for name, judge, sizes in (
                (AS_PRINTED, kci, (kci_neurons,)),
                (FROM_VEHICLE, better, config.wide_kci_neurons),
            )
        },
    )


# ---- spaces ----------------------------------------------------------------------------------------


def choices() -> dict[str, TaskSector]:
    """Spaces for KCI, by what is chosen where the paper leaves a choice; the assumed ones first."""
    assumed = sampling.uvms_space("kinematic_conditioning")
    if not isinstance(assumed, TaskSector):
        raise TypeError("the KCI of the UVMS no longer depends on where the vehicle is")
    lower, upper = ((0.0,) * 3 + limits[3:] for limits in (assumed.rest.lower, assumed.rest.upper))
    return {
        ASSUMED: assumed,
        "task point at the world's origin": replace(assumed, task_point=(0.0, 0.0, 0.0)),
        "task point 2 m farther ahead": replace(assumed, task_point=(0.0, 3.35, 0.0)),
        TURNED: replace(assumed, turned=True),
        "30° to either side": replace(assumed, azimuth=math.radians(30), elevation=math.radians(30)),
        "area in the x–y plane": replace(assumed, elevation=0.0),
        "vehicle upright": replace(assumed, rest=Box(lower, upper, 7)),
    }


def base_positions(space: TaskSector, configurations: int, seed: int) -> NDArray[np.float64]:
    """Draw configurations, and return where the arm's base is in the world, vehicle turned: (m, 3) [m]."""
    q = sampling.uniform(space, configurations, torch.Generator().manual_seed(seed))
    return _base(robots.uvms(), q)[..., :3, 3].numpy()


def sector_outline(space: TaskSector) -> NDArray[np.float64]:
    """Return the border of the search area in the plane z = task point's z, (m, 3) [m], once around."""
    turn = np.linspace(-space.azimuth, space.azimuth, 30)
    inner, outer = ([r * np.sin(turn), r * np.cos(turn), 0 * turn] for r in (space.r_min, space.r_max))
    border = np.array(space.task_point)[:, None] - np.concatenate([inner, np.flip(outer, 1)], axis=1)
    return np.concatenate([border, border[:, :1]], axis=1).T


def reaching(chain: Chain, q: Tensor, task_point: Sequence[float]) -> Float64[Tensor, "*batch 12"]:
    """Turn the arm's first three joints until the wrist is at the task point.

    Parameters
    ----------
    chain
        The UVMS with its shoulder at the arm's base, l1 = 0.
    q
        (..., 12) joint values, of which θ7, θ8 and θ9 are replaced.
    task_point
        In the world [m].

    Returns
    -------
    Joint values with the elbow to one side; NaN for the three where the point is out of reach.
    """
    T_world_base = _base(chain, q)
    out = q.new_tensor(task_point) - T_world_base[..., :3, 3]
    x, y, z = (T_world_base[..., :3, :3].mT @ out[..., None])[..., 0].unbind(-1)
    lengths = robots.describe("uvms").lengths
    upper, lower = lengths["l2"], lengths["l3"]
    elbow = torch.acos((out.square().sum(-1) - upper**2 - lower**2) / (2 * upper * lower))
    beside = torch.atan2(lower * elbow.sin(), upper + lower * elbow.cos())
    shoulder = torch.atan2(-z, torch.hypot(x, y)) - beside
    return torch.cat([q[..., :6], torch.stack([torch.atan2(-x, y), shoulder, elbow], -1), q[..., 9:]], -1)


def _base(chain: Chain, q: Tensor) -> Tensor:
    """Pose of the arm's base, turned with the vehicle: T_world_base (..., 4, 4)."""
    arm_at_home = q.clone()
    arm_at_home[..., 6:] = 0.0
    T_tool_base = torch.eye(4, dtype=q.dtype)
    T_tool_base[1, 3] = robots.describe("uvms").lengths["y_MB"] - chain.home[1, 3]
    return chain.forward(arm_at_home) @ T_tool_base


def _varying(space: Space) -> tuple[int, ...]:
    """Joints that vary in a space, from 1."""
    q = space.from_unit(torch.stack([torch.zeros(space.dimensions), torch.ones(space.dimensions)]))
    return tuple(i for i, (first, last) in enumerate(q.T.tolist(), start=1) if first != last)


def _turning(space: Space, half_range_deg: float) -> Box:
    """Space of w with its joints in another range, at the paper's step."""
    wide = math.radians(half_range_deg) * (space.from_unit(torch.ones(space.dimensions)) > 0)
    return Box(-wide, wide, round(2 * half_range_deg / _STEP_DEG) + 1)


def _anywhere(sector: TaskSector, half_width: float) -> Box:
    """Space of KCI with the vehicle anywhere in a cube, its joints as the paper has them."""
    rest, cube = sector.rest, (half_width,) * 3
    return Box([-x for x in cube] + list(rest.lower), cube + rest.upper, (None,) * 3 + rest.levels)


# ---- trainings -------------------------------------------------------------------------------------


@dataclass(frozen=True)
class _Problem:
    """An index, how much is drawn and trained, and by what networks.

    Joints before the first that is seen are left to the carriers, if the networks have any.
    """

    f: symbolic.CompiledIndex
    config: Config
    readout: Readout = "identity"
    carriers: Tensor = field(default_factory=lambda: torch.zeros(0, 6))
    first_seen: int = 0

    @classmethod
    def of(cls, chain: Chain, name: str, config: Config) -> _Problem:
        return cls(symbolic.compile_index(chain, INDICES[name], "c"), config)

    def drawn(self, space: Space) -> Tensor:
        """Draw the configurations behind the range of an index."""
        return sampling.uniform(space, self.config.drawn, torch.Generator().manual_seed(self.config.seed))

    def extremes(self, space: Space) -> tuple[float, float]:
        values = self.f(self.drawn(space))
        return float(values.min()), float(values.max())

    def quantiles(self, space: Space, shares: NDArray[np.float64]) -> dict[str, NDArray[np.float64]]:
        """Values of the index by kind of draw."""
        random = torch.Generator().manual_seed(self.config.seed)
        draws = {
            "grid": sampling.on_grid(space, self.config.drawn, random),
            "uniform": self.drawn(space),
        }
        return {kind: np.quantile(self.f(q).numpy(), shares) for kind, q in draws.items()}

    def extension(self, half_width: float, space: Space, sizes: Sequence[int]) -> Extension:
        lowest, highest = self.extremes(space)
        rows, seeds = self.config.wide_rows, self.config.few_seeds
        return Extension(
            half_width, lowest, highest,
            math.prod(level for level in space.levels if level is not None),
            tuple(self.trained(space, neurons, rows, seeds) for neurons in sizes),
        )  # fmt: skip

    def trained(
        self, space: Space, neurons: int, rows: int, seeds: Sequence[int], method: Method = "grid"
    ) -> Trained:
        """Train a network for each seed, on rows of its own, and judge them all."""
        test, fresh_seed = self.config.test, self.config.seed + 1
        sets = [
            sampling.data_sets(
                self.f, space, train=rows, test=test, validation=test, seed=seed, method=method
            )
            for seed in seeds
        ]
        networks = self._networks(space, neurons, sets, seeds)
        fresh = sampling.uniform(space, self.config.fresh, torch.Generator().manual_seed(fresh_seed))
        exact = self.f(fresh)
        errors = [_errors(network, fresh, exact) for network in networks]
        return Trained(
            neurons, rows,
            test=tuple(_largest(n, own.test) for n, own in zip(networks, sets, strict=True)),
            between=tuple(_largest(n, own.validation) for n, own in zip(networks, sets, strict=True)),
            fresh=tuple(float(e.max()) for e in errors),
            most=tuple(float(e.quantile(0.99)) for e in errors),
        )  # fmt: skip

    def _networks(
        self, space: Space, neurons: int, sets: Sequence[DataSets], seeds: Sequence[int]
    ) -> list[FeedForward]:
        seen = [joint - 1 for joint in _varying(space) if joint > self.first_seen]
        view = View(space.joints, seen, self.carriers)
        q = torch.stack([own.train.q for own in sets])
        values = torch.stack([own.train.values for own in sets])
        randoms = [torch.Generator().manual_seed(seed) for seed in seeds]
        untrained = [
            FeedForward.untrained(view, neurons, x, y, random, self.readout)
            for x, y, random in zip(q, values, randoms, strict=True)
        ]
        options = Options(epochs=self.config.epochs)
        return [training.network for training in levenberg_marquardt(untrained, q, values, options)]


def _errors(network: FeedForward, q: Tensor, exact: Tensor) -> Tensor:
    """Relative errors, Eq. 21."""
    with torch.no_grad():
        return (network(q) / exact - 1).abs()


def _largest(network: FeedForward, data: DataSet) -> float:
    return float(_errors(network, data.q, data.values).max())


def _choice(chain: Chain, kci: _Problem, space: TaskSector) -> Choice:
    q = kci.drawn(space)
    lowest, highest = kci.extremes(space)
    sigma = torch.linalg.svdvals(chain.spatial_jacobian(q))
    task = q.new_tensor(space.task_point)
    distance = (_base(chain, q)[..., :3, 3] - task).norm(dim=-1)
    reached = reaching(chain, q, space.task_point)
    can = reached.isfinite().all(-1)
    miss = (chain.forward(reached[can])[..., :3, 3] - task).norm(dim=-1)
    config = kci.config
    return Choice(
        lowest, highest,
        kinks=float((sigma[..., 4] < 1.02 * sigma[..., 5]).double().mean()),
        nearest=float(distance.min()),
        farthest=float(distance.max()),
        reachable=float(can.double().mean()),
        reaching_error=float(miss.max()),
        trained=kci.trained(space, config.neurons[1], config.choice_rows, config.few_seeds),
    )  # fmt: skip


# ---- what is shown ---------------------------------------------------------------------------------


def input_table(result: Result) -> dict[str, dict[str, str]]:
    """List the inputs of each index as the paper has them and as the derivation finds them."""
    return {
        name: {"printed": _listed(_INPUTS[name]), "derived": _listed(result.inputs[name])} for name in INDICES
    }


def choice_table(result: Result) -> dict[str, dict[str, float | str]]:
    """KCI and its networks by choice; shares and errors in per cent."""
    return {
        name: {
            "KCI from": choice.lowest,
            "to": choice.highest,
            "error of a constant [%]": 100 * _constant_error(choice.lowest, choice.highest),
            "σ5 ≈ σ6 [%]": 100 * choice.kinks,
            "within reach [%]": 100 * choice.reachable,
            "largest error [%]": _percent(choice.trained.fresh),
            "99 % below [%]": _percent(choice.trained.most),
        }
        for name, choice in result.choices.items()
    }


def _constant_error(lowest: float, highest: float) -> float:
    """Largest relative error of the best constant for values in this range."""
    return (highest - lowest) / (highest + lowest)


def error_table(groups: Mapping[str, Sequence[Trained]]) -> list[dict[str, str | int]]:
    """Errors of networks, medians with the range over seeds in per cent, under the name of each group."""
    return [
        {
            "": name,
            "neurons": trained.neurons,
            "rows": trained.rows,
            "on the test set [%]": _percent(trained.test),
            "between its points [%]": _percent(trained.between),
            "on fresh ones [%]": _percent(trained.fresh),
            "99 % below [%]": _percent(trained.most),
        }
        for name, own in groups.items()
        for trained in own
    ]


def extension_table(extensions: Sequence[Extension], unit: str) -> list[dict[str, str | int]]:
    """Errors of the networks for spaces whose half width has this unit, with the range of the index there."""
    groups = {f"±{own.half_width:g}{unit}": own.trained for own in extensions}
    values = [f"{own.lowest:.3g}–{own.highest:.3g}" for own in extensions for _ in own.trained]
    rows = zip(error_table(groups), values, strict=True)
    return [{"": row[""], "values": told, **row} for row, told in rows]


# ---- verdicts --------------------------------------------------------------------------------------

_PAPER = "sotiropoulos2016"
_INPUTS = {"w": tuple(range(5, 12)), "KCI": tuple(range(1, 12))}
_SETTING = "Taken over as a setting; nothing can be tested. "


def verdicts(result: Result) -> tuple[Verdict, ...]:
    """Judge the claims of the ledger that this study answers for; see above for the thresholds."""
    return (*_on_data_sets(result), *_on_settings(result), _on_rows(result), *_on_extensions(result))


def _on_data_sets(result: Result) -> tuple[Verdict, ...]:
    derived = {name: result.inputs[name] == _INPUTS[name] for name in INDICES}
    return (
        Verdict(
            _PAPER, "data-set-kci", Outcome.of(derived["KCI"]), f"θ {_listed(result.inputs['KCI'])}", "",
            "Found from the derivation of the spatial KCI, which uses every joint but the last.",
        ),
        Verdict(
            _PAPER, "data-set-w", Outcome.of(derived["w"]), f"θ {_listed(result.inputs['w'])}", "",
            "Found from the derivation of w, for unit limits; with unequal limits of the translations "
            "θ4 would be among them.",
        ),
    )  # fmt: skip


def _on_settings(result: Result) -> tuple[Verdict, ...]:
    settings = {
        "inner-radius": "The link lengths are not printed and were inferred from it.",
        "outer-radius": "The link lengths are not printed and were inferred from it.",
        "sampling-angle": "Read as the whole angle; half of it is among the choices that are varied.",
        "joint-range": "Wider ranges are tried under another claim.",
        "joint-step": "The errors between the points of the grid stand beside those on it.",
        "test-set-size": _on_test_sets(result),
    }
    assumed, turned = result.choices[ASSUMED], result.choices[TURNED]
    return (
        *(
            Verdict(_PAPER, claim, Outcome.OUT_OF_SCOPE, "", "", _SETTING + why)
            for claim, why in settings.items()
        ),
        Verdict(
            _PAPER, "search-area-keeps-task-reachable", Outcome.of(turned.reachable == 1),
            f"{100 * turned.reachable:.0f} % of the configurations",
            f"wrist off by {turned.reaching_error:.0e} m",
            "If the base of the turned vehicle is in the area, the arm can always be bent to the task point. "
            "If the area is applied before the vehicle turns, as assumed, the base is "
            f"{assumed.nearest:.2g} to {assumed.farthest:.3g} m away and "
            f"{100 * assumed.reachable:.0f} % reach.",
        ),
    )  # fmt: skip


def _on_test_sets(result: Result) -> str:
    largest = result.by_method["grid"][-1]
    return (
        f"For w its largest error is {_percent(largest.test)} %, that on fresh configurations "
        f"{_percent(largest.fresh)} %."
    )


def _on_rows(result: Result) -> Verdict:
    w, kci = _rows_needed(result.by_method["grid"]), _rows_needed(result.kci_by_rows)
    return Verdict(
        _PAPER, "kci-needs-more-data",
        _by_threshold(kci / w, 2, math.nextafter(1, 2)), f"{kci} rows against {w}",
        f"of {_listed([own.rows for own in result.kci_by_rows])} tried for KCI",
        "The sizes are not printed, so the rows are those that either network needs for an error within a "
        "quarter of what the most rows give.",
    )  # fmt: skip


def _rows_needed(trained: Sequence[Trained]) -> int:
    best = _median(trained[-1].fresh)
    return min(own.rows for own in trained if _median(own.fresh) <= 1.25 * best)


def _on_extensions(result: Result) -> tuple[Verdict, Verdict]:
    limit = _limit()
    widest = {n: _widest(result.ranges, n, limit) for n in _sizes(result.ranges)}
    last = result.ranges[-1]
    printed, better = result.places[AS_PRINTED], result.places[FROM_VEHICLE]
    place = better[-1]
    w_holds = _median(result.by_method["grid"][-1].fresh) <= limit
    kci_holds = (
        max(_widest(own, n, limit) for own in (printed, better) for n in _sizes(own)) >= place.half_width
    )
    return (
        Verdict(
            _PAPER, "whole-space-possible", _by_threshold(max(widest.values()), 180, 90),
            "; ".join(f"{n} neurons: {f'±{deg:g}°' if deg else 'none'}" for n, deg in widest.items()),
            _seeds(last.trained[-1]),
            f"Widest range at which the largest error for w stays within {100 * limit:g} %. For "
            f"±{last.half_width:g}° it is {_percent(last.trained[-1].fresh)} % with "
            f"{last.trained[-1].neurons} neurons, and the whole grid would have {last.grid_rows:.0e} rows.",
        ),
        Verdict(
            _PAPER, "any-task-point", _by_threshold(w_holds + kci_holds, 2, 1),
            f"KCI: {_percent(printed[-1].trained[-1].fresh)} %; {_percent(place.trained[-1].fresh)} %",
            _seeds(place.trained[-1]),
            "True for w, which does not depend on the task point, so that nothing need be extended. For KCI "
            f"the vehicle was let anywhere within ±{place.half_width:g} m: largest errors of "
            f"{printed[-1].trained[-1].neurons} neurons as printed, and of {place.trained[-1].neurons} that "
            "see the world's origin from the vehicle and answer with a cone.",
        ),
    )  # fmt: skip


def _by_threshold(value: float, reproduced: float, in_shape: float) -> Outcome:
    if value >= reproduced:
        return Outcome.REPRODUCED
    return Outcome.IN_SHAPE if value >= in_shape else Outcome.NOT_REPRODUCED


def _sizes(extensions: Sequence[Extension]) -> tuple[int, ...]:
    return tuple(trained.neurons for trained in extensions[0].trained)


def _widest(extensions: Sequence[Extension], neurons: int, limit: float) -> float:
    """Greatest half width at which networks of this size stay within the limit; 0 if at none."""
    return max(
        own.half_width if trained.neurons == neurons and _median(trained.fresh) <= limit else 0.0
        for own in extensions
        for trained in own.trained
    )


def _limit() -> float:
    """Read E, the same for both indices."""
    return float(np.min(load_paper(_PAPER).claim("feed-forward-testing-error-limit").value or math.nan))


def _seeds(trained: Trained) -> str:
    return f"{len(trained.fresh)} seeds" if len(trained.fresh) > 1 else "1 seed"


def _median(values: Sequence[float]) -> float:
    return float(np.median(values))


def _percent(errors: Sequence[float]) -> str:
    """Median of errors in per cent, with their range."""
    return with_range(100 * np.asarray(errors), _short)


def _short(number: float) -> str:
    """Write two digits that count, never with an exponent."""
    return f"{float(f'{number:.2g}'):g}"


def _listed(numbers: Sequence[int]) -> str:
    return ", ".join(map(str, numbers))


def acceptance(result: Result) -> tuple[Acceptance, ...]:
    """Figures that must hold for the book to be built."""
    turned = result.choices[TURNED]
    return (
        Acceptance("share that cannot reach with the turned base in the area", 1 - turned.reachable, 0.0),
        Acceptance(
            "wrist off the task point [m]",
            max(choice.reaching_error for choice in result.choices.values()),
            1e-7,
        ),
    )
