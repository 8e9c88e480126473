"""Live instruments of the book: sliders, presets, numbers and drawings over code that the package exports.

An instrument is one iframe with everything in it, so that it works from a file, without a server, and inside a
notebook. The mathematics comes from ECMAScript modules that :mod:`dexterity` generates. A chapter adds one short
script, ``instrument.js`` beside its ``show.py``, which reads the inputs, calls the modules and draws:

.. code-block:: javascript

    // All quantities are in SI units. `modules` are the imported modules by name, `data` the instrument's data.
    export function values(inputs, { modules, data }) { return { w: modules.index.value([inputs.x]) }; }
    export function draw(outputs, inputs, { stages, data }) { stages.side.line([[0, 0], [1, outputs.w]], "blue"); }
    export function drag(handle, [x, y], inputs, { data }, drawing) { return { x }; }   // only if there are handles

``values`` returns an object with an entry for each readout, and whatever else ``draw`` needs. ``draw`` gets the
stages by the names of the drawings; what a stage offers stands in ``instrument.html``. ``window.instrument`` of the
iframe has ``values(inputs)``, ``inputs``, ``set(changes)`` and ``settled()``, for tests.
"""

from __future__ import annotations

import base64
import html
import json
import math
import zlib
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from importlib import resources
from string import Template
from typing import Any

from dexterity.scenes.colors import COLORS

UNITS: Mapping[str, float] = {
    "": 1.0,
    "m": 1.0,
    "mm": 1e-3,
    "m/s": 1.0,
    "m²": 1.0,
    "m³": 1.0,
    "rad": 1.0,
    "°": math.pi / 180,
    "kg": 1.0,
    "t": 1e3,
    "N": 1.0,
    "kN": 1e3,
    "%": 1e-2,
}
"""Units that are shown, each in SI units."""

TAB_STOPS = 6
"""Most sliders that are tab stops of their own; more of them are one stop, within which ↑ and ↓ move."""


@dataclass(frozen=True)
class Slider:
    """A number that the reader sets.

    Attributes
    ----------
    name, label
        Name in the script, and what the reader sees.
    unit
        One of :data:`UNITS`, in which the number is shown.
    lower, upper, step, start
        In SI units.
    """

    name: str
    label: str
    unit: str
    lower: float
    upper: float
    step: float
    start: float


@dataclass(frozen=True)
class Choice:
    """One of several texts, which the reader chooses; the first one at the start.

    Attributes
    ----------
    name, label
        Name in the script, and what the reader sees.
    options
        Texts; the script gets the chosen one.
    """

    name: str
    label: str
    options: Sequence[str]


@dataclass(frozen=True)
class Readout:
    """A number or a text that the script returns.

    Attributes
    ----------
    name, label
        Name in the script, and what the reader sees.
    unit
        One of :data:`UNITS`, in which a number is shown; the script returns SI units.
    digits
        Significant digits.
    floor
        Numbers whose magnitude is smaller are shown as less than this, in SI units.
    """

    name: str
    label: str
    unit: str = ""
    digits: int = 3
    floor: float = 0.0


@dataclass(frozen=True)
class Drawing:
    """A drawing in one plane, with the same scale in both directions.

    Attributes
    ----------
    name, label
        Name in the script, and what is drawn, for those who see it and those who do not.
    extent
        Left, right, bottom and top of what is shown, in the script's coordinates.
    """

    name: str
    label: str
    extent: tuple[float, float, float, float]


@dataclass(frozen=True)
class Instrument:
    """A live instrument, shown when it is the last value of a cell.

    Attributes
    ----------
    title
        What it is, in a line.
    controls
        Sliders and choices, in their order.
    readouts
        Readouts in groups, by the heading of each group.
    drawings
        Drawings, side by side where there is room.
    modules
        Sources of ECMAScript modules by the names under which the script finds them.
    script
        Source of the script; see :func:`script_beside`.
    presets
        Values of some controls, in SI units, by the name of each preset. The first one is set at the start.
    data
        What else the script needs, in what JSON can say.
    hint
        What to try, in a sentence or two.

    Raises
    ------
    ValueError
        If a unit is unknown, a start or a preset names no control or leaves its limits, or names repeat.
    """

    title: str
    controls: Sequence[Slider | Choice]
    readouts: Mapping[str, Sequence[Readout]]
    drawings: Sequence[Drawing]
    modules: Mapping[str, str] = field(repr=False)
    script: str = field(repr=False)
    presets: Mapping[str, Mapping[str, float | str]] = field(default_factory=dict)
    data: Mapping[str, Any] = field(default_factory=dict)
    hint: str = ""

    def __post_init__(self) -> None:
        controls = {control.name: control for control in self.controls}
        readouts = [readout for group in self.readouts.values() for readout in group]
        for kind, names in (
            ("controls", [control.name for control in self.controls]),
            ("readouts", [readout.name for readout in readouts]),
            ("drawings", [drawing.name for drawing in self.drawings]),
        ):
            if len(set(names)) < len(names):
                raise ValueError(f"{kind} are {names}; each needs a name of its own")
        sliders = [control for control in self.controls if isinstance(control, Slider)]
        parts: list[Slider | Readout] = [*sliders, *readouts]
        for part in parts:
            if part.unit not in UNITS:
                raise ValueError(f"{part.name} is in {part.unit!r}; {', '.join(UNITS)} are known")
        starts = {slider.name: slider.start for slider in sliders}
        for title, values in {"start": starts, **self.presets}.items():
            for name, value in values.items():
                if name not in controls:
                    raise ValueError(f"preset {title!r} sets {name!r}; the controls are {list(controls)}")
                _require_possible(controls[name], value, title)

    def page(self) -> str:
        """Return the document inside the iframe."""
        settings = {
            "controls": [
                {"kind": type(control).__name__.lower(), **asdict(control)} for control in self.controls
            ],
            "readouts": {
                heading: [asdict(readout) for readout in group] for heading, group in self.readouts.items()
            },
            "drawings": [asdict(drawing) for drawing in self.drawings],
            "presets": self.presets,
            "units": UNITS,
            "tabStops": TAB_STOPS,
            "data": self.data,
            "modules": self.modules,
            "script": self.script,
        }
        template = (resources.files(__package__) / "instrument.html").read_text(encoding="utf-8")
        return Template(template).substitute(
            title=html.escape(self.title),
            hint=html.escape(self.hint),
            palette=" ".join(f"--{name.replace(' ', '-')}: {color};" for name, color in COLORS.items()),
            settings=_packed(settings),
        )

    def _repr_html_(self) -> str:
        # The frame takes the height of what is in it as soon as that is known.
        return (
            f'<iframe class="instrument" title="{html.escape(self.title)}" '
            f'style="width:100%;height:640px;border:0" srcdoc="{html.escape(self.page())}"></iframe>'
        )


def script_beside(package: str) -> str:
    """Return the text of ``instrument.js`` in a package, such as that of a chapter."""
    return (resources.files(package) / "instrument.js").read_text(encoding="utf-8")


def _require_possible(control: Slider | Choice, value: float | str, title: str) -> None:
    if isinstance(control, Choice):
        if value not in control.options:
            raise ValueError(
                f"preset {title!r} sets {control.name} to {value!r}, which is none of its options"
            )
    elif not (isinstance(value, int | float) and control.lower <= value <= control.upper):
        limits = f"{control.lower} to {control.upper}"
        raise ValueError(f"preset {title!r} sets {control.name} to {value}; its limits are {limits}")


def _packed(settings: Mapping[str, Any]) -> str:
    """Return JSON, compressed, in base 64: nothing in it can be taken for markup."""
    text = json.dumps(settings, ensure_ascii=False, allow_nan=False)
    return base64.b64encode(zlib.compress(text.encode(), 9)).decode()
