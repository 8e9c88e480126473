"""The search over sizes and readouts: what it returns is what it says."""

import dataclasses
import math

import pytest
import torch

from dexterity.networks import ladder, validation
from dexterity.networks.network import View
from dexterity.networks.worst_case import Search
from dexterity.sampling import Box

SPACE, VIEW = Box([-1.0, -1.0], [1.0, 1.0]), View(2, [0, 1])
EFFORT = ladder.Effort(
    sizes=(1, 2, 6), rows=256, epochs=40, restarts=2, validation=512, search=Search(64, 4, 4, 10)
)


def exact(q):
    return 2 + torch.sin(2 * q[..., 0]) * q[..., 1]


def task(goal=0.02, function=exact, scale=None):
    return ladder.Task(VIEW, function, SPACE, goal, scale)


def test_the_smallest_network_that_keeps_the_goal_is_returned():
    found = ladder.climb(task(), EFFORT)
    assert found.passed
    assert not found.interrupted
    assert max(found.best.validation_error, found.best.worst_error) <= 0.02
    assert found.best.neurons == max(candidate.neurons for candidate in found.candidates)
    assert validation.error_distribution(found.best.network, exact, SPACE, 2000).maximum < 0.03


def test_a_goal_out_of_reach_returns_the_best_and_says_so():
    found = ladder.climb(task(1e-9), dataclasses.replace(EFFORT, sizes=(1, 2), readouts=("identity",)))
    assert not found.passed
    assert found.best.error == min(candidate.error for candidate in found.candidates if candidate.sound)
    assert {candidate.neurons for candidate in found.candidates} == {1, 2}


def test_the_same_seed_gives_the_same_network_and_another_seed_another():
    few = dataclasses.replace(EFFORT, sizes=(2,), readouts=("identity",))
    first, second = ladder.climb(task(), few), ladder.climb(task(), few)
    other = ladder.climb(task(), dataclasses.replace(few, seed=1))
    q = torch.rand(10, 2, dtype=torch.float64, generator=torch.Generator().manual_seed(0))
    assert torch.equal(first.best.network(q), second.best.network(q))
    assert not torch.equal(first.best.network(q), other.best.network(q))


def test_values_of_both_signs_are_learned_by_the_plain_readout():
    found = ladder.climb(task(0.05, lambda q: torch.sin(2 * q[..., 0]) + q[..., 1], scale=3.8), EFFORT)
    assert found.passed
    assert {candidate.readout for candidate in found.candidates} == {"identity"}


def test_what_is_done_is_reported():
    steps = []
    ladder.climb(task(1e-9), EFFORT, lambda text, done, most: steps.append((text, done, most)))
    assert [done for _, done, _ in steps] == list(range(1, len(steps) + 1))
    assert all(done <= most for _, done, most in steps)
    assert steps[-1][1] == steps[-1][2]
    assert "1 neurons, identity" in steps[0][0]


def test_an_interrupt_keeps_what_is_finished():
    def interrupt(text, done, most):
        if done == 2:
            raise KeyboardInterrupt

    found = ladder.climb(task(1e-9), EFFORT, interrupt)
    assert found.interrupted
    assert len(found.candidates) == 2
    with pytest.raises(KeyboardInterrupt):
        ladder.climb(task(function=interrupted), EFFORT)


def interrupted(q):
    raise KeyboardInterrupt


def test_a_network_whose_answers_are_rounding_is_not_taken(monkeypatch):
    monkeypatch.setattr(ladder, "PROMISED", 0.0)
    with pytest.raises(ValueError, match=r"^no network was found whose answers are more than rounding"):
        ladder.climb(task(), dataclasses.replace(EFFORT, sizes=(1,)))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"sizes": ()}, "sizes is"),
        ({"sizes": (3, 2)}, "sizes is"),
        ({"sizes": (2.5,)}, r"sizes\[0\] is 2\.5"),
        ({"readouts": ("square",)}, r"readouts\[0\] is 'square'"),
        ({"readouts": ()}, "readouts is empty"),
        ({"rows": math.nan}, "rows is nan"),
        ({"epochs": math.inf}, "epochs is inf"),
        ({"overhang": -1.0}, r"overhang is -1\.0"),
        ({"search": 3}, "search is 3"),
        ({"seed": -1}, "seed is -1"),
    ],
)
@pytest.mark.usefixtures("annotations_unchecked")
def test_efforts_out_of_range_are_refused(change, message):
    with pytest.raises((TypeError, ValueError), match=f"^{message}"):
        dataclasses.replace(EFFORT, **change)
