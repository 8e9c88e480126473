"""Radial-basis networks grown neuron by neuron.

The loop of Fig. 6b of Sotiropoulos & Aspragathos (2016): a neuron is placed at the training input with the
largest error, the output layer is solved anew, and the testing error decides when to stop. What the paper
leaves out is chosen as the assumptions of ``uvms.radial_basis`` say, in
``data/papers/sotiropoulos2016/assumptions.toml``.

Examples
--------
>>> import dexterity as dx
>>> from dexterity.networks import growth, network, problem
>>> space = dx.sampling.Box([-1, -1], [1, 1], levels=21)
>>> data = dx.sampling.data_sets(
...     lambda q: 2 + q[:, 0].sin(), space, train=100, test=50, validation=50
... )
>>> learned = problem.DesignProblem(network.View(2, [0, 1]), data)
>>> growth.grow(learned, spread=1.0).success
True
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from enum import Enum
from typing import get_args

import torch
from jaxtyping import Float64
from torch import Tensor

from dexterity import checks, spatial
from dexterity.networks.network import View
from dexterity.networks.problem import DesignProblem, Sweep
from dexterity.networks.radial_basis import RadialBasis, bells
from dexterity.networks.rounding import is_sound
from dexterity.sampling import DataSet
from dexterity.spatial import TensorLike
from dexterity.spatial.values import on_cpu

__all__ = ["Growth", "RadialBasisOptions", "Stop", "fit", "grow"]


MOST_SPREADS = 10_000
"""So many spreads can be tried at most."""


@dataclass(frozen=True)
class RadialBasisOptions:
    """Parameters of the design loop; the defaults are those of the paper's network for w.

    Attributes
    ----------
    testing_error
        E: a network is accepted when its largest relative error on the test set is below it, and no more than
        a thousandth of it can be rounding.
    training_goal
        :math:`E_{mse}`: mean square error at which no more neurons are added for a spread.
    error_threshold
        :math:`E_{th}`: mean square error below which testing begins; infinity tests every network.
    first_spread, spread_step, spread_limit
        Spreads that are tried, in the units of scaled inputs.
    neuron_limit
        Largest number of neurons.
    input_scale
        What inputs are multiplied by before distances are taken: one number, or one for each input.
    sweep
        Whether to end at the first spread that passes or to go through all.

    Raises
    ------
    ValueError
        If a number is out of its range, or testing would never begin.

    References
    ----------
    Sotiropoulos & Aspragathos (2016), Table 3 and section 3.4.
    """

    testing_error: float = 0.02
    training_goal: float = 1e-6
    error_threshold: float = 1e-2
    first_spread: float = 0.1
    spread_step: float = 0.1
    spread_limit: float = 10.0
    neuron_limit: int = 300
    input_scale: float | tuple[float, ...] = 1.0
    sweep: Sweep = "first"

    def __post_init__(self) -> None:
        factors = self.input_scale if isinstance(self.input_scale, tuple) else (self.input_scale,)
        scale = tuple(checks.positive(factor, "input_scale") for factor in factors)
        object.__setattr__(self, "input_scale", scale if isinstance(self.input_scale, tuple) else scale[0])
        checks.fields(
            self,
            testing_error=checks.Real(least=0),
            training_goal=checks.Real(least=0),
            error_threshold=checks.Real(infinite=True),
            **dict.fromkeys(("first_spread", "spread_step", "spread_limit"), checks.Real(above=0)),
            neuron_limit=checks.Whole(1),
            sweep=checks.Choice(get_args(Sweep)),
        )
        if not self.training_goal <= self.error_threshold:
            raise ValueError(
                f"error_threshold is {self.error_threshold}; at least the training goal, "
                f"{self.training_goal}, is needed, or testing would never begin"
            )
        if self.first_spread > self.spread_limit:
            raise ValueError(f"first_spread is {self.first_spread}; the limit is {self.spread_limit}")
        if not self._steps < MOST_SPREADS:
            raise ValueError(
                f"spread_step is {self.spread_step}; that makes {self._steps:.3g} spreads up to "
                f"{self.spread_limit}, and {MOST_SPREADS} are the most"
            )

    @property
    def _steps(self) -> float:
        return (self.spread_limit - self.first_spread) / self.spread_step

    @property
    def spreads(self) -> tuple[float, ...]:
        """Spreads from the first to the limit."""
        # A limit that rounding has put just below the last step belongs to the spreads.
        count = math.floor(self._steps + 1e-9) + 1
        return tuple(self.first_spread + i * self.spread_step for i in range(count))

    @checks.arguments(view=checks.Instance(View))
    def scale(self, view: View) -> Float64[Tensor, " r"]:
        """Return the factor of each input of a view.

        Raises
        ------
        ValueError
            If there is another number of factors than of inputs.
        """
        one = self.input_scale
        factors = one if isinstance(one, tuple) else (one,) * view.width
        if len(factors) != view.width:
            raise ValueError(f"input_scale has {len(factors)} factors; the view has {view.width} inputs")
        return torch.tensor(factors, dtype=torch.float64)


class Stop(Enum):
    """Why a network stopped growing."""

    TESTING_ERROR = "the testing error fell below its limit"
    GOAL = "the mean square error reached the goal"
    NEURONS = "the neuron limit was reached"
    CENTRES = "no input with a large error is independent of the centres"


@dataclass(frozen=True)
class Growth:
    """A network grown at one spread, and how it got there.

    Attributes
    ----------
    spread
        In the units of scaled inputs.
    network
        The network when growth stopped.
    stop
        Why it stopped.
    rows
        (h) rows of the training set at which the neurons stand, in the order in which they were placed.
    mean_square_errors
        (h) mean square error over the training set, Eq. 19, with 1, 2, … h neurons.
    testing_errors
        (h) largest relative error over the test set, Eq. 21.
    largest_weights
        (h) largest absolute output weight.
    condition
        Ratio of the largest to the smallest singular value of the last least-squares problem.
    skipped
        Number of inputs with a large error that were not taken, because a bell about them is the sum of
        those that there are, to rounding.
    """

    spread: float
    network: RadialBasis
    stop: Stop
    rows: tuple[int, ...] = field(repr=False)
    mean_square_errors: tuple[float, ...] = field(repr=False)
    testing_errors: tuple[float, ...] = field(repr=False)
    largest_weights: tuple[float, ...] = field(repr=False)
    condition: float
    skipped: int

    @property
    def success(self) -> bool:
        """Whether the testing error fell below its limit."""
        return self.stop is Stop.TESTING_ERROR

    @property
    def neurons(self) -> int:
        """Number of neurons when growth stopped."""
        return self.network.neurons


@torch.no_grad()
@checks.arguments(problem=checks.Instance(DesignProblem), options=checks.Instance(RadialBasisOptions))
def grow(problem: DesignProblem, spread: float, options: RadialBasisOptions = RadialBasisOptions()) -> Growth:
    """Grow a network at one spread, a neuron at a time at the training input with the largest error.

    Parameters
    ----------
    problem
        What to learn.
    spread
        Of all neurons, in the units of scaled inputs.
    options
        When to stop; their spreads are not looked at.

    Returns
    -------
    The growth. A testing error that is never reached is no error: see `Growth.stop`.

    Raises
    ------
    ValueError
        If the spread is not positive, or the options do not fit the view, or no bell differs from a
        constant, because the spread is huge or all inputs are the same.

    References
    ----------
    Sotiropoulos & Aspragathos (2016), section 3.4 and Fig. 6b. Chen, Cowan & Grant (1991) for growth by
    orthogonal least squares.
    """
    spread = checks.positive(spread, "spread")
    return _Growing(problem, spread, options).finish()


@torch.no_grad()
@checks.arguments(view=checks.Instance(View), train=checks.Instance(DataSet))
def fit(
    view: View, train: DataSet, centres: TensorLike, spread: float, input_scale: TensorLike
) -> RadialBasis:
    """Return the network with these centres whose output layer has the least mean square error.

    Parameters
    ----------
    view
        What the network sees.
    train
        Training set.
    centres
        (h, r) in the scaled input space.
    spread
        In the units of scaled inputs.
    input_scale
        (r) factors of the inputs.

    Raises
    ------
    ValueError
        If shapes do not fit, the spread is not positive, or the centres do not determine the weights: two
        coincide, or there are more than rows, or the spread is so large that bells depend on each other.
    """
    spread = checks.positive(spread, "spread")
    scale = on_cpu(input_scale, "input_scale")
    centres = spatial.batch_of(on_cpu(centres, "centres"), "centres", (view.width,))
    if centres.ndim != 2 or not len(centres):
        raise ValueError(f"centres has shape {tuple(centres.shape)}; (h, {view.width}) with h ≥ 1 is needed")
    arrays: dict[str, TensorLike] = {
        "centres": centres, "spread": spread, "input_scale": scale,
        "output_weights": torch.zeros(len(centres)), "output_bias": 0.0,
    }  # fmt: skip
    network = RadialBasis(view, arrays)
    triangle, projections = orthogonalised(design_columns(network, train), train.values)
    weights = solve(triangle, projections)
    return RadialBasis(view, arrays | {"output_weights": weights[1:], "output_bias": weights[0]})


# ---- growing -----------------------------------------------------------------------------------------

INDEPENDENCE = 1e-13
"""Least share of a bell that must not be the sum of earlier ones; rounding is some 1e-16 of it."""

ATTEMPTS = 100
"""Inputs that are tried in turn for one neuron, the largest error first, before growth stops."""


class _Growing:
    """A network that grows: its least-squares problem, solved anew with each column."""

    def __init__(self, problem: DesignProblem, spread: float, options: RadialBasisOptions) -> None:
        train, test = problem.data.train, problem.data.test
        self.problem, self.spread, self.options = problem, spread, options
        self.scale = options.scale(problem.view)
        self.x, self.test_x = (problem.view(data.q) * self.scale for data in (train, test))
        capacity = min(options.neuron_limit, len(self.x)) + 1
        self.basis = _Basis(len(self.x), capacity)
        self.projections = torch.zeros(capacity, dtype=torch.float64)
        self.test_columns = torch.ones(capacity, len(self.test_x), dtype=torch.float64)
        self.residuals = train.values.clone()
        self.free = torch.ones(len(self.x), dtype=torch.bool)
        self.rows: list[int] = []
        self.history: list[tuple[float, float, float]] = []
        self.skipped = 0
        self._append(torch.ones_like(train.values))

    def finish(self) -> Growth:
        """Grow until there is a reason to stop."""
        stop = None
        while stop is None:
            stop = self._reason() if self._place() else Stop.CENTRES
        if not self.rows:
            raise ValueError(
                f"spread is {self.spread}; no bell about a training input differs from a constant then"
            )
        network = self._network()
        singular_values = torch.linalg.svdvals(self._triangle())
        squares, testing, largest = zip(*self.history, strict=True)
        return Growth(
            self.spread, network, stop, tuple(self.rows), squares, testing, largest,
            (singular_values[0] / singular_values[-1]).item(), self.skipped,
        )  # fmt: skip

    def _place(self) -> bool:
        """Place a neuron at the worst input that gives an independent one; tell whether there is any."""
        errors = torch.where(self.free, self.residuals.abs(), -1.0)
        for _ in range(min(ATTEMPTS, int(self.free.sum()))):
            row = int(errors.argmax())
            errors[row] = -1.0
            self.free[row] = False
            centre = self.x[row, None]
            if self._append(bells(self.x, centre, self.spread)[:, 0]):
                self.rows.append(row)
                self.test_columns[self.basis.size - 1] = bells(self.test_x, centre, self.spread)[:, 0]
                self._record()
                return True
            self.skipped += 1
        return False

    def _append(self, column: Tensor) -> bool:
        """Give the least-squares problem a column unless it depends on the others."""
        if not self.basis.append(column):
            return False
        latest = self.basis.vectors[self.basis.size - 1]
        share = latest @ self.residuals
        self.projections[self.basis.size - 1] = share
        self.residuals -= share * latest
        return True

    def _record(self) -> None:
        weights, values = self._weights(), self.problem.data.test.values
        answers = weights @ self.test_columns[: self.basis.size]
        testing_error = ((answers - values) / values).abs().max().item()
        self.history.append((
            self.residuals.square().mean().item(), testing_error, weights[1:].abs().max().item()
        ))  # fmt: skip

    def _reason(self) -> Stop | None:
        mean_square_error, testing_error, _ = self.history[-1]
        passes = testing_error < self.options.testing_error
        if passes and mean_square_error < self.options.error_threshold and self._is_sound():
            return Stop.TESTING_ERROR
        if mean_square_error <= self.options.training_goal:
            return Stop.GOAL
        return Stop.NEURONS if len(self.rows) == self.options.neuron_limit else None

    def _is_sound(self) -> bool:
        """Tell whether the answers are more than rounding: huge weights may cancel."""
        return is_sound(self._network(), self.problem.data.test.q, self.options.testing_error)

    def _network(self) -> RadialBasis:
        weights = self._weights()
        return RadialBasis(self.problem.view, {
            "centres": self.x[self.rows], "spread": self.spread, "input_scale": self.scale,
            "output_weights": weights[1:], "output_bias": weights[0],
        })  # fmt: skip

    def _triangle(self) -> Tensor:
        return self.basis.triangle[: self.basis.size, : self.basis.size]

    def _weights(self) -> Tensor:
        """Bias and output weights (h + 1)."""
        return solve(self._triangle(), self.projections[: self.basis.size])


class _Basis:
    """Orthonormal vectors (size, N) and the triangle that makes the columns so far from them."""

    def __init__(self, rows: int, capacity: int) -> None:
        self.size = 0
        self.vectors = torch.empty(capacity, rows, dtype=torch.float64)
        self.triangle = torch.zeros(capacity, capacity, dtype=torch.float64)

    def append(self, column: Tensor) -> bool:
        """Add a column (N) unless it depends on those that there are; tell whether it was added."""
        vectors = self.vectors[: self.size]
        shares, rest = torch.zeros(self.size, dtype=torch.float64), column
        # Once more, since the first pass leaves what rounding made of it; a third would change nothing.
        for _ in range(2):
            share = vectors @ rest
            rest = rest - share @ vectors
            shares += share
        length = torch.linalg.vector_norm(rest)
        if not length > INDEPENDENCE * torch.linalg.vector_norm(column):
            return False
        self.vectors[self.size] = rest / length
        self.triangle[: self.size, self.size] = shares
        self.triangle[self.size, self.size] = length
        self.size += 1
        return True


# ---- least squares -----------------------------------------------------------------------------------


def design_columns(network: RadialBasis, data: DataSet) -> Tensor:
    """Columns (N, h + 1) whose weighted sum is the network: a constant, then the bells."""
    hidden = network.hidden(network.view(data.q))
    return torch.cat([hidden.new_ones(len(hidden), 1), hidden], dim=1)


def orthogonalised(columns: Tensor, values: Tensor) -> tuple[Tensor, Tensor]:
    """Triangle (h + 1, h + 1) of the columns, and the values in the basis that it leaves (h + 1)."""
    rows, width = columns.shape
    if rows < width:
        raise ValueError(f"train has {rows} rows; at least {width} are needed for {width - 1} centres")
    basis, triangle = torch.linalg.qr(columns)
    if (triangle.diagonal().abs() < INDEPENDENCE * triangle.norm(dim=0)).any():
        raise ValueError("centres do not determine the weights: a bell is the sum of the others, to rounding")
    return triangle, basis.mT @ values


def solve(triangle: Tensor, projections: Tensor) -> Tensor:
    return torch.linalg.solve_triangular(triangle, projections[:, None], upper=True)[:, 0]
