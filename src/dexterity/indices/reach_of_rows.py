"""Along how many of its rows an index can move the tool at all, and which rows a chain can serve.

Examples
--------
>>> import dexterity as dx
>>> arm = dx.Chain.from_dh([{"a": 0.5}, {"a": 0.25}], name="planar arm")
>>> dx.indices.require_not_zero_everywhere(dx.indices.Index("w", "geometric", rows=("vx", "vy")), arm)
>>> dx.indices.require_not_zero_everywhere(dx.indices.Index("w", "geometric"), arm)
Traceback (most recent call last):
    ...
ValueError: planar arm has 2 joints; with fewer than 6 the manipulability of the rows full is zero \
everywhere: at most 2 of the 6 rows can be reached at once. Take rows=('vx', 'vy') or others
"""

from __future__ import annotations

import torch
from torch import Tensor

from dexterity import checks
from dexterity.chain import Chain
from dexterity.indices.index import Index
from dexterity.indices.rows import Rows, shortest_name

__all__ = ["general_configurations", "require_not_zero_everywhere", "rows_of_full_rank"]


@checks.arguments(index=checks.Instance(Index), chain=checks.Instance(Chain))
def require_not_zero_everywhere(index: Index, chain: Chain) -> None:
    """Make sure that an index is not the same worst value, such as zero, at all configurations of a chain.

    Looked at are configurations in general position: what happens there happens almost everywhere.

    Raises
    ------
    ValueError
        If it is; rows that the chain can serve are named.
    """
    measure = index.measure
    q = general_configurations(chain)
    rows = index.row_numbers
    J = index.normalised_jacobian(chain, q)
    if measure.full_rank:
        reached = _rank(J)
        if reached == len(rows):
            return
        tried = f"at most {reached} of the {len(rows)} rows can be reached at once"
    elif (index.bind(chain)(q) != measure.value_at_zero).any():
        return
    else:
        tried = "the tool cannot move so"
    advice = rows_of_full_rank(index, chain)
    few = f"; with fewer than {len(rows)}" if chain.joints < len(rows) else ":"
    raise ValueError(
        f"{chain.name} has {chain.joints} joint{'s' * (chain.joints > 1)}{few} the "
        f"{measure.name.replace('_', ' ')} of the rows {_said(index.rows)} is "
        f"{'zero' if measure.value_at_zero == 0 else measure.value_at_zero} everywhere: {tried}. "
        + (f"Take rows={advice!r} or others" if advice else "No row can be reached: all joints are locked")
    )


def rows_of_full_rank(index: Index, chain: Chain) -> Rows | None:
    """Return rows that the chain can serve all at once: three of a kind if it can, else as many as it can."""
    J = index.normalised_jacobian(chain, general_configurations(chain), rows=range(6))
    for block in ((0, 1, 2), (3, 4, 5)):
        if set(block) < set(index.row_numbers) and _rank(J[:, list(block)]) == 3:
            return shortest_name(block)
    rows: list[int] = []
    for row in range(6):
        if _rank(J[:, [*rows, row]]) == len(rows) + 1:
            rows.append(row)
    return shortest_name(tuple(rows)) if rows else None


def _said(rows: Rows) -> str:
    return rows if isinstance(rows, str) else ", ".join(map(str, rows))


def general_configurations(chain: Chain) -> Tensor:
    """Eight configurations in which nothing is aligned, the same for all chains of that many joints."""
    random = torch.Generator().manual_seed(0)
    return 2 * torch.rand(8, chain.joints, generator=random, dtype=torch.float64, device="cpu") - 1


def _rank(J: Tensor) -> int:
    """Largest rank of some Jacobians, each row scaled to unit length first."""
    lengths = torch.linalg.vector_norm(J, dim=-1, keepdim=True)
    sigma = torch.linalg.svdvals(J / torch.where(lengths > _LENGTH, lengths, torch.inf))
    return int((sigma > _RANK).sum(-1).max())


_LENGTH, _RANK = 1e-12, 1e-9
