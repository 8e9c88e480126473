"""Arms of the tests: parameters printed in public issues, and forward kinematics of other libraries."""

from __future__ import annotations

import math
from collections.abc import Callable
from math import pi

import numpy as np
import torch
from numpy.typing import NDArray

import dexterity as dx

UR5 = dx.Chain.from_dh(
    [{"d": 0.089459, "alpha": pi / 2}, {"a": -0.425}, {"a": -0.39225}, {"d": 0.10915, "alpha": pi / 2},
     {"d": 0.09465, "alpha": -pi / 2}, {"d": 0.0823}],
    name="UR5", lower=[-2 * pi] * 6, upper=[2 * pi] * 6,
)  # fmt: skip
UR3 = dx.Chain.from_dh(
    [{"d": 0.1519, "alpha": pi / 2}, {"a": -0.24365}, {"a": -0.21325}, {"d": 0.11235, "alpha": pi / 2},
     {"d": 0.08535, "alpha": -pi / 2}, {"d": 0.0819}],
    name="UR3",
)  # fmt: skip
PANDA = dx.Chain.from_dh(
    [{"d": 0.333}, {"alpha": -pi / 2}, {"alpha": pi / 2, "d": 0.316}, {"alpha": pi / 2, "a": 0.0825},
     {"alpha": -pi / 2, "a": -0.0825, "d": 0.384}, {"alpha": pi / 2}, {"alpha": pi / 2, "a": 0.088}],
    modified=True, tool=dx.spatial.translation(0, 0, 0.107), name="Panda",
    lower=[-2.8973, -1.7628, -2.8973, -3.0718, -2.8973, -0.0175, -2.8973],
    upper=[2.8973, 1.7628, 2.8973, -0.0698, 2.8973, 3.7525, 2.8973],
)  # fmt: skip
IIWA = dx.Chain.from_dh(
    [{"d": 0.36, "alpha": -pi / 2}, {"alpha": pi / 2}, {"d": 0.42, "alpha": pi / 2}, {"alpha": -pi / 2},
     {"d": 0.4, "alpha": -pi / 2}, {"alpha": pi / 2}, {"d": 0.126}],
    name="iiwa 14", lower=np.radians([-170, -120] * 3 + [-175]), upper=np.radians([170, 120] * 3 + [175]),
)  # fmt: skip
PLANAR = dx.Chain.from_dh([{"a": 0.5}, {"a": 0.4}, {"a": 0.2}], name="planar 3R")
SCARA = dx.Chain.from_dh(
    [{"a": 0.3}, {"a": 0.25, "alpha": pi}, {"kind": "prismatic"}, {}],
    name="SCARA", lower=[-2.5, -2.5, 0, -pi], upper=[2.5, 2.5, 0.2, pi],
)  # fmt: skip


def random_configurations(chain: dx.Chain, count: int, seed: int = 0) -> torch.Tensor:
    """Joint values within the limits, or within a turn about zero where there are none."""
    lower, upper = chain.lower.clamp(min=-math.pi), chain.upper.clamp(max=math.pi)
    shares = torch.rand(
        count, chain.joints, generator=torch.Generator().manual_seed(seed), dtype=torch.float64
    )
    return lower + (upper - lower) * shares


def screw(point: NDArray[np.float64], direction: NDArray[np.float64]) -> NDArray[np.float64]:
    """Revolute screw [v; ω] through a point."""
    direction = np.asarray(direction) / np.linalg.norm(direction)
    return np.concatenate([np.cross(point, direction), direction])


def chain_of(forward: Callable[[NDArray[np.float64]], NDArray[np.float64]], joints: int) -> dx.Chain:
    """Chain of revolute joints with the forward kinematics of another library, from quarter turns."""
    home = forward(np.zeros(joints))
    quarter = [dx.spatial.log(forward(q) @ np.linalg.inv(home)) for q in np.eye(joints) * pi / 2]
    return dx.Chain(torch.stack(quarter) / (pi / 2), home)


def apart(a: torch.Tensor, b: torch.Tensor) -> torch.Tensor:
    """Largest difference (...) of joint values, full turns apart."""
    return dx.spatial.wrap_to_pi(a - b).abs().amax(-1)
