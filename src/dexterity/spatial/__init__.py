"""Rigid-body poses and twists, rotations in other forms, and the checks of what a caller gives.

Twists are [v; ω], poses are homogeneous 4×4 matrices, and every function works on any number of leading batch
axes, on the device of its input, and under torch's compilation, export and function transforms.

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

from dexterity.spatial import tolerances
from dexterity.spatial.poses import (
    adjoint,
    apply,
    compose,
    exp,
    hat,
    inverse,
    inverse_adjoint,
    log,
    pose,
    require_rigid,
    require_rotation,
    rotation_miss,
    translation,
    vee,
    wrap_to_pi,
)
from dexterity.spatial.rotations import (
    QuaternionOrder,
    from_quaternion,
    from_rpy,
    nearest_rigid,
    nearest_rotation,
    quaternion,
    rpy,
)
from dexterity.spatial.values import (
    TensorLike,
    are_readable,
    batch_of,
    common_batch,
    differentiation,
    require_finite_result,
    require_joints,
    to_extended_float64,
    to_float64,
    value_and_gradient,
)

__all__ = [
    "QuaternionOrder",
    "TensorLike",
    "adjoint",
    "apply",
    "are_readable",
    "batch_of",
    "common_batch",
    "compose",
    "differentiation",
    "exp",
    "from_quaternion",
    "from_rpy",
    "hat",
    "inverse",
    "inverse_adjoint",
    "log",
    "nearest_rigid",
    "nearest_rotation",
    "pose",
    "quaternion",
    "require_finite_result",
    "require_joints",
    "require_rigid",
    "require_rotation",
    "rotation_miss",
    "rpy",
    "to_extended_float64",
    "to_float64",
    "tolerances",
    "translation",
    "value_and_gradient",
    "vee",
    "wrap_to_pi",
]
