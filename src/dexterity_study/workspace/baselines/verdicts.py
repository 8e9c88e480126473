"""Verdicts on the other methods of paper C.

A method that got a part of the rows, or fewer rounds than in the authors' public benchmark, does not stand for the
printed row: that is not run. Nor does a small network stand for the paper's.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

import numpy as np
import pandas as pd

from dexterity_study.claims.judge import Judge
from dexterity_study.claims.outcome import Acceptance, Verdict
from dexterity_study.engine.evidence import Evidence
from dexterity_study.workspace.baselines.experiment import CLASSIFIERS, PARTS, REGRESSORS, TARGETS, THRESHOLDS

ALIKE = 0.01
"""Largest difference of two accuracies that are called alike."""

SCORES = ["JSC", "0-1", "MCC", "Prec.", "Rec."]
ERRORS = ["MAE", "MSE", "EVS", "R²"]
SMALL = "The paper's network was not trained at its size and for its epochs. Beside it, a small network on its columns has"

FEWER_ROUNDS = {
    "AdaBoosted DT": "The public benchmark has 200 stumps, and 50 were run",
    "LightGBM": "The public benchmark has up to 5,000 rounds at a rate of 0.02 with 76 leaves, and 100 at 0.1 with 31 were run",
}
"""Methods that were run with fewer rounds than in the authors' public benchmark."""

PART_OF_ROWS = {
    "Decision Tree": "all rows",
    "Gauss. Process": "9,999 rows",
    "k-NN": "all rows",
}
"""Methods of Table VII that got a part of the rows, and what the public benchmark has."""


def verdicts(evidence: Evidence) -> Iterator[Verdict]:
    """Judge the claims of the chapter; scores count the constant targets, as the printed ones do."""
    on = Judge("liao2018")
    by_score, by_error = scores(evidence), errors(evidence)
    yield from _on_networks(on, by_score, by_error)
    yield from _on_orders(on, evidence)
    for name, (key, _) in CLASSIFIERS.items():
        for part, columns in ((f"confidence-{key}", SCORES[:3]), (f"retrieval-{key}", SCORES[3:])):
            own, equal = _of(by_score, name, columns, "test-classes=equal", "{:.3f}")
            note = f"{_training_rows(evidence, name)}. With equal classes: {equal}."
            if missing := _not_as_published(name):
                ours = ", ".join(f"{column.loc['chosen'].median():.3f}" for column in own)
                yield on.not_run(part, f"{missing}, which gives {ours}. {note}")
            else:
                yield on(part, own, note, form="{:.3f}")
    for name, (key, _) in REGRESSORS.items():
        chosen = _chosen(by_error, [name]).median(numeric_only=True)
        # The variance of the Gaussian process is printed to other digits, and is a claim of its own.
        columns = ERRORS if name != "Gauss. Process" else [head for head in ERRORS if head != "EVS"]
        own, alone = _of(by_error, name, columns, "baseline-inputs=each-set", "{:.4f}")
        note = (
            f"{chosen['rows']:,.0f} training rows. Over the targets that vary, R² is "
            f"{chosen['R² of what varies']:.3f}. With a test set scaled by itself: {alone}."
        )
        if name in PART_OF_ROWS:
            ours = ", ".join(f"{column.loc['chosen'].median():.4f}" for column in own)
            missing = f"The public benchmark has {PART_OF_ROWS[name]}. A part of them gives {ours}"
            yield on.not_run(f"estimation-{key}", f"{missing}. {note}")
        else:
            yield on(f"estimation-{key}", own, note, form="{:.4f}")
    varying = _chosen(by_error, ["Gauss. Process"])["EVS of what varies"].median()
    yield on.not_run(
        "variance-gaussian-process",
        f"The public benchmark has {PART_OF_ROWS['Gauss. Process']}. A part of them gives {varying:.3f} over the targets "
        "that vary. A constant target has 1 or 0, depending on whether zero is predicted to the last digit.",
    )


def acceptance(evidence: Evidence) -> Iterator[Acceptance]:
    """Figures that must hold for the book to be accepted."""
    own = evidence["estimation"].where(method="RidgeReg.")
    varying, constant = TARGETS["tool"]
    expected = (varying * own["determination_of_varying"] + constant) / (varying + constant)
    gap = (own["determination"] - expected).abs().max()
    yield Acceptance("R² of ridge regression by both ways of counting", gap, 1e-9)


def _on_networks(on: Judge, by_score: pd.DataFrame, by_error: pd.DataFrame) -> Iterator[Verdict]:
    scored, most = _chosen(by_score, THRESHOLDS)["JSC"], _chosen(by_score, CLASSIFIERS)["JSC"].max()
    confidence = (
        f"a JSC of {scored.min():.3f} to {scored.max():.3f}, the best of the other methods {most:.3f}"
    )
    mean, least = _chosen(by_error, ["NN"])["MSE"].iloc[0], _chosen(by_error, REGRESSORS)["MSE"].min()
    estimation = f"an MSE of {mean:.4f}, the best of the other methods {least:.4f}"
    yield on.not_run("more-accurate", f"{SMALL} {confidence}; and {estimation}.")
    yield on.not_run("networks-first-in-confidence", f"{SMALL} {confidence}.")
    yield on.not_run("network-first-in-estimation", f"{SMALL} {estimation}.")


def _on_orders(on: Judge, evidence: Evidence) -> Iterator[Verdict]:
    rows = _chosen(scores(evidence), CLASSIFIERS)
    # The slow methods have the first seed only.
    accuracy = rows.pivot(index="seed", columns="method", values="JSC").ffill()
    ours = ", ".join(f"{name} {value:.3f}" for name, value in accuracy.median().nlargest(3).items())
    note = f"{_not_as_published('LightGBM')}. The SVM gets a part of the rows: {_training_rows(evidence, 'SVM(RBF)')}."
    yield on.not_run("lightgbm-second", f"{note} As run the order is {ours}.")
    linear = accuracy[["SVM(Lin. L2)", "LogisticReg.", "RidgeReg.(0.5)"]]
    apart = linear.max(axis=1) - linear.min(axis=1)
    worse = accuracy.drop(columns=[*linear.columns, "SVM(Sigmoid)"]).lt(linear.max(axis=1), axis=0)
    alike = (apart <= ALIKE) & ~worse.any(axis=1)
    note = (
        f"Accuracies, at most {apart.max():.3f} apart, and the worst but for the SVM with a sigmoid kernel, which is left "
        "out: it gets a part of the rows. Poses in reach are no half space."
    )
    ours = ", ".join(linear.median().map("{:.3f}".format))
    yield on("linear-models-alike", alike.to_numpy(), note, ours=ours)
    rivals = evidence["estimation"].by_seed("determination", over="method")
    tree = rivals.pop("Decision Tree")
    lowest = rivals.min(axis=1)
    note = (
        f"The public benchmark gives tree and k-NN all rows. With a part of them the tree has an R² of "
        f"{tree.median():.3f}, and the lowest of the other methods is {lowest.min():.3f}. A tree answers with a single "
        "row, whose own variance adds to the variance of the target."
    )
    yield on.not_run("tree-worst-in-estimation", note)
    # From the printed numbers alone.
    keys = [key for key, _ in CLASSIFIERS.values()]
    printed = [(*on.printed(f"confidence-{key}"), *on.printed(f"retrieval-{key}")) for key in keys]
    right, loss, _, precision, recall = np.array(printed).T
    gap = right - 1 / (1 / precision + 1 / recall - 1)
    yield on.refuted(
        "jaccard",
        "By the paper's own numbers JSC is the share of right answers: JSC and 0-1 loss add up to one within "
        f"{np.abs(right + loss - 1).max():.3f} in all rows, and a Jaccard coefficient by precision and recall "
        f"is {gap.min():.3f} to {gap.max():.3f} less.",
    )


def scores(evidence: Evidence) -> pd.DataFrame:
    """Return the scores of all methods of Table VI under all readings, with the most rows, by the table's columns.

    Precision and recall of the other class are a reading that needs no run of its own.
    """
    runs = ("confidence", "slow_confidence", "confidence_network")
    rows = pd.concat([evidence[name].where(None) for name in runs])
    rows = rows.drop_duplicates(["reading", "seed", "method"], keep="last")
    other = rows[rows["reading"] == "chosen"].assign(reading="positive-class=out-of-reach")
    other["hits"] = 1 - other[["hits", "misses", "false_alarms"]].sum(axis=1)
    rows = pd.concat([rows, other.rename(columns={"misses": "false_alarms", "false_alarms": "misses"})])
    hits, misses, alarms = rows["hits"], rows["misses"], rows["false_alarms"]
    rest = 1 - hits - misses - alarms
    sides = (hits + alarms) * (hits + misses) * (rest + alarms) * (rest + misses)
    own = {
        "JSC": hits + rest,
        "0-1": misses + alarms,
        "MCC": (hits * rest - misses * alarms) / np.sqrt(sides),
    }
    own |= {"Prec.": hits / (hits + alarms), "Rec.": hits / (hits + misses)}
    return rows.assign(**own).reset_index(drop=True)


def errors(evidence: Evidence) -> pd.DataFrame:
    """Return the errors and scores of all methods of Table VII under all readings, by the table's columns."""
    names = ("absolute", "squared", "explained", "determination")
    heads = dict(zip(names, ERRORS, strict=True))
    heads |= {f"{name}_of_varying": f"{heads[name]} of what varies" for name in names[2:]}
    network = evidence["estimation_network"].where().assign(method="NN")
    return pd.concat([network, evidence["estimation"].where(None)], ignore_index=True).rename(columns=heads)


def _chosen(rows: pd.DataFrame, methods: Iterable[str]) -> pd.DataFrame:
    return rows[(rows["reading"] == "chosen") & rows["method"].isin(list(methods))]


def _of(
    rows: pd.DataFrame, method: str, columns: Sequence[str], reading: str = "chosen", form: str = "{:.3f}"
) -> tuple[list[pd.Series], str]:
    """Return columns of a method over readings and seeds, and their medians in one reading as text."""
    own = rows[rows["method"] == method].set_index(["reading", "seed"])[list(columns)]
    return [own[column] for column in columns], ", ".join(map(form.format, own.loc[[reading]].median()))


def _not_as_published(name: str) -> str:
    """Say what a classifier lacks of the authors' public benchmark; empty if it has its rows and rounds."""
    if name in FEWER_ROUNDS:
        return FEWER_ROUNDS[name]
    return f"A part of the rows was run, at most {max(PARTS[name]):,}" if name in PARTS else ""


def _training_rows(evidence: Evidence, name: str) -> str:
    """Say how many rows a classifier was trained on; if it gets a part of them, how accurate it is with fewer."""
    rows = evidence["slow_confidence" if name in PARTS else "confidence"].where(method=name)
    accuracy = (1 - rows["misses"] - rows["false_alarms"]).groupby(rows["rows"]).median()
    fewer = ", ".join(f"{count:,}: {value:.3f}" for count, value in accuracy.iloc[:-1].items())
    return f"{accuracy.index[-1]:,} training rows" + (f"; accuracy with {fewer}" if fewer else "")
