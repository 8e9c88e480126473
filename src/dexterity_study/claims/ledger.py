"""The ledger of a paper: what it claims, what its authors chose, and what it leaves open.

A folder a paper, `data/papers/<key>/`, with `paper.toml`, `claims.toml`, `settings.toml` and
`assumptions.toml`, read strictly.
"""

import functools
import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from datetime import date, datetime
from typing import Any, Literal, TypeVar

from dexterity import store
from dexterity_study.engine import readings, strict
from dexterity_study.page.numbers import power_of_ten

Printed = float | tuple[float, ...]
"""A printed number, or several."""

Rule = Literal["number", "bound", "order", "share", "trend", "formula", "cases"]
"""Rule by which a claim is judged."""


@dataclass(frozen=True, kw_only=True)
class _Entry:
    """Something that a paper prints.

    Attributes
    ----------
    id
        Name, unique in its paper: small letters and digits, joined by hyphens.
    where
        Place where it is printed.
    says
        What it says, in our words, one sentence.
    chapter
        Chapter that it belongs to.
    value
        The printed number or numbers, in `unit`.
    unit
        Unit of the value; empty or "1" for a plain number.
    rounding
        Half a unit of the last printed digit, in `unit`; 0 for a value that is meant exactly.
    """

    id: str
    where: str
    says: str
    chapter: str
    value: Printed | None = None
    unit: str = ""
    rounding: float = 0.0

    def __post_init__(self) -> None:
        strict.require_id(self.id)
        strict.require_text(where=self.where, says=self.says, chapter=self.chapter)
        if self.rounding != 0 and not math.isclose(self.rounding, 0.5 * 10.0 ** _last_place(self.rounding)):
            raise ValueError(f"rounding is {self.rounding}; it must be half a power of ten, or 0")

    @property
    def printed(self) -> str:
        """The paper's value with its unit, as it is printed; empty if there is none."""
        if self.value is None:
            return ""
        values = self.value if isinstance(self.value, tuple) else (self.value,)
        return self.with_unit(", ".join(map(self.format, values)))

    def with_unit(self, number: str) -> str:
        """Add the unit to a written number; a plain number has none."""
        return number if self.unit in ("", "1") else f"{number} {self.unit}"

    def format(self, value: float) -> str:
        """Write a number with as many decimals as the paper prints, without its unit."""
        if self.rounding != 0:
            return f"{value:.{max(0, -_last_place(self.rounding))}f}"
        text = f"{value:.12g}"
        return power_of_ten(text) if "e" in text else text


def _last_place(rounding: float) -> int:
    """Return the power of ten of the last printed digit."""
    return round(math.log10(2 * rounding)) if 0 < rounding < math.inf else 0


@dataclass(frozen=True, kw_only=True)
class Near:
    """Own distance up to which a number is in shape, where the rule book's factor has no meaning.

    Attributes
    ----------
    within
        Largest distance of our median from the printed number, in its unit.
    why
        Reason, half a sentence.
    set
        Day on which it was written down.
    """

    within: float
    why: str
    set: date


@dataclass(frozen=True, kw_only=True)
class Claim(_Entry):
    """Something that a paper asserts, and that gets a verdict.

    Attributes
    ----------
    kind
        Sort of assertion; a claim has a value if it is of kind "value".
    rule
        Rule by which it is judged.
    assumes
        Assumptions that it rests on; None for all of its chapter.
    side
        Side of the printed value on which a bound holds.
    near
        Own distance up to which a number is in shape; None for the rule book's factor.
    """

    kind: Literal["value", "ordering", "formula", "statement"]
    rule: Rule
    assumes: tuple[str, ...] | None = None
    side: Literal["below", "above"] = "below"
    near: Near | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        if (self.kind == "value") != (self.value is not None):
            raise ValueError(f"the claim is of kind {self.kind!r} and has the value {self.value}")
        if self.rule in ("number", "bound") and self.value is None:
            raise ValueError(f"the rule is {self.rule!r}, which needs a printed value")


@dataclass(frozen=True, kw_only=True)
class Setting(_Entry):
    """Something that the authors chose, and that gets no verdict.

    Attributes
    ----------
    note
        Our remark, if there is one.
    """

    note: str = ""


@dataclass(frozen=True, kw_only=True)
class _Head:
    """What identifies a paper, the claims that the start page shows, and when it was first compared with results.

    `compared` has a time for each chapter, and for an assumption whose results came to its chapter later.
    """

    key: str
    letter: str
    title: str
    authors: tuple[str, ...]
    journal: str
    year: int
    doi: str
    headlines: tuple[str, ...] = ()
    compared: Mapping[str, datetime] = field(default_factory=dict, hash=False)


@dataclass(frozen=True, kw_only=True)
class Paper(_Head):
    """A paper, with the ledger of its claims, of its authors' settings, and of what it leaves open."""

    claims: tuple[Claim, ...] = ()
    settings: tuple[Setting, ...] = ()
    assumptions: tuple[readings.Assumption, ...] = ()

    def __post_init__(self) -> None:
        strict.require_unique(entry.id for entry in (*self.claims, *self.settings))
        for name in self.headlines:
            self.claim(name)
        known = [assumption.id for assumption in self.assumptions]
        for claim in self.claims:
            for name in claim.assumes or ():
                strict.require_known(name, known, f"claim {claim.id!r} rests on the unknown assumption")
        for assumption in self.assumptions:
            self._check_what_set(assumption)

    def _check_what_set(self, one: readings.Assumption) -> None:
        """Refuse what calls itself declared and was written down after a comparison, or fits what is not printed."""
        compared = self.compared.get(one.id, self.compared.get(one.chapter))
        if one.by == "declared" and (compared is None or one.set >= compared):
            raise ValueError(
                f"assumption {one.id!r} is declared, and was set at {one.set}; {one.chapter}, or what rests on it, was "
                f"first compared with the paper at {compared}"
            )
        for name in one.fits:
            complaint = f"assumption {one.id!r} fits the unknown claim or setting"
            _named(name, (*self.claims, *self.settings), complaint)

    def claim(self, name: str) -> Claim:
        """Return the claim of that id; ValueError, with the nearest ids, if there is none."""
        return _named(name, self.claims, f"paper {self.key} has no claim")

    def setting(self, name: str) -> Setting:
        """Return the setting of that id; ValueError, with the nearest ids, if there is none."""
        return _named(name, self.settings, f"paper {self.key} has no setting")

    def printed(self, name: str) -> Any:
        """Return the printed value of the claim or setting of that id; ValueError if it has none."""
        entry = _named(name, (*self.claims, *self.settings), f"paper {self.key} has no claim or setting")
        if entry.value is None:
            raise ValueError(f"{name!r} of paper {self.key} has no printed value")
        return entry.value


@functools.cache
def load_paper(key: str) -> Paper:
    """Read the ledger of a paper.

    Parameters
    ----------
    key
        Name of its folder in `data/papers`.

    Raises
    ------
    ValueError
        If there is no such paper, or a file of its ledger is malformed: a key is missing, unknown or of
        another type than declared, or an id occurs twice; the message names the file and the entry.
    """
    strict.require_known(key, _keys(), "there is no paper")
    folder = store.data_path("papers", key)
    head = strict.read_table(folder / "paper.toml", _Head)
    if head.key != key:
        raise ValueError(f"{key}/paper.toml: has the key {head.key!r}; it must be the folder's name")
    claims = strict.read_entries(folder / "claims.toml", Claim)
    settings = strict.read_entries(folder / "settings.toml", Setting)
    assumptions = readings.assumptions(key)
    try:
        return Paper(**vars(head), claims=claims, settings=settings, assumptions=assumptions)
    except ValueError as error:
        raise ValueError(f"{key}/claims.toml: {error}") from error


@functools.cache
def load_papers() -> tuple[Paper, ...]:
    """Read the ledgers of all papers, in the order of the papers' letters.

    Raises
    ------
    ValueError
        If a ledger is malformed, or the id of a claim or setting occurs in two of them.
    """
    papers = sorted(map(load_paper, _keys()), key=lambda paper: paper.letter)
    # The ids are anchors of the one page that shows all papers.
    strict.require_unique(entry.id for paper in papers for entry in (*paper.claims, *paper.settings))
    return tuple(papers)


def _keys() -> list[str]:
    return [file.parent.name for file in store.data_path("papers").glob("*/paper.toml")]


_AnyEntry = TypeVar("_AnyEntry", bound=_Entry)


def _named(name: str, entries: Iterable[_AnyEntry], complaint: str) -> _AnyEntry:
    by_id = {entry.id: entry for entry in entries}
    strict.require_known(name, by_id, complaint)
    return by_id[name]
