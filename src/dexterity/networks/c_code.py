"""C files of networks: what :func:`dexterity.networks.export.c_source` and ``c_files`` write.

Sixteen configurations are worked on side by side, and exponentials are computed in place, so that a compiler
turns all of it into vector instructions.

Examples
--------
>>> import dexterity as dx
>>> from dexterity.networks.c_code import parts
>>> network = dx.networks.load_shipped("uvms-manipulability-feed-forward")
>>> file, header, code = parts(network, "w", "float", lambda _: ["A network."])
>>> "int w_batch(const float *q" in file.standalone(header, code)
True
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np
import torch

from dexterity.codegen.angles import needs_values, with_angles_apart
from dexterity.codegen.c_file import CFile, Precision, table
from dexterity.codegen.printing import number
from dexterity.networks.folding import (
    EIGENVALUE,
    EXPONENTIAL,
    Array,
    Bells,
    Sigmoids,
    folded,
    origin_program,
    screws,
)
from dexterity.networks.network import Network, View

__all__ = ["parts", "smallest_eigenvalue"]


def parts(
    network: Network, name: str, precision: Precision, heading: Callable[[Network], Sequence[str]]
) -> tuple[CFile, str, str]:
    """Return a C file with the texts of its header and of its code.

    Parameters
    ----------
    network
        A feed-forward or radial-basis network of one value.
    name
        What all names in the file begin with.
    precision
        ``"double"`` or ``"float"``.
    heading
        Returns what the network is, as lines of printable text.

    Raises
    ------
    TypeError
        If the network is of an unknown kind.
    ValueError
        If the name cannot be used in C, the network answers with several values, its carriers turn by other
        than one radian per unit, or a number is not finite once all scaling is worked into the weights.
    """
    file, view, exported = CFile(name, precision), network.view, folded(network)
    answer = _answer(file, exported)
    origin = _origin(file, view) if len(view.carriers) else ""
    q, values = _references(network)
    code = file.fill(
        "network.c.in",
        carriers=len(view.carriers),
        inputs=len(view.inputs),
        width=view.width,
        seen="{" + ", ".join(map(str, view.inputs)) + "}",
        elementary=file.elementary(origin + answer),
        origin=origin,
        see_origin=f"  {name}_see_origin(lanes, q, x);\n" if len(view.carriers) else "",
        answer=answer,
        count=len(q),
        rows=table(q.ravel()) if len(q) else "{0.0}",
        values=table(values) if len(q) else "{0.0}",
        scale=float(np.abs(values).max(initial=0.0)),
        tolerance=1e-9 if precision == "double" else 1e-3,
        **file.patterns(),
    )
    functions = file.fill("network_functions.h.in", joints=view.joints)
    return file, file.header(heading(network), view.joints, answer, functions), code


def _references(network: Network) -> tuple[Array, Array]:
    """Return up to four configurations at which the network is finite, and its values there."""
    draws = torch.rand(16, network.joints, dtype=torch.float64, generator=torch.Generator().manual_seed(0))
    q = (draws / 2 - 0.25).float().double()
    with torch.no_grad():
        values = network(q)
    finite = values.isfinite()
    return q[finite][:4].numpy(), values[finite][:4].numpy()


def _answer(file: CFile, network: Sigmoids | Bells) -> str:
    if isinstance(network, Bells):
        root = math.sqrt(1 / math.log(2))
        return file.fill(
            "radial_basis.c.in",
            neurons=len(network.output),
            scale=table(network.scale * root),
            centres=table((network.centres * root).T),
            output=table(network.output),
            output_bias=number(network.output_bias),
        )
    # u = a + V (1 − 2 s), with s the sigmoid that the file computes.
    output, biases = -2 * network.output, network.output_biases + network.output.sum(1)
    if network.readout in EXPONENTIAL:
        output, biases = output / math.log(2), biases / math.log(2)
    power = f"{file.name}_power_of_two"
    return file.fill(
        "feed_forward.c.in",
        neurons=len(network.hidden),
        outputs=len(output),
        hidden=table((network.hidden * (2 / math.log(2))).T),
        hidden_biases=table(network.hidden_biases * (2 / math.log(2))),
        output=table(output),
        output_biases=table(biases),
        eigenvalue=smallest_eigenvalue(file) if network.readout == "triple" else "",
        combine=f"  {file.name}_smallest_eigenvalue(lanes, u);\n" if network.readout == "triple" else "",
        value={
            "identity": "u[0][l]",
            "reciprocal": "1.0/u[0][l]",
            "logarithm": f"{power}(u[0][l])",
            "cone": f"{power}(u[0][l] - sqrt(u[1][l]*u[1][l] + u[2][l]*u[2][l]))",
            "triple": f"{power}(u[0][l])",
        }[network.readout],
    )


def smallest_eigenvalue(file: CFile) -> str:
    """Return the C function for the smallest eigenvalues of symmetric 3×3 matrices."""
    return file.fill("smallest_eigenvalue.c.in", **EIGENVALUE)


def _origin(file: CFile, view: View) -> str:
    turning, program = [bool(axis.any()) for _, axis in screws(view)], origin_program(view)
    # A screw with a pitch slides by the joint's value itself, also beyond a turn.
    values_too = needs_values(program, turning)
    return file.fill(
        "origin.c.in",
        turning="{" + ", ".join(str(int(turns)) for turns in turning) + "}",
        rows=f"{2 if values_too else 1}*{file.name.upper()}_CARRIERS",
        raw=f"      carrying[{file.name.upper()}_CARRIERS + j][l] = carrying[j][l];\n" if values_too else "",
        one_turn=file.one_turn(),
        origin=file.loop("origin", with_angles_apart(program, turning) if values_too else program),
    )
