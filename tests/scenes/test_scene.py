import base64
import html.parser
import itertools
import math
import re
import uuid
import zlib
from collections.abc import Callable
from dataclasses import replace
from importlib import resources
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import matplotlib as mpl
import numpy as np
import pytest
import torch
import umsgpack
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

import dexterity as dx
from dexterity import indices, robots, scenes
from dexterity.indices import Ellipsoid
from dexterity.scenes import Body, Scene, Slider
from dexterity.scenes.camera import View, camera_axes
from dexterity.scenes.colors import darker, hex_color, number
from serial_chains import random_robot
from warm_process import WarmProcess

Array = NDArray[np.float64]
Command = dict[str, Any]

PAGE_PARTS = {"scene.html", "scene.css", "panel.js", "viewer.js"}

UVMS = robots.uvms()
REST = np.zeros(12)
FLAT = Ellipsoid(torch.eye(3, dtype=torch.float64), torch.tensor([1.0, 0.5, 0.0], dtype=torch.float64))


# ---- reading a scene back ---------------------------------------------------------------------------


class Reader(html.parser.HTMLParser):
    """Collects elements and insists that each is closed in its place."""

    VOID = frozenset({"meta", "img"})

    def __init__(self, text: str) -> None:
        super().__init__()
        self.elements: list[tuple[str, dict[str, str | None]]] = []
        self.texts: dict[str, str] = {}
        self._open = [("", "")]
        self.feed(text)
        self.close()
        assert self._open == [("", "")]

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.elements.append((tag, dict(attrs)))
        if tag not in self.VOID:
            self._open.append((tag, dict(attrs).get("id") or tag))

    def handle_endtag(self, tag: str) -> None:
        assert self._open.pop()[0] == tag

    def handle_data(self, data: str) -> None:
        _, name = self._open[-1]
        self.texts[name] = self.texts.get(name, "") + data

    def attributes(self, tag: str) -> dict[str, str | None]:
        (found,) = (attributes for name, attributes in self.elements if name == tag)
        return found


def page(scene: Scene) -> Reader:
    iframe = Reader(scene._repr_html_()).attributes("iframe")
    return Reader(iframe["srcdoc"] or "")


def unpacked(packed: str) -> list[Command]:
    framed = zlib.decompress(base64.b64decode(packed))
    found = []
    while framed:
        end = 4 + int.from_bytes(framed[:4], "little")
        found.append(umsgpack.unpackb(framed[4:end]))
        framed = framed[end:]
    return found


def commands(scene: Scene) -> list[Command]:
    return unpacked(page(scene).texts["commands"])


def of_type(scene: Scene, kind: str) -> list[Command]:
    return [command for command in commands(scene) if command["type"] == kind]


def transforms(scene: Scene) -> dict[str, Array]:
    """Poses of all frames in their parents, by path."""
    return {
        command["path"].removeprefix("/meshcat/"): np.reshape(command["matrix"], (4, 4)).T
        for command in of_type(scene, "set_transform")
    }


def objects(scene: Scene) -> dict[str, Command]:
    return {
        command["path"].removeprefix("/meshcat/"): command["object"]
        for command in of_type(scene, "set_object")
    }


def in_world(frames: dict[str, Array], path: str) -> Array:
    prefixes = itertools.accumulate(path.split("/"), "{}/{}".format)
    return np.linalg.multi_dot([np.eye(4), np.eye(4), *(frames[prefix] for prefix in prefixes)])


def joint_path(name: str, joint: int) -> str:
    return name + "".join(f"/link{i}/joint{i}" for i in range(joint + 1))


def tool_path(name: str, chain: dx.Chain) -> str:
    return f"{joint_path(name, chain.joints - 1)}/link{chain.joints}"


def still(scene: Scene) -> bytes:
    source = page(scene).attributes("img")["src"] or ""
    return base64.b64decode(source.removeprefix("data:image/svg+xml;base64,"))


# ---- scenes to look at ------------------------------------------------------------------------------


def uvms_scene(q: Array = REST, **options: Any) -> Scene:
    scene = Scene("The vehicle and its arm", **options)
    scene.add_chain(UVMS, q, name="uvms")
    scene.add_box((1.0, 1.5, 1.0), on="uvms", name="vehicle")
    return scene


def full_scene() -> Scene:
    scene = uvms_scene()
    wiggle = 0.4 * np.sin(np.linspace(0, 2 * np.pi, 40))
    scene.animate("uvms", np.concatenate([wiggle[:, None] * row for row in np.eye(12)]))
    scene.add_chain(robots.puma560(), np.full(6, 0.1), name="puma", axes=False)
    scene.add_sliders("puma")
    scene.add_ellipsoid(FLAT, [0, 1, 0], name="what is lost", scale=0.3)
    scene.add_path(np.random.default_rng(1).normal(size=(50, 3)))
    return scene


# ---- bytes ------------------------------------------------------------------------------------------


def test_the_same_scene_gives_the_same_bytes() -> None:
    scene = full_scene()
    assert scene._repr_html_() == scene._repr_html_() == full_scene()._repr_html_()


PROGRAM = """
import numpy as np
from dexterity import robots
from dexterity.scenes import Scene
scene = Scene("An arm that moves")
scene.add_chain(robots.puma560(), np.zeros(6), name="arm")
scene.animate("arm", np.linspace(0, 1, 12).reshape(2, 6))
shown = scene._repr_html_()
"""


def test_another_process_gives_the_same_bytes() -> None:
    here: dict[str, str] = {}
    exec(PROGRAM, here)
    assert WarmProcess(f"{PROGRAM}\nprint(shown, end='')").end() == (0, here["shown"])


def test_ids_elsewhere_stay_unique() -> None:
    original = uuid.uuid1
    full_scene()._repr_html_()
    assert uuid.uuid1 is original
    assert uuid.uuid1() != uuid.uuid1()


def test_a_scene_is_small() -> None:
    assert len(full_scene()._repr_html_().encode()) < 80_000


def test_a_long_path_is_small_too() -> None:
    scene = Scene("A path")
    turn = np.linspace(0, 40, 2000)
    scene.add_path(np.column_stack([np.cos(turn), np.sin(turn), turn / 10]))
    assert len(scene._repr_html_().encode()) < 80_000


def test_what_is_drawn_is_not_changed_by_later_writes() -> None:
    q, points = np.zeros(12), np.arange(6.0).reshape(2, 3)
    scene = uvms_scene(q)
    scene.add_path(points)
    before = scene._repr_html_()
    q += 1
    points += 1
    assert scene._repr_html_() == before


def test_the_still_picture_does_not_depend_on_the_style_of_figures() -> None:
    before = still(uvms_scene())
    with mpl.rc_context({"font.size": 30, "svg.fonttype": "path", "axes.facecolor": "red"}):
        assert still(uvms_scene()) == before


# ---- the page ---------------------------------------------------------------------------------------


def test_the_page_says_what_it_shows() -> None:
    iframe = Reader(uvms_scene()._repr_html_()).attributes("iframe")
    assert iframe["title"] == "The vehicle and its arm"
    read = page(uvms_scene())
    assert read.texts["title"] == "The vehicle and its arm"
    assert read.attributes("img")["alt"] == "The vehicle and its arm: uvms, vehicle"
    assert read.attributes("html")["lang"] == "en"


def test_the_legend_names_what_has_a_colour() -> None:
    read = page(full_scene())
    names = ["uvms", "tool frame xₜ, yₜ, zₜ", "prismatic axis", "revolute axis", "vehicle", "puma"]
    assert read.texts["li"] == "".join([*names, "what is lost, 0.3 : 1", "path", "grid 1 m"])


def colors_of_legend(scene: Scene) -> list[str | None]:
    return [attributes["data-color"] for tag, attributes in page(scene).elements if tag == "i"]


def drawn_colors(scene: Scene) -> set[int]:
    """Colours of all solids, lines and points, but for the floor."""
    of_objects = {path: thing["materials"][0]["color"] for path, thing in objects(scene).items()}
    of_objects.pop("/floor")
    return {*of_objects.values(), *(command["color"] for command in of_type(scene, "set_path"))}


def test_every_colour_has_its_entry_in_the_legend() -> None:
    scene = full_scene()
    scene.add_bars("bars", ROD, color="yellow")
    scene.add_points(np.eye(3), color="bluish green")
    scene.add_mechanism([CRANK, SLIDE], [TURN_BY, SLIDE_BY], name="press")
    legend = {color for color in colors_of_legend(scene) if color}
    shades = legend | {darker(color) for color in legend}
    assert drawn_colors(scene) <= {number(color) for color in shades}


def test_bodies_of_one_colour_share_an_entry() -> None:
    scene = Scene("A mechanism")
    scene.add_mechanism([CRANK, replace(SPOKE, color="blue"), replace(SPOKE, name="other")], [TURN_BY])
    assert page(scene).texts["li"].startswith("crank, spokeothergrid")


def test_a_remark_is_in_the_legend() -> None:
    scene = uvms_scene()
    scene.add_remark("errors drawn 10 : 1 & more")
    assert "errors drawn 10 : 1 & more" in page(scene).texts["li"]


@pytest.mark.parametrize(
    "title", ['"quoted" & <b>bold</b>', "</script><script>alert(1)</script>", "$title ${x}"]
)
def test_titles_and_names_are_only_text(title: str) -> None:
    scene = Scene(title)
    scene.add_path([[0, 0, 0], [1, 1, 1]], name=title.replace("/", "|"))
    assert Reader(scene._repr_html_()).attributes("iframe")["title"] == title
    read = page(scene)
    assert read.texts["title"] == title
    assert [tag for tag, _ in read.elements].count("script") == 3


def test_the_height_is_the_one_asked_for() -> None:
    style = Reader(uvms_scene(height=300)._repr_html_()).attributes("iframe")["style"]
    assert "height:300px" in (style or "")


def test_scenes_side_by_side_are_whole_and_have_their_titles_below() -> None:
    left, right = Scene("Best & first"), Scene("Worst")
    row = scenes.side_by_side(left, right)._repr_html_()
    assert Reader(row).texts["figcaption"] == "Best & firstWorst"
    assert left._repr_html_() in row
    assert right._repr_html_() in row


def views(shown: str) -> list[Command]:
    frames = [attributes["srcdoc"] or "" for tag, attributes in Reader(shown).elements if tag == "iframe"]
    packed = [Reader(frame).texts["commands"] for frame in frames]
    return [command for one in packed for command in unpacked(one) if command["type"] == "set_view"]


def test_scenes_side_by_side_have_one_camera() -> None:
    near, far = uvms_scene(REST), uvms_scene(np.eye(12)[0] * 3)
    first, second = views(scenes.side_by_side(near, far)._repr_html_())
    assert first == second
    alone = [views(scene._repr_html_())[0] for scene in (near, far)]
    assert alone[0] != alone[1]
    assert max(first["half_extent"]) > max(alone[0]["half_extent"])


def test_scenes_that_look_at_one_box_have_one_camera() -> None:
    near, far = uvms_scene(REST), uvms_scene(np.eye(12)[0] * 3)
    for scene in (near, far):
        scene.look_at((-1, -1, -1), (1, 1, 1))
    assert of_type(near, "set_view") == of_type(far, "set_view")


def test_an_empty_scene_can_be_shown() -> None:
    assert page(Scene("Nothing yet")).attributes("img")["alt"]


def test_the_page_asks_for_nothing_outside() -> None:
    parts = [part for part in resources.files("dexterity.scenes").iterdir() if part.name in PAGE_PARTS]
    assert len(parts) == len(PAGE_PARTS)
    text = "".join(part.read_text(encoding="utf-8") for part in parts)
    assert "http" not in text
    assert text.count(".src = ") == 1


def test_a_standalone_scene_has_the_viewer_inside() -> None:
    shown = scenes.side_by_side(uvms_scene(), Scene("Another"))._repr_html_()
    whole = scenes.standalone(f"<p>Before</p>{shown}")
    assert whole.startswith("<p>Before</p>")
    script = (resources.files("meshcat") / "viewer" / "dist" / "main.min.js").read_bytes()
    frames = [attributes["srcdoc"] or "" for tag, attributes in Reader(whole).elements if tag == "iframe"]
    assert len(frames) == 2
    for frame in frames:
        assert zlib.decompress(base64.b64decode(Reader(frame).texts["inlined-viewer"])) == script
    assert len(whole) < len(shown) + 2 * 400_000
    assert scenes.standalone("<p>No scene</p>") == "<p>No scene</p>"


# ---- the still picture ------------------------------------------------------------------------------


def test_the_still_picture_is_a_picture_with_the_joints_names() -> None:
    texts = {element.text for element in ElementTree.fromstring(still(uvms_scene())).iter()}
    assert texts >= set(UVMS.joint_names)


directions = st.tuples(*[st.floats(-1, 1)] * 3).filter(lambda direction: np.linalg.norm(direction) > 1e-3)


@given(direction=directions, points=st.lists(st.tuples(*[st.floats(-5, 5)] * 3), min_size=2, max_size=8))
def test_everything_is_in_the_picture(direction: tuple[float, ...], points: list[tuple[float, ...]]) -> None:
    axes = camera_axes(np.array(direction))
    np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-12)
    assert axes[1, 2] >= 0
    view = View.of(np.array(points), axes, height=400)
    x, y, depth = view.project(np.array(points)).T
    assert ((x >= 0) & (x <= view.width) & (y >= 0) & (y <= view.height) & (depth > 0)).all()


def test_the_camera_makes_room_for_the_animation() -> None:
    q_frames = np.zeros((3, 12))
    q_frames[1, 0] = 10.0
    scene = uvms_scene()
    scene.animate("uvms", q_frames)
    (at_rest,), (moving,) = of_type(uvms_scene(), "set_view"), of_type(scene, "set_view")
    assert max(moving["half_extent"]) > 5 > max(at_rest["half_extent"])


# ---- chains -----------------------------------------------------------------------------------------


@settings(max_examples=30)
@given(seed=st.integers(0, 10_000), joints=st.integers(2, 8))
def test_the_tree_of_frames_is_the_forward_kinematics(seed: int, joints: int) -> None:
    rng = np.random.default_rng(seed)
    chain = random_robot(rng, joints).chain()
    q = rng.uniform(-3, 3, joints)
    scene = Scene("A random robot")
    scene.add_chain(chain, q, name="robot", axes=False)
    frames = transforms(scene)
    np.testing.assert_allclose(in_world(frames, tool_path("robot", chain)), chain.forward(q), atol=1e-5)
    for joint, T in enumerate(chain.joint_frames(q)):
        np.testing.assert_allclose(in_world(frames, joint_path("robot", joint)), T, atol=1e-5)


def test_every_link_that_has_a_length_is_drawn() -> None:
    links = [path for path in objects(uvms_scene()) if path.endswith("/link")]
    assert links == [f"{joint_path('uvms', joint)}/link" for joint in (5, 7, 8)]


def test_each_joint_has_its_axis_and_its_name() -> None:
    q = np.random.default_rng(3).uniform(-1, 1, 12)
    scene = uvms_scene(q)
    labels = {command["text"]: command["path"] for command in of_type(scene, "set_label")}
    assert labels.keys() == {*UVMS.joint_names, "xₜ", "yₜ", "zₜ"}
    frames = transforms(scene)
    for name, T in zip(UVMS.joint_names, UVMS.joint_frames(q).numpy(), strict=True):
        axis = labels[name].removeprefix("/meshcat/").removesuffix("/label")
        np.testing.assert_allclose(in_world(frames, axis)[:3, 2], T[:3, 2], atol=1e-5)


def test_the_axes_of_the_vehicles_translation_stand_together() -> None:
    q = np.array([1.0, 2.0, 3.0, *np.zeros(9)])
    frames = transforms(uvms_scene(q))
    axes = [path for path in frames if re.search(r"/axis[0-5]$", path)]
    assert len(axes) == 6
    for path in axes:
        np.testing.assert_allclose(in_world(frames, path)[:3, 3], q[:3], atol=1e-5)


def test_revolute_and_prismatic_axes_differ_in_shape_and_colour() -> None:
    drawn = objects(uvms_scene())
    arrows = {
        path.rpartition("/")[0]: thing for path, thing in drawn.items() if path.endswith("/arrow-shaft")
    }
    turning = {axis for axis in arrows if f"{axis}/turn" in drawn}
    colors = {axis: thing["materials"][0]["color"] for axis, thing in arrows.items()}
    assert len(turning) == 9
    assert {colors[axis] for axis in turning}.isdisjoint(colors[axis] for axis in arrows.keys() - turning)


def test_axes_can_be_left_out() -> None:
    scene = Scene("No axes")
    scene.add_chain(UVMS, REST, axes=False)
    assert of_type(scene, "set_label") == []


def test_the_vehicle_moves_with_its_joints() -> None:
    q = np.random.default_rng(4).uniform(-1, 1, 12)
    vehicle = dx.Chain(np.eye(6), np.eye(4))
    T = in_world(transforms(uvms_scene(q)), f"{joint_path('uvms', 5)}/vehicle")
    np.testing.assert_allclose(T, vehicle.forward(q[:6]), atol=1e-5)


def test_a_vehicle_can_stand_anywhere() -> None:
    pose = dx.spatial.exp([1.0, 2.0, 3.0, 0.1, 0.2, 0.3])
    scene = Scene("A box")
    scene.add_box((1, 2, 3), pose=pose, name="vehicle")
    np.testing.assert_allclose(in_world(transforms(scene), "vehicle"), pose, atol=1e-5)
    (geometry,) = objects(scene)["vehicle/body"]["geometries"]
    assert [geometry[side] for side in ("width", "height", "depth")] == [1, 2, 3]


# ---- ellipsoids and paths ---------------------------------------------------------------------------


def body_points(scene: Scene, name: str) -> Array:
    """Points of the drawn ellipsoid's surface in the world, less its centre."""
    matrix = np.reshape(objects(scene)[f"{name}/body"]["object"]["matrix"], (4, 4)).T
    sphere = np.random.default_rng(5).normal(size=(100, 3))
    sphere /= np.linalg.norm(sphere, axis=1, keepdims=True)
    return sphere @ (in_world(transforms(scene), name) @ matrix)[:3, :3].T


@settings(max_examples=15)
@given(seed=st.integers(0, 10_000))
def test_ellipsoids_are_where_unit_joint_rates_lead(seed: int) -> None:
    rng = np.random.default_rng(seed)
    J = np.zeros((6, 7))
    J[:3] = rng.normal(size=(3, 7))
    center = rng.normal(size=3)
    scene = Scene("An ellipsoid")
    scene.add_ellipsoid(indices.velocity_ellipsoid(J, "translational"), center, scale=0.5)
    velocities = body_points(scene, "ellipsoid") / 0.5
    # A velocity v lies on the ellipsoid where the least joint rates that make it have unit norm.
    rates = np.linalg.norm(np.linalg.pinv(J[:3]) @ velocities.T, axis=0)
    np.testing.assert_allclose(rates, 1, rtol=1e-3)
    T = in_world(transforms(scene), "ellipsoid")
    np.testing.assert_allclose(T[:3, 3], center, atol=1e-5)
    assert np.linalg.det(T[:3, :3]) > 0


def test_an_ellipsoid_without_volume_is_a_thin_disc() -> None:
    scene = Scene("A disc")
    scene.add_ellipsoid(FLAT, [0, 0, 0])
    extent = np.abs(body_points(scene, "ellipsoid")).max(axis=0)
    assert 0 < extent[2] < 0.02
    np.testing.assert_allclose(extent[:2], [1, 0.5], rtol=0.1)


def test_a_path_goes_through_its_points() -> None:
    points = np.array([[0.0, 0, 0], [1, 0, 0], [1, 0, 0], [1, 1, 1]])
    scene = Scene("A path")
    scene.add_path(points, name="track", color="blue")
    (drawn,) = of_type(scene, "set_path")
    assert drawn["path"] == "/meshcat/track/line"
    np.testing.assert_allclose(drawn["points"], points[[0, 1, 3]])
    assert drawn["color"] == 0x0072B2


# ---- bars -------------------------------------------------------------------------------------------


def bar_ends(thing: Command, T: Array) -> Array:
    """Both ends (2, 3) of a drawn bar whose frame is at a pose."""
    (geometry,) = thing["geometries"]
    matrix = np.reshape(thing["object"]["matrix"], (4, 4)).T
    half = np.array([0, geometry["height"] / 2, 0])
    ends = np.stack([-half, half]) @ matrix[:3, :3].T + matrix[:3, 3]
    return ends @ T[:3, :3].T + T[:3, 3]


@pytest.mark.parametrize("bars", [1, 5])
def test_bars_go_from_end_to_end(bars: int) -> None:
    ends = np.random.default_rng(bars).normal(size=(bars, 2, 3))
    scene = Scene("Bars")
    scene.add_bars("truss", ends, radius=0.03, color="vermillion")
    things, frames = objects(scene), transforms(scene)
    assert sum(path.startswith("truss/") for path in things) == bars
    for i in range(bars):
        thing = things[f"truss/bar{i}/bar"]
        np.testing.assert_allclose(bar_ends(thing, in_world(frames, f"truss/bar{i}")), ends[i], atol=1e-5)
        for radius in ("radiusTop", "radiusBottom"):
            assert thing["geometries"][0][radius] == pytest.approx(0.03)
        assert thing["materials"][0]["color"] == int(hex_color("vermillion")[1:], 16)
    assert page(scene).texts["li"].startswith("trussgrid")


def test_a_bar_may_be_upright() -> None:
    points = np.concatenate([np.eye(3), -np.eye(3)])
    ends = np.stack([np.ones((6, 3)), 1 + points], axis=1)
    scene = Scene("Bars along the axes")
    scene.add_bars("bars", ends)
    things, frames = objects(scene), transforms(scene)
    for i in range(6):
        found = bar_ends(things[f"bars/bar{i}/bar"], in_world(frames, f"bars/bar{i}"))
        np.testing.assert_allclose(found, ends[i], atol=1e-6)


def keyed_pose(clip: Command, frame: int) -> Array:
    """Pose that the viewer gives to a bar's frame, from its keyframes."""
    tracks = {track["name"]: track["keys"] for track in clip["tracks"]}
    value = {}
    for name, keys in tracks.items():
        times = [key["time"] for key in keys]
        assert (times[0], times[-1]) == (0, 5)
        columns = np.array([key["value"] for key in keys]).T
        value[name] = np.array([np.interp(frame, times, column) for column in columns])
    x, y, z, w = value[".quaternion"]
    assert np.linalg.norm(value[".quaternion"]) == pytest.approx(1, abs=1e-6)
    R = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = R * value[".scale"], value[".position"]
    return T


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_moving_bars_go_from_end_to_end_in_every_frame(seed: int) -> None:
    rng = np.random.default_rng(seed)
    ends = rng.normal(size=(4, 2, 3))
    frames = rng.normal(size=(6, 4, 2, 3))
    frames[:, 2] = ends[2]
    frames[2:5, 1] = frames[2, 1]  # a rest, which needs no keyframes inside
    scene = Scene("Bars")
    scene.add_bars("truss", ends)
    scene.animate_bars("truss", frames, frames_per_second=10)
    (animation,) = of_type(scene, "set_animation")
    clips = {clip["path"].removeprefix("/meshcat/"): clip["clip"] for clip in animation["animations"]}
    things = objects(scene)
    assert list(clips) == ["truss/bar0", "truss/bar1", "truss/bar3"]
    for path, clip in clips.items():
        assert clip["fps"] == 10
        for frame in range(6):
            moved = bar_ends(things[f"{path}/bar"], keyed_pose(clip, frame))
            np.testing.assert_allclose(moved, frames[frame, int(path[-1])], atol=1e-5)
    assert all(len(track["keys"]) == 5 for track in clips["truss/bar1"]["tracks"])
    assert scene._repr_html_() == scene._repr_html_()


def test_the_camera_makes_room_for_moving_bars() -> None:
    scene = bare_bars()
    (at_rest,) = of_type(scene, "set_view")
    scene.animate_bars("truss", [[[[0, 0, 0], [0, 0, 1]]], [[[0, 0, 0], [0, 12, 0]]]])
    (moving,) = of_type(scene, "set_view")
    assert max(moving["half_extent"]) > 5 > max(at_rest["half_extent"])


def test_bars_move_once() -> None:
    scene = bare_bars()
    frames = [[[[0, 0, 0], [0, 0, 1]]], [[[0, 0, 0], [0, 1, 0]]]]
    scene.animate_bars("truss", frames)
    with pytest.raises(ValueError, match=r"^name is 'truss'"):
        scene.animate_bars("truss", frames)


def bare_bars() -> Scene:
    scene = Scene("A bar")
    scene.add_bars("truss", [[[0, 0, 0], [0, 0, 1]]])
    return scene


# ---- motion -----------------------------------------------------------------------------------------


def test_points_are_where_they_are_and_of_one_colour() -> None:
    points = np.random.default_rng(3).normal(size=(40, 3))
    scene = bare_scene()
    scene.add_points(points, name="reach", size=0.02, color="vermillion")
    drawn = objects(scene)["reach/dots"]
    (geometry,), (material,) = drawn["geometries"], drawn["materials"]
    position = geometry["data"]["attributes"]["position"]
    assert position["itemSize"] == 3
    stored = np.frombuffer(position["array"].data, dtype=np.float32)
    np.testing.assert_allclose(stored.reshape(-1, 3), points, rtol=1e-6)
    # three.js draws size · (height / 2) / depth pixels, whatever the field of view is.
    view = View(np.eye(3), np.zeros(3), np.ones(3), width=700, height=400)
    assert material["size"] * 400 / 2 / 3.0 == pytest.approx(0.02 * view.scale(np.array([3.0]))[0], rel=1e-6)
    assert material["color"] == int(hex_color("vermillion")[1:], 16)
    # meshcat's own material would look for a colour of each point, and show black.
    assert not material["vertexColors"]
    assert drawn["object"]["type"] == "Points"
    assert "reach" in scene._repr_html_()


def test_keyframes_stand_only_under_what_moves_and_repeat_the_joint_values() -> None:
    rng = np.random.default_rng(6)
    q_frames = np.zeros((30, 12))
    q_frames[:, 1] = rng.normal(size=30)
    q_frames[10:20, 4] = np.linspace(0, 3, 10)
    q_frames[:, 7] = 0.5  # constant, but not where the chain was drawn
    scene = uvms_scene()
    scene.animate("uvms", q_frames, frames_per_second=10)
    (animation,) = of_type(scene, "set_animation")
    assert animation["options"] == {"play": True, "repetitions": math.inf}
    clips = {clip["path"].removeprefix("/meshcat/"): clip["clip"] for clip in animation["animations"]}
    assert list(clips) == [joint_path("uvms", joint) for joint in (1, 4, 7)]
    for joint in (1, 4, 7):
        clip = clips[joint_path("uvms", joint)]
        (track,) = clip["tracks"]
        times = [key["time"] for key in track["keys"]]
        np.testing.assert_allclose(
            np.interp(range(30), times, joint_values(track)), q_frames[:, joint], atol=1e-6
        )
        assert clip["fps"] == 10
        assert (times[0], times[-1]) == (0, 29)
    assert len(clips[joint_path("uvms", 7)]["tracks"][0]["keys"]) == 2


def joint_values(track: Command) -> list[float]:
    values = [key["value"] for key in track["keys"]]
    if track["name"] == ".position":
        return [z for _, _, z in values]
    return [2 * math.atan2(z, w) for _, _, z, w in values]


def test_sliders_run_over_the_limits() -> None:
    chain = dx.Chain(
        [[0, 0, 0, 0, 0, 1], [0, 0, 1, 0, 0, 0], [0, 0, 0, 1, 0, 0], [1, 0, 0, 0, 0, 0]],
        np.eye(4),
        joint_names=["turn", "lift", "tilt", "slide"],
        lower=[-1, 0, -np.inf, -np.inf],
        upper=[2, 0.5, np.inf, np.inf],
    )
    scene = Scene("Sliders")
    scene.add_chain(chain, [0.1, 0.2, 0.3, 1.7], name="one")
    scene.add_chain(chain, [0, 0, 0, 0], name="two")
    scene.add_sliders("one")
    scene.add_sliders("two")
    controls = of_type(scene, "set_slider")
    labels = ["turn [rad]", "lift [m]", "tilt [rad]", "slide [m]"]
    assert [control["label"] for control in controls] == [*labels, *(f"two {label}" for label in labels)]
    limits = [(-1, 2), (0, 0.5), (-math.pi, math.pi), (-1, 1.7)]
    assert [(control["min"], control["max"]) for control in controls[:4]] == limits
    assert [control["value"] for control in controls[:4]] == [0.1, 0.2, 0.3, 1.7]
    for joint, control in enumerate(controls[:4]):
        kind = "revolute" if joint in (0, 2) else "prismatic"
        nodes = ["meshcat", *joint_path("one", joint).split("/")]
        assert control["joint"] == {"node": nodes, "kind": kind}


# ---- mechanisms -------------------------------------------------------------------------------------

ANGLES = np.linspace(0.0, 6.0, 25)
TURNS = dx.spatial.exp(np.outer(ANGLES, [0, 0, 0, 0, 0, 1.0])).numpy()
SLIDES = dx.spatial.exp(np.outer(np.linspace(0.0, 0.4, 5), [1.0, 0, 0, 0, 0, 0])).numpy()
ROD = np.array([[[0.0, 0, 0], [0.5, 0, 0]]])

CRANK = Body("crank", slider="turn [rad]", poses=TURNS, rods=ROD, pins=np.zeros((1, 3)), color="blue")
SLIDE = Body("slide", on="crank", slider="slide [m]", poses=SLIDES, rods=ROD)
CARRIED = Body("carried", on="slide", poses=dx.spatial.exp([0, 0, 1.0, 0, 0, 0]).numpy(), rods=ROD)
TURN_BY = Slider("turn [rad]", ANGLES, 0.75)
SLIDE_BY = Slider("slide [m]", np.linspace(0.0, 0.4, 5), 0.25)
SPOKE = Body("spoke", rods=ROD)


def mechanism_scene(name: str = "press", **options: Any) -> Scene:
    scene = Scene("A mechanism")
    scene.add_mechanism([CRANK, SLIDE, CARRIED], [TURN_BY, SLIDE_BY], name=name, **options)
    return scene


def test_bodies_stand_where_the_sliders_do() -> None:
    base = dx.spatial.exp([0.1, 0.2, 0.3, 0.4, 0, 0]).numpy()
    frames = transforms(mechanism_scene(pose=base))
    T = base @ dx.spatial.exp([0, 0, 0, 0, 0, 0.75]).numpy() @ dx.spatial.exp([0.25, 0, 0, 0, 0, 0]).numpy()
    np.testing.assert_allclose(in_world(frames, "press/crank/slide"), T, atol=1e-5)
    above = T @ dx.spatial.exp([0, 0, 1.0, 0, 0, 0]).numpy()
    np.testing.assert_allclose(in_world(frames, "press/crank/slide/carried"), above, atol=1e-5)


def test_a_body_is_drawn_by_its_rods_and_pins() -> None:
    drawn = objects(mechanism_scene())
    assert [path for path in drawn if path.startswith("press/")] == [
        "press/crank/rod0",
        "press/crank/pin0",
        "press/crank/slide/rod0",
        "press/crank/slide/carried/rod0",
    ]
    assert drawn["press/crank/rod0"]["materials"][0]["color"] == 0x0072B2


def test_sliders_of_a_mechanism_hold_the_poses_of_what_they_move() -> None:
    turn, slide = of_type(mechanism_scene(), "set_slider")
    assert [turn[key] for key in ("label", "min", "max", "value")] == ["turn [rad]", 0.0, 6.0, 0.75]
    assert [slide[key] for key in ("label", "min", "max", "value")] == ["slide [m]", 0.0, 0.4, 0.25]
    (crank,) = turn["table"]["bodies"]
    assert crank["node"] == ["meshcat", "press", "crank"]
    np.testing.assert_allclose(turn["table"]["values"], ANGLES, atol=1e-6)
    turns = np.array(crank["turns"])
    # More than half a turn: the quaternions go on and do not jump to their negatives.
    np.testing.assert_allclose(np.abs(np.diff(turns, axis=0)).max(), 0.125, atol=0.01)
    np.testing.assert_allclose(np.abs(turns[:, 3]), np.abs(np.cos(ANGLES / 2)), atol=1e-6)
    (moved,) = slide["table"]["bodies"]
    assert moved["node"] == ["meshcat", "press", "crank", "slide"]
    np.testing.assert_allclose(np.array(moved["positions"])[:, 0], np.linspace(0, 0.4, 5), atol=1e-5)


def test_between_two_values_a_body_is_between_two_poses() -> None:
    for angle in (0.05, 1.0, 2.3, 5.99):
        scene = Scene("A crank")
        scene.add_mechanism([CRANK], [Slider("turn [rad]", ANGLES, angle)], name="press")
        T = dx.spatial.exp([0, 0, 0, 0, 0, angle]).numpy()
        np.testing.assert_allclose(in_world(transforms(scene), "press/crank"), T, atol=2e-4)


HALVES = np.linspace(0.0, 1.0, 3)
BALL = Body(
    "ball",
    slider="size",
    poses=np.stack([np.eye(4)] * 3),
    ball=0.5,
    stretches=np.array([[1.0, 1.0, 1.0], [1.0, 2.0, 0.5], [1.0, 4.0, 0.5]]),
)


def test_a_slider_stretches_what_a_body_draws() -> None:
    scene = Scene("A ball that becomes an ellipsoid")
    scene.add_mechanism([BALL], [Slider("size", HALVES, 0.75)])
    np.testing.assert_allclose(
        in_world(transforms(scene), "mechanism/ball"), np.diag([1, 3, 0.5, 1]), atol=1e-6
    )
    (control,) = of_type(scene, "set_slider")
    np.testing.assert_allclose(control["table"]["bodies"][0]["stretches"], BALL.stretches)
    # The ball of 0.5 m becomes 2 m long at the end of the slider, and the camera makes room for it.
    assert np.abs(scene.region).max(axis=0)[1] == pytest.approx(2.0, rel=0.02)


def test_a_body_at_rest_can_be_stretched_too() -> None:
    scene = Scene("A disc")
    scene.add_mechanism([Body("disc", ball=1.0, stretches=np.array([1.0, 1.0, 0.1]))], [])
    np.testing.assert_allclose(
        in_world(transforms(scene), "mechanism/disc"), np.diag([1, 1, 0.1, 1]), atol=1e-6
    )


def test_a_body_draws_arrows_from_its_origin_and_a_ball() -> None:
    scene = Scene("Arrows")
    scene.add_mechanism([Body("one", arrows=np.array([[0, 0, 0.5], [0.2, 0, 0]]), ball=0.1)], [])
    drawn = [
        path.removeprefix("mechanism/one/") for path in objects(scene) if path.startswith("mechanism/one/")
    ]
    arrows = [f"arrow{i}-{part}" for i in (0, 1) for part in ("shaft", "head")]
    assert drawn == [*arrows, "body", "axis0", "axis1", "axis2"]
    assert scene.region.max(axis=0) == pytest.approx([0.2, 0.1, 0.5], abs=1e-6)


@pytest.mark.parametrize(
    ("bodies", "reason"),
    [
        ([replace(BALL, stretches=np.ones((2, 3)))], "stretches"),
        ([replace(BALL, stretches=np.zeros((3, 3)))], "stretches are not all positive"),
        ([BALL, Body("carried", on="ball", rods=ROD)], "has stretches"),
        ([replace(BALL, ball=-1.0)], "ball is -1.0"),
        ([replace(BALL, arrows=np.zeros((1, 3)))], "an arrow without length"),
    ],
)
def test_stretches_arrows_and_balls_are_checked(bodies: list[Body], reason: str) -> None:
    with pytest.raises(ValueError, match=reason):
        Scene("t").add_mechanism(bodies, [Slider("size", HALVES, 0.0)])


def test_the_camera_makes_room_for_what_sliders_do() -> None:
    still = Scene("At rest")
    still.add_mechanism([Body("crank", rods=ROD)], [])
    (at_rest,), (moving,) = (of_type(scene, "set_view") for scene in (still, mechanism_scene()))
    assert max(moving["half_extent"]) > 0.8 > 0.4 > max(at_rest["half_extent"])


def test_two_mechanisms_have_their_own_sliders() -> None:
    scene = mechanism_scene()
    scene.add_mechanism([CRANK], [TURN_BY], name="other")
    names = [control["label"] for control in of_type(scene, "set_slider")]
    assert names == ["turn [rad]", "slide [m]", "other turn [rad]"]


def test_letters_stand_at_points_of_their_body() -> None:
    scene = Scene("A mechanism")
    scene.add_mechanism([replace(CRANK, letters={"A": np.zeros(3), "B": np.array([0.5, 0, 0])})], [TURN_BY])
    paths = {command["text"]: command["path"] for command in of_type(scene, "set_label")}
    frames = transforms(scene)
    at = {text: in_world(frames, path.removeprefix("/meshcat/"))[:3, 3] for text, path in paths.items()}
    np.testing.assert_allclose(at["A"], 0, atol=1e-6)
    np.testing.assert_allclose(at["B"], 0.5 * np.array([math.cos(0.75), math.sin(0.75), 0]), atol=1e-5)


def test_letters_can_stand_anywhere() -> None:
    scene = uvms_scene()
    scene.add_letters({"K": (1.0, 2.0, 3.0)})
    (path,) = [command["path"] for command in of_type(scene, "set_label") if command["text"] == "K"]
    np.testing.assert_allclose(in_world(transforms(scene), path.removeprefix("/meshcat/"))[:3, 3], [1, 2, 3])


# ---- bad input --------------------------------------------------------------------------------------

BAD: dict[str, tuple[str, Callable[[Scene], object]]] = {
    "title": ("title", lambda _: Scene(" ")),
    "height": ("height", lambda _: Scene("t", height=0)),
    "view_from zero": ("view_from", lambda _: Scene("t", view_from=(0, 0, 0))),
    "view_from not finite": ("view_from", lambda _: Scene("t", view_from=(0, math.nan, 0))),
    "q too short": ("q", lambda s: s.add_chain(UVMS, np.zeros(11), name="other")),
    "q not finite": ("q", lambda s: s.add_chain(UVMS, np.full(12, np.nan), name="other")),
    "name taken": ("name", lambda s: s.add_chain(UVMS, REST, name="uvms")),
    "name taken by another kind": ("name", lambda s: s.add_path([[0, 0, 0], [1, 0, 0]], name="uvms")),
    "name with a slash": ("name", lambda s: s.add_path([[0, 0, 0], [1, 0, 0]], name="a/b")),
    "name empty": ("name", lambda s: s.add_box((1, 1, 1), name="")),
    "color": ("color", lambda s: s.add_chain(UVMS, REST, name="other", color="bleu")),
    "size": ("size", lambda s: s.add_box((1, 0, 1), name="v")),
    "size too short": ("size", lambda s: s.add_box((1, 1), name="v")),
    "on": ("on", lambda s: s.add_box((1, 1, 1), name="v", on="nobody")),
    "joint": ("joint", lambda s: s.add_box((1, 1, 1), name="v", on="uvms", joint=13)),
    "joint zero": ("joint", lambda s: s.add_box((1, 1, 1), name="v", on="uvms", joint=0)),
    "pose": ("pose", lambda s: s.add_box((1, 1, 1), name="v", pose=2 * np.eye(4))),
    "ellipsoid of six dimensions": (
        "ellipsoid.axes",
        lambda s: s.add_ellipsoid(indices.velocity_ellipsoid(UVMS.geometric_jacobian(REST)), [0, 0, 0]),
    ),
    "ellipsoid unbounded": (
        "ellipsoid.semi_axes",
        lambda s: s.add_ellipsoid(Ellipsoid(FLAT.axes, 1 / FLAT.semi_axes), [0, 0, 0]),
    ),
    "ellipsoid of a point": (
        "ellipsoid.semi_axes",
        lambda s: s.add_ellipsoid(Ellipsoid(FLAT.axes, 0 * FLAT.semi_axes), [0, 0, 0]),
    ),
    "center": ("center", lambda s: s.add_ellipsoid(FLAT, [0, 0, np.inf])),
    "scale": ("scale", lambda s: s.add_ellipsoid(FLAT, [0, 0, 0], scale=0.0)),
    "points of two dimensions": ("points", lambda s: s.add_path([[0, 0], [1, 1]])),
    "points not finite": ("points", lambda s: s.add_path([[0, 0, 0], [1, np.nan, 1]])),
    "no points": ("points", lambda s: s.add_points(np.zeros((0, 3)))),
    "points of no size": ("size", lambda s: s.add_points([[0, 0, 0]], size=0.0)),
    "points all the same": ("points", lambda s: s.add_path([[1, 1, 1], [1, 1, 1]])),
    "points none": ("points", lambda s: s.add_path(np.zeros((0, 3)))),
    "animate unknown": ("name", lambda s: s.animate("nobody", np.zeros((2, 12)))),
    "q_frames too narrow": ("q_frames", lambda s: s.animate("uvms", np.zeros((2, 11)))),
    "q_frames not finite": ("q_frames", lambda s: s.animate("uvms", np.full((2, 12), np.inf))),
    "q_frames single": ("q_frames", lambda s: s.animate("uvms", np.zeros((1, 12)))),
    "q_frames ambiguous": ("q_frames", lambda s: s.animate("uvms", np.outer([0, 1], np.full(12, math.pi)))),
    "frames_per_second": (
        "frames_per_second",
        lambda s: s.animate("uvms", np.zeros((2, 12)), frames_per_second=0.0),
    ),
    "letters without a point": ("points", lambda s: s.add_letters({})),
    "letters at no point": ("points", lambda s: s.add_letters({"A": (0, 0)})),
    "letters of a name taken": ("name", lambda s: s.add_letters({"A": (0, 0, 0)}, name="uvms")),
    "letters of a body": (
        "bodies", lambda s: s.add_mechanism([replace(SPOKE, letters={"A": np.zeros(2)})], [])
    ),
    "remark": ("text", lambda s: s.add_remark(" ")),
    "box to look at": ("low", lambda s: s.look_at((0, 0), (1, 1))),
    "box to look at without size": ("high", lambda s: s.look_at((0, 0, 1), (0, 0, 1))),
    "bars of points": ("ends", lambda s: s.add_bars("b", np.zeros((2, 3)))),
    "bars not finite": ("ends", lambda s: s.add_bars("b", [[[0, 0, 0], [0, 0, np.inf]]])),
    "bars none": ("ends", lambda s: s.add_bars("b", np.zeros((0, 2, 3)))),
    "bars without a length": ("ends", lambda s: s.add_bars("b", np.zeros((1, 2, 3)))),
    "bars without a radius": ("radius", lambda s: s.add_bars("b", [[[0, 0, 0], [0, 0, 1]]], radius=0.0)),
    "bars of no colour": ("color", lambda s: s.add_bars("b", [[[0, 0, 0], [0, 0, 1]]], color="bleu")),
    "bars of a name taken": ("name", lambda s: s.add_bars("uvms", [[[0, 0, 0], [0, 0, 1]]])),
    "bars unknown": ("name", lambda s: s.animate_bars("nobody", np.zeros((2, 1, 2, 3)))),
    "sliders unknown": ("name", lambda s: s.add_sliders("nobody")),
    "mechanism's name": ("name", lambda s: s.add_mechanism([SPOKE], [], name="uvms")),
    "mechanism's pose": ("pose", lambda s: s.add_mechanism([SPOKE], [], pose=2 * np.eye(4))),
    "body twice": ("bodies", lambda s: s.add_mechanism([SPOKE, SPOKE], [])),
    "body with a slash": ("bodies", lambda s: s.add_mechanism([replace(SPOKE, name="a/b")], [])),
    "body on nothing": ("bodies", lambda s: s.add_mechanism([replace(SPOKE, on="hub")], [])),
    "body without its slider": ("bodies", lambda s: s.add_mechanism([CRANK], [])),
    "body without length": ("bodies", lambda s: s.add_mechanism([replace(SPOKE, rods=0 * ROD)], [])),
    "body of no size": ("bodies", lambda s: s.add_mechanism([replace(SPOKE, radius=0.0)], [])),
    "body without colour": ("color", lambda s: s.add_mechanism([replace(SPOKE, color="bleu")], [])),
    "poses too few": ("bodies", lambda s: s.add_mechanism([replace(CRANK, poses=TURNS[1:])], [TURN_BY])),
    "poses not rigid": ("bodies", lambda s: s.add_mechanism([replace(CRANK, poses=2 * TURNS)], [TURN_BY])),
    "poses too far apart": (
        "bodies",
        lambda s: s.add_mechanism(
            [replace(CRANK, poses=TURNS[::8])], [replace(TURN_BY, values=ANGLES[::8])]
        ),
    ),
    "slider for nothing": ("sliders", lambda s: s.add_mechanism([SPOKE], [TURN_BY])),
    "slider twice": ("sliders", lambda s: s.add_mechanism([CRANK], [TURN_BY, TURN_BY])),
    "slider without values": (
        "sliders", lambda s: s.add_mechanism([CRANK], [replace(TURN_BY, values=ANGLES[:1])])
    ),
    "slider that goes back": (
        "sliders", lambda s: s.add_mechanism([CRANK], [replace(TURN_BY, values=-ANGLES)])
    ),
    "slider elsewhere": ("sliders", lambda s: s.add_mechanism([CRANK], [replace(TURN_BY, start=7.0)])),
}  # fmt: skip


@pytest.mark.parametrize(("argument", "call"), BAD.values(), ids=BAD)
def bare_scene() -> Scene:
    scene = Scene("The arm alone")
    scene.add_chain(UVMS, REST, name="uvms", axes=False)
    return scene


UNTOUCHED = bare_scene()._repr_html_()


@pytest.mark.parametrize(("argument", "call"), BAD.values(), ids=BAD)
def test_bad_input_is_named_and_leaves_the_scene_alone(
    argument: str, call: Callable[[Scene], object]
) -> None:
    scene = bare_scene()
    with pytest.raises(ValueError, match=rf"^{re.escape(argument)}\b"):
        call(scene)
    assert scene._repr_html_() == UNTOUCHED


ALONG_Z = np.array([[[0.0, 0, 0], [0, 0, 1]]])
BAD_FRAMES = {
    "too few bars": (np.zeros((2, 0, 2, 3)), "frames"),
    "one frame": (ALONG_Z[None], "frames"),
    "not finite": (np.full((2, 1, 2, 3), np.nan), "frames"),
    "no length": (np.zeros((2, 1, 2, 3)), "frames"),
    "right round": (np.stack([ALONG_Z, -ALONG_Z]), "frames"),
}


@pytest.mark.parametrize(("frames", "argument"), BAD_FRAMES.values(), ids=BAD_FRAMES)
def test_bad_frames_of_bars_are_named_and_leave_the_scene_alone(frames: Array, argument: str) -> None:
    scene = bare_bars()
    before = scene._repr_html_()
    with pytest.raises(ValueError, match=rf"^{argument}\b"):
        scene.animate_bars("truss", frames)
    with pytest.raises(ValueError, match="frames_per_second"):
        scene.animate_bars("truss", np.stack([ALONG_Z, ALONG_Z]), frames_per_second=0.0)
    assert scene._repr_html_() == before


@pytest.mark.parametrize("first", ["animate", "slide"])
@pytest.mark.parametrize("second", ["animate", "slide"])
def test_a_chain_moves_in_one_way_only(first: str, second: str) -> None:
    scene = bare_scene()
    moves = {
        "animate": lambda: scene.animate("uvms", np.outer([0, 0.1], np.ones(12))),
        "slide": lambda: scene.add_sliders("uvms"),
    }
    moves[first]()
    with pytest.raises(ValueError, match=r"^name is 'uvms'"):
        moves[second]()


# ---- the viewer -------------------------------------------------------------------------------------


def test_the_viewer_is_copied_with_its_licences(tmp_path: Path) -> None:
    folder = tmp_path / "assets" / "meshcat"
    scenes.copy_viewer(folder)
    scenes.copy_viewer(folder)
    dist = resources.files("meshcat") / "viewer" / "dist"
    script = (folder / "main.min.js").read_bytes()
    assert script == (dist / "main.min.js").read_bytes()
    (licence,) = re.findall(rb"please see (\S+)", script[:200])
    assert {path.name for path in folder.iterdir()} == {
        "LICENSE",
        "main.min.js",
        licence.decode(),
        "main.min.js.THIRD_PARTY_LICENSES.json",
    }


def test_the_viewer_knows_the_commands_that_it_is_given() -> None:
    script = (resources.files("meshcat") / "viewer" / "dist" / "main.min.js").read_text(encoding="utf-8")
    page_script = (resources.files("dexterity.scenes") / "viewer.js").read_text(encoding="utf-8")
    ours = {"set_label", "set_view", "set_path", "set_slider", "set_moving"}
    kinds = {command["type"] for command in commands(full_scene())}
    assert kinds >= ours
    assert all(f'"{kind}"==' in script for kind in kinds - ours)
    assert all(re.search(rf"^    {kind}\(.*\) {{", page_script, re.MULTILINE) for kind in ours)
