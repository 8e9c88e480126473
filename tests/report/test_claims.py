import dataclasses
import itertools
import math
import re
import tomllib
from xml.etree import ElementTree

import pytest
from hypothesis import given
from hypothesis import strategies as st

from dexterity import store
from dexterity.report import claims
from dexterity.report.claims import Acceptance, Assumption, Claim, Outcome, Paper, Verdict
from dexterity.report.markup import Cell, table

LEDGER = """
[paper]
key = "smith1999"
letter = "Z"
title = "On <arms> & legs"
authors = ["A. Smith", "B. Jones"]
journal = "Journal"
year = 1999
doi = "10.0/0"

[[claims]]
id = "speed"
where = "Table 1"
kind = "value"
says = "It is fast & small, w < 2."
value = [0.5, 3]
unit = "m/s"
rounding = 0.05
study = "part.one"

[[claims]]
id = "best"
where = "section 2"
kind = "ordering"
says = "It is better."
study = "part.one"

[[claims]]
id = "later"
where = "section 3"
kind = "statement"
says = "It will last."
study = "part.two"
open = true

[[assumptions]]
id = "mass"
where = "section 2"
missing = "The mass."
chosen = "1 kg."
why = "It is the unit."
study = "part.one"
"""
SPEED = Verdict("smith1999", "speed", Outcome.REPRODUCED, "0.5, 3.0 m/s", "±0.01", "Of <course>.")
BEST = Verdict("smith1999", "best", Outcome.NOT_REPRODUCED, "", "", "It is worse.")


def read(tmp_path, text, name="smith1999"):
    file = tmp_path / f"{name}.toml"
    file.write_text(text, encoding="utf-8")
    return claims.read_paper(file)


@pytest.fixture
def paper(tmp_path):
    return read(tmp_path, LEDGER)


def test_a_ledger_is_read_as_it_is_written(paper):
    assert paper.authors == ("A. Smith", "B. Jones")
    assert [claim.id for claim in paper.claims] == ["speed", "best", "later"]
    assert paper.claim("speed").value == (0.5, 3.0)
    assert paper.claim("best") == Claim("best", "section 2", "ordering", "It is better.", "part.one")
    assert paper.claim("later").open
    assert paper.assumption("mass").chosen == "1 kg."


@pytest.mark.parametrize(
    ("old", "new", "complaint"),
    [
        ('letter = "Z"', "", "letter"),
        ('letter = "Z"', 'letter = "Z"\ncolour = "red"', "colour"),
        ("[[claims]]", "[[paper.claims]]", "within paper"),
        ("year = 1999", 'year = "1999"', "year"),
        ('["A. Smith", "B. Jones"]', '"A. Smith"', "authors"),
        ('key = "smith1999"', 'key = "smith"', "key"),
        ("[[claims]]", "[[claim]]", "tables"),
        ("[paper]", "[article]", "tables"),
        ('id = "best"', 'id = "speed"', "speed"),
        ('id = "best"', 'id = "The best"', "The best"),
        ('id = "best"', "id = 3", "3"),
        ('id = "best"', "", "claims 2"),
        ('kind = "ordering"', 'kind = "order"', "best.*kind"),
        ('kind = "ordering"', 'kind = "value"', "best.*value"),
        ("value = [0.5, 3]", "", "speed.*value"),
        ("value = [0.5, 3]", 'value = "0.5"', "speed.*value"),
        ("value = [0.5, 3]", 'value = [0.5, "3"]', "speed.*value"),
        ("rounding = 0.05", "rounding = 0.04", "speed.*rounding"),
        ("rounding = 0.05", "rounding = -0.05", "speed.*rounding"),
        ("rounding = 0.05", "rounding = inf", "speed.*rounding"),
        ("rounding = 0.05", "rounding = true", "speed.*rounding"),
        ("open = true", 'open = "yes"', "later.*open"),
        ('says = "It is better."', 'says = " "', "best.*says"),
        ('says = "It is better."', 'says = "It is better."\nsaid = "x"', "best.*said"),
        ('why = "It is the unit."', "", "mass.*why"),
        ('why = "It is the unit."', 'why = ""', "mass.*why"),
        ("[[assumptions]]", "[[assumptions", "line 36"),
    ],
)
def test_a_malformed_ledger_is_named_with_the_entry(tmp_path, old, new, complaint):
    assert old in LEDGER
    with pytest.raises(ValueError, match=rf"(?s)smith1999\.toml: .*{complaint}"):
        read(tmp_path, LEDGER.replace(old, new))


@given(st.recursive(st.integers() | st.text(max_size=3), lambda inner: st.lists(inner, max_size=2)))
def test_no_entry_of_another_type_passes(tmp_path_factory, value):
    text = LEDGER.replace("[[claims]]", "[[unused]]").replace("[[assumptions]]", "[[unused]]")
    listed = f"claims = {value!r}\n".replace("'", '"')
    try:
        tomllib.loads(listed)
    except tomllib.TOMLDecodeError:
        return
    with pytest.raises(ValueError, match=r"smith1999\.toml"):
        read(tmp_path_factory.mktemp("ledger"), listed + text)


def test_an_unknown_name_is_answered_with_the_nearest(paper):
    with pytest.raises(ValueError, match=r"sped.*speed"):
        paper.claim("sped")
    with pytest.raises(ValueError, match=r"maas.*mass"):
        paper.assumption("maas")
    with pytest.raises(ValueError, match=r"no-such.*sotiropoulos2016"):
        claims.load_paper("no-such")


def test_two_papers_do_not_share_an_anchor(tmp_path, monkeypatch):
    (tmp_path / "_data" / "papers").mkdir(parents=True)
    monkeypatch.setattr(store, "PACKAGE", tmp_path)
    for key, letter in (("smith1999", "B"), ("jones2000", "A")):
        text = LEDGER.replace("smith1999", key).replace('"Z"', f'"{letter}"')
        (tmp_path / "_data" / "papers" / f"{key}.toml").write_text(text)
    with pytest.raises(ValueError, match="speed"):
        claims.load_papers()
    for name in ("speed", "best", "later"):
        text = text.replace(f'"{name}"', f'"{name}-again"')
    (tmp_path / "_data" / "papers" / "jones2000.toml").write_text(text)
    assert [paper.letter for paper in claims.load_papers()] == ["A", "B"]


@pytest.mark.parametrize(
    ("value", "unit", "rounding", "printed"),
    [
        (0.7043, "s", 5e-5, "0.7043 s"),
        (0.7, "s", 5e-5, "0.7000 s"),
        (100, "times", 50, "100 times"),
        (21162, "operations", 0, "21162 operations"),
        (5e-6, "1", 0, "5 × 10⁻⁶"),
        (1.5, "", 0, "1.5"),
        ((350, 425), "operations", 0, "350, 425 operations"),
        ((-15, 15), "deg", 0.5, "-15, 15 deg"),
        (math.nan, "m", 0.5, "nan m"),
    ],
)
def test_a_value_is_written_as_it_is_printed(value, unit, rounding, printed):
    assert Claim("c", "w", "value", "s", "x", value, unit, rounding).printed == printed


@given(st.floats(-1e6, 1e6), st.integers(-6, 0))
def test_a_value_is_rounded_to_the_last_printed_digit(value, place):
    rounding = 0.5 * 10.0**place
    text = Claim("c", "w", "value", "s", "x", value, "", rounding).printed
    assert abs(float(text) - value) <= rounding * (1 + 1e-6)
    assert len(text.partition(".")[2]) == -place


@pytest.mark.parametrize(
    ("value", "holds"), [(1.0, True), (1.1, False), (-5.0, True), (math.nan, False), (math.inf, False)]
)
def test_an_acceptance_figure_holds_up_to_its_limit(value, holds):
    assert Acceptance("error", value, 1.0).holds == holds
    assert not Acceptance("error", value, math.nan).holds


def faults(paper, **verdicts):
    by_study = {name.replace("_", "."): given for name, given in verdicts.items()}
    return claims.ledger_faults([paper], by_study)


def test_a_ledger_that_its_studies_cover_has_no_faults(paper):
    assert faults(paper, part_one=(SPEED, BEST)) == ()


@pytest.mark.parametrize(
    ("verdicts", "complaint"),
    [
        ({"part_one": (SPEED,)}, "best"),
        ({"part_one": (SPEED, BEST, BEST)}, "best 2"),
        ({}, "speed.*not there"),
        ({"part_one": (SPEED, BEST), "part_two": ()}, "later.*open"),
        ({"part_one": (SPEED, BEST, dataclasses.replace(BEST, claim="later"))}, "later.*no ledger"),
        ({"part_one": (SPEED, BEST, dataclasses.replace(BEST, claim="nothing"))}, "nothing"),
        ({"part_one": (SPEED, BEST, dataclasses.replace(BEST, paper="jones2000"))}, "jones2000"),
        ({"part_one": (SPEED, BEST), "part_three": (BEST,)}, "part.three"),
    ],
)
def test_each_way_to_miss_a_claim_is_a_fault(paper, verdicts, complaint):
    found = faults(paper, **verdicts)
    assert any(re.search(complaint, fault) for fault in found), found


def parsed(markup):
    return ElementTree.fromstring(f"<div>{markup._repr_html_()}</div>")


def text_of(element):
    return "".join(element.itertext())


def test_a_scorecard_shows_every_claim_in_the_order_of_the_ledger(paper):
    page = parsed(claims.scorecard([paper], [BEST, SPEED]))
    rows = page.findall(".//tbody/tr")
    assert [row.get("id") for row in rows] == ["claim-speed", "claim-best", "claim-later"]
    cells = [[text_of(cell) for cell in row] for row in rows]
    assert cells[0] == [
        *("It is fast & small, w < 2.Table 1", "0.5, 3.0 m/s", "0.5, 3.0 m/s±0.01"),
        "reproducedOf <course>.",
    ]
    assert cells[2] == ["It will last.section 3", "", "", "open"]
    assert [cell.get("data-label") for cell in rows[0].findall("td")] == ["Paper", "Ours", "Verdict"]
    verdict_classes = [row.find("td[3]/span").get("class") for row in rows]
    assert verdict_classes == [
        *("verdict verdict-reproduced", "verdict verdict-not-reproduced", "verdict verdict-open")
    ]
    assert text_of(page.find("p")) == "Paper Z, 3 claims: 1 reproduced, 1 not reproduced, 1 open"


def test_a_table_can_be_read_aloud_and_scrolled(paper):
    page = parsed(claims.scorecard([paper], [SPEED, BEST]))
    frame = page.find("div")
    assert frame.get("class") == "table-scroll"
    assert frame.get("tabindex") == "0"
    assert text_of(page.find(".//caption")) == "Paper Z: On <arms> & legs"
    assert {heading.get("scope") for heading in page.findall(".//thead/tr/th")} == {"col"}
    assert all(row[0].tag == "th" and row[0].get("scope") == "row" for row in page.findall(".//tbody/tr"))
    assert not any(element.get("style") for element in page.iter())


@pytest.mark.parametrize(
    ("verdicts", "complaint"),
    [
        ([SPEED], "best"),
        ([SPEED, BEST, BEST], "best"),
        ([SPEED, BEST, dataclasses.replace(BEST, claim="bets")], "bets.*best"),
        ([SPEED, BEST, dataclasses.replace(BEST, paper="jones2000")], "jones2000"),
    ],
)
def test_a_scorecard_with_a_gap_or_a_stray_verdict_is_refused(paper, verdicts, complaint):
    with pytest.raises(ValueError, match=complaint):
        claims.scorecard([paper], verdicts)


def test_a_summary_counts_what_the_scorecard_shows(paper):
    page = parsed(claims.summary([paper], [BEST, SPEED]))
    assert [text_of(heading) for heading in page.findall(".//thead/tr/th")] == ["Verdict", "Paper Z"]
    counts = dict(map(text_of, row) for row in page.findall(".//tbody/tr"))
    assert list(counts) == [*Outcome, "open"]
    shown = {outcome: count for outcome, count in counts.items() if count != "0"}
    assert shown == {"reproduced": "1", "not reproduced": "1", "open": "1"}


@pytest.mark.parametrize(
    ("tau", "outcome"),
    [
        (1.0, Outcome.REPRODUCED),
        (0.8, Outcome.REPRODUCED),
        (0.79, Outcome.IN_SHAPE),
        (0.3, Outcome.IN_SHAPE),
        (0.29, Outcome.NOT_REPRODUCED),
        (0.01, Outcome.NOT_REPRODUCED),
        (0.0, Outcome.CONTRADICTED),
        (-1.0, Outcome.CONTRADICTED),
        (math.nan, Outcome.NOT_REPRODUCED),
    ],
)
def test_an_outcome_follows_from_a_correlation(tau, outcome):
    assert Outcome.of_correlation(tau) is outcome


def test_a_claim_that_holds_is_reproduced():
    assert Outcome.of(True) is Outcome.REPRODUCED
    assert Outcome.of(False) is Outcome.NOT_REPRODUCED


def test_a_chapter_shows_its_own_verdicts_only(paper):
    elsewhere = dataclasses.replace(BEST, paper="jones2000", claim="else")
    page = parsed(claims.verdict_table(paper, [BEST, elsewhere]))
    assert [row.get("id") for row in page.findall(".//tbody/tr")] == ["claim-best"]
    with pytest.raises(ValueError, match="bets"):
        claims.verdict_table(paper, [dataclasses.replace(BEST, claim="bets")])


def test_assumptions_are_shown_with_all_that_is_known_of_them(paper):
    row = parsed(claims.assumption_table([paper])).find(".//tbody/tr")
    assert row.get("id") == "assumption-mass"
    assert [text_of(cell) for cell in row] == [
        *("The mass.section 2; matters to part.one", "1 kg.", "It is the unit.")
    ]
    assert parsed(claims.assumption_table([paper], study="part.two")).find(".//tbody/tr") is None


def test_a_row_with_a_cell_too_many_is_refused():
    with pytest.raises(ValueError, match="here has 2 cells"):
        table("caption", ["one"], {"here": [Cell("a"), Cell("b")]})


def test_the_ledgers_of_the_papers_are_sound():
    papers = claims.load_papers()
    assert [paper.letter for paper in papers] == sorted({paper.letter for paper in papers})
    for paper in papers:
        assert claims.load_paper(paper.key) == paper
    for entry in itertools.chain.from_iterable((*paper.claims, *paper.assumptions) for paper in papers):
        assert isinstance(entry, Claim | Assumption)
    verdicts = [
        Verdict(paper.key, claim.id, Outcome.IN_SHAPE, "", "", "Why.")
        for paper in papers
        for claim in paper.claims
        if not claim.open
    ]
    page = parsed(claims.scorecard(papers, verdicts))
    ids = [element.get("id") for element in page.iter() if element.get("id")]
    assert len(ids) == len(set(ids)) == sum(len(paper.claims) for paper in papers)


def test_a_paper_is_never_changed(paper):
    assert isinstance(paper, Paper)
    with pytest.raises(dataclasses.FrozenInstanceError):
        paper.year = 2000
