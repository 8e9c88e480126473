"""The rule book, rule by rule at its thresholds, and what other readings do to a verdict."""

from datetime import UTC, date, datetime

import numpy as np
import pandas as pd
import pytest

from dexterity_study.claims import judge
from dexterity_study.claims.judge import Judge
from dexterity_study.claims.ledger import Claim, Near, Paper
from dexterity_study.claims.outcome import Outcome
from dexterity_study.engine.readings import Alternative, Assumption

SET = datetime(2026, 1, 1, tzinfo=UTC)
HEAD = {"key": "p", "letter": "P", "title": "t", "authors": ("a",), "journal": "j", "year": 2000, "doi": "d"}


def claim(rule, **fields):
    kind = "value" if "value" in fields else "statement"
    return Claim(
        id="c", where="Table 1", says="So it is.", chapter="uvms.tiny", kind=kind, rule=rule, **fields
    )


def assumption(*alternatives, origin="text"):
    others = tuple(Alternative(name=name, origin=origin, why="why", value=name) for name in alternatives)
    return Assumption(
        id="step", where="w", missing="m", chapter="uvms.tiny", chosen="one", why="why", origin="text",
        set=SET, by="known", basis="Something.", value="one", alternatives=others,
    )  # fmt: skip


@pytest.fixture
def verdict(monkeypatch):
    def of(entry, values, assumptions=(), **options):
        paper = Paper(**HEAD, claims=(entry,), assumptions=tuple(assumptions))
        monkeypatch.setattr(judge, "load_paper", lambda _: paper)
        return Judge("p")("c", values, "note", **options)

    return of


def holds(count, of=20):
    return [True] * count + [False] * (of - count)


@pytest.mark.parametrize(
    ("values", "outcome"),
    [
        (holds(18), "reproduced"),
        (holds(17), "in shape"),
        (holds(10), "in shape"),
        (holds(9), "not reproduced"),
        (holds(3), "not reproduced"),
        (holds(2), "contradicted"),
        ([True], "reproduced"),
        ([False], "contradicted"),
    ],
)
@pytest.mark.parametrize("rule", ["share", "order"])
def test_a_share_of_seeds(verdict, rule, values, outcome):
    assert verdict(claim(rule), values).outcome == outcome


@pytest.mark.parametrize(("side", "good", "bad"), [("below", 0.01, 0.03), ("above", 0.03, 0.01)])
def test_a_bound_is_judged_by_the_share_of_seeds_that_keep_it(verdict, side, good, bad):
    entry = claim("bound", value=0.02, side=side)
    for count, outcome in ((18, "reproduced"), (10, "in shape"), (5, "not reproduced"), (0, "contradicted")):
        assert verdict(entry, [good] * count + [bad] * (20 - count)).outcome == outcome


@pytest.mark.parametrize(
    ("values", "outcome"),
    [
        ([5.0], "reproduced"),
        ([4.96], "reproduced"),
        ([4.94], "in shape"),
        ([3.0, 7.0], "reproduced"),
        ([2.5, 2.6], "in shape"),
        ([2.4, 2.45], "not reproduced"),
        ([10.2], "not reproduced"),
        ([-5.0], "not reproduced"),
        ([2.0, 8.1], "underspecified"),
    ],
)
def test_a_number(verdict, values, outcome):
    assert verdict(claim("number", value=5.0, rounding=0.05), values).outcome == outcome


def test_a_number_of_several_parts_is_as_good_as_its_worst_part(verdict):
    entry = claim("number", value=(1.0, 10.0), rounding=0.05)
    assert verdict(entry, [[1.0, 1.02], [9.0, 11.0]]).outcome == Outcome.REPRODUCED
    assert verdict(entry, [[1.0], [11.0]]).outcome == Outcome.IN_SHAPE
    with pytest.raises(ValueError, match="2 printed numbers and 3 of ours"):
        verdict(entry, [1.0, 2.0, 3.0])


def test_a_claim_may_have_its_own_distance_for_in_shape(verdict):
    near = Near(within=0.05, why="a share of one has no factor of two", set=date(2026, 1, 1))
    entry = claim("number", value=0.95, near=near)
    assert verdict(entry, [0.91]).outcome == Outcome.IN_SHAPE
    assert verdict(entry, [0.89]).outcome == Outcome.NOT_REPRODUCED


@pytest.mark.parametrize(
    ("tau", "outcome"),
    [(0.8, "reproduced"), (0.3, "in shape"), (0.1, "not reproduced"), (0.0, "contradicted")],
)
def test_a_trend(verdict, tau, outcome):
    assert verdict(claim("trend"), [tau, tau - 0.01, tau + 0.01]).outcome == outcome


def test_a_formula_holds_to_rounding_or_not_at_all(verdict):
    assert verdict(claim("formula"), [1e-10, -1e-9]).outcome == Outcome.REPRODUCED
    assert verdict(claim("formula"), [1e-10, 1e-8]).outcome == Outcome.CONTRADICTED


def test_cases_are_all_some_or_none(verdict):
    for first, second, outcome in (
        (True, True, "reproduced"),
        (True, False, "in shape"),
        (False, False, "contradicted"),
    ):
        judged = verdict(claim("cases"), {"w": first, "KCI": np.bool_(second)})
        assert judged.outcome == outcome
    assert judged.ours == "w: no, KCI: no"
    assert verdict(claim("cases"), {}).outcome == Outcome.NOT_REPRODUCED


@pytest.mark.parametrize(
    ("cases", "outcome"),
    [
        ({"Adam": True, "SGD": True}, Outcome.LOGGED),
        ({"Adam": True, "SGD": False}, Outcome.LOGGED),
        ({"Adam": False, "SGD": False}, Outcome.CONTRADICTED),
        ({}, Outcome.NOT_REPRODUCED),
    ],
)
def test_what_the_authors_logged_reproduces_nothing_and_can_refute(monkeypatch, cases, outcome):
    monkeypatch.setattr(judge, "load_paper", lambda _: Paper(**HEAD, claims=(claim("cases"),)))
    judged = Judge("p").logged("c", cases, "note")
    assert judged.outcome == outcome
    assert judged.readings == judged.spread == judged.ours == ""
    told = ", ".join(f"{name}: {'yes' if held else 'no'}" for name, held in cases.items())
    assert judged.sentence == (f"note In the logs: {told}." if cases else "note")


def series(**readings):
    rows = {(name.replace("_", "="), seed): x for name, own in readings.items() for seed, x in enumerate(own)}
    return pd.Series(rows).rename_axis(["reading", "seed"])


def test_nothing_is_contradicted_while_an_admissible_reading_has_not_run(verdict):
    entry = claim("share")
    assert verdict(entry, [False], [assumption("two")]).outcome == Outcome.NOT_REPRODUCED
    both = verdict(entry, series(chosen=[False], step_two=[False]), [assumption("two")])
    assert both.outcome == Outcome.CONTRADICTED
    assert both.readings == "Holds in 0 of 2 readings run; 2 are admissible"


def test_readings_that_disagree_leave_a_claim_underspecified_and_are_named(verdict):
    judged = verdict(claim("share"), series(chosen=[True], step_two=[False]), [assumption("two", "three")])
    assert judged.outcome == Outcome.UNDERSPECIFIED
    assert judged.flips == ("step=two",)
    assert judged.readings == "Holds in 1 of 2 readings run; 3 are admissible"


def test_a_value_chosen_because_it_fits_is_no_evidence(verdict):
    fitted = assumption("two", origin="fitted")
    judged = verdict(claim("share"), series(chosen=[False], step_two=[True]), [fitted])
    assert judged.outcome == Outcome.CONTRADICTED
    assert judged.flips == ()


def test_a_claim_that_rests_on_nothing_has_one_reading(verdict):
    judged = verdict(claim("share", assumes=()), [False], [assumption("two")])
    assert judged.outcome == Outcome.CONTRADICTED
    assert judged.readings == ""


def test_our_value_is_the_median_with_its_range(verdict):
    judged = verdict(claim("number", value=5.0), [4.0, 5.0, 7.0], form="{:.1f}", unit="m")
    assert judged.ours == "5.0 (4.0–7.0) m"
    assert judged.spread == "over 3 seeds"
    assert verdict(claim("share"), holds(18)).ours == "18 of 20"


def test_values_of_the_wrong_kind_are_refused(verdict):
    with pytest.raises(ValueError, match="needs truth values"):
        verdict(claim("share"), [0.5])
    with pytest.raises(ValueError, match="no value for the chosen reading"):
        verdict(claim("share"), series(step_two=[True]))


def test_every_word_and_every_rule_is_explained():
    assert judge.WORDS.keys() == set(Outcome)
    assert judge.RULES.keys() == judge._RULES.keys()
