"""Verdicts of the chapter on unprinted settings: its readings are shares of the verdicts of other chapters."""

from dexterity_study.claims.outcome import Acceptance, Verdict
from dexterity_study.engine.evidence import Evidence


def verdicts(_: Evidence) -> tuple[Verdict, ...]:
    """Judge nothing."""
    return ()


def acceptance(_: Evidence) -> tuple[Acceptance, ...]:
    """Ask for nothing."""
    return ()
