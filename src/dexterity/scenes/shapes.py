"""Shapes of a scene, each of which can be drawn twice: into meshcat's viewer and into a still picture.

A shape hangs on a frame and knows nothing of what moves the frame. In the still picture a solid is the
outline of its corners, filled, and what is far is painted first; that is exact enough for convex solids
that do not pierce one another, and small enough for every scene to carry its picture.
"""

from __future__ import annotations

import itertools
import math
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.patches import Polygon
from meshcat.geometry import (
    LineBasicMaterial,
    LineSegments,
    Mesh,
    MeshLambertMaterial,
    Points,
    PointsGeometry,
    PointsMaterial,
)
from meshcat.visualizer import Visualizer

from dexterity.chain import Chain, JointKind
from dexterity.scenes.arguments import Array
from dexterity.scenes.camera import View
from dexterity.scenes.colors import AXIS_COLORS, TRIAD_COLOR, darker, number

__all__ = [
    "Command",
    "Shape",
    "arrows",
    "bar",
    "box",
    "dots",
    "ellipsoid",
    "floor",
    "joint_axis",
    "letters",
    "links",
    "path",
    "reach",
    "rods",
    "triad",
]


@dataclass(frozen=True)
class Command:
    """A command that ``viewer.js`` knows and meshcat does not, and the precision of its numbers."""

    fields: Mapping[str, object]
    precision: str = "double"

    def lower(self) -> dict[str, object]:
        """Return the command as it goes to the viewer."""
        return dict(self.fields)


# ---- kinds of shapes ------------------------------------------------------------------------------


class Shape(ABC):
    """Something to see, carried by the frame with the path `frame`."""

    frame: str

    @property
    @abstractmethod
    def layer(self) -> int:
        """0 for the floor, 1 for what is translucent, 2 for what is not, 3 for letters."""

    @abstractmethod
    def places(self, T: Array) -> Array:
        """Return points (..., k, 3) in the world that bound the shape, its frame being at (..., 4, 4)."""

    @abstractmethod
    def record(self, root: Visualizer) -> None:
        """Draw into meshcat."""

    @abstractmethod
    def paint(self, axes: Axes, view: View, T: Array, order: int) -> None:
        """Draw into the still picture, over all of lower order; its frame is at (4, 4)."""


@dataclass(frozen=True)
class Solid(Shape):
    """A convex body: a geometry of three.js, its pose in the frame, and points of which it is the hull."""

    frame: str
    name: str
    geometry: Mapping[str, object]
    pose: Array
    corners: Array
    color: str
    opacity: float = 1.0

    @property
    def layer(self) -> int:
        return 2 if self.opacity == 1 else 1

    def places(self, T: Array) -> Array:
        return _moved(T @ self.pose, self.corners)

    def record(self, root: Visualizer) -> None:
        opaque = self.opacity == 1
        material = MeshLambertMaterial(color=number(self.color), opacity=self.opacity, depthWrite=opaque)
        root[f"{self.frame}/{self.name}"].set_object(Mesh(_Geometry(self.geometry, self.pose), material))

    def paint(self, axes: Axes, view: View, T: Array, order: int) -> None:
        outline = Polygon(
            np.round(_outline(view.project(self.places(T))[:, :2]), 1),
            facecolor=self.color,
            edgecolor=darker(self.color),
            linewidth=0.6,
            alpha=self.opacity,
            zorder=order,
            clip_on=False,
        )
        axes.add_patch(outline)


@dataclass(frozen=True)
class Curve(Shape):
    """A smooth line of some thickness through points (m, 3)."""

    frame: str
    name: str
    points: Array
    radius: float
    color: str
    layer: int = 2

    def places(self, T: Array) -> Array:
        return _moved(T, self.points)

    def record(self, root: Visualizer) -> None:
        segments = max(2 * len(self.points), 8)
        spline = {"type": "CatmullRomCurve3", "curveType": "centripetal", "arcLengthDivisions": segments}
        tube = {
            "type": "TubeGeometry",
            "path": {**spline, "points": self.points.tolist()},
            "radius": self.radius,
            "radialSegments": 8,
            "tubularSegments": segments,
        }
        material = MeshLambertMaterial(color=number(self.color))
        root[f"{self.frame}/{self.name}"].set_object(Mesh(_Geometry(tube, np.eye(4)), material))

    def paint(self, axes: Axes, view: View, T: Array, order: int) -> None:
        seen = view.project(self.places(T))
        width = max(1.0, float(2 * self.radius * view.scale(seen[:, 2]).mean()))
        x, y = np.round(seen[:, :2], 1).T
        axes.plot(
            x, y, color=self.color, linewidth=width, solid_capstyle="round", zorder=order, clip_on=False
        )


@dataclass(frozen=True)
class Polyline(Shape):
    """Straight lines from point to point (m, 3), as thin on the screen from near as from afar."""

    frame: str
    name: str
    points: Array
    color: str
    layer: int = 2

    pixels = 2.5

    def places(self, T: Array) -> Array:
        return _moved(T, self.points)

    def record(self, root: Visualizer) -> None:
        path = root[f"{self.frame}/{self.name}"].path.lower()
        points = self.points.astype(np.float32).tolist()
        line = {"path": path, "points": points, "pixels": self.pixels, "color": number(self.color)}
        root.window.send(Command({"type": "set_path", **line}, precision="single"))

    def paint(self, axes: Axes, view: View, T: Array, order: int) -> None:
        x, y = np.round(view.project(self.places(T))[:, :2], 1).T
        look: dict[str, Any] = {"solid_joinstyle": "miter", "clip_on": False}
        axes.plot(x, y, color=self.color, linewidth=self.pixels, zorder=order, **look)


@dataclass(frozen=True)
class Hairlines(Shape):
    """Straight segments (k, 2, 3), one pixel wide."""

    frame: str
    name: str
    segments: Array
    color: str
    layer: int = 2

    def places(self, T: Array) -> Array:
        return _moved(T, self.segments.reshape(-1, 3))

    def record(self, root: Visualizer) -> None:
        ends = PointsGeometry(self.segments.reshape(-1, 3).T.astype(np.float32))
        material = LineBasicMaterial(color=number(self.color))
        root[f"{self.frame}/{self.name}"].set_object(LineSegments(ends, material))

    def paint(self, axes: Axes, view: View, T: Array, order: int) -> None:
        seen = np.round(view.project(self.places(T))[:, :2], 1).reshape(-1, 2, 2)
        lines = LineCollection(list(seen), colors=self.color, linewidths=0.7, zorder=order, clip_on=False)
        axes.add_collection(lines, autolim=False)


@dataclass(frozen=True)
class Dots(Shape):
    """Little squares of one size at points (k, 3), which face whoever looks."""

    frame: str
    name: str
    points: Array
    size: float
    color: str
    layer: int = 2

    def places(self, T: Array) -> Array:
        return _moved(T, self.points)

    def record(self, root: Visualizer) -> None:
        centres = PointsGeometry(self.points.T.astype(np.float32))
        # three.js takes the size for that at a field of view of a right angle.
        size = self.size / math.tan(View.field_of_view / 2)
        material = _OneColor(size=size, color=number(self.color))
        root[f"{self.frame}/{self.name}"].set_object(Points(centres, material))

    def paint(self, axes: Axes, view: View, T: Array, order: int) -> None:
        seen = view.project(self.places(T))
        # Far ones first; the area of a marker is in points, of which a pixel is one.
        x, y, depth = seen[np.argsort(-seen[:, 2])].T
        areas = np.round(np.square(self.size * view.scale(depth)), 1)
        look: dict[str, Any] = {"c": self.color, "marker": "s", "linewidths": 0, "clip_on": False}
        axes.scatter(np.round(x, 1), np.round(y, 1), areas, zorder=order, **look)


@dataclass(frozen=True)
class Label(Shape):
    """Letters of constant size at a point (3,)."""

    frame: str
    name: str
    text: str
    point: Array
    layer: int = 3

    def places(self, T: Array) -> Array:
        return _moved(T, self.point[None])

    def record(self, root: Visualizer) -> None:
        anchor = root[f"{self.frame}/{self.name}"]
        anchor.set_transform(_at(self.point))
        anchor.window.send(Command({"type": "set_label", "path": anchor.path.lower(), "text": self.text}))

    def paint(self, axes: Axes, view: View, T: Array, order: int) -> None:
        ((x, y, _),) = np.round(view.project(self.places(T)), 1)
        ground = {"boxstyle": "square,pad=0.1", "facecolor": "#EEF1F4", "alpha": 0.7, "linewidth": 0}
        letters = {"ha": "center", "va": "center", "fontsize": 13, "color": "#1F2933"}
        # A dollar sign is a letter here, and begins no formula.
        axes.text(x, y, self.text, letters, bbox=ground, zorder=order, parse_math=False)


# ---- what scenes are made of ----------------------------------------------------------------------


def links(chain: Chain, joints: Sequence[str], radius: float, color: str) -> list[Shape]:
    """Tubes between the joints and to the tool, and a drum at each revolute joint, on the joints' frames."""
    shapes: list[Shape] = []
    z = np.array([0.0, 0.0, 1.0])
    for joint, kind, link in zip(joints, chain.kinds, chain.link_transforms.numpy()[1:], strict=True):
        end = link[:3, 3]
        if kind == "revolute":
            drum = (-2.2 * radius * z, 2.2 * radius * z)
            shapes.append(_tube(joint, "drum", drum, (1.7 * radius, 1.7 * radius), darker(color)))
        if np.linalg.norm(end) > radius:
            shapes.append(_tube(joint, "link", (np.zeros(3), end), (radius, radius), color))
    return shapes


def rods(frame: str, ends: Array, pins: Array, radius: float, color: str) -> list[Shape]:
    """Tubes between ends (m, 2, 3), and drums along z about pins (p, 3)."""
    drum = np.array([[0.0, 0.0, -2.2 * radius], [0.0, 0.0, 2.2 * radius]])
    return [
        *(
            _tube(frame, f"rod{i}", (start, end), (radius, radius), color)
            for i, (start, end) in enumerate(ends)
        ),
        *(
            _tube(frame, f"pin{i}", tuple(pin + drum), (1.7 * radius, 1.7 * radius), darker(color))
            for i, pin in enumerate(pins)
        ),
    ]


def arrows(frame: str, heads: Array, radius: float, color: str) -> list[Shape]:
    """Arrows from the origin of the frame to their heads (a, 3)."""
    drawn: list[Shape] = []
    for i, head in enumerate(heads):
        drawn += _arrow(frame, f"arrow{i}", head, min(radius, float(np.linalg.norm(head)) / 10), color)
    return drawn


def reach(chain: Chain) -> float:
    """Length of the stretched chain from its first joint on [m]."""
    return float(chain.link_transforms[1:, :3, 3].norm(dim=-1).sum())


def joint_axis(frame: str, kind: JointKind, size: float, joint: str) -> list[Shape]:
    """Axis along z with the joint's name: a long arrow, or a shorter one with a turning arrow about it."""
    length = 1.6 * size if kind == "prismatic" else size
    z, color = np.array([0.0, 0.0, 1.0]), AXIS_COLORS[kind]
    shapes = _arrow(frame, "arrow", length * z, 0.033 * size, color)
    if kind == "revolute":
        angles = np.linspace(0.0, 1.5 * math.pi, 19)
        turn = 0.3 * size * np.column_stack([np.cos(angles), np.sin(angles), np.full(19, 2.0)])
        tip = turn[-1] + np.array([0.2 * size, 0.0, 0.0])
        shapes.append(Curve(frame, "turn", turn, 0.022 * size, color))
        shapes.append(_tube(frame, "turn-head", (turn[-1], tip), (0.07 * size, 0.0), color))
    return [*shapes, Label(frame, "label", joint, (length + 0.2 * size) * z)]


def triad(frame: str, size: float) -> list[Shape]:
    """Arrows along a tool's x, y and z, with these letters."""
    shapes: list[Shape] = []
    for name, axis in zip("xyz", np.eye(3), strict=True):
        shapes += _arrow(frame, name, size * axis, 0.05 * size, TRIAD_COLOR)
        shapes.append(Label(frame, f"label-{name}", f"{name}ₜ", 1.2 * size * axis))
    return shapes


def letters(frame: str, points: Mapping[str, Array]) -> list[Shape]:
    """Names at points (3,)."""
    return [Label(frame, f"letter{i}", text, point) for i, (text, point) in enumerate(points.items())]


def box(frame: str, lengths: Array, color: str) -> list[Shape]:
    """Translucent box about the frame's origin."""
    corners = np.array(list(itertools.product((-0.5, 0.5), repeat=3))) * lengths
    edges = [(a, b) for a, b in itertools.combinations(corners, 2) if (a != b).sum() == 1]
    sides = dict(zip(("width", "height", "depth"), lengths.tolist(), strict=True))
    return [
        Solid(frame, "body", {"type": "BoxGeometry", **sides}, np.eye(4), corners, color, opacity=0.16),
        Hairlines(frame, "edges", np.array(edges), darker(color)),
    ]


def ellipsoid(frame: str, semi_axes: Array, color: str) -> list[Shape]:
    """Translucent ellipsoid about the frame's origin with its principal axes, which are the frame's.

    The shortest semi-axes are drawn at one hundredth of the longest one's length, so that an ellipsoid
    without volume is a thin disc or a needle.
    """
    lengths = np.maximum(semi_axes, 0.01 * semi_axes.max())
    turn, tilt = np.meshgrid(np.arange(24) * math.pi / 12, np.arange(-6, 7) * math.pi / 12)
    sphere = np.stack([np.cos(tilt) * np.cos(turn), np.cos(tilt) * np.sin(turn), np.sin(tilt)], axis=-1)
    geometry = {"type": "SphereGeometry", "radius": 1.0, "widthSegments": 48, "heightSegments": 32}
    pose = np.diag([*lengths, 1.0])
    radius = 0.008 * float(lengths.max())
    return [
        Solid(frame, "body", geometry, pose, sphere.reshape(-1, 3), color, opacity=0.4),
        *(
            _tube(frame, f"axis{i}", (-end, end), (radius, radius), darker(color))
            for i, end in enumerate(np.diag(lengths))
        ),
    ]


def path(frame: str, points: Array, color: str) -> list[Shape]:
    """Lines from point to point (m, 3)."""
    return [Polyline(frame, "line", points, color)]


def dots(frame: str, points: Array, size: float, color: str) -> list[Shape]:
    """Squares of one size [m] at points (k, 3)."""
    return [Dots(frame, "dots", points, size, color)]


def bar(frame: str, length: float, radius: float, color: str) -> list[Shape]:
    """Tube of a length [m] along the frame's y axis, its middle in the origin."""
    half = np.array([0.0, length / 2, 0.0])
    return [_tube(frame, "bar", (-half, half), (radius, radius), color)]


def floor(places: Array) -> tuple[Shape, float]:
    """Grid under points (k, 3), and the width of its squares [m]: 1, 2 or 5 times a power of ten."""
    low, high = places.min(axis=0), places.max(axis=0)
    extent = max(float((high - low).max()), 0.05)
    power = 10.0 ** math.floor(math.log10(extent / 4))
    spacing = max(step * power for step in (1, 2, 5) if step * power <= extent / 4)
    first, last = np.floor(low / spacing), np.ceil(high / spacing) + 1
    x, y = (np.arange(first[i], last[i]) * spacing for i in (0, 1))
    z = low[2] - 0.02 * extent
    lines = [[(a, y[0], z), (a, y[-1], z)] for a in x] + [[(x[0], b, z), (x[-1], b, z)] for b in y]
    return Hairlines("", "floor", np.array(lines), "#C5CDD6", layer=0), spacing


def _tube(frame: str, name: str, ends: tuple[Array, Array], radii: tuple[float, float], color: str) -> Solid:
    """Cylinder between two points, with its radius at each; a cone where one is zero."""
    start, end = ends
    height = float(np.linalg.norm(end - start))
    angles = np.arange(12) * math.pi / 6
    rim = np.column_stack([np.cos(angles), np.zeros(12), np.sin(angles)])
    half = np.array([0.0, height / 2, 0.0])
    corners = np.concatenate([radii[0] * rim - half, radii[1] * rim + half])
    size = {"radiusBottom": radii[0], "radiusTop": radii[1], "height": height, "radialSegments": 24}
    pose = _pose_along_y(end - start, (start + end) / 2)
    return Solid(frame, name, {"type": "CylinderGeometry", **size}, pose, corners, color)


def _arrow(frame: str, name: str, end: Array, radius: float, color: str) -> list[Shape]:
    """Arrow from the origin of the frame."""
    neck = end * (1 - 6 * radius / float(np.linalg.norm(end)))
    return [
        _tube(frame, f"{name}-shaft", (np.zeros(3), neck), (radius, radius), color),
        _tube(frame, f"{name}-head", (neck, end), (2.4 * radius, 0.0), color),
    ]


# ---- inside ---------------------------------------------------------------------------------------


class _Geometry:
    """A geometry of three.js by its own parameters, at a pose in its frame."""

    def __init__(self, parameters: Mapping[str, object], pose: Array) -> None:
        self.uuid = ""
        self._parameters = parameters
        self._pose = pose

    def intrinsic_transform(self) -> Array:
        # meshcat writes this row by row, three.js reads it column by column.
        return self._pose.T

    def lower_in_object(self, data: dict[str, Any]) -> str:
        data["geometries"].append({"uuid": self.uuid, **self._parameters})
        return self.uuid


class _OneColor(PointsMaterial):  # type: ignore[misc]
    """Material of points that have no colours of their own, which meshcat's would look for."""

    def lower(self, object_data: dict[str, Any]) -> dict[str, Any]:
        return {**super().lower(object_data), "vertexColors": False}


def _moved(T: Array, points: Array) -> Array:
    """Points (k, 3) of frames at (..., 4, 4) in the world, (..., k, 3)."""
    return points @ np.swapaxes(T[..., :3, :3], -1, -2) + T[..., None, :3, 3]


def _outline(points: Array) -> Array:
    """Convex outline of points (k, 2): the farthest point in each of many directions."""
    turn = np.arange(90) * math.pi / 45
    farthest = (points @ np.stack([np.cos(turn), np.sin(turn)])).argmax(axis=0)
    return points[farthest[farthest != np.roll(farthest, 1)]]


def _at(point: Array) -> Array:
    T = np.eye(4)
    T[:3, 3] = point
    return T


def _pose_along_y(direction: Array, origin: Array) -> Array:
    """Pose at `origin` with y along `direction`, the axis of symmetry of cylinders in three.js."""
    y = direction / np.linalg.norm(direction)
    x = np.cross(y, np.eye(3)[np.abs(y).argmin()])
    x /= np.linalg.norm(x)
    T = _at(origin)
    T[:3, :3] = np.column_stack([x, y, np.cross(x, y)])
    return T
