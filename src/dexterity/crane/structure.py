"""The crane's structure: beams, pins, rods and pads, and how far the tip sags under weight and payload.

Section 3.2 of Rouvinen (1999) as far as it goes: pillar, lift arm, jib arm and extension are plane beams, the
ground is a torsion spring, cylinders and the four-bar linkage are rigid rods. Sections, masses and the pads
of the extension are assumptions (``data/robots/patu655.toml``).

All is described by energies and constraints of the nodes' coordinates. The structure is statically
determinate, so that in linear statics the constraints' forces follow from equilibrium alone, and the
displacements from the unit-load theorem with flexibilities of the members that no pose changes.

Examples
--------
Vertical deflection of the tip [mm] under three payloads:

>>> import dexterity as dx
>>> deflection = dx.crane.deflection([0.25, 0.5, 1.0], payload=[0.0, 100.0, 200.0])
>>> [round(1000 * y) for y in deflection[:, 1].tolist()]
[-9, -16, -22]
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import torch
from jaxtyping import Bool, Float64
from torch import Tensor

from dexterity import spatial
from dexterity.crane.beams import Beams, flexibility, gravity_potential, hermite, stiffness, strain_energy
from dexterity.crane.description import Crane, Member, Structure, given_crane
from dexterity.crane.kinematics import posture, require_strokes, tip_position, turned
from dexterity.spatial import TensorLike
from dexterity.spatial.values import on_one_device, require_values

__all__ = [
    "Assembly",
    "LoadResponse",
    "Pad",
    "Pose",
    "deflection",
    "flexible_tip",
    "load_response",
    "require_payload",
]


def deflection(
    strokes: TensorLike, payload: TensorLike, crane: Crane | None = None
) -> Float64[Tensor, "*batch 2"]:
    """Find how far own weight and payload move the tip from where the rigid crane has it, by linear statics.

    Parameters
    ----------
    strokes
        (..., 3) strokes s1, s2, s3 [m].
    payload
        (...) mass at the tip [kg]; its batch axes and those of the strokes are broadcast.
    crane
        Which crane; None for :func:`~dexterity.crane.description.patu655`.

    Returns
    -------
    Along x and y [m]. No gradient is kept.

    Raises
    ------
    ValueError
        If shapes do not fit, a number is not finite, a payload is negative or above the crane's rating, a
        linkage cannot close, or the extension would leave the jib or go through it.
    """
    crane = given_crane(crane)
    payload = require_payload(payload, crane)
    response = load_response(strokes, crane)
    (payload,) = on_one_device(payload=payload, strokes=response.own_weight)[:1]
    spatial.common_batch(payload=payload.shape, strokes=response.own_weight.shape[:-1])
    return response.own_weight + payload[..., None] * response.per_kilogram


def flexible_tip(
    strokes: TensorLike, payload: TensorLike, crane: Crane | None = None
) -> Float64[Tensor, "*batch 2"]:
    """Return where the tip of the flexible crane is: the rigid tip and the :func:`deflection` [m].

    Raises
    ------
    ValueError
        As :func:`deflection`.
    """
    return tip_position(strokes, crane).detach() + deflection(strokes, payload, crane)


class LoadResponse(NamedTuple):
    """What moves the tip, linearly.

    Attributes
    ----------
    own_weight
        (..., 2) displacement of the tip by the crane's own weight [m].
    per_kilogram
        (..., 2) displacement by a payload of 1 kg besides [m/kg].
    """

    own_weight: Tensor
    per_kilogram: Tensor


def load_response(strokes: TensorLike, crane: Crane | None = None) -> LoadResponse:
    """Solve the linear statics of poses (..., 3) once for all payloads.

    Raises
    ------
    ValueError
        As :func:`deflection`.

    References
    ----------
    The unit-load theorem: Timoshenko & Young (1965), Theory of structures, chapter 7.
    """
    crane = given_crane(crane)
    strokes = require_values(require_strokes(strokes), "strokes")
    with torch.inference_mode(False):  # forces are slopes, which are not taken in that mode
        assembly = Assembly.of(crane)
        pieces = strokes.detach().cpu().clone().reshape(-1, 3).split(_POSES_AT_ONCE)
        parts = [assembly.compliance(assembly.placed(piece)) for piece in pieces]
    compliance = torch.cat(parts).to(strokes.device)
    own, per_newton = compliance[:, 1:, 0], compliance[:, 1:, 2]
    batch = strokes.shape[:-1]
    gravity = crane.structure.gravity
    return LoadResponse(own.reshape(*batch, 2), (-gravity * per_newton).reshape(*batch, 2))


_POSES_AT_ONCE = 512  # so that what is worked on stays in a processor's cache


def require_payload(payload: TensorLike, crane: Crane) -> Float64[Tensor, "*batch"]:
    """Return payloads [kg] as a tensor if the crane may lift them.

    Raises
    ------
    ValueError
        If one is not finite, negative, or above the crane's rating.
    """
    payload = require_values(spatial.to_float64(payload, "payload"), "payload")
    if ((payload < 0) | (payload > crane.rating)).any():
        worst = payload[(payload < 0) | (payload > crane.rating)][0].item()
        raise ValueError(f"payload holds {worst} kg; 0 to the rating of {crane.rating} kg is needed")
    return payload


class Pose(NamedTuple):
    """The unloaded structure in N poses, in the world.

    Attributes
    ----------
    nodes
        (N, n, 2) points of the nodes [m].
    angles
        (N, 4) angles of pillar, lift, jib and extension [rad].
    pins
        Points (N, 2) of C, D, E, F, G and H, by these letters [m].
    rear, mouth
        Pads at the extension's rear end and at the jib's mouth.
    """

    nodes: Tensor
    angles: Tensor
    pins: dict[str, Tensor]
    rear: Pad
    mouth: Pad


class Pad(NamedTuple):
    """A node that slides along an element.

    Attributes
    ----------
    node
        The node.
    first, second
        (N, n) ones at the ends of the element that it touches.
    place
        (N) where on the element, as a share of its length.
    """

    node: int
    first: Tensor
    second: Tensor
    place: Tensor


@dataclass(frozen=True, eq=False)
class Assembly:
    """A crane's members put together.

    The coordinates of a structure are those of its nodes, three each, and x and y of the pin H.

    Attributes
    ----------
    crane
        What it is made of.
    beams
        All elements.
    members
        Nodes of pillar, lift, jib and extension.
    flexibilities
        Of each member in its own frame: of the pillar on its spring, of the others held at their first node.
    """

    crane: Crane
    beams: Beams
    members: tuple[slice, ...]
    flexibilities: tuple[Tensor, ...]

    @classmethod
    @lru_cache(maxsize=8)
    @torch.inference_mode(False)  # kept for later calls in every mode
    def of(cls, crane: Crane) -> Assembly:
        """Put a crane together."""
        parts = crane.structure
        rows = (parts.pillar, parts.lift, parts.jib, parts.extension)
        bounds = list(itertools.accumulate((len(row.nodes) for row in rows), initial=0))
        members = tuple(slice(*pair) for pair in itertools.pairwise(bounds))
        flexibilities, beams = [], []
        for row in rows:
            own = _beams(row, parts)
            matrix = stiffness(own, torch.tensor(row.nodes, dtype=torch.float64))
            if row is parts.pillar:
                matrix[2, 2] += parts.ground_stiffness
            flexibilities.append(flexibility(matrix, [0, 1] if row is parts.pillar else [0, 1, 2]))
            beams.append(own)
        ends = torch.cat([own.ends + start for own, start in zip(beams, bounds[:-1], strict=True)])
        values = (torch.cat([own[i] for own in beams]) for i in (1, 2, 3))
        return cls(crane, Beams(ends, *values), members, tuple(flexibilities))

    @property
    def size(self) -> int:
        """Number of coordinates."""
        return 3 * self.members[-1].stop + 2

    @property
    def free(self) -> Bool[Tensor, " size"]:
        """Coordinates that are free, all but the place of the pillar's foot."""
        free = torch.ones(self.size, dtype=torch.bool)
        free[:2] = False
        return free

    def placed(self, strokes: Float64[Tensor, "N 3"]) -> Pose:
        """Return the unloaded structure for strokes [m].

        Raises
        ------
        ValueError
            If a linkage cannot close, or the extension would leave the jib or go through it.
        """
        links, parts = self.crane.linkage, self.crane.structure
        tip = tip_position(strokes, self.crane)
        self._require_in_jib(strokes[:, 2])
        place = posture(strokes, self.crane)
        base = tip.new_tensor(links.lift_joint).expand_as(tip)
        still = torch.zeros_like(place.lift)
        elbow = base + turned(place.lift, links.jib_joint)
        angles = torch.stack([still, place.lift, place.jib, place.jib], dim=-1)
        rows = (parts.pillar, parts.lift, parts.jib, parts.extension)
        origins = (torch.zeros_like(tip), base, elbow, tip)
        nodes = torch.cat([
            origin[:, None] + turned(angle[:, None], torch.tensor(row.nodes, dtype=torch.float64))
            for origin, angle, row in zip(origins, angles.unbind(-1), rows, strict=True)
        ], dim=1)  # fmt: skip
        pins = {
            "C": tip.new_tensor(links.lift_cylinder_foot).expand_as(tip),
            "D": base + turned(place.lift, links.lift_cylinder_rod),
            "E": base + turned(place.lift, links.jib_cylinder_foot),
            "F": base + turned(place.lift, links.crank_joint),
            "G": elbow,
            "H": base + turned(place.lift, place.crank_pin),
        }
        jib, extension = self.members[2], self.members[3]
        rear = self._pad(nodes, extension.start, jib, place.jib)
        mouth = self._pad(nodes, jib.stop - 1, extension, place.jib)
        return Pose(nodes, angles, pins, rear, mouth)

    def _require_in_jib(self, s3: Tensor) -> None:
        overlap = self.crane.structure.extension.nodes[-1][0] - self.crane.structure.extension.nodes[0][0]
        outside = (s3 < -1e-9) | (s3 >= overlap)
        if outside.any():
            raise ValueError(
                f"strokes holds s3 = {s3[outside][0].item()} m; "
                f"the extension is in the jib from 0 to {overlap} m"
            )

    def _pad(self, nodes: Tensor, node: int, member: slice, angle: Tensor) -> Pad:
        """Find the element of a member that a node touches."""
        along = turned(angle, (1.0, 0.0))
        stations = ((nodes[:, member] - nodes[:, node, None]) * along[:, None]).sum(-1)
        inner = stations[:, 1:-1]
        first = member.start + (inner <= 0).sum(-1)
        ones = torch.nn.functional.one_hot(first, nodes.shape[1]).to(nodes.dtype)
        a, b = (_picked(some, nodes) for some in (ones, ones.roll(1, dims=-1)))
        place = ((nodes[:, node] - a) * (b - a)).sum(-1) / (b - a).square().sum(-1)
        return Pad(node, ones, ones.roll(1, dims=-1), place)

    # ---- energies and constraints ----

    def strain_energy(self, pose: Pose, q: Float64[Tensor, "N size"]) -> Float64[Tensor, " N"]:
        """Energy of beams and ground [J], co-rotational."""
        nodal = self._nodal(q)
        return (
            strain_energy(self.beams, pose.nodes, nodal)
            + self.crane.structure.ground_stiffness / 2 * nodal[:, 0, 2].square()
        )

    def gravity_potential(self, pose: Pose, q: Float64[Tensor, "N size"]) -> Float64[Tensor, " N"]:
        """Potential of the crane's own weight [J]."""
        parts = self.crane.structure
        ends = self._ends(pose)
        lift_half, jib_half = parts.lift_cylinder_mass / 2, parts.jib_cylinder_mass / 2
        masses = {"C": lift_half, "D": lift_half, "E": jib_half, "H": jib_half + parts.linkage_mass}
        lumps = sum(mass * parts.gravity * _carried(ends[pin], pose, q)[:, 1] for pin, mass in masses.items())
        return gravity_potential(self.beams, pose.nodes, self._nodal(q)) + lumps

    def tip(self, q: Float64[Tensor, "N size"]) -> Float64[Tensor, "N 2"]:
        """Displacement of the tip [m]."""
        return self._nodal(q)[:, -1, :2]

    def constraints(self, pose: Pose, q: Float64[Tensor, "N size"]) -> Float64[Tensor, "N c"]:
        """Gaps [m] of the pins at B and G, of the rods CD, EH, FH, IH and extension, and of both pads."""
        at = {name: _carried(end, pose, q) for name, end in self._ends(pose).items()}
        pins = [at[a] - at[b] for a, b in _PINS]
        rods = [_rod_gap(at[a], at[b], *(self._ends(pose)[name].point for name in (a, b))) for a, b in _RODS]
        gaps = rods + [self._pad_gap(pad, pose, q) for pad in (pose.rear, pose.mouth)]
        return torch.cat([*pins, torch.stack(gaps, dim=-1)], dim=-1)

    def _nodal(self, q: Tensor) -> Tensor:
        return q[:, :-2].unflatten(-1, (-1, 3))

    def _ends(self, pose: Pose) -> dict[str, _End]:
        """Points at which pins and rods take hold: those of the linkage, and nodes that have none beside."""
        pillar, lift, jib, extension = self.members
        holders = {"C": pillar.start + 1, "D": lift.start + 1, "E": lift.start + 3, "F": lift.start + 5}
        holders |= {"G": jib.start + 1}
        ends = {
            pin: _End(node, pose.pins[pin], pose.pins[pin] - pose.nodes[:, node])
            for pin, node in holders.items()
        }
        ends["H"] = _End(None, pose.pins["H"], torch.zeros_like(pose.pins["H"]))
        nodes = {
            "pillar": pillar.stop - 1, "lift": lift.start, "elbow": lift.stop - 1,
            "I": jib.start, "mouth": jib.stop - 1, "rear": extension.start,
        }  # fmt: skip
        for name, node in nodes.items():
            point = pose.nodes[:, node]
            ends[name] = _End(node, point, torch.zeros_like(point))
        return ends

    def _pad_gap(self, pad: Pad, pose: Pose, q: Tensor) -> Tensor:
        """Distance of a pad's node from the bent element, along the normal of its chord, less what it was."""
        nodal = self._nodal(q)
        nodes = pose.nodes + nodal[..., :2]
        a, b = (_picked(some, nodes) for some in (pad.first, pad.second))
        a0, b0 = (_picked(some, pose.nodes) for some in (pad.first, pad.second))
        before, after = b0 - a0, b - a
        length = before.norm(dim=-1)
        turn = torch.atan2(_cross(before, after), (before * after).sum(-1))
        tilts = torch.stack([_picked(some, nodal)[:, 2] - turn for some in (pad.first, pad.second)], dim=-1)
        bow = length * (hermite(pad.place) * tilts).sum(-1)
        gap = _cross(after, nodes[:, pad.node] - a) / after.norm(dim=-1)
        return gap - _cross(before, pose.nodes[:, pad.node] - a0) / length - bow

    # ---- linear statics ----

    def compliance(self, pose: Pose) -> Float64[Tensor, "N 3 3"]:
        """Work [J] that loads do on each other's displacements: own weight, and 1 N along x and y at the tip.

        Below the first of a column is the displacement of the tip by its load [m].
        """
        forces = self.nodal_forces(pose)
        total = torch.zeros(len(forces), 3, 3, dtype=torch.float64)
        for member, angle, matrix in zip(
            self.members, pose.angles.unbind(-1), self.flexibilities, strict=True
        ):
            own = forces[:, 3 * member.start : 3 * member.stop].unflatten(1, (-1, 3)).transpose(-1, -2)
            along = turned(-angle[:, None, None], own[..., :2])
            own = torch.cat([along, own[..., 2:]], dim=-1).transpose(-1, -2).flatten(1, 2)
            total += own.mT @ (matrix @ own)
        return total

    def nodal_forces(self, pose: Pose) -> Float64[Tensor, "N size 3"]:
        """Return the loads with what pins, rods and pads add to them: each member is in equilibrium.

        In the columns: own weight, 1 N along x and 1 N along y at the tip.
        """
        loads, rows = self._loads(pose), self.constraint_rows(pose)
        modes = self._rigid_modes(pose)
        forces = torch.linalg.solve((rows @ modes).mT, -modes.mT @ loads)
        return loads + rows.mT @ forces

    def constraint_rows(self, pose: Pose) -> Float64[Tensor, "N c size"]:
        """Differentiate the constraints by the coordinates at rest."""
        rows = pose.nodes.new_zeros(len(pose.nodes), 2 * len(_PINS) + len(_RODS) + 2, self.size)
        ends = self._ends(pose)
        x, y = torch.eye(2, dtype=torch.float64)
        pulls = [(pin, axis) for pin in _PINS for axis in (-x, -y)]
        for rod in _RODS:
            along = ends[rod[1]].point - ends[rod[0]].point
            pulls.append((rod, along / along.norm(dim=-1, keepdim=True)))
        for i, ((a, b), direction) in enumerate(pulls):
            _pull(rows[:, i], ends[a], -direction)
            _pull(rows[:, i], ends[b], direction)
        for i, pad in enumerate((pose.rear, pose.mouth)):
            rows[:, len(pulls) + i, :-2] = _pad_row(pad, pose).flatten(1)
        return rows

    def _loads(self, pose: Pose) -> Tensor:
        with torch.enable_grad():
            q = torch.zeros(len(pose.nodes), self.size, dtype=torch.float64, requires_grad=True)
            (slope,) = torch.autograd.grad(self.gravity_potential(pose, q).sum(), q)
        loads = slope.new_zeros(*slope.shape, 3)
        loads[..., 0] = -slope
        tip = 3 * (self.members[-1].stop - 1)
        loads[:, tip, 1] = loads[:, tip + 1, 2] = 1.0
        return loads

    def _rigid_modes(self, pose: Pose) -> Tensor:
        """Motions (N, size, 11) of lift, jib and extension as rigid bodies, and of H."""
        modes = pose.nodes.new_zeros(len(pose.nodes), self.size, 11)
        for i, member in enumerate(self.members[1:]):
            own = modes[:, 3 * member.start : 3 * member.stop, 3 * i : 3 * i + 3].unflatten(1, (-1, 3))
            own[:, :, [0, 1, 2], [0, 1, 2]] = 1.0
            arms = pose.nodes[:, member] - pose.nodes[:, member.start, None]
            own[:, :, 0, 2], own[:, :, 1, 2] = -arms[..., 1], arms[..., 0]
        modes[:, -2, 9] = modes[:, -1, 10] = 1.0
        return modes


class _End(NamedTuple):
    """A point (N, 2) and the arm (N, 2) by which a node carries it; without a node, the pin H itself."""

    node: int | None
    point: Tensor
    arm: Tensor


_PINS = (("pillar", "lift"), ("elbow", "G"))
_RODS = (("C", "D"), ("E", "H"), ("F", "H"), ("I", "H"), ("rear", "mouth"))


def _carried(end: _End, pose: Pose, q: Tensor) -> Tensor:
    """Where an end is when the coordinates are q (N, size)."""
    if end.node is None:
        return end.point + q[:, -2:]
    own = q[:, 3 * end.node : 3 * end.node + 3]
    return pose.nodes[:, end.node] + own[:, :2] + turned(own[:, 2], end.arm)


def _pull(row: Tensor, end: _End, direction: Tensor) -> None:
    """Add to a row (N, size) how far an end moves along a direction."""
    if end.node is None:
        row[:, -2:] += direction
    else:
        row[:, 3 * end.node : 3 * end.node + 2] += direction
        row[:, 3 * end.node + 2] += _cross(end.arm, direction)


def _pad_row(pad: Pad, pose: Pose) -> Tensor:
    """Differentiate a pad's gap at rest (N, n, 3): what its node moves less what the bent element does."""
    a, b = (_picked(some, pose.nodes) for some in (pad.first, pad.second))
    length = (b - a).norm(dim=-1)
    tangent = (b - a) / length[:, None]
    normal = torch.stack([-tangent[:, 1], tangent[:, 0]], dim=-1)
    tilts = hermite(pad.place)
    share = (pad.place - tilts.sum(-1))[:, None]
    turns = -length[:, None] * tilts
    first = torch.cat([-(1 - share) * normal, turns[:, :1]], dim=-1)
    second = torch.cat([-share * normal, turns[:, 1:]], dim=-1)
    row = pad.first[..., None] * first[:, None] + pad.second[..., None] * second[:, None]
    row[:, pad.node, :2] += normal
    return row


def _beams(row: Member, parts: Structure) -> Beams:
    """Elements of a member, numbered from its first node."""
    area, moment = (torch.tensor(values, dtype=torch.float64) for values in (row.areas, row.second_moments))
    first = torch.arange(len(row.tubes))
    return Beams(
        torch.stack([first, first + 1], dim=-1),
        parts.youngs_modulus * area,
        parts.youngs_modulus * parts.bending_factor * moment,
        parts.density * parts.gravity * area,
    )


def _rod_gap(a: Tensor, b: Tensor, a0: Tensor, b0: Tensor) -> Tensor:
    """Change of a squared length over twice the length: to first order, how much longer the rod is."""
    before = (b0 - a0).square().sum(-1)
    return ((b - a).square().sum(-1) - before) / (2 * before.sqrt())


def _picked(ones: Tensor, rows: Tensor) -> Tensor:
    """Row of each pose (N, n, k) where there is a one (N, n)."""
    return (ones[:, None] @ rows)[:, 0]


def _cross(a: Tensor, b: Tensor) -> Tensor:
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]
