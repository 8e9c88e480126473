"""Index of the configurations at a pose, and the best of them.

Examples
--------
>>> import dexterity as dx
>>> from dexterity.reach.judgement import Judge
>>> judge = Judge(dx.robots.puma560(), "kci")
>>> judge.label
"Index('kinematic_conditioning', 'geometric')"
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TypeAlias

import torch
from torch import Tensor

from dexterity.chain import Chain
from dexterity.indices import Index, require_not_zero_everywhere
from dexterity.reach.configurations import Found

__all__ = ["IndexLike", "Judge"]

IndexLike: TypeAlias = Index | str | Callable[[Tensor], Tensor] | None
"""An index, the name of one (in the geometric frame), a compiled index or another function of q, or none."""


class Judge:
    """Values configurations by an index, and chooses the best at each pose.

    Parameters
    ----------
    chain
        The chain.
    index
        What values them; see `IndexLike`. Without one, the first configuration at each pose is taken, and its
        value is 1.

    Raises
    ------
    ValueError
        If the index is unknown, does not fit the chain, or is zero everywhere.
    TypeError
        If it is none of these.
    """

    def __init__(self, chain: Chain, index: IndexLike) -> None:
        if isinstance(index, str):
            try:
                index = Index(index, "geometric")
            except ValueError as error:
                raise ValueError(f"index is {index!r}, which cannot be taken: {error}") from error
        if isinstance(index, Index):
            require_not_zero_everywhere(index, chain)
        elif index is not None and not callable(index):
            raise TypeError(f"index is {index!r}; an Index, a name, or a function of joint values is needed")
        self.chain = chain
        self.label = None if index is None else repr(index)
        self.function = index.bind(chain) if isinstance(index, Index) else index
        known = index if isinstance(index, Index) else getattr(index, "index", None)
        self.larger_is_better = known.measure.larger_is_better if isinstance(known, Index) else True

    def values(self, found: Found) -> Tensor:
        """Return the index (k, b) of configurations, NaN where they are not allowed."""
        values = torch.full(found.allowed.shape, math.nan, dtype=torch.float64)
        chosen = found.q[found.allowed]
        if self.function is None:
            values[found.allowed] = 1.0
        elif len(chosen):
            values[found.allowed] = torch.as_tensor(self.function(chosen), dtype=torch.float64)
        return values

    def best(self, found: Found) -> tuple[Tensor, Tensor]:
        """Return the best value (k) at each pose and its configuration (k, n), NaN where none is allowed."""
        values = self.values(found)
        at = self.score(values).argmax(-1)
        rows = torch.arange(len(at))
        reached = found.allowed.any(-1)
        q = torch.where(reached[:, None], found.q[rows, at], math.nan)
        return torch.where(reached, values[rows, at], math.nan), q

    def score(self, values: Tensor) -> Tensor:
        """Return numbers of which the largest is the best: −∞ for NaN."""
        signed = values if self.larger_is_better else -values
        return signed.nan_to_num(nan=-math.inf, posinf=math.inf, neginf=-math.inf)
