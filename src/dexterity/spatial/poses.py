"""Rigid-body poses and twists: hat and vee, exponential, logarithm, adjoint.

Twists are [v; ω], poses are homogeneous 4×4 matrices, and every function works on any number of
leading batch axes. Formulas follow Murray, Li & Sastry (1994), chapter 2 and appendix A; the series
and the quaternion keep them exact to rounding near zero and near a rotation by π.

Examples
--------
>>> import math
>>> import dexterity as dx
>>> T = dx.spatial.exp([0, 0, 0, 0, 0, math.pi / 2])
>>> T[:2, :2].round(decimals=9).abs().tolist()
[[0.0, 1.0], [1.0, 0.0]]
>>> dx.spatial.adjoint(T).shape
torch.Size([6, 6])
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import reduce

import torch
from jaxtyping import Float64
from torch import Tensor

from dexterity.spatial.tolerances import ROUNDING, SIX_DIGITS
from dexterity.spatial.values import (
    TensorLike,
    are_readable,
    as_float64,
    batch_of,
    common_batch,
    on_one_device,
    require_finite_result,
    to_float64,
)

__all__ = [
    "adjoint",
    "apply",
    "compose",
    "exp",
    "hat",
    "inverse",
    "inverse_adjoint",
    "log",
    "pose",
    "require_rigid",
    "require_rotation",
    "rotation_miss",
    "translation",
    "vee",
    "wrap_to_pi",
]


def pose(rotation: TensorLike, translation: TensorLike) -> Float64[Tensor, "*batch 4 4"]:
    """Join a rotation matrix (..., 3, 3) and a translation (..., 3) [m] to a pose.

    Raises
    ------
    ValueError
        If the shapes do not fit or the rotation is not orthonormal with determinant +1, to six digits.
    """
    R = batch_of(rotation, "rotation", (3, 3))
    p = batch_of(translation, "translation", (3,))
    R, p = on_one_device(rotation=R, translation=p)
    batch = common_batch(rotation=R.shape[:-2], translation=p.shape[:-1])
    T = assemble(R.expand(*batch, 3, 3), p.expand(*batch, 3))
    return require_rigid(T, "rotation")


def translation(x: TensorLike, y: TensorLike, z: TensorLike) -> Float64[Tensor, "*batch 4 4"]:
    """Pose without a rotation, moved by x, y and z [m], each a number or (...).

    Raises
    ------
    ValueError
        If something is not finite or the shapes do not broadcast.
    """
    parts = {name: to_float64(part, name) for name, part in (("x", x), ("y", y), ("z", z))}
    batch = common_batch(**{name: part.shape for name, part in parts.items()})
    p = torch.stack([part.expand(batch) for part in on_one_device(**parts)], dim=-1)
    return assemble(torch.eye(3, dtype=p.dtype, device=p.device).expand(*batch, 3, 3), p)


def rotation_miss(matrix: TensorLike) -> Float64[Tensor, "*batch"]:
    r"""Largest element of :math:`|R^\top R - I|`: by how much a rotation misses orthonormality.

    Parameters
    ----------
    matrix
        (..., 3, 3) or (..., 4, 4), of which the rotation block counts.

    Raises
    ------
    ValueError
        If the shape does not fit or something is not finite.
    """
    matrix = to_float64(matrix, "matrix")
    if matrix.shape[-2:] not in ((3, 3), (4, 4)):
        raise ValueError(f"matrix has shape {tuple(matrix.shape)}; its last axes must be 3 × 3 or 4 × 4")
    R = matrix[..., :3, :3]
    return (R.mT @ R - torch.eye(3, dtype=R.dtype, device=R.device)).abs().amax((-2, -1))


def require_rigid(T: TensorLike, name: str) -> Float64[Tensor, "*batch 4 4"]:
    """Return `T` as a tensor if it is a rigid-body pose.

    A rotation that misses orthonormality by more than rounding and by at most 1e-5, such as one in single
    precision or with six printed digits, is replaced by its nearest rotation (see
    :mod:`dexterity.spatial.tolerances`); :func:`rotation_miss` says by how much it missed, and
    :func:`dexterity.spatial.nearest_rigid` repairs larger misses. While torch traces or transforms a
    function, neither is looked at.

    Raises
    ------
    ValueError
        If the shape is not (..., 4, 4), the last row is not 0 0 0 1, or the rotation block is not
        orthonormal with determinant +1.
    """
    T = batch_of(T, name, (4, 4))
    if T.numel() == 0 or not are_readable(T):
        return T
    R, last_row = T[..., :3, :3], T[..., 3, :]
    if (last_row - last_row.new_tensor([0, 0, 0, 1])).abs().max() > SIX_DIGITS:
        raise ValueError(f"{name} is not a rigid-body pose: its last row is not 0 0 0 1")
    miss = rotation_miss(R)
    worst = float(miss.detach().max())
    if not worst <= SIX_DIGITS:
        raise ValueError(
            f"{name} is not a rigid-body pose: its rotation misses orthonormality by {worst:.1e}, "
            f"and more than {SIX_DIGITS:g} is not rounding; dexterity.spatial.nearest_rigid repairs it"
        )
    if (torch.linalg.det(R) < 0).any():
        raise ValueError(f"{name} is not a rigid-body pose: its rotation is a reflection (determinant -1)")
    if worst <= ROUNDING:
        return T
    mended = assemble(polar_rotation(R), T[..., :3, 3])
    return torch.where((miss > ROUNDING)[..., None, None], mended, T)


def require_rotation(R: TensorLike, name: str) -> Float64[Tensor, "*batch 3 3"]:
    """Return `R` as a tensor if it is a rotation, taken as :func:`require_rigid` takes that of a pose.

    Raises
    ------
    ValueError
        If the shape is not (..., 3, 3), or it is not orthonormal with determinant +1.
    """
    R = batch_of(R, name, (3, 3))
    return require_rigid(assemble(R, R.new_zeros(*R.shape[:-2], 3)), name)[..., :3, :3]


def hat(vector: TensorLike) -> Tensor:
    """Matrix form of a rotation vector or of a twist.

    Parameters
    ----------
    vector
        Rotation vectors (..., 3) or twists (..., 6).

    Returns
    -------
    Skew-symmetric (..., 3, 3), or twist matrices (..., 4, 4) with zero last row.

    Raises
    ------
    ValueError
        If the last axis is neither 3 nor 6.
    """
    vector = to_float64(vector, "vector")
    if vector.shape[-1:] == (3,):
        return skew(vector)
    if vector.shape[-1:] == (6,):
        v, omega = vector[..., :3], vector[..., 3:]
        return torch.nn.functional.pad(torch.cat([skew(omega), v[..., None]], dim=-1), (0, 0, 0, 1))
    raise ValueError(f"vector has shape {tuple(vector.shape)}; its last axis must be 3 or 6")


def vee(matrix: TensorLike) -> Tensor:
    """Vector form of a skew-symmetric (..., 3, 3) or twist matrix (..., 4, 4): the inverse of :func:`hat`.

    Raises
    ------
    ValueError
        If the matrix is not of that form (to 1e-9).
    """
    matrix = to_float64(matrix, "matrix")
    if matrix.shape[-2:] not in ((3, 3), (4, 4)):
        raise ValueError(f"matrix has shape {tuple(matrix.shape)}; its last axes must be 3 × 3 or 4 × 4")
    S = matrix[..., :3, :3]
    omega = torch.stack([S[..., 2, 1], S[..., 0, 2], S[..., 1, 0]], dim=-1)
    vector = omega if matrix.shape[-1] == 3 else torch.cat([matrix[..., :3, 3], omega], dim=-1)
    if matrix.numel() and are_readable(matrix) and (hat(vector) - matrix).abs().max() > ROUNDING:
        raise ValueError("matrix is not the hat of a vector: it is not skew-symmetric over a zero last row")
    return vector


def exp(twist: TensorLike) -> Float64[Tensor, "*batch 4 4"]:
    r"""Pose reached by following a constant twist for unit time.

    :math:`e^{\hat\xi} = \begin{bmatrix} e^{\hat\omega} & V(\omega)\,v \\ 0 & 1 \end{bmatrix}` with
    :math:`V = I + \frac{1-\cos\theta}{\theta^2}\hat\omega + \frac{\theta-\sin\theta}{\theta^3}\hat\omega^2`.

    Parameters
    ----------
    twist
        (..., 6), rows [v; ω]: [m] and [rad].

    Raises
    ------
    ValueError
        If the last axis is not 6, a value is not finite, or the values are so large that their squares
        overflow.

    References
    ----------
    Murray, Li & Sastry (1994), Eqs. 2.14, 2.32 and 2.36.
    """
    twist = batch_of(twist, "twist", (6,))
    v, omega = twist[..., :3], twist[..., 3:]
    W = skew(omega)
    a, b, c = (f[..., None, None] for f in _exponential_factors((omega * omega).sum(-1)))
    identity = torch.eye(3, dtype=twist.dtype, device=twist.device)
    V = identity + b * W + c * (W @ W)
    T = assemble(identity + a * W + b * (W @ W), (V @ v[..., None])[..., 0])
    return require_finite_result(T, "twist")


def log(T: TensorLike) -> Float64[Tensor, "*batch 6"]:
    r"""Twist of rotation angle at most π whose exponential is the pose.

    At a rotation by exactly π both axes are right; the one whose first non-zero component is positive
    is returned.

    Parameters
    ----------
    T
        Poses (..., 4, 4).

    Returns
    -------
    Twists (..., 6), rows [v; ω]: [m] and [rad].

    Raises
    ------
    ValueError
        If `T` is not a rigid-body pose.

    References
    ----------
    Murray, Li & Sastry (1994), Eqs. 2.17 and 2.40; the rotation goes through the unit quaternion,
    which loses no digits near zero and near π (Shepperd 1978).
    """
    T = require_rigid(T, "T")
    omega = _rotation_vector(T[..., :3, :3])
    W = skew(omega)
    d = inverse_factor((omega * omega).sum(-1))[..., None, None]
    V_inverse = torch.eye(3, dtype=T.dtype, device=T.device) - 0.5 * W + d * (W @ W)
    twist = torch.cat([(V_inverse @ T[..., :3, 3:])[..., 0], omega], dim=-1)
    return require_finite_result(twist, "T")


def apply(T: TensorLike, p: TensorLike) -> Float64[Tensor, "*batch 3"]:
    """Return points moved by poses, R p + t; leading axes are matched up.

    Parameters
    ----------
    T
        (..., 4, 4) poses; whether they are rigid is not checked.
    p
        (..., 3) points [m].

    Raises
    ------
    ValueError
        If a shape does not fit or something is not finite.
    """
    T = batch_of(T, "T", (4, 4))
    T, p = on_one_device(T=T, p=batch_of(p, "p", (3,)))
    common_batch(T=T.shape[:-2], p=p.shape[:-1])
    return (T[..., :3, :3] @ p[..., None])[..., 0] + T[..., :3, 3]


def wrap_to_pi(angle: TensorLike) -> Float64[Tensor, "*batch"]:
    """Return the copy of an angle [rad] from −π to π; NaN for an angle that is infinite or NaN.

    Raises
    ------
    TypeError
        If the elements are not real numbers.
    """
    return torch.remainder(as_float64(angle, "angle") + torch.pi, 2 * torch.pi) - torch.pi


def adjoint(T: TensorLike) -> Float64[Tensor, "*batch 6 6"]:
    r"""Matrix that moves twists [v; ω] from frame b to frame a: :math:`\mathrm{Ad}_{T_{ab}}`.

    Raises
    ------
    ValueError
        If `T` is not a rigid-body pose (..., 4, 4).

    References
    ----------
    Murray, Li & Sastry (1994), Eq. 2.58.
    """
    T = require_rigid(T, "T")
    R, p = T[..., :3, :3], T[..., :3, 3]
    top = torch.cat([R, skew(p) @ R], dim=-1)
    bottom = torch.cat([torch.zeros_like(R), R], dim=-1)
    return require_finite_result(torch.cat([top, bottom], dim=-2), "T")


def inverse_adjoint(T: TensorLike) -> Float64[Tensor, "*batch 6 6"]:
    """Inverse of :func:`adjoint`, in closed form."""
    return adjoint(inverse(T))


def compose(*poses: TensorLike) -> Float64[Tensor, "*batch 4 4"]:
    """Product of poses from left to right, ``compose(T_a_b, T_b_c) = T_a_c``; batch axes broadcast.

    Raises
    ------
    ValueError
        If there is no pose, one is not of shape (..., 4, 4), or the batch axes do not broadcast.
    """
    if not poses:
        raise ValueError("poses is empty; at least one is needed")
    checked = [batch_of(T, f"poses[{i}]", (4, 4)) for i, T in enumerate(poses)]
    checked = list(on_one_device(**{f"poses[{i}]": T for i, T in enumerate(checked)}))
    common_batch(**{f"poses[{i}]": T.shape[:-2] for i, T in enumerate(checked)})
    # A product of one pose is a copy: what is returned never changes with the caller's array.
    product = reduce(torch.matmul, checked) if len(checked) > 1 else checked[0].clone()
    return require_finite_result(product, "T")


def inverse(T: TensorLike) -> Float64[Tensor, "*batch 4 4"]:
    """Inverse of rigid-body poses (..., 4, 4), in closed form.

    Raises
    ------
    ValueError
        If `T` is not a rigid-body pose.
    """
    return require_finite_result(inverse_of_rigid(require_rigid(T, "T")), "T")


_SERIES_BELOW = 0.25  # θ²; the series below are cut where their next term is under 1e-17 there


def assemble(R: Tensor, p: Tensor) -> Tensor:
    top = torch.cat([R, p[..., None]], dim=-1)
    last_row = top.new_tensor([0.0, 0.0, 0.0, 1.0]).expand(*top.shape[:-2], 1, 4)
    return torch.cat([top, last_row], dim=-2)


def inverse_of_rigid(T: Tensor) -> Tensor:
    R_transposed = T[..., :3, :3].mT
    return assemble(R_transposed, -(R_transposed @ T[..., :3, 3:])[..., 0])


def skew(omega: Tensor) -> Tensor:
    x, y, z = omega.unbind(-1)
    zero = torch.zeros_like(x)
    return torch.stack([zero, -z, y, z, zero, -x, -y, x, zero], dim=-1).unflatten(-1, (3, 3))


def _exponential_factors(theta_squared: Tensor) -> tuple[Tensor, Tensor, Tensor]:
    """Return sin θ/θ, (1 - cos θ)/θ² and (θ - sin θ)/θ³ at any θ ≥ 0, differentiable at zero."""
    small = theta_squared < _SERIES_BELOW
    s = torch.where(small, theta_squared, 0.0)
    series = [
        _horner(s, [1, -1 / 6, 1 / 120, -1 / 5040, 1 / 362880, -1 / 39916800, 1 / 6227020800]),
        _horner(s, [1 / 2, -1 / 24, 1 / 720, -1 / 40320, 1 / 3628800, -1 / 479001600, 1 / 87178291200]),
        _horner(s, [1 / 6, -1 / 120, 1 / 5040, -1 / 362880, 1 / 39916800, -1 / 6227020800]),
    ]
    theta = torch.where(small, 1.0, theta_squared).sqrt()
    direct = [
        theta.sin() / theta,
        2 * ((theta / 2).sin() / theta) ** 2,
        (theta - theta.sin()) / theta**3,
    ]
    a, b, c = (torch.where(small, near, far) for near, far in zip(series, direct, strict=True))
    return a, b, c


def inverse_factor(theta_squared: Tensor) -> Tensor:
    """Return (1 - (θ/2) cot(θ/2))/θ² for 0 ≤ θ ≤ π, differentiable at zero."""
    small = theta_squared < _SERIES_BELOW
    s = torch.where(small, theta_squared, 0.0)
    series = _horner(
        s, [1 / 12, 1 / 720, 1 / 30240, 1 / 1209600, 1 / 47900160, 691 / 1307674368000, 1 / 74724249600]
    )
    theta = torch.where(small, 1.0, theta_squared).sqrt()
    direct = (1 - (theta / 2) * (theta / 2).cos() / (theta / 2).sin()) / theta**2
    return torch.where(small, series, direct)


def _horner(x: Tensor, coefficients: Sequence[float]) -> Tensor:
    total = torch.full_like(x, coefficients[-1])
    for coefficient in reversed(coefficients[:-1]):
        total = total * x + coefficient
    return total


def _rotation_vector(R: Tensor) -> Tensor:
    q = unit_quaternion(R)
    w, xyz = q[..., 0], q[..., 1:]
    n_squared = (xyz * xyz).sum(-1)
    small = n_squared < 1e-4
    t = torch.where(small, n_squared / torch.where(small, w, 1.0) ** 2, 0.0)
    near = 2 / torch.where(small, w, 1.0) * _horner(t, [1, -1 / 3, 1 / 5, -1 / 7, 1 / 9])
    n = torch.where(small, 1.0, n_squared).sqrt()
    far = 2 * torch.atan2(n, w) / n
    return torch.where(small, near, far)[..., None] * xyz


def unit_quaternion(R: Tensor) -> Tensor:
    """Quaternion (w, x, y, z) with w ≥ 0, from the row of 4 q qᵀ whose diagonal entry is largest."""
    (r00, r01, r02), (r10, r11, r12), (r20, r21, r22) = (row.unbind(-1) for row in R.unbind(-2))
    one = torch.ones_like(r00)
    outer = torch.stack(
        [
            torch.stack([one + r00 + r11 + r22, r21 - r12, r02 - r20, r10 - r01], dim=-1),
            torch.stack([r21 - r12, one + r00 - r11 - r22, r01 + r10, r02 + r20], dim=-1),
            torch.stack([r02 - r20, r01 + r10, one - r00 + r11 - r22, r12 + r21], dim=-1),
            torch.stack([r10 - r01, r02 + r20, r12 + r21, one - r00 - r11 + r22], dim=-1),
        ],
        dim=-2,
    )
    largest = outer.diagonal(dim1=-2, dim2=-1).argmax(-1)[..., None]
    row = torch.take_along_dim(outer, largest[..., None], dim=-2)[..., 0, :]
    q = row / (2 * torch.take_along_dim(row, largest, dim=-1).sqrt())
    q = q / torch.linalg.vector_norm(q, dim=-1, keepdim=True)
    return q * _sign_of_first_nonzero(q)


def _sign_of_first_nonzero(q: Tensor) -> Tensor:
    first = (q != 0).to(torch.int8).argmax(-1, keepdim=True)
    return torch.take_along_dim(q, first, dim=-1).sign().detach()


def polar_rotation(M: Tensor) -> Tensor:
    """Rotation nearest to matrices (..., 3, 3) with a positive determinant.

    The singular vectors have no gradient where singular values meet, as they do near a rotation. So they only
    give the start: each of two steps of Newton on the condition that RᵀM is symmetric adds to the order of
    the derivatives, the third included.
    """
    U, _, Vh = torch.linalg.svd(M.detach())
    R = U @ Vh
    identity = torch.eye(3, dtype=M.dtype, device=M.device)
    for _ in range(2):
        product = R.mT @ M
        difference, symmetric = product - product.mT, (product + product.mT) / 2
        trace = symmetric.diagonal(dim1=-2, dim2=-1).sum(-1)[..., None, None]
        turn = torch.stack([difference[..., 2, 1], difference[..., 0, 2], difference[..., 1, 0]], dim=-1)
        omega = torch.linalg.solve(trace * identity - symmetric, turn[..., None])[..., 0]
        W = skew(omega)
        a, b, _ = (f[..., None, None] for f in _exponential_factors((omega * omega).sum(-1)))
        R = R @ (identity + a * W + b * (W @ W))
    return R
