"""The family of arms of paper C as ECMAScript: what is in reach, one branch, and a network's confidence.

The closed form is printed from the same steps as the C of :mod:`dexterity.workspace.compiled`. A network's
confidence is computed in double precision, see :class:`Confidence`; the network itself computes it in single
precision.

Examples
--------
>>> from dexterity.workspace import export
>>> "export function reachable" in export.javascript_module()
True
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import NamedTuple

import sympy
import torch
from jaxtyping import Float64
from sympy import Expr, S
from torch import Tensor

from dexterity import checks, spatial
from dexterity.codegen.ecmascript import Exported, program_module
from dexterity.codegen.printing import template
from dexterity.program import Program, Recorder
from dexterity.spatial import TensorLike
from dexterity.spatial.values import on_cpu
from dexterity.workspace.closed_form import LINKS, PARTS, POSE, derive, part
from dexterity.workspace.jacobian_net import JacobianNet
from dexterity.workspace.reachability import LINK_NAMES, NAMED_BRANCH, TWISTS, Branch

__all__ = ["Confidence", "Layer", "confidence_module", "javascript_module", "margins", "origins"]


# ---- the closed form -------------------------------------------------------------------------------


def margins() -> Program:
    """Record by how much a position is in reach, from d₃, d₄, a₂, a₃ and x, y, z.

    Returns
    -------
    A program of three numbers [m²], all of them at least 0 if and only if the position is in reach: from the
    cylinder about the first axis, from the inner sphere about the shoulder, and to the outer one. See
    :mod:`dexterity.workspace.reachability`.
    """
    d3, d4, a2, a3 = LINKS
    x, y, z = sympy.symbols("x y z", real=True)
    record = Recorder()
    across = record(record(x**2) + record(y**2))
    far = record(record(across + record(z**2)) - record(d3**2))
    forearm = record(sympy.sqrt(record(record(a3**2) + record(d4**2))))
    inner, outer = record(record(a2 - forearm) ** 2), record(record(a2 + forearm) ** 2)
    return record.program((*LINKS, x, y, z), [across - record(d3**2), far - inner, outer - far])


@checks.arguments(branch=checks.Instance(Branch))
def origins(branch: Branch = NAMED_BRANCH) -> Program:
    """Record where the frames of the links are on a branch, from links and pose.

    Returns
    -------
    A program of (7, 3) numbers [m], the base first and the tool last; NaN where the pose is out of reach.
    """
    solved = derive(branch)
    record = Recorder()
    known = record.follow(solved)
    cosines, sines = (
        [x.xreplace(known) for x in solved.outputs[PARTS[name]]] for name in ("cosines", "sines")
    )
    d3, d4, a2, a3 = LINKS
    x, y, z = ([S(int(i == j)) for j in range(3)] for i in range(3))
    point: list[Expr] = [S.Zero] * 3
    points = [*point]
    lengths = zip((0, 0, d3, d4, 0, 0), (0, a2, a3, 0, 0, 0), TWISTS, strict=True)
    for (d, a, twist), c, s in zip(lengths, cosines, sines, strict=True):
        x, y = _sum(record, x, c, y, s), _sum(record, y, c, x, -s)
        point = [
            record(p + record(a * along) + record(d * up)) for p, along, up in zip(point, x, z, strict=True)
        ]
        # A twist is a quarter turn about x or none.
        minus = [-value for value in y], [-value for value in z]
        y, z = (y, z) if twist == 0 else (z, minus[0]) if twist > 0 else (minus[1], y)
        points += point
    return record.program((*LINKS, *POSE), points)


def _sum(record: Recorder, a: list[Expr], c: Expr, b: list[Expr], s: Expr) -> list[Expr]:
    return [record(record(c * p) + record(s * q)) for p, q in zip(a, b, strict=True)]


@checks.arguments(branch=checks.Instance(Branch))
def javascript_module(branch: Branch = NAMED_BRANCH) -> str:
    """Return an ECMAScript module of the closed form for all arms of the family.

    It exports ``margins([links, position])`` and ``reachable(links, position)``, and for one branch
    ``cosines``, ``sines``, ``jacobian``, ``manipulability`` and ``origins`` of ``[links, pose]``. Poses are
    nested 4 × 4 arrays.
    """
    solved = derive(branch)
    functions = {
        "margins": Exported(margins(), (3,), "Margins of the rule of reach [m^2], of links and a position."),
        "cosines": Exported(
            part(solved, "cosines"), (6,), "Cosines of the joint angles, of links and a pose."
        ),
        "sines": Exported(part(solved, "sines"), (6,), "Sines of the joint angles, of links and a pose."),
        "jacobian": Exported(part(solved, "jacobian"), (6, 6), "Geometric Jacobian of the tool point."),
        "manipulability": Exported(part(solved, "manipulability"), (), "Size of its determinant [m^3]."),
        "origins": Exported(origins(branch), (7, 3), "Origins of the frames [m], from the base to the tool."),
    }
    code = (
        "// Whether a position is in reach, with any orientation of the tool.\n"
        "export function reachable(links, position) {\n"
        "  return margins([links, position]).every((margin) => margin >= 0);\n}\n"
    )
    lines = [
        "The arms of Liao & Mao (2018) in closed form, generated by dexterity.",
        f"Links: {', '.join(LINK_NAMES)} [m]. Out of reach the numbers of a branch are NaN.",
    ]
    return program_module(lines, {"links": LINK_NAMES, "branch": branch._asdict()}, functions, code)


# ---- a network's confidence ------------------------------------------------------------------------


class Layer(NamedTuple):
    """A dense layer and what follows it.

    Attributes
    ----------
    weights, biases
        (outer, inner) and (outer).
    slope
        (outer) factor of negative values; 1 where nothing follows.
    """

    weights: Float64[Tensor, "outer inner"]
    biases: Float64[Tensor, " outer"]
    slope: Float64[Tensor, " outer"]


@dataclass(frozen=True)
class Confidence:
    """The confidence of a :class:`~dexterity.workspace.jacobian_net.JacobianNet`, in double precision.

    Attributes
    ----------
    inputs
        Kind of the inputs: ``"rotation"`` or ``"plane"``.
    centre, unit
        Scaling of the inputs.
    layers
        Encoder and head; normalisation is worked into the weights.
    """

    inputs: str
    centre: Float64[Tensor, " width"]
    unit: Float64[Tensor, " width"]
    layers: tuple[Layer, ...]

    @classmethod
    @checks.arguments(network=checks.Instance(JacobianNet))
    def of(cls, network: JacobianNet) -> Confidence:
        """Take the confidence of a network.

        Raises
        ------
        ValueError
            If the inputs of the network are not those of a pose.
        """
        if network.inputs not in ("rotation", "plane"):
            raise ValueError(f"inputs are {network.inputs!r}; 'rotation' and 'plane' can be exported")
        scaling = network.scaling("in")
        layers = tuple(_layers([*network.encoder, *network.confidence]))
        return cls(network.inputs, scaling.centre, scaling.unit, layers)

    def __call__(self, links: TensorLike, T_base_tool: TensorLike) -> Float64[Tensor, "*batch"]:
        """Confidence from 0 to 1 that poses (..., 4, 4) are in reach of arms with links (..., 4) [m]."""
        links = spatial.batch_of(on_cpu(links, "links"), "links", (4,))
        T = spatial.batch_of(on_cpu(T_base_tool, "T_base_tool"), "T_base_tool", (4, 4))
        batch = spatial.common_batch(links=links.shape[:-1], T_base_tool=T.shape[:-2])
        links, position = links.expand(*batch, 4), T[..., :3, 3].expand(*batch, 3)
        if self.inputs == "plane":
            across = torch.hypot(position[..., 0], position[..., 1])[..., None]
            x = torch.cat([links, across, position[..., 2:]], -1)
        else:
            x = torch.cat([links, position, T[..., :3, :3].expand(*batch, 3, 3).flatten(-2)], -1)
        x = (x - self.centre) / self.unit
        for weights, biases, slope in self.layers:
            x = x @ weights.mT + biases
            x = torch.where(x < 0, slope * x, x)
        return x[..., 0].sigmoid()


def _layers(parts: list[torch.nn.Module]) -> list[Layer]:
    layers: list[Layer] = []
    for module in parts:
        if isinstance(module, torch.nn.Linear):
            weights, biases = (_numbers(values) for values in (module.weight, module.bias))
            layers.append(Layer(weights, biases, torch.ones_like(biases)))
        elif isinstance(module, torch.nn.BatchNorm1d):
            scale = _numbers(module.weight) / (_numbers(module.running_var) + module.eps).sqrt()
            last = layers[-1]
            shifted = scale * (last.biases - _numbers(module.running_mean)) + _numbers(module.bias)
            layers[-1] = Layer(scale[:, None] * last.weights, shifted, last.slope)
        elif isinstance(module, torch.nn.PReLU):
            last = layers[-1]
            layers[-1] = last._replace(slope=_numbers(module.weight).expand_as(last.biases))
    return layers


def _numbers(values: Tensor | None) -> Tensor:
    if values is None:
        raise ValueError("a layer of the network has no weights of its own")
    return values.detach().double().cpu()


@checks.arguments(confidence=checks.Instance(Confidence))
def confidence_module(confidence: Confidence) -> str:
    """Return an ECMAScript module that exports ``confidence(links, pose)``; the pose is a 4 × 4 array."""
    code = template("confidence.js.in").substitute(
        plane=json.dumps(confidence.inputs == "plane"),
        centre=confidence.centre.tolist(),
        unit=confidence.unit.tolist(),
        layers=json.dumps([[part.tolist() for part in layer] for layer in confidence.layers]),
    )
    widths = ", ".join(str(len(layer.biases)) for layer in confidence.layers)
    lines = [
        "Confidence of a network that a pose is in reach, generated by dexterity.",
        f"Inputs: {confidence.inputs}. Widths of the layers: {widths}.",
    ]
    return program_module(lines, {"inputs": confidence.inputs, "links": LINK_NAMES}, {}, code)
