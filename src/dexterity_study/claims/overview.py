"""All verdicts at a glance: cards and scorecards of the papers, the rule book, and `scorecard.json`.

python -m dexterity_study.claims.overview README.md   # renews the table between the marks of a Markdown file
"""

from __future__ import annotations

import json
import sys
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

import pandas as pd

from dexterity import store
from dexterity_study.claims.judge import RULES, WORDS
from dexterity_study.claims.ledger import Claim, Paper, load_paper, load_papers
from dexterity_study.claims.outcome import Outcome
from dexterity_study.claims.scorecard import (
    all_verdicts,
    by_claim,
    chip_class,
    claim_line,
    claim_table,
    page_of,
)
from dexterity_study.engine import card as cards_of_runs
from dexterity_study.engine.evidence import chapters, experiments, files, runs
from dexterity_study.page.markup import Cell, Markup, element, folded, inline, table
from dexterity_study.page.numbers import readable
from dexterity_study.page.tables import show

BEGIN, END = "<!-- scorecard: begin -->", "<!-- scorecard: end -->"
"""Marks in a Markdown file around the table of the verdicts."""


def card(key: str) -> Markup:
    """Set the head of a paper's card: what it is, and what became of its headline claims."""
    paper = load_paper(key)
    verdicts = by_claim(all_verdicts())
    source = element("a", "doi:" + paper.doi, href=f"https://doi.org/{paper.doi}") if paper.doi else ""
    head = element("p", f"{element('strong', inline(paper.title))}", css_class="title") + element(
        "p",
        inline(f"{', '.join(paper.authors)} · {paper.journal} · {paper.year}") + (source and f" · {source}"),
    )
    claims = list(map(paper.claim, paper.headlines))
    rows = [
        claim_line(
            claim,
            verdicts[key, claim.id],
            f"{page_of(claim.chapter)}.html#claim-{claim.id}",
            id=f"headline-{claim.id}",
        )
        for claim in claims
    ]
    listed = folded(f"The {len(rows)} headline claims", element("ul", "".join(rows), css_class="answer"))
    return Markup(element("div", head + _bar(paper, claims) + listed, css_class="card-head"))


def what_was_run(key: str) -> Markup:
    """Count, in a line, what the verdicts of a paper rest on, and the hours of computing."""
    paper = load_paper(key)
    names = [
        name
        for name in chapters()
        if name.partition(".")[0] in {c.chapter.partition(".")[0] for c in paper.claims}
    ]
    declared = [one for name in names for one in experiments(name).values()]
    cards = [
        cards_of_runs.read(place.card)["made"]
        for one in declared
        for reading, seed in runs(one)
        if (place := files(one, reading, seed)).card.is_file()
    ]
    # Runs of before the engine know only the duration of their whole study.
    spans = {(one.get("converted_from", number), one["seconds"]) for number, one in enumerate(cards)}
    hours = sum(seconds for _, seconds in spans) / 3600
    facts = {
        "claims judged": len(paper.claims),
        "assumptions": len(paper.assumptions),
        "experiments": len(declared),
        "stored runs": len(cards),
        "hours of computing": round(hours, 1),
    }
    return show(pd.DataFrame([facts]), "{:.1f}")


def summary(kind: str = "") -> Markup:
    """Count the claims of each paper by what became of them.

    Parameters
    ----------
    kind
        Sort of the claims that are counted, such as "value" for printed numbers; all if empty.
    """
    counts = _counts(kind)
    rows = {
        f"summary-{kind}{'-' if kind else ''}{outcome.replace(' ', '-')}": [
            Cell(outcome, css_class=chip_class(outcome)),
            *(Cell(str(count[outcome])) for count in counts.values()),
        ]
        for outcome in Outcome
    }
    columns = ("Verdict", *(f"Paper {paper.letter}" for paper in counts))
    what = {"": "claims", "value": "printed numbers"}.get(kind, f"claims of kind {kind}")
    return Markup(table(f"How many {what} came out how", columns, rows))


def scorecard(key: str) -> Markup:
    """Set all claims of a paper with their verdicts, under a bar that counts them; the page adds the filter."""
    paper = load_paper(key)
    claims = claim_table(paper, paper.claims, by_claim(all_verdicts()))
    return Markup(_bar(paper, paper.claims) + element("div", claims, css_class="filterable"))


def settings_table(key: str) -> Markup:
    """Set what the authors of a paper chose."""
    paper = load_paper(key)
    rows = {
        f"setting-{one.id}": [Cell(one.says, one.where), Cell(one.printed), Cell(one.note)]
        for one in paper.settings
    }
    caption = f"Paper {paper.letter}: what the authors chose"
    return Markup(folded(f"The {len(rows)} settings", table(caption, ("Setting", "Value", "Remark"), rows)))


def rule_book() -> Markup:
    """Set what each word means, and what each rule needs."""
    rules = {f"rule-{rule}": [Cell(rule), Cell(says)] for rule, says in RULES.items()}
    return Markup(_words_table() + table("What each kind of claim needs", ("Claim", "Rule"), rules))


def words() -> Markup:
    """Set what each word of a verdict means, folded."""
    return Markup(folded("What the verdicts mean", _words_table()))


def _words_table() -> str:
    rows = {
        f"word-{word.replace(' ', '-')}": [Cell(word, css_class=chip_class(word)), Cell(says)]
        for word, says in WORDS.items()
    }
    return table("What each word means", ("Verdict", "Meaning"), rows)


def our_values() -> dict[str, str]:
    """Return our value of each headline claim that has one, by the claim's id, as `glue` takes it: in printable letters."""
    verdicts = by_claim(all_verdicts())
    headlines = ((paper.key, name) for paper in load_papers() for name in paper.headlines)
    return {key[1]: _glued(verdicts[key].ours) for key in headlines if verdicts[key].ours}


def _glued(text: str) -> str:
    return readable(text).replace("\N{NO-BREAK SPACE}", " ")


def own_thresholds() -> Markup:
    """Set the claims whose distance for "in shape" differs from the rule book's, with reason and day."""
    rows = {
        f"near-{claim.id}": [
            Cell(claim.says, f"Paper {paper.letter}, {claim.where}"),
            Cell(claim.with_unit(f"{claim.near.within:g}")),
            Cell(claim.near.why, claim.near.set.isoformat()),
        ]
        for paper in load_papers()
        for claim in paper.claims
        if claim.near is not None
    }
    return Markup(table("Thresholds of their own", ("Claim", "In shape within", "Reason"), rows))


def as_json() -> str:
    """Return all verdicts as JSON, in the schema that the scorecard's page describes."""
    verdicts = by_claim(all_verdicts())
    papers = [
        {
            "key": paper.key,
            "letter": paper.letter,
            "title": paper.title,
            "authors": paper.authors,
            "year": paper.year,
            "doi": paper.doi,
            "claims": [
                {
                    "id": claim.id,
                    "says": claim.says,
                    "where": claim.where,
                    "page": f"{page_of(claim.chapter)}.html#claim-{claim.id}",
                    "rule": claim.rule,
                    "headline": claim.id in paper.headlines,
                    "printed": claim.value,
                    "unit": claim.unit,
                    "verdict": verdicts[paper.key, claim.id].outcome,
                    "ours": verdicts[paper.key, claim.id].ours,
                    "spread": verdicts[paper.key, claim.id].spread,
                    "reason": verdicts[paper.key, claim.id].sentence,
                    "readings": verdicts[paper.key, claim.id].readings,
                    "flipped_by": verdicts[paper.key, claim.id].flips,
                    "design": verdicts[paper.key, claim.id].design,
                }
                for claim in paper.claims
            ],
        }
        for paper in load_papers()
    ]
    return json.dumps({"schema": 1, "papers": papers}, ensure_ascii=False, indent=1) + "\n"


def as_markdown() -> str:
    """Return a table in Markdown of how many claims came out how."""
    counts = _counts()
    lines = [
        f"| | {' | '.join(f'paper {paper.letter}' for paper in counts)} |",
        f"|---|{'---:|' * len(counts)}",
        *(
            f"| {outcome} | {' | '.join(str(count[outcome]) for count in counts.values())} |"
            for outcome in Outcome
        ),
        f"| claims | {' | '.join(str(count.total()) for count in counts.values())} |",
    ]
    return "\n".join(lines)


def renewed(text: str) -> str:
    """Return a Markdown text with the present table between its marks.

    Raises
    ------
    ValueError
        If the text has not both marks.
    """
    before, begin, rest = text.partition(BEGIN)
    _, end, after = rest.partition(END)
    if not (begin and end):
        raise ValueError(f"the text needs the marks {BEGIN} and {END}")
    return f"{before}{BEGIN}\n{as_markdown()}\n{END}{after}"


def _counts(kind: str = "") -> dict[Paper, Counter[Outcome]]:
    return {
        paper: Counter(
            one.outcome
            for one in all_verdicts()
            if one.paper == paper.key and kind in ("", paper.claim(one.claim).kind)
        )
        for paper in load_papers()
    }


def _bar(paper: Paper, claims: Sequence[Claim]) -> str:
    """Draw how many of some claims came out how, as one bar whose parts name their numbers."""
    verdicts = by_claim(all_verdicts())
    counts = Counter(verdicts[paper.key, claim.id].outcome for claim in claims)
    shown = [outcome for outcome in Outcome if counts[outcome]]
    parts = (
        element("span", "", css_class=chip_class(outcome), style=f"flex-grow:{counts[outcome]}")
        for outcome in shown
    )
    listed = (
        element("span", f"{counts[outcome]} {outcome}", css_class=chip_class(outcome)) for outcome in shown
    )
    bar = element("div", "".join(parts), css_class="verdict-bar", **{"aria-hidden": "true"})
    return bar + element("p", " ".join(listed), css_class="verdict-counts")


def main(files: Sequence[str]) -> int:
    """Renew the table of Markdown files."""
    for file in map(Path, files):
        store.write_atomically(file, renewed(file.read_text("utf-8")))
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
