"""Structural solves of the crane a second, linear and co-rotational, and answers of networks, on a core."""

import torch

from dexterity import crane
from dexterity.crane import positioning
from dexterity.networks.threads import one_thread
from dexterity.timing import Way, measure

POSES = 5_000
FEW = 100


def strokes(count: int) -> torch.Tensor:
    unit = torch.rand(count, 3, generator=torch.Generator().manual_seed(0), dtype=torch.float64)
    return unit * torch.tensor(crane.patu655().upper, dtype=torch.float64)


def test_half_a_million_answers_of_a_correction_network_in_a_second():
    network = positioning.correction_network(crane.training_set(), torch.Generator(), epochs=1)
    sag, many = positioning.network_sag(network), strokes(POSES)
    payload = torch.full((POSES,), 300.0, dtype=torch.float64)
    with one_thread():
        (timing,) = measure([Way("network", lambda: sag(many, payload), POSES)])
    print(f"{1 / timing.median:,.0f} answers of the thesis's network a second")
    assert 1 / timing.median > 500_000


def test_ten_thousand_linear_solves_in_a_second():
    many, few = strokes(POSES), strokes(FEW)
    with one_thread():
        linear, corotational = measure(
            [
                Way("linear", lambda: crane.load_response(many), POSES),
                Way("co-rotational", lambda: crane.corotational_deflection(few, 500.0), FEW),
            ]
        )
    longer = corotational.median / linear.median
    print(f"{1 / linear.median:,.0f} linear solves a second; co-rotational: {longer:.0f} times as long")
    assert 1 / linear.median > 10_000
