"""Verdicts of the chapter on proved bounds: no claim of a ledger belongs to it."""

from dexterity_study.claims.outcome import Acceptance, Verdict
from dexterity_study.engine.evidence import Evidence


def verdicts(_: Evidence) -> tuple[Verdict, ...]:
    """Judge nothing."""
    return ()


def acceptance(stored: Evidence) -> tuple[Acceptance, ...]:
    """Require a close bound for the network, in an hour, and that every part that was tried is proved again."""
    network, checked = stored["proofs"].where(approximation="network"), stored["checked"].rows
    return (
        Acceptance("proved bound of the network for w", network["bound"].min(), 0.0026),
        Acceptance("time of its longest proof [s]", network["seconds"].max(), 3600),
        Acceptance("parts not proved again", (checked["tried"] - checked["confirmed"]).sum(), 0),
        Acceptance(
            "rounding of the network in double precision", stored["evaluation"].rows["rounding"].max(), 1e-11
        ),
    )
