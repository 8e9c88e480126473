"""The design loop of radial-basis networks over spreads, Fig. 6b of Sotiropoulos & Aspragathos (2016).

The growth at one spread is a job of its own and is stored when it is finished, so that a design that was
killed goes on where it was.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from typing import Any, TypeAlias, cast

import joblib
from tqdm import tqdm

from dexterity import spatial, store
from dexterity.networks import growth as growth_module
from dexterity.networks import network as network_module
from dexterity.networks import problem as problem_module
from dexterity.networks import radial_basis
from dexterity.networks.growth import Growth, RadialBasisOptions, Stop, grow
from dexterity.networks.problem import DesignProblem
from dexterity.networks.radial_basis import RadialBasis
from dexterity.networks.threads import one_thread
from dexterity.networks.trials import TrialStore, source_key

__all__ = ["GrowthRun", "RadialBasisDesign", "design_radial_basis", "grow_all"]

GrowthRun: TypeAlias = tuple[DesignProblem, float, RadialBasisOptions]
"""What :func:`dexterity.networks.growth.grow` takes: a problem, a spread and options."""


@dataclass(frozen=True)
class RadialBasisDesign:
    """What a design loop found.

    Attributes
    ----------
    network
        The network with the fewest neurons that passes; if none does, that with the smallest testing error
        of all sizes at all spreads.
    best
        The growth that it comes from.
    success
        Whether it passes.
    growths
        One for each spread that was tried, in rising order.
    """

    network: RadialBasis
    best: Growth
    success: bool
    growths: tuple[Growth, ...] = field(repr=False)


def design_radial_basis(
    problem: DesignProblem,
    options: RadialBasisOptions,
    *,
    n_jobs: int = 1,
    trials: TrialStore | None = None,
    progress: bool = True,
) -> RadialBasisDesign:
    """Grow a network at each spread until one passes, or at all of them, and return the smallest that passes.

    Parameters
    ----------
    problem
        What to learn.
    options
        Which spreads, when to stop, and whether to go on after the first spread that passes.
    n_jobs
        Spreads that joblib grows at the same time, in its current backend. The result does not depend on it.
    trials
        Where to look for growths that were finished before, and to keep new ones.
    progress
        Whether to show a bar on stderr.

    Returns
    -------
    The design. Testing errors that are never reached are no error: see `RadialBasisDesign.success`.

    Raises
    ------
    ValueError
        If the options do not fit the problem.

    References
    ----------
    Sotiropoulos & Aspragathos (2016), section 3.4, Fig. 6b, Table 3.
    """
    growths = []
    with tqdm(total=len(options.spreads), unit="spread", disable=not progress) as bar:
        for growth in _in_turn(problem, options, n_jobs, trials):
            growths.append(growth)
            bar.update()
            if growth.success and options.sweep == "first":
                break
    passing = [growth for growth in growths if growth.success]
    if passing:
        best = min(passing, key=lambda growth: growth.neurons)
        return RadialBasisDesign(best.network, best, True, tuple(growths))
    best = min(growths, key=lambda growth: min(growth.testing_errors))
    neurons = best.testing_errors.index(min(best.testing_errors)) + 1
    smallest = _grown(problem, best.spread, replace(options, neuron_limit=neurons), trials)
    return RadialBasisDesign(smallest.network, best, False, tuple(growths))


def grow_all(
    runs: Sequence[GrowthRun], *, n_jobs: int = 1, trials: TrialStore | None = None, progress: bool = True
) -> tuple[Growth, ...]:
    """Grow several networks at the same time, such as one for each of many spreads and seeds.

    Parameters
    ----------
    runs
        What to grow.
    n_jobs, trials, progress
        See :func:`design_radial_basis`.

    Returns
    -------
    The growths in the order of the runs, whatever the number of jobs.

    Raises
    ------
    ValueError
        See :func:`dexterity.networks.growth.grow`.
    """
    parallel = joblib.Parallel(n_jobs=n_jobs, return_as="generator")
    results = parallel(joblib.delayed(_grown)(*run, trials) for run in runs)
    return tuple(tqdm(results, total=len(runs), unit="spread", disable=not progress))


def _in_turn(
    problem: DesignProblem, options: RadialBasisOptions, n_jobs: int, trials: TrialStore | None
) -> Iterator[Growth]:
    """Growths in the order of the spreads, as many at a time as there are jobs, so that few are in vain."""
    at_once = joblib.effective_n_jobs(n_jobs)
    for start in range(0, len(options.spreads), at_once):
        runs = [(problem, spread, options) for spread in options.spreads[start : start + at_once]]
        yield from grow_all(runs, n_jobs=n_jobs, trials=trials, progress=False)


def _grown(
    problem: DesignProblem, spread: float, options: RadialBasisOptions, trials: TrialStore | None
) -> Growth:
    """Grow a network, or find it."""
    if trials is None:
        with one_thread():
            return grow(problem, spread, options)
    # A growth does not know which other spreads there are.
    own = replace(options, first_spread=1.0, spread_step=1.0, spread_limit=1.0, sweep="first")
    key = store.content_key("radial-basis growth", problem.key, spread, own, _source())
    stored = trials.get(key)
    if stored is not None:
        return _from_record(cast(RadialBasis, stored))
    growth = _grown(problem, spread, options, None)
    trials.put(key, growth.network, _to_record(growth))
    return growth


@cache
def _source() -> str:
    return source_key([growth_module, network_module, problem_module, radial_basis, spatial])


def _to_record(growth: Growth) -> dict[str, Any]:
    # The condition as text, because JSON has no infinity.
    return {
        "spread": growth.spread, "stop": growth.stop.name, "rows": growth.rows,
        "mean_square_errors": growth.mean_square_errors, "testing_errors": growth.testing_errors,
        "largest_weights": growth.largest_weights, "condition": repr(growth.condition),
        "skipped": growth.skipped,
    }  # fmt: skip


def _from_record(network: RadialBasis) -> Growth:
    record, network.card = network.card, {}
    histories = {
        name: tuple(record[name])
        for name in ("rows", "mean_square_errors", "testing_errors", "largest_weights")
    }
    return Growth(
        spread=record["spread"], network=network, stop=Stop[record["stop"]],
        condition=float(record["condition"]), skipped=record["skipped"], **histories,
    )  # fmt: skip
