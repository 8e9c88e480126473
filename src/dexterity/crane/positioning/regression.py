"""The crane's sag by linear regression in trigonometric features of its arms' angles.

Statics is made of lever arms, which are cosines and sines of the angles of the arms, and is affine in the
payload. What bends how far is no polynomial of them, but nearly so.

Examples
--------
Mean absolute error of the regression [mm]:

>>> import dexterity as dx
>>> data = dx.crane.training_set()
>>> sag = dx.crane.positioning.TrigonometricSag.fit(data, degree=3)
>>> errors = (sag(data.strokes, data.payload) - data.deflection).abs()
>>> round(1000 * float(errors.mean()), 1)
0.3
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

__all__ = ["TrigonometricSag", "trigonometric_features"]


_MOST = 50  # of the degree, beyond which features are too many


def trigonometric_features(
    strokes: Float64[Tensor, "N 3"], degree: int, crane: Crane | None = None
) -> Float64[Tensor, "N features"]:
    r"""Return products of harmonics of the arms' angles and powers of the extension up to a degree.

    They are :math:`\cos(k\theta + l\psi)\, e^j` and :math:`\sin(k\theta + l\psi)\, e^j` with
    :math:`\lvert k\rvert + \lvert l\rvert + j` up to the degree, where θ is the angle of the lift arm, ψ that
    of the jib, and e the extension as a share of its longest.

    Parameters
    ----------
    strokes
        (N, 3) [m].
    degree
        Largest degree, at least 0.
    crane
        Which crane; None for :func:`~dexterity.crane.description.patu655`.

    Raises
    ------
    ValueError
        If the degree is negative, or the strokes are not finite.
    """
    degree = checks.whole(degree, "degree", least=0, most=_MOST)
    crane = given_crane(crane)
    strokes = require_strokes(strokes)
    if strokes.ndim != 2:
        raise ValueError(f"strokes has shape {tuple(strokes.shape)}; (N, 3) is needed")
    place = posture(strokes, crane)
    extension = strokes[:, 2] / crane.upper[2]
    columns = []
    for k in range(degree + 1):
        # One of each two harmonics that are the same but for the sign of the angle.
        for m in range(-(degree - k) if k else 0, degree - k + 1):
            angle = k * place.lift + m * place.jib
            waves = [angle.cos(), angle.sin()] if k or m else [torch.ones_like(angle)]
            columns += [wave * extension**j for wave in waves for j in range(degree - k - abs(m) + 1)]
    return torch.stack(columns, dim=-1)


@dataclass(frozen=True, eq=False)
class TrigonometricSag:
    """A deflection that is linear in features and affine in the payload.

    Attributes
    ----------
    degree
        Of the features.
    coefficients
        (2, features, 2) of own weight and of the rating, for x and y [m].
    crane
        Whose sag it is.
    """

    degree: int
    coefficients: Float64[Tensor, "2 features 2"]
    crane: Crane

    @classmethod
    def fit(cls, data: TrainingSet, degree: int, crane: Crane | None = None) -> TrigonometricSag:
        """Fit a training set by least squares.

        Raises
        ------
        ValueError
            If the degree is negative, or there are fewer rows than coefficients.
        """
        crane = given_crane(crane)
        checks.instance(data, "data", TrainingSet)
        degree = checks.whole(degree, "degree", least=0, most=_MOST)
        count = sum(2 * n * n + 2 * n + 1 for n in range(degree + 1))
        if len(data) < 2 * count:
            raise ValueError(f"degree is {degree} with {2 * count} coefficients; there are {len(data)} rows")
        features = trigonometric_features(data.strokes, degree, crane)
        columns = torch.cat([features, features * (data.payload / crane.rating)[:, None]], dim=-1)
        solved = torch.linalg.lstsq(columns, data.deflection, driver="gelsd").solution
        return cls(degree, solved.unflatten(0, (2, -1)), crane)

    def __call__(self, strokes: Tensor, payload: Tensor) -> Float64[Tensor, "N 2"]:
        """Return the deflection [m] for strokes (N, 3) [m] and payloads (N) [kg]."""
        features = trigonometric_features(strokes, self.degree, self.crane)
        own, rated = features @ self.coefficients
        return own + (payload / self.crane.rating)[:, None] * rated
