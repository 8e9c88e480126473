"""Verdicts on the task–index mapping of paper A."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import pandas as pd

from dexterity_study.claims.judge import WEAK, Judge, by_reading
from dexterity_study.claims.outcome import Acceptance, Verdict
from dexterity_study.engine.evidence import Evidence
from dexterity_study.engine.table import Table
from dexterity_study.uvms.indices.verdicts import NEAR_HOME, RANDOM

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
    taus = {name: _by_seed(evidence, name) for name in evidence["agreement"].readings}
    served = ["w, largest speed", "w, torque about the tool", "w, push along the tool"]
    yield on(
        "w-serves-force-too",
        by_reading({name: (own[served].median() >= WEAK).to_numpy() for name, own in taus.items()}),
        f"Kendall's τ of w, of which {WEAK:g} is needed, among candidates that hold the tool: {speed:.2f} with its largest "
        f"speed, {torque:.2f} with the torque about its axis, {push:.2f} with the force along it.",
        ours=", ".join(
            f"{name}: {value:.2f}" for name, value in (("speed", speed), ("torque", torque), ("push", push))
        ),
    )
    spatial, geometric = tau["spatial KCI, accuracy"], tau["geometric KCI, accuracy"]
    beyond = _about(evidence["candidate_sets"], "world-origin=beyond-the-tool").median()
    yield on(
        "indices-rank-configurations",
        by_reading(_worse_of_both(taus, evidence["candidate_sets"], Evidence("uvms.indices"))),
        "Kendall's τ of an index with what its task needs, for the task that comes out worse. Among candidates that hold the "
        f"tool w has {speed:.2f} with the largest speed. KCI has {spatial:.2f} with the accuracy of the tool in the spatial "
        f"frame, which the paper uses, and {geometric:.2f} in the geometric one; between the two frames τ is "
        f"{tau['KCI: spatial, geometric']:.2f}. With the world's origin beyond the tool the spatial KCI has {beyond:.2f}.",
        form="{:.2f}",
    )
    choice = evidence["choice"]
    median, most = choice.where().median(numeric_only=True), choice.where()["pose"].max()
    yield on(
        "redundancy-leaves-a-choice",
        choice.values("pose") < 1e-9,
        f"Medians of the largest over the smallest index among candidates whose tool poses agree to {most:.0e}.",
        ours=f"w × {median['w_ratio']:.2f}, KCI × {median['kci_ratio']:.1f}",
    )


def _by_seed(evidence: Evidence, reading: str) -> pd.DataFrame:
    """Return Kendall's τ of a reading, with a row for each seed and a column for each pair."""
    return evidence["agreement"].where(reading).pivot(index="seed", columns="pair", values="tau")


def _worse_of_both(taus: Mapping[str, pd.DataFrame], sets: Table, indices: Evidence) -> dict[str, pd.Series]:
    """Return the smaller of τ of w with speed and of KCI with accuracy, by reading and seed.

    The candidates of this chapter hold the tool; random configurations are those of the chapter on indices. Readings of
    the world's origin change KCI alone.
    """
    held = {
        name: own[["w, largest speed", "spatial KCI, accuracy"]].min(axis=1) for name, own in taus.items()
    }
    geometric = taus["chosen"][["w, largest speed", "geometric KCI, accuracy"]].min(axis=1)
    random = indices["rankings"].by_seed("tau", over="pair")
    speed, accuracy = (
        "w against the largest speed of the tool point",
        "spatial KCI against accuracy of the tool",
    )
    moved = {name: _about(sets, name) for name in sets.readings if name != "chosen"}
    free = taus["chosen"]["w, largest speed"]
    return {
        **held,
        **{name: kci.combine(free.reindex(kci.index), min) for name, kci in moved.items()},
        "which-jacobian=geometric": geometric,
        RANDOM: random[[speed, accuracy]].min(axis=1),
        NEAR_HOME: random[[f"{speed}, near home", f"{accuracy}, near home"]].min(axis=1),
    }


def _about(sets: Table, reading: str) -> pd.Series:
    """Return τ of the spatial KCI with the accuracy of the tool, by seed, for candidates that hold the tool."""
    return sets.where(reading, set="tool at rest", index="spatial KCI").set_index("seed")["tau"]


def acceptance(evidence: Evidence) -> Iterator[Acceptance]:
    """Figures that must hold for the book to be accepted."""
    pose = evidence["choice"].where()["pose"].max()
    yield Acceptance("deviation of candidates from the common tool pose", pose, 1e-12)
