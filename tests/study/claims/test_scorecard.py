"""Verdicts of the whole study: one for each claim, the same on every page."""

import json
import re

import pytest

from dexterity import store
from dexterity_study.claims import overview, scorecard
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


def test_chapters_scorecards_and_summary_show_the_same_verdicts():
    whole = {}
    for paper in load_papers():
        whole |= anchors(overview.scorecard(paper.key).html)
    for chapter in chapters():
        own = anchors(scorecard.verdict_table(chapter).html)
        assert own.items() <= whole.items()
    cells = re.findall(r"<td[^>]*>(\d+)</td>", overview.summary().html)
    assert sum(map(int, cells)) == len(whole) == len(scorecard.all_verdicts())


def test_printed_numbers_are_counted_apart():
    html = overview.summary("value").html
    numbers = [claim for paper in load_papers() for claim in paper.claims if claim.kind == "value"]
    assert sum(map(int, re.findall(r"<td[^>]*>(\d+)</td>", html))) == len(numbers) > 0
    assert 'id="summary-value-reproduced"' in html


def test_headlines_and_what_was_not_reproduced_are_not_folded():
    for chapter in chapters():
        html = scorecard.verdict_table(chapter).html
        folded = "".join(re.findall(r"<details.*?</details>", html, flags=re.S))
        outcomes = set(re.findall(r'class="verdict [^"]*"[^>]*>([^<]*)<', folded))
        assert outcomes <= {"reproduced", "not run", "out of scope"}
        assert 'class="headline"' not in folded


def test_the_answer_of_a_chapter_names_claims_of_the_ledgers():
    html = scorecard.answer("product-of-exponentials").html
    assert 'href="../uvms/kinematics.html#claim-product-of-exponentials"' in html
    with pytest.raises(ValueError, match="no paper claims nonsense"):
        scorecard.answer("nonsense")


def test_the_assumptions_say_when_and_by_what_they_were_set():
    html = scorecard.assumption_table().html
    words = {"declared": "declared", "known": "known results", "fitted": "fitted"}
    for one in (assumption for paper in load_papers() for assumption in paper.assumptions):
        row = re.search(rf'id="assumption-{one.id}".*?</tbody>', html, flags=re.S)
        assert row is not None
        assert words[one.by] in row[0]
        assert f"{one.set:%-d %b %Y}" in row[0]
        assert all(name in row[0] for name in one.fits)


def test_the_file_of_all_verdicts_has_every_claim():
    papers = json.loads(overview.as_json())["papers"]
    listed = {(paper["key"], claim["id"]): claim["verdict"] for paper in papers for claim in paper["claims"]}
    assert listed == {(one.paper, one.claim): one.outcome for one in scorecard.all_verdicts()}


def test_the_readme_has_the_table_of_the_verdicts():
    readme = (store.repository() / "README.md").read_text("utf-8")
    assert overview.renewed(readme) == readme, "python -m dexterity_study.claims.overview README.md renews it"


def test_a_text_without_marks_is_refused():
    with pytest.raises(ValueError, match="needs the marks"):
        overview.renewed("nothing")


def test_a_threshold_is_shown_with_its_digits_and_its_unit():
    html = overview.own_thresholds().html
    near = [claim for paper in load_papers() for claim in paper.claims if claim.near is not None]
    assert near
    for claim in near:
        row = re.search(rf'id="near-{claim.id}".*?<td[^>]*>([^<]*)</td>', html, flags=re.S)
        assert row is not None
        number, _, unit = row[1].partition(" ")
        assert float(number) == claim.near.within
        assert unit == ("" if claim.unit == "1" else claim.unit)


def test_the_assumptions_of_a_chapter_are_folded_and_those_of_the_book_are_not():
    chapter, book = scorecard.assumption_table("uvms.cost").html, scorecard.assumption_table().html
    assert re.fullmatch(r"<details.*</details>", chapter, flags=re.S)
    assert "<details" not in book
