"""Robots described in ``data/robots/*.toml``: parameters with their source and licence.

A description gives its joints either by axes, each one step after the joint before it, or by
standard Denavit–Hartenberg rows. A step is a sum of named lengths times directions, so that a length
can be changed by name: ``uvms(l2=0.5)``.

Examples
--------
>>> import dexterity as dx
>>> dx.robots.names()
('docking_arm', 'fanuc_am120ib', 'puma560', 'uvms')
>>> dx.robots.puma560().joint_names
('waist', 'shoulder', 'elbow', 'wrist roll', 'wrist pitch', 'flange')
>>> dx.robots.uvms(l2=0.5).home[:3, 3].tolist()
[0.0, 1.65, 0.0]
"""

from __future__ import annotations

import difflib
import math
import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, get_args

import torch
from torch import Tensor

from dexterity import spatial, store
from dexterity.chain import Chain, JointKind
from dexterity.spatial import TensorLike

__all__ = ["Description", "build", "describe", "docking_arm", "names", "puma560", "read_description", "uvms"]


def uvms(
    *,
    l1: float | None = None,
    l2: float | None = None,
    l3: float | None = None,
    y_MB: float | None = None,
    rates: TensorLike | None = None,
) -> Chain:
    """Twelve-joint underwater vehicle-manipulator system of paper A.

    Parameters
    ----------
    l1, l2, l3
        Base to shoulder (0), shoulder to elbow (0.6) and elbow to wrist (0.4), [m].
    y_MB
        Centre of gravity to the arm's base (0.75), [m].
    rates
        (12,) largest joint rates, [m/s] and [rad/s]; all 1 by default.

    References
    ----------
    Sotiropoulos & Aspragathos (2016), section 2.1 and Table 2. The paper prints neither l1, l2, l3 nor
    the velocity limits; the defaults are the book's assumptions.
    """
    lengths = {"l1": l1, "l2": l2, "l3": l3, "y_MB": y_MB}
    return build(describe("uvms"), {k: v for k, v in lengths.items() if v is not None}, rates=rates)


def docking_arm(variant: Literal["stated", "fitted"] = "stated") -> Chain:
    """Six-joint elbow arm of paper B.

    Parameters
    ----------
    variant
        ``"stated"``: the lengths that the paper gives. ``"fitted"``: lengths inferred from the joint
        angles of its Table 4, which the stated arm does not reproduce.

    References
    ----------
    Sotiropoulos, Aspragathos & Andritsos (2011), section IV, Table 1.
    """
    return build(describe("docking_arm"), variant=None if variant == "stated" else variant)


def puma560() -> Chain:
    """Unimation PUMA 560, tool point at the wrist centre, base frame at the shoulder.

    References
    ----------
    Corke & Armstrong-Hélouvry (1994), A search for consensus among model parameters reported for the
    PUMA 560 robot.
    """
    return build(describe("puma560"))


@dataclass(frozen=True)
class Description:
    """A robot as its file describes it.

    Attributes
    ----------
    name, source, licence
        What it is called, where its numbers come from, and on what terms.
    joints
        Rows of the file, either with ``axis`` or Denavit–Hartenberg rows.
    is_dh
        Whether the rows are Denavit–Hartenberg rows.
    lengths
        Named lengths [m] that steps refer to.
    variants
        Other sets of lengths, by name, with a ``note``.
    vehicle_size
        Extent of the vehicle's body along x, y, z [m], for a robot that rides on one.
    """

    name: str
    source: str
    licence: str
    joints: tuple[Mapping[str, Any], ...]
    is_dh: bool
    lengths: Mapping[str, float]
    variants: Mapping[str, Mapping[str, float | str]]
    vehicle_size: tuple[float, float, float] | None


def names() -> tuple[str, ...]:
    """Names of the serial chains that the package describes; the crane has a module of its own."""
    files = store.data_path("robots").glob("*.toml")
    return tuple(sorted(path.stem for path in files if _has_joints(path)))


def _has_joints(path: Path) -> bool:
    return not {"joints", "dh"}.isdisjoint(tomllib.loads(path.read_text(encoding="utf-8")))


def describe(name: str) -> Description:
    """Read the description of one of the package's robots.

    Raises
    ------
    ValueError
        If there is no robot of that name; the nearest names are given.
    """
    path = store.data_path("robots") / f"{name}.toml"
    # Only its own file is read, unless the name is unknown.
    if Path(name).name != name or not path.is_file() or not _has_joints(path):
        raise ValueError(f"name is {name!r}; {_nearest(name, names())}")
    return read_description(path)


def _nearest(name: str, known: Iterable[str]) -> str:
    near = difflib.get_close_matches(name, known := list(known), n=3, cutoff=0.3) or sorted(known)
    return f"there is no such one. Nearest: {', '.join(near) or 'none'}"


def read_description(path: Path | str) -> Description:
    """Read a robot file.

    Raises
    ------
    ValueError
        If the file is no TOML, or an entry is missing, unknown or of the wrong kind; the error names
        the file and the entry.
    """
    path = Path(path)
    try:
        content = tomllib.loads(path.read_text(encoding="utf-8"))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise ValueError(f"{path.name} is not a robot file: {error}") from error
    try:
        return _description(content)
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
        What :func:`describe` or :func:`read_description` returns.
    lengths
        Lengths [m] that replace the description's, by name.
    variant
        Name of one of the description's variants.
    rates
        Largest joint rates, vehicle joints first, [m/s] and [rad/s]; 1 by default.

    Raises
    ------
    ValueError
        If a length or the variant is unknown, or a length is not finite.
    """
    chosen = dict(description.lengths)
    title = description.name
    if variant is not None:
        if variant not in description.variants:
            raise ValueError(f"variant is {variant!r}; {_nearest(variant, description.variants)}")
        chosen |= {k: float(v) for k, v in description.variants[variant].items() if k != "note"}
        title = f"{title} ({variant})"
    for key, value in (lengths or {}).items():
        if key not in chosen:
            raise ValueError(f"lengths holds {key!r}; {_nearest(key, chosen)}")
        chosen[key] = float(spatial.to_float64(value, f"lengths[{key!r}]"))

    vehicle_rates, arm_rates = None, rates
    if rates is not None and description.vehicle_size is not None:
        rates = spatial.to_float64(rates, "rates")
        joints = 6 + len(description.joints)
        if rates.shape != (joints,):
            raise ValueError(f"rates has shape {tuple(rates.shape)}; ({joints},) is needed")
        vehicle_rates, arm_rates = rates[:6], rates[6:]
    arm = _arm(description, chosen, title, arm_rates)
    if description.vehicle_size is None:
        return arm
    return arm.on_vehicle(torch.eye(4, dtype=torch.float64), name=title, rates=vehicle_rates)


_ENTRIES = {"name", "source", "licence", "url", "vehicle"}
_JOINT_ENTRIES = {"name", "kind", "axis", "step", "lower", "upper"}
_DH_ENTRIES = {"name", "kind", "theta_deg", "d", "a", "alpha_deg", "lower_deg", "upper_deg", "lower", "upper"}


def _description(content: Mapping[str, Any]) -> Description:
    is_dh = "dh" in content
    rows_entry = "dh" if is_dh else "joints"
    _refuse_unknown(content, _ENTRIES | ({"dh"} if is_dh else {"joints", "lengths", "variants"}), "the file")
    lengths = _numbers(content.get("lengths", {}), "lengths")
    vehicle = None if "vehicle" not in content else _table(content["vehicle"], "vehicle")
    if vehicle is not None:
        _refuse_unknown(vehicle, {"size"}, "vehicle")
    description = Description(
        name=_text(content, "name", "the file"),
        source=_text(content, "source", "the file"),
        licence=_text(content, "licence", "the file"),
        joints=_rows(content, rows_entry, lengths),
        is_dh=is_dh,
        lengths=lengths,
        variants=_variants(content.get("variants", {}), lengths),
        vehicle_size=None if vehicle is None else _vector(_required(vehicle, "size", "vehicle"), "size"),
    )
    for variant in (None, *description.variants):
        build(description, variant=variant)
    return description


def _rows(
    content: Mapping[str, Any], entry: str, lengths: Mapping[str, float]
) -> tuple[Mapping[str, Any], ...]:
    rows = _required(content, entry, "the file")
    if not isinstance(rows, list) or not rows:
        raise ValueError(f"{entry} is {rows!r}; one table a joint is needed")
    for i, row in enumerate(rows):
        where = f"joint {i + 1}"
        _text(_table(row, where), "name", where)
        if row.get("kind", "revolute") not in get_args(JointKind):
            raise ValueError(f"kind of {where} is {row['kind']!r}; {get_args(JointKind)} are known")
        if entry == "dh":
            _refuse_unknown(row, _DH_ENTRIES, where)
        else:
            _refuse_unknown(row, _JOINT_ENTRIES, where)
            _check_step_and_axis(row, where, lengths)
        for key in set(row) - {"name", "kind", "axis", "step"}:
            _number(row[key], f"{key} of {where}")
    return tuple(rows)


def _check_step_and_axis(row: Mapping[str, Any], where: str, lengths: Mapping[str, float]) -> None:
    _vector(_required(row, "axis", where), f"axis of {where}")
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


def _refuse_unknown(entries: Mapping[str, Any], known: set[str], where: str) -> None:
    unknown = sorted(set(entries) - known)
    if unknown:
        raise ValueError(f"{where} holds {unknown}; {sorted(known)} are known")


def _required(entries: Mapping[str, Any], key: str, where: str) -> Any:
    if key not in entries:
        raise ValueError(f"{where} has no {key}")
    return entries[key]


def _table(value: Any, where: str) -> Mapping[str, Any]:
    if not isinstance(value, Mapping):
        raise ValueError(f"{where} is {value!r}; a table is needed")
    return value


def _text(entries: Mapping[str, Any], key: str, where: str) -> str:
    value = _required(entries, key, where)
    if not isinstance(value, str) or not value.strip():
        raise ValueError(f"{key} of {where} is {value!r}; a text is needed")
    return value


def _numbers(values: Any, where: str) -> dict[str, float]:
    return {key: _number(value, f"{key} of {where}") for key, value in _table(values, where).items()}


def _number(value: Any, where: str) -> float:
    # bool is a kind of int, but true is no number.
    if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) < math.inf:
        raise ValueError(f"{where} is {value!r}; a finite number is needed")
    return float(value)


def _vector(value: Any, where: str) -> tuple[float, float, float]:
    if not isinstance(value, list) or len(value) != 3:
        raise ValueError(f"{where} is {value!r}; three numbers are needed")
    x, y, z = (_number(number, where) for number in value)
    return x, y, z


def _arm(
    description: Description, lengths: Mapping[str, float], name: str, rates: TensorLike | None
) -> Chain:
    rows = description.joints
    limits: dict[str, Any] = {
        "name": name,
        "joint_names": [row["name"] for row in rows],
        "lower": [_limit(row, "lower", -math.inf) for row in rows],
        "upper": [_limit(row, "upper", math.inf) for row in rows],
        "rates": rates,
    }
    if description.is_dh:
        return Chain.from_dh([_dh_row(row) for row in rows], **limits)
    return Chain(*_screws_and_home(rows, lengths), **limits)


def _screws_and_home(
    rows: tuple[Mapping[str, Any], ...], lengths: Mapping[str, float]
) -> tuple[Tensor, Tensor]:
    point = torch.zeros(3, dtype=torch.float64)
    screws = []
    for row in rows:
        for length, direction in row.get("step", {}).items():
            point = point + lengths[length] * torch.tensor(direction, dtype=torch.float64)
        axis = torch.tensor(row["axis"], dtype=torch.float64)
        if row.get("kind", "revolute") == "prismatic":
            screws.append(torch.cat([axis, torch.zeros_like(axis)]))
        else:
            screws.append(torch.cat([torch.linalg.cross(point, axis), axis]))
    return torch.stack(screws), spatial.pose(torch.eye(3, dtype=torch.float64), point)


def _dh_row(row: Mapping[str, Any]) -> dict[str, float | int | str]:
    return {
        "theta": math.radians(row.get("theta_deg", 0.0)),
        "d": row.get("d", 0.0),
        "a": row.get("a", 0.0),
        "alpha": math.radians(row.get("alpha_deg", 0.0)),
        "kind": row.get("kind", "revolute"),
    }


def _limit(row: Mapping[str, Any], side: str, default: float) -> float:
    if f"{side}_deg" in row:
        return math.radians(row[f"{side}_deg"])
    return float(row.get(side, default))
