"""Outcomes and verdicts: what became of a claim."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum


class Outcome(StrEnum):
    """What became of a claim; `judge.RULES` says what each word needs."""

    REPRODUCED = "reproduced"
    IN_SHAPE = "in shape"
    LOGGED = "as logged"
    FITTED = "fitted"
    NOT_REPRODUCED = "not reproduced"
    CONTRADICTED = "contradicted"
    UNDERSPECIFIED = "underspecified"
    MISPRINT = "misprint"
    NOT_RUN = "not run"
    OUT_OF_SCOPE = "out of scope"


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


@dataclass(frozen=True)
class Verdict:
    """Judgement of a claim.

    Attributes
    ----------
    paper
        Key of the paper.
    claim
        Id of the claim.
    outcome
        What became of it.
    ours
        Our value, with its unit where it has one; empty where there is nothing to measure.
    spread
        Range of our value, and over what; empty where it does not vary.
    sentence
        Reason, in one sentence.
    readings
        Share of the admissible readings in which the claim holds, in words; empty where only one was run.
    flips
        Names of the readings whose grade is on the other side of the chosen one's.
    design
        Share of the readings of a space-filling design in which the claim holds, in words; empty where none was run.
    """

    paper: str
    claim: str
    outcome: Outcome
    ours: str = ""
    spread: str = ""
    sentence: str = ""
    readings: str = ""
    flips: tuple[str, ...] = ()
    design: str = ""
