"""What any network must beat: a constant, polynomials, and boosted trees, fitted to the same data.

A network that errs by two per cent is no achievement where a constant does.

Examples
--------
>>> import torch
>>> from dexterity.networks import baselines
>>> from dexterity.sampling import DataSet
>>> q = torch.tensor([[0.0], [1.0], [2.0]]).double()
>>> baselines.constant(DataSet(q, q[:, 0] + 1)).value
1.5
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import combinations_with_replacement
from typing import Any

import numpy as np
import torch
from jaxtyping import Float64, Int64
from torch import Tensor

from dexterity import checks, spatial
from dexterity.networks.network import View
from dexterity.networks.threads import one_thread
from dexterity.networks.validation import Function
from dexterity.sampling import DataSet
from dexterity.spatial import TensorLike

__all__ = ["Constant", "Polynomial", "Trees", "baselines", "constant", "polynomial", "trees"]


@checks.arguments(view=checks.Instance(View), train=checks.Instance(DataSet), seed=checks.Whole(0, 2**32 - 1))
def baselines(view: View, train: DataSet, seed: int = 0) -> Mapping[str, Function]:
    """Fit all of them to a training set.

    Parameters
    ----------
    view
        What they see of a configuration, as a network would.
    train
        The network's training set.
    seed
        Of the trees.

    Returns
    -------
    ``"constant"``, ``"quadratic"``, ``"cubic"`` and ``"boosted trees"``, as functions of joint values.

    Raises
    ------
    ImportError
        If scikit-learn is missing.
    ValueError
        If there are too few rows for a polynomial, an input does not vary, or values are not positive.
    """
    return {
        "constant": constant(train),
        "quadratic": polynomial(view, train, 2),
        "cubic": polynomial(view, train, 3),
        "boosted trees": trees(view, train, seed),
    }


@dataclass(frozen=True)
class Constant:
    """The same value everywhere.

    Attributes
    ----------
    value
        The value.
    joints
        Number of joints n.
    """

    value: float
    joints: int

    def __post_init__(self) -> None:
        checks.fields(self, value=checks.Real(), joints=checks.Whole(1))

    def __call__(self, q: TensorLike) -> Float64[Tensor, "*batch"]:
        """Value for joint values (..., n)."""
        q = spatial.require_joints(spatial.to_float64(q, "q"), self.joints, "constant")
        # With a slope of zero and not without one, so that a search can climb on its error.
        return 0.0 * q.sum(-1) + self.value


@checks.arguments(train=checks.Instance(DataSet))
def constant(train: DataSet) -> Constant:
    """Return the constant whose largest relative error on the training set is least.

    That is the harmonic mean of the smallest and the largest value.

    Raises
    ------
    ValueError
        If there are no rows or a value is not positive.
    """
    if not len(train.values):
        raise ValueError("train has no rows")
    smallest, largest = float(train.values.min()), float(train.values.max())
    if smallest <= 0:
        raise ValueError(f"train holds the value {smallest}; positive ones are needed")
    return Constant(2 / (1 / smallest + 1 / largest), train.q.shape[-1])


@dataclass(frozen=True)
class Polynomial:
    """A polynomial in what a network would see, scaled to [−1, 1].

    Attributes
    ----------
    view
        What it sees.
    centre, half_range
        (r) of the inputs in the training set.
    factors
        (t, d) factors of each of the t terms, as numbers of inputs; r stands for the factor 1.
    coefficients
        (t) of the terms.
    """

    view: View
    centre: Float64[Tensor, " r"]
    half_range: Float64[Tensor, " r"]
    factors: Int64[Tensor, "t d"]
    coefficients: Float64[Tensor, " t"]

    def __call__(self, q: TensorLike) -> Float64[Tensor, "*batch"]:
        """Value for joint values (..., n)."""
        return _terms((self.view(q) - self.centre) / self.half_range, self.factors) @ self.coefficients


@checks.arguments(view=checks.Instance(View), train=checks.Instance(DataSet))
def polynomial(view: View, train: DataSet, degree: int) -> Polynomial:
    """Fit all terms up to a degree by least squares.

    Raises
    ------
    ValueError
        If the degree is not positive, there are fewer rows than terms, or an input does not vary.
    """
    degree = checks.whole(degree, "degree", least=1)
    x = view(train.q)
    terms = math.comb(view.width + degree, degree)
    if len(x) < terms:
        raise ValueError(f"train has {len(x)} rows; the polynomial has {terms} terms")
    factors = torch.tensor(list(combinations_with_replacement(range(view.width + 1), degree)))
    lowest, highest = x.amin(0), x.amax(0)
    if still := (lowest == highest).nonzero().flatten().tolist():
        raise ValueError(f"inputs {still} do not vary in train: leave them out of the view")
    centre, half_range = (lowest + highest) / 2, (highest - lowest) / 2
    matrix = _terms((x - centre) / half_range, factors)
    # The default driver does not give the same last digits twice, and no driver does on several threads.
    with one_thread():
        coefficients = torch.linalg.lstsq(matrix, train.values[:, None], driver="gelsd").solution[:, 0]
    return Polynomial(view, centre, half_range, factors, coefficients)


@dataclass(frozen=True)
class Trees:
    """Gradient-boosted trees of scikit-learn; a staircase, which torch cannot differentiate."""

    view: View
    model: Any

    def __call__(self, q: TensorLike) -> Float64[Tensor, "*batch"]:
        """Value for joint values (..., n)."""
        x = self.view(q)
        if not x.numel():  # scikit-learn refuses to predict nothing
            return x.new_zeros(x.shape[:-1])
        values = self.model.predict(x.reshape(-1, self.view.width).numpy(force=True))
        return torch.as_tensor(values, device=x.device).reshape(x.shape[:-1])


@checks.arguments(view=checks.Instance(View), train=checks.Instance(DataSet), seed=checks.Whole(0, 2**32 - 1))
def trees(view: View, train: DataSet, seed: int = 0) -> Trees:
    """Fit boosted trees with the library's own settings, but for as many rounds as lower the error.

    Raises
    ------
    ImportError
        If scikit-learn is missing.
    """
    try:
        from sklearn.ensemble import HistGradientBoostingRegressor
    except ImportError as error:
        raise ImportError("boosted trees need scikit-learn: pip install dexterity-study[trees]") from error
    model = HistGradientBoostingRegressor(max_iter=1000, early_stopping=True, random_state=seed)
    model.fit(np.asarray(view(train.q)), np.asarray(train.values))
    return Trees(view, model)


def _terms(x: Tensor, factors: Tensor) -> Tensor:
    """Products (..., t) of inputs (..., r)."""
    padded = torch.nn.functional.pad(x, (0, 1), value=1.0)
    product = padded[..., factors[:, 0]]
    for column in factors[:, 1:].unbind(-1):
        product = product * padded[..., column]
    return product
