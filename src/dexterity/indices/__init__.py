"""Dexterity indices: an open set of measures of a Jacobian, and the ellipsoids behind them.

An :class:`Index` is a measure together with a frame, rows, rates and whatever else gives it a meaning. Each
measure is one file in ``indices/measures``, which is found by itself; :func:`names` lists them and
:func:`describe` says what one is.

Examples
--------
>>> import dexterity as dx
>>> puma, q = dx.robots.puma560(), [0.0, 0.5, 0.25, 0.0, 0.5, 0.0]
>>> w = dx.indices.Index("manipulability").bind(puma)
>>> round(float(w(q)), 4)
0.0087
>>> position = dx.indices.Index("kci", "geometric", rows="translational")
>>> position.name, round(float(position(puma, q)), 4)
('kinematic_conditioning', 0.1482)
>>> dx.indices.describe("log_w").title
'Logarithm of the manipulability, log w'
>>> J = puma.geometric_jacobian(q)
>>> dx.indices.velocity_ellipsoid(J, "translational").semi_axes.shape
torch.Size([3])
"""

from dexterity.indices.ellipsoids import Ellipsoid, Part, force_ellipsoid, velocity_ellipsoid
from dexterity.indices.index import Frame, Index
from dexterity.indices.jacobians import kinematic_conditioning, manipulability, normalise
from dexterity.indices.measure import Closed, Measure, Situation, Spectral, Symbols
from dexterity.indices.reach_of_rows import require_not_zero_everywhere
from dexterity.indices.registry import describe, names
from dexterity.indices.rows import ROW_NAMES, Rows

__all__ = [
    "ROW_NAMES",
    "Closed",
    "Ellipsoid",
    "Frame",
    "Index",
    "Measure",
    "Part",
    "Rows",
    "Situation",
    "Spectral",
    "Symbols",
    "describe",
    "force_ellipsoid",
    "kinematic_conditioning",
    "manipulability",
    "names",
    "normalise",
    "require_not_zero_everywhere",
    "velocity_ellipsoid",
]
