"""Tables VI and VII of paper C with ours."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd

from dexterity_study.claims.ledger import load_paper
from dexterity_study.engine.evidence import Evidence
from dexterity_study.page.markup import Markup
from dexterity_study.page.tables import over_seeds, show
from dexterity_study.workspace.baselines.experiment import CLASSIFIERS, REGRESSORS, THRESHOLDS
from dexterity_study.workspace.baselines.verdicts import ERRORS, SCORES, errors, scores


def confidence_table(stored: Evidence) -> Markup:
    """Set Table VI with ours; the networks are small ones."""
    keys = {name: f"network-{100 * threshold:.0f}" for name, threshold in THRESHOLDS.items()}
    keys |= {name: key for name, (key, _) in CLASSIFIERS.items()}
    kinds = ("confidence", "correlation", "retrieval")
    printed = {name: _printed(key, kinds, SCORES) for name, key in keys.items()}
    readings = {"chosen": "as drawn", "test-classes=equal": "equal classes"}
    return _beside(printed, scores(stored), [*SCORES, "Jaccard"], readings, "{:.3f}")


def estimation_table(stored: Evidence) -> Markup:
    """Set Table VII with ours, EVS and R² in both ways of counting; the network is a small one."""
    keys = {"NN": "network"} | {name: key for name, (key, _) in REGRESSORS.items()}
    printed = {name: _printed(key, ("estimation", "variance"), ERRORS) for name, key in keys.items()}
    readings = {
        "chosen": "tool",
        "baseline-inputs=each-set": "tool, test scaled by itself",
        "estimation-frame=world": "world",
    }
    varying = [f"{name} of what varies" for name in ERRORS[2:]]
    return _beside(printed, errors(stored), [*ERRORS, *varying], readings, "{:.4f}")


def _printed(key: str, kinds: Sequence[str], heads: Sequence[str]) -> dict[str, str]:
    """Return a printed row, which is split among claims if its columns are printed to different digits."""
    names = {f"{kind}-{key}" for kind in kinds}
    claims = [claim for claim in load_paper("liao2018").claims if claim.id in names]
    texts = [claim.format(value) for claim in claims for value in np.atleast_1d(np.array(claim.value))]
    # The variance of the Gaussian process is printed to other digits, and its claim is the last.
    order = ["MAE", "MSE", "R²", "EVS"] if f"variance-{key}" == claims[-1].id else heads
    return dict(zip(order, texts, strict=True))


def _beside(
    printed: Mapping[str, Mapping[str, str]],
    rows: pd.DataFrame,
    columns: Sequence[str],
    readings: Mapping[str, str],
    form: str,
) -> Markup:
    """Set our rows by method and reading, the printed row of a method first."""
    own = rows[rows["reading"].isin(readings)].replace({"reading": readings})
    ours = over_seeds(own, ["method", "reading"], {name: name for name in columns}, form)
    ours.insert(0, "rows", own.groupby(["method", "reading"])["rows"].first().map("{:,}".format))
    theirs = pd.DataFrame.from_dict({(name, "paper"): row for name, row in printed.items()}, orient="index")
    joined = pd.concat([theirs, ours])[ours.columns]
    order = [(name, whose) for name in printed for whose in ("paper", *readings.values())]
    return show(joined.loc[[row for row in order if row in joined.index]])
