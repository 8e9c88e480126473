"""Feed-forward networks against the printed formulas written out in numpy."""

import math

import numpy as np
import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st
from torch.testing import assert_close

from dexterity.networks.feed_forward import FeedForward
from dexterity.networks.network import View

VIEW = View(5, [0, 2, 3])
OUTPUTS = {"identity": 1, "reciprocal": 1, "logarithm": 1, "cone": 3, "triple": 6}


def arrays(neurons=4, outputs=1, values=1, seed=0):
    draw = np.random.default_rng(seed)
    return {
        "hidden_weights": draw.normal(size=(neurons, 3)), "hidden_biases": draw.normal(size=neurons),
        "output_weights": draw.normal(size=(outputs, neurons)), "output_biases": draw.normal(size=outputs),
        "input_centre": draw.normal(size=3), "input_half_range": draw.uniform(1, 2, 3),
        "target_centre": draw.normal(size=values) + 9, "target_half_range": 0.7,
    }  # fmt: skip


def printed(weights, row):
    """Eqs. 13 to 16, neuron by neuron, between the scaling of inputs and that of outputs."""
    x = (row - weights["input_centre"]) / weights["input_half_range"]
    hidden = []
    for into, bias in zip(weights["hidden_weights"], weights["hidden_biases"], strict=True):
        gamma = sum(w * x_i for w, x_i in zip(into, x, strict=True)) + bias
        hidden.append((math.exp(gamma) - math.exp(-gamma)) / (math.exp(gamma) + math.exp(-gamma)))
    return [
        sum(w * h for w, h in zip(out, hidden, strict=True)) + bias
        for out, bias in zip(weights["output_weights"], weights["output_biases"], strict=True)
    ]


def read(readout, u, weights):
    if readout == "cone":
        u = [u[0] - math.hypot(u[1], u[2])]
    if readout == "triple":
        matrix = [[u[0], u[3], u[4]], [u[3], u[1], u[5]], [u[4], u[5], u[2]]]
        u = [np.linalg.eigvalsh(matrix)[0]]
    target = u[0] * weights["target_half_range"] + weights["target_centre"][0]
    return {"identity": target, "reciprocal": 1 / target}.get(readout, math.exp(target))


@pytest.mark.parametrize("readout", OUTPUTS)
def test_values_are_those_of_the_equations(readout, rng):
    weights = arrays(outputs=OUTPUTS[readout])
    q = rng.normal(size=(20, 5))
    expected = [read(readout, printed(weights, row[[0, 2, 3]]), weights) for row in q]
    np.testing.assert_allclose(FeedForward(VIEW, readout, weights)(q).detach(), expected, rtol=1e-12)


def test_several_values(rng):
    weights = arrays(outputs=2, values=2)
    q = rng.normal(size=(6, 5))
    expected = [np.array(printed(weights, row[[0, 2, 3]])) * 0.7 + weights["target_centre"] for row in q]
    network = FeedForward(VIEW, "identity", weights)
    assert network.values == 2
    np.testing.assert_allclose(network(q).detach(), expected, rtol=1e-12)


@pytest.mark.parametrize("readout", OUTPUTS)
def test_gradients(readout, rng):
    network = FeedForward(VIEW, readout, arrays(outputs=OUTPUTS[readout]))
    q = torch.from_numpy(rng.normal(size=(3, 5))).requires_grad_()
    assert torch.autograd.gradcheck(network, q)


def test_batch_axes_are_kept(batch_shape, rng):
    network = FeedForward(VIEW, "identity", arrays())
    q = torch.from_numpy(rng.normal(size=(*batch_shape, 5)))
    values = network(q)
    assert values.shape == batch_shape
    assert_close(values.flatten(), network(q.reshape(-1, 5)), rtol=1e-13, atol=1e-13)


@given(neurons=st.integers(1, 12), readout=st.sampled_from(sorted(OUTPUTS)), seed=st.integers(0, 99))
def test_untrained_networks_are_scaled_to_their_rows(neurons, readout, seed):
    draw = np.random.default_rng(seed)
    q, y = draw.uniform(-3, 5, (40, 5)), draw.uniform(1, 9, 40)
    network = FeedForward.untrained(VIEW, neurons, q, y, torch.Generator().manual_seed(seed), readout)
    x = (VIEW(q) - network.input_centre) / network.input_half_range
    assert_close(x.amax(0), torch.ones(3, dtype=torch.float64), rtol=1e-12, atol=0)
    assert_close(x.amin(0), -torch.ones(3, dtype=torch.float64), rtol=1e-12, atol=0)
    again = FeedForward.untrained(VIEW, neurons, q, y, torch.Generator().manual_seed(seed), readout)
    assert torch.equal(again(q), network(q))
    # The rule of Nguyen and Widrow: weights of equal length, 0.7 times a root of the number of neurons.
    lengths = network.hidden_weights.detach().norm(dim=-1)
    assert_close(lengths, torch.full_like(lengths, 0.7 * neurons ** (1 / 3)), rtol=1e-12, atol=0)
    assert network.hidden_biases.abs().max() <= 0.7 * neurons ** (1 / 3) * (1 + 1e-12)
    assert network.output_weights.abs().max() <= 0.5


def test_bad_arrays(rng):
    good = arrays()
    bad = [
        ({"hidden_weights": np.ones((4, 2))}, "hidden_weights has shape"),
        ({"output_biases": np.ones(2)}, "output_biases has shape"),
        ({"hidden_biases": np.ones(0)}, "at least one element"),
        ({"input_half_range": np.zeros(3)}, "must be positive"),
        ({"target_half_range": -1.0}, "must be positive"),
        ({"hidden_biases": np.full(4, math.nan)}, "finite"),
        ({"more": 1.0}, "there are arrays"),
    ]
    for change, message in bad:
        with pytest.raises(ValueError, match=message):
            FeedForward(VIEW, "identity", good | change)
    with pytest.raises(ValueError, match="one value"):
        FeedForward(VIEW, "cone", arrays(outputs=3, values=2))


def test_bad_training_sets(rng, annotations_unchecked):
    q, y = rng.normal(size=(10, 5)), rng.uniform(1, 2, 10)
    still = q.copy()
    still[:, 2] = 0.5
    bad = [
        (0, q, y, "identity", "neurons is 0"),
        (3, q, y, "square", "readout is 'square'"),
        (3, q[:0], y[:0], "identity", "rows"),
        (3, q, y[:5], "identity", r"q has shape \(10,.*values \(5,"),
        (3, still, y, "identity", r"inputs \[1\] of the network do not vary"),
        (3, q, np.ones(10), "identity", "nothing to learn"),
        (3, q, -y, "logarithm", "needs positive"),
        (3, q, np.stack([y, y], -1), "cone", "one value"),
        (3, q * math.nan, y, "identity", "finite"),
        (3, q, y * math.inf, "identity", "finite"),
    ]
    for neurons, rows, values, readout, message in bad:
        with pytest.raises(ValueError, match=message):
            FeedForward.untrained(VIEW, neurons, rows, values, torch.Generator(), readout)
    with pytest.raises(ValueError, match="readout is"):
        FeedForward(VIEW, "square", arrays())
