"""Screws checked and mended, constant links between joint frames, and motions along or about z.

Each joint carries a frame with z along its axis, so that the product of exponentials becomes
L₀ Z(q₁) L₁ Z(q₂) … Z(qₙ) Lₙ with constant links Lᵢ and motions Z along or about z: a motion then mixes two
columns of a rotation instead of multiplying 4×4 matrices.

Examples
--------
>>> import torch
>>> from dexterity.chain import geometry
>>> screw = torch.tensor([0, 0, 0, 0, 0.6, 0.8], dtype=torch.float32).double()
>>> kind, mended, miss = geometry.checked_screw(screw, 0)
>>> kind, abs(float(mended[3:].norm()) - 1) < 1e-15, 1e-9 < miss < 1e-7
('revolute', True, True)
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from itertools import pairwise
from typing import Literal, TypeAlias

import torch
from torch import Tensor

from dexterity.spatial.poses import adjoint, assemble, inverse, inverse_of_rigid
from dexterity.spatial.tolerances import ROUNDING, SIX_DIGITS
from dexterity.spatial.values import require_finite_result

__all__ = [
    "JointKind",
    "checked_screw",
    "homogeneous",
    "link_transforms",
    "move_along_z",
    "turn_about_z",
    "warn_of_millimetres",
]

JointKind: TypeAlias = Literal["revolute", "prismatic"]
"""What a joint does, turn about its axis or slide along it."""


LARGE = 100.0
"""Extent [m] of a robot that is hardly meant in metres."""


def warn_of_millimetres(name: str, screws: Tensor, home: Tensor, base: Tensor) -> None:
    """Warn of a robot whose axes (n, 6) or tool (4, 4) lie as far from its base (4, 4) as in millimetres."""
    axes = screws @ adjoint(inverse(base)).mT
    points = torch.cat([torch.linalg.cross(axes[:, 3:], axes[:, :3]), (home - base)[None, :3, 3]])
    extent = float(points.abs().max())
    if extent > LARGE:
        warnings.warn(
            f"{name} extends over {extent:.0f} m: lengths are in metres, and these seem to be millimetres",
            stacklevel=3,
        )


def checked_screw(screw: Tensor, i: int) -> tuple[JointKind, Tensor, float]:
    """Return the kind of a joint, its screw, and by how much the screw as it was given missed its form.

    A screw that is right to six digits (:mod:`dexterity.spatial.tolerances`) is replaced by the nearest one
    with an axis of unit length and without pitch.

    Raises
    ------
    ValueError
        If screw `i` is neither revolute nor prismatic, or its axis is not of unit length.
    """
    v, omega = screw[:3], screw[3:]
    turn, slide = float(omega.norm()), float(v.norm())
    if turn <= SIX_DIGITS and (turn == 0 or abs(slide - 1) <= SIX_DIGITS):
        miss = max(turn, _length_miss(slide, i, "is prismatic with an axis"))
        if miss <= ROUNDING:
            return "prismatic", torch.cat([v, torch.zeros_like(v)]), 0.0
        return "prismatic", torch.cat([v / slide, torch.zeros_like(v)]), miss
    length_miss = _length_miss(turn, i, "has an axis of rotation")
    axis = omega / turn
    pitch = float(axis @ v)
    pitch_miss = abs(pitch) / max(1.0, slide)
    if pitch_miss > SIX_DIGITS:
        raise ValueError(
            f"screws[{i}] has a pitch of {pitch:.6g} m/rad; it is neither revolute (0) nor prismatic"
        )
    miss = max(length_miss, pitch_miss)
    if miss <= ROUNDING:
        return "revolute", screw.clone(), 0.0
    return "revolute", torch.cat([v - pitch * axis, axis]), miss


def _length_miss(length: float, i: int, what: str) -> float:
    miss = abs(length - 1)
    if miss > SIX_DIGITS:
        by = f", which misses 1 by {miss:.1e}" if 0 < miss < 1e-3 else ""
        raise ValueError(f"screws[{i}] {what} of length {length:.6g}{by}; 1 is needed, to {SIX_DIGITS:g}")
    return miss


def link_transforms(screws: Tensor, kinds: Sequence[JointKind], home: Tensor) -> Tensor:
    """Constant transforms between successive joint frames at home, from the world to the tool."""
    frames = [torch.eye(4, dtype=screws.dtype, device=screws.device)]
    for screw, kind in zip(screws, kinds, strict=True):
        frames.append(_joint_frame(screw, kind, near=frames[-1][:3, 3]))
    frames.append(home)
    links = torch.stack([inverse_of_rigid(a) @ b for a, b in pairwise(frames)])
    return require_finite_result(links, "home")


def _joint_frame(screw: Tensor, kind: JointKind, near: Tensor) -> Tensor:
    """Frame with z along the joint's axis and its origin at the axis point nearest to `near`."""
    v, omega = screw[:3], screw[3:]
    if kind == "prismatic":
        return assemble(_rotation_with_z(v), near)
    on_axis = torch.linalg.cross(omega, v)
    return assemble(_rotation_with_z(omega), on_axis + omega * (omega @ (near - on_axis)))


def _rotation_with_z(axis: Tensor) -> Tensor:
    """Rotation whose third column is `axis`; a signed permutation where the axis is a coordinate axis."""
    z = axis / axis.norm()
    across = torch.zeros_like(z)
    across[(int(z.abs().argmax()) + 1) % 3] = 1.0
    x = across - z * (z @ across)
    x = x / x.norm()
    return torch.stack([x, torch.linalg.cross(z, x), z], dim=1)


def turn_about_z(frame: Tensor, angle: Tensor) -> Tensor:
    """Turn frames, given as (4 columns, 3 rows, N), about their z axes by N angles [rad]."""
    x, y, z, p = frame
    c, s = angle.cos(), angle.sin()
    return torch.stack([c * x + s * y, c * y - s * x, z, p])


def move_along_z(frame: Tensor, distance: Tensor) -> Tensor:
    """Move frames, given as (4 columns, 3 rows, N), along their z axes by N distances [m]."""
    x, y, z, p = frame
    return torch.stack([x, y, z, p + distance * z])


def homogeneous(frame: Tensor) -> Tensor:
    """Turn (4 columns, 3 rows, N) into N poses (N, 4, 4)."""
    top = frame.permute(2, 1, 0)
    last_row = top.new_tensor([0.0, 0.0, 0.0, 1.0]).expand(len(top), 1, 4)
    return torch.cat([top, last_row], dim=1)
