"""The thesis's networks: their sizes, what they see, and that training teaches them."""

import pytest
import torch
from torch.testing import assert_close

from dexterity import crane
from dexterity.crane.positioning import (
    correction_network,
    direct_network,
    inverse_network,
    learning,
    modular_network,
)

DATA = crane.training_set()
SEES = {
    "correction": (correction_network, DATA.rows[:, :4], DATA.deflection, 14),
    "direct": (direct_network, DATA.rows[:, :4], DATA.tip, 18),
    "modular": (modular_network, DATA.rows[:, :4], DATA.tip, 30),
    "inverse": (
        inverse_network, torch.cat([DATA.tip, DATA.rows[:, [3, 2]]], dim=-1), DATA.strokes[:, :2], 19
    ),
}  # fmt: skip


def generator(seed: int = 0) -> torch.Generator:
    return torch.Generator().manual_seed(seed)


def mean_miss(network, x, y):
    with torch.no_grad():
        return (network(x) - y).norm(dim=-1).mean().item()


@pytest.mark.parametrize("name", SEES)
def test_training_teaches_each_network(name):
    make, x, y, neurons = SEES[name]
    network = make(DATA, generator(), epochs=15)
    assert network.neurons == neurons
    assert network.values == 2
    spread = (y - y.mean(0)).norm(dim=-1).mean().item()
    assert mean_miss(network, x, y) < 0.2 * spread
    again, other = make(DATA, generator(), epochs=2), make(DATA, generator(1), epochs=2)
    assert torch.equal(again(x[:5]), make(DATA, generator(), epochs=2)(x[:5]))
    assert not torch.equal(again(x[:5]), other(x[:5]))


def test_the_sum_of_two_networks_is_one_network():
    """Eq. 64, with the rigid network blind to the payload."""
    x = DATA.rows[:, :4]
    rigid = learning._trained(learning._SEES_STROKES, x, DATA.tip, 5, 2, generator())
    rest = learning._trained(learning._SEES_ALL, x, DATA.deflection, 4, 2, generator(1))
    both = learning._sum(rigid, rest)
    assert both.neurons == 9
    with torch.no_grad():
        assert_close(both(x), rigid(x) + rest(x), rtol=0, atol=1e-12)


def test_a_modular_network_makes_up_for_its_rigid_one():
    x = DATA.rows[:, :4]
    rough = learning._trained(learning._SEES_STROKES, x, DATA.tip - DATA.deflection, 15, 15, generator())
    whole = modular_network(DATA, generator(), epochs=15)
    assert mean_miss(whole, x, DATA.tip) < mean_miss(rough, x, DATA.tip)


@pytest.mark.parametrize("bad", [{"neurons": 0}, {"epochs": 0}])
def test_bad_sizes_are_refused(bad):
    with pytest.raises(ValueError, match=next(iter(bad))):
        correction_network(DATA, generator(), **bad)
