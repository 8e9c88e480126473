"""Compiled indices as Python calls them: arrays and tensors, one configuration and many, in threads."""

import pickle
import time

import numpy as np
import pytest
import torch
from numpy.testing import assert_array_equal

import dexterity as dx
from dexterity import symbolic
from dexterity.indices import Index

PUMA = dx.robots.puma560()
BACKENDS = pytest.mark.parametrize("backend", ["c", "torch"])


@BACKENDS
def test_a_configuration_of_numpy_gives_a_number_of_numpy(rng, backend):
    f = symbolic.compile_index(PUMA, Index("manipulability"), backend)
    q = rng.uniform(-1, 1, (5, 6))
    for row in (q[0], q[1, ::-1], q.T.copy()[:, 2], np.asfortranarray(q)[3]):
        assert type(f(row)) is np.float64
        assert f(row) == pytest.approx(float(f(torch.tensor(row.copy()))), rel=1e-13)
    for other in (q, q[0].tolist(), q[0].astype(np.float32), q[0].astype(">f8"), np.arange(6)):
        assert isinstance(f(other), torch.Tensor)
    assert_array_equal(f(q), f(torch.from_numpy(q)))


@BACKENDS
def test_arrays_that_do_not_fit_are_refused(backend):
    f = symbolic.compile_index(PUMA, Index("manipulability"), backend)
    for q, message in (
        (np.zeros(5), r"^q has shape \(5,\); the chain has 6 joints"),
        (np.zeros((3, 7)), r"^q has shape \(3, 7\); the chain has 6 joints"),
        (np.array([0, 0, np.nan, 0, 0, 0.0]), r"^q is not finite"),
        (np.full((2, 6), np.inf), r"^q is not finite"),
    ):
        with pytest.raises(ValueError, match=message):
            f(q)
        with pytest.raises(ValueError, match=message):
            f.value_and_gradient(q)


def test_threads_share_a_batch_without_a_difference(rng):
    one = symbolic.compile_index(PUMA, Index("kinematic_conditioning"), "c")
    for threads in (2, 3):
        several = symbolic.compile_index(PUMA, Index("kinematic_conditioning"), "c", threads=threads)
        several = pickle.loads(pickle.dumps(several))
        for count in (0, 1, 17, 4095, 4096, 10_001):
            q = torch.from_numpy(rng.uniform(-2, 2, (count, 6)))
            for ours, expected in zip(several.value_and_gradient(q), one.value_and_gradient(q), strict=True):
                assert_array_equal(ours, expected)
        q[9_000, 2] = np.nan
        for f in (one, several):
            with pytest.raises(ValueError, match=r"^q is not finite: .*, first in row 9000$"):
                f(q)


@pytest.mark.parametrize("threads", [0, -1, 1.5, "2"])
def test_threads_are_a_whole_number(threads):
    with pytest.raises((TypeError, ValueError), match="threads"):
        symbolic.compile_index(PUMA, "w", "c", threads=threads)


def test_threads_of_torch_are_those_of_torch():
    with pytest.raises(ValueError, match=r"^threads is 2; backend 'torch' uses those of torch"):
        symbolic.compile_index(PUMA, "w", threads=2)


def test_one_configuration_takes_a_fraction_of_the_time_of_torch(rng):
    """A ratio within one run, with room for any machine; the benchmarks have the times."""
    q = rng.uniform(-1, 1, 6)

    def seconds(function) -> float:
        """Return the least processor time of a call, which no other process has stretched."""
        rounds = []
        for _ in range(20):
            start = time.thread_time()
            for _ in range(10):
                function(q)
            rounds.append(time.thread_time() - start)
        return min(rounds)

    index = Index("manipulability")
    assert 10 * seconds(symbolic.compile_index(PUMA, index, "c")) < seconds(index.bind(PUMA))
