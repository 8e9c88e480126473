"""The networks of the thesis's four methods, trained by the package's Levenberg–Marquardt.

Sections 4.1 to 4.4 of Rouvinen (1999): one hidden layer of hyperbolic tangents, a linear output layer, inputs
and outputs scaled.

Examples
--------
>>> import torch
>>> import dexterity as dx
>>> data, random = dx.crane.training_set(), torch.Generator().manual_seed(0)
>>> network = dx.crane.positioning.correction_network(data, random, neurons=2, epochs=5)
>>> network([[0.25, 0.5, 1.0, 200.0]]).shape
torch.Size([1, 2])
"""

from __future__ import annotations

import torch
from torch import Tensor

from dexterity import checks
from dexterity.crane.data import TrainingSet
from dexterity.networks.feed_forward import FeedForward
from dexterity.networks.levenberg_marquardt import Options, levenberg_marquardt
from dexterity.networks.network import View

__all__ = ["EPOCHS", "correction_network", "direct_network", "inverse_network", "modular_network"]

EPOCHS = 200
"""Epochs of a training, which the thesis does not tell."""


def correction_network(
    data: TrainingSet, generator: torch.Generator, neurons: int = 14, epochs: int = EPOCHS
) -> FeedForward:
    """Train the deflection [m] as a function of s1, s2, s3 [m] and payload [kg] (method 1).

    Parameters
    ----------
    data
        What to learn from.
    generator
        Where the initial weights come from.
    neurons
        Hidden neurons.
    epochs
        Steps of the training.

    Raises
    ------
    ValueError
        If there are no neurons, epochs or rows.

    References
    ----------
    Rouvinen (1999), section 4.1.
    """
    return _trained(_SEES_ALL, _rows(data)[:, :4], data.deflection, neurons, epochs, generator)


def direct_network(
    data: TrainingSet, generator: torch.Generator, neurons: int = 18, epochs: int = EPOCHS
) -> FeedForward:
    """Train the flexible tip [m] as a function of s1, s2, s3 [m] and payload [kg] (method 2).

    Parameters and errors are those of :func:`correction_network`.

    References
    ----------
    Rouvinen (1999), section 4.2; with two outputs, where it says three.
    """
    return _trained(_SEES_ALL, _rows(data)[:, :4], data.tip, neurons, epochs, generator)


def modular_network(
    data: TrainingSet, generator: torch.Generator, neurons: tuple[int, int] = (15, 15), epochs: int = EPOCHS
) -> FeedForward:
    """Train the rigid tip, then what the flexible one differs from that network, and add both (method 3).

    Parameters and errors are those of :func:`correction_network`, with the neurons of both networks.

    Returns
    -------
    One network of s1, s2, s3 [m] and payload [kg] that is the sum of both, after Eq. 64.

    References
    ----------
    Rouvinen (1999), section 4.3, Eqs. 64 and 65.
    """
    inputs = _rows(data)[:, :4]
    if not isinstance(neurons, tuple) or len(neurons) != 2:
        raise ValueError(f"neurons is {checks.shown(neurons)}; those of two networks are needed")
    rigid = _trained(_SEES_STROKES, inputs, data.tip - data.deflection, neurons[0], epochs, generator)
    with torch.no_grad():
        rest = data.tip - rigid(inputs)
    return _sum(rigid, _trained(_SEES_ALL, inputs, rest, neurons[1], epochs, generator))


def inverse_network(
    data: TrainingSet, generator: torch.Generator, neurons: int = 19, epochs: int = EPOCHS
) -> FeedForward:
    """Train s1 and s2 [m] as a function of x, y [m], payload [kg] and s3 [m] (method 4).

    Parameters and errors are those of :func:`correction_network`.

    References
    ----------
    Rouvinen (1999), section 4.4.
    """
    _rows(data)
    inputs = torch.cat([data.tip, data.payload[:, None], data.strokes[:, 2:]], dim=-1)
    return _trained(_SEES_ALL, inputs, data.strokes[:, :2], neurons, epochs, generator)


_SEES_ALL = View(4, (0, 1, 2, 3))
_SEES_STROKES = View(4, (0, 1, 2))


def _rows(data: TrainingSet) -> Tensor:
    return checks.instance(data, "data", TrainingSet).rows


def _trained(
    view: View, x: Tensor, y: Tensor, neurons: int, epochs: int, generator: torch.Generator
) -> FeedForward:
    checks.instance(generator, "generator", torch.Generator)
    neurons, epochs = checks.whole(neurons, "neurons", least=1), checks.whole(epochs, "epochs", least=1)
    start = FeedForward.untrained(view, neurons, x, y, generator)
    return levenberg_marquardt(start, x, y, Options(epochs=epochs)).network


def _sum(rigid: FeedForward, rest: FeedForward) -> FeedForward:
    """Put the hidden layers of both side by side; the first sees no payload."""
    ratio = rest.target_half_range / rigid.target_half_range
    blind = torch.nn.functional.pad(rigid.hidden_weights, (0, 1))
    return FeedForward(rest.view, "identity", {
        "hidden_weights": torch.cat([blind, rest.hidden_weights]),
        "hidden_biases": torch.cat([rigid.hidden_biases, rest.hidden_biases]),
        "output_weights": torch.cat([rigid.output_weights, ratio * rest.output_weights], dim=1),
        "output_biases": rigid.output_biases + ratio * rest.output_biases,
        "input_centre": rest.input_centre, "input_half_range": rest.input_half_range,
        "target_centre": rigid.target_centre + rest.target_centre,
        "target_half_range": rigid.target_half_range,
    })  # fmt: skip
