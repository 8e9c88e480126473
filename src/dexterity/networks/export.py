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

from collections.abc import Iterable
from typing import Any

import torch
from jaxtyping import Float64
from torch import Tensor

from dexterity import checks, sampling, spatial
from dexterity.codegen.c_file import Precision
from dexterity.codegen.heading import printable
from dexterity.codegen.javascript import assembled, function, literal
from dexterity.codegen.library import RowFunction, compiled_library
from dexterity.codegen.printing import template
from dexterity.networks import c_code, card_text
from dexterity.networks.folding import (
    EIGENVALUE,
    Bells,
    Sigmoids,
    folded,
    origin_program,
)
from dexterity.networks.network import Network, View
from dexterity.networks.onnx_models import onnx_model, save_onnx
from dexterity.networks.rounding import rounding
from dexterity.program import Program
from dexterity.spatial import TensorLike
from dexterity.spatial.values import require_values

__all__ = [
    "CompiledNetwork",
    "c_files",
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

    @checks.arguments(network=checks.Instance(Network))
    def __init__(self, network: Network) -> None:
        self.network = network
        library = compiled_library(c_source(network, "network"))
        self._joints = network.joints
        self._batch = RowFunction(library, "network_batch", self._joints, results=1)

    def __reduce__(self) -> tuple[Any, ...]:
        return compile_network, (self.network,)

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
        if not (isinstance(q, Tensor) and q.dtype is torch.float64 and q.layout is torch.strided):
            q = spatial.to_float64(q, "q")
        require_values(q, "q")
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


@checks.arguments(network=checks.Instance(Network))
def c_source(network: Network, name: str, precision: Precision = "double") -> str:
    """Return one C file, without a header, that computes a network's value.

    Parameters and errors are those of :func:`dexterity.codegen.c_files`.
    """
    file, header, code = c_code.parts(network, name, precision, _heading)
    return file.standalone(header, code)


@checks.arguments(network=checks.Instance(Network))
def c_files(network: Network, name: str, precision: Precision = "double") -> dict[str, str]:
    """Return a header and a C file that compute a network's value, by their file names.

    Parameters
    ----------
    network
        A feed-forward or radial-basis network of one value.
    name
        What all names in the files begin with: letters, digits and underscores, a letter first.
    precision
        Type of all numbers: ``"double"``, or ``"float"`` for processors without doubles.

    Raises
    ------
    TypeError
        If the network is of an unknown kind.
    ValueError
        If the name cannot be used in C and C++, the network answers with several values, its carriers turn
        by other than one radian per unit, or a number is not finite once all scaling is worked into the
        weights.
    """
    file, header, code = c_code.parts(network, name, precision, _heading)
    return file.files(header, code)


# ---- JavaScript ------------------------------------------------------------------------------------


@checks.arguments(network=checks.Instance(Network))
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


_SMALLEST_EIGENVALUE = template("smallest_eigenvalue.js.in")


def _answer_in_javascript(network: Sigmoids | Bells, see: str) -> str:
    if isinstance(network, Bells):
        return template("radial_basis.js.in").substitute(
            see=see,
            scale=literal(network.scale.tolist()),
            centres=literal(network.centres.tolist()),
            output=literal(network.output.tolist()),
            output_bias=literal(network.output_bias),
        )
    return template("feed_forward.js.in").substitute(
        see=see,
        hidden=literal(network.hidden.tolist()),
        hidden_biases=literal(network.hidden_biases.tolist()),
        output=literal(network.output.tolist()),
        output_biases=literal(network.output_biases.tolist()),
        eigenvalue=_SMALLEST_EIGENVALUE.substitute(EIGENVALUE) if network.readout == "triple" else "",
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
        _accuracy(network),
        *card_text.lines(network.card),
    ]
    return printable(entries)


def _accuracy(network: Network) -> str:
    """Say how far from the network a file in double and in single precision is, by rounding alone."""
    random = torch.Generator().manual_seed(0)
    space = network.card.space() if "space" in network.card else None
    if space is not None and space.joints == network.joints:
        q, where = sampling.uniform(space, 256, random), "in the space that it was trained on"
    else:
        q = torch.rand(256, network.joints, generator=random, dtype=torch.float64) - 0.5
        where = "where inputs are within 0.5"
    found = rounding(network, q)
    return (
        f"Accuracy: the value of the network but for rounding, {where} at most about {found.double:.0e} of it"
        f" in double and {found.single:.0e} in single precision."
    )


def _counted(inputs: Iterable[int]) -> str:
    """Joints from 1, as chains count them."""
    return ", ".join(str(i + 1) for i in inputs)
