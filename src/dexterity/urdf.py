"""Serial chains out of URDF files: the joints between two links, with their limits, rates and inertias.

Only the path from the base link to the tip link is read in detail. Whatever lies beside it may be of any
kind, since it does not change the kinematics of the path. Its mass counts: a link beside the path moves
with the path's link that carries it, all joints beside the path at zero.

Examples
--------
>>> from dexterity import urdf
>>> text = '''<robot name="slider"><link name="rail"/><link name="carriage"/>
...   <joint name="slide" type="prismatic"><parent link="rail"/><child link="carriage"/>
...     <axis xyz="2 0 0"/><limit lower="0" upper="0.5" velocity="0.2"/></joint></robot>'''
>>> path = urdf.read(text).path()
>>> path.joint_names, path.screws.tolist(), path.upper
(('slide',), [[1.0, 0.0, 0.0, 0.0, 0.0, 0.0]], (0.5,))
"""

from __future__ import annotations

import math
import os
import warnings
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import Element, TreeBuilder
from xml.parsers import expat

import numpy as np
from numpy.typing import NDArray

__all__ = ["Model", "SerialPath", "read"]

_LARGEST_FILE = 32 * 2**20  # bytes; the largest robots of public collections have 1 MB
_MOVING = ("revolute", "continuous", "prismatic")
_OTHER = ("fixed", "floating", "planar")

Array = NDArray[np.float64]


@dataclass(frozen=True)
class SerialPath:
    """Moving joints between two links of a URDF, in the frame of the base link with all joints at zero.

    Attributes
    ----------
    name
        Name of the robot.
    joint_names
        n names of the joints.
    screws
        (n, 6) rows [v; ω], as for :class:`dexterity.chain.Chain`.
    home
        (4, 4) pose of the tip link in the base link.
    lower, upper
        Joint limits, [rad] or [m]; infinite for continuous joints.
    rates
        Largest joint rates, [rad/s] or [m/s]; 1 where the file has none.
    inertias
        Mass [kg], centre of mass [m] and inertia about it [kg m²] of all that moves with each joint but not
        with the next, in the frame of the base link; None if the file gives no mass to what moves.
    """

    name: str
    joint_names: tuple[str, ...]
    screws: Array
    home: Array
    lower: tuple[float, ...]
    upper: tuple[float, ...]
    rates: tuple[float, ...]
    inertias: tuple[Array, Array, Array] | None


@dataclass(frozen=True)
class _Joint:
    """A joint as the file has it; its numbers are read when they are needed."""

    name: str
    type: str
    parent: str
    child: str
    element: Element


@dataclass(frozen=True)
class Model:
    """A URDF that has been read: links and joints by name.

    Attributes
    ----------
    name
        Name of the robot.
    links
        Names of all links, in the order of the file.
    """

    name: str
    links: tuple[str, ...]
    _source: str
    _joints: tuple[_Joint, ...]
    _link_elements: tuple[Element, ...]

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Names of all joints, in the order of the file."""
        return tuple(joint.name for joint in self._joints)

    @property
    def roots(self) -> tuple[str, ...]:
        """Links that are no joint's child."""
        children = {joint.child for joint in self._joints}
        return tuple(link for link in self.links if link not in children)

    def leaves(self, base: str | None = None) -> tuple[str, ...]:
        """Links without a joint behind them that `base`, by default any root, carries by a moving joint."""
        parents = {joint.parent for joint in self._joints}
        carried: set[str] = set().union(*map(self._moved_by, self.roots if base is None else (base,)))
        return tuple(link for link in self.links if link in carried and link not in parents)

    def path(self, base: str | None = None, tip: str | None = None) -> SerialPath:
        """Return the moving joints from one link to another.

        Parameters
        ----------
        base
            Name of the link that stands still; the only link without a parent by default.
        tip
            Name of the link that carries the tool; the only moving link without children by default. It may
            lie anywhere in the tree: a joint that is passed from its child to its parent moves the other way.

        Raises
        ------
        ValueError
            If a link is unknown or not connected, the choice of base or tip is open, or the path holds a
            joint that is neither fixed, revolute, continuous nor prismatic, a joint that mimics another, a
            closed loop, two joints or links of one name, or a value that is missing or out of range. The
            error names the file, the joint and the attribute.
        """
        base = self._link_or_only(base, "base", self.roots, "links without a parent")
        tip = self._link_or_only(tip, "tip", self.leaves(base), "moving links at an end")
        return _SerialReader(self, base, tip).path()

    def refuse(self, where: str, what: str) -> ValueError:
        """Return an error that names the file."""
        return ValueError(f"{self._source}: {where} {what}")

    def _link_or_only(self, link: str | None, role: str, choices: Sequence[str], described: str) -> str:
        if link is None:
            if len(choices) != 1:
                have = f"{len(choices)} {described}: {', '.join(choices)}" if choices else f"no {described}"
                raise ValueError(f"{self._source} has {have}; name the {role}")
            return choices[0]
        if not isinstance(link, str):
            raise TypeError(f"{role} is {link!r}; the name of a link is needed")
        if link not in self.links:
            raise ValueError(f"{role} is {link!r}; {self._source} has the links {', '.join(self.links)}")
        return link

    def _moved_by(self, base: str) -> set[str]:
        """Links that reach `base` over at least one joint that is not fixed."""
        children: dict[str, list[_Joint]] = {}
        for joint in self._joints:
            children.setdefault(joint.parent, []).append(joint)
        moves = {base: False}
        waiting = [base]
        while waiting:
            link = waiting.pop()
            for joint in children.get(link, ()):
                if joint.child not in moves:
                    moves[joint.child] = moves[link] or joint.type != "fixed"
                    waiting.append(joint.child)
        return {link for link, moved in moves.items() if moved}


def read(source: str | os.PathLike[str]) -> Model:
    """Read a URDF.

    Parameters
    ----------
    source
        Path of a file, or the text itself: a string that holds ``<``.

    Raises
    ------
    ValueError
        If the source is no URDF, is a xacro file, declares a document type or entities, or is larger than
        32 MiB.
    TypeError
        If `source` is neither a path nor a text.
    FileNotFoundError
        If there is no such file.
    """
    content, name = _content(source)
    root = _parse(content, name)
    if root.tag != "robot":
        raise ValueError(f"{name} is no URDF: its outermost element is <{root.tag}>; <robot> is needed")
    for element in root.iter():
        if element.tag.startswith("xacro:"):
            raise ValueError(f"{name} holds <{element.tag}>: {_how_to_expand(name)}")
    links = tuple(root.findall("link"))
    joints = tuple(_joint(element, name) for element in root.findall("joint"))
    names = tuple(_attribute(link, "name", f"{name}: a link", name) for link in links)
    if not links:
        raise ValueError(f"{name} is no URDF: it has no link")
    return Model(root.get("name") or "robot", names, name, joints, links)


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


def _attribute(element: Element, key: str, where: str, file: str) -> str:
    value = element.get(key)
    if value is None or not value.strip():
        raise ValueError(f"{where} has no {key}")
    if "${" in value or "$(" in value:
        raise ValueError(f"{where} has {key} {value!r}, which xacro computes: {_how_to_expand(file)}")
    return value


def _joint(element: Element, file: str) -> _Joint:
    name = _attribute(element, "name", f"{file}: a joint", file)
    where = f"{file}: joint {name!r}"
    ends = []
    for end in ("parent", "child"):
        inside = element.find(end)
        if inside is None:
            raise ValueError(f"{where} has no {end}")
        ends.append(_attribute(inside, "link", f"{where}: {end}", file))
    return _Joint(name, _attribute(element, "type", where, file), ends[0], ends[1], element)


# ---- from the base to the tip ------------------------------------------------------------------------


@dataclass(frozen=True)
class _Step:
    """A joint of the path and whether it is passed from its parent to its child."""

    joint: _Joint
    forwards: bool

    @property
    def end(self) -> str:
        return self.joint.child if self.forwards else self.joint.parent


class _SerialReader:
    """Follows a path through a model and reads the numbers on it."""

    def __init__(self, model: Model, base: str, tip: str) -> None:
        self._model, self._base, self._tip = model, base, tip
        self._by_child: dict[str, list[_Joint]] = {}
        for joint in model._joints:
            self._by_child.setdefault(joint.child, []).append(joint)
        self._steps = self._find_steps()

    def path(self) -> SerialPath:
        self._check_names()
        T = np.eye(4)
        moving: list[tuple[_Joint, Array]] = []
        at_home = {self._base: T}
        carrier = {self._base: -1}
        for step in self._steps:
            joint, origin = step.joint, self._origin(step.joint)
            self._check_kind(joint)
            T = T @ origin if step.forwards else T
            if joint.type != "fixed":
                moving.append((joint, self._screw(joint, T, step.forwards)))
            T = T if step.forwards else T @ _inverse(origin)
            at_home[step.end], carrier[step.end] = T, len(moving) - 1
        if not moving:
            raise self._model.refuse(f"the path from {self._base} to {self._tip}", "has no joint that moves")
        limits = [self._limits(joint) for joint, _ in moving]
        lower, upper, rates = zip(*limits, strict=True)
        return SerialPath(
            name=self._model.name,
            joint_names=tuple(joint.name for joint, _ in moving),
            screws=np.array([screw for _, screw in moving]),
            home=T,
            lower=lower,
            upper=upper,
            rates=rates,
            inertias=self._inertias(at_home, carrier, len(moving)),
        )

    # ---- structure ----

    def _find_steps(self) -> tuple[_Step, ...]:
        down = self._ancestry(self._tip, {self._base})
        links = [self._tip, *(joint.parent for joint in down)]
        up = [] if links[-1] == self._base else self._ancestry(self._base, set(links))
        meeting = up[-1].parent if up else self._base
        if meeting not in links:
            raise self._model.refuse(f"link {self._tip!r}", f"is not connected with {self._base!r}")
        down = down[: links.index(meeting)][::-1]
        return (*(_Step(joint, False) for joint in up), *(_Step(joint, True) for joint in down))

    def _ancestry(self, link: str, ends: set[str]) -> list[_Joint]:
        """Joints from a link upwards, as far as one of the ends or a root."""
        joints: list[_Joint] = []
        seen = {link}
        while link not in ends and link in self._by_child:
            above = self._by_child[link]
            if len(above) > 1:
                names = " and ".join(repr(joint.name) for joint in above)
                raise self._model.refuse(
                    f"link {link!r}", f"is the child of the joints {names}: closed loops are not read"
                )
            joints.append(above[0])
            link = above[0].parent
            if link in seen:
                raise self._model.refuse(f"joint {above[0].name!r}", "closes a cycle of links")
            seen.add(link)
        return joints

    def _check_names(self) -> None:
        joints = [step.joint.name for step in self._steps]
        links = [self._base, *(step.end for step in self._steps)]
        for kind, names, everywhere in (
            ("joint", joints, self._model.joint_names),
            ("link", links, self._model.links),
        ):
            for name in names:
                if everywhere.count(name) > 1:
                    raise self._model.refuse(f"{kind} {name!r}", f"stands {everywhere.count(name)} times")
                if name not in everywhere:
                    raise self._model.refuse(f"link {name!r}", "is named by a joint and is not there")

    def _check_kind(self, joint: _Joint) -> None:
        where = f"joint {joint.name!r}"
        if joint.type not in (*_MOVING, "fixed"):
            known = "is unknown" if joint.type not in _OTHER else "is not read"
            raise self._model.refuse(
                where,
                f"has type {joint.type!r}, which {known}: fixed, revolute, continuous and prismatic are",
            )
        mimic = joint.element.find("mimic")
        if mimic is not None and joint.type != "fixed":
            raise self._model.refuse(
                where, f"mimics joint {mimic.get('joint')!r}: joints that are coupled are not read"
            )

    # ---- numbers ----

    def _origin(self, joint: _Joint) -> Array:
        return self._pose(joint.element.find("origin"), f"joint {joint.name!r}: origin")

    def _pose(self, element: Element | None, where: str) -> Array:
        T = np.eye(4)
        if element is not None:
            T[:3, :3] = _rotation(*self._numbers(element, "rpy", where, 3, "0 0 0"))
            T[:3, 3] = self._numbers(element, "xyz", where, 3, "0 0 0")
        return T

    def _screw(self, joint: _Joint, T: Array, forwards: bool) -> Array:
        element = joint.element.find("axis")
        where = f"joint {joint.name!r}: axis"
        axis = np.array([1.0, 0, 0])
        if element is not None:
            axis = np.array(self._numbers(element, "xyz", where, 3, "1 0 0"))
        # Scaled first, so that the square of a short or long axis neither vanishes nor overflows.
        largest = np.abs(axis).max()
        if largest == 0:
            raise self._model.refuse(where, "is 0 0 0; an axis needs a direction")
        axis = axis / largest
        axis = T[:3, :3] @ (axis / np.linalg.norm(axis))
        if not forwards:  # seen from the child, the parent moves the other way
            axis = -axis
        if joint.type == "prismatic":
            return np.concatenate([axis, np.zeros(3)])
        return np.concatenate([np.cross(T[:3, 3], axis), axis])

    def _limits(self, joint: _Joint) -> tuple[float, float, float]:
        element, where = joint.element.find("limit"), f"joint {joint.name!r}: limit"
        lower, upper = -math.inf, math.inf
        if joint.type != "continuous":
            if element is None:
                raise self._model.refuse(
                    f"joint {joint.name!r}", f"is {joint.type} and has no limit"
                    + ("; a joint without limits has type continuous" if joint.type == "revolute" else "")
                )  # fmt: skip
            # Left out, both are 0 by the specification.
            (lower,) = self._numbers(element, "lower", where, 1, "0", infinite=True)
            (upper,) = self._numbers(element, "upper", where, 1, "0", infinite=True)
        if lower > upper:
            raise self._model.refuse(where, f"has lower {lower:g} above upper {upper:g}")
        if element is None:
            return lower, upper, 1.0
        (rate,) = self._numbers(element, "velocity", where, 1, "1")
        if rate < 0:
            raise self._model.refuse(where, f"has velocity {rate:g}; it must not be negative")
        if rate == 0:
            warnings.warn(
                f"{self._model._source}: joint {joint.name!r} has velocity 0, which locks it", stacklevel=5
            )
        return lower, upper, rate

    def _numbers(
        self, element: Element, key: str, where: str, count: int, default: str, infinite: bool = False
    ) -> list[float]:
        text = element.get(key, default)
        try:
            values = [_number(word) for word in text.split()]
        except ValueError:
            values = []
        if len(values) != count or any(math.isnan(x) or (math.isinf(x) and not infinite) for x in values):
            if "${" in text or "$(" in text:
                raise self._model.refuse(
                    where, f"has {key} {text!r}, which xacro computes: {_how_to_expand(self._model._source)}"
                )
            needed = "a number is" if count == 1 else f"{count} numbers are"
            raise self._model.refuse(where, f"has {key} {text!r}; {needed} needed")
        return values

    # ---- masses ----

    def _inertias(
        self, at_home: dict[str, Array], carrier: dict[str, int], joints: int
    ) -> tuple[Array, Array, Array] | None:
        """Sum up what each joint carries, links beside the path with those on it."""
        self._spread(at_home, carrier)
        elements = dict(zip(self._model.links, self._model._link_elements, strict=True))
        parts: list[list[tuple[float, Array, Array]]] = [[] for _ in range(joints)]
        for link, T in at_home.items():
            if carrier[link] >= 0 and link in elements:
                parts[carrier[link]].append(self._inertia(elements[link], link, T))
        if not any(mass for group in parts for mass, _, _ in group):
            return None
        masses, centres, tensors = zip(*(_combined(group) for group in parts), strict=True)
        return np.array(masses), np.array(centres), np.array(tensors)

    def _spread(self, at_home: dict[str, Array], carrier: dict[str, int]) -> None:
        """Place the links beside the path, with their joints at zero, and note which joint carries them."""
        neighbours: dict[str, list[_Step]] = {}
        for joint in self._model._joints:
            neighbours.setdefault(joint.parent, []).append(_Step(joint, True))
            neighbours.setdefault(joint.child, []).append(_Step(joint, False))
        waiting = [link for link in at_home if carrier[link] >= 0]
        while waiting:
            link = waiting.pop()
            for step in neighbours.get(link, ()):
                if step.end not in at_home:
                    origin = self._origin(step.joint)
                    at_home[step.end] = at_home[link] @ (origin if step.forwards else _inverse(origin))
                    carrier[step.end] = carrier[link]
                    waiting.append(step.end)

    def _inertia(self, link: Element, name: str, T: Array) -> tuple[float, Array, Array]:
        inertial = link.find("inertial")
        where = f"link {name!r}: inertial"
        if inertial is None:
            return 0.0, T[:3, 3], np.zeros((3, 3))
        mass_element, tensor_element = inertial.find("mass"), inertial.find("inertia")
        mass = 0.0 if mass_element is None else self._numbers(mass_element, "value", where, 1, "0")[0]
        if mass < 0:
            raise self._model.refuse(where, f"has mass {mass:g}; it must not be negative")
        T = T @ self._pose(inertial.find("origin"), f"{where}: origin")
        tensor = np.zeros((3, 3))
        if tensor_element is not None:
            for (i, j), key in zip(
                np.ndindex(3, 3), ["xx", "xy", "xz", "xy", "yy", "yz", "xz", "yz", "zz"], strict=True
            ):
                (tensor[i, j],) = self._numbers(tensor_element, f"i{key}", where, 1, "0")
        return mass, T[:3, 3], T[:3, :3] @ tensor @ T[:3, :3].T


def _number(word: str) -> float:
    # Python's own notation allows more: digits in groups, other scripts.
    if "_" in word or not word.isascii():
        raise ValueError(word)
    return float(word)


def _combined(parts: Iterable[tuple[float, Array, Array]]) -> tuple[float, Array, Array]:
    """Mass, centre and inertia about the centre of several bodies together."""
    parts = list(parts)
    mass = sum(part[0] for part in parts)
    if mass == 0:
        return 0.0, np.zeros(3), sum((part[2] for part in parts), np.zeros((3, 3)))
    centre = sum((m * c for m, c, _ in parts), np.zeros(3)) / mass
    tensor = np.zeros((3, 3))
    for m, c, inertia in parts:
        r = c - centre
        tensor += inertia + m * (r @ r * np.eye(3) - np.outer(r, r))
    return float(mass), centre, tensor


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


def _inverse(T: Array) -> Array:
    R, p = T[:3, :3], T[:3, 3]
    inverse = np.eye(4)
    inverse[:3, :3], inverse[:3, 3] = R.T, -R.T @ p
    return inverse
