"""Building the book: stale pages are executed side by side, then Sphinx writes them.

    python -m dexterity_study.page.build                    # the whole book
    python -m dexterity_study.page.build uvms/kinematics    # one page

Every executed page is kept as soon as it is finished, so a build that was stopped goes on from there.
Sphinx executes nothing: it finds the outputs of each page in a jupyter-cache that is filled from the
executed notebooks.
"""

import argparse
import json
import shutil
import signal
import sys
import time
import warnings
from collections.abc import Iterable, Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor, as_completed
from dataclasses import dataclass, field
from pathlib import Path
from statistics import fmean

import joblib
import nbformat
import psutil
from jupyter_book.sphinx import build_sphinx
from jupyter_cache import get_cache
from jupyter_cache.base import CacheBundleIn
from nbformat import NotebookNode

from dexterity import checks, store
from dexterity_study.engine.processes import InUse, alone_in
from dexterity_study.page.execution import CellFailed, Execution
from dexterity_study.page.notebooks import (
    Layout,
    Page,
    read_executed,
    read_pages,
    remove_strays,
    write_executed,
)

# sphinx_external_toc looks at every object in memory, torch's deprecated ones among them.
warnings.filterwarnings("ignore", message=r"`torch\..*` is deprecated", category=FutureWarning)

HUNG_AFTER = 600.0
"""Time without output and computation after which a kernel counts as hung [s]."""

_MEMORY = 1.5e9  # of one kernel at work [bytes]


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; the exit code is 0 if all is well."""
    options = _parser().parse_args(arguments)
    layout = Layout(options.book.resolve(), options.config.resolve(), options.output.resolve())
    names = layout.pages()
    unknown = [name for name in options.pages if name not in names]
    if unknown:
        say(f"no such page: {', '.join(unknown)}. The pages are: {', '.join(names)}")
        return 2
    try:
        with alone_in(layout.output):
            return _update(layout, names, options)
    except InUse as busy:
        say(f"The book was not built: {busy}.")
        return 3


def _update(layout: Layout, names: Sequence[str], options: argparse.Namespace) -> int:
    pages = read_pages(layout, names)
    chosen = [page for page in pages if page.name in (options.pages or names)]
    try:
        failed = Executions(layout, options.hung_after).update(chosen)
        if failed or options.execute_only:
            return failed
        if not options.pages:
            remove_strays(layout, pages)
        return write_html(layout, pages, options.pages)
    except KeyboardInterrupt:
        say("Stopped. The finished pages are kept; the same command goes on from here.")
        return 130


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m dexterity_study.page.build", description="Build the book."
    )
    parser.add_argument("pages", nargs="*", metavar="PAGE", help="such as uvms/kinematics; default: all")
    parser.add_argument("--book", type=Path, default=Path("book"), help="folder of the pages")
    parser.add_argument("--config", type=Path, default=Path("_config.yml"), help="settings of the book")
    parser.add_argument("--output", type=Path, default=Path("_build"), help="folder of what is built")
    parser.add_argument(
        "--execute-only", action="store_true", help="execute the pages and stop before Sphinx"
    )
    parser.add_argument(
        "--hung-after",
        type=float,
        default=HUNG_AFTER,
        metavar="SECONDS",
        help="time without output and computation after which a cell counts as hung (default: %(default)g)",
    )
    return parser


def say(line: str) -> None:
    """Print a line at once, also into a pipe."""
    sys.stdout.write(line + "\n")
    sys.stdout.flush()


# ---- execution ----


@dataclass
class Executions:
    """Pages that are executed side by side.

    Attributes
    ----------
    layout, hung_after
        Where the book is, and the patience with a silent kernel [s].
    running
        What is being executed now.
    """

    layout: Layout
    hung_after: float
    running: list[Execution] = field(default_factory=list)

    def update(self, pages: Iterable[Page]) -> int:
        """Execute the stale ones of some pages, keep them, and return the number of those that failed."""
        stale = []
        for page in pages:
            current = read_executed(self.layout, page)
            if current is None:
                stale.append(page)
            else:
                write_executed(self.layout, page, current)  # the prose may be new
        return self._execute(stale) if stale else 0

    def _execute(self, stale: Sequence[Page]) -> int:
        before = self._durations()
        # Longest first; what was never measured may be long.
        order = sorted(stale, key=lambda page: -before.get(page.name, float("inf")))
        workers = max(
            1, min(len(order), joblib.cpu_count(), int(psutil.virtual_memory().available / _MEMORY))
        )
        say(f"Executing {len(order)} of the book's pages, {workers} at a time")
        progress = Progress(before, [page.name for page in order], workers)
        failed = 0
        with ThreadPoolExecutor(workers) as pool:
            jobs = {pool.submit(self._run, page): page for page in order}
            try:
                for job in as_completed(jobs):
                    failed += self._finish(jobs[job], job, progress)
            except BaseException:
                pool.shutdown(wait=False, cancel_futures=True)
                while self.running:
                    for execution in list(self.running):
                        execution.kill()
                    time.sleep(0.1)
                raise
        if failed:
            say(f"The book was not built: {failed} of {len(order)} executed pages failed.")
        return failed

    def _run(self, page: Page) -> tuple[NotebookNode, float]:
        began = time.monotonic()
        execution = Execution(nbformat.from_dict(page.notebook), self.hung_after)
        self.running.append(execution)
        try:
            execution.run()
        finally:
            self.running.remove(execution)
        return execution.nb, time.monotonic() - began

    def _finish(self, page: Page, job: Future[tuple[NotebookNode, float]], progress: "Progress") -> bool:
        """Keep an executed page, or report its failure and return True."""
        try:
            notebook, seconds = job.result()
        except CellFailed as failure:
            say(progress.line(page.name, "FAILED", None))
            say(_report(self.layout, page, failure))
            return True
        write_executed(self.layout, page, notebook)
        durations = self._durations() | {page.name: round(seconds, 1)}
        store.write_atomically(self.layout.durations, json.dumps(durations, indent=1, sort_keys=True))
        say(progress.line(page.name, f"{seconds:.1f} s", seconds))
        return False

    def _durations(self) -> dict[str, float]:
        try:
            durations = json.loads(store.read_bytes(self.layout.durations))
            return {page: checks.real(seconds, "seconds", least=0) for page, seconds in durations.items()}
        except (FileNotFoundError, ValueError, TypeError, AttributeError, RecursionError):
            return {}  # they only foretell how long a build takes


@dataclass
class Progress:
    """How far the execution is, and an estimate of what remains.

    Attributes
    ----------
    before
        Durations in earlier builds [s].
    left
        Pages that are not finished.
    workers
        Number of pages executed at a time.
    """

    before: Mapping[str, float]
    left: list[str]
    workers: int
    now: dict[str, float] = field(default_factory=dict)
    began: float = field(default_factory=time.monotonic)

    def __post_init__(self) -> None:
        self.total = len(self.left)

    def line(self, page: str, outcome: str, seconds: float | None) -> str:
        """Note that a page is finished and describe the state."""
        self.left.remove(page)
        if seconds is not None:
            self.now[page] = seconds
        elapsed = time.monotonic() - self.began
        count = f"{self.total - len(self.left)} of {self.total}"
        return f"  {page:<28} {outcome:>9}   {count:>8}   {_clock(elapsed)} elapsed{self._remaining()}"

    def _remaining(self) -> str:
        known = {**self.before, **self.now}
        if not self.left or not known:
            return ""
        # Earlier durations count at the pace of this build.
        measured = [page for page in self.now if page in self.before]
        pace = 1.0
        if measured:
            pace = sum(self.now[page] for page in measured) / sum(self.before[page] for page in measured)
        expected = [pace * self.before.get(page, fmean(known.values())) for page in self.left]
        return f", about {_clock(max(sum(expected) / self.workers, *expected))} remaining"


def _clock(seconds: float) -> str:
    minutes, rest = divmod(round(seconds), 60)
    return f"{minutes}:{rest:02d} min"


def _report(layout: Layout, page: Page, failure: CellFailed) -> str:
    cell = page.notebook.cells[failure.cell]
    number = sum(other.cell_type == "code" for other in page.notebook.cells[: failure.cell + 1])
    place = f"{layout.book.name}/{page.name}.md, line {page.lines[failure.cell]}"
    parts = [f"{page.name}, code cell {number} ({place}): {failure.reason}", _quote(cell.source, "    | ")]
    if failure.details:
        parts.append(_quote(failure.details, "    "))
    return "\n".join(parts)


def _quote(text: str, margin: str) -> str:
    return "\n".join(margin + line for line in text.splitlines())


# ---- pages ----


def write_html(layout: Layout, pages: Sequence[Page], only: Sequence[str]) -> int:
    """Let Sphinx write all pages, or only those that are named; return 0 if it had nothing to complain about.

    Sphinx reads again the pages that have changed, and writes all, because titles and numbers of one page
    stand on others. It does not repeat the warnings of a page that it has read before, and need not have
    written that page; so after a build that failed or was stopped it reads everything.
    """
    doctrees, unfinished = layout.output / ".doctrees", layout.output / "unfinished"
    if unfinished.exists():
        shutil.rmtree(doctrees, ignore_errors=True)
    # Sphinx adds single pages to a search index that must be there.
    few = only if (layout.html / "searchindex.js").exists() else ()
    _fill_cache(layout, pages)
    unfinished.touch()
    began = time.monotonic()
    outcome = build_sphinx(
        str(layout.book),
        str(layout.html),
        noconfig=True,
        path_config=layout.config,
        confoverrides={"external_toc_path": str(layout.book / "_toc.yml"), "latex_individualpages": False},
        doctreedir=str(doctrees),
        filenames=[str(layout.source(name)) for name in few],
        force_all=not few,
        warningiserror=True,
        keep_going=True,
        quiet=True,
    )
    if outcome:
        say("The book was not built, because of the warnings above.")
        return 1
    unfinished.unlink()
    say(f"Pages written in {time.monotonic() - began:.0f} s")
    for name in only or ["index"]:
        say(f"file://{layout.html / name}.html")
    return 0


def _fill_cache(layout: Layout, pages: Iterable[Page]) -> None:
    """Put every page into the cache that Sphinx takes outputs from, without any if it was never executed."""
    folder = layout.output / ".jupyter_cache"
    shutil.rmtree(folder, ignore_errors=True)
    cache = get_cache(folder)
    for page in pages:
        bundle = CacheBundleIn(_for_sphinx(layout, page), page.name)
        cache.cache_notebook_bundle(bundle, check_validity=False, overwrite=True)


def _for_sphinx(layout: Layout, page: Page) -> NotebookNode:
    """Return the page as Sphinx reads it, with its outputs; the cache compares code cells and kernel."""
    executed = read_executed(layout, page)
    if executed is None:
        # Without a language Sphinx could not colour its cells.
        page.notebook.metadata["language_info"] = {"name": "python", "pygments_lexer": "ipython3"}
        return page.notebook
    executed.metadata = nbformat.from_dict({**executed.metadata, **page.notebook.metadata})
    return executed


if __name__ == "__main__":
    # Whoever ends the build ends the kernels that it has started.
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    sys.exit(main())
