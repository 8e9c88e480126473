"""Verdicts on how the networks of paper D are trained, and how large they should be."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
import pandas as pd

from dexterity_study.claims.judge import Judge
from dexterity_study.claims.outcome import Acceptance, Verdict
from dexterity_study.crane.training.experiment import AT_ONCE, NETWORKS, SECOND_ORDER, lesson, reported_after
from dexterity_study.engine.evidence import Evidence
from dexterity_study.page.numbers import with_range

KEPT = [
    "back-propagation, row by row",
    "back-propagation, all rows at once",
    "Levenberg–Marquardt, sums alone",
    "Levenberg–Marquardt, Jacobian kept",
]
NEAR, LEARNED = 1.1, 0.1
"""Error over the least one up to which a size is best, and over the spread up to which a network has learned."""


def verdicts(evidence: Evidence) -> Iterator[Verdict]:
    """Judge the claims of the chapter."""
    on = Judge("rouvinen1999")
    whole = history(evidence, SECOND_ORDER)[0][-1]
    second = left(evidence, SECOND_ORDER)
    first, later = (
        min((left(evidence, mode, time) for mode in AT_ONCE), key=np.median) for time in (whole, math.inf)
    )
    numbers = memory(evidence)
    more = numbers.iloc[3] / numbers.iloc[1]
    note = f"Left after the same time is {with_range(second, '{:.2f}')} mm, against {with_range(first, '{:.2f}')} mm by the best back-propagation, and {with_range(later, '{:.2f}')} mm if that goes on. With the Jacobian kept it needs {more:.0f} times the numbers of back-propagation in a batch; summed up row by row it needs {numbers.iloc[2]:,}, whatever the data."
    ours = f"{np.median(first / second):.1f} times less error in the same time"
    yield on("crane-lm-is-better", (second < first) & (more > 1), note, ours=ours)

    thesis = pd.Series({name: on.printed(f"crane-{name}-neurons")[0] for name in NETWORKS})
    errors, rules = by_size(evidence), evidence["rules"]
    own = pd.DataFrame({name: errors.loc[name, thesis[name]] for name in NETWORKS}).T
    least, best = errors.groupby("network").min(), errors["test"].unstack("network").idxmin()
    rule = evidence["rule_size"].where().groupby("network").median(numeric_only=True)
    beyond = own["test"] / least["test"]
    note = f"Of the sizes tried the test error is least with {_both(best, '{:g}')} neurons; with {rule['neurons'].max():.0f} it is {_both(rule['test'] / least['test'])} times that. A size chosen by the test has {_both(regret(evidence, 'test'))} times the error on fresh points of the best size, one chosen by held-out poses {_both(regret(evidence, 'held_out'))}."
    ours = f"test error with the thesis's size over the least: {_both(beyond)}"
    yield on("crane-size-by-test-error", dict(beyond <= NEAR), note, ours=ours)

    counts = rules.where(network="direct").iloc[0]
    note = f"It asks for {counts['by_rows']} neurons where the thesis has {_both(thesis, '{:g}')}. Counting poses, since rows of one pose differ by a payload that acts linearly, it asks for {counts['by_poses']}."
    ours = f"held-out error with its size over that with the thesis's: {_both(rule['held_out'] / own['held_out'])}"
    yield on("crane-size-rule", dict(rule["held_out"] <= NEAR * least["held_out"]), note, ours=ours)

    off = own["held_out"] / pd.Series({name: _spread(name) for name in NETWORKS})
    wrong, every = (
        rules.where()["wrong"],
        rules.rows.pivot(index="network", columns="reading", values="wrong"),
    )
    both = every.loc[list(NETWORKS), rules.readings]
    needed = both.apply(lambda shares: (shares <= 1) | (off >= LEARNED)).unstack()
    note = f"None of the thesis's networks meets it: their rows would do for more wrong answers than all. Two of them answer held-out poses all the same, with errors of {_both(off, '{:.2g}')} of the spread. The bound is meant for answers of yes and no, and for the worst of all tasks."
    ours = f"share of errors for these rows: {wrong.min():.1f} to {wrong.max():.1f}"
    yield on("crane-size-bound", needed, note, ours=ours)


def acceptance(evidence: Evidence) -> Iterator[Acceptance]:  # noqa: ARG001 -- there is none
    """Figures that must hold for the book to be accepted."""
    yield from ()


def history(evidence: Evidence, way: str) -> tuple[np.ndarray, np.ndarray]:
    """Return times [s] and errors (seeds, times), or (seeds, gains, times) by back-propagation."""
    last = int(evidence["descent"].where(way=way)["passes"].iloc[0])
    passes = np.arange(last + 1) if way == SECOND_ORDER else reported_after(last)
    return passes * evidence["times"].where(way=way)["seconds"].item(), evidence["descent"].array(way)


def left(evidence: Evidence, way: str, time: float = math.inf) -> np.ndarray:
    """Return the errors (seeds) that a training has after a time, or in the end, with the gain that is best then."""
    times, errors = history(evidence, way)
    there = errors[..., min(int(np.searchsorted(times, time)), len(times) - 1)]
    return there if way == SECOND_ORDER else there[:, np.median(there, axis=0).argmin()]


def memory(evidence: Evidence) -> pd.Series:
    """Return the numbers that each way keeps besides the data and the weights."""
    own = evidence["rules"].where(network="correction").iloc[0]
    rows, neurons = own["rows"], own["neurons"]
    size = neurons * (4 + 1) + 2 * (neurons + 1)
    batch, sums = 2 * size + rows * (neurons + 2), 2 * size**2 + 2 * size
    return pd.Series([2 * size + neurons + 2, batch, sums, sums + 2 * rows * size], KEPT, name="numbers")


def by_size(evidence: Evidence) -> pd.DataFrame:
    """Return medians over the seeds by network and number of neurons."""
    return evidence["sizes"].where().groupby(["network", "neurons"]).median(numeric_only=True)


def regret(evidence: Evidence, metric: str) -> pd.Series:
    """Return by network the error on fresh points of the size with the least of a metric, over the best size's."""
    rows = evidence["sizes"].where()
    runs = rows.groupby(["network", "seed"])
    chosen = rows.loc[runs[metric].idxmin()].set_index(["network", "seed"])
    return (chosen["fresh"] / runs["fresh"].min()).groupby("network").median()


def _spread(name: str) -> float:
    truth = lesson(name)[1]
    return 1e3 * (truth - truth.mean(0)).norm(dim=-1).mean().item()


def _both(values: pd.Series, form: str = "{:.2f}") -> str:
    return ", ".join(f"{form.format(own)} ({name})" for name, own in values.items())
