"""Frames of a scene: poses by path, `parent/child`, parents before their children."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from dexterity.chain import Chain
from dexterity.scenes.arguments import Array
from dexterity.scenes.motion import JointMotion, joint_motion

__all__ = ["DrawnChain", "axis_frame", "chain_frames", "in_world", "node_name"]


@dataclass(frozen=True)
class DrawnChain:
    """A chain in a scene, its joint values, and the paths of the frames that its joints move."""

    chain: Chain
    q: Array
    joints: tuple[str, ...]

    def motions(self, frames: Array, frames_per_second: float, argument: str) -> dict[str, JointMotion]:
        """Motions of the joints that do not rest, through joint values (m, n), by path.

        Raises
        ------
        ValueError
            If a joint turns by π or more from one frame to the next; it names the argument.
        """
        turns = np.abs(np.diff(frames, axis=0)).max(axis=0)
        for joint, kind, turn in zip(self.chain.joint_names, self.chain.kinds, turns, strict=True):
            if kind == "revolute" and turn >= math.pi:
                raise ValueError(
                    f"{argument} turns {joint} by {turn:.3g} rad in one frame; less than π is needed"
                )
        return {
            path: JointMotion(self.chain.joint_names[i], self.chain.kinds[i], frames[:, i], frames_per_second)
            for i, path in enumerate(self.joints)
            if (frames[:, i] != self.q[i]).any()
        }


def chain_frames(chain: Chain, q: Array, name: str) -> tuple[dict[str, Array], tuple[str, ...]]:
    """Frames link0/joint0/link1/… of a chain below `name`, and the paths of those that its joints move."""
    path = node_name(name)
    frames = {path: np.eye(4)}
    joints: list[str] = []
    links = chain.link_transforms.numpy()
    for i, kind in enumerate(chain.kinds):
        path = f"{path}/link{i}"
        frames[path] = links[i]
        path = f"{path}/joint{i}"
        frames[path] = joint_motion(kind, q[i])
        joints.append(path)
    frames[f"{path}/link{chain.joints}"] = links[-1]
    return frames, tuple(joints)


def node_name(name: str) -> str:
    """Name of the viewer's node for a name of the scene.

    Names that mean something to every object of ECMAScript, or to the viewer, get an invisible letter, which
    no name of a scene has.
    """
    return f"{name}\u2060" if name.startswith("__") or name in _TAKEN else name


_TAKEN = frozenset(
    {
        *("<object>", "constructor", "hasOwnProperty", "isPrototypeOf", "propertyIsEnumerable"),
        *("toLocaleString", "toString", "valueOf"),
    }
)


def axis_frame(chain: Chain, joint: int) -> tuple[int, Array]:
    """Joint that carries the arrow of a joint's axis, and the pose of the arrow in that joint's frame.

    Prismatic joints that follow one another have their arrows at the last of them.
    """
    links = chain.link_transforms.numpy()
    bearer, R_axis_bearer = joint, np.eye(3)
    while chain.kinds[bearer : bearer + 2] == ("prismatic", "prismatic"):
        bearer += 1
        R_axis_bearer = R_axis_bearer @ links[bearer][:3, :3]
    T_bearer_axis = np.eye(4)
    T_bearer_axis[:3, :3] = R_axis_bearer.T
    return bearer, T_bearer_axis


def in_world(frames: Mapping[str, Array]) -> dict[str, Array]:
    """Turn poses in their parents' frames into poses in the world; parents come before their children."""
    world: dict[str, Array] = {"": np.eye(4)}
    for path, T_parent_frame in frames.items():
        world[path] = world[path.rpartition("/")[0]] @ T_parent_frame
    return world
