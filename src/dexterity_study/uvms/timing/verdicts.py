"""Verdicts on the times of paper A."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, TypeAlias, cast

import pandas as pd
from scipy.stats import kendalltau

from dexterity.timing.measurement import three_digits
from dexterity_study.claims.judge import Judge
from dexterity_study.claims.outcome import Acceptance, Verdict
from dexterity_study.engine.evidence import Evidence
from dexterity_study.engine.readings import Reading
from dexterity_study.uvms.cost.experiment import INDICES
from dexterity_study.uvms.timing.experiment import (
    EXACT,
    FEED_FORWARD,
    FOOT,
    IN_KIND,
    OCTAVE_IN_KIND,
    RADIAL_BASIS,
)

NETWORKS = (FEED_FORWARD, RADIAL_BASIS)
READINGS = {
    "chosen": ("w", OCTAVE_IN_KIND),
    "rows-of-the-time-table=kci": ("KCI", OCTAVE_IN_KIND),
    "what-a-run-is=one": ("w", "Octave, simulated one by one"),
}
"""Index and rung of the networks whose times the paper prints, by reading, in its language; the exact index is in kind."""

ON = Judge("sotiropoulos2016")
TABLE_5 = {("w", EXACT): "analytical-w-time", ("KCI", EXACT): "analytical-kci-time"}
TABLE_5 |= {("w", network): f"{network}-time" for network in NETWORKS}
SEVERAL_HUNDRED = cast(tuple[int, int], Reading.of("sotiropoulos2016", "chosen")["planner-iteration"])
PRINTED_RATIOS = {side: ON.printed("analytical-w-time") / ON.printed(f"{side}-time") for side in NETWORKS}
_OF_TEST_SET = ON.printed("analytical-w-time") - ON.printed("feed-forward-time")
PRINTED_SAVING = _OF_TEST_SET / ON.printed("timing-inputs")
"""Time per configuration [s] that a feed-forward network for w saves by the printed times."""

Times: TypeAlias = Mapping[str, pd.DataFrame]


def quartiles(rows: pd.DataFrame) -> Times:
    """Return times [s] by quartile, each with a row for index and rung and a column for each side."""
    place: dict[str, Any] = {"index": ["index", "rung"], "columns": "side", "sort": False}
    return {name: rows.pivot_table(values=name, **place) for name in ("lower", "median", "upper")}


def measured(evidence: Evidence) -> Times:
    """Return the times [s] by quartile on all rungs, those in Octave first."""
    return quartiles(pd.concat([evidence["in_octave"].where(), evidence["ladder"].where()]))


def advantages(times: Times) -> pd.DataFrame:
    """Return how many times faster than the exact index each network is, by the medians."""
    networks = times["median"].drop(columns=EXACT)
    return networks.rdiv(times["median"][EXACT], axis="index")


def savings(times: Times) -> pd.Series:
    """Return the time per configuration [s] that a feed-forward network saves, by the medians."""
    return times["median"][EXACT] - times["median"][FEED_FORWARD]


def verdicts(evidence: Evidence) -> Iterator[Verdict]:
    """Judge the claims of the chapter."""
    times = measured(evidence)
    yield from _on_times(times)
    yield from _on_orderings(evidence, times)
    yield from _on_causes(evidence, times)
    yield from _on_planners(times)


def acceptance(evidence: Evidence) -> Iterator[Acceptance]:
    """Figures that must hold for the book to be accepted."""
    for index, own in evidence["agreement"].where().groupby("index", sort=False):
        yield Acceptance(f"ways to {index} from each other, relative", own["deviation"].max(), 1e-9)
    for index, own in evidence["in_octave"].where().groupby("index", sort=False):
        yield Acceptance(f"{index} in Octave, relative", own["deviation"].max(), 1e-9)


def _on_times(times: Times) -> Iterator[Verdict]:
    for (index, side), claim in TABLE_5.items():
        ours = 1000 * times["median"][side][index, OCTAVE_IN_KIND]
        note = (
            f"Measured in MATLAB on the authors' machine; {ON.printed(claim) / ours:.3g} times ours in Octave for 1 000 "
            "configurations."
        )
        yield ON.out_of_scope(claim, note, f"{ours:.3g} s")
    as_read = pd.DataFrame({name: _as_read(times, *place) for name, place in READINGS.items()}).T
    factors = pd.DataFrame({side: as_read[EXACT] / as_read[side] for side in NETWORKS})
    of_rung = advantages(times)
    for claim, side in (("feed-forward-hundredfold", FEED_FORWARD), ("radial-basis-tenfold", RADIAL_BASIS)):
        places = [("KCI", OCTAVE_IN_KIND), ("w", IN_KIND), ("w", FOOT), ("KCI", FOOT)]
        kci, numpy, foot_w, foot_kci = (three_digits(of_rung[side][place]) for place in places)
        note = (
            f"In Octave; {kci} times for KCI. The printed times give {PRINTED_RATIOS[side]:.0f}, and networks that take one "
            f"configuration after the other {factors[side]['what-a-run-is=one']:.0f}. The same programs in numpy give {numpy}; "
            f"with C on both sides, many at once: {foot_w} (w) and {foot_kci} (KCI)."
        )
        yield ON(claim, _by_reading(factors[side]), note, form="{:,.0f}", unit="times")
    note = (
        "Smallest and largest factor. It is what the languages of the two sides make it. The paper's own times give "
        f"{' and '.join(f'{value:.0f}' for value in PRINTED_RATIOS.values())}."
    )
    ends = [_by_reading(factors.min(axis="columns")), _by_reading(factors.max(axis="columns"))]
    yield ON("ten-to-hundredfold", ends, note, form="{:,.0f}", unit="times")


def _on_orderings(evidence: Evidence, times: Times) -> Iterator[Verdict]:
    lower, upper = times["lower"], times["upper"]
    in_kind = lower.index.get_level_values("rung").isin([IN_KIND, OCTAVE_IN_KIND])
    kinds = {IN_KIND: in_kind, "one language": ~in_kind}
    slower = lower[list(NETWORKS)].gt(upper[EXACT], axis="index")
    for side in NETWORKS:
        yield ON(
            f"{side}-faster-than-analytical",
            {kind: not slower[side][of].any() for kind, of in kinds.items()},
            "Cases: on no rung slower than the exact index, quartiles apart. Of "
            f"{(~in_kind).sum()} rungs with one language on both sides the {side} network is slower on {slower[side].sum()}.",
        )
    beaten = upper[[EXACT, RADIAL_BASIS]].lt(lower[FEED_FORWARD], axis="index").any(axis="columns")
    neurons = evidence["instructions"].where().pivot(index="index", columns="side", values="neurons")
    fewer = neurons[RADIAL_BASIS] / neurons[FEED_FORWARD]
    yield ON(
        "feed-forward-fastest",
        {kind: not beaten[of].any() for kind, of in kinds.items()},
        f"Cases: never beaten, quartiles apart; it holds in {(~beaten).sum()} of {len(beaten)} comparisons. The network "
        f"has {fewer['w']:.0f} (w) and {fewer['KCI']:.0f} (KCI) times fewer neurons than the radial-basis network.",
    )


def _on_causes(evidence: Evidence, times: Times) -> Iterator[Verdict]:
    in_kind = {
        name: _follows({index: _as_read(times, index, rung) for index in INDICES})
        for name, (_, rung) in READINGS.items()
    }
    compiled = _follows({index: times["median"].T[index, FOOT] for index in INDICES})
    note = (
        f"Kendall's τ of six times with the six counts of Table 4. Where both sides are compiled it is {compiled:.2f}: no program "
        "then takes the operations that the table gives the exact indices."
    )
    yield ON("times-follow-operations", _by_reading(in_kind), note, form="{:.2f}")
    # What else the machine does moves a first quartile least.
    quickest = evidence["singular_values"].where().groupby("copy")["lower"]
    different, same = (quickest.max() / quickest.min()).to_numpy()
    note = (
        f"Cases: factors. The slowest configuration takes {different:.2f} times as long as the quickest; as many copies of one "
        f"configuration differ by a factor of {same:.2f} themselves."
    )
    cases = {f"{least:g} times": bool(different / same >= least) for least in (1.1, 1.5)}
    yield ON("kci-time-varies", cases, note, ours=f"{different / same:.2f} times")


def _on_planners(times: Times) -> Iterator[Verdict]:
    fewest, most = SEVERAL_HUNDRED
    note = "No planner is named; the number is taken to calculate with."
    yield ON.underspecified("hundreds-of-configurations", note, f"{fewest} to {most} configurations")
    kci_over_w = ON.printed("analytical-kci-time") - ON.printed("analytical-w-time")
    saved = {
        "chosen": PRINTED_SAVING,
        "planner-iteration=from-300": PRINTED_SAVING,
        "rows-of-the-time-table=kci": PRINTED_SAVING + kci_over_w / ON.printed("timing-inputs"),
        "what-a-run-is=one": _OF_TEST_SET,
    }
    note = (
        f"By the paper's own times {fewest} to {most} configurations save {fewest * PRINTED_SAVING:.2f} to "
        f"{most * PRINTED_SAVING:.2f} s, and a second takes {1 / PRINTED_SAVING:,.0f} of them. The claim holds only if a printed "
        "time is for one configuration."
    )
    yield ON("second-saved-per-iteration", most * _by_reading(saved), note, form="{:.2f}", unit="s at most")
    gain = 1e6 * most * savings(times).xs(FOOT, level="rung").max()
    note = (
        "The share of a cycle that goes into the index is not printed. With C on both sides a feed-forward network saves "
        f"{gain:.0f} μs over {most} configurations."
    )
    yield ON.underspecified("slightest-gain-counts", note, f"{gain:.0f} μs")


def _as_read(times: Times, index: str, rung: str) -> pd.Series:
    """Return median times by side, the exact index as in the paper and the networks on a rung."""
    of_place = times["median"].T
    return of_place[index, rung].where(of_place.index != EXACT, of_place[index, OCTAVE_IN_KIND])


def _follows(times: Mapping[str, pd.Series]) -> float:
    """Return Kendall's τ between the counts of Table 4 and the times of the exact indices and printed networks."""
    counts, taken = [], []
    for index, exact in (("w", "w-operations-table"), ("KCI", "kci-operations")):
        claims = [exact, *(f"{side}-{index.lower()}-operations" for side in NETWORKS)]
        counts += [ON.printed(claim) for claim in claims]
        taken += list(times[index][[EXACT, *NETWORKS]])
    return float(kendalltau(counts, taken).statistic)


def _by_reading(values: Mapping[str, float] | pd.Series) -> pd.Series:
    series = pd.Series(values)
    return series.set_axis(pd.MultiIndex.from_product([series.index, [0]], names=["reading", "seed"]))
