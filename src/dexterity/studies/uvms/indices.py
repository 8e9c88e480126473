"""Paper A, section 2.3: what w, KCI and the ellipsoids are, and what they depend on.

Sotiropoulos & Aspragathos (2016), Eqs. 7–11 and Fig. 3.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from scipy.stats import kendalltau
from torch import Tensor

from dexterity import robots
from dexterity.chain import Chain
from dexterity.indices import (
    Frame,
    Index,
    force_ellipsoid,
    kinematic_conditioning,
    manipulability,
    normalise,
    velocity_ellipsoid,
)
from dexterity.report.claims import Acceptance, Outcome, Verdict
from dexterity.report.stored import Tolerance
from dexterity.studies.uvms.kinematics import LIMITS, changes_by_joint

__all__ = [
    "CONFIGS",
    "FRAMES",
    "MOTIONS",
    "TOLERANCE",
    "VEHICLE_LOCKED",
    "Config",
    "Motion",
    "Result",
    "acceptance",
    "along",
    "configurations",
    "rank_correlation",
    "run",
    "verdicts",
]

FRAMES: tuple[Frame, ...] = ("spatial", "body", "geometric")
"""All frames that an index can be taken in."""

VEHICLE_LOCKED = (0.0,) * 6 + (1.0,) * 6
"""Joint rates of a vehicle that keeps station while its arm moves."""

DECIMETRES = (0.1,) * 3 + (1.0,) * 3  # tool rates: one length unit a second, the unit being 0.1 m
ARM_LOCKED = (1.0,) * 6 + (0.0,) * 6


TOLERANCE = Tolerance(rtol=1e-6, atol=1e-6)
"""What a probe may miss by, since rounding errors come out a little different on every processor."""


@dataclass(frozen=True)
class Config:
    """Random configurations: translations within ±1 m, rotations within ±`range_deg` degrees."""

    configurations: int = 2000
    range_deg: float = 60.0
    samples: int = 181  # points along a motion
    seed: int = 1


CONFIGS: Mapping[str, Config] = {
    "smoke": Config(configurations=50, samples=19),
    "book": Config(),
    "full": Config(configurations=50_000),
}
"""What runs at each scale."""


@dataclass(frozen=True)
class Motion:
    """One joint swept through a singularity while the others rest.

    Attributes
    ----------
    title
        What moves.
    joint
        Position of the joint that moves, from 0.
    at_deg
        The other joints' angles [degree], and the swept joint's value at the singularity.
    from_deg, to_deg
        Ends of the sweep [degree].
    joint_rates
        Largest joint rates; zeros lock joints.
    """

    title: str
    joint: int
    at_deg: tuple[float, ...]
    from_deg: float
    to_deg: float
    joint_rates: tuple[float, ...]


MOTIONS: Mapping[str, Motion] = {
    "arm, elbow": Motion(
        "arm alone: the elbow passes through straight",
        8, (0,) * 6 + (20, 30, 0, 25, 30, 0), -90, 90, VEHICLE_LOCKED,
    ),
    "UVMS, elbow": Motion(
        "UVMS: the same motion with the vehicle free",
        8, (0,) * 6 + (20, 30, 0, 25, 30, 0), -90, 90, (1.0,) * 12,
    ),
    "UVMS, pitch": Motion(
        "UVMS: the pitch passes through 90° while all rotary axes fall into one plane",
        4, (0, 0, 0, 0, 90, 90, 0, 30, -30, 0, 90, 0), 0, 180, (1.0,) * 12,
    ),
}  # fmt: skip
"""Motions through a singularity. The third needs a gimbal lock and a wrist that cannot make up for it."""


@dataclass(frozen=True)
class Result:
    """What the indices did on random configurations and along three motions.

    Errors and changes are the largest over all configurations; changes are relative.

    Attributes
    ----------
    determinant_error
        √det(JJᵀ) against the product of singular values.
    unit_free_change
        Change of w and KCI when metres become millimetres and the limits are converted too.
    kci_length_tau, w_length_spread
        Unit tool rates hide a length. With 1 dm/s for 1 m/s: rank correlation of KCI before and after;
        relative spread of the ratio of w before and after (none: a common factor).
    w_limits_tau
        Rank correlation of w between unit joint rates and those of a slow vehicle.
    condition_error
        KCI against `numpy.linalg.cond`.
    w_frame_change
        Change of w from frame to frame.
    kci_home
        KCI at home for each of `FRAMES`.
    kci_frame_tau
        Rank correlation of the spatial KCI with the geometric one.
    kci_origin_range
        Smallest and largest spatial KCI at home while the vehicle starts elsewhere within 2 m.
    kci_spatial_change, kci_body_change
        Change of KCI when one joint alone is redrawn, for each joint.
    kci_body_last_joint_unequal
        Change of the body KCI under θ12 when the tool rates differ within a block.
    kci_ten_inputs_error
        Change of the spatial KCI when the position turns with θ4.
    volume_spread
        Relative spread of the ratio of ellipsoid volume to w.
    reciprocal_error
        Product of the semi-axes of velocity and force ellipsoid, less one.
    inside_error
        By how much J u, ‖u‖ = 1, leaves the ellipsoid.
    isotropic_kci
        KCI of the vehicle alone at home.
    lost_direction_speed
        Largest speed along the lost direction at the UVMS's singularity, per unit joint rates.
    speed_tau
        Rank correlation of w with the largest and with the smallest speed of the tool point.
    accuracy_tau
        Rank correlation of the spatial and of the geometric KCI with the smallness of the tool error
        that joint errors of unit norm can cause.
    sweep_deg, sweep_w, sweep_kci
        Swept angle [degree], w and spatial KCI along `MOTIONS`, by name.
    """

    determinant_error: float
    unit_free_change: float
    kci_length_tau: float
    w_length_spread: float
    w_limits_tau: float
    condition_error: float
    w_frame_change: float
    kci_home: tuple[float, ...]
    kci_frame_tau: float
    kci_origin_range: tuple[float, float]
    kci_spatial_change: tuple[float, ...]
    kci_body_change: tuple[float, ...]
    kci_body_last_joint_unequal: float
    kci_ten_inputs_error: float
    volume_spread: float
    reciprocal_error: float
    inside_error: float
    isotropic_kci: float
    lost_direction_speed: float
    speed_tau: tuple[float, float]
    accuracy_tau: tuple[float, float]
    sweep_deg: dict[str, NDArray[np.float64]]
    sweep_w: dict[str, NDArray[np.float64]]
    sweep_kci: dict[str, NDArray[np.float64]]


def run(config: Config) -> Result:
    """Evaluate everything on one sample of configurations."""
    chain = robots.uvms()
    random = torch.Generator().manual_seed(config.seed)
    q, redrawn = _draw(config, random), _draw(config, random)
    jacobians = {frame: getattr(chain, f"{frame}_jacobian")(q) for frame in FRAMES}
    w = {frame: manipulability(J) for frame, J in jacobians.items()}
    kci = {frame: kinematic_conditioning(J) for frame, J in jacobians.items()}
    J = jacobians["spatial"]
    ellipsoid, force = velocity_ellipsoid(J), force_ellipsoid(J)
    sweeps = {name: along(motion, config.samples) for name, motion in MOTIONS.items()}
    home = torch.zeros(chain.joints)
    return Result(
        determinant_error=_largest(torch.linalg.det(J @ J.mT).sqrt() / w["spatial"] - 1),
        unit_free_change=_unit_free_change(J),
        kci_length_tau=rank_correlation(
            kci["spatial"], kinematic_conditioning(normalise(J, LIMITS["unit"], DECIMETRES))
        ),
        w_length_spread=_spread(manipulability(normalise(J, LIMITS["unit"], DECIMETRES)) / w["spatial"]),
        w_limits_tau=rank_correlation(w["spatial"], manipulability(normalise(J, LIMITS["rov"], (1.0,) * 6))),
        condition_error=_largest(kci["spatial"] * torch.as_tensor(np.linalg.cond(J.numpy())) - 1),
        w_frame_change=max(_largest(w[frame] / w["spatial"] - 1) for frame in FRAMES),
        kci_home=tuple(float(_kci(frame).bind(chain)(home)) for frame in FRAMES),
        kci_frame_tau=rank_correlation(kci["spatial"], kci["geometric"]),
        kci_origin_range=_kci_origin_range(chain, config, random),
        kci_spatial_change=changes_by_joint(chain, _kci("spatial"), q, redrawn),
        kci_body_change=changes_by_joint(chain, _kci("body"), q, redrawn),
        kci_body_last_joint_unequal=changes_by_joint(
            chain, Index("kinematic_conditioning", "body", tool_rates=(1, 1, 2, 1, 1, 1)), q, redrawn
        )[11],
        kci_ten_inputs_error=_ten_inputs_error(chain, q, redrawn),
        volume_spread=_spread(ellipsoid.volume / w["spatial"]),
        reciprocal_error=_largest(ellipsoid.semi_axes * force.semi_axes - 1),
        inside_error=_inside_error(J, random),
        isotropic_kci=float(
            Index("kinematic_conditioning", joint_rates=ARM_LOCKED).bind(chain)(torch.zeros(chain.joints))
        ),
        lost_direction_speed=_lost_direction_speed(chain, MOTIONS["UVMS, pitch"]),
        speed_tau=_speed_tau(w["spatial"], jacobians["geometric"]),
        accuracy_tau=_accuracy_tau(kci["spatial"], kci["geometric"], jacobians["geometric"]),
        sweep_deg={name: sweep[0] for name, sweep in sweeps.items()},
        sweep_w={name: sweep[1] for name, sweep in sweeps.items()},
        sweep_kci={name: sweep[2] for name, sweep in sweeps.items()},
    )


def along(motion: Motion, samples: int) -> tuple[Any, Any, Any]:
    """Swept angle [degree], w and spatial KCI along a motion, `samples` values each."""
    chain = robots.uvms()
    angles = np.linspace(motion.from_deg, motion.to_deg, samples)
    q = configurations(motion, angles)
    w, kci = (
        Index(name, joint_rates=motion.joint_rates).bind(chain)(q).numpy()
        for name in ("manipulability", "kinematic_conditioning")
    )
    return angles, w, kci


def configurations(motion: Motion, angles_deg: NDArray[np.float64]) -> Tensor:
    """Joint values (m, 12) [rad] of a motion at the given angles of its joint [degree]."""
    q = np.tile(np.radians(motion.at_deg), (len(angles_deg), 1))
    q[:, motion.joint] = np.radians(angles_deg)
    return torch.as_tensor(q)


def rank_correlation(a: Tensor, b: Tensor) -> float:
    """Kendall's τ of two rankings of the same candidates, each by values (m,)."""
    return float(kendalltau(a.numpy(), b.numpy()).statistic)


def verdicts(result: Result) -> tuple[Verdict, ...]:
    """Judge the claims of the ledger that this study answers for.

    A claim that one quantity tells another is judged by Kendall's τ, see
    :meth:`dexterity.report.claims.Outcome.of_correlation`. Where there are several readings the kindest
    counts.
    """
    origin_low, origin_high = result.kci_origin_range
    return (
        _verdict(
            "normalised-jacobian",
            result.unit_free_change < 1e-9,
            f"{result.unit_free_change:.0e}",
            "With limits that carry units, neither index depends on the unit of length; with tool rates "
            f"of one, KCI does (τ = {result.kci_length_tau:.2f} between metres and decimetres).",
        ),
        _verdict(
            "w-product-of-singular-values",
            result.determinant_error < 1e-9,
            f"{result.determinant_error:.0e}",
            "Agrees with Eq. 9 to this relative error.",
        ),
        _verdict(
            "w-root-determinant",
            result.determinant_error < 1e-9,
            f"{result.determinant_error:.0e}",
            "Agrees with Eq. 8 to this relative error; close to a singularity Eq. 9 has half the digits.",
        ),
        Verdict(
            "sotiropoulos2016", "ellipsoid-axes", Outcome.UNDERSPECIFIED,
            f"{result.inside_error:.0e}", "",
            "A 6 × 12 matrix has no eigenvectors. With left singular vectors the statement holds: no "
            "velocity of unit joint rates leaves the ellipsoid by more than this.",
        ),
        _verdict(
            "w-ellipsoid-volume",
            result.volume_spread < 1e-9,
            f"{result.volume_spread:.0e}",
            "Relative spread of the ratio, π³/6 in six dimensions.",
        ),
        _verdict(
            "force-ellipsoid-reciprocal",
            result.reciprocal_error < 1e-9,
            f"{result.reciprocal_error:.0e}",
            "Same axes, reciprocal semi-axes, by duality of twists and wrenches.",
        ),
        _verdict(
            "major-axis-fast-minor-axis-strong",
            result.reciprocal_error < 1e-9,
            "speed × force = 1",
            "Along each principal axis; what is gained in speed is lost in force.",
        ),
        _verdict(
            "zero-w-loses-directions",
            result.lost_direction_speed < 1e-12,
            f"{result.lost_direction_speed:.0e}",
            "Speed left along the lost direction at the singularity of the whole UVMS.",
        ),
        Verdict(
            "sotiropoulos2016", "w-means-speed", Outcome.of_correlation(max(result.speed_tau)),
            f"τ = {result.speed_tau[0]:.2f} and {result.speed_tau[1]:.2f}", "largest and smallest speed",
            "Kendall's τ of w with the speed of the tool point; w is a volume, no speed.",
        ),
        Verdict(
            "sotiropoulos2016", "translational-ellipsoid", Outcome.UNDERSPECIFIED, "", "",
            "True of the geometric Jacobian's linear rows; those of the spatial Jacobian, which the paper "
            "uses, are not the velocity of the tool point.",
        ),
        _verdict(
            "kci-ratio", result.condition_error < 1e-9, f"{result.condition_error:.0e}",
            "Agrees with one over numpy's condition number to this relative error.",
        ),
        _verdict(
            "kci-one-is-isotropic",
            abs(result.isotropic_kci - 1) < 1e-12,
            f"{result.isotropic_kci:.3f}",
            "Reached by the vehicle alone at home about the world's origin: its Jacobian is the identity.",
        ),
        Verdict(
            "sotiropoulos2016", "kci-means-accuracy", Outcome.of_correlation(max(result.accuracy_tau)),
            f"τ = {result.accuracy_tau[0]:.2f} and {result.accuracy_tau[1]:.2f}", "spatial and geometric",
            "Kendall's τ of KCI with the smallness of the tool error that small joint errors cause; KCI "
            "tells how evenly errors spread, and only through that how large they are.",
        ),
        _verdict(
            "kci-last-joint-irrelevant",
            max(result.kci_spatial_change[11], result.kci_body_change[11]) < 1e-12,
            f"{result.kci_spatial_change[11]:.0e}",
            "In the spatial frame always; in the body frame only while tool rates are equal within a block "
            f"(else up to {result.kci_body_last_joint_unequal:.0%}).",
        ),
        Verdict(
            "sotiropoulos2016", "kci-eleven-joints",
            Outcome.IN_SHAPE if min(result.kci_spatial_change[:11]) > 1e-3 else Outcome.NOT_REPRODUCED,
            f"from {min(result.kci_spatial_change[:11]):.0%} to {max(result.kci_spatial_change[:11]):.0%}",
            "",
            "True about a fixed world origin, whose choice alone moves KCI at home from "
            f"{origin_low:.2f} to {origin_high:.2f}; θ1 to θ4 enter through three numbers only, and in the "
            "body frame not at all.",
        ),
    )  # fmt: skip


def acceptance(result: Result) -> tuple[Acceptance, ...]:
    """Figures that must hold for the book to be built."""
    return (
        Acceptance("w by Eq. 8 against Eq. 9, relative", result.determinant_error, 1e-9),
        Acceptance("w from frame to frame, relative", result.w_frame_change, 1e-12),
        Acceptance("spatial KCI under θ12, relative", result.kci_spatial_change[11], 1e-12),
        Acceptance("body KCI under θ1–θ4, relative", max(result.kci_body_change[:4]), 1e-12),
        Acceptance("w of the arm with its elbow straight", float(result.sweep_w["arm, elbow"].min()), 1e-12),
        Acceptance("w of the UVMS at its singularity", float(result.sweep_w["UVMS, pitch"].min()), 1e-12),
    )


def _verdict(claim: str, holds: bool, ours: str, sentence: str) -> Verdict:
    return Verdict("sotiropoulos2016", claim, Outcome.of(holds), ours, "", sentence)


def _kci(frame: Frame) -> Index:
    return Index("kinematic_conditioning", frame)


def _draw(config: Config, random: torch.Generator) -> Tensor:
    half_range = torch.full((12,), np.radians(config.range_deg), dtype=torch.float64)
    half_range[:3] = 1.0
    return (2 * torch.rand(config.configurations, 12, generator=random, dtype=torch.float64) - 1) * half_range


def _largest(difference: Tensor) -> float:
    return float(difference.abs().max())


def _spread(ratio: Tensor) -> float:
    return float((ratio.max() - ratio.min()) / ratio.mean())


def _unit_free_change(J: Tensor) -> float:
    metres = normalise(J, LIMITS["rov"], (0.4,) * 3 + (0.7,) * 3)
    in_millimetres = J * torch.tensor([1.0] * 3 + [1000.0] * 9, dtype=J.dtype)
    in_millimetres = torch.cat([in_millimetres[..., :3, :], J[..., 3:, :]], dim=-2)
    millimetres = normalise(in_millimetres, (500.0,) * 3 + (0.3,) * 3 + (1.0,) * 6, (400.0,) * 3 + (0.7,) * 3)
    return max(
        _largest(measure(millimetres) / measure(metres) - 1)
        for measure in (manipulability, kinematic_conditioning)
    )


def _kci_origin_range(chain: Chain, config: Config, random: torch.Generator) -> tuple[float, float]:
    q = torch.zeros(config.configurations, 12, dtype=torch.float64)
    q[:, :3] = 4 * torch.rand(config.configurations, 3, generator=random, dtype=torch.float64) - 2
    kci = _kci("spatial").bind(chain)(q)
    return float(kci.min()), float(kci.max())


def _ten_inputs_error(chain: Chain, q: Tensor, redrawn: Tensor) -> float:
    """Turn the vehicle and its position about the world's x axis together: KCI must not notice."""
    angle = redrawn[:, 3]
    c, s = angle.cos(), angle.sin()
    turned = q.clone()
    turned[:, 1] = c * q[:, 1] - s * q[:, 2]
    turned[:, 2] = s * q[:, 1] + c * q[:, 2]
    turned[:, 3] = q[:, 3] + angle
    f = _kci("spatial").bind(chain)
    return _largest(f(turned) / f(q) - 1)


def _inside_error(J: Tensor, random: torch.Generator) -> float:
    rates = torch.randn(len(J), J.shape[-1], generator=random, dtype=J.dtype)
    velocity = J @ (rates / rates.norm(dim=-1, keepdim=True))[..., None]
    ellipsoid = velocity_ellipsoid(J)
    along_axes = (ellipsoid.axes.mT @ velocity)[..., 0] / ellipsoid.semi_axes
    return max(0.0, float(along_axes.norm(dim=-1).max()) - 1)


def _lost_direction_speed(chain: Chain, motion: Motion) -> float:
    J = chain.spatial_jacobian(torch.as_tensor(np.radians(motion.at_deg)))
    lost = velocity_ellipsoid(J).axes[:, -1]
    return float((lost @ J).norm())


def _speed_tau(w: Tensor, geometric: Tensor) -> tuple[float, float]:
    speeds = velocity_ellipsoid(geometric, "translational").semi_axes
    return rank_correlation(w, speeds[:, 0]), rank_correlation(w, speeds[:, -1])


def _accuracy_tau(spatial_kci: Tensor, geometric_kci: Tensor, geometric: Tensor) -> tuple[float, float]:
    worst_error = velocity_ellipsoid(geometric).semi_axes[:, 0]
    return rank_correlation(spatial_kci, -worst_error), rank_correlation(geometric_kci, -worst_error)
