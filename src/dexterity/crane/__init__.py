"""How a large flexible log crane is positioned: paper D."""

from dexterity.crane.description import Crane, patu655, read_crane
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

__all__ = [
    "Crane",
    "Posture",
    "Reach",
    "inverse",
    "least_extension",
    "patu655",
    "posture",
    "read_crane",
    "tip_jacobian",
    "tip_position",
    "within_limits",
]
