"""The tree of links and joints of a URDF, and the way from one link to another.

Examples
--------
>>> from xml.etree.ElementTree import Element
>>> from dexterity.urdf import tree
>>> from dexterity.urdf.document import Values
>>> joints = [tree.Joint(name, "fixed", "root", name.upper(), Element("joint")) for name in "ab"]
>>> [(step.joint.name, step.forwards) for step in tree.way(joints, "A", "B", Values("a file"))]
[('a', False), ('b', True)]
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from xml.etree.ElementTree import Element

from dexterity.urdf.document import Values

__all__ = ["Joint", "Step", "check_way", "joint", "moved_by", "way"]

_MOVING = ("revolute", "continuous", "prismatic")
_NOT_READ = ("floating", "planar")


@dataclass(frozen=True)
class Joint:
    """A joint as the file has it; its numbers are read when they are needed.

    Attributes
    ----------
    name, type
        Its attributes.
    parent, child
        Names of its links.
    element
        Its XML.
    """

    name: str
    type: str
    parent: str
    child: str
    element: Element


@dataclass(frozen=True)
class Step:
    """A joint of a way.

    Attributes
    ----------
    joint
        The joint.
    forwards
        Whether it is passed from its parent to its child.
    """

    joint: Joint
    forwards: bool

    @property
    def end(self) -> str:
        """Link that the step leads to."""
        return self.joint.child if self.forwards else self.joint.parent


def joint(element: Element, values: Values) -> Joint:
    """Read the names and the type of a joint.

    Raises
    ------
    ValueError
        If one of them is missing, or both links are one.
    """
    name = values.text(element, "name", "a joint")
    where = f"joint {name!r}"
    ends = []
    for end in ("parent", "child"):
        inside = values.part(element, end, where)
        if inside is None:
            raise values.refuse(where, f"has no {end}")
        ends.append(values.text(inside, "link", f"{where}: {end}"))
    if ends[0] == ends[1]:
        raise values.refuse(where, f"has the link {ends[0]!r} as its parent and as its child")
    return Joint(name, values.text(element, "type", where), ends[0], ends[1], element)


def moved_by(joints: Sequence[Joint], base: str) -> set[str]:
    """Links below a base over at least one joint that is not fixed."""
    children: dict[str, list[Joint]] = {}
    for each in joints:
        children.setdefault(each.parent, []).append(each)
    moves = {base: False}
    waiting = [base]
    while waiting:
        link = waiting.pop()
        for each in children.get(link, ()):
            if each.child not in moves:
                moves[each.child] = moves[link] or each.type != "fixed"
                waiting.append(each.child)
    return {link for link, moved in moves.items() if moved}


def way(joints: Sequence[Joint], base: str, tip: str, values: Values) -> tuple[Step, ...]:
    """Return the joints from a base to a tip, up the tree and down again.

    Raises
    ------
    ValueError
        If the two are not connected, or a closed loop or a cycle lies on the way.
    """
    by_child: dict[str, list[Joint]] = {}
    for each in joints:
        by_child.setdefault(each.child, []).append(each)
    down = _ancestry(by_child, tip, {base}, values)
    links = [tip, *(each.parent for each in down)]
    up = [] if links[-1] == base else _ancestry(by_child, base, set(links), values)
    meeting = up[-1].parent if up else base
    if meeting not in links:
        raise values.refuse(f"link {tip!r}", f"is not connected with {base!r}")
    down = down[: links.index(meeting)][::-1]
    return (*(Step(each, False) for each in up), *(Step(each, True) for each in down))


def _ancestry(by_child: dict[str, list[Joint]], link: str, ends: set[str], values: Values) -> list[Joint]:
    """Joints from a link upwards, as far as one of the ends or a root."""
    joints: list[Joint] = []
    seen = {link}
    while link not in ends and link in by_child:
        above = by_child[link]
        if len(above) > 1:
            names = " and ".join(repr(each.name) for each in above)
            raise values.refuse(
                f"link {link!r}", f"is the child of the joints {names}: closed loops are not read"
            )
        joints.append(above[0])
        link = above[0].parent
        if link in seen:
            raise values.refuse(f"joint {above[0].name!r}", "closes a cycle of links")
        seen.add(link)
    return joints


def check_way(
    steps: Sequence[Step], base: str, joints: Sequence[Joint], links: Sequence[str], values: Values
) -> None:
    """Make sure that each joint on a way can be read, and that names on it are there once.

    Raises
    ------
    ValueError
        If a joint is of another type or mimics another one, or a link or joint is there twice or not at all.
    """
    on_way = [("joint", step.joint.name) for step in steps]
    on_way += [("link", link) for link in (base, *(step.end for step in steps))]
    everywhere = {"joint": [each.name for each in joints], "link": list(links)}
    for kind, name in on_way:
        count = everywhere[kind].count(name)
        if count > 1:
            raise values.refuse(f"{kind} {name!r}", f"stands {count} times")
        if count == 0:
            raise values.refuse(f"{kind} {name!r}", "is named by a joint and is not there")
    for step in steps:
        _check_type(step.joint, values)


def _check_type(each: Joint, values: Values) -> None:
    where = f"joint {each.name!r}"
    if each.type not in (*_MOVING, "fixed"):
        known = "is not read" if each.type in _NOT_READ else "is unknown"
        raise values.refuse(
            where,
            f"has type {each.type!r}, which {known}: fixed, revolute, continuous and prismatic are; "
            f"base={each.child!r} begins behind it",
        )
    mimic = each.element.find("mimic")
    if mimic is not None and each.type != "fixed":
        raise values.refuse(
            where,
            f"mimics joint {mimic.get('joint')!r}: joints that are coupled are not read; "
            f"tip={each.parent!r} ends before it",
        )
