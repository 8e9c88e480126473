"""How far an approximation of an index is off, on points that it was not chosen by.

The largest error on the test set at which a design loop stopped says little about other points, since the
loop goes on until a network happens to pass. What is told here is the whole distribution of the error on
fresh points, and how much the stopping rule flatters.

Examples
--------
>>> import dexterity as dx
>>> from dexterity.networks import validation
>>> network = dx.networks.load_shipped("uvms-manipulability-feed-forward")
>>> w = dx.indices.Index("manipulability").bind(dx.robots.uvms())
>>> errors = validation.error_distribution(
...     network, w, dx.sampling.uvms_space("manipulability"), count=1000
... )
>>> errors.count, errors.maximum < 0.002
(1000, True)
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Literal, TypeAlias

import numpy as np
import torch
from jaxtyping import Float64
from numpy.typing import NDArray
from torch import Tensor

from dexterity import checks, sampling, spatial
from dexterity.sampling import DataSet, Space

__all__ = [
    "AcceptanceBias",
    "ErrorDistribution",
    "Function",
    "acceptance_bias",
    "error_distribution",
    "fresh",
    "judge",
    "passing_probability",
    "relative_errors",
]

Function: TypeAlias = Callable[[Tensor], Tensor]
"""An index or what stands in for it, from joint values (..., n) to values (...)."""


@dataclass(frozen=True)
class ErrorDistribution:
    """Errors over a set of configurations, relative as in Eq. 21 of paper A unless a scale was given.

    Attributes
    ----------
    count
        Number of configurations.
    mean, root_mean_square, median
        Of the absolute error.
    percentile_90, percentile_99, percentile_99_9
        What that share of the configurations does not exceed.
    maximum
        Largest of them; no bound for others, see :func:`dexterity.networks.worst_case.worst_case`.
    worst
        (n,) where it is, [rad] or [m].
    """

    count: int
    mean: float
    root_mean_square: float
    median: float
    percentile_90: float
    percentile_99: float
    percentile_99_9: float
    maximum: float
    worst: tuple[float, ...]


@checks.arguments(f=checks.function, index=checks.function)
def error_distribution(
    f: Function,
    index: Function,
    space: Space,
    count: int = 100_000,
    seed: int = 0,
    method: Literal["sobol", "uniform"] = "sobol",
) -> ErrorDistribution:
    """Compare an approximation with an index on fresh points of a space.

    Parameters
    ----------
    f, index
        The approximation, and what it should be.
    space
        Where to draw.
    count, seed, method
        See :func:`fresh`.

    Raises
    ------
    ValueError
        If `count` is not positive, the method is unknown, the index is zero somewhere, or what either
        function returns is not finite or not one value for each configuration.
    """
    return judge(f, fresh(index, space, count, seed, method))


@checks.arguments(index=checks.function)
def fresh(
    index: Function,
    space: Space,
    count: int = 100_000,
    seed: int = 0,
    method: Literal["sobol", "uniform"] = "sobol",
) -> DataSet:
    """Draw configurations between the points of any grid, with the values of an index.

    Raises
    ------
    ValueError
        If `count` is not positive, the method is unknown, or what `index` returns is not finite or not one
        value for each configuration.
    """
    if checks.choice(method, "method", ("sobol", "uniform")) == "sobol":
        q = sampling.sobol(space, count, seed)
    else:
        q = sampling.uniform(space, count, torch.Generator().manual_seed(checks.whole(seed, "seed", least=0)))
    return DataSet(q, _evaluated(index, q, "index"))


@checks.arguments(f=checks.function, data=checks.Instance(DataSet), scale=checks.OrNone(checks.positive))
def judge(f: Function, data: DataSet, scale: float | None = None) -> ErrorDistribution:
    """Compare an approximation with known values.

    Parameters
    ----------
    f
        The approximation.
    data
        Configurations with the values of the index.
    scale
        What errors are divided by; the values themselves if none is given.

    Raises
    ------
    ValueError
        See :func:`~dexterity.networks.validation.relative_errors`.
    """
    errors = relative_errors(f, data, scale).abs()
    sizes = errors.numpy(force=True)
    median, most, nearly_all, all_but_one = np.quantile(sizes, (0.5, 0.9, 0.99, 0.999)).tolist()
    return ErrorDistribution(
        count=len(sizes),
        mean=float(sizes.mean()),
        root_mean_square=float(np.sqrt(np.square(sizes).mean())),
        median=median,
        percentile_90=most,
        percentile_99=nearly_all,
        percentile_99_9=all_but_one,
        maximum=float(sizes.max()),
        worst=tuple(data.q[errors.argmax()].tolist()),
    )


@checks.arguments(f=checks.function, data=checks.Instance(DataSet), scale=checks.OrNone(checks.positive))
def relative_errors(f: Function, data: DataSet, scale: float | None = None) -> Float64[Tensor, " N"]:
    """Return f(q) / value − 1 of each configuration, with its sign; with a scale, (f(q) − value) / scale.

    Parameters
    ----------
    f, data
        See :func:`judge`.
    scale
        A positive number in the unit of the values, for an index that is zero or changes its sign in the
        space.

    Raises
    ------
    ValueError
        If there are no rows, a value is zero and there is no scale, the scale is not positive, or what `f`
        returns is not finite or not one value for each configuration.
    """
    if not len(data.q):
        raise ValueError("data has no rows")
    if scale is not None:
        return (_evaluated(f, data.q, "f") - data.values) / checks.positive(scale, "scale")
    if (data.values == 0).any():
        raise ValueError("data holds a value of zero, of which there is no relative error")
    return _evaluated(f, data.q, "f") / data.values - 1


# ---- the selection effect --------------------------------------------------------------------------


@dataclass(frozen=True)
class AcceptanceBias:
    """What "accept if no test point is off by more than E" lets through.

    Attributes
    ----------
    limit
        The largest error E that is accepted.
    test_points, fresh_points
        How many each network was judged on.
    testing, fresh
        (k,) largest relative error of each network on the test set and on fresh points.
    shares
        (k,) share of the fresh points at which each network is off by more than E.
    """

    limit: float
    test_points: int
    fresh_points: int
    testing: NDArray[np.float64]
    fresh: NDArray[np.float64]
    shares: NDArray[np.float64]

    @cached_property
    def accepted(self) -> NDArray[np.bool_]:
        """Which networks the rule lets through (k,)."""
        return self.testing <= self.limit

    @property
    def broken_share(self) -> float:
        """Share of the accepted networks that break E on fresh points; NaN if none is accepted."""
        kept = self.fresh[self.accepted]
        return float((kept > self.limit).mean()) if len(kept) else float("nan")

    @property
    def expected_share(self) -> float:
        """Share of all networks that a new test set of that size would accept on average.

        A network that is off by more than E at a share p of all points passes t independent ones with
        probability (1 − p)^t.
        """
        return float(np.mean([passing_probability(share, self.test_points) for share in self.shares]))


@checks.arguments(
    networks=checks.Each(checks.function), test=checks.Instance(DataSet), fresh=checks.Instance(DataSet)
)
def acceptance_bias(
    networks: Sequence[Function], test: DataSet, fresh: DataSet, limit: float
) -> AcceptanceBias:
    """Judge networks by a test set, as a design loop does, and by fresh points.

    Parameters
    ----------
    networks
        Candidates of a loop.
    test
        What the loop looks at.
    fresh
        What it does not; best many more points.
    limit
        Largest relative error E that the loop accepts.

    Raises
    ------
    ValueError
        If there is no network, the limit is not positive, or something does not fit, see :func:`judge`.
    """
    if not networks:
        raise ValueError("networks is empty; at least one is needed")
    limit = checks.positive(limit, "limit")
    testing = [float(relative_errors(network, test).abs().max()) for network in networks]
    errors = [relative_errors(network, fresh).abs() for network in networks]
    return AcceptanceBias(
        limit=limit,
        test_points=len(test.q),
        fresh_points=len(fresh.q),
        testing=np.array(testing),
        fresh=np.array([float(error.max()) for error in errors]),
        shares=np.array([float((error > limit).double().mean()) for error in errors]),
    )


def passing_probability(share: float, points: int = 1000) -> float:
    """Return the probability that none of so many independent points falls into a share of the space.

    Raises
    ------
    ValueError
        If the share is not within 0 and 1, or there are no points.
    """
    share = checks.real(share, "share", least=0, most=1)
    return float((1 - share) ** checks.whole(points, "points", least=1))


# ---- private ---------------------------------------------------------------------------------------

_PIECE = 1 << 14  # rows at a time, which bounds the memory that the hidden layer takes


def _evaluated(f: Function, q: Tensor, name: str) -> Tensor:
    """Values (N) of a function at configurations (N, n)."""
    with torch.no_grad():
        pieces = [spatial.to_float64(f(rows), f"{name}(q)") for rows in q.split(_PIECE)]
    for rows, values in zip(q.split(_PIECE), pieces, strict=True):
        if values.shape != rows.shape[:1]:
            raise ValueError(
                f"{name}(q) has shape {tuple(values.shape)}; one value a configuration, ({len(rows)},), "
                "is needed"
            )
    return torch.cat(pieces)
