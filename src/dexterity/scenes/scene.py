"""Three-dimensional scenes in a page: chains, mechanisms, ellipsoids and paths that the reader can turn.

Examples
--------
>>> import dexterity as dx
>>> from dexterity.scenes.scene import Scene, side_by_side
>>> uvms, scenes = dx.robots.uvms(), [Scene("straight"), Scene("bent")]
>>> scenes[0].add_chain(uvms, [0.0] * 12)
>>> scenes[1].add_chain(uvms, [0.0] * 8 + [1.5, 0.0, 0.0, 0.0])
>>> side_by_side(*scenes).text.count("<iframe")
2
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence

import numpy as np

from dexterity import checks
from dexterity.chain import Chain
from dexterity.checks import Instance
from dexterity.indices import Ellipsoid
from dexterity.scenes import page, shapes, still, viewer
from dexterity.scenes.arguments import Array, bar_lengths, finite_array, rigid
from dexterity.scenes.camera import View, camera_axes
from dexterity.scenes.colors import AXIS_COLORS, TRIAD_COLOR, hex_color
from dexterity.scenes.frames import DrawnChain, axis_frame, chain_frames, in_world, node_name
from dexterity.scenes.mechanisms import Body, Mechanism, Slider, assembled, labelled, names_by_color
from dexterity.scenes.motion import BarMotion, JointMotion
from dexterity.scenes.page import Html
from dexterity.scenes.shapes import Shape
from dexterity.spatial import TensorLike

__all__ = ["Scene", "side_by_side"]


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
    ValueError, TypeError
        If the title is no printable text, the height is no whole number from 1 to 10 000, or the direction is
        zero or not finite.
    """

    def __init__(self, title: str, *, height: int = 420, view_from: TensorLike = (1.0, 0.5, 0.5)) -> None:
        self._title = checks.name(title, "title")
        self._height = checks.whole(height, "height", least=1, most=10_000)
        self._camera_axes = camera_axes(finite_array(view_from, "view_from", (3,)))
        self._names: list[str] = []
        self._frames: dict[str, Array] = {}
        self._shapes: list[Shape] = []
        self._chains: dict[str, DrawnChain] = {}
        self._bars: dict[str, Array] = {}
        self._motions: dict[str, JointMotion | BarMotion] = {}
        self._sliders: list[str] = []
        self._mechanisms: dict[str, Mechanism] = {}
        self._legend: dict[str, str] = {}
        self._remarks: list[str] = []
        self._focus: Array | None = None

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
        """Draw a chain: tubes from joint to joint, the joints' axes and the frame of the tool.

        A revolute axis is an arrow with a turning arrow about it, a prismatic axis a longer arrow of
        another colour. Prismatic joints that follow one another have their arrows together, at the last of
        them. Nothing is drawn along the travel of a prismatic joint. Where tubes of several chains coincide,
        those of the chain that was added first are seen.

        Parameters
        ----------
        chain
            The chain.
        q
            (n,) joint values, [rad] or [m].
        name
            What the scene calls it; the chain's own name by default.
        axes
            Whether to draw the axes, with the names of the joints, and the frame of the tool.
        color
            Of the links, in the legend with the name: a name of :data:`dexterity.scenes.colors.COLORS` or a
            colour of matplotlib.

        Raises
        ------
        ValueError
            If the name is no printable text, is taken or holds a slash, `q` does not fit the chain or is not
            finite, or the colour is unknown.
        """
        checks.instance(chain, "chain", Chain)
        checks.flag(axes, "axes")
        q = finite_array(q, "q", (chain.joints,))
        color = hex_color(color)
        name = self._new_name(chain.name if name is None else name)
        frames, joints = chain_frames(chain, q, name)
        self._frames |= frames
        self._chains[name] = DrawnChain(chain, q, joints)
        size = shapes.reach(chain) or 1.0
        radius = 0.016 * size * 0.97 ** (len(self._chains) - 1)
        self._shapes += shapes.links(chain, joints, radius, color)
        self._legend[name] = color
        if axes:
            self._shapes += shapes.triad(f"{joints[-1]}/link{chain.joints}", 0.12 * size)
            self._legend["tool frame xₜ, yₜ, zₜ"] = TRIAD_COLOR
            for i, kind in enumerate(chain.kinds):
                bearer, T_bearer_axis = axis_frame(chain, i)
                frame = self._add_frame(f"{joints[bearer]}/axis{i}", T_bearer_axis)
                self._shapes += shapes.joint_axis(frame, kind, 0.18 * size, chain.joint_names[i])
                self._legend[f"{kind} axis"] = AXIS_COLORS[kind]

    @checks.arguments(
        bodies=checks.Each(checks.Instance(Body)),
        sliders=checks.Each(checks.Instance(Slider)),
        name=checks.name,
    )
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
            If the name is no printable text, is taken or holds a slash; a body is there twice, is carried by
            one that does not come before it, has a slider that is not there, other than one pose for each of
            its values, a pose that is not rigid, a rod or an arrow without length, a radius or a stretch that
            is not positive, is carried by a body with stretches, or turns by π/2 or more from one value to
            the next; a slider is there twice, moves nothing, has less than two
            values, values that do not grow, or starts outside of them; a colour is unknown, or `pose` is no
            rigid pose.
        """
        T = np.eye(4) if pose is None else rigid(pose, "pose")
        by_label = labelled(sliders)
        frames, drives, drawn = assembled(bodies, by_label, name)
        idle = by_label.keys() - {body.slider for body in bodies}
        if idle:
            raise ValueError(f"sliders hold {sorted(idle)}, which move nothing")
        self._add_frame(self._new_node(name), T)
        self._frames |= frames
        self._shapes += drawn
        self._legend |= names_by_color(bodies)
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
            What the scene calls it, also in its legend, and its colour as in :meth:`add_chain`.

        Raises
        ------
        ValueError
            If the name is no printable text or is taken, `size` is not three positive lengths, `on` names no
            chain, `joint` is not one of its joints, or `pose` is not a rigid pose.
        """
        lengths = finite_array(size, "size", (3,))
        if (lengths <= 0).any():
            raise ValueError(f"size is {tuple(lengths.tolist())}; three positive lengths are needed")
        T = np.eye(4) if pose is None else rigid(pose, "pose")
        color = hex_color(color)
        parent = ""
        if on is not None:
            drawn = self._drawn(on, "on")
            joint = checks.whole(joint, "joint", least=1, most=drawn.chain.joints)
            parent = f"{drawn.joints[joint - 1]}/"
            at_zero = drawn.chain.joint_frames(np.zeros(drawn.chain.joints))[joint - 1].numpy()
            T = np.linalg.inv(at_zero) @ T
        frame = self._add_frame(f"{parent}{self._new_node(name)}", T)
        self._shapes += shapes.box(frame, lengths, color)
        self._legend[name] = color

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
            Length in the scene [m] of a semi-axis of 1; the legend states it.

        Raises
        ------
        ValueError
            If the name is no printable text or is taken, the ellipsoid is not of shape (3, 3) and (3,), is
            unbounded or is a point, `center` is not a finite point, or `scale` is not positive.
        """
        checks.instance(ellipsoid, "ellipsoid", Ellipsoid)
        axes = finite_array(ellipsoid.axes, "ellipsoid.axes", (3, 3))
        semi_axes = finite_array(ellipsoid.semi_axes, "ellipsoid.semi_axes", (3,))
        if not semi_axes.max() > 0:
            raise ValueError("ellipsoid.semi_axes are all zero; there is nothing to draw")
        T = np.eye(4)
        T[:3, 3] = finite_array(center, "center", (3,))
        # Either sense of the third axis gives the same ellipsoid; this one makes T a rotation.
        T[:3, :3] = np.column_stack([axes[:, 0], axes[:, 1], np.cross(axes[:, 0], axes[:, 1])])
        lengths = checks.positive(scale, "scale") * semi_axes
        color = hex_color(color)
        frame = self._add_frame(self._new_node(name), T)
        self._shapes += shapes.ellipsoid(frame, lengths, color)
        self._legend[f"{name}, {scale:g} : 1"] = color

    def add_path(self, points: TensorLike, *, name: str = "path", color: str = "vermillion") -> None:
        """Draw straight lines from point to point, as thin on the screen from near as from afar.

        Parameters
        ----------
        points
            (m, 3) points in the world [m], at least two different ones.
        name, color
            What the scene calls it, also in its legend, and its colour as in :meth:`add_chain`.

        Raises
        ------
        ValueError
            If the name is no printable text or is taken, or `points` is not of that shape, not finite, or a
            single place.
        """
        points = finite_array(points, "points", (-1, 3))
        moved = (np.diff(points, axis=0) != 0).any(axis=1)
        if not moved.any():
            raise ValueError("points are a single place; a path needs at least two different ones")
        color = hex_color(color)
        frame = self._add_frame(self._new_node(name), np.eye(4))
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
            If the name is no printable text or is taken, `points` is not of that shape, not finite or empty,
            or the size is not positive.
        """
        points = finite_array(points, "points", (-1, 3))
        if not len(points):
            raise ValueError("points is empty; one or more are needed")
        size, color = checks.positive(size, "size"), hex_color(color)
        frame = self._add_frame(self._new_node(name), np.eye(4))
        self._shapes += shapes.dots(frame, points, size, color)
        self._legend[name] = color

    def add_letters(self, points: Mapping[str, TensorLike], *, name: str = "letters") -> None:
        """Write letters beside places, such as the names that a text has for points.

        Parameters
        ----------
        points
            (3,) points in the world [m] by their letters.
        name
            What the scene calls all of them.

        Raises
        ------
        ValueError
            If the name is no printable text or is taken, there are no points, or one is not of that shape or
            not finite.
        """
        Instance(Mapping)(points, "points")
        if not points:
            raise ValueError("points is empty; one or more are needed")
        places = {
            checks.name(text, "points"): finite_array(point, f"points {text!r}", (3,))
            for text, point in points.items()
        }
        frame = self._add_frame(self._new_node(name), np.eye(4))
        self._shapes += shapes.letters(frame, places)

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
            If the name is no printable text or is taken, `ends` is not of that shape, not finite or empty, a
            bar has no length, or the radius is not positive.
        """
        ends = finite_array(ends, "ends", (-1, 2, 3))
        if not len(ends):
            raise ValueError("ends is empty; one bar or more are needed")
        lengths = bar_lengths(ends, "ends")
        radius, color = checks.positive(radius, "radius"), hex_color(color)
        self._add_frame(self._new_node(name), np.eye(4))
        self._bars[name] = ends
        for i, length in enumerate(lengths.tolist()):
            (pose,) = BarMotion.of(ends[None, i], length, 1.0).poses()
            frame = self._add_frame(f"{node_name(name)}/bar{i}", pose)
            self._shapes += shapes.bar(frame, length, radius, color)
        self._legend[name] = color

    def animate(self, name: str, q_frames: TensorLike, *, frames_per_second: float = 24.0) -> None:
        """Let a chain move through joint values, over and over.

        Between frames the joint values are interpolated. A reader can stop it and choose the time, and is
        told which joints move. It does not start by itself for a reader who asked for less motion.

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
        speed = checks.positive(frames_per_second, "frames_per_second")
        self._motions |= drawn.motions(frames, speed, "q_frames")

    def add_sliders(self, name: str) -> None:
        """Give the reader a slider for each joint of a chain, which arrow keys move too.

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
        checks.choice(name, "name", self._bars)
        paths = [f"{node_name(name)}/bar{i}" for i in range(len(self._bars[name]))]
        if any(path in self._motions for path in paths):
            raise ValueError(f"name is {name!r}, which has an animation already")
        ends = finite_array(frames, "frames", (-1, len(paths), 2, 3))
        if len(ends) < 2:
            raise ValueError(f"frames has {len(ends)} frames; at least two are needed")
        bar_lengths(ends, "frames")
        speed = checks.positive(frames_per_second, "frames_per_second")
        at_rest = bar_lengths(self._bars[name], "ends").tolist()
        motions = [BarMotion.of(ends[:, i], length, speed) for i, length in enumerate(at_rest)]
        moves = (ends != self._bars[name]).any(axis=(0, 2, 3))
        for path, motion, moved in zip(paths, motions, moves, strict=True):
            if moved:
                self._motions[path] = motion

    # ---- how it is shown --------------------------------------------------------------------------

    def add_remark(self, text: str) -> None:
        """Write a remark into the legend, such as the factor of what is drawn larger than it is.

        Raises
        ------
        ValueError, TypeError
            If the remark is no printable text.
        """
        self._remarks.append(checks.name(text, "text"))

    def look_at(self, low: TensorLike, high: TensorLike) -> None:
        """Let the camera look at a box alone, and not at all that is in the scene.

        Two scenes that look at the same box from the same direction have the same camera.

        Parameters
        ----------
        low, high
            (3,) two opposite corners of the box, in the world [m].

        Raises
        ------
        ValueError
            If a corner is not of that shape or not finite, or both are the same.
        """
        corners = finite_array(low, "low", (3,)), finite_array(high, "high", (3,))
        if (corners[0] == corners[1]).all():
            raise ValueError("high is where low is; a box between them is needed")
        self._focus = np.array(list(itertools.product(*np.transpose(corners))))

    def _repr_html_(self) -> str:
        """Return the iframe that shows the scene in a page or a notebook."""
        return self.html_with(self.region)

    @property
    def region(self) -> Array:
        """Points (k, 3) in the world [m] that the picture holds, at rest and in every frame."""
        return self._places() if self._focus is None else self._focus

    def html_with(self, region: Array) -> str:
        """Return the iframe that shows the scene with the camera at a region (k, 3) [m]."""
        view = View.of(region, self._camera_axes, self._height)
        floor, spacing = shapes.floor(region)
        drawn = [floor, *self._shapes]
        driven = {name: self._chains[name] for name in self._sliders}
        sliders = viewer.slider_commands(driven, self._mechanisms)
        return page.iframe(
            self._title,
            ", ".join(self._names),
            self._height,
            legend=self._legend,
            remarks=[*self._remarks, f"grid {spacing:g} m"],
            still=still.picture(drawn, in_world(self._frames), view),
            commands=viewer.packed_commands(drawn, self._frames, view, self._motions, sliders),
        )

    def _places(self) -> Array:
        """Return points (k, 3) in the world of all that is drawn, at rest and in every frame."""
        if not self._shapes:
            return np.zeros((1, 3))
        moving = {path: motion.poses() for path, motion in self._motions.items()}
        moved = [mechanism.extremes() for mechanism in self._mechanisms.values()]
        return np.concatenate(
            [
                shape.places(frames[shape.frame]).reshape(-1, 3)
                for frames in (in_world(self._frames | changed) for changed in ({}, moving, *moved))
                for shape in self._shapes
            ]
        )

    # ---- its parts --------------------------------------------------------------------------------

    def _new_name(self, name: str) -> str:
        if "/" in checks.name(name, "name"):
            raise ValueError(f"name is {name!r}; letters without a slash are needed")
        if name in self._names:
            raise ValueError(f"name is {name!r}, which is taken in this scene")
        self._names.append(name)
        return name

    def _new_node(self, name: str) -> str:
        return node_name(self._new_name(name))

    def _drawn(self, name: str, argument: str) -> DrawnChain:
        return self._chains[checks.choice(name, argument, self._chains)]

    def _require_at_rest(self, name: str) -> None:
        if name in self._sliders or any(path in self._motions for path in self._chains[name].joints):
            raise ValueError(f"name is {name!r}, which has sliders or an animation already")

    def _add_frame(self, path: str, T_parent_frame: Array) -> str:
        self._frames[path] = T_parent_frame
        return path


@checks.arguments(scenes=checks.Each(checks.Instance(Scene)))
def side_by_side(*scenes: Scene) -> Html:
    """Set scenes in a row with their titles below; one under the other where the page is narrow.

    Their cameras look at one region, which holds that of each scene, so that scenes which look from the same
    direction have the same camera.
    """
    region = np.concatenate([scene.region for scene in scenes])
    return page.row((scene.title, scene.html_with(region)) for scene in scenes)
