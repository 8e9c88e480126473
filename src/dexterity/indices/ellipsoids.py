"""Velocity and force ellipsoids of a Jacobian.

Examples
--------
A planar arm of two joints at a right angle: the tool moves in a plane, and any force across it is carried.

>>> import dexterity as dx
>>> arm = dx.Chain.from_dh([{"a": 1}, {"a": 1}])
>>> J = arm.geometric_jacobian([0, 1.5707963267948966])
>>> dx.indices.velocity_ellipsoid(J, "translational").semi_axes.round(decimals=3).tolist()
[1.618, 0.618, 0.0]
>>> float(dx.indices.force_ellipsoid(J, "translational").semi_axes[2])
inf
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal, TypeAlias, get_args

import torch
from jaxtyping import Float64
from torch import Tensor

from dexterity import checks
from dexterity.indices.jacobians import matrices, padded
from dexterity.spatial import TensorLike

__all__ = ["Ellipsoid", "Part", "force_ellipsoid", "velocity_ellipsoid"]

Part: TypeAlias = Literal["full", "translational", "rotational"]
"""All six rows of a Jacobian, its first three, or its last three."""


@dataclass(frozen=True)
class Ellipsoid:
    """Ellipsoid about the origin of a velocity or force space of k dimensions.

    Attributes
    ----------
    axes
        (..., k, k), unit vectors along the principal axes as columns.
    semi_axes
        (..., k) half lengths along them, from the longest velocity axis to the shortest. A zero is a
        velocity that is lost; its reciprocal in the force ellipsoid is infinite.
    """

    axes: Float64[Tensor, "*batch k k"]
    semi_axes: Float64[Tensor, "*batch k"]

    @property
    def volume(self) -> Float64[Tensor, "*batch"]:
        r"""Volume, :math:`\pi^{k/2} / \Gamma(k/2 + 1)` times the product of the semi-axes."""
        k = self.semi_axes.shape[-1]
        return math.pi ** (k / 2) / math.gamma(k / 2 + 1) * self.semi_axes.prod(-1)


def velocity_ellipsoid(J: TensorLike, part: Part = "full") -> Ellipsoid:
    """Tool velocities that joint rates of unit norm reach.

    Parameters
    ----------
    J
        (..., 6, n) Jacobians. For the velocity of the tool point take the geometric one.
    part
        Rows that count: ``"full"`` (k = 6), ``"translational"`` or ``"rotational"`` (k = 3).

    Raises
    ------
    ValueError
        If `J` does not have six rows, is not finite, or `part` is unknown.

    References
    ----------
    Yoshikawa (1985); Sotiropoulos & Aspragathos (2016), section 2.3 and Fig. 3.
    """
    rows = _rows(J, part)
    axes, sigma, _ = torch.linalg.svd(rows)
    return Ellipsoid(axes, padded(sigma, rows.shape[-2]))


def force_ellipsoid(J: TensorLike, part: Part = "full") -> Ellipsoid:
    """Tool forces (or wrenches) that joint efforts of unit norm balance: the reciprocal ellipsoid.

    Parameters and errors are those of :func:`velocity_ellipsoid`. The axes are the same and the
    semi-axes its reciprocals, infinite where the structure carries the load without any joint effort.

    References
    ----------
    Yoshikawa (1985); Chiu (1988).
    """
    velocity = velocity_ellipsoid(J, part)
    return Ellipsoid(velocity.axes, 1 / velocity.semi_axes)


def _rows(J: TensorLike, part: Part) -> Tensor:
    J = matrices(J)
    if J.shape[-2] != 6:
        raise ValueError(f"J has {J.shape[-2]} rows; 6 are needed")
    blocks = {"full": J, "translational": J[..., :3, :], "rotational": J[..., 3:, :]}
    return blocks[checks.choice(part, "part", get_args(Part))]
