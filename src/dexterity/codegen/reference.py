"""Values that a generated file is compared with: those of the index itself, without any derivation.

Examples
--------
>>> import dexterity as dx
>>> from dexterity.codegen.reference import references
>>> from dexterity.derivation import derive
>>> rows = references(derive(dx.robots.puma560(), dx.indices.Index("manipulability")))
>>> rows.q.shape, rows.values.shape, rows.gradients.shape
((4, 6), (4,), (4, 6))
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from dexterity import spatial
from dexterity.chain import Chain
from dexterity.derivation import Derivation

__all__ = ["References", "references", "regular_rows"]

COUNT = 4
"""Configurations that a file brings with it."""


class References(NamedTuple):
    """Configurations (4, n), and the values (4,) and gradients (4, n) of an index there."""

    q: NDArray[np.float64]
    values: NDArray[np.float64]
    gradients: NDArray[np.float64]


def references(derivation: Derivation) -> References:
    """Return the index by its definition, with its gradient by automatic differentiation."""
    chain = derivation.chain.numeric()
    q = regular_rows(chain)
    values, gradients = spatial.value_and_gradient(derivation.index.bind(chain), q)
    # Where an index is zero everywhere it has no derivative, and generated code returns zero.
    gradients = torch.where(values[:, None] == 0, 0.0, gradients)
    return References(q.numpy(), values.numpy(), gradients.numpy())


def regular_rows(chain: Chain) -> Tensor:
    """Return four configurations (4, n) within the limits that are far from singularities.

    They are numbers of single precision, so that a file in single precision is asked for the same ones.
    """
    draws = torch.rand(64, chain.joints, dtype=torch.float64, generator=torch.Generator().manual_seed(0))
    lower, upper = chain.lower.clamp(min=-1.5), chain.upper.clamp(max=1.5)
    outside = lower >= upper  # limits that lie wholly beyond ±1.5
    lower, upper = torch.where(outside, chain.lower, lower), torch.where(outside, chain.upper, upper)
    q = (lower + (upper - lower) * draws).float().double()
    smallest = torch.linalg.svdvals(chain.geometric_jacobian(q))[:, -1]
    return q[smallest.argsort(descending=True)[:COUNT]]
