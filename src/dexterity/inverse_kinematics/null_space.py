r"""Motion that leaves the tool where it is, and pseudo-inverses with damping and weights.

Joint rates :math:`W^{-1} J^\top (J W^{-1} J^\top + \lambda^2 I)^{-1} \dot x` reach a tool velocity with the
least :math:`\dot q^\top W \dot q`; the damping λ bounds them near a singularity.

Examples
--------
>>> import dexterity as dx
>>> from dexterity.inverse_kinematics import null_space_step
>>> panda = dx.robots.load("panda")
>>> w = dx.indices.Index("manipulability").bind(panda)
>>> q = [0.5, -0.7, 0.6, -2.3, 0.3, 1.7, 0.5]
>>> better = null_space_step(panda, q, w, gain=0.05)
>>> float(w(better)) > float(w(q))
True
>>> bool((panda.forward(better) - panda.forward(q)).abs().max() < 1e-9)
True

References
----------
Liégeois (1977), Automatic supervisory control of the configuration and behavior of multibody mechanisms;
Nakamura & Hanafusa (1986), Inverse kinematic solutions with singularity robustness; Whitney (1969) for the
weights.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeAlias, get_args

import torch
from jaxtyping import Float64
from torch import Tensor

from dexterity import checks, spatial
from dexterity.chain import Chain
from dexterity.descent import RowFrame, TwistRows
from dexterity.indices.rows import Rows, row_numbers
from dexterity.spatial import TensorLike
from dexterity.spatial.tolerances import ROUNDING
from dexterity.spatial.values import beside, require_values

__all__ = ["Objective", "damped_pseudo_inverse", "null_space_projector", "null_space_step", "slope"]

Objective: TypeAlias = Callable[[Tensor], Tensor]
"""Values (...) of joint values (..., n); larger is better. An index, bound or compiled, is one."""

_HALVINGS = 8
_LARGEST_DAMPING = 1e150  # its square is finite
_NEWTON_STEPS, _NEWTON_DIGITS, _NEWTON_DAMPING = 12, 1e-13, 1e-13


def damped_pseudo_inverse(
    J: TensorLike, damping: float = 0.0, weights: TensorLike | None = None
) -> Float64[Tensor, "*batch n m"]:
    r"""Weighted, damped pseudo-inverse :math:`W^{-1} J^\top (J W^{-1} J^\top + \lambda^2 I)^{-1}`.

    Parameters
    ----------
    J
        (..., m, n) Jacobians.
    damping
        λ, not negative, in the unit of singular values. 0 leaves out singular values that are zero to
        rounding: the Moore–Penrose inverse for equal weights.
    weights
        (n,) or (..., n) positive costs of joint motion; 1 by default, ``math.inf`` locks a joint. 1/rate²
        makes joints move in proportion to what they can.

    Raises
    ------
    ValueError
        If a shape does not fit, `J` is not finite, the damping is negative, or a weight is not positive.
    """
    J = spatial.to_float64(J, "J")
    if J.ndim < 2:
        raise ValueError(f"J has shape {tuple(J.shape)}; (..., rows, joints) is needed")
    damping = checks.real(damping, "damping", least=0, most=_LARGEST_DAMPING)
    ease = _ease(weights, J)
    scaled = J * ease[..., None, :]
    if damping > 0:
        identity = torch.eye(J.shape[-2], dtype=J.dtype, device=J.device)
        inner = scaled @ scaled.mT + damping**2 * identity
        return ease[..., :, None] * torch.linalg.solve(inner, scaled).mT
    return ease[..., :, None] * torch.linalg.pinv(scaled)


def null_space_projector(J: TensorLike, weights: TensorLike | None = None) -> Float64[Tensor, "*batch n n"]:
    """Matrix I − J⁺J that takes out of joint rates what moves the tool.

    Parameters
    ----------
    J
        (..., m, n) Jacobians.
    weights
        As for :func:`damped_pseudo_inverse`; a joint with an infinite weight does not move.

    Raises
    ------
    ValueError
        As :func:`damped_pseudo_inverse`.
    """
    J = spatial.to_float64(J, "J")
    inverse = damped_pseudo_inverse(J, 0.0, weights)
    free = (_ease(weights, J) > 0).to(J.dtype).expand(*J.shape[:-2], J.shape[-1])
    return torch.diag_embed(free) - inverse @ (J * free[..., None, :])


def null_space_step(
    chain: Chain,
    q: TensorLike,
    objective: Objective | TensorLike,
    *,
    gain: float = 0.1,
    pose: TensorLike | None = None,
    rows: Rows = "full",
    frame: RowFrame = "body",
    weights: TensorLike | None = None,
) -> Float64[Tensor, "*batch n"]:
    """Move joints along a gradient while the tool stays at its pose and the joints within their limits.

    The step is gain · N W⁻¹ g with the projector N of the null space and the gradient g. Joints at a
    limit that it would push outwards are held. What the tool has moved is then taken back by a descent,
    and a step after which that does not succeed is halved.

    Parameters
    ----------
    chain
        A chain with more joints than rows. Joints whose rate is zero do not move.
    q
        (..., n) joint values, [rad] or [m], within the limits.
    objective
        What to increase: an index, plain, bound or compiled; any function of joint values (..., n) that
        torch can differentiate; or its gradient (..., n).
    gain
        Length of the step relative to the projected gradient; positive.
    pose
        (..., 4, 4) pose to hold; that of `q` by default. Give it where steps follow each other.
    rows
        Which components of the tool's twist are held: names or numbers.
    frame
        Axes of the rows: ``"body"`` for those of the tool, ``"geometric"`` for those of the world.
    weights
        (n,) positive costs of joint motion; 1 by default, ``math.inf`` holds a joint.

    Returns
    -------
    (..., n) joint values: the tool is at the pose to 1e-9, and all joints are within their
    limits. Where no step holds the pose, `q` itself.

    Raises
    ------
    ValueError
        If a shape does not fit, something is not finite, `gain` is not positive, or `q` is beyond a limit.
    """
    checks.instance(chain, "chain", Chain)
    q = spatial.require_joints(spatial.to_float64(q, "q"), chain.joints, "chain")
    q = require_values(q, "q").detach()
    gain = checks.real(gain, "gain", above=0)
    beyond = (q < chain.lower.to(q.device) - ROUNDING) | (q > chain.upper.to(q.device) + ROUNDING)
    if beyond.any():
        left = [
            name
            for name, is_left in zip(chain.joint_names, beyond.reshape(-1, chain.joints).any(0), strict=True)
            if is_left
        ]
        raise ValueError(
            f"q is beyond the limits of the chain at {', '.join(left)}; a step starts within them"
        )
    if callable(objective) or isinstance(objective, str):
        gradient = slope(bound_objective(chain, objective, "objective"), q)
    else:
        with q.device:  # where arrays go as well
            gradient = beside(objective, "objective", q)
    if gradient.shape != q.shape:
        raise ValueError(
            f"objective has a gradient of shape {tuple(gradient.shape)}; {tuple(q.shape)} is needed"
        )
    held = chain.forward(q) if pose is None else spatial.require_rigid(beside(pose, "pose", q), "pose")
    held = held.expand(*q.shape[:-1], 4, 4)
    flat = q.reshape(-1, chain.joints)
    checks.choice(frame, "frame", get_args(RowFrame))
    counted = TwistRows(row_numbers(rows), frame)
    direction = null_direction(chain, flat, gradient.reshape(flat.shape), counted, weights)
    moved = held_step(chain, flat, gain * direction, held.reshape(-1, 4, 4), counted, weights)
    return moved.reshape(q.shape)


def bound_objective(chain: Chain, objective: Any, name: str) -> Objective:
    """Return a function of joint values; an index is bound to the chain.

    Raises
    ------
    TypeError
        If it is no function.
    """
    if isinstance(objective, str):
        index = f"dexterity.Index({objective!r}, 'geometric')"
        raise TypeError(f"{name} is {objective!r}; an index is needed, such as {index}")
    bind = getattr(objective, "bind", None)
    return checks.function(objective if bind is None else bind(chain), name)


def slope(objective: Objective, q: Float64[Tensor, "*batch n"]) -> Float64[Tensor, "*batch n"]:
    """Gradient of an objective, by its own ``value_and_gradient`` if it has one, else by torch.

    Raises
    ------
    ValueError
        If torch cannot differentiate it, or the gradient is not finite.
    """
    own: Any = getattr(objective, "value_and_gradient", None)
    if own is not None:
        return spatial.to_float64(own(q)[1], "gradient of the objective")
    _, gradient = spatial.value_and_gradient(objective, q, "objective")
    return spatial.to_float64(gradient, "gradient of the objective")


def null_direction(
    chain: Chain, q: Tensor, gradient: Tensor, rows: TwistRows, weights: TensorLike | None
) -> Tensor:
    """Directions (N, n) in the null space in which objectives rise, and that no limit stops at once."""
    J = rows.jacobian(chain, q, q.new_zeros(len(q), 6))
    lower, upper = chain.lower.to(q.device), chain.upper.to(q.device)
    ease = _ease(weights, J).expand_as(q) * (chain.rates.to(q.device) > 0)
    # Holding joints changes where the others go: as many rounds as joints may be needed.
    for _ in range(chain.joints):
        costs = torch.where(ease > 0, ease.clamp(min=1e-300) ** -2, torch.inf)
        projector = null_space_projector(J, costs)
        direction = (projector @ (ease.square() * gradient)[..., None])[..., 0]
        outwards = ((q >= upper) & (direction > 0)) | ((q <= lower) & (direction < 0))
        if not outwards.any():
            break
        ease = ease.masked_fill(outwards, 0.0)
    return direction.masked_fill(outwards, 0.0)


def held_step(
    chain: Chain, q: Tensor, step: Tensor, pose: Tensor, rows: TwistRows, weights: TensorLike | None
) -> Tensor:
    """Return q + step (N, n) brought back to poses (N, 4, 4) within the limits, halved where that fails."""
    ease = _ease(weights, step).expand_as(q) * (chain.rates.to(q.device) > 0)
    result, todo, share = q.clone(), torch.arange(len(q), device=q.device), 1.0
    for _ in range(_HALVINGS):
        if not len(todo):
            break
        back, miss = _brought_back(chain, q[todo] + share * step[todo], pose[todo], rows, ease[todo])
        held = miss <= ROUNDING
        result[todo[held]] = back[held]
        todo, share = todo[~held], share / 2
    return result


def _brought_back(
    chain: Chain, q: Tensor, pose: Tensor, rows: TwistRows, ease: Tensor
) -> tuple[Tensor, Tensor]:
    """Newton's method to poses (N, 4, 4) from joint values (N, n) close by, and what is missing (N)."""
    lower, upper = chain.lower.to(q.device), chain.upper.to(q.device)
    damping = _NEWTON_DAMPING * torch.eye(len(rows.numbers), dtype=q.dtype, device=q.device)
    q = q.clamp(lower, upper)
    for _ in range(_NEWTON_STEPS):
        twist = rows.remaining(chain.forward(q), pose)
        error = twist[:, rows.numbers]
        if not len(q) or error.abs().max() < _NEWTON_DIGITS:
            break
        J = rows.jacobian(chain, q, twist) * ease[:, None, :]
        inner = J @ J.mT + damping
        step = ease * (J.mT @ torch.linalg.solve(inner, error[..., None]))[..., 0]
        outwards = ((q >= upper) & (step > 0)) | ((q <= lower) & (step < 0))
        if outwards.any():
            J = J.masked_fill(outwards[:, None, :], 0.0)
            step = ease * (J.mT @ torch.linalg.solve(J @ J.mT + damping, error[..., None]))[..., 0]
        q = (q + step).clamp(lower, upper)
    error = rows.remaining(chain.forward(q), pose)[:, rows.numbers]
    return q, error.abs().amax(-1)


def _ease(weights: TensorLike | None, J: Tensor) -> Tensor:
    """Square roots (n) or (..., n) of the reciprocal weights: by what joints are scaled."""
    if weights is None:
        return J.new_ones(J.shape[-1])
    costs = beside(weights, "weights", J, spatial.to_extended_float64)
    if costs.shape[-1:] != J.shape[-1:]:
        raise ValueError(f"weights has shape {tuple(costs.shape)}; {J.shape[-1]} are needed, one for a joint")
    if costs.ndim > 1 and costs.shape[:-1] != J.shape[:-2]:
        raise ValueError(f"weights has batch axes {tuple(costs.shape[:-1])}; J has {tuple(J.shape[:-2])}")
    if spatial.are_readable(costs) and (costs <= 0).any():
        raise ValueError(f"weights holds {costs.min().item():g}; positive costs are needed")
    return costs.rsqrt()
