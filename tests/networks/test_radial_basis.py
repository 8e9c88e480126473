"""Radial-basis networks against Eqs. 16–18 written out, scipy, scikit-learn and finite differences."""

import math

import numpy as np
import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st
from scipy.interpolate import RBFInterpolator
from scipy.spatial.distance import cdist
from sklearn.metrics.pairwise import rbf_kernel
from torch.testing import assert_close

import dexterity as dx
from dexterity.networks.network import View
from dexterity.networks.radial_basis import BIAS, RadialBasis, bells

VIEW = View(5, [0, 2, 3])


def arrays(neurons=4, inputs=3, spread=0.7, scale=1.0, seed=0):
    draw = np.random.default_rng(seed)
    return {
        "centres": draw.normal(size=(neurons, inputs)), "spread": spread,
        "output_weights": draw.normal(size=neurons), "output_bias": draw.normal(),
        "input_scale": np.full(inputs, scale),
    }  # fmt: skip


def printed(weights, x):
    """Eqs. 16 to 18 for one row, term by term, with the norm."""
    hidden = [
        math.exp(-((0.833 / weights["spread"] * math.dist(weights["input_scale"] * x, centre)) ** 2))
        for centre in weights["centres"]
    ]
    return sum(v * h for v, h in zip(weights["output_weights"], hidden, strict=True)) + weights["output_bias"]


@pytest.mark.parametrize("scale", [1.0, 180 / math.pi])
def test_values_are_those_of_the_equations(rng, scale):
    weights = arrays(spread=0.7 * scale, scale=scale)
    q = rng.normal(size=(20, 5))
    expected = [printed(weights, row[[0, 2, 3]]) for row in q]
    np.testing.assert_allclose(RadialBasis(VIEW, weights)(q).detach(), expected, rtol=1e-13)


def test_hidden_answers_are_gaussian_kernels(rng):
    weights = arrays(spread=1.3)
    x = rng.normal(size=(50, 3))
    kernel = rbf_kernel(x, weights["centres"], gamma=(0.833 / 1.3) ** 2)
    np.testing.assert_allclose(
        RadialBasis(VIEW, weights).hidden(torch.as_tensor(x)).detach(), kernel, rtol=1e-13
    )


def test_weights_of_an_interpolant_give_its_values(rng):
    x, y, fresh = rng.normal(size=(30, 3)), rng.normal(size=30), rng.normal(size=(100, 3))
    # The polynomial of degree −1 is none; there is no bias then.
    spread = 0.6
    oracle = RBFInterpolator(x, y, kernel="gaussian", epsilon=BIAS / spread, degree=-1)
    weights = np.linalg.solve(np.exp(-((cdist(x, x) * BIAS / spread) ** 2)), y)
    network = RadialBasis(View(3, range(3)), {
        "centres": x, "spread": spread, "output_weights": weights, "output_bias": 0.0,
        "input_scale": np.ones(3),
    })  # fmt: skip
    np.testing.assert_allclose(network(fresh).detach(), oracle(fresh), rtol=1e-7, atol=1e-8)


@given(spread=st.floats(1e-2, 1e2), share=st.floats(0, 3), seed=st.integers(0, 9))
def test_a_neuron_answers_about_a_half_at_its_spread(spread, share, seed):
    direction = torch.randn(7, generator=torch.Generator().manual_seed(seed), dtype=torch.float64)
    centre = torch.randn(1, 7, generator=torch.Generator().manual_seed(seed + 10), dtype=torch.float64)
    x = centre[0] + share * spread * direction / direction.norm()
    answer = bells(x, centre, spread)[0].item()
    assert answer == pytest.approx(math.exp(-((0.833 * share) ** 2)), rel=1e-9)
    assert (answer >= math.exp(-(0.833**2))) == (share <= 1) or share == pytest.approx(1, abs=1e-9)
    assert math.exp(-(0.833**2)) == pytest.approx(0.4996, abs=5e-5)


def test_multiplying_out_distances_loses_nothing(rng):
    # Centres that lie far from the origin, and a spread from small to large against their distances.
    centres, x = (torch.as_tensor(rng.uniform(999, 1001, (n, 7))) for n in (50, 200))
    for spread in (0.1, 1.0, 10.0):
        distances = np.square(x.numpy().astype(np.longdouble)[:, None] - centres.numpy()).sum(-1)
        expected = np.exp(-distances * (np.longdouble(BIAS) / spread) ** 2).astype(float)
        np.testing.assert_allclose(bells(x, centres, spread), expected, rtol=0, atol=1e-15)


def test_units_of_inputs_are_a_matter_of_scale_and_spread(rng):
    in_radians, q = arrays(), rng.normal(size=(20, 5))
    in_degrees = in_radians | {
        "centres": np.degrees(in_radians["centres"]), "spread": math.degrees(in_radians["spread"]),
        "input_scale": np.full(3, 180 / math.pi),
    }  # fmt: skip
    assert_close(RadialBasis(VIEW, in_degrees)(q), RadialBasis(VIEW, in_radians)(q), rtol=1e-12, atol=0)


def test_any_batch_is_answered_row_by_row(batch_shape, rng):
    network = RadialBasis(VIEW, arrays())
    q = torch.as_tensor(rng.normal(size=(*batch_shape, 5)))
    values = network(q)
    assert values.shape == batch_shape
    for row, value in zip(q.reshape(-1, 5), values.flatten(), strict=True):
        assert_close(network(row), value, rtol=1e-13, atol=0)


def test_gradients_agree_with_finite_differences(rng):
    network = RadialBasis(VIEW, arrays())
    q = torch.as_tensor(rng.normal(size=(6, 5)))
    # Two rows at a centre, where a distance has no gradient but its square does.
    q[:2, [0, 2, 3]] = network.centres.detach()[:2]
    q.requires_grad_()
    assert torch.autograd.gradcheck(network, q)
    assert torch.autograd.gradgradcheck(network, q)
    names = [name for name, _ in network.named_parameters()]
    weights = [parameter.detach().requires_grad_() for parameter in network.parameters()]
    assert sorted(names) == ["centres", "output_bias", "output_weights"]
    call = lambda *new: torch.func.functional_call(network, dict(zip(names, new, strict=True)), (q.detach(),))  # noqa: E731
    assert torch.autograd.gradcheck(call, weights)


def test_it_sees_the_world_from_a_link_as_other_networks_do(rng):
    chain = dx.robots.uvms()
    view = View(12, range(4, 11), chain.screws[:4])
    network = RadialBasis(view, arrays(inputs=10))
    q = torch.as_tensor(rng.normal(size=(8, 12)))
    assert network.inputs == tuple(range(4, 11))
    assert network.joints == 12
    assert network.neurons == 4
    assert_close(network(q), network.answer(view(q)), rtol=0, atol=0)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"output_weights": []}, "output_weights needs at least one"),
        ({"centres": np.zeros((4, 2))}, r"centres has shape \(4, 2\); \(4, 3\)"),
        ({"centres": np.full((4, 3), np.nan)}, "centres is not finite"),
        ({"spread": 0.0}, r"spread is 0\.0; positive"),
        ({"spread": -1.0}, r"spread is -1\.0; positive"),
        ({"spread": [1.0]}, r"spread has shape \(1,\)"),
        ({"input_scale": [1.0, 0.0, 1.0]}, "input_scale is .*; positive"),
        ({"further": 1.0}, "there are arrays"),
    ],
)
def test_arrays_that_make_no_network_are_refused(change, message):
    with pytest.raises(ValueError, match=f"^{message}"):
        RadialBasis(VIEW, arrays() | change)


def test_a_missing_array_is_refused():
    for name in arrays():
        with pytest.raises(ValueError, match=r"^(there are arrays|output_weights)"):
            RadialBasis(VIEW, {key: array for key, array in arrays().items() if key != name})


def test_the_wrong_joints_are_refused():
    network = RadialBasis(VIEW, arrays())
    with pytest.raises(ValueError, match=r"^q has shape \(4,\); the chain has 5 joints"):
        network(np.zeros(4))
    with pytest.raises(ValueError, match=r"^q is not finite"):
        network(np.full(5, np.inf))
