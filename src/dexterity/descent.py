r"""Descent of many chains at once to poses of their tools, each from a start of its own.

A step is one of Levenberg and Marquardt's with the damping of Sugihara: with the error e of the tool's twist,

.. math:: \Delta q = J^\top \left(J J^\top + (\tfrac12 e^\top e + \lambda)\, I\right)^{-1} e,

so that far from the pose the step is nearly along the gradient, near it Newton's. The damping has an upper
bound, so that a vehicle comes to a pose far away in few steps. Joints that a step would carry
beyond their limits stay at them, and the others make up for it. Starts that have arrived, and starts that
come no nearer, leave the batch. Lengths are divided by a quarter of the arm's, so that metres and radians
compare.

Examples
--------
>>> import torch
>>> import dexterity as dx
>>> from dexterity.descent import descend
>>> puma = dx.robots.puma560()
>>> T = puma.forward([0.0, 0.5, 0.25, 0.0, 0.5, 0.0])
>>> q, miss = descend(puma, T[None], torch.full((1, 6), 0.3))
>>> bool(miss < 1e-9), bool((puma.forward(q) - T).abs().max() < 1e-9)
(True, True)

References
----------
Sugihara (2011), Solvability-unconcerned inverse kinematics by the Levenberg–Marquardt method, IEEE
Transactions on Robotics 27(5).
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import torch
from jaxtyping import Float64
from torch import Tensor

from dexterity import spatial
from dexterity.chain import Chain
from dexterity.spatial import TensorLike
from dexterity.spatial.poses import inverse_factor

__all__ = ["descend", "length_scale", "remaining_twist"]

_DAMPING = 1e-9
_LARGEST_DAMPING = 0.25  # with more, steps towards poses far away would be tiny
_LARGEST_TURN = 0.7  # [rad] in a step, beyond which the linearisation means nothing
_PATIENCE, _PROGRESS = 5, 0.5  # a start leaves if its error has not been halved in five steps


@torch.no_grad()
def descend(
    chain: Chain,
    T_world_tool: TensorLike,
    start: TensorLike,
    *,
    rows: Sequence[int] = range(6),
    steps: int = 40,
    tolerance: float = 1e-10,
) -> tuple[Float64[Tensor, "k n"], Float64[Tensor, " k"]]:
    """Bring tools to poses, each from one start, and say how much is missing.

    Parameters
    ----------
    chain
        A chain; its limits are respected throughout, ends included. Joints that turn all the way round are
        led from one end to the other.
    T_world_tool
        (k, 4, 4) wanted poses of the tool.
    start
        (k, n) joint values to start from, [rad] or [m].
    rows
        Which components of the remaining twist must vanish, 0–2 of its translation and 3–5 of its rotation,
        along the axes of the tool; 0–4 leave the turn about its z axis free.
    steps
        Largest number of steps.
    tolerance
        Miss with which a start has arrived.

    Returns
    -------
    Joint values (k, n), and how far each is from its pose (k): the norm of the remaining twist, lengths
    divided by :func:`length_scale`. Where it is not small, the values are those at which the start gave up.

    Raises
    ------
    ValueError
        If a shape does not fit, a pose is not rigid, or something is not finite.
    """
    T = spatial.require_rigid(T_world_tool, "T_world_tool")
    q = spatial.require_joints(spatial.to_float64(start, "start"), chain.joints, "chain")
    if T.ndim != 3:
        raise ValueError(f"T_world_tool has shape {tuple(T.shape)}; (k, 4, 4) is needed")
    if q.shape[:-1] != T.shape[:1]:
        raise ValueError(f"start has shape {tuple(q.shape)}; ({len(T)}, {chain.joints}) is needed")
    chosen, stay = list(rows), _Limits(chain, q.device)
    q, at = stay.within(q), torch.arange(len(q), device=q.device)
    ends, misses = q.clone(), q.new_full((len(q),), math.inf)
    earlier = misses.clone()
    weights = q.new_tensor([1 / length_scale(chain)] * 3 + [1.0] * 3)[chosen]
    identity = torch.eye(len(chosen), dtype=q.dtype, device=q.device)
    for step in range(steps + 1):
        twist = remaining_twist(chain.forward(q), T)
        error = weights * twist[:, chosen]
        miss = error.square().sum(-1)
        leaves = miss < tolerance**2
        if step == steps:
            leaves = torch.ones_like(leaves)
        elif step % _PATIENCE == 0:
            leaves = leaves | (miss > _PROGRESS**2 * earlier)
            earlier = miss
        if leaves.any():
            ends[at[leaves]], misses[at[leaves]] = q[leaves], miss[leaves].sqrt()
            q, T, at, twist, error, miss, earlier = (
                x[~leaves] for x in (q, T, at, twist, error, miss, earlier)
            )
            if not len(q):
                break
        J = weights[:, None] * _twist_jacobian(chain.body_jacobian(q), twist, chosen)[:, chosen]
        damping = ((miss / 2).clamp(max=_LARGEST_DAMPING) + _DAMPING)[:, None, None] * identity
        q = stay.moved(q, J, error, damping)
    return ends, misses


def length_scale(chain: Chain) -> float:
    """Return a quarter of the length of all links [m], by which errors of lengths are divided; 1 for none."""
    length = float(chain.link_transforms[1:, :3, 3].norm(dim=-1).sum())
    return length / 4 if length > 0 else 1.0


class _Limits:
    """Limits of a chain's joints as a step meets them."""

    def __init__(self, chain: Chain, device: torch.device) -> None:
        self.lower, self.upper = chain.lower.to(device), chain.upper.to(device)
        self._revolute = torch.tensor([kind == "revolute" for kind in chain.kinds], device=device)
        # Rounding of limits in degrees must not make a joint that turns all the way round one that does not.
        self.endless = self._revolute & (self.upper - self.lower >= math.tau - 1e-9)
        # About a limit that stands alone, half a turn inside of it; about 0 where there is none.
        lower = torch.where(self.lower.isinf(), self.upper - math.tau, self.lower)
        upper = torch.where(self.upper.isinf(), lower + math.tau, self.upper)
        middle = (lower + upper) / 2
        self._middle = torch.where(middle.isfinite(), middle, 0.0)

    def within(self, q: Tensor) -> Tensor:
        turned = q - math.tau * torch.round((q - self._middle) / math.tau)
        q = torch.where(self.endless, turned, q)
        return torch.minimum(torch.maximum(q, self.lower), self.upper)

    def moved(self, q: Tensor, J: Tensor, error: Tensor, damping: Tensor) -> Tensor:
        """Make a step (k, n); where joints would leave their limits, the step is that of the others."""
        step = _damped_step(J, error, damping)
        aim = q + self._shortened(step)
        leaving = ~self.endless & ((aim < self.lower) | (aim > self.upper))
        held = leaving.any(-1)
        if held.any():
            fixed = leaving[held]
            others = _damped_step(J[held].masked_fill(fixed[:, None], 0.0), error[held], damping[held])
            step[held] = torch.where(fixed, step[held], others)
        return self.within(q + self._shortened(step))

    def _shortened(self, step: Tensor) -> Tensor:
        return torch.where(self._revolute, step.clamp(-_LARGEST_TURN, _LARGEST_TURN), step)


def _damped_step(J: Tensor, error: Tensor, damping: Tensor) -> Tensor:
    inner = torch.baddbmm(damping, J, J.mT)
    return (J.mT @ torch.linalg.solve(inner, error[:, :, None]))[:, :, 0]


def _twist_jacobian(J: Tensor, twist: Tensor, rows: list[int]) -> Tensor:
    """Return the derivatives (k, 6, n) of the remaining twist, but for their sign.

    Where all three rows of a block count, the body Jacobian leads to the pose as well and costs less.
    Where one is free, the others must be right even if the free one is far from zero.
    """
    v, omega = J[:, :3], J[:, 3:]
    if 0 < len({0, 1, 2} & set(rows)) < 3:
        v = v - spatial.hat(twist[:, :3]) @ omega
    if 0 < len({3, 4, 5} & set(rows)) < 3:
        phi = twist[:, 3:]
        W = spatial.hat(phi)
        factor = inverse_factor(phi.square().sum(-1).clamp(max=math.pi**2))[:, None, None]
        omega = omega - W @ omega / 2 + factor * (W @ (W @ omega))
    return torch.cat([v, omega], dim=1)


def remaining_twist(T: Tensor, wanted: Tensor) -> Tensor:
    """Return translation and rotation vector (k, 6) from poses to wanted ones, along axes of the tool."""
    R = T[:, :3, :3].mT @ wanted[:, :3, :3]
    shift = (T[:, :3, :3].mT @ (wanted[:, :3, 3] - T[:, :3, 3])[:, :, None])[:, :, 0]
    skew = torch.stack([R[:, 2, 1] - R[:, 1, 2], R[:, 0, 2] - R[:, 2, 0], R[:, 1, 0] - R[:, 0, 1]], -1)
    sine, cosine = skew.norm(dim=-1), R.diagonal(dim1=-2, dim2=-1).sum(-1) - 1
    # At half a turn the skew part vanishes and any axis does for a step: the next one is not at half a turn.
    angle = torch.where(sine > 0, torch.atan2(sine, cosine) / sine.clamp(min=1e-300), 0.5)
    half_turn = (cosine < 0) & (sine < 1e-9)
    rotation = torch.where(half_turn[:, None], math.pi * _some_axis(R), angle[:, None] * skew)
    return torch.cat([shift, rotation], -1)


def _some_axis(R: Tensor) -> Tensor:
    """Axis (k, 3) of half a turn: the column of R + I that is longest."""
    columns = R + torch.eye(3, dtype=R.dtype, device=R.device)
    longest = columns.norm(dim=-2).argmax(-1)
    axis = columns[torch.arange(len(R), device=R.device), :, longest]
    return axis / axis.norm(dim=-1, keepdim=True).clamp(min=1e-300)
