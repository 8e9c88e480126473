"""What exported code computes of a network: all scaling worked into the weights, its view as a program.

Examples
--------
>>> import dexterity as dx
>>> from dexterity.networks import folding
>>> network = dx.networks.load_shipped("uvms-manipulability-feed-forward")
>>> folding.folded(network).hidden.shape
(8, 7)
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
import sympy
from numpy.typing import NDArray
from sympy import Expr, Symbol

from dexterity.derivation import exact
from dexterity.derivation.symbolic_chain import cross
from dexterity.elimination import dot
from dexterity.networks.feed_forward import FeedForward, Readout
from dexterity.networks.network import Network, View
from dexterity.networks.radial_basis import BIAS, RadialBasis
from dexterity.program import Program, Recorder

__all__ = ["EIGENVALUE", "EXPONENTIAL", "Bells", "Folded", "Sigmoids", "folded", "origin_program", "screws"]

Array: TypeAlias = NDArray[np.float64]
"""Numbers of a network."""


@dataclass(frozen=True)
class Sigmoids:
    r"""A feed-forward network, :math:`u = V \tanh(W x + b) + a`, of what is seen in its own units.

    Attributes
    ----------
    hidden, hidden_biases
        (h, r) and (h): W and b.
    output, output_biases
        (m, h) and (m): V and a; m is 3 for a cone, 6 for a triple, else 1.
    readout
        What makes the value of u: itself, 1/u, exp u, or the exponential of the smallest eigenvalue of the
        matrix that a cone or a triple stands for.
    """

    hidden: Array
    hidden_biases: Array
    output: Array
    output_biases: Array
    readout: Readout


@dataclass(frozen=True)
class Bells:
    r"""A radial-basis network, :math:`a + \sum_j v_j \exp(-‖s x - c_j‖^2)`, of what is seen.

    Attributes
    ----------
    scale
        (r) factors s.
    centres
        (h, r) points c.
    output, output_bias
        (h) and (): v and a.
    """

    scale: Array
    centres: Array
    output: Array
    output_bias: float


EXPONENTIAL: tuple[Readout, ...] = ("logarithm", "cone", "triple")
"""Readouts that end with an exponential."""

EIGENVALUE: Mapping[str, float] = {
    "third": 1 / 3,
    "sixth": 1 / 6,
    "root3": math.sqrt(3),
    "bend": math.sqrt(3) - 5 / 3,
}
"""Constants of the code for the smallest eigenvalue; Newton's steps begin at √3 + r (1/3 − bend r)."""

Folded: TypeAlias = Sigmoids | Bells
"""A network without any scaling of its own."""


def folded(network: Network) -> Folded:
    """Work the scaling of a network into its weights.

    Raises
    ------
    TypeError
        If the network is of an unknown kind.
    ValueError
        If it answers with several values, or its weights are not finite with the scaling worked in.
    """
    with np.errstate(over="ignore", invalid="ignore"):
        if isinstance(network, FeedForward):
            return _require_finite(_sigmoids(network))
        if isinstance(network, RadialBasis):
            return _require_finite(_bells(network))
    raise TypeError(f"network is a {type(network).__name__}; FeedForward and RadialBasis can be exported")


def _require_finite(weights: Sigmoids | Bells) -> Sigmoids | Bells:
    """Refuse weights whose sums can overflow: code with an infinity in it answers with NaN."""
    for name, numbers in vars(weights).items():
        # The factors that exports work in are below 3, and all weights of a row may add up.
        if not isinstance(numbers, str) and not np.abs(numbers).sum() < LARGEST:
            raise ValueError(f"network is not finite with its scaling worked in: its {name} overflow")
    return weights


LARGEST = 1e300
"""Sum of weights from which on the answer may overflow."""


def screws(view: View) -> list[tuple[Array, Array]]:
    """Pairs (v, ω) of the carriers, ω a unit vector or zero."""
    rows = view.carriers.cpu().numpy()
    return [(row[:3], row[3:]) for row in rows]


def origin_program(view: View) -> Program:
    """Return the coordinates of the world's origin in the link of the last carrier.

    Returns
    -------
    A program from the joints of the carriers to three numbers [m].
    """
    joints = [Symbol(f"q{i}", real=True) for i in range(len(view.carriers))]
    record, origin = Recorder(), [sympy.S.Zero] * 3
    for joint, (linear, axis) in zip(joints, screws(view), strict=True):
        origin = _moved_back(record, origin, joint, list(exact(linear)), list(exact(axis)))
    return record.program(joints, origin)


def _moved_back(
    record: Recorder, point: list[Expr], joint: Symbol, linear: list[Expr], axis: list[Expr]
) -> list[Expr]:
    """Coordinates of a point after the inverse motion of a joint (Rodrigues, about a point of its axis)."""
    if not any(axis):
        return record.all(x - v * joint for x, v in zip(point, linear, strict=True))
    foot, pitch = cross(axis, linear), dot(axis, linear)
    arm = record.all(x - p for x, p in zip(point, foot, strict=True))
    along = record(dot(axis, arm))
    across = record.all(a - w * along for a, w in zip(arm, axis, strict=True))
    aside = record.all(cross(axis, across))
    sine, cosine, shift = record(sympy.sin(joint)), record(sympy.cos(joint)), record(along - pitch * joint)
    return record.all(
        p + w * shift + cosine * a - sine * b for p, w, a, b in zip(foot, axis, across, aside, strict=True)
    )


def _sigmoids(network: FeedForward) -> Sigmoids:
    if network.values != 1:
        raise ValueError(f"network answers with {network.values} values; networks of one can be exported")
    own = _numbers(network)
    hidden = own["hidden_weights"] / own["input_half_range"]
    output_biases = own["output_biases"] * own["target_half_range"]
    # All of the diagonal: what is added to it is added to every eigenvalue.
    output_biases[: 3 if network.readout == "triple" else 1] += own["target_centre"]
    return Sigmoids(
        hidden,
        own["hidden_biases"] - hidden @ own["input_centre"],
        own["output_weights"] * own["target_half_range"],
        output_biases,
        network.readout,
    )


def _bells(network: RadialBasis) -> Bells:
    own = _numbers(network)
    width = BIAS / own["spread"]
    return Bells(
        own["input_scale"] * width,
        own["centres"] * width,
        own["output_weights"],
        float(own["output_bias"]),
    )


def _numbers(network: Network) -> dict[str, Array]:
    return {name: tensor.cpu().numpy() for name, tensor in network.state_dict().items()}
