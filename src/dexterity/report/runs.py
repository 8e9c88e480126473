"""Runs of studies, remembered as long as nothing changes that could change them.

A run is remembered under its config, the source it was made from (`sources.source_key`) and the machine. A
file that was damaged, or that belongs to another run, is never believed: the study runs again and the file
is replaced.
"""

import time
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from dexterity import store
from dexterity.report.records import from_json, from_plain, to_json
from dexterity.report.sources import last_change, lock_hash, source_key
from dexterity.report.study import load_study, module_name, scale
from dexterity.timing import Machine

__all__ = ["Run", "remember", "run_study", "with_types"]

_LOADED = time.time()


@dataclass(frozen=True)
class Run:
    """A result with what it was made from.

    Attributes
    ----------
    study
        Name of the study.
    config, result
        The study's `Config` and `Result`.
    seconds
        How long it took, [s].
    source_key
        Key of the code, the data and the pins of what the code imports.
    lock_hash
        Key of the environment's lock; None where there is none.
    machine
        What it ran on.
    date
        Day, in UTC, as YYYY-MM-DD.
    """

    study: str
    config: Any
    result: Any
    seconds: float
    source_key: str
    lock_hash: str | None
    machine: Machine
    date: str

    @property
    def key(self) -> str:
        """The name under which the run is remembered."""
        return _key(self.study, self.config, self.source_key, self.machine)


def remember(study_name: str, config: object = None) -> Run:
    """Return the result of a study: the remembered one, if nothing that made it has changed, or a new one.

    Outside a source tree nothing is remembered. Nor is a run whose source changed after this process
    started, since the code that ran may be older than the files.

    Parameters
    ----------
    study_name
        Part and chapter, such as `"uvms.kinematics"`.
    config
        An instance of the study's `Config`; None for its config at the present scale.

    Raises
    ------
    ValueError
        If there is no such study, or the scale is unknown.
    TypeError
        If `config` is not the study's, or the result has a part that has no place in a record.
    """
    if config is None:
        config = load_study(study_name).CONFIGS[scale()]
    module = module_name(study_name)
    key = _key(study_name, config, source_key(module), Machine.present())
    known = _remembered(study_name, key)
    if known is not None:
        return known
    run = run_study(study_name, config)
    folder = _folder(study_name)
    if folder is not None and last_change(module) <= _LOADED:
        store.write_atomically(folder / f"{run.key}.json", to_json(run))
    return run


def run_study(study_name: str, config: object) -> Run:
    """Run a study, whatever is remembered; the arguments and errors are those of `remember`."""
    study = load_study(study_name)
    if not isinstance(config, study.Config):
        raise TypeError(f"config is {type(config).__name__}; study {study_name} takes its own Config")
    source = source_key(module_name(study_name))
    started = time.perf_counter()
    result = study.run(config)
    run = Run(
        study=study_name,
        config=config,
        result=result,
        seconds=time.perf_counter() - started,
        source_key=source,
        lock_hash=lock_hash(),
        machine=Machine.present(),
        date=datetime.now(UTC).date().isoformat(),
    )
    # Read back what would be written, so that a new result and a remembered one are the same to the bit.
    return with_types(from_json(to_json(run), Run))


def with_types(run: Run) -> Run:
    """Give the config and the result of a run, as they come from a file, the types of its study.

    Raises
    ------
    ValueError
        If they do not fit.
    """
    study = load_study(run.study)
    return replace(
        run, config=from_plain(run.config, study.Config), result=from_plain(run.result, study.Result)
    )


def _key(study_name: str, config: object, source: str, machine: Machine) -> str:
    return store.content_key(study_name, config, source, machine)


def _folder(study_name: str) -> Path | None:
    root = store.repository()
    return root / ".results" / study_name if root else None


def _remembered(study_name: str, key: str) -> Run | None:
    folder = _folder(study_name)
    if folder is None:
        return None
    try:
        record = from_json((folder / f"{key}.json").read_bytes(), Run)
        run = with_types(record) if record.study == study_name else None
    except (FileNotFoundError, ValueError):
        return None
    return run if run and run.key == key else None
