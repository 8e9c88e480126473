"""What a task asks for, computed directly, and what it costs to let an index choose.

All goals are costs, of which less is better: an error, or the reciprocal of a torque or of a speed. None of them needs an
index. They are slower than an index, since each solves an optimisation or draws many errors, and serve to judge it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import torch
from scipy.optimize import linprog
from scipy.stats import kendalltau, qmc
from torch import Tensor

from dexterity.chain import Chain


@dataclass(frozen=True)
class Effect:
    """What it costs to choose the candidate that an index prefers.

    Attributes
    ----------
    tau
        Kendall's τ between the ranking by the index and that by the goal; not a number if all costs are equal.
    loss
        Cost of the candidate that the index prefers, over the least cost of all.
    beaten
        Share of the candidates that cost less than it.
    """

    tau: float
    loss: float
    beaten: float


def effect(score: Tensor, cost: Tensor) -> Effect:
    """Judge a ranking by scores (m,), of which more is better, against the costs (m,) of the candidates.

    Costs that differ by rounding alone are equal.

    Raises
    ------
    ValueError
        If the shapes differ, or a cost is not positive.
    """
    if score.shape != cost.shape or score.ndim != 1:
        raise ValueError(f"score has shape {tuple(score.shape)}, cost {tuple(cost.shape)}; (m,) is needed")
    if not (cost > 0).all():
        raise ValueError("cost holds a number that is not positive")
    relative = (cost / cost.min()).round(decimals=9)
    chosen = relative[score.argmax()]
    tau = kendalltau(score.numpy(), -relative.numpy()).statistic
    return Effect(float(tau), float(chosen), float((relative < chosen).double().mean()))


def effort_per_force(J: Tensor, row: int) -> Tensor:
    """Return the largest joint effort (m,) that a unit force or torque along one row of J (m, 6, n) asks for.

    Its reciprocal is the largest force, or torque, while no joint gives more than a unit effort.
    """
    return J[:, row].abs().amax(-1)


def time_per_metre(J: Tensor, row: int) -> Tensor:
    """Return the shortest time (m,) for a unit of way along one row of J (m, 6, n), while nothing else moves.

    No joint is faster than a unit rate. The rate of the tool is the solution of a linear program; a direction in which the
    tool cannot move takes for ever.
    """
    along = np.zeros((6, 1))
    along[row] = -1.0
    bounds = [(-1.0, 1.0)] * J.shape[-1] + [(0.0, None)]
    objective = [0.0] * J.shape[-1] + [-1.0]
    speeds = [
        abs(linprog(objective, A_eq=np.hstack([one, along]), b_eq=np.zeros(6), bounds=bounds).fun)
        for one in J.numpy()
    ]
    return 1 / torch.tensor(speeds, dtype=torch.float64)


def root_mean_square_miss(chain: Chain, q: Tensor, noise: Tensor, seed: int, draws: int) -> Tensor:
    """Return how far (m,) the tool point misses its place, as the root mean square over many joint errors [m].

    The errors are normal with the standard deviations `noise` (n,), from a scrambled Sobol' sequence of `draws` points, a
    power of two, and the same for every configuration (m, n). They pass through the forward kinematics, without any
    Jacobian.
    """
    normal = qmc.MultivariateNormalQMC(np.zeros(chain.joints), rng=np.random.default_rng(seed)).random(draws)
    errors = noise * torch.as_tensor(normal)[:, None]
    missed = (chain.forward(q + errors) - chain.forward(q))[..., :3, 3]
    return missed.square().sum(-1).mean(0).sqrt()
