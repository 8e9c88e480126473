"""The networks of paper C: scores are scikit-learn's, and the paper's way is what the ledger says."""

import math
from dataclasses import replace

import numpy as np
import pytest
import torch
from sklearn.metrics import explained_variance_score, r2_score

from dexterity.workspace import dataset, jacobian_net, training
from dexterity.workspace.jacobian_net import JacobianNet
from dexterity.workspace.training import Loss
from dexterity_study.claims.ledger import load_paper
from dexterity_study.claims.outcome import Outcome
from dexterity_study.engine.evidence import Evidence
from dexterity_study.workspace.estimation import experiment as study
from dexterity_study.workspace.estimation import logs
from dexterity_study.workspace.estimation.verdicts import verdicts

PAPER = load_paper("liao2018")


@pytest.fixture(scope="module")
def network() -> JacobianNet:
    jacobians = dataset.jacobian_data(500, 2)
    way = study.WAYS[study.BEST]
    made = training.network_for(way.architecture, way.inputs, way.entries, jacobians, seed=0)
    rows = {
        "confidence": training.confidence_rows(made, dataset.confidence_data(2_000, 1)),
        "estimation": training.estimation_rows(made, jacobians),
    }
    return training.train(made, rows, study.options_of(way, (2, 2), 0), seed=0).network


def test_confidence_scores_count_who_is_in_reach(network):
    data = dataset.confidence_data(500, 9)
    scores = study.sureness(network, data)
    for threshold in study.THRESHOLDS:
        said, reach = network.estimate(data.samples).confidence >= threshold, data.reachable
        hits, accuracy = (said & reach).sum(), (said == reach).double().mean().item()
        assert scores[f"accuracy_{threshold:g}"] == pytest.approx(accuracy)
        assert scores[f"precision_{threshold:g}"] == pytest.approx((hits / said.sum()).item())
        assert scores[f"recall_{threshold:g}"] == pytest.approx((hits / reach.sum()).item())


def test_estimation_scores_are_scikit_learns():
    random = np.random.default_rng(0)
    truth = random.normal(size=(50, 23))
    guess = truth + 0.1 + 0.3 * random.normal(size=truth.shape)
    scores, left = study.errors(truth, guess)
    assert scores["r2"] == pytest.approx(r2_score(truth, guess))
    assert scores["explained"] == pytest.approx(explained_variance_score(truth, guess))
    np.testing.assert_allclose(1 - left, r2_score(truth, guess, multioutput="raw_values"))


def test_errors_of_the_combined_model_are_those_of_its_jacobians(network):
    data = dataset.confidence_data(300, 9)
    combined = study.combined(network, data)
    mask = network.estimate(data.samples).mask
    assert combined["given"] == pytest.approx(mask.double().mean().item())
    wrong = (mask & ~data.reachable).sum() / (~data.reachable).sum()
    assert combined["wrongly_given"] == pytest.approx(wrong.item())
    assert 0 < combined["error"] < combined["worst_error"]


def test_rises_over_the_fall():
    assert study.rises((1.0, 0.4, 0.7, 0.2)) == pytest.approx(0.3 / 0.8)
    assert math.isinf(study.rises((1.0, 2.0)))


def test_a_cycle_shows_where_the_confidence_loss_comes_back():
    epochs = [("estimation", 9, 9), *[("confidence", t, v) for t, v in ((4, 4), (2, 3))]]
    epochs += [("estimation", 8, 5), ("confidence", 3, 2), ("confidence", 1, 1), ("estimation", 7, 1)]
    facts = study.cycle_facts([Loss(*epoch) for epoch in epochs])
    assert facts == {"before_cycles": 9, "returns": 1.0, "confidence_to_half": 3, "estimation_to_half": 2}


def test_the_papers_way_is_what_the_ledger_says():
    way = study.WAYS[study.PAPERS_WAY]
    options = study.options_of(way, (0, 0), int(PAPER.printed("epochs")))
    assert len(options.schedule) == PAPER.printed("epochs")
    assert options.batch == PAPER.printed("batch-size")
    assert options.validation == PAPER.printed("validation-share")
    cycle = [epoch.head for epoch in options.schedule[-3:]]
    assert (cycle.count("confidence"), cycle.count("estimation")) == tuple(PAPER.printed("cycle"))
    for architecture in (way.architecture, jacobian_net.PAPER_SIZE):
        assert len(architecture.confidence) + 1 == PAPER.printed("confidence-layers")
        assert len(architecture.estimation) + 1 == PAPER.printed("estimation-layers")
        assert architecture.dropout == PAPER.printed("dropout-rate")
    assert jacobian_net.PAPER_SIZE.encoder[-1] == PAPER.printed("encoding-size")


def test_adam_has_the_printed_settings():
    beta1, beta2, rate, epsilon = PAPER.printed("adam-settings")
    group = training.OPTIMISERS["Adam"]([torch.zeros(1, requires_grad=True)], lr=rate).param_groups[0]
    assert group["betas"] == (beta1, beta2)
    assert group["eps"] == epsilon
    assert study.options_of(study.WAYS[study.PAPERS_WAY], (0, 0), 25).rate == study.RATES["Adam"] == rate


def outcomes(monkeypatch=None, **changed):
    """Return the verdicts by claim, with some logs changed."""
    known = logs.load()
    if changed:
        ids = {name.replace("_", "-"): changes for name, changes in changed.items()}
        other = known | {name: replace(known[name], **changes) for name, changes in ids.items()}
        monkeypatch.setattr(logs, "load", lambda: other)
    return {one.claim: one for one in verdicts(Evidence("workspace.estimation"))}


def test_no_smaller_network_stands_for_the_papers():
    rows = ("confidence-network", "retrieval-network", "correlation-network", "estimation-network")
    judged = outcomes()
    own = [claim.id for claim in PAPER.claims if claim.id.startswith(rows)]
    assert len(own) == 8
    for claim in (*own, "threshold-trades", "threshold-75-best", "regularisation"):
        assert judged[claim].outcome is Outcome.NOT_RUN
        assert judged[claim].ours == ""


def test_nothing_that_was_only_logged_is_reproduced():
    of_logs = [one for one in outcomes().values() if one.sentence.startswith("Logged")]
    assert len(of_logs) == 11
    assert {one.outcome for one in of_logs} == {Outcome.LOGGED, Outcome.CONTRADICTED}


STUCK, LEARNED = ((75, 0.247),), ((75, 0.01),)


@pytest.mark.parametrize(
    ("claim", "changed", "ours", "outcome"),
    [
        ("adamax-best-sgd-worst", {"confidence_sgd": {"training": ((75, 0.2),)}}, "yes, yes", "as logged"),
        (
            "adamax-best-sgd-worst",
            {"confidence_adagrad": {"training": ((75, 0.01),)}},
            "no, no",
            "contradicted",
        ),
        ("adamax-and-sgd-acceptable", {"confidence_sgd": {"training": ((75, 0.6),)}}, "yes, no", "as logged"),
        (
            "rmsprop-adamax-adam-converge",
            {"estimation_adam": {"training": STUCK}},
            "yes, yes, no",
            "as logged",
        ),
        ("nadam-adagrad-sgd-fail", {"estimation_sgd": {"training": LEARNED}}, "yes, yes, no", "as logged"),
        ("adam-unsteady-in-confidence", {"confidence_adam": {"rises": 0.2}}, "no, yes, no", "as logged"),
        ("sgd-steadiest-in-confidence", {"confidence_sgd": {"rises": 0.2}}, "", "contradicted"),
        (
            "cycles-show",
            {"combined_confidence_extremes": {"training": ((1, 0.3), (50, 0.32))}},
            "",
            "contradicted",
        ),
        ("pretraining-looks-bad", {"combined_pretraining": {"validation": ((100, 0.2),)}}, "", "as logged"),
        (
            "cycle-prevents-overfitting",
            {"combined_confidence_15": {"validation": ((50, 0.3),)}},
            "yes, yes",
            "as logged",
        ),
        (
            "confidence-converges-slower",
            {"combined_confidence_15": {"training": ((50, 0.01),)}},
            "no, no",
            "contradicted",
        ),
    ],
)
def test_sentences_on_trainings_are_judged_on_the_training_loss(monkeypatch, claim, changed, ours, outcome):
    judged = outcomes(monkeypatch, **changed)[claim]
    assert judged.outcome == outcome
    assert judged.ours == ""
    if ours:
        told = judged.sentence.rpartition("In the logs: ")[2].rstrip(".").split(", ")
        assert ", ".join(part.rpartition(": ")[2] for part in told if ": " in part) == ours


def test_a_log_has_rising_epochs():
    log = logs.load()["estimation-750"]
    assert log.left == pytest.approx(0.0103 / 0.248)
    assert log.left_in_validation == pytest.approx(0.0071 / 0.248)
    with pytest.raises(ValueError, match=r"training has the epochs \[2, 1\]; they must rise"):
        replace(log, training=((2, 0.1), (1, 0.2)))
    with pytest.raises(ValueError, match="validation has the epochs"):
        replace(log, validation=())


def test_each_change_leaves_less_of_the_variance():
    stored = Evidence("workspace.estimation")["trainings"]
    order = (study.COLUMNS, study.RELEVANT, study.PLAIN, study.WORLD, study.BEST)
    r2 = [stored.values("r2", way=way).median() for way in order]
    assert r2 == sorted(r2)
    assert len(stored.values("r2", way=study.PLAIN)) == len(stored.values("r2", way=study.BEST)) == 10
