"""Arguments of a scene, checked by name."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from dexterity import spatial
from dexterity.spatial import TensorLike
from dexterity.spatial.values import on_cpu

__all__ = ["Array", "bar_lengths", "finite_array", "rigid"]

Array: TypeAlias = NDArray[np.float64]


def finite_array(value: TensorLike, name: str, shape: tuple[int, ...]) -> Array:
    """Return a finite array of a shape in which -1 is any length, independent of the original."""
    array: Array = on_cpu(value, name).detach().numpy().copy()
    fits = all(want in (-1, have) for want, have in zip(shape, array.shape, strict=False))
    if array.ndim != len(shape) or not fits:
        wanted = ", ".join("any" if length == -1 else str(length) for length in shape)
        raise ValueError(f"{name} has shape {array.shape}; ({wanted}) is needed")
    return array


def rigid(poses: TensorLike, name: str, shape: tuple[int, ...] = (4, 4)) -> Array:
    """Return rigid poses of a shape, independent of the original."""
    T = finite_array(poses, name, shape)
    spatial.require_rigid(T, name)
    return T


def bar_lengths(ends: Array, name: str) -> Array:
    """Return the lengths (...) of bars (..., 2, 3) [m], none of which is zero."""
    lengths: Array = np.linalg.norm(ends[..., 1, :] - ends[..., 0, :], axis=-1)
    if not (lengths > 0).all():
        raise ValueError(f"{name} has a bar without a length")
    return lengths
