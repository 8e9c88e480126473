"""The ledger of a paper: what it claims, and what it forces a reader to assume.

One file a paper, `data/papers/<key>.toml`, read strictly.
"""

import difflib
import math
import re
import tomllib
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal, TypeVar

from dexterity import store
from dexterity.report.records import from_plain

__all__ = ["Assumption", "Claim", "Paper", "load_paper", "load_papers", "read_paper"]


@dataclass(frozen=True)
class Claim:
    """Something that a paper asserts.

    Attributes
    ----------
    id
        Name, unique in its paper: small letters and digits, joined by hyphens.
    where
        Where it is printed.
    kind
        What sort of assertion it is.
    says
        The claim in our words, one sentence.
    study
        The study that judges it.
    value
        The printed number or numbers, in `unit`; None if the claim is not of kind "value".
    unit
        Unit of the value; empty or "1" for a plain number.
    rounding
        Half a unit of the last printed digit, in `unit`; 0 for a value that is meant exactly.
    open
        True as long as the study is not written.
    """

    id: str
    where: str
    kind: Literal["value", "ordering", "formula", "statement"]
    says: str
    study: str
    value: float | tuple[float, ...] | None = None
    unit: str = ""
    rounding: float = 0.0
    open: bool = False

    def __post_init__(self) -> None:
        _require_id(self.id)
        _require_text(where=self.where, says=self.says, study=self.study)
        if (self.kind == "value") != (self.value is not None):
            raise ValueError(f"the claim is of kind {self.kind!r} and has the value {self.value}")
        if self.rounding != 0 and not math.isclose(self.rounding, 0.5 * 10.0 ** _last_place(self.rounding)):
            raise ValueError(f"rounding is {self.rounding}; it must be half a power of ten, or 0")

    @property
    def printed(self) -> str:
        """The paper's value with its unit, as it is printed; empty if there is none."""
        if self.value is None:
            return ""
        values = self.value if isinstance(self.value, tuple) else (self.value,)
        unit = "" if self.unit in ("", "1") else f" {self.unit}"
        return ", ".join(map(self.format, values)) + unit

    def format(self, value: float) -> str:
        """Write a number with as many decimals as the paper prints, without its unit."""
        if self.rounding != 0:
            return f"{value:.{max(0, -_last_place(self.rounding))}f}"
        mantissa, _, exponent = f"{value:.12g}".partition("e")
        return f"{mantissa} × 10{str(int(exponent)).translate(_SUPERSCRIPTS)}" if exponent else mantissa


_SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def _last_place(rounding: float) -> int:
    """Return the power of ten of the last printed digit."""
    return round(math.log10(2 * rounding)) if 0 < rounding < math.inf else 0


@dataclass(frozen=True)
class Assumption:
    """Something that a paper leaves out and that had to be chosen.

    Attributes
    ----------
    id
        Name, unique in its paper: small letters and digits, joined by hyphens.
    where
        Where it is missing.
    missing
        What the paper leaves out.
    chosen
        What is chosen here.
    why
        Why, one sentence, settled before any comparison.
    study
        The study that rests on it.
    """

    id: str
    where: str
    missing: str
    chosen: str
    why: str
    study: str

    def __post_init__(self) -> None:
        _require_id(self.id)
        texts = {name: text for name, text in vars(self).items() if name != "id"}
        _require_text(**texts)


@dataclass(frozen=True)
class Paper:
    """A paper with the ledger of its claims and of the assumptions that it forces on a reader."""

    key: str
    letter: str
    title: str
    authors: tuple[str, ...]
    journal: str
    year: int
    doi: str
    claims: tuple[Claim, ...] = ()
    assumptions: tuple[Assumption, ...] = ()

    def __post_init__(self) -> None:
        for entries in (self.claims, self.assumptions):
            _require_unique(entry.id for entry in entries)

    def claim(self, name: str) -> Claim:
        """Return the claim of that name; ValueError, with the nearest names, if there is none."""
        return _named(name, self.claims, f"paper {self.key} has no claim")

    def assumption(self, name: str) -> Assumption:
        """Return the assumption of that name; ValueError, with the nearest names, if there is none."""
        return _named(name, self.assumptions, f"paper {self.key} has no assumption")


def load_papers() -> tuple[Paper, ...]:
    """Read the ledgers of all papers, in the order of the papers' letters.

    Raises
    ------
    ValueError
        If a ledger is malformed, or a claim's name occurs in two of them; the message names file and entry.
    """
    papers = sorted(map(read_paper, store.data_path("papers").glob("*.toml")), key=lambda paper: paper.letter)
    # The names are anchors of the one page that shows all papers.
    _require_unique(claim.id for paper in papers for claim in paper.claims)
    return tuple(papers)


def load_paper(key: str) -> Paper:
    """Read the ledger of a paper.

    Parameters
    ----------
    key
        Name of the ledger's file, without `.toml`.

    Raises
    ------
    ValueError
        If there is no such paper, or its ledger is malformed.
    """
    files = {file.stem: file for file in store.data_path("papers").glob("*.toml")}
    if key not in files:
        raise ValueError(f"there is no paper {key!r}; there are {', '.join(sorted(files))}")
    return read_paper(files[key])


def read_paper(file: Path) -> Paper:
    """Read a ledger from a file.

    Raises
    ------
    ValueError
        If the file is not TOML, a table or key is missing or unknown, a value has another type than `Paper`,
        `Claim` and `Assumption` declare, or a name occurs twice; the message names the file and the entry.
    """
    try:
        plain = tomllib.loads(file.read_text(encoding="utf-8"))
        if not {"paper"} <= plain.keys() <= {"paper", "claims", "assumptions"}:
            raise ValueError(f"has the tables {', '.join(plain)}; known are paper, claims and assumptions")
        paper = from_plain(plain["paper"], Paper)
        if paper.claims or paper.assumptions:
            raise ValueError("claims and assumptions are tables of their own, not within paper")
        claims = tuple(_entries("claims", plain, Claim))
        assumptions = tuple(_entries("assumptions", plain, Assumption))
        paper = replace(paper, claims=claims, assumptions=assumptions)
        if paper.key != file.stem:
            raise ValueError(f"has the key {paper.key!r}; it must be the file's name, {file.stem!r}")
    except ValueError as error:
        raise ValueError(f"{file.name}: {error}") from error
    return paper


_Entry = TypeVar("_Entry", Claim, Assumption)


def _entries(name: str, plain: dict[str, Any], kind: type[_Entry]) -> Iterator[_Entry]:
    for number, entry in enumerate(plain.get(name, ()), start=1):
        try:
            yield from_plain(entry, kind)
        except ValueError as error:
            label = entry.get("id", number) if isinstance(entry, dict) else number
            raise ValueError(f"{name} {label!r}: {error}") from error


def _require_id(name: str) -> None:
    if not re.fullmatch(r"[a-z0-9]+(-[a-z0-9]+)*", name):
        raise ValueError(f"id is {name!r}; it must be small letters and digits, joined by hyphens")


def _require_text(**texts: str) -> None:
    empty = [name for name, text in texts.items() if not text.strip()]
    if empty:
        raise ValueError(f"{', '.join(empty)} must not be empty")


def _require_unique(names: Iterable[str]) -> None:
    twice = [name for name, count in Counter(names).items() if count > 1]
    if twice:
        raise ValueError(f"the id {', '.join(twice)} occurs more than once")


def _named(name: str, entries: Sequence[_Entry], complaint: str) -> _Entry:
    by_name = {entry.id: entry for entry in entries}
    if name not in by_name:
        nearest = difflib.get_close_matches(name, by_name, cutoff=0.0)
        raise ValueError(f"{complaint} {name!r}; the nearest are {', '.join(nearest) or 'none'}")
    return by_name[name]
