"""XML of a URDF: parsed without document types, its values read with errors that name file and place.

Examples
--------
>>> from dexterity.urdf import document
>>> root, file = document.parse("<robot><axis xyz='0 0 2'/></robot>")
>>> document.Values(file).numbers(root[0], "xyz", "joint 'a': axis", 3, "1 0 0")
[0.0, 0.0, 2.0]
"""

from __future__ import annotations

import math
import os
import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import Element, TreeBuilder
from xml.parsers import expat

import numpy as np
from numpy.typing import NDArray

__all__ = ["Array", "Values", "parse"]

Array = NDArray[np.float64]

_LARGEST_FILE = 32 * 2**20  # bytes; the largest robots of public collections have 1 MB


def parse(source: str | os.PathLike[str]) -> tuple[Element, str]:
    """Return the outermost element of a URDF, and what errors call the file.

    Raises
    ------
    ValueError
        If the source is no XML of a robot, is a xacro file, declares a document type, or exceeds 32 MiB.
    TypeError
        If `source` is neither a path nor a text.
    FileNotFoundError
        If there is no such file.
    """
    content, file = _content(source)
    root = _parse(content, file)
    if root.tag != "robot":
        raise ValueError(f"{file} is no URDF: its outermost element is <{root.tag}>; <robot> is needed")
    for element in root.iter():
        if element.tag.startswith("xacro:"):
            raise ValueError(f"{file} holds <{element.tag}>: {_how_to_expand(file)}")
    return root, file


@dataclass(frozen=True)
class Values:
    """Reads the values of a file.

    Attributes
    ----------
    file
        What errors call the file.
    """

    file: str

    def refuse(self, where: str, what: str) -> ValueError:
        """Return an error that names the file and the place."""
        return ValueError(f"{self.file}: {where} {what}")

    def text(self, element: Element, key: str, where: str) -> str:
        """Return an attribute that must be there."""
        value = element.get(key)
        if value is None or not value.strip():
            raise self.refuse(where, f"has no {key}")
        self._check_expanded(value, key, where)
        return value

    def numbers(
        self, element: Element, key: str, where: str, count: int, default: str, infinite: bool = False
    ) -> list[float]:
        """Return an attribute of several numbers, of the default where it is left out."""
        text = element.get(key, default)
        self._check_expanded(text, key, where)
        try:
            values = [_number(word) for word in text.split()]
        except ValueError:
            values = []
        unusable = (math.isnan(x) or (math.isinf(x) and not infinite) for x in values)
        if len(values) != count or any(unusable):
            needed = "a number is" if count == 1 else f"{count} numbers are"
            raise self.refuse(where, f"has {key} {text!r}; {needed} needed")
        return values

    def part(self, element: Element, tag: str, where: str, known: tuple[str, ...] = ()) -> Element | None:
        """Return the element of a tag inside another, None if there is none.

        Raises
        ------
        ValueError
            If there are several, or it holds an attribute beyond those known.
        """
        inside = element.findall(tag)
        if len(inside) > 1:
            raise self.refuse(where, f"has {tag} {len(inside)} times")
        unknown = sorted(set(inside[0].keys()) - set(known)) if inside and known else []
        if unknown:
            raise self.refuse(
                f"{where}: {tag}", f"has {unknown[0]}, which is unknown; {', '.join(known)} are known"
            )
        return inside[0] if inside else None

    def pose(self, element: Element, where: str) -> Array:
        """Return the (4, 4) pose that the origin of an element gives; the identity where it has none."""
        T = np.eye(4)
        origin = self.part(element, "origin", where, ("xyz", "rpy", "quat_xyzw"))
        if origin is None:
            return T
        where = f"{where}: origin"
        angles = self.numbers(origin, "rpy", where, 3, "0 0 0")
        T[:3, :3] = _rotation(*angles)
        if max(map(abs, angles)) > 2 * math.pi:
            said = (
                f"{self.file}: {where} has rpy {origin.get('rpy')!r}, more than a full turn: they are radians"
            )
            warnings.warn(said, stacklevel=2)
        if origin.get("quat_xyzw") is not None:
            if origin.get("rpy") is not None:
                raise self.refuse(where, "has both rpy and quat_xyzw; one of them is needed")
            T[:3, :3] = self._quaternion(origin, where)
        T[:3, 3] = self.numbers(origin, "xyz", where, 3, "0 0 0")
        return T

    def _quaternion(self, origin: Element, where: str) -> Array:
        """Rotation by the unit quaternion of URDF 1.2, whose scalar part comes last."""
        *v, w = self.numbers(origin, "quat_xyzw", where, 4, "0 0 0 1")
        length = math.hypot(*v, w)
        if abs(length - 1) > 1e-3:
            raise self.refuse(
                where, f"has quat_xyzw {origin.get('quat_xyzw')!r} of length {length:g}; 1 is needed"
            )
        x, y, z = (part / length for part in v)
        across = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
        return np.eye(3) + 2 * (w / length * across + across @ across)

    def _check_expanded(self, value: str, key: str, where: str) -> None:
        if "${" in value or "$(" in value:
            raise self.refuse(
                where, f"has {key} {value!r}, which xacro computes: {_how_to_expand(self.file)}"
            )


# ---- the XML ---------------------------------------------------------------------------------------


def _content(source: str | os.PathLike[str]) -> tuple[str | bytes, str]:
    if isinstance(source, str) and "<" in source:
        content: str | bytes = source.removeprefix("\ufeff").lstrip()
        name = "the URDF text"
    elif isinstance(source, str | os.PathLike) and not isinstance(source, bytes):
        path = Path(source)
        if "\0" in str(path) or not str(source).strip():
            raise ValueError(f"source is {str(source)!r}; a path or the text of a URDF is needed")
        name = path.name
        if path.suffix == ".xacro":
            raise ValueError(f"{name} is a xacro file: {_how_to_expand(name)}")
        if not _is_file(path):
            raise FileNotFoundError(f"there is no URDF file {str(source)[:200]}")
        if path.stat().st_size > _LARGEST_FILE:
            raise ValueError(f"{name} has {path.stat().st_size} bytes; at most {_LARGEST_FILE} are read")
        content = path.read_bytes()
    else:
        raise TypeError(f"source is a {type(source).__name__}; a path or the text of a URDF is needed")
    if len(content) > _LARGEST_FILE:
        raise ValueError(f"{name} has {len(content)} characters; at most {_LARGEST_FILE} are read")
    return content, name


def _is_file(path: Path) -> bool:
    try:
        return path.is_file()
    except OSError:  # a name that is too long for the file system
        return False


def _how_to_expand(name: str) -> str:
    expanded = Path(name).name.removesuffix(".xacro").removesuffix(".urdf") if "." in name else "robot"
    given = name if name.endswith(".xacro") else "robot.urdf.xacro"
    return f"expand it first, with `xacro {given} > {expanded}.urdf`"


def _parse(content: str | bytes, name: str) -> Element:
    """Parse without document types: those could declare entities that grow without bound."""
    builder = TreeBuilder()
    parser = expat.ParserCreate()
    parser.buffer_text = True

    def start(tag: str, attributes: dict[str, str]) -> None:
        builder.start(tag, attributes)

    def refuse(*declared: Any) -> None:
        raise ValueError(f"{name} declares a document type (<!DOCTYPE {declared[0]} …>); a URDF has none")

    parser.StartElementHandler = start
    parser.EndElementHandler = builder.end
    parser.StartDoctypeDeclHandler = refuse
    try:
        parser.Parse(content, True)
        return builder.close()
    except expat.ExpatError as error:
        raise ValueError(f"{name} is no URDF: {error}") from error
    except (UnicodeError, AssertionError, LookupError) as error:
        raise ValueError(f"{name} is no URDF: {error}") from error


def _number(word: str) -> float:
    # Python's own notation allows more: digits in groups, other scripts.
    if "_" in word or not word.isascii():
        raise ValueError(word)
    return float(word)


def _rotation(roll: float, pitch: float, yaw: float) -> Array:
    """Rz(yaw) Ry(pitch) Rx(roll), the order of URDF."""
    (cr, sr), (cp, sp), (cy, sy) = ((math.cos(angle), math.sin(angle)) for angle in (roll, pitch, yaw))
    return np.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    )
