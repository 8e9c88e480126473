"""What the study of other methods trains, how it scores and counts, and what it says of the tables."""

import dataclasses

import numpy as np
import pytest
import torch
from sklearn import metrics

from dexterity.report.claims import Outcome, load_paper
from dexterity.studies.workspace import baselines as study
from dexterity.timing import Timing
from dexterity.workspace.dataset import confidence_data
from dexterity.workspace.reachability import reachable

SMOKE = study.CONFIGS["smoke"]
PAPER = load_paper("liao2018")


@pytest.fixture(scope="module")
def result():
    return study.run(SMOKE)


def by_claim(result):
    return {verdict.claim: verdict for verdict in study.verdicts(result)}


def test_the_rule_behind_the_labels_has_all_scores_at_one():
    data = confidence_data(2000, 5)
    rule = reachable(data.samples.links, data.samples.position)
    scores = study.scores_of(data.reachable.numpy(), rule.numpy())
    assert all(values == (1.0,) for values in vars(scores).values())


def test_scores_from_counts():
    # 3 right of those in reach, 2 of those out of it; 1 missed, 4 said wrongly to be in reach.
    truth = np.array([1, 1, 1, 0, 0, 1, 0, 0, 0, 0], dtype=bool)
    answer = np.array([1, 1, 1, 0, 0, 0, 1, 1, 1, 1], dtype=bool)
    scores = study.scores_of(truth, answer)
    assert scores.accuracy == pytest.approx((5 / 10,))
    assert scores.precision == pytest.approx((3 / 7,))
    assert scores.recall == pytest.approx((3 / 4,))
    assert scores.jaccard == pytest.approx((3 / 8,))
    assert scores.correlation == pytest.approx(((3 * 2 - 4 * 1) / np.sqrt(7 * 4 * 6 * 3),))


def test_equal_classes_are_equal_and_of_the_same_draw():
    data = study.equal_classes(1000, 3)
    assert data.reachable.sum() == 500
    assert (reachable(data.samples.links, data.samples.position) == data.reachable).all()
    drawn = confidence_data(1600, 3).samples.links
    assert torch.isin(data.samples.links[:, 0], drawn[:, 0]).all()
    for count in (0, 7):
        with pytest.raises(ValueError, match=f"count is {count}; a positive even number is needed"):
            study.equal_classes(count, 3)


def test_methods_have_the_settings_that_the_ledger_assumes():
    methods, others = study.classifiers(7), study.regressors(7)
    assert methods.keys() == study.CLASSIFIERS.keys()
    assert others.keys() == study.REGRESSORS.keys()
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


def test_every_method_is_there_with_its_rows_and_seeds(result):
    drawn, equal = result.confidence["as drawn"], result.confidence["equal classes"]
    assert drawn.keys() == {*study.CLASSIFIERS, *study.NETWORKS}
    assert equal.keys() == study.CLASSIFIERS.keys()
    parts = {
        "SVM(RBF)": SMOKE.kernel[-1],
        "SVM(Sigmoid)": SMOKE.kernel[-1],
        "Gauss. Process": SMOKE.process[-1],
    }
    for name, own in drawn.items():
        assert own.rows == parts.get(name, SMOKE.train)
        once = name in {*parts, *study.NETWORKS, "AdaBoosted DT"}
        for size, rows in (("small", SMOKE.small), ("large", SMOKE.large)):
            assert len(own.scores[size].accuracy) == (1 if once else len(SMOKE.seeds))
            right = np.array(own.scores[size].accuracy) * rows
            assert right == pytest.approx(right.round(), abs=1e-9)
    assert result.share["equal classes"] == 0.5
    assert result.growth.keys() == parts.keys()
    for name, sizes in (("SVM(RBF)", SMOKE.kernel), ("Gauss. Process", SMOKE.process)):
        assert list(result.growth[name]) == [str(size) for size in sizes]
        assert result.growth[name][str(sizes[-1])] == drawn[name].scores["large"].accuracy[0]


def test_something_is_learned_of_confidence_and_nothing_of_the_jacobian(result):
    for name in ("LightGBM", "XGboost", "LogisticReg."):
        scores = result.confidence["equal classes"][name].scores["large"]
        assert scores.accuracy[0] > 0.65
        # A correlation of equal classes, if errors fall on both alike, is twice the accuracy less one.
        assert scores.correlation[0] == pytest.approx(2 * scores.accuracy[0] - 1, abs=0.05)
    for own in result.estimation["tool"].values():
        assert max(own.varying.determination) < 0.01


@pytest.mark.parametrize("frame", ["tool", "world"])
@pytest.mark.parametrize("met", [True, False])
def test_constant_targets_count_as_in_the_library(frame, met):
    random = np.random.default_rng(0)
    varying = random.normal(size=(50, 5))
    constant = -np.ones((50, study.CONSTANT_TARGETS[frame]))
    guess = varying + 0.3 * random.normal(size=varying.shape)
    truth = np.hstack([varying, constant])
    answer = np.hstack([guess, constant if met else 0.9 * constant])
    found = study.errors_of(truth, answer).determination[0]
    count = constant.shape[1]
    of_varying = study.errors_of(varying, guess).determination[0]
    assert found == pytest.approx((5 * of_varying + count * met) / (5 + count))
    assert found == metrics.r2_score(truth, answer)


def test_both_ways_of_counting_differ_by_the_constant_targets(result):
    for targets, varying in (("tool", 23), ("world", 21)):
        count = study.CONSTANT_TARGETS[targets]
        for name, own in result.estimation[targets].items():
            met = 0 if name == "Gauss. Process" else count
            expected = (varying * np.array(own.varying.determination) + met) / (varying + count)
            assert own.all_targets.determination == pytest.approx(tuple(expected))
    # To predict zero costs one in the mean square of a constant target.
    process = result.estimation["tool"]["Gauss. Process"]
    assert process.all_targets.squared[0] == pytest.approx((23 * process.varying.squared[0] + 2) / 25)
    assert process.varying.explained == pytest.approx((0.0,), abs=1e-6)


def test_the_printed_tables_tell_how_constant_targets_were_counted():
    ridge = PAPER.claim("estimation-ridge-regression").value
    process = PAPER.claim("estimation-gaussian-process").value
    # Both predict the mean; the process misses two of 25 targets by one.
    for of_ridge, of_process in zip(ridge[:2], process[:2], strict=True):
        assert of_process - of_ridge == pytest.approx(2 / 25, abs=2e-4)
    assert ridge[3] == pytest.approx(2 / 25, abs=0.002)


def test_a_printed_row_would_be_reproduced_or_fitted(result):
    accuracy, _, correlation = PAPER.claim("confidence-lightgbm").value
    precision, recall = PAPER.claim("retrieval-lightgbm").value
    printed = study.Classification((accuracy,), (precision,), (recall,), (correlation,), (0.5,))
    claims = ("confidence-lightgbm", "retrieval-lightgbm")
    for classes, outcome in (("as drawn", Outcome.REPRODUCED), ("equal classes", Outcome.FITTED)):
        own = dataclasses.replace(result.confidence[classes]["LightGBM"], scores={"large": printed})
        confidence = {**result.confidence, classes: {**result.confidence[classes], "LightGBM": own}}
        found = by_claim(dataclasses.replace(result, confidence=confidence))
        assert [found[claim].outcome for claim in claims] == [outcome, outcome]

    errors = study.Errors(*((value,) for value in PAPER.claim("estimation-decision-tree").value))
    for targets, outcome in (
        ("tool", Outcome.REPRODUCED),
        ("tool, test scaled by itself", Outcome.FITTED),
    ):
        own = dataclasses.replace(result.estimation[targets]["Decision Tree"], all_targets=errors)
        estimation = {**result.estimation, targets: {**result.estimation[targets], "Decision Tree": own}}
        found = by_claim(dataclasses.replace(result, estimation=estimation))
        assert found["estimation-decision-tree"].outcome is outcome


def test_networks_lead_only_if_all_thresholds_do(result):
    def with_networks(*accuracies):
        methods = dict(result.confidence["as drawn"])
        for name, accuracy in zip(study.NETWORKS, accuracies, strict=True):
            scores = study.Classification((accuracy,), (1.0,), (1.0,), (accuracy,), (1.0,))
            methods[name] = study.Classifier(1, {"small": scores, "large": scores}, ())
        confidence = {**result.confidence, "as drawn": methods}
        found = by_claim(dataclasses.replace(result, confidence=confidence))
        return found["networks-first-in-confidence"].outcome

    assert with_networks(0.999, 0.999, 0.999) is Outcome.REPRODUCED
    assert with_networks(0.999, 0.1, 0.999) is Outcome.IN_SHAPE
    assert with_networks(0.1, 0.1, 0.1) is Outcome.NOT_REPRODUCED


@pytest.mark.parametrize(
    ("values", "outcome"),
    [
        # Its mean absolute error is larger than the mean square of the others.
        ((0.26, 0.12, 0.5, 0.5), Outcome.REPRODUCED),
        ((0.9, 0.12, 0.5, 0.5), Outcome.NOT_REPRODUCED),
        ((0.26, 0.12, 0.5, -9.0), Outcome.NOT_REPRODUCED),
    ],
)
def test_the_network_is_first_if_it_is_in_every_column(result, values, outcome):
    errors = study.Errors(*((value,) for value in values))
    own = dataclasses.replace(result.estimation["tool"]["NN"], all_targets=errors)
    estimation = {**result.estimation, "tool": {**result.estimation["tool"], "NN": own}}
    found = by_claim(dataclasses.replace(result, estimation=estimation))
    assert found["network-first-in-estimation"].outcome is outcome


def test_jsc_is_no_jaccard_coefficient(result):
    assert by_claim(result)["jaccard"].outcome is Outcome.CONTRADICTED


def test_tables_set_ours_beside_the_papers(result):
    confidence = study.confidence_table(result)
    assert {name for name, _ in confidence} == {*study.NETWORKS, *study.CLASSIFIERS}
    assert confidence["NN(.25)", "paper"]["MCC"] == "0.961"
    assert confidence["SVM(RBF)", "paper"]["Rec."] == "0.95"
    assert confidence["SVM(RBF)", "as drawn"]["rows"] == f"{SMOKE.kernel[-1]}"
    estimation = study.estimation_table(result)
    assert estimation["Gauss. Process", "paper"]["R²"] == "−0.0012"
    assert estimation["Gauss. Process", "paper"]["EVS"] == "0.0"
    assert estimation["NN", "paper"]["MSE"] == "0.0095"
    for table in (confidence, estimation, study.growth_table(result)):
        assert len({tuple(row) for row in table.values()}) == 1


def test_times_are_set_beside_the_papers_where_there_are_any(result):
    assert study.time_table(result) == {}
    timed = dataclasses.replace(
        result.confidence["as drawn"]["SVM(RBF)"], times=(Timing("SVM(RBF)", 100, 1e-4, 2e-4, 3e-4),)
    )
    drawn = {**result.confidence["as drawn"], "SVM(RBF)": timed}
    rows = study.time_table(dataclasses.replace(result, confidence={"as drawn": drawn}))
    assert rows.keys() == {("confidence", "SVM(RBF)")}
    (row,) = rows.values()
    assert row["median [µs]"] == "200"
    assert row["paper"] == PAPER.claim("time-confidence-svm-radial").printed
