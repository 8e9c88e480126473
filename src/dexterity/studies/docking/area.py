"""Paper B, sections III.A and IV: manipulability over the task area, its maps, and the angles of Table 4.

Sotiropoulos, Aspragathos & Andritsos (2011), Eqs. 1, 2 and 16, Figs. 9, 10 and 12–15. Everything is done
twice, for the arm as stated and for the one that was fitted to Table 4.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from dexterity import docking, indices, robots
from dexterity.chain import Chain
from dexterity.docking.elbow import ElbowArm
from dexterity.inverse_kinematics import copies_within_limits, spherical_wrist
from dexterity.report.claims import Acceptance, Outcome, Verdict, load_paper
from dexterity.report.stored import Tolerance

__all__ = [
    "ANGLES",
    "CONFIGS",
    "CORNERS",
    "TOLERANCE",
    "Arm",
    "Config",
    "Result",
    "acceptance",
    "arms",
    "configuration_at",
    "control_point_table",
    "entry_table",
    "first_pose",
    "ill_placed_pose",
    "run",
    "run_table",
    "verdicts",
]

STATED, FITTED = "stated", "fitted"
CORNERS: Mapping[str, tuple[float, float, float]] = {
    "K": (-0.2, -0.2, 0.0),
    "L": (-0.2, 0.2, 0.0),
    "M": (0.2, 0.2, 0.0),
    "N": (0.2, -0.2, 0.0),
}
"""Corners of the task area in G [m]."""

ANGLES = ("θ1", "θ2", "θ3", "θ5", "θ6")
"""Angles of Table 4 that are compared; θ4 is 0 to rounding everywhere and tells nothing."""

TOLERANCE = Tolerance(rtol=1e-6, atol=1e-6)
"""What a probe may miss by, since rounding errors come out a little different on every processor."""

_PAPER = "sotiropoulos2011"
_MATCH = 1.5e-3  # [rad], three half units of the last printed digit
_PER_SIDE = (2, 3, 5, 9)


@dataclass(frozen=True)
class Config:
    """Points a side of maps, and how many poses beside the task area and configurations are drawn."""

    map_per_side: int = 41
    fine_per_side: int = 21
    drawn: int = 200_000
    configurations: int = 20_000
    seed: int = 0


CONFIGS: Mapping[str, Config] = {
    "smoke": Config(map_per_side=9, fine_per_side=9, drawn=5_000, configurations=200),
    "book": Config(),
    "full": Config(map_per_side=101, fine_per_side=41, drawn=1_000_000),
}
"""What runs at each scale."""


@dataclass(frozen=True)
class Arm:
    """What one of the arms does.

    Attributes
    ----------
    closed_form_error
        Largest difference of the closed form of w from the determinant, over random configurations.
    cap
        Largest w that the arm can have with its tool upright.
    misses
        How far [m] the angles of Table 4 put the tool from each corner.
    entries
        Differences [rad] of the angles of Table 4, in the order of `ANGLES`, from those of the branch that
        has most of them, at each corner; infinity where the corner is out of reach.
    runs
        Area manipulability at the poses of the seven runs of Table 3.
    map, ill_map
        (n, n) w_max over the task area, x by rows, at the pose of the first run and at the ill-placed pose.
    inside
        By number of control points, how large the smallest w of a fine grid is beside that of the control
        points: median, smallest, and share of poses with a dead spot inside, over random poses that reach all
        control points.
    """

    closed_form_error: float
    cap: float
    misses: Mapping[str, float]
    entries: Mapping[str, tuple[float, ...]]
    runs: tuple[float, ...]
    map: NDArray[np.float64]
    ill_map: NDArray[np.float64]
    inside: Mapping[str, tuple[float, float, float]]

    @property
    def matched(self) -> int:
        """Number of entries of Table 4 that the arm has."""
        return sum(abs(miss) <= _MATCH for misses in self.entries.values() for miss in misses)


@dataclass(frozen=True)
class Result:
    """Both arms, and what Table 4 says by itself.

    Attributes
    ----------
    arms
        What each arm does, by name.
    margins
        Smallest distance [rad] of the angles of Table 4 from a limit, at each corner.
    margins_of_three
        The same for the first three angles, of which the largest counts.
    """

    arms: Mapping[str, Arm]
    margins: Mapping[str, float]
    margins_of_three: Mapping[str, float]


def run(config: Config) -> Result:
    """Look at the poses that the paper prints, and at random ones."""
    limits = robots.docking_arm()
    printed = {name: printed_angles(name) for name in CORNERS}
    margins = {name: torch.minimum(q - limits.lower, limits.upper - q) for name, q in printed.items()}
    return Result(
        arms={name: _arm(arm, config) for name, arm in arms().items()},
        margins={name: margin.min().item() for name, margin in margins.items()},
        margins_of_three={name: margin[:3].max().item() for name, margin in margins.items()},
    )


def arms() -> dict[str, Chain]:
    """Return the arm as the paper states it, and the fitted one."""
    return {STATED: robots.docking_arm(), FITTED: robots.docking_arm("fitted")}


def printed_angles(corner: str) -> Tensor:
    """Angles (6,) of Table 4 at a corner."""
    return torch.tensor(
        load_paper(_PAPER).claim(f"configuration-{corner.lower()}").value, dtype=torch.float64
    )


def printed_poses() -> Tensor:
    """Poses (7, 4) of Table 3."""
    columns = [load_paper(_PAPER).claim(f"poses-{name}").value for name in ("x", "y", "z", "psi")]
    return torch.tensor(columns, dtype=torch.float64).mT


def first_pose() -> Tensor:
    """Pose (4,) of the first run of Table 3."""
    return printed_poses()[0]


def ill_placed_pose() -> Tensor:
    """Pose (4,) of Fig. 10."""
    return torch.tensor(load_paper(_PAPER).claim("ill-placed-pose").value, dtype=torch.float64)


def configuration_at(arm: Chain, pose: Tensor, corner: str) -> Tensor | None:
    """Return the most dexterous configuration (6,) within the limits at a corner; None if there is none."""
    q, valid, within = docking.configurations(arm, pose, [CORNERS[corner]])
    allowed = q[0][(valid & within)[0]]
    if len(allowed) == 0:
        return None
    return allowed[indices.manipulability(arm.geometric_jacobian(allowed)).argmax()]


def _arm(arm: Chain, config: Config) -> Arm:
    area, ill = (
        docking.largest_manipulability(arm, pose, docking.square(0.2, config.map_per_side))
        for pose in (first_pose(), ill_placed_pose())
    )
    shape = (config.map_per_side, config.map_per_side)
    corners = docking.square(0.2)
    return Arm(
        closed_form_error=_closed_form_error(arm, config),
        cap=_cap(arm),
        misses={name: _miss(arm, name) for name in CORNERS},
        entries={name: _entries(arm, name) for name in CORNERS},
        runs=tuple(docking.area_manipulability(arm, printed_poses(), corners).tolist()),
        map=area.reshape(shape).numpy(),
        ill_map=ill.reshape(shape).numpy(),
        inside=_inside(arm, config),
    )


def _closed_form_error(arm: Chain, config: Config) -> float:
    """Compare at random configurations, whose limits and branches are left aside."""
    free = Chain(arm.screws, arm.home, lower=[-math.pi] * 6, upper=[math.pi] * 6)
    random = torch.Generator().manual_seed(config.seed)
    q = (2 * torch.rand(config.configurations, 6, generator=random, dtype=torch.float64) - 1) * math.pi
    T = free.forward(q)
    branches, _ = spherical_wrist(free, T)
    J = free.geometric_jacobian(branches)
    by_determinant = torch.linalg.det(J).abs().amax(-1)
    closed = _closed_form(free).manipulability(T[:, :3, 3].mT, T[:, :3, 0].mT)
    return (closed - by_determinant).abs().max().item()


def _closed_form(arm: Chain) -> ElbowArm:
    elbow = ElbowArm.of(arm)
    if elbow is None:
        raise ValueError(f"arm is {arm}; an elbow arm is needed")
    return elbow


def _cap(arm: Chain) -> float:
    """Largest w with the sixth axis upright, over all of the workspace."""
    elbow = _closed_form(arm)
    side = torch.linspace(-1, 1, 1601, dtype=torch.float64) * (elbow.upper_arm + elbow.forearm)
    ahead, up = torch.meshgrid(side[side >= 0], side, indexing="ij")
    point = torch.stack([(ahead.square() + elbow.sideways**2).sqrt(), 0 * up, up + elbow.height])
    upright = point.new_tensor([0.0, 0.0, 1.0])[:, None, None]
    return elbow.manipulability(point, upright).max().item()


def _miss(arm: Chain, corner: str) -> float:
    T = docking.base_pose(first_pose()) @ arm.forward(printed_angles(corner))
    return (T[:3, 3] - T.new_tensor(CORNERS[corner])).norm().item()


def _entries(arm: Chain, corner: str) -> tuple[float, ...]:
    """Differences of the compared angles from the branch, or a copy of it, that has most of them."""
    q, valid, _ = docking.configurations(arm, first_pose(), [CORNERS[corner]])
    if not valid.any():
        return (math.inf,) * len(ANGLES)
    wide = Chain(arm.screws, arm.home, lower=[-2 * math.pi] * 6, upper=[2 * math.pi] * 6)
    candidates = torch.cat([copies_within_limits(wide, branch) for branch in q[0][valid[0]]])
    misses = (printed_angles(corner) - candidates)[:, [0, 1, 2, 4, 5]]
    matches = (misses.abs() <= _MATCH).sum(1) - misses.abs().clamp(max=10).sum(1) / 100
    return tuple(misses[matches.argmax()].tolist())


def _inside(arm: Chain, config: Config) -> dict[str, tuple[float, float, float]]:
    problem = docking.DockingProblem(arm, region="or")
    random = torch.Generator().manual_seed(config.seed)
    unit = torch.rand(config.drawn, 4, generator=random, dtype=torch.float64)
    poses = problem.lower + (problem.upper - problem.lower) * unit
    poses = poses[problem.allows(poses)]
    poses = poses[problem.area_manipulability(poses) > 0]
    fine = docking.area_manipulability(arm, poses, docking.square(0.2, config.fine_per_side))
    found = {}
    for per_side in _PER_SIDE:
        coarse = docking.area_manipulability(arm, poses, docking.square(0.2, per_side))
        share = (fine / coarse)[coarse > 0]
        found[str(per_side**2)] = (
            share.median().item(),
            share.min().item(),
            (share == 0).double().mean().item(),
        )
    return found


# ---- tables ----------------------------------------------------------------------------------------


def entry_table(result: Result) -> dict[str, dict[str, str]]:
    """Misses [rad] of the entries of Table 4 for both arms, and of the corner [m]."""
    rows = {}
    for name, arm in result.arms.items():
        for corner, misses in arm.entries.items():
            told = ["–" if math.isinf(miss) else f"{miss:.4f}" for miss in misses]
            rows[f"{corner}, {name}"] = {
                **dict(zip(ANGLES, told, strict=True)),
                "off the corner [m]": f"{arm.misses[corner]:.4f}",
            }
    return rows


def run_table(result: Result) -> dict[str, dict[str, float]]:
    """Area manipulability at the poses of Table 3, printed and of both arms, and the caps."""
    printed = load_paper(_PAPER).claim("area-manipulability-of-runs").value
    rows = {"printed": printed, **{name: arm.runs for name, arm in result.arms.items()}}
    caps = {"printed": math.nan, **{name: arm.cap for name, arm in result.arms.items()}}
    return {
        name: {**{str(i): value for i, value in enumerate(values, start=1)}, "largest possible": caps[name]}
        for name, values in rows.items()
        if isinstance(values, tuple)
    }


def control_point_table(result: Result) -> dict[str, dict[str, float]]:
    """Tell how much of what control points promise holds inside the area, by their number."""
    return {
        f"{points} points, {name}": {
            "kept, median [%]": 100 * median,
            "kept, worst [%]": 100 * worst,
            "poses with a dead spot [%]": 100 * dead,
        }
        for name, arm in result.arms.items()
        for points, (median, worst, dead) in arm.inside.items()
    }


# ---- verdicts --------------------------------------------------------------------------------------

_SETTING = "Taken over as a setting; nothing can be tested. "


def verdicts(result: Result) -> tuple[Verdict, ...]:
    """Judge the claims of the ledger that this study answers for.

    A row of Table 4 is reproduced where the stated arm has all five angles, fitted where the fitted arm has,
    and in neither case not reproduced. A map is high where w is at least half of its largest value, and small
    means below a tenth of the area.
    """
    return (*_on_formulas(result), *_on_table_4(result), *_on_maps(result), *_on_points(result))


def _on_formulas(result: Result) -> tuple[Verdict, ...]:
    error = max(arm.closed_form_error for arm in result.arms.values())
    same = Outcome.of(error < 1e-10)
    return (
        _verdict(
            "manipulability", same, f"within {error:.0e}", "",
            "The determinant beside l₁ l₂ |sin θ₃| r |sin θ₅| with r ahead of the shoulder.",
        ),
        _verdict(
            "area-manipulability", same, "", "",
            "Taken over; the closed form of it agrees with all eight branches one by one.",
        ),
        _verdict("map", same, "", "", "Taken over; it is what Eq. 1 takes the smallest value of."),
        _verdict("task-area", Outcome.OUT_OF_SCOPE, "", "", f"{_SETTING}It decides what is in reach."),
    )  # fmt: skip


def _on_table_4(result: Result) -> tuple[Verdict, ...]:
    stated, fitted = (result.arms[name] for name in (STATED, FITTED))
    rows = []
    for corner in CORNERS:
        here = {name: arm.entries[corner] for name, arm in result.arms.items()}
        hits = {name: sum(abs(miss) <= _MATCH for miss in misses) for name, misses in here.items()}
        outcome = Outcome.NOT_REPRODUCED
        if hits[STATED] == len(ANGLES):
            outcome = Outcome.REPRODUCED
        elif hits[FITTED] == len(ANGLES):
            outcome = Outcome.FITTED
        missing = [
            f"{angle} by {miss:.3f}"
            for angle, miss in zip(ANGLES, here[FITTED], strict=True)
            if abs(miss) > _MATCH
        ]
        rows.append(
            _verdict(
                f"configuration-{corner.lower()}", outcome,
                f"{hits[STATED]} of {len(ANGLES)} angles (stated), {hits[FITTED]} (fitted)",
                f"the printed angles are {1e3 * stated.misses[corner]:.0f} mm off the corner (stated), "
                f"{1e3 * fitted.misses[corner]:.0f} mm (fitted)",
                f"The fitted arm misses {', '.join(missing)} rad."
                if missing
                else "The fitted arm was fitted to this row among others.",
            )
        )  # fmt: skip
    clear = min(result.margins[corner] for corner in "LMN")
    near = result.margins_of_three["K"]
    return (
        *rows,
        _verdict(
            "away-from-limits", Outcome.of(clear > 0.5), f"{clear:.2f} rad", "the nearest of all",
            "By the printed angles alone.",
        ),
        _verdict(
            "near-limits-at-k", Outcome.of(near < 0.2), f"{near:.2f} rad", "the farthest of the three",
            "By the printed angles alone. These angles do not reach K, with either arm.",
        ),
    )  # fmt: skip


def _on_maps(result: Result) -> tuple[Verdict, ...]:
    high = {name: _share(arm.map >= 0.5 * arm.map.max()) for name, arm in result.arms.items()}
    dead = {name: _share(arm.map == 0) for name, arm in result.arms.items()}
    near_k = {name: _share(_quarter_at_k(arm.map) == 0) * 0.25 for name, arm in result.arms.items()}
    small = {name: 0 < dead[name] < 0.1 and near_k[name] > 0.9 * dead[name] for name in result.arms}
    ill = {name: _share(arm.ill_map == 0) for name, arm in result.arms.items()}
    caps = {name: arm.cap for name, arm in result.arms.items()}
    printed = load_paper(_PAPER).claim("area-manipulability-of-runs").value
    lowest = min(printed) if isinstance(printed, tuple) else math.nan
    return (
        _verdict(
            "high-over-most-of-the-area", _of_both(share > 0.5 for share in high.values()),
            _both("{:.0%}", high), "share of the area with at least half of the largest w",
            "At the printed pose of the first run.",
        ),
        _verdict(
            "dead-zone-near-k", _of_both(small.values()), _both("{:.0%}", dead),
            "share of the area where w is zero",
            "At the printed pose of the first run. The dead part of the quarter at K is "
            f"{_both('{:.0%}', near_k)} of the area.",
        ),
        _verdict(
            "ill-placed-pose", Outcome.OUT_OF_SCOPE, "", "", f"{_SETTING}What it leads to is judged apart.",
        ),
        _verdict(
            "ill-placed-pose-is-dead", _of_both(share > 0.1 for share in ill.values()),
            _both("{:.0%}", ill), "share of the area where w is zero", "As printed: out of reach there.",
        ),
        _verdict(
            "area-manipulability-of-runs",
            Outcome.CONTRADICTED if max(caps.values()) < lowest else Outcome.NOT_REPRODUCED,
            _both("up to {:.3f}", {name: max(arm.runs) for name, arm in result.arms.items()}),
            f"largest w with the tool upright: {_both('{:.3f}', caps)}",
            f"The smallest printed value, {lowest:.3f}, is more than Eq. 2 gives in metres, for any arm and "
            "at any pose.",
        ),
    )  # fmt: skip


def _on_points(result: Result) -> tuple[Verdict, ...]:
    corners = {name: arm.inside["4"] for name, arm in result.arms.items()}
    dead = {name: inside[2] for name, inside in corners.items()}
    more = {name: arm.inside["9"][2] for name, arm in result.arms.items()}
    most = {name: arm.inside["25"][2] for name, arm in result.arms.items()}
    some = any(share > 0 for share in dead.values())
    return (
        _verdict(
            "minimum-is-assured", Outcome.CONTRADICTED if some else Outcome.REPRODUCED,
            _both("{:.0%}", dead), "share of the poses that reach all corners and have a dead spot inside",
            "Between the corners w may be smaller than at any of them, and zero.",
        ),
        _verdict(
            "four-points-may-not-suffice", Outcome.of(some), _both("{:.1%}", more),
            "share of poses with a dead spot left by nine points",
            f"Twenty-five leave {_both('{:.1%}', most)}.",
        ),
    )  # fmt: skip


def _quarter_at_k(values: NDArray[np.float64]) -> NDArray[np.float64]:
    half = (values.shape[0] + 1) // 2
    return values[:half, :half]


def _share(where: NDArray[np.bool_]) -> float:
    return float(np.mean(where))


def _of_both(holds: Iterable[bool]) -> Outcome:
    """Reproduced where it holds for both arms, in shape where for one."""
    return (Outcome.NOT_REPRODUCED, Outcome.IN_SHAPE, Outcome.REPRODUCED)[sum(holds)]


def _both(form: str, values: Mapping[str, float]) -> str:
    return ", ".join(f"{form.format(value)} ({name})" for name, value in values.items())


def acceptance(result: Result) -> tuple[Acceptance, ...]:
    """Figures that must hold for the book to be built."""
    return (
        *(
            Acceptance(f"closed form of w from the determinant, {name} arm", arm.closed_form_error, 1e-10)
            for name, arm in result.arms.items()
        ),
        Acceptance("entries of Table 4 that the fitted arm misses", 20 - result.arms[FITTED].matched, 6),
    )


def _verdict(claim: str, outcome: Outcome, ours: str, spread: str, sentence: str) -> Verdict:
    return Verdict(_PAPER, claim, outcome, ours, spread, sentence)
