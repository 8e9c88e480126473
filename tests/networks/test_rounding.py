"""Rounding in the answers of networks: estimates bound what is seen, and cancelling weights are found."""

import copy

import numpy as np
import pytest
import torch
from mpmath import mp

from dexterity import networks, sampling
from dexterity.networks import design, growth, problem, pruning
from dexterity.networks.network import View
from dexterity.networks.radial_basis import RadialBasis
from dexterity.networks.rounding import rounding
from example_networks import JOINTS, PLAIN, examples, feed_forward, random_configurations

NETWORKS = examples()


@pytest.mark.parametrize("network", NETWORKS.values(), ids=NETWORKS)
def test_the_estimate_bounds_what_a_small_change_of_every_weight_does(rng, network):
    """Evaluation errs by no more than a relative change of all weights by a rounding error does."""
    q = random_configurations(rng, 100)
    size = 1e-9
    found = rounding(network, q)
    changed = copy.deepcopy(network)
    with torch.no_grad():
        for parameter in changed.parameters():
            signs = torch.from_numpy(rng.choice([-1.0, 1.0], size=tuple(parameter.shape)))
            parameter.mul_(1 + size * signs)
        seen = ((changed(q) - network(q)) / network(q)).abs().max()
    assert float(seen) < 1.01 * size * found.amplification


@pytest.mark.parametrize("network", NETWORKS.values(), ids=NETWORKS)
def test_single_precision_errs_by_the_amplification(rng, network):
    found = rounding(network, random_configurations(rng, 200))
    assert 0 < found.single < 10 * found.amplification * torch.finfo(torch.float32).eps
    assert found.double == found.amplification * torch.finfo(torch.float64).eps


def cancelling(weight):
    """Two RBF units beside each other, which almost cancel."""
    arrays = {
        "centres": [[0.5] * 5, [0.5 + 1e-9] * 5],
        "spread": 5.0,
        "output_weights": [weight, -weight],
        "output_bias": 1.0,
        "input_scale": [1.0] * 5,
    }
    return RadialBasis(PLAIN, arrays)


def test_huge_weights_that_cancel_are_found(rng):
    q = random_configurations(rng, 50)
    assert rounding(cancelling(1.0), q).double < 1e-13
    found = rounding(cancelling(1e12), q)
    assert found.double > 1e-6
    assert found.single > 1e-2


def test_the_estimate_bounds_the_error_against_fifty_digits(rng):
    network = cancelling(1e10)
    arrays = {name: tensor.numpy() for name, tensor in network.state_dict().items()}
    with mp.workdps(50):
        for q in random_configurations(rng, 10):
            x = [mp.mpf(float(q[joint])) for joint in network.inputs]
            width = mp.mpf(0.833) / mp.mpf(5)
            exact = mp.mpf(1)
            for centre, weight in zip(arrays["centres"], arrays["output_weights"], strict=True):
                square = sum(((a - mp.mpf(float(c))) * width) ** 2 for a, c in zip(x, centre, strict=True))
                exact += mp.mpf(float(weight)) * mp.exp(-square)
            error = float(abs(mp.mpf(network(q).item()) / exact - 1))
            assert error <= rounding(network, q[None]).double


def test_a_sum_of_exactly_nothing_has_no_digit():
    arrays = {"centres": [[0.0]], "spread": 1.0, "output_weights": [1.0], "output_bias": -1.0}
    network = RadialBasis(View(1, [0]), arrays | {"input_scale": [1.0]})
    assert rounding(network, [[0.0]]).double == np.inf


@pytest.mark.parametrize("name", networks.shipped())
def test_shipped_networks_are_more_than_rounding(name):
    network = networks.load_shipped(name)
    found = rounding(network, sampling.sobol(network.card.space(), 1024, 1))
    assert found.double < 1e-9
    assert found.single < 0.5 * network.card["worst_case"]["error"]


def test_what_is_no_row_is_refused(rng):
    with pytest.raises(ValueError, match=r"^q has shape \(\)"):
        rounding(feed_forward(rng, "identity"), [0.0] * JOINTS)


# ---- loops that accept networks --------------------------------------------------------------------


def small_problem(function):
    space = sampling.Box([-1.0, -1.0], [1.0, 1.0])
    data = sampling.data_sets(function, space, train=80, test=40, validation=40, method="sobol")
    return problem.DesignProblem(View(2, [0, 1]), data)


@pytest.mark.parametrize("share", [1e-3, 1e-300])
def test_design_loops_accept_no_network_whose_answers_are_rounding(monkeypatch, share):
    """A huge spread makes RBF units that almost cancel; the share decides what is still an answer."""
    learned = small_problem(lambda q: 2 + q[:, 0].sin())
    monkeypatch.setattr("dexterity.networks.rounding.SHARE", share)
    accepts = share == 1e-3
    options = growth.RadialBasisOptions(neuron_limit=40)
    grown = growth.grow(learned, 1.0, options)
    assert grown.success == accepts
    assert pruning.prune(learned, grown.network).success == accepts
    few = design.FeedForwardOptions(neuron_limit=3, epoch_limit=30)
    assert design.design_feed_forward(learned, few, progress=False).success == accepts


def test_weights_that_cancel_to_the_last_digit_do_not_pass():
    """At a spread of 1e5 the weights are 1e9 and more; their sum keeps few digits."""
    learned = small_problem(lambda q: 2 + (3 * q[:, 0]).sin())
    for spread in (30.0, 1e3, 1e5):
        grown = growth.grow(learned, spread, growth.RadialBasisOptions(testing_error=0.05, neuron_limit=40))
        found = rounding(grown.network, learned.data.test.q)
        assert not grown.success or found.double <= 1e-3 * 0.05
