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
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, Literal, NamedTuple, TypeAlias, get_args

import numpy as np
import torch
from jaxtyping import Bool, Float64
from torch import Tensor
from tqdm import tqdm

from dexterity import checks, spatial
from dexterity.chain import Chain
from dexterity.collision import Bodies
from dexterity.docking.area import (
    TOOL_AHEAD,
    TOOL_UP,
    Face,
    area_manipulability,
    base_pose,
    control_points,
    orientation,
    square,
)
from dexterity.docking.free_branches import require_same_arm
from dexterity.inverse_kinematics import spherical_wrist
from dexterity.search import box
from dexterity.search.genetic import GeneticOptions, GeneticSearch, genetic_search
from dexterity.search.zoom import ZoomOptions, ZoomSearch, grid_counts, zoom_search
from dexterity.spatial import TensorLike
from dexterity.spatial.values import on_cpu

__all__ = ["Docking", "DockingProblem", "Region", "evaluations", "genetic_docking", "global_docking"]

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
    bodies
        Bodies on the arm, on its base and in G: configurations in collision do not count. None for an arm
        that passes through block and vehicle, as in the paper's formulas.

    Raises
    ------
    ValueError
        If the arm has no spherical wrist, the bodies are on another arm, the region or the face is unknown, a
        number is not finite or out of its range, there is no control point or one is beyond the block, the
        task area is larger than the block, a lower limit is above its upper one, or no pose is allowed.
    TypeError
        If an argument is of another kind.
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
    bodies: Bodies | None = None

    def __post_init__(self) -> None:
        checks.fields(
            self,
            arm=_fit_arm,
            region=checks.Choice(get_args(Region)),
            face=checks.Choice(get_args(Face)),
            block=_Row(2, _Length(above=0.0)),
            area=_Length(above=0.0),
            height=_Row(2, _Length()),
            yaw=_Row(2, _Length()),
            tilt=checks.Real(least=0.0, most=math.pi / 2),
            start=_Row(3, _Length()),
            heading=_Length(),
            foot=_Row(3, _Length()),
            manipulability_weight=checks.Real(least=0.0),
            distance_weight=checks.Real(least=0.0),
            tool=_tool,
        )
        if self.bodies is not None:
            require_same_arm(self.arm, self.bodies)
        if self.area > min(self.block):
            raise ValueError(f"area is {self.area}; the block is {self.block}, and smaller")
        for name in ("height", "yaw"):
            if getattr(self, name)[0] > getattr(self, name)[1]:
                raise ValueError(f"{name} is {getattr(self, name)}; the lower limit is above the upper one")
        beside = [side > self.area for side in self.block]
        if not (all(beside) if self.region == "and" else any(beside)):
            raise ValueError("region is empty: the task area leaves nothing of the block beside it")
        if self.points is not None:
            object.__setattr__(self, "points", control_points(self.points).detach().clone())
        points = self._control_points
        if (points[:, self._lie.along].abs() > points.new_tensor(self.block) / 2).any():
            raise ValueError("points holds some beyond the block")

    @property
    def control_points(self) -> Float64[Tensor, "m 3"]:
        """Points that the area manipulability is taken over (a copy)."""
        return self._control_points.clone()

    @cached_property
    @torch.inference_mode(False)  # kept for later calls in every mode
    def _control_points(self) -> Tensor:
        if self.points is None:
            return square(self.area / 2, face=self.face)
        return control_points(self.points)

    @property
    def _lie(self) -> _Lie:
        return _LIES[self.face]

    @property
    def lower(self) -> Float64[Tensor, " d"]:
        """Lower limits of a pose, of 4 numbers or, with tilt, of 6 (a copy)."""
        return self._ends[0].clone()

    @property
    def upper(self) -> Float64[Tensor, " d"]:
        """Upper limits of a pose, of 4 numbers or, with tilt, of 6 (a copy)."""
        return self._ends[1].clone()

    @cached_property
    @torch.inference_mode(False)  # kept for later calls in every mode
    def _ends(self) -> tuple[Tensor, Tensor]:
        return self._limits(-1), self._limits(1)

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
        lower, upper = self._ends
        inside = ((pose >= lower - _EDGE) & (pose <= upper + _EDGE)).all(-1)
        beside = pose[..., self._lie.along].abs() >= self.area / 2 - _EDGE
        return inside & (beside.all(-1) if self.region == "and" else beside.any(-1))

    def distance(self, pose: TensorLike) -> Float64[Tensor, "*batch"]:
        """Distance D [m] that the vehicle's foot covers from the start, Eqs. 3–7."""
        return (self._foot(self._poses(pose)) - self._foot_before).norm(dim=-1)

    @cached_property
    @torch.inference_mode(False)  # kept for later calls in every mode
    def _foot_before(self) -> Tensor:
        return self._foot(torch.tensor([*self.start, self.heading], dtype=torch.float64))

    def _foot(self, pose: Tensor) -> Tensor:
        return spatial.apply(base_pose(pose), pose.new_tensor(self.foot))

    def area_manipulability(self, pose: TensorLike) -> Float64[Tensor, "*batch"]:
        """Area manipulability M_a over the control points, Eq. 1, of configurations that are free."""
        tool = self._lie.tool if self.tool is None else self.tool
        return area_manipulability(self.arm, self._poses(pose), self._control_points, tool, self.bodies)

    def objective(self, pose: TensorLike) -> Float64[Tensor, "*batch"]:
        """Objective a M_a − b D of Eq. 8, wherever the pose is."""
        gain = self.manipulability_weight * self.area_manipulability(pose)
        return gain - self.distance_weight * self.distance(pose)

    def fitness(self, pose: TensorLike) -> Float64[Tensor, "*batch"]:
        """Fitness of Eq. 15: the objective where the pose is allowed, else 0."""
        return torch.where(self.allows(pose), self.objective(pose), 0.0)

    def _poses(self, pose: TensorLike) -> Tensor:
        pose = on_cpu(pose, "pose")
        size = 6 if self.tilt else 4
        if pose.shape[-1:] != (size,):
            raise ValueError(f"pose has shape {tuple(pose.shape)}; (..., {size}) is needed")
        return pose


_MOST = 1e6  # [m] and [rad], beyond which squares of lengths lose what a docking pose is about


def _Length(above: float | None = None) -> checks.Real:
    return checks.Real(above=above, least=-_MOST if above is None else None, most=_MOST)


@dataclass(frozen=True)
class _Row:
    """So many numbers in a row, each by a check."""

    count: int
    check: checks.Check

    def __call__(self, value: Any, name: str) -> tuple[float, ...]:
        values = on_cpu(value, name).tolist() if isinstance(value, Tensor | np.ndarray) else value
        if not isinstance(values, Sequence) or isinstance(values, str | bytes) or len(values) != self.count:
            raise ValueError(f"{name} is {checks.shown(value)}; {self.count} numbers are needed")
        return tuple(self.check(number, name) for number in values)


def _fit_arm(value: Any, name: str) -> Chain:
    """Return an arm that the docking functions serve."""
    arm = checks.Instance(Chain)(value, name)
    try:
        spherical_wrist(arm, arm.home)
    except ValueError as error:
        raise ValueError(f"{error}; dexterity.reach.place places the base of any chain") from None
    return arm


def _tool(value: Any, name: str) -> tuple[tuple[float, ...], ...] | None:
    if value is None:
        return None
    return tuple(tuple(row) for row in orientation(value, name).tolist())


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

    def __repr__(self) -> str:
        names = ("x", "y", "z", "yaw") if len(self.pose) == 4 else ("x", "y", "z", "roll", "pitch", "yaw")
        pose = ", ".join(
            f"{name} {value:.4g} {'m' if name in 'xyz' else 'rad'}"
            for name, value in zip(names, self.pose.tolist(), strict=True)
        )
        return (
            f"Docking({pose}; area manipulability {self.area_manipulability:.4g}, "
            f"distance {self.distance:.4g} m, fitness {self.fitness:.4g})"
        )

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


@checks.arguments(
    problem=checks.Instance(DockingProblem), options=checks.OrNone(checks.Instance(GeneticOptions))
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
    steps = torch.full_like(problem.lower, checks.positive(precision, "precision"))
    generator = torch.Generator().manual_seed(checks.whole(seed, "seed"))
    search = genetic_search(
        problem.fitness, problem.lower, problem.upper, steps, generator, options or GeneticOptions()
    )
    return Docking.at(problem, search)


@checks.arguments(
    problem=checks.Instance(DockingProblem),
    options=checks.OrNone(checks.Instance(ZoomOptions)),
    progress=checks.OrNone(checks.Flag()),
)
def global_docking(
    problem: DockingProblem,
    steps: TensorLike | None = None,
    options: ZoomOptions | None = None,
    progress: bool | None = None,
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
    progress
        Whether to show a bar with the number of poses and the remaining time; None for a bar on a terminal
        when the search takes more than three seconds. :func:`evaluations` says how many poses there are.

    Raises
    ------
    ValueError
        If the steps do not fit, or a grid would have too many poses.
    """
    options, steps = options or ZoomOptions(), _first_steps(problem, steps)
    total = evaluations(problem, steps, options)
    disable = None if progress is None else not progress
    delay = 3.0 if progress is None else 0.0
    with tqdm(total=total, desc="docking poses", unit_scale=True, disable=disable, delay=delay) as bar:

        def objective(pose: Tensor) -> Tensor:
            values = problem.objective(pose)
            bar.update(len(pose))
            return values

        searches = [zoom_search(objective, *box, steps, options) for box in problem.boxes]
    return Docking.at(problem, max(searches, key=lambda search: search.value))


@checks.arguments(
    problem=checks.Instance(DockingProblem), options=checks.OrNone(checks.Instance(ZoomOptions))
)
def evaluations(
    problem: DockingProblem, steps: TensorLike | None = None, options: ZoomOptions | None = None
) -> int:
    """Return how many poses :func:`global_docking` looks at, at most.

    An elbow arm takes some microseconds a pose, another arm some milliseconds.

    Parameters and errors are those of :func:`global_docking`.
    """
    options, lengths = (
        options or ZoomOptions(),
        box.steps(_first_steps(problem, steps), "steps", _size(problem)),
    )
    count = 0
    for low, high in problem.boxes:
        grid = grid_counts(low, high, lengths)
        count += math.prod(grid) + min(
            options.starts, math.prod(grid)
        ) * options.stages * options.levels ** len(low)
    return count


def _size(problem: DockingProblem) -> int:
    return 6 if problem.tilt else 4


def _first_steps(problem: DockingProblem, steps: TensorLike | None) -> TensorLike:
    return [0.05, 0.05, 0.05, *[0.2] * (_size(problem) - 4), 0.1] if steps is None else steps
