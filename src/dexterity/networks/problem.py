"""What a design loop is given, the error by which it decides, and how it ends.

Examples
--------
>>> import dexterity as dx
>>> from dexterity.networks import network, problem
>>> w = dx.indices.Index("manipulability").bind(dx.robots.uvms())
>>> data = dx.sampling.data_sets(
...     w, dx.sampling.uvms_space("manipulability"), train=200, test=100
... )
>>> learned = problem.DesignProblem(network.View(12, [4, 5, 6, 7, 8, 9, 10]), data)
>>> round(problem.largest_relative_error(lambda q: 1.25 * w(q), learned.data.test), 6)
0.25
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from enum import Enum
from typing import Literal, TypeAlias, TypeVar

import torch
from torch import Tensor
from tqdm import tqdm

from dexterity import checks
from dexterity.networks.network import View
from dexterity.sampling import DataSet, DataSets

__all__ = ["DesignProblem", "End", "Sweep", "largest_relative_error"]

Sweep: TypeAlias = Literal["first", "all"]
"""Whether a design ends at the first size or spread that passes, as printed, or goes through all of them."""


class End(Enum):
    """Why a design ended."""

    PASSED = "a network passed the test"
    EXHAUSTED = "all sizes or spreads were tried, and no network passed"
    INTERRUPTED = "it was interrupted, and no network had passed"


@dataclass(frozen=True)
class DesignProblem:
    """An index to be learned: what the network sees, and the data.

    Attributes
    ----------
    view
        What the network sees of a configuration.
    data
        The training set, the test set that the loop looks at, and the validation set that it does not.

    Raises
    ------
    ValueError
        If a set is empty, has another number of joints than the view or another number of values than
        configurations, holds NaN or an infinity, or holds a value of zero where a relative error is taken;
        or if the training values are all the same.
    """

    view: View
    data: DataSets

    def __post_init__(self) -> None:
        checks.fields(self, view=checks.Instance(View), data=checks.Instance(DataSets))
        for name in ("train", "test", "validation"):
            _check(getattr(self.data, name), name, self.view.joints)
        for name in ("test", "validation"):
            if (getattr(self.data, name).values == 0).any():
                raise ValueError(f"{name} holds a value of 0, where no relative error exists")
        values = self.data.train.values
        if values.min() == values.max():
            raise ValueError(f"train holds one value, {values[0].item()}: there is nothing to learn")


_Found = TypeVar("_Found")


def collected(found: Iterator[_Found], total: int, unit: str, progress: bool) -> tuple[list[_Found], End]:
    """Go through what a design loop finds, with a bar on stderr; an interrupt from the keyboard ends it.

    Returns
    -------
    What was found, and why the loop ended if nothing of it passes.

    Raises
    ------
    KeyboardInterrupt
        If there is nothing so far.
    """
    so_far: list[_Found] = []
    with tqdm(total=total, unit=unit, disable=not progress) as bar:
        try:
            for each in found:
                so_far.append(each)
                bar.update()
        except KeyboardInterrupt:
            if not so_far:
                raise
            return so_far, End.INTERRUPTED
    return so_far, End.EXHAUSTED


@checks.arguments(network=checks.function, data=checks.Instance(DataSet))
def largest_relative_error(network: Callable[[Tensor], Tensor], data: DataSet) -> float:
    """Return the largest relative error over a data set, Eq. 21 of Sotiropoulos & Aspragathos (2016).

    Parameters
    ----------
    network
        Any function of joint values, (N, n) → (N).
    data
        Configurations and exact values, none of them zero.
    """
    with torch.no_grad():
        return ((network(data.q) - data.values) / data.values).abs().max().item()


def _check(data: DataSet, name: str, joints: int) -> None:
    if not len(data.q) or data.q.shape[1] != joints:
        raise ValueError(f"{name}.q has shape {tuple(data.q.shape)}; rows of {joints} joints are needed")
