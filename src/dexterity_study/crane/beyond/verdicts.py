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
from dexterity_study.page.tables import with_range

LOOP = f"{STRUCTURE}, in a loop"
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
    yield on(
        "crane-lighter-payloads-would-help",
        (spot[after] < spot[before]).to_numpy(),
        "Seeds in which the error at (2, 2) with 30 kg falls with 10, 20 and 40 kg in the data. The mean of all points "
        f"with 30 kg goes from {with_range(light[before])} to {with_range(light[after])} mm.",
        ours=f"{with_range(spot[after])} mm against {with_range(spot[before])} mm",
    )
    of_data = evidence["even_data"]
    largest = {m: 1e3 * of_data.by_seed("largest", over="data", method=m) for m in ("method 2", "method 3")}
    shares = {m: (own["as many, evenly"] < own["thesis's grid"]).mean() for m, own in largest.items()}
    told = (f"{m}: {with_range(own[data])} mm ({data})" for m, own in largest.items() for data in own)
    yield on(
        "crane-denser-data-would-help",
        {method: bool(share >= HALF) for method, share in shares.items()},
        f"Cases: methods whose largest error falls in most seeds. Largest errors, {'; '.join(told)}.",
        ours=", ".join(f"{share:.0%} of the seeds ({method})" for method, share in shares.items()),
    )
    errors = 1e3 * evidence["smaller_crane"].by_seed("mean", over="size")
    whole, small = errors.columns.to_numpy()
    share = errors[small].median() / small / errors[whole].median()
    amplification = evidence["smaller_crane"].where().groupby("size")["amplification"].first()
    yield on(
        "crane-smaller-would-help",
        {"in millimetres": bool(share * small < 1), "beside its size": bool(share < NOTICEABLE)},
        f"As a share of the size the mean error is {share:.2f} times what it was: it shrinks with the crane. The "
        "amplification, which is blamed, is a ratio and stays as it is "
        f"({amplification[whole]:.3g} and {amplification[small]:.3g}).",
        ours=f"{with_range(errors[small])} mm against {with_range(errors[whole])} mm",
    )
    (power, needed), (_, needed_small) = growth(evidence)
    entries = evidence["tables"].where(size=1.0).set_index("entries")["largest"]
    yield on(
        "crane-tables-grow",
        {"with the accuracy": bool(power > 1), "with the working area": bool(needed > needed_small)},
        f"Entries grow as error^(−{power:.2f}). {entries.idxmax():,} entries leave {1e3 * entries.max():.3g} mm, "
        f"{entries.idxmin():,} leave {1e3 * entries.min():.3g} mm.",
        ours=f"{needed:,.0f} entries for a millimetre; {needed_small:,.0f} with a crane of half the size",
    )


def _on_solving(on: Judge, evidence: Evidence) -> Iterator[Verdict]:
    errors, fresh = loop(evidence, "linear"), loop(evidence, "linear", "fresh")
    once, last, solves = errors["mean"][1], errors["largest"].to_numpy()[-1], errors.index.max()
    simulated = on.printed("crane-correction-mean")[2]
    yield on(
        "crane-analytical-impossible",
        [bool(1e3 * once >= simulated or last > EXACT)],
        f"Rigid inverse and deflection have closed forms both. One put into the other once, without any iteration, "
        f"misses by less than the thesis's best method does on average, and {solves} times by almost nothing. At "
        f"{fresh['unsettled'].to_numpy()[-1]:.1%} of fresh points that does not settle, where the jib is folded, and "
        "Gauss–Newton takes over.",
        ours=f"mean {1e3 * once:.3g} mm after one solve, largest {1e3 * last:.3g} mm after {solves}",
    )
    seconds = times(evidence, "training data", "at once")["median"]["training data"]
    apart = 1e3 * evidence["models_apart"].where()[["mean", "largest"]].to_numpy()[0]
    measured = on.printed("crane-measured-target-rmean")[-1]
    yield on(
        "crane-simulation-suffices",
        {
            "quickly": bool(seconds < 60 * on.printed("crane-training-time")),
            "accurately": bool(measured <= simulated + on.printed("crane-measured-accuracy")),
        },
        f"A co-rotational structure differs from linear statics by {apart[0]:.3g} mm on average, "
        f"{apart[1]:.3g} mm at most. The real crane, compensated so, is measured {measured} mm off on average "
        f"in the thesis, where simulation has {simulated:.3g} mm.",
        ours=f"{seconds:.2g} s for all of the training data, on one core",
    )


def _on_speed(on: Judge, evidence: Evidence) -> Iterator[Verdict]:
    points = {of: times(evidence, "point", of) for of in ("at once", "one by one")}
    limits = {
        name: Reading.of(on.paper.key, name)["crane-real-time"] for name in ("chosen", "crane-real-time=0.1")
    }
    slow = {(name, of): points[of]["upper"][LOOP] >= limit for name, limit in limits.items() for of in points}
    analysis = 60 * on.printed("crane-training-time") / on.printed("crane-grid-vectors")
    yield on(
        "crane-iterative-is-expensive",
        pd.Series(slow, dtype=bool).rename_axis(["reading", "points"]),
        "Cases: points that come at once, which tells the arithmetic, and one by one, which is mostly calls from Python. "
        f"The co-rotational structure takes {_ms(points['at once'], COROTATIONAL)} at once. With the analyses of "
        f"1999 a point would have taken {analysis * loop(evidence, 'linear').index.max():.1f} s, and the claim was right then.",
        ours="; ".join(f"{_ms(own, LOOP)} a point {of}" for of, own in points.items()),
    )
    sags = {of: times(evidence, "sag", of) for of in ("at once", "one by one")}
    ratios = [f"{own['median'][STRUCTURE] / own['median'][THESIS]:.3g} {of}" for of, own in sags.items()]
    yield on(
        "crane-networks-are-cheaper",
        {of: bool(own["upper"][THESIS] < own["lower"][STRUCTURE]) for of, own in sags.items()},
        "Cases in which the quartiles of network and structure lie apart, for a sag on one core.",
        ours=f"times as fast: {', '.join(ratios)}",
    )


def _ms(rows: pd.DataFrame, way: str) -> str:
    median, lower, upper = (f"{1e3 * rows[name][way]:.2g}" for name in ("median", "lower", "upper"))
    return f"{median} ms ({lower}–{upper})"
