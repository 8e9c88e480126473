"""Exact and learned kinematics of manipulators, and the study of four papers built on them.

Quantities are SI and radians in float64; leading axes are batch axes; twists are ordered [v; ω];
``T_a_b`` maps coordinates in frame b to frame a.
"""

from dexterity import (
    crane,
    docking,
    indices,
    inverse_kinematics,
    networks,
    robots,
    sampling,
    search,
    spatial,
    symbolic,
    tasks,
    workspace,
)
from dexterity.chain import Chain

__version__ = "0.1.0"

__all__ = [
    "Chain",
    "crane",
    "docking",
    "indices",
    "inverse_kinematics",
    "networks",
    "robots",
    "sampling",
    "search",
    "spatial",
    "symbolic",
    "tasks",
    "workspace",
]
