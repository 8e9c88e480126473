"""Arms, readings of Eq. 14, corners and printed poses that the chapters on docking share."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from functools import cache
from typing import Any, TypeAlias

import torch
from torch import Tensor

from dexterity import docking, robots, spatial, store
from dexterity.chain import Chain
from dexterity.docking import DockingProblem

Values: TypeAlias = Mapping[str, Any]
Rows: TypeAlias = Iterator[dict[str, Any]]

CORNERS: Mapping[str, tuple[float, float, float]] = {
    "K": (-0.2, -0.2, 0.0),
    "L": (-0.2, 0.2, 0.0),
    "M": (0.2, 0.2, 0.0),
    "N": (0.2, -0.2, 0.0),
}
"""Corners of the task area in G [m]."""

ARMS: Mapping[str, str] = {"stated": "chosen", "fitted": "fitted-arm=fitted"}
"""Readings of the two arms, the one that the paper states and the one that was fitted to Table 4."""

CASES: Mapping[str, str] = {
    "stated, and": "chosen",
    "stated, or": "reading-of-the-group=or",
    "fitted, and": "fitted-arm=fitted",
    "fitted, or": "fitted-arm=fitted+reading-of-the-group=or",
}
"""Readings of the four cases: either arm, beside the task area in both directions or in one."""

PAPER = {"paper": "sotiropoulos2011"}
OF_DATA = {"data": ("robots/docking_arm.toml",)}
LEDGERS = tuple(f"papers/sotiropoulos2011/{of}.toml" for of in ("claims", "settings"))
OF_LEDGER = {"data": (*LEDGERS, *OF_DATA["data"])}
"""Data files of an experiment that computes at poses or angles which the paper prints."""

ROUNDING = {"rtol": 1e-6, "atol": 1e-6}
"""Rounding errors differ a little from processor to processor."""


def arm_of(reading: Values) -> Chain:
    """Return the arm of a reading."""
    return robots.docking_arm(reading["fitted-arm"])


def problem_of(reading: Values, **settings: Any) -> DockingProblem:
    """Return the docking problem of a reading, with some settings other than the paper's."""
    return DockingProblem(arm_of(reading), region=reading["reading-of-the-group"], **settings)


def printed(name: str, what: str = "value") -> Tensor:
    """Return what the paper prints for a claim or a setting, or the rounding of it."""
    return torch.tensor(_ledger()[name][what], dtype=torch.float64)


@cache
def _ledger() -> dict[str, dict[str, Any]]:
    parts = [store.read_toml(store.data_path(*name.split("/"))) for name in LEDGERS]
    return {entry["id"]: entry for part in parts for entries in part.values() for entry in entries}


def printed_poses() -> Tensor:
    """Return the poses (7, 4) of Table 3."""
    return torch.stack([printed(f"poses-{name}") for name in ("x", "y", "z", "psi")], dim=-1)


def drawn_joints(count: int, seed: int) -> Tensor:
    """Draw joint values (count, 6) from a full turn."""
    random = torch.Generator().manual_seed(seed)
    return (2 * torch.rand(count, 6, generator=random, dtype=torch.float64) - 1) * math.pi


def drawn_poses(problem: DockingProblem, count: int, seed: int) -> Tensor:
    """Draw so many poses of the whole box, and return those that are allowed."""
    random = torch.Generator().manual_seed(seed)
    unit = torch.rand(count, len(problem.lower), generator=random, dtype=torch.float64)
    poses = problem.lower + (problem.upper - problem.lower) * unit
    return poses[problem.allows(poses)]


def quarter_turned(poses: Tensor, turns: int) -> Tensor:
    """Turn poses (..., 4) by quarter turns about z; the square area looks the same."""
    angle = turns * math.pi / 2
    turn = docking.base_pose([0.0, 0.0, 0.0, angle])
    yaw = spatial.wrap_to_pi(poses[..., 3:] + angle)
    return torch.cat([spatial.apply(turn, poses[..., :3]), yaw], dim=-1)
