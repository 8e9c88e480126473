"""Which poses an arm reaches, how well, and where its base should be: for any chain.

Examples
--------
>>> from dexterity import reach
>>> len(reach.rotations(100)), reach.box([0.2, 0, 0], [0.6, 0, 0.4], spacing=0.1).shape
(216, torch.Size([25, 3]))
"""

from typing import TYPE_CHECKING

from dexterity import lazy
from dexterity.reach.following import Path, follow
from dexterity.reach.inverse_map import InverseReachMap
from dexterity.reach.placements import Placement, Placements
from dexterity.reach.placing import place
from dexterity.reach.positions import ball, bounds, box
from dexterity.reach.reach_map import ReachMap, ReachMapFileError
from dexterity.reach.rotation_grid import covering_radius, rotations
from dexterity.reach.surveys import survey
from dexterity.reach.tool_poses import panel, planar_bases, pointing, seam

__all__ = [
    "InverseReachMap",
    "Path",
    "Placement",
    "Placements",
    "ReachMap",
    "ReachMapFileError",
    "ball",
    "bounds",
    "box",
    "covering_radius",
    "follow",
    "panel",
    "place",
    "planar_bases",
    "pointing",
    "rotations",
    "seam",
    "survey",
]

# Hidden from type checkers, for whom every name would otherwise be a module.
if not TYPE_CHECKING:
    __getattr__, __dir__ = lazy.submodules(__name__, __all__)
