"""Verdicts on the networks of paper C.

Its networks were not trained at their size and for their epochs, and no smaller network stands for them: what needs
them is not run. What the text says of optimisers and cycles describes trainings whose logs the authors published; it
is judged on these logs, on the training loss that the text speaks of.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from dexterity_study.claims.judge import Judge
from dexterity_study.claims.outcome import Acceptance, Verdict
from dexterity_study.engine.evidence import Evidence
from dexterity_study.engine.readings import Reading
from dexterity_study.engine.table import Table
from dexterity_study.workspace.estimation import experiment as ways
from dexterity_study.workspace.estimation import logs

READING: Mapping[str, Any] = Reading.chosen("liao2018")

ACCEPTABLE: float = READING["steadiness"]
"""Share of the best constant's loss below which a loss is acceptable."""

SMALLER = (
    "The paper's network was not trained at its size and for its epochs; a smaller one does not stand for it."
)


def verdicts(evidence: Evidence) -> Iterator[Verdict]:
    """Judge the claims of the chapter."""
    on = Judge("liao2018")
    yield on.misprint(
        "cross-entropy",
        "The term for poses out of reach is missing. Without it a network that always says yes has no loss, and the "
        "precision that Table VI prints is not that of such a network.",
    )
    note = "As printed the step has no sign of the gradient; in use is the mean of the gradients."
    yield on.refuted("update-rule-adamax", note)
    yield on.not_run("update-rules", "Trainings use the rules of torch, which correct the bias of the means.")
    yield on.not_run("scaling-accelerates", "All networks here have scaled inputs and targets.")
    yield _on_the_gate(on, evidence["trainings"])
    yield from _on_tables(on)
    yield from _on_cycles(on)
    yield from _on_optimisers(on)


def acceptance(evidence: Evidence) -> Iterator[Acceptance]:
    """Figures that must hold for the book to be accepted, medians over the seeds."""
    for name, metric, way, limit in (
        ("wrong answers of the best confidence head", "accuracy_0.5", ways.BEST, 0.008),
        ("its MCC from 1", "correlation_0.5", ways.BEST, 0.017),
        ("variance left with a rotation matrix", "r2", ways.PLAIN, 0.01),
        ("variance left in the plane of the arm", "r2", ways.BEST, 0.003),
    ):
        yield Acceptance(name, 1 - evidence["trainings"].values(metric, way=way).median(), limit)


def _on_the_gate(on: Judge, table: Table) -> Verdict:
    """Judge what the gate saves where the Jacobians that it refuses are dropped, and where they are infinite."""
    saved = 1 - table.values("given", way=ways.BEST)
    infinite, finite = np.full((6, 6), np.inf).nbytes, np.zeros((6, 6)).nbytes
    cases = {
        "refused poses dropped": bool((saved > 0).all()),
        "infinite Jacobians, as in Eq. 11": infinite < finite,
    }
    note = (
        f"Dropped poses save {saved.median():.0%} of the memory of the Jacobians, at the share of poses in reach of our "
        "sets. A Jacobian of infinities takes as much memory as one of numbers."
    )
    return on("gate-saves-memory", cases, note)


def _on_tables(on: Judge) -> Iterator[Verdict]:
    log, ceiling = logs.load()["estimation-750"], ways.ENTRIES / (ways.ENTRIES + ways.CONSTANT_ENTRIES)
    (epoch, last), printed = log.validation[-1], on.printed("estimation-network")
    variance = on.printed("estimation-ridge-regression")[1]
    note = (
        f"{SMALLER} The authors' log of this network ends at a validation loss of {last:g} after {epoch:g} epochs; printed "
        f"is {printed[1]:g}, on test rows scaled by themselves. Of the mean variance {variance:g}, which is the printed "
        f"error of ridge regression, that is {printed[1] / variance:.1%}. The printed R² is lower because the two "
        f"constant entries count nothing in it: its ceiling is {ceiling:.2f}, and it means {printed[3] / ceiling:.3f} "
        "over the entries that vary."
    )
    yield on.not_run("estimation-network", note)
    for claim in (
        "confidence-network-50", "confidence-network-75", "confidence-network-25", "correlation-network-25",
        "retrieval-network-50", "retrieval-network-25", "retrieval-network-75",
    ):  # fmt: skip
        yield on.not_run(claim, SMALLER)
    note = f"{SMALLER} A recall cannot rise with the threshold; a precision can fall."
    yield on.not_run("threshold-trades", note)
    note = f"{SMALLER} The order depends on the share of poses in reach."
    yield on.not_run("threshold-75-best", note)
    note = (
        f"{SMALLER} By the authors' log a network with dropout learns: its training loss falls from {log.constant:g}, that "
        f"of a constant, to {dict(log.training)[25]:.2g} in 25 epochs. No log is without dropout."
    )
    yield on.not_run("regularisation", note)


def _on_cycles(on: Judge) -> Iterator[Verdict]:
    by = logs.load()
    before, first, last = (
        by["combined-pretraining"],
        by["combined-confidence-1"],
        by["combined-confidence-15"],
    )
    tuned, alone = by["combined-estimation-15"], by["confidence-adam"]
    left = before.left_in_validation
    note = (
        f"Logged: after the encoder's {before.validation[-1][0]:g} epochs the validation loss of the estimation is "
        f"{left:.0%} of the best constant's."
    )
    yield on.logged("pretraining-looks-bad", [left > 0.5], note, told=f"R² near {1 - left:.2f}")
    single = {head: by[f"{head}-adam"].training[0] for head in ("confidence", "estimation")}
    shares = {head: loss / by[f"{head}-adam"].constant for head, (_, loss) in single.items()}
    cases = {
        "combined model, after its last cycle": last.left > tuned.left,
        "single networks, after 25 epochs": shares["confidence"] > shares["estimation"],
    }
    note = (
        f"Logged training losses, in shares of the best constant's: {last.left:.0%} in confidence and {tuned.left:.0%} in "
        f"estimation after the last cycle; {shares['confidence']:.0%} and {shares['estimation']:.0%} in single networks."
    )
    yield on.logged("confidence-converges-slower", cases, note)
    (_, early), (_, late) = first.validation[-1], last.validation[-1]
    best = min(loss for _, loss in alone.validation)
    cases = {"estimation": tuned.left_in_validation < left, "confidence": late < early}
    note = (
        f"Logged validation losses, whether they fall over the cycles. Confidence rises from {early:g} after the first to "
        f"{late:g} after the last; the single network is at {best:g} after 50 epochs. Sharing the encoder hurts."
    )
    yield on.logged("cycle-prevents-overfitting", cases, note)
    (_, begins), (_, ends) = by["combined-confidence-extremes"].training
    note = (
        f"Logged: each of the {last.cycle} cycles begins with a new confidence head, at a training loss of at least "
        f"{begins:g}, and ends at {ends:g} or less."
    )
    yield on.logged("cycles-show", [begins > ends], note)


def _on_optimisers(on: Judge) -> Iterator[Verdict]:
    confidence, estimation = logs.by_optimiser("confidence"), logs.by_optimiser("estimation")
    ranked = sorted(confidence, key=lambda name: confidence[name].left)
    ends = {"Adamax ends best": ranked[0] == "Adamax", "SGD ends worst": ranked[-1] == "SGD"}
    note = f"Logged training losses. {_listed(confidence, ranked[0], ranked[-2], ranked[-1])}."
    yield on.logged("adamax-best-sgd-worst", ends, f"{note} {_in_validation(confidence, 'Adamax', 'SGD')}")
    rises = {name: log.rises for name, log in confidence.items() if log.rises is not None}
    note = (
        "Logged: rises of the training loss over its fall. RMSprop has the same to two digits; the other four have "
        f"{sorted(rises.values())[2]:.1f} and more."
    )
    yield on.logged(
        "sgd-steadiest-in-confidence", [rises["SGD"] <= min(rises.values())], note, told=f"{rises['SGD']:.1f}"
    )
    note = "The logs are known at some epochs only, which do not show all rises."
    yield on.not_run("rmsprop-steadiest-in-estimation", note)
    names: tuple[str, ...] = ("Adam", "Nadam", "RMSprop")
    unsteady = {name: rises[name] > 1 for name in names}
    note = (
        "Logged: unsteady where the training loss rises by more than it falls in all. "
        f"{', '.join(f'{name}: {rises[name]:.1f}' for name in names)}. {_in_validation(confidence, *names)}"
    )
    yield on.logged("adam-unsteady-in-confidence", unsteady, note)
    for claim, by, names, good in (
        ("adamax-and-sgd-acceptable", confidence, ("Adamax", "SGD"), True),
        ("nadam-and-adagrad-good-in-confidence", confidence, ("Nadam", "Adagrad", "SGD"), True),
        ("rmsprop-adamax-adam-converge", estimation, ("RMSprop", "Adamax", "Adam"), True),
        ("nadam-adagrad-sgd-fail", estimation, ("Nadam", "Adagrad", "SGD"), False),
    ):
        cases = {name: (by[name].left < ACCEPTABLE) == good for name in names}
        note = (
            f"Logged training losses after {logs.EPOCHS} epochs, in shares of the best constant's: {_listed(by, *names)}. "
            f"Acceptable is less than {ACCEPTABLE:.2g}. {_in_validation(by, *names)}"
        )
        yield on.logged(claim, cases, note)


def _listed(by: Mapping[str, logs.Log], *names: str) -> str:
    return ", ".join(f"{name}: {by[name].left:.1%}" for name in names)


def _in_validation(by: Mapping[str, logs.Log], *names: str) -> str:
    shares = ", ".join(f"{name}: {by[name].left_in_validation:.0%}" for name in names)
    return f"In validation, {shares}."
