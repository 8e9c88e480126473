"""How long w and KCI of the UVMS take, alone and with their gradients, beside what one would use otherwise.

All are first compared with each other. ``make bench`` prints the table.
"""

from __future__ import annotations

import os
import subprocess
from dataclasses import dataclass

import numpy as np
import pandas as pd
import pytest
import torch
from alone import PEERS, results, run_alone
from index_peers import Peer, others, ours

import dexterity as dx
from dexterity import timing
from dexterity.indices import Frame, Index
from dexterity.symbolic import compile_index
from dexterity.timing import Way
from serial_chains import paper_uvms

TURNS = {1: (12, 0.01), 1_000: (8, 0.01), 100_000: (3, 0.1)}  # by batch: how many, how long at least [s]
ON_A_GPU = 1_000_000
CHECKED = 100  # configurations in which the ways are compared
VALUE, WITH_GRADIENT = "value", "value and gradient"
FASTEST = "dexterity, C"
PINOCCHIO = "pinocchio + numpy, one by one"


@dataclass(frozen=True)
class Case:
    """An index under the name that the table gives it, and whether others compute it too."""

    title: str
    name: str
    frame: Frame
    compared: bool = True


W = Case("w", "manipulability", "geometric")  # the same in all frames
KCI = Case("KCI, geometric frame", "kinematic_conditioning", "geometric")
SPATIAL_KCI = Case("KCI, spatial frame", "kinematic_conditioning", "spatial", compared=False)


@pytest.fixture(scope="module")
def table() -> pd.DataFrame:
    """Times by index, what is computed, batch and way."""
    return run_alone(__file__, "indices").set_index(["index", "computed", "batch", "way"]).sort_index()


def test_w_of_many_configurations(table: pd.DataFrame):
    ratio = table["ratio"][W.title, VALUE, 100_000]
    assert ratio[PINOCCHIO] >= 250
    assert ratio[ratio.index.str.startswith("batched numpy")].min() >= 40


def test_kci_of_many_configurations(table: pd.DataFrame):
    assert table["ratio"][KCI.title, VALUE, 100_000][PINOCCHIO] >= 130


@pytest.mark.skipif((os.cpu_count() or 1) < 2, reason="two processors are needed")
@pytest.mark.parametrize("case", [W, KCI], ids=lambda case: case.name)
def test_two_threads_are_nearly_twice_as_fast(table: pd.DataFrame, case: Case):
    assert table["ratio"][case.title, VALUE, 100_000]["dexterity, C, two threads"] <= 1 / 1.8


@pytest.mark.parametrize("case", [W, KCI], ids=lambda case: case.name)
def test_one_configuration_of_numpy_takes_two_microseconds(table: pd.DataFrame, case: Case):
    """The call from Python with its checks takes most of it."""
    assert table["median"][case.title, VALUE, 1]["dexterity, C, numpy in and out"] <= 2e-6


def test_w_of_one_configuration_costs_no_more_than_by_pinocchio(table: pd.DataFrame):
    pinocchio = table.loc[(W.title, VALUE, 1, PINOCCHIO)]
    assert pinocchio["ratio"] >= 1 or not pinocchio["distinguishable"]


def test_the_gradient_of_w_costs_a_few_values(table: pd.DataFrame):
    with_gradient, value = (
        table["median"][W.title, what, 100_000, FASTEST] for what in (WITH_GRADIENT, VALUE)
    )
    assert with_gradient / value <= 8


# ---- the measurements ------------------------------------------------------------------------------


def configurations(number: int) -> torch.Tensor:
    return torch.from_numpy(np.random.default_rng(0).uniform(-np.pi, np.pi, (number, 12)))


def compare_all() -> pd.DataFrame:
    chain, robot, q = dx.robots.uvms(), paper_uvms(), configurations(max(TURNS))
    tables = {}
    for case in (W, KCI, SPATIAL_KCI):
        index = Index(case.name, frame=case.frame)
        peers = ours(chain, index) + (others(chain, robot, index) if case.compared else [])
        check_that_they_agree(peers, q[:CHECKED])
        for computed, function in ((VALUE, "value"), (WITH_GRADIENT, "value_and_gradient")):
            for batch, (rounds, seconds) in TURNS.items():
                ways = [way(peer, function, q[:batch]) for peer in peers if getattr(peer, function)]
                timings = timing.measure(ways, rounds, seconds)
                tables[case.title, computed, batch] = timing.table(timings, FASTEST)
    return pd.concat(tables, names=["index", "computed", "batch"])


def way(peer: Peer, function: str, q: torch.Tensor) -> Way:
    call, compute = peer.given(q), getattr(peer, function)
    return Way(peer.name, lambda: call(compute), min(len(q), peer.most))


def check_that_they_agree(peers: list[Peer], q: torch.Tensor) -> None:
    """Compare with the first one; finite differences have the largest errors."""
    values, gradients = (np.asarray(x) for x in peers[0].value_and_gradient(q))
    for peer in peers:
        call = peer.given(q)
        if peer.value:
            value, expected = np.asarray(call(peer.value)), values[: peer.most]
            np.testing.assert_allclose(value, expected, rtol=1e-9, err_msg=peer.name)
        if peer.value_and_gradient:
            found = call(peer.value_and_gradient)
            value, gradient = zip(*found, strict=True) if isinstance(found, list) else found
            np.testing.assert_allclose(np.asarray(value), values, rtol=1e-9, err_msg=peer.name)
            np.testing.assert_allclose(np.asarray(gradient), gradients, rtol=0, atol=1e-7, err_msg=peer.name)


def shares_of_bandwidth(device: str, number: int) -> list[str]:
    """Tell how fast generated torch code is, and beside it a copy, counting what must be read and written."""
    chain, q = dx.robots.uvms(), configurations(number).to(device)
    copy = torch.empty_like(q)
    doubles = {"copy": 24}  # of one configuration
    ways = [Way("copy", lambda: copy.copy_(q), number)]
    for case in (W, KCI):
        f = compile_index(chain, Index(case.name, frame=case.frame), backend="torch")
        doubles |= {f"{case.title}, {VALUE}": 13, f"{case.title}, {WITH_GRADIENT}": 25}
        ways += [
            Way(f"{case.title}, {VALUE}", lambda f=f: f(q), number),
            Way(f"{case.title}, {WITH_GRADIENT}", lambda f=f: f.value_and_gradient(q), number),
        ]
    table = timing.table(timing.measure(ways), "copy")
    texts = timing.readable(table)
    rates = pd.Series(doubles) * 8 / table["median"]  # [GB/s]
    return [
        f"{name}: {texts['median [ns]'][name]} ns, quartiles {texts['quartiles [ns]'][name]} ns, "
        f"{rates[name] / rates['copy']:.1%} of the {rates['copy']:,.0f} GB/s of a copy"
        for name in table.index[1:]
    ]


def on_a_gpu() -> str:
    if not torch.cuda.is_available():
        return "There was no GPU to measure on."
    head = f"Generated torch code on {torch.cuda.get_device_name()}, {ON_A_GPU:,} configurations:"
    return "\n- ".join([head, *shares_of_bandwidth("cuda", ON_A_GPU)])


def compiler() -> str:
    command = [*os.environ.get("CC", "cc").split(), "--version"]
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout.splitlines()[0]


if __name__ == "__main__":
    title = "Indices of the 12-joint UVMS, float64, per configuration; ratios to C in the same case"
    conditions = timing.conditions(*PEERS) | {"C compiler": compiler()}
    timing.write(results("indices"), compare_all(), conditions, f"{title}\n\n{on_a_gpu()}")
