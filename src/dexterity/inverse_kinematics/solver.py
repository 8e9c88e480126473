"""Inverse kinematics of any chain: in closed form where it has one, else by search.

Examples
--------
>>> import dexterity as dx
>>> panda = dx.robots.load("panda")
>>> q = [0.5, -0.7, 0.6, -2.3, 0.3, 1.7, 0.5]
>>> found = dx.inverse_kinematics.solve(panda, panda.forward(q), seeds=16, near=q)
>>> found.method, found.complete, bool(found.reached)
('search', False, True)
>>> bool((found.q[0] - panda.forward(q).new_tensor(q)).abs().max() < 1e-6)
True
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, Literal, TypeAlias, get_args

import torch
from torch import Tensor

from dexterity import checks, spatial
from dexterity.chain import Chain
from dexterity.descent import RowFrame, TwistRows
from dexterity.indices.rows import Rows, row_numbers
from dexterity.inverse_kinematics.branches import Form
from dexterity.inverse_kinematics.closed_forms import form_of, reasons
from dexterity.inverse_kinematics.null_space import (
    Objective,
    bound_objective,
    held_step,
    null_direction,
    slope,
)
from dexterity.inverse_kinematics.seeds import Ends, distinct, search
from dexterity.inverse_kinematics.slices import Locked, branches_of_slices, locked_values
from dexterity.inverse_kinematics.solutions import SeedsEnded, Solutions
from dexterity.inverse_kinematics.turns import middle_of_limits, nearest_copy
from dexterity.spatial import TensorLike
from dexterity.spatial.tolerances import LIMIT
from dexterity.spatial.values import beside, require_values

__all__ = ["Method", "Secondary", "solve"]

Method: TypeAlias = Literal["auto", "closed form", "search"]
"""How to solve, in closed form where there is one and else by search, or one of the two."""

Secondary: TypeAlias = Objective | Literal["centre"] | Any
"""What redundant joints are for, an index or any function of joint values, or the middle of the limits."""

_MOST_SEEDS = 100_000  # of which the poses alone fill a gigabyte or two
_LAST = 1e300  # key of what is valid beyond the limits
_SAME = 1e-4  # [rad] or [m] below which two ends of a search are one configuration
_REPRESENTATIVE = 0.5  # [rad] or [m] by which configurations of a redundant chain are told apart
_CLIMBS, _FIRST_CLIMB, _LARGEST_CLIMB = 40, 0.1, 0.5  # steps in the null space and their lengths [rad] or [m]


def solve(
    chain: Chain,
    T_world_tool: TensorLike,
    *,
    rows: Rows = "full",
    frame: RowFrame = "body",
    locked: Mapping[str, TensorLike] | None = None,
    seeds: int = 64,
    near: TensorLike | None = None,
    secondary: Secondary | None = None,
    limit_tolerance: float = LIMIT,
    tolerance: float = 1e-9,
    method: Method = "auto",
    enough: int | None = None,
    seed: int = 0,
) -> Solutions:
    """Find joint values that put the tool at poses.

    Parameters
    ----------
    chain
        Any chain. A joint whose rate is zero is locked: it keeps its value in `near`, or zero.
    T_world_tool
        (..., 4, 4) wanted poses of the tool.
    rows
        Components of the remaining twist that must vanish: ``"full"``, ``"translational"``,
        ``"rotational"``, or a selection by names or numbers. ``("vx", "vy", "vz", "wx", "wy")`` leaves the
        rotation about the z axis free.
    frame
        Axes of the rows: ``"body"`` for those of the tool, ``"geometric"`` for those of the world. Along the
        tool's, the five rows above hold its position and where its z axis points; along the world's,
        ``("vx", "vy", "wz")`` are those of a task in the horizontal plane. It makes no difference where all
        three of a kind count.
    locked
        Values [rad] or [m] of joints to lock, by name: with each of them, a closed form finds all
        configurations of the other joints. :func:`.slices` chooses them for arms of seven joints.
    seeds
        How many seeds of a search to try at each pose, at most 100 000.
    near
        (n,) or (..., n) joint values to be near to, such as where the robot is. They are one of the seeds,
        copies by full turns come near to them, and solutions are ordered by their distance.
    secondary
        What joints that are redundant are used for: an index (as it is, bound, or compiled), any function of
        joint values (..., n) that torch can differentiate, or ``"centre"`` for the middle of the limits.
        Without `near`, solutions are ordered by it, the largest first.
    limit_tolerance
        By how much [rad] or [m] a limit may be exceeded.
    tolerance
        Largest residual of a solution, in radians and in metres relative to the size of the chain; at most 1.
    method
        ``"auto"`` takes a closed form if the chain has one, all rows count and no rate is zero, else a
        search; ``"closed form"`` and ``"search"`` take one of both.
    enough
        A search leaves a pose when so many seeds have reached it; all seeds are tried by default.
    seed
        Of the Sobol sequence from which seeds are taken.

    Returns
    -------
    The solutions at each pose, the best first, on the device of the poses, and how they were
    found. A closed form finds all of them, with locked joints all that have their values; a search finds
    those to which its seeds descend, one for all that differ by full turns, and of a redundant chain
    representatives that differ by 0.5 rad or m in a joint.

    Raises
    ------
    ValueError
        If a shape or a number does not fit, a pose is not rigid, or the closed form that was asked for does
        not exist, also for a value of the locked joints.
    TypeError
        If an argument is of another kind.
    """
    checks.instance(chain, "chain", Chain)
    checks.choice(frame, "frame", get_args(RowFrame))
    counted = TwistRows(row_numbers(rows), frame)
    seeds = checks.whole(seeds, "seeds", least=1, most=_MOST_SEEDS)
    seed = checks.seed(seed)
    tolerance = checks.real(tolerance, "tolerance", above=0, most=1)
    limit_tolerance = checks.real(limit_tolerance, "limit_tolerance", least=0)
    checks.choice(method, "method", get_args(Method))
    if enough is not None:
        enough = checks.whole(enough, "enough", least=1)
    T = require_values(spatial.require_rigid(T_world_tool, "T_world_tool"), "T_world_tool").detach()
    start = _seed(chain, near, T)
    value = _objective(chain, secondary)

    def ordered(q: Tensor, residual: Tensor, **told: Any) -> Solutions:
        return _ordered(chain, q, residual, start, value, limit_tolerance, tolerance, told)

    if locked is not None:
        held = _slices(chain, locked, counted, method)
        q, residual, name, miss = branches_of_slices(chain, T, held)
        return ordered(q, residual, method=name, complete=False, miss=miss, locked=held)
    form = _form(chain, counted, method)
    if form is not None:
        q, _, residual = form.branches(chain, T)
        return ordered(q, residual, method=form.name, complete=True, miss=form.miss(chain))
    poses = T.reshape(-1, 4, 4).cpu()
    first = None if start is None else start.reshape(-1, chain.joints).cpu()
    # Searches run on the processor, whatever torch's default device is.
    with torch.device("cpu"):
        free = _with_locked_joints(chain, start)
        ends = search(
            free, poses, counted,
            count=seeds, near=first, enough=enough, tolerance=tolerance, seed=seed,
        )  # fmt: skip
        q, residual = _different(free, poses, counted, ends, first, value, tolerance)
    q = q.reshape(*T.shape[:-2], *q.shape[1:]).to(T.device)
    residual = residual.reshape(*T.shape[:-2], *residual.shape[1:]).to(T.device)
    ended = _ended(free, ends, tolerance, T)
    return ordered(q, residual, method="search", complete=False, seeds=ended)


def _seed(chain: Chain, near: TensorLike | None, T: Tensor) -> Tensor | None:
    """Seeds (..., n), one for each pose."""
    if near is None:
        return None
    seed = beside(near, "near", T).detach()
    if seed.shape[-1:] != (chain.joints,):
        raise ValueError(f"near has shape {tuple(seed.shape)}; the chain has {chain.joints} joints")
    try:
        return seed.expand(*T.shape[:-2], chain.joints)
    except RuntimeError as error:
        raise ValueError(
            f"near has shape {tuple(seed.shape)}; {(*T.shape[:-2], chain.joints)} is needed"
        ) from error


def _beside(start: Tensor | None) -> Tensor | None:
    return None if start is None else start[..., None, :]


def _objective(chain: Chain, secondary: Secondary | None) -> Objective | None:
    if secondary is None:
        return None
    if isinstance(secondary, str):
        checks.choice(secondary, "secondary", ("centre",))
        return _centring(chain)
    return bound_objective(chain, secondary, "secondary")


def _centring(chain: Chain) -> Objective:
    """Minus half the sum of squared distances from the middle of the limits, in half ranges."""
    limited = chain.lower.isfinite() & chain.upper.isfinite() & (chain.upper > chain.lower)
    middle = middle_of_limits(chain)
    half = torch.where(limited, (chain.upper - chain.lower) / 2, torch.inf)

    def value(q: Tensor) -> Tensor:
        return -((q - middle.to(q.device)) / half.to(q.device)).square().sum(-1) / 2

    return value


def _form(chain: Chain, rows: TwistRows, method: Method) -> Form | None:
    """Return the closed form to use, None for a search."""
    if method == "search":
        return None
    form = form_of(chain)
    usable = form is not None and _all_count(rows) and bool((chain.rates > 0).all())
    if method == "closed form" and not usable:
        reason = (
            f"has none ({reasons(chain)})"
            if form is None
            else "has one for all six rows and no locked joint alone"
        )
        raise ValueError(f"method is 'closed form', but chain {chain.name!r} {reason}; take 'search'")
    return form if usable else None


def _all_count(rows: TwistRows) -> bool:
    return set(rows.numbers) == set(range(6))


def _slices(chain: Chain, locked: Mapping[str, TensorLike], rows: TwistRows, method: Method) -> Locked:
    """Values of locked joints, which only a closed form of the other joints serves."""
    values = locked_values(chain, locked)
    if method == "search" or not _all_count(rows):
        raise ValueError(
            f"locked holds {', '.join(values)}, which a closed form needs; a search with all six rows or "
            "others takes a chain with joints locked by Chain.lock"
        )
    return values


def _with_locked_joints(chain: Chain, start: Tensor | None) -> Chain:
    """Return the chain with limits that hold the joints whose rate is zero."""
    locked = chain.rates == 0
    if not locked.any():
        return chain
    values = torch.zeros(chain.joints, dtype=torch.float64)
    if start is not None:
        seeds = start.reshape(-1, chain.joints).cpu()
        if (seeds[:, locked] != seeds[:1, locked]).any():
            raise ValueError(
                "near holds different values of a locked joint (rate 0); one for all poses is needed"
            )
        values = seeds[0]
    values = values.clamp(chain.lower, chain.upper)
    return Chain(
        chain.screws, chain.home,
        name=chain.name, joint_names=chain.joint_names, rates=chain.rates,
        lower=torch.where(locked, values, chain.lower), upper=torch.where(locked, values, chain.upper),
    )  # fmt: skip


def _different(
    chain: Chain,
    T: Tensor,
    rows: TwistRows,
    ends: Ends,
    start: Tensor | None,
    value: Objective | None,
    tolerance: float,
) -> tuple[Tensor, Tensor]:
    """Return ends (B, k, n) that differ, and their residuals (B, k); spare places hold the best end."""
    redundant = int((chain.upper - chain.lower > LIMIT).sum()) > len(rows.numbers)
    radius = _REPRESENTATIVE if redundant else _SAME
    q, residual = ends.q, ends.residual
    if start is not None:
        q, _ = nearest_copy(chain, q, start[:, None])
        residual, q = _by(residual, q, _first_valid(residual, tolerance, (q - start[:, None]).norm(dim=-1)))
    kept = distinct(chain, q, residual <= tolerance, radius)
    if value is not None and redundant:
        which = kept.nonzero(as_tuple=True)
        q = q.clone()
        q[which] = _climbed(chain, q[which], T[which[0]], rows, value)
        kept = distinct(chain, q, kept, _SAME)
    k = max(1, int(kept.sum(1).amax())) if len(kept) else 1
    # Kept ones first; where there is none, the end that came nearest.
    order = torch.where(kept, -1.0, residual).argsort(dim=1, stable=True)[:, :k]
    chosen, missing = q.take_along_dim(order[..., None], 1), residual.take_along_dim(order, 1)
    spare = ~kept.take_along_dim(order, 1)
    spare[:, 0] = False
    return (
        torch.where(spare[..., None], chosen[:, :1], chosen),
        torch.where(spare, torch.inf, missing),
    )


def _first_valid(residual: Tensor, tolerance: float, distance: Tensor) -> Tensor:
    return torch.where(residual <= tolerance, distance, torch.inf)


def _by(residual: Tensor, q: Tensor, key: Tensor) -> tuple[Tensor, Tensor]:
    order = key.argsort(dim=-1, stable=True)
    return residual.take_along_dim(order, -1), q.take_along_dim(order[..., None], -2)


def _climbed(chain: Chain, q: Tensor, T: Tensor, rows: TwistRows, value: Objective) -> Tensor:
    """Joint values (N, n) after an ascent in the null space, the tools at their poses (N, 4, 4)."""
    length = torch.full_like(q[:, :1], _FIRST_CLIMB)
    best = value(q)
    for _ in range(_CLIMBS):
        direction = null_direction(chain, q, slope(value, q), rows, None)
        norm = direction.norm(dim=-1, keepdim=True)
        step = length * direction / norm.clamp(min=1e-12)
        moved = held_step(chain, q, step, T, rows, None)
        after = value(moved)
        better = after > best
        q, best = torch.where(better[:, None], moved, q), torch.where(better, after, best)
        length = torch.where(better[:, None], (1.5 * length).clamp(max=_LARGEST_CLIMB), length / 3)
        if not (length > 1e-5).any():
            break
    return q


def _ended(chain: Chain, ends: Ends, tolerance: float, T: Tensor) -> SeedsEnded:
    tried = ends.residual.isfinite()
    converged = ends.residual <= tolerance
    at_limits = tried & ~converged & ends.at_limits(chain)
    stuck = tried & ~converged & ~at_limits
    shape = T.shape[:-2]
    return SeedsEnded(*(x.sum(1).reshape(shape).to(T.device) for x in (tried, converged, at_limits, stuck)))


def _ordered(
    chain: Chain,
    q: Tensor,
    residual: Tensor,
    start: Tensor | None,
    value: Objective | None,
    limit_tolerance: float,
    tolerance: float,
    told: dict[str, Any],
) -> Solutions:
    """Put solutions that are valid and within the limits in front, the best first, then the valid ones."""
    q, within = nearest_copy(chain, q, _beside(start), limit_tolerance)
    valid = residual <= tolerance
    if start is not None:
        key = (q - start[..., None, :]).norm(dim=-1)
    elif value is not None:
        key = -value(q).detach()
    else:
        key = (q - middle_of_limits(chain).to(q.device)).norm(dim=-1)
    key = key.masked_fill(~within, _LAST).masked_fill(~valid, math.inf)
    order = key.argsort(dim=-1, stable=True)
    if "locked" in told:  # of many slices few may have any
        order = order[..., : max(1, int(valid.sum(-1).max())) if valid.numel() else 1]
    return Solutions(
        chain=chain,
        q=q.take_along_dim(order[..., None], -2),
        valid=valid.take_along_dim(order, -1),
        within_limits=within.take_along_dim(order, -1),
        residual=residual.take_along_dim(order, -1),
        limit_tolerance=limit_tolerance,
        **told,
    )
