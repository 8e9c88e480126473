"""Joint values that put the tool at a pose.

Closed forms find every configuration of six-joint arms three of whose axes meet (`wrists`) by Paden–Kahan
subproblems (`subproblems`). Full turns and limits are looked at afterwards (`turns`).

Examples
--------
>>> import dexterity as dx
>>> puma = dx.robots.puma560()
>>> T = puma.forward([0.0, 0.5, 0.25, 0.0, 0.5, 0.0])
>>> q, valid = dx.inverse_kinematics.spherical_wrist(puma, T)
>>> q.shape, int(valid.sum())
(torch.Size([8, 6]), 8)
"""

from dexterity.inverse_kinematics.subproblems import subproblem_1, subproblem_2, subproblem_3, subproblem_4
from dexterity.inverse_kinematics.turns import copies_within_limits, nearest_copy, within_limits
from dexterity.inverse_kinematics.wrists import spherical_shoulder, spherical_wrist

__all__ = [
    "copies_within_limits",
    "nearest_copy",
    "spherical_shoulder",
    "spherical_wrist",
    "subproblem_1",
    "subproblem_2",
    "subproblem_3",
    "subproblem_4",
    "within_limits",
]
