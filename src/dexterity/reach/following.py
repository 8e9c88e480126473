"""Whether poses can be followed one after the other without a jump, and the best configurations on the way.

At each pose there are candidates. A closed form has all configurations with all their copies by full turns. A
search has those in which its starts end, and those to which the candidates of the pose before and of the pose
after lead: neighbours along the curves of configurations of a redundant arm. Dynamic programming then finds,
of all sequences of candidates whose joints move by no more than a step from pose to pose, the one with the
best worst index, and of those the shortest; or the one with the best mean.

Examples
--------
>>> import dexterity as dx
>>> from dexterity import reach
>>> ur, down = dx.robots.ur5e(), reach.pointing([0, 0, -1])
>>> seam = reach.seam([-0.25, 0.5, 0.1], [0.25, 0.5, 0.1], 12, down)
>>> path = reach.follow(ur, seam, 0.3, "kci")
>>> path.followed, path.complete, path.largest_step < 0.3
(True, True, True)
>>> reach.follow(ur, seam, 0.01).until
1

References
----------
Bellman (1957), Dynamic Programming; De Maeyer, Moyaers & Demeester (2017), Cartesian path planning for arc
welding robots: evaluation of the Descartes algorithm, for sequences of configurations along a seam.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from typing import Literal, NamedTuple, TypeAlias

import torch
from jaxtyping import Float64
from torch import Tensor

from dexterity import checks, spatial
from dexterity.chain import Chain
from dexterity.descent import RowFrame
from dexterity.indices.rows import Rows, row_numbers
from dexterity.inverse_kinematics.seeds import distinct
from dexterity.inverse_kinematics.turns import middle_of_limits
from dexterity.reach.configurations import ClosedForm, Found, Method, Search, finder
from dexterity.reach.judgement import IndexLike, Judge
from dexterity.reach.tool_poses import several_poses
from dexterity.spatial import TensorLike
from dexterity.spatial.tolerances import LIMIT
from dexterity.spatial.values import on_cpu

__all__ = ["By", "Follower", "Path", "follow"]

By: TypeAlias = Literal["worst", "mean"]
"""What values a list of poses, the worst of them or their mean."""

_APART, _SAME = 0.5, 1e-4  # [rad] or [m] between fresh starts of a search, and between candidates
_LARGEST = 1e300  # infinite indices count as much


class Followed(NamedTuple):
    """Configurations (k, n) and their index (k), NaN if there is none, and how many poses are followed."""

    values: Tensor
    q: Tensor
    until: int


@dataclass(frozen=True, eq=False)
class Path:
    """Configurations at poses that follow one another.

    Attributes
    ----------
    chain
        The chain.
    poses
        (k, 4, 4) poses of the tool.
    configurations
        (k, n) one configuration at each pose, [rad] or [m]; NaN if the poses cannot be followed. A joint that
        has room for it turns on from pose to pose, also over a full turn.
    values
        (k,) their index, 1 without one.
    until
        How many poses can be followed from the first one.
    complete
        Whether poses that are not followed cannot be; after a search for configurations they may be.
    """

    chain: Chain
    poses: Float64[Tensor, "k 4 4"]
    configurations: Float64[Tensor, "k n"]
    values: Float64[Tensor, " k"]
    until: int
    complete: bool

    @property
    def followed(self) -> bool:
        """Whether there is a configuration at each pose, within a step from the one before."""
        return self.until == len(self.poses)

    @property
    def largest_step(self) -> float:
        """Largest change of a joint from pose to pose, [rad] or [m]; 0 for one pose."""
        if len(self.poses) < 2:
            return 0.0
        return float(self.configurations.diff(dim=0).abs().max())

    def __repr__(self) -> str:
        said = f"largest step {self.largest_step:.3g}" if self.followed else f"followed to pose {self.until}"
        return f"Path({self.chain.name!r}, {len(self.poses)} poses, {said})"


def follow(
    chain: Chain,
    poses: TensorLike,
    largest_step: TensorLike,
    index: IndexLike = None,
    *,
    by: By = "worst",
    method: Method = "auto",
    rows: Rows = "full",
    frame: RowFrame = "body",
    starts: int = 16,
    limit_tolerance: float = LIMIT,
    seed: int = 0,
) -> Path:
    """Find the best configurations at poses in order, no joint of which moves far from pose to pose.

    Parameters
    ----------
    chain
        The chain, its limits ends included.
    poses
        (k, 4, 4) poses of the tool in the chain's world frame, in the order in which they are followed.
    largest_step
        How far a joint may move from pose to pose, [rad] or [m]: one number, or (n,).
    index
        What configurations are valued by, as for :func:`dexterity.reach.survey`. Without one, the joints
        move as little as they can, in sum.
    by
        ``"worst"`` or ``"mean"``.
    method, rows, frame, starts, limit_tolerance, seed
        How configurations are found, as for :func:`dexterity.reach.survey`.

    Returns
    -------
    The path; where poses cannot be followed, how far they can.

    Raises
    ------
    ValueError
        If a shape does not fit, a pose is not rigid, the method does not serve the chain, or a number is out
        of its range.
    TypeError
        If an argument is of the wrong kind.
    """
    chain = checks.instance(chain, "chain", Chain)
    T = several_poses(poses, "poses")
    find = finder(
        chain, method, rows=row_numbers(rows), frame=frame, starts=starts,
        limit_tolerance=limit_tolerance, seed=seed,
    )  # fmt: skip
    path = Follower(find, Judge(chain, index), largest_step, by)(T, find(T))
    return Path(chain, T, path.q, path.values, path.until, find.complete)


class Follower:
    """Finds the best sequence of configurations at poses in order.

    Parameters
    ----------
    find
        Finds configurations.
    judge
        Values them.
    largest_step
        How far a joint may move from pose to pose, [rad] or [m]: one number, or (n,).
    by
        ``"worst"`` or ``"mean"``.

    Raises
    ------
    ValueError
        If a step is not positive, or `by` is unknown.
    """

    def __init__(
        self, find: ClosedForm | Search, judge: Judge, largest_step: TensorLike, by: By = "worst"
    ) -> None:
        self.find, self.judge, self.by = find, judge, checks.choice(by, "by", ("worst", "mean"))
        step = on_cpu(largest_step, "largest_step").detach()
        joints = find.chain.joints
        if step.shape not in ((), (joints,)) or (step <= 0).any():
            raise ValueError(
                f"largest_step is {step.tolist()}; a positive number or {joints} of them, one for a joint, "
                "are needed"
            )
        self.step = step.expand(joints)

    def __call__(self, T: Tensor, found: Found, *, led: bool = True) -> Followed:
        """Look at rigid poses (k, 4, 4) with what was found there.

        Unless `led` is false, a search adds what the candidates of each pose lead to at its neighbours.
        """
        turns = _Turns(self.find, self.step, len(T))
        candidates = [q[ok] for q, ok in zip(found.q, found.allowed, strict=True)]
        if led and isinstance(self.find, Search):
            _lead(self.find, T, candidates)
        candidates = [turns.copies(q) for q in candidates]
        sizes = [len(q) for q in candidates]
        everything = torch.cat(candidates)[None]
        valued = self.judge.values(Found(everything, everything.new_ones(1, sum(sizes)).bool()))[0]
        scores = self.judge.score(valued).clamp(-_LARGEST, _LARGEST).split(sizes)
        steps = [turns.steps(a, b) for a, b in itertools.pairwise(candidates)]
        allowed = [(step <= self.step + LIMIT).all(-1) for step in steps]
        chosen, until = self._best(list(scores), allowed, [step.norm(dim=-1) for step in steps])
        if chosen is None:
            empty = torch.full((len(T), self.find.chain.joints), math.nan, dtype=torch.float64)
            return Followed(empty[:, 0].clone(), empty, until)
        picked = list(zip(chosen, candidates, valued.split(sizes), strict=True))
        q = turns.turned_on(torch.stack([candidate[at] for at, candidate, _ in picked]))
        return Followed(torch.stack([value[at] for at, _, value in picked]), q, until)

    def _best(
        self, scores: list[Tensor], allowed: list[Tensor], lengths: list[Tensor]
    ) -> tuple[list[int] | None, int]:
        """Numbers of the best candidates, None if a pose cannot be followed, and how many poses can be."""
        open_, shut = torch.tensor(0.0).double(), torch.tensor(-math.inf).double()
        free = [torch.where(ok, open_, shut) for ok in allowed]
        if self.by == "mean":
            return _swept(scores, free)[:2]
        worst = [torch.where(ok, math.inf, shut) for ok in allowed]
        _, until, bound = _swept(scores, worst, lowest=True)
        if until < len(scores):
            return None, until
        good = [torch.where(score >= bound, open_, shut) for score in scores]
        short = [torch.where(ok, -length, shut) for ok, length in zip(allowed, lengths, strict=True)]
        return _swept(good, short)[:2]


class _Turns:
    """Full turns of a chain's joints along some poses.

    A joint whose limits leave room for all steps and a turn more can start at a turn from which it never
    comes to an end, so that its full turns do not count; the copies of the other joints are candidates.
    """

    def __init__(self, find: ClosedForm | Search, step: Tensor, poses: int) -> None:
        self._chain = chain = find.chain
        wider = getattr(find, "limit_tolerance", LIMIT)
        self._lower, self._upper = chain.lower - wider, chain.upper + wider
        self._revolute = torch.tensor([kind == "revolute" for kind in chain.kinds])
        # From pose to pose such a joint takes the nearest copy, at most half a turn away.
        extent = (poses - 1) * step.clamp(max=math.pi)
        self.endless = self._revolute & (self._upper - self._lower >= extent + math.tau)

    def copies(self, q: Tensor) -> Tensor:
        """Return all copies (m, n) of configurations (c, n) that count."""
        for joint in (self._revolute & ~self.endless).nonzero()[:, 0].tolist():
            lower, upper = float(self._lower[joint]), float(self._upper[joint])
            turns = torch.arange(math.floor((upper - lower) / math.tau) + 1)
            moved = q[:, None].repeat(1, len(turns), 1)
            moved[..., joint] += math.tau * (torch.ceil((lower - q[:, joint, None]) / math.tau) + turns)
            q = moved[moved[..., joint] <= upper]
        return q

    def steps(self, a: Tensor, b: Tensor) -> Tensor:
        """Return how far joints move (a, b, n) from candidates (a, n) to others (b, n)."""
        apart = b - a[:, None]
        return torch.where(self.endless, spatial.wrap_to_pi(apart), apart).abs()

    def turned_on(self, q: Tensor) -> Tensor:
        """Return configurations (k, n) that turn on from pose to pose, within the limits."""
        steps = q.diff(dim=0)
        steps = torch.where(self.endless, spatial.wrap_to_pi(steps), steps)
        q = torch.cat([q[:1], q[:1] + steps.cumsum(0)])
        low, high = q.amin(0), q.amax(0)
        turns = torch.round((middle_of_limits(self._chain) - (low + high) / 2) / math.tau)
        # Beside a limit that stands alone, the middle may be too near to it.
        up = torch.ceil((self._lower - low) / math.tau - turns).clamp(min=0)
        down = torch.floor((self._upper - high) / math.tau - turns).clamp(max=0)
        return torch.where(self.endless, q + math.tau * (turns + up + down), q)


def _lead(search: Search, T: Tensor, candidates: list[Tensor]) -> None:
    """Add to the candidates of each pose what those of the pose before, then of the one after, lead to."""
    for i in range(1, len(T)):
        candidates[i] = _with_neighbours(search, T[i], candidates[i], candidates[i - 1], _APART)
    for i in reversed(range(len(T) - 1)):
        candidates[i] = _with_neighbours(search, T[i], candidates[i], candidates[i + 1], _SAME)


def _with_neighbours(search: Search, T: Tensor, own: Tensor, starts: Tensor, apart: float) -> Tensor:
    """Return configurations (c, n) at a pose to which neighbours lead, and its own that are apart."""
    if not len(starts):
        return own
    led = search.from_starts(T[None], starts[None])
    q = torch.cat([led.q[0][led.allowed[0]], own])[None]
    first, usable = int(led.allowed.sum()), torch.ones(q.shape[:2], dtype=torch.bool)
    kept = distinct(search.chain, q, usable, _SAME)[0]
    kept[first:] &= distinct(search.chain, q, usable, apart)[0][first:]
    return q[0][kept]


def _swept(
    nodes: list[Tensor], edges: list[Tensor], *, lowest: bool = False
) -> tuple[list[int] | None, int, float]:
    """Sequence of nodes with the largest sum, or largest lowest, of nodes and edges; −∞ shuts them.

    Returns
    -------
    The numbers of the nodes, or None; how many poses they get to; and the sum, or the lowest.
    """
    join = torch.minimum if lowest else torch.add
    best, came = nodes[0], []
    for i, edge in enumerate([*edges, None]):
        if not len(best) or best.amax() == -math.inf:
            return None, i, -math.inf
        if edge is not None:
            top, at = join(best[:, None], edge).max(0)
            best = join(top, nodes[i + 1])
            came.append(at)
    path = [int(best.argmax())]
    for at in reversed(came):
        path.append(int(at[path[-1]]))
    return path[::-1], len(nodes), float(best.amax())
