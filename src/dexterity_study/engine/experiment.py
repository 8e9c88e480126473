"""Declaration of an experiment: a function of a seed and a reading that returns tidy rows, and how it is run.

An `experiment.py` declares its experiments with :func:`experiment` and imports the library besides, nothing
else of the study, so that what it imports is what made its rows.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any

from dexterity import checks
from dexterity_study.engine.readings import Reading
from dexterity_study.engine.table import Row, Table

Arrays = Mapping[str, Any]
Function = Callable[..., Iterable[Row] | tuple[Iterable[Row], Arrays]]


@dataclass(frozen=True)
class Experiment:
    """An experiment of a chapter.

    Attributes
    ----------
    function
        Takes `seed` if anything is drawn, the values of the assumptions as `reading` if it depends on any, and
        keyword arguments whose defaults are the full effort. Returns rows, mappings of key columns and metrics;
        or rows and a mapping of arrays by name.
    keys
        Columns that name a row within a seed, such as `("index", "spread")`; all others are metrics.
    seeds
        Seeds of the stored runs.
    paper
        Key of the paper whose assumptions it depends on; None if it depends on none.
    assumes
        The assumptions that it depends on.
    readings
        Names of the readings that are run besides the chosen one, such as `"region=or"`.
    reading_seeds
        Seeds of those other readings; all if empty.
    data
        Data files that it reads, below `data/`, such as `"robots/uvms.toml"`; a folder stands for its files.
    arrays
        Names of the arrays that it returns.
    smoke
        Keyword arguments of the reduced run that tests and probes repeat, for the first seed.
    timed
        Whether it takes times: it then runs alone.
    rtol, atol
        How far a number of the probe may be off when it is repeated: `atol` + `rtol` · abs(stored).
    unsteady
        Metrics, such as times, that a probe cannot repeat.
    versions
        Returns the versions of programs that it runs outside of Python, by name, for the card.
    """

    function: Function
    keys: tuple[str, ...] = ()
    seeds: tuple[int, ...] = (0,)
    paper: str | None = None
    assumes: tuple[str, ...] = ()
    readings: tuple[str, ...] = ()
    reading_seeds: tuple[int, ...] = ()
    data: tuple[str, ...] = ()
    arrays: tuple[str, ...] = ()
    smoke: Mapping[str, Any] = field(default_factory=lambda: MappingProxyType({}))
    timed: bool = False
    rtol: float = 1e-6
    atol: float = 1e-9
    unsteady: tuple[str, ...] = ()
    versions: Callable[[], Mapping[str, str]] = dict

    def __post_init__(self) -> None:
        for name in ("rtol", "atol"):
            checks.real(getattr(self, name), f"{name} of {self.name}", least=0)
        known = self._parameters
        takes_more = any(one.kind is one.VAR_KEYWORD for one in known.values())
        if (unknown := self.smoke.keys() - known.keys()) and not takes_more:
            raise TypeError(f"{self.name} has no parameters {sorted(unknown)}; smoke names them")
        if bool(self.assumes) != ("reading" in known) or bool(self.assumes) != bool(self.paper):
            raise TypeError(
                f"{self.name} assumes {self.assumes} of paper {self.paper!r}; the paper, its assumptions and the "
                "parameter `reading` go together"
            )
        if len(set(self.seeds)) < len(self.seeds) or not self.seeds:
            raise TypeError(
                f"{self.name} has the seeds {self.seeds}; different seeds are needed, at least one"
            )
        if len(self.seeds) > 1 and "seed" not in known:
            raise TypeError(f"{self.name} has the seeds {self.seeds} and takes no seed")

    @property
    def _parameters(self) -> Mapping[str, inspect.Parameter]:
        return inspect.signature(self.function).parameters

    @property
    def name(self) -> str:
        """Name of the function."""
        return self.function.__name__

    @property
    def module(self) -> str:
        """Full name of the module that declares it."""
        return self.function.__module__

    @property
    def chapter(self) -> str:
        """Part and chapter, such as `"uvms.radial_basis"`."""
        return ".".join(self.module.split(".")[1:-1])

    def reading(self, name: str = "chosen") -> Reading:
        """Return a reading of the paper by its name."""
        return Reading.of(self.paper, name)

    def __call__(self, seed: int = 0, reading: str = "chosen", **changes: Any) -> Table:
        """Run it once.

        Parameters
        ----------
        seed
            Seed of all that is drawn.
        reading
            Name of the reading.
        changes
            Keyword arguments that differ from the full effort.
        """
        values: dict[str, Any] = {"seed": seed} if "seed" in self._parameters else {}
        if self.assumes:
            values["reading"] = self.reading(reading).only(*self.assumes)
        made = self.function(**values, **changes)
        rows, arrays = made if isinstance(made, tuple) else (made, {})
        # A live run may leave some out.
        if undeclared := set(arrays) - set(self.arrays):
            raise ValueError(
                f"{self.name} returns the arrays {sorted(undeclared)} and declares {sorted(self.arrays)}"
            )
        return Table.of_run(rows, arrays, keys=self.keys, reading=reading, seed=seed)

    def probe(self) -> Table:
        """Run it once at smoke effort, for the chosen reading and the first seed."""
        return self(self.seeds[0], **self.smoke)


def experiment(**declared: Any) -> Callable[[Function], Experiment]:
    """Declare the decorated function as an experiment; see :class:`Experiment` for the arguments."""

    def declare(function: Function) -> Experiment:
        for name in {"seeds", "reading_seeds"} & declared.keys():
            declared[name] = _seeds(declared[name])
        return Experiment(function, **declared)

    return declare


def _seeds(declared: int | Iterable[int]) -> tuple[int, ...]:
    return tuple(range(declared)) if isinstance(declared, int) else tuple(declared)
