"""The genetic algorithm of paper B: binary chromosomes whose probabilities favour the fitter and fall.

Sotiropoulos, Aspragathos & Andritsos (2011), section III.B, say no more than that. Chosen here: parents are
drawn by linear rank, and so is how likely each is to mate; mates swap what is behind one cut; both
probabilities fall evenly to zero; the fittest is kept as it is. The whole population is worked on at once.

Examples
--------
>>> import torch
>>> from dexterity.search import genetic_search
>>> objective = lambda x: -((x - 0.5) ** 2).sum(-1)
>>> random = torch.Generator().manual_seed(0)
>>> found = genetic_search(objective, [0, 0], [1, 1], [0.01, 0.01], random)
>>> found.value > -0.001, found.stop.name
(True, 'STALLED')
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from enum import Enum

import torch
from jaxtyping import Bool, Float64
from torch import Tensor

from dexterity import checks
from dexterity.checks import Real, Whole
from dexterity.search import box
from dexterity.search.box import Objective
from dexterity.spatial import TensorLike

__all__ = ["Chromosome", "GeneticOptions", "GeneticSearch", "Stop", "genetic_search"]


@dataclass(frozen=True)
class GeneticOptions:
    """Parameters of the search; the defaults are those of Table 2.

    Attributes
    ----------
    population
        Individuals of a generation, at least 2.
    generations
        Largest number of generations after the first.
    crossover
        Probability that an individual mates, on average over a population and in the first generation. The
        fittest has twice of it and the least fit none.
    mutation
        Probability that a bit of a child turns over, in the first generation.
    patience
        Generations without a better individual after which the search ends.

    Raises
    ------
    ValueError, TypeError
        If a number is out of its range, or no number.
    """

    population: int = 60
    generations: int = 500
    crossover: float = 0.20
    mutation: float = 0.08
    patience: int = 50

    def __post_init__(self) -> None:
        checks.fields(
            self,
            population=Whole(2, 1_000_000),
            generations=Whole(1),
            crossover=Real(least=0, most=0.5),
            mutation=Real(least=0, most=1),
            patience=Whole(1),
        )


_MOST_BITS = 52  # of a variable: more than the digits of a number


class Stop(Enum):
    """Why a search ended."""

    GENERATIONS = "the generations were used up"
    STALLED = "nothing better came for long"


@dataclass(frozen=True)
class GeneticSearch:
    """The best individual and how it was found.

    Attributes
    ----------
    point
        (d,) point with the largest value.
    value
        That value.
    evaluations
        How many points the objective was asked for.
    stop
        Why the search ended.
    history
        (generations + 1) largest value in each generation.
    points
        (generations + 1, d) points of these.
    """

    point: Float64[Tensor, " d"]
    value: float
    evaluations: int
    stop: Stop
    history: tuple[float, ...] = field(repr=False)
    points: Float64[Tensor, "g d"] = field(repr=False)


@dataclass(frozen=True)
class Chromosome:
    """Points of a box as bits, plain binary numbers one variable after the other.

    Attributes
    ----------
    lower, upper
        (d,) limits of the variables.
    bits
        How many bits each variable has.
    """

    lower: Tensor
    upper: Tensor
    bits: tuple[int, ...]

    @classmethod
    def of(cls, lower: TensorLike, upper: TensorLike, precision: TensorLike) -> Chromosome:
        """Return the shortest chromosome whose steps are not longer than a precision (d).

        Raises
        ------
        ValueError
            If the limits make no box, or a precision is not positive or finer than 2⁻⁵² of the box.
        """
        low, high = box.limits(lower, upper)
        values = (high - low) / box.steps(precision, "precision", len(low)) + 1
        if (values > 2.0**_MOST_BITS).any():
            raise ValueError(f"precision is {precision}; at least 2^-{_MOST_BITS} of the box is needed")
        return cls(low, high, tuple(max(1, math.ceil(math.log2(n) - 1e-9)) for n in values.tolist()))

    @property
    def length(self) -> int:
        """Number of bits."""
        return sum(self.bits)

    def decoded(self, genes: Bool[Tensor, "N bits"]) -> Float64[Tensor, "N d"]:
        """Return the points of chromosomes."""
        columns = []
        for part, low, high in zip(genes.split(self.bits, dim=1), self.lower, self.upper, strict=True):
            weights = 2.0 ** torch.arange(part.shape[1] - 1, -1, -1, dtype=torch.float64)
            columns.append(low + (high - low) * (part.to(torch.float64) @ weights) / (weights.sum()))
        return torch.stack(columns, dim=1)


def genetic_search(
    objective: Objective,
    lower: TensorLike,
    upper: TensorLike,
    precision: TensorLike,
    generator: torch.Generator,
    options: GeneticOptions = GeneticOptions(),
) -> GeneticSearch:
    """Search a box for the point with the largest value.

    Parameters
    ----------
    objective
        Values (N) of points (N, d), larger is better. It is asked for a whole generation at a time.
    lower, upper
        (d,) limits of the box.
    precision
        (d,) largest step between neighbouring values of each variable.
    generator
        Source of randomness.
    options
        Sizes and probabilities.

    Raises
    ------
    ValueError
        If the limits or the precision do not fit, or the objective answers with NaN or another shape.
    TypeError
        If the objective is no function or does not answer with numbers, or `generator` is no generator.

    References
    ----------
    Sotiropoulos, Aspragathos & Andritsos (2011), section III.B; Baker (1985) for selection by rank;
    Michalewicz (1992) for crossover and mutation of binary chromosomes.
    """
    checks.function(objective, "objective")
    checks.instance(generator, "generator", torch.Generator)
    checks.instance(options, "options", GeneticOptions)
    chromosome = Chromosome.of(lower, upper, precision)
    size = (options.population, chromosome.length)
    genes = torch.rand(size, generator=generator) < 0.5
    values = box.evaluated(objective, chromosome.decoded(genes))
    history, points = [values.max().item()], [chromosome.decoded(genes[values.argmax()][None])[0]]
    best, since, stop = history[0], 0, Stop.GENERATIONS
    for generation in range(options.generations):
        left = 1 - generation / options.generations
        genes = _next_generation(genes, values, left, options, generator)
        values = box.evaluated(objective, chromosome.decoded(genes))
        history.append(values.max().item())
        points.append(chromosome.decoded(genes[values.argmax()][None])[0])
        best, since = (history[-1], 0) if history[-1] > best else (best, since + 1)
        if since == options.patience:
            stop = Stop.STALLED
            break
    return GeneticSearch(
        points[-1], history[-1], len(history) * options.population, stop, tuple(history), torch.stack(points)
    )


def _next_generation(
    genes: Tensor, values: Tensor, left: float, options: GeneticOptions, generator: torch.Generator
) -> Tensor:
    """Select by rank, mate, turn bits over, and keep the fittest as it is.

    `left` is the share of the generations that are to come, by which both probabilities have fallen.
    """
    n, bits = genes.shape
    order = values.argsort(descending=True)
    # 2 for the fittest down to 0 for the least fit: how many children each may expect.
    favour = torch.linspace(2, 0, n)
    chosen = torch.multinomial(favour, n, replacement=True, generator=generator)
    parents, favour = genes[order[chosen]], favour[chosen]
    mating = (torch.rand(n, generator=generator) < left * options.crossover * favour).nonzero().flatten()
    mating = mating[torch.randperm(len(mating), generator=generator)][: len(mating) // 2 * 2]
    first, second = mating.view(2, -1)
    cuts = torch.randint(1, max(2, bits), (len(first), 1), generator=generator)
    swapped = torch.arange(bits) >= cuts
    children = parents.clone()
    children[first] = torch.where(swapped, parents[second], parents[first])
    children[second] = torch.where(swapped, parents[first], parents[second])
    children ^= torch.rand(n, bits, generator=generator) < left * options.mutation
    children[0] = genes[order[0]]
    return children
