"""What is to be positioned, what a method answers with, and how far off that is.

Section 4 of Rouvinen (1999): 25 points with five payloads each, from initial strokes that were rounded to the
centimetre "to create some noise".

Examples
--------
Distance of the loaded tip from two targets [mm] without compensation:

>>> from dexterity.crane.positioning import errors, thesis_task, uncompensated
>>> task = thesis_task(points=[[4.0, 0.0], [5.0, 2.0]], payloads=[100.0])
>>> [round(1000 * d) for d in errors(task, uncompensated(task)).distance.tolist()]
[18, 29]
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple, TypeAlias

import torch
from jaxtyping import Bool, Float64, Int64
from torch import Tensor

from dexterity import checks, spatial
from dexterity.crane.data import TEST_PAYLOADS, TEST_POINTS
from dexterity.crane.description import Crane, given_crane
from dexterity.crane.equilibrium import corotational_deflection
from dexterity.crane.kinematics import inverse, tip_position
from dexterity.crane.structure import deflection, require_payload
from dexterity.spatial import TensorLike
from dexterity.spatial.values import on_cpu

__all__ = [
    "Errors",
    "Placement",
    "SagModel",
    "Task",
    "corotational_sag",
    "errors",
    "linear_sag",
    "thesis_task",
]

SagModel: TypeAlias = Callable[[Tensor, Tensor], Tensor]
"""Deflection (N, 2) [m] for strokes (N, 3) [m] and payloads (N) [kg], a structure's or a learned one."""


@dataclass(frozen=True, eq=False)
class Task:
    """Points that the loaded tip is to be brought to.

    Attributes
    ----------
    targets
        (N, 2) x, y [m].
    payload
        (N) [kg].
    starts
        (N, 3) strokes that the crane has before [m].
    crane
        Which crane.

    Raises
    ------
    ValueError
        If shapes do not fit, a number is not finite, or a payload is negative or above the crane's rating.
    """

    targets: Float64[Tensor, "N 2"]
    payload: Float64[Tensor, " N"]
    starts: Float64[Tensor, "N 3"]
    crane: Crane

    def __post_init__(self) -> None:
        checks.instance(self.crane, "crane", Crane)
        targets = on_cpu(self.targets, "targets")
        for name, shape in (("targets", (2,)), ("payload", ()), ("starts", (3,))):
            value = on_cpu(getattr(self, name), name)
            if value.shape != (*targets.shape[:1], *shape):
                wanted = f"(N, {shape[0]})" if shape else "(N,)"
                raise ValueError(f"{name} has shape {tuple(value.shape)}; {wanted} is needed")
            # A copy: the task stays as it is when the caller's array changes.
            object.__setattr__(self, name, value.clone())
        require_payload(self.payload, self.crane)

    def __len__(self) -> int:
        """Return the number of points N."""
        return len(self.targets)

    @cached_property
    @torch.inference_mode(False)  # kept for later calls in every mode
    def lower(self) -> Float64[Tensor, "N 3"]:
        """Least strokes [m], which are the cylinders' limits, or the start where that is beyond them."""
        return torch.minimum(self.starts, self.starts.new_tensor(self.crane.lower))

    @cached_property
    @torch.inference_mode(False)  # kept for later calls in every mode
    def upper(self) -> Float64[Tensor, "N 3"]:
        """Largest strokes [m], likewise."""
        return torch.maximum(self.starts, self.starts.new_tensor(self.crane.upper))

    @checks.arguments(strokes=checks.Instance(Tensor))
    def allows(self, strokes: Float64[Tensor, "N 3"]) -> Bool[Tensor, " N"]:
        """Tell which strokes the cylinders have."""
        return ((strokes >= self.lower - 1e-9) & (strokes <= self.upper + 1e-9)).all(-1)


_BEYOND, _FARTHEST = 0.05, 1e9  # [m]


def thesis_task(
    points: TensorLike = TEST_POINTS, payloads: TensorLike = TEST_PAYLOADS, crane: Crane | None = None
) -> Task:
    """Return the thesis's test, or one like it: each point (n, 2) [m] with each payload (m) [kg].

    A point's start is the rigid crane's, elbow up with the least extension, rounded to the centimetre.

    Raises
    ------
    ValueError
        If a point cannot be reached with strokes that are up to 5 cm beyond the cylinders' ends, as (2, −4)
        needs, a payload is negative or above the crane's rating, or shapes do not fit.

    References
    ----------
    Rouvinen (1999), section 4, Figs. 4.2 and 4.4.
    """
    crane = given_crane(crane)
    targets, masses = on_cpu(points, "points"), on_cpu(payloads, "payloads")
    for name, value, shape in (("points", targets, (-1, 2)), ("payloads", masses, (-1,))):
        if value.ndim != len(shape) or value.shape[1:] != shape[1:] or not len(value):
            wanted = "(n, 2)" if len(shape) == 2 else "(m,)"
            raise ValueError(f"{name} has shape {tuple(value.shape)}; {wanted} is needed, at least one")
    if (masses < 0).any() or (masses > crane.rating).any():
        raise ValueError(f"payloads is {masses.tolist()}; 0 to the rating of {crane.rating} kg is needed")
    if targets.abs().max() > _FARTHEST:
        raise ValueError(f"points holds numbers beyond {_FARTHEST:g} m")
    reach = inverse(targets, crane=crane)
    lower, upper = targets.new_tensor(crane.lower), targets.new_tensor(crane.upper)
    near = ((reach.strokes >= lower - _BEYOND) & (reach.strokes <= upper + _BEYOND)).all(-1)
    if not near.all():
        raise ValueError(f"points holds {targets[~near][0].tolist()}, which the crane does not reach")
    starts = (reach.strokes * 100).round() / 100
    return Task(
        targets.repeat_interleave(len(masses), dim=0),
        masses.repeat(len(targets)),
        starts.repeat_interleave(len(masses), dim=0),
        crane,
    )


@dataclass(frozen=True, eq=False)
class Placement:
    """What a method answers a task with.

    Attributes
    ----------
    strokes
        (N, 3) strokes to be driven to [m].
    converged
        (N) whether the method reached its own goal.
    iterations
        (N) steps, generations or solves that it took.
    """

    strokes: Float64[Tensor, "N 3"]
    converged: Bool[Tensor, " N"]
    iterations: Int64[Tensor, " N"]


class Errors(NamedTuple):
    """How far the loaded tip is from the targets, as the thesis's table has it.

    Attributes
    ----------
    each
        (N, 2) target less tip [m].
    stopped
        (N) whether a stroke is beyond a cylinder's end.
    """

    each: Tensor
    stopped: Tensor

    @property
    def distance(self) -> Float64[Tensor, " N"]:
        """Distance of the tip from each target [m]."""
        return self.each.norm(dim=-1)

    @property
    def mean(self) -> Float64[Tensor, "3"]:
        """Mean of the errors along x, along y, and of the distances [m]."""
        return torch.cat([self.each.abs().mean(0), self.distance.mean()[None]])

    @property
    def largest(self) -> Float64[Tensor, "3"]:
        """Largest error along x, along y, and largest distance [m]."""
        return torch.cat([self.each.abs().amax(0), self.distance.amax()[None]])


@checks.arguments(sag=checks.OrNone(checks.function))
def errors(task: Task, placement: Placement, sag: SagModel | None = None, end_stops: bool = True) -> Errors:
    """Drive the crane to what a method answers with, exactly, and measure where the tip is.

    Parameters
    ----------
    task, placement
        What was wanted and what a method says.
    sag
        The crane's true deflection; None for :func:`linear_sag`.
    end_stops
        Whether cylinders stop at their ends, as they do. The thesis's simulation moves them to any stroke; so
        does False here, with the deflection of where they would have stopped.

    Raises
    ------
    ValueError
        If a stroke is not finite, or a linkage cannot close beyond the ends.
    """
    checks.instance(task, "task", Task)
    checks.instance(placement, "placement", Placement)
    end_stops = checks.flag(end_stops, "end_stops")
    told = spatial.to_float64(placement.strokes, "strokes")
    if told.shape != task.starts.shape:
        raise ValueError(
            f"placement has strokes of shape {tuple(told.shape)}; {tuple(task.starts.shape)} is needed"
        )
    driven = torch.minimum(torch.maximum(told, task.lower), task.upper)
    rigid = tip_position(driven if end_stops else told, task.crane)
    tip = rigid + (sag or linear_sag(task.crane))(driven, task.payload)
    return Errors(task.targets - tip, ~task.allows(told))


@checks.arguments(crane=checks.OrNone(checks.Instance(Crane)))
def linear_sag(crane: Crane | None = None) -> SagModel:
    """Return a crane's deflection by linear statics as a function of strokes and payload."""
    return functools.partial(deflection, crane=crane)


@checks.arguments(crane=checks.OrNone(checks.Instance(Crane)))
def corotational_sag(crane: Crane | None = None) -> SagModel:
    """Return a crane's co-rotational deflection as a function, which is NaN where it was not found."""
    return functools.partial(_corotational, crane=crane)


def _corotational(strokes: Tensor, payload: Tensor, crane: Crane | None) -> Tensor:
    return corotational_deflection(strokes, payload, crane).deflection
