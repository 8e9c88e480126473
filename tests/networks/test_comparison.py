"""Fits and times that networks are compared with."""

import pytest
import torch

import dexterity as dx
from dexterity.networks import comparison
from dexterity.networks.network import View
from dexterity.sampling import Box, DataSet, sobol
from dexterity.timing import Timing

SPACE, VIEW = Box([-1.0, -1.0], [1.0, 1.0]), View(2, [0, 1])


def rows(function, count=200):
    q = sobol(SPACE, count, 0)
    return DataSet(q, function(q))


def test_fits_are_exact_where_they_can_be():
    linear = rows(lambda q: 3 + q[:, 0] - 2 * q[:, 1] + 1)
    cubic = rows(lambda q: 3 + q[:, 0] ** 3 - q[:, 1] * q[:, 0] ** 2)
    for data, name in ((linear, "linear"), (cubic, "cubic")):
        fitted = comparison.fits(VIEW, data)
        torch.testing.assert_close(fitted[name](data.q), data.values, rtol=0, atol=1e-12)


def test_few_rows_leave_out_the_cubic():
    assert list(comparison.fits(VIEW, rows(lambda q: 3 + q[:, 0], 9))) == ["constant", "linear"]


def test_with_a_scale_the_constant_is_the_middle():
    data = rows(lambda q: q[:, 0])
    middle = (data.values.min() + data.values.max()) / 2
    assert comparison.fits(VIEW, data, scale=2.0)["constant"](data.q[0]) == pytest.approx(float(middle))


def test_overlapping_quartiles_are_no_gain():
    def timing(name, *quartiles):
        return Timing(name, 10, *quartiles)

    apart = comparison.Times(timing("exact", 3.9, 4.0, 4.1), timing("network", 1.9, 2.0, 2.1), ("C", "C"))
    overlap = comparison.Times(
        timing("exact", 1.0, 4.0, 4.1), timing("network", 1.9, 2.0, 2.1), ("torch", "C")
    )
    assert (apart.ratio, overlap.ratio) == (2.0, 1.0)
    assert overlap.entry()["exact_over_network"] == "indistinguishable"
    assert (apart.language, overlap.language) == ("C", "torch (exact) and C (network)")


def test_times_are_those_of_both():
    q = sobol(SPACE, 100, 0)
    network = dx.networks.FeedForward.untrained(VIEW, 3, q, q.sum(-1), torch.Generator().manual_seed(0))
    measured = comparison.times(lambda q: q.sum(-1), network, q, "torch", rounds=1, seconds=0.001)
    assert measured.languages[0] == "torch"
    assert set(measured.entry()["ns_per_configuration"]) == {"exact", "network"}
