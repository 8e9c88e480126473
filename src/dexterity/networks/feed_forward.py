"""Feed-forward networks with one hidden layer of sigmoids.

Eqs. 13–16 of Sotiropoulos & Aspragathos (2016), with the scaling of inputs and outputs inside, and three more
ways to read the output: two that keep errors relative, and one with the shape of an index that depends on
two singular values which meet.

Examples
--------
>>> import torch
>>> from dexterity.networks.feed_forward import FeedForward
>>> from dexterity.networks.network import View
>>> q, random = (
...     torch.linspace(-1, 1, 50).double()[:, None],
...     torch.Generator().manual_seed(0),
... )
>>> network = FeedForward.untrained(View(1, [0]), 5, q, q.sin()[:, 0], random)
>>> network.neurons, network(q).shape
(5, torch.Size([50]))
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Literal, TypeAlias

import torch
from jaxtyping import Float64
from torch import Tensor

from dexterity import checks, spatial
from dexterity.networks.network import Network, View, checked
from dexterity.spatial import TensorLike
from dexterity.spatial.values import require_values

__all__ = ["FeedForward", "Readout"]

Readout: TypeAlias = Literal["identity", "reciprocal", "logarithm", "cone", "triple"]
"""How a value is read from the output layer, see `FeedForward`."""


class FeedForward(Network):
    r"""One hidden layer of hyperbolic tangents and a linear output layer.

    With the inputs scaled to [−1, 1], :math:`u = W_2 \tanh(W_1 x + b_1) + b_2`. What is trained on, the
    target t, is u times a half range plus a centre, and the value is

    - ``"identity"``: t itself, as in the paper;
    - ``"reciprocal"``: 1/t;
    - ``"logarithm"``: exp t, whose absolute error is the relative one of the value;
    - ``"cone"``: exp t too, with t from three linear outputs, :math:`u_1 - \sqrt{u_2^2 + u_3^2}`, the smaller
      eigenvalue of a symmetric 2×2 matrix;
    - ``"triple"``: the same of a symmetric 3×3 matrix with the diagonal :math:`u_1, u_2, u_3` and
      :math:`u_4, u_5, u_6` at (1, 2), (1, 3) and (2, 3).

    Where the smallest of two or three singular values meet, an index that depends on it has the tip of a
    cone, which no single smooth output can follow. As an eigenvalue of a matrix that is smooth itself it can.

    Attributes
    ----------
    hidden_weights, hidden_biases
        (h, r) and (h): :math:`W_1` and :math:`b_1`.
    output_weights, output_biases
        (m, h) and (m): :math:`W_2` and :math:`b_2`; m is the number of values, 3 for a cone, 6 for a triple.
    input_centre, input_half_range
        (r) each, in the units of the joints [rad] or [m]: what is scaled to 0 and to 1.
    target_centre, target_half_range
        (k) and (): the same for the targets, with one half range for all.
    readout
        One of the above.

    References
    ----------
    Sotiropoulos & Aspragathos (2016), Eqs. 13–16. Nguyen & Widrow (1990) for the initial weights. Köppel,
    Domcke & Cederbaum (1984) for surfaces that meet in a cone, as eigenvalues of a smooth matrix.
    """

    hidden_weights: Tensor
    hidden_biases: Tensor
    output_weights: Tensor
    output_biases: Tensor
    input_centre: Tensor
    input_half_range: Tensor
    target_centre: Tensor
    target_half_range: Tensor

    def __init__(self, view: View, readout: Readout, arrays: Mapping[str, TensorLike]) -> None:
        super().__init__(view)
        checks.choice(readout, "readout", READOUTS)
        checks.Instance(Mapping)(arrays, "arrays")
        self.readout: Readout = readout
        for name, array in checked(arrays, _shapes(view, readout, arrays)).items():
            if name in WEIGHTS:
                self.register_parameter(name, torch.nn.Parameter(array))
            else:
                self.register_buffer(name, array)
        if (self.input_half_range <= 0).any() or self.target_half_range <= 0:
            raise ValueError("input_half_range and target_half_range must be positive")

    @classmethod
    @checks.arguments(
        view=checks.Instance(View), neurons=checks.Whole(1), random=checks.Instance(torch.Generator)
    )
    def untrained(
        cls,
        view: View,
        neurons: int,
        q: TensorLike,
        values: TensorLike,
        random: torch.Generator,
        readout: Readout = "identity",
    ) -> FeedForward:
        """Return a network with random weights, scaled to a training set.

        Parameters
        ----------
        view
            What the network sees.
        neurons
            Hidden neurons h.
        q, values
            (N, n) joint values and (N) or (N, k) values of the training set.
        random
            Where the weights come from: the rule of Nguyen and Widrow in the hidden layer, uniform between
            −0.5 and 0.5 in the output layer.
        readout
            How the value is read from the output layer.

        Raises
        ------
        ValueError
            If there are no neurons or no rows, shapes do not fit, an input or the values do not vary, or a
            readout meets values that it has no target for.
        """
        neurons = checks.whole(neurons, "neurons", least=1)
        checks.choice(readout, "readout", READOUTS)
        x, targets = view(q), target_of(values, readout)
        if x.ndim != 2 or not len(x) or not targets.ndim or len(x) != len(targets):
            raise ValueError(
                f"q has shape {tuple(x.shape)} and values {tuple(targets.shape)}; equal numbers of rows "
                "are needed"
            )
        input_centre, input_half_range = _middle(x)
        target_centre, target_half_ranges = _middle(targets)
        if still := (input_half_range == 0).nonzero().flatten().tolist():
            raise ValueError(f"inputs {still} of the network do not vary in q: leave them out of its view")
        if not torch.isfinite(target_half_ranges).all() or not torch.isfinite(target_centre).all():
            raise ValueError(f"values reach {targets.abs().max():.3g}, and their range overflows: scale them")
        if not target_half_ranges.max() > 0:
            raise ValueError("values are all the same: there is nothing to learn")
        hidden, output = _nguyen_widrow(neurons, view.width, _outputs(readout, targets.shape[1]), random)
        return cls(view, readout, {
            "hidden_weights": hidden[:, :-1], "hidden_biases": hidden[:, -1],
            "output_weights": output[:, :-1], "output_biases": output[:, -1],
            "input_centre": input_centre, "input_half_range": input_half_range,
            "target_centre": target_centre, "target_half_range": target_half_ranges.max(),
        })  # fmt: skip

    @property
    def neurons(self) -> int:
        """Number of hidden neurons h."""
        return len(self.hidden_biases)

    def _detail(self) -> str:
        return f"readout {self.readout!r}"

    @property
    def values(self) -> int:
        """Number of values k that the network answers with."""
        return len(self.target_centre)

    def answer(self, x: Tensor) -> Tensor:
        """Return values (...), or (..., k) for several, for what is seen (..., r)."""
        scaled = (x - self.input_centre) / self.input_half_range
        hidden = torch.tanh(scaled @ self.hidden_weights.mT + self.hidden_biases)
        outputs = hidden @ self.output_weights.mT + self.output_biases
        combined = smallest_eigenvalue(outputs) if self.readout in EIGENVALUES else outputs
        values = READOUTS[self.readout].value(combined * self.target_half_range + self.target_centre)
        return values[..., 0] if self.values == 1 else values


@dataclass(frozen=True)
class ReadoutRule:
    """A target as a function of a value, and back."""

    target: Callable[[Tensor], Tensor]
    value: Callable[[Tensor], Tensor]


READOUTS: Mapping[str, ReadoutRule] = {
    "identity": ReadoutRule(torch.clone, torch.clone),
    "reciprocal": ReadoutRule(torch.reciprocal, torch.reciprocal),
    "logarithm": ReadoutRule(torch.log, torch.exp),
    "cone": ReadoutRule(torch.log, torch.exp),
    "triple": ReadoutRule(torch.log, torch.exp),
}
"""Targets of the readouts."""

EIGENVALUES: Mapping[str, int] = {"cone": 3, "triple": 6}
"""Numbers of linear outputs of the readouts that are the smallest eigenvalue of a matrix."""

WEIGHTS = ("hidden_weights", "hidden_biases", "output_weights", "output_biases")
"""Names of what is trained."""


def target_of(values: TensorLike, readout: Readout) -> Float64[Tensor, "N k"]:
    """Return what a network with this readout is trained on, for values (N) or (N, k).

    Raises
    ------
    ValueError
        If values are not finite, or not positive where the readout needs that.
    """
    values = require_values(spatial.to_float64(values, "values"), "values")
    if readout != "identity" and (values <= 0).any():
        raise ValueError(f"values hold {values.min()}; the readout {readout!r} needs positive ones")
    targets = READOUTS[readout].target(values)
    if not torch.isfinite(targets).all():
        raise ValueError(
            f"values hold {values.min():.3g}, whose target for the readout {readout!r} overflows"
        )
    return targets[:, None] if targets.ndim == 1 else targets


def smallest_eigenvalue(outputs: Tensor) -> Tensor:
    """Return the smallest eigenvalues (..., 1) of matrices given by three or six linear outputs (..., m)."""
    if outputs.shape[-1] == 3:
        return outputs[..., :1] - torch.hypot(outputs[..., 1:2], outputs[..., 2:])
    return torch.linalg.eigvalsh(symmetric(outputs))[..., :1]


def symmetric(outputs: Tensor) -> Tensor:
    """Return symmetric matrices (..., 3, 3) with diagonal and upper elements from (..., 6)."""
    return outputs[..., [0, 3, 4, 3, 1, 5, 4, 5, 2]].unflatten(-1, (3, 3))


def _shapes(view: View, readout: Readout, arrays: Mapping[str, TensorLike]) -> dict[str, tuple[int, ...]]:
    neurons = len(spatial.to_float64(arrays.get("hidden_biases", ()), "hidden_biases"))
    values = len(spatial.to_float64(arrays.get("target_centre", ()), "target_centre"))
    if not neurons or not values:
        raise ValueError("hidden_biases and target_centre need at least one element each")
    outputs = _outputs(readout, values)
    return {
        "hidden_weights": (neurons, view.width), "hidden_biases": (neurons,),
        "output_weights": (outputs, neurons), "output_biases": (outputs,),
        "input_centre": (view.width,), "input_half_range": (view.width,),
        "target_centre": (values,), "target_half_range": (),
    }  # fmt: skip


def _outputs(readout: Readout, values: int) -> int:
    if readout not in EIGENVALUES:
        return values
    if values != 1:
        raise ValueError(f"the readout {readout!r} answers with one value; there are {values}")
    return EIGENVALUES[readout]


def _middle(rows: Tensor) -> tuple[Tensor, Tensor]:
    """Centre and half range of each column."""
    lowest, highest = rows.amin(0), rows.amax(0)
    return (lowest + highest) / 2, (highest - lowest) / 2


def _nguyen_widrow(neurons: int, inputs: int, outputs: int, random: torch.Generator) -> tuple[Tensor, Tensor]:
    """Random weights of hidden (h, r + 1) and output layer (m, h + 1), biases last."""

    def uniform(*shape: int) -> Tensor:
        return 2 * torch.rand(*shape, generator=random, dtype=torch.float64) - 1

    directions = torch.nn.functional.normalize(uniform(neurons, inputs), dim=-1)
    spread = (
        torch.linspace(-1, 1, neurons, dtype=torch.float64)
        if neurons > 1
        else torch.zeros(1, dtype=torch.float64)
    )
    length = 0.7 * neurons ** (1 / inputs)
    hidden = length * torch.cat([directions, (spread * directions[:, 0].sign())[:, None]], dim=-1)
    return hidden, uniform(outputs, neurons + 1) / 2
