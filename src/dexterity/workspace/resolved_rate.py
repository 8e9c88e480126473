r"""Resolved-rate motion control: joint rates from a Jacobian, however found (Figs. 11 and 12 of paper C).

.. math:: \dot q = J^{-1}(q) \, \bigl( \nu_d(t) + k \, e(q, t) \bigr),

where :math:`\nu_d` is the wanted velocity of the tool and e what is missing of its pose, in the world's axes:
positions as they are, orientations as a rotation vector. The joint angles are integrated in steps. The true
forward kinematics closes the loop, so that a Jacobian which is a little wrong slows the error's decay, or
leaves some of it, but does not let it grow.

References
----------
Whitney, D. E. (1969), Resolved motion rate control of manipulators and human prostheses.

Examples
--------
>>> import dexterity as dx
>>> from dexterity.workspace.resolved_rate import Circle, track
>>> puma, q = dx.robots.puma560(), [0.0, 0.5, 0.25, 0.0, 0.5, 0.0]
>>> R, (x, y, z) = puma.forward(q)[:3, :3].tolist(), puma.forward(q)[:3, 3].tolist()
>>> circle = Circle((x - 0.05, y, z), 0.05, 10.0, 0.0, orientation=tuple(map(tuple, R)))
>>> track(circle, puma.forward, puma.geometric_jacobian, q, duration=0.5).completed
True
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, NamedTuple, Protocol, TypeAlias, get_args, runtime_checkable

import torch
from jaxtyping import Float64
from torch import Tensor

from dexterity import checks, spatial
from dexterity.checks import Real
from dexterity.spatial import TensorLike
from dexterity.spatial.values import on_cpu

__all__ = ["Circle", "Method", "Path", "Tracking", "Wanted", "track"]

Method: TypeAlias = Literal["euler", "rk4"]
"""How joint angles are integrated, by Euler's first-order steps or Runge and Kutta's of fourth order."""

JointFunction: TypeAlias = Callable[[Tensor], Tensor]
"""A function of joint angles (..., n)."""


class Wanted(NamedTuple):
    """What the tool is to do at times (...).

    Attributes
    ----------
    T_world_tool
        (..., 4, 4) poses.
    velocity
        (..., 6) velocity of the tool point [m/s] and angular velocity [rad/s], in the world's axes.
    """

    T_world_tool: Tensor
    velocity: Tensor


@runtime_checkable
class Path(Protocol):
    """Where the tool is to be."""

    def __call__(self, time: Tensor) -> Wanted:
        """Return poses and velocities at times (...) [s]."""
        ...


@dataclass(frozen=True)
class Circle:
    """A circle in a level plane, along which the tool's axis goes round a cone.

    Attributes
    ----------
    centre
        Of the circle in the world [m].
    radius
        Of the circle [m].
    period
        Of one round [s].
    lean
        Between the tool's axis and its mean direction [rad].
    orientation
        (3, 3) rotation R_world_tool that is leant, as rows.

    Raises
    ------
    ValueError
        If the radius is negative, the period is not positive, or the orientation is no rotation.
    """

    centre: tuple[float, float, float]
    radius: float
    period: float
    lean: float
    orientation: tuple[tuple[float, float, float], ...]

    def __post_init__(self) -> None:
        checks.fields(self, radius=Real(least=0), period=Real(above=0), lean=Real())
        for name, shape in (("centre", (3,)), ("orientation", (3, 3))):
            value = on_cpu(getattr(self, name), name)
            if value.shape != shape:
                raise ValueError(f"{name} has shape {tuple(value.shape)}; {shape} is needed")
            rows = value.tolist()
            # As tuples: a circle stays as it is when the caller's array changes.
            object.__setattr__(self, name, tuple(map(tuple, rows)) if name == "orientation" else tuple(rows))
        spatial.pose(self.orientation, self.centre)

    def __call__(self, time: Tensor) -> Wanted:
        """Return poses and velocities at times (...) [s]."""
        speed = math.tau / self.period
        c, s, nothing = (speed * time).cos(), (speed * time).sin(), torch.zeros_like(time)
        ahead, across = torch.stack([c, s, nothing], -1), torch.stack([-s, c, nothing], -1)
        # A turn about the level axis `across`, which itself turns about the vertical.
        lean = spatial.exp(torch.cat([torch.zeros_like(across), self.lean * across], -1))[..., :3, :3]
        position = ahead.new_tensor(self.centre) + self.radius * ahead
        turning = speed * (ahead.new_tensor([0.0, 0.0, 1.0]) - lean[..., 2])
        return Wanted(
            spatial.pose(lean @ ahead.new_tensor(self.orientation), position),
            torch.cat([self.radius * speed * across, turning], -1),
        )


@dataclass(frozen=True)
class Tracking:
    """A run of the control loop.

    Attributes
    ----------
    time
        (m,) [s], from 0.
    q
        (m, n) joint angles [rad].
    position_error
        (m,) distance of the tool from where it is to be [m].
    orientation_error
        (m,) angle between the tool's orientation and the wanted one [rad].
    manipulability
        (m,) w of the Jacobian that was used.
    message
        Why the run ended before its time; empty if it did not.
    """

    time: Float64[Tensor, " m"]
    q: Float64[Tensor, "m n"]
    position_error: Float64[Tensor, " m"]
    orientation_error: Float64[Tensor, " m"]
    manipulability: Float64[Tensor, " m"]
    message: str

    @property
    def completed(self) -> bool:
        """Whether the loop ran to its end."""
        return not self.message


def track(
    path: Path,
    forward: JointFunction,
    geometric_jacobian: JointFunction,
    q: TensorLike,
    *,
    duration: float,
    step: float = 0.01,
    gain: float = 1.0,
    method: Method = "euler",
    largest_rate: float = 10.0,
) -> Tracking:
    """Follow a path.

    Parameters
    ----------
    path
        Where the tool is to be.
    forward
        Poses T_world_tool (..., 4, 4) at joint angles (..., n): the arm itself.
    geometric_jacobian
        (..., 6, n) of the tool point at joint angles (..., n), exact or estimated; n is 6.
    q
        (n,) joint angles to start from [rad].
    duration
        How long [s].
    step
        Of integration [s]; the last one ends at the duration.
    gain
        On the error of the pose [1/s].
    method
        How joint angles are integrated.
    largest_rate
        Joint rate [rad/s] above which the run is ended: the arm is near a singularity, or the Jacobian is
        wrong.

    Returns
    -------
    The run; it says so if it was ended before its time.

    Raises
    ------
    ValueError
        If `q` is not (n,) or not finite, a time or the largest rate is not positive, the gain is negative, or
        the method is unknown.
    """
    q = on_cpu(q, "q")
    if q.ndim != 1:
        raise ValueError(f"q has shape {tuple(q.shape)}; one configuration (n,) is needed")
    for name, function in (("path", path), ("forward", forward), ("geometric_jacobian", geometric_jacobian)):
        checks.function(function, name)
    duration, step, largest_rate = (
        checks.positive(value, name)
        for value, name in ((duration, "duration"), (step, "step"), (largest_rate, "largest_rate"))
    )
    if duration / step > _MOST_STEPS:
        raise ValueError(
            f"step is {step}, with which a duration of {duration} s takes {duration / step:.3g} steps; "
            f"at most {_MOST_STEPS:,} are taken"
        )
    gain = checks.real(gain, "gain", least=0)
    checks.choice(method, "method", get_args(Method))
    return _Loop(path, forward, geometric_jacobian, gain, method, largest_rate).run(q, duration, step)


_MOST_STEPS = 10_000_000


class _Ended(Exception):  # noqa: N818  # it ends a run, which goes on as a result
    """A joint rate that no arm has."""


@dataclass(frozen=True)
class _Loop:
    path: Path
    forward: JointFunction
    jacobian: JointFunction
    gain: float
    method: Method
    largest_rate: float

    def run(self, q: Tensor, duration: float, step: float) -> Tracking:
        steps = math.ceil(duration / step - 1e-9)
        times = (step * torch.arange(steps + 1, dtype=torch.float64)).clamp(max=duration)
        ends, middles = self.path(times), self.path((times[1:] + times[:-1]) / 2)
        passed, message = [q], ""
        for i, length in enumerate(times.diff().tolist()):
            try:
                q = q + length * self._mean_rate(q, length, _at(ends, i), _at(middles, i), _at(ends, i + 1))
            except _Ended as ended:
                message = f"after {times[i]:.4g} s {ended}"
                break
            passed.append(q)
        return self._told(times[: len(passed)], torch.stack(passed), message)

    def _mean_rate(self, q: Tensor, length: float, start: Wanted, middle: Wanted, end: Wanted) -> Tensor:
        first = self._rate(q, start)
        if self.method == "euler":
            return first
        second = self._rate(q + length / 2 * first, middle)
        third = self._rate(q + length / 2 * second, middle)
        fourth = self._rate(q + length * third, end)
        return (first + 2 * second + 2 * third + fourth) / 6

    def _rate(self, q: Tensor, wanted: Wanted) -> Tensor:
        velocity = wanted.velocity + self.gain * _missing(wanted.T_world_tool, self.forward(q))
        rate, failed = torch.linalg.solve_ex(self.jacobian(q), velocity)
        # What is not a number is not below any rate either.
        if failed or not rate.abs().max() <= self.largest_rate:
            raise _Ended(f"a joint would turn at {rate.abs().max():.3g} rad/s")
        return rate

    def _told(self, times: Tensor, q: Tensor, message: str) -> Tracking:
        missing = _missing(self.path(times).T_world_tool, self.forward(q))
        return Tracking(
            time=times,
            q=q,
            position_error=missing[:, :3].norm(dim=1),
            orientation_error=missing[:, 3:].norm(dim=1),
            manipulability=torch.linalg.det(self.jacobian(q)).abs(),
            message=message,
        )


def _at(wanted: Wanted, i: int) -> Wanted:
    return Wanted(wanted.T_world_tool[i], wanted.velocity[i])


def _missing(wanted: Tensor, T: Tensor) -> Tensor:
    """From poses to wanted ones: steps [m] and rotation vectors [rad], (..., 6), in the world's axes."""
    turn = torch.zeros_like(T)
    turn[..., :3, :3], turn[..., 3, 3] = wanted[..., :3, :3] @ T[..., :3, :3].mT, 1
    return torch.cat([wanted[..., :3, 3] - T[..., :3, 3], spatial.log(turn)[..., 3:]], -1)
