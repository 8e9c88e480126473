"""Where an underwater vehicle should dock so that its arm is dexterous over an area: paper B.

Examples
--------
>>> import dexterity as dx
>>> arm, corners = dx.robots.docking_arm(), dx.docking.square(0.2)
>>> M_a = dx.docking.area_manipulability(arm, [-0.4, -0.2, 0.2, 0.84], corners)
>>> round(float(M_a), 3)
0.026
"""

from typing import TYPE_CHECKING

from dexterity import lazy
from dexterity.docking.area import (
    TOOL_UP,
    Solutions,
    area_manipulability,
    base_pose,
    configurations,
    inverse_kinematics,
    largest_manipulability,
    on_base,
    square,
)
from dexterity.docking.free_branches import block_and_vehicle
from dexterity.docking.problem import Docking, DockingProblem, evaluations, genetic_docking, global_docking

if TYPE_CHECKING:
    from dexterity.docking import export

__all__ = [
    "TOOL_UP",
    "Docking",
    "DockingProblem",
    "Solutions",
    "area_manipulability",
    "base_pose",
    "block_and_vehicle",
    "configurations",
    "evaluations",
    "export",
    "genetic_docking",
    "global_docking",
    "inverse_kinematics",
    "largest_manipulability",
    "on_base",
    "square",
]

# Hidden from type checkers, for whom every name would otherwise be a module.
if not TYPE_CHECKING:
    __getattr__, __dir__ = lazy.submodules(__name__, __all__)
