"""Networks as code: standalone C99 files, JavaScript modules, ONNX models, and compiled functions.

A C file needs ``math.h`` alone; sixteen configurations are worked on side by side, and exponentials are
computed in place, so that a compiler turns all of it into vector instructions.

Examples
--------
>>> import dexterity as dx
>>> from dexterity.networks import export
>>> network = dx.networks.load_shipped("uvms-manipulability-feed-forward")
>>> "w_batch(" in export.c_source(network, "w")
True
>>> "export function value" in export.javascript_module(network)
True
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Sequence

import numpy as np
import torch
from jaxtyping import Float64
from torch import Tensor

from dexterity import spatial
from dexterity.codegen.c99 import NOT_FINITE, commented, loop, power_of_two, sine_cosine
from dexterity.codegen.heading import printable
from dexterity.codegen.javascript import assembled, function
from dexterity.codegen.library import RowFunction, compiled_library
from dexterity.codegen.printing import template
from dexterity.networks import card_text
from dexterity.networks.folding import (
    EXPONENTIAL,
    SWEEPS,
    Array,
    Bells,
    Sigmoids,
    folded,
    origin_program,
    screws,
)
from dexterity.networks.network import Network, View
from dexterity.networks.onnx_models import onnx_model, save_onnx
from dexterity.program import Program
from dexterity.spatial import TensorLike

__all__ = [
    "CompiledNetwork",
    "c_source",
    "compile_network",
    "javascript_module",
    "onnx_model",
    "save_onnx",
]


class CompiledNetwork:
    """A network in C; :func:`compile_network` makes it.

    Attributes
    ----------
    network
        What was compiled. It is the one to differentiate.
    """

    def __init__(self, network: Network) -> None:
        self.network = network
        library = compiled_library(c_source(network, "network"))
        self._joints = network.joints
        self._batch = RowFunction(library, "network_batch", self._joints, results=1)

    def __call__(self, q: TensorLike) -> Float64[Tensor, "*batch"]:
        """Value of the index as the network knows it.

        Parameters
        ----------
        q
            (..., n) joint values, [rad] for revolute and [m] for prismatic joints.

        Raises
        ------
        ValueError
            If the last axis of `q` is not the number of joints, or `q` is not finite.
        """
        # The file refuses what is not finite; a look at it here would cost more than one configuration.
        if not (isinstance(q, Tensor) and q.dtype is torch.float64):
            q = spatial.to_float64(q, "q")
        return self._batch.values(spatial.require_joints(q, self._joints, "chain"))


def compile_network(network: Network) -> CompiledNetwork:
    """Return a network as a fast function of the chain's joint values, on the CPU and without gradients.

    Raises
    ------
    TypeError
        If the network is of an unknown kind.
    ValueError
        If it answers with several values, or its carriers turn by other than one radian per unit.
    CompilationFailed
        If there is no C compiler, or it fails.
    OSError
        If the folder for compiled code cannot be written.
    """
    return CompiledNetwork(network)


# ---- C ---------------------------------------------------------------------------------------------


def c_source(network: Network, name: str) -> str:
    """Return a C99 file that computes a network's value.

    Parameters
    ----------
    network
        A feed-forward or radial-basis network of one value.
    name
        What its functions begin with: letters, digits and underscores, a letter first.

    Raises
    ------
    TypeError
        If the network is of an unknown kind.
    ValueError
        If the name is no name in C, the network answers with several values, or its carriers turn by other
        than one radian per unit.
    """
    if not re.fullmatch(r"[A-Za-z]\w*", name, flags=re.ASCII):
        raise ValueError(f"name is {name!r}; letters, digits and underscores, a letter first, are needed")
    view, answer = network.view, _answer_in_c(folded(network))
    return template("network.c.in").substitute(
        heading=commented(_heading(network)),
        name=name,
        not_finite=NOT_FINITE,
        joints=view.joints,
        carriers=len(view.carriers),
        inputs=len(view.inputs),
        width=view.width,
        seen=_in_braces(view.inputs),
        origin=_origin_in_c(view) if len(view.carriers) else "",
        see_origin="  see_origin(lanes, q, x);\n" if len(view.carriers) else "",
        power_of_two=power_of_two(),
        answer=answer,
    )


def _answer_in_c(network: Sigmoids | Bells) -> str:
    if isinstance(network, Bells):
        root = math.sqrt(1 / math.log(2))
        return template("radial_basis.c.in").substitute(
            neurons=len(network.output),
            scale=_in_braces(network.scale * root),
            centres=_in_braces(network.centres * root),
            output=_in_braces(network.output),
            output_bias=repr(network.output_bias),
        )
    # u = a + V (1 − 2 s), with s the sigmoid that the file computes.
    output, biases = -2 * network.output, network.output_biases + network.output.sum(1)
    if network.readout in EXPONENTIAL:
        output, biases = output / math.log(2), biases / math.log(2)
    return template("feed_forward.c.in").substitute(
        neurons=len(network.hidden),
        outputs=len(output),
        hidden=_in_braces(network.hidden * (2 / math.log(2))),
        hidden_biases=_in_braces(network.hidden_biases * (2 / math.log(2))),
        output=_in_braces(output),
        output_biases=_in_braces(biases),
        eigenvalue=_smallest_eigenvalue("c") if network.readout == "triple" else "",
        combine="  smallest_eigenvalue(lanes, u);\n" if network.readout == "triple" else "",
        value={
            "identity": "u[0][l]",
            "reciprocal": "1.0/u[0][l]",
            "logarithm": "power_of_two(u[0][l])",
            "cone": "power_of_two(u[0][l] - sqrt(u[1][l]*u[1][l] + u[2][l]*u[2][l]))",
            "triple": "power_of_two(u[0][l])",
        }[network.readout],
    )


def _smallest_eigenvalue(language: str) -> str:
    return template(f"smallest_eigenvalue.{language}.in").substitute(sweeps=SWEEPS)


def _origin_in_c(view: View) -> str:
    turning = [int(axis.any()) for _, axis in screws(view)]
    return template("origin.c.in").substitute(
        turning=_in_braces(turning),
        sine_cosine=sine_cosine() if any(turning) else "",
        origin=loop("origin", origin_program(view)),
    )


def _in_braces(numbers: Array | Sequence[int]) -> str:
    """Numbers, or rows of them, as a C array with all their digits."""
    return repr(np.asarray(numbers).tolist()).replace("[", "{").replace("]", "}")


# ---- JavaScript ------------------------------------------------------------------------------------


def javascript_module(network: Network) -> str:
    """Return an ECMAScript module that exports ``value(q)`` and a description, ``about``, with the card.

    Raises
    ------
    TypeError
        If the network is of an unknown kind.
    ValueError
        If it answers with several values, or its carriers turn by other than one radian per unit.
    """
    about = {"joints": network.joints, "inputs": network.inputs, "card": network.card.to_dict()}
    computation = _answer_in_javascript(folded(network), _see_in_javascript(network.view))
    return assembled(_heading(network), about, network.joints, computation)


def _answer_in_javascript(network: Sigmoids | Bells, see: str) -> str:
    if isinstance(network, Bells):
        return template("radial_basis.js.in").substitute(
            see=see,
            scale=network.scale.tolist(),
            centres=network.centres.tolist(),
            output=network.output.tolist(),
            output_bias=repr(network.output_bias),
        )
    return template("feed_forward.js.in").substitute(
        see=see,
        hidden=network.hidden.tolist(),
        hidden_biases=network.hidden_biases.tolist(),
        output=network.output.tolist(),
        output_biases=network.output_biases.tolist(),
        eigenvalue=_smallest_eigenvalue("js") if network.readout == "triple" else "",
        value={
            "identity": "u[0]",
            "reciprocal": "1 / u[0]",
            "logarithm": "Math.exp(u[0])",
            "cone": "Math.exp(u[0] - Math.hypot(u[1], u[2]))",
            "triple": "Math.exp(smallestEigenvalue(u))",
        }[network.readout],
    )


def _see_in_javascript(view: View) -> str:
    program = origin_program(view) if len(view.carriers) else Program((), (), ())
    return template("see.js.in").substitute(origin=function("origin", program), seen=list(view.inputs))


# ---- what stands at the head -----------------------------------------------------------------------


def _heading(network: Network) -> list[str]:
    kind = {"FeedForward": "Feed-forward", "RadialBasis": "Radial-basis"}[type(network).__name__]
    origin = f"the world's origin in the link after joint {len(network.view.carriers)}, and "
    entries = [
        f"{kind} network of {network.neurons} neurons, generated by dexterity.",
        f"Sees {origin if len(network.view.carriers) else ''}joints {_counted(network.inputs)}.",
        "Units: radians and metres.",
        *card_text.lines(network.card),
    ]
    return printable(entries)


def _counted(inputs: Iterable[int]) -> str:
    """Joints from 1, as chains count them."""
    return ", ".join(str(i + 1) for i in inputs)
