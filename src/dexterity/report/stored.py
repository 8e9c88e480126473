"""Results of long studies, stored with the source, and the probes that show whether they still hold.

`data/results/<part>-<chapter>.json` holds a run at full scale and a probe: a short run with the tolerance
to which it must come out again. A study whose probe cannot come out again to the last digits says how far
it may differ in a `TOLERANCE` of its own.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from dexterity import store
from dexterity.report.records import from_json, from_plain, to_json, to_plain
from dexterity.report.runs import Run, run_study, with_types
from dexterity.report.sources import source_key
from dexterity.report.study import load_study, module_name

__all__ = ["Probe", "ProbeMissed", "Stored", "Tolerance", "check_stored", "load_stored", "write_stored"]


@dataclass(frozen=True)
class Tolerance:
    """How far a float of a probe may be from the stored one: `atol` + `rtol` · abs(stored)."""

    rtol: float = 1e-9
    atol: float = 1e-12


@dataclass(frozen=True)
class Probe:
    """A short run of a study, to be repeated."""

    config: Any
    result: Any
    tolerance: Tolerance


@dataclass(frozen=True)
class Stored:
    """A run at full scale, with its probe."""

    run: Run
    probe: Probe

    @property
    def is_current(self) -> bool:
        """Whether the source that the run was made from is the present one."""
        return self.run.source_key == source_key(module_name(self.run.study))


class ProbeMissed(Exception):  # noqa: N818 -- it is a finding, not a fault
    """A probe that does not come out as stored."""


def write_stored(study_name: str) -> Path:
    """Run a study at full scale, and its probe, and store both.

    Parameters
    ----------
    study_name
        Part and chapter, such as `"uvms.kinematics"`.

    Returns
    -------
    The file that was written.

    Raises
    ------
    ValueError
        If there is no such study.
    RuntimeError
        If the package does not run from a source tree.
    """
    root = store.repository()
    if root is None:
        raise RuntimeError("stored results belong to the source tree, and this is an installed package")
    study = load_study(study_name)
    full, short = (run_study(study_name, study.CONFIGS[scale]) for scale in ("full", "smoke"))
    probe = Probe(short.config, short.result, getattr(study, "TOLERANCE", Tolerance()))
    file = root / "data" / "results" / _file_name(study_name)
    store.write_atomically(file, to_json(Stored(full, probe)))
    return file


def load_stored(study_name: str) -> Stored | None:
    """Read the stored result of a study; None if there is none.

    Raises
    ------
    ValueError
        If the file is damaged, is another study's, or no longer fits the study's `Config` and `Result`.
    """
    try:
        file = store.data_path("results", _file_name(study_name))
    except FileNotFoundError:
        return None
    try:
        stored = from_json(file.read_bytes(), Stored)
        if stored.run.study != study_name:
            raise ValueError(f"is of study {stored.run.study}")
        return replace(stored, run=with_types(stored.run), probe=_typed_probe(stored.probe, study_name))
    except ValueError as error:
        raise ValueError(f"{file.name} must be renewed by `make full STUDY={study_name}`: {error}") from error


def check_stored(study_name: str) -> None:
    """Repeat the probe of a stored result.

    Raises
    ------
    ProbeMissed
        If a number is off by more than the stored tolerance, or anything else differs; it lists what does.
    ValueError
        If there is no stored result, or it cannot be read.
    """
    stored = load_stored(study_name)
    if stored is None:
        raise ValueError(f"study {study_name} has no stored result")
    probe = stored.probe
    again = run_study(study_name, probe.config)
    differences = list(
        _differences("result", to_plain(probe.result), to_plain(again.result), probe.tolerance)
    )
    if differences:
        raise ProbeMissed(
            "\n".join([f"the probe of {study_name} does not come out as stored:", *differences])
        )


def _file_name(study_name: str) -> str:
    return f"{study_name.replace('.', '-')}.json"


def _typed_probe(probe: Probe, study_name: str) -> Probe:
    study = load_study(study_name)
    return replace(
        probe, config=from_plain(probe.config, study.Config), result=from_plain(probe.result, study.Result)
    )


def _differences(place: str, stored: Any, now: Any, tolerance: Tolerance) -> Iterator[str]:
    if isinstance(stored, dict) and isinstance(now, dict) and stored.keys() == now.keys():
        for name in stored:
            yield from _differences(f"{place}.{name}", stored[name], now[name], tolerance)
    elif isinstance(stored, list | tuple) and isinstance(now, list | tuple) and len(stored) == len(now):
        for index, (one, other) in enumerate(zip(stored, now, strict=True)):
            yield from _differences(f"{place}[{index}]", one, other, tolerance)
    elif not _agree(stored, now, tolerance):
        yield f"{place}: stored {stored!r}, now {now!r}"


def _agree(stored: Any, now: Any, tolerance: Tolerance) -> bool:
    if isinstance(stored, float) and isinstance(now, float):
        return abs(now - stored) <= tolerance.atol + tolerance.rtol * abs(stored)
    return bool(stored == now)
