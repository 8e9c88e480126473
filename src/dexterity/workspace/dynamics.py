"""Inertia of the arms of paper C as the tool point feels it, and how evenly: Asada's ratio.

The paper keeps a pose in its Jacobian data only if the arm's inertia at the tool point is even enough. The
dynamic parameters decide that, and nothing else: no label depends on them.

Examples
--------
>>> from dexterity import spatial
>>> from dexterity.workspace import dataset, dynamics, reachability
>>> samples = dataset.jacobian_data(count=20, seed=0, poses=5).samples
>>> q, _ = reachability.inverse(
...     samples.links, spatial.pose(samples.rotation(), samples.position)
... )
>>> bool((dynamics.asada_ratio(samples.links, samples.dynamics, q) >= 0.03).all())
True
"""

from __future__ import annotations

from typing import NamedTuple

import torch
from jaxtyping import Float64
from torch import Tensor

from dexterity import checks, spatial
from dexterity.spatial import TensorLike
from dexterity.spatial.values import beside
from dexterity.workspace.reachability import Frames, frames

__all__ = ["DynamicParameters", "asada_ratio", "cartesian_inertia", "joint_inertia"]

_SINGULAR = 1e-9  # [m³] of the determinant of the Jacobian, below which a pose has no inertia at its tool


class DynamicParameters(NamedTuple):
    """What the six links weigh and how the motors turn; each with leading batch axes.

    Attributes
    ----------
    mass
        (..., 6) [kg].
    centre
        (..., 6, 3) centres of mass in the links' frames [m].
    inertia
        (..., 6, 3) principal moments about the centres of mass, along the axes of the links' frames [kg m²].
    viscous
        (..., 6) viscous friction [N m s/rad].
    coulomb
        (..., 6, 2) Coulomb friction forwards and backwards [N m].
    gear
        (..., 6) gear ratios; the sign is the motor's sense.
    motor
        (..., 6) moments of inertia of the motors [kg m²].
    """

    mass: Tensor
    centre: Tensor
    inertia: Tensor
    viscous: Tensor
    coulomb: Tensor
    gear: Tensor
    motor: Tensor

    def rows(self, where: Tensor) -> DynamicParameters:
        """Return the parameters of some manipulators of a batch, by their numbers or by a mask."""
        return DynamicParameters(*(part[where] for part in self))


def joint_inertia(
    links: TensorLike, dynamics: DynamicParameters, q: TensorLike
) -> Float64[Tensor, "*batch 6 6"]:
    """Inertia matrix M(q) of the arm with its motors.

    Parameters
    ----------
    links
        (..., 4) d₃, d₄, a₂, a₃ [m].
    dynamics
        Parameters with the same batch axes. Friction plays no part.
    q
        (..., 6) joint angles [rad].

    Returns
    -------
    Torque per joint acceleration [kg m²].

    Raises
    ------
    ValueError
        If a shape does not fit, a length is negative, or something is not finite.
    TypeError
        If `dynamics` are no dynamic parameters, or what is needed as numbers is none.

    References
    ----------
    Siciliano et al. (2009), Robotics: Modelling, Planning and Control, Eq. 7.32.
    """
    return _joint_inertia(*_placed(links, dynamics, q))


def _placed(
    links: TensorLike, dynamics: DynamicParameters, q: TensorLike
) -> tuple[Frames, DynamicParameters]:
    checks.instance(dynamics, "dynamics", DynamicParameters)
    placed = frames(links, q)
    parts, batches = [], {"q": placed.origins.shape[:-2]}
    for name, part in zip(DynamicParameters._fields, dynamics, strict=True):
        shape = _SHAPES.get(name, (6,))
        parts.append(spatial.batch_of(beside(part, name, placed.origins), name, shape))
        batches[name] = parts[-1].shape[: -len(shape)]
    batch = spatial.common_batch(**batches)
    rotations, origins = placed.rotations.expand(*batch, 7, 3, 3), placed.origins.expand(*batch, 7, 3)
    return Frames(rotations, origins), DynamicParameters(*parts)


_SHAPES = {"centre": (6, 3), "inertia": (6, 3), "coulomb": (6, 2)}


def _joint_inertia(placed: Frames, dynamics: DynamicParameters) -> Tensor:
    R, origins = placed.rotations[..., 1:, :, :], placed.origins
    axes = placed.rotations[..., :6, :, 2]
    centres = origins[..., 1:, :] + (R @ dynamics.centre[..., None])[..., 0]
    # A joint moves the links behind it.
    moves = torch.ones(6, 6, dtype=axes.dtype, device=axes.device).tril()[..., None]
    linear = moves * torch.linalg.cross(
        axes[..., None, :, :], centres[..., :, None, :] - origins[..., None, :6, :]
    )
    angular = moves * torch.einsum("...ikl,...jk->...ijl", R, axes)
    M = torch.einsum("...i,...ijk,...ilk->...jl", dynamics.mass, linear, linear)
    M = M + torch.einsum("...ik,...ijk,...ilk->...jl", dynamics.inertia, angular, angular)
    return M + torch.diag_embed(dynamics.gear.square() * dynamics.motor)


def cartesian_inertia(
    links: TensorLike, dynamics: DynamicParameters, q: TensorLike
) -> Float64[Tensor, "*batch 3 3"]:
    """Inertia of the tool point, the translational block of J⁻ᵀ M J⁻¹; zero where the arm is singular.

    The arguments and errors are those of :func:`joint_inertia`.

    Returns
    -------
    Force per acceleration of the tool point whose angular acceleration is zero [kg].

    References
    ----------
    Asada (1983), A geometrical representation of manipulator dynamics and its application to arm design.
    """
    return _cartesian_inertia(*_placed(links, dynamics, q))


def _cartesian_inertia(placed: Frames, dynamics: DynamicParameters) -> Tensor:
    M, J = _joint_inertia(placed, dynamics), placed.jacobian()
    regular = (torch.linalg.det(J).abs() >= _SINGULAR)[..., None, None]
    unit = torch.eye(6, dtype=J.dtype, device=J.device)
    rates = torch.linalg.solve(torch.where(regular, J, unit), unit[:, :3])
    return torch.where(regular, rates.mT @ M @ rates, 0.0)


def asada_ratio(links: TensorLike, dynamics: DynamicParameters, q: TensorLike) -> Float64[Tensor, "*batch"]:
    """Smallest over largest principal inertia at the tool point, from 0 to 1; 0 where the arm is singular.

    The arguments and errors are those of :func:`joint_inertia`.
    """
    return ratio_at(*_placed(links, dynamics, q))


def ratio_at(placed: Frames, dynamics: DynamicParameters) -> Float64[Tensor, "*batch"]:
    """Asada's ratio of arms whose frames are placed already."""
    inertia = _cartesian_inertia(placed, dynamics)
    if spatial.are_readable(inertia) and not inertia.isfinite().all():
        raise ValueError("links or dynamics hold numbers so large that an inertia is infinite")
    principal = torch.linalg.eigvalsh(inertia)
    largest = principal[..., 2]
    return torch.where(largest > 0, principal[..., 0] / torch.where(largest > 0, largest, 1.0), 0.0)
