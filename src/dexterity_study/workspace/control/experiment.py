"""A control loop on exact and estimated Jacobians at many gains, so that no verdict depends on a chosen gain.

Source: Liao & Mao (2018), section VII, Figs. 11 and 12, which print no gain. An error that the feedback holds is
inversely proportional to the gain, so that its product with the gain says how good a Jacobian is. The networks are
those of the maps, with the estimation head alone.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import torch
from torch import Tensor

from dexterity.chain import Chain
from dexterity.workspace import dataset, reachability, training
from dexterity.workspace.jacobian_net import JacobianNet
from dexterity.workspace.resolved_rate import track
from dexterity_study.engine.experiment import experiment
from dexterity_study.workspace.puma.experiment import CIRCLE, LINKS, NETWORKS, tracking_arm

EXACT = "exact"
"""Name of the exact Jacobian in the rows."""

GAINS = (1.0, 5.0, 20.0, 100.0)
"""Gains on the error of the pose [1/s]; with the last one a step of the loop takes back the whole error."""


@experiment(
    keys=("jacobian", "gain"),
    smoke={"rows": 1_000, "epochs": 1, "at": (0.5, 1.0), "step": 0.25},
    # A training carries rounding errors on and makes them larger.
    rtol=0.05,
    atol=0.02,
    unsteady=("ended",),
    paper="liao2018",
    assumes=("rate-control-path",),
)
def gains(
    seed: int,
    reading: Mapping[str, Any],
    rows: int = 60_000,
    epochs: int = 12,
    at: Sequence[float] = GAINS,
    step: float | None = None,
) -> Iterator[dict[str, Any]]:
    """Largest errors on the circle by Jacobian and gain; of the reading all but the gain is used."""
    radius, period, rate, _ = reading["rate-control-path"]
    arm, path = tracking_arm(), replace(CIRCLE, radius=radius, period=period)
    start, _ = reachability.inverse(LINKS, path(torch.zeros((), dtype=torch.float64)).T_world_tool)
    for name, jacobian in _jacobians(arm, rows, epochs, seed):
        for gain in at:
            run = track(path, arm.forward, jacobian, start, duration=period, step=step or 1 / rate, gain=gain)
            estimated, truth = jacobian(run.q), arm.geometric_jacobian(run.q)
            wrong = torch.linalg.matrix_norm(estimated - truth) / torch.linalg.matrix_norm(truth)
            yield {
                "jacobian": name,
                "gain": gain,
                "largest": run.position_error.max().item(),
                "orientation": run.orientation_error.max().item(),
                "jacobian_error": wrong.median().item(),
                "ended": run.message or "on time",
            }


def _jacobians(
    arm: Chain, rows: int, epochs: int, seed: int
) -> Iterator[tuple[str, Callable[[Tensor], Tensor]]]:
    """Yield the exact Jacobian, and those of the networks after their training."""
    yield EXACT, arm.geometric_jacobian
    data = dataset.jacobian_data(rows, 2 * seed + 2, dynamics=False)
    options = training.Options(training.epochs(estimation=epochs), rate=3e-3, batch=512, validation=0.02)
    for name, way in NETWORKS.items():
        network = training.network_for(way.architecture, way.inputs, way.entries, data, seed)
        sets: dict[training.Head, training.Rows] = {"estimation": training.estimation_rows(network, data)}
        yield name, partial(_estimate, training.train(network, sets, options, seed).network, arm)


def _estimate(network: JacobianNet, arm: Chain, q: Tensor) -> Tensor:
    """Fig. 12: the pose from the joint angles, the Jacobian from the pose."""
    return network.answer(LINKS, arm.forward(q)).jacobian
