"""Training logs that the authors of paper C published: losses by epoch, cited as facts.

What the paper says of optimisers and cycles describes these trainings. None of them was repeated here.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Literal

from dexterity import store
from dexterity_study.engine import strict

OPTIMISERS = ("Adam", "Adamax", "Nadam", "RMSprop", "Adagrad", "SGD")
"""Optimisers of the single networks that were trained for the figures."""

EPOCHS = 75
"""Epochs of the trainings by optimiser."""

Curve = tuple[tuple[float, float], ...]
"""Pairs of epoch and loss."""


@dataclass(frozen=True)
class Log:
    """Losses of one training.

    Attributes
    ----------
    id
        Name, unique in the file.
    network
        Whether the head was trained in a network of its own, or in the combined model.
    head
        The head that was trained.
    optimiser
        Name of its optimiser.
    constant
        Loss of the best constant answer.
    training, validation
        Losses by epoch, where they are known.
    rises
        Sum of all rises of the training loss over its fall; None where it is not known.
    cycle
        Number of the cycle of the combined model; 0 outside of the cycles.
    """

    id: str
    network: Literal["single", "combined"]
    head: Literal["confidence", "estimation"]
    optimiser: str
    constant: float
    training: Curve
    validation: Curve
    rises: float | None = None
    cycle: int = 0

    def __post_init__(self) -> None:
        strict.require_id(self.id)
        for name in ("training", "validation"):
            epochs = [epoch for epoch, _ in getattr(self, name)]
            if not epochs or epochs != sorted(set(epochs)):
                raise ValueError(f"{name} has the epochs {epochs}; they must rise, and there must be one")

    @property
    def left(self) -> float:
        """Share of the best constant's loss that the last training loss is."""
        return self.training[-1][1] / self.constant

    @property
    def left_in_validation(self) -> float:
        """Share of the best constant's loss that the last validation loss is; more than one is worse than a constant."""
        return self.validation[-1][1] / self.constant


@cache
def load() -> dict[str, Log]:
    """Read the logs, by id.

    Raises
    ------
    ValueError
        If the file is malformed; the message names the entry.
    """
    entries = strict.read_entries(store.data_path("papers", "liao2018", "logs.toml"), Log)
    return {entry.id: entry for entry in entries}


def by_optimiser(head: Literal["confidence", "estimation"]) -> dict[str, Log]:
    """Return the logs of a head's single networks of 75 epochs, by optimiser."""
    return {name: load()[f"{head}-{name.lower()}"] for name in OPTIMISERS}
