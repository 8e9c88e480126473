"""The studies behind the book: one module a chapter, a frozen config in and a frozen result out.

A study lies in the folder of its part and is found there; `dexterity.report.study.Study` says what it offers.
"""

import pkgutil
from collections.abc import Iterator
from pathlib import Path

from dexterity.report.claims import Acceptance, Verdict
from dexterity.report.provenance import load_study, remember

__all__ = ["STUDIES", "acceptances", "verdicts", "verdicts_by_study"]


def _found() -> Iterator[str]:
    for folder in map(Path, __path__):
        for part in pkgutil.iter_modules([str(folder)]):
            if part.ispkg:
                chapters = pkgutil.iter_modules([str(folder / part.name)])
                yield from (f"{part.name}.{chapter.name}" for chapter in chapters)


STUDIES: tuple[str, ...] = tuple(sorted(_found()))
"""Names of all studies, such as `"uvms.kinematics"`."""


def verdicts() -> tuple[Verdict, ...]:
    """Return the verdicts of all studies at the present scale, from remembered runs where there are any."""
    return tuple(verdict for own in verdicts_by_study().values() for verdict in own)


def verdicts_by_study() -> dict[str, tuple[Verdict, ...]]:
    """Return the verdicts of each study, by its name."""
    return {name: load_study(name).verdicts(remember(name).result) for name in STUDIES}


def acceptances() -> dict[str, tuple[Acceptance, ...]]:
    """Return the figures that must hold for each study, by its name."""
    return {name: load_study(name).acceptance(remember(name).result) for name in STUDIES}
