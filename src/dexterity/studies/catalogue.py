"""Which studies there are, and the results that they are judged by."""

import pkgutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from dexterity.report.claims import Acceptance, Verdict
from dexterity.report.provenance import load_stored, load_study, remember

__all__ = ["STUDIES", "acceptances", "judged", "verdicts", "verdicts_by_study"]


def _found() -> Iterator[str]:
    folder = Path(__file__).parent
    for part in pkgutil.iter_modules([str(folder)]):
        if part.ispkg:
            chapters = pkgutil.iter_modules([str(folder / part.name)])
            yield from (f"{part.name}.{chapter.name}" for chapter in chapters)


STUDIES: tuple[str, ...] = tuple(sorted(_found()))
"""Names of all studies, such as `"uvms.kinematics"`."""


def verdicts() -> tuple[Verdict, ...]:
    """Return the verdicts of all studies, see :func:`judged`."""
    return tuple(verdict for own in verdicts_by_study().values() for verdict in own)


def verdicts_by_study() -> dict[str, tuple[Verdict, ...]]:
    """Return the verdicts of each study, by its name."""
    return {name: load_study(name).verdicts(judged(name)) for name in STUDIES}


def acceptances() -> dict[str, tuple[Acceptance, ...]]:
    """Return the figures that must hold for each study, by its name."""
    return {name: load_study(name).acceptance(judged(name)) for name in STUDIES}


def judged(study_name: str) -> Any:
    """Return the result that a study is judged by.

    That is the run at the present scale, a remembered one where there is one. A study whose networks cannot
    be trained while a book is built says so by `JUDGED_AS_STORED`, and is judged by its stored result.

    Raises
    ------
    ValueError
        If there is no such study, or no stored result where it is needed.
    """
    if not getattr(load_study(study_name), "JUDGED_AS_STORED", False):
        return remember(study_name).result
    stored = load_stored(study_name)
    if stored is None:
        raise ValueError(f"study {study_name} is judged by its stored result, and there is none")
    return stored.run.result
