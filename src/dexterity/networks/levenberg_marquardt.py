"""The Levenberg–Marquardt method for feed-forward networks, many at a time.

The step of Eq. 20 of Sotiropoulos & Aspragathos (2016) for a stack of networks of one size: restarts and
seeds share every matrix product, and a network that has stopped leaves the stack.

Examples
--------
>>> import torch
>>> from dexterity.networks import levenberg_marquardt as lm, network, train
>>> q = torch.linspace(-1, 1, 50).double()[:, None]
>>> (start,) = train.initial_networks(network.View(1, [0]), 4, q, q.sin()[:, 0], [0])
>>> training = lm.levenberg_marquardt(start, q, q.sin()[:, 0], lm.Options(goal=1e-6))
>>> training.success
True
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from enum import Enum
from typing import Literal, TypeAlias, get_args, overload

import torch
from torch import Tensor

from dexterity import checks, spatial
from dexterity.networks.feed_forward import FeedForward
from dexterity.networks.normal_equations import Layout, TrainingSet, normal_equations, sum_of_squares
from dexterity.networks.threads import one_thread
from dexterity.sampling import DataSet
from dexterity.spatial import TensorLike
from dexterity.spatial.values import require_values

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
    rises
        Training stops after so many steps taken since the error on held-out rows was least, if there are any.

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
    rises: int = 6

    def __post_init__(self) -> None:
        checks.fields(
            self,
            damping=checks.Choice(get_args(Damping)),
            **dict.fromkeys(("epochs", "rises"), checks.Whole(1)),
            **dict.fromkeys(("goal", "smallest_gradient", "smallest_step"), checks.Real(least=0)),
            **dict.fromkeys(("initial_damping", "largest_damping"), checks.Real(above=0)),
        )


class Stop(Enum):
    """Why a training ended."""

    GOAL = "the mean square error reached the goal"
    GRADIENT = "the gradient vanished"
    STEP = "the step became too short to matter"
    DAMPING = "no step lowers the error, however damped"
    EPOCHS = "the epochs were used up"
    RISES = "the error on held-out rows no longer fell"
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
    network: FeedForward,
    x: TensorLike,
    y: TensorLike,
    options: Options = ...,
    *,
    held_out: DataSet | None = ...,
) -> Training: ...
@overload
def levenberg_marquardt(
    network: Sequence[FeedForward],
    x: TensorLike,
    y: TensorLike,
    options: Options = ...,
    *,
    held_out: DataSet | None = ...,
) -> list[Training]: ...
@checks.arguments(options=checks.Instance(Options), held_out=checks.OrNone(checks.Instance(DataSet)))
def levenberg_marquardt(
    network: FeedForward | Sequence[FeedForward],
    x: TensorLike,
    y: TensorLike,
    options: Options = Options(),
    *,
    held_out: DataSet | None = None,
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
    held_out
        Rows that weights are not fitted to, the same for all networks. With them the network that is returned
        is the one with the least error on them.

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
    several = (network,) if isinstance(network, FeedForward) else network
    networks = list(checks.Each(checks.Instance(FeedForward))(several, "network"))
    if not networks:
        raise ValueError("network is an empty sequence; at least one network is needed")
    with one_thread():
        rows = _rows(networks, x, y)
        aside = None
        if held_out is not None:
            aside = _rows(networks, held_out.q, held_out.values, ("held_out.q", "held_out.values"))
        trainings = _train(networks, rows, aside, options)
    return trainings[0] if isinstance(network, FeedForward) else trainings


def _rows(
    networks: list[FeedForward], x: TensorLike, y: TensorLike, names: tuple[str, str] = ("x", "y")
) -> tuple[Tensor, Tensor]:
    """Return joint values (B or 1, N, n) and values (B or 1, N, k)."""
    first = networks[0]
    q, values = (
        require_values(spatial.to_float64(given, name), name).detach()
        for given, name in zip((x, y), names, strict=True)
    )
    if first.values == 1:
        values = values[..., None]
    if q.ndim == 2:
        q, values = q[None], values[None]
    if q.ndim != 3 or q.shape[0] not in (1, len(networks)) or q.shape[2] != first.joints:
        raise ValueError(
            f"{names[0]} has shape {tuple(q.shape)}; (N, {first.joints}), "
            f"or ({len(networks)}, N, {first.joints}) with rows of its own for each network, is needed"
        )
    if values.shape != (*q.shape[:2], first.values):
        raise ValueError(
            f"{names[1]} has shape {tuple(values.shape)}; "
            f"{names[0]} has {q.shape[1]} rows of {first.values} values"
        )
    if not q.shape[1]:
        raise ValueError(f"{names[0]} has no rows")
    return q, values


# ---- the iteration ---------------------------------------------------------------------------------


class _State:
    """Where each network of a stack is: best weights, their error and normal equations, and the damping."""

    def __init__(
        self,
        layout: Layout,
        weights: Tensor,
        training_set: TrainingSet,
        held_out: TrainingSet | None,
        options: Options,
    ) -> None:
        self.layout = layout
        self.training_set = training_set
        self.held_out = held_out
        self.options = options
        self.weights = weights
        self.error = sum_of_squares(layout, weights, training_set)
        self.matrix, self.vector = normal_equations(layout, weights, training_set)
        largest = self.matrix.diagonal(dim1=1, dim2=2).amax(-1)
        scale = largest if options.damping == "gain_ratio" else torch.ones_like(largest)
        self.damping = options.initial_damping * scale
        self.growth = torch.full_like(self.damping, 2.0)
        self.residuals = training_set.targets.shape[-1] * layout.values

    @property
    def mean_square_error(self) -> Tensor:
        """Mean square error (B) in the units of the targets."""
        return self.error / self.residuals * self.training_set.half_range**2

    @property
    def judged_by(self) -> Tensor:
        """What the returned network has least of (B): its error, on held-out rows if there are any."""
        if self.held_out is None:
            return self.error
        return sum_of_squares(self.layout, self.weights, self.held_out)

    def step(self) -> tuple[Tensor, Tensor]:
        """Try one step for each network; return which took it (B) and how long the steps were (B)."""
        identity = torch.eye(self.layout.parameters, dtype=self.weights.dtype, device=self.weights.device)
        factor, failed = torch.linalg.cholesky_ex(self.matrix + self.damping[:, None, None] * identity)
        steps = -torch.cholesky_solve(self.vector[..., None], factor)[..., 0]
        trial = self.weights + steps
        error = sum_of_squares(self.layout, trial, self.training_set)
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
        matrix, vector = normal_equations(self.layout, trial[taken], self.training_set[taken])
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
        self.training_set = self.training_set[going]
        self.held_out = self.held_out[going] if self.held_out else None
        for name in ("weights", "error", "matrix", "vector", "damping", "growth"):
            setattr(self, name, getattr(self, name)[going])


def _train(
    networks: list[FeedForward],
    rows: tuple[Tensor, Tensor],
    aside: tuple[Tensor, Tensor] | None,
    options: Options,
) -> list[Training]:
    layout = Layout.of(networks[0])
    _require_alike(networks)
    training_set = TrainingSet.of(networks, *rows)
    held_out = TrainingSet.of(networks, *aside) if aside else None
    state = _State(layout, layout.pack(networks), training_set, held_out, options)
    if not torch.isfinite(state.mean_square_error).all():
        raise ValueError(
            f"y reaches {float(rows[1].abs().max()):.3g}, and the mean square error is not finite: scale it"
        )
    judged = state.judged_by.tolist()
    records = [
        _Record(state.weights[i], mse, judged[i], [mse])
        for i, mse in enumerate(state.mean_square_error.tolist())
    ]
    _iterate(state, records, options.epochs)
    return [
        Training(
            layout.unpacked(network, record.weights), record.mean_square_error, len(record.history) - 1,
            record.stop, tuple(record.history),
        )
        for network, record in zip(networks, records, strict=True)
    ]  # fmt: skip


@dataclass
class _Record:
    """What is known of one training so far: the best weights, their error, what they were chosen by."""

    weights: Tensor
    mean_square_error: float
    least: float
    history: list[float]
    rises: int = 0
    stop: Stop = Stop.EPOCHS

    def look_at(self, weights: Tensor, mean_square_error: float, judged: float) -> None:
        """Keep weights that are better; count those that are not."""
        if judged < self.least:
            self.weights, self.mean_square_error = weights, mean_square_error
            self.least, self.rises = judged, 0
        else:
            self.rises += 1


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
    errors, judged, took = state.mean_square_error.tolist(), state.judged_by.tolist(), taken.tolist()
    for i, record in enumerate(going):
        record.history.append(errors[i])
        if took[i]:
            record.look_at(state.weights[i], errors[i], judged[i])
    return [
        reason or (Stop.RISES if record.rises >= state.options.rises else None)
        for reason, record in zip(state.reasons(taken, lengths), going, strict=True)
    ]


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
        if Layout.of(network) != Layout.of(first) or network.readout != first.readout or not same_view:
            raise ValueError(f"network {i} differs from the first in its size, its view or its readout")
