"""Verdicts on the networks of paper C.

The rows of its tables are judged by its network at a smaller size after more steps: with the paper's epochs and
batches it learns next to nothing.
"""

from __future__ import annotations

from collections.abc import Iterator

import pandas as pd

from dexterity_study.claims.judge import Judge
from dexterity_study.claims.outcome import Acceptance, Verdict
from dexterity_study.engine.evidence import Evidence
from dexterity_study.engine.table import Table
from dexterity_study.page.numbers import with_range
from dexterity_study.workspace.estimation import experiment as ways
from dexterity_study.workspace.estimation.experiment import HEADS, LONGER, SCORES, THRESHOLDS

ACCEPTABLE = {"confidence": 1 / 3, "estimation": 1 / 10}
"""Share of the best constant's loss below which an optimiser has converged."""


def verdicts(evidence: Evidence) -> Iterator[Verdict]:
    """Judge the claims of the chapter."""
    on, trainings, optimisers = Judge("liao2018"), evidence["trainings"], evidence["optimisers"]
    yield on.misprint(
        "cross-entropy",
        "The term for poses out of reach is missing. Without it a network that always says yes has no loss, and the "
        "precision that Table VI prints is not that of such a network.",
    )
    note = "The paper writes infinities into the Jacobian; they take as much memory as numbers."
    yield on.refuted("gate-saves-memory", note)
    note = "As printed the step has no sign of the gradient; in use is the mean of the gradients."
    yield on.refuted("update-rule-adamax", note)
    yield on.not_run("update-rules", "Trainings use the rules of torch, which correct the bias of the means.")
    yield on.not_run("scaling-accelerates", "All networks here have scaled inputs and targets.")
    yield from _on_tables(on, trainings)
    yield from _on_seeds(on, trainings, optimisers.where(head="estimation")["constant"].iloc[0])
    yield from _on_optimisers(on, optimisers)


def acceptance(evidence: Evidence) -> Iterator[Acceptance]:
    """Figures that must hold for the book to be accepted, medians over the seeds."""
    for name, metric, way, limit in (
        ("wrong answers of the best confidence head", "accuracy_0.5", ways.BEST, 0.008),
        ("its MCC from 1", "correlation_0.5", ways.BEST, 0.017),
        ("variance left with a rotation matrix", "r2", ways.PLAIN, 0.01),
        ("variance left in the plane of the arm", "r2", ways.BEST, 0.003),
    ):
        yield Acceptance(name, 1 - evidence["trainings"].values(metric, way=way).median(), limit)


def with_constants(values: pd.Series, each: float) -> pd.Series:
    """Return means over all entries but zeros, where each constant one counts so much."""
    return (ways.ENTRIES * values + ways.CONSTANT_ENTRIES * each) / (ways.ENTRIES + ways.CONSTANT_ENTRIES)


NOTES = {
    "threshold-trades": "So it is for any network.",
    "threshold-75-best": "By the MCC. It depends on the share of poses in reach, which the paper implies to be smaller.",
    "regularisation": "By R², at this size and with this many rows; batch normalisation is in both networks.",
    "pretraining-looks-bad": "R² on held-out rows; the head is trained with the encoder from the first step on.",
    "confidence-converges-slower": "To half of its loss's fall. The confidence head starts on a trained encoder.",
    "cycle-prevents-overfitting": "Two networks that share nothing do better than with one encoder trained by one head.",
    "cycles-show": "Share of the cycles that begin with a higher confidence loss than the one before ended with.",
}
"""Reasons of the verdicts that go by the share of the seeds."""

PAPERS_NETWORK = "The paper's way at a smaller size with more steps."


def _on_tables(on: Judge, table: Table) -> Iterator[Verdict]:
    other = {"chosen": "estimation-scores=constants-as-ones"}
    parts = []
    for metric, each in {"absolute": 0, "squared": 0, "explained": 1, "r2": 1}.items():
        values = table.values(metric, way=LONGER)
        ones = with_constants(values, each).rename(index=other, level="reading")
        parts.append(pd.concat([values, ones]))
    ceiling = ways.ENTRIES / (ways.ENTRIES + ways.CONSTANT_ENTRIES)
    meant = on.printed("estimation-network")[-1] / ceiling
    note = f"If constant entries count nothing in R², its ceiling is {ceiling:.2f}, and the printed one means {meant:.3f}."
    yield on("estimation-network", parts, f"{PAPERS_NETWORK} {note}", form="{:.3f}")
    for t in THRESHOLDS:
        own = {score: table.values(f"{score}_{t:g}", way=LONGER) for score in SCORES}
        row, percent = [own["accuracy"], 1 - own["accuracy"], own["correlation"]], f"{100 * t:g}"
        # With the threshold 0.25 the MCC is printed to another digit and is a claim of its own.
        if t == 0.25:
            yield on("correlation-network-25", row.pop(), PAPERS_NETWORK, form="{:.3f}")
        yield on(f"confidence-network-{percent}", row, PAPERS_NETWORK, form="{:.3f}")
        retrieval = [own["precision"], own["recall"]]
        yield on(f"retrieval-network-{percent}", retrieval, PAPERS_NETWORK, form="{:.3f}")


def _on_seeds(on: Judge, table: Table, constant: float) -> Iterator[Verdict]:
    def by_threshold(score: str) -> pd.DataFrame:
        own = [table.values(f"{score}_{t:g}", way=LONGER) for t in THRESHOLDS]
        return pd.concat(own, axis=1, keys=THRESHOLDS)

    precision, recall, correlation = map(by_threshold, ("precision", "recall", "correlation"))
    rising = (precision.diff(axis=1).iloc[:, 1:] >= 0).all(axis=1)
    best, worst = correlation.idxmax(axis=1), correlation.idxmin(axis=1)
    dropped, kept = (table.values("r2", way=way) for way in (LONGER, ways.UNDROPPED))
    dropped, kept = dropped.align(kept, join="inner")
    early = 1 - table.values("before_cycles", way=LONGER) / constant
    slow, fast = (table.values(f"{head}_to_half", way=LONGER) for head in HEADS)
    cycled, apart = (table.values("accuracy_0.5", way=way) for way in (LONGER, ways.COLUMNS))
    returns = table.values("returns", way=LONGER)
    for claim, holds, ours in (
        ("threshold-trades", rising & (recall[0.75] <= recall[0.25]), ("precision", *precision.items())),
        ("threshold-75-best", (best == 0.75) & (worst == 0.25), ("", ("best", best), ("worst", worst))),
        ("regularisation", dropped > kept, ("R²", ("dropout", dropped), ("none", kept))),
        ("pretraining-looks-bad", early < 0.5, ("", ("R²", early))),
        ("confidence-converges-slower", slow > fast, ("epochs", *zip(HEADS, (slow, fast), strict=True))),
        ("cycle-prevents-overfitting", cycled > apart, ("accuracy", ("cycles", cycled), ("apart", apart))),
        ("cycles-show", returns > 0.5, ("", ("share", returns))),
    ):
        what, *parts = ours
        told = ", ".join(f"{name}: {with_range(values, '{:.3g}')}" for name, values in parts)
        yield on(claim, holds, NOTES[claim], ours=f"{what} {told}".strip())


def _on_optimisers(on: Judge, table: Table) -> Iterator[Verdict]:
    by: dict[str, pd.DataFrame] = {head: table.where(head=head).set_index("optimiser") for head in HEADS}
    ranked = by["confidence"]["left"].sort_values().index
    ends = {"Adamax ends best": ranked[0] == "Adamax", "SGD ends worst": ranked[-1] == "SGD"}
    yield on("adamax-best-sgd-worst", ends, f"One seed, from best to worst: {', '.join(ranked)}.")
    for claim, head, wanted, among in (
        ("sgd-steadiest-in-confidence", "confidence", "SGD", list(ranked)),
        ("rmsprop-steadiest-in-estimation", "estimation", "RMSprop", ["RMSprop", "Adamax", "Adam"]),
    ):
        rises = by[head]["rises"][among]
        ours = f"{rises.idxmin()} {rises.min():.2g}; {wanted} {rises[wanted]:.2g}"
        note = "By rises of the loss over its fall; one seed."
        yield on(claim, [rises.idxmin() == wanted], note, ours=ours)
    for claim, head, names, holds in (
        ("adamax-and-sgd-acceptable", "confidence", ("Adamax", "SGD"), True),
        ("adam-unsteady-in-confidence", "confidence", ("Adam", "Nadam", "RMSprop"), False),
        ("nadam-and-adagrad-good-in-confidence", "confidence", ("Nadam", "Adagrad", "SGD"), True),
        ("rmsprop-adamax-adam-converge", "estimation", ("RMSprop", "Adamax", "Adam"), True),
        ("nadam-adagrad-sgd-fail", "estimation", ("Nadam", "Adagrad", "SGD"), False),
    ):
        good = by[head]["left"] < ACCEPTABLE[head]
        cases = {name: bool(good[name]) == holds for name in names}
        note = f"Acceptable is a loss below {ACCEPTABLE[head]:.2g} of the best constant's; one seed."
        yield on(claim, cases, note, ours=f"acceptable: {', '.join(good.index[good]) or 'none'}")
