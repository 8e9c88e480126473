"""Cameras that look at a box of the world, for the viewer and for the still picture alike."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from dexterity.scenes.arguments import Array

__all__ = ["View", "camera_axes"]


def camera_axes(view_from: Array) -> Array:
    """Rows right, up and back of a camera that looks from a direction (3,), the world's z upright.

    Raises
    ------
    ValueError
        If the direction is zero.
    """
    if not view_from.any():
        raise ValueError("view_from is zero; a direction from the scene to the camera is needed")
    # By a power of two, which changes no digit, so that no square is too large or too small.
    back = np.ldexp(view_from, -int(np.frexp(np.abs(view_from).max())[1]))
    back = back / np.linalg.norm(back)
    right = np.array([-back[1], back[0], 0.0])
    slant = np.linalg.norm(right)
    if slant <= 1e-9:  # straight from above or below
        back, right, slant = (
            np.array([0.0, 0.0, np.sign(back[2])]),
            np.array([1.0, 0.0, 0.0]),
            np.float64(1.0),
        )
    right = right / slant
    return np.array([right, np.cross(back, right), back])


@dataclass(frozen=True)
class View:
    """A camera that looks at a box.

    Attributes
    ----------
    axes
        (3, 3), rows right, up and back of the camera in the world.
    target
        (3,) middle of the box in the world [m].
    half_extent
        (3,) half the width, height and depth of the box as the camera sees it [m].
    width, height
        Of the still picture [CSS pixels].
    """

    axes: Array
    target: Array
    half_extent: Array
    width: int
    height: int

    field_of_view = math.radians(30)
    """From the bottom of the picture to its top [rad]."""

    @classmethod
    def of(cls, places: Array, axes: Array, height: int) -> View:
        """Look at points (k, 3) with some room about them."""
        seen = places @ axes.T
        low, high = seen.min(axis=0), seen.max(axis=0)
        half_extent = np.maximum(1.08 * (high - low) / 2, 0.05)
        return cls(axes, (low + high) / 2 @ axes, half_extent, width=720, height=height)

    def scale(self, depth: Array) -> Array:
        """Pixels per metre at a depth (...) in front of the camera [m]."""
        return self.height / (2 * math.tan(self.field_of_view / 2) * depth)

    def project(self, points: Array) -> Array:
        """Pixels from the left and from the bottom, and depth [m], of points (k, 3)."""
        x, y, z = ((points - self.target) @ self.axes.T).T
        half_width, half_height, half_depth = self.half_extent
        visible = max(half_height, half_width * self.height / self.width)
        depth = half_depth + visible / math.tan(self.field_of_view / 2) - z
        scale = self.scale(depth)
        return np.column_stack([self.width / 2 + x * scale, self.height / 2 + y * scale, depth])
