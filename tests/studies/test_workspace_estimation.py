"""Scores of paper C's networks against scikit-learn and by hand; what is stored, against the package."""

import math

import numpy as np
import pytest
import torch
from sklearn.metrics import accuracy_score, jaccard_score, precision_score, r2_score, recall_score

from dexterity.report.provenance import load_stored
from dexterity.studies.workspace import estimation as study
from dexterity.workspace import dataset, jacobian_net, training

CONFIG = study.CONFIGS["smoke"]


@pytest.fixture(scope="module")
def network():
    return study.best_network(CONFIG)


def test_confidence_scores_are_scikit_learns(network):
    data = dataset.confidence_data(500, 9)
    scores = study._sureness(network, data)["0.25"]
    said = (network.estimate(data.samples).confidence >= 0.25).numpy()
    truth = data.reachable.numpy()
    assert scores.accuracy == pytest.approx(accuracy_score(truth, said))
    assert scores.jaccard == pytest.approx(jaccard_score(truth, said))
    assert scores.precision == pytest.approx(precision_score(truth, said))
    assert scores.recall == pytest.approx(recall_score(truth, said))


def test_both_ways_to_count_constants_are_scikit_learns():
    random = np.random.default_rng(0)
    truth = random.normal(size=(50, 23))
    guess = truth + 0.3 * random.normal(size=truth.shape)
    scores = study.Estimation(0.0, 0.0, 0.0, r2_score(truth, guess), ())
    constants = np.tile([0.0, 1.0], (50, 1))
    known = r2_score(np.hstack([truth, constants]), np.hstack([guess, constants]))
    missed = r2_score(np.hstack([truth, constants]), np.hstack([guess, constants + 1e-9]))
    assert scores.r2_with_ones == pytest.approx(known)
    assert scores.r2_with_nothing == pytest.approx(missed)


def test_errors_of_the_combined_model_are_those_of_its_jacobians(network):
    data = dataset.confidence_data(300, 9)
    combined = study._combined(network, data)
    mask = network.estimate(data.samples).mask
    assert combined.given == pytest.approx(mask.double().mean().item())
    wrong = (mask & ~data.reachable).sum() / (~data.reachable).sum()
    assert combined.wrongly_given == pytest.approx(wrong.item())
    assert 0 < combined.error < combined.worst_error


def test_rises_over_the_fall():
    curve = study.Curve("confidence", (1, 2, 3, 4), (0.0,) * 4, (1.0, 0.4, 0.7, 0.2))
    assert curve.rises == pytest.approx(0.3 / 0.8)
    assert math.isinf(study.Curve("confidence", (1, 2), (0.0,) * 2, (1.0, 2.0)).rises)


def test_the_papers_way_is_what_the_ledger_says():
    paper = study.load_paper("liao2018")
    config = study.CONFIGS["full"]
    assert config.paper_epochs == paper.claim("epochs").value
    options = study._options(study.VARIANTS[study.PAPERS_WAY], config)
    assert len(options.schedule) == config.paper_epochs
    assert options.batch == paper.claim("batch-size").value
    assert options.validation == paper.claim("validation-share").value
    cycle = [epoch.head for epoch in options.schedule[-3:]]
    assert (cycle.count("confidence"), cycle.count("estimation")) == tuple(paper.claim("cycle").value)
    for architecture in (study.VARIANTS[study.PAPERS_WAY].architecture, jacobian_net.PAPER_SIZE):
        assert len(architecture.confidence) + 1 == paper.claim("confidence-layers").value
        assert len(architecture.estimation) + 1 == paper.claim("estimation-layers").value
        assert architecture.dropout == paper.claim("dropout-rate").value
    assert jacobian_net.PAPER_SIZE.encoder[-1] == paper.claim("encoding-size").value


def test_adam_has_the_printed_settings():
    beta1, beta2, rate, epsilon = study.load_paper("liao2018").claim("adam-settings").value
    group = training.OPTIMISERS["Adam"]([torch.zeros(1, requires_grad=True)], lr=rate).param_groups[0]
    assert group["betas"] == (beta1, beta2)
    assert group["eps"] == epsilon
    assert study._options(study.VARIANTS[study.PAPERS_WAY], CONFIG).rate == rate


def test_the_stored_run_has_ten_seeds_of_what_counts():
    stored = load_stored("workspace.estimation").run
    assert len(stored.result.variants[study.PLAIN]) == len(stored.result.variants[study.BEST]) == 10
    assert all(figure.holds for figure in study.acceptance(stored.result))
    assert len(study.acceptance(stored.result)) == 4


def test_each_change_leaves_less_of_the_variance():
    variants = load_stored("workspace.estimation").run.result.variants
    order = (study.COLUMNS, study.RELEVANT, study.PLAIN, study.WORLD, study.BEST)
    left = [np.median([1 - outcome.estimation[0].r2 for outcome in variants[name]]) for name in order]
    assert left == sorted(left, reverse=True)
