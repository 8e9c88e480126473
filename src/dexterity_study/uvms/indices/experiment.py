"""w, KCI and their ellipsoids on random configurations and along three motions.

Source: Sotiropoulos & Aspragathos (2016), Eqs. 7–11 and Fig. 3. Errors and changes are relative and the largest
over all configurations.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import partial
from typing import Any, NamedTuple

import numpy as np
import torch
from scipy.stats import kendalltau
from torch import Tensor

from dexterity import indices, robots
from dexterity.chain import Chain
from dexterity.indices import Index
from dexterity_study.engine.experiment import experiment
from dexterity_study.engine.table import Row
from dexterity_study.uvms.kinematics import experiment as kinematics
from dexterity_study.uvms.kinematics.experiment import FRAMES, OF_DATA, changes_by_joint, draws, largest

RANDOM = {"seeds": 10, "smoke": {"configurations": 50}, **kinematics.ROUNDING}
ONES = (1.0,) * 6
VEHICLE_LOCKED = (0.0,) * 6 + ONES
"""Joint rates of a vehicle that keeps station while its arm moves."""

SLOW_VEHICLE = (0.5,) * 3 + (0.3,) * 3 + ONES
DECIMETRES = (0.1,) * 3 + (1.0,) * 3
"""Tool rates of one length unit a second, the unit being 0.1 m."""


class Motion(NamedTuple):
    """A sweep of one joint (from 0) by ±90° about a singular posture [degree], with the rates of all joints."""

    joint: int
    posture_deg: tuple[float, ...]
    joint_rates: tuple[float, ...]

    def angles(self, samples: int) -> np.ndarray:
        """Return angles of the joint [degree]."""
        return self.posture_deg[self.joint] + np.linspace(-90, 90, samples)

    def configurations(self, angles_deg: np.ndarray) -> Tensor:
        """Return joint values (m, 12) [rad] at some angles of the joint [degree]."""
        q = np.tile(np.radians(self.posture_deg), (len(angles_deg), 1))
        q[:, self.joint] = np.radians(angles_deg)
        return torch.as_tensor(q)


_STRAIGHT = (0,) * 6 + (20, 30, 0, 25, 30, 0)
MOTIONS: Mapping[str, Motion] = {
    "arm, elbow": Motion(8, _STRAIGHT, VEHICLE_LOCKED),
    "UVMS, elbow": Motion(8, _STRAIGHT, ONES * 2),
    "UVMS, roll": Motion(4, (0, 0, 0, 0, 90, 90, 0, 30, -30, 0, 90, 0), ONES * 2),
}
"""Motions through a singularity. The third needs a gimbal lock and a wrist that cannot make up for it."""


@experiment(**RANDOM, **OF_DATA)
def formulas(seed: int, configurations: int = 2000) -> Iterator[Row]:
    """Formulas of section 2.3 against others that say the same."""
    chain = robots.uvms()
    q, _ = draws(chain, seed, configurations)
    J = chain.spatial_jacobian(q)
    w, kci = indices.manipulability(J), indices.kinematic_conditioning(J)
    ellipsoid, force = indices.velocity_ellipsoid(J), indices.force_ellipsoid(J)
    frames = [indices.manipulability(getattr(chain, f"{frame}_jacobian")(q)) for frame in FRAMES]
    yield {
        "determinant": largest(torch.linalg.det(J @ J.mT).sqrt() / w - 1),
        "unit_free": _change_of_units(J),
        "w_length": _spread(indices.manipulability(indices.normalise(J, ONES * 2, DECIMETRES)) / w),
        "condition": largest(kci * torch.as_tensor(np.linalg.cond(J.numpy())) - 1),
        "w_frame": max(largest(in_frame / w - 1) for in_frame in frames),
        "volume": _spread(ellipsoid.volume / w),
        "reciprocal": largest(ellipsoid.semi_axes * force.semi_axes - 1),
        "outside": _outside(J, torch.Generator().manual_seed(seed + 1000)),
    }


@experiment(keys=("pair",), **RANDOM, **OF_DATA)
def rankings(seed: int, configurations: int = 2000) -> Iterator[Row]:
    """Kendall's τ between two rankings of the same configurations."""
    chain = robots.uvms()
    q, _ = draws(chain, seed, configurations)
    near_home, _ = draws(chain, seed, configurations, range_deg=15.0)
    J = chain.spatial_jacobian(q)
    in_decimetres = indices.normalise(J, ONES * 2, DECIMETRES)
    slow = indices.normalise(J, SLOW_VEHICLE, ONES)
    w, kci = indices.manipulability(J), indices.kinematic_conditioning(J)
    pairs = {
        "KCI, tool rates of 1 m/s against 0.1 m/s": (kci, indices.kinematic_conditioning(in_decimetres)),
        "w, unit joint limits against a slow vehicle": (w, indices.manipulability(slow)),
        **_indices_against_the_tool(chain, q),
        **{f"{pair}, near home": both for pair, both in _indices_against_the_tool(chain, near_home).items()},
    }
    yield from rank_correlations(pairs)


@experiment(keys=("joint",), **RANDOM, **kinematics.IN_OTHER_FRAMES)
def changes_of_kci(seed: int, reading: Mapping[str, Any], configurations: int = 2000) -> Iterator[Row]:
    """Largest relative change of KCI when one joint alone is redrawn."""
    index = Index("kinematic_conditioning", reading["which-jacobian"])
    yield from changes_by_joint(index, seed, configurations)


@experiment(**RANDOM, **OF_DATA)
def conditioning(seed: int, configurations: int = 2000) -> Iterator[Row]:
    """Dependence of KCI on frame and origin."""
    chain, kci = robots.uvms(), partial(Index, "kinematic_conditioning")
    home = torch.zeros(chain.joints)
    moved = torch.zeros(configurations, chain.joints, dtype=torch.float64)
    moved[:, :3] = 2 * draws(chain, seed, configurations)[0][:, :3]
    about_origin = kci("spatial").bind(chain)(moved)
    *_, last_joint = changes_by_joint(kci("body", tool_rates=(1, 1, 2, 1, 1, 1)), seed, configurations)
    yield {
        **{f"home_{frame}": kci(frame).bind(chain)(home) for frame in FRAMES},
        "lowest": about_origin.min(),
        "highest": about_origin.max(),
        "body_last_joint_unequal": last_joint["change"],
        "vehicle_alone": kci(joint_rates=ONES + (0.0,) * 6).bind(chain)(home),
    }


@experiment(
    keys=("motion",), arrays=("angle", "w", "kci"), smoke={"samples": 19}, **kinematics.ROUNDING, **OF_DATA
)
def motions(samples: int = 181) -> tuple[list[dict[str, Any]], dict[str, Any]]:
    """Measure w and the spatial KCI along motions through a singularity."""
    chain = robots.uvms()
    rows, curves = [], []
    for name, motion in MOTIONS.items():
        angles = motion.angles(samples)
        J = indices.normalise(chain.spatial_jacobian(motion.configurations(angles)), motion.joint_rates, ONES)
        w, kci = indices.manipulability(J), indices.kinematic_conditioning(J)
        singular = J[samples // 2]
        left = (indices.velocity_ellipsoid(singular).axes[:, -1] @ singular).norm()
        rows.append({"motion": name, "smallest_w": w.min(), "smallest_kci": kci.min(), "speed_left": left})
        curves.append((angles, w, kci))
    return rows, dict(zip(("angle", "w", "kci"), map(np.array, zip(*curves, strict=True)), strict=True))


def rank_correlations(pairs: Mapping[str, tuple[Tensor, Tensor]]) -> Iterator[Row]:
    """Yield Kendall's τ of two rankings of the same candidates, each by values (m,)."""
    for pair, (first, second) in pairs.items():
        yield {"pair": pair, "tau": kendalltau(first.numpy(), second.numpy()).statistic}


def _indices_against_the_tool(chain: Chain, q: Tensor) -> Mapping[str, tuple[Tensor, Tensor]]:
    """Return each index and what it is said to grade, at configurations (m, n)."""
    J, Jg = chain.spatial_jacobian(q), chain.geometric_jacobian(q)
    w, kci = indices.manipulability(J), indices.kinematic_conditioning(J)
    about_tool = indices.kinematic_conditioning(Jg)
    speeds = indices.velocity_ellipsoid(Jg, "translational").semi_axes
    accuracy = -indices.velocity_ellipsoid(Jg).semi_axes[:, 0]
    return {
        "KCI, spatial against geometric frame": (kci, about_tool),
        "w against the largest speed of the tool point": (w, speeds[:, 0]),
        "w against the smallest speed of the tool point": (w, speeds[:, -1]),
        "spatial KCI against accuracy of the tool": (kci, accuracy),
        "geometric KCI against accuracy of the tool": (about_tool, accuracy),
    }


def _spread(ratio: Tensor) -> float:
    return float((ratio.max() - ratio.min()) / ratio.mean())


def _change_of_units(J: Tensor) -> float:
    """Return the change of w and KCI when metres become millimetres and the limits are converted too."""
    metres = indices.normalise(J, SLOW_VEHICLE, (0.4,) * 3 + (0.7,) * 3)
    in_millimetres = J.clone()
    in_millimetres[..., :3, 3:] *= 1000.0
    in_millimetres[..., 3:, :3] /= 1000.0
    millimetres = indices.normalise(
        in_millimetres, (500.0,) * 3 + SLOW_VEHICLE[3:], (400.0,) * 3 + (0.7,) * 3
    )
    measures = (indices.manipulability, indices.kinematic_conditioning)
    return max(largest(measure(millimetres) / measure(metres) - 1) for measure in measures)


def _outside(J: Tensor, random: torch.Generator) -> float:
    """Return by how much J u with ‖u‖ = 1 leaves the ellipsoid."""
    rates = torch.randn(len(J), J.shape[-1], generator=random, dtype=J.dtype)
    velocity = J @ (rates / rates.norm(dim=-1, keepdim=True))[..., None]
    ellipsoid = indices.velocity_ellipsoid(J)
    along_axes = (ellipsoid.axes.mT @ velocity)[..., 0] / ellipsoid.semi_axes
    return max(0.0, float(along_axes.norm(dim=-1).max()) - 1)
