"""Three-dimensional scenes in a page: chains, mechanisms, ellipsoids and paths that the reader can turn.

A :class:`Scene` keeps simple shapes on a tree of frames. Showing it draws the same shapes twice: as
meshcat's commands, which the page replays in meshcat's viewer, and as a still picture, for a page
without WebGL, for print, and for the moment before the viewer starts. No server is involved, and the
same scene gives the same bytes.

The page is ``scene.html`` beside this file: an iframe with everything in it but the viewer's script,
which all scenes of a book share. :func:`copy_viewer` puts it where they look for it.
"""

from __future__ import annotations

import base64
import html
import io
import itertools
import json
import math
import zlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from string import Template
from typing import Any, Protocol, runtime_checkable

import matplotlib.style
import numpy as np
import umsgpack
from matplotlib.figure import Figure
from meshcat.animation import Animation
from meshcat.commands import SetObject
from meshcat.path import Path as NodePath
from meshcat.visualizer import Visualizer

from dexterity import store
from dexterity.chain import Chain
from dexterity.indices import Ellipsoid
from dexterity.report import shapes
from dexterity.report.arguments import finite_array, positive, rigid
from dexterity.report.markup import Markup, element
from dexterity.report.mechanisms import Body, Drive, Mechanism, Slider, assembled, labelled
from dexterity.report.motion import BarMotion, JointMotion, joint_motion
from dexterity.report.shapes import Array, Command, Shape, View
from dexterity.spatial import TensorLike

__all__ = ["Scene", "copy_viewer", "side_by_side"]


def copy_viewer(folder: str | Path) -> None:
    """Copy meshcat's viewer and its licences into a folder, for a book's ``_static/meshcat``.

    Parameters
    ----------
    folder
        Where to put ``main.min.js``, its two licence files and meshcat's own ``LICENSE``. Made if missing.

    Raises
    ------
    OSError
        If a file cannot be written.
    """
    viewer = resources.files("meshcat") / "viewer"
    script = "main.min.js"
    built = (f"{script}.LICENSE.txt", f"{script}.THIRD_PARTY_LICENSES.json", script)
    for source in (viewer / "LICENSE", *(viewer / "dist" / name for name in built)):
        store.write_atomically(Path(folder) / source.name, source.read_bytes())


def side_by_side(*scenes: Scene) -> Markup:
    """Set scenes in a row with their titles below; one under the other where the page is narrow."""
    cells = (
        element(
            "figure",
            scene._repr_html_() + element("figcaption", html.escape(scene.title)),
            style="flex:1 1 17rem;min-width:0;margin:0",
        )
        for scene in scenes
    )
    return Markup(element("div", "".join(cells), style="display:flex;flex-wrap:wrap;gap:0.75rem"))


class Scene:
    """A scene in the world frame, z up, lengths in metres.

    As the last line of a notebook's cell it shows itself.

    Parameters
    ----------
    title
        What the scene shows, in a few words; read out to those who do not see it.
    height
        Height on the page [CSS pixels]. The width is that of the text.
    view_from
        Direction from the scene to the camera, of any length. How far away the camera stands follows from
        what is in the scene, over the whole animation if there is one.

    Raises
    ------
    ValueError
        If the title is empty, the height is not positive, or the direction is zero or not finite.
    """

    def __init__(self, title: str, *, height: int = 420, view_from: TensorLike = (1.0, 0.5, 0.5)) -> None:
        if not title.strip():
            raise ValueError("title is empty; it must say what the scene shows")
        if height <= 0:
            raise ValueError(f"height is {height}; a positive number of pixels is needed")
        self._title = title
        self._height = height
        self._camera_axes = shapes.camera_axes(finite_array(view_from, "view_from", (3,)))
        self._names: list[str] = []
        self._frames: dict[str, Array] = {}
        self._shapes: list[Shape] = []
        self._chains: dict[str, _DrawnChain] = {}
        self._bars: dict[str, Array] = {}
        self._motions: dict[str, JointMotion | BarMotion] = {}
        self._sliders: list[str] = []
        self._mechanisms: dict[str, Mechanism] = {}
        self._legend: dict[str, str] = {}

    def __repr__(self) -> str:
        return f"Scene({self._title!r})"

    @property
    def title(self) -> str:
        """What the scene shows."""
        return self._title

    # ---- what can be in a scene -------------------------------------------------------------------

    def add_chain(
        self,
        chain: Chain,
        q: TensorLike,
        *,
        name: str | None = None,
        axes: bool = True,
        color: str = "#64748B",
    ) -> None:
        """Draw a chain: tubes from joint to joint, the joints' axes, the frame of the tool.

        A revolute axis is an arrow with a turning arrow about it, a prismatic axis a longer arrow of
        another colour. Prismatic joints that follow one another have their arrows together, at the last of
        them. Nothing is drawn along the travel of a prismatic joint.

        Parameters
        ----------
        chain
            The chain.
        q
            (n,) joint values, [rad] or [m].
        name
            What the scene calls it; the chain's own name by default.
        axes
            Whether to draw the axes, with the names of the joints.
        color
            Of the links: a name of :data:`dexterity.report.figures.COLORS` or a colour of matplotlib.

        Raises
        ------
        ValueError
            If the name is taken or holds a slash, `q` does not fit the chain or is not finite, or the
            colour is unknown.
        """
        q = finite_array(q, "q", (chain.joints,))
        color = shapes.hex_color(color)
        name = self._new_name(chain.name if name is None else name)
        joints = self._add_joint_frames(chain, q, name)
        self._chains[name] = _DrawnChain(chain, q, joints)
        size = shapes.reach(chain) or 1.0
        self._shapes += shapes.links(chain, joints, 0.016 * size, color)
        self._shapes += shapes.triad(f"{joints[-1]}/link{chain.joints}", 0.12 * size)
        if axes:
            self._add_axes(chain, joints, 0.18 * size)

    def add_mechanism(
        self,
        bodies: Sequence[Body],
        sliders: Sequence[Slider],
        *,
        name: str = "mechanism",
        pose: TensorLike | None = None,
    ) -> None:
        """Draw bodies that sliders move, such as linkages, whose joints are no chain.

        Each slider moves any number of bodies, each body by one slider at most, and with what carries it.
        Between the values of a slider the poses are interpolated. The camera stands so far away that all
        which the sliders can do is seen.

        Parameters
        ----------
        bodies
            The bodies, each after the one that carries it.
        sliders
            The sliders, in the order in which they are shown.
        name
            What the scene calls the mechanism.
        pose
            (4, 4) pose in the world of the frame that carries the bodies which no other one carries; the
            identity by default.

        Raises
        ------
        ValueError
            If the name is taken or holds a slash; a body is there twice, is carried by one that does not
            come before it, has a slider that is not there, other than one pose for each of its values, a
            pose that is not rigid, a rod without length or no positive radius, or turns by π/2 or more from
            one value to the next; a slider is there twice, moves nothing, has less than two values, values
            that do not grow, or starts outside of them; a colour is unknown, or `pose` is no rigid pose.
        """
        T = np.eye(4) if pose is None else rigid(pose, "pose")
        by_label = labelled(sliders)
        frames, drives, drawn = assembled(bodies, by_label, name)
        idle = by_label.keys() - {body.slider for body in bodies}
        if idle:
            raise ValueError(f"sliders hold {sorted(idle)}, which move nothing")
        self._new_name(name)
        self._add_frame(name, T)
        for path, T_carrier_body in frames.items():
            self._add_frame(path, T_carrier_body)
        self._shapes += drawn
        self._mechanisms[name] = Mechanism(tuple(by_label.values()), drives)

    def add_box(
        self,
        size: TensorLike,
        *,
        on: str | None = None,
        joint: int = 6,
        pose: TensorLike | None = None,
        name: str = "box",
        color: str = "sky blue",
    ) -> None:
        """Draw a translucent box, such as the body of a vehicle.

        Parameters
        ----------
        size
            Extent along the x, y and z axes of the box [m].
        on
            Name of a chain that moves the box; none by default.
        joint
            How many of that chain's joints move it.
        pose
            (4, 4) pose in the world of the centre of the box, with the joints of the chain at zero; the
            identity by default.
        name, color
            What the scene calls it, and its colour as in :meth:`add_chain`.

        Raises
        ------
        ValueError
            If the name is taken, `size` is not three positive lengths, `on` names no chain, `joint` is not
            one of its joints, or `pose` is not a rigid pose.
        """
        lengths = finite_array(size, "size", (3,))
        if (lengths <= 0).any():
            raise ValueError(f"size is {tuple(lengths.tolist())}; three positive lengths are needed")
        T = np.eye(4) if pose is None else rigid(pose, "pose")
        color = shapes.hex_color(color)
        parent = ""
        if on is not None:
            drawn = self._drawn(on, "on")
            if not 1 <= joint <= drawn.chain.joints:
                raise ValueError(f"joint is {joint}; {on} has joints 1 to {drawn.chain.joints}")
            parent = f"{drawn.joints[joint - 1]}/"
            at_zero = drawn.chain.joint_frames(np.zeros(drawn.chain.joints))[joint - 1].numpy()
            T = np.linalg.inv(at_zero) @ T
        frame = self._add_frame(f"{parent}{self._new_name(name)}", T)
        self._shapes += shapes.box(frame, lengths, color)

    def add_ellipsoid(
        self,
        ellipsoid: Ellipsoid,
        center: TensorLike,
        *,
        name: str = "ellipsoid",
        color: str = "blue",
        scale: float = 1.0,
    ) -> None:
        """Draw an ellipsoid in three dimensions with its principal axes; one without volume as a thin disc.

        Parameters
        ----------
        ellipsoid
            What :func:`dexterity.indices.velocity_ellipsoid` or its force counterpart returns for one
            configuration and three rows.
        center
            (3,) where to put it in the world [m].
        name, color
            What the scene calls it, also in its legend, and its colour as in :meth:`add_chain`.
        scale
            Length in the scene [m] of a semi-axis of 1.

        Raises
        ------
        ValueError
            If the name is taken, the ellipsoid is not of shape (3, 3) and (3,), is unbounded or is a
            point, `center` is not a finite point, or `scale` is not positive.
        """
        axes = finite_array(ellipsoid.axes, "ellipsoid.axes", (3, 3))
        semi_axes = finite_array(ellipsoid.semi_axes, "ellipsoid.semi_axes", (3,))
        if not semi_axes.max() > 0:
            raise ValueError("ellipsoid.semi_axes are all zero; there is nothing to draw")
        T = np.eye(4)
        T[:3, 3] = finite_array(center, "center", (3,))
        # Either sense of the third axis gives the same ellipsoid; this one makes T a rotation.
        T[:3, :3] = np.column_stack([axes[:, 0], axes[:, 1], np.cross(axes[:, 0], axes[:, 1])])
        lengths = positive(scale, "scale") * semi_axes
        color = shapes.hex_color(color)
        frame = self._add_frame(self._new_name(name), T)
        self._shapes += shapes.ellipsoid(frame, lengths, color)
        self._legend[name] = color

    def add_path(self, points: TensorLike, *, name: str = "path", color: str = "vermillion") -> None:
        """Draw a curve through points.

        Parameters
        ----------
        points
            (m, 3) points in the world [m], at least two different ones.
        name, color
            What the scene calls it, also in its legend, and its colour as in :meth:`add_chain`.

        Raises
        ------
        ValueError
            If the name is taken, or `points` is not of that shape, not finite, or a single place.
        """
        points = finite_array(points, "points", (-1, 3))
        moved = (np.diff(points, axis=0) != 0).any(axis=1)
        if not moved.any():
            raise ValueError("points are a single place; a path needs at least two different ones")
        color = shapes.hex_color(color)
        frame = self._add_frame(self._new_name(name), np.eye(4))
        self._shapes += shapes.path(frame, points[np.append(True, moved)], color)
        self._legend[name] = color

    def add_points(
        self, points: TensorLike, *, name: str = "points", size: float = 0.01, color: str = "blue"
    ) -> None:
        """Draw points as little squares that face the reader.

        Parameters
        ----------
        points
            (k, 3) points in the world [m], one or more.
        name, color
            What the scene calls them, also in its legend, and their colour as in :meth:`add_chain`.
        size
            Side of a square [m].

        Raises
        ------
        ValueError
            If the name is taken, `points` is not of that shape, not finite or empty, or the size is not
            positive.
        """
        points = finite_array(points, "points", (-1, 3))
        if not len(points):
            raise ValueError("points is empty; one or more are needed")
        size, color = positive(size, "size"), shapes.hex_color(color)
        frame = self._add_frame(self._new_name(name), np.eye(4))
        self._shapes += shapes.dots(frame, points, size, color)
        self._legend[name] = color

    def add_bars(self, name: str, ends: TensorLike, *, radius: float = 0.02, color: str = "#64748B") -> None:
        """Draw round bars between pairs of points, such as the members of a structure.

        Parameters
        ----------
        name
            What the scene calls all of them, also in its legend.
        ends
            (m, 2, 3) both ends of each in the world [m]; one bar or more.
        radius
            Of the bars [m].
        color
            As in :meth:`add_chain`.

        Raises
        ------
        ValueError
            If the name is taken, `ends` is not of that shape, not finite or empty, a bar has no length, or
            the radius is not positive.
        """
        ends = finite_array(ends, "ends", (-1, 2, 3))
        if not len(ends):
            raise ValueError("ends is empty; one bar or more are needed")
        lengths = _bar_lengths(ends, "ends")
        radius, color = positive(radius, "radius"), shapes.hex_color(color)
        self._add_frame(self._new_name(name), np.eye(4))
        self._bars[name] = ends
        for i, length in enumerate(lengths.tolist()):
            (pose,) = BarMotion.of(ends[None, i], length, 1.0).poses()
            frame = self._add_frame(f"{name}/bar{i}", pose)
            self._shapes += shapes.bar(frame, length, radius, color)
        self._legend[name] = color

    def animate(self, name: str, q_frames: TensorLike, *, frames_per_second: float = 24.0) -> None:
        """Let a chain move through joint values, over and over.

        Between frames the joint values are interpolated. The controls of the viewer stop it, step through
        it and change its speed. It does not start by itself for a reader who asked for less motion.

        Parameters
        ----------
        name
            Name under which the chain was drawn.
        q_frames
            (m, n) joint values of at least two frames, [rad] or [m].
        frames_per_second
            How fast they are played.

        Raises
        ------
        ValueError
            If there is no chain of that name, it has sliders or moves already, `q_frames` does not fit it,
            is not finite or turns a joint by π or more from one frame to the next, or the speed is not
            positive.
        """
        drawn = self._drawn(name, "name")
        self._require_at_rest(name)
        frames = finite_array(q_frames, "q_frames", (-1, drawn.chain.joints))
        if len(frames) < 2:
            raise ValueError(f"q_frames has {len(frames)} frames; at least two are needed")
        speed = positive(frames_per_second, "frames_per_second")
        turns = np.abs(np.diff(frames, axis=0)).max(axis=0)
        for joint, kind, turn in zip(drawn.chain.joint_names, drawn.chain.kinds, turns, strict=True):
            if kind == "revolute" and turn >= math.pi:
                raise ValueError(
                    f"q_frames turns {joint} by {turn:.3g} rad in one frame; less than π is needed"
                )
        for i, path in enumerate(drawn.joints):
            if (frames[:, i] != drawn.q[i]).any():
                self._motions[path] = JointMotion(drawn.chain.kinds[i], frames[:, i], speed)

    def add_sliders(self, name: str) -> None:
        """Give the reader a slider for each joint of a chain.

        It runs between the limits of the joint; where there is none, to π rad or 1 m either way.

        Parameters
        ----------
        name
            Name under which the chain was drawn.

        Raises
        ------
        ValueError
            If there is no chain of that name, or it moves by itself or has sliders already.
        """
        self._drawn(name, "name")
        self._require_at_rest(name)
        self._sliders.append(name)

    def animate_bars(self, name: str, frames: TensorLike, *, frames_per_second: float = 24.0) -> None:
        """Let bars move, over and over, and become longer and shorter with the distance of their ends.

        Between frames the places of their middles, their directions and their lengths are interpolated. A
        reader has the same controls as with :meth:`animate`.

        Parameters
        ----------
        name
            Name under which the bars were drawn.
        frames
            (k, m, 2, 3) ends of all m bars in at least two frames [m].
        frames_per_second
            How fast they are played.

        Raises
        ------
        ValueError
            If there are no bars of that name, they move already, `frames` does not fit them or is not
            finite, a bar has no length in one of them or turns by π or more from one to the next, or the
            speed is not positive.
        """
        if name not in self._bars:
            raise ValueError(f"name is {name!r}; the bars of this scene are {sorted(self._bars)}")
        paths = [f"{name}/bar{i}" for i in range(len(self._bars[name]))]
        if any(path in self._motions for path in paths):
            raise ValueError(f"name is {name!r}, which has an animation already")
        ends = finite_array(frames, "frames", (-1, len(paths), 2, 3))
        if len(ends) < 2:
            raise ValueError(f"frames has {len(ends)} frames; at least two are needed")
        _bar_lengths(ends, "frames")
        speed = positive(frames_per_second, "frames_per_second")
        at_rest = _bar_lengths(self._bars[name], "ends").tolist()
        motions = [BarMotion.of(ends[:, i], length, speed) for i, length in enumerate(at_rest)]
        moves = (ends != self._bars[name]).any(axis=(0, 2, 3))
        for path, motion, moved in zip(paths, motions, moves, strict=True):
            if moved:
                self._motions[path] = motion

    # ---- how it is shown --------------------------------------------------------------------------

    def _repr_html_(self) -> str:
        """Return the iframe that shows the scene in a page or a notebook."""
        places = self._places()
        view = View.of(places, self._camera_axes, self._height)
        floor, spacing = shapes.floor(places)
        all_shapes = [floor, *self._shapes]
        legend = [_legend_row(text, color) for text, color in self._legend.items()]
        template = (resources.files(__package__) / "scene.html").read_text(encoding="utf-8")
        page = Template(template).substitute(
            title=html.escape(self._title),
            alt=html.escape(f"{self._title}: {', '.join(self._names)}"),
            legend="".join([*legend, f"<li>grid {spacing:g} m</li>"]),
            still=base64.b64encode(self._still(view, all_shapes)).decode(),
            commands=self._commands(view, all_shapes),
        )
        return (
            f'<iframe class="meshcat-scene" title="{html.escape(self._title)}" '
            f'style="width:100%;height:{self._height}px;border:0" srcdoc="{html.escape(page)}"></iframe>'
        )

    def _commands(self, view: View, all_shapes: Sequence[Shape]) -> str:
        """Return all that the viewer is to do, compressed, in base 64."""
        recorder = _Recorder()
        root = Visualizer(window=recorder)
        _set_stage(root, view)
        for path, T in self._frames.items():
            root[path].set_transform(T)
        for shape in all_shapes:
            shape.record(root)
        if self._motions:
            animation = Animation()
            for path, motion in self._motions.items():
                animation.clips[_node(path)] = motion.clip()
            root.set_animation(animation, repetitions=math.inf)
        for slider in self._slider_commands():
            recorder.send(slider)
        return recorder.packed()

    def _still(self, view: View, all_shapes: Sequence[Shape]) -> bytes:
        """Return the scene as an SVG picture, what is far painted first."""
        frames = _in_world(self._frames)
        depths = [view.project(shape.places(frames[shape.frame]))[:, 2].mean() for shape in all_shapes]
        far_first = sorted(range(len(all_shapes)), key=lambda i: (all_shapes[i].layer, -depths[i]))
        with matplotlib.style.context(["default", _STILL_STYLE]):
            figure = Figure(figsize=(view.width / 72, view.height / 72), dpi=72, facecolor="none")
            axes = figure.add_axes((0, 0, 1, 1), xlim=(0, view.width), ylim=(0, view.height))
            axes.set_axis_off()
            for order, i in enumerate(far_first):
                all_shapes[i].paint(axes, view, frames[all_shapes[i].frame], order)
            picture = io.BytesIO()
            figure.savefig(picture, format="svg", metadata=_NO_METADATA)
        return picture.getvalue()

    def _places(self) -> Array:
        """Return points (k, 3) in the world that the picture must hold, at rest and in every frame."""
        if not self._shapes:
            return np.zeros((1, 3))
        moving = {path: motion.poses() for path, motion in self._motions.items()}
        moved = [mechanism.extremes() for mechanism in self._mechanisms.values()]
        return np.concatenate(
            [
                shape.places(frames[shape.frame]).reshape(-1, 3)
                for frames in (_in_world(self._frames | changed) for changed in ({}, moving, *moved))
                for shape in self._shapes
            ]
        )

    def _slider_commands(self) -> Iterator[Command]:
        taken: set[str] = set()
        for name in self._sliders:
            drawn = self._chains[name]
            for i, joint in enumerate(drawn.chain.joint_names):
                unit = "rad" if drawn.chain.kinds[i] == "revolute" else "m"
                yield _slider(_untaken(f"{joint} [{unit}]", name, taken), drawn, i)
        for name, mechanism in self._mechanisms.items():
            for slider in mechanism.sliders:
                yield _mechanism_slider(_untaken(slider.label, name, taken), slider, mechanism.drives)

    # ---- its parts --------------------------------------------------------------------------------

    def _new_name(self, name: str) -> str:
        if not name or "/" in name:
            raise ValueError(f"name is {name!r}; letters without a slash are needed")
        if name in self._names:
            raise ValueError(f"name is {name!r}, which is taken in this scene")
        self._names.append(name)
        return name

    def _drawn(self, name: str, argument: str) -> _DrawnChain:
        if name not in self._chains:
            raise ValueError(f"{argument} is {name!r}; the chains of this scene are {sorted(self._chains)}")
        return self._chains[name]

    def _require_at_rest(self, name: str) -> None:
        if name in self._sliders or any(path in self._motions for path in self._chains[name].joints):
            raise ValueError(f"name is {name!r}, which has sliders or an animation already")

    def _add_frame(self, path: str, T_parent_frame: Array) -> str:
        self._frames[path] = T_parent_frame
        return path

    def _add_joint_frames(self, chain: Chain, q: Array, name: str) -> tuple[str, ...]:
        """Add link0/joint0/link1/… below `name`: links stay as they are, joints carry the motion."""
        path, joints = self._add_frame(name, np.eye(4)), []
        links = chain.link_transforms.numpy()
        for i, kind in enumerate(chain.kinds):
            path = self._add_frame(f"{path}/link{i}", links[i])
            path = self._add_frame(f"{path}/joint{i}", joint_motion(kind, q[i]))
            joints.append(path)
        self._add_frame(f"{path}/link{chain.joints}", links[-1])
        return tuple(joints)

    def _add_axes(self, chain: Chain, joints: Sequence[str], size: float) -> None:
        links = chain.link_transforms.numpy()
        for i, kind in enumerate(chain.kinds):
            bearer, R_axis_bearer = i, np.eye(3)
            while chain.kinds[bearer : bearer + 2] == ("prismatic", "prismatic"):
                bearer += 1
                R_axis_bearer = R_axis_bearer @ links[bearer][:3, :3]
            T_bearer_axis = np.eye(4)
            T_bearer_axis[:3, :3] = R_axis_bearer.T
            frame = self._add_frame(f"{joints[bearer]}/axis{i}", T_bearer_axis)
            self._shapes += shapes.joint_axis(frame, kind, size, chain.joint_names[i])
            self._legend[f"{kind} axis"] = shapes.AXIS_COLORS[kind]


_NO_METADATA = dict.fromkeys(("Creator", "Date", "Format", "Type"))

_STILL_STYLE: Any = {
    "font.sans-serif": ["DejaVu Sans"],
    "svg.fonttype": "none",
    "svg.hashsalt": "dexterity",
}


def _legend_row(text: str, color: str) -> str:
    return f'<li><i style="background:{color}"></i>{html.escape(text)}</li>'


def _untaken(label: str, name: str, taken: set[str]) -> str:
    """Label of a slider, with what it moves in front where the label alone is taken."""
    label = f"{name} {label}" if label in taken else label
    taken.add(label)
    return label


# ---- motion ---------------------------------------------------------------------------------------


@dataclass(frozen=True)
class _DrawnChain:
    """A chain in a scene, its joint values, and the paths of the frames that its joints move."""

    chain: Chain
    q: Array
    joints: tuple[str, ...]


def _in_world(frames: Mapping[str, Array]) -> dict[str, Array]:
    """Turn poses in their parents' frames into poses in the world; parents come before their children."""
    world: dict[str, Array] = {"": np.eye(4)}
    for path, T_parent_frame in frames.items():
        world[path] = world[path.rpartition("/")[0]] @ T_parent_frame
    return world


# ---- meshcat --------------------------------------------------------------------------------------


@runtime_checkable
class _Lowerable(Protocol):
    """What can be sent to meshcat's window."""

    def lower(self) -> dict[str, object]: ...


class _Recorder:
    """Stands in for meshcat's window and keeps what it is sent, with ids that are the same every time."""

    def __init__(self) -> None:
        self._commands: list[bytes] = []
        self._ids = itertools.count()

    def send(self, command: _Lowerable) -> None:
        if isinstance(command, SetObject):
            for element in (command.object, command.object.geometry, command.object.material):
                element.uuid = f"{next(self._ids):x}"
        # Poses go in the precision that WebGL draws in; the numbers of a slider are to be read.
        precision = "double" if isinstance(command, Command) else "single"
        self._commands.append(umsgpack.packb(command.lower(), force_float_precision=precision))

    def packed(self) -> str:
        """Return each command after its length in four bytes, all compressed, in base 64."""
        framed = b"".join(len(command).to_bytes(4, "little") + command for command in self._commands)
        return base64.b64encode(zlib.compress(framed, 9)).decode()


def _set_stage(root: Visualizer, view: View) -> None:
    """Clear meshcat's stage, light it from above the camera's left shoulder, and place the camera."""
    for path in ("Background", "Grid", "Axes", "Lights/PointLightNegativeX", "Lights/PointLightPositiveX"):
        root[f"/{path}"].set_property("visible", False)
    lamp = root["/Lights/FillLight/<object>"]
    lamp.set_property("position", (np.array([-0.5, 1.0, 0.9]) @ view.axes).tolist())
    lamp.set_property("intensity", 0.45)
    root["/Lights/AmbientLight/<object>"].set_property("intensity", 0.7)
    camera = {
        "target": view.target.tolist(),
        "back": view.axes[2].tolist(),
        "half_extent": view.half_extent.tolist(),
        "field_of_view": math.degrees(view.field_of_view),
    }
    root.window.send(Command({"type": "set_view", **camera}))


def _slider(label: str, drawn: _DrawnChain, joint: int) -> Command:
    """Slider over the limits of a joint, which moves the joint's frame."""
    value, kind = float(drawn.q[joint]), drawn.chain.kinds[joint]
    unlimited = math.pi if kind == "revolute" else 1.0
    lower, upper = float(drawn.chain.lower[joint]), float(drawn.chain.upper[joint])
    if kind == "revolute":
        motion = "'quaternion', [0, 0, Math.sin(value / 2), Math.cos(value / 2)]"
    else:
        motion = "'position', [0, 0, value]"
    node = json.dumps(_node(drawn.joints[joint]).entries)
    control = {
        "name": label,
        "callback": f"value => {{ viewer.set_property({node}, {motion}); viewer.set_dirty(); }}",
        "value": value,
        "min": lower if math.isfinite(lower) else min(-unlimited, value),
        "max": upper if math.isfinite(upper) else max(unlimited, value),
        "step": 0.01,
    }
    return Command({"type": "set_control", **control})


def _mechanism_slider(label: str, slider: Slider, drives: Mapping[str, Drive]) -> Command:
    """Slider that moves the frames of all bodies that are its own."""
    moved = [
        {
            "node": _node(path).entries,
            "positions": drive.positions.round(5).tolist(),
            "turns": drive.turns.round(6).tolist(),
        }
        for path, drive in drives.items()
        if drive.slider.label == slider.label
    ]
    table = json.dumps({"values": slider.values.round(6).tolist(), "bodies": moved}, separators=(",", ":"))
    span = float(slider.values[-1] - slider.values[0])
    control = {
        "name": label,
        "callback": f"value => moveBodies(value, {table})",
        "value": slider.start,
        "min": float(slider.values[0]),
        "max": float(slider.values[-1]),
        "step": 10.0 ** math.floor(math.log10(span / 100)),
    }
    return Command({"type": "set_control", **control})


def _node(path: str) -> NodePath:
    return NodePath(("meshcat",)).append(path)


# ---- input ----------------------------------------------------------------------------------------


def _bar_lengths(ends: Array, name: str) -> Array:
    """Return the lengths (...) of bars (..., 2, 3) [m], none of which is zero."""
    lengths: Array = np.linalg.norm(ends[..., 1, :] - ends[..., 0, :], axis=-1)
    if not (lengths > 0).all():
        raise ValueError(f"{name} has a bar without a length")
    return lengths
