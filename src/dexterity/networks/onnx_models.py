"""Networks as ONNX models, in double or single precision: joint values in, the index out.

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
import math
import os
from typing import TYPE_CHECKING, Any, Literal, TypeAlias, get_args

import numpy as np

from dexterity import checks, store
from dexterity.networks.folding import EXPONENTIAL, Array, Bells, Sigmoids, folded, screws
from dexterity.networks.network import Network, View

if TYPE_CHECKING:
    import onnx

__all__ = ["Precision", "onnx_model", "save_onnx"]

Precision: TypeAlias = Literal["double", "float"]
"""Precision of a model's numbers, 64 or 32 bits."""

OPSET = 17
"""Version of ONNX's operators that models are written in."""

IR_VERSION = 8
"""Version of ONNX's format that came with these operators."""


def onnx_model(network: Network, precision: Precision = "double") -> onnx.ModelProto:
    """Return a network as an ONNX model.

    Its input ``q`` (N, n) holds joint values, [rad] or [m], its output ``value`` (N) the index; both are of
    the precision. The network's card, as JSON, is in the metadata under ``card``. A model does not look
    whether `q` is finite.

    Parameters
    ----------
    network
        A feed-forward or radial-basis network of one value.
    precision
        ``"double"``, which agrees with the network but for rounding errors, or ``"float"``, which takes and
        returns single precision; :func:`dexterity.networks.rounding.rounding` tells what it costs.

    Raises
    ------
    ImportError
        If the package onnx is missing.
    TypeError
        If the network is of an unknown kind.
    ValueError
        If the precision is unknown, the network answers with several values, or its weights overflow.
    """
    checks.choice(precision, "precision", get_args(Precision))
    onnx = _onnx()
    graph = _Graph(onnx, np.float64 if precision == "double" else np.float32)
    weights = folded(network)
    seen = _seen(graph, network.view)
    value = _bells(graph, weights, seen) if isinstance(weights, Bells) else _sigmoids(graph, weights, seen)
    graph.add("Identity", value, name="value")
    kind = onnx.TensorProto.DOUBLE if precision == "double" else onnx.TensorProto.FLOAT
    model = onnx.helper.make_model(
        onnx.helper.make_graph(
            graph.nodes,
            "network",
            [onnx.helper.make_tensor_value_info("q", kind, ["N", network.joints])],
            [onnx.helper.make_tensor_value_info("value", kind, ["N"])],
            graph.constants,
        ),
        opset_imports=[onnx.helper.make_opsetid("", OPSET)],
        ir_version=IR_VERSION,
        producer_name="dexterity",
    )
    onnx.helper.set_model_props(model, {"card": json.dumps(network.card.to_dict(), ensure_ascii=False)})
    onnx.checker.check_model(model, full_check=True)
    return model


@checks.arguments(path=checks.path)
def save_onnx(network: Network, path: str | os.PathLike[str], precision: Precision = "double") -> None:
    """Write a network to a file as an ONNX model; see :func:`onnx_model`.

    Raises
    ------
    OSError
        If the file cannot be written.
    """
    store.write_atomically(path, onnx_model(network, precision).SerializeToString(deterministic=True))


class _Graph:
    """Operators and constants, named by their number."""

    def __init__(self, onnx: Any, dtype: type) -> None:
        self._onnx = onnx
        self.dtype = dtype
        # Far below any size that a matrix has, and so large that its square is no zero.
        self.tiny = 1e-150 if dtype is np.float64 else 1e-18
        self._names: dict[tuple[bytes, tuple[int, ...], str], str] = {}
        self.nodes: list[Any] = []
        self.constants: list[Any] = []

    def add(self, operator: str, *inputs: str, name: str = "", **attributes: Any) -> str:
        """Return the name of an operator's output."""
        name = name or f"{operator.lower()}_{len(self.nodes)}"
        self.nodes.append(self._onnx.helper.make_node(operator, inputs, [name], **attributes))
        return name

    def constant(self, numbers: Any, dtype: type | None = None) -> str:
        """Return the name of a constant; equal constants are one."""
        array: np.ndarray = np.array(numbers, dtype=dtype or self.dtype, order="C")
        key = (array.tobytes(), array.shape, array.dtype.str)
        if key not in self._names:
            self._names[key] = f"constant_{len(self.constants)}"
            self.constants.append(self._onnx.numpy_helper.from_array(array, self._names[key]))
        return self._names[key]

    def columns(self, x: str, count: int) -> list[str]:
        """Return the names of all columns of rows, (N, 1) each."""
        if count == 1:
            return [x]
        names = [f"{x}_{i}" for i in range(count)]
        self.nodes.append(self._onnx.helper.make_node("Split", [x], names, axis=1))
        return names

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
    outputs = graph.affine(hidden, network.output.T, network.output_biases)
    columns = graph.columns(outputs, len(network.output))
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
    r"""Smallest eigenvalue of symmetric 3×3 matrices: diagonal, then elements 12, 13 and 23.

    Without a loop, so that a row costs some hundred operations. B, the matrix without its mean eigenvalue and
    divided by its size, has eigenvalues :math:`\lambda` with :math:`\lambda^3 - 3\lambda = \det B`. With the
    sign of B such that the determinant is not negative, the largest one is between √3 and 2, apart from the
    others, and found by Newton's steps to the last digit. The other two are :math:`-\lambda/2 \pm h`, and h
    is taken from what is left of B without the largest, since the determinant alone would lose half the
    digits where they meet.
    """
    g = _Arithmetic(graph)
    diagonal, mean = columns[:3], graph.constant(0.0)
    # Twice, since what rounding leaves of the mean counts where all eigenvalues meet.
    for _ in range(2):
        step = g.mul(g.sum(diagonal), 1 / 3)
        diagonal, mean = [g.sub(column, step) for column in diagonal], g.add(mean, step)
    shifted = [*diagonal, *columns[3:]]
    size = g.sqrt(g.mul(_square_of_norm(g, shifted), 1 / 6))
    divisor = graph.add("Max", size, graph.constant(graph.tiny))
    small = [g.div(column, divisor) for column in shifted]
    half = g.mul(_determinant(g, small), 0.5)
    is_negative = graph.add("Less", half, graph.constant(0.0))
    sign = graph.add("Where", is_negative, graph.constant(-1.0), graph.constant(1.0))
    largest = _largest(g, graph.add("Min", graph.add("Abs", half), graph.constant(1.0)))
    below = g.sqrt(g.mul(_square_of_norm(g, _rest(g, [g.mul(sign, one) for one in small], largest)), 0.5))
    middle = g.mul(largest, -0.5)
    smallest = graph.add("Where", is_negative, graph.add("Neg", largest), g.sub(middle, below))
    return g.add(mean, g.mul(size, smallest))


def _largest(g: _Arithmetic, half: str) -> str:
    """Largest root of λ³ − 3λ = 2 r, for r from 0 to 1: a parabola, and Newton's steps from it."""
    root3 = math.sqrt(3)
    root = g.add(g.mul(half, g.sub(g.mul(half, 5 / 3 - root3), -1 / 3)), root3)
    for _ in range(3):
        square = g.mul(root, root)
        cube = g.add(g.mul(g.mul(root, square), 2.0), g.mul(half, 2.0))
        root = g.div(cube, g.mul(g.sub(square, 1.0), 3.0))
    return root


def _rest(g: _Arithmetic, matrix: list[str], largest: str) -> list[str]:
    """Matrix without the largest eigenvalue, and with the mean of the other two taken off from these two."""
    d, e, f = matrix[3:]
    x, y, z = (g.sub(diagonal, largest) for diagonal in matrix[:3])
    # The adjugate of B − λ is a multiple of the projection onto the eigenvector, and its trace is 6 to 9.
    adjugate = [
        g.sub(g.mul(y, z), g.mul(f, f)),
        g.sub(g.mul(x, z), g.mul(e, e)),
        g.sub(g.mul(x, y), g.mul(d, d)),
        g.sub(g.mul(e, f), g.mul(d, z)),
        g.sub(g.mul(d, f), g.mul(e, y)),
        g.sub(g.mul(d, e), g.mul(f, x)),
    ]
    factor = g.div(g.mul(largest, 1.5), g.sum(adjugate[:3]))
    middle = g.mul(largest, 0.5)
    diagonal = [g.add(one, middle) for one in matrix[:3]]
    return [g.sub(one, g.mul(factor, part)) for one, part in zip([*diagonal, d, e, f], adjugate, strict=True)]


def _determinant(g: _Arithmetic, matrix: list[str]) -> str:
    x, y, z, d, e, f = matrix
    first = g.mul(x, g.sub(g.mul(y, z), g.mul(f, f)))
    second = g.mul(d, g.sub(g.mul(d, z), g.mul(e, f)))
    third = g.mul(e, g.sub(g.mul(d, f), g.mul(e, y)))
    return g.add(g.sub(first, second), third)


def _square_of_norm(g: _Arithmetic, matrix: list[str]) -> str:
    """Sum of the squares of all nine elements."""
    diagonal = g.sum([g.mul(one, one) for one in matrix[:3]])
    return g.add(diagonal, g.mul(g.sum([g.mul(one, one) for one in matrix[3:]]), 2.0))


class _Arithmetic:
    """Operators on columns and numbers of a graph."""

    def __init__(self, graph: _Graph) -> None:
        self._graph = graph

    def _apply(self, operator: str, *operands: str | float) -> str:
        names = (one if isinstance(one, str) else self._graph.constant(one) for one in operands)
        return self._graph.add(operator, *names)

    def add(self, x: str | float, y: str | float) -> str:
        return self._apply("Add", x, y)

    def sub(self, x: str | float, y: str | float) -> str:
        return self._apply("Sub", x, y)

    def mul(self, x: str | float, y: str | float) -> str:
        return self._apply("Mul", x, y)

    def div(self, x: str | float, y: str | float) -> str:
        return self._apply("Div", x, y)

    def sqrt(self, x: str) -> str:
        return self._graph.add("Sqrt", x)

    def sum(self, columns: list[str]) -> str:
        x, y, z = columns
        return self.add(self.add(x, y), z)


def _bells(graph: _Graph, network: Bells, x: str) -> str:
    """Weighted sum of bells, with the squares of distances multiplied out as the network does."""
    middle = network.centres.mean(0)
    bases = network.centres - middle
    points = graph.add("Sub", graph.add("Mul", x, graph.constant(network.scale)), graph.constant(middle))
    products = graph.affine(points, 2 * bases.T, -np.square(bases).sum(1))
    axis = graph.constant([1], np.int64)
    squares = graph.add("ReduceSum", graph.add("Mul", points, points), axis, keepdims=1)
    bells = graph.add("Exp", graph.add("Sub", products, squares))
    weighted = graph.affine(bells, network.output[:, None], np.array([network.output_bias]))
    return graph.add("Squeeze", weighted, axis)


def _onnx() -> Any:
    try:
        import onnx
    except ImportError as error:
        raise ImportError("ONNX models need the package onnx: pip install dexterity-study[onnx]") from error
    return onnx
