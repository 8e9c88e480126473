"""Colours of scenes and figures, which stay apart in every common colour blindness.

Examples
--------
>>> from dexterity.scenes.colors import COLORS
>>> COLORS["blue"]
'#0072B2'
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

import matplotlib.colors

from dexterity.chain import JointKind

__all__ = ["AXIS_COLORS", "COLORS", "TRIAD_COLOR", "darker", "hex_color", "number"]

COLORS: Mapping[str, str] = MappingProxyType(
    {
        "black": "#000000",
        "orange": "#E69F00",
        "sky blue": "#56B4E9",
        "bluish green": "#009E73",
        "yellow": "#F0E442",
        "blue": "#0072B2",
        "vermillion": "#D55E00",
        "reddish purple": "#CC79A7",
    }
)
"""The eight colours of Okabe & Ito (2008), which stay apart in every common colour blindness."""

AXIS_COLORS: Mapping[JointKind, str] = {
    "prismatic": COLORS["reddish purple"],
    "revolute": COLORS["orange"],
}
"""Colours of joint axes."""

TRIAD_COLOR = "#1f2933"
"""Colour of the axes of a tool's frame, which letters tell apart."""


def hex_color(color: str) -> str:
    """Return ``#rrggbb`` for a name of :data:`COLORS` or a colour of matplotlib.

    Raises
    ------
    ValueError
        If there is no such colour.
    """
    try:
        return matplotlib.colors.to_hex(COLORS.get(color, color))
    except (ValueError, TypeError):
        raise ValueError(f"color is {color!r}; {', '.join(COLORS)} are known, and '#rrggbb'") from None


def darker(color: str) -> str:
    """Return a darker shade of ``#rrggbb``."""
    red, green, blue = matplotlib.colors.to_rgb(color)
    return matplotlib.colors.to_hex((0.65 * red, 0.65 * green, 0.65 * blue))


def number(color: str) -> int:
    """Return ``#rrggbb`` as a number, for three.js."""
    return int(color.removeprefix("#"), 16)
