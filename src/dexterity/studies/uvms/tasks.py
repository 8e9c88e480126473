"""Paper A, Table 1 used: the same candidate configurations ranked for different tasks.

Sotiropoulos & Aspragathos (2016), section 2.3. All candidates hold the tool in one pose, in front of a
panel, and differ in where the vehicle stands and how the arm reaches.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import torch
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation
from torch import Tensor

from dexterity import robots, tasks
from dexterity.chain import Chain
from dexterity.indices import Index, kinematic_conditioning, velocity_ellipsoid
from dexterity.report.claims import Acceptance, Outcome, Verdict
from dexterity.report.stored import Tolerance
from dexterity.studies.uvms.indices import VEHICLE_LOCKED, rank_correlation

__all__ = [
    "CONFIGS",
    "TOLERANCE",
    "Config",
    "Result",
    "acceptance",
    "agreements",
    "candidates",
    "run",
    "verdicts",
]

TOLERANCE = Tolerance(rtol=1e-6, atol=1e-6)
"""What a probe may miss by, since rounding errors come out a little different on every processor."""


@dataclass(frozen=True)
class Config:
    """Candidates with the vehicle turned and the arm's first three joints bent within these ranges."""

    candidates: int = 100
    vehicle_deg: float = 15.0
    arm_deg: float = 60.0
    seeds: tuple[int, ...] = tuple(range(10))


CONFIGS: Mapping[str, Config] = {
    "smoke": Config(candidates=20, seeds=(0, 1)),
    "book": Config(),
    "full": Config(seeds=tuple(range(200))),
}
"""What runs at each scale."""


@dataclass(frozen=True)
class Result:
    """How two rankings of the same candidates compare; correlations are Kendall's τ, one for each seed.

    Attributes
    ----------
    table_counts
        Tasks of Table 1 that go with w and with KCI.
    pose_error
        Largest deviation of a candidate's tool pose from the common one.
    q, w, kci
        Candidates of the first seed (m, 12), their w and their spatial KCI (m,).
    w_range, kci_range
        Largest over smallest value among the candidates, for each seed.
    w_kci_tau, best_ten_shared
        Agreement of the rankings by w and by KCI, and how many of the best ten they share.
    kci_frame_tau
        Agreement of the rankings by the spatial and by the geometric KCI.
    w_locked_tau
        Agreement of the rankings by w with a free vehicle and with one that keeps station.
    w_torque_tau, w_push_tau, w_speed_tau
        Of w with the torque about the tool's axis and with the force along it that joint efforts of unit
        norm hold, and with the largest speed of the tool point that joint rates of unit norm give.
    kci_accuracy_tau, kci_tool_accuracy_tau
        Of the spatial and of the geometric KCI with the smallness of the largest error of the tool pose
        for joint errors of unit norm.
    """

    table_counts: tuple[int, int]
    pose_error: float
    q: NDArray[np.float64]
    w: NDArray[np.float64]
    kci: NDArray[np.float64]
    w_range: tuple[float, ...]
    kci_range: tuple[float, ...]
    w_kci_tau: tuple[float, ...]
    best_ten_shared: tuple[int, ...]
    kci_frame_tau: tuple[float, ...]
    w_locked_tau: tuple[float, ...]
    w_torque_tau: tuple[float, ...]
    w_push_tau: tuple[float, ...]
    w_speed_tau: tuple[float, ...]
    kci_accuracy_tau: tuple[float, ...]
    kci_tool_accuracy_tau: tuple[float, ...]


def run(config: Config) -> Result:
    """Draw candidates for each seed and rank them."""
    chain = robots.uvms()
    drawn = [candidates(chain, config, seed) for seed in config.seeds]
    ranked = [_compare(chain, q) for q in drawn]
    first = drawn[0]
    in_table = [task for task in tasks.TASKS.values() if "Table 1" in task.where]
    return Result(
        table_counts=(
            sum(task.index == "manipulability" for task in in_table),
            sum(task.index == "kinematic_conditioning" for task in in_table),
        ),
        pose_error=max(float((chain.forward(q) - chain.home).abs().max()) for q in drawn),
        q=first.numpy(),
        w=tasks.rank(chain, first, "valve turning").values.numpy(),
        kci=tasks.rank(chain, first, "welding").values.numpy(),
        best_ten_shared=tuple(int(entry.pop("best_ten_shared")) for entry in ranked),
        **{name: tuple(entry[name] for entry in ranked) for name in ranked[0]},
    )


def candidates(chain: Chain, config: Config, seed: int) -> Tensor:
    """Random configurations (m, 12) that hold the UVMS's tool in its pose at home.

    Vehicle angles and the arm's first three joints are drawn; the wrist's three joints, which turn
    about z, -x and y, make up the orientation and the vehicle's translation the position.
    """
    random = torch.Generator().manual_seed(seed)
    q = torch.zeros(config.candidates, chain.joints, dtype=torch.float64)
    half_range = torch.tensor(np.radians([config.vehicle_deg] * 3 + [config.arm_deg] * 3))
    q[:, 3:9] = (2 * torch.rand(config.candidates, 6, generator=random, dtype=torch.float64) - 1) * half_range
    wrist = chain.forward(q)[:, :3, :3].mT @ chain.home[:3, :3]
    z, x, y = Rotation.from_matrix(wrist.numpy()).as_euler("ZXY").T
    q[:, 9:12] = torch.as_tensor(np.stack([z, -x, y], axis=-1))
    q[:, :3] = chain.home[:3, 3] - chain.forward(q)[:, :3, 3]
    return q


def agreements(result: Result) -> dict[str, tuple[float, ...]]:
    """Kendall's τ of each pair of rankings, one value for each seed, under a short name of the pair."""
    return {
        "w, KCI": result.w_kci_tau,
        "w: free, locked vehicle": result.w_locked_tau,
        "w, largest speed": result.w_speed_tau,
        "w, torque about the tool": result.w_torque_tau,
        "w, push along the tool": result.w_push_tau,
        "KCI: spatial, geometric": result.kci_frame_tau,
        "spatial KCI, accuracy": result.kci_accuracy_tau,
        "geometric KCI, accuracy": result.kci_tool_accuracy_tau,
    }


def verdicts(result: Result) -> tuple[Verdict, ...]:
    """Judge the claims of the ledger that this study answers for.

    A claim that one quantity serves for another is judged by the median of Kendall's τ over the seeds,
    see :meth:`dexterity.report.claims.Outcome.of_correlation`. Where there are several readings the
    kindest counts.
    """
    force = max(np.median(result.w_torque_tau), np.median(result.w_push_tau))
    judgement = "A judgement of what the work needs: taken over as data, and nothing here can test it."
    return (
        _verdict(
            "speed-and-force-tasks", Outcome.of(result.table_counts[0] == 7), str(result.table_counts[0]), "",
            "All in data/tasks.toml.",
        ),
        _verdict(
            "accuracy-tasks", Outcome.of(result.table_counts[1] == 5), str(result.table_counts[1]), "",
            "All in data/tasks.toml; fragile object recovery is added from the text.",
        ),
        *(
            _verdict(claim, Outcome.OUT_OF_SCOPE, "", "", judgement)
            for claim in (
                "cutting-and-cleaning-need-force",
                "jumpers-and-testing-need-accuracy",
                "welding-needs-accuracy",
                "valves-need-torque",
                "debris-needs-force",
                "fragile-recovery-needs-accuracy",
                "several-tasks-need-speed",
            )
        ),
        _verdict(
            "fine-cutting-needs-both", Outcome.UNDERSPECIFIED,
            _median("τ = {:.2f}", result.w_kci_tau), _spread(result.w_kci_tau),
            "Between the rankings by w and by KCI; how to weigh the two is not said.",
        ),
        _verdict(
            "w-serves-force-too", Outcome.of_correlation(force),
            f"τ = {np.median(result.w_torque_tau):.2f} and {np.median(result.w_push_tau):.2f}",
            f"{_spread(result.w_torque_tau)}; {_spread(result.w_push_tau)}",
            "Of w with the torque about the tool's axis and with the force along it.",
        ),
        _verdict(
            "indices-rank-configurations",
            Outcome.IN_SHAPE if np.median(result.kci_frame_tau) < 0.8 else Outcome.REPRODUCED,
            _median("τ = {:.2f}", result.kci_frame_tau), _spread(result.kci_frame_tau),
            "Both order candidates, but the order by KCI depends on the frame: this is the agreement between "
            "the spatial and the geometric KCI. The spatial one, which the paper uses, agrees with the "
            f"accuracy of the tool with τ = {np.median(result.kci_accuracy_tau):.2f}, the geometric one with "
            f"τ = {np.median(result.kci_tool_accuracy_tau):.2f}.",
        ),
        _verdict(
            "redundancy-leaves-a-choice", Outcome.of(result.pose_error < 1e-12),
            f"w × {np.median(result.w_range):.2f}, KCI × {np.median(result.kci_range):.1f}",
            _spread(result.kci_range),
            "Largest over smallest index among candidates whose tool poses agree to "
            f"{result.pose_error:.0e}.",
        ),
    )  # fmt: skip


def acceptance(result: Result) -> tuple[Acceptance, ...]:
    """Figures that must hold for the book to be built."""
    return (Acceptance("deviation of candidates from the common tool pose", result.pose_error, 1e-12),)


def _compare(chain: Chain, q: Tensor) -> dict[str, float]:
    w_ranking = tasks.rank(chain, q, "valve turning")
    kci_ranking = tasks.rank(chain, q, "welding")
    w, kci = w_ranking.values, kci_ranking.values
    J = chain.geometric_jacobian(q)
    tool_axis = chain.forward(q)[:, :3, 1]
    push, torque = (1 / (tool_axis[:, None] @ rows).norm(dim=-1)[:, 0] for rows in (J[:, :3], J[:, 3:]))
    accuracy = -velocity_ellipsoid(J).semi_axes[:, 0]
    locked = Index("manipulability", joint_rates=VEHICLE_LOCKED).bind(chain)(q)
    best = [set(ranking.order[:10].tolist()) for ranking in (w_ranking, kci_ranking)]
    return {
        "w_range": float(w.max() / w.min()),
        "kci_range": float(kci.max() / kci.min()),
        "w_kci_tau": rank_correlation(w, kci),
        "best_ten_shared": len(best[0] & best[1]),
        "kci_frame_tau": rank_correlation(kci, kinematic_conditioning(J)),
        "w_locked_tau": rank_correlation(w, locked),
        "w_torque_tau": rank_correlation(w, torque),
        "w_push_tau": rank_correlation(w, push),
        "w_speed_tau": rank_correlation(w, velocity_ellipsoid(J, "translational").semi_axes[:, 0]),
        "kci_accuracy_tau": rank_correlation(kci, accuracy),
        "kci_tool_accuracy_tau": rank_correlation(kinematic_conditioning(J), accuracy),
    }


def _verdict(claim: str, outcome: Outcome, ours: str, spread: str, sentence: str) -> Verdict:
    return Verdict("sotiropoulos2016", claim, outcome, ours, spread, sentence)


def _median(form: str, values: tuple[float, ...]) -> str:
    return form.format(np.median(values))


def _spread(values: tuple[float, ...]) -> str:
    return f"{min(values):.2f} to {max(values):.2f} over {len(values)} seeds"
