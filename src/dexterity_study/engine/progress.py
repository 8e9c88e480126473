"""Progress of runs: how many have ended, the time that has passed, and an estimate of what is left."""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Sequence
from pathlib import Path
from types import TracebackType

from dexterity_study.engine import card
from dexterity_study.engine.tasks import EvidenceTask


class Progress:
    """Prints a line whenever a run has ended, as long as its context is open.

    A run has ended when its files are newer than the start; so this sees runs of other processes and machines.
    """

    def __init__(self, tasks: Sequence[EvidenceTask], interval: float = 1.0) -> None:
        self._products = {task.name: _product(task) for task in tasks}
        self._expected = {name: _seconds(file) for name, file in self._products.items()}
        self._interval = interval
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._watch, daemon=True)

    def __enter__(self) -> Progress:
        self._started = time.time()
        self._say(f"{len(self._products)} runs, about {_span(sum(self._expected.values()))} of computing")
        self._thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._over.set()
        self._thread.join()

    def _watch(self) -> None:
        waiting = dict(self._products)
        while waiting:
            last = self._over.wait(self._interval)
            for name in [name for name, file in waiting.items() if _is_newer(file, self._started)]:
                del waiting[name]
                self._say_ended(name, waiting)
            if last:
                return

    def _say_ended(self, name: str, waiting: dict[str, Path]) -> None:
        passed = time.time() - self._started
        left = sum(self._expected[one] for one in waiting)
        done = sum(self._expected.values()) - left
        remaining = _span(passed * left / done) if done else "unknown"
        count = f"{len(self._products) - len(waiting)} of {len(self._products)}"
        self._say(f"{count}: {name}; {_span(passed)} passed, {remaining} left")

    @staticmethod
    def _say(text: str) -> None:
        # Past the capture of standard output by pytask.
        sys.__stderr__.write(f"{text}\n") if sys.__stderr__ else None


def _product(task: EvidenceTask) -> Path:
    """Return the product that is written last."""
    return max(task.files, key=lambda path: path.suffix == ".toml")


def _seconds(file: Path) -> float:
    """Return how long a run took the last time; a guess if no card says so, a second for a probe."""
    try:
        return float(card.read(file)["made"]["seconds"]) if file.suffix == ".toml" else 1.0
    except (FileNotFoundError, ValueError, KeyError, TypeError):
        return 10.0


def _is_newer(file: Path, moment: float) -> bool:
    return file.is_file() and file.stat().st_mtime >= moment


def _span(seconds: float) -> str:
    minutes, rest = divmod(round(seconds), 60)
    return f"{minutes} min {rest:02d} s" if minutes else f"{rest} s"
