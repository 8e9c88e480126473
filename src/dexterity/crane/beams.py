"""Plane Euler–Bernoulli beams: their stiffness, and their energy when they turn far.

A node has three coordinates: displacement along x and y [m] and rotation [rad], counterclockwise. Elements
join two nodes; what is known of them stands in rows. The linear stiffness is the textbook's. The energy is
co-rotational: stretch and bending are measured from the element's own chord, so that rotations may be large
while strains are small.

Examples
--------
A cantilever with EI = 1/3 N·m² and a length of 1 m deflects by 1 m per newton:

>>> import torch
>>> from dexterity.crane.beams import Beams, flexibility, stiffness
>>> one = torch.ones(1, dtype=torch.float64)
>>> beams = Beams(torch.tensor([[0, 1]]), axial=one, bending=one / 3, weight=0 * one)
>>> K = stiffness(beams, torch.tensor([[0.0, 0.0], [1.0, 0.0]], dtype=torch.float64))
>>> round(flexibility(K, held=[0, 1, 2])[4, 4].item(), 6)
1.0
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import torch
from jaxtyping import Float64
from torch import Tensor

__all__ = ["Beams", "flexibility", "gravity_potential", "hermite", "stiffness", "strain_energy"]


class Beams(NamedTuple):
    """Elements between nodes.

    Attributes
    ----------
    ends
        (e, 2) nodes that each joins.
    axial
        (e) EA [N].
    bending
        (e) EI [N·m²].
    weight
        (e) weight per length [N/m].
    """

    ends: Tensor
    axial: Tensor
    bending: Tensor
    weight: Tensor

    def at_ends(self, rows: Float64[Tensor, "*batch n k"]) -> tuple[Tensor, Tensor]:
        """Pick what nodes have (..., n, k) at the first and second ends of elements, (..., e, k) each."""
        # A product, because indexing is slow to differentiate.
        picks = torch.nn.functional.one_hot(self.ends, rows.shape[-2]).to(rows.dtype)
        return picks[:, 0] @ rows, picks[:, 1] @ rows


def stiffness(beams: Beams, nodes: Float64[Tensor, "n 2"]) -> Float64[Tensor, "n_3 n_3"]:
    """Linear stiffness of all beams about the points (n, 2) [m] of their nodes.

    References
    ----------
    Przemieniecki (1968), Theory of matrix structural analysis, section 5.6, without shear.
    """
    total = nodes.new_zeros(3 * len(nodes), 3 * len(nodes))
    for (a, b), axial, bending in zip(beams.ends.tolist(), beams.axial, beams.bending, strict=True):
        along = nodes[b] - nodes[a]
        length = along.norm()
        stretch, tilts = _natural_modes(along / length, length)
        part = axial / length * torch.outer(stretch, stretch)
        part = part + bending / length * (tilts.mT @ tilts.new_tensor([[4.0, 2.0], [2.0, 4.0]]) @ tilts)
        places = [3 * a, 3 * a + 1, 3 * a + 2, 3 * b, 3 * b + 1, 3 * b + 2]
        total[torch.tensor(places)[:, None], torch.tensor(places)] += part
    return total


def _natural_modes(direction: Tensor, length: Tensor) -> tuple[Tensor, Tensor]:
    """Stretch (6) and tilts (2, 6) of the ends against the chord, per coordinate of an element."""
    c, s = direction.tolist()
    stretch = direction.new_tensor([-c, -s, 0.0, c, s, 0.0])
    turn = direction.new_tensor([s, -c, 0.0, -s, c, 0.0]) / length
    tilts = -turn.repeat(2, 1)
    tilts[0, 2] = tilts[1, 5] = 1.0
    return stretch, tilts


def flexibility(stiffness: Float64[Tensor, "n n"], held: Sequence[int]) -> Float64[Tensor, "n n"]:
    """Inverse of a stiffness with some coordinates held, whose rows and columns are zero.

    For loads that are in equilibrium among themselves, what is held does not matter to the work that they do
    on each other's displacements.

    Raises
    ------
    ValueError
        If what is held leaves a mechanism.
    """
    free = [i for i in range(len(stiffness)) if i not in set(held)]
    rows = torch.tensor(free)[:, None]
    factor, failed = torch.linalg.cholesky_ex(stiffness[rows, torch.tensor(free)])
    if failed:
        raise ValueError(f"held is {list(held)}, which leaves a mechanism")
    inverse = torch.zeros_like(stiffness)
    inverse[rows, torch.tensor(free)] = torch.cholesky_inverse(factor)
    return inverse


def strain_energy(
    beams: Beams, nodes: Float64[Tensor, "*#batch n 2"], q: Float64[Tensor, "*#batch n 3"]
) -> Float64[Tensor, "..."]:
    """Energy [J] of beams whose nodes (..., n, 2) [m] are displaced by q (..., n, 3), co-rotationally.

    References
    ----------
    Crisfield (1991), Non-linear finite element analysis of solids and structures, volume 1, section 7.3.
    """
    chord = _chord(beams, nodes, q)
    stretch = chord.stretch.square() * beams.axial / chord.length
    a, b = chord.tilts.unbind(-1)
    bend = (a.square() + a * b + b.square()) * 4 * beams.bending / chord.length
    return (stretch + bend).sum(-1) / 2


def gravity_potential(
    beams: Beams, nodes: Float64[Tensor, "*#batch n 2"], q: Float64[Tensor, "*#batch n 3"]
) -> Float64[Tensor, "..."]:
    """Potential [J] of the beams' own weight along −y; its gradient is the consistent nodal load."""
    (a, b), (q_a, q_b) = beams.at_ends(nodes), beams.at_ends(q)
    after = b + q_b[..., :2] - a - q_a[..., :2]
    middle = (a[..., 1] + q_a[..., 1] + b[..., 1] + q_b[..., 1]) / 2
    # The bow of an element lifts it, by as much on average.
    lift = after[..., 0] * (q_a[..., 2] - q_b[..., 2]) / 12
    return (beams.weight * (b - a).norm(dim=-1) * (middle + lift)).sum(-1)


def hermite(place: Float64[Tensor, "*batch"]) -> Float64[Tensor, "*batch 2"]:
    """Bow of an element of length 1 at a share of its length, per tilt of its first and its second end."""
    return torch.stack([place * (1 - place) ** 2, place**2 * (place - 1)], dim=-1)


class _Chord(NamedTuple):
    """Lengths (..., e) of elements, their stretch (..., e), and tilts (..., e, 2) of ends against them."""

    length: Tensor
    stretch: Tensor
    tilts: Tensor


def _chord(beams: Beams, nodes: Tensor, q: Tensor) -> _Chord:
    (a, b), (q_a, q_b) = beams.at_ends(nodes), beams.at_ends(q)
    before = b - a
    after = before + q_b[..., :2] - q_a[..., :2]
    length = before.norm(dim=-1)
    # The angle between both, and not a difference of two angles, which would jump.
    cross = before[..., 0] * after[..., 1] - before[..., 1] * after[..., 0]
    turn = torch.atan2(cross, (before * after).sum(-1))
    # (l² − L²) / (l + L) keeps its digits where the stretch is small.
    change = after - before
    stretch = (change * (before + after)).sum(-1) / (after.norm(dim=-1) + length)
    return _Chord(length, stretch, torch.stack([q_a[..., 2] - turn, q_b[..., 2] - turn], dim=-1))
