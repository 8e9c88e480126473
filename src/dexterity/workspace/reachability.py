r"""The family of arms of paper C, exactly: what is in reach, the joint angles of a branch, the Jacobians.

Six revolute joints in standard Denavit-Hartenberg form, α = (π/2, 0, −π/2, π/2, −π/2, 0), where only the
offsets d₃, d₄ and the lengths a₂, a₃ differ from zero: the layout of the PUMA 560, with the wrist's centre
for a tool point. The arm reaches every orientation wherever it reaches at all. With L² = a₃² + d₄² and
ρ² = x² + y² + z² − d₃², a position is in reach if and only if

.. math:: \sqrt{x^2 + y^2} \ge d_3, \qquad |a_2 - L| \le \rho \le a_2 + L .

Everything takes a batch of manipulators beside a batch of poses. One manipulator is a
:class:`dexterity.chain.Chain` by :func:`arm`, and all its branches come from
:func:`dexterity.inverse_kinematics.spherical_wrist`.

Examples
--------
>>> import torch
>>> from dexterity.workspace.reachability import arm, inverse
>>> links = [0.15, 0.43, 0.43, 0.02]
>>> T = arm(links).forward([0.0, 0.5, 0.25, 0.0, 0.5, 0.0])
>>> q, reached = inverse(links, T)
>>> bool(reached), bool(torch.allclose(arm(links).forward(q), T))
(True, True)
"""

from __future__ import annotations

import math
from typing import NamedTuple

import torch
from jaxtyping import Bool, Float64
from torch import Tensor

from dexterity import checks, spatial
from dexterity.chain import Chain
from dexterity.spatial import TensorLike
from dexterity.spatial.values import on_cpu, on_one_device

__all__ = [
    "LINK_NAMES",
    "NAMED_BRANCH",
    "TWISTS",
    "Branch",
    "Frames",
    "arm",
    "body_jacobian",
    "forward",
    "frames",
    "geometric_jacobian",
    "in_tool_axes",
    "inverse",
    "reachable",
]

LINK_NAMES = ("d3", "d4", "a2", "a3")
"""Columns of `links` [m]."""

TWISTS = (math.pi / 2, 0.0, -math.pi / 2, math.pi / 2, -math.pi / 2, 0.0)
"""Angles α between the axes of consecutive joints [rad]."""


class Branch(NamedTuple):
    """Which of the eight configurations of a pose is meant, in the words of the Robotics Toolbox.

    Attributes
    ----------
    left
        Whether the arm stands on the side of the first axis that is away from the target.
    up
        Whether the elbow is above the line from the shoulder to the wrist, seen from the right arm.
    flip
        Whether the wrist is turned over: θ₅ is positive then.
    """

    left: bool = True
    up: bool = True
    flip: bool = False


NAMED_BRANCH = Branch()
"""The one that the paper's data hold, left and up without a flip."""


def arm(links: TensorLike, name: str = "arm") -> Chain:
    """Return one manipulator of the family as a chain, without limits.

    Parameters
    ----------
    links
        (4,) d₃, d₄, a₂, a₃ [m].
    name
        What the chain is called.

    Raises
    ------
    ValueError
        If there are not four numbers, or one is negative or not finite.
    """
    d3, d4, a2, a3 = on_cpu(one_arm(links), "links").tolist()
    lengths = zip((0, 0, d3, d4, 0, 0), (0, a2, a3, 0, 0, 0), TWISTS, strict=True)
    return Chain.from_dh([{"d": d, "a": a, "alpha": alpha} for d, a, alpha in lengths], name=name)


def reachable(links: TensorLike, position: TensorLike) -> Bool[Tensor, "*batch"]:
    """Whether a position is in reach, with any orientation of the tool.

    Parameters
    ----------
    links
        (..., 4) d₃, d₄, a₂, a₃ [m].
    position
        (..., 3) tool points in the base [m]; the batch axes of both are broadcast.

    Raises
    ------
    ValueError
        If a shape does not fit, a length is negative, or something is not finite.
    """
    links, position = _links(links), spatial.batch_of(position, "position", (3,))
    links, position = on_one_device(links=links, position=position)
    spatial.common_batch(links=links.shape[:-1], position=position.shape[:-1])
    (d3, d4, a2, a3), (x, y, z) = links.unbind(-1), position.unbind(-1)
    across = x.square() + y.square()
    far = across + z.square() - d3.square()
    forearm = (a3.square() + d4.square()).sqrt()
    return (across >= d3.square()) & (far >= (a2 - forearm).square()) & (far <= (a2 + forearm).square())


def inverse(
    links: TensorLike, T_base_tool: TensorLike, branch: Branch = NAMED_BRANCH
) -> tuple[Float64[Tensor, "*batch 6"], Bool[Tensor, "*batch"]]:
    """Joint angles of one branch, for a batch of manipulators.

    Parameters
    ----------
    links
        (..., 4) d₃, d₄, a₂, a₃ [m].
    T_base_tool
        (..., 4, 4) poses of the tool in the base; the batch axes of both are broadcast.
    branch
        Which configuration.

    Returns
    -------
    Angles [rad] in (−π, π], and whether the position is in reach. Where it is not, the angles stretch or fold
    the arm towards it.

    Raises
    ------
    ValueError
        If a shape does not fit, a length is negative, a pose is not rigid, or something is not finite.
    """
    links, T = _links(links), spatial.require_rigid(T_base_tool, "T_base_tool")
    checks.instance(branch, "branch", Branch)
    links, T = on_one_device(links=links, T_base_tool=T)
    spatial.common_batch(links=links.shape[:-1], T_base_tool=T.shape[:-2])
    reach = reachable(links, T[..., :3, 3])
    q1, q2, q3 = _arm_angles(links, T[..., :3, 3], branch)
    q4, q5, q6 = _wrist_angles(q1, q2 + q3, T[..., :3, :3], branch.flip)
    q = torch.stack(torch.broadcast_tensors(q1, q2, q3, q4, q5, q6), -1)
    return spatial.wrap_to_pi(q), reach


def _arm_angles(links: Tensor, position: Tensor, branch: Branch) -> tuple[Tensor, Tensor, Tensor]:
    d3, d4, a2, a3 = links.unbind(-1)
    x, y, z = position.unbind(-1)
    side = -1.0 if branch.left else 1.0
    across = x.square() + y.square()
    ahead = side * (across - d3.square()).clamp(min=0).sqrt()
    q1 = torch.atan2(y, x) + torch.atan2(d3, ahead)
    forearm = (a3.square() + d4.square()).sqrt()
    far = across - d3.square() + z.square()
    product = 2 * a2 * forearm
    cosine = (far - a2.square() - forearm.square()) / torch.where(product > 0, product, 1.0)
    cosine = cosine.clamp(-1, 1)
    bend = -side if branch.up else side
    sine = bend * (1 - cosine.square()).sqrt()
    q2 = torch.atan2(z, ahead) - torch.atan2(forearm * sine, a2 + forearm * cosine)
    return q1, q2, torch.atan2(sine, cosine) - torch.atan2(d4, a3)


def _wrist_angles(q1: Tensor, q23: Tensor, R: Tensor, flip: bool) -> tuple[Tensor, Tensor, Tensor]:
    c1, s1, c23, s23 = (part[..., None] for part in (q1.cos(), q1.sin(), q23.cos(), q23.sin()))
    x, y, z = R.unbind(-2)
    ahead = c1 * x + s1 * y
    # Rows of the rotation from frame 3, at the end of the forearm, to the tool.
    first, second, third = c23 * ahead + s23 * z, c1 * y - s1 * x, c23 * z - s23 * ahead
    q4 = torch.atan2(second[..., 2], first[..., 2]) + (math.pi if flip else 0.0)
    c4, s4 = q4.cos(), q4.sin()
    q5 = torch.atan2(-(c4 * first[..., 2] + s4 * second[..., 2]), third[..., 2])
    q6 = torch.atan2(c4 * second[..., 0] - s4 * first[..., 0], c4 * second[..., 1] - s4 * first[..., 1])
    return q4, q5, q6


class Frames(NamedTuple):
    """Where the links' frames are, that of the base first and that of the tool last.

    Attributes
    ----------
    rotations
        (..., 7, 3, 3) from each frame to the base.
    origins
        (..., 7, 3) in the base [m].
    """

    rotations: Tensor
    origins: Tensor

    def jacobian(self) -> Tensor:
        """Geometric Jacobian (..., 6, 6) of the tool point, in the axes of the base."""
        axes = self.rotations[..., :6, :, 2]
        arms = self.origins[..., 6:, :] - self.origins[..., :6, :]
        return torch.cat([torch.linalg.cross(axes, arms), axes], -1).mT


def frames(links: TensorLike, q: TensorLike) -> Frames:
    """Place the links of a batch of manipulators.

    Parameters
    ----------
    links
        (..., 4) d₃, d₄, a₂, a₃ [m].
    q
        (..., 6) joint angles [rad]; the batch axes of both are broadcast.

    Raises
    ------
    ValueError
        If a shape does not fit, a length is negative, or something is not finite.
    """
    links, q = _links(links), spatial.require_joints(spatial.to_float64(q, "q"), 6, "arm")
    links, q = on_one_device(links=links, q=q)
    d3, d4, a2, a3 = links.unbind(-1)
    nothing = torch.zeros_like(d3)
    offsets, lengths = (nothing, nothing, d3, d4, nothing, nothing), (nothing, a2, a3, *[nothing] * 3)
    batch = spatial.common_batch(links=links.shape[:-1], q=q.shape[:-1])
    R, p = torch.eye(3, dtype=q.dtype, device=q.device).expand(*batch, 3, 3), q.new_zeros(*batch, 3)
    rotations, origins = [R], [p]
    for angle, d, a, twist in zip(q.unbind(-1), offsets, lengths, TWISTS, strict=True):
        c, s = angle.cos()[..., None], angle.sin()[..., None]
        x, y, z = R.unbind(-1)
        x, y = c * x + s * y, c * y - s * x
        p = p + a[..., None] * x + d[..., None] * z
        # A twist is a quarter turn about x or none.
        y, z = (y, z) if twist == 0 else (z, -y) if twist > 0 else (-z, y)
        R = torch.stack([x, y, z], -1)
        rotations.append(R)
        origins.append(p)
    return Frames(torch.stack(rotations, -3), torch.stack(origins, -2))


def forward(links: TensorLike, q: TensorLike) -> Float64[Tensor, "*batch 4 4"]:
    """Pose of the tool in the base; the arguments and errors are those of :func:`frames`."""
    rotations, origins = frames(links, q)
    return spatial.pose(rotations[..., 6, :, :], origins[..., 6, :])


def geometric_jacobian(links: TensorLike, q: TensorLike) -> Float64[Tensor, "*batch 6 6"]:
    """Map joint rates to the velocity of the tool point and the angular velocity, in the axes of the base.

    The arguments and errors are those of :func:`frames`. Of its 36 entries 21 vary: the wrist's joints do not
    move the tool point, joints 2 and 3 have the same level axis, and the first axis is upright.
    """
    return frames(links, q).jacobian()


def body_jacobian(links: TensorLike, q: TensorLike) -> Float64[Tensor, "*batch 6 6"]:
    """Map joint rates to the twist of the tool, in its own axes.

    The arguments and errors are those of :func:`frames`. Of its 36 entries 23 vary.
    """
    placed = frames(links, q)
    return in_tool_axes(placed.jacobian(), placed.rotations[..., 6, :, :])


def in_tool_axes(J: Float64[Tensor, "*batch 6 6"], R: Float64[Tensor, "*batch 3 3"]) -> Tensor:
    """Turn a geometric Jacobian into the body Jacobian, exactly, for a tool with rotation R to the base."""
    return torch.cat([R.mT @ J[..., :3, :], R.mT @ J[..., 3:, :]], -2)


def one_arm(links: TensorLike) -> Tensor:
    """Return the lengths (4,) of one manipulator, independent of the original."""
    links = _links(links)
    if links.shape != (4,):
        raise ValueError(f"links has shape {tuple(links.shape)}; one manipulator (4,) is needed")
    return links.clone()


def _links(links: TensorLike) -> Tensor:
    links = spatial.batch_of(links, "links", (4,))
    if spatial.are_readable(links) and (links < 0).any():
        raise ValueError(f"links holds {links.min().item()}; lengths are at least 0")
    return links
