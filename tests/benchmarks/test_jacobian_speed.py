"""How long geometric Jacobians of the UVMS take, beside what one would write or use otherwise.

All are measured in one fresh process on one thread, without the run-time checks of annotations that the
other tests switch on, and are first compared with each other. ``make bench`` prints the table.
"""

from __future__ import annotations

import importlib.metadata
import json
import os
import platform
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

BATCH = 100_000
ROUNDS = 6  # all are measured in turn, again and again, so that what else the machine does hits all alike
SECONDS_A_ROUND = 0.5  # spent on each, at least
SMALL_BATCH = 1_000  # also the number of configurations of the libraries that take one at a time
ONE_THREAD = dict.fromkeys(["OMP_NUM_THREADS", "MKL_NUM_THREADS", "OPENBLAS_NUM_THREADS"], "1")

Array = NDArray[np.float64]


def test_geometric_jacobians_are_faster_than_plain_numpy_and_pytorch_kinematics():
    tests = str(Path(__file__).resolve().parents[1])
    run = subprocess.run(
        [sys.executable, __file__],
        env=os.environ | ONE_THREAD | {"PYTHONPATH": tests},
        stdout=subprocess.PIPE,
        text=True,
        check=True,
    )
    report = json.loads(run.stdout)
    print("\n" + table(report))
    median = {row["name"]: row["median"] for row in report["rows"]}
    assert median["numpy"] / median["dexterity"] >= 1.5
    assert median["pytorch_kinematics"] / median["dexterity"] > 1
    assert median["pytorch_kinematics, 1,000 at a time"] / median["dexterity"] > 1


def table(report: dict[str, Any]) -> str:
    ours, *others = report["rows"]
    lines = [
        f"Geometric Jacobians of the 12-joint UVMS, float64, one thread, {BATCH:,} configurations",
        f"{report['processor']}; {report['versions']}",
        f"{'[ns per configuration]':38}{'median':>8}{'quartiles':>18}{'ratio':>19}",
        f"{ours['name']:38}{ours['median']:8,.0f}{quartiles(ours):>18}{1:19.2f}",
    ]
    for row in others:
        overlap = row["lower"] <= ours["upper"] and ours["lower"] <= row["upper"]
        ratio = "indistinguishable" if overlap else f"{row['median'] / ours['median']:.2f}"
        lines.append(f"{row['name']:38}{row['median']:8,.0f}{quartiles(row):>18}{ratio:>19}")
    return "\n".join(lines)


def quartiles(row: dict[str, Any]) -> str:
    return f"{row['lower']:,.0f}–{row['upper']:,.0f}"


# ---- in numpy --------------------------------------------------------------------------------------


def plain_numpy(screws: Array, home: Array, q: Array) -> Array:
    """Jacobians (N, 6, n) by products of exponentials with the batch in front, as one would write them.

    Rotations multiply as stacks of matrices; what does not depend on q is worked out once a joint.
    """
    R, p = np.eye(3), np.zeros(3)
    linear, angular = np.empty((2, len(screws), len(q), 3))
    for i, (screw, value) in enumerate(zip(screws, q.T, strict=True)):
        v, omega = screw[:3], screw[3:]
        angular[i] = R @ omega
        linear[i] = R @ v + cross(p, angular[i])
        if omega.any():
            W, s, c = np.cross(np.eye(3), omega), np.sin(value)[:, None, None], np.cos(value)[:, None, None]
            nearest = np.cross(omega, v)  # point of the axis, which the motion leaves where it is
            p = p + R @ nearest
            R = R @ (np.eye(3) + s * W + (1 - c) * (W @ W))
            p = p - R @ nearest
        else:
            p = p + value[:, None] * (R @ v)
    linear += cross(angular, p + R @ home[:3, 3])
    return np.concatenate([linear, angular], axis=-1).transpose(1, 2, 0)


def numpy_batch_last(screws: Array, home: Array, q: Array) -> Array:
    """Return the same with the batch last, so that each operation runs over contiguous memory."""
    N = len(q)
    R, p = np.broadcast_to(np.eye(3)[:, :, None], (3, 3, N)), np.zeros((3, N))
    linear, angular = np.empty((2, 3, len(screws), N))
    for i, (screw, value) in enumerate(zip(screws, np.ascontiguousarray(q.T), strict=True)):
        v, omega = screw[:3], screw[3:]
        angular[:, i] = np.einsum("rcN,c->rN", R, omega)
        linear[:, i] = np.einsum("rcN,c->rN", R, v) + cross(p.T, angular[:, i].T).T
        if omega.any():
            W, s, c = np.cross(np.eye(3), omega), np.sin(value), np.cos(value)
            nearest = np.cross(omega, v)
            p = p + np.einsum("rcN,c->rN", R, nearest)
            turn = np.eye(3)[:, :, None] + s * W[:, :, None] + (1 - c) * (W @ W)[:, :, None]
            R = np.einsum("rkN,kcN->rcN", R, turn)
            p = p - np.einsum("rcN,c->rN", R, nearest)
        else:
            p = p + value * np.einsum("rcN,c->rN", R, v)
    tool = p + np.einsum("rcN,c->rN", R, home[:3, 3])
    linear += cross(angular.transpose(1, 2, 0), tool.T).transpose(2, 0, 1)
    return np.concatenate([linear, angular]).transpose(2, 0, 1)


def cross(a: Array, b: Array) -> Array:
    """Cross product over the last axis; faster on batches than numpy's, and laid out as its arguments."""
    (ax, ay, az), (bx, by, bz) = np.moveaxis(a, -1, 0), np.moveaxis(b, -1, 0)
    return np.moveaxis(np.stack([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx]), 0, -1)


# ---- the measurements, in a process of their own ---------------------------------------------------


@dataclass(frozen=True)
class Way:
    """A way to compute the first `batch` Jacobians."""

    name: str
    compute: Callable[[], Any]
    batch: int = BATCH


def measure() -> dict[str, Any]:
    import torch

    torch.set_num_threads(1)
    q = torch.from_numpy(np.random.default_rng(0).uniform(-1, 1, (BATCH, 12)))
    ways = ways_to_compute(q)
    expected = np.asarray(ways[0].compute())
    for way in ways:
        J = np.asarray(way.compute())
        np.testing.assert_allclose(J, expected[: way.batch], rtol=0, atol=1e-12, err_msg=way.name)
    distributions = ["torch", "numpy", "pytorch-kinematics", "pin", "roboticstoolbox-python"]
    versions = [f"{name} {importlib.metadata.version(name)}" for name in distributions]
    return {
        "processor": processor(),
        "versions": ", ".join([f"Python {platform.python_version()}", *versions]),
        "rows": nanoseconds(ways),
    }


def ways_to_compute(q: Any) -> list[Way]:
    import pinocchio
    import torch

    import dexterity as dx
    from peer_models import pinocchio_model, pytorch_kinematics_chain, roboticstoolbox_transforms
    from serial_chains import paper_uvms

    chain, robot = dx.robots.uvms(), paper_uvms()
    screws, home = chain.screws.numpy(), chain.home.numpy()
    peer, transforms = pytorch_kinematics_chain(robot), roboticstoolbox_transforms(robot)
    model, tool = pinocchio_model(robot)
    data, frame = model.createData(), pinocchio.ReferenceFrame.LOCAL_WORLD_ALIGNED
    few = q[:SMALL_BATCH].numpy()
    return [
        Way("dexterity", lambda: chain.geometric_jacobian(q)),
        Way("numpy", lambda: plain_numpy(screws, home, q.numpy())),
        Way("numpy, batch axis last", lambda: numpy_batch_last(screws, home, q.numpy())),
        Way("pytorch_kinematics", lambda: peer.jacobian(q)),
        Way(
            "pytorch_kinematics, 1,000 at a time",
            lambda: torch.cat([peer.jacobian(piece) for piece in q.split(SMALL_BATCH)]),
        ),
        Way(
            "pinocchio, one by one",
            lambda: [pinocchio.computeFrameJacobian(model, data, one, tool, frame) for one in few],
            SMALL_BATCH,
        ),
        Way("roboticstoolbox, one by one", lambda: [transforms.jacob0(one) for one in few], SMALL_BATCH),
    ]


def nanoseconds(ways: list[Way]) -> list[dict[str, Any]]:
    """Median and quartiles of the time per configuration, for each way."""
    from torch.utils.benchmark import Timer

    timers = [Timer("compute()", globals={"compute": way.compute}, num_threads=1) for way in ways]
    times: list[list[float]] = [[] for _ in ways]
    for _ in range(ROUNDS):
        for timer, taken in zip(timers, times, strict=True):
            taken += timer.blocked_autorange(min_run_time=SECONDS_A_ROUND).times
    rows = []
    for way, taken in zip(ways, times, strict=True):
        lower, median, upper = np.quantile(taken, [0.25, 0.5, 0.75]) * 1e9 / way.batch
        rows.append({"name": way.name, "lower": lower, "median": median, "upper": upper})
    return rows


def processor() -> str:
    """Name of the processor, where the system tells it."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        return platform.processor() or platform.machine()
    names = [line.split(":")[1].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.machine()


if __name__ == "__main__":
    json.dump(measure(), sys.stdout)
