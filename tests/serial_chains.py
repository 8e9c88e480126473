"""Serial robots described joint by joint, from which each library builds its own model of the same robot."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

import dexterity as dx

Kind = Literal["revolute", "prismatic"]


@dataclass(frozen=True)
class Joint:
    """A joint about or along a unit axis (3,) of its frame, placed (4, 4) in the frame of the one before."""

    kind: Kind
    placement: NDArray[np.float64]
    axis: NDArray[np.float64]


@dataclass(frozen=True)
class SerialRobot:
    """Joints from the base to the tool, and the tool's pose (4, 4) in the moved frame of the last joint."""

    joints: tuple[Joint, ...]
    tool: NDArray[np.float64]

    def chain(self) -> dx.Chain:
        """Chain of the package, from the screws at home."""
        T = np.eye(4)
        screws = []
        for joint in self.joints:
            T = T @ joint.placement
            axis, point = T[:3, :3] @ joint.axis, T[:3, 3]
            if joint.kind == "revolute":
                screws.append([*np.cross(point, axis), *axis])
            else:
                screws.append([*axis, 0, 0, 0])
        return dx.Chain(np.array(screws), T @ self.tool)


def random_robot(rng: np.random.Generator, joints: int) -> SerialRobot:
    """Robot of at least two joints in general position, revolute and prismatic ones mixed."""
    kinds: list[Kind] = [
        "revolute",
        "prismatic",
        *rng.choice(["revolute", "prismatic"], joints - 2, p=[0.7, 0.3]),
    ]
    rng.shuffle(kinds)
    return SerialRobot(
        tuple(Joint(kind, random_pose(rng), _random_axis(rng)) for kind in kinds), random_pose(rng)
    )


def random_pose(rng: np.random.Generator) -> NDArray[np.float64]:
    """Pose (4, 4) of any orientation, about half a metre away."""
    T = np.eye(4)
    T[:3, :3] = Rotation.random(random_state=rng).as_matrix()
    T[:3, 3] = rng.normal(0, 0.3, 3)
    return T


def paper_uvms() -> SerialRobot:
    """Return paper A's UVMS from the points and axes of its section 2.1, with the robot file's links."""
    y_MB, l1, l2, l3 = 0.75, 0.0, 0.6, 0.4
    q1, q2 = (0, 0, 0), (0, y_MB, l1)
    q3, q4 = (0, y_MB + l2, l1), (0, y_MB + l2 + l3, l1)
    x, y, z = np.eye(3)
    points = [q1] * 6 + [q2] * 2 + [q3] + [q4] * 3
    axes = [x, y, z, x, y, z, z, -x, -x, z, -x, y]
    kinds: Sequence[Kind] = ["prismatic"] * 3 + ["revolute"] * 9
    steps = [_translation(np.subtract(b, a)) for a, b in pairwise([q1, *points])]
    joints = tuple(Joint(*joint) for joint in zip(kinds, steps, axes, strict=True))
    return SerialRobot(joints, np.eye(4))


def _random_axis(rng: np.random.Generator) -> NDArray[np.float64]:
    axis = rng.normal(size=3)
    return axis / np.linalg.norm(axis)


def _translation(step: NDArray[np.float64]) -> NDArray[np.float64]:
    T = np.eye(4)
    T[:3, 3] = step
    return T
