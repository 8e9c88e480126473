"""Points of scrambled Sobol sequences, the same whatever torch's default type and device are.

Examples
--------
>>> from dexterity import sobol
>>> sobol.points(2, 4, seed=0).shape
torch.Size([4, 2])

References
----------
Owen (1998), Scrambling Sobol' and Niederreiter–Xing points.
"""

from __future__ import annotations

import torch
from jaxtyping import Float64
from torch import Tensor

__all__ = ["points"]


def points(dimensions: int, count: int, seed: int) -> Float64[Tensor, "count dimensions"]:
    """Return the first points of a sequence in the unit cube, on the CPU."""
    with torch.device("cpu"):
        engine = torch.quasirandom.SobolEngine(dimensions, scramble=True, seed=seed)
        first = engine.quasi.double() / 2**engine.MAXBIT
        drawn = engine.draw(count, dtype=torch.float64)
    # The engine computes its first point in torch's default type; here it has single precision, always.
    drawn[:1] = first.float()
    return drawn
