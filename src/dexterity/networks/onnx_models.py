"""Networks as ONNX models, in double precision: joint values in, the index out.

Examples
--------
>>> import dexterity as dx
>>> from dexterity.networks import onnx_models
>>> network = dx.networks.load_shipped("uvms-manipulability-feed-forward")
>>> graph = onnx_models.onnx_model(network).graph
>>> [variable.name for variable in (*graph.input, *graph.output)]
['q', 'value']
"""

from __future__ import annotations

import json
import os
from typing import TYPE_CHECKING, Any

import numpy as np

from dexterity import store
from dexterity.networks.folding import EXPONENTIAL, SWEEPS, Array, Bells, Sigmoids, folded, screws
from dexterity.networks.network import Network, View

if TYPE_CHECKING:
    import onnx

__all__ = ["onnx_model", "save_onnx"]

OPSET = 17
"""Version of ONNX's operators that models are written in."""

IR_VERSION = 8
"""Version of ONNX's format that came with these operators."""


def onnx_model(network: Network) -> onnx.ModelProto:
    """Return a network as an ONNX model.

    Its input ``q`` (N, n) holds joint values, [rad] or [m], its output ``value`` (N) the index; both are
    double. The network's card, as JSON, is in the metadata under ``card``. A model does not look whether `q`
    is finite.

    Raises
    ------
    ImportError
        If the package onnx is missing.
    TypeError
        If the network is of an unknown kind.
    ValueError
        If it answers with several values, or its carriers turn by other than one radian per unit.
    """
    onnx = _onnx()
    graph = _Graph(onnx)
    weights = folded(network)
    seen = _seen(graph, network.view)
    value = _bells(graph, weights, seen) if isinstance(weights, Bells) else _sigmoids(graph, weights, seen)
    graph.add("Identity", value, name="value")
    double = onnx.TensorProto.DOUBLE
    model = onnx.helper.make_model(
        onnx.helper.make_graph(
            graph.nodes,
            "network",
            [onnx.helper.make_tensor_value_info("q", double, ["N", network.joints])],
            [onnx.helper.make_tensor_value_info("value", double, ["N"])],
            graph.constants,
        ),
        opset_imports=[onnx.helper.make_opsetid("", OPSET)],
        ir_version=IR_VERSION,
        producer_name="dexterity",
    )
    onnx.helper.set_model_props(model, {"card": json.dumps(network.card.to_dict(), ensure_ascii=False)})
    onnx.checker.check_model(model, full_check=True)
    return model


def save_onnx(network: Network, path: str | os.PathLike[str]) -> None:
    """Write a network to a file as an ONNX model; see :func:`onnx_model`.

    Raises
    ------
    OSError
        If the file cannot be written.
    """
    store.write_atomically(path, onnx_model(network).SerializeToString(deterministic=True))


class _Graph:
    """Operators and constants, named by their number."""

    def __init__(self, onnx: Any) -> None:
        self._onnx = onnx
        self.nodes: list[Any] = []
        self.constants: list[Any] = []

    def add(self, operator: str, *inputs: str, name: str = "", **attributes: Any) -> str:
        """Return the name of an operator's output."""
        name = name or f"{operator.lower()}_{len(self.nodes)}"
        self.nodes.append(self._onnx.helper.make_node(operator, inputs, [name], **attributes))
        return name

    def constant(self, numbers: Any, dtype: type = np.float64) -> str:
        """Return the name of a constant."""
        name = f"constant_{len(self.constants)}"
        array: np.ndarray = np.ascontiguousarray(numbers, dtype=dtype)
        self.constants.append(self._onnx.numpy_helper.from_array(array, name))
        return name

    def joints(self, numbers: list[int]) -> str:
        """Return the name of some columns of the joint values, (N, k)."""
        return self.add("Gather", "q", self.constant(numbers, np.int64), axis=1)

    def affine(self, x: str, matrix: Array, shift: Array) -> str:
        """Return the name of rows times a matrix, shifted."""
        return self.add("Add", self.add("MatMul", x, self.constant(matrix)), self.constant(shift))


def _seen(graph: _Graph, view: View) -> str:
    """Return the name of what the network sees, (N, r)."""
    inputs = graph.joints(list(view.inputs))
    if not len(view.carriers):
        return inputs
    origin = graph.constant(np.zeros((1, 3)))
    for joint, (linear, axis) in enumerate(screws(view)):
        value = graph.joints([joint])
        if axis.any():
            origin = _turned_back(graph, origin, value, linear, axis)
        else:
            origin = graph.add("Sub", origin, graph.add("MatMul", value, graph.constant(linear[None])))
    return graph.add("Concat", origin, inputs, axis=1)


def _turned_back(graph: _Graph, point: str, angle: str, linear: Array, axis: Array) -> str:
    """Coordinates of a point after a screw's inverse motion: Rodrigues' formula about a point of the axis."""
    foot, pitch, along = np.cross(axis, linear), axis @ linear, np.outer(axis, axis)
    arm = graph.add("Sub", point, graph.constant(foot))
    across = graph.add("MatMul", arm, graph.constant(np.eye(3) - along))
    aside = graph.add("MatMul", arm, graph.constant(np.cross(axis, np.eye(3)).T))
    turned = graph.add(
        "Add",
        graph.add("Mul", graph.add("Cos", angle), across),
        graph.add("Mul", graph.add("Sin", angle), aside),
    )
    slid = graph.add("MatMul", angle, graph.constant(-pitch * axis[None]))
    return graph.add("Add", graph.add("Add", turned, slid), graph.affine(arm, along, foot))


def _sigmoids(graph: _Graph, network: Sigmoids, x: str) -> str:
    hidden = graph.add("Tanh", graph.affine(x, network.hidden.T, network.hidden_biases))
    columns = [
        graph.affine(hidden, weights[:, None], bias)
        for weights, bias in zip(network.output, network.output_biases[:, None], strict=True)
    ]
    if network.readout == "cone":
        squares = [graph.add("Mul", column, column) for column in columns[1:]]
        columns[0] = graph.add("Sub", columns[0], graph.add("Sqrt", graph.add("Add", *squares)))
    value = _smallest_eigenvalue(graph, columns) if network.readout == "triple" else columns[0]
    if network.readout == "reciprocal":
        value = graph.add("Reciprocal", value)
    elif network.readout in EXPONENTIAL:
        value = graph.add("Exp", value)
    return graph.add("Squeeze", value, graph.constant([1], np.int64))


def _smallest_eigenvalue(graph: _Graph, columns: list[str]) -> str:
    """Smallest eigenvalue of symmetric 3×3 matrices: diagonal, then elements 12, 13 and 23."""
    u, zero = dict(enumerate(columns)), graph.constant(np.zeros((1, 1)))
    for _ in range(SWEEPS):
        for a, b, g, x, y in ((0, 1, 3, 4, 5), (0, 2, 4, 3, 5), (1, 2, 5, 3, 4)):
            tangent, sine, cosine = _rotation(graph, graph.add("Sub", u[b], u[a]), u[g])
            shift = graph.add("Mul", tangent, u[g])
            u[a], u[b] = graph.add("Sub", u[a], shift), graph.add("Add", u[b], shift)
            u[g] = zero
            u[x], u[y] = (
                graph.add("Sub", graph.add("Mul", cosine, u[x]), graph.add("Mul", sine, u[y])),
                graph.add("Add", graph.add("Mul", sine, u[x]), graph.add("Mul", cosine, u[y])),
            )
    return graph.add("Min", u[0], u[1], u[2])


def _rotation(graph: _Graph, d: str, g: str) -> tuple[str, str, str]:
    """Tangent, sine and cosine of a rotation of Jacobi: d the difference on the diagonal, g beside it."""
    twice = graph.add("Add", g, g)
    root = graph.add("Sqrt", graph.add("Add", graph.add("Mul", d, d), graph.add("Mul", twice, twice)))
    length = graph.add("Add", graph.add("Add", graph.add("Abs", d), root), graph.constant(1e-300))
    side = graph.add(
        "Where", graph.add("Less", d, graph.constant(0.0)), graph.constant(-1.0), graph.constant(1.0)
    )
    tangent = graph.add("Div", graph.add("Mul", side, twice), length)
    square = graph.add("Add", graph.add("Mul", tangent, tangent), graph.constant(1.0))
    cosine = graph.add("Reciprocal", graph.add("Sqrt", square))
    return tangent, graph.add("Mul", tangent, cosine), cosine


def _bells(graph: _Graph, network: Bells, x: str) -> str:
    scaled = graph.add("Mul", x, graph.constant(network.scale))
    apart = graph.add(
        "Sub",
        graph.add("Unsqueeze", scaled, graph.constant([1], np.int64)),
        graph.constant(network.centres),
    )
    squares = graph.add(
        "ReduceSum", graph.add("Mul", apart, apart), graph.constant([2], np.int64), keepdims=0
    )
    bells = graph.add("Exp", graph.add("Neg", squares))
    weighted = graph.add("MatMul", bells, graph.constant(network.output))
    return graph.add("Add", weighted, graph.constant(network.output_bias))


def _onnx() -> Any:
    try:
        import onnx
    except ImportError as error:
        raise ImportError("ONNX models need the package onnx: pip install dexterity-study[onnx]") from error
    return onnx
