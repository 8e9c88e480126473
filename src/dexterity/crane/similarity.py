"""The same crane in another size.

Kinematics has no scale: a crane of half the size reaches half as far with half the strokes. Its structure
has one. Weights go with the cube of the size and stiffnesses against bending, as forces over lengths, with
its first power, so that a smaller crane sags less even as a share of its size.

Examples
--------
>>> import dexterity as dx
>>> half = dx.crane.scaled(dx.crane.patu655(), 0.5)
>>> tip = dx.crane.tip_position([0.25, 0.5, 1.0])
>>> bool((dx.crane.tip_position([0.125, 0.25, 0.5], half) - tip / 2).norm() < 1e-9)
True
"""

from __future__ import annotations

import dataclasses
from typing import Any

from dexterity import checks
from dexterity.crane.description import Crane, Linkage, Member, Structure

__all__ = ["scaled"]


def scaled(crane: Crane, factor: float) -> Crane:
    r"""Return a crane whose lengths are all multiplied by a factor.

    Masses, the rating among them, are multiplied by the factor's cube, and so is the stiffness of the ground.
    With loads by the cube, deflections are multiplied by its square.

    Parameters
    ----------
    crane
        The crane.
    factor
        New lengths by old ones.

    Raises
    ------
    ValueError
        If the factor is no number from 10⁻⁶ to 10⁶.

    References
    ----------
    Timoshenko & Young (1965), Theory of structures: deflections go as :math:`F L^3 / (E I)`.
    """
    checks.instance(crane, "crane", Crane)
    factor = checks.real(factor, "factor", least=1e-6, most=1e6)
    return dataclasses.replace(
        crane,
        name=f"{crane.name}, {factor:g} of its size",
        lower=_times(crane.lower, factor),
        upper=_times(crane.upper, factor),
        rating=crane.rating * factor**3,
        linkage=_scaled_linkage(crane.linkage, factor),
        structure=_scaled_structure(crane.structure, factor),
    )


def _scaled_linkage(linkage: Linkage, factor: float) -> Linkage:
    lengths = {field.name: getattr(linkage, field.name) for field in dataclasses.fields(linkage)}
    return Linkage(**{name: _times(length, factor) for name, length in lengths.items()})


def _scaled_structure(parts: Structure, factor: float) -> Structure:
    changes: dict[str, Any] = {name: _scaled_member(getattr(parts, name), factor) for name in _MEMBERS}
    changes |= {name: getattr(parts, name) * factor**3 for name in _CUBED}
    return dataclasses.replace(parts, **changes)


_MEMBERS = ("pillar", "lift", "jib", "extension")
_CUBED = ("ground_stiffness", "lift_cylinder_mass", "jib_cylinder_mass", "linkage_mass")


def _scaled_member(member: Member, factor: float) -> Member:
    return Member(_times(member.nodes, factor), _times(member.tubes, factor))


def _times(value: Any, factor: float) -> Any:
    """Multiply a length, or each of nested tuples of them."""
    return tuple(_times(part, factor) for part in value) if isinstance(value, tuple) else value * factor
