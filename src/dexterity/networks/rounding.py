r"""How much of a network's answer is rounding: huge weights that cancel leave nothing else.

Rounding errors of double precision are some :math:`10^{-16}` of what is added up, so that a result that is a
million times smaller than its summands loses six digits. Two looks are taken: sums of absolute values are
compared with the answers, and the network is evaluated in single precision too.

Examples
--------
>>> import dexterity as dx
>>> from dexterity.networks import rounding
>>> network = dx.networks.load_shipped("uvms-manipulability-feed-forward")
>>> q = dx.sampling.sobol(dx.sampling.uvms_space("manipulability"), 256, 0)
>>> found = rounding.rounding(network, q)
>>> found.double < 1e-13, found.single < 1e-4
(True, True)
"""

from __future__ import annotations

import copy
from dataclasses import dataclass

import torch
from torch import Tensor

from dexterity import checks
from dexterity.networks.feed_forward import FeedForward
from dexterity.networks.network import Network
from dexterity.networks.radial_basis import BIAS, RadialBasis
from dexterity.spatial import TensorLike

__all__ = ["Rounding", "is_sound", "rounding"]

EPSILON = torch.finfo(torch.float64).eps


@dataclass(frozen=True)
class Rounding:
    """Rounding errors of a network's answers, relative to the answers.

    Attributes
    ----------
    amplification
        Largest ratio of what is added up to the answer: by so much rounding is amplified.
    double
        Estimate for double precision: the amplification times the distance of two numbers.
    single
        Largest difference between answers in single and in double precision.
    """

    amplification: float
    double: float
    single: float


SHARE = 1e-3
"""Largest share of an error that may be rounding in double precision."""


@checks.arguments(network=checks.Instance(Network), error=checks.Real(least=0))
def is_sound(network: Network, q: TensorLike, error: float) -> bool:
    """Tell whether rounding in double precision is a small share of an error that a network may have.

    Parameters
    ----------
    network, q
        See :func:`rounding`.
    error
        Error that the network may have, relative to its answers.
    """
    return rounding(network, q).double <= SHARE * error


@torch.no_grad()
@checks.arguments(network=checks.Instance(Network))
def rounding(network: Network, q: TensorLike) -> Rounding:
    """Estimate the rounding errors of a network at configurations.

    Parameters
    ----------
    network
        A feed-forward or radial-basis network.
    q
        (N, n) joint values, [rad] or [m].

    Raises
    ------
    TypeError
        If the network is of another kind.
    ValueError
        If `q` does not fit the network or has no rows.
    """
    x = network.view(q)
    if x.ndim != 2 or not len(x):
        raise ValueError(f"q has shape {tuple(x.shape[:-1])} before its joints; rows (N, n) are needed")
    values = network.answer(x)
    if isinstance(network, FeedForward):
        sizes = _feed_forward(network, x)
    elif isinstance(network, RadialBasis):
        sizes = _radial_basis(network, x) / values.abs()
    else:
        raise TypeError(f"network is a {type(network).__name__}; FeedForward or RadialBasis is needed")
    # A sum that is zero to the last digit has no relative error that is finite.
    amplification = float(sizes.nan_to_num(nan=torch.inf, posinf=torch.inf).max())
    single = copy.deepcopy(network).float().answer(x.float()).double()
    difference = ((single - values) / values).abs().nan_to_num(nan=torch.inf, posinf=torch.inf)
    return Rounding(amplification, amplification * EPSILON, float(difference.max()))


def _feed_forward(network: FeedForward, x: Tensor) -> Tensor:
    """Amplification (N): sums of absolute values, carried through the layers."""
    own = dict(network.state_dict())
    scaled = (x - own["input_centre"]) / own["input_half_range"]
    rounded = (x.abs() + own["input_centre"].abs()) / own["input_half_range"]
    hidden = torch.tanh(scaled @ own["hidden_weights"].mT + own["hidden_biases"])
    entering = rounded @ own["hidden_weights"].abs().mT + own["hidden_biases"].abs()
    leaving = (1 - hidden.square()) * entering + hidden.abs()
    outputs = leaving @ own["output_weights"].abs().mT + own["output_biases"].abs()
    # An eigenvalue moves by no more than the Frobenius norm of what its matrix moves by.
    targets = torch.linalg.vector_norm(outputs, dim=-1) * own["target_half_range"]
    targets = targets + own["target_centre"].abs().max()
    if network.readout in ("identity", "reciprocal"):
        values = network.answer(x)
        values = values if values.ndim == 1 else torch.linalg.vector_norm(values, dim=-1)
        return targets / (values.abs() if network.readout == "identity" else 1 / values.abs())
    return 1 + targets


def _radial_basis(network: RadialBasis, x: Tensor) -> Tensor:
    """Sum of absolute values (N), with what rounding of the exponents adds."""
    own = dict(network.state_dict())
    points, centres = x * own["input_scale"], own["centres"]
    middle, width = centres.mean(0), BIAS / own["spread"]
    points, bases = (points - middle) * width, (centres - middle) * width
    exponents = (
        2 * points.abs() @ bases.abs().mT + bases.square().sum(-1) + points.square().sum(-1, keepdim=True)
    )
    bells = network.hidden(x) * (1 + exponents)
    return bells @ own["output_weights"].abs() + own["output_bias"].abs()
