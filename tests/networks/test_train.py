"""Networks for several seeds, against the same networks trained by hand."""

import pytest
import torch

from dexterity.networks import train
from dexterity.networks.feed_forward import FeedForward
from dexterity.networks.levenberg_marquardt import Options, levenberg_marquardt
from dexterity.networks.network import View

VIEW = View(3, [0, 2])
SHORT = Options(epochs=4)


def rows(count, seed):
    q = 2 * torch.rand(count, 3, dtype=torch.float64, generator=torch.Generator().manual_seed(seed)) - 1
    return q, 2 + torch.sin(q[:, 0]) * q[:, 2]


def untrained(q, values, seed):
    return FeedForward.untrained(VIEW, 4, q, values, torch.Generator().manual_seed(seed))


def assert_same(network, other):
    for name, tensor in network.state_dict().items():
        torch.testing.assert_close(tensor, other.state_dict()[name], rtol=0, atol=0)


def test_one_seed_gives_the_bits_of_a_training_by_itself():
    q, values = rows(40, 0)
    (training,) = train.for_seeds(VIEW, 4, q, values, (7,), SHORT)
    by_hand = levenberg_marquardt(untrained(q, values, 7), q, values, SHORT)
    assert training.history == by_hand.history
    assert_same(training.network, by_hand.network)


def test_seeds_are_trained_in_their_order_on_shared_rows():
    q, values = rows(40, 0)
    trainings = train.for_seeds(VIEW, 4, q, values, (3, 1), SHORT)
    by_hand = levenberg_marquardt([untrained(q, values, seed) for seed in (3, 1)], q, values, SHORT)
    for training, expected in zip(trainings, by_hand, strict=True):
        assert_same(training.network, expected.network)


def test_each_seed_may_have_rows_of_its_own():
    sets = [rows(40, 0), rows(40, 1)]
    q, values = (torch.stack(parts) for parts in zip(*sets, strict=True))
    trainings = train.for_seeds(VIEW, 4, q, values, (3, 1), SHORT)
    for training, (x, y), seed in zip(trainings, sets, (3, 1), strict=True):
        alone = levenberg_marquardt(untrained(x, y, seed), x, y, SHORT)
        torch.testing.assert_close(torch.tensor(training.history), torch.tensor(alone.history))


def test_the_readout_is_that_of_the_networks():
    q, values = rows(40, 0)
    (network,) = train.initial_networks(VIEW, 4, q, values, (0,), "triple")
    assert network.readout == "triple"


def test_no_seeds_and_a_wrong_number_of_training_sets_are_refused():
    q, values = rows(40, 0)
    with pytest.raises(ValueError, match="seeds is empty"):
        train.for_seeds(VIEW, 4, q, values, ())
    with pytest.raises(ValueError, match="one for each of 2 seeds"):
        train.for_seeds(VIEW, 4, q[None], values[None], (0, 1))
