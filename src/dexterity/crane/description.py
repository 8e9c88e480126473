"""What a crane is made of: ``data/robots/patu655.toml``, read strictly.

Examples
--------
>>> import dexterity as dx
>>> crane = dx.crane.patu655()
>>> crane.name, crane.upper, crane.rating
('patu655', (0.535, 0.78, 1.6), 500.0)
"""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any, TypeAlias

import torch
from jaxtyping import Float64
from torch import Tensor

from dexterity import checks, store
from dexterity.checks import Check, Instance, Name, Real

__all__ = ["Crane", "Linkage", "Member", "Structure", "given_crane", "patu655", "read_crane"]

Point: TypeAlias = tuple[float, float]


@dataclass(frozen=True)
class Linkage:
    """Joints and rods, [m]; capital letters are the thesis's.

    Attributes
    ----------
    lift_joint, lift_cylinder_foot
        B and C, in the world.
    lift_cylinder_rod, jib_joint, crank_joint, jib_cylinder_foot
        D, G, F and E, in the lift frame, whose origin is B.
    coupler_pin, extension_joint
        I and J, in the jib frame, whose origin is G. J is the tip at stroke 0.
    lift_cylinder_length, jib_cylinder_length
        Of CD and EH at stroke 0.
    crank, coupler, rocker
        Lengths of FH, HI and GI.
    """

    lift_joint: Point
    lift_cylinder_foot: Point
    lift_cylinder_rod: Point
    lift_cylinder_length: float
    jib_joint: Point
    crank_joint: Point
    jib_cylinder_foot: Point
    jib_cylinder_length: float
    crank: float
    coupler: float
    rocker: float
    coupler_pin: Point
    extension_joint: Point

    def __post_init__(self) -> None:
        for field in dataclasses.fields(self):
            check = _points if str(field.type) == "Point" else Real(above=0)
            object.__setattr__(self, field.name, check(getattr(self, field.name), field.name))


def _points(value: Any, name: str, size: int = 2) -> tuple[float, ...]:
    """Return a tuple of finite numbers."""
    Instance((tuple, list))(value, name)
    if len(value) != size:
        raise ValueError(f"{name} is {checks.shown(value)}; {size} numbers are needed")
    return tuple(checks.real(number, f"{name}[{i}]") for i, number in enumerate(value))


@dataclass(frozen=True)
class Member:
    """A row of beams from node to node.

    Attributes
    ----------
    nodes
        Points [m].
    tubes
        Breadth, height and wall [m] of the rectangular tube between each two.
    """

    nodes: tuple[Point, ...]
    tubes: tuple[tuple[float, float, float], ...]

    def __post_init__(self) -> None:
        for name, size in (("nodes", 2), ("tubes", 3)):
            rows = Instance((tuple, list))(getattr(self, name), name)
            whole = tuple(_points(row, f"{name}[{i}]", size) for i, row in enumerate(rows))
            object.__setattr__(self, name, whole)
        if len(self.nodes) < 2 or len(self.tubes) != len(self.nodes) - 1:
            raise ValueError(f"there are {len(self.nodes)} nodes and {len(self.tubes)} tubes between them")
        for b, h, t in self.tubes:
            if not 0 < 2 * t <= min(b, h):
                raise ValueError(f"a tube is {b} × {h} with a wall of {t}, which does not fit")
        if any(first == last for first, last in itertools.pairwise(self.nodes)):
            raise ValueError("nodes holds a point twice in a row; a tube needs a length")

    @property
    def areas(self) -> tuple[float, ...]:
        """Areas of the sections [m²]."""
        return tuple(b * h - (b - 2 * t) * (h - 2 * t) for b, h, t in self.tubes)

    @property
    def second_moments(self) -> tuple[float, ...]:
        """Second moments of area against bending in the plane [m⁴]."""
        return tuple((b * h**3 - (b - 2 * t) * (h - 2 * t) ** 3) / 12 for b, h, t in self.tubes)


@dataclass(frozen=True)
class Structure:
    """What bends and what weighs, in SI units; all of it assumed, two numbers of it fitted.

    Attributes
    ----------
    pillar, lift, jib, extension
        Members: in the world, in the lift frame, in the jib frame, and along the jib from the tip.
    bending_factor
        Factor of all second moments of area; fitted.
    ground_stiffness
        Of the torsion spring under the pillar [N·m/rad]; fitted.
    lift_cylinder_mass, jib_cylinder_mass, linkage_mass
        Half of each cylinder weighs at either end, crank and coupler at H.
    """

    gravity: float
    youngs_modulus: float
    density: float
    bending_factor: float
    ground_stiffness: float
    lift_cylinder_mass: float
    jib_cylinder_mass: float
    linkage_mass: float
    pillar: Member
    lift: Member
    jib: Member
    extension: Member

    def __post_init__(self) -> None:
        for field in dataclasses.fields(self):
            check: Check = Real(least=0)
            if field.name in ("youngs_modulus", "bending_factor", "ground_stiffness"):
                check = Real(above=0)
            elif field.name in _TABLES:
                check = Instance(Member)
            object.__setattr__(self, field.name, check(getattr(self, field.name), field.name))


@dataclass(frozen=True)
class Crane:
    """A crane with a lift cylinder, a jib cylinder with its four-bar linkage, and an extension.

    Attributes
    ----------
    name, source, licence
        What it is called, where its numbers come from, and on what terms.
    lower, upper
        Limits of the strokes s1, s2, s3 [m].
    rating
        Largest payload [kg].
    linkage, structure
        Its parts.
    """

    name: str
    source: str
    licence: str
    lower: tuple[float, float, float]
    upper: tuple[float, float, float]
    rating: float
    linkage: Linkage
    structure: Structure

    def __post_init__(self) -> None:
        checks.fields(
            self,
            name=Name(),
            source=Name(),
            licence=Name(),
            rating=Real(above=0),
            linkage=Instance(Linkage),
            structure=Instance(Structure),
        )
        for name in ("lower", "upper"):
            object.__setattr__(self, name, _points(getattr(self, name), name, 3))
        if any(low > high for low, high in zip(self.lower, self.upper, strict=True)):
            raise ValueError(
                f"lower is {self.lower} and upper {self.upper}; each limit must be below its upper one"
            )


@lru_cache(maxsize=1)
def patu655() -> Crane:
    """Log crane of paper D.

    References
    ----------
    Rouvinen (1999), sections 3.1 and 3.3, Appendix A. The structure's sections and masses are assumptions.
    """
    return read_crane(store.data_path("robots", "patu655.toml"))


def given_crane(crane: Crane | None, name: str = "crane") -> Crane:
    """Return a crane, :func:`patu655` for None.

    Raises
    ------
    TypeError
        If it is no crane.
    """
    return patu655() if crane is None else checks.instance(crane, name, Crane)


def stroke_values(crane: Crane, counts: Sequence[int]) -> list[Float64[Tensor, " count"]]:
    """Return so many values of each stroke, evenly spaced from its lower to its upper limit [m]."""
    limits = zip(crane.lower, crane.upper, counts, strict=True)
    return [torch.linspace(low, high, count, dtype=torch.float64) for low, high, count in limits]


@checks.arguments(path=checks.path)
def read_crane(path: Path | str) -> Crane:
    """Read a crane from a file.

    Raises
    ------
    ValueError
        If the file is no TOML, or an entry is missing, unknown, of the wrong kind or without sense; the
        error names the file and the entry.
    """
    path = Path(path)
    try:
        crane: Crane = _made(Crane, store.read_toml(path), "the file")
    except (ValueError, TypeError) as error:
        raise ValueError(f"{path.name} is not a crane's file: {error}") from error
    return crane


_TABLES: dict[str, type[Any]] = {
    "linkage": Linkage, "structure": Structure,
    "pillar": Member, "lift": Member, "jib": Member, "extension": Member,
}  # fmt: skip

_ROWS = {"nodes": 2, "tubes": 3}


def _made(kind: type[Any], entries: Any, where: str) -> Any:
    """Make a dataclass of a table that must have its fields and no others."""
    if not isinstance(entries, dict):
        raise ValueError(f"{where} is {checks.shown(entries)}; a table is needed")
    fields = {field.name: str(field.type) for field in dataclasses.fields(kind)}
    if entries.keys() != fields.keys():
        raise ValueError(f"{where} holds {sorted(entries)}; {sorted(fields)} are needed")
    values = {name: _value(name, entries[name], hint, where) for name, hint in fields.items()}
    try:
        return kind(**values)
    except (ValueError, TypeError) as error:
        raise ValueError(f"{where}: {error}") from error


def _value(name: str, value: Any, hint: str, where: str) -> Any:
    if name in _TABLES:
        return _made(_TABLES[name], value, name)
    label = f"{name} of {where}"
    if name in _ROWS:
        if not isinstance(value, list):
            raise ValueError(f"{label} is {checks.shown(value)}; rows are needed")
        return tuple(_numbers(row, _ROWS[name], label) for row in value)
    if hint == "Point" or hint.startswith("tuple"):
        return _numbers(value, 2 if hint == "Point" else 3, label)
    if hint == "str":
        if not isinstance(value, str) or not value.strip():
            raise ValueError(f"{label} is {checks.shown(value)}; a text is needed")
        return value
    return _number(value, label)


def _numbers(value: Any, size: int, label: str) -> tuple[float, ...]:
    if not isinstance(value, list) or len(value) != size:
        raise ValueError(f"{label} is {checks.shown(value)}; {size} numbers are needed")
    return tuple(_number(number, label) for number in value)


def _number(value: Any, label: str) -> float:
    try:
        return checks.real(value, label)
    except TypeError as error:
        raise ValueError(str(error)) from error
