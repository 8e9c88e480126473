"""Robot files: TOML with a robot's joints, limits and rates, their source and their licence.

Every file has ``name``, ``source`` and ``licence``, and may have ``url``. Joints come in one of three forms,
one table a joint:

``[[joints]]``
    ``axis = [x, y, z]`` of unit length in the world frame at home, and ``step``, the way from the joint
    before: a sum of named lengths times directions, such as ``step = { l2 = [0, 1, 0] }`` with a table
    ``[lengths]``. A length can then be changed by name, and ``[variants.NAME]`` holds other lengths with a
    ``note``.
``[[dh]]``
    Denavit–Hartenberg row: ``theta``, ``alpha`` [rad] or ``theta_deg``, ``alpha_deg``, and ``d``, ``a`` [m];
    0 where left out. ``convention = "modified"`` at the top of the file takes the rows as Craig's.
``[[frames]]``
    As in a URDF: ``xyz`` [m] and ``rpy`` [rad] or ``rpy_deg`` from the frame of the joint before, then the
    motion about or along ``axis`` (z if left out) in the new frame.

A joint of any form has a ``name``, and may have ``kind`` (``"revolute"`` or ``"prismatic"``), ``lower``,
``upper`` [rad] or [m], and ``rate`` [rad/s] or [m/s]; a revolute joint takes ``lower_deg``, ``upper_deg``
and ``rate_deg`` in their place. Tables ``[base]`` and ``[tool]`` with ``xyz`` and ``rpy`` or ``rpy_deg``
place the first frame in the world and the tool in the last frame. ``[vehicle]`` with ``size`` [m] puts the
robot on a free vehicle.

Examples
--------
>>> import pathlib, tempfile
>>> from dexterity import robots
>>> path = pathlib.Path(tempfile.mkdtemp(), "slider.toml")
>>> _ = path.write_text('''name = "slider"
... source = "a drawing"
... licence = "MIT"
... [[dh]]
... name = "slide"
... kind = "prismatic"
... upper = 0.5
... rate = 0.2
... [[dh]]
... name = "turn"
... a = 0.3
... lower_deg = -90
... upper_deg = 90
... ''')
>>> robots.load(path).upper
tensor([0.5000, 1.5708], dtype=torch.float64)
"""

from __future__ import annotations

import difflib
import math
import os
import tomllib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, TypeAlias, get_args

import torch
from torch import Tensor

from dexterity import spatial
from dexterity.chain import Chain, JointKind
from dexterity.spatial import TensorLike

__all__ = ["Description", "Form", "build", "has_joints", "nearest", "read_description"]

Form: TypeAlias = Literal["joints", "dh", "frames"]
"""The table that a file gives its joints in."""

_LARGEST_FILE = 65536  # bytes; the largest of the package's files has 5 kB
_TURN = 2 * math.pi


@dataclass(frozen=True)
class Description:
    """A robot as its file describes it.

    Attributes
    ----------
    name, source, licence
        What it is called, where its numbers come from, and on what terms.
    form
        Table that the joints come in.
    joints
        Rows of that table.
    is_modified
        Whether Denavit–Hartenberg rows follow Craig's convention.
    lengths
        Named lengths [m] that steps refer to.
    variants
        Other sets of lengths, by name, with a ``note``.
    base, tool
        (4, 4) poses of the first frame in the world and of the tool in the last frame.
    vehicle_size
        Extent of the vehicle's body along x, y, z [m], for a robot that rides on one.
    """

    name: str
    source: str
    licence: str
    form: Form
    joints: tuple[Mapping[str, Any], ...]
    is_modified: bool
    lengths: Mapping[str, float]
    variants: Mapping[str, Mapping[str, float | str]]
    base: Tensor
    tool: Tensor
    vehicle_size: tuple[float, float, float] | None


def has_joints(path: Path) -> bool:
    """Whether a robot file describes a serial chain."""
    return not set(get_args(Form)).isdisjoint(_toml(path))


def nearest(name: str, known: Iterable[str]) -> str:
    """Return the known names that are nearest to an unknown one, as the end of an error."""
    near = difflib.get_close_matches(name, known := list(known), n=3, cutoff=0.3) or sorted(known)
    return f"there is no such one. Nearest: {', '.join(near) or 'none'}"


def read_description(path: Path | str) -> Description:
    """Read a robot file, in the format that :mod:`dexterity.robots.description` explains.

    Raises
    ------
    ValueError
        If the file is no TOML, is larger than 64 KiB, or an entry is missing, unknown, of the wrong kind or
        contradicts another one; the error names the file and the entry.
    TypeError
        If `path` is no path.
    FileNotFoundError
        If there is no such file.
    """
    if not isinstance(path, str | os.PathLike):
        raise TypeError(f"path is {path!r}; the path of a robot file is needed")
    path = Path(path)
    try:
        with torch.device("cpu"):
            return _description(_toml(path))
    except (ValueError, OverflowError) as error:
        raise ValueError(f"{path.name} is not a robot file: {error}") from error


def build(
    description: Description,
    lengths: Mapping[str, float] | None = None,
    *,
    variant: str | None = None,
    rates: TensorLike | None = None,
) -> Chain:
    """Chain of a description.

    Parameters
    ----------
    description
        What :func:`dexterity.robots.describe` or :func:`read_description` returns.
    lengths
        Lengths [m] that replace the description's, by name.
    variant
        Name of one of the description's variants.
    rates
        Largest joint rates, vehicle joints first, [m/s] and [rad/s]; those of the file by default, 1 where
        it has none.

    Raises
    ------
    ValueError
        If a length or the variant is unknown, or a length is not finite.
    TypeError
        If an argument is of another type.
    """
    if not isinstance(description, Description):
        raise TypeError(f"description is {description!r}; read_description or describe gives one")
    if lengths is not None and not isinstance(lengths, Mapping):
        raise TypeError(f"lengths is {lengths!r}; a mapping from names to lengths is needed")
    chosen = dict(description.lengths)
    title = description.name
    if variant is not None:
        if variant not in description.variants:
            raise ValueError(f"variant is {variant!r}; {nearest(str(variant), description.variants)}")
        chosen |= {k: float(v) for k, v in description.variants[variant].items() if k != "note"}
        title = f"{title} ({variant})"
    for key, value in (lengths or {}).items():
        if key not in chosen:
            raise ValueError(f"lengths holds {key!r}; {nearest(str(key), chosen)}")
        length = spatial.to_float64(value, f"lengths[{key!r}]")
        if length.ndim:
            raise ValueError(f"lengths[{key!r}] has shape {tuple(length.shape)}; a number is needed")
        chosen[key] = float(length)

    vehicle_rates, arm_rates = None, rates
    if rates is not None and description.vehicle_size is not None:
        rates = spatial.to_float64(rates, "rates")
        joints = 6 + len(description.joints)
        if rates.shape != (joints,):
            raise ValueError(f"rates has shape {tuple(rates.shape)}; ({joints},) is needed")
        vehicle_rates, arm_rates = rates[:6], rates[6:]
    with torch.device("cpu"):
        arm = _arm(description, chosen, title, arm_rates)
        if description.vehicle_size is None:
            return arm
        return arm.on_vehicle(torch.eye(4, dtype=torch.float64), name=title, rates=vehicle_rates)


# ---- reading ---------------------------------------------------------------------------------------

_FILE = {"name", "source", "licence", "url", "vehicle", "base", "tool"}
_LIMITS = {"lower", "upper", "rate", "lower_deg", "upper_deg", "rate_deg"}
_ROW: dict[str, set[str]] = {
    "joints": {"axis", "step"},
    "dh": {"theta", "theta_deg", "d", "a", "alpha", "alpha_deg"},
    "frames": {"xyz", "rpy", "rpy_deg", "axis"},
}
_VECTORS = {"axis", "xyz", "rpy", "rpy_deg"}


def _toml(path: Path) -> dict[str, Any]:
    """Content of a file; every error but that of a missing file is a ValueError."""
    if path.is_dir():
        raise ValueError("it is a folder")
    if path.exists() and path.stat().st_size > _LARGEST_FILE:
        raise ValueError(f"it has {path.stat().st_size} bytes; at most {_LARGEST_FILE} are read")
    try:
        return tomllib.loads(path.read_text(encoding="utf-8-sig"))
    except RecursionError as error:
        raise ValueError("its tables are nested too deeply") from error


def _description(content: Mapping[str, Any]) -> Description:
    form: Form = next((form for form in ("dh", "frames") if form in content), "joints")
    extra = {"joints": {"lengths", "variants"}, "dh": {"convention"}, "frames": set[str]()}[form]
    _refuse_unknown(content, _FILE | {form} | extra, "the file")
    convention = content.get("convention", "standard")
    if convention not in ("standard", "modified"):
        raise ValueError(f"convention is {convention!r}; standard or modified is needed")
    lengths = _numbers(content.get("lengths", {}), "lengths")
    vehicle = None if "vehicle" not in content else _table(content["vehicle"], "vehicle")
    if vehicle is not None:
        _refuse_unknown(vehicle, {"size"}, "vehicle")
    description = Description(
        name=_text(content, "name", "the file"),
        source=_text(content, "source", "the file"),
        licence=_text(content, "licence", "the file"),
        form=form,
        joints=_rows(content, form, lengths),
        is_modified=convention == "modified",
        lengths=lengths,
        variants=_variants(content.get("variants", {}), lengths),
        base=_pose(content.get("base", {}), "base"),
        tool=_pose(content.get("tool", {}), "tool"),
        vehicle_size=None if vehicle is None else _size(_required(vehicle, "size", "vehicle")),
    )
    for variant in (None, *description.variants):
        build(description, variant=variant)
    return description


def _rows(content: Mapping[str, Any], form: Form, lengths: Mapping[str, float]) -> tuple[dict[str, Any], ...]:
    rows = _required(content, form, "the file")
    if not isinstance(rows, list) or not rows:
        raise ValueError(f"{form} is {_short(rows)}; one table a joint is needed")
    for i, row in enumerate(rows):
        where = f"joint {i + 1}"
        _text(_table(row, where), "name", where)
        kind = row.get("kind", "revolute")
        if kind not in get_args(JointKind):
            raise ValueError(f"kind of {where} is {_short(kind)}; {get_args(JointKind)} are known")
        _refuse_unknown(row, {"name", "kind"} | _LIMITS | _ROW[form], where)
        for key in set(row) - {"name", "kind", "step"}:
            (_vector if key in _VECTORS else _number)(row[key], f"{key} of {where}")
        _check_angles(row, kind, where)
        if form == "joints":
            _required(row, "axis", where)
            _check_step(row, where, lengths)
    return tuple(rows)


def _check_angles(row: Mapping[str, Any], kind: str, where: str) -> None:
    """Refuse a value in two units, and an angle as the limit of a joint that slides."""
    for key in ("lower", "upper", "rate", "theta", "alpha", "rpy"):
        in_degrees = f"{key}_deg"
        if key in row and in_degrees in row:
            raise ValueError(f"{where} holds {key} and {in_degrees}; one of them is needed")
        if kind == "prismatic" and key in ("lower", "upper", "rate") and in_degrees in row:
            raise ValueError(f"{where} is prismatic and holds {in_degrees}; {key} [m] is needed")
    for key in ("theta", "alpha"):
        if key in row and not abs(row[key]) <= _TURN:
            raise ValueError(f"{key} of {where} is {row[key]} rad, more than a turn; {key}_deg takes degrees")


def _check_step(row: Mapping[str, Any], where: str, lengths: Mapping[str, float]) -> None:
    step = _table(row.get("step", {}), f"step of {where}")
    _refuse_unknown(step, set(lengths), f"step of {where}")
    for length, direction in step.items():
        _vector(direction, f"step {length} of {where}")


def _variants(variants: Any, lengths: Mapping[str, float]) -> Mapping[str, Mapping[str, float | str]]:
    for name, variant in _table(variants, "variants").items():
        changed = set(_table(variant, f"variant {name}")) - {"note"}
        _refuse_unknown(variant, {*lengths, "note"}, f"variant {name}")
        _numbers({key: variant[key] for key in changed}, f"variant {name}")
        _text(variant, "note", f"variant {name}")
    return dict(variants)


def _pose(value: Any, where: str) -> Tensor:
    table = _table(value, where)
    _refuse_unknown(table, {"xyz", "rpy", "rpy_deg"}, where)
    if {"rpy", "rpy_deg"} <= set(table):
        raise ValueError(f"{where} holds rpy and rpy_deg; one of them is needed")
    for key in table:
        _vector(table[key], f"{key} of {where}")
    return _origin(table)


def _size(value: Any) -> tuple[float, float, float]:
    size = _vector(value, "size of vehicle")
    if min(size) <= 0:
        raise ValueError(f"size of vehicle is {value!r}; three positive lengths are needed")
    return size


def _refuse_unknown(entries: Mapping[str, Any], known: set[str], where: str) -> None:
    unknown = sorted(set(entries) - known)
    if unknown:
        near = difflib.get_close_matches(unknown[0], known, n=1, cutoff=0.5)
        hint = f"; did you mean {near[0]}?" if near else ";"
        raise ValueError(f"{where} holds {_short(unknown)}{hint} {sorted(known)} are known")


def _required(entries: Mapping[str, Any], key: str, where: str) -> Any:
    if key not in entries:
        raise ValueError(f"{where} has no {key}")
    return entries[key]


def _table(value: Any, where: str) -> Mapping[str, Any]:
    if not isinstance(value, Mapping):
        raise ValueError(f"{where} is {_short(value)}; a table is needed")
    return value


def _text(entries: Mapping[str, Any], key: str, where: str) -> str:
    value = _required(entries, key, where)
    if not isinstance(value, str) or not value.strip():
        raise ValueError(f"{key} of {where} is {_short(value)}; a text is needed")
    return value


def _numbers(values: Any, where: str) -> dict[str, float]:
    return {key: _number(value, f"{key} of {where}") for key, value in _table(values, where).items()}


def _number(value: Any, where: str) -> float:
    # bool is a kind of int, but true is no number.
    if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) < math.inf:
        raise ValueError(f"{where} is {_short(value)}; a finite number is needed")
    return float(value)


def _vector(value: Any, where: str) -> tuple[float, float, float]:
    if not isinstance(value, list) or len(value) != 3:
        raise ValueError(f"{where} is {_short(value)}; three numbers are needed")
    x, y, z = (_number(number, where) for number in value)
    return x, y, z


def _short(value: Any) -> str:
    text = repr(value)
    return text if len(text) <= 80 else f"{text[:77]}…"


# ---- from rows to a chain --------------------------------------------------------------------------


def _arm(
    description: Description, lengths: Mapping[str, float], name: str, rates: TensorLike | None
) -> Chain:
    rows = description.joints
    options: dict[str, Any] = {
        "name": name,
        "joint_names": [row["name"] for row in rows],
        "lower": [_in_radians(row, "lower", -math.inf) for row in rows],
        "upper": [_in_radians(row, "upper", math.inf) for row in rows],
        "rates": [_in_radians(row, "rate", 1.0) for row in rows] if rates is None else rates,
    }
    base, tool = description.base, description.tool
    if description.form == "dh":
        dh_rows = [_dh_row(row) for row in rows]
        return Chain.from_dh(dh_rows, description.is_modified, base=base, tool=tool, **options)
    if description.form == "frames":
        screws, home = _along_frames(rows, base)
    else:
        screws, home = _along_steps(rows, lengths)
        screws, home = screws @ spatial.adjoint(base).mT, base @ home
    return Chain(screws, home @ tool, **options)


def _along_steps(rows: Sequence[Mapping[str, Any]], lengths: Mapping[str, float]) -> tuple[Tensor, Tensor]:
    point = torch.zeros(3, dtype=torch.float64)
    screws = []
    for row in rows:
        for length, direction in row.get("step", {}).items():
            point = point + lengths[length] * torch.tensor(direction, dtype=torch.float64)
        screws.append(_screw(torch.tensor(row["axis"], dtype=torch.float64), point, row))
    return torch.stack(screws), spatial.pose(torch.eye(3, dtype=torch.float64), point)


def _along_frames(rows: Sequence[Mapping[str, Any]], base: Tensor) -> tuple[Tensor, Tensor]:
    T, screws = base, []
    for row in rows:
        T = T @ _origin(row)
        axis = torch.tensor(row.get("axis", [0, 0, 1]), dtype=torch.float64)
        screws.append(_screw(T[:3, :3] @ axis, T[:3, 3], row))
    return torch.stack(screws), T


def _screw(axis: Tensor, point: Tensor, row: Mapping[str, Any]) -> Tensor:
    if row.get("kind", "revolute") == "prismatic":
        return torch.cat([axis, torch.zeros_like(axis)])
    return torch.cat([torch.linalg.cross(point, axis), axis])


def _origin(table: Mapping[str, Any]) -> Tensor:
    """Pose of ``xyz`` and of ``rpy``, turned about the fixed axes x, then y, then z."""
    T = torch.eye(4, dtype=torch.float64)
    angles = table.get("rpy") or [math.radians(angle) for angle in table.get("rpy_deg", (0.0, 0.0, 0.0))]
    for axis, angle in enumerate(angles):
        i, j = (axis + 1) % 3, (axis + 2) % 3
        turn = torch.eye(4, dtype=torch.float64)
        turn[i, i] = turn[j, j] = math.cos(angle)
        turn[j, i] = math.sin(angle)
        turn[i, j] = -math.sin(angle)
        T = turn @ T
    T[:3, 3] = torch.tensor(table.get("xyz", [0, 0, 0]), dtype=torch.float64)
    return T


def _dh_row(row: Mapping[str, Any]) -> dict[str, float | int | str]:
    return {
        "theta": _in_radians(row, "theta", 0.0),
        "d": row.get("d", 0.0),
        "a": row.get("a", 0.0),
        "alpha": _in_radians(row, "alpha", 0.0),
        "kind": row.get("kind", "revolute"),
    }


def _in_radians(row: Mapping[str, Any], key: str, default: float) -> float:
    if f"{key}_deg" in row:
        return math.radians(row[f"{key}_deg"])
    return float(row.get(key, default))
