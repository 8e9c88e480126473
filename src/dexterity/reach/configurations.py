"""Configurations of a chain at poses, found in closed form or by search.

The closed form finds all of them. A search descends from several starts at each pose. The starts are the
nearest ones of as many independent sets of configurations within the limits, so that how often a pose was
found says how many were missed.

Examples
--------
>>> import dexterity as dx
>>> from dexterity.reach.configurations import finder
>>> puma = dx.robots.puma560()
>>> find = finder(puma)
>>> find.method, find.complete
('closed form', True)
>>> found = find(puma.forward([[0.0, 0.5, 0.25, 0.0, 0.5, 0.0]]))
>>> found.q.shape, int(found.allowed.sum())
(torch.Size([1, 8, 6]), 5)
"""

from __future__ import annotations

import math
import threading
from collections.abc import Sequence
from functools import cached_property
from typing import Literal, NamedTuple, TypeAlias, get_args

import numpy as np
import torch
from scipy.spatial import cKDTree
from torch import Tensor

from dexterity import checks, sobol
from dexterity.chain import Chain
from dexterity.descent import RowFrame, TwistRows, descend
from dexterity.inverse_kinematics import closed_form, solve
from dexterity.inverse_kinematics.seeds import pose_features
from dexterity.spatial.tolerances import LIMIT

__all__ = ["ClosedForm", "Found", "Method", "Search", "different", "drawn_range", "finder"]

Method: TypeAlias = Literal["auto", "closed form", "search"]
"""How configurations are found; ``"auto"`` takes the closed form where the chain has one."""

_ARRIVED = 1e-9
_DIFFERENT = 1e-4  # [rad] or [m], to which the search finds joint values even near a singularity


class Found(NamedTuple):
    """Configurations at k poses.

    Attributes
    ----------
    q
        (k, b, n) joint values [rad] or [m].
    allowed
        (k, b) whether they put the tool at the pose, within the limits.
    """

    q: Tensor
    allowed: Tensor


class ClosedForm:
    """All configurations of a chain that has a closed form.

    Parameters
    ----------
    chain
        The chain.
    limit_tolerance
        By how much [rad] or [m] a limit may be exceeded.

    Raises
    ------
    ValueError
        If the chain has no closed form.
    """

    method, complete = "closed form", True

    def __init__(self, chain: Chain, limit_tolerance: float = LIMIT) -> None:
        self.chain, self.limit_tolerance = chain, limit_tolerance
        if closed_form(chain) is None or (chain.rates == 0).any():
            raise ValueError(
                f"method is 'closed form', which {chain.name} has none of; 'search' takes any chain"
            )

    def __call__(self, T_world_tool: Tensor) -> Found:
        """Look at rigid poses (k, 4, 4)."""
        found = solve(self.chain, T_world_tool, method="closed form", limit_tolerance=self.limit_tolerance)
        return Found(found.q, found.valid & found.within_limits)


class Search:
    """Configurations that descents from several starts at each pose end in.

    Parameters
    ----------
    chain
        A chain whose prismatic joints have limits. A joint whose rate is zero is locked at zero.
    starts
        Descents for each pose.
    rows, frame
        Which components of the tool's pose must fit, and their axes, as for
        :func:`dexterity.descent.descend`; all six by default.
    samples
        Configurations that the starts are chosen from, for all starts together.
    seed
        Of the drawn configurations.

    Raises
    ------
    ValueError
        If a prismatic joint has no limits, or a number is out of its range.
    """

    method, complete = "search", False

    def __init__(
        self,
        chain: Chain,
        starts: int = 16,
        rows: Sequence[int] = range(6),
        samples: int = 2**17,
        seed: int = 0,
        frame: RowFrame = "body",
    ) -> None:
        self.chain, self.rows = _held(chain), TwistRows(tuple(rows), frame)
        self.starts = checks.whole(starts, "starts", least=1, most=10_000)
        self.samples = checks.whole(samples, "samples", least=1)
        self.seed = checks.whole(seed, "seed", least=0)
        self._lower, self._width = drawn_range(chain)
        self._lock = threading.Lock()

    @cached_property
    @torch.inference_mode(False)  # kept for later calls in every mode
    def _library(self) -> list[tuple[Tensor, cKDTree]]:
        """Configurations of each set, and their poses as points of a tree."""
        size, sets = max(1, self.samples // self.starts), []
        for i in range(self.starts):
            # Each set with a scrambling of its own, so that they are independent.
            seed = (self.seed * 10_007 + i) % 2**31
            q = self._lower + self._width * sobol.points(self.chain.joints, size, seed)
            sets.append((q, cKDTree(self._features(self.chain.forward(q)))))
        return sets

    def _features(self, T: Tensor) -> np.ndarray:
        """Points (k, f) of a tree for poses; all in one place where no number tells poses apart."""
        features = pose_features(self.chain, T, self.rows).numpy()
        return features if features.shape[1] else np.zeros((len(T), 1))

    def __call__(self, T_world_tool: Tensor) -> Found:
        """Look at rigid poses (k, 4, 4), one start of each set for each."""
        # Built by the first of all threads that get here.
        with self._lock:
            library = self._library
        features = self._features(T_world_tool)
        nearest = [q[torch.from_numpy(tree.query(features)[1])] for q, tree in library]
        return self.from_starts(T_world_tool, torch.stack(nearest, 1))

    def from_starts(self, T_world_tool: Tensor, starts: Tensor) -> Found:
        """Look at poses (k, 4, 4) from starts (k, b, n), such as the configurations of their neighbours."""
        count, b, joints = starts.shape
        T = T_world_tool[:, None].expand(count, b, 4, 4).reshape(-1, 4, 4)
        q, miss = descend(
            self.chain, T, starts.reshape(-1, joints), rows=self.rows.numbers, frame=self.rows.frame
        )
        return Found(q.reshape(starts.shape), (miss < _ARRIVED).reshape(count, b))


def finder(
    chain: Chain, method: Method = "auto", *, rows: Sequence[int] = range(6), frame: RowFrame = "body",
    starts: int = 16, limit_tolerance: float = LIMIT, seed: int = 0,
) -> ClosedForm | Search:  # fmt: skip
    """Return what finds the configurations of a chain.

    Parameters
    ----------
    chain
        The chain.
    method
        ``"closed form"``, ``"search"``, or ``"auto"`` for the first of them that serves.
    rows
        Which components of the tool's pose must fit; a closed form has all six.
    frame
        Axes of the rows, ``"body"`` for those of the tool or ``"geometric"`` for those of the world.
    starts
        Descents for each pose, of a search.
    limit_tolerance
        By how much [rad] or [m] a closed form may exceed a limit. A search stays within the limits.
    seed
        Of the starts.

    Raises
    ------
    ValueError
        If the method is unknown or does not serve the chain and the rows, or a number is out of its range.
    """
    checks.choice(method, "method", get_args(Method))
    checks.choice(frame, "frame", get_args(RowFrame))
    tolerance = checks.real(limit_tolerance, "limit_tolerance", least=0.0)
    chosen = tuple(rows)
    whole = chosen == tuple(range(6))
    if method == "closed form" and not whole:
        raise ValueError(f"rows is {chosen}; a closed form has all six, method='search' takes any")
    has_form = closed_form(chain) is not None and bool((chain.rates > 0).all())
    if method == "closed form" or (method == "auto" and whole and has_form):
        return ClosedForm(chain, tolerance)
    return Search(chain, starts, chosen, seed=seed, frame=frame)


def different(chain: Chain, found: Found) -> Tensor:
    """Return which allowed configurations (k, b) are not copies of one before, full turns apart or not."""
    q, allowed = found
    apart = q[:, :, None] - q[:, None]
    revolute = torch.tensor([kind == "revolute" for kind in chain.kinds])
    turns = torch.where(revolute, math.tau * torch.round(apart / math.tau), 0.0)
    same = ((apart - turns).abs() < _DIFFERENT).all(-1) & allowed[:, None]
    before = torch.ones(q.shape[1], q.shape[1], dtype=torch.bool).tril(-1)
    return allowed & ~(same & before).any(-1)


def _held(chain: Chain) -> Chain:
    """Return a chain whose limits hold its locked joints."""
    locked = chain.rates == 0
    if not locked.any():
        return chain
    lower, upper = (torch.where(locked, 0.0, limit) for limit in (chain.lower, chain.upper))
    return chain.with_limits(lower=lower, upper=upper)


def drawn_range(chain: Chain) -> tuple[Tensor, Tensor]:
    """Return lower ends and widths (n) of where joint values are drawn, at most a full turn of an angle."""
    lower, upper = chain.lower, chain.upper
    for i, kind in enumerate(chain.kinds):
        if kind == "prismatic" and math.isinf(upper[i] - lower[i]):
            raise ValueError(
                f"chain moves {chain.joint_names[i]} without limits; a search needs those of prismatic joints"
            )
    revolute = torch.tensor([kind == "revolute" for kind in chain.kinds])
    low = torch.where(lower.isinf(), torch.where(upper.isinf(), -math.pi, upper - math.tau), lower)
    high = torch.where(upper.isinf(), low + math.tau, upper)
    # Copies a full turn apart are one configuration, and need no draws.
    return low, torch.where(revolute, (high - low).clamp(max=math.tau), high - low)
