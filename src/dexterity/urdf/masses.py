"""Masses of what moves with each joint of a way, links beside the way included.

Examples
--------
>>> import numpy as np
>>> from dexterity.urdf import masses
>>> halves = [(1.5, np.array([x, 0, 0]), np.zeros((3, 3))) for x in (0.25, 0.75)]
>>> mass, centre, inertia = masses.combined(halves)
>>> mass, centre.tolist(), inertia[2, 2].item()
(3.0, [0.5, 0.0, 0.0], 0.1875)
"""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Mapping, Sequence
from typing import TypeAlias
from xml.etree.ElementTree import Element

import numpy as np

from dexterity.urdf.document import Array, Values
from dexterity.urdf.tree import Joint, Step

__all__ = ["Body", "carried", "combined"]

_ROUNDING = 1e-6  # of the largest moment: numbers are printed with few digits
_NOTHING = 1e-12  # [kg m²]
_DIGITS = 1e-2  # of the largest moment: what a description with three digits may miss

Body: TypeAlias = tuple[float, Array, Array]
"""Mass [kg], centre of mass [m] and inertia about it [kg m²]."""


def carried(
    at_home: Mapping[str, Array],
    carrier: Mapping[str, int],
    count: int,
    joints: Sequence[Joint],
    links: Mapping[str, Element],
    values: Values,
) -> tuple[Array, Array, Array] | None:
    """Sum up what each moving joint carries.

    Parameters
    ----------
    at_home
        Pose at home of each link of the way.
    carrier
        Number of the moving joint that each of these links follows, -1 for none.
    count
        Number of moving joints.
    joints, links
        All joints, and all links by name.
    values
        Reads the file.

    Returns
    -------
    Masses (n,), centres (n, 3) and inertias (n, 3, 3); None if nothing that moves has a mass.
    """
    at_home, carrier = _spread(at_home, carrier, joints, values)
    bodies: list[list[Body]] = [[] for _ in range(count)]
    for link, T in at_home.items():
        if carrier[link] >= 0 and link in links:
            bodies[carrier[link]].append(_body(links[link], link, T, values))
    if not any(mass for group in bodies for mass, _, _ in group):
        return None
    masses, centres, tensors = zip(*map(combined, bodies), strict=True)
    return np.array(masses), np.array(centres), np.array(tensors)


def _spread(
    at_home: Mapping[str, Array], carrier: Mapping[str, int], joints: Sequence[Joint], values: Values
) -> tuple[dict[str, Array], dict[str, int]]:
    """Place the links beside the way, with their joints at zero, and note which joint carries them."""
    at_home, carrier = dict(at_home), dict(carrier)
    neighbours: dict[str, list[Step]] = {}
    for joint in joints:
        neighbours.setdefault(joint.parent, []).append(Step(joint, True))
        neighbours.setdefault(joint.child, []).append(Step(joint, False))
    waiting = [link for link in at_home if carrier[link] >= 0]
    while waiting:
        link = waiting.pop()
        for step in neighbours.get(link, ()):
            if step.end not in at_home:
                origin = values.pose(step.joint.element, f"joint {step.joint.name!r}")
                at_home[step.end] = at_home[link] @ (origin if step.forwards else np.linalg.inv(origin))
                carrier[step.end] = carrier[link]
                waiting.append(step.end)
    return at_home, carrier


def _body(link: Element, name: str, T: Array, values: Values) -> Body:
    inertial = link.find("inertial")
    where = f"link {name!r}: inertial"
    if inertial is None:
        return 0.0, T[:3, 3], np.zeros((3, 3))
    mass_element, tensor_element = inertial.find("mass"), inertial.find("inertia")
    mass = 0.0 if mass_element is None else values.numbers(mass_element, "value", where, 1, "0")[0]
    if mass < 0:
        raise values.refuse(where, f"has mass {mass:g}; it must not be negative")
    T = T @ values.pose(inertial, where)
    tensor = np.zeros((3, 3))
    if tensor_element is not None:
        for i, j in ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)):
            (value,) = values.numbers(tensor_element, f"i{'xyz'[i]}{'xyz'[j]}", where, 1, "0")
            tensor[i, j] = tensor[j, i] = value
        least, most = tensor.diagonal().min(), tensor.diagonal().max()
        if least < -max(_ROUNDING * most, _NOTHING):
            raise values.refuse(where, f"has the moment of inertia {least:g}; it must not be negative")
        _warn_of_no_body(tensor, where, values)
    return mass, T[:3, 3], T[:3, :3] @ tensor @ T[:3, :3].T


def _warn_of_no_body(tensor: Array, where: str, values: Values) -> None:
    """Warn of principal moments that no body has. Published robots have such links, and move all the same."""
    moments = np.linalg.eigvalsh(tensor)
    beyond = max(moments[2] - moments[0] - moments[1], -moments[0])
    if beyond > max(_DIGITS * np.abs(moments).max(), _NOTHING):
        shown = ", ".join(f"{moment:.4g}" for moment in moments)
        warnings.warn(
            f"{values.file}: {where} has the principal moments {shown} kg m², and no body has them: none is "
            "negative or larger than the sum of the other two. What depends on masses is wrong",
            stacklevel=6,
        )


def combined(bodies: Iterable[Body]) -> Body:
    """Mass, centre and inertia about the centre of several bodies together."""
    bodies = list(bodies)
    mass = sum(body[0] for body in bodies)
    tensors = sum((body[2] for body in bodies), np.zeros((3, 3)))
    if mass == 0:
        return 0.0, np.zeros(3), tensors
    centre = sum((m * c for m, c, _ in bodies), np.zeros(3)) / mass
    for m, c, _ in bodies:
        r = c - centre
        tensors = tensors + m * (r @ r * np.eye(3) - np.outer(r, r))
    return float(mass), centre, tensors
