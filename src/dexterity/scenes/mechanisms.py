"""Mechanisms in a scene: rigid bodies in a tree of frames, which sliders move by tables of poses.

A closed linkage is no chain. But what one slider does to each body can be told beforehand, pose by pose, and
the page interpolates between them.

Examples
--------
>>> import numpy as np
>>> import dexterity as dx
>>> scene, values = dx.scenes.Scene("A door"), np.array([0.0, 1.0])
>>> poses = dx.spatial.exp(np.outer(values, [0, 0, 0, 0, 0, 1])).numpy()
>>> door = dx.scenes.Body("door", slider="angle", poses=poses, pins=np.zeros((1, 3)))
>>> scene.add_mechanism([door], [dx.scenes.Slider("angle", values, start=0.0)])
>>> scene.region.shape[1]
3
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TypeAlias

import numpy as np
from scipy.spatial.transform import Rotation

from dexterity import checks
from dexterity.scenes import shapes
from dexterity.scenes.arguments import Array, finite_array, rigid
from dexterity.scenes.colors import hex_color
from dexterity.scenes.frames import node_name
from dexterity.scenes.shapes import Shape

__all__ = ["Body", "Drive", "Mechanism", "Slider", "assembled", "labelled", "names_by_color"]


@dataclass(frozen=True)
class Slider:
    """A slider that moves bodies of a mechanism, see :meth:`~dexterity.scenes.scene.Scene.add_mechanism`.

    Attributes
    ----------
    label
        What stands beside it, with its unit.
    values
        (k,) values for which the bodies have poses, each larger than the one before; it runs from the first
        to the last.
    start
        Where it stands at first.
    """

    label: str
    values: Array
    start: float


@dataclass(frozen=True)
class Body:
    """A body of a mechanism: rods, pins, arrows and a ball, see :class:`~dexterity.scenes.scene.Scene`.

    Attributes
    ----------
    name
        What the mechanism calls it.
    on
        Name of the body that carries it; empty for none.
    slider
        Label of the slider that moves it on what carries it; empty for none.
    poses
        (k, 4, 4) poses in the frame of what carries it, one for each value of the slider, or (4, 4) without
        a slider.
    rods
        (m, 2, 3) ends of its rods in its own frame [m].
    pins
        (p, 3) middles of its pins, which lie along the z axis of its own frame [m].
    radius
        Of its rods [m].
    color
        As in :meth:`~dexterity.scenes.scene.Scene.add_chain`.
    letters
        (3,) points in its own frame [m] by the letters that are drawn there.
    arrows
        (a, 3) heads of its arrows, which start at the origin of its own frame [m].
    ball
        Radius of a translucent ball with its three axes about the origin of its own frame [m]; 0 for none.
    stretches
        (k, 3) positive factors of all that is drawn along the axes of its own frame, one row for each value
        of the slider, or (3,) without a slider; none by default. They make a ball an ellipsoid and an arrow
        longer. A body with stretches carries no other one.
    """

    name: str
    on: str = ""
    slider: str = ""
    poses: Array = field(default_factory=lambda: np.eye(4))
    rods: Array = field(default_factory=lambda: np.zeros((0, 2, 3)))
    pins: Array = field(default_factory=lambda: np.zeros((0, 3)))
    radius: float = 0.04
    color: str = "#64748B"
    letters: Mapping[str, Array] = field(default_factory=dict)
    arrows: Array = field(default_factory=lambda: np.zeros((0, 3)))
    ball: float = 0.0
    stretches: Array | None = None


@dataclass(frozen=True)
class Drive:
    """Poses of a frame in the one that carries it, for values (k,) of a slider, as the viewer takes them.

    Positions (k, 3), quaternions (k, 4), and stretches (k, 3) along the frame's own axes.
    """

    slider: Slider
    positions: Array
    turns: Array
    stretches: Array

    def at(self, values: Array) -> Array:
        """Poses (..., 4, 4) for values (...), as ``viewer.js`` interpolates them."""
        known = self.slider.values
        rows = np.concatenate([self.positions, self.turns, self.stretches], axis=1).T
        between = np.stack([np.interp(values, known, row) for row in rows], axis=-1)
        T = np.broadcast_to(np.eye(4), (*np.shape(values), 4, 4)).copy()
        T[..., :3, 3] = between[..., :3]
        R = Rotation.from_quat(between[..., 3:7].reshape(-1, 4)).as_matrix()
        T[..., :3, :3] = R.reshape(*np.shape(values), 3, 3) * between[..., None, 7:]
        return T


@dataclass(frozen=True)
class Mechanism:
    """Sliders of a mechanism, and what they do to the frames of its bodies, by path."""

    sliders: tuple[Slider, ...]
    drives: Mapping[str, Drive]

    def extremes(self) -> dict[str, Array]:
        """Poses (n, 4, 4) of the bodies for values of the sliders all over their ranges."""
        if not self.sliders:
            return {}
        steps = max(2, min(9, int(729.5 ** (1 / len(self.sliders)))))
        ranges = [np.linspace(slider.values[0], slider.values[-1], steps) for slider in self.sliders]
        grid = {
            slider.label: values.ravel()
            for slider, values in zip(self.sliders, np.meshgrid(*ranges), strict=True)
        }
        return {path: drive.at(grid[drive.slider.label]) for path, drive in self.drives.items()}


def labelled(sliders: Sequence[Slider]) -> dict[str, Slider]:
    """Sliders by label, if each is as it should be."""
    by_label: dict[str, Slider] = {}
    for slider in sliders:
        checks.instance(slider, "sliders", Slider)
        if checks.name(slider.label, "sliders") in by_label:
            raise ValueError(f"sliders hold {slider.label!r}, which is there already")
        values = finite_array(slider.values, f"sliders {slider.label!r} values", (-1,))
        if len(values) < 2 or not (np.diff(values) > 0).all():
            raise ValueError(f"sliders {slider.label!r} has values that do not grow; two or more are needed")
        start = checks.real(slider.start, f"sliders {slider.label!r} start")
        if not values[0] <= start <= values[-1]:
            raise ValueError(f"sliders {slider.label!r} starts at {start}, outside of its values")
        by_label[slider.label] = Slider(slider.label, values, start)
    return by_label


def names_by_color(bodies: Sequence[Body]) -> dict[str, str]:
    """Names of the bodies of each colour, with the colour."""
    names: dict[str, list[str]] = {}
    for body in bodies:
        names.setdefault(hex_color(body.color), []).append(body.name)
    return {", ".join(of_color): color for color, of_color in names.items()}


_Assembly: TypeAlias = tuple[dict[str, Array], dict[str, Drive], list[Shape]]


def assembled(bodies: Sequence[Body], sliders: Mapping[str, Slider], name: str) -> _Assembly:
    """Frames of bodies at first and what moves them, by path, and their shapes."""
    paths = {"": node_name(name)}
    frames: dict[str, Array] = {}
    drives: dict[str, Drive] = {}
    drawn: list[Shape] = []
    stretched: set[str] = set()
    for body in bodies:
        checks.instance(body, "bodies", Body)
        argument = f"bodies {body.name!r}"
        if "/" in checks.name(body.name, "bodies") or body.name in paths:
            raise ValueError(f"{argument} is no name without a slash, or there already")
        if body.on not in paths:
            raise ValueError(f"{argument} is on {body.on!r}, which does not come before it")
        if body.on in stretched:
            raise ValueError(f"{argument} is on {body.on!r}, which has stretches; a rigid body is needed")
        path = paths[body.name] = f"{paths[body.on]}/{node_name(body.name)}"
        if body.slider:
            if body.slider not in sliders:
                raise ValueError(f"{argument} has the slider {body.slider!r}; there are {sorted(sliders)}")
            slider = sliders[body.slider]
            drives[path] = _drive(body, slider, argument)
            frames[path] = drives[path].at(np.array(slider.start))
        else:
            factors = _stretches(body, (3,), argument)
            frames[path] = rigid(body.poses, f"{argument} poses") @ np.diag([*factors, 1.0])
        if body.stretches is not None:
            stretched.add(body.name)
        rods = finite_array(body.rods, f"{argument} rods", (-1, 2, 3))
        pins = finite_array(body.pins, f"{argument} pins", (-1, 3))
        if (rods[:, 0] == rods[:, 1]).all(axis=-1).any():
            raise ValueError(f"{argument} has a rod without length")
        radius = checks.positive(body.radius, f"{argument} radius")
        arrows = finite_array(body.arrows, f"{argument} arrows", (-1, 3))
        if not arrows.any(axis=-1).all():
            raise ValueError(f"{argument} has an arrow without length")
        ball = checks.real(body.ball, f"{argument} ball")
        if not 0 <= ball < math.inf:
            raise ValueError(f"{argument} ball is {ball}; a radius, or 0 for none, is needed")
        color = hex_color(body.color)
        drawn += shapes.rods(path, rods, pins, radius, color)
        drawn += shapes.arrows(path, arrows, radius, color)
        if ball:
            drawn += shapes.ellipsoid(path, np.full(3, ball), color)
        points = {
            checks.name(text, f"{argument} letters"): finite_array(
                point, f"{argument} letters {text!r}", (3,)
            )
            for text, point in body.letters.items()
        }
        drawn += shapes.letters(path, points)
    return frames, drives, drawn


def _drive(body: Body, slider: Slider, argument: str) -> Drive:
    steps = len(slider.values)
    T = rigid(body.poses, f"{argument} poses", (steps, 4, 4))
    turns = Rotation.from_matrix(T[:, :3, :3]).as_quat()
    # A quaternion and its negative are one rotation; neighbours are to be near each other.
    near = np.sign(np.sum(turns[1:] * turns[:-1], axis=1))
    turns[1:] *= np.where(near == 0, 1.0, near).cumprod()[:, None]
    if (np.sum(turns[1:] * turns[:-1], axis=1) <= math.cos(math.pi / 4)).any():
        raise ValueError(f"{argument} poses turn by π/2 or more from one value to the next; less is needed")
    return Drive(slider, T[:, :3, 3], turns, _stretches(body, (steps, 3), argument))


def _stretches(body: Body, shape: tuple[int, ...], argument: str) -> Array:
    if body.stretches is None:
        return np.ones(shape)
    factors = finite_array(body.stretches, f"{argument} stretches", shape)
    if not (factors > 0).all():
        raise ValueError(f"{argument} stretches are not all positive")
    return factors
