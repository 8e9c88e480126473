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
from importlib.util import find_spec
from types import ModuleType

__all__ = ["submodules"]


def submodules(
    package: str, names: Sequence[str]
) -> tuple[Callable[[str], ModuleType], Callable[[], list[str]]]:
    """Return ``__getattr__`` and ``__dir__`` of a package (PEP 562): all its modules are its attributes.

    Parameters
    ----------
    package
        Name of the package.
    names
        Names that it exports, which are listed whether they are imported yet or not.
    """

    def get(name: str) -> ModuleType:
        if name.startswith("_") or find_spec(f"{package}.{name}") is None:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        return import_module(f"{package}.{name}")

    def listed() -> list[str]:
        return sorted({*vars(sys.modules[package]), *names})

    return get, listed
