"""Paper B, section III.A: every configuration of an arm at a pose, and what its limits leave of them.

Sotiropoulos, Aspragathos & Andritsos (2011). Beside the two readings of the paper's arm stand a PUMA 560 and
an arm whose axes neither meet nor are parallel.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from dexterity import docking, robots, spatial
from dexterity.chain import Chain
from dexterity.indices import manipulability
from dexterity.inverse_kinematics import spherical_wrist, subproblem_1, subproblem_2, subproblem_3
from dexterity.report.claims import Acceptance, Outcome, Verdict
from dexterity.report.stored import Tolerance

__all__ = [
    "CONFIGS",
    "TOLERANCE",
    "Config",
    "Result",
    "RoundTrip",
    "acceptance",
    "arms",
    "branch_table",
    "by_three_subproblems",
    "eight_configurations",
    "round_trip_table",
    "run",
    "stretching",
    "verdicts",
]

STATED, FITTED, PUMA, SKEW = "stated", "fitted", "PUMA 560", "all axes skew"

TOLERANCE = Tolerance(rtol=1e-6, atol=1e-6)
"""What a probe may miss by, since rounding errors come out a little different on every processor."""

_ERROR = 1e-9
_SAME = 1e-6  # [rad], and of the largest w


@dataclass(frozen=True)
class Config:
    """Random configurations of every arm, each joint drawn from a full turn."""

    poses: int = 20_000
    seed: int = 0


CONFIGS: Mapping[str, Config] = {
    "smoke": Config(poses=300),
    "book": Config(),
    "full": Config(poses=200_000),
}
"""What runs at each scale."""


@dataclass(frozen=True)
class RoundTrip:
    """Forward kinematics of random configurations, and all branches of the poses that come out.

    Attributes
    ----------
    pose_error
        Largest deviation of a valid branch from its pose, in rotation and, in [m], in position.
    found
        Share of the configurations that are among the branches of their pose.
    branches
        Share of the poses with so many valid branches, under "0" to "8".
    within_limits
        The same for branches within the joint limits; empty for an arm without limits.
    wrist_binds
        Share of the branches of the arm within the limits of the first three joints for which neither branch
        of the wrist is within its own; NaN for an arm without limits.
    values_of_w
        Largest number of different w among the branches of a pose.
    wrist_changes_w
        Largest difference between the w of two branches that differ in the wrist alone, beside the largest w.
    refused
        Share of the poses that are flagged when they are moved out of reach.
    """

    pose_error: float
    found: float
    branches: Mapping[str, float]
    within_limits: Mapping[str, float]
    wrist_binds: float
    values_of_w: int
    wrist_changes_w: float
    refused: float


@dataclass(frozen=True)
class Result:
    """What the branches of the arms are.

    Attributes
    ----------
    arms
        Round trips by name of the arm.
    by_the_book
        Difference [rad] between the branches of the stated arm and those that subproblems 1 to 3 give, below
        which 99 of 100 poses stay.
    short_of_reach
        How far [m] the wrist is from the border of the stated arm's workspace, on a straight way outwards.
    apart
        Largest difference [rad] of a joint between the two branches of the elbow there.
    jump
        Largest change [rad] of a joint of a branch from one step of that way to the next.
    """

    arms: Mapping[str, RoundTrip]
    by_the_book: float
    short_of_reach: NDArray[np.float64]
    apart: NDArray[np.float64]
    jump: float


def run(config: Config) -> Result:
    """Draw configurations of every arm and solve for them again."""
    short, elbows = stretching(robots.docking_arm())
    return Result(
        arms={name: _round_trip(arm, config) for name, arm in arms().items()},
        by_the_book=_difference_by_the_book(robots.docking_arm(), config),
        short_of_reach=short.numpy(),
        apart=_apart(elbows[:, 0], elbows[:, 1]).numpy(),
        jump=_apart(elbows[1:], elbows[:-1]).max().item(),
    )


def arms() -> dict[str, Chain]:
    """Return the arms by name: the two of paper B, a PUMA 560, and one with skew axes."""
    directions = torch.tensor(
        [[0, 0, 1], [0.3, -1, 0.2], [0.5, -1, 0.6], [1, 0, 0.2], [0, -1, 0.3], [1, 0.1, 0]],
        dtype=torch.float64,
    )
    directions = directions / directions.norm(dim=1, keepdim=True)
    points = torch.tensor(
        [[0, 0, 0], [0.1, 0, 0.1], [0.5, 0.1, 0.1], *[[0.9, 0, 0.1]] * 3], dtype=torch.float64
    )
    home = torch.eye(4, dtype=torch.float64)
    home[:3, 3] = points[-1]
    screws = torch.cat([torch.linalg.cross(points, directions), directions], dim=1)
    skew = Chain(screws, home, name="arm with skew axes")
    return {
        STATED: robots.docking_arm(),
        FITTED: robots.docking_arm("fitted"),
        PUMA: robots.puma560(),
        SKEW: skew,
    }


def eight_configurations(arm: Chain, pose: Tensor) -> Tensor:
    """Return the branches (8, 6) of a tool pose (4, 4), those of one wrist after those of the other."""
    q, valid = spherical_wrist(arm, pose)
    return torch.cat([q[valid][0::2], q[valid][1::2]])


def stretching(arm: Chain, steps: int = 400) -> tuple[Tensor, Tensor]:
    """Move the tool of an elbow arm straight outwards to the border of its workspace.

    Returns
    -------
    How far (steps) it is from the border [m], and the two branches of the elbow there (steps, 2, 6), in reach
    of each other.
    """
    q = torch.tensor([0.3, 0.9, -1.6, 0.0, 0.4, 0.0], dtype=torch.float64)
    start = arm.forward(q)
    shoulder = arm.joint_frames(torch.zeros(6))[1, :3, 3]
    outwards = start[:3, 3] - shoulder
    reach = (arm.home[:3, 3] - shoulder).norm()
    # Steps that shorten like a square: the branches close in on each other with its root.
    short = (reach - outwards.norm()) * torch.linspace(1, 0, steps, dtype=torch.float64).square()
    poses = start.expand(steps, 4, 4).clone()
    poses[:, :3, 3] = shoulder + ((reach - short) / outwards.norm())[:, None] * outwards
    branches, _ = spherical_wrist(arm, poses)
    followed = [branches[0, _apart(branches[0], q).argmin()], branches[0, _other_elbow(branches[0], q)]]
    path = [torch.stack(followed)]
    for here in branches[1:]:
        path.append(torch.stack([here[_apart(here, last).argmin()] for last in path[-1]]))
    return short, torch.stack(path)


def by_three_subproblems(arm: Chain, T: Tensor) -> Tensor:
    """Return the branches (..., 8, 6) of an arm whose first two axes meet, by subproblems 1, 2 and 3 alone.

    The elbow first, from how far the wrist is from where the two axes meet; then these two, then the wrist's.
    """
    S = arm.screws
    # At home the first axis is upright, the second level, and the last along x.
    shoulder, wrist = arm.joint_frames(torch.zeros(6))[[1, 4], :3, 3]
    moved = T @ spatial.inverse(arm.home)

    centre = spatial.apply(moved, wrist)
    third = subproblem_3(S[2], wrist, shoulder, (centre - shoulder).norm(dim=-1))
    bent = spatial.apply(spatial.exp(S[2] * third[..., None]), wrist)
    arm_pairs = subproblem_2(S[0], S[1], bent, centre[..., None, :])
    third = third[..., None].expand(arm_pairs.shape[:-1])
    first_three = torch.cat([arm_pairs, third[..., None]], dim=-1).flatten(-3, -2)
    left = moved[..., None, :, :]
    for i in range(3):
        left = spatial.exp(-S[i] * first_three[..., i, None]) @ left
    along, beside = wrist + wrist.new_tensor([1, 0, 0]), wrist + wrist.new_tensor([0, 1, 0])
    wrist_pairs = subproblem_2(S[3], S[4], along, spatial.apply(left, along))
    left = left[..., None, :, :]
    for i in range(2):
        left = spatial.exp(-S[3 + i] * wrist_pairs[..., i, None]) @ left
    sixth = subproblem_1(S[5], beside, spatial.apply(left, beside))
    first_three = first_three[..., None, :].expand(*wrist_pairs.shape[:-1], 3)
    return torch.cat([first_three, wrist_pairs, sixth[..., None]], dim=-1).flatten(-3, -2)


def _difference_by_the_book(arm: Chain, config: Config) -> float:
    T = arm.forward(_drawn(config))
    other = by_three_subproblems(arm, T)
    q, _ = spherical_wrist(arm, T)
    # Near a singular pose branches are known to the root of rounding; what counts is that each is there.
    return torch.quantile(_apart(q[:, :, None], other[:, None]).amin(-1).amax(-1), 0.99).item()


def _drawn(config: Config) -> Tensor:
    random = torch.Generator().manual_seed(config.seed)
    return (2 * torch.rand(config.poses, 6, generator=random, dtype=torch.float64) - 1) * math.pi


def _other_elbow(branches: Tensor, q: Tensor) -> int:
    """Which of the branches (8, 6) differs from a configuration in the elbow and in what follows from it."""
    bent = torch.sign(branches[:, 2]) != torch.sign(q[2])
    distance = torch.where(bent, _apart(branches[:, [0, 3]], q[[0, 3]]), torch.inf)
    return int(distance.argmin())


def _apart(a: Tensor, b: Tensor) -> Tensor:
    """Largest difference (...) of joint values, full turns apart."""
    return spatial.wrap_to_pi(a - b).abs().amax(-1)


def _round_trip(arm: Chain, config: Config) -> RoundTrip:
    q = _drawn(config)
    T = arm.forward(q)
    found, valid, within = docking.inverse_kinematics(arm, T)
    own = (valid & (_apart(found, q[:, None]) < _SAME)).any(-1)
    pose_error = (arm.forward(found) - T[:, None]).abs().amax((-2, -1))
    limited = bool(torch.isfinite(arm.lower).all())
    away = T.clone()
    away[:, :3, 3] += 100.0
    different, by_wrist = _values_of_w(arm, found, valid)
    return RoundTrip(
        pose_error=pose_error[valid].max().item(),
        found=own.double().mean().item(),
        branches=_shares(valid.sum(-1)),
        within_limits=_shares((valid & within).sum(-1)) if limited else {},
        wrist_binds=_wrist_binds(arm, found, valid, within) if limited else math.nan,
        values_of_w=different,
        wrist_changes_w=by_wrist,
        refused=1 - spherical_wrist(arm, away)[1].any(-1).double().mean().item(),
    )


def _shares(counts: Tensor) -> dict[str, float]:
    return {str(n): (counts == n).double().mean().item() for n in range(9)}


def _wrist_binds(arm: Chain, q: Tensor, valid: Tensor, within: Tensor) -> float:
    inside = ((q >= arm.lower) & (q <= arm.upper))[..., :3].all(-1) & valid
    reached = inside.unflatten(-1, (4, 2)).any(-1)
    return (reached & ~within.unflatten(-1, (4, 2)).any(-1)).sum().item() / reached.sum().item()


def _values_of_w(arm: Chain, q: Tensor, valid: Tensor) -> tuple[int, float]:
    """Count the different w of a pose at most, and tell by how much the wrist's branches differ in it.

    Both beside the largest w of all poses, since near a singular one w itself is no more than rounding.
    """
    w = torch.where(valid, manipulability(arm.geometric_jacobian(q)), math.nan)
    scale = w.nan_to_num(0.0).max()
    pairs = w.unflatten(-1, (4, 2))
    by_wrist = (pairs[..., 0] - pairs[..., 1]).abs().nan_to_num(0.0).max() / scale
    steps = w.sort(-1).values.diff(dim=-1).nan_to_num(0.0) > _SAME * scale
    return int(1 + steps.sum(-1).max()), by_wrist.item()


# ---- tables ----------------------------------------------------------------------------------------


def round_trip_table(result: Result) -> dict[str, dict[str, str]]:
    """Round trips by arm."""
    return {
        name: {
            "largest pose error": f"{trip.pose_error:.0e}",
            "own configuration found [%]": f"{100 * trip.found:.4g}",
            "out of reach, flagged [%]": f"{100 * trip.refused:.4g}",
            "different w at most": str(trip.values_of_w),
        }
        for name, trip in result.arms.items()
    }


def branch_table(result: Result) -> dict[str, dict[str, float]]:
    """Shares [%] of the poses by number of branches, and by number of those within the limits."""
    rows = {name: trip.branches for name, trip in result.arms.items()}
    rows |= {
        f"{name}, within limits": trip.within_limits
        for name, trip in result.arms.items()
        if trip.within_limits
    }
    return {name: {count: 100 * share for count, share in shares.items()} for name, shares in rows.items()}


# ---- verdicts --------------------------------------------------------------------------------------

_SETTING = "Taken over as a setting; nothing can be tested. "


def verdicts(result: Result) -> tuple[Verdict, ...]:
    """Judge the claims of the ledger that this study answers for.

    What is solved is judged on all poses of both of the paper's arms: errors below 1e-9, every configuration
    found.
    """
    own = [result.arms[name] for name in (STATED, FITTED)]
    error, found = max(trip.pose_error for trip in own), min(trip.found for trip in own)
    solved = error < _ERROR and found == 1.0
    eight = min(trip.branches["8"] for trip in own)
    inside = result.arms[STATED].within_limits
    values = max(trip.values_of_w for trip in own)
    return (
        _verdict(
            "elbow-arm", Outcome.of(solved), "", "",
            "The arm is solved as what it is said to be: the last three axes meet in a point.",
        ),
        _verdict(
            "link-lengths", Outcome.OUT_OF_SCOPE, "", "",
            f"{_SETTING}They do not bring the arm to the corners with the angles of Table 4.",
        ),
        _verdict(
            "lower-limits", Outcome.OUT_OF_SCOPE, "", "",
            f"{_SETTING}Of the poses of random configurations {1 - inside['0']:.0%} are reached within them.",
        ),
        _verdict(
            "upper-limits", Outcome.OUT_OF_SCOPE, "", "",
            f"{_SETTING}Where the first three joints are within theirs, one of the wrist's two branches is "
            f"within its own in {1 - max(trip.wrist_binds for trip in own):.0%} of the cases.",
        ),
        _verdict(
            "paden-kahan", Outcome.of(solved and result.by_the_book < _SAME), f"{error:.0e}",
            "largest error of a pose",
            "Subproblems 1 to 3 give all branches of the stated arm. The fitted one has its plane beside the "
            "first axis, and needs a fourth, which brings a point onto a plane.",
        ),
        _verdict(
            "eight-solutions", Outcome.REPRODUCED if eight > 0.99 and values == 8 else Outcome.IN_SHAPE,
            f"{eight:.0%} of the poses have eight",
            f"with at most {result.arms[STATED].values_of_w} (stated) and {values} (fitted) different w",
            "A pose has eight configurations where it is reached at all and limits are left aside. But the "
            "two of the wrist have the same w, and in the stated arm so do the two of the shoulder.",
        ),
        _verdict(
            "solutions-are-discrete", Outcome.of(False) if result.jump > math.pi / 4 else Outcome.IN_SHAPE,
            f"{result.apart[0]:.1f} rad apart inside, {result.apart[-2]:.0e} rad at the border",
            f"two branches of the elbow; {result.short_of_reach[-2]:.0e} m from the border",
            "At one pose they are discrete, but each changes steadily with the pose, and where the arm is "
            "stretched two of them meet and go over into each other.",
        ),
    )  # fmt: skip


def acceptance(result: Result) -> tuple[Acceptance, ...]:
    """Figures that must hold for the book to be built."""
    book = Acceptance("difference to what subproblems 1 to 3 give [rad]", result.by_the_book, _SAME)
    return (book, *_acceptance_of_arms(result))


def _acceptance_of_arms(result: Result) -> tuple[Acceptance, ...]:
    return tuple(
        Acceptance(f"{what}, {name}", value, limit)
        for name, trip in result.arms.items()
        for what, value, limit in (
            ("largest error of a branch", trip.pose_error, 10 * _ERROR),
            ("share of configurations that are not found", 1 - trip.found, 0.0),
            ("share of poses out of reach that are not flagged", 1 - trip.refused, 0.0),
        )
    )


def _verdict(claim: str, outcome: Outcome, ours: str, spread: str, sentence: str) -> Verdict:
    return Verdict("sotiropoulos2011", claim, outcome, ours, spread, sentence)
