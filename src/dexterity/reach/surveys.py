"""Survey of positions and rotations: which poses a chain reaches, by closed form, by search or by sampling.

The closed form finds all configurations of a pose. A search descends from independent starts at each pose,
then tries poses that were not found again from the configurations of their neighbours, and looks at a sample
of the rest with four times as many starts, which gives the bound of what was missed. A sampling draws
configurations and says which cells of the grid they fall into.

Examples
--------
>>> import dexterity as dx
>>> from dexterity import reach
>>> grid = reach.box([0.3, 0.0, 0.2], [0.6, 0.0, 0.5], spacing=0.1)
>>> surveyed = reach.survey(dx.robots.panda(), grid, reach.rotations(24)[:4], index="kci", starts=4)
>>> surveyed.method, int(surveyed.examined.sum()), surveyed.missed.estimate
('search', 64, 0.0)
"""

from __future__ import annotations

from typing import Literal, TypeAlias, get_args

import torch
from torch import Tensor

from dexterity import checks, spatial
from dexterity.chain import Chain
from dexterity.descent import RowFrame, TwistRows
from dexterity.indices.rows import Rows, row_numbers
from dexterity.reach.configurations import ClosedForm, Search, finder
from dexterity.reach.draft import Draft
from dexterity.reach.improvement import improved
from dexterity.reach.judgement import IndexLike, Judge
from dexterity.reach.missed import Missed
from dexterity.reach.reach_map import ReachMap
from dexterity.reach.sampled import sampled
from dexterity.reach.work import Progress, counted, in_pieces
from dexterity.spatial import TensorLike
from dexterity.spatial.tolerances import LIMIT
from dexterity.spatial.values import on_cpu

__all__ = ["Method", "survey"]

Method: TypeAlias = Literal["auto", "closed form", "search", "sampling"]
"""How poses are looked at; ``"auto"`` takes the closed form where the chain has one, and else a search."""

_AT_ONCE = {"closed form": 4096, "search": 1024}

_COMPLETE = "closed form: all configurations of each pose are found"
_INTERRUPTED = (
    "the survey was interrupted; poses that were not looked at are neither reached nor out of reach"
)


def survey(
    chain: Chain,
    positions: TensorLike,
    rotations: TensorLike,
    *,
    index: IndexLike = None,
    method: Method = "auto",
    rows: Rows = "full",
    frame: RowFrame = "body",
    starts: int = 16,
    draws: int = 10**6,
    cell: tuple[float, float] | None = None,
    limit_tolerance: float = LIMIT,
    seed: int = 0,
    threads: int | None = None,
    progress: Progress = False,
    unfinished: ReachMap | None = None,
) -> ReachMap:
    """Look at every position with every rotation.

    Parameters
    ----------
    chain
        The chain, its limits ends included.
    positions
        (p, 3) positions of the tool in the chain's world frame [m], such as from :func:`dexterity.reach.box`.
    rotations
        (r, 3, 3) rotations of the tool, such as :func:`dexterity.reach.rotations` makes.
    index
        What configurations are valued by: an index, the name of one (in the geometric frame), a compiled
        index or another function of q; None to ask for reach alone.
    method
        ``"auto"``, ``"closed form"``, ``"search"`` or ``"sampling"``.
    rows
        Components of the tool's pose that must fit: ``"translational"`` for positions alone, ``("vx", "vy",
        "vz", "wx", "wy")`` to leave the turn about the z axis free. Only a search takes others than
        ``"full"``.
    frame
        Axes of the rows: ``"body"`` for those of the tool, ``"geometric"`` for those of the world.
    starts
        Descents for each pose, of a search.
    draws
        Configurations that a sampling draws.
    cell
        Half the side [m] of the cell about a position and half the width [rad] of that about a rotation,
        for a sampling; by default half the distance of the nearest two positions, and the covering radius of
        the rotations.
    limit_tolerance
        By how much [rad] or [m] a closed form may exceed a limit.
    seed
        Of what is drawn. The map does not depend on the number of threads.
    threads
        Pieces that are worked on at the same time; as many as there are processors by default.
    progress
        True for a bar with the remaining time, or a function of how many poses are done and of how many.
    unfinished
        A map of the same survey that was interrupted, to go on from.

    Returns
    -------
    The map. After Ctrl-C, the map of what was finished, with ``finished`` false.

    Raises
    ------
    ValueError
        If a shape does not fit, a rotation is none, the method does not serve the chain, a number is out
        of its range, or the unfinished map is of another survey.
    TypeError
        If an argument is of the wrong kind.
    """
    chain = checks.instance(chain, "chain", Chain)
    points, turns = _positions(positions), _rotations(rotations)
    checks.choice(method, "method", ("auto", "closed form", "search", "sampling"))
    checks.choice(frame, "frame", get_args(RowFrame))
    judge, chosen = Judge(chain, index), TwistRows(row_numbers(rows), frame)
    workers = checks.thread_count(threads, "threads")
    seed, draws = checks.seed(seed), checks.whole(draws, "draws", least=1)
    checks.OrNone(checks.Each(checks.Real(above=0)))(cell, "cell")
    checks.OrNone(checks.Instance(ReachMap))(unfinished, "unfinished")
    if method == "sampling":
        if unfinished is not None:
            raise ValueError("unfinished is given; a sampling cannot go on from a map, draw more instead")
        if chosen.numbers != tuple(range(6)):
            raise ValueError(f"rows is {rows!r}; a sampling has cells of all six rows")
        return sampled(chain, points, turns, judge, draws=draws, cell=cell, seed=seed, progress=progress)
    find = finder(
        chain, method, rows=chosen.numbers, frame=frame, starts=starts,
        limit_tolerance=limit_tolerance, seed=seed,
    )  # fmt: skip
    draft = _draft(find, judge, points, turns, unfinished)
    left = (~draft.examined).flatten().nonzero()[:, 0]
    with counted(progress, len(left), f"{chain.name}, {find.method}") as add:
        complete = in_pieces(
            left,
            lambda at: find(draft.poses(at)),
            lambda at, found: draft.record(at, found, judge),
            size=_AT_ONCE[find.method],
            threads=workers,
            add=add,
        )
    missed = Missed(0.0, 0.0, None, _COMPLETE)
    if isinstance(find, Search) and complete:
        missed = improved(draft, find, judge, threads=workers)
    if not complete:
        missed = Missed(0.0, None, None, _INTERRUPTED)
    return draft.finished(judge, find.method, chosen, missed)


def _draft(
    find: ClosedForm | Search, judge: Judge, positions: Tensor, rotations: Tensor, unfinished: ReachMap | None
) -> Draft:
    if unfinished is not None:
        pairs = (
            (unfinished.positions, positions), (unfinished.rotations, rotations),
            (unfinished.chain.screws, find.chain.screws), (unfinished.chain.home, find.chain.home),
            (unfinished.chain.lower, find.chain.lower), (unfinished.chain.upper, find.chain.upper),
        )  # fmt: skip
        alike = all(a.shape == b.shape and torch.equal(a, b) for a, b in pairs)
        if not alike or (unfinished.method, unfinished.index) != (find.method, judge.label):
            raise ValueError(
                f"unfinished is {unfinished!r} with the index {unfinished.index}; a map of the same chain, "
                "positions, rotations, method and index is needed"
            )
    return Draft(find.chain, positions, rotations, unfinished)


def _positions(positions: TensorLike) -> Tensor:
    points = on_cpu(positions, "positions")
    if points.ndim != 2 or points.shape[1] != 3 or not len(points):
        raise ValueError(f"positions has shape {tuple(points.shape)}; (p, 3) with p ≥ 1 is needed")
    return points.detach().clone()


def _rotations(rotations: TensorLike) -> Tensor:
    R = on_cpu(rotations, "rotations")
    if R.ndim != 3 or R.shape[1:] != (3, 3) or not len(R):
        raise ValueError(f"rotations has shape {tuple(R.shape)}; (r, 3, 3) with r ≥ 1 is needed")
    return spatial.require_rotation(R.detach(), "rotations").clone()
