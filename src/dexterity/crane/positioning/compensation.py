"""Aiming off by what the crane will sag: the thesis's first method, and the same until nothing changes.

The rigid crane is brought to the target, what it sags there is taken off the target, and it is brought to
that. The thesis does so once, with a network for the sag and a genetic algorithm for the rigid crane. Done a
few times with the structure itself, it is exact.

Examples
--------
>>> from dexterity.crane import positioning
>>> task = positioning.thesis_task(points=[[4.0, 0.0], [5.0, 2.0]], payloads=[100.0])
>>> rigid = positioning.errors(task, positioning.uncompensated(task))
>>> aimed = positioning.errors(
...     task, positioning.compensate(task, positioning.linear_sag())
... )
>>> bool(aimed.largest[2] < rigid.largest[2] / 10)
True
"""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Callable
from typing import TypeAlias

import torch
from torch import Tensor

from dexterity import checks
from dexterity.crane.kinematics import FARTHEST, inverse, least_extension, tip_position
from dexterity.crane.positioning.genetic import GeneticInverseOptions, genetic_inverse
from dexterity.crane.positioning.task import Placement, SagModel, Task
from dexterity.networks.feed_forward import FeedForward
from dexterity.spatial.values import on_cpu

__all__ = [
    "RigidInverse",
    "by_inverse_network",
    "compensate",
    "exact_inverse",
    "genetic",
    "network_sag",
    "uncompensated",
]

RigidInverse: TypeAlias = Callable[[Task, Tensor], Placement]
"""Strokes that bring the rigid tip to positions (N, 2), from the starts and within the limits of a task."""


@checks.arguments(task=checks.Instance(Task))
def exact_inverse(task: Task, positions: Tensor) -> Placement:
    """Solve the rigid crane in closed form, elbow up, with the start's extension or the least that reaches.

    What cannot be reached is NaN and flagged.
    """
    positions = on_cpu(positions, "positions")
    if positions.shape != task.targets.shape:
        raise ValueError(
            f"positions has shape {tuple(positions.shape)}; {tuple(task.targets.shape)} is needed"
        )
    if (positions.abs() > FARTHEST).any():
        raise ValueError(f"positions holds numbers beyond {FARTHEST:g} m")
    extension = torch.maximum(task.starts[:, 2], least_extension(positions, task.crane))
    reach = inverse(positions, extension, task.crane)
    within = reach.reached & task.allows(reach.strokes.nan_to_num())
    return Placement(reach.strokes, within, torch.ones(len(task), dtype=torch.long))


@checks.arguments(
    generator=checks.Instance(torch.Generator), options=checks.OrNone(checks.Instance(GeneticInverseOptions))
)
def genetic(generator: torch.Generator, options: GeneticInverseOptions | None = None) -> RigidInverse:
    """Return the thesis's genetic algorithm as a way to solve the rigid crane; None for its own options."""
    chosen = options or GeneticInverseOptions()
    return lambda task, positions: genetic_inverse(task, positions, generator, chosen)


@checks.arguments(network=checks.Instance(FeedForward))
def network_sag(network: FeedForward) -> SagModel:
    """Return a correction network as a deflection."""
    return functools.partial(_sag_of, network)


def _sag_of(network: FeedForward, strokes: Tensor, payload: Tensor) -> Tensor:
    with torch.no_grad():
        return network(torch.cat([strokes, payload[:, None]], dim=-1))


@checks.arguments(task=checks.Instance(Task))
def uncompensated(task: Task) -> Placement:
    """Bring the rigid crane to the targets, elbow up with the least extension, whatever it sags."""
    reach = inverse(task.targets, crane=task.crane)
    within = reach.reached & task.allows(reach.strokes.nan_to_num())
    return Placement(reach.strokes, within, torch.ones(len(task), dtype=torch.long))


def compensate(
    task: Task,
    sag: SagModel,
    rigid_inverse: RigidInverse = exact_inverse,
    corrections: int = 1,
    tolerance: float = 0.0,
) -> Placement:
    """Aim off by the sag, once as the thesis does or until the tip stays.

    Parameters
    ----------
    task
        What is wanted.
    sag
        The deflection: a network's, a regression's, a structure's.
    rigid_inverse
        How the rigid crane is solved; :func:`exact_inverse` or :func:`genetic`.
    corrections
        Largest number of times that the aim is changed, up to 10 000; a tip that stays is left at once.
    tolerance
        Distance [m] from its target at which the tip, by this very sag, is near enough to stop.

    Returns
    -------
    Its iterations are corrections; it has converged where the rigid crane was solved and, if there is a
    tolerance, the tip by this sag is within it.

    Raises
    ------
    ValueError
        If there is no correction, or the rigid crane does not reach where it is to aim.

    References
    ----------
    Rouvinen (1999), section 4.1, Fig. 4.7.
    """
    checks.instance(task, "task", Task)
    checks.function(sag, "sag")
    checks.function(rigid_inverse, "rigid_inverse")
    corrections = checks.whole(corrections, "corrections", least=1, most=_MOST_CORRECTIONS)
    tolerance = checks.real(tolerance, "tolerance", least=0)
    placement = rigid_inverse(task, task.targets)
    taken = torch.zeros(len(task), dtype=torch.long)
    for _ in range(corrections):
        deflection = sag(_reached(placement, task.targets), task.payload)
        far = _miss(task, placement.strokes, deflection) > tolerance
        if not far.any():
            break
        current = dataclasses.replace(task, starts=placement.strokes)
        solved = rigid_inverse(current, task.targets - deflection)
        strokes = torch.where(far[:, None], solved.strokes, placement.strokes)
        stays = corrections > 1 and torch.equal(strokes, placement.strokes)
        placement = Placement(strokes, torch.where(far, solved.converged, placement.converged), taken)
        taken = taken + far
        if stays:
            break
    strokes = _reached(placement, task.targets)
    near = tolerance == 0 or _miss(task, strokes, sag(strokes, task.payload)) <= tolerance
    return Placement(strokes, placement.converged & near, taken)


_MOST_CORRECTIONS = 10_000


def _reached(placement: Placement, targets: Tensor) -> Tensor:
    lost = placement.strokes.isnan().any(-1)
    if lost.any():
        raise ValueError(
            f"targets holds {targets[lost][0].tolist()}, for which the rigid crane cannot be aimed off"
        )
    return placement.strokes


def _miss(task: Task, strokes: Tensor, deflection: Tensor) -> Tensor:
    return (tip_position(strokes, task.crane) + deflection - task.targets).norm(dim=-1)


@checks.arguments(task=checks.Instance(Task), network=checks.Instance(FeedForward))
def by_inverse_network(task: Task, network: FeedForward) -> Placement:
    """Ask an inverse network for s1 and s2, given the least extension that the rigid crane needs (method 4).

    Nothing is solved, so nothing can fail to converge.

    References
    ----------
    Rouvinen (1999), section 4.4.
    """
    extension = least_extension(task.targets, task.crane)[:, None]
    with torch.no_grad():
        pair = network(torch.cat([task.targets, task.payload[:, None], extension], dim=-1))
    count = len(task)
    return Placement(
        torch.cat([pair, extension], dim=-1),
        torch.ones(count, dtype=torch.bool),
        torch.ones(count, dtype=torch.long),
    )
