"""What inverse kinematics found at poses, how, and how sure that is.

Examples
--------
>>> import dexterity as dx
>>> ur = dx.robots.load("ur5e")
>>> found = dx.inverse_kinematics.solve(ur, ur.forward([0.3, -1.0, 1.2, -0.5, 0.8, 0.2]))
>>> found.method, found.complete, int(found.count)
('three parallel axes', True, 8)
>>> found
Solutions(1 pose by three parallel axes (complete): 1 reached within the limits)
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import torch
from jaxtyping import Bool, Float64, Int64
from torch import Tensor

from dexterity import spatial
from dexterity.chain import Chain
from dexterity.inverse_kinematics.slices import Locked
from dexterity.inverse_kinematics.turns import copies_within_limits, nearest_copy
from dexterity.spatial import TensorLike
from dexterity.spatial.tolerances import LIMIT
from dexterity.spatial.values import beside

__all__ = ["SeedsEnded", "Solutions"]


@dataclass(frozen=True)
class SeedsEnded:
    """How many seeds of a search were tried at each pose (...), and where they ended.

    Attributes
    ----------
    tried
        Seeds from which a descent started.
    converged
        Those that reached the pose.
    at_limits
        Those that ended away from the pose with a joint at a limit.
    stuck
        Those that ended away from the pose with no joint at a limit, at a local minimum or out of steps.
    """

    tried: Int64[Tensor, "*batch"]
    converged: Int64[Tensor, "*batch"]
    at_limits: Int64[Tensor, "*batch"]
    stuck: Int64[Tensor, "*batch"]


@dataclass(frozen=True, repr=False)
class Solutions:
    """Configurations of a chain at poses, the best first.

    First come those that are valid and within the limits; among them those near to a seed if there is one,
    then those with a large secondary value if there is one, then those near the middle of the limits.

    Attributes
    ----------
    chain
        The chain.
    q
        (..., k, n) joint values, [rad] or [m], the copy nearest to the seed or to the middle of the limits.
        All are finite; k is 8 for a closed form, else the largest number found at a pose.
    valid
        (..., k) whether they put the tool at the pose; the rest fills up the array or came no nearer.
    within_limits
        (..., k) whether all joints are within their limits, ends included.
    residual
        (..., k) how far the tool is from the pose: the larger of radians and metres, the latter relative to
        the size of the arm.
    method
        ``"spherical wrist"``, ``"three parallel axes"``, ``"spherical shoulder"`` or ``"search"``.
    complete
        Whether the method finds every configuration up to full turns and joints that may have any value.
        Where it is True and nothing is valid, the pose is out of reach; after a search, nothing is said.
    locked
        Values of joints that were locked, by name: all configurations with these values are found, and no
        others. None without locked joints.
    miss
        By how much the chain's description misses the conditions of the closed form; 0 for a search.
    seeds
        Where the seeds of a search ended; None for a closed form.
    limit_tolerance
        By how much limits could be exceeded.
    """

    chain: Chain
    q: Float64[Tensor, "*batch k n"]
    valid: Bool[Tensor, "*batch k"]
    within_limits: Bool[Tensor, "*batch k"]
    residual: Float64[Tensor, "*batch k"]
    method: str
    complete: bool
    miss: float = 0.0
    locked: Locked | None = None
    seeds: SeedsEnded | None = None
    limit_tolerance: float = field(default=LIMIT)

    @property
    def usable(self) -> Bool[Tensor, "*batch k"]:
        """Which configurations are valid and within the limits."""
        return self.valid & self.within_limits

    @property
    def count(self) -> Int64[Tensor, "*batch"]:
        """How many configurations at each pose are valid and within the limits."""
        return self.usable.sum(-1)

    @property
    def reached(self) -> Bool[Tensor, "*batch"]:
        """At which poses at least one configuration is valid and within the limits."""
        return self.usable.any(-1)

    def nearest(
        self, q: TensorLike, weights: TensorLike | None = None
    ) -> tuple[Float64[Tensor, "*batch n"], Bool[Tensor, "*batch"]]:
        """Return the configuration and copy nearest to joint values, such as where the robot is.

        Parameters
        ----------
        q
            (..., n) joint values.
        weights
            (n,) weights of the squared differences of the joints, not negative; 1 by default, which adds
            radians to metres.

        Returns
        -------
        Joint values (..., n) with the smallest Euclidean distance among those that are valid and within the
        limits, and whether there are any; without any, the nearest of all.

        Raises
        ------
        ValueError
            If `q` or `weights` does not fit.
        """
        seed = spatial.require_joints(beside(q, "q", self.q), self.chain.joints, "chain")
        moved, within = nearest_copy(self.chain, self.q, seed[..., None, :], self.limit_tolerance)
        usable = self.valid & within
        distance = ((moved - seed[..., None, :]) * self._scales(weights)).norm(dim=-1)
        distance = torch.where(usable | ~usable.any(-1, keepdim=True), distance, torch.inf)
        best = distance.argmin(-1)[..., None, None]
        return torch.take_along_dim(moved, best, dim=-2)[..., 0, :], usable.any(-1)

    def _scales(self, weights: TensorLike | None) -> Tensor:
        """Roots (n) of the weights of joints."""
        if weights is None:
            return self.q.new_ones(self.chain.joints)
        values = beside(weights, "weights", self.q)
        if values.shape != (self.chain.joints,) or (values < 0).any():
            raise ValueError(
                f"weights is {values.tolist()}; {self.chain.joints} numbers that are not negative are needed"
            )
        return values.sqrt()

    def copies(self) -> Float64[Tensor, "copies n"]:
        """Return every configuration at one pose with all its copies by full turns within the limits.

        Returns
        -------
        (copies, n), those of the best solution first; see
        :func:`dexterity.inverse_kinematics.copies_within_limits`.

        Raises
        ------
        ValueError
            If there are several poses, a joint has one limit alone, or there are more than a million copies.
        """
        if self.q.ndim != 2:
            raise ValueError(
                f"solutions are those of poses {tuple(self.q.shape[:-2])}; those of one are needed"
            )
        each = [copies_within_limits(self.chain, q, self.limit_tolerance) for q in self.q[self.usable]]
        return torch.cat([*each, self.q.new_zeros(0, self.chain.joints)])

    def __repr__(self) -> str:
        poses = self.reached.numel()
        complete = "complete" if self.complete else "not complete"
        how = f"{self.method} ({complete})"
        if self.locked is not None:
            count = math.prod(len(values) for values in self.locked.values())
            how = f"{self.method}, {' and '.join(self.locked)} locked (complete at {count} values)"
        return (
            f"Solutions({poses} {'pose' if poses == 1 else 'poses'} by {how}: "
            f"{int(self.reached.sum())} reached within the limits)"
        )
