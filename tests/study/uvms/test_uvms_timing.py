"""Both sides of the timing ladder compute the same numbers, and its ratios are those of the times."""

import pandas as pd
import pytest

from dexterity_study.uvms.timing import experiment, verdicts
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
