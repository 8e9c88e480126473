"""Verdicts on the measurements of paper D: a simulation can judge none, and says what it has beside them."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from dexterity_study.claims.judge import Judge
from dexterity_study.claims.outcome import Acceptance, Verdict
from dexterity_study.crane.experiment.experiment import REFERENCES, ZEROED, from_reference
from dexterity_study.engine.evidence import Evidence
from dexterity_study.page.numbers import with_range

ROWS = {"max": "largest", "mean": "mean"}
"""Rows of Tables 4.2 and 4.3, each in x, y and distance, as the ledger and as a table name them."""


def verdicts(evidence: Evidence) -> Iterator[Verdict]:
    """Put simulated cranes beside each measurement."""
    on = Judge("rouvinen1999")
    target, reached = (layout(evidence, reference) for reference in REFERENCES)
    for name, table in (("target", target), ("reference", reached)):
        for i, row in enumerate(f"{axis}{kind}" for kind in ROWS for axis in "xyr"):
            yield _on_row(on, f"crane-measured-{name}-{row}", table[:, i])
    mean, largest = (reached[:, row, -2:].T for row in (5, 2))
    both = (mean[1] < mean[0]) & (largest[1] < largest[0])
    note = f"Both fall on {both.mean():.0%} of {len(both)} simulated cranes."
    ours = f"mean {_mm(mean[0])} to {_mm(mean[1])} mm, largest {_mm(largest[0])} to {_mm(largest[1])} mm"
    yield on.out_of_scope("crane-measured-gain", note, ours)
    without, compensated = (target[:, 5, 4:6] - target[:, 5, :2]).T
    note = f"Change of the mean distance from the target up to the heaviest payload. By its size it is {np.median(abs(compensated)):.1f} mm in the median simulated crane, without compensation {np.median(abs(without)):.1f} mm."
    ours = f"{_mm(compensated)} mm with, {_mm(without)} mm without"
    yield on.out_of_scope("crane-measured-payload-does-not-matter", note, ours)
    harmed, model = evidence["measurements"].where(), evidence["model"].where()
    there = harmed["point"].isin((2, 3))
    at, elsewhere = (harmed[which][["all", "play", ZEROED]].mean() for which in (there, ~there))
    least = model.groupby("point")["jib_cylinder"].min()
    pushes = " and ".join(f"point {point}" for point in least.index[least > 0]) or "no point"
    note = f"At points 2 and 3 {at['all']:.0%} of the simulated cranes are better without, at others {elsewhere['all']:.0%}; by play alone {at['play']:.0%} at 2 and 3, and {at[ZEROED]:.0%} if the model was set right where the cylinder pulls. The model's jib cylinder pushes at {pushes} alone. Load takes up play to where the tip is lower, as sag does."
    counts = harmed.groupby(["seed", "crane"])["all"].sum()
    ours = f"better without at {with_range(counts, '{:g}')} of nine points"
    yield on.out_of_scope("crane-measured-exceptions", note, ours)
    gains = [table[:, 3:5, -2:] @ (1, -1) for table in (target, reached)]
    note = f"Gain of the mean error from the target, and from the point reached. More is gained in y on {min((gain[:, 1] > gain[:, 0]).mean() for gain in gains):.0%} of the simulated cranes at least."
    ours = "; ".join(f"{_mm(gain[:, 1])} mm in y, {_mm(gain[:, 0])} mm in x" for gain in gains)
    yield on.out_of_scope("crane-measured-y-gains", note, ours)


def _on_row(on: Judge, claim: str, ours: np.ndarray) -> Verdict:
    entry = on.paper.claim(claim)
    printed = np.array(entry.value, dtype=float)
    low, high = np.quantile(ours, [0.05, 0.95], axis=0)
    larger, smaller = printed < low - entry.rounding, printed > high + entry.rounding
    change = np.median(ours[:, -1] - ours[:, -2])
    note = f"Of {len(printed)} printed numbers {larger.sum()} are below the middle 90 % of {len(ours)} simulated cranes, and {smaller.sum()} above. Method 1 changes the last by {change:+.1f} mm in the median crane, in print by {printed[-1] - printed[-2]:+.1f} mm."
    medians = ", ".join(f"{value:.1f}" for value in np.median(ours, axis=0))
    return on.out_of_scope(claim, note, f"{medians} mm")


def acceptance(evidence: Evidence) -> Iterator[Acceptance]:
    """Figures that must hold for the book to be accepted."""
    largest = 1e3 * evidence["model"].where()["structure"].max()
    yield Acceptance("largest error of the structure's loop on the model itself [mm]", largest, 0.05)


def errors_of(evidence: Evidence) -> np.ndarray:
    """Return target less reading (cranes, ways, points, payloads, 2) [mm] on cranes that differ in all."""
    return 1e3 * np.concatenate(evidence["measurements"].array("errors")).astype(float)


def layout(evidence: Evidence, reference: str) -> np.ndarray:
    """Return errors [mm] as Tables 4.2 and 4.3 have them: (cranes, 6, 8), without and with method 1 in turn."""
    errors = np.abs(from_reference(errors_of(evidence), reference)[:, :2])
    three = np.concatenate([errors, np.linalg.norm(errors, axis=-1, keepdims=True)], axis=-1)
    each = [of(three, axis=2) for of in (np.max, np.mean)]
    every = [of(three, axis=(2, 3))[:, :, None] for of in (np.max, np.mean)]
    both = np.concatenate([np.concatenate(each, axis=-1), np.concatenate(every, axis=-1)], axis=2)
    return both.transpose(0, 3, 2, 1).reshape(len(both), both.shape[-1], -1)


def _mm(values: np.ndarray) -> str:
    return with_range(values, "{:.1f}")
