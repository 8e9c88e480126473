"""What moves in a scene by itself: joints that take values and bars whose ends wander, frame by frame."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from meshcat.animation import AnimationClip
from scipy.spatial.transform import Rotation

from dexterity.chain import JointKind
from dexterity.scenes.arguments import Array

__all__ = ["BarMotion", "JointMotion", "joint_motion"]


@dataclass(frozen=True)
class JointMotion:
    """Values (m,) that a joint takes one after the other."""

    name: str
    kind: JointKind
    values: Array
    frames_per_second: float

    def poses(self) -> Array:
        """Motion of the joint in each frame, (m, 4, 4)."""
        return joint_motion(self.kind, self.values)

    def spans(self) -> list[tuple[float, float]]:
        """Pairs of times [s] between which the joint moves."""
        moves = np.concatenate([[False], np.diff(self.values) != 0, [False]])
        ends = np.flatnonzero(moves[1:] != moves[:-1]) / self.frames_per_second
        return list(zip(ends[::2].tolist(), ends[1::2].tolist(), strict=True))

    def clip(self) -> AnimationClip:
        """Keyframes for meshcat, without those inside a rest."""
        clip = AnimationClip(fps=self.frames_per_second)
        for frame in _frames_in_motion(self.values[:, None]):
            value = float(self.values[frame])
            if self.kind == "revolute":
                turn = [0.0, 0.0, math.sin(value / 2), math.cos(value / 2)]
                clip.set_property(frame, "quaternion", "quaternion", turn)
            else:
                clip.set_property(frame, "position", "vector3", [0.0, 0.0, value])
        return clip


@dataclass(frozen=True)
class BarMotion:
    """Where a bar along the y axis is moved to, one frame after the other.

    Attributes
    ----------
    middles
        (k, 3) in the world [m].
    turns
        (k, 4) unit quaternions x, y, z, w that turn y into its direction.
    stretches
        (k) lengths over the one that it was drawn with.
    """

    middles: Array
    turns: Array
    stretches: Array
    frames_per_second: float

    @classmethod
    def of(cls, ends: Array, length: float, frames_per_second: float) -> BarMotion:
        """Follow the ends (k, 2, 3) of a bar that was drawn with a length.

        Raises
        ------
        ValueError
            If the bar turns by π from one frame to the next.
        """
        along = ends[:, 1] - ends[:, 0]
        lengths = np.linalg.norm(along, axis=1)
        middles = ends.mean(axis=1)
        return cls(middles, _turns_of_y(along / lengths[:, None]), lengths / length, frames_per_second)

    def poses(self) -> Array:
        """Frame of the bar in each frame of the animation, (k, 4, 4); its y axis is stretched."""
        T = np.broadcast_to(np.eye(4), (len(self.middles), 4, 4)).copy()
        T[:, :3, :3] = Rotation.from_quat(self.turns).as_matrix()
        T[:, :3, 1] *= self.stretches[:, None]
        T[:, :3, 3] = self.middles
        return T

    def clip(self) -> AnimationClip:
        """Keyframes for meshcat, without those inside a rest."""
        clip = AnimationClip(fps=self.frames_per_second)
        stretches = np.ones_like(self.middles)
        stretches[:, 1] = self.stretches
        tracks = {"position": self.middles, "quaternion": self.turns, "scale": stretches}
        for name, values in tracks.items():
            kind = "quaternion" if name == "quaternion" else "vector3"
            for frame in _frames_in_motion(values):
                clip.set_property(frame, name, kind, values[frame].tolist())
        return clip


def _frames_in_motion(values: Array) -> list[int]:
    """Name the frames of (k, n) values but those inside a rest."""
    changes = (np.diff(values, axis=0) != 0).any(axis=1)
    return [int(frame) for frame in np.flatnonzero(np.append(True, changes) | np.append(changes, True))]


def _turns_of_y(directions: Array) -> Array:
    """Turn y into unit vectors (k, 3), each the shortest way from the last: unit quaternions (k, 4)."""
    y = np.array([0.0, 1.0, 0.0])
    # Half a turn about x is as short as any other way to look against y.
    turn = Rotation.from_rotvec([math.pi if directions[0, 1] < _RIGHT_ROUND else 0.0, 0.0, 0.0])
    turns = []
    for i, direction in enumerate(directions):
        now = turn.apply(y)
        axis, cosine = np.cross(now, direction), now @ direction
        sine = np.linalg.norm(axis)
        if i and cosine < _RIGHT_ROUND:
            raise ValueError("frames turns a bar right round in one frame; less than π is needed")
        # A bar that keeps its direction keeps its turn to the last digit.
        if sine > 0 and not (i and (direction == directions[i - 1]).all()):
            turn = Rotation.from_rotvec(axis / sine * math.atan2(sine, cosine)) * turn
        turns.append(turn.as_quat())
    return np.array(turns)


_RIGHT_ROUND = -1 + 1e-9
"""Cosine of a turn by π, but for rounding."""


def joint_motion(kind: JointKind, values: Array | float) -> Array:
    """Turn about z or move along z: (...) values to (..., 4, 4) poses."""
    T = np.broadcast_to(np.eye(4), (*np.shape(values), 4, 4)).copy()
    if kind == "prismatic":
        T[..., 2, 3] = values
        return T
    T[..., 0, 0] = T[..., 1, 1] = np.cos(values)
    T[..., 1, 0] = np.sin(values)
    T[..., 0, 1] = -T[..., 1, 0]
    return T
