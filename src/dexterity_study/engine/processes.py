"""Processes of the study: one at a time in a folder, and none that goes on without the one that started it."""

from __future__ import annotations

import fcntl
import os
import signal
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path


class InUse(RuntimeError):  # noqa: N818 -- it says what a folder is
    """Another process works in a folder."""


@contextmanager
def alone_in(folder: Path) -> Iterator[None]:
    """Hold a folder, which is made if it is missing; it is free again when the process ends, however it ends.

    Raises
    ------
    InUse
        If another process holds it.
    """
    folder.mkdir(parents=True, exist_ok=True)
    handle = os.open(folder, os.O_RDONLY)
    try:
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError as error:
            raise InUse(f"another process works in {folder}: wait until it has ended, or stop it") from error
        yield
    finally:
        os.close(handle)


@cache
def end_with_parent(seconds: float = 0.5) -> None:
    """Have this process killed when the one that started it is gone, which is looked at so often [s]."""
    parent = os.getppid()

    def watch() -> None:
        while os.getppid() == parent:
            time.sleep(seconds)
        os.kill(os.getpid(), signal.SIGKILL)

    threading.Thread(target=watch, daemon=True).start()
