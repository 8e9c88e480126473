"""Cards of networks: errors on fresh points, the worst case that a search finds, data and size.

A card is what :func:`dexterity.networks.save` keeps beside the weights, so that whoever loads a network
later knows what it approximates, where, and how well.

Examples
--------
>>> import dexterity as dx
>>> from dexterity.networks.card import describe
>>> from dexterity.networks.worst_case import Search
>>> network = dx.networks.load_shipped("uvms-manipulability-feed-forward")
>>> w = dx.indices.Index("manipulability").bind(dx.robots.uvms())
>>> space, few = dx.sampling.uvms_space("manipulability"), Search(256, 16, 8, steps=5)
>>> describe(network, w, space, seed=5, count=1000, search=few)["neurons"]
8
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any

from dexterity import operations
from dexterity.networks.feed_forward import FeedForward
from dexterity.networks.network import Network
from dexterity.networks.threads import one_thread
from dexterity.networks.validation import Function, fresh, judge
from dexterity.networks.worst_case import Search, worst_case
from dexterity.operations import Operations
from dexterity.sampling import Space

__all__ = ["describe", "layer_operations", "plain"]


def describe(
    network: Network,
    exact: Function,
    space: Space,
    about: Mapping[str, Any] | None = None,
    *,
    seed: int,
    count: int = 200_000,
    search: Search | None = None,
) -> dict[str, Any]:
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
        ``licence``; :func:`plain` writes dataclasses for them.
    seed
        Seed of the fresh points and of the search. It should be none by which the network was chosen.
    count
        Number of fresh points.
    search
        Effort of the search for the worst case; that of its defaults if none is given.

    Returns
    -------
    The entries of `about`, and ``kind``, ``inputs``, ``neurons``, ``space``, ``errors``, ``worst_case`` and
    ``operations``, in what JSON can say. Errors are relative.

    Raises
    ------
    ValueError
        See :func:`dexterity.networks.validation.error_distribution` and
        :func:`dexterity.networks.worst_case.worst_case`.
    """
    with one_thread():
        errors = judge(network, fresh(exact, space, count, seed))
        worst = worst_case(network, exact, space, search or Search(), seed)
    return {
        **(about or {}),
        "kind": type(network).__name__,
        "inputs": _inputs(network),
        "neurons": network.neurons,
        "space": {"kind": type(space).__name__, **plain(space)},
        "errors": {**plain(errors), "seed": seed, "points": "fresh, Sobol"},
        "worst_case": {
            "error": worst.error,
            "q": list(worst.q),
            "value": worst.value,
            "exact": worst.exact,
            "evaluations": worst.evaluations,
            "seed": seed,
            "found_by": "multi-start ascent, no bound",
        },
        "operations": {"layers": layer_operations(network).total},
    }


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


def plain(value: Any) -> dict[str, Any]:
    """Return the fields of a dataclass in what JSON can say: tuples become lists, at any depth."""
    return {name: _listed(item) for name, item in dataclasses.asdict(value).items()}


def _listed(item: Any) -> Any:
    if isinstance(item, Mapping):
        return {key: _listed(value) for key, value in item.items()}
    return [_listed(value) for value in item] if isinstance(item, list | tuple) else item


def _inputs(network: Network) -> str:
    joints = ", ".join(f"θ{joint + 1}" for joint in network.inputs)
    carriers = len(network.view.carriers)
    return f"world's origin in the link that joints 1 to {carriers} carry; {joints}" if carriers else joints
