r"""Robot files: TOML with a robot's joints, limits and rates, or CSV with a Denavit–Hartenberg table.

A file may have ``name`` (that of the file if left out), ``source``, ``licence`` and ``url``; robots of the
package have all of them. Joints come in one of three forms, one table a joint:

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

A joint of any form may have ``name``, ``kind`` (``"revolute"`` if left out, or ``"prismatic"``), ``lower``,
``upper`` [rad] or [m], and ``rate`` [rad/s] or [m/s]; a revolute joint takes ``lower_deg``, ``upper_deg``
and ``rate_deg`` in their place. ``inertial`` with ``mass`` [kg], ``centre`` [m] and ``inertia`` = [xx, xy,
xz, yy, yz, zz] about the centre [kg m²] is given for all joints or for none, in the frame that the row ends
with: that of the Denavit–Hartenberg row, that of the row of ``[[frames]]``, or world axes at the joint.

Tables ``[base]`` and ``[tool]`` with ``xyz`` and ``rpy`` or ``rpy_deg`` place the first frame in the world
and the tool in the last frame. ``[vehicle]`` puts the robot on a vehicle: ``size`` [m];
``[[vehicle.joints]]`` with ``name``, limits and rates, all six without limits if left out; ``axes`` and
``[vehicle.mount]`` as for :meth:`dexterity.chain.Chain.on_vehicle`; and ``arm``, the name of a robot of the
package, in a file without joints of its own.

A CSV file has a line of names and a line for each joint. Its columns are entries of ``[[dh]]``, in any order,
and may include ``convention``, which is the same for all joints. A cell may be empty; angles may be typed as
``pi/2``. Lines that begin with ``#`` are passed over. A tool and a base are added by
:meth:`~dexterity.chain.Chain.with_tool` and :meth:`~dexterity.chain.Chain.with_base`, or need TOML.

Examples
--------
>>> import pathlib, tempfile
>>> from dexterity import robots
>>> path = pathlib.Path(tempfile.mkdtemp(), "slider.toml")
>>> _ = path.write_text('''[[dh]]
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
>>> table = path.with_name("arm.csv")
>>> _ = table.write_text("d,a,alpha,upper\n0.3,,pi/2,pi\n,0.5,,pi/2\n")
>>> robots.load(table)
Chain('arm', 2 joints, tool at (0.5, 0, 0.3) m)
  joint 1  revolute  -inf to 3.142 rad  1 rad/s
  joint 2  revolute  -inf to 1.571 rad  1 rad/s
"""

from __future__ import annotations

import math
import os
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, TypeAlias, get_args

import torch
from torch import Tensor

from dexterity import checks, spatial, store
from dexterity.chain import Chain, Inertias, JointKind, dh, geometry, mounting
from dexterity.robots import dh_table
from dexterity.spatial import TensorLike
from dexterity.spatial.tolerances import SIX_DIGITS

__all__ = ["Description", "Form", "Vehicle", "build", "describe", "names", "read_description"]

Form: TypeAlias = Literal["joints", "dh", "frames"]
"""The table that a file gives its joints in."""

_TURN = 2 * math.pi


@dataclass(frozen=True)
class Vehicle:
    """A vehicle that carries a robot.

    Attributes
    ----------
    size
        Extent of its body along x, y, z [m].
    joints
        Rows with names, limits and rates; none for six joints without limits.
    axes
        ``"world"`` or ``"body"``.
    mount
        (4, 4) pose of the arm's world frame in the vehicle.
    arm
        Name of the robot of the package that it carries, if the file has no joints itself.
    """

    size: tuple[float, float, float]
    joints: tuple[Mapping[str, Any], ...]
    axes: str
    mount: Tensor
    arm: str | None


@dataclass(frozen=True)
class Description:
    """A robot as its file describes it.

    Attributes
    ----------
    name, source, licence
        What it is called, where its numbers come from, and on what terms; the last two may be empty.
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
    vehicle
        The vehicle that carries the robot.
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
    vehicle: Vehicle | None

    @property
    def vehicle_size(self) -> tuple[float, float, float] | None:
        """Extent of the vehicle's body along x, y, z [m]; None without a vehicle."""
        return None if self.vehicle is None else self.vehicle.size


def names() -> tuple[str, ...]:
    """Names of the serial chains that the package describes; the crane has a module of its own."""
    files = store.data_path("robots").glob("*.toml")
    return tuple(sorted(path.stem for path in files if _is_chain(path)))


def describe(name: str) -> Description:
    """Read the description of one of the package's robots.

    Raises
    ------
    ValueError
        If there is no robot of that name; the nearest names are given.
    TypeError
        If `name` is no text.
    """
    return described(name, "name")


def described(name: str, called: str) -> Description:
    """Read the description of one of the package's robots, whose name is the argument `called`."""
    if not isinstance(name, str):
        raise TypeError(f"{called} is {checks.shown(name)}; the name of a robot is needed")
    path = store.data_path("robots") / f"{name}.toml"
    # Only the robot's own file is read, unless the name is unknown.
    if not re.fullmatch(r"\w{1,100}", name) or not path.is_file() or not _is_chain(path):
        raise ValueError(f"{called} is {checks.shown(name)}; {checks.hint(name, names())}")
    return read_description(path)


def shipped_chain(name: str, called: str = "name") -> Chain:
    """Chain of one of the package's robots, built again only if a file that it was made from has changed."""
    path = store.data_path("robots") / f"{name}.toml"
    chain, contents = _SHIPPED.get(path, (None, {}))
    if chain is None or any(file.read_bytes() != content for file, content in contents.items()):
        description = described(name, called)
        contents = {path: path.read_bytes()}
        chain = build(description)
        if description.vehicle is not None and description.vehicle.arm is not None:
            contents |= _SHIPPED[path.with_stem(description.vehicle.arm)][1]
        _SHIPPED[path] = chain, contents
    return chain


_SHIPPED: dict[Path, tuple[Chain, dict[Path, bytes]]] = {}
"""Chains, which cannot be changed, and contents of the files that they were made from, by robot file."""


def _is_chain(path: Path) -> bool:
    content = store.read_toml(path)
    return not set(get_args(Form)).isdisjoint(content) or "arm" in content.get("vehicle", {})


def read_description(path: Path | str) -> Description:
    """Read a robot file, in the format that :mod:`dexterity.robots.description` explains.

    Raises
    ------
    ValueError
        If the file is neither TOML nor CSV, or an entry is missing, unknown, of the wrong kind or
        contradicts another one; the error names the file and the entry.
    TypeError
        If `path` is no path.
    FileNotFoundError
        If there is no such file.
    """
    if not isinstance(path, str | os.PathLike):
        raise TypeError(f"path is {checks.shown(path)}; the path of a robot file is needed")
    path = Path(path)
    try:
        with torch.device("cpu"):
            is_table = path.suffix.lower() == ".csv"
            content = dh_table.read(path, _ROW["dh"] | _LIMITS) if is_table else store.read_toml(path)
            return _description({"name": path.stem, **content})
    except (ValueError, TypeError, OverflowError) as error:
        raise ValueError(f"{path.name} is not a robot file: {error}") from error


def build(
    description: Description,
    lengths: Mapping[str, float] | None = None,
    *,
    variant: str | None = None,
    rates: TensorLike | None = None,
    arm: Chain | None = None,
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
        (n,) largest rates of all joints of the chain, [m/s] and [rad/s]; those of the file by default, 1
        where it has none.
    arm
        Arm in place of the one that the description's vehicle carries.

    Raises
    ------
    ValueError
        If a length or the variant is unknown, a length is not finite, `rates` does not fit, or `arm` is given
        for a description without a vehicle.
    TypeError
        If an argument is of another type.
    """
    if not isinstance(description, Description):
        raise TypeError(f"description is {checks.shown(description)}; read_description or describe gives one")
    chosen, title = _chosen_lengths(description, lengths, variant)
    with torch.device("cpu"):
        if arm is None:
            arm = _arm(description, chosen, title)
        elif not isinstance(arm, Chain):
            raise TypeError(f"arm is {checks.shown(arm)}; a Chain is needed")
        elif description.vehicle is None:
            raise ValueError(f"arm is given, and {description.name} is no vehicle")
        chain = arm if description.vehicle is None else _on_vehicle(arm, description.vehicle, title)
    return chain if rates is None else chain.with_limits(rates=rates)


def _chosen_lengths(
    description: Description, lengths: Mapping[str, float] | None, variant: str | None
) -> tuple[dict[str, float], str]:
    """Lengths of a variant with those that the caller replaces, and the name of the chain."""
    if lengths is not None and not isinstance(lengths, Mapping):
        raise TypeError(f"lengths is {checks.shown(lengths)}; a mapping from names to lengths is needed")
    chosen = dict(description.lengths)
    title = description.name
    if variant is not None:
        checks.choice(variant, "variant", description.variants)
        chosen |= {k: float(v) for k, v in description.variants[variant].items() if k != "note"}
        title = f"{title} ({variant})"
    for key, value in (lengths or {}).items():
        if key not in chosen:
            raise ValueError(f"lengths holds {checks.shown(key)}; {checks.hint(str(key), chosen)}")
        length = spatial.to_float64(value, f"lengths[{key!r}]")
        if length.ndim:
            raise ValueError(f"lengths[{key!r}] has shape {tuple(length.shape)}; a number is needed")
        chosen[key] = float(length)
    return chosen, title


# ---- reading ---------------------------------------------------------------------------------------

_FILE = {"name", "source", "licence", "url", "vehicle", "base", "tool"}
_LIMITS = {"lower", "upper", "rate", "lower_deg", "upper_deg", "rate_deg"}
_ROW: dict[str, set[str]] = {
    "joints": {"axis", "step"},
    "dh": {"theta", "theta_deg", "d", "a", "alpha", "alpha_deg"},
    "frames": {"xyz", "rpy", "rpy_deg", "axis"},
}
_VECTORS = {"axis", "xyz", "rpy", "rpy_deg"}


def _description(content: Mapping[str, Any]) -> Description:
    form: Form = next((form for form in ("dh", "frames") if form in content), "joints")
    extra = {"joints": {"lengths", "variants"}, "dh": {"convention"}, "frames": set[str]()}[form]
    _refuse_unknown(content, _FILE | {form} | extra, "the file")
    convention = content.get("convention", "standard")
    if convention not in ("standard", "modified"):
        raise ValueError(f"convention is {checks.shown(convention)}; standard or modified is needed")
    lengths = _numbers(content.get("lengths", {}), "lengths")
    vehicle = None if "vehicle" not in content else _vehicle(content["vehicle"])
    carries = vehicle is not None and vehicle.arm is not None
    if carries and form in content:
        raise ValueError(f"vehicle has an arm and the file has {form}; one of them is needed")
    description = Description(
        name=_text(content, "name", "the file"),
        source=_text(content, "source", "the file") if "source" in content else "",
        licence=_text(content, "licence", "the file") if "licence" in content else "",
        form=form,
        joints=() if carries else _rows(content, form, lengths),
        is_modified=convention == "modified",
        lengths=lengths,
        variants=_variants(content.get("variants", {}), lengths),
        base=_pose(content.get("base", {}), "base"),
        tool=_pose(content.get("tool", {}), "tool"),
        vehicle=vehicle,
    )
    for variant in (None, *description.variants):
        build(description, variant=variant)
    return description


def _vehicle(value: Any) -> Vehicle:
    vehicle = _table(value, "vehicle")
    _refuse_unknown(vehicle, {"size", "joints", "axes", "mount", "arm"}, "vehicle")
    x, y, z = _vector(_required(vehicle, "size", "vehicle"), "size of vehicle")
    if min(x, y, z) <= 0:
        raise ValueError(f"size of vehicle is {[x, y, z]}; three positive lengths are needed")
    rows = vehicle.get("joints", [])
    if not isinstance(rows, list):
        raise ValueError(f"joints of vehicle is {checks.shown(rows)}; one table a joint is needed")
    for i, row in enumerate(rows):
        where = f"joint {i + 1} of vehicle"
        name = _text(_table(row, where), "name", where)
        _refuse_unknown(row, {"name"} | _LIMITS, where)
        for key in set(row) - {"name"}:
            _number(row[key], f"{key} of {where}")
        slides = mounting.vehicle_joints([name], "world").screws[0, :3].any()
        _check_angles(row, "prismatic" if slides else "revolute", where)
    return Vehicle(
        size=(x, y, z),
        joints=tuple(rows),
        axes=vehicle.get("axes", "world"),
        mount=_pose(vehicle.get("mount", {}), "mount of vehicle"),
        arm=_text(vehicle, "arm", "vehicle") if "arm" in vehicle else None,
    )


def _rows(content: Mapping[str, Any], form: Form, lengths: Mapping[str, float]) -> tuple[dict[str, Any], ...]:
    rows = _required(content, form, "the file")
    if not isinstance(rows, list) or not rows:
        raise ValueError(f"{form} is {checks.shown(rows)}; one table a joint is needed")
    for i, row in enumerate(rows):
        where = f"joint {i + 1}"
        if "name" in _table(row, where):
            _text(row, "name", where)
        kind = row.get("kind", "revolute")
        if kind not in get_args(JointKind):
            raise ValueError(f"kind of {where} is {checks.shown(kind)}; {get_args(JointKind)} are known")
        _refuse_unknown(row, {"name", "kind", "inertial"} | _LIMITS | _ROW[form], where)
        for key in set(row) - {"name", "kind", "step", "inertial"}:
            (_vector if key in _VECTORS else _number)(row[key], f"{key} of {where}")
        _check_axis(row, where)
        _check_inertial(row, where, "inertial" in rows[0])
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
            raise ValueError(f"{where} is prismatic and holds {in_degrees}; {key} in metres is needed")
    for key in ("theta", "alpha"):
        if key in row and not abs(row[key]) <= _TURN:
            raise ValueError(f"{key} of {where} is {row[key]} rad, more than a turn; {key}_deg takes degrees")


def _check_axis(row: Mapping[str, Any], where: str) -> None:
    length = math.hypot(*row.get("axis", [1]))
    if abs(length - 1) > SIX_DIGITS:
        raise ValueError(f"axis of {where} is {row['axis']}, of length {length:.6g}; 1 is needed")


def _check_inertial(row: Mapping[str, Any], where: str, needed: bool) -> None:
    if ("inertial" in row) != needed:
        raise ValueError(f"{where} has {'no' if needed else 'an'} inertial; all joints need one, or none")
    if not needed:
        return
    inertial = _table(row["inertial"], f"inertial of {where}")
    _refuse_unknown(inertial, {"mass", "centre", "inertia"}, f"inertial of {where}")
    if _number(_required(inertial, "mass", f"inertial of {where}"), f"mass of {where}") < 0:
        raise ValueError(f"mass of {where} is {inertial['mass']}; it must not be negative")
    _vector(_required(inertial, "centre", f"inertial of {where}"), f"centre of {where}")
    _vector(_required(inertial, "inertia", f"inertial of {where}"), f"inertia of {where}", 6)


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


def _refuse_unknown(entries: Mapping[str, Any], known: set[str], where: str) -> None:
    if unknown := sorted(set(entries) - known):
        hint = checks.hint(unknown[0], sorted(known))
        raise ValueError(f"{where} holds {checks.shown(unknown)}; {hint}")


def _required(entries: Mapping[str, Any], key: str, where: str) -> Any:
    if key not in entries:
        raise ValueError(f"{where} has no {key}")
    return entries[key]


def _table(value: Any, where: str) -> Mapping[str, Any]:
    if not isinstance(value, Mapping):
        raise ValueError(f"{where} is {checks.shown(value)}; a table is needed")
    return value


def _text(entries: Mapping[str, Any], key: str, where: str) -> str:
    value = _required(entries, key, where)
    if not isinstance(value, str) or not value.strip():
        raise ValueError(f"{key} of {where} is {checks.shown(value)}; a text is needed")
    return value


def _numbers(values: Any, where: str) -> dict[str, float]:
    return {key: _number(value, f"{key} of {where}") for key, value in _table(values, where).items()}


def _number(value: Any, where: str) -> float:
    # bool is a kind of int, but true is no number.
    if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) < math.inf:
        raise ValueError(f"{where} is {checks.shown(value)}; a finite number is needed")
    return float(value)


def _vector(value: Any, where: str, count: int = 3) -> tuple[float, ...]:
    if not isinstance(value, list) or len(value) != count:
        raise ValueError(
            f"{where} is {checks.shown(value)}; {'three' if count == 3 else count} numbers are needed"
        )
    return tuple(_number(number, where) for number in value)


# ---- from rows to a chain --------------------------------------------------------------------------


def _arm(description: Description, lengths: Mapping[str, float], name: str) -> Chain:
    if description.vehicle is not None and description.vehicle.arm is not None:
        return shipped_chain(description.vehicle.arm)
    rows = description.joints
    if description.form == "dh":
        dh_rows = [_dh_row(row) for row in rows]
        screws, frames = dh.screws_and_frames(dh_rows, description.base, description.is_modified)
    elif description.form == "frames":
        screws, frames = _along_frames(rows, description.base)
    else:
        screws, frames = _along_steps(rows, lengths, description.base)
    geometry.warn_of_millimetres(name, screws, frames[-1], description.base)
    return Chain(
        screws,
        frames[-1] @ description.tool,
        name=name,
        joint_names=[row.get("name", f"joint {i}") for i, row in enumerate(rows, 1)],
        lower=[_in_radians(row, "lower", -math.inf) for row in rows],
        upper=[_in_radians(row, "upper", math.inf) for row in rows],
        rates=[_in_radians(row, "rate", 1.0) for row in rows],
        inertias=_inertias(rows, torch.stack(frames)) if "inertial" in rows[0] else None,
    )


def _on_vehicle(arm: Chain, vehicle: Vehicle, name: str) -> Chain:
    rows = vehicle.joints
    if not rows:
        return arm.on_vehicle(vehicle.mount, axes=vehicle.axes, name=name)
    return arm.on_vehicle(
        vehicle.mount,
        joints=[row["name"] for row in rows],
        axes=vehicle.axes,
        lower=[_in_radians(row, "lower", -math.inf) for row in rows],
        upper=[_in_radians(row, "upper", math.inf) for row in rows],
        rates=[_in_radians(row, "rate", 1.0) for row in rows],
        name=name,
    )


def _along_steps(
    rows: Sequence[Mapping[str, Any]], lengths: Mapping[str, float], base: Tensor
) -> tuple[Tensor, tuple[Tensor, ...]]:
    """Screws, and a frame with world axes at each joint."""
    point = torch.zeros(3, dtype=torch.float64)
    screws, frames = [], []
    for row in rows:
        for length, direction in row.get("step", {}).items():
            point = point + lengths[length] * torch.tensor(direction, dtype=torch.float64)
        screws.append(_screw(torch.tensor(row["axis"], dtype=torch.float64), point, row))
        frames.append(base @ spatial.pose(torch.eye(3, dtype=torch.float64), point))
    at_base = torch.stack(screws)
    # A product with the identity would change signs of zeros, which content keys count.
    moved = not torch.equal(base, torch.eye(4, dtype=torch.float64))
    return at_base @ spatial.adjoint(base).mT if moved else at_base, tuple(frames)


def _along_frames(rows: Sequence[Mapping[str, Any]], base: Tensor) -> tuple[Tensor, tuple[Tensor, ...]]:
    """Screws, and the frame that each row ends with."""
    T, screws, frames = base, [], []
    for row in rows:
        T = T @ _origin(row)
        axis = torch.tensor(row.get("axis", [0, 0, 1]), dtype=torch.float64)
        screws.append(_screw(T[:3, :3] @ axis, T[:3, 3], row))
        frames.append(T)
    return torch.stack(screws), tuple(frames)


def _inertias(rows: Sequence[Mapping[str, Any]], frames: Tensor) -> Inertias:
    """Masses of the links at home in the world, from those in the frames of their rows."""
    numbers = [row["inertial"] for row in rows]
    xx, xy, xz, yy, yz, zz = torch.tensor([each["inertia"] for each in numbers], dtype=torch.float64).unbind(
        1
    )
    in_frames = Inertias(
        torch.tensor([each["mass"] for each in numbers], dtype=torch.float64),
        torch.tensor([each["centre"] for each in numbers], dtype=torch.float64),
        torch.stack([xx, xy, xz, xy, yy, yz, xz, yz, zz], dim=1).reshape(-1, 3, 3),
    )
    if strange := in_frames.no_body():
        raise ValueError(strange)
    return in_frames.moved(frames)


def _screw(axis: Tensor, point: Tensor, row: Mapping[str, Any]) -> Tensor:
    if row.get("kind", "revolute") == "prismatic":
        return torch.cat([axis, torch.zeros_like(axis)])
    return torch.cat([torch.linalg.cross(point, axis), axis])


def _origin(table: Mapping[str, Any]) -> Tensor:
    angles = table.get("rpy") or [math.radians(angle) for angle in table.get("rpy_deg", (0.0, 0.0, 0.0))]
    return spatial.from_rpy(angles, table.get("xyz", (0.0, 0.0, 0.0)))


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
