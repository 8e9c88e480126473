"""One policy of tolerances: what is taken as it is, what is taken and mended, and what is refused.

=================  =======  ==============================================================================
constant           value    what it decides
=================  =======  ==============================================================================
``ROUNDING``       1e-9     A condition that is missed by less holds. Nothing is changed.
``SIX_DIGITS``     1e-5     A condition that is missed by less holds for a description that is right to six
                            digits. It is taken as the nearest one that fulfils the condition: a rotation as
                            the nearest rotation, an axis with unit length, axes that almost meet or are
                            almost parallel as if they did. A public function says by how much it missed:
                            :func:`dexterity.spatial.rotation_miss` of a rotation,
                            :func:`dexterity.inverse_kinematics.geometric_miss` of an arm.
``LIMIT``          1e-9     Ends of limits [rad] or [m] are included, and so is what exceeds them by less.
                            Each function that compares with limits takes another value as an argument.
=================  =======  ==============================================================================

A larger miss and a reflection are refused with a message that names the argument and the miss. Angles that
come out of a function are exact to rounding for the description as it was taken.

Examples
--------
>>> import torch
>>> import dexterity as dx
>>> R = dx.spatial.from_rpy([0.3, 0.4, 0.5])[:3, :3]
>>> printed = (R * 1e6).round() / 1e6
>>> 1e-7 < float(dx.spatial.rotation_miss(printed)) < dx.spatial.tolerances.SIX_DIGITS
True
>>> T = dx.spatial.pose(printed, [0, 0, 0])
>>> float(dx.spatial.rotation_miss(T)) < 1e-15
True
"""

from __future__ import annotations

__all__ = ["LIMIT", "ROUNDING", "SIX_DIGITS"]

ROUNDING = 1e-9
SIX_DIGITS = 1e-5
LIMIT = 1e-9
