"""How a large flexible log crane is positioned: paper D."""

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
    "tip_jacobian",
    "tip_position",
    "training_set",
    "within_limits",
]
