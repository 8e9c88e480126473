"""A URDF that has been read, and the serial chain between two of its links.

Examples
--------
>>> from dexterity import urdf
>>> text = '''<robot name="gate"><link name="post"/><link name="wing"/>
...   <joint name="hinge" type="continuous"><parent link="post"/><child link="wing"/></joint></robot>'''
>>> model = urdf.read(text)
>>> model.roots, model.leaves(), model.path().home[0].tolist()
(('post',), ('wing',), [1.0, 0.0, 0.0, 0.0])
"""

from __future__ import annotations

import math
import os
import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from xml.etree.ElementTree import Element

import numpy as np

from dexterity import checks
from dexterity.urdf import document, masses, tree
from dexterity.urdf.document import Array, Values
from dexterity.urdf.tree import Joint

__all__ = ["Model", "SerialPath", "read"]


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
    _values: Values
    _joints: tuple[Joint, ...]
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
        bases = self.roots if base is None else (checks.choice(base, "base", self.links),)
        carried: set[str] = set().union(*(tree.moved_by(self._joints, each) for each in bases))
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
        steps = tree.way(self._joints, base, tip, self._values)
        tree.check_way(steps, base, self._joints, self.links, self._values)
        T = np.eye(4)
        moving, screws = [], []
        at_home, carrier = {base: T}, {base: -1}
        for step in steps:
            joint = step.joint
            origin = self._values.pose(joint.element, f"joint {joint.name!r}")
            T = T @ origin if step.forwards else T
            if joint.type != "fixed":
                moving.append(joint)
                screws.append(_screw(joint, T, step.forwards, self._values))
            T = T if step.forwards else T @ np.linalg.inv(origin)
            at_home[step.end], carrier[step.end] = T, len(moving) - 1
        if not moving:
            raise self._values.refuse(f"the path from {base} to {tip}", "has no joint that moves")
        lower, upper, rates = zip(*(_limits(joint, self._values) for joint in moving), strict=True)
        links = dict(zip(self.links, self._link_elements, strict=True))
        return SerialPath(
            name=self.name,
            joint_names=tuple(joint.name for joint in moving),
            screws=np.array(screws),
            home=T,
            lower=lower,
            upper=upper,
            rates=rates,
            inertias=masses.carried(at_home, carrier, len(moving), self._joints, links, self._values),
        )

    def _link_or_only(self, link: str | None, role: str, choices: Sequence[str], described: str) -> str:
        if link is None:
            if len(choices) != 1:
                have = f"{len(choices)} {described}: {', '.join(choices)}" if choices else f"no {described}"
                raise ValueError(f"{self._values.file} has {have}; name the {role}")
            return choices[0]
        if not isinstance(link, str):
            raise TypeError(f"{role} is {link!r}; the name of a link is needed")
        if link not in self.links:
            raise ValueError(f"{role} is {link!r}; {self._values.file} has the links {', '.join(self.links)}")
        return link


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
    root, file = document.parse(source)
    values = Values(file)
    links = tuple(root.findall("link"))
    joints = tuple(tree.joint(element, values) for element in root.findall("joint"))
    names = tuple(values.text(link, "name", "a link") for link in links)
    if not links:
        raise ValueError(f"{file} is no URDF: it has no link")
    return Model(root.get("name") or "robot", names, values, joints, links)


def _screw(joint: Joint, T: Array, forwards: bool, values: Values) -> Array:
    """Screw of a joint whose frame at home is T."""
    where = f"joint {joint.name!r}"
    element, where = values.part(joint.element, "axis", where, ("xyz",)), f"{where}: axis"
    axis = np.array([1.0, 0, 0])
    if element is not None:
        axis = np.array(values.numbers(element, "xyz", where, 3, ""))
    # Scaled first, so that the square of a short or long axis neither vanishes nor overflows.
    largest = np.abs(axis).max()
    if largest == 0:
        raise values.refuse(where, "is 0 0 0; an axis needs a direction")
    axis = axis / largest
    axis = T[:3, :3] @ (axis / np.linalg.norm(axis))
    if not forwards:  # seen from the child, the parent moves the other way
        axis = -axis
    if joint.type == "prismatic":
        return np.concatenate([axis, np.zeros(3)])
    return np.concatenate([np.cross(T[:3, 3], axis), axis])


def _limits(joint: Joint, values: Values) -> tuple[float, float, float]:
    """Lower and upper limit and largest rate of a joint."""
    where = f"joint {joint.name!r}"
    element, where = values.part(joint.element, "limit", where), f"{where}: limit"
    lower, upper = -math.inf, math.inf
    if joint.type != "continuous":
        if element is None:
            hint = "; a joint without limits has type continuous" if joint.type == "revolute" else ""
            raise values.refuse(f"joint {joint.name!r}", f"is {joint.type} and has no limit{hint}")
        # Left out, both are 0 by the specification.
        (lower,) = values.numbers(element, "lower", where, 1, "0", infinite=True)
        (upper,) = values.numbers(element, "upper", where, 1, "0", infinite=True)
    if lower > upper:
        raise values.refuse(where, f"has lower {lower:g} above upper {upper:g}")
    if lower == upper:
        said = (
            f"{values.file}: joint {joint.name!r} has lower and upper limit {lower:g}, so that it cannot move"
        )
        warnings.warn(said, stacklevel=4)
    if element is None:
        return lower, upper, 1.0
    (rate,) = values.numbers(element, "velocity", where, 1, "1")
    if rate < 0:
        raise values.refuse(where, f"has velocity {rate:g}; it must not be negative")
    if rate == 0:
        warnings.warn(f"{values.file}: joint {joint.name!r} has velocity 0, which locks it", stacklevel=4)
    return lower, upper, rate
