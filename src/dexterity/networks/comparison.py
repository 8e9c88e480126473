"""What a network is compared with: the exact code, and fits that take no training.

Examples
--------
>>> import dexterity as dx
>>> from dexterity.networks import comparison
>>> from dexterity.sampling import DataSet
>>> q = dx.sampling.sobol(dx.sampling.Box([-1, -1], [1, 1]), 64, 0)
>>> view = dx.networks.View(2, [0, 1])
>>> list(comparison.fits(view, DataSet(q, 2 + q[:, 0])))
['constant', 'linear', 'cubic']
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import torch
from torch import Tensor

from dexterity import checks, operations, symbolic
from dexterity.chain import Chain
from dexterity.codegen.library import CompilationFailed
from dexterity.indices import Index
from dexterity.networks.baselines import Constant, constant, polynomial
from dexterity.networks.export import compile_network
from dexterity.networks.network import Network, View
from dexterity.networks.validation import Function
from dexterity.sampling import DataSet
from dexterity.timing import Machine, Timing, Way, measure, ratio

__all__ = ["Times", "exact_operations", "fits", "times"]


@checks.arguments(
    view=checks.Instance(View), train=checks.Instance(DataSet), scale=checks.OrNone(checks.positive)
)
def fits(view: View, train: DataSet, scale: float | None = None) -> Mapping[str, Function]:
    """Fit a constant, and a linear and a cubic polynomial where there are rows enough for them.

    Parameters
    ----------
    view
        What they see of a configuration, as the network does.
    train
        The network's training set.
    scale
        What errors are divided by; the values if none is given.
    """
    middle = (float(train.values.min()) + float(train.values.max())) / 2
    found: dict[str, Function] = {
        "constant": constant(train) if scale is None else Constant(middle, train.q.shape[1])
    }
    for name, degree in (("linear", 1), ("cubic", 3)):
        if math.comb(view.width + degree, degree) <= len(train.values):
            found[name] = polynomial(view, train, degree)
    return found


@checks.arguments(chain=checks.Instance(Chain), index=checks.Instance(Index))
def exact_operations(chain: Chain, index: Index) -> Mapping[str, int]:
    """Count the operations of the exact index, in an entry that says what is counted; none if not derived."""
    derivation = symbolic.derive(chain, index)
    if derivation.kind == "numeric":
        return {}
    if derivation.kind == "spectral":
        program = derivation.bidiagonal
    else:
        program = derivation.squared_manipulability if index.name == "manipulability" else derivation.value
    return {"exact, before a root or an iteration": operations.count_program(program).total}


@dataclass(frozen=True)
class Times:
    """Times of a configuration, measured in one run.

    Attributes
    ----------
    exact, network
        The exact index and the network, on one core.
    languages
        What the exact index and the network are computed in: C, or torch where there is no compiler or the
        index has no form in C.
    """

    exact: Timing
    network: Timing
    languages: tuple[str, str]

    @property
    def language(self) -> str:
        """What both are computed in, as a text."""
        exact, network = self.languages
        return exact if exact == network else f"{exact} (exact) and {network} (network)"

    @property
    def ratio(self) -> float:
        """How many times as long the exact index takes as the network; 1 where the quartiles overlap."""
        quotient = ratio(self.exact, self.network)
        return quotient.value if quotient.distinguishable else 1.0

    def entry(self) -> dict[str, Any]:
        """Return what a card says of the times."""
        each = {"exact": self.exact, "network": self.network}
        return {
            "ns_per_configuration": {
                name: [round(1e9 * t, 1) for t in (one.lower, one.median, one.upper)]
                for name, one in each.items()
            },
            "exact_over_network": str(ratio(self.exact, self.network)),
            "both": (
                f"{self.language}, {self.exact.configurations} configurations at once, one core; quartiles"
            ),
            "processor": Machine.present().processor,
        }


@checks.arguments(
    exact=checks.function, network=checks.Instance(Network), q=checks.Instance(Tensor), language=checks.name
)
def times(
    exact: Function, network: Network, q: Tensor, language: str, rounds: int = 10, seconds: float = 0.05
) -> Times:
    """Measure the exact index and a network on the same configurations in one run.

    Parameters
    ----------
    exact
        The exact index.
    network
        The network.
    q
        (N, n) configurations, worked on at once.
    language
        What the exact index is computed in, ``"C"`` or ``"torch"``. The network is compiled to C where there
        is a compiler.
    rounds, seconds
        See :func:`dexterity.timing.measurement.measure`.
    """
    compiled: Function = network
    try:
        compiled, own = compile_network(network), "C"
    except CompilationFailed:
        own = "torch"
    ways = [Way("exact", lambda: exact(q), len(q)), Way("network", lambda: compiled(q), len(q))]
    with torch.no_grad():
        exact_time, network_time = measure(ways, rounds=rounds, seconds=seconds)
    return Times(exact_time, network_time, (language, own))
