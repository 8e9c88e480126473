"""Spheres, capsules and boxes, and the bodies that they make on a chain's links, on its base or in the world.

A shape is given where it is at home, that is with all joints at zero, in the world frame of the chain. That
frame stands on the base.

Examples
--------
>>> import dexterity as dx
>>> arm = dx.robots.docking_arm()
>>> [body.name for body in dx.collision.capsules(arm, radius=0.04, hand=0.1, along=(1, 0, 0))]
['link 1', 'link 2', 'link 4', 'hand']
>>> dx.collision.Capsule((0, 0, 0), (0.4, 0, 0), radius=-0.04)
Traceback (most recent call last):
    ...
ValueError: radius is -0.04; a finite number at least 0 is needed
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, Literal, TypeAlias

import numpy as np
import torch
from torch import Tensor

from dexterity import checks, spatial
from dexterity.chain import Chain
from dexterity.spatial import TensorLike

__all__ = ["Body", "Box", "Capsule", "Link", "Shape", "Sphere", "capsules"]

_LARGEST = 1e6  # [m], beyond which squares of lengths lose what a distance is about

Point: TypeAlias = tuple[float, float, float]


def _point(value: Any, name: str) -> Point:
    values = value.tolist() if isinstance(value, Tensor | np.ndarray) else value
    if not isinstance(values, Sequence) or isinstance(values, str | bytes) or len(values) != 3:
        raise ValueError(f"{name} is {checks.shown(value)}; 3 numbers are needed")
    x, y, z = (checks.real(number, name, least=-_LARGEST, most=_LARGEST) for number in values)
    return x, y, z


_RADIUS = checks.Real(least=0.0)


def _radius(value: Any, name: str) -> float:
    radius: float = _RADIUS(value, name)
    return checks.real(radius, name, most=_LARGEST)


@dataclass(frozen=True)
class Sphere:
    """A ball.

    Attributes
    ----------
    centre
        Its centre [m].
    radius
        Its radius [m]; 0 makes it a point.

    Raises
    ------
    ValueError
        If the centre is not three numbers, the radius is negative, or a number is not finite.
    TypeError
        If a value is no number.
    """

    centre: tuple[float, float, float]
    radius: float

    def __post_init__(self) -> None:
        checks.fields(self, centre=_point, radius=_radius)


@dataclass(frozen=True)
class Capsule:
    """All points within a radius of a straight line between two points.

    Attributes
    ----------
    start, end
        The two points [m]. They may be the same.
    radius
        The radius [m]; 0 makes it a line.

    Raises
    ------
    ValueError
        If an end is not three numbers, the radius is negative, or a number is not finite.
    TypeError
        If a value is no number.
    """

    start: tuple[float, float, float]
    end: tuple[float, float, float]
    radius: float

    def __post_init__(self) -> None:
        checks.fields(self, start=_point, end=_point, radius=_radius)


@dataclass(frozen=True)
class Box:
    """A rectangular box.

    Attributes
    ----------
    size
        Lengths of its edges along its own x, y and z axes [m].
    centre
        Its centre [m].
    rotation
        (3, 3) directions of its axes, in columns; None for those of the frame that it is given in.

    Raises
    ------
    ValueError
        If size or centre are not three numbers, a length is not above 0, the rotation is none, or a number is
        not finite.
    TypeError
        If a value is no number.
    """

    size: tuple[float, float, float]
    centre: tuple[float, float, float] = (0.0, 0.0, 0.0)
    rotation: TensorLike | None = None

    def __post_init__(self) -> None:
        checks.fields(self, size=_size, centre=_point, rotation=_rotation)


def _size(value: Any, name: str) -> Point:
    size = _point(value, name)
    for length in size:
        checks.positive(length, name)
    return size


def _rotation(value: Any, name: str) -> tuple[tuple[float, ...], ...] | None:
    if value is None:
        return None
    R = spatial.to_float64(value, name)
    if R.shape != (3, 3):
        raise ValueError(f"{name} has shape {tuple(R.shape)}; (3, 3) is needed")
    return tuple(tuple(row) for row in spatial.require_rotation(R, name).tolist())


Shape: TypeAlias = Sphere | Capsule | Box
"""A sphere, a capsule or a box."""

Link: TypeAlias = int | Literal["world"]
"""What carries a body, 0 for the base, i for the link that joint i moves, or ``"world"`` around the base."""


@dataclass(frozen=True)
class Body:
    """A shape, and what carries it.

    Attributes
    ----------
    shape
        Its form, and where it is at home.
    link
        0 for the base, 1 … n for the link that a joint moves, or ``"world"`` for what does not move with the
        base. A body of the world is given in the world that `T_world_base` of
        :meth:`~dexterity.collision.bodies.Bodies.clearance` refers to.
    name
        What it is called in errors; printable text.

    Raises
    ------
    ValueError
        If the link is negative or another word, or the name is blank.
    TypeError
        If an argument is of another type.
    """

    shape: Shape
    link: Link
    name: str

    def __post_init__(self) -> None:
        checks.fields(self, shape=checks.Instance((Sphere, Capsule, Box)), link=_link, name=checks.Name())


def _link(value: Any, name: str) -> Link:
    if isinstance(value, str):
        checks.choice(value, name, ("world",))
        return "world"
    return checks.whole(value, name, least=0)


@checks.arguments(chain=checks.Instance(Chain), radius=_radius, hand=_radius, along=_point)
def capsules(
    chain: Chain, radius: float, hand: float = 0.0, along: tuple[float, float, float] = (0.0, 0.0, 1.0)
) -> tuple[Body, ...]:
    """Return the links of a chain as capsules, from each joint to the next and from the last to the tool.

    A joint is where the origin of its frame is, see :meth:`dexterity.chain.Chain.joint_frames`. A link
    without a length, such as those inside of a spherical wrist, has no capsule.

    Parameters
    ----------
    chain
        The chain.
    radius
        Radius of all capsules [m]; 0 makes them lines.
    hand
        Length of a capsule on the last link, called ``"hand"``, that begins at the tool point [m]; 0 for
        none.
    along
        Direction of the hand in the tool frame, of any length.

    Raises
    ------
    ValueError
        If the radius or the hand is negative or not finite, the hand is longer than all links together, its
        direction has no length, or no link has a length.
    TypeError
        If the chain is none, or a value is no number.
    """
    frames = chain.joint_frames(torch.zeros(chain.joints, dtype=torch.float64))
    points = torch.cat([frames[:, :3, 3], chain.home[None, :3, 3]])
    lengths = (points[1:] - points[:-1]).norm(dim=-1)
    bodies = [
        Body(Capsule(_row(start), _row(end), radius), i + 1, f"link {i + 1}")
        for i, (start, end) in enumerate(pairwise(points))
        if lengths[i] > _SHORTEST
    ]
    if not bodies:
        raise ValueError(f"chain is {chain.name}, none of whose links has a length")
    if hand > float(lengths.sum()):
        raise ValueError(f"hand is {hand:g} m; all links together have {float(lengths.sum()):.4g} m")
    if hand > 0:
        bodies.append(_hand(chain, radius, hand, along))
    return tuple(bodies)


_SHORTEST = 1e-9  # [m], below which a link has no length


def _hand(chain: Chain, radius: float, length: float, along: Point) -> Body:
    direction = torch.tensor(along, dtype=torch.float64)
    if not direction.norm() > 0:
        raise ValueError(f"along is {along}; a direction with a length is needed")
    tool = chain.home
    end = spatial.apply(tool, length * direction / direction.norm())
    return Body(Capsule(_row(tool[:3, 3]), _row(end), radius), chain.joints, "hand")


def _row(point: Tensor) -> Point:
    return _point(point, "point")
