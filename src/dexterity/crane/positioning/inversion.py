"""Strokes at which a network says that the tip is where it should be: by descent, and by damped Gauss–Newton.

Section 2.4.6 of Rouvinen (1999) goes down the gradient of the output error with a fixed rate and the payload
held. Gauss–Newton with a damping that each point earns for itself takes a few steps where descent takes a
hundred, and without the damping it fails.

Examples
--------
>>> from dexterity.crane import positioning
>>> task = positioning.thesis_task(points=[[4.0, 0.0], [5.0, 2.0]], payloads=[100.0])
>>> tip = positioning.sagging_tip(task, positioning.linear_sag())
>>> positioning.gauss_newton(task, tip).converged.tolist()
[True, True]
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import torch
from jaxtyping import Float64
from torch import Tensor

from dexterity import checks
from dexterity.checks import OrNone, Real, Whole
from dexterity.crane.kinematics import tip_jacobian, tip_position
from dexterity.crane.positioning.task import Placement, SagModel, Task
from dexterity.networks.feed_forward import FeedForward

__all__ = [
    "DescentOptions",
    "GaussNewtonOptions",
    "TipModel",
    "descend",
    "gauss_newton",
    "network_tip",
    "safe_rate",
    "sagging_tip",
]


@dataclass(frozen=True)
class DescentOptions:
    """How to descend.

    Attributes
    ----------
    tolerance
        Error of Eq. 59, in scaled outputs, at which a point is left.
    rate
        Learning rate γ of Eq. 63; None for :func:`safe_rate`.
    iterations
        Largest number of steps.

    Raises
    ------
    ValueError
        If a number is out of its range.
    """

    tolerance: float = 1e-7
    rate: float | None = None
    iterations: int = 10_000

    def __post_init__(self) -> None:
        checks.fields(self, tolerance=Real(above=0), rate=OrNone(Real(above=0)), iterations=Whole(1))


def descend(task: Task, network: FeedForward, options: DescentOptions = DescentOptions()) -> Placement:
    """Invert a network for the tip by gradient descent in its scaled strokes, from the starts.

    Parameters
    ----------
    task
        What is wanted.
    network
        Of strokes and payload (..., 4) for the tip (..., 2), with readout "identity".
    options
        Rate and tolerance.

    References
    ----------
    Rouvinen (1999), Eqs. 59 to 63, after Lampinen (1997).
    """
    checks.instance(task, "task", Task)
    checks.instance(network, "network", FeedForward)
    checks.instance(options, "options", DescentOptions)
    with torch.no_grad():
        rate = safe_rate(network, task) if options.rate is None else options.rate
        centre, half = network.input_centre, network.input_half_range
        x = (torch.cat([task.starts, task.payload[:, None]], dim=-1) - centre) / half
        wanted = (task.targets - network.target_centre) / network.target_half_range
        taken = torch.zeros(len(task), dtype=torch.long)
        going = torch.arange(len(task))
        for step in range(options.iterations + 1):
            miss, slope = _scaled_miss(network, x[going], wanted[going])
            left = miss.square().sum(-1) / 2 > options.tolerance
            going = going[left]
            if not len(going) or step == options.iterations:
                break
            down = (miss[left, None] @ slope[left])[:, 0, :3]
            x[going, :3] -= rate * down
            taken[going] += 1
        converged = torch.ones(len(task), dtype=torch.bool)
        converged[going] = False
    return Placement((x * half + centre)[:, :3], converged, taken)


def _scaled_miss(network: FeedForward, x: Tensor, wanted: Tensor) -> tuple[Tensor, Tensor]:
    """Scaled output less what is wanted (N, 2), and its derivative by the scaled inputs (N, 2, 4)."""
    hidden = torch.tanh(x @ network.hidden_weights.mT + network.hidden_biases)
    output = hidden @ network.output_weights.mT + network.output_biases
    slope = (network.output_weights * (1 - hidden.square())[:, None]) @ network.hidden_weights
    return output - wanted, slope


@checks.arguments(network=checks.Instance(FeedForward), task=checks.Instance(Task))
def safe_rate(network: FeedForward, task: Task, points: int = 9) -> float:
    """One over the largest squared singular value that the Jacobian by the scaled strokes has on a grid.

    With it, descent does not overshoot where the network is no steeper than on the grid, which spans what the
    network was scaled to.

    Parameters
    ----------
    network
        What is inverted.
    task
        Whose middle payload the grid has.
    points
        Of the grid along each stroke.
    """
    points = checks.whole(points, "points", least=2, most=100)
    with torch.no_grad():
        line = torch.linspace(-1, 1, points, dtype=torch.float64)
        grid = torch.nn.functional.pad(torch.cartesian_prod(line, line, line), (0, 1))
        grid[:, 3] = (task.payload.median() - network.input_centre[3]) / network.input_half_range[3]
        slopes = _scaled_miss(network, grid, torch.zeros(2, dtype=torch.float64))[1][..., :3]
        return 1 / torch.linalg.matrix_norm(slopes, ord=2).max().item() ** 2


# ---- damped Gauss–Newton ---------------------------------------------------------------------------

TipModel: TypeAlias = Callable[[Tensor, Tensor], tuple[Tensor, Tensor]]
"""Tip (N, 2) [m] and its derivative by the strokes (N, 2, 3), for strokes (N, 3) and payloads (N)."""


@checks.arguments(network=checks.Instance(FeedForward))
def network_tip(network: FeedForward) -> TipModel:
    """Return a network of strokes and payload for the tip, with its derivative."""

    def tip(strokes: Tensor, payload: Tensor) -> tuple[Tensor, Tensor]:
        with torch.no_grad():
            inputs = torch.cat([strokes, payload[:, None]], dim=-1)
            scaled = (inputs - network.input_centre) / network.input_half_range
            output, slope = _scaled_miss(network, scaled, torch.zeros(2, dtype=torch.float64))
            position = output * network.target_half_range + network.target_centre
            return position, (slope * network.target_half_range / network.input_half_range)[..., :3]

    return tip


@checks.arguments(task=checks.Instance(Task), sag=checks.function)
def sagging_tip(task: Task, sag: SagModel) -> TipModel:
    """Return the rigid tip with a deflection, and the rigid tip's derivative, which is close enough."""

    def tip(strokes: Tensor, payload: Tensor) -> tuple[Tensor, Tensor]:
        return tip_position(strokes, task.crane) + sag(strokes, payload), tip_jacobian(strokes, task.crane)

    return tip


@dataclass(frozen=True)
class GaussNewtonOptions:
    """How to step.

    Attributes
    ----------
    tolerance
        Distance [m] at which a point is left.
    iterations
        Largest number of steps tried.
    damping
        In the beginning, as a share of the squared Jacobian. It falls to a tenth where a step brings a point
        nearer, and grows tenfold where it does not.

    Raises
    ------
    ValueError
        If a number is out of its range.
    """

    tolerance: float = 1e-6
    iterations: int = 100
    damping: float = 1e-3

    def __post_init__(self) -> None:
        checks.fields(self, tolerance=Real(above=0), iterations=Whole(1), damping=Real(above=0))


def gauss_newton(task: Task, tip: TipModel, options: GaussNewtonOptions = GaussNewtonOptions()) -> Placement:
    """Invert a model of the tip by Gauss–Newton steps of least length, each point with a damping of its own.

    A cylinder that would leave its limits stays where it is, and the step is taken with the others.

    Parameters
    ----------
    task
        What is wanted.
    tip
        The model.
    options
        Damping and tolerance.

    References
    ----------
    Levenberg (1944); Nakamura & Hanafusa (1986) for the damped least-squares inverse of a redundant arm.
    """
    checks.instance(task, "task", Task)
    checks.function(tip, "tip")
    checks.instance(options, "options", GaussNewtonOptions)
    strokes = task.starts.clone()
    position, slope = tip(strokes, task.payload)
    miss = task.targets - position
    damping = torch.full((len(task),), options.damping, dtype=torch.float64)
    taken = torch.zeros(len(task), dtype=torch.long)
    for _ in range(options.iterations):
        going = (miss.norm(dim=-1) > options.tolerance).nonzero()[:, 0]
        if not len(going):
            break
        trial = _trial(task, strokes[going], slope[going], miss[going], damping[going], going)
        position, slopes = tip(trial, task.payload[going])
        misses = task.targets[going] - position
        nearer = misses.norm(dim=-1) < miss[going].norm(dim=-1)
        damping[going] *= torch.where(nearer, 0.1, 10.0)
        taken[going] += 1
        moved = going[nearer]
        strokes[moved], miss[moved], slope[moved] = trial[nearer], misses[nearer], slopes[nearer]
    return Placement(strokes, miss.norm(dim=-1) <= options.tolerance, taken)


def _trial(
    task: Task, strokes: Tensor, slope: Tensor, miss: Tensor, damping: Tensor, which: Tensor
) -> Float64[Tensor, "N 3"]:
    """Strokes after a step that keeps to the limits."""
    moving = torch.ones_like(strokes)
    damping = damping * slope.square().sum((-2, -1))
    for _ in range(strokes.shape[1]):
        trial = strokes + _step(slope * moving[:, None], miss, damping)
        beyond = (trial < task.lower[which]) | (trial > task.upper[which])
        moving = torch.where(beyond, 0.0, moving)
    return torch.where(beyond.any(-1, keepdim=True), strokes, trial)


def _step(slope: Tensor, miss: Tensor, damping: Tensor) -> Float64[Tensor, "N 3"]:
    damped = slope @ slope.mT + damping[:, None, None] * torch.eye(2, dtype=slope.dtype)
    return (slope.mT @ torch.linalg.solve(damped, miss[..., None]))[..., 0]
