"""Scenes of a vehicle that is docked on a block, which the chapters on docking share."""

from __future__ import annotations

from torch import Tensor

from dexterity import docking, indices
from dexterity.chain import Chain
from dexterity.docking import DockingProblem
from dexterity.docking.area import TOOL_AHEAD, TOOL_UP, Face
from dexterity.scenes import Scene
from dexterity_study.claims.ledger import load_paper
from dexterity_study.docking.cases import CORNERS
from dexterity_study.docking.inverse_kinematics.show import PALETTE

PAPER = load_paper("sotiropoulos2011")
BODY = PAPER.printed("vehicle")
BLOCK = "#8B8378"

_REGIONS = {
    "top": ((-0.55, -0.4, 0.0), (0.2, 0.2, 0.4)),
    "side": ((-0.5, -0.6, -0.25), (0.0, 0.2, 0.25)),
}
"""Opposite corners of what the camera looks at, with the arm and the task area in it [m]."""

_VIEWS = {"top": (0.7, -1.0, 0.8), "side": (-0.8, 1.0, 0.5)}


def stage(title: str, face: Face = "top") -> Scene:
    """Set a block with the task area on one of its faces."""
    scene, block = Scene(title, view_from=_VIEWS[face]), PAPER.printed("block")
    below = [0, 0, -block[2] / 2, 0] if face == "top" else [block[0] / 2, 0, 0, 0]
    scene.add_box(block, pose=docking.base_pose(below), name="block", color=BLOCK)
    ring = list(_corners(face).values())
    scene.add_path([*ring, ring[0]], name="task area", color="orange")
    return scene


def add_docked(scene: Scene, arm: Chain, pose: Tensor, face: Face = "top") -> None:
    """Add the vehicle at a pose (4,) or (6,) of its arm's base, and the arm at every corner that it reaches."""
    scene.add_box(BODY, pose=docking.base_pose(pose) @ body_on_base(), name="vehicle")
    tool = TOOL_UP if face == "top" else TOOL_AHEAD
    for (corner, point), color in zip(_corners(face).items(), PALETTE, strict=True):
        q, valid, within = docking.configurations(arm, pose, [point], tool)
        allowed = q[valid & within]
        if len(allowed):
            best = allowed[indices.manipulability(arm.geometric_jacobian(allowed)).argmax()]
            name = f"arm at {corner}"
            scene.add_chain(docking.on_base(arm, pose), best, name=name, axes=False, color=color)
    scene.add_letters(_corners(face))
    scene.look_at(*_REGIONS[face])


def body_on_base() -> Tensor:
    """Return the pose of the middle of the vehicle in the arm's base: behind it, its bottom as low as the foot."""
    length, _, height = BODY
    return docking.base_pose([-length / 2, 0, DockingProblem.foot[2] + height / 2, 0])


def _corners(face: Face) -> dict[str, tuple[float, float, float]]:
    """Return the corners of the task area in G [m] by the paper's letters, one after the other round it."""
    if face == "top":
        return dict(CORNERS)
    return {name: (0.0, x, y) for name, (x, y, _) in CORNERS.items()}
