"""Paper A, sections 2.1, 2.2 and 3.1: the kinematics, and which joints can change w.

Sotiropoulos & Aspragathos (2016), Eqs. 1–6 and 12.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import scipy.linalg
import torch
from torch import Tensor

from dexterity import robots, spatial
from dexterity.chain import Chain
from dexterity.indices import Index, manipulability
from dexterity.report.claims import Acceptance, Outcome, Verdict
from dexterity.report.stored import Tolerance

__all__ = [
    "CONFIGS",
    "LIMITS",
    "TOLERANCE",
    "Config",
    "Invariance",
    "Result",
    "acceptance",
    "changes_by_joint",
    "equation_6_as_printed",
    "joints_in_turn",
    "run",
    "verdicts",
]

LIMITS: Mapping[str, tuple[float, ...]] = {
    "unit": (1.0,) * 12,
    "rov": (0.5,) * 3 + (0.3,) * 3 + (1.0,) * 6,
    "unequal translations": (0.5, 0.5, 0.1) + (0.3,) * 3 + (1.0,) * 6,
}
"""Largest joint rates [m/s, rad/s] that the index is normalised with; the paper gives none."""


TOLERANCE = Tolerance(rtol=1e-6, atol=1e-6)
"""What a probe may miss by, since rounding errors come out a little different on every processor."""


@dataclass(frozen=True)
class Config:
    """Random configurations: translations within ±1 m, rotations within ±`range_deg` degrees."""

    configurations: int = 1000
    range_deg: float = 60.0
    difference_step: float = 1e-5  # [rad] or [m], of central differences
    seed: int = 0


CONFIGS: Mapping[str, Config] = {
    "smoke": Config(configurations=20),
    "book": Config(),
    "full": Config(configurations=20_000),
}
"""What runs at each scale."""


@dataclass(frozen=True)
class Invariance:
    """Largest relative change of w when one joint alone is redrawn, for each of the joints."""

    limits: str
    change: tuple[float, ...]


@dataclass(frozen=True)
class Result:
    """Largest deviations over all configurations; positions in [m].

    Attributes
    ----------
    joints, home_position
        Number of joints, tool point at home.
    twist_error
        By how much the exponential of a joint's twist moves a point of its own axis, or misses the
        plain translation.
    forward_error
        `Chain.forward` against the product of `scipy.linalg.expm`.
    spatial_error, body_error, geometric_error
        Jacobians against central differences of `Chain.forward`.
    printed_error, printed_base_change
        Eq. 6 as printed, with the home pose in the adjoint: against the spatial Jacobian, and the
        relative change of its w under θ1–θ4, which w should not have.
    linear_rows_error
        Linear rows of the spatial Jacobian against the velocity of the tool point [m/s].
    spatial_last_joint, body_last_joint
        Change of the two Jacobians when θ12 alone is redrawn.
    invariance
        One entry for each set of limits in `LIMITS`.
    w_home, w_home_other_links, w_home_raised
        w at home; with l2 and l3 swapped; with l1 = 0.1 m.
    """

    joints: int
    home_position: tuple[float, ...]
    twist_error: float
    forward_error: float
    spatial_error: float
    body_error: float
    geometric_error: float
    printed_error: float
    printed_base_change: float
    linear_rows_error: float
    spatial_last_joint: float
    body_last_joint: float
    invariance: tuple[Invariance, ...]
    w_home: float
    w_home_other_links: float
    w_home_raised: float


def run(config: Config) -> Result:
    """Compare, difference and redraw."""
    chain = robots.uvms()
    random = torch.Generator().manual_seed(config.seed)
    q = _draw(chain, config, random)
    redrawn = _draw(chain, config, random)
    spatial_jacobian, body_jacobian = chain.spatial_jacobian(q), chain.body_jacobian(q)
    differences = _central_differences(chain, q, config.difference_step)
    geometric_jacobian = chain.geometric_jacobian(q)
    turned = _with_joint(q, redrawn, 11)
    return Result(
        joints=chain.joints,
        home_position=tuple(chain.home[:3, 3].tolist()),
        twist_error=_twist_error(chain, q),
        forward_error=_largest(chain.forward(q) - _product_of_expm(chain, q)),
        spatial_error=_largest(spatial_jacobian - differences["spatial"]),
        body_error=_largest(body_jacobian - differences["body"]),
        geometric_error=_largest(geometric_jacobian - differences["geometric"]),
        printed_error=_largest(spatial_jacobian - equation_6_as_printed(chain, q)),
        printed_base_change=_printed_base_change(chain, q, redrawn),
        linear_rows_error=_largest((spatial_jacobian - differences["geometric"])[..., :3, :]),
        spatial_last_joint=_largest(chain.spatial_jacobian(turned) - spatial_jacobian),
        body_last_joint=_largest(chain.body_jacobian(turned) - body_jacobian),
        invariance=tuple(
            Invariance(name, changes_by_joint(chain, Index("manipulability", joint_rates=rates), q, redrawn))
            for name, rates in LIMITS.items()
        ),
        w_home=_w_home(chain),
        w_home_other_links=_w_home(robots.uvms(l2=0.4, l3=0.6)),
        w_home_raised=_w_home(robots.uvms(l1=0.1)),
    )


def equation_6_as_printed(chain: Chain, q: Tensor) -> Tensor:
    """Columns of Eq. 6 with the home pose g_st(0) inside the adjoint: (..., n) → (..., 6, n)."""
    before = torch.eye(4, dtype=q.dtype).expand(*q.shape[:-1], 4, 4)
    columns = []
    for i, screw in enumerate(chain.screws):
        columns.append((spatial.adjoint(before @ chain.home) @ screw[:, None])[..., 0])
        before = before @ spatial.exp(screw * q[..., i, None])
    return torch.stack(columns, dim=-1)


def changes_by_joint(chain: Chain, index: Index, q: Tensor, redrawn: Tensor) -> tuple[float, ...]:
    """Largest relative change of an index when one joint alone is redrawn, for each joint.

    Parameters
    ----------
    chain, index
        The robot and what is evaluated on it.
    q, redrawn
        (m, n) configurations, and as many from which the redrawn values are taken.
    """
    f = index.bind(chain)
    before = f(q)
    return tuple(_largest(f(_with_joint(q, redrawn, i)) / before - 1) for i in range(chain.joints))


def joints_in_turn(chain: Chain, *, slide: float = 0.3, turn_deg: float = 40.0, frames: int = 24) -> Tensor:
    """Joint values (n · frames, n) that move each joint there and back while the others rest at zero.

    Parameters
    ----------
    chain
        The robot.
    slide, turn_deg
        How far a prismatic [m] and a revolute joint [degree] moves to either side.
    frames
        Frames for each joint.
    """
    wave = torch.sin(torch.linspace(0, 2 * torch.pi, frames, dtype=torch.float64))
    reach = [slide if kind == "prismatic" else np.radians(turn_deg) for kind in chain.kinds]
    return torch.kron(torch.diag(torch.tensor(reach, dtype=torch.float64)), wave[:, None])


def verdicts(result: Result) -> tuple[Verdict, ...]:
    """Judge the claims of the ledger that this study answers for."""
    unit, rov, unequal = result.invariance
    base, last, others = slice(0, 4), 11, slice(4, 11)
    return (
        _verdict(
            "revolute-twist",
            result.twist_error < 1e-12,
            f"axis moved by {result.twist_error:.0e} m",
            "Its exponential leaves every point of the joint's axis where it is.",
        ),
        _verdict(
            "prismatic-twist",
            result.twist_error < 1e-12,
            f"off by {result.twist_error:.0e} m",
            "Its exponential is the plain translation.",
        ),
        _verdict("twelve-joints", result.joints == 12, str(result.joints), "Vehicle and arm are one chain."),
        _setting("joint-axes", "Taken over as the description of the robot; nothing can be tested."),
        _verdict(
            "vehicle-euler-xyz",
            result.forward_error < 1e-12,
            f"{result.forward_error:.0e}",
            "As an order of turns about the moved axes x, y, z this is what Eq. 3 computes.",
        ),
        _setting("vehicle-size", "Taken over for the pictures and for y_MB = l_v/2."),
        _verdict(
            "product-of-exponentials",
            result.forward_error < 1e-12,
            f"{result.forward_error:.0e}",
            "Agrees with the product of matrix exponentials computed by scipy.",
        ),
        _verdict(
            "home-pose",
            np.allclose(result.home_position, (0, 1.75, 0), atol=1e-12),
            f"({', '.join(f'{x:g}' for x in result.home_position)}) m",
            "With y_MB = 0.75, l2 = 0.6, l3 = 0.4 and l1 = 0 assumed.",
        ),
        Verdict(
            "sotiropoulos2016",
            "jacobian-maps-rates",
            Outcome.CONTRADICTED if result.linear_rows_error > 1e-3 else Outcome.REPRODUCED,
            f"{result.linear_rows_error:.2g} m/s",
            "largest over all configurations",
            "The spatial Jacobian gives the twist of the tool body about the world's origin; its linear rows "
            "miss the velocity of the tool point by this much for unit joint rates.",
        ),
        Verdict(
            "sotiropoulos2016",
            "jacobian-columns",
            Outcome.CONTRADICTED if result.printed_error > 1e-3 else Outcome.REPRODUCED,
            f"{result.printed_error:.2g}",
            "largest over all configurations",
            "With g_st(0) inside the adjoint the columns differ from the derivative of Eq. 3 by this much; "
            f"without it they agree to {result.spatial_error:.0e}. As printed, w would also change by up to "
            f"{result.printed_base_change:.0%} under θ1 to θ4, against the claim of base invariance.",
        ),
        _verdict(
            "last-joint-irrelevant",
            result.spatial_last_joint == 0,
            f"{result.spatial_last_joint:.0e}",
            f"True of the spatial Jacobian; the body Jacobian changes by up to {result.body_last_joint:.2g}.",
        ),
        Verdict(
            "sotiropoulos2016",
            "w-base-invariant",
            Outcome.IN_SHAPE
            if max(unit.change[base]) < 1e-12 < unequal.change[3]
            else Outcome.NOT_REPRODUCED,
            f"{max(unit.change[base] + rov.change[base]):.0e}",
            f"{unequal.change[3]:.0%} under θ4 with unequal limits",
            "Holds for θ1 to θ3 always, and for θ4 only while the velocity limits in y and z are equal, "
            "which the paper does not say.",
        ),
        _verdict(
            "w-seven-joints",
            min(unit.change[others]) > 1e-3 and max(*unit.change[base], unit.change[last]) < 1e-12,
            f"{min(unit.change[others]):.1%} to {max(unit.change[others]):.1%}",
            "Each of θ5 to θ11 alone changes w by this much at most; with unequal limits θ4 is an eighth.",
        ),
    )


def acceptance(result: Result) -> tuple[Acceptance, ...]:
    """Figures that must hold for the book to be built."""
    isotropic = [entry for entry in result.invariance if entry.limits != "unequal translations"]
    unequal = next(entry for entry in result.invariance if entry.limits == "unequal translations")
    return (
        Acceptance("forward kinematics against scipy.linalg.expm", result.forward_error, 1e-12),
        Acceptance("spatial Jacobian against central differences", result.spatial_error, 1e-8),
        Acceptance("body Jacobian against central differences", result.body_error, 1e-8),
        Acceptance("geometric Jacobian against central differences", result.geometric_error, 1e-8),
        Acceptance(
            "relative change of w under θ1–θ4 and θ12, equal translation limits",
            max(max(*entry.change[:4], entry.change[11]) for entry in isotropic),
            1e-12,
        ),
        Acceptance("counter-example: θ4 leaves w alone with unequal limits", 0.01 / unequal.change[3], 1.0),
    )


def _verdict(claim: str, holds: bool, ours: str, sentence: str) -> Verdict:
    return Verdict("sotiropoulos2016", claim, Outcome.of(holds), ours, "", sentence)


def _setting(claim: str, sentence: str) -> Verdict:
    return Verdict("sotiropoulos2016", claim, Outcome.OUT_OF_SCOPE, "", "", sentence)


def _draw(chain: Chain, config: Config, random: torch.Generator) -> Tensor:
    half_range = torch.full((chain.joints,), np.radians(config.range_deg), dtype=torch.float64)
    half_range[:3] = 1.0
    unit = torch.rand(config.configurations, chain.joints, generator=random, dtype=torch.float64)
    return (2 * unit - 1) * half_range


def _with_joint(q: Tensor, redrawn: Tensor, joint: int) -> Tensor:
    changed = q.clone()
    changed[:, joint] = redrawn[:, joint]
    return changed


def _largest(difference: Tensor) -> float:
    return float(difference.abs().max())


def _w_home(chain: Chain) -> float:
    return float(Index("manipulability").bind(chain)(torch.zeros(chain.joints)))


def _twist_error(chain: Chain, q: Tensor) -> float:
    points = chain.joint_frames(torch.zeros(chain.joints))[:, :3, 3]
    error = 0.0
    for i, (screw, kind) in enumerate(zip(chain.screws, chain.kinds, strict=True)):
        T = spatial.exp(screw * q[:, i, None])
        moved = spatial.apply(T, points[i])
        expected = points[i] + (q[:, i, None] * screw[:3] if kind == "prismatic" else 0.0)
        error = max(error, _largest(moved - expected))
    return error


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
    """Twist of the nearest twist matrix: differences are skew-symmetric only up to their error."""
    S = (X[..., :3, :3] - X[..., :3, :3].mT) / 2
    return torch.cat([X[..., :3, 3], torch.stack([S[..., 2, 1], S[..., 0, 2], S[..., 1, 0]], dim=-1)], dim=-1)


def _printed_base_change(chain: Chain, q: Tensor, redrawn: Tensor) -> float:
    before = manipulability(equation_6_as_printed(chain, q))
    return max(
        _largest(manipulability(equation_6_as_printed(chain, _with_joint(q, redrawn, i))) / before - 1)
        for i in range(4)
    )
