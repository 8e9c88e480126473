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
from dataclasses import dataclass
from typing import Literal, TypeAlias

import torch
from jaxtyping import Float64
from torch import Tensor

from dexterity import spatial
from dexterity.chain import Chain
from dexterity.spatial import TensorLike
from dexterity.spatial.poses import inverse_factor

__all__ = ["RowFrame", "TwistRows", "descend", "length_scale"]

RowFrame: TypeAlias = Literal["body", "geometric"]
"""Axes of rows, those of the tool or those of the world, with the words of an index's frame."""

_DAMPING = 1e-13  # small, so that poses at singular configurations are met to the last digits
_LARGEST_DAMPING = 0.25  # with more, steps towards poses far away would be tiny
_LARGEST_TURN = 0.7  # [rad] in a step, beyond which the linearisation means nothing
_PATIENCE, _PROGRESS = 5, 0.5  # a start leaves if its error has not been halved in five steps


@dataclass(frozen=True)
class TwistRows:
    """Components of the twist that remains to a wanted pose, and the axes along which they are.

    Attributes
    ----------
    numbers
        Of the rows, 0–2 of the translation and 3–5 of the rotation vector.
    frame
        ``"body"`` for axes of the tool, ``"geometric"`` for axes of the world; where all three rows of a kind
        count, it makes no difference.
    """

    numbers: tuple[int, ...] = (0, 1, 2, 3, 4, 5)
    frame: RowFrame = "body"

    def remaining(self, T: Tensor, wanted: Tensor) -> Tensor:
        """Return translations and rotation vectors (k, 6) from poses to wanted ones, along the axes."""
        R = T[:, :3, :3].mT @ wanted[:, :3, :3]
        shift = (T[:, :3, :3].mT @ (wanted[:, :3, 3] - T[:, :3, 3])[:, :, None])[:, :, 0]
        twist = torch.stack([shift, _rotation_vector(R)], 1)
        if self.frame == "geometric":
            twist = twist @ T[:, :3, :3].mT
        return twist.flatten(1)

    def jacobian(self, chain: Chain, q: Tensor, twist: Tensor) -> Tensor:
        """Return the derivatives (k, m, n) of the remaining rows, but for their sign.

        Where all three rows of a block count, the Jacobian leads to the pose as well and costs less.
        Where one is free, the others must be right even if the free one is far from zero.
        """
        body = self.frame == "body"
        J = chain.body_jacobian(q) if body else chain.geometric_jacobian(q)
        v, omega = J[:, :3], J[:, 3:]
        if body and self._in_part(0, 1, 2):
            v = v - spatial.hat(twist[:, :3]) @ omega
        if self._in_part(3, 4, 5):
            phi = twist[:, 3:]
            W = spatial.hat(phi if body else -phi)
            factor = inverse_factor(phi.square().sum(-1).clamp(max=math.pi**2))[:, None, None]
            omega = omega - W @ omega / 2 + factor * (W @ (W @ omega))
        return torch.cat([v, omega], dim=1)[:, list(self.numbers)]

    def _in_part(self, *block: int) -> bool:
        return 0 < len(set(block) & set(self.numbers)) < 3


@torch.no_grad()
def descend(
    chain: Chain,
    T_world_tool: TensorLike,
    start: TensorLike,
    *,
    rows: Sequence[int] = range(6),
    frame: RowFrame = "body",
    steps: int = 40,
    tolerance: float = 1e-10,
    limits: Literal["kept", "approached"] = "kept",
) -> tuple[Float64[Tensor, "k n"], Float64[Tensor, " k"]]:
    """Bring tools to poses, each from one start, and say how much is missing.

    Parameters
    ----------
    chain
        A chain. Joints that turn all the way round are led from one end of their limits to the other.
    T_world_tool
        (k, 4, 4) wanted poses of the tool.
    start
        (k, n) joint values to start from, [rad] or [m].
    rows
        Which components of the remaining twist must vanish, 0–2 of its translation and 3–5 of its rotation;
        0–4 leave the turn about the z axis free.
    frame
        Axes of the rows: ``"body"`` for those of the tool, ``"geometric"`` for those of the world.
    steps
        Largest number of steps.
    tolerance
        Miss with which a start has arrived.
    limits
        ``"kept"``: limits are respected throughout, ends included. ``"approached"``: they may be exceeded on
        the way, and what exceeds them at the end is part of the miss.

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
    counted = TwistRows(tuple(rows), frame)
    stay = (_Limits if limits == "kept" else _Approached)(chain, q.device)
    q, at = stay.within(q), torch.arange(len(q), device=q.device)
    ends, misses = q.clone(), q.new_full((len(q),), math.inf)
    earlier = misses.clone()
    weights = q.new_tensor([1 / length_scale(chain)] * 3 + [1.0] * 3)[list(counted.numbers)]
    for step in range(steps + 1):
        twist = counted.remaining(chain.forward(q), T)
        error = torch.cat([weights * twist[:, counted.numbers], stay.excess(q)], 1)
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
        J = torch.cat([weights[:, None] * counted.jacobian(chain, q, twist), stay.slopes(q)], 1)
        q = stay.moved(q, J, error, (miss / 2).clamp(max=_LARGEST_DAMPING) + _DAMPING)
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
        """Lead endless joints round, and the others to their limits."""
        q = torch.where(self.endless, self._turned(q), q)
        return torch.minimum(torch.maximum(q, self.lower), self.upper)

    def _turned(self, q: Tensor) -> Tensor:
        return q - math.tau * torch.round((q - self._middle) / math.tau)

    def excess(self, q: Tensor) -> Tensor:
        """Return errors (k, e) of joints beyond their limits; none, for joint values that keep them."""
        return q[:, :0]

    def slopes(self, q: Tensor) -> Tensor:
        """Return the derivatives (k, e, n) of the excess, but for their sign."""
        return q.new_zeros(len(q), 0, q.shape[1])

    def moved(self, q: Tensor, J: Tensor, error: Tensor, damping: Tensor) -> Tensor:
        """Make a step (k, n); where joints would leave their limits, the step is that of the others."""
        step = _damped_step(J, error, damping)
        held = torch.zeros_like(q, dtype=torch.bool)
        for _ in range(q.shape[1]):
            aim = q + self._shortened(step)
            leaving = ~self.endless & ~held & ((aim < self.lower) | (aim > self.upper))
            more = leaving.any(-1)
            if not more.any():
                break
            # A joint that is held goes as far as its limit; its step is no longer part of what others do.
            held |= leaving
            fixed = held[more]
            others = _damped_step(J[more].masked_fill(fixed[:, None], 0.0), error[more], damping[more])
            step[more] = torch.where(fixed, step[more], others)
        return self.within(q + self._shortened(step))

    def _shortened(self, step: Tensor) -> Tensor:
        return torch.where(self._revolute, step.clamp(-_LARGEST_TURN, _LARGEST_TURN), step)


class _Approached(_Limits):
    """Limits that a step may exceed, at the price of an error."""

    def __init__(self, chain: Chain, device: torch.device) -> None:
        super().__init__(chain, device)
        self._weights = torch.where(self._revolute, 1.0, 1 / length_scale(chain)).double()

    def within(self, q: Tensor) -> Tensor:
        """Turn joints to the copy nearest to the middle of their limits."""
        return torch.where(self._revolute, self._turned(q), q)

    def excess(self, q: Tensor) -> Tensor:
        return self._weights * (torch.minimum(torch.maximum(q, self.lower), self.upper) - q)

    def slopes(self, q: Tensor) -> Tensor:
        return torch.diag_embed(torch.where(self.excess(q) != 0, self._weights, 0.0))

    def moved(self, q: Tensor, J: Tensor, error: Tensor, damping: Tensor) -> Tensor:
        return self.within(q + self._shortened(_damped_step(J, error, damping)))


def _damped_step(J: Tensor, error: Tensor, damping: Tensor) -> Tensor:
    identity = torch.eye(J.shape[1], dtype=J.dtype, device=J.device)
    inner = torch.baddbmm(damping[:, None, None] * identity, J, J.mT)
    return (J.mT @ torch.linalg.solve(inner, error[:, :, None]))[:, :, 0]


def _rotation_vector(R: Tensor) -> Tensor:
    """Rotation vectors (k, 3) of rotations, and of half a turn about any axis that does for a step."""
    skew = torch.stack([R[:, 2, 1] - R[:, 1, 2], R[:, 0, 2] - R[:, 2, 0], R[:, 1, 0] - R[:, 0, 1]], -1)
    sine, cosine = skew.norm(dim=-1), R.diagonal(dim1=-2, dim2=-1).sum(-1) - 1
    # At half a turn the skew part vanishes: the next step is not at half a turn.
    angle = torch.where(sine > 0, torch.atan2(sine, cosine) / sine.clamp(min=1e-300), 0.5)
    half_turn = (cosine < 0) & (sine < 1e-9)
    return torch.where(half_turn[:, None], math.pi * _some_axis(R), angle[:, None] * skew)


def _some_axis(R: Tensor) -> Tensor:
    """Axis (k, 3) of half a turn: the column of R + I that is longest."""
    columns = R + torch.eye(3, dtype=R.dtype, device=R.device)
    longest = columns.norm(dim=-2).argmax(-1)
    axis = columns[torch.arange(len(R), device=R.device), :, longest]
    return axis / axis.norm(dim=-1, keepdim=True).clamp(min=1e-300)
