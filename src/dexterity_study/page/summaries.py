"""A summary table at the head of each module on the pages of the API: its functions and classes, a line each."""

import inspect
from collections.abc import Iterator
from types import ModuleType
from typing import Any

from sphinx.application import Sphinx


def add_summary(_app: Sphinx, what: str, name: str, module: Any, _options: Any, lines: list[str]) -> None:
    """Append the table to the docstring of a module that has more than one function or class."""
    if what == "module" and len(entries := list(_entries(module))) > 1:
        lines += ["", ".. list-table::", "   :class: summary", ""]
        for entry, text in entries:
            lines += [f"   * - :py:obj:`{entry} <{name}.{entry}>`", f"     - {text}"]


def _entries(module: ModuleType) -> Iterator[tuple[str, str]]:
    """Yield name and first line of each function and class that is at home in a module."""
    for name in getattr(module, "__all__", ()):
        thing = getattr(module, name)
        if getattr(thing, "__module__", None) == module.__name__ and (text := inspect.getdoc(thing)):
            yield name, text.splitlines()[0]
