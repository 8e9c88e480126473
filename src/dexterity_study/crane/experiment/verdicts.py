"""Verdicts on the measurements of paper D: a simulation can judge none, and says what it has beside them."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from dexterity_study.claims.judge import Judge
from dexterity_study.claims.outcome import Acceptance, Verdict
from dexterity_study.crane.experiment.experiment import REFERENCES, ZEROED, from_reference
from dexterity_study.engine.evidence import Evidence
from dexterity_study.page.tables import with_range

ROWS = {"max": "largest", "mean": "mean"}
"""Rows of Tables 4.2 and 4.3, each in x, y and distance, as the ledger and as a table name them."""


def verdicts(evidence: Evidence) -> Iterator[Verdict]:
    """Put simulated cranes beside each measurement."""
    on = Judge("rouvinen1999")
    for reference, table in (("target", "target"), ("reference", "point reached")):
        for i, row in enumerate(f"{axis}{kind}" for kind in ROWS for axis in "xyr"):
            yield _on_row(on, f"crane-measured-{reference}-{row}", layout(evidence, table)[:, i])
    mean, largest = (layout(evidence, "point reached")[:, row, -2:].T for row in (5, 2))
    both = (mean[1] < mean[0]) & (largest[1] < largest[0])
    yield on.out_of_scope(
        "crane-measured-gain",
        f"Both fall on {both.mean():.0%} of {len(both)} simulated cranes.",
        f"mean {_mm(mean[0])} to {_mm(mean[1])} mm, largest {_mm(largest[0])} to {_mm(largest[1])} mm",
    )
    means = layout(evidence, "target")[:, 5]
    without, compensated = (means[:, 4:6] - means[:, :2]).T
    yield on.out_of_scope(
        "crane-measured-payload-does-not-matter",
        "Change of the mean distance from the target up to the heaviest payload. By its size it is "
        f"{np.median(abs(compensated)):.1f} mm in the median simulated crane, without compensation "
        f"{np.median(abs(without)):.1f} mm.",
        f"{_mm(compensated)} mm with, {_mm(without)} mm without",
    )
    harmed, model = evidence["measurements"].where(), evidence["model"].where()
    there = harmed["point"].isin((2, 3))
    pushes = model.groupby("point")["jib_cylinder"].min().loc[lambda force: force > 0].index
    yield on.out_of_scope(
        "crane-measured-exceptions",
        f"At points 2 and 3 {harmed['all'][there].mean():.0%} of the simulated cranes are better without, at others "
        f"{harmed['all'][~there].mean():.0%}; by play alone {harmed['play'][there].mean():.0%} at 2 and 3, and "
        f"{harmed[ZEROED][there].mean():.0%} if the model was set right where the cylinder pulls. The model's jib "
        f"cylinder pushes at {' and '.join(f'point {point}' for point in pushes) or 'no point'} alone. Load takes up "
        "play to where the tip is lower, as sag does.",
        f"better without at {with_range(harmed.groupby(['seed', 'crane'])['all'].sum(), '{:g}')} of nine points",
    )
    gains = [layout(evidence, to)[:, 3:5, -2:] @ (1, -1) for to in REFERENCES]
    yield on.out_of_scope(
        "crane-measured-y-gains",
        "Gain of the mean error from the target, and from the point reached. More is gained in y on "
        f"{min((gain[:, 1] > gain[:, 0]).mean() for gain in gains):.0%} of the simulated cranes at least.",
        "; ".join(f"{_mm(gain[:, 1])} mm in y, {_mm(gain[:, 0])} mm in x" for gain in gains),
    )


def _on_row(on: Judge, claim: str, ours: np.ndarray) -> Verdict:
    entry = on.paper.claim(claim)
    printed = np.array(entry.value, dtype=float)
    low, high = np.quantile(ours, [0.05, 0.95], axis=0)
    larger, smaller = printed < low - entry.rounding, printed > high + entry.rounding
    change = np.median(ours[:, -1] - ours[:, -2])
    return on.out_of_scope(
        claim,
        f"Of {len(printed)} printed numbers {larger.sum()} are below the middle 90 % of {len(ours)} simulated cranes, "
        f"and {smaller.sum()} above. Method 1 changes the last by {change:+.1f} mm in the median crane, in print by "
        f"{printed[-1] - printed[-2]:+.1f} mm.",
        ", ".join(f"{value:.1f}" for value in np.median(ours, axis=0)) + " mm",
    )


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
