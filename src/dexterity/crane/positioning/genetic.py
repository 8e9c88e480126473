"""The thesis's genetic algorithm for the rigid crane's inverse kinematics, for many positions at once.

Section 4.1 of Rouvinen (1999): fifteen individuals, two of which are the strokes that the crane has, up to a
thousand populations, the distance to the position as fitness, good enough below five millimetres. All else is
chosen here, after :mod:`dexterity.search.genetic`, whose chromosomes these are: parents are drawn by linear
rank, neighbours swap what is behind one cut, bits turn over, the fittest is kept.

Examples
--------
>>> import torch
>>> from dexterity.crane.positioning import genetic_inverse, thesis_task
>>> task = thesis_task(points=[[4.0, 0.0], [5.0, 2.0]], payloads=[100.0])
>>> found = genetic_inverse(task, task.targets, torch.Generator().manual_seed(0))
>>> found.converged.tolist()
[True, True]
"""

from __future__ import annotations

from dataclasses import dataclass

import torch
from jaxtyping import Float64
from torch import Tensor

from dexterity import checks
from dexterity.checks import OrNone, Real, Whole
from dexterity.crane.kinematics import tip_position
from dexterity.crane.positioning.task import Placement, Task
from dexterity.search.genetic import Chromosome
from dexterity.spatial.values import on_cpu

__all__ = ["GeneticInverseOptions", "genetic_inverse"]


@dataclass(frozen=True)
class GeneticInverseOptions:
    """Parameters of the search; the first four are the thesis's.

    Attributes
    ----------
    population
        Individuals, at least 2 more than are given.
    given
        How many of the first are the strokes that the crane has.
    generations
        Largest number of generations after the first.
    tolerance
        Distance [m] that is good enough.
    bits
        Of each stroke.
    crossover
        Probability that two children swap.
    mutation
        Probability that a bit turns over; None for one bit of a child on average.

    Raises
    ------
    ValueError
        If a number is out of its range.
    """

    population: int = 15
    given: int = 2
    generations: int = 1000
    tolerance: float = 0.005
    bits: int = 12
    crossover: float = 0.6
    mutation: float | None = None

    def __post_init__(self) -> None:
        checks.fields(
            self,
            population=Whole(2),
            given=Whole(0),
            generations=Whole(1),
            tolerance=Real(least=0),
            bits=Whole(1, 52),
            crossover=Real(least=0, most=1),
            mutation=OrNone(Real(least=0, most=1)),
        )
        if self.given > self.population - 2:
            raise ValueError(f"given is {self.given} of a population of {self.population}; 2 must be left")


def genetic_inverse(
    task: Task,
    positions: Float64[Tensor, "N 2"],
    generator: torch.Generator,
    options: GeneticInverseOptions = GeneticInverseOptions(),
) -> Placement:
    """Search strokes that bring the rigid tip to positions, from a task's starts.

    Parameters
    ----------
    task
        Starts and limits.
    positions
        (N, 2) where the rigid tip should be [m].
    generator
        Source of randomness.
    options
        Parameters.

    Returns
    -------
    The best individuals; those that are not good enough after all generations are flagged.

    References
    ----------
    Rouvinen (1999), section 4.1; Goldberg (1989) for the binary algorithm.
    """
    checks.instance(task, "task", Task)
    checks.instance(generator, "generator", torch.Generator)
    checks.instance(options, "options", GeneticInverseOptions)
    positions = on_cpu(positions, "positions")
    if positions.shape != task.targets.shape:
        raise ValueError(
            f"positions has shape {tuple(positions.shape)}; {tuple(task.targets.shape)} is needed"
        )
    search = _Search(task, positions, options)
    genes = search.first(generator)
    best, misses = search.best(genes)
    taken = torch.zeros(len(task), dtype=torch.long)
    for generation in range(1, options.generations + 1):
        going = (misses > options.tolerance).nonzero()[:, 0]
        if not len(going):
            break
        genes[going] = search.next(genes[going], going, generator)
        best[going], misses[going] = search.best(genes[going], going)
        taken[going] = generation
    return Placement(best, misses <= options.tolerance, taken)


class _Search:
    """Populations (N, individuals, bits), one for each position."""

    def __init__(self, task: Task, positions: Tensor, options: GeneticInverseOptions) -> None:
        self.task = task
        self.positions = positions
        self.options = options
        self.chromosome = Chromosome(torch.zeros(3).double(), torch.ones(3).double(), (options.bits,) * 3)
        self.mutation = 1 / self.chromosome.length if options.mutation is None else options.mutation

    def first(self, generator: torch.Generator) -> Tensor:
        size = (len(self.task), self.options.population, self.chromosome.length)
        genes = torch.rand(size, generator=generator) < 0.5
        genes[:, : self.options.given] = self._encoded(self.task.starts)[:, None]
        return genes

    def _encoded(self, strokes: Tensor) -> Tensor:
        span = self.task.upper - self.task.lower
        steps = ((strokes - self.task.lower) / span * (2**self.options.bits - 1)).round().long()
        powers = 2 ** torch.arange(self.options.bits - 1, -1, -1)
        return (steps[..., None] // powers % 2 == 1).flatten(1)

    def _misses(self, genes: Tensor, which: Tensor | slice) -> tuple[Tensor, Tensor]:
        """Strokes (N, individuals, 3) and distances of their tips (N, individuals)."""
        lower, upper = self.task.lower[which, None], self.task.upper[which, None]
        share = self.chromosome.decoded(genes.flatten(0, 1)).unflatten(0, genes.shape[:2])
        strokes = lower + (upper - lower) * share
        away = tip_position(strokes, self.task.crane) - self.positions[which, None]
        return strokes, away.norm(dim=-1)

    def best(self, genes: Tensor, which: Tensor | slice = slice(None)) -> tuple[Tensor, Tensor]:
        """Strokes (N, 3) and distance (N) of the fittest of each population."""
        strokes, misses = self._misses(genes, which)
        least, place = misses.min(dim=1)
        return strokes[torch.arange(len(place)), place], least

    def next(self, genes: Tensor, which: Tensor, generator: torch.Generator) -> Tensor:
        """Select by rank, let neighbours swap, turn bits over, and keep the fittest as it is."""
        order = self._misses(genes, which)[1].argsort(dim=1)
        ranked = torch.take_along_dim(genes, order[..., None], dim=1)
        count, individuals, bits = genes.shape
        favour = torch.linspace(2, 0, individuals).expand(count, -1)
        chosen = torch.multinomial(favour, individuals, replacement=True, generator=generator)
        children = torch.take_along_dim(ranked, chosen[..., None], dim=1)
        pairs = individuals // 2
        first, second = children[:, : 2 * pairs].unflatten(1, (pairs, 2)).unbind(2)
        swaps = torch.rand(count, pairs, 1, generator=generator) < self.options.crossover
        cuts = torch.randint(1, bits, (count, pairs, 1), generator=generator)
        swapped = swaps & (torch.arange(bits) >= cuts)
        mated = torch.stack([torch.where(swapped, second, first), torch.where(swapped, first, second)], dim=2)
        children[:, : 2 * pairs] = mated.flatten(1, 2)
        children ^= torch.rand(children.shape, generator=generator) < self.mutation
        children[:, 0] = ranked[:, 0]
        return children
