"""Execution of notebooks without a time limit.

A cell may take as long as it needs. A kernel counts as hung only if it has neither answered nor computed
for a while, so a slow or busy machine fails nothing.
"""

import asyncio
import os
import re
import signal
import tempfile
from dataclasses import dataclass
from typing import Any

import psutil
from nbclient import NotebookClient
from nbclient.exceptions import CellExecutionError, DeadKernelError
from nbformat import NotebookNode
from traitlets.config import Config

NO_LIMIT = 10**8  # [s]; nbclient takes no None for these limits

_CHECKS = 60  # of a kernel's progress, within the time after which it counts as hung
_IDLE = 1e-3  # share of a core that a waiting kernel's own housekeeping stays below
_ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
_COLOUR = re.compile(r"\x1b\[[0-9;]*m")


@dataclass
class CellFailed(Exception):  # noqa: N818 -- it says what became of a cell
    """A cell that raised, wrote to stderr, hung, or lost its kernel.

    Attributes
    ----------
    cell
        Index of the cell among all cells of the notebook.
    reason, details
        One line, and the traceback or the text on stderr.
    """

    cell: int
    reason: str
    details: str = ""


class Execution(NotebookClient):
    """One notebook being executed, from an empty folder and with one thread."""

    def __init__(self, notebook: NotebookNode, hung_after: float) -> None:
        super().__init__(
            notebook,
            kernel_name="python3",
            timeout=None,
            startup_timeout=NO_LIMIT,
            iopub_timeout=NO_LIMIT,
            record_timing=False,
            coalesce_streams=True,
            on_cell_start=self._note_cell,
            config=Config(
                {"KernelManager": {"transport": "ipc"}}
            ),  # TCP ports of kernels started at once may clash
        )
        self.hung_after = hung_after
        self.cell = 0
        self.messages = 0
        self.is_hung = False

    def run(self) -> None:
        """Execute all cells.

        Raises
        ------
        CellFailed
            At the first cell that fails.
        """
        with tempfile.TemporaryDirectory() as folder:
            self.resources = {"metadata": {"path": folder}}
            self.config.KernelManager.connection_file = f"{folder}/kernel.json"
            try:
                asyncio.run(self._run())
            except CellExecutionError as error:
                raise CellFailed(self.cell, f"{error.ename}: {error.evalue}", self._traceback()) from error
            except (DeadKernelError, RuntimeError) as error:
                silent = f"no output and no computation for {self.hung_after:g} s: it hangs"
                raise CellFailed(self.cell, silent if self.is_hung else str(error)) from error
        self._refuse_stderr()

    def kill(self) -> None:
        """Kill the kernel and its children at once."""
        process = self._process()
        if process is not None:
            os.killpg(process.pid, signal.SIGKILL)

    async def _run(self) -> None:
        watchdog = asyncio.create_task(self._watch())
        try:
            await self.async_execute(env={**os.environ, **_ONE_THREAD})
        finally:
            watchdog.cancel()

    def _note_cell(self, cell_index: int, **_: Any) -> None:
        self.cell = cell_index

    def process_message(self, *arguments: Any, **options: Any) -> Any:
        """Count what the kernel sends."""
        self.messages += 1
        return super().process_message(*arguments, **options)

    def _traceback(self) -> str:
        lines = (
            line
            for output in self.nb.cells[self.cell].outputs
            if output.output_type == "error"
            for line in output.traceback
        )
        return _COLOUR.sub("", "\n".join(lines))

    def _refuse_stderr(self) -> None:
        for number, cell in enumerate(self.nb.cells):
            for output in cell.get("outputs", ()):
                if output.output_type == "stream" and output.name == "stderr":
                    raise CellFailed(number, "text on stderr", output.text)

    # ---- progress ----

    def _process(self) -> psutil.Process | None:
        pid = getattr(getattr(self.km, "provisioner", None), "pid", None)
        return psutil.Process(pid) if pid and psutil.pid_exists(pid) else None

    async def _watch(self) -> None:
        """Kill the kernel when it has made no progress at many checks in a row.

        Checks are counted, not hours of the clock, which go on while the build itself is stopped.
        """
        checks, messages, used = 0, 0, 0.0
        while checks < _CHECKS:
            await asyncio.sleep(self.hung_after / _CHECKS)
            process = self._process()
            if process is None:
                continue
            now, is_runnable = _load(process)
            if is_runnable or self.messages > messages or now - used > _IDLE * self.hung_after:
                checks, messages, used = 0, self.messages, now
            else:
                checks += 1
        self.is_hung = True
        self.kill()


def _load(process: psutil.Process) -> tuple[float, bool]:
    """Return the processor time of a process and its children [s], and whether one of them is runnable."""
    seconds, is_runnable = 0.0, False
    for member in (process, *process.children(recursive=True)):
        try:
            seconds += sum(member.cpu_times()[:4])
            is_runnable |= member.status() in (psutil.STATUS_RUNNING, psutil.STATUS_DISK_SLEEP)
        except psutil.NoSuchProcess:
            continue
    return seconds, is_runnable
