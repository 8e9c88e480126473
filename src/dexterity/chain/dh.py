"""Denavit–Hartenberg rows as screws.

Examples
--------
>>> import torch
>>> from dexterity.chain import dh
>>> screws, frames = dh.screws_and_frames([{"a": 0.5}, {"a": 0.25}], torch.eye(4, dtype=torch.float64))
>>> screws[1].tolist(), frames[-1][0, 3].item()
([0.0, -0.5, 0.0, 0.0, 0.0, 1.0], 0.75)
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import TypeAlias

import torch
from torch import Tensor

from dexterity import checks, spatial
from dexterity.chain.geometry import JointKind

__all__ = ["Row", "screws_and_frames"]

Row: TypeAlias = Mapping[str, float | int | str]
"""``theta``, ``d``, ``a``, ``alpha`` and ``kind`` of a joint."""

_NUMBERS = ("theta", "d", "a", "alpha")
_EXAMPLE = "such as {'theta': 0, 'd': 0.333, 'a': 0, 'alpha': math.pi / 2}"


def screws_and_frames(
    rows: Sequence[Row], base: Tensor, modified: bool = False
) -> tuple[Tensor, tuple[Tensor, ...]]:
    """Return the screws (n, 6) of the rows at home, and the frame that each row ends with.

    Parameters
    ----------
    rows
        See :meth:`dexterity.chain.Chain.from_dh`.
    base
        (4, 4) pose of the first frame in the world.
    modified
        Whether the rows follow Craig's convention.

    Raises
    ------
    TypeError
        If `rows` is no sequence of mappings, or a value is no number.
    ValueError
        If there is no row, a key or kind is unknown, a value is not finite, or an angle exceeds a turn.
    """
    if isinstance(rows, str | bytes | Mapping) or not isinstance(rows, Iterable):
        raise TypeError(f"rows is {checks.shown(rows)}; a sequence of mappings is needed, one a joint")
    T, screws, frames = base, [], []
    for i, row in enumerate(rows):
        kind, before, after = _motions(i, row, modified)
        T = T @ before
        screws.append(_screw_along_z(T, kind))
        T = T @ after
        frames.append(T)
    if not screws:
        raise ValueError("rows is empty; one mapping a joint is needed")
    return torch.stack(screws), tuple(frames)


def _motions(i: int, row: Row, modified: bool) -> tuple[JointKind, Tensor, Tensor]:
    """Kind of joint, motion before its axis (from the frame before) and after it."""
    if not isinstance(row, Mapping):
        raise TypeError(f"rows[{i}] is {checks.shown(row)}; a mapping is needed, {_EXAMPLE}")
    unknown = sorted(map(str, set(row) - {*_NUMBERS, "kind"}))
    if unknown:
        raise ValueError(f"rows[{i}] holds {unknown}; theta, d, a, alpha and kind are known")
    kind: JointKind = "prismatic" if row.get("kind") == "prismatic" else "revolute"
    if row.get("kind", kind) != kind:
        raise ValueError(f"rows[{i}] has kind {row['kind']!r}; revolute or prismatic is needed")
    theta, d, a, alpha = (_number(row.get(key, 0.0), f"rows[{i}].{key}", key) for key in _NUMBERS)
    zero = torch.zeros((), dtype=torch.float64, device="cpu")
    along_z = spatial.exp(torch.stack([zero, zero, d, zero, zero, theta]))
    along_x = spatial.exp(torch.stack([a, zero, zero, alpha, zero, zero]))
    if modified:
        return kind, along_x, along_z
    return kind, torch.eye(4, dtype=torch.float64, device="cpu"), along_z @ along_x


def _number(value: float | int | str, name: str, key: str) -> Tensor:
    number = checks.real(value, name)
    if key in ("theta", "alpha") and abs(number) > 2 * math.pi + 1e-9:
        raise ValueError(
            f"{name} is {number:g} rad, more than a full turn; angles are in radians: "
            f"math.radians({number:g}) if these are degrees"
        )
    return torch.tensor(number, dtype=torch.float64, device="cpu")


def _screw_along_z(T: Tensor, kind: JointKind) -> Tensor:
    z, p = T[:3, 2], T[:3, 3]
    if kind == "prismatic":
        return torch.cat([z, torch.zeros_like(z)])
    return torch.cat([torch.linalg.cross(p, z), z])
