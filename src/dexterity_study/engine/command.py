"""Evidence from the command line: `python -m dexterity_study.engine.command evidence|stale|accept|probe|smoke`."""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import joblib
import pytask
from pytask import ExitCode

from dexterity import store
from dexterity_study.engine import card, cluster, evidence, runs
from dexterity_study.engine.experiment import Experiment
from dexterity_study.engine.processes import InUse, alone_in
from dexterity_study.engine.progress import Progress
from dexterity_study.engine.state import out_of_date
from dexterity_study.engine.tasks import EvidenceTask, task_name, tasks_of


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; the exit code is 0 if nothing is wrong or, for `stale`, out of date."""
    parser = argparse.ArgumentParser(prog="python -m dexterity_study.engine.command", description=__doc__)
    commands = parser.add_subparsers(required=True, metavar="command")
    for name, (run, says) in _COMMANDS.items():
        command = commands.add_parser(name, help=says)
        command.set_defaults(run=run)
        command.add_argument(
            "part", nargs="?", default="", help="a part, chapter or experiment: uvms, uvms.cost, …"
        )
        if name == "accept":
            command.add_argument("--reason", required=True, help="why the runs still stand, one sentence")
        if name == "evidence":
            command.add_argument("--backend", choices=["loky", "dask"], default="loky")
            command.add_argument("--scheduler", default="", help="address of a dask scheduler")
            command.add_argument("--workers", type=int, default=os.cpu_count() or 1)
    options = vars(parser.parse_args(arguments))
    run, part = options.pop("run"), options.pop("part").replace("/", ".")
    if run not in (_evidence, _accept):
        return run(part, **options)
    try:
        with alone_in(_root() / "data" / "results"):
            return run(part, **options)
    except InUse as busy:
        sys.stdout.write(f"nothing is run or stored: {busy}\n")
        return 3


def _evidence(part: str, backend: str, scheduler: str, workers: int) -> int:
    asked = _tasks(part)
    stale = out_of_date(asked)
    waiting = [task for task in asked if task.name in stale]
    if backend == "dask":
        cluster.use(scheduler)
    failed = False
    with Progress(waiting):
        # What takes times runs alone, one task after the other.
        for timed, count in ((False, workers), (True, 1)):
            chosen = [task for task in waiting if task.is_timed == timed]
            way = "custom" if backend == "dask" else "loky" if count > 1 else "none"
            if chosen:
                failed |= _session(chosen, n_workers=count, parallel_backend=way).exit_code != ExitCode.OK
    return 1 if failed else 0


def _stale(part: str) -> int:
    waiting = _tasks(part)
    by_reason: dict[tuple[str, ...], list[str]] = {}
    for task, why in out_of_date(waiting).items():
        by_reason.setdefault(why, []).append(task)
    for why, names in by_reason.items():
        sys.stdout.write("".join([*(f"{name}\n" for name in names), *(f"  {reason}\n" for reason in why)]))
    count = sum(map(len, by_reason.values()))
    sys.stdout.write(f"{count} of {len(waiting)} tasks are out of date\n")
    return 1 if count else 0


def _accept(part: str, reason: str) -> int:
    stale = out_of_date(_tasks(part))
    asked = [one for one in _experiments(part) if any(task.name in stale for task in tasks_of(one))]
    accepted = []
    for experiment, missed, _ in _probed(asked):
        wrong = [*_unstored(experiment), *missed]
        sys.stdout.write("".join(f"{line}\n" for line in wrong))
        state = "is not accepted" if wrong else "is accepted"
        sys.stdout.write(f"{experiment.chapter}.{experiment.name} {state}\n")
        sys.stdout.flush()
        if not wrong:
            accepted.append(experiment)
            for reading, seed in evidence.runs(experiment):
                if why := stale.get(task_name(experiment, reading, seed)):
                    card.accept(evidence.files(experiment, reading, seed).card, reason, list(why))
    if accepted:
        _lock(" or ".join(f"{one.chapter}.{one.name}[" for one in accepted))
    return 1 if len(accepted) < len(asked) else 0


def _probed(experiments: list[Experiment]) -> Iterator[tuple[Experiment, list[str], float]]:
    """Repeat probes side by side; yield what each misses, and how long it took."""
    jobs = (joblib.delayed(_missed)(one.chapter, one.name) for one in experiments)
    # A single one needs no other process.
    workers = max(1, min(len(experiments), joblib.cpu_count()))
    answers = joblib.Parallel(n_jobs=workers, return_as="generator")(jobs)
    for experiment, (missed, seconds) in zip(experiments, answers, strict=True):
        yield experiment, missed, seconds


def _missed(chapter: str, name: str) -> tuple[list[str], float]:
    started = time.perf_counter()
    missed = list(runs.missed(evidence.experiments(chapter)[name]))
    return missed, time.perf_counter() - started


def _unstored(experiment: Experiment) -> Iterator[str]:
    for reading, seed in evidence.runs(experiment):
        place = evidence.files(experiment, reading, seed)
        if not (place.rows.is_file() and place.card.is_file()):
            yield f"{task_name(experiment, reading, seed)} has never run: make evidence"


def _lock(expression: str) -> None:
    """Record the present state of tasks in `pytask.lock`."""
    tasks = Path(__file__).with_name("task_evidence.py")
    command = [sys.executable, "-m", "pytask", "lock", "accept", "--yes", "-k", expression, str(tasks)]
    done = subprocess.run(command, cwd=_root(), capture_output=True, text=True, check=False)  # noqa: S603
    if done.returncode != ExitCode.OK:
        raise RuntimeError(f"pytask could not record the state of {expression}:\n{done.stdout}")


def _probe(part: str) -> int:
    failed = False
    for experiment, missed, seconds in _probed(_experiments(part)):
        failed |= bool(missed)
        state = "is missed" if missed else "comes out as stored"
        sys.stdout.write("".join(f"{line}\n" for line in missed))
        sys.stdout.write(f"probe of {experiment.chapter}.{experiment.name} {state} ({seconds:.1f} s)\n")
        sys.stdout.flush()
    return 1 if failed else 0


def _smoke(part: str) -> int:
    folder = _root() / "_build" / "evidence"
    for experiment in _experiments(part):
        started = time.perf_counter()
        file = folder / f"{experiment.chapter}.{experiment.name}.csv"
        store.write_atomically(file, runs.smoke_rows(experiment))
        took = time.perf_counter() - started
        sys.stdout.write(
            f"{experiment.chapter}.{experiment.name}: {took:.1f} s, {file.relative_to(_root())}\n"
        )
    return 0


_COMMANDS: Mapping[str, tuple[Callable[..., int], str]] = {
    "evidence": (_evidence, "run what is out of date and store it"),
    "stale": (_stale, "list what is out of date, and why"),
    "accept": (_accept, "repeat the probes, and accept runs although files have changed since"),
    "probe": (_probe, "repeat the probes and compare them with the stored ones"),
    "smoke": (_smoke, "run experiments at smoke effort, into _build/evidence"),
}


# ---- tasks and sessions ----------------------------------------------------------------------------


def _experiments(part: str) -> list[Experiment]:
    chosen = [
        one
        for chapter in evidence.chapters()
        for one in evidence.experiments(chapter).values()
        if f"{chapter}.{one.name}.".startswith(f"{part}." if part else "")
    ]
    if not chosen:
        raise SystemExit(f"there is no part, chapter or experiment {part!r}")
    return chosen


def _tasks(part: str) -> list[EvidenceTask]:
    return [task for experiment in _experiments(part) for task in tasks_of(experiment)]


def _session(chosen: list[EvidenceTask], **options: Any) -> pytask.Session:
    return pytask.build(tasks=chosen, config=_root() / "pyproject.toml", **options)


def _root() -> Path:
    root = store.repository()
    if root is None:
        raise SystemExit("evidence belongs to the source tree, and this is an installed package")
    return root


if __name__ == "__main__":
    sys.exit(main())
