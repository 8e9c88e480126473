"""Small design problems, importable by processes of their own."""

import torch

from dexterity import sampling
from dexterity.networks.design import FeedForwardOptions
from dexterity.networks.network import View
from dexterity.networks.problem import DesignProblem
from dexterity.sampling import Box

SMALL = FeedForwardOptions(testing_error=0.01, training_goal=0.0, epoch_limit=30, restarts=2, neuron_limit=7)


def wave(q: torch.Tensor) -> torch.Tensor:
    return 2 + torch.sin(2 * q[:, 0]) * torch.cos(q[:, 1]) / 2


def small_problem(seed: int = 0, train: int = 150) -> DesignProblem:
    space = Box([-1.0, -1.0], [1.0, 1.0])
    data = sampling.data_sets(wave, space, train=train, test=50, validation=50, seed=seed, method="uniform")
    return DesignProblem(View(2, [0, 1]), data)
