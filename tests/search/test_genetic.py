"""The genetic algorithm: its chromosomes, what its options do, and known problems."""

import dataclasses
import math
import statistics
from collections.abc import Callable

import numpy as np
import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st
from pymoo.algorithms.soo.nonconvex.ga import GA
from pymoo.core.problem import Problem
from pymoo.operators.crossover.pntx import SinglePointCrossover
from pymoo.operators.mutation.bitflip import BitflipMutation
from pymoo.operators.sampling.rnd import BinaryRandomSampling
from pymoo.optimize import minimize
from torch.testing import assert_close

from dexterity.search.genetic import Chromosome, GeneticOptions, Stop, genetic_search

LOW, HIGH, STEP = [-4.0, -4.0, -4.0], [4.0, 4.0, 4.0], [0.01, 0.01, 0.01]


def generator(seed: int = 0) -> torch.Generator:
    return torch.Generator().manual_seed(seed)


def sphere(x: torch.Tensor) -> torch.Tensor:
    return -(x - torch.tensor([1.0, -2.0, 0.5])).square().sum(1)


def rastrigin(x: torch.Tensor) -> torch.Tensor:
    return (10 * (2 * math.pi * x).cos() - 10 - x.square()).sum(1)


def plateau(x: torch.Tensor) -> torch.Tensor:
    return torch.zeros(len(x), dtype=torch.float64)


# ---- chromosomes -----------------------------------------------------------------------------------


@given(st.floats(-10, 10), st.floats(0.01, 20), st.floats(1e-4, 1.0))
def test_a_chromosome_is_as_short_as_its_precision_allows(low, width, precision):
    (bits,) = Chromosome.of([low], [low + width], [precision]).bits
    # One bit is the least, however coarse the precision.
    assert width / (2**bits - 1) <= precision * (1 + 1e-6) or bits == 1
    assert bits == 1 or width / (2 ** (bits - 1) - 1) > precision * (1 - 1e-6)


def test_bits_are_binary_numbers_one_variable_after_the_other():
    chromosome = Chromosome.of([0.0, -1.0], [7.0, 2.0], [1.0, 1.0])
    assert chromosome.bits == (3, 2)
    genes = torch.tensor([[0, 0, 0, 0, 0], [1, 1, 1, 1, 1], [1, 0, 1, 0, 1]], dtype=torch.bool)
    expected = torch.tensor([[0.0, -1.0], [7.0, 2.0], [5.0, 0.0]], dtype=torch.float64)
    assert_close(chromosome.decoded(genes), expected)


def test_a_variable_may_be_held():
    found = genetic_search(sphere, [-4, -2, -4], [4, -2, 4], STEP, generator())
    assert found.point[1] == -2.0


# ---- the search ------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(5))
def test_a_hill_is_climbed(seed):
    found = genetic_search(sphere, LOW, HIGH, STEP, generator(seed))
    assert found.value == pytest.approx(sphere(found.point[None]).item())
    assert found.value > -0.01


def test_most_runs_find_the_best_of_many_hills():
    values = [genetic_search(rastrigin, LOW, HIGH, STEP, generator(seed)).value for seed in range(10)]
    assert sorted(values)[5] > -0.5


def test_it_beats_as_many_random_points():
    found = genetic_search(sphere, LOW, HIGH, STEP, generator())
    uniform = torch.rand(found.evaluations, 3, generator=generator(), dtype=torch.float64)
    assert found.value > sphere(8 * uniform - 4).max()


def test_nothing_good_is_lost():
    found = genetic_search(rastrigin, LOW, HIGH, STEP, generator())
    assert list(found.history) == sorted(found.history)
    assert_close(rastrigin(found.points), torch.tensor(found.history, dtype=torch.float64))
    assert found.value == found.history[-1] == max(found.history)
    assert found.evaluations == 60 * len(found.history)


def test_the_same_seed_gives_the_same_bytes():
    one, other = (genetic_search(rastrigin, LOW, HIGH, STEP, generator(3)) for _ in range(2))
    assert one.history == other.history
    assert torch.equal(one.points, other.points)
    assert genetic_search(rastrigin, LOW, HIGH, STEP, generator(4)).history != one.history


def test_it_ends_when_nothing_better_comes():
    found = genetic_search(plateau, LOW, HIGH, STEP, generator())
    assert found.stop is Stop.STALLED
    assert len(found.history) == 1 + 50


def test_it_ends_when_the_generations_are_used_up():
    options = GeneticOptions(generations=20, patience=30)
    found = genetic_search(sphere, LOW, HIGH, STEP, generator(), options)
    assert found.stop is Stop.GENERATIONS
    assert len(found.history) == 1 + 20


@pytest.mark.parametrize("part", ["crossover", "mutation"])
def test_both_probabilities_are_of_use(part):
    """Medians over seeds of a search without mutation, and of one without mating, against one with both."""

    def median(options: GeneticOptions) -> float:
        values = [genetic_search(sphere, LOW, HIGH, STEP, generator(s), options).value for s in range(20)]
        return sorted(values)[10]

    options = GeneticOptions(generations=15, crossover=0.4)
    without = dataclasses.replace(options, **{part: 0.0})
    assert median(options) > median(without)


# ---- against pymoo ---------------------------------------------------------------------------------


def steps(x: torch.Tensor) -> torch.Tensor:
    """Terraces on a gentle slope, which give no gradient."""
    return -(4 * (x - 0.3).abs()).floor().sum(1) - (x + 1).square().sum(1) / 10


def by_pymoo(objective: Callable[[torch.Tensor], torch.Tensor], evaluations: int, seed: int) -> float:
    """Largest value that pymoo's genetic algorithm finds with the same bits, sizes and probabilities."""
    chromosome = Chromosome.of(LOW, HIGH, STEP)

    class Bits(Problem):
        def __init__(self) -> None:
            super().__init__(n_var=chromosome.length, n_obj=1, vtype=bool)

        def _evaluate(self, x, out, *_args, **_kwargs):
            out["F"] = -objective(chromosome.decoded(torch.tensor(x.astype(bool)))).numpy()[:, None]

    options = GeneticOptions()
    algorithm = GA(
        pop_size=options.population,
        sampling=BinaryRandomSampling(),
        crossover=SinglePointCrossover(prob=options.crossover),
        mutation=BitflipMutation(prob_var=options.mutation),
        eliminate_duplicates=False,
    )
    return -float(minimize(Bits(), algorithm, ("n_evals", evaluations), seed=seed).F[0])


@pytest.mark.parametrize("objective", [sphere, rastrigin, steps])
def test_it_finds_what_pymoo_finds_at_equal_cost(objective):
    ours = [genetic_search(objective, LOW, HIGH, STEP, generator(seed)) for seed in range(5)]
    theirs = [by_pymoo(objective, found.evaluations, seed) for seed, found in enumerate(ours)]
    random = objective(8 * torch.rand(1000, 3, generator=generator(), dtype=torch.float64) - 4)
    climbed = statistics.median(theirs) - random.median().item()
    assert statistics.median(found.value for found in ours) > statistics.median(theirs) - 1e-3 * climbed


# ---- bad input -------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"population": 1}, "population is 1"),
        ({"generations": 0}, "generations is 0"),
        ({"patience": 0}, "patience is 0"),
        ({"crossover": 0.7}, "crossover is 0.7"),
        ({"mutation": -0.1}, "mutation is -0.1"),
        ({"mutation": math.nan}, "mutation is nan"),
    ],
)
def test_options_out_of_range(change, message):
    with pytest.raises(ValueError, match=message):
        GeneticOptions(**change)


@pytest.mark.parametrize(
    ("low", "high", "step", "message"),
    [
        ([0, 0], [1, -1], [0.1, 0.1], "lower is 0.0 and upper -1.0 at variable 1"),
        ([0], [1, 1], [0.1, 0.1], "two vectors of one length"),
        ([], [], [], "two vectors of one length"),
        ([0], [1], [0.0], "positive numbers are needed"),
        ([0], [1], [0.1, 0.1], "positive numbers are needed"),
        ([0], [math.inf], [0.1], "upper is not finite"),
    ],
)
def test_limits_that_make_no_box(low, high, step, message):
    with pytest.raises(ValueError, match=message):
        genetic_search(sphere, low, high, step, generator())


def test_an_objective_that_does_not_answer():
    with pytest.raises(ValueError, match="objective is NaN at"):
        genetic_search(lambda x: x[:, 0] / 0 * 0, LOW, HIGH, STEP, generator())
    with pytest.raises(ValueError, match="objective has values of shape"):
        genetic_search(lambda x: x, LOW, HIGH, STEP, generator())


def test_a_precision_beyond_the_digits_of_a_number_is_refused():
    with pytest.raises(ValueError, match=r"^precision is .*; at least 2\^-52 of the box is needed"):
        Chromosome.of([0.0], [1.0], [1e-300])


def test_a_chromosome_does_not_change_with_the_callers_limits():
    lower, upper = np.zeros(2), torch.ones(2, dtype=torch.float64)
    chromosome = Chromosome.of(lower, upper, [0.1, 0.1])
    lower[:] = upper[:] = 7.0
    assert chromosome.lower.tolist() == [0.0, 0.0]
    assert chromosome.upper.tolist() == [1.0, 1.0]


@pytest.mark.usefixtures("annotations_unchecked")
@pytest.mark.parametrize("field", ["population", "generations", "crossover", "mutation", "patience"])
@pytest.mark.parametrize("value", [math.nan, math.inf, 2.5, True, "3", None])
def test_options_that_are_no_numbers(field, value):
    with pytest.raises((TypeError, ValueError), match=f"^{field} is "):
        GeneticOptions(**{field: value})
