"""Stored evidence: where the rows, arrays and cards of each run lie, and how a chapter reads them.

`data/results/<part>/<chapter>/<experiment>/<reading>.<seed>.csv` holds rows, `.npz` beside it arrays, `.toml`
the card; `probe.csv` holds the reduced run that is repeated to see whether all this still comes out.
"""

from __future__ import annotations

import csv
import importlib
import pkgutil
import tokenize
import zipfile
import zlib
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TypeVar

import dexterity_study
from dexterity import store
from dexterity_study.engine.experiment import Experiment
from dexterity_study.engine.table import Table, from_csv, from_npz


@dataclass(frozen=True)
class Files:
    """Files of one run of an experiment; `arrays` exists where the run has any."""

    rows: Path
    arrays: Path
    card: Path


class NoEvidence(LookupError):  # noqa: N818 -- it is a state of the study, not a fault
    """An experiment has no stored rows."""


@cache
def chapters() -> tuple[str, ...]:
    """Return the names of all chapters with experiments, such as `"uvms.radial_basis"`, sorted."""
    names = []
    for part in pkgutil.iter_modules(dexterity_study.__path__):
        if part.ispkg:
            folder = Path(dexterity_study.__path__[0]) / part.name
            inner = pkgutil.iter_modules([str(folder)])
            names += [f"{part.name}.{c.name}" for c in inner if (folder / c.name / "experiment.py").is_file()]
    return tuple(sorted(names))


def experiments(chapter: str) -> dict[str, Experiment]:
    """Return the experiments of a chapter by name, in the order of their declaration.

    Raises
    ------
    ValueError
        If there is no such chapter.
    """
    if chapter not in chapters():
        raise ValueError(f"there is no chapter {chapter!r}; chapters are {', '.join(chapters())}")
    module = importlib.import_module(f"dexterity_study.{chapter}.experiment")
    return {one.name: one for one in vars(module).values() if isinstance(one, Experiment)}


def folder(experiment: Experiment) -> Path:
    """Return the folder of an experiment's evidence.

    Raises
    ------
    RuntimeError
        If the package does not run from a source tree.
    """
    root = store.repository()
    if root is None:
        raise RuntimeError("evidence belongs to the source tree, and this is an installed package")
    return root.joinpath("data", "results", *experiment.chapter.split("."), experiment.name)


def files(experiment: Experiment, reading: str, seed: int) -> Files:
    """Return the places of the files of one run."""
    stem = folder(experiment) / f"{reading}.{seed}"
    return Files(*(stem.with_name(f"{stem.name}.{suffix}") for suffix in ("csv", "npz", "toml")))


def probe_file(experiment: Experiment) -> Path:
    """Return the place of the rows of a probe."""
    return folder(experiment) / "probe.csv"


def runs(experiment: Experiment) -> Iterator[tuple[str, int]]:
    """Yield reading and seed of each run that is declared."""
    yield from (("chosen", seed) for seed in experiment.seeds)
    others = experiment.reading_seeds or experiment.seeds
    yield from ((reading, seed) for reading in experiment.readings for seed in others)


class Evidence(Mapping[str, Table]):
    """The evidence of a chapter: a table for each experiment, read from the stored files.

    Parameters
    ----------
    chapter
        Its name, such as `"uvms.radial_basis"`.
    tables
        Tables by experiment, in place of the stored ones: a live or reduced run.
    """

    def __init__(self, chapter: str, tables: Mapping[str, Table] | None = None) -> None:
        self.chapter = chapter
        self._experiments = experiments(chapter)
        self._tables = dict(tables or {})

    @classmethod
    def smoke(cls, chapter: str) -> Evidence:
        """Run each experiment of a chapter at smoke effort: two seeds, and one of each other reading."""
        made = {}
        for name, one in experiments(chapter).items():
            asked = [("chosen", seed) for seed in one.seeds[:2]] + [
                (other, one.seeds[0]) for other in one.readings
            ]
            made[name] = Table.joined([one(seed, reading, **one.smoke) for reading, seed in asked])
        return cls(chapter, made)

    def __getitem__(self, experiment: str) -> Table:
        """Return the table of an experiment; KeyError if there is none, NoEvidence if nothing is stored."""
        if experiment not in self._tables:
            self._tables[experiment] = load(self._experiments[experiment])
        return self._tables[experiment]

    def __iter__(self) -> Iterator[str]:
        return iter(self._experiments)

    def __len__(self) -> int:
        return len(self._experiments)


def load(experiment: Experiment) -> Table:
    """Read the stored runs of an experiment.

    Raises
    ------
    NoEvidence
        If none is stored.
    ValueError
        If a file is damaged, or a folder has its name; the error names it.
    """
    tables = []
    for reading, seed in runs(experiment):
        place = files(experiment, reading, seed)
        if place.rows.exists():
            table = _read(place.rows, lambda content: from_csv(content.decode()))
            held = _read(place.arrays, from_npz) if place.arrays.exists() else {}
            tables.append(Table(table.rows, table.keys, {(reading, seed): held} if held else {}))
    if not tables:
        raise NoEvidence(
            f"{experiment.chapter}.{experiment.name} has no stored rows: make evidence makes them"
        )
    return Table.joined(tables)


_Content = TypeVar("_Content")
_DAMAGED = (
    ValueError, csv.Error, zipfile.BadZipFile, zlib.error, EOFError, OSError, KeyError, NotImplementedError,
    RuntimeError, MemoryError, RecursionError, SyntaxError, tokenize.TokenError,
)  # fmt: skip


def _read(file: Path, understood: Callable[[bytes], _Content]) -> _Content:
    try:
        return understood(store.read_bytes(file))
    except _DAMAGED as error:
        raise ValueError(f"{file.parent.name}/{file.name} is damaged: {error}") from error
