"""A kink of KCI: a posture at which the two smallest singular values meet, and the surroundings of the posture."""

from __future__ import annotations

from typing import NamedTuple

import torch
from scipy import optimize
from torch import Tensor

from dexterity import robots, sampling

JOINTS = (4, 8)
"""The two joints that are varied: the roll θy of the vehicle and the elbow."""

HALF_WIDTH_DEG = 15.0
"""Half width of the paper's range of a joint."""

_SAMPLES = 1000


class Sheet(NamedTuple):
    """Singular values over two joints: angles [degree], (k,) each, and all six singular values, (k, k, 6)."""

    first_deg: Tensor
    second_deg: Tensor
    sigma: Tensor


def singular_values(q: Tensor) -> Tensor:
    """Return the singular values (..., 6) of the spatial Jacobian with unit limits, the largest first."""
    return torch.linalg.svdvals(robots.uvms().spatial_jacobian(q))


def tip() -> Tensor:
    """Find joint values (12,) in the paper's space of KCI at which the two smallest singular values are equal.

    The sample with the smallest distance between both is the start, and the joints in :data:`JOINTS` are moved. Two
    joints are needed, because two conditions make the smallest eigenvalue of a symmetric matrix double.

    Raises
    ------
    RuntimeError
        If the values do not meet within the paper's range of the joints.
    """
    q = sampling.sobol(sampling.uvms_space("kinematic_conditioning"), _SAMPLES, 0)
    start = q[int(_gap(q).argmin())]

    def gap(values: Tensor) -> float:
        return float(_gap(_with_joints(start, torch.as_tensor(values))))

    options = {"xatol": 1e-13, "fatol": 1e-13, "maxiter": 1000}
    met = optimize.minimize(gap, start[list(JOINTS)].numpy(), method="Nelder-Mead", options=options)
    if met.fun > 1e-9 or abs(met.x).max() > torch.pi * HALF_WIDTH_DEG / 180:
        raise RuntimeError(f"the two smallest singular values stay {met.fun:.1e} apart")
    return _with_joints(start, torch.as_tensor(met.x))


def sheet(at: Tensor, samples: int) -> Sheet:
    """Take the singular values over the whole range of the two joints in :data:`JOINTS`, the others as in `at` (12,)."""
    angles = torch.linspace(-HALF_WIDTH_DEG, HALF_WIDTH_DEG, samples, dtype=torch.float64)
    grid = torch.stack(torch.meshgrid(angles, angles, indexing="ij"), dim=-1)
    return Sheet(angles, angles, singular_values(_with_joints(at, grid.deg2rad())))


def line(at: Tensor, samples: int) -> tuple[Tensor, Tensor]:
    """Take the singular values (k, 6) along the first of both joints through `at` (12,), with its angles [degree], (k,).

    The angle of `at` is the middle one.
    """
    middle = at[JOINTS[0]].rad2deg()
    width = HALF_WIDTH_DEG - float(middle.abs())
    angles = middle + torch.linspace(-width, width, 2 * (samples // 2) + 1, dtype=torch.float64)
    values = torch.stack([angles.deg2rad(), at[JOINTS[1]].expand(len(angles))], dim=-1)
    return angles, singular_values(_with_joints(at, values))


def _gap(q: Tensor) -> Tensor:
    sigma = singular_values(q)
    return sigma[..., 4] - sigma[..., 5]


def _with_joints(q: Tensor, values: Tensor) -> Tensor:
    changed = q.expand(*values.shape[:-1], -1).clone()
    changed[..., list(JOINTS)] = values
    return changed
