"""The design loop of radial-basis networks over spreads, Fig. 6b of Sotiropoulos & Aspragathos (2016).

Examples
--------
>>> import dexterity as dx
>>> from dexterity.networks import network, problem, radial_basis_design
>>> space = dx.sampling.Box([-1, -1], [1, 1], levels=21)
>>> data = dx.sampling.data_sets(
...     lambda q: 2 + q[:, 0].sin(), space, train=100, test=50, validation=50
... )
>>> learned = problem.DesignProblem(network.View(2, [0, 1]), data)
>>> radial_basis_design.design_radial_basis(learned, progress=False).success
True
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace

import joblib

from dexterity import checks
from dexterity.networks.growth import Growth, RadialBasisOptions, grow
from dexterity.networks.problem import DesignProblem, End, collected
from dexterity.networks.radial_basis import RadialBasis
from dexterity.networks.threads import one_thread

__all__ = ["RadialBasisDesign", "design_radial_basis"]

_PRINTED = RadialBasisOptions()


@dataclass(frozen=True)
class RadialBasisDesign:
    """Outcome of a design loop.

    Attributes
    ----------
    network
        The network with the fewest neurons that passes; if none does, that with the smallest testing error
        of all sizes at all spreads.
    best
        The growth that it comes from.
    end
        Why the loop ended.
    growths
        One for each spread that was tried, in rising order.
    """

    network: RadialBasis
    best: Growth
    end: End
    growths: tuple[Growth, ...] = field(repr=False)

    @property
    def success(self) -> bool:
        """Whether the network passes."""
        return self.end is End.PASSED


@checks.arguments(
    problem=checks.Instance(DesignProblem),
    options=checks.Instance(RadialBasisOptions),
    n_jobs=checks.Whole(),
    progress=checks.Flag(),
)
def design_radial_basis(
    problem: DesignProblem,
    options: RadialBasisOptions = _PRINTED,
    *,
    n_jobs: int = 1,
    progress: bool = True,
) -> RadialBasisDesign:
    """Grow a network at each spread until one passes, or at all of them, and return the smallest that passes.

    An interrupt from the keyboard ends the loop and returns what there is so far.

    Parameters
    ----------
    problem
        What to learn.
    options
        Which spreads, when to stop, and whether to go on after the first spread that passes.
    n_jobs
        Spreads that joblib grows at the same time, in its current backend. The result does not depend on it.
    progress
        Whether to show a bar on stderr.

    Returns
    -------
    The design. Testing errors that are never reached are no error: see `RadialBasisDesign.end`.

    Raises
    ------
    ValueError
        If the options do not fit the problem.
    KeyboardInterrupt
        If there is nothing so far.

    References
    ----------
    Sotiropoulos & Aspragathos (2016), section 3.4, Fig. 6b, Table 3.
    """
    growths, end = collected(_in_turn(problem, options, n_jobs), len(options.spreads), "spread", progress)
    return _design(problem, options, growths, end)


def _in_turn(problem: DesignProblem, options: RadialBasisOptions, n_jobs: int) -> Iterator[Growth]:
    """Growths in the order of the spreads, as many at a time as there are jobs, up to where the loop ends."""
    at_once = joblib.effective_n_jobs(n_jobs)
    parallel = joblib.Parallel(n_jobs=n_jobs, return_as="generator")
    for start in range(0, len(options.spreads), at_once):
        spreads = options.spreads[start : start + at_once]
        for growth in parallel(joblib.delayed(_grown)(problem, spread, options) for spread in spreads):
            yield growth
            if growth.success and options.sweep == "first":
                return


def _grown(problem: DesignProblem, spread: float, options: RadialBasisOptions) -> Growth:
    with one_thread():
        return grow(problem, spread, options)


def _design(
    problem: DesignProblem, options: RadialBasisOptions, growths: Sequence[Growth], otherwise: End
) -> RadialBasisDesign:
    """Return the smallest network that passes, else that with the smallest error and the end `otherwise`."""
    passing = [growth for growth in growths if growth.success]
    if passing:
        best = min(passing, key=lambda growth: growth.neurons)
        return RadialBasisDesign(best.network, best, End.PASSED, tuple(growths))
    best = min(growths, key=lambda growth: min(growth.testing_errors))
    neurons = best.testing_errors.index(min(best.testing_errors)) + 1
    smallest = _grown(problem, best.spread, replace(options, neuron_limit=neurons))
    return RadialBasisDesign(smallest.network, best, otherwise, tuple(growths))
