"""Modules of a package that are imported when they are first used.

Examples
--------
>>> from dexterity import lazy
>>> get, listed = lazy.submodules("dexterity.workspace", ["maps"])
>>> get("maps").__name__, "maps" in listed()
('dexterity.workspace.maps', True)
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from importlib import import_module
from types import ModuleType

__all__ = ["submodules"]


def submodules(
    package: str, names: Sequence[str]
) -> tuple[Callable[[str], ModuleType], Callable[[], list[str]]]:
    """Return ``__getattr__`` and ``__dir__`` of a package (PEP 562).

    Parameters
    ----------
    package
        Name of the package.
    names
        Names that it exports; those that it does not define are modules of it, imported at first use.
    """

    def get(name: str) -> ModuleType:
        if name not in names:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        return import_module(f"{package}.{name}")

    def listed() -> list[str]:
        return sorted({*vars(sys.modules[package]), *names})

    return get, listed
