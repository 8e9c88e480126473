"""Radial-basis networks: one hidden layer of bells about centres, and a linear output.

Eqs. 16–18 of Sotiropoulos & Aspragathos (2016). They are grown by :mod:`dexterity.networks.growth`.

Examples
--------
>>> from dexterity.networks.network import View
>>> from dexterity.networks.radial_basis import RadialBasis
>>> arrays = {"centres": [[0.0], [1.0]], "spread": 0.5, "input_scale": [1.0]}
>>> weights = {"output_weights": [1.0, -1.0], "output_bias": 2.0}
>>> network = RadialBasis(View(1, [0]), arrays | weights)
>>> network.neurons, network([[0.5]]).tolist()
(2, [2.0])
"""

from __future__ import annotations

from collections.abc import Mapping

import torch
from torch import Tensor

from dexterity import checks, spatial
from dexterity.networks.network import Network, View, checked
from dexterity.spatial import TensorLike

__all__ = ["BIAS", "RadialBasis"]

BIAS = 0.833
"""Bias of a hidden neuron times its spread; a neuron answers exp(−0.833²) = 0.4996 at the spread."""


class RadialBasis(Network):
    r"""Gaussian bells of one width about centres, weighted and summed.

    With s the input scale and σ the spread,

    .. math:: f(x) = c + \sum_j v_j \exp(-(0.833\,\lVert s x - c_j \rVert / \sigma)^2).

    Attributes
    ----------
    centres
        (h, r) points in the scaled input space.
    spread
        () distance from a centre at which a neuron answers 0.4996, in the units of scaled inputs.
    output_weights, output_bias
        (h) and (): the linear layer, in the units of the value.
    input_scale
        (r) factors on the inputs before distances are taken: 1 for radians and metres, 180/π for degrees.

    Notes
    -----
    Eq. 18 is printed with a plain sum of the differences between input and centre. The norm that is meant
    is taken here, the Euclidean one, since the text on the spread speaks of distances.

    References
    ----------
    Sotiropoulos & Aspragathos (2016), Eqs. 16–18 and section 3.2.
    """

    centres: Tensor
    spread: Tensor
    output_weights: Tensor
    output_bias: Tensor
    input_scale: Tensor

    def __init__(self, view: View, arrays: Mapping[str, TensorLike]) -> None:
        super().__init__(view)
        checks.Instance(Mapping)(arrays, "arrays")
        neurons = spatial.to_float64(arrays.get("output_weights", ()), "output_weights").numel()
        if not neurons:
            raise ValueError("output_weights needs at least one element")
        shapes: dict[str, tuple[int, ...]] = {
            "centres": (neurons, view.width), "spread": (), "output_weights": (neurons,),
            "output_bias": (), "input_scale": (view.width,),
        }  # fmt: skip
        for name, array in checked(arrays, shapes).items():
            if name in ("spread", "input_scale"):
                if not (array > 0).all():
                    raise ValueError(f"{name} is {array.tolist()}; positive numbers are needed")
                self.register_buffer(name, array)
            else:
                self.register_parameter(name, torch.nn.Parameter(array))

    @property
    def neurons(self) -> int:
        """Number of hidden neurons h."""
        return len(self.output_weights)

    def hidden(self, x: Tensor) -> Tensor:
        """Answers (..., h) of the hidden neurons to what is seen (..., r)."""
        return bells(x * self.input_scale, self.centres, self.spread)

    def answer(self, x: Tensor) -> Tensor:
        """Return values (...) for what is seen (..., r)."""
        return self.hidden(x) @ self.output_weights + self.output_bias


def bells(x: Tensor, centres: Tensor, spread: Tensor | float) -> Tensor:
    """Answers (..., h) of neurons about centres (h, r) to points (..., r), both scaled.

    The square of the distance is multiplied out, which leaves one matrix product. From the middle of the
    centres this loses nothing to rounding as long as points lie within a thousand spreads.
    """
    middle = centres.detach().mean(0)
    width = BIAS / spread
    points, bases = (x - middle) * width, (centres - middle) * width
    return torch.exp(2 * points @ bases.mT - bases.square().sum(-1) - points.square().sum(-1, keepdim=True))
