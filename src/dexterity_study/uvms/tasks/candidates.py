"""Sets of candidate configurations that a planner might choose from, and their Jacobians.

A ranking says as much about the candidates as about the index that ranks them, so that every number of the chapter names
the set that it is for.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np
import torch
from scipy.spatial.transform import Rotation
from torch import Tensor

from dexterity import robots
from dexterity_study.uvms.indices.experiment import ONES, VEHICLE_LOCKED
from dexterity_study.uvms.kinematics.experiment import draws


@dataclass(frozen=True)
class CandidateSet:
    """A way to draw candidates.

    Attributes
    ----------
    draw
        Takes a seed and a number m, and returns configurations (m, 12) [m] and [rad].
    joint_rates
        Rates (12,) of the joints while the task is done, [m/s] and [rad/s]; zero for joints that are locked.
    """

    draw: Callable[[int, int], Tensor]
    joint_rates: tuple[float, ...] = ONES * 2

    @property
    def moves(self) -> Tensor:
        """Whether each joint moves, (12,) ones and zeros."""
        return (torch.tensor(self.joint_rates) > 0).double()


def candidates(seed: int, count: int, vehicle_deg: float = 15.0, arm_deg: float = 60.0) -> Tensor:
    """Draw configurations (m, 12) that hold the UVMS's tool in its pose at home.

    Vehicle angles and the arm's first three joints are drawn; the other six joints follow from them.
    """
    random = torch.Generator().manual_seed(seed)
    half_range = torch.tensor(np.radians([vehicle_deg] * 3 + [arm_deg] * 3))
    return holding((2 * torch.rand(count, 6, generator=random, dtype=torch.float64) - 1) * half_range)


def holding(angles: Tensor) -> Tensor:
    """Return the configurations (m, 12) with the tool in its pose at home and angles (m, 6) given [rad].

    The angles are those of the vehicle and of the arm's first three joints. The wrist's three joints, which turn about
    z, -x and y, make up the orientation, and the vehicle's translation the position.
    """
    chain = robots.uvms()
    q = torch.zeros(len(angles), chain.joints, dtype=torch.float64)
    q[:, 3:9] = angles
    wrist = chain.forward(q)[:, :3, :3].mT @ chain.home[:3, :3]
    z, x, y = Rotation.from_matrix(wrist.numpy()).as_euler("ZXY").T
    q[:, 9:12] = torch.as_tensor(np.stack([z, -x, y], axis=-1))
    q[:, :3] = chain.home[:3, 3] - chain.forward(q)[:, :3, 3]
    return q


def _random_postures(range_deg: float) -> Callable[[int, int], Tensor]:
    return lambda seed, count: draws(robots.uvms(), seed, count, range_deg)[0]


def _arm_postures(seed: int, count: int) -> Tensor:
    q = draws(robots.uvms(), seed, count)[0]
    q[:, :6] = 0.0
    return q


SETS: Mapping[str, CandidateSet] = MappingProxyType(
    {
        "tool at rest": CandidateSet(candidates),
        "random, ±15°": CandidateSet(_random_postures(15.0)),
        "random, ±60°": CandidateSet(_random_postures(60.0)),
        "arm alone, ±60°": CandidateSet(_arm_postures, VEHICLE_LOCKED),
    }
)
"""Candidate sets of the chapter. The vehicle of the last one keeps still at the world's origin."""
