"""Data files that a run reads, seen as it opens them."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path

from dexterity import store


@contextmanager
def data_files_read() -> Iterator[set[str]]:
    """Collect the data files that are opened within the context, by names below `data/`.

    Ledgers are left out: values of assumptions are parameters of a task.
    """
    _listen()
    opened: set[str] = set()
    _COLLECTING.append(opened)
    try:
        yield opened
    finally:
        _COLLECTING.remove(opened)


_COLLECTING: list[set[str]] = []


@cache
def _listen() -> None:
    folder = f"{store.data_path()}{os.sep}"

    def hear(event: str, arguments: tuple[object, ...]) -> None:
        if event == "open" and _COLLECTING and isinstance(arguments[0], str | os.PathLike):
            path = os.fspath(arguments[0])
            if isinstance(path, str) and path.startswith(folder):
                name = Path(path).relative_to(folder).as_posix()
                if not name.startswith("papers/"):
                    for opened in _COLLECTING:
                        opened.add(name)

    # A hook cannot be taken back; it does nothing while nobody collects.
    sys.addaudithook(hear)
