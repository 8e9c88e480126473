"""Training of a feed-forward network for each of several seeds, all in one call.

Networks of one size share every matrix product, see :mod:`dexterity.networks.levenberg_marquardt`. A call
with one seed gives the bits that a training by itself gives; several seeds differ from that by rounding.

Examples
--------
>>> import torch
>>> from dexterity.networks import levenberg_marquardt, network, train
>>> q, view = torch.linspace(-1, 1, 50).double()[:, None], network.View(1, [0])
>>> options = levenberg_marquardt.Options(goal=1e-6)
>>> trainings = train.for_seeds(view, 4, q, q.sin()[:, 0], [0, 1, 2], options)
>>> [training.success for training in trainings]
[True, True, True]
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import torch

from dexterity import checks, spatial
from dexterity.networks.feed_forward import FeedForward, Readout
from dexterity.networks.levenberg_marquardt import Options, Training, levenberg_marquardt
from dexterity.networks.network import View, device_name
from dexterity.spatial import TensorLike

__all__ = ["for_seeds", "initial_networks"]


@checks.arguments(
    device=device_name,
    view=checks.Instance(View),
    neurons=checks.Whole(1),
    seeds=checks.Each(checks.seed),
    options=checks.OrNone(checks.Instance(Options)),
)
def for_seeds(
    view: View,
    neurons: int,
    q: TensorLike,
    values: TensorLike,
    seeds: Sequence[int],
    options: Options | None = None,
    *,
    readout: Readout = "identity",
    device: str = "cpu",
) -> list[Training]:
    """Train a network for each seed of initial weights.

    Parameters
    ----------
    view
        Inputs of the networks.
    neurons
        Hidden neurons of each network.
    q
        (N, n) joint values of the training set, or (B, N, n) with rows of its own for each of B seeds.
    values
        (N) values, or (N, k) for k outputs; with a leading axis B as `q`.
    seeds
        Seeds of the initial weights, one for each network.
    options
        When to stop, and how to damp; those of the trainer by default.
    readout
        How the value is read from the output layer.
    device
        Where to train, such as ``"cuda"``; the networks come back to the processor.

    Returns
    -------
    The trainings in the order of the seeds; `Training.network` is the network.

    Raises
    ------
    ValueError
        See :func:`initial_networks` and :func:`dexterity.networks.levenberg_marquardt.levenberg_marquardt`.
    """
    networks = initial_networks(view, neurons, q, values, seeds, readout)
    networks = [network.to(device) for network in networks]
    trainings = levenberg_marquardt(networks, q, values, options or Options())
    return [replace(training, network=training.network.cpu()) for training in trainings]


@checks.arguments(view=checks.Instance(View), neurons=checks.Whole(1), seeds=checks.Each(checks.seed))
def initial_networks(
    view: View,
    neurons: int,
    q: TensorLike,
    values: TensorLike,
    seeds: Sequence[int],
    readout: Readout = "identity",
) -> list[FeedForward]:
    """Return an untrained network for each seed, scaled to its training set.

    The parameters are those of :func:`for_seeds`.

    Raises
    ------
    ValueError
        If there are no seeds, or not one training set for each seed; or see
        :meth:`dexterity.networks.feed_forward.FeedForward.untrained`.
    """
    if not seeds:
        raise ValueError("seeds is empty; at least one is needed")
    q, values = spatial.to_float64(q, "q"), spatial.to_float64(values, "values")
    if q.ndim == 2:
        sets = [(q, values)] * len(seeds)
    elif q.ndim == 3 and values.ndim and len(q) == len(values) == len(seeds):
        sets = list(zip(q, values, strict=True))
    else:
        raise ValueError(
            f"q has shape {tuple(q.shape)} and values {tuple(values.shape)}; "
            f"training sets (N, n) and (N) are needed, one for all or one for each of {len(seeds)} seeds"
        )
    return [
        FeedForward.untrained(view, neurons, x, y, torch.Generator().manual_seed(seed), readout)
        for seed, (x, y) in zip(seeds, sets, strict=True)
    ]
