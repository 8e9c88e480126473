"""Table 1 used: candidate configurations that hold the tool in one pose, ranked for different tasks.

Source: Sotiropoulos & Aspragathos (2016), section 2.3. The candidates stand in front of a panel and differ in
where the vehicle is and how the arm reaches.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
import torch
from scipy.spatial.transform import Rotation
from torch import Tensor

from dexterity import robots, tasks
from dexterity.indices import Index, kinematic_conditioning, velocity_ellipsoid
from dexterity_study.engine.experiment import experiment
from dexterity_study.engine.table import Row
from dexterity_study.uvms.indices.experiment import VEHICLE_LOCKED, rank_correlations
from dexterity_study.uvms.kinematics.experiment import ROUNDING, largest

OF_DATA = {"data": ("robots/uvms.toml", "tasks.toml")}
RANDOM = {"seeds": 50, "smoke": {"count": 20}, **ROUNDING, **OF_DATA}


@experiment(keys=("index",), **OF_DATA)
def table() -> Iterator[Row]:
    """Tasks of Table 1 that go with each index."""
    listed = [task for task in tasks.TASKS.values() if "Table 1" in task.where]
    for index in ("manipulability", "kinematic_conditioning"):
        yield {"index": index, "tasks": sum(task.index == index for task in listed)}


@experiment(
    keys=("pair",),
    paper="sotiropoulos2016",
    assumes=("candidate-configurations",),
    readings=("candidate-configurations=300",),
    reading_seeds=10,
    **RANDOM,
)
def agreement(seed: int, reading: Mapping[str, Any], count: int | None = None) -> Iterator[Row]:
    """Kendall's τ between two rankings of the same candidates."""
    chain = robots.uvms()
    q = candidates(seed, count or reading["candidate-configurations"])
    w, kci = (tasks.rank(chain, q, task, frame="spatial").values for task in ("valve turning", "welding"))
    J = chain.geometric_jacobian(q)
    tool_axis = chain.forward(q)[:, :3, 1]
    push, torque = (1 / (tool_axis[:, None] @ rows).norm(dim=-1)[:, 0] for rows in (J[:, :3], J[:, 3:]))
    accuracy = -velocity_ellipsoid(J).semi_axes[:, 0]
    about_tool = kinematic_conditioning(J)
    pairs = {
        "w, KCI": (w, kci),
        "w: free, locked vehicle": (w, Index("manipulability", joint_rates=VEHICLE_LOCKED).bind(chain)(q)),
        "w, largest speed": (w, velocity_ellipsoid(J, "translational").semi_axes[:, 0]),
        "w, torque about the tool": (w, torque),
        "w, push along the tool": (w, push),
        "KCI: spatial, geometric": (kci, about_tool),
        "spatial KCI, accuracy": (kci, accuracy),
        "geometric KCI, accuracy": (about_tool, accuracy),
    }
    yield from rank_correlations(pairs)


@experiment(**RANDOM)
def choice(seed: int, count: int = 100) -> Iterator[Row]:
    """Deviation of the candidates from their common tool pose, and how much they differ in w and KCI."""
    chain = robots.uvms()
    q = candidates(seed, count)
    w, kci = (tasks.rank(chain, q, task, frame="spatial").values for task in ("valve turning", "welding"))
    yield {
        "pose": largest(chain.forward(q) - chain.home),
        "w_ratio": w.max() / w.min(),
        "kci_ratio": kci.max() / kci.min(),
    }


def candidates(seed: int, count: int, vehicle_deg: float = 15.0, arm_deg: float = 60.0) -> Tensor:
    """Draw configurations (m, 12) that hold the UVMS's tool in its pose at home.

    Vehicle angles and the arm's first three joints are drawn; the wrist's three joints, which turn about z, -x
    and y, make up the orientation, and the vehicle's translation the position.
    """
    chain = robots.uvms()
    random = torch.Generator().manual_seed(seed)
    q = torch.zeros(count, chain.joints, dtype=torch.float64)
    half_range = torch.tensor(np.radians([vehicle_deg] * 3 + [arm_deg] * 3))
    q[:, 3:9] = (2 * torch.rand(count, 6, generator=random, dtype=torch.float64) - 1) * half_range
    wrist = chain.forward(q)[:, :3, :3].mT @ chain.home[:3, :3]
    z, x, y = Rotation.from_matrix(wrist.numpy()).as_euler("ZXY").T
    q[:, 9:12] = torch.as_tensor(np.stack([z, -x, y], axis=-1))
    q[:, :3] = chain.home[:3, 3] - chain.forward(q)[:, :3, 3]
    return q
