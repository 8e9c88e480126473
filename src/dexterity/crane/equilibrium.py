"""Equilibrium of structures that turn far, by Newton's method: for the crane, the judge of linear statics.

At rest a structure has the least potential that its constraints allow. Both are written once, as functions of
the coordinates; the forces and the stiffness of a Newton step are their derivatives.

Examples
--------
Vertical deflection of the tip [mm] under 200 kg:

>>> import dexterity as dx
>>> sag = dx.crane.corotational_deflection([0.25, 0.5, 1.0], payload=200.0)
>>> bool(sag.converged), round(1000 * float(sag.deflection[1]))
(True, -22)
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import torch
from jaxtyping import Bool, Float64
from torch import Tensor

from dexterity import checks, spatial
from dexterity.checks import Real, Whole
from dexterity.crane.description import Crane, given_crane
from dexterity.crane.kinematics import require_strokes
from dexterity.crane.structure import Assembly, require_payload
from dexterity.spatial import TensorLike
from dexterity.spatial.values import require_values

__all__ = ["Equilibrium", "NewtonOptions", "Potential", "Sag", "corotational_deflection", "equilibrium"]

Potential: TypeAlias = Callable[[Tensor, float], Tensor]
"""Potential (N) [J] of coordinates (N, n) under a share of the loads."""


@dataclass(frozen=True)
class NewtonOptions:
    """How an equilibrium is sought.

    Attributes
    ----------
    load_steps
        In how many equal steps the loads are put on.
    iterations
        Largest number of Newton steps for each of them.
    tolerance
        A structure has converged where no coordinate changes by more [m] or [rad].

    Raises
    ------
    ValueError
        If a number is out of its range.
    """

    load_steps: int = 1
    iterations: int = 30
    tolerance: float = 1e-10

    def __post_init__(self) -> None:
        checks.fields(self, load_steps=Whole(1), iterations=Whole(1), tolerance=Real(above=0))


@dataclass(frozen=True)
class Equilibrium:
    """Where structures come to rest.

    Attributes
    ----------
    q
        (N, n) coordinates.
    forces
        (N, c) forces of the constraints [N] for constraints in [m].
    converged
        (N) whether each has converged under the whole load.
    iterations
        Newton steps altogether.
    """

    q: Float64[Tensor, "N n"]
    forces: Float64[Tensor, "N c"]
    converged: Bool[Tensor, " N"]
    iterations: int


def equilibrium(
    potential: Potential,
    constraints: Callable[[Tensor], Tensor],
    free: Bool[Tensor, " n"],
    structures: int,
    options: NewtonOptions = NewtonOptions(),
) -> Equilibrium:
    """Find the equilibria of structures under load, from rest.

    Parameters
    ----------
    potential
        Of strain less the work of the loads.
    constraints
        Gaps (N, c) of coordinates (N, n), which are zero in the end.
    free
        Which coordinates may change.
    structures
        Their number N.
    options
        Steps and tolerance.

    Returns
    -------
    An equilibrium that was not found is no error: see `Equilibrium.converged`.

    References
    ----------
    Nocedal & Wright (2006), Numerical optimization, section 18.1: Newton's method on the Lagrangian.
    """
    n = len(free)
    count = constraints(torch.zeros(structures, n, dtype=torch.float64)).shape[1]
    z = torch.zeros(structures, n + count, dtype=torch.float64)
    moving = torch.cat([free, torch.ones(count, dtype=torch.bool)]).nonzero()[:, 0]
    change = torch.full((structures,), torch.inf, dtype=torch.float64)
    taken = 0
    for step in range(1, options.load_steps + 1):
        for _ in range(options.iterations):
            taken += 1
            move = _newton_move(potential, constraints, z, moving, n, step / options.load_steps)
            z = z - move
            change = move[:, :n].abs().amax(-1)
            if (change.isnan() | (change <= options.tolerance)).all():
                break
    return Equilibrium(z[:, :n], z[:, n:], change <= options.tolerance, taken)


def _newton_move(
    potential: Potential,
    constraints: Callable[[Tensor], Tensor],
    z: Tensor,
    moving: Tensor,
    n: int,
    share: float,
) -> Tensor:
    """Newton step (N, n + c) of the Lagrangian; NaN where it is singular."""
    with torch.enable_grad():
        z = z.detach().requires_grad_()
        lagrangian = potential(z[:, :n], share) + (z[:, n:] * constraints(z[:, :n])).sum(-1)
        (slope,) = torch.autograd.grad(lagrangian.sum(), z, create_graph=True)
        picks = torch.eye(z.shape[1], dtype=z.dtype)[moving, None].expand(-1, len(z), -1)
        (curvature,) = torch.autograd.grad(slope, z, picks, is_grads_batched=True)
    matrix = curvature.transpose(0, 1)[:, :, moving]
    solved, failed = torch.linalg.solve_ex(matrix, slope.detach()[:, moving, None])
    move = torch.zeros_like(slope)
    move[:, moving] = torch.where(failed[:, None] > 0, torch.nan, solved[..., 0])
    return move.detach()


# ---- the crane -------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Sag:
    """How far the tip sags.

    Attributes
    ----------
    deflection
        (..., 2) flexible tip less rigid one [m]; NaN where it was not found.
    converged
        (...) whether it was found.
    """

    deflection: Float64[Tensor, "*batch 2"]
    converged: Bool[Tensor, "*batch"]


def corotational_deflection(
    strokes: TensorLike,
    payload: TensorLike,
    crane: Crane | None = None,
    options: NewtonOptions = NewtonOptions(),
) -> Sag:
    """Find how far the tip sags when the structure is let turn with its deflection.

    Beams, pins, rods and pads are those of :func:`~dexterity.crane.structure.deflection`, which takes their
    equilibrium in the unloaded pose; here it is in the loaded one.

    Parameters
    ----------
    strokes, payload, crane
        As there.
    options
        Steps and tolerance of Newton's method.

    Raises
    ------
    ValueError
        As there.

    References
    ----------
    Crisfield (1991), Non-linear finite element analysis of solids and structures, volume 1, chapter 7.
    """
    crane = given_crane(crane)
    strokes, payload = require_values(require_strokes(strokes), "strokes"), require_payload(payload, crane)
    checks.instance(options, "options", NewtonOptions)
    batch = spatial.common_batch(payload=payload.shape, strokes=strokes.shape[:-1])
    with torch.inference_mode(False):  # steps are slopes, which are not taken in that mode
        rows = strokes.detach().cpu().clone().expand(*batch, 3).reshape(-1, 3).split(_POSES_AT_ONCE)
        masses = payload.detach().cpu().clone().expand(batch).reshape(-1).split(_POSES_AT_ONCE)
        assembly = Assembly.of(crane)
        parts = [_sag(assembly, *piece, options) for piece in zip(rows, masses, strict=True)]
    converged = torch.cat([part.converged for part in parts]).to(strokes.device)
    moved = torch.cat([assembly.tip(part.q) for part in parts]).to(strokes.device)
    found = torch.where(converged[:, None], moved, torch.nan)
    return Sag(found.reshape(*batch, 2), converged.reshape(batch))


_POSES_AT_ONCE = 256


def _sag(assembly: Assembly, strokes: Tensor, payload: Tensor, options: NewtonOptions) -> Equilibrium:
    pose = assembly.placed(strokes)
    weight = payload * assembly.crane.structure.gravity

    def potential(q: Tensor, share: float) -> Tensor:
        raised = assembly.gravity_potential(pose, q) + weight * assembly.tip(q)[:, 1]
        return assembly.strain_energy(pose, q) + share * raised

    def constraints(q: Tensor) -> Tensor:
        return assembly.constraints(pose, q)

    return equilibrium(potential, constraints, assembly.free, len(strokes), options)
