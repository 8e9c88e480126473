r"""Workspaces of an arm on a grid of positions and orientations, and how manipulable the arm is there.

Whatever tells which poses are in reach, and with what manipulability, is an :class:`Answer`: all branches of
any arm with a spherical wrist, with its limits and its tool; the closed form of the family of paper C; a
learned Jacobian. The maps do not know which one they have.

Any other chain, such as a UR5e or a Panda, has a map by :func:`dexterity.reach.survey`. Maps are worked out
on the CPU.

The paper's introduction has five workspaces. With :math:`W \subset \mathbb{R}^3 \times SO(3)` the poses in
reach, a position belongs to the *reachable* workspace if some orientation is had there, to the *dexterous*
one if all are, to the *total orientation* workspace of a set of orientations if all of the set are, to the
*constant orientation* workspace of R if R is; the *orientation* workspace of a position is what is had there.
On a grid "some" and "all" are of finitely many orientations: a reachable workspace comes out too small, the
others too large, by what lies between the orientations.

Examples
--------
>>> import dexterity as dx
>>> from dexterity.workspace import maps
>>> answer = maps.ByBranches(dx.robots.puma560())
>>> survey = maps.survey(answer, maps.Grid.cube(0.8, per_side=3), maps.rotations(8))
>>> survey.share.shape, int(survey.reachable.sum())
(torch.Size([3, 3, 3]), 4)
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple, Protocol, runtime_checkable

import numpy as np
import torch
from jaxtyping import Bool, Float64, Int64
from torch import Tensor

from dexterity import checks, spatial
from dexterity.chain import Chain
from dexterity.inverse_kinematics import nearest_copy, spherical_wrist
from dexterity.inverse_kinematics.turns import angles_within
from dexterity.spatial import TensorLike
from dexterity.spatial.tolerances import LIMIT
from dexterity.spatial.values import on_cpu
from dexterity.workspace.closed_form import in_torch
from dexterity.workspace.compiled import in_c
from dexterity.workspace.dataset import HALF_SIDE, LARGEST_LENGTH
from dexterity.workspace.reachability import NAMED_BRANCH, Branch, arm, one_arm, reachable

__all__ = [
    "TRAINED_HALF_SIDE",
    "Answer",
    "ByBranches",
    "ByClosedForm",
    "ByNetwork",
    "Grid",
    "Map",
    "PoseNetwork",
    "Reply",
    "Survey",
    "around",
    "constant_orientation",
    "in_training_range",
    "orientation_workspace",
    "rotations",
    "survey",
]

TRAINED_HALF_SIDE = HALF_SIDE
"""Half the side of the cube of positions that networks are trained on, [m]."""

POSES_AT_ONCE = 2**15
"""Poses that are worked on together.

The closed form takes some 1 kB for each, so 32 MB, all branches take some 5 kB, so 160 MB; a network takes
what its layers do.
"""


# ---- who answers -----------------------------------------------------------------------------------


class Reply(NamedTuple):
    """What is known of poses.

    Attributes
    ----------
    reached
        (...) whether they are in reach.
    manipulability
        (...) w of the geometric Jacobian of the tool point [m³]; 0 where a pose is out of reach.
    """

    reached: Tensor
    manipulability: Tensor


@runtime_checkable
class Answer(Protocol):
    """Tells what an arm reaches, and how well."""

    def __call__(self, T_base_tool: Tensor) -> Reply:
        """Look at rigid poses (..., 4, 4) of the tool in the base."""
        ...


@dataclass(frozen=True)
class ByBranches:
    """All branches of an arm with a spherical wrist, within its limits; the best of them counts.

    Attributes
    ----------
    arm
        Six revolute joints, the last three through one point; its tool may be anywhere.
    limit_tolerance
        By how much [rad] a limit may be exceeded.

    Raises
    ------
    ValueError
        If the arm has no spherical wrist, or the tolerance is negative.
    """

    arm: Chain
    limit_tolerance: float = LIMIT

    def __post_init__(self) -> None:
        checks.fields(self, arm=checks.Instance(Chain), limit_tolerance=checks.Real(least=0.0))
        try:
            spherical_wrist(self.arm, self.arm.home)
        except ValueError as error:
            raise ValueError(f"{error}; dexterity.reach.survey maps any chain") from None

    def __call__(self, T_base_tool: Tensor) -> Reply:
        """Look at rigid poses (..., 4, 4).

        Raises
        ------
        ValueError
            If a pose is not rigid or not finite.
        """
        q, valid = spherical_wrist(self.arm, T_base_tool)
        _, within = nearest_copy(self.arm, q, limit_tolerance=self.limit_tolerance)
        allowed = valid & within
        w = torch.zeros(allowed.shape, dtype=q.dtype, device=q.device)
        w[allowed] = torch.linalg.det(self.arm.geometric_jacobian(q[allowed])).abs()
        return Reply(allowed.any(-1), w.amax(-1))


class ByClosedForm:
    """An arm of the family of paper C, by square roots alone.

    Where an angle may have any value, one is held against the limits, as in `ByBranches`.

    Parameters
    ----------
    links
        (4,) d₃, d₄, a₂, a₃ [m].
    branch
        The configuration that counts; None for the best of all eight.
    lower, upper
        (6,) joint limits [rad]; none by default. Infinite ones are allowed.
    T_flange_tool
        (4, 4) tool in the frame whose origin is the wrist's centre; none by default.
    backend
        ``"torch"``: needs nothing else. ``"c"``: some ten times as fast; needs a C compiler.
    limit_tolerance
        By how much [rad] a limit may be exceeded. Limits are looked at through the cosine of the distance
        from their middle, so that limits that hold a joint are met to 1e-7 at best.

    Raises
    ------
    ValueError
        If there are not four lengths, one is negative or not finite, the limits are not six or the wrong way
        round, the tool is not one rigid pose, or the backend is unknown.
    CompilationFailed
        If a compiler is missing or fails.
    """

    def __init__(
        self,
        links: TensorLike,
        branch: Branch | None = NAMED_BRANCH,
        *,
        lower: TensorLike | None = None,
        upper: TensorLike | None = None,
        T_flange_tool: TensorLike | None = None,
        backend: Literal["torch", "c"] = "torch",
        limit_tolerance: float = LIMIT,
    ) -> None:
        self._links = on_cpu(one_arm(links), "links")
        checks.choice(backend, "backend", _BACKENDS)
        checks.OrNone(checks.Instance(Branch))(branch, "branch")
        self._tolerance = checks.real(limit_tolerance, "limit_tolerance", least=0.0)
        free = arm(self._links)
        limited = free.with_limits(lower=lower, upper=upper)
        pairs = enumerate(zip(limited.lower.tolist(), limited.upper.tolist(), strict=True))
        # Joints that can turn all the way round fit always.
        self._limits = {joint: limits for joint, limits in pairs if limits[1] - limits[0] < math.tau}
        self._to_flange = None if T_flange_tool is None else spatial.inverse(_one_pose(T_flange_tool))
        names = ("cosines", "sines", "manipulability") if self._limits else ("manipulability",)
        # Without limits a flip of the wrist changes nothing.
        flips = (False, True) if self._limits else (False,)
        every = itertools.starmap(Branch, itertools.product((True, False), (True, False), flips))
        self._made_of = backend, names, [branch] if branch else list(every)
        self._branches = self._functions()

    def _functions(self) -> list[Callable[[Tensor, Tensor], Tensor]]:
        backend, names, branches = self._made_of
        return [_BACKENDS[backend](branch, *names) for branch in branches]

    def __getstate__(self) -> dict[str, Any]:
        # What is compiled stays in its process.
        return {name: value for name, value in vars(self).items() if name != "_branches"}

    def __setstate__(self, state: dict[str, Any]) -> None:
        vars(self).update(state)
        self._branches = self._functions()

    def __call__(self, T_base_tool: Tensor) -> Reply:
        """Look at rigid poses (..., 4, 4).

        Raises
        ------
        ValueError
            If a pose is not rigid or not finite.
        """
        T = spatial.require_rigid(T_base_tool, "T_base_tool")
        if self._to_flange is not None:
            T = T @ self._to_flange
        reached = torch.zeros(T.shape[:-2], dtype=torch.bool)
        in_reach, best = reachable(self._links, T[..., :3, 3]), torch.zeros(T.shape[:-2], dtype=T.dtype)
        for branch in self._branches:
            values = branch(self._links, T)
            allowed = in_reach & self._within_limits(values)
            reached |= allowed
            # On the very border a square root may be that of a number just below zero, and w is zero.
            best = torch.maximum(best, torch.where(allowed, values[..., -1], 0.0).nan_to_num(nan=0.0))
        return Reply(reached, best)

    def _within_limits(self, values: Tensor) -> Tensor:
        within = torch.ones(values.shape[:-1], dtype=torch.bool)
        for joint, limits in self._limits.items():
            within &= angles_within(values[..., joint], values[..., 6 + joint], limits, self._tolerance)
        return within


_BACKENDS = {"torch": in_torch, "c": in_c}


@runtime_checkable
class PoseNetwork(Protocol):
    """Networks that estimate the Jacobian of an arm at a pose, and how sure they are that there is one."""

    def answer(self, links: Tensor, T_base_tool: Tensor) -> tuple[Tensor, Tensor, Tensor]:
        """Look at arms (..., 4) and poses (..., 4, 4).

        Returns
        -------
        Confidence (...), geometric Jacobian (..., 6, 6) without NaN, and whether the confidence is above the
        threshold (...).
        """
        ...


class ByNetwork:
    """What networks take an arm of the family of paper C to reach.

    Parameters
    ----------
    network
        The networks.
    links
        (4,) d₃, d₄, a₂, a₃ [m].

    Raises
    ------
    ValueError
        If there are not four numbers, or one is negative or not finite.
    """

    @checks.arguments(network=checks.Instance(PoseNetwork))
    def __init__(self, network: PoseNetwork, links: TensorLike) -> None:
        self._network = network
        self._links = one_arm(links)

    def __call__(self, T_base_tool: Tensor) -> Reply:
        """Look at rigid poses (..., 4, 4), in the range that the networks were trained in or not.

        Raises
        ------
        ValueError
            If a pose is not rigid or not finite.
        """
        T = spatial.require_rigid(T_base_tool, "T_base_tool")
        _, J, reached = self._network.answer(self._links.expand(*T.shape[:-2], 4), T)
        return Reply(reached, torch.where(reached, torch.linalg.det(J).abs(), 0.0))

    def in_training_range(self, position: TensorLike) -> Bool[Tensor, "*batch"]:
        """Whether the arm and positions (..., 3) are such as networks are trained on."""
        return in_training_range(self._links, position)


def in_training_range(links: TensorLike, position: TensorLike) -> Bool[Tensor, "*batch"]:
    """Whether arms (..., 4) and positions (..., 3) [m] are such as networks are trained on.

    Outside, an answer of a network is worth nothing, whatever its confidence.

    Raises
    ------
    ValueError
        If a shape does not fit, or something is not finite.
    """
    links, position = spatial.batch_of(links, "links", (4,)), spatial.batch_of(position, "position", (3,))
    known = ((links >= 0) & (links <= LARGEST_LENGTH)).all(-1)
    return known & (position.abs() <= TRAINED_HALF_SIDE).all(-1)


def _one_pose(T_flange_tool: TensorLike) -> Tensor:
    T = spatial.require_rigid(T_flange_tool, "T_flange_tool")
    if T.shape != (4, 4):
        raise ValueError(f"T_flange_tool has shape {tuple(T.shape)}; one pose (4, 4) is needed")
    return T


# ---- where it is asked -----------------------------------------------------------------------------


@dataclass(frozen=True)
class Grid:
    """Positions on a box grid in the base.

    Attributes
    ----------
    x, y, z
        Coordinates along each axis [m]; any numbers of them, one or more.

    Raises
    ------
    ValueError
        If an axis is empty, or not a row of finite numbers.
    """

    x: Tensor
    y: Tensor
    z: Tensor

    def __post_init__(self) -> None:
        for name in ("x", "y", "z"):
            values = on_cpu(getattr(self, name), name)
            if values.ndim != 1 or len(values) == 0:
                raise ValueError(f"{name} has shape {tuple(values.shape)}; one coordinate or more are needed")
            object.__setattr__(self, name, values.clone())

    @classmethod
    def cube(cls, half_side: float, per_side: int) -> Grid:
        """Return a cube about the base, its faces included.

        Parameters
        ----------
        half_side
            Half the length of a side [m].
        per_side
            Positions a side.

        Raises
        ------
        ValueError
            If the half side is not positive, or there are fewer than two positions a side.
        """
        half, count = checks.positive(half_side, "half_side"), checks.whole(per_side, "per_side", least=2)
        side = torch.linspace(-half, half, count, dtype=torch.float64)
        return cls(side, side, side)

    @property
    def shape(self) -> tuple[int, int, int]:
        """Numbers of positions along x, y and z."""
        return len(self.x), len(self.y), len(self.z)

    def points(self) -> Float64[Tensor, "nx ny nz 3"]:
        """Return all positions [m]."""
        return torch.stack(torch.meshgrid(self.x, self.y, self.z, indexing="ij"), -1)


def rotations(count: int) -> Float64[Tensor, "count 3 3"]:
    """Return rotations spread evenly over all orientations: super-Fibonacci spirals, the same every time.

    Raises
    ------
    ValueError
        If there is not one at least.

    References
    ----------
    Alexa (2022), Super-Fibonacci spirals: fast, low-discrepancy sampling of SO(3), CVPR.
    """
    count = checks.whole(count, "count", least=1)
    step = torch.arange(count, dtype=torch.float64) + 0.5
    inner, outer = (step / count).sqrt(), (1 - step / count).sqrt()
    a, b = math.tau * step / math.sqrt(2), math.tau * step / _PSI
    return _from_quaternions(inner * a.sin(), inner * a.cos(), outer * b.sin(), outer * b.cos())


_PSI = 1.533751168755204288118041  # positive root of ψ⁴ = ψ + 4


def _from_quaternions(x: Tensor, y: Tensor, z: Tensor, w: Tensor) -> Tensor:
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    return torch.stack([torch.stack(row, -1) for row in rows], -2)


def around(orientations: TensorLike, direction: TensorLike, half_angle: float) -> Bool[Tensor, " m"]:
    """Tell which orientations have the tool's z axis within a cone: a range for `survey`.

    Parameters
    ----------
    orientations
        (m, 3, 3) rotations of the tool to the base.
    direction
        (3,) axis of the cone in the base, of any length but zero.
    half_angle
        Between the axis and the cone's side [rad], from 0 to π.

    Raises
    ------
    ValueError
        If a shape does not fit, something is not finite or no rotation, the direction is zero, or the angle
        is not in that range.
    """
    R, axis = _orientations(orientations), on_cpu(direction, "direction")
    if axis.shape != (3,) or not axis.norm() > 0:
        raise ValueError(f"direction is {axis.tolist()}; three numbers that are not all 0 are needed")
    widest = checks.real(half_angle, "half_angle", least=0.0, most=math.pi)
    return R[..., 2] @ (axis / axis.norm()) >= math.cos(widest) - 1e-12


# ---- maps ------------------------------------------------------------------------------------------


class Map(NamedTuple):
    """An answer on a grid, or for orientations at a point.

    Attributes
    ----------
    reached
        Whether a pose is in reach; (nx, ny, nz) or (m,).
    manipulability
        w [m³], 0 where it is not; of the same shape.
    """

    reached: Tensor
    manipulability: Tensor


def constant_orientation(
    answer: Answer, grid: Grid, orientation: TensorLike, poses_at_once: int = POSES_AT_ONCE
) -> Map:
    """Map the constant orientation workspace (nx, ny, nz) of one orientation.

    Parameters
    ----------
    answer
        Who tells what is in reach.
    grid
        Positions.
    orientation
        (3, 3) rotation of the tool to the base.
    poses_at_once
        Size of a slab; more takes more memory and changes nothing.

    Raises
    ------
    ValueError
        If the orientation is no rotation, or a slab holds no pose.
    """
    R = on_cpu(orientation, "orientation")
    if R.ndim != 2:
        raise ValueError(f"orientation has shape {tuple(R.shape)}; (3, 3) is needed")
    R = spatial.require_rotation(R, "orientation")
    found = survey(answer, grid, R[None], None, poses_at_once)
    return Map(found.count > 0, found.largest)


def orientation_workspace(answer: Answer, position: TensorLike, orientations: TensorLike) -> Map:
    """Tell which of m orientations are had at a position: the orientation workspace.

    Parameters
    ----------
    answer
        Who tells what is in reach.
    position
        (3,) in the base [m].
    orientations
        (m, 3, 3) rotations of the tool to the base.

    Raises
    ------
    ValueError
        If a shape does not fit, an orientation is no rotation, or something is not finite.
    """
    R, place = _orientations(orientations), on_cpu(position, "position")
    if place.shape != (3,):
        raise ValueError(f"position has shape {tuple(place.shape)}; (3,) is needed")
    return Map(*_asked(answer)(_poses(R, place[None])[0]))


@dataclass(frozen=True)
class Survey:
    """What is had of a set of orientations at each position (nx, ny, nz) of a grid.

    Attributes
    ----------
    orientations
        How many there are.
    in_range
        How many of them are in the range of the total orientation workspace.
    count
        How many are in reach.
    count_in_range
        How many of the range are in reach.
    largest
        Largest w of an orientation [m³]; 0 where there is none.
    """

    orientations: int
    in_range: int
    count: Int64[Tensor, "nx ny nz"]
    count_in_range: Int64[Tensor, "nx ny nz"]
    largest: Float64[Tensor, "nx ny nz"]

    @property
    def reachable(self) -> Tensor:
        """Positions with some of the orientations."""
        return self.count > 0

    @property
    def total_orientation(self) -> Tensor:
        """Positions with all orientations of the range."""
        return self.count_in_range == self.in_range

    @property
    def dexterous(self) -> Tensor:
        """Positions with all orientations."""
        return self.count == self.orientations

    @property
    def share(self) -> Tensor:
        """Share of the orientations that a position has, the measure of its orientation workspace."""
        return self.count.double() / self.orientations


def survey(
    answer: Answer,
    grid: Grid,
    orientations: TensorLike,
    in_range: TensorLike | None = None,
    poses_at_once: int = POSES_AT_ONCE,
) -> Survey:
    """Ask for every position of a grid with every orientation, slab by slab.

    Parameters
    ----------
    answer
        Who tells what is in reach.
    grid
        Positions.
    orientations
        (m, 3, 3) rotations of the tool to the base.
    in_range
        (m,) which of them the total orientation workspace is of, as `around` tells; all by default.
    poses_at_once
        Size of a slab; more takes more memory and changes nothing. What is kept takes 24 bytes a position.

    Raises
    ------
    ValueError
        If an orientation is no rotation, there is none, the range does not fit them or is empty, or a slab
        holds no pose.
    """
    R, answer = _orientations(orientations), _asked(answer)
    checks.instance(grid, "grid", Grid)
    try:
        chosen = torch.as_tensor(np.ones(len(R), dtype=bool) if in_range is None else np.asarray(in_range))
    except (TypeError, ValueError) as error:
        raise TypeError(f"in_range cannot be read as an array: {error}") from error
    if chosen.dtype != torch.bool or chosen.shape != (len(R),) or not chosen.any():
        raise ValueError(
            f"in_range is {chosen.dtype} of shape {tuple(chosen.shape)}; {len(R)} truth values, one of them "
            "true at least, are needed"
        )
    poses_at_once = checks.whole(poses_at_once, "poses_at_once", least=1)
    points = grid.points().reshape(-1, 3)
    count = torch.zeros(len(points), dtype=torch.int64)
    count_in_range, largest = count.clone(), torch.zeros(len(points), dtype=torch.float64)
    for where, turns in _slabs(len(points), len(R), poses_at_once):
        reply = answer(_poses(R[turns], points[where]))
        count[where] += reply.reached.sum(1)
        count_in_range[where] += reply.reached[:, chosen[turns]].sum(1)
        largest[where] = torch.maximum(largest[where], reply.manipulability.amax(1))
    shape = grid.shape
    return Survey(
        orientations=len(R),
        in_range=int(chosen.sum()),
        count=count.reshape(shape),
        count_in_range=count_in_range.reshape(shape),
        largest=largest.reshape(shape),
    )


def _asked(answer: Answer) -> Answer:
    if not callable(answer):
        raise TypeError(f"answer is {checks.shown(answer)}; an Answer, such as ByBranches(arm), is needed")
    return answer


def _slabs(positions: int, orientations: int, at_once: int) -> Iterator[tuple[slice, slice]]:
    turns = min(orientations, at_once)
    places = max(1, at_once // turns)
    for first in range(0, positions, places):
        for start in range(0, orientations, turns):
            yield slice(first, first + places), slice(start, start + turns)


def _poses(R: Tensor, points: Tensor) -> Tensor:
    """Poses (k, m, 4, 4) of every point (k, 3) with every orientation (m, 3, 3)."""
    T = R.new_zeros(len(points), len(R), 4, 4)
    T[..., :3, :3], T[..., :3, 3], T[..., 3, 3] = R, points[:, None], 1
    return T


def _orientations(orientations: TensorLike) -> Tensor:
    R = on_cpu(orientations, "orientations")
    if R.ndim != 3 or R.shape[1:] != (3, 3) or len(R) == 0:
        raise ValueError(f"orientations has shape {tuple(R.shape)}; (m, 3, 3) with m ≥ 1 is needed")
    return spatial.require_rotation(R, "orientations")
