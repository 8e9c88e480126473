"""Verdicts on pages: of a chapter, of all papers, and how many came out how."""

from __future__ import annotations

import importlib
from collections import Counter
from collections.abc import Iterable, Sequence
from functools import cache
from html import escape

from dexterity_study.claims.judge import RULES, WORDS
from dexterity_study.claims.ledger import Claim, Paper, load_papers
from dexterity_study.claims.outcome import Outcome, Verdict
from dexterity_study.engine.evidence import Evidence, chapters
from dexterity_study.engine.readings import Assumption
from dexterity_study.page.markup import Cell, Markup, element, table


@cache
def chapter_verdicts(chapter: str) -> tuple[Verdict, ...]:
    """Return the verdicts of a chapter on its stored evidence; the only ones that any page shows."""
    module = importlib.import_module(f"dexterity_study.{chapter}.verdicts")
    return tuple(module.verdicts(Evidence(chapter)))


def all_verdicts() -> tuple[Verdict, ...]:
    """Return the verdicts of all chapters."""
    return tuple(verdict for chapter in chapters() for verdict in chapter_verdicts(chapter))


def faults(papers: Sequence[Paper], verdicts: Iterable[Verdict]) -> tuple[str, ...]:
    """Return a sentence for each claim without a verdict or with several, and for each verdict on no claim."""
    claims = {(paper.key, claim.id) for paper in papers for claim in paper.claims}
    given = Counter((verdict.paper, verdict.claim) for verdict in verdicts)
    return (
        *(f"claim {paper}/{name} has no verdict" for paper, name in sorted(claims - given.keys())),
        *(f"the ledgers have no claim {paper}/{name}" for paper, name in sorted(given.keys() - claims)),
        *(
            f"claim {paper}/{name} has {count} verdicts"
            for (paper, name), count in given.items()
            if count > 1
        ),
    )


def verdict_table(chapter: str) -> Markup:
    """Set the claims of a chapter with their verdicts, a table for each paper."""
    verdicts = _by_claim(chapter_verdicts(chapter))
    tables = []
    for paper in load_papers():
        judged = [claim for claim in paper.claims if (paper.key, claim.id) in verdicts]
        if judged:
            tables.append(_claim_table(paper, judged, verdicts))
    return Markup("\n".join(tables))


def scorecard() -> Markup:
    """Set all claims of the papers with their verdicts, under a line that counts them."""
    verdicts = _by_claim(all_verdicts())
    parts = [
        _count_line(paper, verdicts) + _claim_table(paper, paper.claims, verdicts) for paper in load_papers()
    ]
    return Markup("\n".join(parts))


def summary() -> Markup:
    """Count the claims of each paper by what became of them."""
    counts = {
        paper: Counter(one.outcome for one in all_verdicts() if one.paper == paper.key)
        for paper in load_papers()
    }
    rows = {
        f"summary-{outcome.replace(' ', '-')}": [
            Cell(outcome, css_class=_css(outcome)),
            *(Cell(str(count[outcome])) for count in counts.values()),
        ]
        for outcome in Outcome
    }
    columns = ("Verdict", *(f"Paper {paper.letter}" for paper in counts))
    return Markup(table("How many claims came out how", columns, rows))


def headlines() -> Markup:
    """Set the headline claims of each paper with their verdicts."""
    verdicts = _by_claim(all_verdicts())
    parts = (
        _claim_table(paper, map(paper.claim, paper.headlines), verdicts, "headline")
        for paper in load_papers()
    )
    return Markup("\n".join(parts))


def rule_book() -> Markup:
    """Set what each word means, and what each rule needs."""
    words = {
        f"word-{word.replace(' ', '-')}": [Cell(word, css_class=_css(word)), Cell(says)]
        for word, says in WORDS.items()
    }
    rules = {f"rule-{rule}": [Cell(rule), Cell(says)] for rule, says in RULES.items()}
    return Markup(
        table("What each word means", ("Verdict", "Meaning"), words)
        + table("What each kind of claim needs", ("Claim", "Rule"), rules)
    )


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


def settings_table() -> Markup:
    """Set what the authors chose, a table for each paper."""
    tables = []
    for paper in load_papers():
        rows = {
            f"setting-{one.id}": [Cell(one.says, one.where), Cell(one.printed), Cell(one.note)]
            for one in paper.settings
        }
        if rows:
            caption = f"Paper {paper.letter}: what the authors chose"
            tables.append(table(caption, ("Setting", "Value", "Remark"), rows))
    return Markup("\n".join(tables))


def assumption_table(chapter: str | None = None) -> Markup:
    """Set the assumptions that the papers force on a reader, a table for each paper; of one chapter if it is named."""
    columns = ("Missing", "Chosen", "Why", "Others")
    tables = []
    for paper in load_papers():
        chosen = [one for one in paper.assumptions if chapter in (None, one.chapter)]
        if chosen:
            rows = {f"assumption-{one.id}": _assumption_cells(one) for one in chosen}
            tables.append(table(f"Paper {paper.letter}: what had to be assumed", columns, rows))
    return Markup("\n".join(tables))


def _assumption_cells(one: Assumption) -> list[Cell]:
    others = "; ".join(f"{other.name} ({other.origin})" for other in one.alternatives)
    return [
        Cell(one.missing, f"{one.where}; matters to {one.chapter}"),
        Cell(one.chosen, f"origin: {one.origin}"),
        Cell(one.why, f"set on {one.set.isoformat()}, {one.relative} the results"),
        Cell(others or "–"),
    ]


def _by_claim(verdicts: Iterable[Verdict]) -> dict[tuple[str, str], Verdict]:
    return {(one.paper, one.claim): one for one in verdicts}


def _claim_table(
    paper: Paper, claims: Iterable[Claim], verdicts: dict[tuple[str, str], Verdict], anchor: str = "claim"
) -> str:
    rows = {f"{anchor}-{one.id}": _claim_cells(one, verdicts[paper.key, one.id]) for one in claims}
    return table(f"Paper {paper.letter}: {paper.title}", ("Claim", "Paper", "Ours", "Verdict"), rows)


def _claim_cells(claim: Claim, verdict: Verdict) -> list[Cell]:
    flips = f"Flipped by {', '.join(verdict.flips)}" if verdict.flips else ""
    note = ". ".join(filter(None, [verdict.sentence.rstrip("."), verdict.readings, flips]))
    return [
        Cell(claim.says, claim.where),
        Cell(claim.printed),
        Cell(verdict.ours, verdict.spread),
        Cell(verdict.outcome, f"{note}." if note else "", _css(verdict.outcome)),
    ]


def _count_line(paper: Paper, verdicts: dict[tuple[str, str], Verdict]) -> str:
    counts = Counter(verdicts[paper.key, claim.id].outcome for claim in paper.claims)
    listed = ", ".join(
        element("span", f"{counts[outcome]} {outcome}", css_class=_css(outcome))
        for outcome in Outcome
        if counts[outcome]
    )
    start = f"Paper {paper.letter}, {len(paper.claims)} claims: "
    return element("p", escape(start) + listed, css_class="claim-count") + "\n"


def _css(outcome: str) -> str:
    return f"verdict verdict-{outcome.replace(' ', '-')}"
