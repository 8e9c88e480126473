"""The crane's sag by interpolation in a table of corrections.

What the thesis's networks are to replace: the deflection at the nodes of a regular grid of strokes, once by
own weight and once by payload, with multilinear interpolation between them.

Examples
--------
>>> import dexterity as dx
>>> from dexterity.crane.positioning import TableSag
>>> table, task = TableSag.of([3, 3, 3]), dx.crane.positioning.thesis_task()
>>> table.entries, table(task.starts, task.payload).shape
(108, torch.Size([125, 2]))
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import torch
from jaxtyping import Float64
from scipy.interpolate import RegularGridInterpolator
from torch import Tensor

from dexterity import checks
from dexterity.crane.description import Crane, given_crane, stroke_values
from dexterity.crane.structure import load_response

__all__ = ["TableSag"]


_MOST_NODES = 10_000_000


@dataclass(frozen=True, eq=False)
class TableSag:
    """A deflection that is looked up.

    Attributes
    ----------
    nodes
        Values of each stroke.
    interpolator
        Of strokes (N, 3) for the deflection (N, 4), by own weight and by 1 kg [m].
    """

    nodes: tuple[int, int, int]
    interpolator: RegularGridInterpolator

    @classmethod
    def of(cls, nodes: Sequence[int], crane: Crane | None = None) -> TableSag:
        """Fill a table by linear statics, over all strokes that a crane's cylinders have.

        Parameters
        ----------
        nodes
            How many values of s1, s2 and s3 it has, two at least of each.
        crane
            Which crane; None for :func:`~dexterity.crane.description.patu655`.

        Raises
        ------
        ValueError
            If the nodes are not three, or there are fewer than two of a stroke.
        """
        if isinstance(nodes, str | bytes) or not isinstance(nodes, Sequence) or len(nodes) != 3:
            raise ValueError(f"nodes is {checks.shown(nodes)}; 2 or more of each of three strokes are needed")
        nodes = [checks.whole(count, f"nodes[{i}]", least=2) for i, count in enumerate(nodes)]
        if math.prod(nodes) > _MOST_NODES:
            raise ValueError(
                f"nodes is {nodes}, {math.prod(nodes):,} in all; at most {_MOST_NODES:,} are filled"
            )
        crane = given_crane(crane)
        axes = stroke_values(crane, nodes)
        response = load_response(torch.stack(torch.meshgrid(*axes, indexing="ij"), dim=-1), crane)
        values = torch.cat([response.own_weight, response.per_kilogram], dim=-1).numpy()
        # A start may be beyond a cylinder's end; the table goes on as it was.
        reading = RegularGridInterpolator(
            [axis.numpy() for axis in axes], values, bounds_error=False, fill_value=None
        )
        first, second, third = nodes
        return cls((first, second, third), reading)

    @property
    def entries(self) -> int:
        """How many numbers the table holds."""
        return int(np.prod(self.nodes)) * 4

    def __call__(self, strokes: Tensor, payload: Tensor) -> Float64[Tensor, "N 2"]:
        """Return the deflection [m] for strokes (N, 3) [m] and payloads (N) [kg]."""
        read = torch.from_numpy(self.interpolator(strokes.detach().numpy()))
        return read[:, :2] + payload[:, None] * read[:, 2:]
