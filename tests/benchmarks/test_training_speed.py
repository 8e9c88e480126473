"""How long trainings take beside torch-levenberg-marquardt's, and together beside one after the other.

The tasks are the paper's: w with 8 neurons and KCI with 25. Each way makes so many steps from the same
weights with the same rule for the damping. ``make bench`` prints the table.
"""

from __future__ import annotations

import logging
from dataclasses import dataclass

import pandas as pd
import pytest
import torch
from alone import results, run_alone
from torch_levenberg_marquardt.damping import StandardDampingStrategy
from torch_levenberg_marquardt.training import LevenbergMarquardtModule

import dexterity as dx
from dexterity import sampling, timing
from dexterity.indices import Index
from dexterity.networks.feed_forward import FeedForward
from dexterity.networks.levenberg_marquardt import Options, levenberg_marquardt
from dexterity.networks.network import View
from dexterity.sampling import DataSet
from dexterity.symbolic import compile_index
from dexterity.timing import Way

STEPS = 10
RESTARTS = 32
ALONE, TOGETHER = f"{RESTARTS} calls", f"one call of {RESTARTS}"
OURS, PEER = "dexterity", "torch-levenberg-marquardt"


@dataclass(frozen=True)
class Task:
    name: str
    index: str
    inputs: range
    neurons: int
    rows: int


W = Task("w", "manipulability", range(4, 11), 8, 5_000)
KCI = Task("KCI", "kinematic_conditioning", range(11), 25, 10_000)


@pytest.fixture(scope="module")
def table() -> pd.DataFrame:
    """Times by task and way."""
    return run_alone(__file__, "training").set_index(["task", "way"]).sort_index()


@pytest.mark.parametrize("task", [W.name, KCI.name])
def test_a_training_takes_at_most_half_the_time_of_the_peer(table: pd.DataFrame, task: str):
    assert table["ratio"][task, OURS] <= 0.5


def test_restarts_together_are_faster_than_one_after_the_other(table: pd.DataFrame):
    together = table.loc[("restarts of w", TOGETHER)]
    assert together["ratio"] < 1
    assert together["distinguishable"]


# ---- the measurements ------------------------------------------------------------------------------


class Answering(torch.nn.Module):
    """A network as the peer takes it: as a function of what it sees."""

    def __init__(self, network: FeedForward) -> None:
        super().__init__()
        self.network = network

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        return self.network.answer(x)


def training_set(task: Task) -> DataSet:
    index = compile_index(dx.robots.uvms(), Index(task.index), backend="c")
    space = sampling.uvms_space(task.index)
    return sampling.data_sets(index, space, train=task.rows, test=1, validation=1).train


def start(task: Task, data: DataSet, seed: int = 0) -> FeedForward:
    random = torch.Generator().manual_seed(seed)
    return FeedForward.untrained(View(12, task.inputs), task.neurons, data.q, data.values, random)


def by_peer(task: Task, data: DataSet) -> float:
    network = start(task, data)
    module = LevenbergMarquardtModule(
        Answering(network), damping_strategy=StandardDampingStrategy(), solve_method="cholesky"
    )
    x = network.view(data.q)
    for _ in range(STEPS):
        _, loss, _, _ = module.training_step(x, data.values)
    return float(loss)


def beside_the_peer(task: Task) -> pd.DataFrame:
    data = training_set(task)
    network = start(task, data)
    options = Options(epochs=STEPS, damping="factor")
    ways = [
        Way(PEER, lambda: by_peer(task, data), 1),
        Way(OURS, lambda: levenberg_marquardt(network, data.q, data.values, options), 1),
    ]
    return timing.table(timing.measure(ways, rounds=5, seconds=0.2), PEER)


def together() -> pd.DataFrame:
    data = training_set(W)
    networks = [start(W, data, seed) for seed in range(RESTARTS)]
    options = Options(epochs=STEPS)

    def one_by_one() -> None:
        for network in networks:
            levenberg_marquardt(network, data.q, data.values, options)

    ways = [
        Way(ALONE, one_by_one, 1),
        Way(TOGETHER, lambda: levenberg_marquardt(networks, data.q, data.values, options), 1),
    ]
    return timing.table(timing.measure(ways, rounds=3, seconds=0.2), ALONE)


if __name__ == "__main__":
    logging.getLogger("torch_levenberg_marquardt").setLevel(logging.ERROR)
    tables = {task.name: beside_the_peer(task) for task in (W, KCI)} | {"restarts of w": together()}
    timing.write(
        results("training"),
        pd.concat(tables, names=["task"]),
        timing.conditions("torch-levenberg-marquardt"),
        f"{STEPS} steps of a training, float64; the configuration that times are given for is a training",
    )
