"""Manipulability over the task area, at the poses that the paper prints and at random ones.

Source: Sotiropoulos, Aspragathos & Andritsos (2011), Eqs. 1, 2 and 16, Figs. 9 and 10, Tables 3 and 4.
"""

from __future__ import annotations

import math
from typing import Any

import torch
from torch import Tensor

from dexterity import docking, spatial
from dexterity.chain import Chain
from dexterity.docking.elbow import ElbowArm
from dexterity.inverse_kinematics import copies_within_limits, spherical_wrist
from dexterity_study.docking import cases
from dexterity_study.docking.cases import Rows, Values
from dexterity_study.engine.experiment import experiment

ANGLES = ("θ1", "θ2", "θ3", "θ4", "θ5", "θ6")
COMPARED = (0, 1, 2, 4, 5)
"""Angles of Table 4 that tell branches apart; θ4 is 0 to rounding everywhere."""

MATCH = 1.5e-3
"""Largest difference of angles that match [rad], three half units of the last printed digit."""

TOOLS = {"up": docking.TOOL_UP, "down": ((0.0, 0.0, 1.0), (0.0, 1.0, 0.0), (-1.0, 0.0, 0.0))}
SIDES = (2, 3, 5, 9)
OF_PAPER = {**cases.PAPER, **cases.ROUNDING}
BY_ARM = {"assumes": ("fitted-arm",), "readings": (cases.ARMS["fitted"],), **OF_PAPER}
BY_TOOL = {
    "assumes": ("fitted-arm", "tool-orientation"),
    "readings": (cases.ARMS["fitted"], "tool-orientation=down"),
    **OF_PAPER,
}


@experiment(smoke={"configurations": 200}, **BY_ARM, **cases.OF_DATA)
def closed_form(seed: int, reading: Values, configurations: int = 20_000) -> Rows:
    """Largest difference of the closed form of w from the determinant, and largest w with the tool upright [m³]."""
    arm = cases.arm_of(reading)
    # Limits would leave aside some of the branches whose largest w is compared.
    free = Chain(arm.screws, arm.home, lower=[-math.pi] * 6, upper=[math.pi] * 6)
    elbow = elbow_of(free)
    T = free.forward(cases.drawn_joints(configurations, seed))
    w = torch.linalg.det(free.geometric_jacobian(spherical_wrist(free, T)[0])).abs().amax(-1)
    error = (elbow.manipulability(T[:, :3, 3].mT, T[:, :3, 0].mT) - w).abs().max()
    yield {"error": error, "cap": _largest_upright(elbow)}


@experiment(keys=("run",), **BY_TOOL, **cases.OF_LEDGER)
def runs(reading: Values) -> Rows:
    """Area manipulability at the poses of Table 3 [m³]."""
    arm, tool = cases.arm_of(reading), TOOLS[reading["tool-orientation"]]
    areas = docking.area_manipulability(arm, cases.printed_poses(), docking.square(0.2), tool)
    yield from ({"run": run, "area": area} for run, area in enumerate(areas.tolist(), start=1))


@experiment(keys=("corner",), **BY_TOOL, **cases.OF_LEDGER)
def angles(reading: Values) -> Rows:
    """Angles of Table 4 less those of the nearest branch [rad], and how far they put the tool off the corner [m]."""
    arm, pose = cases.arm_of(reading), cases.printed_poses()[0]
    for corner, point in cases.CORNERS.items():
        own = cases.printed(f"configuration-{corner.lower()}")
        tool = docking.on_base(arm, pose).forward(own)[:3, 3]
        q, valid, _ = docking.configurations(arm, pose, [point], TOOLS[reading["tool-orientation"]])
        misses = _misses(arm, own, q[valid]) if valid.any() else []
        off = (tool - tool.new_tensor(point)).norm()
        yield {"corner": corner, "off": off, **dict(zip(ANGLES, misses, strict=False))}


@experiment(keys=("pose",), arrays=("w",), smoke={"per_side": 9}, **BY_TOOL, **cases.OF_LEDGER)
def maps(reading: Values, per_side: int = 101) -> tuple[list[Any], dict[str, Any]]:
    """Shares of the task area with at least half of the largest w and with none; every other point of the maps."""
    poses = {"first run": cases.printed_poses()[0], "ill placed": cases.printed("ill-placed-pose")}
    points, half = docking.square(0.2, per_side), (per_side + 1) // 2
    arm, tool, rows, drawn = cases.arm_of(reading), TOOLS[reading["tool-orientation"]], [], []
    for name, pose in poses.items():
        w = docking.largest_manipulability(arm, pose, points, tool).reshape(per_side, per_side)
        high, dead = (w >= w.max() / 2).double().mean(), (w == 0).double()
        # K is the first point, and the first quarter of the area the one about it.
        near_k = dead[:half, :half].mean() / 4
        rows.append({"pose": name, "high": high, "dead": dead.mean(), "dead_near_k": near_k})
        drawn.append(w[::2, ::2].float())
    return rows, {"w": torch.stack(drawn)}


@experiment(keys=("points",), smoke={"drawn": 5_000, "fine_per_side": 9}, **BY_TOOL, **cases.OF_DATA)
def control_points(seed: int, reading: Values, drawn: int = 1_000_000, fine_per_side: int = 41) -> Rows:
    """Smallest w of a fine grid beside that of few control points, over random poses that reach all corners."""
    tool = TOOLS[reading["tool-orientation"]]
    problem = docking.DockingProblem(cases.arm_of(reading), region="or", tool=tool)
    poses = cases.drawn_poses(problem, drawn, seed)
    poses = poses[problem.area_manipulability(poses) > 0]
    fine, *coarse = (
        docking.area_manipulability(problem.arm, poses, docking.square(0.2, per_side), tool)
        for per_side in (fine_per_side, *SIDES)
    )
    for per_side, at_points in zip(SIDES, coarse, strict=True):
        kept = (fine / at_points)[at_points > 0]
        dead = (kept == 0).double().mean()
        yield {"points": per_side**2, "kept": kept.median(), "worst": kept.min(), "dead": dead}


def elbow_of(arm: Chain) -> ElbowArm:
    """Return the elbow arm that a chain is; ValueError if it is none."""
    elbow = ElbowArm.of(arm)
    if elbow is None:
        raise ValueError(f"arm is {arm}; an elbow arm is needed")
    return elbow


def _largest_upright(elbow: ElbowArm) -> Tensor:
    side = torch.linspace(-1, 1, 1601, dtype=torch.float64) * (elbow.upper_arm + elbow.forearm)
    ahead, up = torch.meshgrid(side[side >= 0], side, indexing="ij")
    point = torch.stack([(ahead.square() + elbow.sideways**2).sqrt(), 0 * up, up + elbow.height])
    return elbow.manipulability(point, point.new_tensor([0.0, 0.0, 1.0])[:, None, None]).max()


def _misses(arm: Chain, printed: Tensor, branches: Tensor) -> list[float]:
    """Differences (6,) from the branch, or the copy of it by full turns, that has most of the angles."""
    wide = Chain(arm.screws, arm.home, lower=[-2 * math.pi] * 6, upper=[2 * math.pi] * 6)
    misses = printed - torch.cat([copies_within_limits(wide, branch) for branch in branches])
    sizes = misses[:, COMPARED].abs()
    best = misses[((sizes <= MATCH).sum(1) - sizes.clamp(max=10).sum(1) / 100).argmax()]
    best[3] = spatial.wrap_to_pi(best[3])
    return best.tolist()
