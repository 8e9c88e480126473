"""Verdicts on the task–index mapping of paper A."""

from __future__ import annotations

from collections.abc import Iterator

import pandas as pd

from dexterity_study.claims.judge import WEAK, Judge
from dexterity_study.claims.outcome import Acceptance, Verdict
from dexterity_study.engine.evidence import Evidence

JUDGEMENTS = (
    "cutting-and-cleaning-need-force",
    "jumpers-and-testing-need-accuracy",
    "welding-needs-accuracy",
    "valves-need-torque",
    "debris-needs-force",
    "fragile-recovery-needs-accuracy",
    "several-tasks-need-speed",
)
"""Claims on what a work needs."""


def verdicts(evidence: Evidence) -> Iterator[Verdict]:
    """Judge the claims of the chapter."""
    on = Judge("sotiropoulos2016")
    table, choice = evidence["table"], evidence["choice"]
    for claim, index, note in (
        ("speed-and-force-tasks", "manipulability", "All are in data/tasks.toml."),
        (
            "accuracy-tasks",
            "kinematic_conditioning",
            "All are in data/tasks.toml; fragile object recovery is added from the text.",
        ),
    ):
        yield on(claim, table.values("tasks", index=index), note, form="{:g}")
    for claim in JUDGEMENTS:
        yield on.out_of_scope(
            claim, "A judgement of what the work needs: kept as data, and nothing here can test it."
        )
    both = _taus(evidence, "w, KCI").median()
    yield on.underspecified(
        "fine-cutting-needs-both",
        "Kendall's τ between the rankings by w and by KCI; the paper does not say how to weigh the two.",
        f"τ = {both:.2f}",
    )
    speed, torque, push = (
        _taus(evidence, f"w, {what}").median()
        for what in ("largest speed", "torque about the tool", "push along the tool")
    )
    yield on(
        "w-serves-force-too",
        {"speed": speed >= WEAK, "torque": torque >= WEAK, "push": push >= WEAK},
        f"Kendall's τ of w, of which {WEAK:g} is needed: {speed:.2f} with the largest speed of the tool, {torque:.2f} with the "
        f"torque about its axis, {push:.2f} with the force along it.",
    )
    spatial, geometric = (
        _taus(evidence, f"{frame} KCI, accuracy").median() for frame in ("spatial", "geometric")
    )
    frames = _taus(evidence, "KCI: spatial, geometric").median()
    yield on(
        "indices-rank-configurations",
        {"speed, by w": speed >= WEAK, "accuracy, by KCI": spatial >= WEAK},
        "Both indices order candidates, but the order by KCI depends on the frame: Kendall's τ between the spatial and the "
        f"geometric KCI is {frames:.2f}. The spatial one, which the paper uses, agrees with the accuracy of the tool with "
        f"τ = {spatial:.2f}, the geometric one with τ = {geometric:.2f}.",
    )
    ratios = choice.where()
    yield on(
        "redundancy-leaves-a-choice",
        choice.values("pose") < 1e-9,
        f"Medians of the largest over the smallest index among candidates whose tool poses agree to {ratios['pose'].max():.0e}.",
        ours=f"w × {ratios['w_ratio'].median():.2f}, KCI × {ratios['kci_ratio'].median():.1f}",
    )


def acceptance(evidence: Evidence) -> Iterator[Acceptance]:
    """Figures that must hold for the book to be accepted."""
    yield Acceptance(
        "deviation of candidates from the common tool pose", evidence["choice"].where()["pose"].max(), 1e-12
    )


def _taus(evidence: Evidence, pair: str) -> pd.Series:
    return evidence["agreement"].where(pair=pair)["tau"]
