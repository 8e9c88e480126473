"""Every configuration of an arm at a pose, Sotiropoulos, Aspragathos & Andritsos (2011), section III.A."""

from __future__ import annotations

import math
from typing import Any

import torch
from torch import Tensor

from dexterity import docking, robots, spatial
from dexterity.chain import Chain
from dexterity.indices import manipulability
from dexterity.inverse_kinematics import spherical_wrist, subproblem_1, subproblem_2, subproblem_3
from dexterity_study.docking.cases import OF_DATA, ROUNDING, Rows, drawn_joints
from dexterity_study.engine.experiment import experiment

SAME = 1e-6
"""What counts as the same: joint values [rad], and w beside the largest w."""


def arms() -> dict[str, Chain]:
    """Return the paper's two arms, a PUMA 560, and an arm whose axes neither meet nor are parallel."""
    wrist = [0.9, 0, 0.1]
    points = torch.tensor([[0, 0, 0], [0.1, 0, 0.1], [0.5, 0.1, 0.1], *[wrist] * 3], dtype=torch.float64)
    directions = [[0, 0, 1], [0.3, -1, 0.2], [0.5, -1, 0.6], [1, 0, 0.2], [0, -1, 0.3], [1, 0.1, 0]]
    axes = torch.nn.functional.normalize(torch.tensor(directions, dtype=torch.float64))
    home = spatial.pose(torch.eye(3), wrist)
    skew = Chain(torch.cat([torch.linalg.cross(points, axes), axes], dim=1), home)
    arms = {"stated": robots.docking_arm(), "fitted": robots.docking_arm("fitted")}
    return {**arms, "PUMA 560": robots.puma560(), "all axes skew": skew}


@experiment(keys=("arm",), smoke={"poses": 300}, data=(*OF_DATA["data"], "robots/puma560.toml"), **ROUNDING)
def round_trips(seed: int, poses: int = 200_000) -> Rows:
    """Forward kinematics of random configurations, and all branches of the poses that come out."""
    for name, arm in arms().items():
        q = drawn_joints(poses, seed)
        T, away = arm.forward(q), arm.forward(q)
        away[:, :3, 3] += 100.0
        branches, valid, within = docking.inverse_kinematics(arm, T)
        row = {
            "arm": name,
            "pose_error": (arm.forward(branches) - T[:, None]).abs().amax((-2, -1))[valid].max(),
            "found": (valid & (_apart(branches, q[:, None]) < SAME)).any(-1).double().mean(),
            "refused": (~spherical_wrist(arm, away)[1].any(-1)).double().mean(),
            "values_of_w": _values_of_w(arm, branches, valid),
        }
        row |= {f"branches_{n}": (valid.sum(-1) == n).double().mean() for n in range(9)}
        if torch.isfinite(arm.lower).all():
            allowed = (valid & within).sum(-1)
            row |= {f"within_{n}": (allowed == n).double().mean() for n in range(9)}
        yield row


@experiment(smoke={"poses": 300}, **OF_DATA, **ROUNDING)
def three_subproblems(seed: int, poses: int = 200_000) -> Rows:
    """Difference [rad] of 99 % of the stated arm's branches from those by subproblems 1 to 3."""
    arm = robots.docking_arm()
    T = arm.forward(drawn_joints(poses, seed))
    branches, other = spherical_wrist(arm, T)[0], by_three_subproblems(arm, T)
    # Near a singular pose branches are known to the root of rounding; what counts is that each is there.
    misses = _apart(branches[:, :, None], other[:, None]).amin(-1).amax(-1)
    yield {"difference": torch.quantile(misses, 0.99)}


@experiment(arrays=("short", "apart"), **OF_DATA, **ROUNDING)
def border() -> tuple[list[dict[str, Any]], dict[str, Any]]:
    """Difference of the stated arm's two elbows [rad], and how far the border is [m], as it stretches."""
    short, elbows = stretching(robots.docking_arm())
    apart = _apart(elbows[:, 0], elbows[:, 1])
    row = {"inside": apart[0], "near": apart[-2], "near_by": short[-2], "at_border": apart[-1]}
    row["jump"] = _apart(elbows[1:], elbows[:-1]).max()
    return [row], {"short": short.float(), "apart": apart.float()}


def stretching(arm: Chain, steps: int = 400) -> tuple[Tensor, Tensor]:
    """Move the tool outwards to the border; return how far it is (steps) and both elbows' branches (steps, 2, 6)."""
    q = torch.tensor([0.3, 0.9, -1.6, 0.0, 0.4, 0.0], dtype=torch.float64)
    shoulder = arm.joint_frames(torch.zeros(6))[1, :3, 3]
    poses = arm.forward(q).repeat(steps, 1, 1)
    outwards = poses[0, :3, 3] - shoulder
    reach = (arm.home[:3, 3] - shoulder).norm()
    # Steps that shorten like a square: the branches close in on each other with its root.
    short = (reach - outwards.norm()) * torch.linspace(1, 0, steps, dtype=torch.float64).square()
    poses[:, :3, 3] = shoulder + ((reach - short) / outwards.norm())[:, None] * outwards
    branches, _ = spherical_wrist(arm, poses)
    bent = torch.sign(branches[0, :, 2]) != torch.sign(q[2])
    other = torch.where(bent, _apart(branches[0][:, [0, 3]], q[[0, 3]]), torch.inf).argmin()
    path = [branches[0][torch.stack([_apart(branches[0], q).argmin(), other])]]
    for here in branches[1:]:
        path.append(torch.stack([here[_apart(here, last).argmin()] for last in path[-1]]))
    return short, torch.stack(path)


def by_three_subproblems(arm: Chain, T: Tensor) -> Tensor:
    """Return the branches (..., 8, 6) of an arm whose first two axes meet: the elbow, these two, then the wrist."""
    S = arm.screws
    # At home the first axis is upright, the second level, and the last along x.
    shoulder, wrist = arm.joint_frames(torch.zeros(6))[[1, 4], :3, 3]
    moved = T @ spatial.inverse(arm.home)
    centre = spatial.apply(moved, wrist)
    third = subproblem_3(S[2], wrist, shoulder, (centre - shoulder).norm(dim=-1))
    bent = spatial.apply(spatial.exp(S[2] * third[..., None]), wrist)
    pairs = subproblem_2(S[0], S[1], bent, centre[..., None, :])
    q = torch.cat([pairs, third[..., None, None].expand(*pairs.shape[:-1], 1)], dim=-1).flatten(-3, -2)
    left = _turned_back(S[:3], q, moved[..., None, :, :])
    along, beside = wrist + wrist.new_tensor([1, 0, 0]), wrist + wrist.new_tensor([0, 1, 0])
    pairs = subproblem_2(S[3], S[4], along, spatial.apply(left, along))
    left = _turned_back(S[3:5], pairs, left[..., None, :, :])
    sixth = subproblem_1(S[5], beside, spatial.apply(left, beside))
    q = q[..., None, :].expand(*pairs.shape[:-1], 3)
    return torch.cat([q, pairs, sixth[..., None]], dim=-1).flatten(-3, -2)


def _turned_back(screws: Tensor, q: Tensor, T: Tensor) -> Tensor:
    for i, screw in enumerate(screws):
        T = spatial.exp(-screw * q[..., i, None]) @ T
    return T


def _apart(a: Tensor, b: Tensor) -> Tensor:
    """Largest difference (...) of joint values, full turns apart."""
    return spatial.wrap_to_pi(a - b).abs().amax(-1)


def _values_of_w(arm: Chain, q: Tensor, valid: Tensor) -> int:
    """Largest number of different w of a pose; near a singular one w itself is no more than rounding."""
    w = torch.where(valid, manipulability(arm.geometric_jacobian(q)), math.nan)
    steps = w.sort(-1).values.diff(dim=-1).nan_to_num(0.0) > SAME * w.nan_to_num(0.0).max()
    return int(1 + steps.sum(-1).max())
