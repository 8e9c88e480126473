"""Verdicts of the whole study: one for each claim, the same on every page."""

import re

import pytest

from dexterity_study.claims import scorecard
from dexterity_study.claims.check import missed
from dexterity_study.claims.ledger import load_papers
from dexterity_study.engine.evidence import chapters


def anchors(html):
    return dict(re.findall(r'id="claim-([^"]+)".*?class="(verdict [^"]+)"', html, flags=re.S))


def test_each_claim_has_one_verdict():
    assert scorecard.faults(load_papers(), scorecard.all_verdicts()) == ()


def test_acceptance_figures_hold():
    assert list(missed()) == []


@pytest.mark.parametrize("chapter", chapters())
def test_a_chapter_judges_its_own_claims(chapter):
    own = {claim.id for paper in load_papers() for claim in paper.claims if claim.chapter == chapter}
    assert {verdict.claim for verdict in scorecard.chapter_verdicts(chapter)} == own


def test_chapters_scorecard_and_summary_show_the_same_verdicts():
    whole = anchors(scorecard.scorecard().html)
    for chapter in chapters():
        own = anchors(scorecard.verdict_table(chapter).html)
        assert own.items() <= whole.items()
    cells = re.findall(r"<td[^>]*>(\d+)</td>", scorecard.summary().html)
    assert sum(map(int, cells)) == len(whole) == len(scorecard.all_verdicts())


def test_a_threshold_is_shown_with_its_digits_and_its_unit():
    html = scorecard.own_thresholds().html
    near = [claim for paper in load_papers() for claim in paper.claims if claim.near is not None]
    assert near
    for claim in near:
        row = re.search(rf'id="near-{claim.id}".*?<td[^>]*>([^<]*)</td>', html, flags=re.S)
        assert row is not None
        number, _, unit = row[1].partition(" ")
        assert float(number) == claim.near.within
        assert unit == ("" if claim.unit == "1" else claim.unit)
