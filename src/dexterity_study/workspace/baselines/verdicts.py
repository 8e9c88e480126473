"""Verdicts on the other methods of paper C."""

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
SMALL = "A small network on the paper's columns, with one seed, in place of the paper's"


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
        yield on(f"estimation-{key}", own, note, form="{:.4f}")
    process = "Gauss. Process"
    yield on(
        "variance-gaussian-process",
        _of(by_error, process, ["EVS"])[0][0],
        f"It is {_chosen(by_error, [process])['EVS of what varies'].median():.3f} over the targets that vary. A "
        "constant target has 1 or 0, depending on whether zero is predicted to the last digit.",
    )


def acceptance(evidence: Evidence) -> Iterator[Acceptance]:
    """Figures that must hold for the book to be accepted."""
    own = evidence["estimation"].where(method="RidgeReg.")
    varying, constant = TARGETS["tool"]
    expected = (varying * own["determination_of_varying"] + constant) / (varying + constant)
    gap = (own["determination"] - expected).abs().max()
    yield Acceptance("R² of ridge regression by both ways of counting", gap, 1e-9)


def _on_networks(on: Judge, by_score: pd.DataFrame, by_error: pd.DataFrame) -> Iterator[Verdict]:
    best = _chosen(by_score, CLASSIFIERS).groupby("seed")[["JSC", "MCC"]].max()
    networks = _chosen(by_score, THRESHOLDS)
    leads = best.lt(networks[["JSC", "MCC"]].min()).all(axis="columns").to_numpy()
    rivals, network = _chosen(by_error, REGRESSORS), _chosen(by_error, ["NN"])[ERRORS].iloc[0]
    # Errors are to be small, scores large.
    sign = pd.Series([-1, -1, 1, 1], ERRORS)
    top = (rivals[ERRORS] * sign).groupby(rivals["seed"]).max()
    first = top.lt(network * sign).all(axis="columns").to_numpy()
    both = {"confidence": bool(leads.all()), "estimation": bool(first.all())}
    yield on("more-accurate", both, f"{SMALL}.")
    note = f"{SMALL}. JSC at the three thresholds; the best of the other methods has {best['JSC'].max():.3f}."
    ours = ", ".join(networks["JSC"].map("{:.3f}".format))
    yield on("networks-first-in-confidence", leads, note, ours=ours)
    least = f"the smallest MSE of the other methods is {rivals['MSE'].min():.4f}"
    note, ours = f"{SMALL}. {', '.join(ERRORS)}; {least}.", ", ".join(network.map("{:.4f}".format))
    yield on("network-first-in-estimation", first, note, ours=ours)


def _on_orders(on: Judge, evidence: Evidence) -> Iterator[Verdict]:
    rows = _chosen(scores(evidence), CLASSIFIERS)
    # The slow methods have the first seed only.
    accuracy = rows.pivot(index="seed", columns="method", values="JSC").ffill()
    order = [own.sort_values(ascending=False).index[:3].tolist() for _, own in accuracy.iterrows()]
    medians = accuracy.median().nlargest(3)
    note = (
        f"LightGBM is the best in {sum(first[0] == 'LightGBM' for first in order)} of {len(order)} seeds. The SVM "
        f"gets a part of the rows: {_training_rows(evidence, 'SVM(RBF)')}."
    )
    holds = [first == ["LightGBM", "SVM(RBF)", "Random Forest"] for first in order]
    ours = ", ".join(f"{name} {value:.3f}" for name, value in medians.items())
    yield on("lightgbm-second", holds, note, ours=ours)
    linear = accuracy[["SVM(Lin. L2)", "LogisticReg.", "RidgeReg.(0.5)"]]
    apart = linear.max(axis=1) - linear.min(axis=1)
    worse = accuracy.drop(columns=linear.columns).lt(linear.max(axis=1), axis=0)
    alike = (apart <= ALIKE) & worse["SVM(Sigmoid)"] & (worse.sum(axis=1) == 1)
    note = f"Accuracies, at most {apart.max():.3f} apart. What is in reach is no half space."
    ours = ", ".join(linear.median().map("{:.3f}".format))
    yield on("linear-models-alike", alike.to_numpy(), note, ours=ours)
    rivals = evidence["estimation"].by_seed("determination", over="method")
    tree = rivals.pop("Decision Tree")
    lowest = rivals.min(axis=1)
    note = (
        f"The lowest R² of the other methods is {lowest.min():.3f}. A tree answers with a single row, whose own "
        "variance adds to the variance of the target."
    )
    worst = (tree < lowest.clip(upper=0)).to_numpy()
    yield on("tree-worst-in-estimation", worst, note, ours=f"R² {tree.median():.3f}")
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


def _training_rows(evidence: Evidence, name: str) -> str:
    """Say how many rows a classifier was trained on; if it gets a part of them, how accurate it is with fewer."""
    rows = evidence["slow_confidence" if name in PARTS else "confidence"].where(method=name)
    accuracy = (1 - rows["misses"] - rows["false_alarms"]).groupby(rows["rows"]).median()
    fewer = ", ".join(f"{count:,}: {value:.3f}" for count, value in accuracy.iloc[:-1].items())
    return f"{accuracy.index[-1]:,} training rows" + (f"; accuracy with {fewer}" if fewer else "")
