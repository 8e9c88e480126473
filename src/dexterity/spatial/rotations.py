"""Rotations from and to quaternions and roll-pitch-yaw angles, and the rotation nearest to a matrix.

All functions take leading batch axes and are differentiable. What they return is a pose (4, 4), which the
other functions of the package take; a matrix that goes in may be (3, 3) or (4, 4).

Examples
--------
>>> import math
>>> import dexterity as dx
>>> T = dx.spatial.from_rpy([0, 0, math.pi / 2], [0.1, 0.2, 0.3])
>>> [round(x, 6) for x in dx.spatial.quaternion(T, order="xyzw").tolist()]
[0.0, 0.0, 0.707107, 0.707107]
>>> [round(x, 6) for x in dx.spatial.rpy(T).tolist()]
[0.0, 0.0, 1.570796]
>>> dx.spatial.nearest_rotation([[0.9999, 0, 0], [0, 1, 0.0001], [0, 0, 1]]).shape
torch.Size([3, 3])
"""

from __future__ import annotations

from typing import Literal, TypeAlias, get_args

import torch
from jaxtyping import Float64
from torch import Tensor

from dexterity import checks
from dexterity.spatial import poses
from dexterity.spatial.tolerances import SIX_DIGITS
from dexterity.spatial.values import TensorLike, are_readable, batch_of, to_float64

__all__ = [
    "QuaternionOrder",
    "from_quaternion",
    "from_rpy",
    "nearest_rigid",
    "nearest_rotation",
    "quaternion",
    "rpy",
]

QuaternionOrder: TypeAlias = Literal["xyzw", "wxyz"]
"""Where the real part stands, last (ROS, scipy, pinocchio) or first (Eigen's constructor, MuJoCo)."""


def nearest_rotation(matrix: TensorLike, *, largest_miss: float = 1e-2) -> Float64[Tensor, "*batch 3 3"]:
    r"""Rotation nearest to a matrix in the Frobenius norm: :math:`U V^\top` of its singular values.

    Parameters
    ----------
    matrix
        (..., 3, 3).
    largest_miss
        Largest element of :math:`|R^\top R - I|` that is still repaired; ``math.inf`` repairs every matrix
        with a positive determinant.

    Raises
    ------
    ValueError
        If the shape does not fit, a matrix misses by `largest_miss` or more, or its determinant is not
        positive: it is a reflection or flat.

    References
    ----------
    Schönemann (1966), A generalized solution of the orthogonal Procrustes problem.
    """
    bound = checks.real(largest_miss, "largest_miss", above=0, infinite=True)
    return _nearest(batch_of(matrix, "matrix", (3, 3)), bound, "matrix")


def nearest_rigid(T: TensorLike, *, largest_miss: float = 1e-2) -> Float64[Tensor, "*batch 4 4"]:
    """Pose with the nearest rotation and the same translation.

    Parameters
    ----------
    T
        (..., 4, 4) matrices; the last row is taken as 0 0 0 1.
    largest_miss
        As for :func:`nearest_rotation`.

    Raises
    ------
    ValueError
        As :func:`nearest_rotation`, or if the last row misses 0 0 0 1 by `largest_miss` or more.
    """
    T = batch_of(T, "T", (4, 4))
    bound = checks.real(largest_miss, "largest_miss", above=0, infinite=True)
    R = _nearest(T[..., :3, :3], bound, "T")
    last_row = T[..., 3, :] - T.new_tensor([0.0, 0.0, 0.0, 1.0])
    if are_readable(T) and (last_row.abs() >= bound).any():
        raise ValueError("T is not a rigid-body pose: its last row is not 0 0 0 1")
    return poses.assemble(R, T[..., :3, 3])


def _nearest(R: Tensor, bound: float, name: str) -> Tensor:
    if are_readable(R) and R.numel():
        if (torch.linalg.det(R) <= 0).any():
            raise ValueError(
                f"{name} is a reflection or flat (determinant not positive): no rotation is near"
            )
        miss = float(poses.rotation_miss(R).detach().max())
        if miss >= bound:
            raise ValueError(
                f"{name} misses orthonormality by {miss:.1e}; less than {bound:g} is needed, "
                "or a larger largest_miss"
            )
    return poses.polar_rotation(R)


def from_rpy(angles: TensorLike, translation: TensorLike = (0.0, 0.0, 0.0)) -> Float64[Tensor, "*batch 4 4"]:
    """Pose turned by roll, pitch and yaw about the fixed axes x, y and z, in this order: Rz Ry Rx.

    Parameters
    ----------
    angles
        (..., 3) roll, pitch, yaw [rad], as in a URDF.
    translation
        (..., 3) [m].

    Raises
    ------
    ValueError
        If a shape does not fit or something is not finite.
    """
    return poses.pose(rotation_of_rpy(batch_of(angles, "angles", (3,))), translation)


def rotation_of_rpy(angles: Float64[Tensor, "*batch 3"]) -> Float64[Tensor, "*batch 3 3"]:
    """Rotation of :func:`from_rpy`, of angles that were checked before."""
    (cr, cp, cy), (sr, sp, sy) = angles.cos().unbind(-1), angles.sin().unbind(-1)
    entries = [
        cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr,
        sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr,
        -sp, cp * sr, cp * cr,
    ]  # fmt: skip
    return torch.stack(entries, dim=-1).unflatten(-1, (3, 3))


def rpy(T: TensorLike) -> Float64[Tensor, "*batch 3"]:
    """Roll, pitch and yaw [rad] of a pose or rotation, the inverse of :func:`from_rpy`.

    Roll and yaw are from −π to π, pitch is from −π/2 to π/2. At a pitch of ±π/2 only the sum or difference of
    roll and yaw is defined; roll is 0 there.

    Parameters
    ----------
    T
        (..., 4, 4) poses or (..., 3, 3) rotations.

    Raises
    ------
    ValueError
        If `T` is not a rotation or a rigid-body pose.
    """
    R = _rotation_of(T)
    sine, cosine = R[..., 2, 1], R[..., 2, 2]
    # atan2 has no gradient where both are zero.
    locked = (sine == 0) & (cosine == 0)
    roll = torch.atan2(torch.where(locked, 0.0, sine), torch.where(locked, 1.0, cosine))
    c, s = roll.cos(), roll.sin()
    pitch = torch.atan2(-R[..., 2, 0], s * sine + c * cosine)
    yaw = torch.atan2(s * R[..., 0, 2] - c * R[..., 0, 1], c * R[..., 1, 1] - s * R[..., 1, 2])
    return torch.stack([roll, pitch, yaw], dim=-1)


def from_quaternion(
    quaternion: TensorLike, translation: TensorLike = (0.0, 0.0, 0.0), *, order: QuaternionOrder
) -> Float64[Tensor, "*batch 4 4"]:
    """Pose with the rotation of a unit quaternion.

    Parameters
    ----------
    quaternion
        (..., 4) of length 1; one that is right to six digits is taken at length 1.
    translation
        (..., 3) [m].
    order
        ``"xyzw"`` or ``"wxyz"``. Libraries differ, so there is no default.

    Raises
    ------
    ValueError
        If a shape does not fit, something is not finite, the order is unknown, or the length is not 1.
    """
    q = _ordered(batch_of(quaternion, "quaternion", (4,)), order, "wxyz")
    length = torch.linalg.vector_norm(q, dim=-1, keepdim=True)
    if are_readable(q) and ((length - 1).abs() > SIX_DIGITS).any():
        wrong = length.flatten()[(length - 1).abs().argmax()].item()
        raise ValueError(f"quaternion has length {wrong:.6g}; 1 is needed")
    w, x, y, z = (q / length).unbind(-1)
    entries = [
        1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y),
        2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x),
        2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y),
    ]  # fmt: skip
    return poses.pose(torch.stack(entries, dim=-1).unflatten(-1, (3, 3)), translation)


def quaternion(T: TensorLike, *, order: QuaternionOrder) -> Float64[Tensor, "*batch 4"]:
    """Return the unit quaternion of a pose or rotation.

    Of the two quaternions of a rotation, the one with the positive real part is returned; at a half turn,
    the one whose first imaginary part that is not zero is positive.

    Parameters
    ----------
    T
        (..., 4, 4) poses or (..., 3, 3) rotations.
    order
        ``"xyzw"`` or ``"wxyz"``.

    Raises
    ------
    ValueError
        If `T` is not a rotation or a rigid-body pose, or the order is unknown.

    References
    ----------
    Shepperd (1978), Quaternion from rotation matrix.
    """
    return _ordered(poses.unit_quaternion(_rotation_of(T)), "wxyz", order)


def _ordered(q: Tensor, given: QuaternionOrder, wanted: QuaternionOrder) -> Tensor:
    for order in (given, wanted):
        checks.choice(order, "order", get_args(QuaternionOrder))
    if given == wanted:
        return q
    return q.roll(1, dims=-1) if given == "xyzw" else q.roll(-1, dims=-1)


def _rotation_of(T: TensorLike) -> Tensor:
    T = to_float64(T, "T")
    if T.shape[-2:] == (3, 3):
        return poses.require_rotation(T, "T")
    return poses.require_rigid(T, "T")[..., :3, :3]
