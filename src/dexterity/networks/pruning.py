"""Radial-basis networks pruned neuron by neuron after they have grown.

Examples
--------
>>> import dexterity as dx
>>> from dexterity.networks import growth, network, problem, pruning
>>> space = dx.sampling.Box([-1, -1], [1, 1], levels=21)
>>> data = dx.sampling.data_sets(
...     lambda q: 2 + q[:, 0].sin(), space, train=100, test=50, validation=50
... )
>>> learned = problem.DesignProblem(network.View(2, [0, 1]), data)
>>> pruning.prune(learned, growth.grow(learned, spread=1.0).network).success
True
"""

from __future__ import annotations

from dataclasses import dataclass, field

import torch

from dexterity import checks
from dexterity.networks.growth import design_columns, orthogonalised, solve
from dexterity.networks.problem import DesignProblem
from dexterity.networks.radial_basis import RadialBasis
from dexterity.networks.rounding import is_sound

__all__ = ["Pruning", "prune"]


@dataclass(frozen=True)
class Pruning:
    """A network pruned as far as its testing error allows, and what removing more would do.

    Attributes
    ----------
    network
        The smallest network before the testing error first reached its limit; the one that came in, with
        weights solved anew, if that does not pass.
    success
        Whether the network that came in passes.
    order
        (h − 1) neurons of the network that came in, from 0, in the order of their removal.
    mean_square_errors
        (h) mean square error over the training set with h, h − 1, … 1 neurons.
    testing_errors
        (h) largest relative error over the test set.
    """

    network: RadialBasis
    success: bool
    order: tuple[int, ...] = field(repr=False)
    mean_square_errors: tuple[float, ...] = field(repr=False)
    testing_errors: tuple[float, ...] = field(repr=False)

    @property
    def neurons(self) -> int:
        """Number of neurons of the pruned network."""
        return self.network.neurons


@torch.no_grad()
@checks.arguments(problem=checks.Instance(DesignProblem), network=checks.Instance(RadialBasis))
def prune(problem: DesignProblem, network: RadialBasis, testing_error: float = 0.02) -> Pruning:
    r"""Remove neurons one at a time, the least useful first, while the testing error stays below its limit.

    The least useful neuron is the one without which the training error, with the output layer solved anew,
    grows least: by :math:`v_j^2 / [(A^\top A)^{-1}]_{jj}` for the columns A of the least-squares problem.

    Parameters
    ----------
    problem
        What the network has learned.
    network
        A network, whose output layer is solved anew first.
    testing_error
        Largest relative error on the test set, E, that a pruned network stays below.

    Raises
    ------
    ValueError
        If the network's inputs or centres do not fit the problem, or `testing_error` is not positive.

    References
    ----------
    Sotiropoulos & Aspragathos (2016), sections 4.5 and 5, propose to prune and leave open how; see the
    assumption ``pruning-method``. Hassibi & Stork (1993) for the growth of the error.
    """
    testing_error = checks.positive(testing_error, "testing_error")
    return _Pruning(problem, network).finish(testing_error)


class _Pruning:
    """A network that shrinks: its least-squares problem, solved anew without each column."""

    def __init__(self, problem: DesignProblem, network: RadialBasis) -> None:
        train, self.test = problem.data.train, problem.data.test
        self.network, self.count = network, len(train.values)
        self.test_columns = design_columns(network, self.test)
        columns = design_columns(network, train)
        self.triangle, self.projections = orthogonalised(columns, train.values)
        self.kept = list(range(network.neurons))
        self.weights = solve(self.triangle, self.projections)
        self.error = (columns @ self.weights - train.values).square().sum()

    def finish(self, limit: float) -> Pruning:
        """Remove all neurons but one; the network is the one before the limit is first reached."""
        order, history, passing = [], [self._errors()], [self._state()]
        passes = success = history[0][1] < limit and self._is_sound(limit)
        while len(self.kept) > 1:
            order.append(self._remove())
            history.append(self._errors())
            passes = passes and history[-1][1] < limit and self._is_sound(limit)
            if passes:
                passing.append(self._state())
        squares, testing = zip(*history, strict=True)
        return Pruning(passing[-1], success, tuple(order), squares, testing)

    def _is_sound(self, limit: float) -> bool:
        """Tell whether the answers are more than rounding: huge weights may cancel."""
        return is_sound(self._state(), self.test.q, limit)

    def _remove(self) -> int:
        """Remove the least useful neuron and say which of the network it was."""
        inverse = torch.linalg.solve_triangular(
            self.triangle, torch.eye(len(self.triangle), dtype=torch.float64), upper=True
        )
        growth = self.weights.square() / inverse.square().sum(1)
        # The first column is the constant, which stays.
        column = 1 + int(growth[1:].argmin())
        rest = torch.cat([self.triangle[:, :column], self.triangle[:, column + 1 :]], dim=1)
        basis, self.triangle = torch.linalg.qr(rest)
        self.projections = basis.mT @ self.projections
        self.weights = solve(self.triangle, self.projections)
        self.error = self.error + growth[column]
        return self.kept.pop(column - 1)

    def _errors(self) -> tuple[float, float]:
        columns = self.test_columns[:, [0, *(neuron + 1 for neuron in self.kept)]]
        testing_error = ((columns @ self.weights - self.test.values) / self.test.values).abs().max()
        return (self.error / self.count).item(), testing_error.item()

    def _state(self) -> RadialBasis:
        arrays = {
            "centres": self.network.centres[self.kept], "spread": self.network.spread,
            "input_scale": self.network.input_scale,
            "output_weights": self.weights[1:], "output_bias": self.weights[0],
        }  # fmt: skip
        return RadialBasis(self.network.view, arrays)
