"""A scene as commands of meshcat's viewer, which the page replays: no server is involved.

Examples
--------
>>> import tempfile
>>> from pathlib import Path
>>> from dexterity.scenes import copy_viewer
>>> with tempfile.TemporaryDirectory() as folder:
...     copy_viewer(folder)
...     any(file.suffix == ".js" for file in Path(folder).iterdir())
True
"""

from __future__ import annotations

import base64
import itertools
import math
import zlib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from importlib import resources
from pathlib import Path
from typing import Protocol, runtime_checkable

import numpy as np
import umsgpack
from meshcat.animation import Animation
from meshcat.commands import SetObject
from meshcat.path import Path as NodePath
from meshcat.visualizer import Visualizer

from dexterity import checks, store
from dexterity.scenes.arguments import Array
from dexterity.scenes.camera import View
from dexterity.scenes.frames import DrawnChain
from dexterity.scenes.mechanisms import Drive, Mechanism, Slider
from dexterity.scenes.motion import BarMotion, JointMotion
from dexterity.scenes.shapes import Command, Shape

__all__ = ["copy_viewer", "packed_commands", "slider_commands"]


@checks.arguments(folder=checks.path)
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


def packed_commands(
    shapes: Sequence[Shape],
    frames: Mapping[str, Array],
    view: View,
    motions: Mapping[str, JointMotion | BarMotion],
    sliders: Iterable[Command],
) -> str:
    """Return all that the viewer is to do, compressed, in base 64; frames have poses in their parents'."""
    recorder = _Recorder()
    root = Visualizer(window=recorder)
    _set_stage(root, view)
    for path, T in frames.items():
        root[path].set_transform(T)
    for shape in shapes:
        shape.record(root)
    if motions:
        animation = Animation()
        for path, motion in motions.items():
            animation.clips[_node(path)] = motion.clip()
        root.set_animation(animation, repetitions=math.inf)
        recorder.send(_moving(motions.values()))
    for slider in sliders:
        recorder.send(slider)
    return recorder.packed()


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
        # Places go in the precision that WebGL draws in; the numbers of a slider are to be read.
        precision = command.precision if isinstance(command, Command) else "single"
        self._commands.append(umsgpack.packb(command.lower(), force_float_precision=precision))

    def packed(self) -> str:
        """Return each command after its length in four bytes, all compressed, in base 64."""
        framed = b"".join(len(command).to_bytes(4, "little") + command for command in self._commands)
        return base64.b64encode(zlib.compress(framed, 9)).decode()


def slider_commands(
    chains: Mapping[str, DrawnChain], mechanisms: Mapping[str, Mechanism]
) -> Iterator[Command]:
    """Sliders for the joints of chains and of mechanisms, by name, each with a label of its own."""
    taken: set[str] = set()
    for name, drawn in chains.items():
        for i, joint in enumerate(drawn.chain.joint_names):
            unit = "rad" if drawn.chain.kinds[i] == "revolute" else "m"
            yield _joint_slider(_untaken(f"{joint} [{unit}]", name, taken), drawn, i)
    for name, mechanism in mechanisms.items():
        for slider in mechanism.sliders:
            yield _mechanism_slider(_untaken(slider.label, name, taken), slider, mechanism.drives)


def _moving(motions: Iterable[JointMotion | BarMotion]) -> Command:
    """Names of the joints that move by themselves, and when [s]."""
    spans = [
        {"name": motion.name, "start": start, "end": end}
        for motion in motions
        if isinstance(motion, JointMotion)
        for start, end in motion.spans()
    ]
    return Command({"type": "set_moving", "spans": spans})


def _untaken(label: str, name: str, taken: set[str]) -> str:
    """Label of a slider, with what it moves in front where the label alone is taken."""
    label = f"{name} {label}" if label in taken else label
    taken.add(label)
    return label


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


def _joint_slider(label: str, drawn: DrawnChain, joint: int) -> Command:
    """Slider over the limits of a joint, which moves the joint's frame."""
    value, kind = float(drawn.q[joint]), drawn.chain.kinds[joint]
    unlimited = math.pi if kind == "revolute" else 1.0
    lower, upper = float(drawn.chain.lower[joint]), float(drawn.chain.upper[joint])
    slider = {
        "label": label,
        "value": value,
        "min": lower if math.isfinite(lower) else min(-unlimited, value),
        "max": upper if math.isfinite(upper) else max(unlimited, value),
        "step": 0.01,
        "joint": {"node": _node(drawn.joints[joint]).entries, "kind": kind},
    }
    return Command({"type": "set_slider", **slider})


def _mechanism_slider(label: str, slider: Slider, drives: Mapping[str, Drive]) -> Command:
    """Slider that moves the frames of all bodies that are its own."""
    moved = [
        {
            "node": _node(path).entries,
            "positions": drive.positions.round(5).tolist(),
            "turns": drive.turns.round(6).tolist(),
            "stretches": drive.stretches.round(6).tolist(),
        }
        for path, drive in drives.items()
        if drive.slider.label == slider.label
    ]
    span = float(slider.values[-1] - slider.values[0])
    made = {
        "label": label,
        "value": slider.start,
        "min": float(slider.values[0]),
        "max": float(slider.values[-1]),
        "step": 10.0 ** math.floor(math.log10(span / 100)),
        "table": {"values": slider.values.round(6).tolist(), "bodies": moved},
    }
    return Command({"type": "set_slider", **made})


def _node(path: str) -> NodePath:
    return NodePath(("meshcat",)).append(path)
