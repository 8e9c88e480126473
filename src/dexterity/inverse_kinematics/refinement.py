"""Newton steps on the pose: they take off rounding near double roots, and what a description misses.

Examples
--------
>>> import torch
>>> import dexterity as dx
>>> from dexterity.inverse_kinematics.refinement import polished
>>> puma = dx.robots.puma560()
>>> q = torch.tensor([[0.0, 0.5, 0.25, 0.0, 0.5, 0.0]], dtype=torch.float64)
>>> _, valid, residual = polished(puma, q + 1e-6, puma.forward(q), size=1.0)
>>> bool(valid), float(residual) < 1e-10
(True, True)
"""

from __future__ import annotations

import functools
import math

import torch
from torch import Tensor

from dexterity import spatial
from dexterity.chain import Chain
from dexterity.descent import descend
from dexterity.spatial.tolerances import ROUNDING

__all__ = ["arm_size", "polished", "pose_miss"]

_DIGITS = 1e-12  # a miss below this needs no step
_REACH = 0.1  # miss from which a branch is improved where the description is right to six digits


def arm_size(arm: Chain) -> float:
    """Sum of the lengths of the links [m], at least 1: what misses of positions are relative to."""
    return max(1.0, float(arm.link_transforms[:, :3, 3].norm(dim=-1).sum()))


def polished(
    arm: Chain, q: Tensor, T: Tensor, size: float, miss: float = 0.0, tolerance: float = ROUNDING
) -> tuple[Tensor, Tensor, Tensor]:
    """Improve joint values (..., n) by Newton, and tell which (...) are at the pose, and their misses (...).

    `miss` is by how much the description of the arm misses the conditions of the closed form that gave `q`.
    An arm that misses none needs one step near double roots alone.
    """
    q, T = spatial.wrap_to_pi(q), T.expand(*q.shape[:-1], 4, 4)
    off = pose_miss(arm, q, T, size)
    exact = miss <= ROUNDING
    near = (off > _DIGITS) & (off < (math.sqrt(ROUNDING) if exact else _REACH))
    if exact:
        moved = q[near] + _newton_step(arm, q[near], T[near])
    else:
        # Near a singular configuration a small miss of the description moves the joints far.
        moved, _ = descend(_without_limits(arm), T[near].detach(), q[near].detach(), tolerance=_DIGITS)
        if T.requires_grad:
            # The descent has no gradient; a step of Newton at its end has that of the configuration.
            moved = moved + _newton_step(arm, moved, T[near])
    q[near] = spatial.wrap_to_pi(moved)
    off[near] = pose_miss(arm, q[near], T[near], size)
    return q, off <= tolerance, off


@functools.lru_cache(maxsize=8)
def _without_limits(arm: Chain) -> Chain:
    with torch.device("cpu"):
        return Chain(arm.screws, arm.home, name=arm.name)


def pose_miss(arm: Chain, q: Tensor, T: Tensor, size: float) -> Tensor:
    """Largest miss (...) of a pose, positions relative to the size of the arm."""
    away = (arm.forward(q) - T).abs()
    return torch.maximum(away[..., :3, :3].amax((-2, -1)), away[..., :3, 3].amax(-1) / size)


def _newton_step(arm: Chain, q: Tensor, T: Tensor) -> Tensor:
    J = arm.body_jacobian(q)
    twist = spatial.log(spatial.compose(spatial.inverse(arm.forward(q)), T))
    # Damped, since the wrist is singular where branches coincide.
    damping = _DIGITS * torch.eye(J.shape[-1], dtype=J.dtype, device=J.device)
    return torch.linalg.solve(J.mT @ J + damping, (J.mT @ twist[..., None]))[..., 0]
