"""Good arguments that several samples share: robots, configurations, small networks, each made once."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Mapping
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import torch

import dexterity as dx
from dexterity import networks, robots, sampling

Arguments = Mapping[str, Callable[[], Any]]

Q = np.array([0.3, -0.5, 0.7, 0.2, 0.9, -0.4])
VECTOR = np.array([0.1, 0.2, 0.3])
TWIST = np.array([0.1, 0.2, 0.3, 0.4, 0.5, 0.6])
UNIT = np.array([0.0, 0.0, 1.0])
PAIR = np.array([[0.1, 0.2], [0.3, -0.4]])
SPACE = sampling.Box([-0.5] * 6, [0.5] * 6, 3)
SQUARE = sampling.Box([-0.5] * 2, [0.5] * 2)
FEW = networks.Search(samples=16, corners=4, starts=2, steps=2)


def of(**values: Any) -> Arguments:
    """Arguments by name; what can be called is called for its value."""
    return {name: value if callable(value) else lambda value=value: value for name, value in values.items()}


@cache
def puma() -> dx.Chain:
    return robots.puma560()


@cache
def ur5e() -> dx.Chain:
    return robots.ur5e()


@cache
def planar() -> dx.Chain:
    return dx.Chain([[0, 0, 0, 0, 0, 1], [0, -1, 0, 0, 0, 1]], np.eye(4), lower=[-3, -3], upper=[3, 3])


@cache
def elbow() -> dx.Chain:
    return robots.docking_arm()


@cache
def T() -> np.ndarray:
    return puma().forward(Q).numpy()


@cache
def J() -> np.ndarray:
    return puma().geometric_jacobian(Q).numpy()


def draws() -> torch.Generator:
    return torch.Generator().manual_seed(0)


def hill(x: torch.Tensor) -> torch.Tensor:
    return 2 - (x - 0.3).square().sum(-1)


@cache
def w() -> dx.Index:
    return dx.Index("manipulability", "geometric")


@cache
def both() -> networks.View:
    return networks.View(2, (0, 1))


@cache
def small_data() -> sampling.DataSets:
    return sampling.data_sets(hill, SQUARE, train=24, test=8, validation=8, method="uniform")


def data_set() -> sampling.DataSet:
    return small_data().train


@cache
def feed_forward() -> networks.FeedForward:
    return networks.FeedForward.untrained(both(), 2, data_set().q, data_set().values, draws())


@cache
def radial_basis() -> networks.RadialBasis:
    return networks.radial_basis_design.grow(
        problem(), 1.0, networks.growth.RadialBasisOptions(neuron_limit=3)
    ).network


@cache
def problem() -> networks.problem.DesignProblem:
    return networks.problem.DesignProblem(both(), small_data())


_KEPT = tempfile.TemporaryDirectory()


@cache
def folder() -> Path:
    """A folder for what is written; it is the working folder of all calls, and goes with the process."""
    return Path(_KEPT.name)
