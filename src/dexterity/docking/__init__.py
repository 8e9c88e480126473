"""Where an underwater vehicle should dock so that its arm is dexterous over an area: paper B.

Examples
--------
>>> import dexterity as dx
>>> arm, corners = dx.robots.docking_arm(), dx.docking.square(0.2)
>>> M_a = dx.docking.area_manipulability(arm, [-0.4, -0.2, 0.2, 0.84], corners)
>>> round(float(M_a), 3)
0.026
"""

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
from dexterity.docking.problem import Docking, DockingProblem, genetic_docking, global_docking

__all__ = [
    "TOOL_UP",
    "Docking",
    "DockingProblem",
    "Solutions",
    "area_manipulability",
    "base_pose",
    "configurations",
    "genetic_docking",
    "global_docking",
    "inverse_kinematics",
    "largest_manipulability",
    "on_base",
    "square",
]
