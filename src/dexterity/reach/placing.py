"""Where the base of a chain should be, so that its tool reaches a list of poses with a good index.

Each base is valued by its worst pose, or by the mean over its poses; at a pose the best configuration counts.
The best base is then improved between the candidates.

Examples
--------
>>> import math
>>> import dexterity as dx
>>> from dexterity import reach
>>> seam = reach.seam([-0.25, 0, 0], [0.25, 0, 0], 5, reach.pointing([0, 0, -1]))
>>> bases = reach.planar_bases([-0.2, 0, 0.2], [-0.7, -0.5], [0, math.pi / 2])
>>> placed = reach.place(dx.robots.ur5e(), seam, bases, "kci", refine=False)
>>> placed.best.coordinates[:2].tolist(), bool(placed.best.score > 0.1)
([0.0, -0.5], True)
"""

from __future__ import annotations

import math

import torch
from torch import Tensor

from dexterity import checks, spatial
from dexterity.chain import Chain
from dexterity.descent import RowFrame
from dexterity.indices.rows import Rows, row_numbers
from dexterity.reach.configurations import ClosedForm, Found, Method, Search, finder
from dexterity.reach.following import By, Follower
from dexterity.reach.judgement import IndexLike, Judge
from dexterity.reach.placements import Placements, Valued
from dexterity.reach.refinement import refined
from dexterity.reach.tool_poses import several_poses
from dexterity.reach.work import Progress, counted, in_pieces
from dexterity.spatial import TensorLike
from dexterity.spatial.tolerances import LIMIT
from dexterity.spatial.values import on_cpu

__all__ = ["place"]

_POSES_AT_ONCE = 1024


def place(
    chain: Chain,
    poses: TensorLike,
    bases: TensorLike,
    index: IndexLike = "kinematic_conditioning",
    *,
    by: By = "worst",
    largest_step: TensorLike | None = None,
    method: Method = "auto",
    rows: Rows = "full",
    frame: RowFrame = "body",
    starts: int = 16,
    limit_tolerance: float = LIMIT,
    refine: bool = True,
    seed: int = 0,
    threads: int | None = None,
    progress: Progress = False,
) -> Placements:
    """Compare bases by what the chain does from there at all poses, and improve the best.

    Parameters
    ----------
    chain
        The chain; its world frame is what is placed.
    poses
        (k, 4, 4) poses of the tool in the world, such as :func:`dexterity.reach.seam` makes.
    bases
        (b, 4, 4) candidate poses of the chain's world frame in the world, or (b, 3) rows x, y [m], yaw [rad]
        on the floor.
    index
        What configurations are valued by, as for :func:`dexterity.reach.survey`.
    by
        ``"worst"`` or ``"mean"``.
    largest_step
        How far a joint may move from pose to pose, [rad] or [m], one number or (n,): the poses are then
        followed in their order, as by :func:`dexterity.reach.follow`, and a base from which they cannot be
        is none. By default each pose has its best configuration, whatever the others have.
    method, rows, frame, starts, limit_tolerance, seed
        How configurations are found, as for :func:`dexterity.reach.survey`.
    refine
        Whether to improve the best base, in the coordinates that differ between the candidates and within
        their range.
    threads, progress
        As for :func:`dexterity.reach.survey`; what is counted is bases.

    Returns
    -------
    The bases compared. After Ctrl-C, those that were looked at.

    Raises
    ------
    ValueError
        If a shape does not fit, a pose is not rigid, the method does not serve the chain, or a number is out
        of its range.
    TypeError
        If an argument is of the wrong kind.
    """
    chain = checks.instance(chain, "chain", Chain)
    T, candidates = several_poses(poses, "poses"), _bases(bases)
    by_name = checks.choice(by, "by", ("worst", "mean"))
    judge, workers = Judge(chain, index), checks.thread_count(threads, "threads")
    find = finder(
        chain, method, rows=row_numbers(rows), frame=frame, starts=starts,
        limit_tolerance=limit_tolerance, seed=seed,
    )  # fmt: skip
    follower = None if largest_step is None else Follower(find, judge, largest_step, by)
    value = _Valuer(find, judge, T, follower)
    values = torch.full((len(candidates), len(T)), math.nan, dtype=torch.float64)
    q = torch.full((*values.shape, chain.joints), math.nan, dtype=torch.float64)
    examined, followed = torch.zeros(2, len(candidates), dtype=torch.bool)

    def keep(at: Tensor, found: Valued) -> None:
        values[at], q[at], followed[at] = found
        examined[at] = True

    with counted(progress, len(candidates), f"{chain.name}, {find.method}") as add:
        finished = in_pieces(
            torch.arange(len(candidates)),
            lambda at: value(candidates[at]),
            keep,
            size=max(1, _POSES_AT_ONCE // len(T)),
            threads=workers,
            add=add,
        )
    placed = Placements(
        chain, T, candidates, values, q, examined, by_name, judge.label, judge.larger_is_better,
        find.complete, followed if follower else None,
    )  # fmt: skip
    if checks.flag(refine, "refine") and finished and placed.ties:
        return refined(placed, value, seed)
    return placed


def _bases(bases: TensorLike) -> Tensor:
    values = on_cpu(bases, "bases")
    if values.ndim == 2 and values.shape[1] == 3 and len(values):
        T = torch.eye(4, dtype=torch.float64).repeat(len(values), 1, 1)
        cosine, sine = values[:, 2].cos(), values[:, 2].sin()
        T[:, 0, 0], T[:, 0, 1], T[:, 1, 0], T[:, 1, 1] = cosine, -sine, sine, cosine
        T[:, :2, 3] = values[:, :2]
        return T
    return several_poses(values, "bases")


class _Valuer:
    """Values bases: the best index and its configuration at each pose, or those of the best path."""

    def __init__(
        self, find: ClosedForm | Search, judge: Judge, poses: Tensor, follower: Follower | None
    ) -> None:
        self.find, self.judge, self.poses, self.follower = find, judge, poses, follower

    def __call__(self, bases: Tensor, near: Tensor | None = None) -> Valued:
        """Value bases (b, 4, 4); a search starts from configurations (k, n) at a base near by, if any."""
        T = spatial.inverse(bases)[:, None] @ self.poses
        if near is None or isinstance(self.find, ClosedForm):
            found = self.find(T.flatten(0, 1))
        else:
            found = self.find.from_starts(T.flatten(0, 1), near.repeat(len(bases), 1)[:, None])
        best, configurations = self.judge.best(found)
        values, q = best.reshape(T.shape[:2]), configurations.reshape(*T.shape[:2], -1)
        followed = torch.ones(len(bases), dtype=torch.bool)
        if self.follower is not None:
            parts = (x.reshape(*T.shape[:2], *x.shape[1:]) for x in found)
            for i, (poses, *candidates) in enumerate(zip(T, *parts, strict=True)):
                path = self.follower(poses, Found(*candidates), led=near is None)
                followed[i] = path.until == len(poses)
                if followed[i]:
                    values[i], q[i] = path.values, path.q
        return Valued(values, q, followed)
