"""What the other methods of paper C are, how they are scored and counted, and what the tables say of it."""

import numpy as np
import pytest
import torch
from sklearn import metrics

from dexterity.workspace.dataset import confidence_data
from dexterity.workspace.reachability import reachable
from dexterity_study.claims.ledger import load_paper
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


@pytest.mark.parametrize(
    ("thresholds", "holds"),
    [((0.999, 0.999, 0.999), True), ((0.999, 0.1, 0.999), False), ((0.1, 0.1, 0.1), False)],
)
def test_networks_lead_only_if_all_thresholds_do(evidence, thresholds, holds):
    rows = evidence["confidence_network"].rows.assign(
        hits=np.array(thresholds) / 2, misses=0.5 - np.array(thresholds) / 2, false_alarms=0.0
    )
    assert outcome(evidence, "confidence_network", rows, "networks-first-in-confidence") == holds


@pytest.mark.parametrize(
    ("values", "holds"),
    [
        # Its mean absolute error is larger than the mean square of the others.
        ((0.26, 0.12, 0.5, 0.5), True),
        ((0.9, 0.12, 0.5, 0.5), False),
        ((0.26, 0.12, 0.5, -9.0), False),
    ],
)
def test_the_network_is_first_if_it_is_in_every_column(evidence, values, holds):
    names = ("absolute", "squared", "explained", "determination")
    rows = evidence["estimation_network"].rows.assign(**dict(zip(names, values, strict=True)))
    assert outcome(evidence, "estimation_network", rows, "network-first-in-estimation") == holds


def outcome(evidence, name, rows, claim):
    """Judge a claim with other rows of an experiment; tell whether it is reproduced."""
    changed = Evidence("workspace.baselines", {**evidence, name: Table(rows, evidence[name].keys)})
    found = {one.claim: one.outcome for one in verdicts.verdicts(changed)}
    return found[claim] == "reproduced"
