"""What both searches are given: a box, and a function of many points at a time that is to be made large.

Examples
--------
>>> from dexterity.search import box
>>> lower, upper = box.limits([0, 0], [1, 2])
>>> box.evaluated(lambda points: points.sum(-1), upper[None]).tolist()
[3.0]
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

import torch
from torch import Tensor

from dexterity import checks
from dexterity.spatial import TensorLike
from dexterity.spatial.values import on_cpu

__all__ = ["Objective", "evaluated", "limits", "steps"]

Objective: TypeAlias = Callable[[Tensor], Tensor]
"""Values (N) of points (N, d); larger is better."""


def limits(lower: TensorLike, upper: TensorLike) -> tuple[Tensor, Tensor]:
    """Return the limits (d) of a box, independent of the originals.

    Raises
    ------
    ValueError
        If they are no vectors of one length, not finite, too far apart, or a lower one is above its upper
        one.
    """
    low, high = (on_cpu(limit, name).detach().clone() for limit, name in ((lower, "lower"), (upper, "upper")))
    if low.ndim != 1 or low.shape != high.shape or len(low) == 0:
        raise ValueError(
            f"lower has shape {tuple(low.shape)} and upper {tuple(high.shape)}; "
            "two vectors of one length are needed"
        )
    if (low > high).any():
        i = int((low > high).nonzero()[0])
        raise ValueError(f"lower is {low[i].item()} and upper {high[i].item()} at variable {i}")
    if not (high - low).isfinite().all():
        raise ValueError(f"upper is {high.tolist()}, farther from lower than numbers go")
    return low, high


def steps(value: TensorLike, name: str, variables: int) -> Tensor:
    """Return positive numbers (d), one a variable.

    Raises
    ------
    ValueError
        If they are not as many, or one is not positive.
    """
    each = on_cpu(value, name).detach()
    if each.shape != (variables,) or (each <= 0).any():
        raise ValueError(
            f"{name} is {checks.shown(each.tolist())}; "
            f"{variables} positive numbers are needed, one a variable"
        )
    return each


def evaluated(objective: Objective, points: Tensor) -> Tensor:
    """Values (N) of points (N, d).

    Raises
    ------
    ValueError
        If the objective answers with another shape, or with NaN.
    TypeError
        If it does not answer with numbers.
    """
    answer = objective(points)
    try:
        values = torch.as_tensor(answer).detach()
    except (TypeError, ValueError, RuntimeError) as error:
        raise TypeError(f"objective answers with {checks.shown(answer)}; numbers are needed") from error
    if values.is_complex():
        raise TypeError(f"objective answers with {values.dtype} values; real numbers are needed")
    if values.shape != points.shape[:1]:
        raise ValueError(f"objective has values of shape {tuple(values.shape)}; ({len(points)},) is needed")
    if values.isnan().any():
        raise ValueError(f"objective is NaN at {points[values.isnan()][0].tolist()}")
    return values.to(torch.float64)
