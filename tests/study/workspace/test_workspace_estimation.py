"""The networks of paper C: scores are scikit-learn's, and the paper's way is what the ledger says."""

import math

import numpy as np
import pandas as pd
import pytest
import torch
from sklearn.metrics import explained_variance_score, r2_score

from dexterity.workspace import dataset, jacobian_net, training
from dexterity.workspace.jacobian_net import JacobianNet
from dexterity.workspace.training import Loss
from dexterity_study.claims.ledger import load_paper
from dexterity_study.engine.evidence import Evidence
from dexterity_study.workspace.estimation import experiment as study
from dexterity_study.workspace.estimation.verdicts import with_constants

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
    constants = np.tile([0.0, 1.0], (50, 1))
    for each, hair in ((1, 0.0), (0, 1e-9)):
        known = r2_score(np.hstack([truth, constants]), np.hstack([guess, constants + hair]))
        assert with_constants(pd.Series([scores["r2"]]), each)[0] == pytest.approx(known)


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


def test_each_change_leaves_less_of_the_variance():
    stored = Evidence("workspace.estimation")["trainings"]
    order = (study.COLUMNS, study.RELEVANT, study.PLAIN, study.WORLD, study.BEST)
    r2 = [stored.values("r2", way=way).median() for way in order]
    assert r2 == sorted(r2)
    assert len(stored.values("r2", way=study.PLAIN)) == len(stored.values("r2", way=study.BEST)) == 10
