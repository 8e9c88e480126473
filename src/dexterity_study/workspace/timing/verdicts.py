"""Verdicts on the times of paper C: orders of times are judged, times of the authors' machine are not."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np
import pandas as pd

from dexterity.timing import Timing
from dexterity_study.claims.judge import Judge
from dexterity_study.claims.outcome import Acceptance, Verdict
from dexterity_study.engine.evidence import Evidence
from dexterity_study.engine.table import Table
from dexterity_study.workspace.timing import experiment as of

Place = tuple[str, str]

PRINTED = {
    "time-ikine": (of.TOOLBOX, of.NUMERICAL),
    "time-ikine6s": (of.TOOLBOX, of.ANALYTIC),
    "time-jacobian-numerical": (of.TOOLBOX, of.NUMERICAL_JACOBIAN),
    "time-jacobian-analytic": (of.TOOLBOX, of.ANALYTIC_JACOBIAN),
    "time-confidence-networks": (of.SOME, of.PAPERS),
    "time-estimation-network": (of.SOME, of.PAPERS),
}
"""Rung and way whose time is beside a printed one, by claim."""

RUNGS = {"chosen": of.SOME, "time-of-a-sample=single": of.SINGLE}
"""Rung of networks by reading."""


def verdicts(evidence: Evidence) -> Iterator[Verdict]:
    """Judge the claims of the chapter."""
    on, ladder, size = Judge("liao2018"), times(evidence), sizes(evidence)
    yield from _on_grids(on, evidence, ladder)
    yield from _on_order(on, ladder)
    yield on.underspecified(
        "portable",
        "The paper does not say what portable means. Its network's weights need a library for networks; the exact answer "
        "needs math.h.",
        f"{4e-6 * size['parameters']:.0f} MB of weights beside a C file of {size['source_bytes'] / 1024:.0f} kB",
    )
    own = {claim: (ladder[place].median, "") for claim, place in PRINTED.items()}
    for row in evidence["others"].where().to_dict("records"):
        own[f"time-{row['method']}"] = row["median"], f" Ours was trained on {row['rows']:,} rows."
    for claim, (median, trained) in own.items():
        times_ours = printed_seconds(on, claim) / median
        note = f"That is of the authors' machine and software; it is {times_ours:.3g} times ours.{trained}"
        yield on.out_of_scope(claim, note, f"{1e6 * median:,.3g} µs")


def acceptance(evidence: Evidence) -> Iterator[Acceptance]:
    """Figures that must hold for the book to be accepted."""
    for name in ("toolbox", "torch", "c"):
        yield Acceptance(f"Jacobian, {name}, from that by angles", sizes(evidence)[name], 1e-9)


def times(evidence: Evidence) -> dict[tuple[str, str], Timing]:
    """Return the times of the ladder by rung and way."""
    rows = evidence["ladder"].where().to_dict("records")
    return {
        (row["rung"], row["way"]): Timing(row["way"], *(row[name] for name in of.COLUMNS)) for row in rows
    }


def sizes(evidence: Evidence) -> pd.Series:
    """Return the facts on the ways that are no times."""
    return evidence["ways"].where().iloc[0]


def printed_seconds(on: Judge, claim: str) -> float:
    """Return a printed time [s]; of several, which are all the same, the first."""
    return float(np.ravel(on.printed(claim))[0]) * (1.0 if on.paper.claim(claim).unit == "s" else 1e-6)


def exponent(grids: Table) -> float:
    """Return the slope of the logarithm of a grid's time over that of its side."""
    rows = grids.where()
    return float(np.polyfit(np.log(rows["side"]), np.log(rows["median"]), 1)[0])


def _on_grids(on: Judge, evidence: Evidence, ladder: Mapping[Place, Timing]) -> Iterator[Verdict]:
    slope = exponent(evidence["grids"])
    note = (
        "A grid of n steps a side has n⁶ poses, and the time of a pose does not depend on n. For the paper's arms, whose "
        "reach leaves orientation aside, n³ positions suffice."
    )
    yield on("complexity", slope, note, form="{:.2f}")
    slow = ladder[of.TOOLBOX, of.NUMERICAL_JACOBIAN].median / ladder[of.C_MANY, of.CLOSED].median
    note = (
        f"By numerical inverse kinematics a pose takes the toolbox {slow:,.0f} times as long as the closed form in C. But "
        "that is a factor for each pose, not a complexity."
    )
    cases = {"ten times as long as compiled": bool(slow >= 10), "a time that outgrows the poses": slope > 7}
    yield on("workspaces-are-slow", cases, note)


def _on_order(on: Judge, ladder: Mapping[Place, Timing]) -> Iterator[Verdict]:
    def faster(one: Place, other: Place) -> bool:
        """Whether the quartiles lie apart."""
        return ladder[one].upper < ladder[other].lower

    numerical, analytic = (of.TOOLBOX, of.NUMERICAL_JACOBIAN), (of.TOOLBOX, of.ANALYTIC_JACOBIAN)
    angles = (of.TOOLBOX, of.ANALYTIC), (of.TOOLBOX, of.NUMERICAL)
    pairs = {"angles": angles, "with the Jacobian": (analytic, numerical)}
    factors = {name: ladder[b].median / ladder[a].median for name, (a, b) in pairs.items()}
    ours = ", ".join(f"{name}: {factor:.0f} times" for name, factor in factors.items())
    cases = {name: faster(*pair) for name, pair in pairs.items()}
    yield on("analytic-faster-than-numerical", cases, "Quartiles lie apart.", ours=ours)
    holds = [
        faster((rung, of.PAPERS), rival)
        for rung in RUNGS.values()
        for rival in (numerical, analytic, (rung, of.CLOSED))
    ]
    index = pd.MultiIndex.from_product([RUNGS, range(3)], names=["reading", "case"])
    places = (of.SOME, of.PAPERS), (of.SOME, of.CLOSED), (of.C_MANY, of.CLOSED)
    network, exact, in_c = (1e6 * ladder[place].median for place in places)
    note = (
        "Cases: numerical and analytic inverse kinematics of the toolbox, and the exact answer in the same language and "
        f"batches. The exact answer takes {exact:.3g} µs in torch, {in_c:.2g} µs compiled."
    )
    ours = f"{network:.3g} µs in batches, {sum(holds[:3])} of 3 cases"
    yield on("faster-than-inverse-kinematics", pd.Series(holds, index), note, ours=ours)
