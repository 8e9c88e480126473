"""Ways to bring the loaded tip of the crane to a point: the thesis's four, and today's.

Examples
--------
>>> from dexterity.crane.positioning import compensate, errors, linear_sag, thesis_task
>>> task = thesis_task(points=[[4.0, 0.0], [5.0, 2.0]], payloads=[100.0])
>>> placement = compensate(task, linear_sag(), corrections=10)
>>> bool(errors(task, placement).largest[2] < 1e-6)
True
"""

from typing import TYPE_CHECKING

from dexterity import lazy
from dexterity.crane.positioning.angle_network import AngleNetworkSag
from dexterity.crane.positioning.compensation import (
    by_inverse_network,
    compensate,
    exact_inverse,
    genetic,
    network_sag,
    uncompensated,
)
from dexterity.crane.positioning.genetic import GeneticInverseOptions, genetic_inverse
from dexterity.crane.positioning.inversion import (
    DescentOptions,
    GaussNewtonOptions,
    descend,
    gauss_newton,
    network_tip,
    safe_rate,
    sagging_tip,
)
from dexterity.crane.positioning.learning import (
    correction_network,
    direct_network,
    inverse_network,
    modular_network,
)
from dexterity.crane.positioning.regression import TrigonometricSag, trigonometric_features
from dexterity.crane.positioning.tables import TableSag
from dexterity.crane.positioning.task import (
    Errors,
    Placement,
    Task,
    corotational_sag,
    errors,
    linear_sag,
    thesis_task,
)

if TYPE_CHECKING:
    from dexterity.crane.positioning import export

__all__ = [
    "AngleNetworkSag",
    "DescentOptions",
    "Errors",
    "GaussNewtonOptions",
    "GeneticInverseOptions",
    "Placement",
    "TableSag",
    "Task",
    "TrigonometricSag",
    "by_inverse_network",
    "compensate",
    "corotational_sag",
    "correction_network",
    "descend",
    "direct_network",
    "errors",
    "exact_inverse",
    "export",
    "gauss_newton",
    "genetic",
    "genetic_inverse",
    "inverse_network",
    "linear_sag",
    "modular_network",
    "network_sag",
    "network_tip",
    "safe_rate",
    "sagging_tip",
    "thesis_task",
    "trigonometric_features",
    "uncompensated",
]

# Hidden from type checkers, for whom every name would otherwise be a module.
if not TYPE_CHECKING:
    __getattr__, __dir__ = lazy.submodules(__name__, __all__)
