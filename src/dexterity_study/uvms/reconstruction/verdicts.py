"""Verdicts of the chapter on unprinted settings: none before its design is complete."""

from dexterity_study.claims.outcome import Acceptance, Verdict
from dexterity_study.engine.evidence import Evidence


def verdicts(_: Evidence) -> tuple[Verdict, ...]:
    """Judge nothing yet."""
    return ()


def acceptance(_: Evidence) -> tuple[Acceptance, ...]:
    """Ask for nothing yet."""
    return ()
