r"""Masses of the links of a chain, and its mass matrix.

The mass matrix is that of the composite rigid bodies: with the inertia :math:`\mathcal I_k` about the tool
point of all links that move with joint k, :math:`M_{jk} = J_j^\top \mathcal I_k J_k` for :math:`j \le k`.

Examples
--------
>>> import dexterity as dx
>>> tensor = [[0, 0, 0], [0, 0.25, 0], [0, 0, 0.25]]
>>> rod = dx.Chain.from_dh([{"a": 1.0}], inertias=([3.0], [[0.5, 0, 0]], [tensor]))
>>> rod.mass_matrix([0.7]).tolist()  # m l² / 3
[[1.0]]

References
----------
Featherstone, Rigid Body Dynamics Algorithms (2008), section 6.2.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import torch
from jaxtyping import Float64
from torch import Tensor

from dexterity import checks, spatial
from dexterity.spatial import TensorLike
from dexterity.spatial.poses import skew
from dexterity.spatial.values import on_cpu

__all__ = ["Inertias", "checked_inertias", "mass_matrices"]

_SYMMETRY = 1e-6  # of the largest entry: numbers are printed with few digits


class Inertias(NamedTuple):
    """Masses of what moves with each joint but not with the next one, at home in the world frame.

    Attributes
    ----------
    masses
        (n,) masses [kg].
    centres
        (n, 3) centres of mass [m].
    tensors
        (n, 3, 3) inertias about the centres of mass, in world axes [kg m²].
    """

    masses: Float64[Tensor, " n"]
    centres: Float64[Tensor, "n 3"]
    tensors: Float64[Tensor, "n 3 3"]

    def no_body(self) -> str:
        """Say which tensor has a negative principal moment, as no body has; nothing if none has."""
        least, most = torch.linalg.eigvalsh(self.tensors)[:, [0, -1]].unbind(1)
        negative = (least < -_SYMMETRY * most.clamp(min=0)).nonzero().flatten().tolist()
        if not negative:
            return ""
        i = negative[0]
        moment = float(least[i])
        return f"inertias.tensors[{i}] has the principal moment {moment:.6g}, and no body a negative one"

    def moved(self, T: Tensor) -> Inertias:
        """Return the inertias after a rigid motion, one (4, 4) for all or (n, 4, 4)."""
        R = T[..., :3, :3]
        return Inertias(self.masses.clone(), spatial.apply(T, self.centres), R @ self.tensors @ R.mT)

    def merged(self, groups: Sequence[Sequence[int]]) -> Inertias:
        """Return one body for each group of bodies."""
        bodies = [self._together(list(group)) for group in groups]
        masses, centres, tensors = zip(*bodies, strict=True)
        return Inertias(torch.stack(masses), torch.stack(centres), torch.stack(tensors))

    def _together(self, group: list[int]) -> tuple[Tensor, Tensor, Tensor]:
        masses, centres = self.masses[group], self.centres[group]
        mass = masses.sum()
        centre = (masses @ centres) / mass if mass > 0 else centres[-1]
        steiner = masses[:, None, None] * _about_origin(centres - centre)
        return mass, centre, (self.tensors[group] + steiner).sum(0)


def checked_inertias(
    inertias: tuple[TensorLike, TensorLike, TensorLike], n: int, called: str = "inertias"
) -> Inertias:
    """Return inertias of n links on the CPU, without memory shared with the caller.

    Raises
    ------
    TypeError
        If `inertias` is not three arrays of numbers.
    ValueError
        If a shape does not fit, a value is not finite, a mass is negative, or a tensor is not symmetric.
    """
    if not isinstance(inertias, Sequence) or isinstance(inertias, str) or len(inertias) != 3:
        raise TypeError(
            f"{called} is {checks.shown(inertias)}; "
            "masses (n,), centres (n, 3) and tensors (n, 3, 3) are needed"
        )
    parts = []
    for name, values, shape in zip(Inertias._fields, inertias, [(n,), (n, 3), (n, 3, 3)], strict=True):
        tensor = on_cpu(values, f"{called}.{name}").detach().clone()
        if tuple(tensor.shape) != shape:
            raise ValueError(f"{called}.{name} has shape {tuple(tensor.shape)}; {shape} is needed")
        parts.append(tensor)
    masses, centres, tensors = parts
    if (masses < 0).any():
        raise ValueError(f"{called}.masses is {masses.tolist()}; masses must not be negative")
    if ((tensors - tensors.mT).abs() > _SYMMETRY * tensors.abs().amax((1, 2), keepdim=True)).any():
        raise ValueError(f"{called}.tensors is not symmetric")
    return Inertias(masses, centres, 0.5 * (tensors + tensors.mT))


def mass_matrices(
    inertias: Inertias, at_home: Tensor, frames: Sequence[Tensor], columns: Tensor, reference: Tensor
) -> Tensor:
    """Mass matrices (N, n, n) at N configurations.

    Parameters
    ----------
    inertias
        Of the n links, at home.
    at_home
        (n, 4, 4) frames of the joints at home.
    frames
        n frames of the joints at the configurations, (4 columns, 3 rows, N) each.
    columns
        (6, n, N) velocity of the reference point and angular velocity per unit rate of each joint.
    reference
        (3, N) reference point.
    """
    in_frames = inertias.moved(spatial.inverse(at_home))
    poses = torch.stack(list(frames)).permute(3, 0, 2, 1)  # (N, n, 3, 4)
    R, p = poses[..., :3], poses[..., 3]
    masses, centres, tensors = (part.to(p.device) for part in in_frames)
    centre = (R @ centres[..., None])[..., 0] + p - reference.T[:, None]
    coupling = masses[:, None, None] * skew(centre)
    linear = (masses[:, None, None] * torch.eye(3, dtype=p.dtype, device=p.device)).expand_as(coupling)
    about_reference = R @ tensors @ R.mT + masses[:, None, None] * _about_origin(centre)
    links = torch.cat(
        [torch.cat([linear, -coupling], dim=-1), torch.cat([coupling, about_reference], dim=-1)], dim=-2
    )
    composite = links.flip(1).cumsum(1).flip(1)  # of joint k: all links from k to the tool
    J = columns.permute(2, 1, 0)  # (N, n, 6)
    momenta = (composite @ J[..., None])[..., 0]
    product = momenta @ J.mT  # [k, j] = J_j · I_k J_k, which holds for j ≤ k
    return product.tril() + product.tril(-1).mT


def _about_origin(centres: Tensor) -> Tensor:
    """Inertia about the origin of a unit mass at each point, -[c]²."""
    W = skew(centres)
    return W @ W.mT
