"""The genetic algorithm for the rigid crane: what it returns is what it says, from seeds that are kept."""

import dataclasses

import pytest
import torch
from torch.testing import assert_close

from dexterity import crane
from dexterity.crane.positioning import GeneticInverseOptions, genetic_inverse, thesis_task
from dexterity.crane.positioning.genetic import _Search

TASK = thesis_task(payloads=[100.0])


def generator(seed: int = 0) -> torch.Generator:
    return torch.Generator().manual_seed(seed)


def test_it_comes_within_its_tolerance_or_says_so():
    found = genetic_inverse(TASK, TASK.targets, generator(), GeneticInverseOptions(generations=100))
    miss = (crane.tip_position(found.strokes) - TASK.targets).norm(dim=-1)
    assert torch.equal(found.converged, miss <= 0.005)
    assert found.converged.double().mean() > 0.4
    assert (found.iterations[~found.converged] == 100).all()
    assert (found.iterations[found.converged] <= 100).all()
    assert TASK.allows(found.strokes).all()


def test_it_ends_near_the_strokes_that_it_was_given():
    found = genetic_inverse(TASK, TASK.targets, generator(), GeneticInverseOptions(generations=40))
    drawn = TASK.lower + (TASK.upper - TASK.lower) * torch.rand(25, 3, generator=generator(1)).double()
    assert (found.strokes - TASK.starts).norm(dim=-1).median() < 0.3 * (drawn - TASK.starts).norm(
        dim=-1
    ).median()


def test_more_generations_never_make_it_worse():
    misses = []
    for generations in (1, 5, 25):
        options = GeneticInverseOptions(generations=generations, tolerance=0.0)
        found = genetic_inverse(TASK, TASK.targets, generator(), options)
        misses.append((crane.tip_position(found.strokes) - TASK.targets).norm(dim=-1))
        assert (found.iterations == generations).all()
    assert (misses[1] <= misses[0] + 1e-12).all()
    assert (misses[2] <= misses[1] + 1e-12).all()
    # Two individuals are the start, to half a bit of each stroke.
    start = (crane.tip_position(TASK.starts) - TASK.targets).norm(dim=-1)
    assert (misses[0] <= start + 0.02).all()


def test_the_same_seed_gives_the_same_strokes():
    options = GeneticInverseOptions(generations=30)
    first, again, other = (genetic_inverse(TASK, TASK.targets, generator(s), options) for s in (0, 0, 1))
    assert torch.equal(first.strokes, again.strokes)
    assert not torch.equal(first.strokes, other.strokes)


def test_a_crane_that_is_there_stays_there():
    found = genetic_inverse(TASK, crane.tip_position(TASK.starts), generator())
    assert (found.iterations == 0).double().mean() > 0.9
    assert (found.strokes - TASK.starts)[found.iterations == 0].abs().max() < 1.7 / 4095


def test_chromosomes_are_the_nearest_strokes():
    search = _Search(TASK, TASK.targets, GeneticInverseOptions())
    genes = search.first(generator())
    assert genes.shape == (25, 15, 36)
    assert torch.equal(genes[:, 0], genes[:, 1])
    steps = (TASK.upper - TASK.lower) / 4095
    strokes, _ = search._misses(genes[:, :1], slice(None))
    assert ((strokes[:, 0] - TASK.starts).abs() <= steps / 2 + 1e-12).all()


def test_the_fittest_of_all_is_kept_without_crossover_and_mutation():
    options = GeneticInverseOptions(crossover=0.0, mutation=0.0, generations=5, tolerance=0.0)
    found = genetic_inverse(TASK, TASK.targets, generator(), options)
    search = _Search(TASK, TASK.targets, options)
    best, _ = search.best(search.first(generator()))
    assert_close(found.strokes, best)


@pytest.mark.parametrize(
    "bad",
    [{"given": 14}, {"given": -1}, {"generations": 0}, {"bits": 0}, {"crossover": 1.1}, {"mutation": -0.1},
     {"tolerance": -1.0}],
    ids=str,
)  # fmt: skip
def test_bad_options_are_named(bad):
    with pytest.raises(ValueError, match=next(iter(bad))):
        dataclasses.replace(GeneticInverseOptions(), **bad)
