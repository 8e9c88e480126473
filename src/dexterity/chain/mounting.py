"""Joints of vehicles and bases: which degrees of freedom, in which order, along which axes.

A free vehicle has six degrees of freedom, of which some may be chosen. Along the world's axes it moves first
and then turns; along its own axes it turns first and then moves, so that a turned vehicle surges ahead.

Examples
--------
>>> from dexterity.chain import mounting
>>> vehicle = mounting.vehicle_joints(("x", "y", "z", "yaw"), "body", prefix="rov ")
>>> vehicle.names, vehicle.order
(('rov yaw', 'rov x', 'rov y', 'rov z'), (3, 0, 1, 2))
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import torch
from torch import Tensor

from dexterity import checks

__all__ = ["AXES", "VEHICLE_JOINTS", "Mount", "freedom", "vehicle_joints"]

VEHICLE_JOINTS = ("x", "y", "z", "θx", "θy", "θz")
"""Degrees of freedom of a free vehicle."""

AXES = ("world", "body")
"""Axes along which a vehicle moves."""

_ALIASES = {
    "surge": "x", "sway": "y", "heave": "z",
    "rx": "θx", "ry": "θy", "rz": "θz", "roll": "θx", "pitch": "θy", "yaw": "θz",
}  # fmt: skip


@dataclass(frozen=True)
class Mount:
    """Joints in front of an arm, from the world to the vehicle.

    Attributes
    ----------
    names
        Names of the joints.
    screws
        (k, 6) rows [v; ω] at home, where the vehicle frame lies on the world frame.
    order
        For each joint its place among the degrees of freedom as they were asked for.
    """

    names: tuple[str, ...]
    screws: Tensor
    order: tuple[int, ...]


def freedom(name: str) -> str | None:
    """Degree of freedom that a name stands for, one of :data:`VEHICLE_JOINTS`, or None."""
    return name if name in VEHICLE_JOINTS else _ALIASES.get(name)


def vehicle_joints(joints: Sequence[str], axes: str, prefix: str = "") -> Mount:
    """Choose degrees of freedom of a vehicle.

    Parameters
    ----------
    joints
        Names: ``x``, ``y``, ``z`` or ``surge``, ``sway``, ``heave``, and ``θx``, ``θy``, ``θz``, which may be
        written ``rx``, ``ry``, ``rz`` or ``roll``, ``pitch``, ``yaw``.
    axes
        ``"world"``: x, y, z, θx, θy, θz from the world to the vehicle. ``"body"``: θx, θy, θz, x, y, z.
    prefix
        Text before each name.

    Raises
    ------
    ValueError
        If a name is unknown or there twice, there is none, or `axes` is unknown.
    TypeError
        If `joints` is no sequence of names, or `prefix` is no text.
    """
    asked = checks.names(joints, "joints")
    if not asked:
        raise ValueError(f"joints is empty; at least one of {', '.join(VEHICLE_JOINTS)} is needed")
    checks.choice(axes, "axes", AXES)
    checks.instance(prefix, "prefix", str)
    if not prefix.isprintable():
        raise ValueError(f"prefix is {checks.shown(prefix)}; printable text is needed")
    known = (*VEHICLE_JOINTS, *_ALIASES)
    freedoms = [_ALIASES.get(checks.choice(name, "joints", known), name) for name in asked]
    for freedom in freedoms:
        if freedoms.count(freedom) > 1:
            raise ValueError(f"joints is {list(asked)}; it holds {freedom} more than once")
    sequence = VEHICLE_JOINTS if axes == "world" else VEHICLE_JOINTS[3:] + VEHICLE_JOINTS[:3]
    order = tuple(freedoms.index(freedom) for freedom in sequence if freedom in freedoms)
    unit = torch.eye(6, dtype=torch.float64, device="cpu")
    screws = unit[[VEHICLE_JOINTS.index(freedoms[i]) for i in order]]
    return Mount(tuple(prefix + asked[i] for i in order), screws, order)
