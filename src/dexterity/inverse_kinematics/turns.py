"""Limits and full turns: which copy of a configuration is within the limits, and which is nearest.

A revolute joint puts the tool at the same pose after a full turn. Ends of limits are included, with a
tolerance that every function takes as an argument: joint values that come back from a pose differ from the
ones that went in by rounding.

Examples
--------
>>> import math
>>> import dexterity as dx
>>> from dexterity.inverse_kinematics import nearest_copy
>>> joint = dx.Chain([[0, 0, 0, 0, 0, 1]], dx.spatial.translation(1, 0, 0), lower=[-6.3], upper=[6.3])
>>> q, within = nearest_copy(joint, [-0.25], near=[6.0])
>>> round(q.item(), 4) == round(2 * math.pi - 0.25, 4), bool(within)
(True, True)
"""

from __future__ import annotations

import itertools
import math

import torch
from jaxtyping import Bool, Float64
from torch import Tensor

from dexterity import checks, spatial
from dexterity.chain import Chain
from dexterity.spatial import TensorLike
from dexterity.spatial.tolerances import LIMIT
from dexterity.spatial.values import beside, require_values

__all__ = ["copies_within_limits", "nearest_copy", "within_limits"]

_MOST_COPIES = 1_000_000


def within_limits(chain: Chain, q: TensorLike, limit_tolerance: float = LIMIT) -> Bool[Tensor, "*batch"]:
    """Whether all joints are within their limits, ends included.

    Parameters
    ----------
    chain
        A chain; joints without limits are always within.
    q
        (..., n) joint values, [rad] or [m], as they are: full turns are not removed.
    limit_tolerance
        By how much [rad] or [m] a limit may be exceeded; 0 compares exactly.

    Raises
    ------
    ValueError
        If the last axis of `q` is not the number of joints, `q` is not finite, or the tolerance is negative.
    """
    checks.instance(chain, "chain", Chain)
    q = spatial.require_joints(spatial.to_float64(q, "q"), chain.joints, "chain")
    lower, upper = _widened(chain, q.device, limit_tolerance)
    return ((q >= lower) & (q <= upper)).all(-1)


def angles_within(
    cosine: Tensor, sine: Tensor, limits: tuple[float, float], limit_tolerance: float = LIMIT
) -> Bool[Tensor, "*batch"]:
    """Tell which angles, by their cosines and sines (...), are within limits [rad], full turns left out.

    They are compared through the cosine of their distance from the middle of the limits, which needs no arc
    tangent; limits that hold a joint are met to 1e-7 at best.
    """
    lower, upper = limits
    middle, half = (lower + upper) / 2, (upper - lower) / 2
    if not half < math.pi:
        return torch.ones_like(cosine, dtype=torch.bool)
    end = math.cos(min(half + limit_tolerance, math.pi)) - _ROUNDING
    return cosine * math.cos(middle) + sine * math.sin(middle) >= end


_ROUNDING = 4e-15  # of the sum of two products of cosines and sines


def nearest_copy(
    chain: Chain, q: TensorLike, near: TensorLike | None = None, limit_tolerance: float = LIMIT
) -> tuple[Float64[Tensor, "*batch n"], Bool[Tensor, "*batch"]]:
    """Move joint values by full turns, and tell whether they are within the limits.

    Parameters
    ----------
    chain
        A chain. Prismatic joints are left as they are.
    q
        (..., n) joint values, [rad] or [m].
    near
        (..., n) joint values to come near to, such as where the robot is. Without them, the values go to the
        middle of the limits, above a lower and below an upper limit that stands alone, and to zero where
        there is none.
    limit_tolerance
        By how much [rad] or [m] a limit may be exceeded.

    Returns
    -------
    The copy of each configuration that is within the limits and among those nearest to `near` or to the
    middle, each joint for itself; and whether all joints are within (...), ends included. A joint that has no
    copy within its limits has the nearest one without regard to them.

    Raises
    ------
    ValueError
        If the last axis of `q` or `near` is not the number of joints, something is not finite, the batch axes
        do not broadcast, or the tolerance is negative.
    """
    checks.instance(chain, "chain", Chain)
    q = spatial.require_joints(spatial.to_float64(q, "q"), chain.joints, "chain")
    lower, upper = _widened(chain, q.device, limit_tolerance)
    target = middle_of_limits(chain).to(q.device) if near is None else _seed(chain, near, q)
    turns = torch.round((target - q) / math.tau)
    if near is not None:
        first, last = torch.ceil((lower - q) / math.tau), torch.floor((upper - q) / math.tau)
        # Where no copy is within, the nearest stays.
        turns = torch.where(first <= last, turns.clamp(first, last), turns)
    revolute = torch.tensor([kind == "revolute" for kind in chain.kinds], device=q.device)
    moved = torch.where(revolute, q + math.tau * turns, q)
    return moved, ((moved >= lower) & (moved <= upper)).all(-1)


def copies_within_limits(
    chain: Chain, q: TensorLike, limit_tolerance: float = LIMIT
) -> Float64[Tensor, "copies n"]:
    """Return all values of one configuration that differ by full turns and are within the limits.

    Parameters
    ----------
    chain
        A chain. A joint without limits keeps its value; with one limit it would have infinitely many copies.
    q
        (n,) joint values, [rad] or [m].
    limit_tolerance
        By how much [rad] or [m] a limit may be exceeded.

    Returns
    -------
    (copies, n), in rising order of the first joint, then of the second, and so on; none if a joint has none.

    Raises
    ------
    ValueError
        If `q` is not (n,) or not finite, the tolerance is negative, a revolute joint has one limit alone, or
        there are more than a million copies.
    """
    checks.instance(chain, "chain", Chain)
    q = spatial.require_joints(spatial.to_float64(q, "q"), chain.joints, "chain")
    if require_values(q, "q").ndim != 1:
        raise ValueError(f"q has shape {tuple(q.shape)}; one configuration, ({chain.joints},), is needed")
    lower, upper = (limit.tolist() for limit in _widened(chain, q.device, limit_tolerance))
    # More copies than can be counted come from a tolerance, since limits are finite.
    checks.real(limit_tolerance, "limit_tolerance", most=1e15)
    numbers = [
        _turns_within(value, kind, low, high, name)
        for value, kind, low, high, name in zip(
            q.tolist(), chain.kinds, lower, upper, chain.joint_names, strict=True
        )
    ]
    count = math.prod(len(each) for each in numbers)
    if count > _MOST_COPIES:
        widest = max(range(chain.joints), key=lambda i: len(numbers[i]))
        raise ValueError(
            f"q has {count} copies within the limits; {_MOST_COPIES} are the most. "
            f"{chain.joint_names[widest]} alone has {len(numbers[widest])}: limit it"
        )
    turns = q.new_tensor(list(itertools.product(*numbers))).reshape(-1, chain.joints)
    return q + math.tau * turns


def _turns_within(value: float, kind: str, lower: float, upper: float, name: str) -> range:
    """Whole turns that may be added to a joint's value."""
    unlimited = math.isinf(lower) and math.isinf(upper)
    if kind == "prismatic" or unlimited:
        return range(1) if lower <= value <= upper else range(0)
    if math.isinf(upper - lower):
        raise ValueError(f"chain has no limits at {name} on one side, and so infinitely many copies")
    return range(math.ceil((lower - value) / math.tau), math.floor((upper - value) / math.tau) + 1)


def middle_of_limits(chain: Chain) -> Tensor:
    """Middle of the limits (n), half a turn from a limit that stands alone, zero without any."""
    lower, upper = chain.lower, chain.upper
    middle = torch.where(
        lower.isinf(), upper - math.pi, torch.where(upper.isinf(), lower + math.pi, (lower + upper) / 2)
    )
    return torch.where(lower.isinf() & upper.isinf(), 0.0, middle)


def _seed(chain: Chain, near: TensorLike, q: Tensor) -> Tensor:
    seed = beside(near, "near", q)
    if seed.shape[-1:] != (chain.joints,):
        raise ValueError(f"near has shape {tuple(seed.shape)}; the chain has {chain.joints} joints")
    try:
        torch.broadcast_shapes(seed.shape, q.shape)
    except RuntimeError as error:
        raise ValueError(
            f"near has shape {tuple(seed.shape)}, which does not broadcast with q, {tuple(q.shape)}"
        ) from error
    return seed


def _widened(chain: Chain, device: torch.device, limit_tolerance: float) -> tuple[Tensor, Tensor]:
    """Limits (n) of a chain, wider by a tolerance."""
    wider = checks.real(limit_tolerance, "limit_tolerance", least=0)
    return chain.lower.to(device) - wider, chain.upper.to(device) + wider
