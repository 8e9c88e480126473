"""Verdicts on the task–index mapping of paper A."""

from __future__ import annotations

from collections.abc import Iterator

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
    w, kci = (
        evidence["table"].values("tasks", index=index)
        for index in ("manipulability", "kinematic_conditioning")
    )
    yield on("speed-and-force-tasks", w, "All are in data/tasks.toml.", form="{:g}")
    note = "All are in data/tasks.toml; fragile object recovery is added from the text."
    yield on("accuracy-tasks", kci, note, form="{:g}")
    for claim in JUDGEMENTS:
        note = "A judgement of what the work needs: kept as data, and nothing here can test it."
        yield on.out_of_scope(claim, note)
    tau = evidence["agreement"].by_seed("tau", over="pair").median()
    note = "Kendall's τ between the rankings by w and by KCI; the paper does not say how to weigh the two."
    yield on.underspecified("fine-cutting-needs-both", note, f"τ = {tau['w, KCI']:.2f}")
    speed, torque = tau["w, largest speed"], tau["w, torque about the tool"]
    push = tau["w, push along the tool"]
    yield on(
        "w-serves-force-too",
        {"speed": speed >= WEAK, "torque": torque >= WEAK, "push": push >= WEAK},
        f"Kendall's τ of w, of which {WEAK:g} is needed: {speed:.2f} with the largest speed of the tool, {torque:.2f} with the "
        f"torque about its axis, {push:.2f} with the force along it.",
    )
    spatial, geometric = tau["spatial KCI, accuracy"], tau["geometric KCI, accuracy"]
    yield on(
        "indices-rank-configurations",
        {"speed, by w": speed >= WEAK, "accuracy, by KCI": spatial >= WEAK},
        "Both indices order candidates, but the order by KCI depends on the frame: Kendall's τ between the spatial and the "
        f"geometric KCI is {tau['KCI: spatial, geometric']:.2f}. The spatial one, which the paper uses, agrees with the "
        f"accuracy of the tool with τ = {spatial:.2f}, the geometric one with τ = {geometric:.2f}.",
    )
    choice = evidence["choice"]
    median, most = choice.where().median(numeric_only=True), choice.where()["pose"].max()
    yield on(
        "redundancy-leaves-a-choice",
        choice.values("pose") < 1e-9,
        f"Medians of the largest over the smallest index among candidates whose tool poses agree to {most:.0e}.",
        ours=f"w × {median['w_ratio']:.2f}, KCI × {median['kci_ratio']:.1f}",
    )


def acceptance(evidence: Evidence) -> Iterator[Acceptance]:
    """Figures that must hold for the book to be accepted."""
    pose = evidence["choice"].where()["pose"].max()
    yield Acceptance("deviation of candidates from the common tool pose", pose, 1e-12)
