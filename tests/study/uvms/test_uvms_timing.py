"""Both sides of the timing ladder compute the same numbers, and its ratios are those of the times."""

import pandas as pd
import pytest

from dexterity_study.claims.outcome import Outcome
from dexterity_study.engine.evidence import Evidence
from dexterity_study.uvms.timing import experiment, show, verdicts
from dexterity_study.uvms.timing.experiment import EXACT, FEED_FORWARD, FOOT, RADIAL_BASIS


def test_all_ways_agree_and_every_rung_has_the_exact_index_and_both_networks():
    rows = experiment.agreement(configurations=30, many=40, in_loops=2).rows
    assert rows["deviation"].max() < 1e-9
    sides = rows.groupby(["index", "rung"])["side"].agg(set)
    assert len(sides) == 18
    assert all({EXACT, FEED_FORWARD, RADIAL_BASIS} <= own for own in sides)


def timed(*medians: float) -> pd.DataFrame:
    sides = (EXACT, FEED_FORWARD, RADIAL_BASIS)
    times = [{"side": side, "median": own} for side, own in zip(sides, medians, strict=True)]
    rows = pd.DataFrame(times).assign(index="w", rung=FOOT, configurations=1000)
    return rows.assign(lower=0.99 * rows["median"], upper=1.01 * rows["median"])


def test_advantages_are_ratios_and_savings_are_differences_of_medians():
    times = verdicts.quartiles(timed(2e-8, 1e-8, 4e-8))
    assert verdicts.advantages(times).loc[("w", FOOT)].to_dict() == pytest.approx(
        {FEED_FORWARD: 2.0, RADIAL_BASIS: 0.5}
    )
    assert verdicts.savings(times)["w", FOOT] == pytest.approx(1e-8)


def test_several_hundred_configurations_save_no_second_by_the_printed_times():
    assert max(verdicts.SEVERAL_HUNDRED) * verdicts.PRINTED_SAVING < 0.7
    assert verdicts.PRINTED_RATIOS[FEED_FORWARD] == pytest.approx(123.6, abs=0.1)


def test_a_comparison_says_faster_slower_or_that_quartiles_overlap():
    times = verdicts.quartiles(timed(2e-8, 1e-8, 4e-8))
    words = show._compared(times, ("w", FOOT))
    assert words == {FEED_FORWARD: "2 times faster", RADIAL_BASIS: "2 times slower"}
    equal = show._compared(verdicts.quartiles(timed(1e-8, 1.001e-8, 1e-4)), ("w", FOOT))
    assert equal[FEED_FORWARD] == "equally fast within the quartiles"
    assert equal[RADIAL_BASIS] == "10,000 times slower"


@pytest.mark.parametrize(
    ("seconds", "written"),
    [(13.7, "14 s"), (0.7043, "700 ms"), (5.7e-3, "5.7 ms"), (1.7e-5, "17 µs"), (5e-8, "0.05 µs")],
)
def test_a_duration_has_the_unit_that_suits_it(seconds, written):
    assert show._duration(seconds) == written


def test_the_ladder_is_read_from_the_printed_times_to_compiled_code():
    lines = show.aloud(Evidence("uvms.timing")).splitlines()
    assert len(lines) == 10
    assert (
        "700 ms for the exact index and 5.7 ms for the feed-forward network, which is 124 times" in lines[0]
    )
    assert all("feed-forward" in line and "radial-basis" in line for line in lines)


def test_times_in_octave_stand_in_for_those_of_matlab():
    evidence = Evidence("uvms.timing")
    times = verdicts.measured(evidence)
    own = {verdict.claim: verdict for verdict in verdicts.verdicts(evidence)}
    ratio = verdicts.advantages(times).loc[("w", experiment.OCTAVE_IN_KIND), FEED_FORWARD]
    assert own["feed-forward-hundredfold"].ours == f"{ratio:,.0f} times"
    assert own["analytical-w-time"].outcome is Outcome.OUT_OF_SCOPE
