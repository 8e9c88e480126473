"""Normal equations of feed-forward networks, for a stack of networks of one size.

The network's Jacobian is written out, but never kept: only the sums over the rows of the training set are,
taken over pieces of the rows that stay in a processor's cache. Networks of a stack share every product.

Examples
--------
>>> import torch
>>> from dexterity.networks import network, normal_equations as normal, train
>>> q = torch.linspace(-1, 1, 50).double()[:, None]
>>> networks = train.initial_networks(network.View(1, [0]), 4, q, q.sin()[:, 0], [0, 1])
>>> layout = normal.Layout.of(networks[0])
>>> rows = normal.TrainingSet.of(networks, q[None], q.sin()[None])
>>> [
...     part.shape
...     for part in normal.normal_equations(layout, layout.pack(networks), rows)
... ]
[torch.Size([2, 13, 13]), torch.Size([2, 13])]
"""

from __future__ import annotations

import copy
import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import torch
from jaxtyping import Float64
from torch import Tensor

from dexterity.networks.feed_forward import (
    EIGENVALUES,
    FeedForward,
    smallest_eigenvalue,
    symmetric,
    target_of,
)

__all__ = ["Layout", "TrainingSet", "normal_equations", "sum_of_squares"]


@dataclass(frozen=True)
class TrainingSet:
    """What the networks of a stack see and should answer, one row of the training set a column.

    Attributes
    ----------
    inputs
        (B or 1, r + 1, N) scaled inputs with a one below.
    products
        (B or 1, ·, N) products of any two of them.
    targets
        (B or 1, k, N) scaled targets.
    half_range
        (B) half ranges of the targets.
    eigenvalue
        Whether the answer is the smallest eigenvalue of a matrix of outputs.
    """

    inputs: Float64[Tensor, "B_or_1 r_plus_1 N"]
    products: Float64[Tensor, "B_or_1 products N"]
    targets: Float64[Tensor, "B_or_1 k N"]
    half_range: Float64[Tensor, " B"]
    eigenvalue: bool

    @classmethod
    def of(cls, networks: Sequence[FeedForward], q: Tensor, values: Tensor) -> TrainingSet:
        """Return the training set of a stack: joint values (B or 1, N, n) and values (B or 1, N, k)."""
        first = networks[0]
        device = first.hidden_weights.device
        own_rows = len(q) > 1
        own_scaling = any(not _scaled_alike(first, network) for network in networks[1:])
        seen, answers = [], []
        for i, network in enumerate(networks if own_rows or own_scaling else networks[:1]):
            x = network.view(q[i if own_rows else 0].to(device))
            target = target_of(values[i if own_rows else 0].to(device), network.readout)
            seen.append(((x - network.input_centre) / network.input_half_range).mT)
            answers.append(((target - network.target_centre) / network.target_half_range).mT)
        inputs = torch.nn.functional.pad(torch.stack(seen), (0, 0, 0, 1), value=1.0).contiguous()
        half_range = torch.stack([network.target_half_range for network in networks])
        products = _products(inputs)
        targets = torch.stack(answers).contiguous()
        return cls(inputs, products, targets, half_range, first.readout in EIGENVALUES)

    def __getitem__(self, networks: Tensor | slice) -> TrainingSet:
        """Return what some of the networks see and should answer."""
        if len(self.inputs) == 1:
            return replace(self, half_range=self.half_range[networks])
        inputs, products, targets = (array[networks] for array in (self.inputs, self.products, self.targets))
        return TrainingSet(inputs, products, targets, self.half_range[networks], self.eigenvalue)

    def pieces(self, rows: int) -> Iterator[tuple[Tensor, Tensor, Tensor]]:
        """Yield inputs, their products and targets, so many rows at a time; what all share has no axis B."""
        arrays = (self.inputs, self.products, self.targets)
        shared = (array[0] if len(array) == 1 else array for array in arrays)
        yield from zip(*(array.split(max(1, rows), dim=-1) for array in shared), strict=True)


@dataclass(frozen=True)
class Layout:
    """How the weights of a network stand in one row of P numbers: hidden layer, then output layer.

    Attributes
    ----------
    inputs, neurons, outputs
        Sizes r, h and m of the layers.
    values
        Number k of values that are made of the outputs.
    """

    inputs: int
    neurons: int
    outputs: int
    values: int

    @classmethod
    def of(cls, network: FeedForward) -> Layout:
        """Return the layout of a network."""
        neurons, inputs = network.hidden_weights.shape
        return cls(inputs, neurons, len(network.output_biases), network.values)

    @property
    def border(self) -> int:
        """Place at which the output layer begins."""
        return self.neurons * (self.inputs + 1)

    @property
    def parameters(self) -> int:
        """Number P of weights and biases."""
        return self.border + self.outputs * (self.neurons + 1)

    def pack(self, networks: Sequence[FeedForward]) -> Tensor:
        """Return the weights (B, P) of networks."""
        rows = []
        for network in networks:
            hidden = torch.cat([network.hidden_weights, network.hidden_biases[:, None]], dim=1)
            output = torch.cat([network.output_weights, network.output_biases[:, None]], dim=1)
            rows.append(torch.cat([hidden.flatten(), output.flatten()]).detach())
        return torch.stack(rows)

    def layers(self, weights: Tensor) -> tuple[Tensor, Tensor]:
        """Return hidden (B, h, r + 1) and output layer (B, m, h + 1) of weights (B, P), biases last."""
        hidden = weights[:, : self.border].unflatten(-1, (self.neurons, self.inputs + 1))
        return hidden, weights[:, self.border :].unflatten(-1, (self.outputs, self.neurons + 1))

    def unpacked(self, network: FeedForward, weights: Tensor) -> FeedForward:
        """Return a copy of a network with other weights (P)."""
        hidden, output = (layer[0] for layer in self.layers(weights[None]))
        trained = copy.deepcopy(network)
        trained.card = {}  # what was known of the network is not true of the one with other weights
        with torch.no_grad():
            trained.hidden_weights.copy_(hidden[:, :-1])
            trained.hidden_biases.copy_(hidden[:, -1])
            trained.output_weights.copy_(output[:, :-1])
            trained.output_biases.copy_(output[:, -1])
        return trained


def _answers(layers: tuple[Tensor, Tensor], x: Tensor, eigenvalue: bool) -> tuple[Tensor, Tensor, Tensor]:
    """Hidden (B, h, N) and linear outputs (B, m, N) of a stack of networks, and scaled answers (B, k, N)."""
    hidden_layer, output_layer = layers
    hidden = torch.tanh_(hidden_layer @ x if x.ndim == 3 else _folded_product(hidden_layer, x))
    outputs = torch.baddbmm(output_layer[..., -1:], output_layer[..., :-1], hidden)
    return hidden, outputs, smallest_eigenvalue(outputs.mT).mT if eigenvalue else outputs


def _folded_product(stack: Tensor, matrix: Tensor) -> Tensor:
    """Multiply a stack (B, i, j) by a matrix (j, k) that all share in one product."""
    return (stack.flatten(0, 1) @ matrix).unflatten(0, stack.shape[:2])


def sum_of_squares(layout: Layout, weights: Tensor, training_set: TrainingSet) -> Tensor:
    """Return the sum of squared residuals (B) of networks with weights (B, P)."""
    total = weights.new_zeros(len(weights))
    layers = layout.layers(weights)
    for x, _, targets in training_set.pieces(_numbers_at_once(weights) // (len(weights) * layout.neurons)):
        residuals = _answers(layers, x, training_set.eigenvalue)[2] - targets
        total += residuals.square().sum(dim=(1, 2))
    return total


def normal_equations(layout: Layout, weights: Tensor, training_set: TrainingSet) -> tuple[Tensor, Tensor]:
    """Return JᵀJ (B, P, P) and Jᵀe (B, P) of networks with weights (B, P)."""
    numbers = layout.values * (layout.parameters + len(_pairs(layout.neurons)))
    # So many networks at a time that pieces of the rows stay long.
    together = max(1, _numbers_at_once(weights) // (_SHORTEST_PIECE * numbers))
    parts = []
    for start in range(0, len(weights), together):
        some = slice(start, start + together)
        rows = _numbers_at_once(weights) // (numbers * len(weights[some]))
        parts.append(_summed_over_rows(layout, weights[some], training_set[some], rows))
    matrices, vectors = zip(*parts, strict=True)
    return torch.cat(matrices), torch.cat(vectors)


def _summed_over_rows(
    layout: Layout, weights: Tensor, training_set: TrainingSet, rows: int
) -> tuple[Tensor, Tensor]:
    r"""JᵀJ (B, P, P) and Jᵀe (B, P), without J.

    In the Jacobian of a row, the weight from input a to neuron j has the column :math:`g_j x_a`. The sum of
    :math:`g_j x_a \, g_k x_b` over the rows is a product of all pairs (j, k) and all pairs (a, b), of which
    about half each differ: a quarter of the work of JᵀJ, and the pairs (a, b) are the same for all networks.
    """
    layers = layout.layers(weights)
    tail = layout.parameters - layout.border
    pairs = [len(_pairs(size)) for size in (layout.neurons, layout.inputs + 1)]
    hidden_part = weights.new_zeros(len(weights), *pairs)
    cross_part = weights.new_zeros(len(weights), layout.border, tail + 1)
    output_part = weights.new_zeros(len(weights), tail, tail + 1)
    for x, products, targets in training_set.pieces(rows):
        hidden, outputs, answers = _answers(layers, x, training_set.eigenvalue)
        slopes = _slopes(outputs, layout.values, training_set.eigenvalue)
        by_output = _by_output_layer(slopes, hidden, answers - targets)
        into_hidden = _into_hidden(slopes, layers[1], hidden)
        x, products = (_repeated(array, layout.values) for array in (x, products))
        by_hidden = (into_hidden[:, :, None] * x[..., None, :, :]).flatten(1, 2)
        _add_product(hidden_part, _products(into_hidden), products)
        _add_product(cross_part, by_hidden, by_output)
        _add_product(output_part, by_output[:, :-1], by_output)
    across = torch.cat([cross_part, output_part], dim=1)
    left = torch.cat([_unfolded(hidden_part, layout), cross_part[..., :-1].mT], dim=1)
    return torch.cat([left, across[..., :-1]], dim=2), across[..., -1]


def _slopes(outputs: Tensor, values: int, eigenvalue: bool) -> Tensor:
    """Differentiate scaled answers by linear outputs: (B, m, k, N), or with 1 for N where it is constant."""
    if not eigenvalue:
        identity = torch.eye(values, dtype=outputs.dtype, device=outputs.device)
        return identity[..., None].expand(len(outputs), -1, -1, -1)
    slopes = _slopes_of_cone(outputs) if outputs.shape[1] == 3 else _slopes_of_triple(outputs)
    return slopes[:, :, None]


def _slopes_of_cone(outputs: Tensor) -> Tensor:
    """Differentiate by each of the outputs (B, 3, N); at the tip take the axis of the cone."""
    distance = torch.hypot(outputs[:, 1:2], outputs[:, 2:])
    sides = outputs[:, 1:] / torch.where(distance > 0, distance, 1.0)
    return torch.cat([torch.ones_like(distance), -sides], dim=1)


def _slopes_of_triple(outputs: Tensor) -> Tensor:
    """Differentiate by each of the outputs (B, 6, N), with any eigenvector of a multiple eigenvalue."""
    x, y, z = torch.linalg.eigh(symmetric(outputs.mT)).eigenvectors[..., 0].unbind(-1)
    return torch.stack([x * x, y * y, z * z, 2 * x * y, 2 * x * z, 2 * y * z], dim=1)


def _by_output_layer(slopes: Tensor, hidden: Tensor, residuals: Tensor) -> Tensor:
    """Columns (B, m (h + 1) + 1, k N) of the Jacobian for the output layer, and the residuals behind."""
    networks, neurons, rows = hidden.shape
    outputs, values = slopes.shape[1:3]
    columns = hidden.new_empty(networks, outputs * (neurons + 1) + 1, values, rows)
    layer = columns[:, :-1].unflatten(1, (outputs, neurons + 1))
    torch.mul(slopes[:, :, None], hidden[:, None, :, None], out=layer[:, :, :-1])
    layer[:, :, -1] = slopes
    columns[:, -1] = residuals
    return columns.flatten(2)


def _into_hidden(slopes: Tensor, output_layer: Tensor, hidden: Tensor) -> Tensor:
    """Differentiate scaled answers by what enters the hidden neurons: (B, h, k N)."""
    into_outputs = torch.einsum("bmh,bmkn->bhkn", output_layer[..., :-1], slopes)
    return (into_outputs * (1 - hidden.square())[:, :, None]).flatten(2)


def _products(x: Tensor) -> Tensor:
    """Products (..., ·, N) of any two of the rows of x (..., s, N), in the order of `_pairs`."""
    size = x.shape[-2]
    products = x.new_empty(*x.shape[:-2], len(_pairs(size)), x.shape[-1])
    end = 0
    for i in range(0, size, _BLOCK):
        left, right = x[..., i : i + _BLOCK, None, :], x[..., None, i:, :]
        sizes = (left.shape[-3], right.shape[-2])
        start, end = end, end + math.prod(sizes)
        torch.mul(left, right, out=products[..., start:end, :].unflatten(-2, sizes))
    return products


@lru_cache(maxsize=64)
def _pairs(size: int) -> tuple[tuple[int, int], ...]:
    """Pairs of numbers below `size`, each at least once: a few first ones with all from them on at a time."""
    blocks = [(range(size)[i : i + _BLOCK], range(i, size)) for i in range(0, size, _BLOCK)]
    return tuple(pair for block in blocks for pair in itertools.product(*block))


_BLOCK = 5


def _repeated(x: Tensor, values: int) -> Tensor:
    """Repeat the rows of the training set (..., N) for each value: (..., k N)."""
    return x[..., None, :].expand(*x.shape[:-1], values, -1).flatten(-2)


def _add_product(total: Tensor, left: Tensor, right: Tensor) -> None:
    """Add left (B, i, N) times the transpose of right, (B, j, N) or (j, N) for all, to total (B, i, j)."""
    if right.ndim == 3:
        total.baddbmm_(left, right.mT)
    else:
        total.flatten(0, 1).addmm_(left.flatten(0, 1), right.mT)


def _unfolded(sums: Tensor, layout: Layout) -> Tensor:
    """Turn sums over pairs of neurons and pairs of inputs into the block (B, h (r + 1), h (r + 1)) of JᵀJ."""
    neurons, inputs = (_pair_numbers(size, sums.device) for size in (layout.neurons, layout.inputs + 1))
    blocks = sums[:, neurons[:, None, :, None], inputs[None, :, None, :]]
    return blocks.reshape(len(sums), layout.border, layout.border)


def _pair_numbers(size: int, device: torch.device) -> Tensor:
    """(size, size) where each pair is among `_pairs`."""
    numbers = torch.empty(size, size, dtype=torch.long)
    first, second = torch.tensor(_pairs(size)).mT
    numbers[first, second] = numbers[second, first] = torch.arange(len(first))
    return numbers.to(device)


_SHORTEST_PIECE = 256


def _numbers_at_once(weights: Tensor) -> int:
    """So many that they stay in a processor's cache, or fill a GPU."""
    return 2**19 if weights.device.type == "cpu" else 2**27


def _scaled_alike(a: FeedForward, b: FeedForward) -> bool:
    names = ("input_centre", "input_half_range", "target_centre", "target_half_range")
    return all(torch.equal(getattr(a, name), getattr(b, name)) for name in names)
