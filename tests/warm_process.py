"""Processes that need not import torch again: forks of one that has, and that has nothing of this tree.

The run-time checks of annotations in the tests are not in them. They see the packages of any source tree.
"""

import atexit
import os
import runpy
import signal
import sys
import tempfile
import time
from collections.abc import Mapping, Sequence
from multiprocessing import get_context
from pathlib import Path

_TREE = Path(__file__).parents[1]
_FORKS = get_context("forkserver")
_FORKS.set_forkserver_preload(
    ["torch", "numpy", "scipy.linalg", "sympy", "joblib", "pytask", "torch._dynamo"]
)


class WarmProcess:
    """A process that runs a module, as ``python -m`` does, or a program, as ``python -c`` does.

    Parameters
    ----------
    program
        Name of a module, or text of a program with more than one line.
    arguments
        What it finds in ``sys.argv``.
    tree
        Source tree whose packages it imports; this one by default.
    folder
        Working folder; the tree by default.
    environment
        Variables that are added to those of this process.
    """

    def __init__(
        self,
        program: str,
        *arguments: str,
        tree: Path = _TREE,
        folder: Path | None = None,
        environment: Mapping[str, str] | None = None,
    ) -> None:
        handle, self._log = tempfile.mkstemp()
        os.close(handle)
        variables = {**os.environ, "PYTHONPATH": str(tree / "src"), **(environment or {})}
        variables |= {"OMP_NUM_THREADS": "1"}
        given = (program, arguments, tree / "src", folder or tree, variables, self._log)
        # The name tells what is started that this is nobody's worker.
        self._process = _FORKS.Process(target=_run, args=given, name="MainProcess")
        self._process.start()

    @property
    def pid(self) -> int:
        """Number of the process, which leads a group of its own."""
        return self._process.pid

    def kill(self, number: int = signal.SIGKILL) -> None:
        """Send a signal to the process and all of its group."""
        os.killpg(self.pid, number)

    def end(self, timeout: float = 300) -> tuple[int, str]:
        """Wait for the end; return the exit code and what was printed and written to standard error."""
        self._process.join(timeout)
        if (code := self._process.exitcode) is None:
            self.kill()
            raise TimeoutError(Path(self._log).read_text(encoding="utf-8"))
        printed = Path(self._log).read_text(encoding="utf-8")
        Path(self._log).unlink()
        return code, printed


def _run(
    program: str, arguments: Sequence[str], packages: Path, folder: Path, variables: dict[str, str], log: str
) -> None:
    os.setsid()
    output = os.open(log, os.O_WRONLY | os.O_APPEND)
    os.dup2(output, 1)
    os.dup2(output, 2)
    os.environ.clear()
    os.environ.update(variables)
    sys.path.insert(0, str(packages))
    os.chdir(folder)
    sys.argv = ["-c", *arguments]
    try:
        if "\n" in program:
            exec(compile(program, "<program>", "exec"), {"__name__": "__main__"})
        else:
            runpy.run_module(program, run_name="__main__", alter_sys=True)
    finally:
        atexit._run_exitfuncs()


def wait_for(condition: object, seconds: float = 120) -> None:
    """Wait until a condition, a function without arguments, holds."""
    end = time.monotonic() + seconds
    while not condition():  # type: ignore[operator]
        assert time.monotonic() < end, "waited in vain"
        time.sleep(0.05)
