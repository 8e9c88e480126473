"""Register of all measures: every module in the folder ``measures`` holds one, as ``MEASURE``.

The folders are those of the package's path, so that a file in a folder of one's own counts as soon as that
folder is appended to ``dexterity.indices.measures.__path__``.

Examples
--------
>>> from dexterity import indices
>>> len(indices.names()) >= 12
True
>>> indices.describe("w").name
'manipulability'
"""

from __future__ import annotations

import pkgutil
from collections.abc import Mapping
from functools import cache
from importlib import import_module
from types import MappingProxyType

from dexterity import checks
from dexterity.indices import measures
from dexterity.indices.measure import Measure

__all__ = ["describe", "names"]


def names() -> tuple[str, ...]:
    """Names of all measures, in alphabetical order."""
    return tuple(sorted({measure.name for measure in _known().values()}))


def describe(name: str) -> Measure:
    """Measure of that name or alias, whatever its case.

    Raises
    ------
    TypeError
        If the name is no text.
    ValueError
        If no measure is called that; all are listed, with the nearest.
    """
    if not isinstance(name, str):
        raise TypeError(f"name is {checks.shown(name)}; the name of an index is needed: {', '.join(names())}")
    known = _known()
    wanted = name.strip().lower().replace(" ", "_").replace("-", "_")
    if wanted in known:
        return known[wanted]
    raise ValueError(f"name is {checks.shown(name)}; {checks.hint(name, known, names())}")


def _known() -> Mapping[str, Measure]:
    return _in_folders(tuple(measures.__path__))


@cache
def _in_folders(folders: tuple[str, ...]) -> Mapping[str, Measure]:
    known: dict[str, Measure] = {}
    for module in pkgutil.iter_modules(folders, f"{measures.__name__}."):
        measure = import_module(module.name).MEASURE
        for name in (measure.name, *measure.aliases):
            if known.setdefault(name, measure) is not measure:
                raise ValueError(f"two measures are called {name!r}: {known[name].title} and {measure.title}")
    return MappingProxyType(known)
