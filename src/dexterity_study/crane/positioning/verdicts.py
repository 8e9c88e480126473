"""Verdicts on the four ways to position of paper D."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import pairwise, product

import numpy as np
import pandas as pd

from dexterity.crane import TEST_PAYLOADS, TEST_POINTS
from dexterity_study.claims.judge import Judge
from dexterity_study.claims.outcome import Acceptance, Verdict
from dexterity_study.crane.positioning import experiment
from dexterity_study.crane.positioning.experiment import DIRECT, EXACT, FREE, GENETIC, INVERSE, MODULAR, NONE
from dexterity_study.engine.evidence import Evidence
from dexterity_study.engine.readings import Reading
from dexterity_study.page.numbers import with_range

NAMES = {GENETIC: "correction", DIRECT: "direct", MODULAR: "modular", INVERSE: "inverse"}
LEFT_OUT = {DIRECT: ((1, 7), (2, 7)), MODULAR: ((1, 6), (1, -2))}
"""Points that the thesis leaves out, for they came out worst."""

TOLERANCES = {1e-5: "-coarse", 1e-7: "", 1e-8: "-fine"}
"""Tolerances of a descent, with the ends of the claims on its steps."""


def verdicts(evidence: Evidence) -> Iterator[Verdict]:
    """Judge the claims of the chapter."""
    on = Judge("rouvinen1999")
    formulas, note = evidence["formulas"], "Relative, from automatic differentiation at the test points."
    yield on("crane-output-error", formulas.values("gradient"), note)
    yield on("crane-input-descent", formulas.values("gradient"), note)
    yield on(
        "crane-modular-sum", formulas.values("sum"), "Both halves run apart, beside the whole; relative."
    )
    of = evidence["methods"].values
    for (method, name), kind in product(NAMES.items(), ("mean", "max")):
        values = [of(f"{kind}{axis}", method=method) for axis in ("_x", "_y", "")]
        yield on(f"crane-{name}-{kind}", values, f"Column of the table, {method}.", form="{:.1f}", unit="mm")
    yield from _on_correction(on, evidence)
    yield from _on_descents(on, evidence)
    yield from _on_networks(on, evidence)
    yield from _on_all(on, evidence)


def acceptance(evidence: Evidence) -> Iterator[Acceptance]:
    """Figures that must hold for the book to be accepted."""
    for name in ("gradient", "sum"):
        yield Acceptance(f"relative deviation of a {name}", evidence["formulas"].values(name).max(), 1e-9)
    exact = evidence["methods"].where(method=EXACT)["mean"].median()
    yield Acceptance("mean error of method 1, solved exactly, median [mm]", exact, 2.5)


def _on_correction(on: Judge, evidence: Evidence) -> Iterator[Verdict]:
    moved = evidence["branch"].by_seed("moved", over="given")
    note = f"Median change of a stroke: {moved[2].median():.0f} mm, {moved[0].median():.0f} mm without those two."
    yield on("crane-seeds-keep-the-branch", moved[2] < 0.5 * moved[0], note)
    own, none = distance(evidence, GENETIC), distance(evidence, NONE)
    point, load = np.divmod(own.reshape(len(own), -1).argmax(1), len(TEST_PAYLOADS))
    note = (
        f"Which one is the worst depends on the network and on what the search leaves: {named(set(point))}."
    )
    yield on("crane-correction-worst", at((2, -4))[point] & (np.array(TEST_PAYLOADS)[load] == 30), note)
    added = own - none
    worse = (added > 0).any(2)
    others = worse[:, ~at((1, 6), (2, 2))].sum(1)
    note = f"Worse at some load are {with_range(worse.sum(1))} points of 25, {with_range(others)} of them not named."
    yield on("crane-correction-helps-nearly-everywhere", (others == 0) & (worse.sum(1) <= 2), note)
    note = "Negative where method 1 helps."
    yield on("crane-correction-harm", added[:, at((1, 6))][:, 0, :2].T, note, form="{:.1f}", unit="mm")
    yield on("crane-correction-harm-at-2-2", added[:, at((2, 2))][:, 0, 0], note, form="{:.1f}", unit="mm")
    light, rest = own[..., 0].mean(1), own[..., 1:].mean((1, 2))
    note = f"Mean error with 30 kg, below all training data: {with_range(light)} mm; {with_range(rest)} mm with the others."
    yield on("crane-correction-extrapolates", (light < 1.5 * rest) & (light < none[..., 0].mean(1)), note)


def _on_descents(on: Judge, evidence: Evidence) -> Iterator[Verdict]:
    methods, descents = evidence["methods"], evidence["descents"]
    for method, left_out in LEFT_OUT.items():
        own, name = distance(evidence, method), NAMES[method]
        two, medians = np.argsort(-own.max(2), axis=1)[:, :2], np.median(own.max(2), axis=0)
        note = f"By the largest error at any load; by the medians over the seeds they are {named(np.argsort(-medians)[:2])}."
        yield on(f"crane-{name}-worst", at(*left_out)[two].all(1), note)
        kept, note = own[:, ~at(*left_out)], "The same two points left out."
        values = [kept.max((1, 2)), kept.mean((1, 2))]
        yield on(f"crane-{name}-without-worst", values, note, form="{:.1f}", unit="mm")
        for tolerance, end in TOLERANCES.items():
            if (claim := f"crane-{name}-iterations{end}") in [each.id for each in on.paper.claims]:
                steps = descents.where(method=method, tolerance=tolerance)
                note = "Steps are inversely proportional to a learning rate that is nowhere printed."
                ours = f"{with_range(steps['steps'], '{:.0f}')}, {with_range(steps['most_steps'], '{:.0f}')} steps"
                yield on.underspecified(claim, note, ours)
    direct, modular = (descents.by_seed("mean", "tolerance", method=one) for one in LEFT_OUT)
    gains = [100 * (1 - direct[b] / direct[a]) for a, b in pairwise(direct)]
    note = "Of errors in scaled outputs."
    yield on("crane-direct-tolerance-gain", gains, note, form="{:.0f}", unit="%")
    yield on("crane-modular-tolerance-loss", modular[1e-5] / modular[1e-7], note, form="{:.2f}", unit="times")
    taken, moved = (methods.values(name, method=DIRECT) for name in ("steps", "moved"))
    note = f"Strokes move by {with_range(moved)} mm, as medians, but it takes {with_range(taken, '{:.0f}')} steps on the mean; hundreds in the thesis, too."
    yield on("crane-few-iterations", (taken <= 20) & (moved < 20), note)


def _on_networks(on: Judge, evidence: Evidence) -> Iterator[Verdict]:
    methods, left = evidence["methods"], evidence["training"].where(method=MODULAR)
    note = f"{with_range(left['left'])} mm over the training data, and {with_range(left['apart'])} mm with a network of the sag; the first network misses the rigid tip by {with_range(left['rigid'])} mm."
    yield on("crane-modular-residual", left["left"] < left["apart"], note)
    fewer, better = (_pairs(evidence, MODULAR, DIRECT, metric) for metric in ("steps", "mean"))
    note = "Of all pairs of seeds. Both descend with the largest safe rate of their own network."
    yield on("crane-modular-needs-fewer", fewer, note)
    note = "Of all pairs of seeds. A matter of the seed, unless the share is near one of its ends."
    yield on("crane-modular-beats-direct", better, note)
    largest, none = methods.values("max", method=MODULAR), methods.where(method=NONE)["max"].max()
    readings = [Reading.of("rouvinen1999", name) for name in ("chosen", "crane-reasonable=0.25")]
    small = {own.name: largest["chosen"] < own["crane-reasonable"] * none for own in readings}
    note = f"{with_range(largest)} mm, against {none:.0f} mm without compensation, of which some share is called reasonable."
    yield on("crane-modular-max-is-reasonable", pd.concat(small, names=["reading"]), note)
    counted = evidence["operations"]
    own, free = (methods.values("mean", method=method) for method in (INVERSE, FREE))
    none, strokes = methods.where(method=NONE)["mean"].max(), evidence["training"].where(method=INVERSE)
    note = f"{with_range(own)} mm, against {none:.1f} mm without compensation: the network misses its strokes by {with_range(strokes['left'])} mm over its data, and the mechanism makes more of it."
    yield on("crane-inverse-fails", own > none, note)
    answer = counted.values("answer")
    note = "A tangent as one operation. Scaling is counted, the rule for the extension is not."
    yield on("crane-inverse-operations", answer, note, form="{:g}", unit="operations")
    descent = methods.where(method=DIRECT)["steps"].median() * counted.values("step")
    ours = f"{answer['chosen'].item()} operations; {descent['chosen'].item():,.0f} for a descent of method 2"
    note = "Cheap, and farther from the target than no compensation at all."
    yield on("crane-inverse-is-cheap", answer < 0.1 * descent, note, ours=ours)
    note = f"With the same neurons, all three strokes from point and load: {with_range(free)} mm; {with_range(own)} mm with the extension given."
    yield on("crane-unrestricted-inverse-is-no-function", own < free, note)


def _on_all(on: Judge, evidence: Evidence) -> Iterator[Verdict]:
    methods, orders = evidence["methods"], {}
    for better, worse in pairwise((GENETIC, MODULAR, DIRECT, INVERSE)):
        both = [_pairs(evidence, better, worse, kind) for kind in ("mean", "max")]
        orders[f"{better} < {worse}"] = min(both, key=np.mean)
    shares = ", ".join(f"{name}: {own.mean():.0%}" for name, own in orders.items())
    note = "Of all pairs of seeds, by the mean or the largest error, whichever has fewer; the weakest of the three decides."
    yield on("crane-order", min(orders.values(), key=np.mean), note, ours=shares)
    own, none, exact = (methods.where(method=one)["mean"] for one in (GENETIC, NONE, EXACT))
    printed = on.printed("crane-correction-mean")[2]
    cases = {"it falls": own.max() < none.max(), f"to {printed:.1f} mm": own.min() <= printed <= own.max()}
    note = f"From {none.max():.1f} mm, which is fitted, to {with_range(own)} mm; to {with_range(exact)} mm if the rigid crane is solved exactly."
    yield on("crane-compensation-helps", cases, note)
    needs_none = {"method 2": True, "method 3": False}
    note = "By what they learn from: tips, which can be measured; the first network of method 3, the tips of a rigid model."
    yield on("crane-no-kinematic-model", needs_none, note)
    first, second = (methods.values(f"{one}_search", method=GENETIC) for one in ("first", "second"))
    factor = (first + second) / first
    note = f"Generations of both searches are {with_range(factor)} times those of the first, which starts next to its solution."
    yield on("crane-doubles-time", (factor > 1.5) & (factor < 2.5), note)
    note = "No accuracy that loading or drilling needs is stated, and none was measured here."
    yield on.out_of_scope("crane-useful-accuracy", note)


def distance(evidence: Evidence, method: str) -> np.ndarray:
    """Return the distances (seeds, points, loads) that a method leaves at the test points [mm]."""
    own = evidence["methods"].array("distance")[:, experiment.METHODS.index(method)]
    return own.reshape(len(own), len(TEST_POINTS), len(TEST_PAYLOADS)).astype(float)


def at(*points: tuple[float, float]) -> np.ndarray:
    """Tell which of the test points these are."""
    return np.array([point in points for point in TEST_POINTS])


def named(points: Iterable[int]) -> str:
    """Write test points, told by their places in the list."""
    return " and ".join("({:g}, {:g})".format(*TEST_POINTS[place]) for place in points)


def _pairs(evidence: Evidence, better: str, worse: str, metric: str) -> np.ndarray:
    """Tell for each seed of one method and each of another whether the metric is smaller."""
    own, other = (evidence["methods"].where(method=one)[metric].to_numpy() for one in (better, worse))
    return (own[:, None] < other).ravel()
