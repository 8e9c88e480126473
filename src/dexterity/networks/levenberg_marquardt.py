"""The Levenberg–Marquardt method for feed-forward networks, many at a time.

The step of Eq. 20 of Sotiropoulos & Aspragathos (2016) with the network's Jacobian written out, for a stack
of networks of one size: restarts and seeds share every matrix product, and a network that has stopped
leaves the stack. Only the normal equations are kept, summed over pieces of the rows.
"""

from __future__ import annotations

import copy
import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from enum import Enum
from functools import lru_cache
from typing import Literal, TypeAlias, get_args, overload

import torch
from torch import Tensor

from dexterity import spatial
from dexterity.networks.feed_forward import (
    EIGENVALUES,
    FeedForward,
    smallest_eigenvalue,
    symmetric,
    target_of,
)
from dexterity.spatial import TensorLike

__all__ = ["Damping", "Options", "Stop", "Training", "levenberg_marquardt"]

Damping: TypeAlias = Literal["gain_ratio", "factor"]
"""How the damping changes, by the gain ratio of a step (Nielsen) or by factors (the paper's toolbox)."""


@dataclass(frozen=True)
class Options:
    """When to stop, and how to damp.

    Attributes
    ----------
    goal
        Mean square error at which training has succeeded, in units of what is trained on: the index itself
        unless the network's readout says otherwise.
    epochs
        Largest number of steps tried, whether they are taken or not.
    damping
        ``"gain_ratio"``: from `initial_damping` times the largest diagonal element of the normal equations;
        raised ever faster while steps fail, lowered by how well the model foretold a step that succeeds.
        ``"factor"``: the damping starts at `initial_damping` itself, ×10 after a step that fails, ×0.1
        after one that succeeds.
    initial_damping
        See `damping`.
    smallest_gradient
        Training stops where no element of the gradient of the scaled mean square error is larger.
    smallest_step
        Training stops at a step shorter than this times the length of all weights.
    largest_damping
        Training stops where damping has grown beyond it and steps still fail.

    Raises
    ------
    ValueError
        If a number is out of its range or the damping rule is unknown.
    """

    goal: float = 0.0
    epochs: int = 100
    damping: Damping = "gain_ratio"
    initial_damping: float = 1e-3
    smallest_gradient: float = 1e-10
    smallest_step: float = 1e-10
    largest_damping: float = 1e10

    def __post_init__(self) -> None:
        if self.damping not in get_args(Damping):
            raise ValueError(f"damping is {self.damping!r}; {get_args(Damping)} are known")
        if self.epochs < 1:
            raise ValueError(f"epochs is {self.epochs}; at least 1 is needed")
        for name in ("goal", "smallest_gradient", "smallest_step"):
            if not 0 <= getattr(self, name) < math.inf:
                raise ValueError(f"{name} is {getattr(self, name)}; 0 or a positive number is needed")
        for name in ("initial_damping", "largest_damping"):
            if not 0 < getattr(self, name) < math.inf:
                raise ValueError(f"{name} is {getattr(self, name)}; a positive number is needed")


class Stop(Enum):
    """Why a training ended."""

    GOAL = "the mean square error reached the goal"
    GRADIENT = "the gradient vanished"
    STEP = "the step became too short to matter"
    DAMPING = "no step lowers the error, however damped"
    EPOCHS = "the epochs were used up"
    INTERRUPTED = "it was interrupted"


@dataclass(frozen=True)
class Training:
    """A trained network and how it got there.

    Attributes
    ----------
    network
        Network with the best weights found.
    mean_square_error
        Mean square error of that network over the training set, Eq. 19, in the units of `Options.goal`.
    epochs
        Steps tried.
    stop
        Why it ended.
    history
        (epochs + 1) mean square error before the first step and after each.
    """

    network: FeedForward
    mean_square_error: float
    epochs: int
    stop: Stop
    history: tuple[float, ...] = field(repr=False)

    @property
    def success(self) -> bool:
        """Whether the goal was reached."""
        return self.stop is Stop.GOAL


@overload
def levenberg_marquardt(
    network: FeedForward, x: TensorLike, y: TensorLike, options: Options = ...
) -> Training: ...
@overload
def levenberg_marquardt(
    network: Sequence[FeedForward], x: TensorLike, y: TensorLike, options: Options = ...
) -> list[Training]: ...
def levenberg_marquardt(
    network: FeedForward | Sequence[FeedForward],
    x: TensorLike,
    y: TensorLike,
    options: Options = Options(),
) -> Training | list[Training]:
    r"""Train a network, or several of one size in one call.

    A step takes :math:`(J^\top J + \mu I)^{-1} J^\top e` off the weights. An interrupt from the keyboard ends
    the training and returns the best weights so far.

    Parameters
    ----------
    network
        Initial networks; they are left as they are. Several must agree in everything but their weights and
        scaling.
    x
        (N, n) joint values, or (B, N, n) with rows of its own for each of B networks.
    y
        (N) values, or (N, k) for k outputs; with a leading axis B as `x`.
    options
        When to stop, and how to damp.

    Returns
    -------
    A training, or a list of them for a sequence. A goal that is not reached is no error: see `Training.stop`.

    Raises
    ------
    ValueError
        If there is no network or no row, shapes do not fit, something is not finite, or the networks of a
        sequence are not alike.

    References
    ----------
    Hagan & Menhaj (1994); Nielsen (1999), Damping parameter in Marquardt's method; Sotiropoulos & Aspragathos
    (2016), Eqs. 19 and 20.
    """
    networks = [network] if isinstance(network, FeedForward) else list(network)
    if not networks:
        raise ValueError("network is an empty sequence; at least one network is needed")
    trainings = _train(networks, *_rows(networks, x, y), options)
    return trainings[0] if isinstance(network, FeedForward) else trainings


def _rows(networks: list[FeedForward], x: TensorLike, y: TensorLike) -> tuple[Tensor, Tensor]:
    """Return joint values (B or 1, N, n) and values (B or 1, N, k)."""
    first = networks[0]
    q, values = spatial.to_float64(x, "x"), spatial.to_float64(y, "y")
    if first.values == 1:
        values = values[..., None]
    if q.ndim == 2:
        q, values = q[None], values[None]
    if q.ndim != 3 or q.shape[0] not in (1, len(networks)) or q.shape[2] != first.joints:
        raise ValueError(
            f"x has shape {tuple(q.shape)}; (N, {first.joints}), or ({len(networks)}, N, {first.joints}) "
            "with rows of its own for each network, is needed"
        )
    if values.shape != (*q.shape[:2], first.values):
        raise ValueError(
            f"y has shape {tuple(values.shape)}; x has {q.shape[1]} rows of {first.values} values"
        )
    if not q.shape[1]:
        raise ValueError("x has no rows")
    return q, values


# ---- the training set as a stack of networks sees it -----------------------------------------------


@dataclass(frozen=True)
class _Problem:
    """What the networks of a stack see and should answer, one row of the training set a column.

    Scaled inputs with a one below (B or 1, r + 1, N), the products of any two of them (B or 1, ·, N), scaled
    targets (B or 1, k, N), and half ranges (B) of the targets.
    """

    inputs: Tensor
    products: Tensor
    targets: Tensor
    half_range: Tensor
    eigenvalue: bool

    @classmethod
    def of(cls, networks: Sequence[FeedForward], q: Tensor, values: Tensor) -> _Problem:
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

    def __getitem__(self, networks: Tensor | slice) -> _Problem:
        """Return the problem of some of the networks."""
        if len(self.inputs) == 1:
            return replace(self, half_range=self.half_range[networks])
        inputs, products, targets = (array[networks] for array in (self.inputs, self.products, self.targets))
        return _Problem(inputs, products, targets, self.half_range[networks], self.eigenvalue)

    def pieces(self, rows: int) -> Iterator[tuple[Tensor, Tensor, Tensor]]:
        """Yield inputs, their products and targets, so many rows at a time; what all share has no axis B."""
        arrays = (self.inputs, self.products, self.targets)
        shared = (array[0] if len(array) == 1 else array for array in arrays)
        yield from zip(*(array.split(max(1, rows), dim=-1) for array in shared), strict=True)


@dataclass(frozen=True)
class _Shape:
    """Sizes of a network, and its weights in one row of P numbers."""

    inputs: int
    neurons: int
    outputs: int
    values: int

    @classmethod
    def of(cls, network: FeedForward) -> _Shape:
        neurons, inputs = network.hidden_weights.shape
        return cls(inputs, neurons, len(network.output_biases), network.values)

    @property
    def border(self) -> int:
        """Where the output layer begins among the weights."""
        return self.neurons * (self.inputs + 1)

    @property
    def parameters(self) -> int:
        return self.border + self.outputs * (self.neurons + 1)

    def pack(self, networks: Sequence[FeedForward]) -> Tensor:
        """Weights (B, P) of networks."""
        rows = []
        for network in networks:
            hidden = torch.cat([network.hidden_weights, network.hidden_biases[:, None]], dim=1)
            output = torch.cat([network.output_weights, network.output_biases[:, None]], dim=1)
            rows.append(torch.cat([hidden.flatten(), output.flatten()]).detach())
        return torch.stack(rows)

    def layers(self, weights: Tensor) -> tuple[Tensor, Tensor]:
        """Hidden (B, h, r + 1) and output layer (B, m, h + 1) of weights (B, P), biases last."""
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


def _error(shape: _Shape, weights: Tensor, problem: _Problem) -> Tensor:
    """Sum of squared residuals (B)."""
    total = weights.new_zeros(len(weights))
    layers = shape.layers(weights)
    for x, _, targets in problem.pieces(_numbers_at_once(weights) // (len(weights) * shape.neurons)):
        residuals = _answers(layers, x, problem.eigenvalue)[2] - targets
        total += residuals.square().sum(dim=(1, 2))
    return total


def _normal_equations(shape: _Shape, weights: Tensor, problem: _Problem) -> tuple[Tensor, Tensor]:
    """JᵀJ (B, P, P) and Jᵀe (B, P), for so many networks at a time that pieces of the rows stay long."""
    numbers = shape.values * (shape.parameters + len(_pairs(shape.neurons)))
    together = max(1, _numbers_at_once(weights) // (_SHORTEST_PIECE * numbers))
    parts = []
    for start in range(0, len(weights), together):
        some = slice(start, start + together)
        rows = _numbers_at_once(weights) // (numbers * len(weights[some]))
        parts.append(_summed_over_rows(shape, weights[some], problem[some], rows))
    matrices, vectors = zip(*parts, strict=True)
    return torch.cat(matrices), torch.cat(vectors)


def _summed_over_rows(shape: _Shape, weights: Tensor, problem: _Problem, rows: int) -> tuple[Tensor, Tensor]:
    r"""JᵀJ (B, P, P) and Jᵀe (B, P), without J.

    In the Jacobian of a row, the weight from input a to neuron j has the column :math:`g_j x_a`. The sum of
    :math:`g_j x_a \, g_k x_b` over the rows is a product of all pairs (j, k) and all pairs (a, b), of which
    about half each differ: a quarter of the work of JᵀJ, and the pairs (a, b) are the same for all networks.
    """
    layers = shape.layers(weights)
    tail = shape.parameters - shape.border
    pairs = [len(_pairs(size)) for size in (shape.neurons, shape.inputs + 1)]
    hidden_part = weights.new_zeros(len(weights), *pairs)
    cross_part = weights.new_zeros(len(weights), shape.border, tail + 1)
    output_part = weights.new_zeros(len(weights), tail, tail + 1)
    for x, products, targets in problem.pieces(rows):
        hidden, outputs, answers = _answers(layers, x, problem.eigenvalue)
        slopes = _slopes(outputs, shape.values, problem.eigenvalue)
        by_output = _by_output_layer(slopes, hidden, answers - targets)
        into_hidden = _into_hidden(slopes, layers[1], hidden)
        x, products = (_repeated(array, shape.values) for array in (x, products))
        by_hidden = (into_hidden[:, :, None] * x[..., None, :, :]).flatten(1, 2)
        _add_product(hidden_part, _products(into_hidden), products)
        _add_product(cross_part, by_hidden, by_output)
        _add_product(output_part, by_output[:, :-1], by_output)
    across = torch.cat([cross_part, output_part], dim=1)
    left = torch.cat([_unfolded(hidden_part, shape), cross_part[..., :-1].mT], dim=1)
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


def _unfolded(sums: Tensor, shape: _Shape) -> Tensor:
    """Turn sums over pairs of neurons and pairs of inputs into the block (B, h (r + 1), h (r + 1)) of JᵀJ."""
    neurons, inputs = (_pair_numbers(size, sums.device) for size in (shape.neurons, shape.inputs + 1))
    blocks = sums[:, neurons[:, None, :, None], inputs[None, :, None, :]]
    return blocks.reshape(len(sums), shape.border, shape.border)


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


# ---- the iteration ---------------------------------------------------------------------------------


class _State:
    """Where each network of a stack is: best weights, their error and normal equations, and the damping."""

    def __init__(self, shape: _Shape, weights: Tensor, problem: _Problem, options: Options) -> None:
        self.shape = shape
        self.problem = problem
        self.options = options
        self.weights = weights
        self.error = _error(shape, weights, problem)
        self.matrix, self.vector = _normal_equations(shape, weights, problem)
        largest = self.matrix.diagonal(dim1=1, dim2=2).amax(-1)
        scale = largest if options.damping == "gain_ratio" else torch.ones_like(largest)
        self.damping = options.initial_damping * scale
        self.growth = torch.full_like(self.damping, 2.0)
        self.residuals = problem.targets.shape[-1] * shape.values

    @property
    def mean_square_error(self) -> Tensor:
        """Mean square error (B) in the units of the targets."""
        return self.error / self.residuals * self.problem.half_range**2

    def step(self) -> tuple[Tensor, Tensor]:
        """Try one step for each network; return which took it (B) and how long the steps were (B)."""
        identity = torch.eye(self.shape.parameters, dtype=self.weights.dtype, device=self.weights.device)
        factor, failed = torch.linalg.cholesky_ex(self.matrix + self.damping[:, None, None] * identity)
        steps = -torch.cholesky_solve(self.vector[..., None], factor)[..., 0]
        trial = self.weights + steps
        error = _error(self.shape, trial, self.problem)
        foretold = (steps * (self.damping[:, None] * steps - self.vector)).sum(-1)
        gain = (self.error - error) / foretold
        taken = (failed == 0) & (error < self.error)
        self._damp(taken, gain)
        self._take(taken, trial, error)
        return taken, steps.norm(dim=-1)

    def _damp(self, taken: Tensor, gain: Tensor) -> None:
        if self.options.damping == "factor":
            self.damping = torch.where(taken, 0.1 * self.damping, 10 * self.damping)
        else:
            lowered = self.damping * (1 - (2 * gain - 1) ** 3).clamp(min=1 / 3)
            self.damping = torch.where(taken, lowered, self.damping * self.growth)
            self.growth = torch.where(taken, 2.0, 2 * self.growth)

    def _take(self, taken: Tensor, trial: Tensor, error: Tensor) -> None:
        if not taken.any():
            return
        matrix, vector = _normal_equations(self.shape, trial[taken], self.problem[taken])
        self.weights = torch.where(taken[:, None], trial, self.weights)
        self.error = torch.where(taken, error, self.error)
        self.matrix[taken], self.vector[taken] = matrix, vector

    def reasons(self, taken: Tensor, lengths: Tensor) -> list[Stop | None]:
        """Why each network should stop now, or None."""
        smallest_step = self.options.smallest_step * self.weights.norm(dim=-1)
        tests = {
            Stop.GOAL: self.mean_square_error <= self.options.goal,
            Stop.GRADIENT: self.vector.abs().amax(-1) <= self.options.smallest_gradient * self.residuals,
            Stop.STEP: taken & (lengths <= smallest_step),
            Stop.DAMPING: ~taken
            & ((self.damping > self.options.largest_damping) | (lengths <= smallest_step)),
        }
        flags = {stop: test.tolist() for stop, test in tests.items()}
        return [next((stop for stop in flags if flags[stop][i]), None) for i in range(len(self.weights))]

    def keep(self, going: Tensor) -> None:
        """Go on with some of the networks alone."""
        self.problem = self.problem[going]
        for name in ("weights", "error", "matrix", "vector", "damping", "growth"):
            setattr(self, name, getattr(self, name)[going])


def _train(networks: list[FeedForward], q: Tensor, values: Tensor, options: Options) -> list[Training]:
    shape = _Shape.of(networks[0])
    _require_alike(networks)
    state = _State(shape, shape.pack(networks), _Problem.of(networks, q, values), options)
    records = [_Record(state.weights[i], [mse]) for i, mse in enumerate(state.mean_square_error.tolist())]
    _iterate(state, records, options.epochs)
    return [
        Training(
            shape.unpacked(network, record.weights), record.history[-1], len(record.history) - 1, record.stop,
            tuple(record.history),
        )
        for network, record in zip(networks, records, strict=True)
    ]  # fmt: skip


@dataclass
class _Record:
    """What is known of one training so far."""

    weights: Tensor
    history: list[float]
    stop: Stop = Stop.EPOCHS


def _iterate(state: _State, records: list[_Record], epochs: int) -> None:
    """Step until every network has stopped, and fill in the records."""
    going = list(records)
    lengths = torch.full_like(state.error, math.inf)
    reasons = state.reasons(torch.ones_like(state.error, dtype=torch.bool), lengths)
    try:
        for _ in range(epochs):
            going = _leave(state, going, reasons)
            if not going:
                return
            reasons = _epoch(state, going)
        _leave(state, going, reasons)
    except KeyboardInterrupt:
        for record in going:
            record.stop = Stop.INTERRUPTED


def _epoch(state: _State, going: list[_Record]) -> list[Stop | None]:
    taken, lengths = state.step()
    errors, took = state.mean_square_error.tolist(), taken.tolist()
    for i, record in enumerate(going):
        record.history.append(errors[i])
        if took[i]:
            record.weights = state.weights[i]
    return state.reasons(taken, lengths)


def _leave(state: _State, going: list[_Record], reasons: list[Stop | None]) -> list[_Record]:
    """Let the networks that have a reason stop; return the records of the others."""
    for record, reason in zip(going, reasons, strict=True):
        if reason is not None:
            record.stop = reason
    staying = [i for i, reason in enumerate(reasons) if reason is None]
    if len(staying) < len(going):
        state.keep(torch.tensor(staying, dtype=torch.long, device=state.error.device))
    return [going[i] for i in staying]


def _require_alike(networks: list[FeedForward]) -> None:
    first = networks[0]
    for i, network in enumerate(networks[1:], start=1):
        same_view = network.inputs == first.inputs and torch.equal(network.view.carriers, first.view.carriers)
        if _Shape.of(network) != _Shape.of(first) or network.readout != first.readout or not same_view:
            raise ValueError(f"network {i} differs from the first in its size, its view or its readout")
