"""Verdicts and assumptions on the page of a chapter; verdicts come from stored evidence, the same on every page."""

from __future__ import annotations

import importlib
from collections import Counter
from collections.abc import Iterable, Sequence
from functools import cache

from dexterity_study.claims.ledger import Claim, Paper, load_papers
from dexterity_study.claims.outcome import Outcome, Verdict
from dexterity_study.engine.evidence import Evidence, chapters
from dexterity_study.engine.readings import Assumption
from dexterity_study.page.markup import Cell, Markup, element, folded, inline, table

_SET_BY = {"declared": "declared", "known": "known results", "fitted": "fitted"}
_PAGES = {"workspace.baselines": "workspace/estimation", "workspace.control": "workspace/timing"}
"""Pages of the chapters that share one."""


@cache
def chapter_verdicts(chapter: str) -> tuple[Verdict, ...]:
    """Return the verdicts of a chapter on its stored evidence; the only ones that any page shows."""
    module = importlib.import_module(f"dexterity_study.{chapter}.verdicts")
    return tuple(module.verdicts(Evidence(chapter)))


def all_verdicts() -> tuple[Verdict, ...]:
    """Return the verdicts of all chapters."""
    return tuple(verdict for chapter in chapters() for verdict in chapter_verdicts(chapter))


def by_claim(verdicts: Iterable[Verdict]) -> dict[tuple[str, str], Verdict]:
    """Return verdicts by the key of the paper and the id of the claim."""
    return {(one.paper, one.claim): one for one in verdicts}


def page_of(chapter: str) -> str:
    """Return the page of the book that shows a chapter, such as `uvms/kinematics`."""
    return _PAGES.get(chapter, chapter.replace(".", "/"))


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


def answer(*claims: str) -> Markup:
    """Set the answer box of a chapter: claims by id, the paper's number against ours, and the verdict.

    A verdict links to its row, which may stand on another page.

    Raises
    ------
    ValueError
        If no paper has such a claim.
    """
    verdicts, entries = by_claim(all_verdicts()), _entries()
    unknown = [name for name in claims if name not in entries]
    if unknown:
        raise ValueError(f"no paper claims {', '.join(unknown)}")
    rows = (
        claim_line(entry, verdicts[paper.key, entry.id], f"../{page_of(entry.chapter)}.html#claim-{entry.id}")
        for paper, entry in map(entries.__getitem__, claims)
    )
    return Markup(element("ul", "".join(rows), css_class="answer"))


def claim_line(claim: Claim, verdict: Verdict, link: str, **attributes: str) -> str:
    """Set a claim as an item of a list: its verdict, what it says, the paper's number against ours."""
    chip = element("a", verdict.outcome, css_class=chip_class(verdict.outcome), href=link)
    numbers = ", ".join(
        f"{whose}: {value}" for whose, value in (("paper", claim.printed), ("ours", verdict.ours)) if value
    )
    small = element("small", inline(numbers)) if numbers else ""
    return element("li", f"{chip} {element('span', inline(claim.says) + small)}", **attributes)


def verdict_table(*names: str) -> Markup:
    """Set the claims of a page's chapters, a table for each paper.

    Headline claims and all that is not reproduced come first; the others are folded.
    """
    verdicts = by_claim(verdict for name in names for verdict in chapter_verdicts(name))
    parts = []
    for paper in load_papers():
        judged = [claim for claim in paper.claims if (paper.key, claim.id) in verdicts]
        shown = [claim for claim in judged if _is_shown(paper, claim, verdicts[paper.key, claim.id])]
        others = [claim for claim in judged if claim not in shown]
        target = f"../reference/scorecard_{paper.letter.lower()}.html"
        if shown:
            parts.append(claim_table(paper, shown, verdicts, target))
        if others:
            summary = f"Paper {paper.letter}: {_count(len(others), 'claim')} that came out as printed, were not run, or cannot be computed"
            parts.append(folded(summary, claim_table(paper, others, verdicts, target)))
    return Markup("\n".join(parts))


def claim_table(
    paper: Paper, claims: Iterable[Claim], verdicts: dict[tuple[str, str], Verdict], target: str = ""
) -> str:
    """Set claims of a paper with their verdicts; each links to its row on a page, by default its chapter's."""
    rows = {}
    for claim in claims:
        verdict = verdicts[paper.key, claim.id]
        link = f"{target or f'../{page_of(claim.chapter)}.html'}#claim-{claim.id}"
        flips = f"Flipped by {', '.join(verdict.flips)}" if verdict.flips else ""
        note = ". ".join(
            filter(None, [claim.where, verdict.sentence.rstrip("."), verdict.readings, flips, verdict.design])
        )
        rows[f"claim-{claim.id}"] = [
            Cell(claim.says, f"{note}.", "headline" if claim.id in paper.headlines else ""),
            Cell(claim.printed),
            Cell(verdict.ours, verdict.spread),
            Cell(verdict.outcome, "", chip_class(verdict.outcome), link),
        ]
    return table(f"Paper {paper.letter}: {paper.title}", ("Claim", "Paper", "Ours", "Verdict"), rows)


def assumption_table(*names: str) -> Markup:
    """Set the assumptions that the papers force on a reader, those that change verdicts first; of all chapters if none is named.

    Those of named chapters are folded, and only the verdicts of these chapters are counted: a page depends on its
    evidence alone.
    """
    verdicts = [one for name in names for one in chapter_verdicts(name)] if names else all_verdicts()
    flips = Counter(
        part.partition("=")[0] for one in verdicts for name in set(one.flips) for part in name.split("+")
    )
    columns = ("Missing", "Chosen", "Set by", "Others", "Verdicts changed")
    parts = []
    for paper in load_papers():
        own = [one for one in paper.assumptions if not names or one.chapter in names]
        own.sort(key=lambda one: -flips[one.id])
        rows = {f"assumption-{one.id}": _assumption_cells(paper, one, flips[one.id]) for one in own}
        if rows:
            caption = f"Paper {paper.letter}: what had to be assumed"
            whole = table(caption, columns, rows)
            parts.append(folded(f"{caption} ({len(rows)})", whole) if names else whole)
    return Markup("\n".join(parts))


def chip_class(outcome: str) -> str:
    """Return the classes of a verdict's word for the style sheet."""
    return f"verdict verdict-{outcome.replace(' ', '-')}"


@cache
def _entries() -> dict[str, tuple[Paper, Claim]]:
    return {claim.id: (paper, claim) for paper in load_papers() for claim in paper.claims}


def _is_shown(paper: Paper, claim: Claim, verdict: Verdict) -> bool:
    plain = (Outcome.REPRODUCED, Outcome.NOT_RUN, Outcome.OUT_OF_SCOPE)
    return claim.id in paper.headlines or verdict.outcome not in plain


def _assumption_cells(paper: Paper, one: Assumption, flips: int) -> list[Cell]:
    others = "; ".join(f"{other.name} ({other.origin})" for other in one.alternatives)
    return [
        Cell(
            one.missing, f"{one.where}; matters to {one.chapter}. {one.why} {_what_set(paper, one)}".strip()
        ),
        Cell(one.chosen, f"origin: {one.origin}"),
        Cell(_SET_BY[one.by], f"{one.set:%-d %b %Y}"),
        Cell(others or "–"),
        Cell(str(flips) if one.alternatives else "–"),
    ]


def _what_set(paper: Paper, one: Assumption) -> str:
    """Return the results that were known, or the printed values that were fitted; empty for what was declared."""
    if not one.fits:
        return one.basis
    return f"{one.basis} Fitted to {'; '.join(_printed(paper, name) for name in one.fits)}."


def _printed(paper: Paper, name: str) -> str:
    where = next(entry.where for entry in (*paper.claims, *paper.settings) if entry.id == name)
    return f"{where}, {name}"


def _count(number: int, noun: str) -> str:
    return f"{number} {noun}{'s'[: number != 1]}"
