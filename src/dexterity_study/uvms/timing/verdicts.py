"""Verdicts on the times of paper A."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TypeAlias, cast

import pandas as pd
from scipy.stats import kendalltau

from dexterity.timing import Ratio, Timing, ratio
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
    ONE_BY_ONE,
    RADIAL_BASIS,
)

NETWORKS = (FEED_FORWARD, RADIAL_BASIS)
READINGS = {
    "chosen": ("w", IN_KIND),
    "rows-of-the-time-table=kci": ("KCI", IN_KIND),
    "what-a-run-is=one": ("w", ONE_BY_ONE),
}
"""Index and rung of the networks whose times the paper prints, by reading; the exact index is always in kind."""

ON = Judge("sotiropoulos2016")
SEVERAL_HUNDRED = cast(tuple[int, int], Reading.of("sotiropoulos2016", "chosen")["planner-iteration"])
PRINTED_RATIOS = {side: ON.printed("analytical-w-time") / ON.printed(f"{side}-time") for side in NETWORKS}
PRINTED_SAVING = (ON.printed("analytical-w-time") - ON.printed("feed-forward-time")) / ON.printed(
    "timing-inputs"
)
"""Time per configuration [s] that a feed-forward network for w saves by the printed times."""

Times: TypeAlias = Mapping[tuple[str, str], Mapping[str, Timing]]


def timings(rows: pd.DataFrame) -> Times:
    """Return the times of each side, by index and rung."""
    columns = ["side", "configurations", "lower", "median", "upper"]
    return {
        (str(index), str(rung)): {own[0]: Timing(*own) for own in of_place[columns].itertuples(index=False)}
        for (index, rung), of_place in rows.groupby(["index", "rung"], sort=False)
    }


def advantages(times: Times) -> dict[tuple[str, str], dict[str, Ratio]]:
    """Return how many times faster than the exact index each network is, by index and rung."""
    return {
        place: {side: ratio(own[EXACT], time) for side, time in own.items() if side != EXACT}
        for place, own in times.items()
    }


def saving(times: Mapping[str, Timing]) -> float:
    """Return the time per configuration [s] that a feed-forward network saves."""
    return times[EXACT].median - times[FEED_FORWARD].median


def verdicts(evidence: Evidence) -> Iterator[Verdict]:
    """Judge the claims of the chapter."""
    times = timings(evidence["ladder"].where())
    yield from _on_times(times)
    yield from _on_orderings(evidence, times)
    yield from _on_causes(evidence, times)
    yield from _on_planners(times)


def acceptance(evidence: Evidence) -> Iterator[Acceptance]:
    """Figures that must hold for the book to be accepted."""
    for index, own in evidence["agreement"].where().groupby("index", sort=False):
        yield Acceptance(f"ways to {index} from each other, relative", own["deviation"].max(), 1e-9)


def _on_times(times: Times) -> Iterator[Verdict]:
    sides = {"analytical-w-time": ("w", EXACT), "analytical-kci-time": ("KCI", EXACT)}
    sides |= {f"{network}-time": ("w", network) for network in NETWORKS}
    for claim, (index, side) in sides.items():
        own = 1000 * times[index, IN_KIND][side].median
        note = f"Measured in MATLAB on the authors' machine; {ON.printed(claim) / own:.3g} times ours for 1 000 configurations."
        yield ON.out_of_scope(claim, note, f"{own:.3g} s")
    factors = advantages(times)
    read = {name: _as_read(times, *place) for name, place in READINGS.items()}
    ours = pd.DataFrame(
        {
            side: {name: own[EXACT].median / own[side].median for name, own in read.items()}
            for side in NETWORKS
        }
    )
    for claim, side in (("feed-forward-hundredfold", FEED_FORWARD), ("radial-basis-tenfold", RADIAL_BASIS)):
        note = (
            f"{factors['KCI', IN_KIND][side]} times for KCI. The printed times give {PRINTED_RATIOS[side]:.0f}, and networks that "
            f"take one configuration after the other {ours[side]['what-a-run-is=one']:.0f}. With C on both sides, many at once: "
            f"{factors['w', FOOT][side]} (w) and {factors['KCI', FOOT][side]} (KCI)."
        )
        yield ON(claim, _over(ours[side]), note, form="{:,.0f}", unit="times")
    note = (
        "Smallest and largest factor. It is what the languages of the two sides make it. The paper's own times give "
        f"{' and '.join(f'{value:.0f}' for value in PRINTED_RATIOS.values())}."
    )
    ends = [_over(ours.min(axis="columns")), _over(ours.max(axis="columns"))]
    yield ON("ten-to-hundredfold", ends, note, form="{:,.0f}", unit="times")


def _on_orderings(evidence: Evidence, times: Times) -> Iterator[Verdict]:
    kinds = {IN_KIND: [place for place in times if place[1] == IN_KIND]}
    kinds["one language"] = [place for place in times if place[1] != IN_KIND]
    slower = {
        side: {place for place, own in times.items() if own[side].lower > own[EXACT].upper}
        for side in NETWORKS
    }
    counts = " and ".join(f"the {side} network on {len(places)}" for side, places in slower.items())
    yield ON(
        "networks-faster-than-analytical",
        {f"{side}, {kind}": not slower[side] & set(kinds[kind]) for side in NETWORKS for kind in kinds},
        "Cases: on no rung slower than the exact index, quartiles apart. Of "
        f"{len(kinds['one language'])} rungs with one language on both sides {counts} are slower.",
    )
    beaten = {
        place
        for place, own in times.items()
        if any(own[side].upper < own[FEED_FORWARD].lower for side in (EXACT, RADIAL_BASIS))
    }
    neurons = evidence["instructions"].where().pivot(index="index", columns="side", values="neurons")
    fewer = neurons[RADIAL_BASIS] / neurons[FEED_FORWARD]
    yield ON(
        "feed-forward-fastest",
        {kind: not beaten & set(places) for kind, places in kinds.items()},
        f"Cases: never beaten, quartiles apart; it holds in {len(times) - len(beaten)} of {len(times)} comparisons. The network "
        f"has {fewer['w']:.0f} (w) and {fewer['KCI']:.0f} (KCI) times fewer neurons than the radial-basis network.",
    )


def _on_causes(evidence: Evidence, times: Times) -> Iterator[Verdict]:
    read = {
        name: _follows({index: _as_read(times, index, rung) for index in INDICES})
        for name, (_, rung) in READINGS.items()
    }
    compiled = _follows({index: times[index, FOOT] for index in INDICES})
    note = (
        f"Kendall's τ of six times with the six counts of Table 4. Where both sides are compiled it is {compiled:.2f}: no program "
        "then takes the operations that the table gives the exact indices."
    )
    yield ON("times-follow-operations", _over(read), note, form="{:.2f}")
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
    saved = {"chosen": PRINTED_SAVING, "planner-iteration=from-300": PRINTED_SAVING}
    exact = ON.printed("analytical-kci-time") - ON.printed("analytical-w-time")
    saved["rows-of-the-time-table=kci"] = PRINTED_SAVING + exact / ON.printed("timing-inputs")
    saved["what-a-run-is=one"] = PRINTED_SAVING * ON.printed("timing-inputs")
    note = (
        f"By the paper's own times {fewest} to {most} configurations save {fewest * PRINTED_SAVING:.2f} to "
        f"{most * PRINTED_SAVING:.2f} s, and a second takes {1 / PRINTED_SAVING:,.0f} of them. The claim holds only if a printed "
        "time is for one configuration."
    )
    at_most = _over({name: most * own for name, own in saved.items()})
    yield ON("second-saved-per-iteration", at_most, note, form="{:.2f}", unit="s at most")
    gain = 1e6 * most * max(saving(times[index, FOOT]) for index in INDICES)
    note = (
        "The share of a cycle that goes into the index is not printed. With C on both sides a feed-forward network saves "
        f"{gain:.0f} μs over {most} configurations."
    )
    yield ON.underspecified("slightest-gain-counts", note, f"{gain:.0f} μs")


def _as_read(times: Times, index: str, rung: str) -> Mapping[str, Timing]:
    return {**times[index, rung], EXACT: times[index, IN_KIND][EXACT]}


def _follows(times: Mapping[str, Mapping[str, Timing]]) -> float:
    """Return Kendall's τ between the counts of Table 4 and the times of the exact indices and printed networks."""
    counts, taken = [], []
    for index, exact in (("w", "w-operations-table"), ("KCI", "kci-operations")):
        counts += [
            ON.printed(exact),
            *(ON.printed(f"{side}-{index.lower()}-operations") for side in NETWORKS),
        ]
        taken += [times[index][side].median for side in (EXACT, *NETWORKS)]
    return float(kendalltau(counts, taken).statistic)


def _over(by_reading: Mapping[str, float] | pd.Series) -> pd.Series:
    own = pd.Series(dict(by_reading))
    return own.set_axis(pd.MultiIndex.from_product([own.index, [0]], names=["reading", "seed"]))
