"""A crane as it stands in a yard: pins that are a little off, with play, another stiffness, coarse sensors.

The controller knows a model. The existing crane differs from it by draws from a generator, so that methods
can be tried on many cranes, none of which is the model.

Play is taken up by the load. Let a joint give way by d, and let λ be the force with which it holds, in the
sense of d: then the potential energy changes by λ·d, and the joint rests where this is least, against the end
of its play. What that does to the tip follows from the force λₑ with which the joint holds 1 N at the tip,
since the work is the same: u = −λₑ·d. The structure is statically determinate, so that all of this is
equilibrium, and exact to first order in the play.

Examples
--------
>>> import torch
>>> import dexterity as dx
>>> differences = dx.crane.Differences(play=0.001)
>>> crane = dx.crane.existing_crane(differences, torch.Generator().manual_seed(0))
>>> strokes, payload = torch.tensor([[0.25, 0.5, 1.0]]).double(), torch.ones(1).double()
>>> bool(crane.seating(strokes, payload).norm() > 0.001)
True
"""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import torch
from jaxtyping import Float64
from torch import Tensor

from dexterity import checks
from dexterity.checks import Instance, Real
from dexterity.crane.description import Crane, Linkage, Member, Point, Structure, given_crane
from dexterity.crane.kinematics import require_strokes, tip_position
from dexterity.crane.structure import Assembly, Pose, deflection, require_payload
from dexterity.spatial import TensorLike
from dexterity.spatial.values import on_cpu

__all__ = ["JOINTS", "Differences", "ExistingCrane", "JointForces", "existing_crane", "joint_forces"]

JOINTS = ("B", "G", "CD", "EH", "FH", "IH", "extension cylinder", "rear pad", "mouth pad")
"""What has play, which is two pins, five rods with a pin at either end, and two pads."""

_PINS_AT = (1, 1, 2, 2, 2, 2, 2, 1, 1)


@dataclass(frozen=True)
class Differences:
    """How far an existing crane may be from its model; nothing by default.

    Attributes
    ----------
    misalignment
        Largest offset of a pin along either axis, and of a rod's length [m].
    play
        Largest play of a pin or a pad, from one end to the other [m].
    stiffness
        Largest share by which the bending factor and the ground's stiffness are off.
    stroke_step, reading_step
        What strokes are driven to multiples of, and what the tip is read to [m]; 0 for exactly.

    Raises
    ------
    ValueError
        If a number is negative, or the stiffness may come to nothing.
    """

    misalignment: float = 0.0
    play: float = 0.0
    stiffness: float = 0.0
    stroke_step: float = 0.0
    reading_step: float = 0.0

    def __post_init__(self) -> None:
        checks.fields(
            self,
            misalignment=Real(least=0),
            play=Real(least=0),
            stiffness=Real(least=0, below=1),
            stroke_step=Real(least=0),
            reading_step=Real(least=0),
        )


@dataclass(frozen=True)
class ExistingCrane:
    """A crane that is not quite its model.

    Attributes
    ----------
    built
        Its linkage and structure.
    play
        How far each of `JOINTS` can move from one end to the other, both pins of a rod together [m].
    stroke_step, reading_step
        As in :class:`Differences` [m].
    zeros
        (11) where in its play each joint is taken to be by the model: x and y of both pins, the rods, the
        pads; 0 for the middle, 1 and -1 for its ends.
    """

    built: Crane
    play: tuple[float, ...]
    stroke_step: float = 0.0
    reading_step: float = 0.0
    zeros: tuple[float, ...] = (0.0,) * 11

    def __post_init__(self) -> None:
        checks.fields(self, built=Instance(Crane), stroke_step=Real(least=0), reading_step=Real(least=0))
        for name, count, least in (("play", len(JOINTS), 0.0), ("zeros", 11, None)):
            lengths = Instance((tuple, list))(getattr(self, name), name)
            if len(lengths) != count:
                raise ValueError(f"{name} has {len(lengths)} lengths; there are {count} joints")
            finite = tuple(Real(least)(length, f"{name}[{i}]") for i, length in enumerate(lengths))
            object.__setattr__(self, name, finite)

    def tip(self, strokes: Float64[Tensor, "N 3"], payload: Float64[Tensor, " N"]) -> Float64[Tensor, "N 2"]:
        """Return where the loaded tip comes to rest [m] if it is driven to strokes (N, 3) [m].

        Raises
        ------
        ValueError
            As :func:`~dexterity.crane.structure.deflection`.
        """
        strokes, payload = _rows(strokes, payload, self.built)
        driven = _rounded(strokes, self.stroke_step)
        rigid = tip_position(driven, self.built)
        return rigid + deflection(driven, payload, self.built) + self.seating(driven, payload)

    def reading(
        self, strokes: Float64[Tensor, "N 3"], payload: Float64[Tensor, " N"]
    ) -> Float64[Tensor, "N 2"]:
        """Return what is read of the :meth:`tip` [m]."""
        return _rounded(self.tip(strokes, payload), self.reading_step)

    def seating(
        self, strokes: Float64[Tensor, "N 3"], payload: Float64[Tensor, " N"]
    ) -> Float64[Tensor, "N 2"]:
        """Return how far play lets the tip move under load [m].

        Raises
        ------
        ValueError
            As :func:`joint_forces`.
        """
        strokes, payload = _rows(strokes, payload, self.built)
        if not any(self.play):
            return torch.zeros_like(strokes[:, :2])
        held = _held(strokes, self.built)
        first, second, *others = self.play
        slack = strokes.new_tensor([first, first, second, second, *others]) / 2
        moved = _ends(_under(held, payload, self.built)) - strokes.new_tensor(self.zeros)
        return (held[..., 1:] * (slack * moved)[..., None]).sum(1)

    def zeroed(self, strokes: Float64[Tensor, "3"], payload: float = 0.0) -> ExistingCrane:
        """Return the same crane with its model set right where it stands at strokes (3,) [m] with a payload.

        Its play is then taken to be where the load has it there, which matters where the load has it on the
        other side. How the lower arm turns in between is left out of account.

        Raises
        ------
        ValueError
            As :func:`joint_forces`.
        """
        strokes, masses = _rows(require_strokes(strokes)[None], [payload], self.built)
        ends = _ends(_under(_held(strokes, self.built), masses, self.built))
        return dataclasses.replace(self, zeros=tuple(ends[0].tolist()))


def existing_crane(
    differences: Differences, generator: torch.Generator, model: Crane | None = None
) -> ExistingCrane:
    """Draw a crane that differs from a model.

    The draws are the same whatever the differences are; they are scaled by them. With the same generator a
    crane that is only misaligned has the pins of one that has play besides.

    Parameters
    ----------
    differences
        How far it may be from the model.
    generator
        Source of randomness.
    model
        What it should be; None for :func:`~dexterity.crane.description.patu655`.
    """
    checks.instance(differences, "differences", Differences)
    checks.instance(generator, "generator", torch.Generator)
    model = given_crane(model, "model")
    pins = torch.rand(len(_PINS), 2, generator=generator, dtype=torch.float64) * 2 - 1
    rods = torch.rand(len(_RODS), generator=generator, dtype=torch.float64) * 2 - 1
    soft = torch.rand(2, generator=generator, dtype=torch.float64) * 2 - 1
    loose = torch.rand(len(JOINTS), 2, generator=generator, dtype=torch.float64)
    loose[:, 1] *= torch.tensor(_PINS_AT) - 1
    bending, ground = (1 + differences.stiffness * soft).tolist()
    built = _misaligned(model, differences.misalignment * pins, differences.misalignment * rods)
    parts = dataclasses.replace(
        built.structure,
        bending_factor=bending * model.structure.bending_factor,
        ground_stiffness=ground * model.structure.ground_stiffness,
    )
    return ExistingCrane(
        dataclasses.replace(built, structure=parts),
        tuple((differences.play * loose.sum(1)).tolist()),
        differences.stroke_step,
        differences.reading_step,
    )


class JointForces(NamedTuple):
    """With what forces joints hold the crane [N], in the order of `JOINTS`.

    Attributes
    ----------
    pins
        (N, 2, 2) of B on the lift arm and of G on the jib, along x and y.
    rods
        (N, 5) of CD, EH, FH, IH and extension cylinder, positive where they push.
    pads
        (N, 2) of rear and mouth, positive where they press the pad's node upwards along the arm's normal.
    """

    pins: Tensor
    rods: Tensor
    pads: Tensor


def joint_forces(
    strokes: Float64[Tensor, "N 3"], payload: Float64[Tensor, " N"], crane: Crane | None = None
) -> JointForces:
    """Find what joints hold under the crane's own weight and a payload.

    Parameters
    ----------
    strokes
        (N, 3) strokes [m].
    payload
        (N) [kg].
    crane
        Which crane; None for :func:`~dexterity.crane.description.patu655`.

    Raises
    ------
    ValueError
        As :func:`~dexterity.crane.structure.deflection`.
    """
    crane = given_crane(crane)
    strokes, payload = _rows(strokes, payload, crane)
    total = _under(_held(strokes, crane), payload, crane)
    # A pin's gap is counted from the outer arm to the inner one; the extension comes out as its rod shrinks.
    rods = torch.cat([total[:, 4:8], -total[:, 8:9]], dim=-1)
    return JointForces(-total[:, :4].unflatten(1, (2, 2)), rods, total[:, 9:])


# ---- forces ----------------------------------------------------------------------------------------


def _rows(strokes: TensorLike, payload: TensorLike, crane: Crane) -> tuple[Tensor, Tensor]:
    """Return strokes (N, 3) and payloads (N), as many of one as of the other."""
    strokes, payload = on_cpu(require_strokes(strokes), "strokes"), require_payload(payload, crane)
    if strokes.ndim != 2 or payload.shape != strokes.shape[:1]:
        raise ValueError(
            f"strokes has shape {tuple(strokes.shape)} and payload {tuple(payload.shape)}; "
            "(N, 3) and (N,) are needed"
        )
    return strokes, payload


def _held(strokes: Tensor, crane: Crane) -> Tensor:
    """Find the forces (N, 11, 3) that hold own weight, and 1 N along x and along y at the tip."""
    with torch.inference_mode(False):  # loads are slopes, which are not taken in that mode
        assembly = Assembly.of(crane)
        pose = assembly.placed(strokes.detach().clone())
        added = assembly.nodal_forces(pose) - _loads(assembly, pose)
        return torch.linalg.lstsq(assembly.constraint_rows(pose).mT, added).solution


def _under(held: Tensor, payload: Tensor, crane: Crane) -> Tensor:
    """Add up the forces (N, 11) under own weight and a payload."""
    weight = crane.structure.gravity * require_payload(payload, crane)
    return held[..., 0] - weight[:, None] * held[..., 2]


def _ends(forces: Tensor) -> Tensor:
    """Tell at which end of its play each joint is, less its sign (N, 11), by the forces (N, 11) that hold."""
    groups = [forces[:, 0:2], forces[:, 2:4], *forces[:, 4:, None].unbind(1)]
    return torch.cat(
        [group / group.norm(dim=-1, keepdim=True).clamp(min=_WEIGHTLESS) for group in groups], dim=-1
    )


_WEIGHTLESS = 1e-12  # [N]


def _loads(assembly: Assembly, pose: Pose) -> Tensor:
    """Own weight, and 1 N along x and along y at the tip, on the coordinates (N, size, 3)."""
    with torch.enable_grad():
        q = torch.zeros(len(pose.nodes), assembly.size, dtype=torch.float64, requires_grad=True)
        works = (-assembly.gravity_potential(pose, q), *assembly.tip(q).unbind(-1))
        slopes = [torch.autograd.grad(work.sum(), q)[0] for work in works]
    return torch.stack(slopes, dim=-1)


# ---- what is built otherwise -----------------------------------------------------------------------

_PINS = (
    "lift_joint", "lift_cylinder_foot", "lift_cylinder_rod", "jib_joint", "crank_joint", "jib_cylinder_foot",
    "coupler_pin", "extension_joint",
)  # fmt: skip
_RODS = ("lift_cylinder_length", "jib_cylinder_length", "crank", "coupler")


def _misaligned(model: Crane, pins: Tensor, rods: Tensor) -> Crane:
    links = model.linkage
    moved = {
        name: _moved(getattr(links, name), step) for name, step in zip(_PINS, pins.tolist(), strict=True)
    }
    lengths = {name: getattr(links, name) + step for name, step in zip(_RODS, rods.tolist(), strict=True)}
    rocker = links.rocker + _length(moved["coupler_pin"]) - _length(links.coupler_pin)
    changes: dict[str, Any] = {**moved, **lengths, "rocker": rocker}
    linkage = dataclasses.replace(links, **changes)
    return dataclasses.replace(model, linkage=linkage, structure=_joined(model.structure, links, linkage))


def _joined(parts: Structure, model: Linkage, built: Linkage) -> Structure:
    """Move the ends of the arms along with the pins that join them."""
    steps = {
        name: tuple(b - a for a, b in zip(getattr(model, name), getattr(built, name), strict=True))
        for name in ("lift_joint", "jib_joint", "coupler_pin", "extension_joint")
    }
    return dataclasses.replace(
        parts,
        pillar=_with_ends(parts.pillar, last=steps["lift_joint"]),
        lift=_with_ends(parts.lift, last=steps["jib_joint"]),
        jib=_with_ends(parts.jib, steps["coupler_pin"], steps["extension_joint"]),
    )


def _with_ends(member: Member, first: tuple[float, ...] = (0, 0), last: tuple[float, ...] = (0, 0)) -> Member:
    nodes = (_moved(member.nodes[0], first), *member.nodes[1:-1], _moved(member.nodes[-1], last))
    return dataclasses.replace(member, nodes=nodes)


def _moved(point: Point, step: list[float] | tuple[float, ...]) -> Point:
    return point[0] + step[0], point[1] + step[1]


def _length(point: Point) -> float:
    return math.hypot(*point)


def _rounded(values: Tensor, step: float) -> Tensor:
    return (values / step).round() * step if step else values
