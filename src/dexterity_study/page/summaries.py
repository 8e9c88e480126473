"""A summary table at the head of each module on the pages of the API: its functions and classes, a line each."""

import inspect
from collections.abc import Iterable, Iterator
from types import ModuleType
from typing import Any

from sphinx.application import Sphinx


def add_summary(_app: Sphinx, what: str, name: str, module: Any, options: Any, lines: list[str]) -> None:
    """Append the table to the docstring of a module of which more than one function or class is shown."""
    if what != "module" or not (members := options.get("members")):
        return
    listed = members if isinstance(members, list) else getattr(module, "__all__", ())
    if len(entries := list(_entries(module, listed))) > 1:
        lines += ["", ".. list-table::", "   :class: summary", ""]
        for entry, text in entries:
            lines += [f"   * - :py:obj:`{entry} <{name}.{entry}>`", f"     - {text}"]


def _entries(module: ModuleType, names: Iterable[str]) -> Iterator[tuple[str, str]]:
    """Yield name and first line of those functions and classes that are at home in a module."""
    for name in names:
        thing = getattr(module, name)
        if getattr(thing, "__module__", None) == module.__name__ and (text := inspect.getdoc(thing)):
            yield name, text.splitlines()[0]
