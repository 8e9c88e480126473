"""Baselines against scikit-learn, scipy and polynomials that they must find."""

import numpy as np
import pytest
import torch
from scipy.optimize import minimize_scalar
from sklearn.ensemble import HistGradientBoostingRegressor
from sklearn.linear_model import LinearRegression
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import PolynomialFeatures
from torch.testing import assert_close

import dexterity as dx
from dexterity.indices import Index
from dexterity.networks import baselines, validation
from dexterity.networks.network import View
from dexterity.networks.worst_case import Search, worst_case
from dexterity.sampling import DataSet, data_sets, uvms_space

VIEW = View(12, range(4, 11))


@pytest.fixture(scope="module")
def sets():
    exact = Index("manipulability").bind(dx.robots.uvms())
    return data_sets(exact, uvms_space("manipulability"), train=1500, test=200, validation=200)


def x_of(data):
    return data.q[:, 4:11].numpy()


@pytest.mark.parametrize("degree", [1, 2, 3])
def test_polynomials_agree_with_scikit_learn(sets, degree):
    model = make_pipeline(PolynomialFeatures(degree), LinearRegression())
    model.fit(x_of(sets.train), sets.train.values.numpy())
    ours = baselines.polynomial(VIEW, sets.train, degree)
    np.testing.assert_allclose(ours(sets.test.q), model.predict(x_of(sets.test)), rtol=1e-10)


def test_a_cubic_is_found_by_a_cubic(sets):
    def cubic(q):
        return 5 + q[..., 4] * q[..., 6] ** 2 - 3 * q[..., 7] + q[..., 8] * q[..., 9] * q[..., 10]

    data = DataSet(sets.train.q, cubic(sets.train.q))
    found = baselines.polynomial(VIEW, data, 3)
    assert_close(found(sets.test.q), cubic(sets.test.q), rtol=0, atol=1e-11)
    with pytest.raises(AssertionError):
        assert_close(baselines.polynomial(VIEW, data, 2)(sets.test.q), cubic(sets.test.q), rtol=0, atol=1e-4)


def test_the_constant_has_the_least_largest_error(sets):
    def largest(value):
        return validation.judge(baselines.Constant(value, sets.train.q.shape[1]), sets.train).maximum

    best = minimize_scalar(largest, bounds=(10, 15), method="bounded", options={"xatol": 1e-10})
    ours = baselines.constant(sets.train)
    assert ours.value == pytest.approx(best.x, rel=1e-6)
    assert largest(ours.value) <= best.fun


def test_the_worst_case_of_the_constant_is_at_an_extreme_of_the_index(sets):
    exact = Index("manipulability").bind(dx.robots.uvms())
    ours = baselines.constant(sets.train)
    found = worst_case(ours, exact, uvms_space("manipulability"), Search(1024, 128, 16, 40))
    assert found.value == ours.value
    assert found.error > validation.judge(ours, sets.train).maximum


def test_trees_agree_with_scikit_learn(sets):
    model = HistGradientBoostingRegressor(max_iter=1000, early_stopping=True, random_state=3)
    model.fit(x_of(sets.train), sets.train.values.numpy())
    ours = baselines.trees(VIEW, sets.train, 3)
    np.testing.assert_array_equal(ours(sets.test.q), model.predict(x_of(sets.test)))


def test_all_are_functions_of_all_joints(sets, batch_shape):
    fitted = baselines.baselines(VIEW, sets.train)
    assert list(fitted) == ["constant", "quadratic", "cubic", "boosted trees"]
    errors = {name: validation.judge(f, sets.test).maximum for name, f in fitted.items()}
    assert errors["cubic"] < errors["quadratic"] < errors["constant"]
    assert errors["boosted trees"] < errors["constant"]
    count = torch.Size(batch_shape).numel()
    if count:
        for f in fitted.values():
            q = sets.test.q[:count].reshape(*batch_shape, 12)
            assert_close(f(q).reshape(-1), f(sets.test.q)[:count], rtol=1e-12, atol=0)
            assert f(q).shape == batch_shape


def test_polynomials_have_gradients(sets):
    f = baselines.polynomial(VIEW, sets.train, 3)
    assert torch.autograd.gradcheck(f, sets.test.q[:3].clone().requires_grad_())


def rows(values, q=None):
    values = torch.tensor(values, dtype=torch.float64)
    return DataSet(torch.arange(12.0 * len(values)).double().reshape(-1, 12) if q is None else q, values)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: baselines.constant(rows([])), "train has no rows"),
        (lambda: baselines.constant(rows([1.0, 0.0])), r"train holds the value 0\.0"),
        (lambda: baselines.polynomial(VIEW, rows([1.0] * 9), 2), "train has 9 rows; the polynomial has 36"),
        (lambda: baselines.polynomial(VIEW, rows([1.0] * 9), 0), "degree is 0"),
        (
            lambda: baselines.polynomial(VIEW, rows([1.0] * 9, torch.ones(9, 12).double()), 1),
            r"inputs \[0, 1, 2, 3, 4, 5, 6\] do not vary",
        ),
    ],
)
def test_what_nothing_can_be_fitted_to_is_refused(call, message):
    with pytest.raises(ValueError, match=f"^{message}"):
        call()
