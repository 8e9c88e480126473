"""Verdicts of the chapter on the indices of the library: no claim of a ledger belongs to it."""

from dexterity_study.claims.outcome import Acceptance, Verdict
from dexterity_study.engine.evidence import Evidence


def verdicts(_: Evidence) -> tuple[Verdict, ...]:
    """Judge nothing."""
    return ()


def acceptance(stored: Evidence) -> tuple[Acceptance, ...]:
    """Require that compiled indices agree with autograd, and peers with the library."""
    agreement, peers = stored["agreement"].rows, stored["peers"].rows
    return (
        Acceptance("compiled values, largest deviation", agreement["value"].max(), 1e-9),
        Acceptance("compiled gradients, largest deviation", agreement["gradient"].max(), 1e-9),
        Acceptance("other packages, largest deviation", peers["deviation"].max(), 1e-9),
    )
