"""Joint values that put the tool at a pose: all of them in closed form, or by search, for any chain.

:func:`.solve` takes a closed form where the chain has one (:func:`.closed_form`) and a search from many
seeds where not, and says which. The closed forms can be called by themselves (`wrists`, `parallel_axes`).
Full turns and limits are in `turns`, motion that leaves the tool where it is in `null_space`.

Examples
--------
>>> import dexterity as dx
>>> puma = dx.robots.puma560()
>>> T = puma.forward([0.0, 0.5, 0.25, 0.0, 0.5, 0.0])
>>> dx.inverse_kinematics.solve(puma, T)
Solutions(1 pose by spherical wrist (complete): 1 reached within the limits)
>>> q, valid = dx.inverse_kinematics.spherical_wrist(puma, T)
>>> q.shape, int(valid.sum())
(torch.Size([8, 6]), 8)
"""

from dexterity.inverse_kinematics.closed_forms import closed_form, geometric_miss
from dexterity.inverse_kinematics.null_space import (
    damped_pseudo_inverse,
    null_space_projector,
    null_space_step,
)
from dexterity.inverse_kinematics.parallel_axes import three_parallel_axes
from dexterity.inverse_kinematics.slices import slices
from dexterity.inverse_kinematics.solutions import SeedsEnded, Solutions
from dexterity.inverse_kinematics.solver import solve
from dexterity.inverse_kinematics.subproblems import subproblem_1, subproblem_2, subproblem_3, subproblem_4
from dexterity.inverse_kinematics.turns import copies_within_limits, nearest_copy, within_limits
from dexterity.inverse_kinematics.wrists import spherical_shoulder, spherical_wrist

__all__ = [
    "SeedsEnded",
    "Solutions",
    "closed_form",
    "copies_within_limits",
    "damped_pseudo_inverse",
    "geometric_miss",
    "nearest_copy",
    "null_space_projector",
    "null_space_step",
    "slices",
    "solve",
    "spherical_shoulder",
    "spherical_wrist",
    "subproblem_1",
    "subproblem_2",
    "subproblem_3",
    "subproblem_4",
    "three_parallel_axes",
    "within_limits",
]
