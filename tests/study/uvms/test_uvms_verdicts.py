"""Verdicts on paper A: they rest on stored evidence alone, and each rule of a chapter can fail."""

import re

import numpy as np
import pandas as pd
import pytest

from dexterity import store
from dexterity_study.claims import scorecard
from dexterity_study.claims.judge import Judge, by_reading
from dexterity_study.engine.evidence import Evidence, chapters
from dexterity_study.engine.experiment import Experiment
from dexterity_study.engine.table import Table
from dexterity_study.uvms.choice import verdicts as choice
from dexterity_study.uvms.cost import verdicts as cost
from dexterity_study.uvms.feed_forward import verdicts as feed_forward
from dexterity_study.uvms.tasks import verdicts as tasks
from dexterity_study.uvms.timing import verdicts as timing

PART = [chapter for chapter in chapters() if chapter.startswith("uvms.")]


def given(verdicts, claim):
    """Return the verdict on a claim."""
    return next(one for one in verdicts if one.claim == claim)


def changed(chapter, experiment, change):
    """Return the stored evidence of a chapter with the rows of one experiment changed."""
    table = Evidence(chapter)[experiment]
    return Evidence(chapter, {experiment: Table(change(table.rows.copy()), table.keys, table.arrays)})


def test_no_verdict_of_the_part_needs_or_knows_a_live_run(monkeypatch):
    shown = {chapter: scorecard.chapter_verdicts(chapter) for chapter in PART}

    def refuse(self, *_, **__):
        raise AssertionError(f"{self.name} was run for a verdict")

    monkeypatch.setattr(Experiment, "__call__", refuse)
    scorecard.chapter_verdicts.cache_clear()
    assert {chapter: scorecard.chapter_verdicts(chapter) for chapter in PART} == shown


def test_no_page_of_the_part_judges_by_itself():
    pages = sorted((store.repository() / "book" / "uvms").glob("*.md"))
    assert pages
    for page in pages:
        text = page.read_text("utf-8")
        assert not re.search(r"\bverdicts\(|\bJudge\(|chapter_verdicts", text), page.name


def test_values_of_several_readings_are_put_below_one_another():
    series = by_reading({"chosen": [1.0, 2.0], "a=b": 3.0, "c=d": {"w": True, "KCI": False}})
    assert series["chosen"].tolist() == [1.0, 2.0]
    assert series["a=b"].tolist() == [3.0]
    assert series["c=d"].tolist() == [True, False]


# ---- cost ------------------------------------------------------------------------------------------


def test_counts_per_neuron_are_those_of_the_norm_without_its_sums():
    on = Judge("sotiropoulos2016")
    assert [142 * part for part in cost.per_neuron(11)] == list(on.printed("radial-basis-kci-split"))
    assert [149 * part for part in cost.per_neuron(11)] == list(on.printed("radial-basis-w-split"))
    assert [149 * part for part in cost.per_neuron(7)] != list(on.printed("radial-basis-w-split"))


def test_a_count_that_the_rule_does_not_explain_is_no_misprint():
    def more_neurons(rows):
        of_w = rows["what"] == "radial-basis w"
        rows.loc[of_w, "neurons"] += 1
        return rows

    stored, other = Evidence("uvms.cost"), changed("uvms.cost", "counts", more_neurons)
    claim = "radial-basis-w-operations"
    assert given(cost.verdicts(stored), claim).outcome == "misprint"
    assert given(cost.verdicts(other), claim).outcome == "in shape"


def test_kinds_of_network_are_judged_apart_by_what_the_expression_is():
    found = {one.claim: one for one in cost.verdicts(Evidence("uvms.cost"))}
    assert found["feed-forward-cheaper-than-analytical"].flips == ()
    assert set(found["radial-basis-cheaper-than-analytical"].flips) == set(cost.EXPRESSIONS[1:])
    assert found["jacobian-is-expensive"].flips == ("analytical-expressions=reduced",)

    def dear(rows):
        rows.loc[rows["what"] == "feed-forward w", "operations"] *= 1000
        rows.loc[rows["what"] == "feed-forward KCI", "operations"] *= 1000
        return rows

    other = given(cost.verdicts(changed("uvms.cost", "counts", dear)), "feed-forward-cheaper-than-analytical")
    assert other.outcome == "contradicted"


# ---- tasks -----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("tau", "flipped"),
    [
        (0.9, {"configurations-compared=random", "world-origin=arm-base"}),
        (0.1, {"world-origin=beyond-the-tool"}),
        (-0.5, {"world-origin=beyond-the-tool"}),
    ],
)
def test_indices_rank_configurations_only_if_both_do(tau, flipped):
    def same(rows):
        rows.loc[rows["pair"].str.contains("accuracy"), "tau"] = tau
        rows.loc[rows["pair"] == "w, largest speed", "tau"] = 0.9
        return rows

    judged = given(tasks.verdicts(changed("uvms.tasks", "agreement", same)), "indices-rank-configurations")
    assert flipped <= set(judged.flips)
    assert ("world-origin=beyond-the-tool" in judged.flips) == (tau < 0.3)
    assert judged.ours == f"{tau:.2f}"


# ---- networks --------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("errors", "outcome"),
    [
        ({4: 0.03, 5: 0.03, 6: 0.05, 7: 0.05, 8: 0.01}, "reproduced"),
        ({4: 0.03, 5: 0.01, 6: 0.05, 7: 0.05, 8: 0.01}, "in shape"),
        ({4: 0.01, 5: 0.01, 6: 0.05, 7: 0.05, 8: 0.01}, "not reproduced"),
        ({4: 0.06, 5: 0.06, 6: 0.05, 7: 0.05, 8: 0.01}, "not reproduced"),
    ],
)
def test_four_and_five_neurons_are_good_only_above_the_limit_and_below_six_and_seven(errors, outcome):
    def printed(rows):
        for neurons, error in errors.items():
            rows.loc[rows["neurons"] == neurons, "testing_error"] = error
        return rows

    evidence = changed("uvms.feed_forward", "sizes", printed)
    assert given(feed_forward.verdicts(evidence), "four-and-five-neurons-good").outcome == outcome


def test_a_loop_is_at_the_smallest_size_of_its_own_reading_or_not_at_its_end():
    index = pd.MultiIndex.from_product([["chosen", "a=b"], [0, 1]], names=["reading", "seed"])
    ends = pd.Series([3.0, 2.0, 5.0, np.inf], index)
    assert feed_forward._ends_at_the_smallest(ends, "reading").tolist() == [False, True, True, False]
    none = pd.Series(np.inf, index)
    assert not feed_forward._ends_at_the_smallest(none, "reading").any()


# ---- timing, choice --------------------------------------------------------------------------------


def test_kinds_of_network_are_timed_apart():
    def slow(rows):
        own = rows["side"] == timing.FEED_FORWARD
        rows.loc[own, ["lower", "median", "upper"]] *= 1e6
        return rows

    claims = ("feed-forward-faster-than-analytical", "radial-basis-faster-than-analytical")
    before, after = (
        {claim: given(timing.verdicts(evidence), claim).outcome for claim in claims}
        for evidence in (Evidence("uvms.timing"), changed("uvms.timing", "ladder", slow))
    )
    assert before[claims[0]] == "reproduced"
    assert after[claims[0]] != "reproduced"
    assert after[claims[1]] == before[claims[1]]


@pytest.mark.parametrize(("error", "holds"), [(0.021, True), (0.019, False)])
def test_two_per_cent_is_held_against_a_constant_without_a_factor(error, holds):
    def constant(rows):
        rows.loc[rows["what"] == "constant", "sampled"] = error
        return rows

    judged = given(choice.verdicts(changed("uvms.choice", "judged", constant)), "two-per-cent-acceptable")
    assert (judged.outcome in ("reproduced", "in shape")) == holds


def test_pruning_helps_only_within_the_limit_and_closes_no_gap():
    def none_removed(rows):
        rows["after"] = rows["before"]
        return rows

    def small(rows):
        rows["operations"] = 1
        return rows

    stored = list(choice.verdicts(Evidence("uvms.choice")))
    assert given(stored, "pruning-helps-radial-basis").outcome == "in shape"
    assert given(stored, "pruning-does-not-close-the-gap").outcome == "reproduced"
    without = choice.verdicts(changed("uvms.choice", "pruned", none_removed))
    assert given(without, "pruning-helps-radial-basis").outcome == "contradicted"
    closed = choice.verdicts(changed("uvms.choice", "pruned", small))
    assert given(closed, "pruning-does-not-close-the-gap").outcome == "contradicted"


def test_other_systems_are_judged_beside_the_papers_own():
    judged = given(choice.verdicts(Evidence("uvms.choice")), "any-uvms")
    assert judged.outcome == "in shape"
    assert "the paper's UVMS as printed, KCI" in judged.ours
    for claim in ("space-robots", "mobile-robots"):
        assert given(choice.verdicts(Evidence("uvms.choice")), claim).outcome == "underspecified"
