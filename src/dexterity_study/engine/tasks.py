"""Experiments as tasks of pytask: each run of each experiment, and its probe."""

from __future__ import annotations

import json
import multiprocessing
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from pytask import PathNode, PythonNode, TaskWithoutPath

from dexterity import store
from dexterity_study.engine import evidence, runs, sources
from dexterity_study.engine.experiment import Experiment
from dexterity_study.engine.processes import end_with_parent


@dataclass(kw_only=True)
class SourceNode(PathNode):
    """A source file, which changes with what its code does."""

    def state(self) -> str:
        """Return the fingerprint of the file."""
        return sources.fingerprint(Path(str(self.path)))


@dataclass(kw_only=True)
class PrintedNode(PathNode):
    """A ledger, which changes with what the paper prints, and not with our words about it."""

    def state(self) -> str:
        """Return a key of the printed values and their roundings."""
        ledger = store.read_toml(Path(str(self.path)))
        printed = {
            entry["id"]: [entry.get("value"), entry.get("rounding")]
            for entries in ledger.values()
            for entry in entries
        }
        return store.content_key(printed)


@dataclass(kw_only=True)
class ParameterNode(PythonNode):
    """The parameters of one task, which change with their value."""

    task: str
    name: str = "parameters"
    hash: bool = True

    @property
    def signature(self) -> str:
        """Return a name that no other node has."""
        return f"{self.task} {self.name}"


@dataclass(kw_only=True)
class EvidenceTask(TaskWithoutPath):
    """A task that depends on what its nodes name, and not on the file that declares it."""

    is_timed: bool = False
    files: tuple[Path, ...] = ()

    def state(self) -> str:
        """Return a constant: the nodes say all."""
        return "0"


def tasks() -> Iterator[EvidenceTask]:
    """Yield the tasks of all chapters."""
    for chapter in evidence.chapters():
        for experiment in evidence.experiments(chapter).values():
            yield from tasks_of(experiment)


def tasks_of(experiment: Experiment) -> Iterator[EvidenceTask]:
    """Yield the tasks of an experiment: its probe, and each of its runs."""
    made_from = _nodes(experiment)
    yield _task(
        experiment, "chosen", experiment.seeds[0], made_from, [evidence.probe_file(experiment)], probe=True
    )
    for reading, seed in evidence.runs(experiment):
        place = evidence.files(experiment, reading, seed)
        products = [place.rows, place.card, *([place.arrays] if experiment.arrays else [])]
        yield _task(experiment, reading, seed, made_from, products)


def task_name(experiment: Experiment, reading: str = "", seed: int = 0) -> str:
    """Return the name of the task of a run; of the probe, where no reading is named."""
    which = f"{reading}.{seed}" if reading else "probe"
    return f"{experiment.chapter}.{experiment.name}[{which}]"


def _task(
    experiment: Experiment,
    reading: str,
    seed: int,
    made_from: dict[str, PathNode],
    products: list[Path],
    *,
    probe: bool = False,
) -> EvidenceTask:
    name = task_name(experiment) if probe else task_name(experiment, reading, seed)
    values = experiment.reading(reading).only(*experiment.assumes) if experiment.assumes else {}
    parameters = {"task": name, "reading": reading, "values": values, "seed": seed}
    text = json.dumps(parameters, sort_keys=True)
    return EvidenceTask(
        name=name,
        function=_execute,
        depends_on={"made_from": made_from, "parameters": ParameterNode(task=name, value=text)},
        produces={"products": {path.name: PathNode(name=_name(path), path=path) for path in products}},
        is_timed=experiment.timed,
        files=tuple(products),
    )


def _execute(made_from: dict[str, Path], parameters: str, products: dict[str, Path]) -> None:  # noqa: ARG001
    if multiprocessing.current_process().name != "MainProcess":
        end_with_parent()
    asked = json.loads(parameters)
    name, _, which = asked["task"].rstrip("]").partition("[")
    chapter, _, experiment = name.rpartition(".")
    if which == "probe":
        runs.run_probe(chapter, experiment)
    else:
        runs.run(chapter, experiment, asked["reading"], asked["seed"])


def _nodes(experiment: Experiment) -> dict[str, PathNode]:
    """Return what an experiment depends on: the source of its imports, and the data files that it names."""
    nodes: list[PathNode] = [
        SourceNode(name=_name(path), path=path) for path in sources.closure(experiment.module).values()
    ]
    for name in experiment.data:
        path = store.data_path(*name.split("/"))
        node = PrintedNode if name.startswith("papers/") else PathNode
        files = sorted(path.rglob("*")) if path.is_dir() else [path]
        nodes += [node(name=_name(file), path=file) for file in files if file.is_file()]
    return {node.name: node for node in nodes}


def _name(path: Path) -> str:
    root = store.repository()
    return path.relative_to(root).as_posix() if root else path.as_posix()
