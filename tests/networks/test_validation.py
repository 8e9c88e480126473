"""Error distributions against their definition, and the selection effect against probability."""

import math

import numpy as np
import pytest
import torch
from torch.testing import assert_close

from dexterity import sampling
from dexterity.networks import validation
from dexterity.sampling import Box, DataSet

SPACE = Box([-1.0, 0.0, 0.5], [1.0, 0.0, 2.0])


def index(q):
    return 3.0 + q[..., 0] * q[..., 2]


def off(q):
    """Be off by a tenth of the square of the first coordinate, relatively, now more and now less."""
    return index(q) * (1 + 0.1 * q[..., 0] ** 2 * q[..., 0].sign())


@pytest.mark.parametrize("method", ["sobol", "uniform"])
def test_the_distribution_is_that_of_the_error(method):
    told = validation.error_distribution(off, index, SPACE, 1 << 16, seed=3, method=method)
    assert told.count == 1 << 16
    # x uniform in [−1, 1], |error| = 0.1 x²; five standard deviations of independent draws, and more.
    expected = {
        "mean": 0.1 / 3, "root_mean_square": 0.1 / math.sqrt(5), "median": 0.1 / 4, "percentile_90": 0.081,
        "percentile_99": 0.1 * 0.99**2, "percentile_99_9": 0.1 * 0.999**2, "maximum": 0.1,
    }  # fmt: skip
    for name, value in expected.items():
        assert getattr(told, name) == pytest.approx(value, abs=6e-4), name
    assert told.maximum <= 0.1
    at_worst = torch.tensor(told.worst, dtype=torch.float64)
    assert abs(off(at_worst) / index(at_worst) - 1) == pytest.approx(told.maximum, rel=1e-12)


def test_percentiles_are_those_of_numpy_however_many_pieces(rng):
    q = torch.as_tensor(rng.uniform(-1, 1, (40_000, 3)))
    data = DataSet(q, index(q) + 4)
    errors = np.abs(off(q).numpy() / data.values.numpy() - 1)
    told = validation.judge(off, data)
    assert told.percentile_99 == pytest.approx(np.quantile(errors, 0.99), rel=1e-12)
    assert told.maximum == pytest.approx(errors.max(), rel=1e-12)
    assert_close(validation.relative_errors(off, data).abs().numpy(), errors)


def test_fresh_points_come_again_with_their_seed_alone():
    one, again, other = (validation.fresh(index, SPACE, 100, seed) for seed in (0, 0, 1))
    assert torch.equal(one.q, again.q)
    assert torch.equal(one.values, index(one.q))
    assert SPACE.contains(one.q).all()
    assert not torch.equal(one.q, other.q)


def test_a_distribution_remembers_no_gradients():
    factor = torch.ones((), dtype=torch.float64, requires_grad=True)
    data = validation.fresh(index, SPACE, 10)
    assert not validation.relative_errors(lambda q: factor * off(q), data).requires_grad


@pytest.mark.parametrize(
    ("f", "exact", "message"),
    [
        (lambda q: q, index, r"f\(q\) has shape \(10, 3\)"),
        (lambda q: off(q) * math.nan, index, r"f\(q\) is not finite"),
        (off, lambda q: q[..., 1], "data holds a value of zero"),
        (off, lambda q: q[..., 0] / 0, r"index\(q\) is not finite"),
        (off, lambda q: q[0, 0], r"index\(q\) has shape \(\)"),
    ],
)
def test_functions_that_cannot_be_compared_are_refused(f, exact, message):
    with pytest.raises(ValueError, match=f"^{message}"):
        validation.error_distribution(f, exact, SPACE, 10)


def test_other_bad_input_is_refused():
    with pytest.raises(ValueError, match=r"^data has no rows"):
        validation.judge(off, DataSet(torch.zeros(0, 3, dtype=torch.float64), torch.zeros(0).double()))
    with pytest.raises(ValueError, match=r"^count is 0"):
        validation.error_distribution(off, index, SPACE, 0)


def test_an_unknown_method_is_refused(annotations_unchecked):
    with pytest.raises(ValueError, match=r"^method is 'grid'"):
        validation.error_distribution(off, index, SPACE, 10, method="grid")


# ---- the selection effect --------------------------------------------------------------------------


def spiked(share):
    """Return something exact but for a share of the space, where it is off by five per cent."""
    return lambda q: index(q) * (1 + 0.05 * (q[..., 0] > 1 - 2 * share).double())


def test_what_passes_a_small_test_set_often_breaks_the_limit():
    """Networks with a bad share of 1e-3 pass 1 000 points as often as probability says."""
    fresh = validation.fresh(index, SPACE, 50_000, seed=99)
    accepted = []
    for seed in range(200):
        q = sampling.uniform(SPACE, 1000, torch.Generator().manual_seed(seed))
        bias = validation.acceptance_bias([spiked(1e-3)], DataSet(q, index(q)), fresh, limit=0.02)
        assert bias.shares[0] == pytest.approx(1e-3, abs=1e-4)
        assert bias.fresh[0] == pytest.approx(0.05, rel=1e-9)
        accepted.append(bool(bias.accepted[0]))
        if accepted[-1]:
            assert bias.broken_share == 1.0
        else:
            assert math.isnan(bias.broken_share)
    expected = validation.passing_probability(1e-3, 1000)
    assert np.mean(accepted) == pytest.approx(expected, abs=4 * math.sqrt(expected / 200))


def test_shares_among_several_networks():
    test, fresh = (validation.fresh(index, SPACE, n, seed=n, method="uniform") for n in (1000, 20_000))
    networks = [spiked(0.0), spiked(1e-4), spiked(0.1)]
    bias = validation.acceptance_bias(networks, test, fresh, limit=0.02)
    assert (bias.test_points, bias.fresh_points) == (1000, 20_000)
    assert bias.accepted.tolist() == [True, True, False]
    assert bias.broken_share == 0.5
    assert bias.expected_share == pytest.approx((1 + (1 - bias.shares[1]) ** 1000) / 3, rel=1e-9)


def test_probabilities_at_both_ends():
    assert validation.passing_probability(0.0) == 1.0
    assert validation.passing_probability(1.0) == 0.0
    assert validation.passing_probability(0.5, 3) == 0.125


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda data: validation.acceptance_bias([], data, data, 0.02), "networks is empty"),
        (lambda data: validation.acceptance_bias([off], data, data, 0.0), r"limit is 0\.0"),
        (lambda data: validation.acceptance_bias([off], data, data, math.nan), "limit is nan"),
        (lambda data: validation.passing_probability(1.5), r"share is 1\.5"),
        (lambda data: validation.passing_probability(0.5, 0), "points is 0"),
    ],
)
def test_a_selection_without_sense_is_refused(call, message):
    with pytest.raises(ValueError, match=f"^{message}"):
        call(validation.fresh(index, SPACE, 10))
