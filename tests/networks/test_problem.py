"""What a design loop refuses to begin with, and its measure of error."""

import dataclasses

import numpy as np
import pytest
import torch

from dexterity import sampling
from dexterity.networks.network import View
from dexterity.networks.problem import DesignProblem, largest_relative_error
from dexterity.sampling import Box, DataSet

SPACE = Box([-1.0] * 3, [1.0] * 3)
DATA = sampling.data_sets(
    lambda q: 3 + q.sum(-1) / 2, SPACE, train=50, test=20, validation=20, method="uniform"
)
VIEW = View(3, range(3))


def with_set(name, **change):
    data = getattr(DATA, name)
    changed = DataSet(change.get("q", data.q), change.get("values", data.values))
    return dataclasses.replace(DATA, **{name: changed})


def test_the_error_is_the_largest_relative_one():
    values = DATA.test.values
    factors = torch.linspace(0.9, 1.05, len(values), dtype=torch.float64)
    assert largest_relative_error(lambda q: values * factors, DATA.test) == pytest.approx(0.1, rel=1e-12)
    # Against the exact value and not the answer, and whatever its sign.
    below = DataSet(DATA.test.q, -values)
    assert largest_relative_error(lambda q: -2 * values, below) == pytest.approx(1.0, rel=1e-12)


@pytest.mark.parametrize("name", ["train", "test", "validation"])
@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"q": torch.zeros(0, 3).double(), "values": torch.zeros(0).double()}, r"q has shape \(0, 3\)"),
        ({"q": torch.zeros(20, 4).double(), "values": torch.ones(20).double()}, r"q has shape \(20, 4\)"),
    ],
)
def test_broken_data_are_refused(name, change, message):
    with pytest.raises(ValueError, match=rf"^{name}\.{message}"):
        DesignProblem(VIEW, with_set(name, **change))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"values": DATA.train.values * np.nan}, "values is not finite"),
        ({"q": DATA.train.q / 0}, "q is not finite"),
        ({"values": torch.ones(7).double()}, "values holds 7 numbers; q has"),
        ({"q": torch.ones(7).double()}, r"q has shape \(7,\)"),
        ({"values": DATA.train.q}, "values has shape"),
    ],
)
def test_a_data_set_that_is_none_is_refused(annotations_unchecked, change, message):
    with pytest.raises(ValueError, match=f"^{message}"):
        dataclasses.replace(DATA.train, **change)


def test_a_data_set_does_not_change_with_the_arrays_it_was_made_of():
    q, values = DATA.train.q.clone(), DATA.train.values.clone()
    kept = DataSet(q, values)
    q.zero_(), values.zero_()
    assert torch.equal(kept.q, DATA.train.q)
    assert torch.equal(kept.values, DATA.train.values)


def test_values_of_zero_have_no_relative_error():
    for name in ("test", "validation"):
        values = getattr(DATA, name).values.clone()
        values[3] = 0
        with pytest.raises(ValueError, match=f"^{name} holds a value of 0"):
            DesignProblem(VIEW, with_set(name, values=values))


def test_a_constant_is_nothing_to_learn():
    with pytest.raises(ValueError, match=r"^train holds one value, 2\.0"):
        DesignProblem(VIEW, with_set("train", values=torch.full_like(DATA.train.values, 2.0)))
