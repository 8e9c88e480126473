"""Readings of a paper: a value for each thing that it leaves open.

What a paper leaves open is an assumption in `data/papers/<key>/assumptions.toml`, with the value that was
chosen and the other admissible ones. A reading names one value for each; experiments are run under readings.
"""

import functools
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from datetime import datetime
from typing import Literal, TypeAlias

from dexterity import store
from dexterity_study.engine import strict

Scalar: TypeAlias = bool | int | float | str
Value: TypeAlias = Scalar | tuple[Scalar, ...] | tuple[tuple[Scalar, ...], ...]
Origin: TypeAlias = Literal["text", "toolbox", "physics", "fitted"]
"""Where a value comes from. It is the text of the paper, the software of its time, with its defaults and with what the
authors published of their own, geometry, units and what is physically sensible, or the numbers that the paper
prints, which it was chosen to fit."""


@dataclass(frozen=True)
class Alternative:
    """Another admissible value of an assumption.

    Attributes
    ----------
    name
        Name, unique in its assumption: letters and digits, joined by hyphens or dots.
    origin
        Source of the value.
    why
        Reason to admit it, half a sentence.
    value
        The value; None if the assumption has none.
    """

    name: str
    origin: Origin
    why: str
    value: Value | None = None

    def __post_init__(self) -> None:
        if self.name == "chosen" or not re.fullmatch(r"[A-Za-z0-9]+([.-][A-Za-z0-9]+)*", self.name):
            raise ValueError(
                f"an alternative has the name {self.name!r}; it must be letters and digits, joined by "
                "hyphens or dots, and not 'chosen'"
            )
        strict.require_text(why=self.why)


@dataclass(frozen=True)
class Assumption:
    """Something that a paper leaves open and that had to be chosen.

    Attributes
    ----------
    id
        Name, unique in its paper: small letters and digits, joined by hyphens.
    where
        Place in the paper where it is missing.
    missing
        What the paper leaves out.
    chapter
        Chapter that rests on it.
    chosen
        What is chosen, in words.
    why
        Reason, one sentence.
    origin
        Source of the choice.
    set
        Time of the commit in which it was first written down.
    by
        What set it: *declared*, before the first results of its chapter and with no result that bears on it; *known*,
        when results that bear on it were there; or *fitted* to printed values.
    basis
        The results that were known, or how the printed values were used, in a sentence; empty if it was declared.
    fits
        Ids of the claims and settings whose printed values it was fitted to.
    value
        What is chosen, for code; None if it is no variable of any code.
    alternatives
        Other admissible choices; they have values if the assumption has one.
    """

    id: str
    where: str
    missing: str
    chapter: str
    chosen: str
    why: str
    origin: Origin
    set: datetime
    by: Literal["declared", "known", "fitted"]
    basis: str = ""
    fits: tuple[str, ...] = ()
    value: Value | None = None
    alternatives: tuple[Alternative, ...] = ()

    def __post_init__(self) -> None:
        strict.require_id(self.id)
        strict.require_text(
            where=self.where, missing=self.missing, chapter=self.chapter, chosen=self.chosen, why=self.why
        )
        strict.require_unique(alternative.name for alternative in self.alternatives)
        if any((alternative.value is None) != (self.value is None) for alternative in self.alternatives):
            raise ValueError("the chosen and all alternatives have a value, or none has")
        values = (self.value, *(alternative.value for alternative in self.alternatives))
        strict.require_unique(f"the value {value!r}" for value in values if value is not None)
        self._check_what_set_it()

    def _check_what_set_it(self) -> None:
        if self.set.tzinfo is None:
            raise ValueError(f"set is {self.set}, which needs a time zone")
        if (self.by == "declared") != (not self.basis):
            raise ValueError(
                f"by is {self.by!r} and the basis is {self.basis!r}; all but what is declared needs one"
            )
        if not (self.by == "fitted") == (self.origin == "fitted") == bool(self.fits):
            raise ValueError(
                f"by is {self.by!r}, the origin {self.origin!r}, and fits {self.fits}; what is fitted has the origin "
                "'fitted' and names the printed values"
            )


@functools.cache
def assumptions(paper: str) -> tuple[Assumption, ...]:
    """Read the assumptions that a paper forces on its readers.

    Parameters
    ----------
    paper
        Key of the paper.

    Raises
    ------
    ValueError
        If the file is malformed; the message names it and the entry.
    FileNotFoundError
        If there is no such paper.
    """
    return strict.read_entries(store.data_path("papers", paper, "assumptions.toml"), Assumption)


@dataclass(frozen=True)
class Reading(Mapping[str, Value]):
    """A value for each assumption of a paper that has one, by the assumption's id.

    Attributes
    ----------
    paper
        Key of the paper; None for what rests on no paper, whose one reading is empty.
    exchanged
        Assumptions that have another value than the chosen one, by id, and the names of the alternatives.
    """

    paper: str | None
    exchanged: tuple[tuple[str, str], ...] = ()

    def __post_init__(self) -> None:
        strict.require_unique(name for name, _ in self.exchanged)
        if list(self.exchanged) != sorted(self.exchanged):
            raise ValueError(f"exchanged is {self.exchanged}; it must be sorted")
        for name, alternative in self.exchanged:
            others = _values(self.paper, name).keys() - {"chosen"}
            strict.require_known(alternative, others, f"assumption {name} has no alternative")

    @classmethod
    def chosen(cls, paper: str | None) -> "Reading":
        """Return the reading in which each assumption has the value that was chosen."""
        return cls(paper)

    @classmethod
    def of(cls, paper: str | None, name: str) -> "Reading":
        """Return the reading of a name.

        Parameters
        ----------
        paper
            Key of the paper, or None.
        name
            "chosen", or "assumption=alternative" for each that differs, joined by "+".

        Raises
        ------
        ValueError
            If the paper has no such assumption with a value, or that no such alternative; the message has the
            nearest names.
        """
        if name == "chosen":
            return cls(paper)
        pairs = [tuple(part.split("=")) for part in name.split("+")]
        if any(len(pair) != 2 for pair in pairs):
            raise ValueError(f"the reading is {name!r}; it must be 'chosen' or 'assumption=alternative+…'")
        return cls(paper, tuple(sorted((assumption, alternative) for assumption, alternative in pairs)))

    @property
    def name(self) -> str:
        """The name by which `of` returns this reading."""
        return "+".join("=".join(pair) for pair in self.exchanged) or "chosen"

    def __getitem__(self, assumption: str) -> Value:
        try:
            values = _values(self.paper, assumption)
        except ValueError as error:
            raise KeyError(str(error)) from error
        return values[dict(self.exchanged).get(assumption, "chosen")]

    def __iter__(self) -> Iterator[str]:
        return iter(_variables(self.paper))

    def __len__(self) -> int:
        return len(_variables(self.paper))

    def only(self, *assumptions: str) -> dict[str, Value]:
        """Return the values of some assumptions, as a parameter of a task."""
        return {name: self[name] for name in assumptions}


def _values(paper: str | None, assumption: str) -> dict[str, Value]:
    """Return all values of an assumption, by "chosen" and by the alternatives' names."""
    variables = _variables(paper)
    strict.require_known(assumption, variables, f"paper {paper} has no assumption with a value")
    entry = variables[assumption]
    named = {"chosen": entry.value} | {other.name: other.value for other in entry.alternatives}
    return {name: value for name, value in named.items() if value is not None}


@functools.cache
def _variables(paper: str | None) -> dict[str, Assumption]:
    """Return the assumptions that have a value, by id."""
    entries = assumptions(paper) if paper is not None else ()
    return {entry.id: entry for entry in entries if entry.value is not None}
