"""The kinematics of paper A against matrix exponentials and differences, and the joints that can change w.

Source: Sotiropoulos & Aspragathos (2016), Eqs. 1–6 and 12.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import reduce
from itertools import accumulate
from typing import Any

import numpy as np
import scipy.linalg
import torch
from torch import Tensor

from dexterity import robots, spatial
from dexterity.chain import Chain
from dexterity.indices import Frame, Index, manipulability
from dexterity_study.engine.experiment import experiment
from dexterity_study.engine.table import Row

OF_DATA = {"data": ("robots/uvms.toml",)}
PAPER = {"paper": "sotiropoulos2016", **OF_DATA}
ROUNDING = {"atol": 1e-6}
"""Rounding errors differ a little from processor to processor."""

RANDOM = {"seeds": 10, "smoke": {"configurations": 20}, **ROUNDING}
IN_OTHER_FRAMES = {
    "assumes": ("which-jacobian",),
    "readings": ("which-jacobian=body", "which-jacobian=geometric"),
    **PAPER,
}
FRAMES: tuple[Frame, ...] = ("spatial", "body", "geometric")
LIMITS = ("rov", "slow-heave", "slow-vehicle", "fast-arm", "tool-1.5", "tool-2")


@experiment(**RANDOM, **OF_DATA)
def formulas(seed: int, configurations: int = 2000) -> Iterator[Row]:
    """Largest deviations over random configurations; positions in [m]."""
    chain = robots.uvms()
    q, redrawn = draws(chain, seed, configurations)
    jacobians = {frame: getattr(chain, f"{frame}_jacobian")(q) for frame in FRAMES}
    differences = _central_differences(chain, q)
    motions = scipy.linalg.expm((spatial.hat(chain.screws) * q[..., None, None]).numpy())
    forward = torch.as_tensor(reduce(np.matmul, motions.swapaxes(0, 1))) @ chain.home
    turned = _with_joint(q, redrawn, 11)
    printed = _equation_6_as_printed(chain, q)
    w = manipulability(printed)
    others = (manipulability(_equation_6_as_printed(chain, _with_joint(q, redrawn, i))) for i in range(4))
    yield {
        "joints": chain.joints,
        "twist": _twist_error(chain, q),
        "forward": largest(chain.forward(q) - forward),
        **{frame: largest(J - differences[frame]) for frame, J in jacobians.items()},
        "printed": largest(jacobians["spatial"] - printed),
        "printed_base_change": max(largest(other / w - 1) for other in others),
        "spatial_last_joint": largest(chain.spatial_jacobian(turned) - jacobians["spatial"]),
        "body_last_joint": largest(chain.body_jacobian(turned) - jacobians["body"]),
    }


@experiment(**RANDOM, **IN_OTHER_FRAMES)
def tool_velocity(seed: int, reading: Mapping[str, Any], configurations: int = 2000) -> Iterator[Row]:
    """Linear rows of a Jacobian against the velocity of the tool point, in world axes [m/s]."""
    chain = robots.uvms()
    q, _ = draws(chain, seed, configurations)
    J = getattr(chain, f"{reading['which-jacobian']}_jacobian")(q)
    yield {"deviation": largest((J - _central_differences(chain, q)["geometric"])[:, :3])}


@experiment(
    keys=("joint",),
    assumes=("velocity-limits",),
    readings=tuple(f"velocity-limits={name}" for name in LIMITS),
    **RANDOM,
    **PAPER,
)
def changes_of_w(seed: int, reading: Mapping[str, Any], configurations: int = 2000) -> Iterator[Row]:
    """Largest relative change of w when one joint alone is redrawn."""
    joint_rates, tool_rates = reading["velocity-limits"]
    index = Index("manipulability", joint_rates=joint_rates, tool_rates=tool_rates)
    yield from changes_by_joint(index, seed, configurations)


@experiment(
    assumes=("link-lengths", "base-link-height", "arm-mount"),
    readings=("link-lengths=swapped", "base-link-height=0.1", "base-link-height=0.2", "base-link-height=0.3"),
    **PAPER,
)
def at_home(reading: Mapping[str, Any]) -> Iterator[Row]:
    """The tool point at home against Eq. 4 [m], and w there."""
    l2, l3 = reading["link-lengths"]
    l1, y_MB = reading["base-link-height"], reading["arm-mount"]
    chain = robots.uvms(l1=l1, l2=l2, l3=l3, y_MB=y_MB)
    expected = spatial.pose(torch.eye(3), [0.0, y_MB + l2 + l3, l1])
    x, y, z = chain.home[:3, 3].tolist()
    w = Index("manipulability").bind(chain)(torch.zeros(chain.joints))
    yield {"deviation": largest(chain.home - expected), "x": x, "y": y, "z": z, "w": w}


def draws(chain: Chain, seed: int, configurations: int, range_deg: float = 60.0) -> tuple[Tensor, Tensor]:
    """Draw two sets of configurations (m, n): translations within ±1 m, rotations within ±`range_deg`."""
    random = torch.Generator().manual_seed(seed)
    half_range = torch.full((chain.joints,), np.radians(range_deg), dtype=torch.float64)
    half_range[:3] = 1.0
    unit = torch.rand(2, configurations, chain.joints, generator=random, dtype=torch.float64)
    first, second = (2 * unit - 1) * half_range
    return first, second


def changes_by_joint(index: Index, seed: int, configurations: int) -> Iterator[Row]:
    """Yield the largest relative change of an index when one joint alone is redrawn, for each joint."""
    chain = robots.uvms()
    q, redrawn = draws(chain, seed, configurations)
    f = index.bind(chain)
    before = f(q)
    for joint in range(chain.joints):
        yield {"joint": joint, "change": largest(f(_with_joint(q, redrawn, joint)) / before - 1)}


def _central_differences(chain: Chain, q: Tensor, step: float = 1e-5) -> Mapping[str, Tensor]:
    """Differentiate the tool pose numerically, and read the twists (..., 6, n) in each of the three frames."""
    steps = step * torch.eye(chain.joints, dtype=q.dtype)
    change = (chain.forward(q[..., None, :] + steps) - chain.forward(q[..., None, :] - steps)) / (2 * step)
    back = spatial.inverse(chain.forward(q))[..., None, :, :]
    twists, body_twists = spatial.vee(change @ back), spatial.vee(back @ change)
    of_point = torch.cat([change[..., :3, 3], twists[..., 3:]], dim=-1)
    return {"spatial": twists.mT, "body": body_twists.mT, "geometric": of_point.mT}


def largest(difference: Tensor) -> float:
    """Return the largest absolute value."""
    return float(difference.abs().max())


def _equation_6_as_printed(chain: Chain, q: Tensor) -> Tensor:
    """Return the columns of Eq. 6 with the home pose g_st(0) inside the adjoint: (m, n) → (m, 6, n)."""
    motions = spatial.exp(chain.screws * q[..., None]).unbind(-3)
    before = accumulate(motions[:-1], torch.matmul, initial=torch.eye(4, dtype=q.dtype).expand(len(q), 4, 4))
    columns = [spatial.adjoint(T @ chain.home) @ screw for T, screw in zip(before, chain.screws, strict=True)]
    return torch.stack(columns, dim=-1)


def _with_joint(q: Tensor, redrawn: Tensor, joint: int) -> Tensor:
    changed = q.clone()
    changed[:, joint] = redrawn[:, joint]
    return changed


def _twist_error(chain: Chain, q: Tensor) -> float:
    """Return by how much a joint moves a point of its own axis, or misses the plain translation."""
    points = chain.joint_frames(torch.zeros(chain.joints))[:, :3, 3]
    slides = torch.tensor([[kind == "prismatic"] for kind in chain.kinds])
    moved = spatial.apply(spatial.exp(chain.screws * q[..., None]), points)
    return largest(moved - points - slides * q[..., None] * chain.screws[:, :3])
