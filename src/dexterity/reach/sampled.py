"""Reach by sampling: configurations are drawn, and the cells of a grid that they fall into are reached.

What is found is certain, and is a lower bound; what is missed can only be estimated, and is what the draws
have little chance to see: near the border of the workspace and near singularities.

Examples
--------
>>> import torch
>>> import dexterity as dx
>>> from dexterity import reach
>>> arm = dx.robots.panda()
>>> grid = reach.box([-0.8, -0.8, 0.0], [0.8, 0.8, 0.8], spacing=0.4)
>>> surveyed = reach.survey(arm, grid, reach.rotations(24), method="sampling", draws=20_000)
>>> 0.1 < float(surveyed.share.mean()) < 0.9, surveyed.missed.share < 0.05
(True, True)
"""

from __future__ import annotations

import math

import torch
from scipy.spatial import cKDTree
from torch import Tensor

from dexterity import checks
from dexterity.chain import Chain
from dexterity.descent import TwistRows
from dexterity.reach.configurations import drawn_range
from dexterity.reach.draft import Draft
from dexterity.reach.judgement import Judge
from dexterity.reach.missed import CONFIDENCE, Missed, largest_share, unseen
from dexterity.reach.reach_map import ReachMap
from dexterity.reach.rotation_grid import covering_radius
from dexterity.reach.work import Progress, counted, in_pieces

__all__ = ["sampled"]

_AT_ONCE = 2**15
_HELD_OUT = 0.1


def sampled(
    chain: Chain,
    positions: Tensor,
    rotations: Tensor,
    judge: Judge,
    *,
    draws: int,
    cell: tuple[float, float] | None,
    seed: int,
    progress: Progress = False,
) -> ReachMap:
    """Draw configurations uniformly within the limits, and mark the cells that their poses fall into.

    Parameters and errors are those of :func:`dexterity.reach.survey`. The last tenth of the draws is held
    out: the share of them that falls into cells that no draw before them saw bounds what is missed.
    """
    draws = checks.whole(draws, "draws", least=10, most=10**9)
    cells = _Cells(positions, rotations, cell)
    draft = Draft(chain, positions, rotations)
    lower, width = drawn_range(chain)
    generator = torch.Generator().manual_seed(seed)
    first = draws - int(draws * _HELD_OUT)
    with counted(progress, draws, f"{chain.name}, sampling") as add:

        def draw(at: Tensor) -> Tensor:  # on one thread, so that the draws are the same every time
            share = torch.rand(len(at), chain.joints, generator=generator, dtype=torch.float64)
            return lower + width * share

        complete = in_pieces(
            torch.arange(first), draw, lambda _, q: _mark(draft, judge, cells, q), size=_AT_ONCE, add=add
        )
        known, tried, new = draft.reached.clone(), 0, 0

        def hold_out(_: Tensor, q: Tensor) -> None:
            nonlocal tried, new
            falls = _mark(draft, judge, cells, q)
            tried, new = tried + len(falls), new + int((~known.flatten()[falls]).sum())

        if complete:
            complete = in_pieces(torch.arange(first, draws), draw, hold_out, size=_AT_ONCE, add=add)
    draft.examined[:] = complete
    draft.examined |= draft.reached
    return draft.finished(judge, "sampling", TwistRows(), _missed(draft, tried, new), cells.size)


def _missed(draft: Draft, tried: int, new: int) -> Missed:
    estimate, share = unseen(draft.hits.numpy()), largest_share(new, tried)
    return Missed(
        estimate,
        None,
        share,
        f"sampling: {new} of {tried} held-out configurations that fell into the grid fell into cells that no "
        f"draw before them saw; with {100 * CONFIDENCE:.0f} % confidence at most {100 * share:.2g} % of such "
        f"configurations do. Cells seen once and twice suggest that at least {estimate:.0f} are missed.",
    )


def _mark(draft: Draft, judge: Judge, cells: _Cells, q: Tensor) -> Tensor:
    """Mark the cells that configurations (k, n) fall into, and return their numbers; some fall into none."""
    at, inside = cells.of(draft.chain.forward(q))
    at, q = at[inside], q[inside]
    values = torch.ones(len(q), dtype=torch.float64)
    if judge.function is not None and len(q):
        values = torch.as_tensor(judge.function(q), dtype=torch.float64)
    draft.hits.view(-1).scatter_add_(0, at, torch.ones_like(at))
    draft.count.copy_(draft.hits)
    draft.reached.view(-1)[at] = True
    # The best of each cell in this piece: the last after sorting by the score.
    order = judge.score(values).argsort(stable=True)
    best = torch.full((draft.reached.numel(),), -1)
    best[at[order]] = order
    chosen = best[best >= 0]
    cell = at[chosen]
    better = judge.score(values[chosen]) > judge.score(draft.best.view(-1)[cell])
    better |= draft.best.view(-1)[cell].isnan()
    draft.best.view(-1)[cell[better]] = values[chosen][better]
    draft.configurations.view(-1, draft.chain.joints)[cell[better]] = q[chosen][better]
    return at


class _Cells:
    """Cells about positions, cubes, and about rotations."""

    def __init__(self, positions: Tensor, rotations: Tensor, size: tuple[float, float] | None) -> None:
        self.size = _cell_size(positions, rotations) if size is None else _given(size)
        self._rotations = len(rotations)
        self._near_position = cKDTree(positions.numpy())
        self._near_rotation = cKDTree(rotations.flatten(1).numpy())

    def of(self, T: Tensor) -> tuple[Tensor, Tensor]:
        """Return numbers (k) of the cells of poses, and whether they are in any."""
        # Cubes and no balls, so that cells of a regular grid leave no gaps.
        away, position = self._near_position.query(T[:, :3, 3].numpy(), p=math.inf)
        chord, rotation = self._near_rotation.query(T[:, :3, :3].flatten(1).numpy())
        side, angle = self.size
        inside = torch.as_tensor(away <= side) & torch.as_tensor(
            chord <= 2 * math.sqrt(2) * math.sin(min(angle, math.pi) / 2)
        )
        return torch.as_tensor(position * self._rotations + rotation), inside


def _given(size: tuple[float, float]) -> tuple[float, float]:
    side, angle = size
    return checks.positive(side, "cell"), checks.real(angle, "cell", above=0.0, most=math.pi)


def _cell_size(positions: Tensor, rotations: Tensor) -> tuple[float, float]:
    for values, name in ((positions, "positions"), (rotations, "rotations")):
        if len(values) < 2:
            raise ValueError(f"{name} holds one; a sampling needs its cell, such as cell=(0.05, 0.3)")
    distance, _ = cKDTree(positions.numpy()).query(positions.numpy(), k=2, p=math.inf)
    side = float(distance[:, 1].min()) / 2
    if side == 0:
        raise ValueError("positions holds one twice; a sampling needs different ones, or its cell")
    angle = covering_radius(rotations)
    if angle < math.pi / 2:
        return side, angle
    # Too few to cover all rotations: cells as wide as the gap to the nearest other one.
    chord, _ = cKDTree(rotations.flatten(1).numpy()).query(rotations.flatten(1).numpy(), k=2)
    return side, 2 * math.asin(min(1.0, float(chord[:, 1].min()) / (2 * math.sqrt(2)))) / 2
