"""What has changed since a run was recorded in `pytask.lock`."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

from pytask import PNode

from dexterity import store
from dexterity_study.engine.experiment import Experiment
from dexterity_study.engine.tasks import EvidenceTask, tasks_of


def out_of_date(tasks: list[EvidenceTask]) -> dict[str, tuple[str, ...]]:
    """Return what has changed, by names of the tasks for which anything has."""
    changed = {task.name: changes(task) for task in tasks}
    return {name: why for name, why in changed.items() if why}


def changes(task: EvidenceTask) -> tuple[str, ...]:
    """Return the files and parameters of a task that are not as recorded, each with what became of it."""
    entry = _lock().get(task.name)
    if entry is None:
        return ("never recorded",)
    return tuple(
        f"{place}: {'missing' if now is None else 'changed' if then else 'new'}"
        for recorded, nodes in (
            (entry.get("depends_on", {}), task.depends_on),
            (entry.get("produces", {}), task.produces),
        )
        for place, now, then in _compared(recorded, nodes)
        if now != then
    )


def changed_since(experiment: Experiment) -> tuple[str, ...]:
    """Return what has changed since the runs of an experiment were recorded, over all its runs."""
    return tuple(dict.fromkeys(why for task in tasks_of(experiment) for why in changes(task)))


def _compared(recorded: dict[str, str], nodes: Any) -> Iterator[tuple[str, str | None, str | None]]:
    present = {node.name: node.state() for node in _leaves(nodes)}
    for place in [*present, *(recorded.keys() - present.keys())]:
        yield place, present.get(place), recorded.get(place)


def _leaves(nodes: Any) -> Iterator[PNode]:
    for node in nodes.values():
        if isinstance(node, dict):
            yield from _leaves(node)
        else:
            yield node


def _lock() -> dict[str, dict[str, Any]]:
    root = store.repository()
    file = root / "pytask.lock" if root else None
    return _entries(file, file.stat().st_mtime_ns) if file and file.is_file() else {}


@cache
def _entries(file: Path, changed: int) -> dict[str, dict[str, Any]]:  # noqa: ARG001 -- a changed file is read again
    return {entry["id"]: entry for entry in store.read_toml(file).get("task", [])}
