"""A bar with the remaining time, on standard error, for subcommands that take more than a moment.

Examples
--------
>>> from dexterity.command.progress import Bar
>>> with Bar("poses") as bar:
...     for done in range(3):
...         bar(done + 1, 3)
"""

from __future__ import annotations

import sys
import time
from types import TracebackType

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from dexterity.command.reports import say

__all__ = ["Bar"]

SECONDS_BETWEEN_LINES = 10.0
"""Time between two lines where standard error is no terminal."""


class Bar:
    """Called with what is done and what there is to do; draws a bar in a terminal, and lines elsewhere.

    Parameters
    ----------
    noun
        What is counted.
    """

    def __init__(self, noun: str) -> None:
        self.noun = noun
        self._started = self._said = time.monotonic()
        self._progress: Progress | None = None
        if sys.stderr.isatty():
            self._progress = Progress(
                TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn(),
                console=Console(stderr=True), transient=True,
            )  # fmt: skip
            self._task = self._progress.add_task(noun, total=None)

    def __enter__(self) -> Bar:
        if self._progress is not None:
            self._progress.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._progress is not None:
            self._progress.stop()

    def __call__(self, done: int, total: int) -> None:
        """Show that `done` of `total` are finished."""
        if self._progress is not None:
            self._progress.update(self._task, completed=done, total=total)
        elif 0 < done < total and time.monotonic() - self._said >= SECONDS_BETWEEN_LINES:
            self._said = time.monotonic()
            left = (self._said - self._started) * (total - done) / done
            say(f"{self.noun}: {done} of {total}, {_duration(left)} left")

    def step(self, text: str, done: int, total: int) -> None:
        """Show that `done` of `total` are finished, and what is at work."""
        if self._progress is not None:
            self._progress.update(self._task, description=f"{self.noun}: {text}")
        self(done, total)


def _duration(seconds: float) -> str:
    minutes, rest = divmod(round(seconds), 60)
    return f"{minutes} min {rest} s" if minutes else f"{rest} s"
