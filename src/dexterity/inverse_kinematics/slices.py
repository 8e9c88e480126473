"""Slices of redundant arms: joints locked at values, and all configurations of the others in closed form.

An arm of seven joints has a curve of configurations at a pose. With one joint locked, those of the other six
may have a closed form, so that all points of the curve are found at which the locked joint has its value.

Examples
--------
>>> import dexterity as dx
>>> panda = dx.robots.load("panda")
>>> locked = dx.inverse_kinematics.slices(panda, 5)
>>> [(name, len(values)) for name, values in locked.items()]
[('panda_joint5', 5)]
>>> T = panda.forward([0.5, -0.7, 0.6, -2.3, 0.3, 1.7, 0.5])
>>> found = dx.inverse_kinematics.solve(panda, T, locked={"panda_joint7": [0.5]})
>>> found.method, int(found.count)
('spherical shoulder', 2)

References
----------
He & Liu (2021), Analytical inverse kinematics for Franka Emika Panda, ICCMA; Shimizu et al. (2008),
Analytical inverse kinematic computation for 7-DOF redundant manipulators with joint limits.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping
from typing import TypeAlias

import torch
from jaxtyping import Float64
from torch import Tensor

from dexterity import checks, sobol, spatial
from dexterity.chain import Chain
from dexterity.inverse_kinematics.branches import Form
from dexterity.inverse_kinematics.closed_forms import form_of, reasons
from dexterity.spatial import TensorLike
from dexterity.spatial.tolerances import LIMIT

__all__ = ["Locked", "branches_of_slices", "locked_values", "slices"]

Locked: TypeAlias = dict[str, Float64[Tensor, " values"]]
"""Values of joints that are locked, by their names."""

_SAMPLE = 64  # configurations at which joints are compared
_GENERIC = 0.381966  # share of a range at which nothing is aligned
_MOST = 10_000  # slices


def slices(chain: Chain, count: int = 32) -> Locked:
    """Choose the joint of an arm of seven to lock, and values for it.

    Parameters
    ----------
    chain
        Seven revolute joints.
    count
        How many values, from one limit to the other, or over a full turn.

    Returns
    -------
    The name of the joint with its values, for `locked` of :func:`.solve`. Of the joints without which the
    others have a closed form, it is the one that moves most where the tool stays at its pose. Values at
    which there is no closed form are left out.

    Raises
    ------
    ValueError
        If the chain has not seven joints, or no joint leaves a closed form.
    """
    checks.instance(chain, "chain", Chain)
    checks.whole(count, "count", least=1, most=_MOST)
    if chain.joints != 7:
        raise ValueError(f"chain has {chain.joints} joints; slices are for seven")
    lower, upper = _ranges(chain)
    moves = _self_motion(chain, lower, upper)
    for joint in moves.argsort(descending=True).tolist():
        name, width = chain.joint_names[joint], float(upper[joint] - lower[joint])
        if form_of(chain.lock({name: float(lower[joint]) + _GENERIC * width})) is None:
            continue
        whole = width >= math.tau - 1e-9
        values = torch.linspace(0, 1, count + whole, dtype=torch.float64, device="cpu")[:count]
        values = lower[joint] + width * (values if count > 1 else values + 0.5)
        return {name: torch.stack([v for v in values if form_of(chain.lock({name: float(v)}))])}
    raise ValueError(f"chain {chain.name!r} has no joint that leaves a closed form when it is locked")


def locked_values(chain: Chain, locked: Mapping[str, TensorLike]) -> Locked:
    """Check values of locked joints: known joints, and values within the limits, each a number or a row.

    Raises
    ------
    TypeError
        If `locked` is no mapping.
    ValueError
        If a joint is unknown, values do not fit, or there are more than 10 000 slices.
    """
    if not isinstance(locked, Mapping) or not locked:
        raise TypeError(f"locked is {checks.shown(locked)}; values by names of joints are needed")
    held = {}
    for name, values in locked.items():
        checks.choice(name, "locked", chain.joint_names)
        row = spatial.to_float64(values, f"locked[{name!r}]").detach().cpu()
        if row.ndim > 1 or not row.numel():
            raise ValueError(f"locked[{name!r}] has shape {tuple(row.shape)}; one value or a row is needed")
        i = chain.joint_names.index(name)
        low, high = float(chain.lower[i]), float(chain.upper[i])
        if (row < low - LIMIT).any() or (row > high + LIMIT).any():
            raise ValueError(
                f"locked[{name!r}] is {row.tolist()}; the joint's limits are {low:g} and {high:g}"
            )
        held[name] = row.reshape(-1).clone()
    if (count := math.prod(len(values) for values in held.values())) > _MOST:
        raise ValueError(f"locked makes {count} slices; {_MOST} are the most")
    return held


def branches_of_slices(chain: Chain, T: Tensor, locked: Locked) -> tuple[Tensor, Tensor, str, float]:
    """Branches (..., b, n) at poses (..., 4, 4) in all slices, misses (..., b), the form and what it misses.

    Raises
    ------
    ValueError
        If the other joints have no closed form at a value.
    """
    held = torch.tensor([name in locked for name in chain.joint_names], device=T.device)
    parts, names, miss = [], [], 0.0
    for values in itertools.product(*(values.tolist() for values in locked.values())):
        at = dict(zip(locked, values, strict=True))
        rest, form = _rest(chain, at)
        branches, _, residual = form.branches(rest, T)
        q = branches.new_empty(*branches.shape[:-1], chain.joints)
        q[..., ~held] = branches
        q[..., held] = q.new_tensor([at[name] for name in chain.joint_names if name in at])
        parts.append((q, residual))
        names.append(form.name)
        miss = max(miss, form.miss(rest))
    return (
        torch.cat([q for q, _ in parts], -2),
        torch.cat([residual for _, residual in parts], -1),
        " or ".join(dict.fromkeys(names)),
        miss,
    )


def _rest(chain: Chain, at: dict[str, float]) -> tuple[Chain, Form]:
    """Return the chain of the joints that are not locked, and its closed form."""
    rest = chain.lock(at)
    form = form_of(rest)
    if form is None or not bool((rest.rates > 0).all()):
        said = ", ".join(f"{name} at {value:g}" for name, value in at.items())
        why = reasons(rest) if form is None else "a rate is zero"
        raise ValueError(f"locked holds {said}, where the other joints have no closed form: {why}")
    return rest, form


def _ranges(chain: Chain) -> tuple[Tensor, Tensor]:
    """Limits (n), those of a turn where joints go farther."""
    lower = torch.where(
        chain.lower.isinf(), torch.where(chain.upper.isinf(), -math.pi, chain.upper - math.tau), chain.lower
    )
    return lower, torch.minimum(chain.upper, lower + math.tau)


def _self_motion(chain: Chain, lower: Tensor, upper: Tensor) -> Tensor:
    """Mean shares (n) of the joints in the motion that leaves the tool at its pose."""
    q = lower + (upper - lower) * sobol.points(chain.joints, _SAMPLE, seed=0)
    return torch.linalg.svd(chain.body_jacobian(q)).Vh[:, -1].abs().mean(0)
