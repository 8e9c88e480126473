"""Where the numbers of a chapter come from.

`remember` gives a chapter the result of a study, `load_stored` the stored one of the long run, and `footer`
says what both were made from.

From the command line, `python -m dexterity.report.provenance fresh-cache FOLDER` empties the book's
execution cache when the source is no longer the one that it was filled from.
"""

import argparse
import dataclasses
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from dexterity.report import execution_cache
from dexterity.report.markup import Markup, definitions
from dexterity.report.runs import Run, remember
from dexterity.report.sources import source_key
from dexterity.report.stored import (
    ProbeMissed,
    Stored,
    Tolerance,
    check_stored,
    load_stored,
    write_stored,
)
from dexterity.report.study import load_study, scale
from dexterity.store import content_key

__all__ = [
    "ProbeMissed",
    "Run",
    "Stored",
    "Tolerance",
    "check_stored",
    "footer",
    "load_stored",
    "load_study",
    "remember",
    "scale",
    "source_key",
    "write_stored",
]


def footer(*runs: Run) -> Markup:
    """Close a chapter with what its runs were made from.

    Parameters
    ----------
    runs
        The runs that the chapter shows.

    Raises
    ------
    ValueError
        If a stored result of one of the studies cannot be read.
    """
    lists = (definitions(f"Provenance of {run.study}", _facts(run), "provenance") for run in runs)
    return Markup("\n".join(lists))


def _facts(run: Run) -> dict[str, str]:
    return {
        "Study": run.study,
        "Scale": _scale_of(run),
        "Seeds": ", ".join(_seeds(run.config)) or "no random draw",
        "Run time": f"{run.seconds:.3g} s on {run.date}",
        "Source key": run.source_key,
        "Lock": run.lock_hash or "none",
        "Machine": str(run.machine),
        "Stored result": _stored_result(run.study),
    }


def _scale_of(run: Run) -> str:
    configs = load_study(run.study).CONFIGS
    names = (name for name in (scale(), *configs) if content_key(configs[name]) == content_key(run.config))
    return next(names, "a config of its own")


def _seeds(config: Any) -> Iterator[str]:
    """Yield every seed that a config declares, here or in a dataclass within."""
    for field in dataclasses.fields(config):
        value = getattr(config, field.name)
        if dataclasses.is_dataclass(value):
            yield from _seeds(value)
        elif field.name == "seed":
            yield str(value)
        elif field.name == "seeds":
            yield from map(str, value)


def _stored_result(study_name: str) -> str:
    stored = load_stored(study_name)
    if stored is None:
        return "none"
    return f"{'current' if stored.is_current else 'from other sources'} ({stored.run.date})"


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; the exit code is 0 if all is well."""
    parser = argparse.ArgumentParser(
        prog="python -m dexterity.report.provenance", description="Look after what the book remembers."
    )
    commands = parser.add_subparsers(required=True, metavar="command")
    fresh_cache = commands.add_parser("fresh-cache", help="empty an execution cache whose source has changed")
    fresh_cache.add_argument("folder", type=Path, help="the cache's folder")
    folder = parser.parse_args(arguments).folder
    try:
        emptied = execution_cache.refresh(folder)
    except (OSError, ValueError) as error:
        parser.exit(1, f"{error}\n")
    sys.stdout.write(f"{folder}: {'emptied, the source has changed' if emptied else 'up to date'}\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
