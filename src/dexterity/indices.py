"""Dexterity indices and ellipsoids of a Jacobian.

The manipulability w and the kinematic conditioning index KCI of Sotiropoulos & Aspragathos (2016),
Eqs. 7–10, for Jacobians with any number of rows and columns. Everything is computed from the singular
values of J itself: squaring J loses half the digits near a singularity and can turn a zero into NaN.

Examples
--------
>>> import dexterity as dx
>>> puma, q = dx.robots.puma560(), [0.0, 0.5, 0.25, 0.0, 0.5, 0.0]
>>> w = dx.indices.Index("manipulability").bind(puma)
>>> round(float(w(q)), 4)
0.0087
>>> J = puma.geometric_jacobian(q)
>>> dx.indices.velocity_ellipsoid(J, "translational").semi_axes.shape
torch.Size([3])
"""

from __future__ import annotations

import difflib
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, TypeAlias, get_args

import torch
from jaxtyping import Float64
from torch import Tensor

from dexterity import spatial
from dexterity.chain import Chain
from dexterity.spatial import TensorLike

__all__ = [
    "Ellipsoid",
    "Frame",
    "Index",
    "Part",
    "force_ellipsoid",
    "kinematic_conditioning",
    "manipulability",
    "normalise",
    "velocity_ellipsoid",
]

Frame: TypeAlias = Literal["spatial", "body", "geometric"]
"""Name of one of the three Jacobians of :class:`dexterity.chain.Chain`."""

Part: TypeAlias = Literal["full", "translational", "rotational"]
"""All six rows of a Jacobian, its first three, or its last three."""


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
    return _singular_values(J).prod(-1)


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
    sigma = _singular_values(J)
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
    J = _matrices(J)
    joint_rates = spatial.to_float64(joint_rates, "joint_rates").to(J.device)
    tool_rates = spatial.to_float64(tool_rates, "tool_rates").to(J.device)
    if joint_rates.shape != J.shape[-1:]:
        raise ValueError(f"joint_rates has shape {tuple(joint_rates.shape)}; ({J.shape[-1]},) is needed")
    if tool_rates.shape != J.shape[-2:-1]:
        raise ValueError(f"tool_rates has shape {tuple(tool_rates.shape)}; ({J.shape[-2]},) is needed")
    if (joint_rates < 0).any():
        raise ValueError(f"joint_rates holds a negative rate: {joint_rates.tolist()}")
    if (tool_rates <= 0).any():
        raise ValueError(f"tool_rates must be positive: {tool_rates.tolist()}")
    return J * joint_rates / tool_rates[:, None]


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
    return Ellipsoid(axes, _padded(sigma, rows.shape[-2]))


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


@dataclass(frozen=True)
class Index:
    """A dexterity index together with the frame and the limits that give it a meaning.

    Parameters
    ----------
    name
        ``"manipulability"`` or ``"kinematic_conditioning"``.
    frame
        Which Jacobian: ``"spatial"`` (the papers'), ``"body"`` or ``"geometric"``. The manipulability
        is the same in all three while the tool rates are equal within each block of three; the
        kinematic conditioning index is not.
    joint_rates
        n largest joint rates, [rad/s] or [m/s]; those of the chain by default.
    tool_rates
        6 largest tool rates, [m/s] and [rad/s], in the axes of the frame; 1 by default.

    Raises
    ------
    ValueError
        If the name or the frame is unknown.
    """

    name: str
    frame: Frame = "spatial"
    joint_rates: tuple[float, ...] | None = None
    tool_rates: tuple[float, ...] | None = None

    def __post_init__(self) -> None:
        if self.name not in _MEASURES:
            near = difflib.get_close_matches(self.name, _MEASURES, n=1, cutoff=0.0)
            raise ValueError(f"name is {self.name!r}; {sorted(_MEASURES)} are known. Nearest: {near[0]}")
        if self.frame not in get_args(Frame):
            raise ValueError(f"frame is {self.frame!r}; {get_args(Frame)} are known")
        for field in ("joint_rates", "tool_rates"):
            rates = getattr(self, field)
            if rates is not None:
                object.__setattr__(self, field, tuple(float(rate) for rate in rates))

    def bind(self, chain: Chain) -> Callable[[TensorLike], Float64[Tensor, "*batch"]]:
        """Return the index as a function of the chain's joint values: (..., n) → (...).

        Raises
        ------
        ValueError
            If the rates do not fit the chain.
        """
        measure = _MEASURES[self.name]
        jacobian = getattr(chain, f"{self.frame}_jacobian")
        joint_rates = chain.rates if self.joint_rates is None else self.joint_rates
        tool_rates = (1.0,) * 6 if self.tool_rates is None else self.tool_rates
        normalise(torch.zeros(6, chain.joints), joint_rates, tool_rates)

        def value(q: TensorLike) -> Tensor:
            return measure(normalise(jacobian(q), joint_rates, tool_rates))

        return value


_MEASURES: dict[str, Callable[[TensorLike], Tensor]] = {
    "manipulability": manipulability,
    "kinematic_conditioning": kinematic_conditioning,
}


def _matrices(J: TensorLike) -> Tensor:
    J = spatial.to_float64(J, "J")
    if J.ndim < 2 or 0 in J.shape[-2:]:
        raise ValueError(f"J has shape {tuple(J.shape)}; (..., rows, joints) is needed")
    return J


def _rows(J: TensorLike, part: Part) -> Tensor:
    J = _matrices(J)
    if J.shape[-2] != 6:
        raise ValueError(f"J has {J.shape[-2]} rows; 6 are needed")
    if part not in get_args(Part):
        raise ValueError(f"part is {part!r}; {get_args(Part)} are known")
    return {"full": J, "translational": J[..., :3, :], "rotational": J[..., 3:, :]}[part]


def _singular_values(J: TensorLike) -> Tensor:
    J = _matrices(J)
    return _padded(torch.linalg.svdvals(J), J.shape[-2])


def _padded(sigma: Tensor, rows: int) -> Tensor:
    """Add the zero singular values of a Jacobian with fewer joints than rows."""
    return torch.nn.functional.pad(sigma, (0, rows - sigma.shape[-1]))
