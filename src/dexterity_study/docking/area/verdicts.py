"""Verdicts on the area manipulability of paper B.

A map is high where w is at least half of its largest value; a dead zone is small below a tenth of the area.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pandas as pd

from dexterity_study.claims.judge import Judge
from dexterity_study.claims.outcome import Acceptance, Verdict
from dexterity_study.docking.area.experiment import ANGLES, COMPARED, MATCH
from dexterity_study.docking.cases import ARMS, CORNERS
from dexterity_study.engine.evidence import Evidence


def verdicts(evidence: Evidence) -> Iterator[Verdict]:
    """Judge the claims of the chapter."""
    on = Judge("sotiropoulos2011")
    yield from _on_w(on, evidence)
    yield from _on_table_4(on, evidence)
    yield from _on_the_area(on, evidence)


def _on_w(on: Judge, evidence: Evidence) -> Iterator[Verdict]:
    caps, errors = (evidence["closed_form"].values(of) for of in ("cap", "error"))
    note = "Determinant less l₁ l₂ |sin θ₃| r |sin θ₅|, r ahead of the shoulder, beside the largest w with the tool upright."
    yield on("manipulability", errors / caps, note)
    claim, areas = "area-manipulability-of-runs", evidence["runs"]
    least = min(on.printed(claim))
    if caps.max() < least:
        yield on.refuted(
            claim,
            f"The smallest printed value, {least:.3f}, is more than Eq. 2 gives in metres with the tool upright, at any pose: "
            f"{both('{:.3f}', caps)}.",
            both("up to {:.3f}", areas.rows.groupby(["reading", "seed"])["area"].max()),
        )
    else:
        yield on(claim, [areas.values("area", run=run) for run in areas.where()["run"]])


def _on_table_4(on: Judge, evidence: Evidence) -> Iterator[Verdict]:
    misses = evidence["angles"].rows.set_index(["reading", "seed"])
    angles = {corner: np.array(on.printed(f"configuration-{corner.lower()}")) for corner in CORNERS}
    for corner, printed in angles.items():
        own = misses[misses["corner"] == corner]
        yield on(
            f"configuration-{corner.lower()}",
            [value - own[angle] for angle, value in zip(ANGLES, printed, strict=True)],
            f"The angles of the nearest branch. Without θ4, which is printed as 0 throughout, {both('{:.0f}', matches(own))} of "
            f"{len(COMPARED)} match. The printed ones put the tool off the corner by {both('{:.0f} mm', 1e3 * own['off'])}.",
            form="{:.3f}",
            ours="" if own["θ1"].loc["chosen"].notna().all() else "out of reach",
        )
    lower, upper = (np.array(on.printed(f"{side}-limits")) for side in ("lower", "upper"))
    margins = {corner: np.minimum(q - lower, upper - q) for corner, q in angles.items()}
    clear = {corner: margins[corner].min() for corner in "LMN"}
    note = (
        f"By the printed angles alone, the nearest of which is {min(clear.values()):.2f} rad from its limit."
    )
    yield on("away-from-limits", {corner: bool(margin > 0.5) for corner, margin in clear.items()}, note)
    near = dict(zip(ANGLES[:3], margins["K"], strict=False))
    yield on(
        "near-limits-at-k",
        {angle: bool(margin < 0.2) for angle, margin in near.items()},
        f"By the printed angles alone, the farthest of which is {max(near.values()):.2f} rad from its limit. These angles "
        "do not reach K, with either arm.",
    )


def _on_the_area(on: Judge, evidence: Evidence) -> Iterator[Verdict]:
    maps, points = evidence["maps"], evidence["control_points"]
    high, dead, near_k = (maps.values(metric, pose="first run") for metric in ("high", "dead", "dead_near_k"))
    ill = maps.values("dead", pose="ill placed")
    four, nine, most = (points.values("dead", points=count) for count in (4, 9, 25))

    note = "Share of the area with at least half of the largest w, at the printed pose of the first run."
    yield on("high-over-most-of-the-area", high > 0.5, note, ours=both("{:.0%}", high))
    note = (
        "Share of the area where w is zero, at the printed pose of the first run. The dead part of the quarter at K is "
        f"{both('{:.0%}', near_k)} of the area."
    )
    small_at_k = (dead > 0) & (dead < 0.1) & (near_k > 0.9 * dead)
    yield on("dead-zone-near-k", small_at_k, note, ours=both("{:.0%}", dead))
    note = "Share of the area where w is zero, as printed: out of reach there."
    yield on("ill-placed-pose-is-dead", ill > 0.1, note, ours=both("{:.0%}", ill))
    note = (
        "Share of the poses that reach all corners and have a dead spot inside: between the corners w may be smaller than "
        "at any of them, and zero."
    )
    yield on("minimum-is-assured", four == 0, note, ours=both("{:.0%}", four))
    note = f"Share of poses with a dead spot left by nine points. Twenty-five leave {both('{:.1%}', most)}."
    yield on("four-points-may-not-suffice", four > 0, note, ours=both("{:.1%}", nine))


def acceptance(evidence: Evidence) -> Iterator[Acceptance]:
    """Figures that must hold for the book to be accepted."""
    error = evidence["closed_form"].values("error").max()
    yield Acceptance("closed form of w from the determinant [m³]", error, 1e-10)
    missed = 20 - matches(evidence["angles"].where(ARMS["fitted"])).sum()
    yield Acceptance("entries of Table 4 that the fitted arm misses", missed, 6)


def matches(misses: pd.DataFrame) -> pd.Series:
    """Count the angles of Table 4 that match a branch, in each row."""
    return (misses[[ANGLES[i] for i in COMPARED]].abs() <= MATCH).sum(axis="columns")


def both(form: str, values: pd.Series) -> str:
    """Write a value, which has one seed, for both arms."""
    return ", ".join(f"{form.format(values[reading].item())} ({arm})" for arm, reading in ARMS.items())
