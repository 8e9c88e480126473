"""Ledgers of the papers: what is refused, and whether the four are whole."""

import pytest

from dexterity import store
from dexterity_study.claims import ledger
from dexterity_study.engine import readings
from dexterity_study.engine.evidence import chapters

FILES = {
    "paper.toml": """
key = "paper"
letter = "A"
title = "A title"
authors = ["A. Nonymous"]
journal = "A journal"
year = 2016
doi = ""

[compared]
"part.chapter" = 2026-01-31T10:00:01Z
""",
    "claims.toml": """
[[claims]]
id = "share"
where = "Table 1"
kind = "value"
says = "So much."
chapter = "part.chapter"
value = [0.5, 12]
unit = "%"
rounding = 0.05
rule = "number"
assumes = ["limit"]

[[claims]]
id = "order"
where = "section 1"
kind = "ordering"
says = "First the first."
chapter = "part.chapter"
rule = "order"
""",
    "settings.toml": """
[[settings]]
id = "size"
where = "section 2"
says = "Size of the thing."
chapter = "part.chapter"
value = 1e-9
unit = "1"
rounding = 0
note = "It is small."
""",
    "assumptions.toml": """
[[assumptions]]
id = "limit"
where = "Table 1"
missing = "The limit."
chapter = "part.chapter"
chosen = "Ten."
why = "It is round."
origin = "text"
set = 2026-01-31T10:00:00Z
by = "declared"
""",
}


@pytest.fixture
def write_paper(tmp_path, monkeypatch):
    """Return a function that writes the ledger of the only paper, with one text exchanged for another."""
    folder = tmp_path / "papers" / "paper"
    folder.mkdir(parents=True)
    monkeypatch.setattr(store, "data_path", lambda *parts: tmp_path.joinpath(*parts))
    caches = (ledger.load_paper, ledger.load_papers, readings.assumptions)

    def write(name="paper.toml", old="", new=""):
        for cached in caches:
            cached.cache_clear()
        for file, text in FILES.items():
            assert file != name or old in text
            (folder / file).write_text(text.replace(old, new, 1) if file == name else text, encoding="utf-8")

    yield write
    for cached in caches:
        cached.cache_clear()


def test_a_ledger_is_what_its_files_say(write_paper):
    write_paper()
    paper = ledger.load_paper("paper")
    assert (paper.letter, paper.authors, paper.year) == ("A", ("A. Nonymous",), 2016)
    assert paper.claim("share").assumes == ("limit",)
    assert paper.claim("order").assumes is None
    assert paper.setting("size").note == "It is small."
    assert [assumption.id for assumption in paper.assumptions] == ["limit"]
    assert (paper.printed("share"), paper.printed("size")) == ((0.5, 12.0), 1e-9)


def test_numbers_are_written_as_they_are_printed(write_paper):
    write_paper()
    paper = ledger.load_paper("paper")
    assert paper.claim("share").printed == "0.5, 12.0 %"
    assert paper.setting("size").printed == "1\xa0×\xa010⁻⁹"
    assert paper.claim("order").printed == ""


def test_a_paper_is_read_once(write_paper):
    write_paper()
    assert ledger.load_papers()[0] is ledger.load_paper("paper")


@pytest.mark.parametrize("method", ["claim", "setting", "printed"])
def test_an_unknown_id_is_answered_with_the_nearest(write_paper, method):
    write_paper()
    with pytest.raises(ValueError, match=r"paper has no .*'saze'; the nearest are (size|share)"):
        getattr(ledger.load_paper("paper"), method)("saze")


def test_what_prints_no_value_has_none(write_paper):
    write_paper()
    with pytest.raises(ValueError, match="'order' of paper paper has no printed value"):
        ledger.load_paper("paper").printed("order")


def test_an_unknown_paper_is_answered_with_those_there_are(write_paper):
    write_paper()
    with pytest.raises(ValueError, match="there is no paper 'papier'; the nearest are paper"):
        ledger.load_paper("papier")


@pytest.mark.parametrize(
    ("file", "old", "new", "complaint"),
    [
        ("paper.toml", 'key = "paper"', 'key = "other"', "has the key 'other'"),
        ("paper.toml", "year = 2016", 'year = "2016"', "is not of type int"),
        ("paper.toml", "year = 2016", "", "year"),
        ("paper.toml", "year = 2016", "year = 2016\nclaims = []", "claims"),
        ("claims.toml", 'where = "Table 1"', "", "entry 'share': .*where"),
        ("claims.toml", 'where = "Table 1"', 'where = ""', "entry 'share': .*where must not be empty"),
        ("claims.toml", 'kind = "value"', 'kind = "number"', "entry 'share': .*number"),
        ("claims.toml", 'kind = "value"', 'kind = "statement"', "entry 'share': .*and has the value"),
        ("claims.toml", "value = [0.5, 12]", 'value = "0.5"', "entry 'share': .*is none of"),
        ("claims.toml", "value = [0.5, 12]", "value = true", "entry 'share': .*is none of"),
        ("claims.toml", "rounding = 0.05", "rounding = 0.03", "entry 'share': .*half a power of ten"),
        ("claims.toml", 'rule = "number"', 'rule = "guess"', "entry 'share': .*guess"),
        ("claims.toml", 'rule = "order"', 'rule = "bound"', "entry 'order': .*needs a printed value"),
        ("claims.toml", 'rule = "number"', 'rule = "number"\nopen = true', "entry 'share': .*open"),
        ("claims.toml", 'id = "order"', 'id = "share"', "share occurs more than once"),
        ("claims.toml", 'id = "order"', 'id = "size"', "size occurs more than once"),
        ("claims.toml", '["limit"]', '["limt"]', "claim 'share' rests on .*'limt'; the nearest are limit"),
        (
            "assumptions.toml",
            'by = "declared"',
            'by = "known"',
            "entry 'limit': .*all but what is declared needs one",
        ),
        ("settings.toml", 'note = "It is small."', "note = 3", "entry 'size': .*is not of type str"),
        ("settings.toml", "[[settings]]", "[[claims]]", "has the keys claims"),
    ],
)
def test_a_malformed_ledger_is_refused_by_file_and_entry(write_paper, file, old, new, complaint):
    write_paper(file, old, new)
    with pytest.raises(ValueError, match=f"(?s)^paper/{file}: .*{complaint}"):
        ledger.load_paper("paper")


@pytest.mark.parametrize(("old", "new"), [("10:00:01", "10:00:00"), ("part.chapter", "part.other")])
def test_what_was_set_after_a_comparison_is_not_declared(write_paper, old, new):
    write_paper("paper.toml", old, new)
    with pytest.raises(
        ValueError, match="assumption 'limit' is declared, and was set at 2026-01-31 10:00:00"
    ):
        ledger.load_paper("paper")


def test_an_assumption_that_came_later_is_held_against_its_own_results(write_paper):
    write_paper(
        "paper.toml",
        '"part.chapter" = 2026-01-31T10:00:01Z',
        '"part.chapter" = 2026-01-01T10:00:00Z\nlimit = 2026-02-01T10:00:00Z',
    )
    assert ledger.load_paper("paper").assumptions[0].by == "declared"


def test_what_is_fitted_names_what_is_printed(write_paper):
    fitted = 'by = "fitted"\nbasis = "Read off."\nfits = ["shape"]'
    write_paper(
        "assumptions.toml",
        'origin = "text"\nset = 2026-01-31T10:00:00Z\nby = "declared"',
        f'origin = "fitted"\nset = 2026-01-31T11:00:00Z\n{fitted}',
    )
    with pytest.raises(
        ValueError, match=r"assumption 'limit' fits the unknown .*'shape'; the nearest are share"
    ):
        ledger.load_paper("paper")


PAPERS = ("sotiropoulos2016", "sotiropoulos2011", "liao2018", "rouvinen1999")


def test_the_papers_come_in_the_order_of_their_letters():
    assert tuple(paper.key for paper in ledger.load_papers()) == PAPERS
    assert [paper.letter for paper in ledger.load_papers()] == list("ABCD")


@pytest.mark.parametrize("key", PAPERS)
def test_what_the_authors_chose_is_no_claim(key):
    assert not any(claim.says.startswith("Setting") for claim in ledger.load_paper(key).claims)


@pytest.mark.parametrize("key", PAPERS)
def test_every_chapter_that_is_named_exists(key):
    paper = ledger.load_paper(key)
    entries = (*paper.claims, *paper.settings, *paper.assumptions)
    assert {entry.chapter for entry in entries} <= set(chapters())
