"""Sets of configurations, and data sets drawn from them.

A space is a set of configurations that the unit cube parametrises smoothly: points of the cube are drawn,
or climbed in by a search, and mapped to joint values. Joints that do not vary take no coordinate of the
cube. A coordinate may have a grid, as the papers sample; draws between the points of the grid judge what
was learned on it.

References
----------
Sotiropoulos & Aspragathos (2016), sections 3.1 and 4.2; its assumptions on sampling in
``data/papers/sotiropoulos2016/assumptions.toml``.

Examples
--------
>>> import dexterity as dx
>>> uvms, space = dx.robots.uvms(), dx.sampling.uvms_space("manipulability")
>>> w = dx.indices.Index("manipulability").bind(uvms)
>>> data = dx.sampling.data_sets(w, space, train=100, test=20, validation=20)
>>> data.train.q.shape, bool(space.contains(data.test.q).all())
(torch.Size([100, 12]), True)
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Literal, Protocol, TypeAlias, get_args, runtime_checkable

import numpy as np
import torch
from jaxtyping import Bool, Float64, Int64
from torch import Tensor

from dexterity import checks, robots, spatial
from dexterity import sobol as sobol_points
from dexterity.chain import Chain
from dexterity.derivation import derive
from dexterity.indices import Index, require_not_zero_everywhere
from dexterity.spatial import TensorLike
from dexterity.spatial.values import on_cpu

__all__ = [
    "Box",
    "DataSet",
    "DataSets",
    "Method",
    "Space",
    "TaskSector",
    "data_sets",
    "grid",
    "grid_size",
    "on_grid",
    "relevant_joints",
    "sobol",
    "uniform",
    "uvms_space",
]

Method: TypeAlias = Literal["grid", "sobol", "uniform"]
"""How training sets are drawn, on the grid, from a scrambled Sobol sequence, or uniformly."""


@runtime_checkable
class Space(Protocol):
    """A set of configurations of n joints that the unit cube of m coordinates parametrises."""

    @property
    def joints(self) -> int:
        """Number of joints n."""

    @property
    def dimensions(self) -> int:
        """Number of coordinates m of the unit cube, those that vary."""

    @property
    def levels(self) -> tuple[int | None, ...]:
        """Number of grid values of each of the m coordinates, None where it has no grid."""

    def from_unit(self, u: TensorLike) -> Float64[Tensor, "*batch n"]:
        """Map points of the unit cube to configurations; differentiable.

        Parameters
        ----------
        u
            (..., m) coordinates from 0 to 1.

        Returns
        -------
        (..., n) joint values, [rad] or [m].

        Raises
        ------
        ValueError
            If the last axis of `u` is not m, or `u` is not finite or leaves the cube by more than 1e-9,
            which rounding may; nothing is clipped.
        """

    def to_unit(self, q: TensorLike) -> Float64[Tensor, "*batch m"]:
        """Return the coordinates of configurations: the inverse of :meth:`from_unit` inside the space.

        Parameters
        ----------
        q
            (..., n) joint values, [rad] or [m].

        Returns
        -------
        (..., m) coordinates, some below 0 or above 1 for a configuration outside. Joints that do not vary
        leave no trace in them.

        Raises
        ------
        ValueError
            If the last axis of `q` is not n, or `q` is not finite.
        """

    def contains(self, q: TensorLike) -> Bool[Tensor, "*batch"]:
        """Tell which configurations lie inside, joints that do not vary at their values.

        Limits belong to the space, and so does what rounding puts outside: up to 1e-9 of a coordinate's
        range, and 1e-9 rad or m of a joint that does not vary.

        Parameters
        ----------
        q
            (..., n) joint values, [rad] or [m].

        Raises
        ------
        ValueError
            If the last axis of `q` is not n, or `q` is not finite.
        """


_DEGREES_20 = math.radians(20)


@dataclass(frozen=True, init=False)
class Box:
    """Configurations between limits, each joint by itself.

    Parameters
    ----------
    lower, upper
        (n,) limits, [rad] or [m]; equal ones hold a joint.
    levels
        Number of grid values from the lower to the upper limit, at least 2, or None for no grid: one for
        all joints that vary, or one for each of them.

    Raises
    ------
    ValueError
        If the limits are not two finite vectors of one length, a lower one exceeds its upper one, or the
        levels do not fit.
    """

    lower: tuple[float, ...]
    upper: tuple[float, ...]
    levels: tuple[int | None, ...]

    def __init__(
        self, lower: TensorLike, upper: TensorLike, levels: int | Sequence[int | None] | None = None
    ) -> None:
        low, high = _vector(lower, "lower"), _vector(upper, "upper")
        if len(low) != len(high):
            raise ValueError(f"lower has {len(low)} joints and upper {len(high)}; as many are needed")
        for i, (a, b) in enumerate(zip(low, high, strict=True)):
            if a > b:
                raise ValueError(f"lower exceeds upper at joint {i + 1}: {a} > {b}")
        object.__setattr__(self, "lower", low)
        object.__setattr__(self, "upper", high)
        object.__setattr__(self, "levels", _levels(levels, self.dimensions))

    @classmethod
    @checks.arguments(chain=checks.Instance(Chain))
    def from_chain(cls, chain: Chain, levels: int | Sequence[int | None] | None = None) -> Box:
        """Take the joint limits of a chain.

        Raises
        ------
        ValueError
            If a joint is unlimited, or the levels do not fit.
        """
        unlimited = ~(torch.isfinite(chain.lower) & torch.isfinite(chain.upper))
        if unlimited.any():
            names = [name for name, free in zip(chain.joint_names, unlimited, strict=True) if free]
            raise ValueError(f"chain has unlimited joints: {', '.join(names)}; a box needs limits, give them")
        return cls(chain.lower, chain.upper, levels)

    @classmethod
    def around(
        cls,
        chain: Chain,
        q: TensorLike | None = None,
        half_range: TensorLike = _DEGREES_20,
        joints: Sequence[int] | None = None,
    ) -> Box:
        """Take a part of a chain's joint limits, about a configuration.

        Parameters
        ----------
        chain
            The robot.
        q
            (n,) configuration in the middle, [rad] or [m]; by default the middle of the limits, 0 where a
            joint has none.
        half_range
            How far joints go to either side, [rad] or [m]: one number, or one for each joint; 20° by default.
            The box ends at the joint limits.
        joints
            Joints that vary, from 0; all by default. The others are held at `q`.

        Raises
        ------
        ValueError
            If `q` is outside the limits, `half_range` is not positive, or a number does not fit the chain.
        """
        checks.instance(chain, "chain", Chain)
        middle = _middle_of_limits(chain) if q is None else on_cpu(q, "q").detach()
        if middle.shape != (chain.joints,):
            raise ValueError(f"q has shape {tuple(middle.shape)}; ({chain.joints},) is needed")
        outside = (middle < chain.lower - _ROUNDING) | (middle > chain.upper + _ROUNDING)
        if outside.any():
            names = [name for name, is_out in zip(chain.joint_names, outside, strict=True) if is_out]
            raise ValueError(f"q is outside the limits of the chain at {', '.join(names)}")
        reach = on_cpu(half_range, "half_range").detach()
        if reach.shape not in ((), (chain.joints,)) or not (reach > 0).all():
            raise ValueError(f"half_range is {half_range}; a positive number, or one a joint, is needed")
        varies = torch.full((chain.joints,), joints is None)
        if joints is not None:
            varies[list(checks.Each(checks.Whole(0, chain.joints - 1))(joints, "joints"))] = True
        reach = torch.where(varies, reach, 0.0)
        middle = middle.clamp(chain.lower, chain.upper)
        return cls(torch.maximum(middle - reach, chain.lower), torch.minimum(middle + reach, chain.upper))

    @property
    def joints(self) -> int:
        """Number of joints n."""
        return len(self.lower)

    @property
    def dimensions(self) -> int:
        """Number of joints m that vary."""
        return len(self.free_joints)

    @cached_property
    def free_joints(self) -> tuple[int, ...]:
        """Joints that vary, counted from 0; the coordinates of the unit cube in this order."""
        return tuple(i for i, (a, b) in enumerate(zip(self.lower, self.upper, strict=True)) if a < b)

    def from_unit(self, u: TensorLike) -> Float64[Tensor, "*batch n"]:
        """Map points of the unit cube to configurations; see :meth:`Space.from_unit`."""
        u = _in_cube(u, self.dimensions)
        share = u @ self._placement(u.device)
        return torch.lerp(share.new_tensor(self.lower), share.new_tensor(self.upper), share)

    def to_unit(self, q: TensorLike) -> Float64[Tensor, "*batch m"]:
        """Return the coordinates of configurations; see :meth:`Space.to_unit`."""
        q = spatial.require_joints(spatial.to_float64(q, "q"), self.joints, "space")
        placement = self._placement(q.device)
        lower, upper = (placement @ q.new_tensor(limits) for limits in (self.lower, self.upper))
        return (q @ placement.mT - lower) / (upper - lower)

    def contains(self, q: TensorLike) -> Bool[Tensor, "*batch"]:
        """Tell which configurations lie inside; see :meth:`Space.contains`."""
        q = spatial.require_joints(spatial.to_float64(q, "q"), self.joints, "space")
        is_held = q.new_tensor(self.lower) == q.new_tensor(self.upper)
        is_displaced = is_held & ((q - q.new_tensor(self.lower)).abs() > _ROUNDING)
        return ~(is_displaced.any(-1) | _leaves_cube(self.to_unit(q)).any(-1))

    def _placement(self, device: torch.device) -> Tensor:
        """Give each coordinate (row) its joint (column); a product with it only moves numbers."""
        return torch.eye(self.joints, dtype=torch.float64, device=device)[list(self.free_joints)]


@dataclass(frozen=True)
class TaskSector:
    r"""Configurations of an arm on a free vehicle with the arm's base near a task point, paper A's Fig. 7.

    The base lies at a distance r from the task point t, in a direction that is −y turned by the azimuth α
    about z and by the elevation ε out of the x–y plane:
    :math:`t - r (\sin α \cos ε, \cos α \cos ε, \sin ε)`. The vehicle's translations follow from it. The
    coordinates of the unit cube are r, α, ε without a grid (an angle only if it varies), then the further
    joints.

    Parameters
    ----------
    task_point
        In the world frame [m].
    base_offset
        From the vehicle's origin to the arm's base, in the vehicle frame [m].
    r_min, r_max
        Least and greatest distance of the base from the task point [m].
    azimuth, elevation
        Greatest angles to either side [rad], at most π, and below π/2.
    rest
        The joints behind the three translations.
    turned
        Whether the offset turns with the vehicle, whose angles are then the first three joints of `rest`:
        about its own x, then y, then z axis. If not, the base of the unturned vehicle is where the
        direction says.

    Raises
    ------
    ValueError
        If a number is not finite, not 0 < r_min < r_max, an angle is out of range, or `rest` has no joints
        that turn the offset.

    References
    ----------
    Sotiropoulos & Aspragathos (2016), section 4.2 and Fig. 7, which leaves open what the assumptions
    ``sector-of-the-base`` and ``base-position-without-rotation`` say.
    """

    task_point: tuple[float, float, float]
    base_offset: tuple[float, float, float]
    r_min: float
    r_max: float
    azimuth: float
    elevation: float
    rest: Box
    turned: bool = False

    def __post_init__(self) -> None:
        checks.fields(self, rest=checks.Instance(Box), turned=checks.Flag())
        for name in ("task_point", "base_offset"):
            vector = _vector(getattr(self, name), name)
            if len(vector) != 3:
                raise ValueError(f"{name} has {len(vector)} numbers; 3 are needed")
            object.__setattr__(self, name, vector)
        for name in ("r_min", "r_max", "azimuth", "elevation"):
            object.__setattr__(self, name, _number(getattr(self, name), name))
        if not 0 < self.r_min < self.r_max:
            raise ValueError(f"r_min is {self.r_min} and r_max {self.r_max}; 0 < r_min < r_max is needed")
        if not 0 <= self.azimuth <= math.pi:
            raise ValueError(f"azimuth is {self.azimuth}; 0 ≤ azimuth ≤ π is needed")
        if not 0 <= self.elevation < math.pi / 2:
            raise ValueError(f"elevation is {self.elevation}; 0 ≤ elevation < π/2 is needed")
        if self.turned and self.rest.joints < 3:
            raise ValueError(f"rest has {self.rest.joints} joints; 3 are needed to turn the offset")

    @property
    def joints(self) -> int:
        """Number of joints n, three translations and the rest."""
        return 3 + self.rest.joints

    @property
    def dimensions(self) -> int:
        """Number of coordinates m."""
        return self._coordinates.dimensions

    @property
    def levels(self) -> tuple[int | None, ...]:
        """Number of grid values of each coordinate; distance and angles have none."""
        return self._coordinates.levels

    def from_unit(self, u: TensorLike) -> Float64[Tensor, "*batch n"]:
        """Map points of the unit cube to configurations; see :meth:`Space.from_unit`."""
        coordinates = self._coordinates.from_unit(u)
        r, azimuth, elevation = coordinates[..., :3].unbind(-1)
        rest = coordinates[..., 3:]
        ahead = r * elevation.cos()
        to_task = torch.stack([ahead * azimuth.sin(), ahead * azimuth.cos(), r * elevation.sin()], -1)
        base = coordinates.new_tensor(self.task_point) - to_task
        return torch.cat([base - self._offset(rest), rest], -1)

    def to_unit(self, q: TensorLike) -> Float64[Tensor, "*batch m"]:
        """Return the coordinates of configurations; see :meth:`Space.to_unit`."""
        return self._coordinates.to_unit(self._to_coordinates(q))

    def contains(self, q: TensorLike) -> Bool[Tensor, "*batch"]:
        """Tell which configurations lie inside; see :meth:`Space.contains`."""
        return self._coordinates.contains(self._to_coordinates(q))

    @cached_property
    def _coordinates(self) -> Box:
        """Box of distance, azimuth, elevation and the rest."""
        lower = (self.r_min, -self.azimuth, -self.elevation)
        upper = (self.r_max, self.azimuth, self.elevation)
        continuous = sum(a < b for a, b in zip(lower, upper, strict=True))
        levels = (None,) * continuous + self.rest.levels
        return Box(lower + self.rest.lower, upper + self.rest.upper, levels)

    def _to_coordinates(self, q: TensorLike) -> Tensor:
        q = spatial.require_joints(spatial.to_float64(q, "q"), self.joints, "space")
        rest = q[..., 3:]
        to_task = q.new_tensor(self.task_point) - (q[..., :3] + self._offset(rest))
        x, y, z = to_task.unbind(-1)
        polar = [
            torch.linalg.vector_norm(to_task, dim=-1),
            torch.atan2(x, y),
            torch.atan2(z, torch.hypot(x, y)),
        ]
        return torch.cat([torch.stack(polar, -1), rest], -1)

    def _offset(self, rest: Tensor) -> Tensor:
        offset = rest.new_tensor(self.base_offset)
        if not self.turned:
            return offset
        x, y, z = offset.unbind(-1)
        about_x, about_y, about_z = rest[..., :3].unbind(-1)
        x, y = _turn(x, y, about_z)
        z, x = _turn(z, x, about_y)
        y, z = _turn(y, z, about_x)
        return torch.stack([x, y, z], -1)


@checks.arguments(index_name=checks.Instance(str), turned=checks.Flag())
def uvms_space(
    index_name: str,
    half_range_deg: float = 15.0,
    step_deg: float = 5.0,
    task_point: tuple[float, float, float] = (0.0, 1.35, 0.0),
    turned: bool = False,
) -> Box | TaskSector:
    """Space that paper A samples for an index of its underwater vehicle-manipulator system.

    Joints that the index does not depend on are held at zero. Where it depends on the vehicle's
    translations they keep the arm's base in a sector about the task point, between the radii of the arm's
    workspace and within 15° to either side.

    Parameters
    ----------
    index_name
        ``"manipulability"`` (θ5 … θ11) or ``"kinematic_conditioning"`` (sector and θ4 … θ11).
    half_range_deg, step_deg
        Greatest angle of each revolute joint to either side, and the step of its grid.
    task_point
        In the world frame [m].
    turned
        Whether the sector holds the base of the turned vehicle; see :class:`TaskSector`.

    Raises
    ------
    ValueError
        If the index is unknown, an angle is not positive, or the steps do not fill the range.

    References
    ----------
    Sotiropoulos & Aspragathos (2016), Eqs. 11 and 12, section 4.2, Fig. 7.
    """
    levels = _levels_of_steps(half_range_deg, step_deg)
    _vector(task_point, "task_point")  # a box has none, and yet it is given
    chain = robots.uvms()
    varying = relevant_joints(chain, Index(index_name))
    upper = [math.radians(half_range_deg) if i in varying else 0.0 for i in range(3, chain.joints)]
    rest = Box([-x for x in upper], upper, levels)
    if not set(varying) & {0, 1, 2}:
        return Box((0.0,) * 3 + rest.lower, (0.0,) * 3 + rest.upper, rest.levels)
    length = robots.describe("uvms").lengths
    return TaskSector(
        task_point=task_point,
        base_offset=(0.0, length["y_MB"], length["l1"]),
        r_min=abs(length["l2"] - length["l3"]),
        r_max=length["l2"] + length["l3"],
        azimuth=math.radians(15),
        elevation=math.radians(15),
        rest=rest,
        turned=turned,
    )


def relevant_joints(chain: Chain, index: Index) -> tuple[int, ...]:
    """Joints that an index depends on, counted from 0: the inputs of paper A's Eqs. 11 and 12.

    They are found by deriving the index; see ``matters`` of :class:`dexterity.symbolic.Derivation`. Where
    it cannot be derived, they are the joints along which it changes at one of many configurations.

    Raises
    ------
    ValueError
        If the rates of the index do not fit the chain, or the index is zero everywhere.
    """
    checks.instance(chain, "chain", Chain)
    checks.instance(index, "index", Index)
    require_not_zero_everywhere(index, chain)
    try:
        return tuple(joint - 1 for joint in derive(chain, index).matters)
    except ValueError:
        slopes = _slopes(index.bind(chain), chain)
        return tuple((slopes > 1e-9 * slopes.max()).nonzero().flatten().tolist())


def _slopes(function: Callable[[Tensor], Tensor], chain: Chain) -> Tensor:
    """Largest absolute derivative along each joint (n) at points within the limits."""
    lower, upper = (limits.clamp(-math.pi, math.pi) for limits in (chain.lower, chain.upper))
    u = torch.rand(64, chain.joints, generator=torch.Generator().manual_seed(0), dtype=torch.float64)
    _, gradients = spatial.value_and_gradient(function, torch.lerp(lower, upper, u))
    return gradients.nan_to_num(nan=0.0, posinf=0.0, neginf=0.0).abs().amax(0)


# ---- draws -------------------------------------------------------------------------------------------


def uniform(space: Space, count: int, random: torch.Generator) -> Float64[Tensor, "count n"]:
    """Draw configurations uniformly in the unit cube, between the points of a grid.

    Raises
    ------
    ValueError
        If `count` is not positive, or nothing varies in the space.
    """
    count = _require_draw(space, count)
    checks.instance(random, "random", torch.Generator)
    return space.from_unit(torch.rand(count, space.dimensions, generator=random, dtype=torch.float64))


def sobol(space: Space, count: int, seed: int, overhang: float = 0.0) -> Float64[Tensor, "count n"]:
    """Draw the first configurations of a scrambled Sobol sequence in the unit cube.

    They fill it more evenly than independent draws; `count` had best be a power of two.

    Parameters
    ----------
    space
        Where to draw.
    count
        Number of configurations.
    seed
        Scrambles the sequence.
    overhang
        How much wider than the unit cube the cube is that the sequence fills. What lies outside is moved onto
        the nearest face, so that each coordinate is at one of its bounds with probability
        overhang/(1 + overhang): edges and corners, which draws inside hardly ever come near when there are
        many coordinates, are drawn too.

    Raises
    ------
    ValueError
        If `count` is not positive, `overhang` is negative or not finite, nothing varies in the space, or more
        than 21 201 coordinates do.

    References
    ----------
    Owen (1998), Scrambling Sobol' and Niederreiter–Xing points.
    """
    count = _require_draw(space, count)
    return _sobol(space, count, checks.whole(seed, "seed"), checks.real(overhang, "overhang", least=0))


def _sobol(space: Space, count: int, seed: int, overhang: float = 0.0) -> Tensor:
    u = sobol_points.points(space.dimensions, count, seed)
    return space.from_unit((u + overhang * (u - 0.5)).clamp(0, 1))


def on_grid(space: Space, count: int, random: torch.Generator) -> Float64[Tensor, "count n"]:
    """Draw configurations on the grid, in random order.

    No row of the grid is drawn twice. Where some coordinates have no grid they are drawn uniformly, and
    the others independently among their grid values.

    Raises
    ------
    ValueError
        If `count` is not positive, no coordinate has a grid, or the grid has fewer rows (or 2⁶³ or more).
    """
    checks.instance(random, "random", torch.Generator)
    return _from_grid(space, count, random)[0]


def grid_size(space: Space) -> int:
    """Return the number of rows of the whole grid.

    Raises
    ------
    ValueError
        If a coordinate has no grid.
    """
    return math.prod(_grid_levels(space))


def grid(space: Space, start: int = 0, stop: int | None = None) -> Float64[Tensor, "rows n"]:
    """Return the whole grid, or its rows from `start` up to but without `stop`; the last joint runs fastest.

    Raises
    ------
    ValueError
        If a coordinate has no grid, or not 0 ≤ start ≤ stop ≤ its number of rows.
    """
    size = grid_size(space)
    start, stop = checks.whole(start, "start"), size if stop is None else checks.whole(stop, "stop")
    if not 0 <= start <= stop <= size:
        raise ValueError(f"start is {start} and stop {stop}; 0 ≤ start ≤ stop ≤ {size} is needed")
    if stop - start > _MOST_ROWS or stop > 2**63 - 1:
        raise ValueError(
            f"stop is {stop} and start {start}; a call makes {_MOST_ROWS} rows at most, of those below 2⁶³"
        )
    return _grid_rows(space, torch.arange(start, stop))


# ---- data sets ---------------------------------------------------------------------------------------


@dataclass(frozen=True)
class DataSet:
    """Configurations with the values of an index.

    Attributes
    ----------
    q
        (N, n) joint values, [rad] or [m]; all joints, whether they vary or not.
    values
        (N,) values of the index.

    Both are copies of what was given.

    Raises
    ------
    ValueError, TypeError
        If a shape does not fit, or something is no finite number.
    """

    q: Float64[Tensor, "N n"]
    values: Float64[Tensor, " N"]

    def __post_init__(self) -> None:
        for name, axes, shape in (("q", 2, "(N, n)"), ("values", 1, "(N,)")):
            given = spatial.to_float64(getattr(self, name), name).detach().clone()
            if given.ndim != axes:
                raise ValueError(f"{name} has shape {tuple(given.shape)}; {shape} is needed")
            object.__setattr__(self, name, given)
        if len(self.q) != len(self.values):
            raise ValueError(f"values holds {len(self.values)} numbers; q has {len(self.q)} rows")

    @classmethod
    @checks.arguments(f=checks.function, q=checks.Instance(Tensor), name=checks.name)
    def of(cls, f: Callable[[Tensor], Tensor], q: Float64[Tensor, "N n"], name: str = "f") -> DataSet:
        """Evaluate a function at configurations.

        Parameters
        ----------
        f
            Takes the configurations and answers with their values.
        q
            (N, n) joint values, [rad] or [m].
        name
            What the caller calls the function; used in the error.

        Raises
        ------
        ValueError
            If it does not answer with one finite value a configuration.
        """
        with torch.no_grad():
            values = spatial.to_float64(f(q), f"{name}(q)")
        if values.shape != q.shape[:1]:
            raise ValueError(
                f"{name}(q) has shape {tuple(values.shape)}; ({len(q)},) is needed, a value for each q"
            )
        return cls(q, values)


@dataclass(frozen=True)
class DataSets:
    """Data sets that were drawn apart; no configuration occurs twice in them.

    Attributes
    ----------
    train
        What a network learns from.
    test
        What a design loop looks at to stop or to go on, drawn as the training set is. It cannot judge the
        network that the loop chose by it.
    validation
        Drawn uniformly, between the points of a grid.
    """

    train: DataSet
    test: DataSet
    validation: DataSet


def data_sets(
    f: Callable[[Tensor], Tensor],
    space: Space,
    *,
    train: int = 5000,
    test: int = 1000,
    validation: int = 1000,
    seed: int = 0,
    method: Method = "grid",
) -> DataSets:
    """Draw data sets, each from a generator of its own; a set does not depend on the sizes of later ones.

    The order is test, training, validation: the test set stays the same while the training set grows.

    Parameters
    ----------
    f
        The index as a function of joint values, (N, n) → (N).
    space
        Where to draw.
    train, test, validation
        Numbers of configurations.
    seed
        Not negative. The same seed gives the same sets.
    method
        How to draw the training and the test set. ``"grid"`` as paper A; ``"sobol"`` takes two differently
        scrambled sequences.

    Raises
    ------
    ValueError
        If a number is not positive, the method is unknown, the grid has too few rows or the space too few
        configurations for sets without a common one, or what `f` returns is not finite or not (N).
    """
    checks.function(f, "f")
    checks.choice(method, "method", get_args(Method))
    train, test, validation = (
        checks.whole(number, name, least=1)
        for name, number in {"train": train, "test": test, "validation": validation}.items()
    )
    seed = checks.whole(seed, "seed", least=0)
    seeds = [int(state) for state in np.random.SeedSequence(seed).generate_state(3, np.uint64)]
    first, second, third = (torch.Generator().manual_seed(s) for s in seeds)
    if method == "grid":
        test_q, taken = _from_grid(space, test, first)
        train_q, _ = _from_grid(space, train, second, taken)
    elif method == "sobol":
        _require_draw(space, test)
        test_q, train_q = _sobol(space, test, seeds[0]), _sobol(space, train, seeds[1])
    else:
        test_q, train_q = uniform(space, test, first), uniform(space, train, second)
    validation_q = uniform(space, validation, third)

    rows = torch.cat([train_q, test_q, validation_q])
    different = len(rows.unique(dim=0))
    if different < len(rows):
        raise ValueError(
            f"space gave only {different} different configurations in {len(rows)}; it is too small"
        )
    return DataSets(*(DataSet.of(f, q) for q in (train_q, test_q, validation_q)))


# ---- private -----------------------------------------------------------------------------------------

_ROUNDING = 1e-9
_MOST_ROWS = 10**9
"""Configurations that are made in one call; their joint values need tens of gigabytes."""


def _vector(values: TensorLike, name: str) -> tuple[float, ...]:
    vector = on_cpu(values, name)
    if vector.ndim != 1 or len(vector) == 0:
        raise ValueError(f"{name} has shape {tuple(vector.shape)}; a vector is needed")
    # Plus zero, because -0.0 equals 0.0 and yet has another content key.
    return tuple((vector + 0.0).tolist())


def _middle_of_limits(chain: Chain) -> Tensor:
    """Middle (n) of the limits; without limits 0, or the limit that is nearest to it."""
    middle = (chain.lower + chain.upper) / 2
    nearest_to_zero = torch.zeros_like(middle).clamp(chain.lower, chain.upper)
    return torch.where(torch.isfinite(middle), middle, nearest_to_zero)


def _number(value: float, name: str) -> float:
    return checks.real(value, name) + 0.0


def _levels(levels: int | Sequence[int | None] | None, dimensions: int) -> tuple[int | None, ...]:
    if isinstance(levels, str | bytes):
        raise TypeError(f"levels is {levels!r}; a whole number, None, or one for each joint is needed")
    if isinstance(levels, np.ndarray) and levels.ndim > 0:
        levels = levels.tolist()
    each = tuple(levels) if isinstance(levels, Sequence) else (levels,) * dimensions
    if len(each) != dimensions:
        raise ValueError(f"levels has {len(each)} entries; one for each of the {dimensions} joints that vary")
    return tuple(checks.OrNone(checks.Whole(2))(level, "levels") for level in each)


def _levels_of_steps(half_range_deg: float, step_deg: float) -> int:
    half_range_deg = checks.positive(half_range_deg, "half_range_deg")
    step_deg = checks.positive(step_deg, "step_deg")
    steps = 2 * half_range_deg / step_deg
    if not steps < 2**53:
        raise ValueError(f"half_range_deg is {half_range_deg:g} and step_deg {step_deg:g}: too many steps")
    if round(steps) < 1 or abs(steps - round(steps)) > 1e-9 * steps:
        raise ValueError(f"step_deg is {step_deg}; steps that fill {2 * half_range_deg}° are needed")
    return round(steps) + 1


def _in_cube(u: TensorLike, dimensions: int) -> Tensor:
    u = spatial.to_float64(u, "u")
    if u.ndim == 0 or u.shape[-1] != dimensions:
        raise ValueError(
            f"u has shape {tuple(u.shape)}; the space has {dimensions} coordinates: (..., {dimensions})"
        )
    if spatial.are_readable(u) and _leaves_cube(u).any():
        raise ValueError(f"u goes from {u.min().item()} to {u.max().item()}; 0 to 1 is needed")
    return u


def _leaves_cube(u: Tensor) -> Tensor:
    return (u < -_ROUNDING) | (u > 1 + _ROUNDING)


def _turn(a: Tensor, b: Tensor, angle: Tensor) -> tuple[Tensor, Tensor]:
    cos, sin = angle.cos(), angle.sin()
    return a * cos - b * sin, a * sin + b * cos


def _require_draw(space: Space, count: int) -> int:
    """Return the number of configurations as an int."""
    checks.Instance(Space)(space, "space")
    count = checks.whole(count, "count", least=1, most=_MOST_ROWS)
    if space.dimensions == 0:
        raise ValueError("space is a single configuration; at least one joint must vary")
    return count


def _grid_levels(space: Space) -> tuple[int, ...]:
    checks.Instance(Space)(space, "space")
    levels = tuple(level for level in space.levels if level is not None)
    if len(levels) < space.dimensions:
        without = space.dimensions - len(levels)
        raise ValueError(f"space has {without} coordinates without a grid; levels are needed for all")
    return levels


def _grid_rows(space: Space, rows: Int64[Tensor, " N"]) -> Tensor:
    cube = torch.zeros(len(rows), space.dimensions, dtype=torch.float64)
    for i, level in reversed(list(enumerate(_grid_levels(space)))):
        cube[:, i] = _share(rows % level, level)
        rows = rows // level
    return space.from_unit(cube)


def _from_grid(
    space: Space, count: int, random: torch.Generator, taken: Tensor | None = None
) -> tuple[Tensor, Tensor | None]:
    """Draw configurations on the grid, none of the rows taken; return their rows too if the grid has rows."""
    count = _require_draw(space, count)
    if set(space.levels) == {None}:
        raise ValueError("space has no grid: no coordinate has levels")
    if None in space.levels:
        shares = [_one_coordinate(level, count, random) for level in space.levels]
        return space.from_unit(torch.stack(shares, -1)), None
    left_out = torch.zeros(0, dtype=torch.int64) if taken is None else taken.sort().values
    left = grid_size(space) - len(left_out)
    if not count <= left < 2**63:
        raise ValueError(f"count is {count}; the grid has {left} rows for it, and must have fewer than 2⁶³")
    draw = np.random.default_rng(int(torch.randint(2**63 - 1, (1,), generator=random)))
    rank = torch.from_numpy(draw.choice(left, count, replace=False))
    # From the rank among the rows that are left to the number of the row.
    rows = rank + torch.searchsorted(left_out - torch.arange(len(left_out)), rank, right=True)
    return _grid_rows(space, rows), rows


def _one_coordinate(level: int | None, count: int, random: torch.Generator) -> Tensor:
    if level is None:
        return torch.rand(count, generator=random, dtype=torch.float64)
    return _share(torch.randint(level, (count,), generator=random), level)


def _share(number: Tensor, level: int) -> Tensor:
    return number.to(torch.float64) / (level - 1)
