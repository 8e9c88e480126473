"""Singular values of Jacobians, and their scaling by the largest rates of joints and tool.

Everything is computed from the singular values of J itself: squaring J loses half the digits near a
singularity and can turn a zero into NaN.

Examples
--------
>>> import torch
>>> from dexterity.indices import manipulability, normalise
>>> J = normalise(torch.eye(6), joint_rates=[2.0] * 6, tool_rates=[1.0] * 6)
>>> float(manipulability(J))
64.0
"""

from __future__ import annotations

import torch
from jaxtyping import Float64
from torch import Tensor

from dexterity import spatial
from dexterity.spatial import TensorLike
from dexterity.spatial.values import beside

__all__ = [
    "kinematic_conditioning",
    "manipulability",
    "matrices",
    "normalise",
    "singular_values",
    "with_finite_powers",
]


def manipulability(J: TensorLike) -> Float64[Tensor, "*batch"]:
    r"""Yoshikawa's manipulability :math:`w = \sigma_1 \cdots \sigma_m = \sqrt{\det(J J^\top)}`.

    Parameters
    ----------
    J
        (..., m, n) Jacobians, m = 6 for the whole twist; rows may be left out.

    Returns
    -------
    (...) values, 0 at a singularity and wherever there are fewer joints than rows. The unit is the
    product of the rows' units; 1 for a normalised Jacobian.

    Raises
    ------
    ValueError
        If `J` is no stack of matrices or is not finite.

    References
    ----------
    Yoshikawa (1985); Sotiropoulos & Aspragathos (2016), Eqs. 8 and 9.
    """
    return singular_values(matrices(J)).prod(-1)


def kinematic_conditioning(J: TensorLike) -> Float64[Tensor, "*batch"]:
    r"""Kinematic conditioning index :math:`\sigma_m / \sigma_1`, the inverse of the condition number.

    Parameters
    ----------
    J
        (..., m, n) Jacobians, m = 6 for the whole twist; rows may be left out.

    Returns
    -------
    (...) values from 0 (singular, or fewer joints than rows) to 1 (isotropic). 0 for a Jacobian of
    zeros, which moves nothing.

    Raises
    ------
    ValueError
        If `J` is no stack of matrices or is not finite.

    References
    ----------
    Angeles & López-Cajún (1992); Sotiropoulos & Aspragathos (2016), Eq. 10.
    """
    return ratio_of_extremes(singular_values(matrices(J)))


def ratio_of_extremes(sigma: Float64[Tensor, "*batch m"]) -> Float64[Tensor, "*batch"]:
    """Return the smallest over the largest of descending singular values, 0 where all are zero."""
    largest = sigma[..., 0]
    return sigma[..., -1] / torch.where(largest > 0, largest, 1.0)


def normalise(
    J: TensorLike, joint_rates: TensorLike, tool_rates: TensorLike
) -> Float64[Tensor, "*batch m n"]:
    r"""Scale a Jacobian by the largest rates of joints and tool.

    :math:`U J G^{-1}` with :math:`G^{-1} = \mathrm{diag}(\dot\theta_{max})` and
    :math:`U = \mathrm{diag}(1/\dot r_{max})`.

    Parameters
    ----------
    J
        (..., m, n) Jacobians.
    joint_rates
        (n,) largest joint rates, [rad/s] or [m/s]; 0 locks a joint.
    tool_rates
        (m,) largest tool rates, [m/s] and [rad/s].

    Raises
    ------
    ValueError
        If a shape does not fit, a joint rate is negative, or a tool rate is not positive.

    References
    ----------
    Sotiropoulos & Aspragathos (2016), Eq. 7.
    """
    J = matrices(J)
    joint_rates = beside(joint_rates, "joint_rates", J)
    tool_rates = beside(tool_rates, "tool_rates", J)
    if joint_rates.shape != J.shape[-1:]:
        raise ValueError(f"joint_rates has shape {tuple(joint_rates.shape)}; ({J.shape[-1]},) is needed")
    if tool_rates.shape != J.shape[-2:-1]:
        raise ValueError(f"tool_rates has shape {tuple(tool_rates.shape)}; ({J.shape[-2]},) is needed")
    if spatial.are_readable(joint_rates) and (joint_rates < 0).any():
        raise ValueError(f"joint_rates holds a negative rate: {joint_rates.tolist()}")
    if spatial.are_readable(tool_rates) and (tool_rates <= 0).any():
        raise ValueError(f"tool_rates must be positive: {tool_rates.tolist()}")
    return J * joint_rates / tool_rates[:, None]


def matrices(J: TensorLike) -> Float64[Tensor, "*batch m n"]:
    """Return Jacobians as a finite float64 tensor.

    Raises
    ------
    ValueError
        If `J` is no stack of matrices, is not finite, or holds numbers whose powers are not.
    """
    J = spatial.to_float64(J, "J")
    if J.ndim < 2 or 0 in J.shape[-2:]:
        raise ValueError(f"J has shape {tuple(J.shape)}; (..., rows, joints) is needed")
    return with_finite_powers(J, "J")


def with_finite_powers(values: Float64[Tensor, "..."], name: str) -> Float64[Tensor, "..."]:
    """Return numbers as they are if products of six of them are numbers as well.

    Raises
    ------
    ValueError
        If one is beyond 1e50 and may be looked at.
    """
    if values.numel() and spatial.are_readable(values) and values.abs().max() > _LARGEST:
        raise ValueError(f"{name} holds numbers beyond {_LARGEST:g}, whose powers have no value in float64")
    return values


_LARGEST = 1e50


def singular_values(J: Float64[Tensor, "*batch m n"]) -> Float64[Tensor, "*batch m"]:
    """Return the singular values in descending order, with the zeros of a Jacobian of too few joints."""
    return padded(torch.linalg.svdvals(J), J.shape[-2])


def padded(sigma: Float64[Tensor, "*batch k"], rows: int) -> Float64[Tensor, "*batch m"]:
    """Add the zero singular values of a Jacobian with fewer joints than rows."""
    return torch.nn.functional.pad(sigma, (0, rows - sigma.shape[-1]))
