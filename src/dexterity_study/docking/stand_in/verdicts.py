"""Verdicts of the chapter on a network for the area measure: no claim of a ledger belongs to it."""

from dexterity_study.claims.outcome import Acceptance, Verdict
from dexterity_study.engine.evidence import Evidence


def verdicts(_: Evidence) -> tuple[Verdict, ...]:
    """Judge nothing."""
    return ()


def acceptance(_: Evidence) -> tuple[Acceptance, ...]:
    """Require nothing."""
    return ()
