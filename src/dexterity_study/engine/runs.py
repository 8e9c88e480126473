"""Runs of experiments: one stored with its card, and one repeated to see whether it still comes out."""

from __future__ import annotations

import csv
import io
import math
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import torch

from dexterity import store
from dexterity_study.engine import card, evidence, sources
from dexterity_study.engine.experiment import Experiment
from dexterity_study.engine.reads import data_files_read
from dexterity_study.engine.table import summaries, to_csv, to_npz


class SourceChanged(RuntimeError):  # noqa: N818 -- it says what happened
    """Source was edited while it ran, so that nobody can say what made the result."""


def run(chapter: str, name: str, reading: str, seed: int) -> None:
    """Run an experiment on one thread and store its rows, its arrays and its card.

    Raises
    ------
    OSError
        If its folder cannot be written to; nothing is run.
    SourceChanged
        If a file that the experiment uses has changed since this process first used it; nothing is stored.
    """
    experiment = evidence.experiments(chapter)[name]
    _require_unchanged(experiment)
    place = evidence.files(experiment, reading, seed)
    _require_writable(place.rows.parent)
    torch.set_num_threads(1)
    started = time.perf_counter()
    table = experiment(seed, reading)
    seconds = time.perf_counter() - started
    _require_unchanged(experiment)
    store.write_atomically(place.rows, to_csv(table))
    if missing := set(experiment.arrays) - table.arrays.get((reading, seed), {}).keys():
        raise ValueError(
            f"{experiment.chapter}.{name} returns no arrays {sorted(missing)}, which it declares"
        )
    if experiment.arrays:
        store.write_atomically(place.arrays, to_npz(table.arrays[reading, seed]))
    card.write(place.card, {"made": card.made(experiment.module, seconds, experiment.versions())})


_SEEN: dict[Path, str] = {}
"""Fingerprints of source files when this process first ran an experiment that uses them."""


def _require_unchanged(experiment: Experiment) -> None:
    for file in sources.closure(experiment.module).values():
        now = sources.fingerprint(file)
        if _SEEN.setdefault(file, now) != now:
            raise SourceChanged(f"{file.name} has changed while {experiment.chapter} ran; run it again")


def run_probe(chapter: str, name: str) -> None:
    """Run an experiment at smoke effort and store its rows, with summaries of its arrays."""
    experiment = evidence.experiments(chapter)[name]
    file = evidence.probe_file(experiment)
    _require_writable(file.parent)
    store.write_atomically(file, smoke_rows(experiment))


def _require_writable(folder: Path) -> None:
    """Fail before hours of computing, and not after them."""
    folder.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryFile(dir=folder):
        pass


def smoke_rows(experiment: Experiment) -> str:
    """Run an experiment at smoke effort on one thread and return its rows, with summaries of its arrays."""
    torch.set_num_threads(1)
    return to_csv(summaries(experiment.probe()))


def missed(experiment: Experiment) -> Iterator[str]:
    """Repeat the probe of an experiment and yield a line for each number that does not come out as stored.

    So it does for each data file that is read and that the experiment does not name.
    """
    file = evidence.probe_file(experiment)
    if not file.exists():
        yield f"{experiment.chapter}.{experiment.name}: there is no stored probe"
        return
    with data_files_read() as opened:
        rows = smoke_rows(experiment)
    for name in sorted(opened):
        if not any(name == own or name.startswith(f"{own}/") for own in experiment.data):
            yield f"{experiment.chapter}.{experiment.name} reads {name}, which it does not name"
    stored, now = _numbers(store.read_bytes(file).decode()), _numbers(rows)
    for place in dict.fromkeys([*stored, *now]):
        one, other = stored.get(place), now.get(place)
        if not _agree(one, other, experiment, metric=place[-1]):
            yield f"{experiment.chapter}.{experiment.name} {'/'.join(place)}: stored {one}, now {other}"


def _numbers(rows: str) -> dict[tuple[str, ...], str]:
    """Return the values of CSV rows by keys and metric."""
    lines = csv.reader(io.StringIO(rows))
    next(lines)
    return {tuple(names): value for *names, value in lines}


def _agree(stored: object, now: object, experiment: Experiment, metric: str) -> bool:
    if stored is None or now is None:
        return False
    if metric in experiment.unsteady:
        return True
    try:
        one, other = float(str(stored)), float(str(now))
    except ValueError:
        return stored == now
    # An infinite one would have every number as near as it may be.
    near = math.isfinite(one) and abs(other - one) <= experiment.atol + experiment.rtol * abs(one)
    return one == other or near
