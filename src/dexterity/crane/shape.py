"""The shape of a loaded crane: where all its nodes go, and the bars that it is drawn with.

By linear statics, as :func:`~dexterity.crane.structure.deflection`, which is what becomes of the last node.

Examples
--------
>>> from dexterity.crane.shape import bars
>>> drawn = bars([0.25, 0.5, 1.0])
>>> sorted(set(drawn.parts))
['cylinders', 'extension', 'jib arm', 'lift arm', 'linkage', 'pillar']
>>> drawn.loaded(200.0, magnified=10.0).shape == drawn.ends.shape
True
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import torch
from jaxtyping import Float64
from torch import Tensor

from dexterity import checks, spatial
from dexterity.crane.description import Crane, given_crane
from dexterity.crane.kinematics import require_strokes, turned
from dexterity.crane.structure import Assembly, Pose, require_payload
from dexterity.spatial import TensorLike
from dexterity.spatial.values import on_cpu

__all__ = ["PARTS", "Bars", "NodalResponse", "bars", "displacements", "nodal_response"]

PARTS = ("pillar", "lift arm", "jib arm", "extension", "cylinders", "linkage")
"""What bars belong to. The cylinder of the extension lies in the jib and is left out."""

_RODS = {"cylinders": (("C", "D"), ("E", "H")), "linkage": (("F", "H"), ("I", "H"))}


class NodalResponse(NamedTuple):
    """What moves the nodes, linearly.

    Attributes
    ----------
    nodes
        (..., n, 2) points of the unloaded crane's nodes [m]: pillar, lift arm, jib arm, extension.
    own_weight
        (..., n, 3) displacement along x and y [m] and turn [rad] by the crane's own weight.
    per_kilogram
        (..., n, 3) the same by a payload of 1 kg besides.
    """

    nodes: Tensor
    own_weight: Tensor
    per_kilogram: Tensor


def nodal_response(strokes: TensorLike, crane: Crane | None = None) -> NodalResponse:
    """Solve the linear statics of poses (..., 3) [m] for all nodes.

    Raises
    ------
    ValueError
        As :func:`~dexterity.crane.structure.deflection`.
    """
    solved = _solved(strokes, crane)
    nodal = solved.moves[:, :-2].unflatten(1, (-1, 3))
    parts = (solved.pose.nodes, nodal[..., 0], nodal[..., 1])
    return NodalResponse(*(solved.in_batch(part) for part in parts))


@dataclass(frozen=True, eq=False)
class Bars:
    """Straight bars from node to node and from pin to pin, and how they move.

    Attributes
    ----------
    parts
        Of `PARTS`, to which each of m bars belongs.
    ends
        (..., m, 2, 2) both ends of each in the unloaded crane [m].
    own_weight, per_kilogram
        (..., m, 2, 2) how far the crane's own weight moves them [m], and a payload of 1 kg besides.
    crane
        Which crane.
    """

    parts: tuple[str, ...]
    ends: Float64[Tensor, "*batch m 2 2"]
    own_weight: Float64[Tensor, "*batch m 2 2"]
    per_kilogram: Float64[Tensor, "*batch m 2 2"]
    crane: Crane

    def loaded(self, payload: TensorLike, magnified: float = 1.0) -> Float64[Tensor, "*batch m 2 2"]:
        """Return the ends under a payload (...) [kg], displacements magnified to be seen.

        Raises
        ------
        ValueError
            If a payload is negative or above the rating, its batch axes do not fit, or the magnification is
            not finite.
        """
        payload = require_payload(payload, self.crane)
        spatial.common_batch(payload=payload.shape, strokes=self.ends.shape[:-3])
        payload = payload[..., None, None, None]
        if not isinstance(magnified, Tensor) or magnified.is_meta:
            magnified = checks.real(magnified, "magnified")
        return self.ends + magnified * (self.own_weight + payload * self.per_kilogram)


def bars(strokes: TensorLike, crane: Crane | None = None) -> Bars:
    """Return the bars that a crane with strokes (..., 3) [m] is drawn with.

    Raises
    ------
    ValueError
        As :func:`~dexterity.crane.structure.deflection`.
    """
    solved = _solved(strokes, crane)
    places = _places(solved)
    parts, ends = zip(*_joined(solved), strict=True)
    at, by_weight, per_kilogram = (
        solved.in_batch(
            torch.stack([torch.stack([places[end][i] for end in pair], dim=1) for pair in ends], 1)
        )
        for i in range(3)
    )
    return Bars(parts, at, by_weight, per_kilogram, solved.assembly.crane)


def displacements(assembly: Assembly, pose: Pose) -> Float64[Tensor, "N size 3"]:
    """Displace all coordinates by linear statics.

    Members bend by their own flexibilities, held at one end; rigid motions of theirs then close pins, rods
    and pads again.

    Returns
    -------
    In the columns: by the crane's own weight, by 1 N along x and by 1 N along y at the tip.
    """
    forces, rows = assembly.nodal_forces(pose), assembly.constraint_rows(pose)
    bent = torch.zeros_like(forces)
    for member, angle, matrix in zip(
        assembly.members, pose.angles.unbind(-1), assembly.flexibilities, strict=True
    ):
        place = slice(3 * member.start, 3 * member.stop)
        own = matrix @ _turned_rows(-angle, forces[:, place])
        bent[:, place] = _turned_rows(angle, own)
    modes = assembly._rigid_modes(pose)
    return bent - modes @ torch.linalg.solve(rows @ modes, rows @ bent)


class _Solved(NamedTuple):
    """N poses of a batch, and displacements (N, size, 2) by own weight and per kilogram."""

    assembly: Assembly
    pose: Pose
    moves: Tensor
    batch: tuple[int, ...]

    def in_batch(self, rows: Tensor) -> Tensor:
        return rows.reshape(*self.batch, *rows.shape[1:])


def _solved(strokes: TensorLike, crane: Crane | None) -> _Solved:
    crane = given_crane(crane)
    strokes = on_cpu(require_strokes(strokes), "strokes").detach()
    with torch.inference_mode(False):
        strokes = strokes.clone()
        assembly = Assembly.of(crane)
        pose = assembly.placed(strokes.reshape(-1, 3))
        moved = displacements(assembly, pose)
    moves = torch.stack([moved[..., 0], -crane.structure.gravity * moved[..., 2]], dim=-1)
    return _Solved(assembly, pose, moves, tuple(strokes.shape[:-1]))


def _places(solved: _Solved) -> dict[str | int, tuple[Tensor, Tensor, Tensor]]:
    """Points (N, 2) of nodes by number and of pins by letter, with their displacements by both loads."""
    nodal = solved.moves[:, :-2].unflatten(1, (-1, 3))
    places: dict[str | int, tuple[Tensor, Tensor, Tensor]] = {
        node: (solved.pose.nodes[:, node], nodal[:, node, :2, 0], nodal[:, node, :2, 1])
        for node in range(nodal.shape[1])
    }
    for pin, end in solved.assembly._ends(solved.pose).items():
        if end.node is None:
            places[pin] = (end.point, solved.moves[:, -2:, 0], solved.moves[:, -2:, 1])
        else:
            across = torch.stack([-end.arm[:, 1], end.arm[:, 0]], dim=-1)
            own, by_load = (nodal[:, end.node, :2, i] + nodal[:, end.node, 2:, i] * across for i in (0, 1))
            places[pin] = (end.point, own, by_load)
    return places


def _joined(solved: _Solved) -> list[tuple[str, tuple[str | int, str | int]]]:
    """Bars by the part that they belong to: beams, arms from nodes to the pins that they carry, rods."""
    members = list(zip(PARTS, solved.assembly.members, strict=False))
    owner = {node: part for part, row in members for node in range(row.start, row.stop)}
    holders = {pin: end.node for pin, end in solved.assembly._ends(solved.pose).items()}
    beams = [(part, (node, node + 1)) for part, row in members for node in range(row.start, row.stop - 1)]
    arms = [(owner[node], (node, pin)) for pin, node in holders.items() if node and pin in solved.pose.pins]
    rods = [(part, pair) for part, pairs in _RODS.items() for pair in pairs]
    return [*beams, *arms, *rods]


def _turned_rows(angle: Tensor, rows: Tensor) -> Tensor:
    """Turn what nodes have in x and y; rows are (N, 3 nodes, columns)."""
    nodal = rows.unflatten(1, (-1, 3)).transpose(-1, -2)
    ahead = turned(angle[:, None, None], nodal[..., :2])
    return torch.cat([ahead, nodal[..., 2:]], dim=-1).transpose(-1, -2).flatten(1, 2)
