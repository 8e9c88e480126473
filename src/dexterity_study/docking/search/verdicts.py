"""Verdicts on the genetic search of paper B.

A run is near the optimum at 95 % of it, and trapped below 90 %. It ends at a pose like the ill-placed one if more than a
tenth of the area is dead. M_a jumps if it changes by more than a tenth of its largest value between poses 1e-12 apart.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pandas as pd

from dexterity_study.claims.judge import Judge
from dexterity_study.claims.outcome import Acceptance, Verdict
from dexterity_study.docking.search.experiment import ALONE, NEAR
from dexterity_study.engine.evidence import Evidence
from dexterity_study.page.numbers import with_range

TRAPPED, DEAD, JUMP = 0.90, 0.10, 0.10
STEP = 0.01
"""Step of the chromosome [m], by which a base may be beyond the border of a quarter."""


def verdicts(evidence: Evidence) -> Iterator[Verdict]:
    """Judge the claims of the chapter."""
    on = Judge("sotiropoulos2011")
    yield from _on_the_problem(on, evidence)
    yield from _on_runs(on, evidence)
    yield from _on_table_3(on, evidence)


def _on_the_problem(on: Judge, evidence: Evidence) -> Iterator[Verdict]:
    geometry = evidence["geometry"].where().iloc[0]
    yield on("foot", geometry["deviation"], "Deviation of D from that by a chain of joints [m].")
    allowed = evidence["table_3"].where(None).groupby("reading", sort=False)["allowed"].all()
    yield on("group", allowed, "The seven printed poses are in both groups, and do not tell them apart.")
    jump, largest = geometry["jump"], geometry["largest"]
    note = (
        f"A joint limit switches a branch off: M_a jumps by {jump:.3f} m³, and is {largest:.3f} m³ at most."
    )
    yield on("objective-is-not-continuous", [jump > JUMP * largest], note)
    best = optima(evidence).drop(index=[*ALONE.values()])
    nearest = best["distance"] <= best["nearest_image"] + 1e-9
    yield on(
        "distance-breaks-the-tie",
        (best["tied"] >= 2) & nearest & (best["farthest_image"] > best["distance"] + 1e-3),
        "Quarter turns about the middle of the area change M_a by rounding alone, and the optimum is the nearest of these "
        "poses. The stated arm's mirror image about the diagonal stays tied.",
        ours=f"{best['tied'].min():.0f} of four turned poses as good without D",
    )
    note = "No rule is given; the plainest one is taken, see the assumptions."
    yield on.underspecified("probabilities-favour-and-fall", note)


def _on_runs(on: Judge, evidence: Evidence) -> Iterator[Verdict]:
    runs, gradients = found(evidence), evidence["gradients"].where(None)
    flat, climbed = (f"{gradients[of].min():.0%} to {gradients[of].max():.0%}" for of in ("flat", "climbed"))
    first, last = (evidence["penalty"].values(end) for end in ("first", "last"))
    yield on(
        "penalty-discards",
        last < first,
        "Share of the individuals that are not allowed, at the end and at the start. Zero is more than the fitness −b D of "
        f"the {flat} of the allowed poses that do not reach all corners.",
        ours=f"{last.iloc[0]:.0%}, after {first.iloc[0]:.0%}",
    )
    yield on("inside-margins", runs["allowed"], "A run whose best fitness is above zero is allowed.")
    shares = runs["share"]
    note = f"Near is {NEAR:.0%} of the true optimum; found: {_by_region(100 * shares, '{:.0f}')} % of it."
    yield on("near-optimal", shares >= NEAR, note)
    yield on(
        "no-local-minima",
        shares >= TRAPPED,
        f"Below {TRAPPED:.0%} a run counts as trapped; the worst has {shares.min():.0%}. Of climbs by gradients {climbed} "
        f"come near, since {flat} of the allowed poses are flat.",
    )
    note = "Runs dead over a tenth of the area at most. Four corners do not see what is between them."
    yield on("high-dexterity", runs["dead"] <= DEAD, note)
    note = "Before a side of the area the best poses are on the border of two quarters, and count for both."
    yield on("same-quarter", runs["on_quarter"], note)
    yield on("face-the-target", runs["faces"], "The ray ahead of the base meets the task area.")
    count = runs.loc["chosen"]["evaluations"].median()
    note = (
        f"A run rates {count:.0f} poses; neither the vehicle's computer nor a mission control is described."
    )
    yield on.out_of_scope("on-board", note)


def _on_table_3(on: Judge, evidence: Evidence) -> Iterator[Verdict]:
    runs, fit = found(evidence), evidence["printed_fitness"].where().iloc[0]
    runs = runs[runs["on_quarter"]]
    note = "Runs that end on the nearest quarter; each printed value is held to their range."
    for name in ("x", "y", "psi"):
        claim = f"poses-{name}"
        yield on(claim, [runs[name]] * len(on.printed(claim)), note, ours=_by_region(runs[name]))
    note = "The margin was chosen so that these values lie in it."
    yield on.fitted("poses-z", note, _by_region(runs["z"]))
    yield (on.refuted if fit["misfit"] > 1e-6 else on.underspecified)(
        "fitness-of-runs",
        "No weights a, b ≥ 0 and no initial heading make a M_a − b D of the printed fitness, with the printed M_a.",
        f"missed by {fit['misfit']:.3f} at least, at a = {fit['a']:.3g} and b = {fit['b']:.3g}",
    )
    ours = evidence["table_3"].where(None).pivot(index="reading", columns="run", values="area_manipulability")
    fitness, dexterity = (_pairs(on.printed(f"{of}-of-runs")) for of in ("fitness", "area-manipulability"))
    held = {reading: pd.Series(_pairs(own) * fitness > 0) for reading, own in ours.iterrows()}
    fitted = ours.loc["fitted-arm=fitted"]
    yield on(
        "best-run",
        pd.concat(held, names=["reading"]),
        "Pairs of the printed poses that our M_a puts in the order of the printed fitness. The printed columns "
        f"{'have' if (fitness * dexterity > 0).all() else 'do not have'} one order. The stated arm reaches all corners from "
        f"{(ours.loc['chosen'] > 0).sum()} of the poses, the fitted one from {(fitted > 0).sum()}, of which run "
        f"{fitted.idxmax()} is its best.",
    )


def acceptance(evidence: Evidence) -> Iterator[Acceptance]:
    """Figures that must hold for the book to be accepted."""
    yield Acceptance("D against that of a chain [m]", evidence["geometry"].where()["deviation"].item(), 1e-12)
    best, highest = optima(evidence), found(evidence)["share"].groupby("reading").max()
    for reading, apart in (best["evolved"] / best["fitness"] - 1).abs().items():
        yield Acceptance(f"difference of two methods, {reading}", apart, 1e-3)
    for bodies in ("block", "block and vehicle"):
        own = physical(evidence, bodies)
        for reading, apart in (own["evolved"] / own["area_manipulability"] - 1).abs().items():
            yield Acceptance(f"difference of two methods around {bodies}, {reading}", apart, 1e-3)
    for reading, share in highest.items():
        yield Acceptance(f"a genetic run above the optimum, {reading}", share - 1, 1e-3)


def optima(evidence: Evidence) -> pd.DataFrame:
    """Return the true optima by reading."""
    return evidence["optimum"].where(None).set_index("reading")


def physical(evidence: Evidence, bodies: str) -> pd.DataFrame:
    """Return the optima by reading of an arm that goes around the block, or around block and vehicle."""
    rows = evidence["physical"].where(None)
    return rows[rows["bodies"] == bodies].set_index("reading")


def found(evidence: Evidence) -> pd.DataFrame:
    """Return the genetic runs by reading and seed, with what they are worth beside the true optimum."""
    rows = evidence["genetic"].where(None).set_index(["reading", "seed"])
    best = optima(evidence).loc[rows.index.get_level_values("reading")]
    return rows.assign(
        share=rows["fitness"] / best["fitness"].to_numpy(),
        of_lattice=rows["fitness"] / best["on_lattice"].to_numpy(),
        on_quarter=(rows[["x", "y"]] < STEP).all(axis="columns"),
    )


def _by_region(values: pd.Series, form: str = "{:.2f}") -> str:
    regions = {"and": "chosen", "or": "reading-of-the-group=or"}
    return "; ".join(f"{with_range(values[own], form)} ({name})" for name, own in regions.items())


def _pairs(values: object) -> np.ndarray:
    """Return the differences of all pairs."""
    own = np.asarray(values, dtype=float)
    first, second = np.triu_indices(len(own), 1)
    return own[first] - own[second]
