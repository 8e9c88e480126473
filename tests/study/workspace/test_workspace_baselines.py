"""What the other methods of paper C are, how they are scored and counted, and what the tables say of it."""

import numpy as np
import pytest
import torch
from sklearn import metrics

from dexterity.workspace.dataset import confidence_data
from dexterity.workspace.reachability import reachable
from dexterity_study.claims.ledger import load_paper
from dexterity_study.claims.outcome import Outcome
from dexterity_study.engine.evidence import Evidence
from dexterity_study.engine.table import Table
from dexterity_study.workspace.baselines import experiment, verdicts

PAPER = load_paper("liao2018")


@pytest.fixture(scope="module")
def evidence():
    runs = {
        "confidence": ("chosen", "test-classes=equal"),
        "slow_confidence": ("chosen", "test-classes=equal"),
        "estimation": ("chosen", "baseline-inputs=each-set", "estimation-frame=world"),
        "confidence_network": ("chosen",),
        "estimation_network": ("chosen",),
    }
    made = {}
    for name, readings in runs.items():
        one = getattr(experiment, name)
        made[name] = Table.joined([one(0, reading, **one.smoke) for reading in readings])
    return Evidence("workspace.baselines", made)


def scores(evidence, method, reading="chosen"):
    rows = verdicts.scores(evidence)
    return rows[(rows["method"] == method) & (rows["reading"] == reading)].iloc[0]


def test_methods_have_the_settings_that_the_ledger_assumes():
    methods, others = (
        {name: experiment.seeded(method, 7) for name, method in table.items()}
        for table in (experiment.CLASSIFIERS, experiment.REGRESSORS)
    )
    assert methods["LightGBM"].random_state == others["Decision Tree"].random_state == 7
    assert experiment.REGRESSORS["Decision Tree"].model.random_state is None
    settings = {
        "Random Forest": {"n_estimators": 10},
        "AdaBoosted DT": {"n_estimators": 50},
        "SVM(RBF)": {"C": 1.0, "gamma": "auto"},
        "SVM(Sigmoid)": {"C": 1.0, "gamma": "auto", "kernel": "sigmoid"},
        "RidgeReg.(0.5)": {"alpha": 1.0},
        "XGboost": {"max_depth": 1, "n_estimators": 100, "learning_rate": 0.1},
        "LightGBM": {"num_leaves": 31, "learning_rate": 0.1, "n_estimators": 100},
    }
    for name, expected in settings.items():
        assert methods[name].get_params().items() >= expected.items()
    assert others["k-NN"].get_params()["n_neighbors"] == 5


def test_equal_classes_are_equal_and_of_the_same_draw():
    data = experiment.equal_classes(1000, 3)
    assert data.reachable.sum() == 500
    assert (reachable(data.samples.links, data.samples.position) == data.reachable).all()
    drawn = confidence_data(1600, 3).samples.links
    assert torch.isin(data.samples.links[:, 0], drawn[:, 0]).all()


def test_scores_follow_from_the_shares_of_answers(evidence):
    # 3 right of those in reach, 2 of those out of it; 1 missed, 4 said wrongly to be in reach.
    truth = torch.tensor([1, 1, 1, 0, 0, 1, 0, 0, 0, 0], dtype=torch.bool)
    answer = torch.tensor([1, 1, 1, 0, 0, 0, 1, 1, 1, 1], dtype=torch.bool)
    shares = experiment.shares_of(truth, answer)
    assert shares == pytest.approx({"hits": 0.3, "misses": 0.1, "false_alarms": 0.4})
    rows = evidence["confidence"].rows.iloc[[0]].assign(**shares)
    changed = Evidence("workspace.baselines", {**evidence, "confidence": Table(rows, ("method", "rows"))})
    name = rows["method"].iloc[0]
    for reading, y, guess in (
        ("chosen", truth, answer),
        ("positive-class=out-of-reach", ~truth, ~answer),
    ):
        own = scores(changed, name, reading)
        assert own["JSC"] == pytest.approx(metrics.accuracy_score(y, guess))
        assert own["MCC"] == pytest.approx(metrics.matthews_corrcoef(y, guess))
        assert own["Prec."] == pytest.approx(metrics.precision_score(y, guess))
        assert own["Rec."] == pytest.approx(metrics.recall_score(y, guess))


def test_something_is_learned_of_confidence_and_nothing_of_the_jacobian(evidence):
    for name in ("LightGBM", "XGboost", "LogisticReg."):
        own = scores(evidence, name, "test-classes=equal")
        assert own["JSC"] > 0.65
        # A correlation of equal classes, if errors fall on both alike, is twice the accuracy less one.
        assert own["MCC"] == pytest.approx(2 * own["JSC"] - 1, abs=0.05)
    assert evidence["estimation"].where()["determination_of_varying"].max() < 0.01


@pytest.mark.parametrize("met", [True, False])
@pytest.mark.parametrize("constant", [1, 2])
def test_constant_targets_count_as_in_the_library(constant, met):
    random = np.random.default_rng(0)
    truth = np.hstack([random.normal(size=(50, 5)), -np.ones((50, constant))])
    answer = truth + 0.3 * random.normal(size=truth.shape) * ([1] * 5 + [not met] * constant)
    found = experiment.errors_of(truth, answer, varying=5)
    expected = (5 * found["determination_of_varying"] + constant * met) / (5 + constant)
    assert found["determination"] == pytest.approx(expected)
    assert found["determination_of_varying"] == metrics.r2_score(truth[:, :5], answer[:, :5])


def test_both_ways_of_counting_differ_by_the_constant_targets(evidence):
    for reading, frame in (("chosen", "tool"), ("estimation-frame=world", "world")):
        varying, constant = experiment.TARGETS[frame]
        for row in evidence["estimation"].where(reading).to_dict("records"):
            met = 0 if row["method"] == "Gauss. Process" else constant
            expected = (varying * row["determination_of_varying"] + met) / (varying + constant)
            assert row["determination"] == pytest.approx(expected)


def test_the_printed_tables_tell_how_constant_targets_were_counted():
    ridge, process = (
        PAPER.printed(f"estimation-{name}") for name in ("ridge-regression", "gaussian-process")
    )
    # Both predict the mean; the process misses two of 25 targets by one.
    for of_ridge, of_process in zip(ridge[:2], process[:2], strict=True):
        assert of_process - of_ridge == pytest.approx(2 / 25, abs=2e-4)
    assert ridge[3] == pytest.approx(2 / 25, abs=0.002)


def verdict_of(evidence, claim):
    return next(one for one in verdicts.verdicts(evidence) if one.claim == claim)


@pytest.mark.parametrize(
    "claim",
    [
        "more-accurate", "networks-first-in-confidence", "network-first-in-estimation", "lightgbm-second",
        "tree-worst-in-estimation", "variance-gaussian-process",
        *(f"{kind}-{name}" for kind in ("confidence", "retrieval") for name in (
            "svm-radial", "svm-sigmoid", "gaussian-process", "boosted-trees", "lightgbm"
        )),
        *(f"estimation-{name}" for name in ("decision-tree", "gaussian-process", "nearest-neighbours")),
    ],
)  # fmt: skip
def test_a_part_of_the_rows_or_rounds_does_not_stand_for_a_printed_row(evidence, claim):
    judged = verdict_of(evidence, claim)
    assert judged.outcome is Outcome.NOT_RUN
    assert judged.ours == ""
    assert judged.sentence


def test_what_ran_on_all_rows_is_judged(evidence):
    judged = [one for one in verdicts.verdicts(evidence) if one.claim.endswith(("naive-bayes", "xgboost"))]
    assert len(judged) == 4
    assert all(one.outcome is not Outcome.NOT_RUN and one.ours for one in judged)


@pytest.mark.parametrize(
    ("linear", "forest", "sigmoid", "outcome"),
    [
        ((0.750, 0.751, 0.752), 0.9, 0.6, Outcome.REPRODUCED),
        ((0.750, 0.751, 0.752), 0.9, 0.8, Outcome.REPRODUCED),
        ((0.750, 0.751, 0.765), 0.9, 0.6, Outcome.NOT_REPRODUCED),
        ((0.750, 0.751, 0.752), 0.7, 0.6, Outcome.NOT_REPRODUCED),
    ],
)
def test_linear_methods_are_alike_and_the_worst_of_those_with_all_rows(
    evidence, linear, forest, sigmoid, outcome
):
    right = dict(zip(("SVM(Lin. L2)", "LogisticReg.", "RidgeReg.(0.5)"), linear, strict=True))
    right |= {"Random Forest": forest, "SVM(Sigmoid)": sigmoid}
    tables = {}
    for name in ("confidence", "slow_confidence"):
        rows = evidence[name].rows.copy()
        hits = rows["method"].map(right).fillna(0.95)
        tables[name] = Table(rows.assign(hits=hits, misses=1 - hits, false_alarms=0.0), evidence[name].keys)
    changed = Evidence("workspace.baselines", {**evidence, **tables})
    assert verdict_of(changed, "linear-models-alike").outcome is outcome
