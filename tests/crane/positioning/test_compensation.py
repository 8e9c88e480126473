"""Aiming off: exact with the structure, as good as the sag that it is told otherwise."""

import dataclasses
import itertools

import pytest
import torch
from torch.testing import assert_close

from dexterity import crane
from dexterity.crane.positioning import (
    GeneticInverseOptions,
    by_inverse_network,
    compensate,
    corotational_sag,
    correction_network,
    errors,
    exact_inverse,
    genetic,
    inverse_network,
    linear_sag,
    network_sag,
    thesis_task,
    uncompensated,
)

TASK = thesis_task()
DATA = crane.training_set()


def generator(seed: int = 0) -> torch.Generator:
    return torch.Generator().manual_seed(seed)


def test_the_structure_in_a_loop_is_exact():
    """Asked for: at most 0.05 mm on its own model."""
    four = errors(TASK, compensate(TASK, linear_sag(), corrections=4))
    assert four.distance.max() < 5e-5
    assert not four.stopped.any()
    looped = compensate(TASK, linear_sag(), corrections=30, tolerance=1e-9)
    assert looped.converged.all()
    assert looped.iterations.max() < 12
    assert errors(TASK, looped).distance.max() <= 1e-9


def test_every_correction_brings_it_nearer():
    distances = [
        errors(TASK, compensate(TASK, linear_sag(), corrections=k)).distance.mean() for k in (1, 2, 3)
    ]
    distances.insert(0, errors(TASK, uncompensated(TASK)).distance.mean())
    for before, after in itertools.pairwise(distances):
        assert after < before / 5


def test_on_the_co_rotational_crane():
    few = thesis_task([(5.0, 2.0), (2.0, 7.0), (1.0, -2.0)], [30.0, 470.0])
    sag = corotational_sag()
    looped = compensate(few, sag, corrections=3)
    assert looped.converged.all()
    assert errors(few, looped, sag).distance.max() <= 5e-5
    linear = errors(few, compensate(few, linear_sag(), corrections=8), sag)
    assert 1e-4 < linear.distance.max() < 5e-3


def test_a_sag_that_is_the_same_everywhere_takes_one_correction():
    def sag(strokes: torch.Tensor, payload: torch.Tensor) -> torch.Tensor:
        return torch.tensor([-0.01, -0.03], dtype=torch.float64).expand(len(strokes), 2)

    once = compensate(TASK, sag)
    assert errors(TASK, once, sag).distance.max() < 1e-9
    assert (once.iterations == 1).all()


def test_without_sag_nothing_is_corrected():
    def sag(strokes: torch.Tensor, payload: torch.Tensor) -> torch.Tensor:
        return torch.zeros(len(strokes), 2, dtype=torch.float64)

    none = compensate(TASK, sag, tolerance=1e-9)
    assert (none.iterations == 0).all()
    assert_close(none.strokes, exact_inverse(TASK, TASK.targets).strokes)


def test_the_rigid_crane_is_solved_with_at_least_the_starts_extension():
    solved = exact_inverse(TASK, TASK.targets)
    assert solved.converged.all()
    assert (solved.strokes[:, 2] >= TASK.starts[:, 2] - 1e-12).all()
    assert (crane.tip_position(solved.strokes) - TASK.targets).norm(dim=-1).max() < 1e-9


def test_a_network_corrects_most_of_it():
    network = correction_network(DATA, generator(), epochs=60)
    found = errors(TASK, compensate(TASK, network_sag(network)))
    assert found.distance.mean() < 0.15 * errors(TASK, uncompensated(TASK)).distance.mean()


def test_the_thesis_first_method_runs_on_its_genetic_algorithm():
    few = thesis_task([(4.0, 2.0), (3.0, 0.0)], [120.0, 310.0])
    options = GeneticInverseOptions(generations=30, tolerance=0.03)
    placement = compensate(few, linear_sag(), genetic(generator(), options))
    assert placement.converged.any()
    assert errors(few, placement).distance[placement.converged].max() < 0.032
    again = compensate(few, linear_sag(), genetic(generator(), options))
    assert torch.equal(placement.strokes, again.strokes)


def test_an_inverse_network_is_asked_once():
    placement = by_inverse_network(TASK, inverse_network(DATA, generator(), epochs=10))
    assert placement.strokes.shape == (125, 3)
    assert_close(placement.strokes[:, 2], crane.least_extension(TASK.targets))
    assert errors(TASK, placement).distance.isfinite().all()


def test_aiming_at_what_the_rigid_crane_does_not_reach_is_refused():
    def sag(strokes: torch.Tensor, payload: torch.Tensor) -> torch.Tensor:
        return torch.full((len(strokes), 2), -9.0, dtype=torch.float64)

    lift_joint = TASK.targets.new_tensor([-0.09, 1.115])
    lost = dataclasses.replace(TASK, targets=lift_joint.expand(125, 2))
    with pytest.raises(ValueError, match=r"targets.*-0\.09"):
        compensate(lost, sag)
    with pytest.raises(ValueError, match="corrections"):
        compensate(TASK, sag, corrections=0)
