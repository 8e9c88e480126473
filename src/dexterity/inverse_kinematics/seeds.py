"""Search for configurations of any chain: descents from many seeds, and which of their ends differ.

Seeds are points of a Sobol sequence within the limits. Half of those of a pose are the ones whose tool is
nearest to it, so that most of them arrive; the others are the first points of the sequence, so that no
part of the joint space is left out.

Examples
--------
>>> import torch
>>> import dexterity as dx
>>> from dexterity.descent import TwistRows
>>> from dexterity.inverse_kinematics.seeds import search
>>> panda = dx.robots.load("panda")
>>> T = panda.forward([0.5, -0.7, 0.6, -2.3, 0.3, 1.7, 0.5])
>>> ends = search(panda, T[None], TwistRows(), count=16)
>>> bool(ends.residual.min() < 1e-9)
True
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import torch
from torch import Tensor

from dexterity import sobol
from dexterity.chain import Chain
from dexterity.descent import TwistRows, descend, length_scale
from dexterity.spatial.tolerances import LIMIT

__all__ = ["Ends", "distinct", "pose_features", "search"]

_POOL = 4096  # points of the Sobol sequence among which seeds are chosen
_AT_ONCE = 8192  # descents that are worked on at a time
_ROUNDS = (4, 12)  # seeds of the first rounds where few solutions are enough
_DIGITS = 1e-3  # of the tolerance, at which a descent ends


@dataclass(frozen=True)
class Ends:
    """Where seeds of poses ended: joint values (B, s, n), residuals (B, s), infinite where none was tried."""

    q: Tensor
    residual: Tensor

    def at_limits(self, chain: Chain) -> Tensor:
        """Which ends (B, s) have a joint at a limit."""
        at = (self.q <= chain.lower + LIMIT) | (self.q >= chain.upper - LIMIT)
        return (at & (chain.upper > chain.lower)).any(-1)


def search(
    chain: Chain,
    T: Tensor,
    rows: TwistRows,
    *,
    count: int = 64,
    near: Tensor | None = None,
    enough: int | None = None,
    tolerance: float = 1e-9,
    seed: int = 0,
) -> Ends:
    """Descend to poses (B, 4, 4) from seeds, one of them `near` (B, n), until `enough` have arrived."""
    rounds = [count] if enough is None else _split(count)
    pool = _pool(chain, seed)
    seeds = _Seeds(chain, rows, pool, pose_features(chain, chain.forward(pool), rows))
    parts = []
    for some in torch.arange(len(T)).split(max(1, _AT_ONCE // count)):
        starts = seeds.of_poses(T[some], count)
        if near is not None:
            starts = torch.cat([near[some, None], starts[:, :-1]], dim=1)
        ends = _descended(chain, T[some], starts, rows, rounds, enough, tolerance)
        if enough is None:
            ends = _from_beyond(chain, T[some], starts, rows, ends, tolerance)
        parts.append(ends)
    return Ends(torch.cat([part.q for part in parts]), torch.cat([part.residual for part in parts]))


def distinct(chain: Chain, q: Tensor, usable: Tensor, radius: float) -> Tensor:
    """Which of configurations (B, s, n) are to be kept, so that none is within a radius of one before it."""
    revolute = torch.tensor([kind == "revolute" for kind in chain.kinds])
    kept = torch.zeros_like(usable)
    for i in range(q.shape[1]):
        apart = q[:, : i + 1] - q[:, i : i + 1]
        apart = torch.where(revolute, torch.remainder(apart + math.pi, math.tau) - math.pi, apart)
        taken = (kept[:, : i + 1] & (apart.abs().amax(-1) < radius)).any(-1)
        kept[:, i] = usable[:, i] & ~taken
    return kept


def _descended(
    chain: Chain,
    T: Tensor,
    starts: Tensor,
    rows: TwistRows,
    rounds: list[int],
    enough: int | None,
    tolerance: float,
) -> Ends:
    """Descend from starts (B, s, n) in rounds; the next leaves out poses at which enough have arrived."""
    ends, residual = starts.clone(), torch.full(starts.shape[:2], math.inf, dtype=T.dtype)
    left, first = torch.arange(len(T)), 0
    for size in rounds:
        some = slice(first, first + size)
        targets = T[left, None].expand(-1, size, 4, 4).flatten(0, 1)
        q, miss = _to(chain, targets, starts[left, some].flatten(0, 1), rows, tolerance)
        ends[left, some], residual[left, some] = q.view(*starts[left, some].shape), miss.view(len(left), size)
        first += size
        if enough is not None:
            left = left[(residual[left] <= tolerance).sum(1) < enough]
        if not len(left):
            break
    return Ends(ends, residual)


def _from_beyond(
    chain: Chain, T: Tensor, starts: Tensor, rows: TwistRows, ends: Ends, tolerance: float
) -> Ends:
    """Try poses that no start has reached once more, by ways that lead beyond the limits.

    A descent within the limits may end at one of them, on the way to a configuration in a corner of theirs.
    """
    missed = ~(ends.residual <= tolerance).any(1)
    if not missed.any():
        return ends
    targets = T[missed, None].expand(-1, starts.shape[1], 4, 4).flatten(0, 1)
    beyond, _ = _to(chain, targets, starts[missed].flatten(0, 1), rows, tolerance, limits="approached")
    q, miss = _to(chain, targets, beyond, rows, tolerance)
    q, miss = q.view(*starts[missed].shape), miss.view(-1, starts.shape[1])
    better = miss < ends.residual[missed]
    merged = Ends(ends.q.clone(), ends.residual.clone())
    merged.q[missed] = torch.where(better[..., None], q, ends.q[missed])
    merged.residual[missed] = torch.where(better, miss, ends.residual[missed])
    return merged


def _to(
    chain: Chain, T: Tensor, starts: Tensor, rows: TwistRows, tolerance: float,
    limits: Literal["kept", "approached"] = "kept",
) -> tuple[Tensor, Tensor]:  # fmt: skip
    return descend(
        chain, T, starts, rows=rows.numbers, frame=rows.frame, tolerance=_DIGITS * tolerance, limits=limits
    )


def _split(count: int) -> list[int]:
    rounds: list[int] = []
    for size in (*_ROUNDS, count):
        rounds.append(min(size, count - sum(rounds)))
    return [size for size in rounds if size]


def _pool(chain: Chain, seed: int) -> Tensor:
    """Points (p, n) of a Sobol sequence within the limits, or within a turn of their middle."""
    lower, upper = chain.lower, chain.upper
    reach = torch.tensor(
        [math.pi if kind == "revolute" else 4 * length_scale(chain) for kind in chain.kinds],
        dtype=lower.dtype,
    )
    alone = torch.where(lower.isinf(), upper - reach, lower + reach)
    middle = torch.where(lower.isinf() | upper.isinf(), alone, (lower + upper) / 2)
    middle = torch.where(lower.isinf() & upper.isinf(), 0.0, middle)
    low, high = torch.maximum(lower, middle - reach), torch.minimum(upper, middle + reach)
    return low + (high - low) * sobol.points(chain.joints, _POOL, seed)


def pose_features(chain: Chain, T: Tensor, rows: TwistRows) -> Tensor:
    """Numbers (k, f) of poses whose differences are about as large as the remaining twist in some rows."""
    linear = [row for row in range(3) if row in rows.numbers]
    # Along axes of the tool, parts of a position are not those of the world.
    linear = linear if rows.frame == "geometric" or len(linear) == 3 else []
    free = [row - 3 for row in range(3, 6) if row not in rows.numbers]
    R = T[:, :3, :3]
    if len(free) == 1:  # what a rotation about one axis leaves as it is
        R = R[:, :, free] if rows.frame == "body" else R[:, free]
    turning = R.flatten(1) / math.sqrt(2) if len(free) < 2 else T.new_zeros(len(T), 0)
    return torch.cat([T[:, linear, 3] / length_scale(chain), turning], 1)


@dataclass(frozen=True)
class _Seeds:
    """Points (p, n) of the joint space, and features (p, f) of the poses there."""

    chain: Chain
    rows: TwistRows
    points: Tensor
    features: Tensor

    def of_poses(self, T: Tensor, count: int) -> Tensor:
        """Seeds (B, count, n): the nearest first, then the first of the sequence."""
        first = torch.arange(count).expand(len(T), -1)
        if not self.features.shape[1]:
            return self.points[first]
        half = (count + 1) // 2
        apart = torch.cdist(pose_features(self.chain, T, self.rows), self.features)
        nearest = apart.topk(half, largest=False).indices
        return self.points[torch.cat([nearest, first[:, : count - half]], dim=1)]
