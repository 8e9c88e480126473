"""What the tool works on in the scenes: a valve, a seam between two plates, and a panel, as simple bodies.

The tool point at home lies on the body, and the tool's y axis points ahead, into it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType

import numpy as np

from dexterity import robots
from dexterity.scenes import Scene

VIEW = (1.0, -0.75, 0.55)
"""Direction to the camera, behind the vehicle and at its right."""

REGION = (-0.7, -0.7, -0.9), (0.7, 2.0, 0.7)
"""Opposite corners of what the camera looks at [m]."""

_STEEL = "#8B8378"
_PLATE = 0.02  # thickness [m]


def valve(scene: Scene, radius: float = 0.15) -> None:
    """Set a hand wheel on a panel; the tool holds its rim at the top, and its axis is parallel to the tool's."""
    tool = _tool()
    hub = tool - _offset(z=radius)
    turn = np.linspace(0, 2 * np.pi, 19)
    rim = hub + radius * np.stack([np.sin(turn), 0 * turn, np.cos(turn)], axis=1)
    spokes = np.stack([np.broadcast_to(hub, (3, 3)), rim[:18:6]], axis=1)
    stem = np.array([[hub, hub + _offset(y=0.25)]])
    bars = np.concatenate([np.stack([rim[:-1], rim[1:]], axis=1), spokes, stem])
    scene.add_bars("hand wheel of the valve", bars, radius=0.014, color="vermillion")
    _plate(scene, "panel", hub + _offset(y=0.25), (1.4, 1.0))


def seam(scene: Scene) -> None:
    """Set two plates that meet in a seam along x, with the tool in its middle."""
    tool = _tool()
    for name, side in (("upper plate", 1), ("lower plate", -1)):
        _plate(scene, name, tool + _offset(z=0.25 * side), (1.4, 0.5))
    scene.add_path(np.array([tool + _offset(x=x) for x in (-0.7, 0.7)]), name="seam", color="vermillion")


def panel(scene: Scene) -> None:
    """Set a panel with the places where its thickness is measured; the tool is at the middle one."""
    tool = _tool()
    _plate(scene, "panel", tool, (1.4, 1.0))
    x, z = np.meshgrid(np.linspace(-0.6, 0.6, 7), np.linspace(-0.4, 0.4, 5))
    places = tool + np.stack([x, 0 * x, z], axis=-1).reshape(-1, 3)
    scene.add_points(places, name="places to inspect", size=0.03, color="vermillion")


STAGES: Mapping[str, Callable[[Scene], None]] = MappingProxyType(
    {"valve turning": valve, "welding": seam, "inspection": panel}
)
"""What the tool works on, by task."""


def _tool() -> np.ndarray:
    place: np.ndarray = robots.uvms().home[:3, 3].numpy()
    return place


def _offset(x: float = 0.0, y: float = 0.0, z: float = 0.0) -> np.ndarray:
    return np.array([x, y, z])


def _plate(scene: Scene, name: str, front: np.ndarray, size: tuple[float, float]) -> None:
    """Set a plate across y with the middle of its front face [m], its width and its height [m]."""
    width, height = size
    pose = np.eye(4)
    pose[:3, 3] = front + _offset(y=_PLATE / 2)
    scene.add_box((width, _PLATE, height), pose=pose, name=name, color=_STEEL)
