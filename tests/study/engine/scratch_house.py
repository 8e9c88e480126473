"""A small copy of the source tree with one chapter of its own, to be edited, killed and looked at."""

from __future__ import annotations

import contextlib
import json
import os
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

from dexterity import store
from warm_process import WarmProcess

EXPERIMENT = '''"""Tiny."""

import time
from dexterity import robots
from dexterity.timing.measurement import Timing
from dexterity_study.engine.experiment import experiment
from dexterity_study.uvms.tiny.sampler import draw

LOOKS = "docstring-free constant"


@experiment(seeds=3, keys=("size",), smoke={"pause": 0.0}, data=("robots/uvms.toml",))
def errors(seed, pause=0.0, sizes=(1, 2)):
    """Errors."""
    time.sleep(pause)
    for size in sizes:
        yield {"size": size, "error": draw(seed) / size, "joints": robots.uvms().joints}


@experiment(timed=True, unsteady=("seconds",))
def speed(seed):
    yield {"seconds": time.perf_counter(), "kind": Timing.__name__}
'''
SAMPLER = '''"""Draws."""

import random


def draw(seed):
    """Draw a number."""
    return random.Random(seed).random()
'''


STALE_AFTER = """
import json, sys
from collections.abc import Callable, Iterator
from pathlib import Path
from dexterity_study.engine.state import out_of_date
from dexterity_study.engine.tasks import tasks

answers = []
for file, old, new in json.loads(sys.argv[2]):
    path = Path(sys.argv[1], file)
    before = path.read_text(encoding="utf-8")
    assert old in before, (file, old)
    path.write_text(before.replace(old, new, 1), encoding="utf-8")
    answers.append(out_of_date(list(tasks())))
    path.write_text(before, encoding="utf-8")
print(json.dumps(answers))
"""


CLUSTER = """
import json, sys
from distributed import Client, LocalCluster

if __name__ == "__main__":
    cluster = LocalCluster(n_workers=int(sys.argv[1]), threads_per_worker=1, dashboard_address=None)
    client = Client(cluster)
    print(cluster.scheduler_address, flush=True)
    for line in sys.stdin:
        if line.strip() == "stop":
            break
        workers = client.scheduler_info(n_workers=-1)["workers"]
        pids = client.run(lambda: __import__("os").getpid())
        print(json.dumps([pids[one] for one in workers]), flush=True)
    client.close()
    cluster.close()
"""


class House:
    """A copy of the library and the engine in a folder, with the chapter `uvms.tiny`."""

    def __init__(self, folder: Path) -> None:
        root = store.repository()
        assert root is not None
        self.root = folder
        chapter = folder / "src/dexterity_study/uvms/tiny"
        left_out = shutil.ignore_patterns("__pycache__", "studies", "report")
        shutil.copytree(root / "src/dexterity", folder / "src/dexterity", ignore=left_out)
        shutil.copytree(
            root / "src/dexterity_study/engine", folder / "src/dexterity_study/engine", ignore=left_out
        )
        shutil.copytree(root / "data/robots", folder / "data/robots")
        shutil.copy(root / "data/tasks.toml", folder / "data")
        shutil.copy(root / "pyproject.toml", folder)
        chapter.mkdir(parents=True)
        for package in (chapter, chapter.parent, chapter.parent.parent):
            (package / "__init__.py").write_text("")
        (chapter / "experiment.py").write_text(EXPERIMENT)
        (chapter / "sampler.py").write_text(SAMPLER)
        (chapter / "verdicts.py").write_text('"""Judges."""\nSENTENCE = "It holds."\n')
        self.chapter = chapter

    @property
    def results(self) -> Path:
        """Folder of the chapter's evidence."""
        return self.root / "data/results/uvms/tiny"

    def edit(self, file: str | Path, old: str, new: str) -> None:
        """Replace a text in a file, which must have it."""
        path = self.root / file
        text = path.read_text(encoding="utf-8")
        assert old in text
        path.write_text(text.replace(old, new), encoding="utf-8")

    def stale_after(self, edits: list[tuple[str, str, str]]) -> list[dict[str, list[str]]]:
        """Make one edit after the other, each undone again, and return what is stale with it, by task."""
        code, printed = WarmProcess(STALE_AFTER, str(self.root), json.dumps(edits), tree=self.root).end()
        assert code == 0, printed
        return json.loads(printed)

    @contextlib.contextmanager
    def cluster(self, workers: int) -> Iterator[tuple[str, Callable[[], list[int]]]]:
        """Run a dask cluster of processes; yield its address and how to list its workers."""
        environment = os.environ | {"PYTHONPATH": str(self.root / "src"), "OMP_NUM_THREADS": "1"}
        command = [sys.executable, "-c", CLUSTER, str(workers)]
        pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "text": True}
        process = subprocess.Popen(command, cwd=self.root, env=environment, **pipes)  # type: ignore[call-overload]

        def alive() -> list[int]:
            process.stdin.write("workers\n")
            process.stdin.flush()
            return json.loads(process.stdout.readline())

        try:
            yield process.stdout.readline().strip(), alive
        finally:
            process.communicate("stop\n", timeout=60)

    def start(self, *arguments: str) -> WarmProcess:
        """Start the engine's command line."""
        return WarmProcess("dexterity_study.engine.command", *arguments, tree=self.root)

    def run(self, *arguments: str) -> tuple[int, str]:
        """Run the engine's command line and return its exit code and what it printed."""
        return self.start(*arguments).end()
