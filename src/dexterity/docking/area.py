"""How dexterous an arm is over an area: Eqs. 1, 2 and 16 of Sotiropoulos, Aspragathos & Andritsos (2011).

The area is given by control points; at each the tool's orientation is fixed in the world. A point counts with
the best of the configurations that reach it within the joint limits, and the area with its worst point.

Examples
--------
>>> import dexterity as dx
>>> arm, corners = dx.robots.docking_arm(), dx.docking.square(0.2)
>>> solutions = dx.docking.configurations(arm, [-0.4, -0.2, 0.2, 0.84], corners)
>>> solutions.q.shape, solutions.within_limits.any(-1).tolist()
(torch.Size([4, 8, 6]), [True, True, True, True])
"""

from __future__ import annotations

import functools
import math
from typing import Literal, NamedTuple, TypeAlias, get_args

import torch
from jaxtyping import Float64
from torch import Tensor

from dexterity import checks, spatial
from dexterity.chain import Chain
from dexterity.collision import Bodies, CompiledBodies, in_c
from dexterity.docking.elbow import ElbowArm
from dexterity.docking.free_branches import FreeBranches, require_same_arm
from dexterity.inverse_kinematics import nearest_copy, spherical_wrist
from dexterity.spatial import TensorLike
from dexterity.spatial.poses import assemble
from dexterity.spatial.rotations import rotation_of_rpy
from dexterity.spatial.values import on_cpu

__all__ = [
    "TOOL_AHEAD",
    "TOOL_UP",
    "Face",
    "Solutions",
    "area_manipulability",
    "base_pose",
    "configurations",
    "control_points",
    "inverse_kinematics",
    "largest_manipulability",
    "on_base",
    "orientation",
    "square",
]

TOOL_UP = ((0.0, 0.0, -1.0), (0.0, 1.0, 0.0), (1.0, 0.0, 0.0))
"""Orientation R_G_tool with the sixth axis straight up, as Table 4 has it; w is the same if it is down."""

TOOL_AHEAD = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
"""Orientation R_G_tool with the sixth axis along x, straight at the side of a block that looks along −x."""

Face: TypeAlias = Literal["top", "side"]
"""Face of a block, the top or the side that looks along −x. G is in the middle of it, z up."""

_NUMBERS_AT_ONCE = 2**15


class Solutions(NamedTuple):
    """Configurations of an arm at poses.

    Attributes
    ----------
    q
        (..., 8, 6) joint values [rad]; of copies full turns apart, those nearest to the middle of the limits.
    valid
        (..., 8) whether they put the tool at the pose.
    within_limits
        (..., 8) whether all joints are within their limits.
    """

    q: Tensor
    valid: Tensor
    within_limits: Tensor


def inverse_kinematics(arm: Chain, T_base_tool: TensorLike) -> Solutions:
    """Return all branches of :func:`dexterity.inverse_kinematics.spherical_wrist`, with the limits looked at.

    Raises
    ------
    ValueError
        If the arm has no spherical wrist, or a pose is not rigid or not finite.
    TypeError
        If the arm is no chain.
    """
    checks.instance(arm, "arm", Chain)
    q, valid = spherical_wrist(arm, T_base_tool)
    moved, within_limits = nearest_copy(arm, q)
    return Solutions(moved, valid, within_limits)


def square(
    half_width: float, per_side: int = 2, height: float = 0.0, face: Face = "top"
) -> Float64[Tensor, "m 3"]:
    """Return control points on a square about the origin of G, row by row; two a side are its corners.

    Parameters
    ----------
    half_width
        Half the length of a side [m].
    per_side
        Points a side.
    height
        How far outside of the face they are [m].
    face
        Which face they are on: with it x and y vary, or y and z.

    Raises
    ------
    ValueError
        If the half width is not positive, or there are fewer than two points a side.
    """
    half, count = checks.positive(half_width, "half_width"), checks.whole(per_side, "per_side", least=2)
    height, face = checks.real(height, "height"), _face(face)
    side = torch.linspace(-half, half, count, dtype=torch.float64)
    flat = torch.cartesian_prod(side, side)
    off = torch.full((len(flat), 1), height, dtype=torch.float64)
    return torch.cat([flat, off] if face == "top" else [-off, flat], dim=1)


def _face(face: Face) -> Face:
    checks.choice(face, "face", get_args(Face))
    return face


def base_pose(pose: TensorLike) -> Float64[Tensor, "*batch 4 4"]:
    """Return T_G_base of poses (..., 4) = x, y, z, ψ or (..., 6) = x, y, z, roll, pitch, ψ, [m] and [rad].

    Raises
    ------
    ValueError
        If the last axis is neither 4 nor 6, or a number is not finite.
    """
    pose = _poses(pose)
    angles = pose[..., 3:] if pose.shape[-1] == 6 else torch.nn.functional.pad(pose[..., 3:], (2, 0))
    return assemble(rotation_of_rpy(angles), pose[..., :3])


def on_base(arm: Chain, pose: TensorLike) -> Chain:
    """Return an arm whose world frame is G, its base at one pose, (4,) or (6,) as for `base_pose`.

    Raises
    ------
    ValueError
        If it is not one pose, or a number is not finite.
    """
    checks.instance(arm, "arm", Chain)
    pose = _poses(pose)
    if pose.ndim != 1:
        raise ValueError(f"pose has shape {tuple(pose.shape)}; one pose is needed")
    T = base_pose(pose)
    return arm.with_base(T)


def configurations(arm: Chain, pose: TensorLike, points: TensorLike, tool: TensorLike = TOOL_UP) -> Solutions:
    """Return all configurations (..., m, 8, 6) of the arm on a base at poses, its tool at control points.

    Parameters, frames and errors are those of `largest_manipulability`.
    """
    base, points, R = base_pose(pose), control_points(points), orientation(tool)
    T_tool = spatial.pose(R, points)
    return inverse_kinematics(arm, spatial.compose(spatial.inverse(base)[..., None, :, :], T_tool))


def largest_manipulability(
    arm: Chain,
    pose: TensorLike,
    points: TensorLike,
    tool: TensorLike = TOOL_UP,
    bodies: Bodies | None = None,
) -> Float64[Tensor, "*batch m"]:
    """Largest w of the configurations within the joint limits, at each control point, Eq. 16.

    With bodies, configurations in collision do not count. These values are computed by compiled C: a C
    compiler is needed, and torch cannot differentiate them.

    Parameters
    ----------
    arm
        Six joints with a spherical wrist. For an elbow arm, as the paper's is, the closed form is taken.
    pose
        (..., 4) = x, y, z, ψ of the arm's base in G, [m] and [rad], or (..., 6) = x, y, z, roll, pitch, ψ.
    points
        (m, 3) control points in G [m].
    tool
        (3, 3) orientation R_G_tool of the tool at every point.
    bodies
        Bodies on the arm, on its base and in G, the frame of their world, such as those of
        :func:`~dexterity.docking.free_branches.block_and_vehicle`; None for an arm that passes through all.

    Returns
    -------
    (..., m) values; 0 where a point is not reached, not within the limits, or not without a collision.

    Raises
    ------
    ValueError
        If a shape does not fit, something is not finite, there is no control point, the orientation is no
        rotation, the arm has no spherical wrist, or the bodies are on another arm.
    CompilationFailed
        If there are bodies, and a compiler is missing or fails.
    """
    elbow = _elbow_arm(checks.instance(arm, "arm", Chain))
    pose, points, R = _poses(pose), control_points(points), orientation(tool)
    rows = pose.reshape(-1, pose.shape[-1])
    if bodies is not None:
        return _around(arm, rows, points, R, bodies).reshape(*pose.shape[:-1], len(points))
    at_once = max(1, _NUMBERS_AT_ONCE // len(points))
    if elbow is None:
        parts = [_by_branches(arm, some, points, R) for some in rows.split(at_once)]
    else:
        parts = [_by_closed_form(elbow, some, points, R) for some in rows.split(at_once)]
    return torch.cat(parts).reshape(*pose.shape[:-1], len(points))


def area_manipulability(
    arm: Chain,
    pose: TensorLike,
    points: TensorLike,
    tool: TensorLike = TOOL_UP,
    bodies: Bodies | None = None,
) -> Float64[Tensor, "*batch"]:
    """Area manipulability M_a (...), Eq. 1: the smallest over the control points of the largest w.

    Parameters, frames and errors are those of `largest_manipulability`.
    """
    if bodies is not None:
        return _area_around(checks.instance(arm, "arm", Chain), pose, points, tool, bodies)
    if _elbow_arm(checks.instance(arm, "arm", Chain)) is not None:
        return largest_manipulability(arm, pose, points, tool).amin(-1)
    pose, points = _poses(pose), control_points(points)
    rows = pose.reshape(-1, pose.shape[-1])
    smallest = torch.full((len(rows),), math.inf, dtype=rows.dtype)
    # Once a point is out of reach, no other point can change that the smallest value is 0.
    for point in points:
        alive = smallest > 0
        found = largest_manipulability(arm, rows[alive], point[None], tool)[:, 0]
        smallest = smallest.masked_scatter(alive, torch.minimum(smallest[alive], found))
    return smallest.reshape(pose.shape[:-1])


def _area_around(
    arm: Chain, pose: TensorLike, points: TensorLike, tool: TensorLike, bodies: Bodies
) -> Tensor:
    pose, points, R = _poses(pose), control_points(points), orientation(tool)
    rows = pose.reshape(-1, pose.shape[-1])
    return _around(arm, rows, points, R, bodies, smallest=True).reshape(pose.shape[:-1])


def _around(
    arm: Chain, pose: Tensor, points: Tensor, R: Tensor, bodies: Bodies, smallest: bool = False
) -> Tensor:
    """Values (N, m) of branches that are free of collision, or the smallest ones (N)."""
    quick, checked = _with_bodies(arm, bodies)
    if quick is not None:
        places = base_pose(pose) if pose.shape[-1] == 6 else pose
        return quick.values(places, points, R, smallest)
    at_once = max(1, _NUMBERS_AT_ONCE // len(points))
    values = torch.cat([_by_branches(arm, some, points, R, checked) for some in pose.split(at_once)])
    return values.amin(-1) if smallest else values


@functools.lru_cache(maxsize=8)
@torch.inference_mode(False)  # kept for later calls in every mode
def _with_bodies(arm: Chain, bodies: Bodies) -> tuple[FreeBranches | None, CompiledBodies | None]:
    """Return what serves an arm with bodies: the closed form if there is one, else a check of branches."""
    require_same_arm(arm, bodies)
    quick = FreeBranches.of(arm, bodies)
    return quick, in_c(bodies) if quick is None else None


@functools.lru_cache(maxsize=8)
@torch.inference_mode(False)  # kept for later calls in every mode
def _elbow_arm(arm: Chain) -> ElbowArm | None:
    return ElbowArm.of(arm)


def _by_closed_form(elbow: ElbowArm, pose: Tensor, points: Tensor, R: Tensor) -> Tensor:
    if pose.shape[-1] == 6:
        back = base_pose(pose)[:, :3, :3].mT
        local = (back[:, None] @ (points - pose[:, None, :3])[..., None])[..., 0].movedim(-1, 0)
        axis = (back @ R[:, 0]).mT[..., None]
        return elbow.manipulability(local.contiguous(), axis)
    x, y, z = (points[:, i] - pose[:, i, None] for i in range(3))
    cosine, sine = pose[:, 3:].cos(), pose[:, 3:].sin()
    local = torch.stack([cosine * x + sine * y, cosine * y - sine * x, z])
    a, b, c = R[:, 0]
    axis = torch.stack([cosine * a + sine * b, cosine * b - sine * a, torch.full_like(cosine, float(c))])
    return elbow.manipulability(local, axis)


def _by_branches(
    arm: Chain, pose: Tensor, points: Tensor, R: Tensor, bodies: CompiledBodies | None = None
) -> Tensor:
    w = pose.new_zeros(len(pose), len(points))
    centre, radius = _ball(arm)
    local = spatial.apply(spatial.inverse(base_pose(pose))[:, None], points)
    near = (local - centre).norm(dim=-1) <= radius
    places, numbers = near.nonzero().unbind(1)
    T_base = base_pose(pose[places])
    q, valid, within = inverse_kinematics(arm, spatial.inverse(T_base) @ spatial.pose(R, points[numbers]))
    usable = valid & within
    if bodies is not None:
        bases = T_base[:, None].expand(*usable.shape, 4, 4)
        usable[usable.clone()] = ~bodies.collides(q[usable], bases[usable])
    values = torch.zeros_like(q[..., 0])
    values[usable] = torch.linalg.det(arm.spatial_jacobian(q[usable])).abs()
    w[near] = values.amax(-1)
    return w


@functools.lru_cache(maxsize=8)
@torch.inference_mode(False)  # kept for later calls in every mode
def _ball(arm: Chain) -> tuple[Tensor, float]:
    """Centre (3) and radius [m] of a ball that the tool point cannot leave."""
    links = arm.link_transforms
    return links[0, :3, 3], float(links[1:, :3, 3].norm(dim=-1).sum()) * (1 + 1e-9)


def _poses(pose: TensorLike) -> Tensor:
    pose = on_cpu(pose, "pose")
    if pose.ndim == 0 or pose.shape[-1] not in (4, 6):
        raise ValueError(f"pose has shape {tuple(pose.shape)}; (..., 4) or (..., 6) is needed")
    return pose


def control_points(points: TensorLike) -> Float64[Tensor, "m 3"]:
    """Return control points as a tensor.

    Raises
    ------
    ValueError
        If they are not (m, 3) with m ≥ 1, or one is not finite.
    """
    points = on_cpu(points, "points")
    if points.ndim != 2 or points.shape[1] != 3 or len(points) == 0:
        raise ValueError(f"points has shape {tuple(points.shape)}; (m, 3) with m ≥ 1 is needed")
    return points


def orientation(tool: TensorLike, name: str = "tool") -> Float64[Tensor, "3 3"]:
    """Return the orientation of a tool as a tensor.

    Raises
    ------
    ValueError
        If it is not (3, 3), not finite, or no rotation.
    """
    R = on_cpu(tool, name)
    if R.shape != (3, 3):
        raise ValueError(f"{name} has shape {tuple(R.shape)}; (3, 3) is needed")
    return spatial.require_rotation(R, name)
