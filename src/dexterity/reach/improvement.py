"""Second look of a search: from neighbours of what it found, and with more starts at a sample of the rest.

Examples
--------
>>> import torch
>>> import dexterity as dx
>>> from dexterity.reach.configurations import Search
>>> from dexterity.reach.draft import Draft
>>> from dexterity.reach.improvement import improved
>>> from dexterity.reach.judgement import Judge
>>> arm, far = dx.robots.ur5e(), torch.tensor([[0.4, 0.1, 0.4], [3.0, 0.0, 0.0]], dtype=torch.float64)
>>> draft, find, judge = Draft(arm, far, torch.eye(3).double()[None]), Search(arm, starts=4), Judge(arm, None)
>>> at = torch.arange(2)
>>> draft.record(at, find(draft.poses(at)), judge)
1
>>> improved(draft, find, judge).estimate
0.0
"""

from __future__ import annotations

import torch
from scipy.spatial import cKDTree
from torch import Tensor

from dexterity.reach.configurations import Search
from dexterity.reach.draft import Draft
from dexterity.reach.judgement import Judge
from dexterity.reach.missed import CONFIDENCE, Missed, largest_share, unseen
from dexterity.reach.work import in_pieces

__all__ = ["improved"]

_NEIGHBOURS = 6
_SEEDS = 3
_ROUNDS = 4
_SAMPLE = 2000
_MORE = 4


def improved(draft: Draft, find: Search, judge: Judge, *, threads: int = 1) -> Missed:
    """Look again at the poses that a search did not find, and say what may be missed still.

    Parameters
    ----------
    draft
        A map whose poses have all been looked at once; it is added to.
    find
        The search that looked.
    judge
        Chooses the best configuration.
    threads
        Pieces that are worked on at the same time.
    """
    by_starts = unseen(draft.hits.numpy()) * (find.starts - 1) / find.starts
    if not _from_neighbours(draft, find, judge, threads):
        return _INTERRUPTED
    open_poses = (draft.examined & ~draft.reached).flatten().nonzero()[:, 0]
    generator = torch.Generator().manual_seed(find.seed)
    sample = open_poses[torch.randperm(len(open_poses), generator=generator)[:_SAMPLE]]
    numbers, frame = find.rows.numbers, find.rows.frame
    stronger = Search(find.chain, _MORE * find.starts, numbers, find.samples, find.seed + 1, frame)
    before = int(draft.reached.sum())
    complete = in_pieces(
        sample,
        lambda at: stronger(draft.poses(at)),
        lambda at, found: draft.record(at, found, judge, independent=False),
        size=256,
        threads=threads,
    )
    found = int(draft.reached.sum()) - before
    if not complete or (found and not _from_neighbours(draft, find, judge, threads)):
        return _INTERRUPTED
    later = int((draft.reached & (draft.hits == 0)).sum())
    upper = max(0.0, len(open_poses) * largest_share(found, len(sample)) - found) if len(sample) else 0.0
    expected = found * (len(open_poses) - len(sample)) / max(1, len(sample))
    return Missed(
        max(expected, by_starts - later, 0.0),
        upper,
        None,
        f"search: {found} of {len(sample)} unreached poses, drawn at random, were reached with "
        f"{stronger.starts} instead of {find.starts} starts; with "
        f"{100 * CONFIDENCE:.0f} % confidence at most {upper:.0f} more of {len(open_poses)} would be. Starts "
        f"that met a pose once and twice suggest {by_starts:.1f} unseen, and {later} were found later.",
    )


_INTERRUPTED = Missed(0.0, None, None, "search: interrupted before what was missed could be estimated")


def _from_neighbours(draft: Draft, find: Search, judge: Judge, threads: int) -> bool:
    """Descend to unreached poses from configurations of neighbours, until that finds no more."""
    near = [_nearest(points) for points in (draft.positions, draft.rotations.flatten(1))]
    for _ in range(_ROUNDS):
        before = int(draft.reached.sum())
        if not _descend(draft, find, *_starts(draft, *near), judge, threads):
            return False
        if int(draft.reached.sum()) == before:
            break
    return True


def _descend(draft: Draft, find: Search, at: Tensor, starts: Tensor, judge: Judge, threads: int) -> bool:
    return in_pieces(
        torch.arange(len(at)),
        lambda some: find.from_starts(draft.poses(at[some]), starts[some]),
        lambda some, found: draft.record(at[some], found, judge, independent=False),
        size=4096,
        threads=threads,
    )


def _nearest(points: Tensor) -> Tensor:
    """Return the numbers (k, m) of the points nearest to each of k, itself left out."""
    count = min(_NEIGHBOURS + 1, len(points))
    _, nearest = cKDTree(points.numpy()).query(points.numpy(), k=count)
    return torch.as_tensor(nearest).reshape(len(points), -1)[:, 1:]


def _starts(draft: Draft, positions: Tensor, rotations: Tensor) -> tuple[Tensor, Tensor]:
    """Unreached poses (k) with reached neighbours, and configurations (k, b, n) of these."""
    open_poses = draft.examined & ~draft.reached
    where = open_poses.nonzero()
    i, j = where[:, 0], where[:, 1]
    # Neighbours in position with the same rotation, and in rotation at the same position.
    there_i = torch.cat([positions[i], i[:, None].expand(-1, rotations.shape[1])], 1)
    there_j = torch.cat([j[:, None].expand(-1, positions.shape[1]), rotations[j]], 1)
    reached = draft.reached[there_i, there_j]
    has_some = reached.any(1)
    order = (~reached).long().argsort(dim=1, stable=True)[has_some, :_SEEDS]
    rows = torch.arange(len(order))[:, None]
    there_i, there_j, reached = there_i[has_some], there_j[has_some], reached[has_some]
    # Where there are fewer, the first stands in for the others.
    order = torch.where(reached[rows, order], order, order[:, :1])
    at = (i * len(draft.rotations) + j)[has_some]
    return at, draft.configurations[there_i[rows, order], there_j[rows, order]]
