"""The judgement of a network: errors on fresh points, the worst case that a search finds, rounding and size.

Examples
--------
>>> import dexterity as dx
>>> from dexterity.networks.judgement import describe
>>> from dexterity.networks.worst_case import Search
>>> network = dx.networks.load_shipped("uvms-manipulability-feed-forward")
>>> w = dx.indices.Index("manipulability").bind(dx.robots.uvms())
>>> space, few = dx.sampling.uvms_space("manipulability"), Search(256, 16, 8, steps=5)
>>> describe(network, w, space, seed=5, count=1000, search=few)["neurons"]
8
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import torch
from torch import Tensor

from dexterity import checks, operations
from dexterity.networks import spaces
from dexterity.networks.card import Card, plain
from dexterity.networks.feed_forward import FeedForward
from dexterity.networks.network import Network
from dexterity.networks.rounding import rounding
from dexterity.networks.threads import one_thread
from dexterity.networks.validation import Function, fresh, judge, relative_errors
from dexterity.networks.worst_case import Search, WorstCase, worst_case
from dexterity.operations import Operations
from dexterity.sampling import Box, DataSet, Space

__all__ = ["describe", "layer_operations"]

BINS = 40
"""Bins of the histogram of errors."""

POINTS = 25
"""Points of a line through the worst configuration."""

LINES = 9
"""Lines through the worst configuration at most."""


@checks.arguments(
    exact=checks.function,
    about=checks.OrNone(checks.Instance(Mapping)),
    search=checks.OrNone(checks.Instance(Search)),
    scale=checks.OrNone(checks.positive),
    baselines=checks.OrNone(checks.Named(checks.function)),
)
def describe(
    network: Network,
    exact: Function,
    space: Space,
    about: Mapping[str, Any] | None = None,
    *,
    seed: int,
    count: int = 200_000,
    search: Search | None = None,
    scale: float | None = None,
    baselines: Mapping[str, Function] | None = None,
) -> Card:
    """Judge a network on points that nothing was chosen by, and return its card.

    Parameters
    ----------
    network
        A feed-forward or radial-basis network.
    exact
        Index that the network approximates; torch must be able to differentiate it once.
    space
        Where the network is to be used. Nothing outside of it is judged.
    about
        Further entries that cannot be measured, such as ``name``, ``chain``, ``index``, ``training`` and
        ``licence``; :mod:`dexterity.networks.card` writes them.
    seed
        Seed of the fresh points and of the search. It should be none by which the network was chosen.
    count
        Number of fresh points.
    search
        Effort of the search for the worst case; that of its defaults if none is given.
    scale
        What errors are divided by; the values of the index if none is given.
    baselines
        What the network is compared with, by name, on the same points; see
        :mod:`dexterity.networks.baselines`.

    Returns
    -------
    The entries of `about`, and ``kind``, ``inputs``, ``neurons``, ``space``, ``errors``, ``worst_case``,
    ``operations``, ``rounding``, ``baselines``, ``histogram`` and ``slices``. Errors are relative to the
    index, or to the scale.

    Raises
    ------
    ValueError
        See :func:`dexterity.networks.validation.error_distribution` and
        :func:`dexterity.networks.worst_case.worst_case`.
    """
    checks.Instance(Network)(network, "network")
    seed = checks.whole(seed, "seed", least=0)
    with one_thread():
        points = fresh(exact, space, count, seed)
        errors = judge(network, points, scale)
        worst = worst_case(network, exact, space, search or Search(), seed, scale)
        if errors.maximum > worst.error:  # kinks may hold up every climb
            worst = _at(network, exact, errors.worst, errors.maximum, worst)
        entries = {
            **(about or {}),
            "kind": type(network).__name__,
            "inputs": _inputs(network),
            "neurons": network.neurons,
            "space": spaces.to_card(space),
            "errors": {**plain(errors), "seed": seed, "points": "fresh, Sobol"},
            "worst_case": _worst(worst, seed),
            "operations": {"layers": layer_operations(network).total},
            "rounding": plain(rounding(network, points.q[:ROUNDED])),
            "baselines": {
                name: {"maximum": judge(f, points, scale).maximum} for name, f in (baselines or {}).items()
            },
            "histogram": _histogram(relative_errors(network, points, scale)),
            "slices": _slices(network, exact, space, worst, _names(about, space)),
        }
    if scale is not None:
        entries["errors"]["relative_to"] = scale
    return Card(entries)


ROUNDED = 4096
"""Points at which the rounding of the answers is looked at."""


@checks.arguments(network=checks.Instance(Network))
def layer_operations(network: Network) -> Operations:
    """Count the operations of a network's layers by the rules of paper A, without its view and its readout.

    References
    ----------
    Sotiropoulos & Aspragathos (2016), Table 4.
    """
    width, h = network.view.width, network.neurons
    if not isinstance(network, FeedForward):
        return operations.radial_basis(width, h)
    further_outputs = len(network.output_biases) - 1
    return operations.feed_forward(width, h) + further_outputs * Operations(h, h)


def _inputs(network: Network) -> str:
    joints = ", ".join(f"θ{joint + 1}" for joint in network.inputs)
    carriers = len(network.view.carriers)
    return f"world's origin in the link that joints 1 to {carriers} carry; {joints}" if carriers else joints


def _at(network: Network, exact: Function, q: tuple[float, ...], error: float, found: WorstCase) -> WorstCase:
    """Take a fresh point for the worst case."""
    place = torch.tensor(q, dtype=torch.float64)
    with torch.no_grad():
        return replace(found, error=error, q=q, value=float(network(place)), exact=float(exact(place)))


def _worst(worst: WorstCase, seed: int) -> dict[str, Any]:
    return {
        "error": worst.error,
        "q": list(worst.q),
        "value": worst.value,
        "exact": worst.exact,
        "evaluations": worst.evaluations,
        "seed": seed,
        "found_by": "multi-start ascent, no bound",
    }


# ---- what a page draws -------------------------------------------------------------------------------


def _histogram(errors: Tensor) -> dict[str, list[float]]:
    sizes = errors.abs().numpy()
    largest = max(float(sizes.max()), 1e-16)
    edges = np.geomspace(1e-4 * largest, largest, BINS + 1)
    # Smaller errors stand in the first bin; the largest must not fall behind the last for rounding.
    counts, _ = np.histogram(sizes.clip(edges[0], edges[-1]), edges)
    return {"edges": _digits(edges), "counts": counts.tolist()}


def _slices(
    network: Network, exact: Function, space: Space, worst: WorstCase, names: Sequence[str]
) -> list[dict[str, Any]]:
    """Lines through the worst configuration, along one coordinate of the space after the other."""
    place = space.to_unit(torch.tensor(worst.q, dtype=torch.float64)).clamp(0, 1)
    lines = []
    for k in range(min(space.dimensions, LINES)):
        u = place.repeat(POINTS, 1)
        u[:, k] = torch.linspace(0, 1, POINTS, dtype=torch.float64)
        q = space.from_unit(u)
        data, answers = DataSet.of(exact, q, "exact"), DataSet.of(network, q, "network")
        low, high = _range(space, k)
        lines.append({
            "joint": names[k],
            "from": low,
            "to": high,
            "worst": low + (high - low) * float(place[k]),
            "exact": _digits(data.values),
            "network": _digits(answers.values),
        })  # fmt: skip
    return lines


def _range(space: Space, k: int) -> tuple[float, float]:
    if not isinstance(space, Box):
        return 0.0, 1.0
    joint = space.free_joints[k]
    return space.lower[joint], space.upper[joint]


def _names(about: Mapping[str, Any] | None, space: Space) -> list[str]:
    if not isinstance(space, Box):
        return [f"coordinate {k + 1}, as a share of its range" for k in range(space.dimensions)]
    chain = (about or {}).get("chain")
    names = chain.get("joint_names") if isinstance(chain, Mapping) else None
    return [str(names[joint]) if names else f"joint {joint + 1}" for joint in space.free_joints]


def _digits(numbers: Any) -> list[float]:
    """Numbers as a picture needs them, with five digits."""
    return [float(f"{number:.5g}") for number in numbers.tolist()]
