"""Claims and verdicts: what the papers say, and what became of it.

A study returns a verdict for each claim that the ledger of a paper gives to it; the tables here set both
side by side.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from html import escape

from dexterity.report.ledger import Assumption, Claim, Paper, load_paper, load_papers, read_paper
from dexterity.report.markup import Cell, Markup, element, table

__all__ = [
    "Acceptance",
    "Assumption",
    "Claim",
    "Outcome",
    "Paper",
    "Verdict",
    "assumption_table",
    "ledger_faults",
    "load_paper",
    "load_papers",
    "read_paper",
    "scorecard",
    "summary",
    "verdict_table",
]


class Outcome(StrEnum):
    """What became of a claim."""

    REPRODUCED = "reproduced"
    IN_SHAPE = "in shape"
    FITTED = "fitted"
    NOT_REPRODUCED = "not reproduced"
    CONTRADICTED = "contradicted"
    UNDERSPECIFIED = "underspecified"
    OUT_OF_SCOPE = "out of scope"

    @classmethod
    def of(cls, holds: bool) -> Outcome:
        """Reproduced or not."""
        return cls.REPRODUCED if holds else cls.NOT_REPRODUCED

    @classmethod
    def of_correlation(cls, tau: float) -> Outcome:
        """Judge a claim that one quantity tells another, by Kendall's τ of the two.

        The bounds are the same for every study: reproduced from 0.8, in shape from 0.3, contradicted from
        0 downwards, not reproduced in between.
        """
        if tau >= 0.8:
            return cls.REPRODUCED
        if tau >= 0.3:
            return cls.IN_SHAPE
        return cls.CONTRADICTED if tau <= 0 else cls.NOT_REPRODUCED


@dataclass(frozen=True)
class Verdict:
    """A study's judgement of a claim.

    Attributes
    ----------
    paper
        Key of the paper.
    claim
        Name of the claim.
    outcome
        What became of it.
    ours
        Our value, with its unit where it has one; empty where there is nothing to measure.
    spread
        How far our value moves, and over what; empty where it does not.
    sentence
        Why, in one sentence.
    """

    paper: str
    claim: str
    outcome: Outcome
    ours: str
    spread: str
    sentence: str


@dataclass(frozen=True)
class Acceptance:
    """A figure that must not exceed its limit for the book to be accepted."""

    name: str
    value: float
    limit: float

    @property
    def holds(self) -> bool:
        """Whether the value is within the limit; NaN never is."""
        return self.value <= self.limit


def ledger_faults(papers: Sequence[Paper], verdicts: Mapping[str, Sequence[Verdict]]) -> tuple[str, ...]:
    """Compare the ledgers with the studies that there are and with the verdicts that they return.

    Parameters
    ----------
    papers
        The ledgers.
    verdicts
        The verdicts of each study, by the study's name.

    Returns
    -------
    One sentence for each claim that no study judges although it is not marked open, that is marked open
    although its study is there, that its study leaves out or judges twice, and for each verdict on a claim
    that is not the study's own. None if all is well.
    """
    claims = {(paper.key, claim.id): claim for paper in papers for claim in paper.claims}
    given = Counter((study, v.paper, v.claim) for study, own in verdicts.items() for v in own)
    faults = [
        f"study {study} judges {paper}/{name}, which no ledger gives to it"
        for study, paper, name in given
        if (paper, name) not in claims or claims[paper, name].study != study
    ]
    for (paper, name), claim in claims.items():
        count = given[claim.study, paper, name]
        if claim.open and claim.study in verdicts:
            faults.append(f"claim {paper}/{name} is marked open, but its study {claim.study} is there")
        elif not claim.open and claim.study not in verdicts:
            faults.append(
                f"claim {paper}/{name} is not marked open, and its study {claim.study} is not there"
            )
        elif not claim.open and count != 1:
            faults.append(f"study {claim.study} gives claim {paper}/{name} {count} verdicts")
    return tuple(faults)


def scorecard(papers: Sequence[Paper], verdicts: Iterable[Verdict]) -> Markup:
    """Set all claims of the papers with their verdicts, under a line that counts them.

    Parameters
    ----------
    papers
        The ledgers; each gets a table, with the claims in the ledger's order.
    verdicts
        The verdicts of all studies.

    Raises
    ------
    ValueError
        If a claim that is not marked open has no verdict, a claim has two, or a verdict's claim is not there.
    """
    by_claim = _by_claim(papers, verdicts)
    missing = [
        claim.id
        for paper in papers
        for claim in paper.claims
        if not claim.open and (paper.key, claim.id) not in by_claim
    ]
    if missing:
        raise ValueError(f"no verdict is given for {', '.join(missing)}")
    parts = (_count_line(paper, by_claim) + _claim_table(paper, paper.claims, by_claim) for paper in papers)
    return Markup("\n".join(parts))


def summary(papers: Sequence[Paper], verdicts: Iterable[Verdict]) -> Markup:
    """Count the claims of each paper by what became of them.

    Parameters
    ----------
    papers
        The ledgers, a column for each.
    verdicts
        The verdicts of all studies.

    Raises
    ------
    ValueError
        If a claim has two verdicts, or a verdict's claim is not there.
    """
    by_claim = _by_claim(papers, verdicts)
    counts = {f"Paper {paper.letter}": _counts(paper, by_claim) for paper in papers}
    rows = {
        f"summary-{outcome.replace(' ', '-')}": [
            Cell(outcome, css_class=_verdict_class(outcome)),
            *(Cell(str(count[outcome])) for count in counts.values()),
        ]
        for outcome in (*Outcome, _OPEN)
    }
    return Markup(table("How many claims came out how", ("Verdict", *counts), rows))


def verdict_table(paper: Paper, verdicts: Iterable[Verdict]) -> Markup:
    """Set the verdicts of one chapter beside the claims of a paper, in the ledger's order.

    Parameters
    ----------
    paper
        The ledger.
    verdicts
        The chapter's verdicts; those on other papers are left out.

    Raises
    ------
    ValueError
        If two verdicts are on the same claim, or a verdict's claim is not in the ledger.
    """
    by_claim = _by_claim([paper], (verdict for verdict in verdicts if verdict.paper == paper.key))
    judged = [claim for claim in paper.claims if (paper.key, claim.id) in by_claim]
    return Markup(_claim_table(paper, judged, by_claim))


def assumption_table(papers: Iterable[Paper], study: str | None = None) -> Markup:
    """Set the assumptions that papers force on a reader, a table for each paper.

    Parameters
    ----------
    papers
        The ledgers.
    study
        Only the assumptions that this study rests on; all if None.
    """
    columns = ("Missing", "Chosen", "Why")
    tables = []
    for paper in papers:
        chosen = [entry for entry in paper.assumptions if study in (None, entry.study)]
        rows = {f"assumption-{entry.id}": _assumption_cells(entry) for entry in chosen}
        tables.append(table(f"Paper {paper.letter}: what had to be assumed", columns, rows))
    return Markup("\n".join(tables))


def _assumption_cells(entry: Assumption) -> list[Cell]:
    missing = Cell(entry.missing, f"{entry.where}; matters to {entry.study}")
    return [missing, Cell(entry.chosen), Cell(entry.why)]


_ByClaim = dict[tuple[str, str], Verdict]


def _by_claim(papers: Sequence[Paper], verdicts: Iterable[Verdict]) -> _ByClaim:
    by_key = {paper.key: paper for paper in papers}
    by_claim: _ByClaim = {}
    for verdict in verdicts:
        if verdict.paper not in by_key:
            raise ValueError(
                f"the verdict on {verdict.claim} names the paper {verdict.paper!r}, not one of these"
            )
        claim = by_key[verdict.paper].claim(verdict.claim)
        if (verdict.paper, claim.id) in by_claim:
            raise ValueError(f"claim {claim.id} has two verdicts")
        by_claim[verdict.paper, claim.id] = verdict
    return by_claim


def _claim_table(paper: Paper, claims: Iterable[Claim], by_claim: _ByClaim) -> str:
    columns = ("Claim", "Paper", "Ours", "Verdict")
    rows = {f"claim-{c.id}": _claim_cells(c, by_claim.get((paper.key, c.id))) for c in claims}
    return table(f"Paper {paper.letter}: {paper.title}", columns, rows)


def _claim_cells(claim: Claim, verdict: Verdict | None) -> list[Cell]:
    printed = [Cell(claim.says, claim.where), Cell(claim.printed)]
    if verdict is None:
        return [*printed, Cell(""), Cell(_OPEN, css_class=_verdict_class(_OPEN))]
    return [
        *printed,
        Cell(verdict.ours, verdict.spread),
        Cell(verdict.outcome, verdict.sentence, _verdict_class(verdict.outcome)),
    ]


_OPEN = "open"


def _verdict_class(outcome: str) -> str:
    return f"verdict verdict-{outcome.replace(' ', '-')}"


def _counts(paper: Paper, by_claim: _ByClaim) -> Counter[str]:
    verdicts = (by_claim.get((paper.key, claim.id)) for claim in paper.claims)
    return Counter(str(verdict.outcome) if verdict else _OPEN for verdict in verdicts)


def _count_line(paper: Paper, by_claim: _ByClaim) -> str:
    counts = _counts(paper, by_claim)
    listed = ", ".join(
        element("span", f"{counts[outcome]} {outcome}", css_class=_verdict_class(outcome))
        for outcome in (*Outcome, _OPEN)
        if counts[outcome]
    )
    start = f"Paper {paper.letter}, {len(paper.claims)} claims: "
    return element("p", escape(start) + listed, css_class="claim-count") + "\n"
