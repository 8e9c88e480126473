"""Recipes for networks whose largest error counts, and not their mean square error alone.

Least squares leaves the largest errors where training sets have few rows, at the faces and corners of the
space. Two remedies are offered: rows that lie on the faces, and rounds of training in which the worst points
found so far, by ascent, join the training set.

Examples
--------
>>> import dexterity as dx
>>> from dexterity.networks import network, recipes
>>> space = dx.sampling.Box([-1, -1], [1, 1])
>>> recipe = recipes.Recipe(neurons=3, rows=64, epochs=20)
>>> trained = recipes.prepare(
...     recipe, network.View(2, [0, 1]), lambda q: 2 + q[..., 0].sin(), space, [0, 1]
... )
>>> [network.neurons for network in trained]
[3, 3]
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import torch

from dexterity import checks, sampling
from dexterity.networks import train
from dexterity.networks.feed_forward import READOUTS, FeedForward, Readout
from dexterity.networks.levenberg_marquardt import Options, levenberg_marquardt
from dexterity.networks.network import View
from dexterity.networks.threads import one_thread
from dexterity.networks.validation import Function
from dexterity.networks.worst_case import Search, worst_points
from dexterity.sampling import DataSet, Space

__all__ = ["Recipe", "prepare"]


@dataclass(frozen=True)
class Recipe:
    """How to train a feed-forward network.

    Attributes
    ----------
    neurons, readout
        See :class:`dexterity.networks.feed_forward.FeedForward`.
    rows, overhang
        Of the first training set, see :func:`dexterity.sampling.sobol`.
    epochs
        Of the first training.
    rounds
        How often worst points join the training set and training goes on.
    worst_points
        How many a round, shared by the networks that are trained together.
    round_epochs
        Of each further training.

    Raises
    ------
    ValueError
        If a number is out of its range.
    """

    neurons: int = 8
    readout: Readout = "identity"
    rows: int = 5000
    overhang: float = 0.0
    epochs: int = 100
    rounds: int = 0
    worst_points: int = 1000
    round_epochs: int = 30

    def __post_init__(self) -> None:
        whole = ("neurons", "rows", "epochs", "worst_points", "round_epochs")
        checks.fields(
            self,
            readout=checks.Choice(tuple(READOUTS)),
            **dict.fromkeys(whole, checks.Whole(1)),
            rounds=checks.Whole(0),
            overhang=checks.Real(least=0),
        )


@checks.arguments(
    recipe=checks.Instance(Recipe),
    view=checks.Instance(View),
    index=checks.function,
    space=checks.Instance(Space),
    seeds=checks.Each(checks.seed),
    rows_seed=checks.seed,
)
def prepare(
    recipe: Recipe, view: View, index: Function, space: Space, seeds: Sequence[int], rows_seed: int = 0
) -> tuple[FeedForward, ...]:
    """Train a network for each seed of initial weights, all on the same rows.

    Parameters
    ----------
    recipe
        How.
    view
        What the networks see.
    index
        What they learn, as a function of joint values; torch must be able to differentiate it once if the
        recipe has rounds.
    space
        Where.
    seeds
        Of the initial weights.
    rows_seed
        Of the training set and of the searches for worst points.

    Raises
    ------
    ValueError
        If there are no seeds, an input of the view does not vary in the space, or the index does not fit
        the readout.
    """
    with one_thread():
        q = sampling.sobol(space, recipe.rows, rows_seed, recipe.overhang)
        data = DataSet.of(index, q, "index")
        trainings = train.for_seeds(
            view,
            recipe.neurons,
            data.q,
            data.values,
            seeds,
            Options(epochs=recipe.epochs),
            readout=recipe.readout,
        )
        networks = [training.network for training in trainings]
        for number in range(1, recipe.rounds + 1):
            search = Search(starts=math.ceil(recipe.worst_points / len(networks)), steps=_STEPS)
            worst = [worst_points(one, index, space, search, rows_seed + number) for one in networks]
            data = _joined([data, *worst])
            further = Options(epochs=recipe.round_epochs)
            trainings = levenberg_marquardt(networks, data.q, data.values, further)
            networks = [training.network for training in trainings]
    return tuple(networks)


_STEPS = 30  # a worst point to train on need not be the very top of its hill


def _joined(sets: Sequence[DataSet]) -> DataSet:
    return DataSet(torch.cat([one.q for one in sets]), torch.cat([one.values for one in sets]))
