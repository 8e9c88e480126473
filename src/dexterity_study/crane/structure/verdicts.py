"""Verdicts on the structure of the crane, its training data and its errors without compensation."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pandas as pd

from dexterity.crane import TEST_PAYLOADS
from dexterity_study.claims.judge import Judge
from dexterity_study.claims.outcome import Acceptance, Verdict
from dexterity_study.crane.structure.experiment import GRID_PAYLOADS, STATISTICS, TARGETS, named, statistics
from dexterity_study.engine.evidence import Evidence

FAR = 0.9
"""Share of the points in reach that have a nearer training vector than a point about which data is scarce."""


def verdicts(evidence: Evidence) -> Iterator[Verdict]:
    """Judge the claims of the chapter."""
    on = Judge("rouvinen1999")
    yield from _on_model(on, evidence)
    yield from _on_training_data(on, evidence)
    yield from _on_errors(on, evidence)


def acceptance(evidence: Evidence) -> Iterator[Acceptance]:
    """Figures that must hold for the book to be accepted."""
    rest, linear = evidence["at_rest"].where(), evidence["linear_statics"].where().set_index("on")
    yield Acceptance("beams from closed forms", _beam_misses(evidence), 1e-8)
    yield Acceptance("forces left at equilibrium, as a share of the weight", rest["residual"].max(), 1e-6)
    yield Acceptance("co-rotational solutions that were not found", linear["missing"].sum(), 0)
    yield Acceptance("co-rotational from linear, mean over the test [mm]", float(linear["mean"]["test"]), 1.0)
    fitted = statistics_of(evidence).xs("chosen").iloc[0]
    off = max(abs(fitted[name] - target) for name, target in TARGETS.items())
    yield Acceptance("statistics that were fitted from the printed ones [mm]", off, 0.02)
    many = evidence["rates"].where(way="linear, 4,096 poses at once")["median"].max()
    yield Acceptance("processor time of a structural solve [µs]", 1e6 * many, 100)


def _on_model(on: Judge, evidence: Evidence) -> Iterator[Verdict]:
    ways, rest = evidence["ways"].where(), evidence["at_rest"].where().iloc[0]
    note = (
        "Whether the steel stays elastic, and whether warping matters, depends on sections that are not told."
    )
    yield on.underspecified("crane-linear-material", note)
    note = "Largest relative miss of clamped beams under a force and under their own weight, by elements. Without inertia, since the crane is at rest."
    yield on("crane-beam", _beam_misses(evidence), note)
    note = f"Force that is left at a node after {rest['steps']} Newton steps, as a share of all weight. With multipliers instead of independent coordinates, which has the same roots."
    yield on("crane-equilibrium", rest["residual"], note)
    ratios = ways["largest"] / ways["least"]
    note = f"Largest over least deflection of the ways to reach a test point, median over the points; at most {ratios.max():.2f}. Only the extension was varied."
    ours = f"{ratios.median():.2f} times"
    yield on("crane-deflection-depends-on-pose", [bool(ratios.median() > 1.1)], note, ours=ours)
    note = "The measurements are in another work, and the model and the crane are not at hand."
    yield on.out_of_scope("crane-model-verified", note)


def _on_training_data(on: Judge, evidence: Evidence) -> Iterator[Verdict]:
    coverage, rates = evidence["coverage"], evidence["rates"].where().set_index("way")["median"]
    hole, high, higher = coverage.where().to_dict("records")
    ends, steps, (least, most, step) = (
        on.printed(f"crane-grid-{name}") for name in ("stroke-ends", "increments", "masses")
    )
    counts = [*(np.divide(ends, steps) + 1), (most - least) / step + 1]
    yield on("crane-grid-values", counts, "From the printed ends and steps.", form="{:.0f}")
    yield on("crane-grid-vectors", hole["grid"], "The product of these four.", form="{:.0f}")
    listed = coverage.where("crane-jib-stroke=0.75")["vectors"].iloc[0]
    note = f"Left out are vectors whose rigid tip has a negative x; the rule was chosen because it leaves this number, as was the jib cylinder's end. By the loaded tip {hole['by_loaded_tip']:.0f} are left, with the listing's end {listed}. How links inside each other are told is not printed."
    yield on.fitted("crane-training-vectors", note, f"{hole['vectors']:.0f} vectors")
    cases = {
        "nine tenths within half a metre": hole["within"] >= 0.9,
        "half in several ways": hole["ways"] >= 0.5,
    }
    note = "Shares of the points in reach that have a vector within half a metre, and that are reached with two or more of the grid's extensions."
    yield on("crane-training-covers", cases, note, ours=f"{hole['within']:.0%} and {hole['ways']:.0%}")
    note = f"Distance of the nearest loaded tip, which is farther than at {hole['rank']:.0%} of the points in reach."
    yield on("crane-gap-at-2-2", [bool(hole["rank"] > FAR)], note, ours=f"{hole['distance']:.2f} m")
    cases = {
        "scarce about (1, 7)": high["rank"] > FAR,
        "scarce about (2, 7)": higher["rank"] > FAR,
        "more so about (2, 7)": higher["distance"] > high["distance"],
    }
    note = f"The nearest loaded tip is {high['distance']:.2f} m and {higher['distance']:.2f} m away, farther than at {high['rank']:.0%} and {higher['rank']:.0%} of the points in reach; {high['neighbours']:.0f} and {higher['neighbours']:.0f} poses are within a metre."
    yield on("crane-gap-at-2-7", cases, note)
    whole = hole["grid"] * rates
    ours = f"{whole['co-rotational, 64 at once']:.0f} s co-rotational, {whole['linear, 4,096 poses at once']:.2f} s linear"
    yield on.out_of_scope("crane-training-time", "That machine and that program are not at hand.", ours)
    apart = set(TEST_PAYLOADS).isdisjoint(GRID_PAYLOADS) and hole["nearest_test"] > 1e-3
    note = "Least distance of a test point from a loaded tip; no payload is in both. One payload is below the smallest that is trained."
    yield on("crane-test-is-not-trained", [bool(apart)], note, ours=f"{1e3 * hole['nearest_test']:.0f} mm")


def _on_errors(on: Judge, evidence: Evidence) -> Iterator[Verdict]:
    ours, swapped = statistics_of(evidence), swap_statistics(evidence)
    sections = evidence["fits"].where(changed="sections, masses, pads, strokes").query("found == True")
    left, taken, nearest = nearest_swap(evidence)
    off = (nearest / printed() - 1).abs().max()
    note = f"The last was fitted. Other sections leave x at {_span(sections['max x'])} mm. With {taken} for {left} a new fit meets all six statistics within {off:.1%}, and the thesis does not list its test points."
    largest = [ours[name] for name in STATISTICS[3:]]
    yield on("crane-uncompensated-max", largest, note, form="{:.1f}", unit="mm")
    chosen = ours.xs("chosen").iloc[0]
    note = f"The last was fitted, with the largest distance. With one test point swapped and a new fit x is {_span(swapped['mean x'])} mm and y {_span(swapped['mean y'])} mm."
    means = ", ".join(f"{chosen[name]:.1f}" for name in STATISTICS[:3]) + " mm"
    yield on.fitted("crane-uncompensated-mean", note, means)
    rows = evidence["uncompensated"].where().set_index(["x", "y", "payload"])
    sizes = 1e3 * np.hypot(rows["error_x"], rows["error_y"])
    three = {f"({x}, {y}), {m} kg": sizes[x, y, m] for x, y, m in ((1, 6, 30), (1, 6, 120), (2, 2, 30))}
    small = {name: size < on.printed("crane-uncompensated-small") for name, size in three.items()}
    note = "None of the three was fitted; they follow from the two numbers that were."
    told = ", ".join(f"{name}: {size:.1f} mm" for name, size in three.items())
    yield on("crane-uncompensated-small", small, note, ours=told)


def printed() -> pd.Series:
    """Return the six printed statistics of the errors without compensation [mm]."""
    on = Judge("rouvinen1999")
    values = (*on.printed("crane-uncompensated-mean"), *on.printed("crane-uncompensated-max"))
    return pd.Series(values, STATISTICS)


def statistics_of(evidence: Evidence) -> pd.DataFrame:
    """Return the six statistics [mm] by reading and seed."""
    groups = evidence["uncompensated"].where(None).groupby(["reading", "seed"], sort=False)
    rows = {run: statistics(own[["error_x", "error_y"]]) for run, own in groups}
    return pd.DataFrame.from_dict(rows, orient="index").rename_axis(["reading", "seed"])


def swap_statistics(evidence: Evidence) -> pd.DataFrame:
    """Return the six statistics [mm] of all fits with two test points swapped."""
    return pd.DataFrame(evidence["swaps"].array("statistics")[0], columns=list(STATISTICS)).astype(float)


def nearest_swap(evidence: Evidence) -> tuple[str, str, pd.Series]:
    """Return the swap of test points that comes nearest to all printed statistics: left out, taken, statistics."""
    every = swap_statistics(evidence)
    best = (every / printed() - 1).abs().max(axis=1).argmin()
    points = evidence["swaps"].array("swapped")[0][best]
    return named(points[:2]), named(points[2:]), every.iloc[best]


def _beam_misses(evidence: Evidence) -> float:
    return float(evidence["beams"].where()[["force", "own_weight"]].abs().to_numpy().max())


def _span(values: pd.Series) -> str:
    return f"{values.min():.1f}–{values.max():.1f}"
