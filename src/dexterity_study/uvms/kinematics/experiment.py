"""The kinematics of paper A against matrix exponentials and differences, and the joints that can change w.

Source: Sotiropoulos & Aspragathos (2016), Eqs. 1–6 and 12.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
import scipy.linalg
import torch
from torch import Tensor

from dexterity import robots, spatial
from dexterity.chain import Chain
from dexterity.indices import Index, manipulability
from dexterity_study.engine.experiment import experiment

OF_DATA = {"data": ("robots/uvms.toml",)}
PAPER = {"paper": "sotiropoulos2016"}
ROUNDING = {"rtol": 1e-6, "atol": 1e-6}
"""Rounding errors differ a little from processor to processor."""


@experiment(seeds=10, smoke={"configurations": 20}, **ROUNDING, **OF_DATA)
def formulas(seed: int, configurations: int = 2000, step: float = 1e-5) -> Iterator[dict[str, Any]]:
    """Largest deviations over random configurations; positions in [m], steps of differences in [rad] or [m]."""
    chain = robots.uvms()
    q, redrawn = draws(chain, seed, configurations)
    spatial_jacobian, body_jacobian = chain.spatial_jacobian(q), chain.body_jacobian(q)
    differences = _central_differences(chain, q, step)
    turned = _with_joint(q, redrawn, 11)
    printed = equation_6_as_printed(chain, q)
    w = manipulability(printed)
    others = (manipulability(equation_6_as_printed(chain, _with_joint(q, redrawn, i))) for i in range(4))
    yield {
        "joints": chain.joints,
        "twist": _twist_error(chain, q),
        "forward": _largest(chain.forward(q) - _product_of_expm(chain, q)),
        "spatial": _largest(spatial_jacobian - differences["spatial"]),
        "body": _largest(body_jacobian - differences["body"]),
        "geometric": _largest(chain.geometric_jacobian(q) - differences["geometric"]),
        "printed": _largest(spatial_jacobian - printed),
        "printed_base_change": max(_largest(other / w - 1) for other in others),
        "spatial_last_joint": _largest(chain.spatial_jacobian(turned) - spatial_jacobian),
        "body_last_joint": _largest(chain.body_jacobian(turned) - body_jacobian),
    }


@experiment(
    seeds=10,
    assumes=("which-jacobian",),
    readings=("which-jacobian=body", "which-jacobian=geometric"),
    smoke={"configurations": 20},
    **ROUNDING,
    **PAPER,
    **OF_DATA,
)
def tool_velocity(
    seed: int, reading: Mapping[str, Any], configurations: int = 2000, step: float = 1e-5
) -> Iterator[dict[str, Any]]:
    """Linear rows of a Jacobian against the velocity of the tool point, in world axes [m/s]."""
    chain = robots.uvms()
    q, _ = draws(chain, seed, configurations)
    rows = getattr(chain, f"{reading['which-jacobian']}_jacobian")(q)[..., :3, :]
    yield {"deviation": _largest(rows - _central_differences(chain, q, step)["geometric"][..., :3, :])}


@experiment(
    seeds=10,
    keys=("joint",),
    assumes=("velocity-limits",),
    readings=tuple(
        f"velocity-limits={name}"
        for name in ("rov", "slow-heave", "slow-vehicle", "fast-arm", "tool-1.5", "tool-2")
    ),
    smoke={"configurations": 20},
    **ROUNDING,
    **PAPER,
    **OF_DATA,
)
def changes_of_w(
    seed: int, reading: Mapping[str, Any], configurations: int = 2000
) -> Iterator[dict[str, Any]]:
    """Largest relative change of w when one joint alone is redrawn."""
    chain = robots.uvms()
    q, redrawn = draws(chain, seed, configurations)
    joint_rates, tool_rates = reading["velocity-limits"]
    index = Index("manipulability", joint_rates=joint_rates, tool_rates=tool_rates)
    for joint, change in enumerate(changes_by_joint(chain, index, q, redrawn)):
        yield {"joint": joint, "change": change}


@experiment(
    assumes=("link-lengths", "base-link-height", "arm-mount"),
    readings=("link-lengths=swapped", "base-link-height=0.1", "base-link-height=0.2", "base-link-height=0.3"),
    **PAPER,
    **OF_DATA,
)
def at_home(seed: int, reading: Mapping[str, Any]) -> Iterator[dict[str, Any]]:  # noqa: ARG001 -- nothing is drawn
    """The tool point at home against Eq. 4 [m], and w there."""
    l2, l3 = reading["link-lengths"]
    l1, y_MB = reading["base-link-height"], reading["arm-mount"]
    chain = robots.uvms(l1=l1, l2=l2, l3=l3, y_MB=y_MB)
    expected = torch.eye(4, dtype=torch.float64)
    expected[:3, 3] = torch.tensor([0.0, y_MB + l2 + l3, l1], dtype=torch.float64)
    x, y, z = chain.home[:3, 3].tolist()
    w = Index("manipulability").bind(chain)(torch.zeros(chain.joints))
    yield {"deviation": _largest(chain.home - expected), "x": x, "y": y, "z": z, "w": w}


# ---- shared with other chapters --------------------------------------------------------------------


def draws(chain: Chain, seed: int, configurations: int, range_deg: float = 60.0) -> tuple[Tensor, Tensor]:
    """Draw two sets of configurations (m, n): translations within ±1 m, rotations within ±`range_deg`."""
    random = torch.Generator().manual_seed(seed)
    half_range = torch.full((chain.joints,), np.radians(range_deg), dtype=torch.float64)
    half_range[:3] = 1.0
    unit = torch.rand(2, configurations, chain.joints, generator=random, dtype=torch.float64)
    first, second = (2 * unit - 1) * half_range
    return first, second


def changes_by_joint(chain: Chain, index: Index, q: Tensor, redrawn: Tensor) -> list[float]:
    """Return the largest relative change of an index when one joint alone is redrawn, for each joint."""
    f = index.bind(chain)
    before = f(q)
    return [_largest(f(_with_joint(q, redrawn, i)) / before - 1) for i in range(chain.joints)]


# ---- deviations ------------------------------------------------------------------------------------


def equation_6_as_printed(chain: Chain, q: Tensor) -> Tensor:
    """Return the columns of Eq. 6 with the home pose g_st(0) inside the adjoint: (..., n) → (..., 6, n)."""
    before = torch.eye(4, dtype=q.dtype).expand(*q.shape[:-1], 4, 4)
    columns = []
    for i, screw in enumerate(chain.screws):
        columns.append((spatial.adjoint(before @ chain.home) @ screw[:, None])[..., 0])
        before = before @ spatial.exp(screw * q[..., i, None])
    return torch.stack(columns, dim=-1)


def _with_joint(q: Tensor, redrawn: Tensor, joint: int) -> Tensor:
    changed = q.clone()
    changed[:, joint] = redrawn[:, joint]
    return changed


def _largest(difference: Tensor) -> float:
    return float(difference.abs().max())


def _twist_error(chain: Chain, q: Tensor) -> float:
    """Return by how much a joint moves a point of its own axis, or misses the plain translation."""
    points = chain.joint_frames(torch.zeros(chain.joints))[:, :3, 3]
    errors = []
    for i, (screw, kind) in enumerate(zip(chain.screws, chain.kinds, strict=True)):
        moved = spatial.apply(spatial.exp(screw * q[:, i, None]), points[i])
        expected = points[i] + (q[:, i, None] * screw[:3] if kind == "prismatic" else 0.0)
        errors.append(_largest(moved - expected))
    return max(errors)


def _product_of_expm(chain: Chain, q: Tensor) -> Tensor:
    T = np.broadcast_to(np.eye(4), (len(q), 4, 4))
    for i, screw in enumerate(chain.screws):
        T = T @ scipy.linalg.expm((spatial.hat(screw) * q[:, i, None, None]).numpy())
    return torch.as_tensor(T) @ chain.home


def _central_differences(chain: Chain, q: Tensor, step: float) -> Mapping[str, Tensor]:
    """Differentiate the tool pose numerically, and read the twist in each of the three frames."""
    T = chain.forward(q)
    columns: dict[str, list[Tensor]] = {"spatial": [], "body": [], "geometric": []}
    for shift in step * torch.eye(chain.joints, dtype=q.dtype):
        change = (chain.forward(q + shift) - chain.forward(q - shift)) / (2 * step)
        twist = _twist_of(change @ spatial.inverse(T))
        columns["spatial"].append(twist)
        columns["body"].append(_twist_of(spatial.inverse(T) @ change))
        columns["geometric"].append(torch.cat([change[..., :3, 3], twist[..., 3:]], dim=-1))
    return {frame: torch.stack(parts, dim=-1) for frame, parts in columns.items()}


def _twist_of(X: Tensor) -> Tensor:
    """Return the twist of the nearest twist matrix: differences are skew-symmetric only up to their error."""
    S = (X[..., :3, :3] - X[..., :3, :3].mT) / 2
    return torch.cat([X[..., :3, 3], torch.stack([S[..., 2, 1], S[..., 0, 2], S[..., 1, 0]], dim=-1)], dim=-1)
