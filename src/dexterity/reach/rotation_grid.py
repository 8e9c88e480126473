r"""Grids of rotations: few of them, and no rotation far from all.

How far a rotation can be from the nearest of a grid is its covering radius. The smallest two grids are the
rotations of a cube and of an icosahedron. Each larger one has the same points about each of the 24 rotations
of a cube: quaternions (1, x, y, z) along a body-centred cubic lattice, drawn out a little towards the edge of
the region that is nearest to the rotation (Karney 2007).

=========== ===== ===== ===== ====== ====== ====== ======
rotations      24    60   216    648   1992   4344   7416
radius [°]   62.8  44.5  37.4   20.9   16.2   12.2    9.9
=========== ===== ===== ===== ====== ====== ====== ======

Examples
--------
>>> import math
>>> from dexterity import reach
>>> grid = reach.rotations(500)
>>> len(grid), round(math.degrees(reach.covering_radius(grid)), 1)
(648, 20.8)
>>> len(reach.rotations(spacing=math.radians(45)))
60

References
----------
Karney (2007), Quaternions in molecular modeling, J. Mol. Graph. Model. 25(5), section 7. Yershova, Jain,
LaValle & Mitchell (2010), Generating uniform incremental grids on SO(3) using the Hopf fibration, IJRR 29(7).
"""

from __future__ import annotations

import functools
import itertools
import math
from typing import NamedTuple

import numpy as np
import torch
from jaxtyping import Float64
from numpy.typing import NDArray
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation
from torch import Tensor

from dexterity import checks, spatial
from dexterity.spatial import TensorLike
from dexterity.spatial.values import on_cpu

__all__ = ["covering_radius", "rotations"]


class _Lattice(NamedTuple):
    """Number of rotations, upper bound of their covering radius [°], distance and stretch of the lattice."""

    size: int
    radius: float
    distance: float
    stretch: float


_GROUPS = {24: ("O", 62.80), 60: ("I", 44.48)}
_LATTICES = (
    _Lattice(216, 37.34, 0.17545, 3.0),
    _Lattice(648, 20.84, 0.16809, 0.0),
    _Lattice(1992, 16.19, 0.12436, 2.0),
    _Lattice(4344, 12.14, 0.09509, 1.5),
    _Lattice(7416, 9.84, 0.07695, 1.5),
)
_RADII = {count: math.radians(radius) for count, (_, radius) in _GROUPS.items()} | {
    lattice.size: math.radians(lattice.radius) for lattice in _LATTICES
}


def rotations(count: int | None = None, *, spacing: float | None = None) -> Float64[Tensor, "r 3 3"]:
    """Return the smallest grid of rotations that has a number of them, or a covering radius.

    Parameters
    ----------
    count
        Least number of rotations, from 1 to 7416.
    spacing
        Largest distance of any rotation from the nearest of the grid [rad], at least 0.172 (9.84°).

    Returns
    -------
    (r, 3, 3) rotations of the tool to the base.

    Raises
    ------
    TypeError
        If neither or both are given, or one is no number.
    ValueError
        If no grid is as fine.
    """
    if (count is None) == (spacing is None):
        raise TypeError("count or spacing is needed, one of them")
    if count is not None:
        least = checks.whole(count, "count", least=1, most=max(_RADII))
        return _grid(next(known for known in _RADII if known >= least)).clone()
    widest, finest = checks.positive(spacing, "spacing"), min(_RADII.values())
    if widest < finest:
        raise ValueError(f"spacing is {widest} rad; the finest grid has {finest:.3f} rad, and 7416 rotations")
    return _grid(next(known for known, radius in _RADII.items() if radius <= widest)).clone()


def covering_radius(rotations: TensorLike) -> float:
    """Return the largest distance of any rotation from the nearest of some rotations [rad].

    Unit quaternions of the rotations, with both signs, are points on a sphere in four dimensions. The facets
    of their convex hull are the empty caps between them, of which the widest counts.

    Parameters
    ----------
    rotations
        (r, 3, 3) rotations.

    Returns
    -------
    An angle up to π; π where the rotations leave a half-space of quaternions empty.

    Raises
    ------
    ValueError
        If the rotations are none, or not of that shape.
    """
    R = on_cpu(rotations, "rotations")
    if R.ndim != 3 or R.shape[1:] != (3, 3) or not len(R):
        raise ValueError(f"rotations has shape {tuple(R.shape)}; (r, 3, 3) with r ≥ 1 is needed")
    R = spatial.require_rotation(R, "rotations")
    quaternions = Rotation.from_matrix(R.detach().numpy()).as_quat()
    points = np.concatenate([quaternions, -quaternions])
    if np.linalg.matrix_rank(points, tol=1e-9) < 4:
        return math.pi
    nearest_facet = -float(ConvexHull(points).equations[:, -1].max())
    return 2 * math.acos(min(nearest_facet, 1.0))


@functools.cache
@torch.inference_mode(False)  # kept for later calls in every mode
def _grid(count: int) -> Tensor:
    if count in _GROUPS:
        grid = Rotation.create_group(_GROUPS[count][0])
    else:
        grid = _about_a_cube(next(lattice for lattice in _LATTICES if lattice.size == count))
    return torch.from_numpy(grid.as_matrix())


def _about_a_cube(lattice: _Lattice) -> Rotation:
    """Return rotations that a lattice puts about each rotation of a cube, without those that coincide."""
    offsets = _lattice_points(lattice.distance, lattice.stretch)
    near = Rotation.from_quat(np.column_stack([offsets, np.ones(len(offsets))]))
    cube = Rotation.create_group("O")
    quaternions = np.concatenate([(turn * near).as_quat() for turn in cube])
    # A quaternion and its negative are one rotation, and have the same products.
    products = np.einsum("ni,nj->nij", quaternions, quaternions).reshape(-1, 16)
    _, first = np.unique(np.round(products, 7), axis=0, return_index=True)
    return Rotation.from_quat(quaternions[np.sort(first)])


def _lattice_points(distance: float, stretch: float) -> NDArray[np.float64]:
    """Return vector parts (k, 3) of quaternions (1, x, y, z) that are nearest to the identity of a cube's."""
    most = math.floor(0.45 / distance) + 1
    numbers = np.array(list(itertools.product(range(-most, most + 1), repeat=3)))
    same_parity = ((numbers - numbers[:, :1]) % 2 == 0).all(axis=1)
    steps = distance * numbers[same_parity].astype(float)
    points: NDArray[np.float64] = np.sinh(stretch * steps) / stretch if stretch else steps
    sizes = np.abs(points)
    within = (sizes.max(axis=1) <= math.sqrt(2) - 1 + 1e-9) & (sizes.sum(axis=1) <= 1 + 1e-9)
    return points[within]
