"""The docking problem, Eqs. 3–15 of Sotiropoulos, Aspragathos & Andritsos (2011), solved in two ways.

Examples
--------
>>> import dexterity as dx
>>> problem = dx.docking.DockingProblem(dx.robots.docking_arm())
>>> options = dx.search.GeneticOptions(population=20, generations=10)
>>> docking = dx.docking.genetic_docking(problem, seed=0, options=options)
>>> docking.pose.shape, bool(problem.allows(docking.pose)), docking.fitness > 0
(torch.Size([4]), True, True)
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, field
from functools import cached_property
from typing import Literal, NamedTuple, TypeAlias, get_args

import torch
from jaxtyping import Bool, Float64
from torch import Tensor

from dexterity import spatial
from dexterity.chain import Chain
from dexterity.docking.area import (
    TOOL_AHEAD,
    TOOL_UP,
    Face,
    area_manipulability,
    base_pose,
    control_points,
    square,
)
from dexterity.search.genetic import GeneticOptions, GeneticSearch, genetic_search
from dexterity.search.zoom import ZoomOptions, ZoomSearch, zoom_search
from dexterity.spatial import TensorLike

__all__ = ["Docking", "DockingProblem", "Region", "genetic_docking", "global_docking"]

Region: TypeAlias = Literal["and", "or"]
"""Whether the base is beside the task area in x *and* y, as Eq. 14 has it, or in either, as the text says."""


_EDGE = 1e-12  # [m] and [rad]


class _Lie(NamedTuple):
    """How a face lies in G: its two directions, its normal and on which side of it outside is, its tool."""

    along: tuple[int, int]
    normal: int
    outwards: float
    tool: tuple[tuple[float, float, float], ...]


_LIES = {"top": _Lie((0, 1), 2, 1.0, TOOL_UP), "side": _Lie((1, 2), 0, -1.0, TOOL_AHEAD)}


@dataclass(frozen=True)
class DockingProblem:
    """A block with a task area on a face, a vehicle that docks on it, and what a good pose is.

    The frame G is in the middle of the face, z up; lengths [m], angles [rad].

    Parameters
    ----------
    arm
        Arm at the vehicle's bow, six joints with a spherical wrist.
    region
        Whether the base stays beside the task area in both directions or in one; see `Region`.
    face
        Which face of the block; the directions of the side are y and z.
    points
        (m, 3) control points; None for the corners of the task area.
    block
        Extent of the face along its two directions.
    area
        Width of the square task area in its middle.
    height
        Smallest and largest distance of the arm's base from the face.
    yaw
        Smallest and largest ψ.
    tilt
        Largest roll and pitch to either side. Where it is positive, poses are x, y, z, roll, pitch, ψ.
    start, heading
        Position and heading ψ of the arm's base before docking.
    foot
        Where the vehicle is fixed, seen from the arm's base.
    manipulability_weight, distance_weight
        Weights a and b of Eq. 8.
    tool
        (3, 3) orientation R_G_tool of the tool at the control points; None to have its sixth axis square to
        the face.

    Raises
    ------
    ValueError
        If the region or the face is unknown, a number is not finite or out of its range, there is no control
        point or one is beyond the block, the task area is larger than the block, a lower limit is above its
        upper one, or no pose is allowed.
    """

    arm: Chain
    region: Region = "and"
    face: Face = "top"
    points: TensorLike | None = None
    block: tuple[float, float] = (2.0, 2.0)
    area: float = 0.4
    height: tuple[float, float] = (0.2, 0.25)
    yaw: tuple[float, float] = (-math.pi, math.pi)
    tilt: float = 0.0
    start: tuple[float, float, float] = (-2.0, -2.0, 2.0)
    heading: float = math.pi / 4
    foot: tuple[float, float, float] = (-0.3, 0.0, -0.2)
    manipulability_weight: float = 50.0
    distance_weight: float = 0.1
    tool: tuple[tuple[float, float, float], ...] | None = None

    def __post_init__(self) -> None:
        for name, known in (("region", get_args(Region)), ("face", get_args(Face))):
            if getattr(self, name) not in known:
                raise ValueError(f"{name} is {getattr(self, name)!r}; {known} are known")
        for name in ("block", "area", "height", "yaw", "tilt", "start", "heading", "foot"):
            spatial.to_float64(getattr(self, name), name)
        if min(self.block) <= 0 or self.area <= 0:
            raise ValueError(f"block is {self.block} and area {self.area}; positive lengths are needed")
        if self.area > min(self.block):
            raise ValueError(f"area is {self.area}; the block is {self.block}, and smaller")
        for name in ("height", "yaw"):
            if getattr(self, name)[0] > getattr(self, name)[1]:
                raise ValueError(f"{name} is {getattr(self, name)}; the lower limit is above the upper one")
        if not 0 <= self.tilt <= math.pi / 2:
            raise ValueError(f"tilt is {self.tilt}; 0 to π/2 is needed")
        beside = [side > self.area for side in self.block]
        if not (all(beside) if self.region == "and" else any(beside)):
            raise ValueError("region is empty: the task area leaves nothing of the block beside it")
        for name in ("manipulability_weight", "distance_weight"):
            if not 0 <= getattr(self, name) < math.inf:
                raise ValueError(f"{name} is {getattr(self, name)}; 0 or a positive number is needed")
        points = self.control_points
        if (points[:, self._lie.along].abs() > points.new_tensor(self.block) / 2).any():
            raise ValueError("points holds some beyond the block")

    @cached_property
    def control_points(self) -> Float64[Tensor, "m 3"]:
        """Points that the area manipulability is taken over."""
        return control_points(square(self.area / 2, face=self.face) if self.points is None else self.points)

    @property
    def _lie(self) -> _Lie:
        return _LIES[self.face]

    @cached_property
    def lower(self) -> Float64[Tensor, " d"]:
        """Lower limits of a pose, of 4 numbers or, with tilt, of 6."""
        return self._limits(-1)

    @cached_property
    def upper(self) -> Float64[Tensor, " d"]:
        """Upper limits of a pose, of 4 numbers or, with tilt, of 6."""
        return self._limits(1)

    @property
    def boxes(self) -> tuple[tuple[Tensor, Tensor], ...]:
        """Limits (d) and (d) of boxes that together are the group W_d."""
        edge = self.lower.new_tensor(self.area / 2)
        beside = {i: [(self.lower[i], -edge), (edge, self.upper[i])] for i in self._lie.along}
        if self.region == "and":
            sides = [dict(zip(beside, sides, strict=True)) for sides in itertools.product(*beside.values())]
        else:
            sides = [{i: side} for i, both in beside.items() for side in both]
        boxes = []
        for side in sides:
            lower, upper = self.lower.clone(), self.upper.clone()
            for i, (low, high) in side.items():
                lower[i], upper[i] = low, high
            if (lower <= upper).all():
                boxes.append((lower, upper))
        return tuple(boxes)

    def _limits(self, side: int) -> Tensor:
        place = torch.empty(3, dtype=torch.float64)
        place[list(self._lie.along)] = side * place.new_tensor(self.block) / 2
        place[self._lie.normal] = self._lie.outwards * self.height[side * self._lie.outwards > 0]
        tilt = [side * self.tilt] * 2 if self.tilt else []
        return torch.cat([place, place.new_tensor([*tilt, self.yaw[side > 0]])])

    def allows(self, pose: TensorLike) -> Bool[Tensor, "*batch"]:
        """Tell which poses (..., 4) or (..., 6) are in the group W_d of Eq. 14, its edges included."""
        pose = self._poses(pose)
        # The best poses are on edges, which rounding must not put outside.
        inside = ((pose >= self.lower - _EDGE) & (pose <= self.upper + _EDGE)).all(-1)
        beside = pose[..., self._lie.along].abs() >= self.area / 2 - _EDGE
        return inside & (beside.all(-1) if self.region == "and" else beside.any(-1))

    def distance(self, pose: TensorLike) -> Float64[Tensor, "*batch"]:
        """Distance D [m] that the vehicle's foot covers from the start, Eqs. 3–7."""
        return (self._foot(self._poses(pose)) - self._foot_before).norm(dim=-1)

    @cached_property
    def _foot_before(self) -> Tensor:
        return self._foot(torch.tensor([*self.start, self.heading], dtype=torch.float64))

    def _foot(self, pose: Tensor) -> Tensor:
        return spatial.apply(base_pose(pose), pose.new_tensor(self.foot))

    def area_manipulability(self, pose: TensorLike) -> Float64[Tensor, "*batch"]:
        """Area manipulability M_a over the control points, Eq. 1."""
        tool = self._lie.tool if self.tool is None else self.tool
        return area_manipulability(self.arm, self._poses(pose), self.control_points, tool)

    def objective(self, pose: TensorLike) -> Float64[Tensor, "*batch"]:
        """Objective a M_a − b D of Eq. 8, wherever the pose is."""
        gain = self.manipulability_weight * self.area_manipulability(pose)
        return gain - self.distance_weight * self.distance(pose)

    def fitness(self, pose: TensorLike) -> Float64[Tensor, "*batch"]:
        """Fitness of Eq. 15: the objective where the pose is allowed, else 0."""
        return torch.where(self.allows(pose), self.objective(pose), 0.0)

    def _poses(self, pose: TensorLike) -> Tensor:
        pose = spatial.to_float64(pose, "pose")
        if pose.shape[-1:] != self.lower.shape:
            raise ValueError(f"pose has shape {tuple(pose.shape)}; (..., {len(self.lower)}) is needed")
        return pose


@dataclass(frozen=True)
class Docking:
    """A docking pose that a search has found.

    Attributes
    ----------
    pose
        (4,) = x, y, z, ψ of the arm's base in G, [m] and [rad], or (6,) with roll and pitch before ψ.
    area_manipulability
        M_a there.
    distance
        D there [m].
    fitness
        Fitness of Eq. 15 there.
    search
        How it was found.
    """

    pose: Float64[Tensor, " d"]
    area_manipulability: float
    distance: float
    fitness: float
    search: GeneticSearch | ZoomSearch = field(repr=False)

    @classmethod
    def at(cls, problem: DockingProblem, search: GeneticSearch | ZoomSearch) -> Docking:
        """Return the docking at the best point of a search."""
        pose = search.point
        return cls(
            pose,
            problem.area_manipulability(pose).item(),
            problem.distance(pose).item(),
            problem.fitness(pose).item(),
            search,
        )


def genetic_docking(
    problem: DockingProblem,
    seed: int,
    options: GeneticOptions | None = None,
    precision: float = 0.01,
) -> Docking:
    """Solve a docking problem as the paper does, by its genetic algorithm.

    Parameters
    ----------
    problem
        What is to be solved.
    seed
        Of the algorithm's random numbers.
    options
        Parameters of the algorithm; None for those of Table 2.
    precision
        Step of all variables in the chromosome, [m] and [rad].

    Raises
    ------
    ValueError
        If the precision is not positive, or the arm has no spherical wrist.
    """
    steps = torch.full_like(problem.lower, precision)
    generator = torch.Generator().manual_seed(seed)
    search = genetic_search(
        problem.fitness, problem.lower, problem.upper, steps, generator, options or GeneticOptions()
    )
    return Docking.at(problem, search)


def global_docking(
    problem: DockingProblem, steps: TensorLike | None = None, options: ZoomOptions | None = None
) -> Docking:
    """Solve a docking problem by looking everywhere: a grid over all poses, then finer ones about the best.

    Parameters
    ----------
    problem
        What is to be solved.
    steps
        (d,) steps of the first grid, [m] and [rad]; by default 0.05 m, and 0.1 rad or, for a tilt, 0.2.
    options
        How fine to look then; None for the defaults.

    Raises
    ------
    ValueError
        If the steps do not fit, or the arm has no spherical wrist.
    """
    if steps is None:
        steps = [0.05, 0.05, 0.05, *[0.2] * (len(problem.lower) - 4), 0.1]
    searches = [
        zoom_search(problem.objective, *box, steps, options or ZoomOptions()) for box in problem.boxes
    ]
    return Docking.at(problem, max(searches, key=lambda search: search.value))
