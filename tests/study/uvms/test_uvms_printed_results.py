"""Printed results in a design: what a reading gives, and in which share of the readings they come out."""

import math

import numpy as np
import pandas as pd
import pytest

from dexterity_study.claims.ledger import load_paper
from dexterity_study.uvms import unprinted
from dexterity_study.uvms.reconstruction import experiment, show
from dexterity_study.uvms.reconstruction.printed_results import RESULTS, all_at_once, come_out


def rows(**columns):
    index = pd.MultiIndex.from_product([range(2), range(3)], names=["number", "repetition"])
    return pd.DataFrame(
        {name: [value] * 6 if np.isscalar(value) else value for name, value in columns.items()}, index
    )


def test_a_loop_at_its_limit_has_found_nothing():
    found = rows(w_ff_neurons=[8, 9, 100, 100, 7, 8], w_ff_passes=[True, True, False, True, True, True])
    assert unprinted.ends_of_loops("w", found).tolist() == [8, 9, math.inf, 100, 7, 8]


def test_bells_are_those_of_the_first_spread_of_a_row():
    columns = {f"w_rb_neurons_from_{first:g}": number for number, first in enumerate(experiment.FIRST)}
    columns |= {f"w_rb_spread_from_{first:g}": first + 1 for first in experiment.FIRST}
    found = rows(**columns, first_spread=[0.1, 0.3, 0.5, 1.0, 0.3, 1.0])
    assert unprinted.ends_of_growth("w", rows=found).tolist() == [math.inf, 1, 2, 3, 1, 3]
    assert unprinted.ends_of_growth("w", "spread", found).tolist() == [math.inf, 1.3, 1.5, 2.0, 1.3, 2.0]


def test_first_spreads_are_drawn_evenly_and_apart_from_the_other_factors():
    drawn = unprinted.first_spreads()
    assert sorted(drawn) == sorted(np.repeat(experiment.FIRST, 64))
    readings = pd.DataFrame([experiment.reading(number) for number in range(256)])
    numeric = readings.select_dtypes("number")
    assert numeric.corrwith(pd.Series(drawn), method="spearman").abs().max() < 0.2


@pytest.mark.parametrize(
    ("errors", "share"), [([0.01, 0.03, 0.01, 0.03, 0.03, 0.01], 0.5), ([0.01] * 6, 1.0)]
)
def test_a_condition_holds_where_half_of_the_draws_do(errors, share):
    condition = next(one for one in RESULTS if one.title == "KCI: 25 sigmoids pass, trained further")
    assert condition.share(rows(KCI_ff_error=errors)).share == share


def test_a_printed_number_far_from_all_draws_does_not_come_out():
    condition = next(one for one in RESULTS if one.title == "w: loop ends near 8 sigmoids")
    found = rows(w_ff_neurons=[7, 8, 9, 2, 2, 3], w_ff_passes=True)
    assert condition.share(found).holds.tolist() == [True, False]


def test_printed_sizes_are_those_of_the_ledger():
    paper = load_paper("sotiropoulos2016")
    printed = {
        "feed-forward-w-neurons": experiment.PRINTED["w"][0],
        "feed-forward-kci-neurons": experiment.PRINTED["KCI"][0],
        "radial-basis-w-neurons": experiment.PRINTED["w"][1],
        "radial-basis-kci-spread": experiment.SPREAD,
    }
    assert {claim: paper.claim(claim).value for claim in printed} == printed
    assert {one.claim for one in RESULTS if one.claim} == printed.keys()


def test_results_and_shares_of_the_stored_design_agree():
    rows = unprinted.design()
    found, every = come_out(rows), all_at_once(rows)
    assert every.readings == len(found) == rows.index.get_level_values("number").nunique()
    assert every.count == found.all(axis=1).sum()
    assert f"Of {every.readings} readings, " in show.finding()
