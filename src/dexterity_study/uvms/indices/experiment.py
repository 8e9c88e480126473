"""w, KCI and their ellipsoids on random configurations and along three motions.

Source: Sotiropoulos & Aspragathos (2016), Eqs. 7–11 and Fig. 3. Errors and changes are relative and the largest
over all configurations.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from scipy.stats import kendalltau
from torch import Tensor

from dexterity import robots
from dexterity.indices import (
    Frame,
    Index,
    force_ellipsoid,
    kinematic_conditioning,
    manipulability,
    normalise,
    velocity_ellipsoid,
)
from dexterity_study.engine.experiment import experiment
from dexterity_study.uvms.kinematics.experiment import OF_DATA, PAPER, ROUNDING, changes_by_joint, draws

FRAMES: tuple[Frame, ...] = ("spatial", "body", "geometric")
ONES = (1.0,) * 6
VEHICLE_LOCKED = (0.0,) * 6 + (1.0,) * 6
"""Joint rates of a vehicle that keeps station while its arm moves."""

SLOW_VEHICLE = (0.5,) * 3 + (0.3,) * 3 + (1.0,) * 6
DECIMETRES = (0.1,) * 3 + (1.0,) * 3
"""Tool rates of one length unit a second, the unit being 0.1 m."""


@dataclass(frozen=True)
class Motion:
    """One joint swept through a singularity while the others rest: angles [degree], joint from 0."""

    title: str
    joint: int
    at_deg: tuple[float, ...]
    from_deg: float
    to_deg: float
    joint_rates: tuple[float, ...]


_ELBOW = (0,) * 6 + (20, 30, 0, 25, 30, 0)
_PITCH = (0, 0, 0, 0, 90, 90, 0, 30, -30, 0, 90, 0)
MOTIONS: Mapping[str, Motion] = {
    "arm, elbow": Motion("arm alone: the elbow passes through straight", 8, _ELBOW, -90, 90, VEHICLE_LOCKED),
    "UVMS, elbow": Motion("UVMS: the same motion with the vehicle free", 8, _ELBOW, -90, 90, (1.0,) * 12),
    "UVMS, pitch": Motion(
        "UVMS: the pitch passes through 90° while all rotary axes fall into one plane",
        4,
        _PITCH,
        0,
        180,
        (1.0,) * 12,
    ),
}
"""Motions through a singularity. The third needs a gimbal lock and a wrist that cannot make up for it."""


@experiment(seeds=10, smoke={"configurations": 50}, **ROUNDING, **OF_DATA)
def formulas(seed: int, configurations: int = 2000) -> Iterator[dict[str, Any]]:
    """Formulas of section 2.3 against others that say the same."""
    chain = robots.uvms()
    q, _ = draws(chain, seed, configurations)
    J = chain.spatial_jacobian(q)
    w, kci = manipulability(J), kinematic_conditioning(J)
    ellipsoid, force = velocity_ellipsoid(J), force_ellipsoid(J)
    frames = [manipulability(getattr(chain, f"{frame}_jacobian")(q)) for frame in FRAMES]
    yield {
        "determinant": _largest(torch.linalg.det(J @ J.mT).sqrt() / w - 1),
        "unit_free": _change_of_units(J),
        "w_length": _spread(manipulability(normalise(J, (1.0,) * 12, DECIMETRES)) / w),
        "condition": _largest(kci * torch.as_tensor(np.linalg.cond(J.numpy())) - 1),
        "w_frame": max(_largest(own / w - 1) for own in frames),
        "volume": _spread(ellipsoid.volume / w),
        "reciprocal": _largest(ellipsoid.semi_axes * force.semi_axes - 1),
        "outside": _outside(J, torch.Generator().manual_seed(seed + 1000)),
    }


@experiment(seeds=10, keys=("pair",), smoke={"configurations": 50}, **ROUNDING, **OF_DATA)
def rankings(seed: int, configurations: int = 2000) -> Iterator[dict[str, Any]]:
    """Kendall's τ between two rankings of the same configurations."""
    chain = robots.uvms()
    q, _ = draws(chain, seed, configurations)
    J, Jg = chain.spatial_jacobian(q), chain.geometric_jacobian(q)
    w, kci, about_tool = manipulability(J), kinematic_conditioning(J), kinematic_conditioning(Jg)
    speeds = velocity_ellipsoid(Jg, "translational").semi_axes
    accuracy = -velocity_ellipsoid(Jg).semi_axes[:, 0]
    pairs = {
        "KCI, spatial against geometric frame": (kci, about_tool),
        "KCI, tool rates of 1 m/s against 0.1 m/s": (
            kci,
            kinematic_conditioning(normalise(J, (1.0,) * 12, DECIMETRES)),
        ),
        "w, unit joint limits against a slow vehicle": (w, manipulability(normalise(J, SLOW_VEHICLE, ONES))),
        "w against the largest speed of the tool point": (w, speeds[:, 0]),
        "w against the smallest speed of the tool point": (w, speeds[:, -1]),
        "spatial KCI against accuracy of the tool": (kci, accuracy),
        "geometric KCI against accuracy of the tool": (about_tool, accuracy),
    }
    for pair, (first, second) in pairs.items():
        yield {"pair": pair, "tau": rank_correlation(first, second)}


@experiment(
    seeds=10,
    keys=("joint",),
    assumes=("which-jacobian",),
    readings=("which-jacobian=body", "which-jacobian=geometric"),
    smoke={"configurations": 50},
    **ROUNDING,
    **PAPER,
    **OF_DATA,
)
def changes_of_kci(
    seed: int, reading: Mapping[str, Any], configurations: int = 2000
) -> Iterator[dict[str, Any]]:
    """Largest relative change of KCI when one joint alone is redrawn."""
    chain = robots.uvms()
    q, redrawn = draws(chain, seed, configurations)
    index = Index("kinematic_conditioning", reading["which-jacobian"])
    for joint, change in enumerate(changes_by_joint(chain, index, q, redrawn)):
        yield {"joint": joint, "change": change}


@experiment(seeds=10, smoke={"configurations": 50}, **ROUNDING, **OF_DATA)
def conditioning(seed: int, configurations: int = 2000) -> Iterator[dict[str, Any]]:
    """Dependence of KCI on frame and origin."""
    chain = robots.uvms()
    q, redrawn = draws(chain, seed, configurations)
    home = torch.zeros(chain.joints)
    moved = torch.zeros(configurations, 12, dtype=torch.float64)
    moved[:, :3] = 2 * q[:, :3]
    about_origin = _kci("spatial").bind(chain)(moved)
    unequal = Index("kinematic_conditioning", "body", tool_rates=(1, 1, 2, 1, 1, 1))
    alone = Index("kinematic_conditioning", joint_rates=(1.0,) * 6 + (0.0,) * 6)
    yield {
        **{f"home_{frame}": _kci(frame).bind(chain)(home) for frame in FRAMES},
        "lowest": about_origin.min(),
        "highest": about_origin.max(),
        "body_last_joint_unequal": changes_by_joint(chain, unequal, q, redrawn)[11],
        "vehicle_alone": alone.bind(chain)(home),
    }


@experiment(
    keys=("motion",),
    arrays=("angle", "w", "kci"),
    smoke={"samples": 19},
    **ROUNDING,
    **OF_DATA,
)
def motions(seed: int, samples: int = 181) -> tuple[list[dict[str, Any]], dict[str, Any]]:  # noqa: ARG001 -- nothing is drawn
    """Measure w and the spatial KCI along motions through a singularity."""
    chain = robots.uvms()
    rows, curves = [], []
    for name, motion in MOTIONS.items():
        angles = np.linspace(motion.from_deg, motion.to_deg, samples)
        q = configurations_of(motion, angles)
        w, kci = (
            Index(index, joint_rates=motion.joint_rates).bind(chain)(q).numpy()
            for index in ("manipulability", "kinematic_conditioning")
        )
        J = chain.spatial_jacobian(torch.as_tensor(np.radians(motion.at_deg)))
        lost = velocity_ellipsoid(normalise(J, motion.joint_rates, ONES)).axes[:, -1]
        left = (lost @ normalise(J, motion.joint_rates, ONES)).norm()
        rows.append({"motion": name, "smallest_w": w.min(), "smallest_kci": kci.min(), "speed_left": left})
        curves.append((angles, w, kci))
    angle, w, kci = (np.array(column) for column in zip(*curves, strict=True))
    return rows, {"angle": angle, "w": w, "kci": kci}


# ---- shared with pages and other chapters ----------------------------------------------------------


def configurations_of(motion: Motion, angles_deg: NDArray[np.float64]) -> Tensor:
    """Return joint values (m, 12) [rad] of a motion at some angles of its joint [degree]."""
    q = np.tile(np.radians(motion.at_deg), (len(angles_deg), 1))
    q[:, motion.joint] = np.radians(angles_deg)
    return torch.as_tensor(q)


def rank_correlation(first: Tensor, second: Tensor) -> float:
    """Return Kendall's τ of two rankings of the same candidates, each by values (m,)."""
    return float(kendalltau(first.numpy(), second.numpy()).statistic)


# ---- deviations ------------------------------------------------------------------------------------


def _kci(frame: Frame) -> Index:
    return Index("kinematic_conditioning", frame)


def _largest(difference: Tensor) -> float:
    return float(difference.abs().max())


def _spread(ratio: Tensor) -> float:
    return float((ratio.max() - ratio.min()) / ratio.mean())


def _change_of_units(J: Tensor) -> float:
    """Return the change of w and KCI when metres become millimetres and the limits are converted too."""
    metres = normalise(J, SLOW_VEHICLE, (0.4,) * 3 + (0.7,) * 3)
    in_millimetres = J.clone()
    in_millimetres[..., :3, 3:] *= 1000.0
    in_millimetres[..., 3:, :3] /= 1000.0
    millimetres = normalise(in_millimetres, (500.0,) * 3 + SLOW_VEHICLE[3:], (400.0,) * 3 + (0.7,) * 3)
    measures = (manipulability, kinematic_conditioning)
    return max(_largest(measure(millimetres) / measure(metres) - 1) for measure in measures)


def _outside(J: Tensor, random: torch.Generator) -> float:
    """Return by how much J u with ‖u‖ = 1 leaves the ellipsoid."""
    rates = torch.randn(len(J), J.shape[-1], generator=random, dtype=J.dtype)
    velocity = J @ (rates / rates.norm(dim=-1, keepdim=True))[..., None]
    ellipsoid = velocity_ellipsoid(J)
    along_axes = (ellipsoid.axes.mT @ velocity)[..., 0] / ellipsoid.semi_axes
    return max(0.0, float(along_axes.norm(dim=-1).max()) - 1)
