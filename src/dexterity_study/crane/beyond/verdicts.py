"""Verdicts on what paper D says of exact solutions, of networks against them, and of its remedies."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pandas as pd

from dexterity_study.claims.judge import HALF, Judge
from dexterity_study.claims.outcome import Acceptance, Verdict
from dexterity_study.crane.beyond.experiment import COROTATIONAL, EXACT, REGRESSION, STRUCTURE, THESIS
from dexterity_study.engine.evidence import Evidence
from dexterity_study.engine.readings import Reading
from dexterity_study.page.numbers import with_range

LOOP, ASKED = f"{STRUCTURE}, in a loop", ("at once", "one by one")
NOTICEABLE = 0.9
"""Share of its error, beside its size, below which a smaller crane does better: a tenth, set beforehand."""


def verdicts(evidence: Evidence) -> Iterator[Verdict]:
    """Judge the claims of the chapter."""
    on = Judge("rouvinen1999")
    yield from _on_remedies(on, evidence)
    yield from _on_solving(on, evidence)
    yield from _on_speed(on, evidence)


def acceptance(evidence: Evidence) -> Iterator[Acceptance]:
    """Figures that must hold for the book to be accepted, in [mm] and in [µs]."""
    for structure in ("linear", "co-rotational"):
        left = loop(evidence, structure)["largest"].to_numpy()[-1]
        yield Acceptance(
            f"largest error of the {structure} structure in a loop [mm]", 1e3 * left, 1e3 * EXACT
        )
    learned = evidence["exact_methods"].where(method=f"{REGRESSION}, in a loop").iloc[0]
    yield Acceptance("mean error of the learned sag [mm]", 1e3 * learned["test_mean"], 0.1)
    yield Acceptance("largest error of the learned sag [mm]", 1e3 * learned["test_largest"], 0.5)
    network = times(evidence, "sag", "at once")["median"][THESIS]
    yield Acceptance("time of a network evaluation, at once [µs]", 1e6 * network, 2.0)


def loop(evidence: Evidence, structure: str, points: str = "test") -> pd.DataFrame:
    """Return the errors of a structure in a loop by the number of solves."""
    return evidence["loops"].where(structure=structure, points=points).set_index("solves")


def times(evidence: Evidence, of: str, points: str) -> pd.DataFrame:
    """Return quartiles of processor times [s] by what was asked."""
    return evidence["times"].where(of=of, points=points).set_index("way")


def growth(evidence: Evidence, goal: float = 1e-3) -> list[tuple[float, float]]:
    """Return by what power of one over the error tables grow, and the entries for an error, by size of the crane."""
    fits = [
        np.polyfit(np.log(rows["largest"]), np.log(rows["entries"]), 1)
        for _, rows in evidence["tables"].where().groupby("size", sort=False)
    ]
    return [(-float(fit[0]), float(np.exp(np.polyval(fit, np.log(goal))))) for fit in fits]


def _on_remedies(on: Judge, evidence: Evidence) -> Iterator[Verdict]:
    lighter = evidence["lighter_payloads"]
    spot, light = (1e3 * lighter.by_seed(name, over="data") for name in ("spot", "light"))
    before, after = spot.columns
    note = f"Seeds in which the error at (2, 2) with 30 kg falls with 10, 20 and 40 kg in the data. The mean of all points with 30 kg goes from {with_range(light[before])} to {with_range(light[after])} mm."
    ours = f"{with_range(spot[after])} mm against {with_range(spot[before])} mm"
    yield on("crane-lighter-payloads-would-help", (spot[after] < spot[before]).to_numpy(), note, ours=ours)
    of_data = evidence["even_data"]
    largest = {m: 1e3 * of_data.by_seed("largest", over="data", method=m) for m in ("method 2", "method 3")}
    shares = {m: (own["as many, evenly"] < own["thesis's grid"]).mean() for m, own in largest.items()}
    each = (f"{m}: {with_range(own[data])} mm ({data})" for m, own in largest.items() for data in own)
    note = f"Cases: methods whose largest error falls in most seeds. Largest errors, {'; '.join(each)}."
    ours = ", ".join(f"{share:.0%} of the seeds ({method})" for method, share in shares.items())
    falls = {method: share >= HALF for method, share in shares.items()}
    yield on("crane-denser-data-would-help", falls, note, ours=ours)
    errors = 1e3 * evidence["smaller_crane"].by_seed("mean", over="size")
    whole, small = errors.columns.to_numpy()
    share = errors[small].median() / small / errors[whole].median()
    amplification = evidence["smaller_crane"].where().groupby("size")["amplification"].first()
    note = f"As a share of the size the mean error is {share:.2f} times what it was: it shrinks with the crane. The amplification, which is blamed, is a ratio and stays as it is ({amplification[whole]:.3g} and {amplification[small]:.3g})."
    cases = {"in millimetres": share * small < 1, "beside its size": share < NOTICEABLE}
    ours = f"{with_range(errors[small])} mm against {with_range(errors[whole])} mm"
    yield on("crane-smaller-would-help", cases, note, ours=ours)
    (power, needed), (_, needed_small) = growth(evidence)
    entries = evidence["tables"].where(size=1.0).set_index("entries")["largest"]
    note = f"Entries grow as error^(−{power:.2f}). {entries.idxmax():,} entries leave {1e3 * entries.max():.3g} mm, {entries.idxmin():,} leave {1e3 * entries.min():.3g} mm."
    cases = {"with the accuracy": power > 1, "with the working area": needed > needed_small}
    ours = f"{needed:,.0f} entries for a millimetre; {needed_small:,.0f} with a crane of half the size"
    yield on("crane-tables-grow", cases, note, ours=ours)


def _on_solving(on: Judge, evidence: Evidence) -> Iterator[Verdict]:
    errors, fresh = loop(evidence, "linear"), loop(evidence, "linear", "fresh")
    once, last, solves = errors["mean"][1], errors["largest"].to_numpy()[-1], errors.index.max()
    simulated = on.printed("crane-correction-mean")[2]
    note = f"Rigid inverse and deflection have closed forms both. One put into the other once, without any iteration, misses by less than the thesis's best method does on average, and {solves} times by almost nothing. At {fresh['unsettled'].to_numpy()[-1]:.1%} of fresh points that does not settle, where the jib is folded, and Gauss–Newton takes over."
    ours = f"mean {1e3 * once:.3g} mm after one solve, largest {1e3 * last:.3g} mm after {solves}"
    impossible = bool(1e3 * once >= simulated or last > EXACT)
    yield on("crane-analytical-impossible", [impossible], note, ours=ours)
    seconds = times(evidence, "training data", "at once")["median"]["training data"]
    mean, most = 1e3 * evidence["models_apart"].where()[["mean", "largest"]].to_numpy()[0]
    measured = on.printed("crane-measured-target-rmean")[-1]
    cases = {
        "quickly": bool(seconds < 60 * on.printed("crane-training-time")),
        "accurately": measured <= simulated + on.printed("crane-measured-accuracy"),
    }
    note = f"A co-rotational structure differs from linear statics by {mean:.3g} mm on average, {most:.3g} mm at most. The real crane, compensated so, is measured {measured} mm off on average in the thesis, where simulation has {simulated:.3g} mm."
    ours = f"{seconds:.2g} s for all of the training data, on one core"
    yield on("crane-simulation-suffices", cases, note, ours=ours)


def _on_speed(on: Judge, evidence: Evidence) -> Iterator[Verdict]:
    points, sags = ({way: times(evidence, of, way) for way in ASKED} for of in ("point", "sag"))
    limits = {
        name: Reading.of(on.paper.key, name)["crane-real-time"] for name in ("chosen", "crane-real-time=0.1")
    }
    slow = {(name, way): points[way]["upper"][LOOP] >= limits[name] for name in limits for way in points}
    analysis = 60 * on.printed("crane-training-time") / on.printed("crane-grid-vectors")
    note = f"Cases: points that come at once, which tells the arithmetic, and one by one, which is mostly calls from Python. The co-rotational structure takes {_ms(points['at once'], COROTATIONAL)} at once. With the analyses of 1999 a point would have taken {analysis * loop(evidence, 'linear').index.max():.1f} s, and the claim was right then."
    cases = pd.Series(slow, dtype=bool).rename_axis(["reading", "points"])
    ours = "; ".join(f"{_ms(own, LOOP)} a point {way}" for way, own in points.items())
    yield on("crane-iterative-is-expensive", cases, note, ours=ours)
    ratios = [f"{own['median'][STRUCTURE] / own['median'][THESIS]:.3g} {way}" for way, own in sags.items()]
    note = "Cases in which the quartiles of network and structure lie apart, for a sag on one core."
    cheaper = {way: own["upper"][THESIS] < own["lower"][STRUCTURE] for way, own in sags.items()}
    yield on("crane-networks-are-cheaper", cheaper, note, ours=f"times as fast: {', '.join(ratios)}")


def _ms(rows: pd.DataFrame, way: str) -> str:
    median, lower, upper = (f"{1e3 * rows[name][way]:.2g}" for name in ("median", "lower", "upper"))
    return f"{median} ms ({lower}–{upper})"
