"""How a large flexible log crane is positioned: paper D.

Examples
--------
The rigid tip [m], and its vertical deflection [mm] under 200 kg:

>>> import dexterity as dx
>>> strokes = [0.25, 0.5, 1.0]
>>> [round(coordinate, 1) for coordinate in dx.crane.tip_position(strokes).tolist()]
[3.7, -0.7]
>>> round(1000 * float(dx.crane.deflection(strokes, payload=200.0)[1]))
-22
"""

from typing import TYPE_CHECKING

from dexterity import lazy
from dexterity.crane import positioning
from dexterity.crane.data import TEST_PAYLOADS, TEST_POINTS, TrainingSet, training_set
from dexterity.crane.description import Crane, patu655, read_crane
from dexterity.crane.equilibrium import NewtonOptions, Sag, corotational_deflection
from dexterity.crane.existing import Differences, ExistingCrane, JointForces, existing_crane, joint_forces
from dexterity.crane.kinematics import (
    Posture,
    Reach,
    inverse,
    least_extension,
    posture,
    tip_jacobian,
    tip_position,
    within_limits,
)
from dexterity.crane.similarity import scaled
from dexterity.crane.structure import LoadResponse, deflection, flexible_tip, load_response

if TYPE_CHECKING:
    from dexterity.crane import shape

__all__ = [
    "TEST_PAYLOADS",
    "TEST_POINTS",
    "Crane",
    "Differences",
    "ExistingCrane",
    "JointForces",
    "LoadResponse",
    "NewtonOptions",
    "Posture",
    "Reach",
    "Sag",
    "TrainingSet",
    "corotational_deflection",
    "deflection",
    "existing_crane",
    "flexible_tip",
    "inverse",
    "joint_forces",
    "least_extension",
    "load_response",
    "patu655",
    "positioning",
    "posture",
    "read_crane",
    "scaled",
    "shape",
    "tip_jacobian",
    "tip_position",
    "training_set",
    "within_limits",
]

# Hidden from type checkers, for whom every name would otherwise be a module.
if not TYPE_CHECKING:
    __getattr__, __dir__ = lazy.submodules(__name__, __all__)
