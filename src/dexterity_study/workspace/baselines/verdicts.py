"""Verdicts on the other methods of paper C."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

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
SMALL = "A small network on the paper's columns, with one seed, in place of the paper's"


def verdicts(evidence: Evidence) -> Iterator[Verdict]:
    """Judge the claims of the chapter; scores count the constant targets, as the printed ones do."""
    on = Judge("liao2018")
    yield from _on_networks(on, evidence)
    yield from _on_orders(on, evidence)
    yield _on_jaccard(on)
    rows = scores(evidence)
    for name, key in CLASSIFIERS.items():
        own = rows[rows["method"] == name]
        for part, columns in ((f"confidence-{key}", SCORES[:3]), (f"retrieval-{key}", SCORES[3:])):
            equal = _listed(own, "test-classes=equal", columns, "{:.3f}")
            note = f"{_training_rows(evidence, name)}. With equal classes: {equal}."
            yield on(part, _parts(own, columns), note, form="{:.3f}")
    for name, key in REGRESSORS.items():
        own = errors(evidence)
        yield from _on_regressor(on, own[own["method"] == name], key)


def acceptance(evidence: Evidence) -> Iterator[Acceptance]:
    """Figures that must hold for the book to be accepted."""
    own = evidence["estimation"].where(method="RidgeReg.")
    varying, constant = TARGETS["tool"]
    expected = (varying * own["determination_of_varying"] + constant) / (varying + constant)
    gap = (own["determination"] - expected).abs().max()
    yield Acceptance("R² of ridge regression by both ways of counting", gap, 1e-9)


def _on_networks(on: Judge, evidence: Evidence) -> Iterator[Verdict]:
    best = _chosen(scores(evidence), list(CLASSIFIERS)).groupby("seed")[["JSC", "MCC"]].max()
    networks = _chosen(scores(evidence), list(THRESHOLDS)).set_index("method")
    leads = best.lt(networks[["JSC", "MCC"]].min()).all(axis="columns").to_numpy()
    network = _chosen(errors(evidence), ["NN"])[ERRORS].iloc[0]
    rivals = _chosen(errors(evidence), list(REGRESSORS)).groupby("seed")
    first = (
        rivals[ERRORS[:2]]
        .min()
        .gt(network[ERRORS[:2]])
        .join(rivals[ERRORS[2:]].max().lt(network[ERRORS[2:]]))
    )
    is_first = first.all(axis="columns").to_numpy()
    yield on(
        "more-accurate", {"confidence": bool(leads.all()), "estimation": bool(is_first.all())}, f"{SMALL}."
    )
    yield on(
        "networks-first-in-confidence",
        leads,
        f"{SMALL}. JSC at the three thresholds; the best of the other methods has {best['JSC'].max():.3f}.",
        ours=", ".join(networks["JSC"].map("{:.3f}".format)),
    )
    yield on(
        "network-first-in-estimation",
        is_first,
        f"{SMALL}. {', '.join(ERRORS)}; the smallest MSE of the other methods is {rivals['MSE'].min().min():.4f}.",
        ours=", ".join(network.map("{:.4f}".format)),
    )


def _on_orders(on: Judge, evidence: Evidence) -> Iterator[Verdict]:
    rows = _chosen(scores(evidence), list(CLASSIFIERS))
    # The slow methods have the first seed only.
    accuracy = rows.pivot(index="seed", columns="method", values="JSC").ffill()
    order = [own.sort_values(ascending=False).index[:3].tolist() for _, own in accuracy.iterrows()]
    medians = accuracy.median().sort_values(ascending=False)
    yield on(
        "lightgbm-second",
        [first == ["LightGBM", "SVM(RBF)", "Random Forest"] for first in order],
        f"LightGBM is the best in {sum(first[0] == 'LightGBM' for first in order)} of {len(order)} seeds. The SVM "
        f"gets a part of the rows: {_training_rows(evidence, 'SVM(RBF)')}.",
        ours=", ".join(f"{name} {value:.3f}" for name, value in medians.iloc[:3].items()),
    )
    linear = accuracy[["SVM(Lin. L2)", "LogisticReg.", "RidgeReg.(0.5)"]]
    apart = linear.max(axis=1) - linear.min(axis=1)
    worse = accuracy.drop(columns=linear.columns).lt(linear.max(axis=1), axis=0)
    yield on(
        "linear-models-alike",
        ((apart <= ALIKE) & worse["SVM(Sigmoid)"] & (worse.sum(axis=1) == 1)).to_numpy(),
        f"Accuracies, at most {apart.max():.3f} apart. What is in reach is no half space.",
        ours=", ".join(linear.median().map("{:.3f}".format)),
    )
    determination = evidence["estimation"].by_seed("determination", over="method")
    lowest = determination.drop(columns="Decision Tree").min(axis=1)
    yield on(
        "tree-worst-in-estimation",
        (determination["Decision Tree"] < lowest.clip(upper=0)).to_numpy(),
        f"The lowest R² of the other methods is {lowest.min():.3f}. A tree answers with a single row, whose own "
        "variance adds to the variance of the target.",
        ours=f"R² {determination['Decision Tree'].median():.3f}",
    )


def _on_jaccard(on: Judge) -> Verdict:
    """Derive from the printed numbers alone which score JSC is."""
    accuracy, loss, _, precision, recall = np.array(
        [(*on.printed(f"confidence-{key}"), *on.printed(f"retrieval-{key}")) for key in CLASSIFIERS.values()]
    ).T
    gap = accuracy - 1 / (1 / precision + 1 / recall - 1)
    return on.refuted(
        "jaccard",
        "By the paper's own numbers JSC is the share of right answers: JSC and 0-1 loss add up to one within "
        f"{np.abs(accuracy + loss - 1).max():.3f} in all rows, and a Jaccard coefficient by precision and recall "
        f"is {gap.min():.3f} to {gap.max():.3f} less.",
    )


def _on_regressor(on: Judge, own: pd.DataFrame, key: str) -> Iterator[Verdict]:
    chosen = own[own["reading"] == "chosen"].median(numeric_only=True)
    columns = [head for head in ERRORS if (key, head) != ("gaussian-process", "EVS")]
    alone = _listed(own, "baseline-inputs=each-set", columns, "{:.4f}")
    yield on(
        f"estimation-{key}",
        _parts(own, columns),
        f"{chosen['rows']:,.0f} training rows. Over the targets that vary, R² is "
        f"{chosen['R² of what varies']:.3f}. With a test set scaled by itself: {alone}.",
        form="{:.4f}",
    )
    if key == "gaussian-process":
        yield on(
            "variance-gaussian-process",
            own.set_index(["reading", "seed"])["EVS"],
            f"It is {chosen['EVS of what varies']:.3f} over the targets that vary. A constant target has 1 or 0, "
            "depending on whether zero is predicted to the last digit.",
        )


# ---- numbers that verdicts and tables share --------------------------------------------------------


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
    values = (
        hits + rest,
        misses + alarms,
        (hits * rest - misses * alarms) / np.sqrt(sides),
        hits / (hits + alarms),
        hits / (hits + misses),
        hits / (hits + misses + alarms),
    )
    return rows.assign(**dict(zip([*SCORES, "Jaccard"], values, strict=True))).reset_index(drop=True)


def errors(evidence: Evidence) -> pd.DataFrame:
    """Return the errors and scores of all methods of Table VII under all readings, by the table's columns."""
    names = ("absolute", "squared", "explained", "determination")
    heads = dict(zip(names, ERRORS, strict=True))
    heads |= {f"{name}_of_varying": f"{heads[name]} of what varies" for name in names[2:]}
    network = evidence["estimation_network"].where().assign(method="NN")
    return pd.concat([network, evidence["estimation"].where(None)], ignore_index=True).rename(columns=heads)


def _chosen(rows: pd.DataFrame, methods: Sequence[str]) -> pd.DataFrame:
    return rows[(rows["reading"] == "chosen") & rows["method"].isin(methods)]


def _parts(rows: pd.DataFrame, columns: Sequence[str]) -> list[pd.Series]:
    by_run = rows.set_index(["reading", "seed"])
    return [by_run[column] for column in columns]


def _listed(rows: pd.DataFrame, reading: str, columns: Sequence[str], form: str) -> str:
    return ", ".join(rows[rows["reading"] == reading][columns].median().map(form.format))


def _training_rows(evidence: Evidence, name: str) -> str:
    """Say how many rows a classifier was trained on; if it gets a part of them, how accurate it is with fewer."""
    rows = evidence["slow_confidence" if name in PARTS else "confidence"].where(method=name)
    accuracy = (1 - rows["misses"] - rows["false_alarms"]).groupby(rows["rows"]).median()
    fewer = ", ".join(f"{count:,}: {value:.3f}" for count, value in accuracy.iloc[:-1].items())
    return f"{accuracy.index[-1]:,} training rows" + (f"; accuracy with {fewer}" if fewer else "")
