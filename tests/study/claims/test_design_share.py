"""A claim in a space-filling design of readings, on made-up rows."""

import numpy as np
import pandas as pd
import pytest

from dexterity_study.claims import judge
from dexterity_study.claims.design import DesignShare
from dexterity_study.claims.judge import Judge
from dexterity_study.claims.ledger import Claim, Paper
from dexterity_study.claims.outcome import Outcome

HEAD = {"key": "p", "letter": "P", "title": "t", "authors": ("a",), "journal": "j", "year": 2000, "doi": "d"}


@pytest.fixture
def on(monkeypatch):
    """Return a function that makes a judge of one claim."""

    def of(rule, **fields):
        kind = "value" if "value" in fields else "statement"
        entry = Claim(
            id="c", where="w", says="So.", chapter="uvms.tiny", kind=kind, rule=rule, assumes=(), **fields
        )
        monkeypatch.setattr(judge, "load_paper", lambda _: Paper(**HEAD, claims=(entry,)))
        return Judge("p")

    return of


def rows(*readings):
    """Index the values of each reading's repetitions."""
    named = {
        (number, repetition): x for number, own in enumerate(readings) for repetition, x in enumerate(own)
    }
    return pd.Series(named).rename_axis(["number", "repetition"])


def test_repetitions_of_a_reading_are_judged_together_by_the_rule_of_the_claim(on):
    neurons = rows([140, 160, 150], [10, 12, 11], [300, 290, 299], [100, np.inf, 110])
    share = on("number", value=149).in_design("c", neurons)
    # 299 is more than twice 149; a loop that does not end once leaves its reading undecided.
    assert share.holds.tolist() == [True, False, False, False]
    assert str(share) == "Holds in 1 of 4 readings of the design (25%)"
    errors = rows([0.01, 0.03, 0.01], [0.03, 0.03, 0.01])
    assert on("bound", value=0.02).in_design("c", errors).holds.tolist() == [True, False]


def test_cases_hold_where_one_does_in_half_of_the_repetitions(on):
    w, kci = rows([True, True], [False, False]), rows([False, True], [False, True])
    share = on("cases").in_design("c", pd.DataFrame({"w": w, "KCI": kci}))
    assert share.holds.tolist() == [True, True]
    assert on("cases").in_design("c", pd.DataFrame({"w": w})).holds.tolist() == [True, False]


def test_a_number_of_several_parts_has_a_column_for_each(on):
    parts = pd.DataFrame({"size": rows([8, 8], [8, 8]), "spread": rows([8.9, 8.9], [1.0, 1.0])})
    assert on("number", value=(8.0, 8.9)).in_design("c", parts).holds.tolist() == [True, False]


def test_missing_and_repeated_rows_are_refused(on):
    judged = on("bound", value=0.02)
    with pytest.raises(ValueError, match="is missing; where a loop does not end it is infinity"):
        judged.in_design("c", rows([0.01, np.nan]))
    with pytest.raises(ValueError, match="one row for each reading and repetition"):
        judged.in_design("c", rows([0.01]).droplevel(1))
    with pytest.raises(ValueError, match="one row for each reading and repetition"):
        judged.in_design("c", pd.concat([rows([0.01]), rows([0.01])]))


def share_of(holds, of=20):
    return DesignShare(pd.Series([True] * holds + [False] * (of - holds)))


@pytest.mark.parametrize(
    ("value", "holds", "outcome"),
    [
        (True, 20, "reproduced"),
        (True, 18, "reproduced"),
        (True, 17, "underspecified"),
        (False, 0, "contradicted"),
        (False, 2, "not reproduced"),
        (False, 3, "underspecified"),
    ],
)
def test_more_than_a_tenth_of_the_design_makes_a_claim_underspecified(on, value, holds, outcome):
    verdict = on("share")("c", [value], design=share_of(holds))
    assert verdict.outcome == Outcome(outcome)
    assert verdict.design == f"Holds in {holds} of 20 readings of the design ({holds / 20:.0%})"


def test_claims_that_hold_at_once_are_counted_reading_by_reading():
    both = share_of(12) & DesignShare(pd.Series([False] * 10 + [True] * 10))
    assert (both.count, both.readings) == (2, 20)
    with pytest.raises(ValueError, match="different readings"):
        share_of(1) & share_of(1, of=21)


def test_a_design_names_the_factor_that_decides_and_no_other():
    draws = np.random.default_rng(0)
    factors = pd.DataFrame({"speed": np.linspace(0.5, 2, 64), "frame": draws.choice(["a", "b"], 64)})
    share = DesignShare(factors["speed"] > 1.25, factors)
    compared = share.by_factor()
    assert compared["share"].loc["speed"].tolist() == [1.0, 0.0]
    assert compared["readings"].loc["frame"].sum() == 64
    assert share.turns_on() == "speed (above 1.25: 100%, to 1.25: 0%)"
    assert DesignShare(share_of(64, of=64).holds, factors).turns_on() == ""
    with pytest.raises(ValueError, match="factors"):
        share_of(64, of=64).turns_on()


def test_a_design_takes_no_part_where_none_is_given(on):
    verdict = on("share")("c", [True])
    assert (verdict.outcome, verdict.design) == (Outcome.REPRODUCED, "")
