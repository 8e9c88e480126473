"""The crane's sag by a network of what is known: angles for strokes, and a sag affine in the payload.

The thesis's correction network sees strokes and payload, and has to learn the linkages and a multiplication.
Both are known. This one sees cosines and sines of the arms' angles and the extension, and answers with the
sag by own weight and by the rating. It has one row a pose to learn from instead of ten.

Examples
--------
>>> import torch
>>> import dexterity as dx
>>> data, random = dx.crane.training_set(), torch.Generator().manual_seed(0)
>>> sag = dx.crane.positioning.AngleNetworkSag.fit(data, 3, random, epochs=20)
>>> sag(data.strokes[:5], data.payload[:5]).shape
torch.Size([5, 2])
"""

from __future__ import annotations

from dataclasses import dataclass

import torch
from jaxtyping import Float64
from torch import Tensor

from dexterity import checks
from dexterity.crane.data import TrainingSet
from dexterity.crane.description import Crane, given_crane
from dexterity.crane.kinematics import posture, require_strokes
from dexterity.crane.positioning.learning import EPOCHS
from dexterity.networks.feed_forward import FeedForward
from dexterity.networks.levenberg_marquardt import Options, levenberg_marquardt
from dexterity.networks.network import View

__all__ = ["AngleNetworkSag"]


@dataclass(frozen=True, eq=False)
class AngleNetworkSag:
    """A deflection that a network says by own weight and by the rating.

    Attributes
    ----------
    network
        Of cosine and sine of the lift arm's and the jib's angle and the extension [m] (..., 5), for the
        deflection by own weight and by the rating besides (..., 4) [m].
    crane
        Whose sag it is.
    """

    network: FeedForward
    crane: Crane

    @classmethod
    def fit(
        cls,
        data: TrainingSet,
        neurons: int,
        generator: torch.Generator,
        epochs: int = EPOCHS,
        crane: Crane | None = None,
    ) -> AngleNetworkSag:
        """Train a network on a training set by the Levenberg–Marquardt method.

        Parameters
        ----------
        data
            What to learn from, each pose with two payloads at least.
        neurons
            Hidden neurons.
        generator
            Where the initial weights come from.
        epochs
            Steps of the training.
        crane
            Which crane; None for :func:`~dexterity.crane.description.patu655`.

        Raises
        ------
        ValueError
            If there are no neurons or epochs, or a pose comes with one payload only.
        """
        crane = given_crane(crane)
        checks.instance(data, "data", TrainingSet)
        checks.instance(generator, "generator", torch.Generator)
        neurons, epochs = checks.whole(neurons, "neurons", least=1), checks.whole(epochs, "epochs", least=1)
        strokes, affine = _affine(data, crane.rating)
        view = View(_INPUTS, tuple(range(_INPUTS)))
        seen = _seen(strokes, crane)
        start = FeedForward.untrained(view, neurons, seen, affine, generator)
        return cls(levenberg_marquardt(start, seen, affine, Options(epochs=epochs)).network, crane)

    def __call__(self, strokes: Tensor, payload: Tensor) -> Float64[Tensor, "N 2"]:
        """Return the deflection [m] for strokes (N, 3) [m] and payloads (N) [kg]."""
        with torch.no_grad():
            said = self.network(_seen(strokes, self.crane))
        return said[:, :2] + (payload / self.crane.rating)[:, None] * said[:, 2:]


_INPUTS = 5


def _seen(strokes: Tensor, crane: Crane) -> Float64[Tensor, "N 5"]:
    place = posture(strokes, crane)
    waves = (place.lift.cos(), place.lift.sin(), place.jib.cos(), place.jib.sin())
    return torch.stack([*waves, require_strokes(strokes)[:, 2]], dim=-1)


def _affine(data: TrainingSet, rating: float) -> tuple[Tensor, Tensor]:
    """Poses (P, 3), and the lines (P, 4) through their deflections: at no payload, and the rise."""
    strokes, pose = data.strokes.unique(dim=0, return_inverse=True)
    count = torch.zeros(len(strokes), dtype=torch.float64).index_add(0, pose, torch.ones_like(data.payload))

    def mean(values: Tensor) -> Tensor:
        total = torch.zeros(len(strokes), values.shape[1], dtype=torch.float64).index_add(0, pose, values)
        return total / count[:, None]

    share = (data.payload / rating)[:, None]
    from_mean = share - mean(share)[pose]
    spread = mean(from_mean.square())
    if (spread == 0).any():
        raise ValueError(
            f"data holds {strokes[spread[:, 0] == 0][0].tolist()} with one payload; 2 are needed"
        )
    rise = mean(from_mean * data.deflection) / spread
    return strokes, torch.cat([mean(data.deflection) - mean(share) * rise, rise], dim=-1)
