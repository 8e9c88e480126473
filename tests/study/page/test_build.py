"""Throw-away books: what is executed when, what a failure says, and how a build goes on after a kill."""

import json
import signal
import sys
from pathlib import Path

import nbformat
import psutil
import pytest

from dexterity_study.page import build
from dexterity_study.page.execution import Execution
from warm_process import WarmProcess, wait_for

HEADER = "---\nfile_format: mystnb\nkernelspec:\n  name: python3\n---\n\n"

# Leaves a line in a file for every time that it is executed.
COUNTED = """# {name}

Some prose.

```{{code-cell}} python3
from pathlib import Path

with Path({log!r}).open("a") as log:
    log.write("{name}\\n")
print(6 * 7)
```
"""


class Book:
    """A book in a folder of its own."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.log = folder, folder / "executed.txt"
        (folder / "book").mkdir()
        (folder / "_config.yml").write_text("sphinx: {config: {myst_enable_extensions: []}}\n")
        (folder / "book" / "_toc.yml").write_text(
            "format: jb-book\nroot: index\nchapters: [{file: one}, {file: two}]\n"
        )
        (folder / "book" / "index.md").write_text("# A book without code\n")
        for name in ("one", "two"):
            self.write(name, COUNTED.format(name=name, log=str(self.log)))

    def write(self, name: str, text: str) -> None:
        self.source(name).write_text(HEADER + text)

    def edit(self, name: str, old: str, new: str) -> None:
        text = self.source(name).read_text()
        assert old in text
        self.source(name).write_text(text.replace(old, new))

    def source(self, name: str) -> Path:
        return self.folder / "book" / f"{name}.md"

    @property
    def arguments(self) -> list[str]:
        places = {"--book": "book", "--config": "_config.yml", "--output": "_build"}
        return ["--execute-only", *(f"{option}={self.folder / name}" for option, name in places.items())]

    def execute(self, *more: str) -> int:
        return build.main([*self.arguments, *more])

    def executed(self) -> list[str]:
        """Return the pages that were executed, in the order of their names, and forget them."""
        names = self.log.read_text().split() if self.log.exists() else []
        self.log.unlink(missing_ok=True)
        return sorted(names)

    def notebooks(self) -> dict[str, bytes]:
        folder = self.folder / "_build" / "executed"
        return {file.stem: file.read_bytes() for file in folder.rglob("*.ipynb")}


@pytest.fixture
def book(tmp_path: Path) -> Book:
    return Book(tmp_path)


def test_only_an_edited_cell_is_executed_again(book: Book, capsys: pytest.CaptureFixture[str]) -> None:
    """jupyter-book#1633, MyST-NB#621, lecture-python-advanced.myst#346: outputs of a changed source."""
    assert book.execute() == 0
    assert book.executed() == ["one", "two"]
    assert "2 of 2" in capsys.readouterr().out
    first = book.notebooks()

    assert book.execute() == 0
    assert book.executed() == []
    assert book.notebooks() == first

    book.edit("one", "Some prose.", "Better prose.")
    assert book.execute() == 0
    assert book.executed() == []
    assert b"Better prose." in book.notebooks()["one"]
    assert b"42" in book.notebooks()["one"]
    assert book.notebooks()["two"] == first["two"]

    book.edit("two", "6 * 7", "6 * 8")
    assert book.execute() == 0
    assert book.executed() == ["two"]
    assert b"48" in book.notebooks()["two"]


def test_executed_notebook_is_valid_and_runs_again(book: Book) -> None:
    assert book.execute("one") == 0
    assert set(book.notebooks()) == {"one"}
    notebook = nbformat.reads(book.notebooks()["one"].decode(), as_version=4)
    nbformat.validate(notebook)
    book.executed()
    again = Execution(nbformat.from_dict(notebook), hung_after=60)
    again.run()
    assert book.executed() == ["one"]
    assert again.nb.cells == notebook.cells


@pytest.mark.parametrize(
    ("cell", "reason", "details"),
    [
        ("1 / 0", "ZeroDivisionError: division by zero", "ZeroDivisionError"),
        ("import sys\nprint('odd', file=sys.stderr)", "text on stderr", "odd"),
        ("import os\nos._exit(1)", "Kernel died", ""),
    ],
    ids=["raises", "warns", "dies"],
)
def test_failing_cell_is_reported(
    book: Book, capsys: pytest.CaptureFixture[str], cell: str, reason: str, details: str
) -> None:
    book.write("one", f"# One\n\n```{{code-cell}}\nx = 1\n```\n\nProse.\n\n```{{code-cell}}\n{cell}\n```\n")
    assert book.execute() != 0
    output = capsys.readouterr().out
    assert f"one, code cell 2 (book/one.md, line 16): {reason}" in output
    assert f"| {cell.splitlines()[-1]}" in output
    assert details in output.partition(reason)[2]
    assert "\x1b[" not in output
    assert "1 of 2 executed pages failed" in output
    assert set(book.notebooks()) == {"two"}


def test_silent_cell_counts_as_hung(book: Book, capsys: pytest.CaptureFixture[str]) -> None:
    """No clock decides about a cell that works: jupyter-book#613, #945, d2l-book#16, agu24workshop#27."""
    book.write("one", "# One\n\n```{code-cell}\nimport time\ntime.sleep(600)\n```\n")
    # Computing all the time and telling something from time to time are both progress.
    busy = "import time\nend = time.monotonic() + 4\nwhile time.monotonic() < end: pass"
    chatty = "for _ in range(4):\n    time.sleep(1)\n    print(_, flush=True)"
    book.write("two", f"# Two\n\n```{{code-cell}}\n{busy}\n{chatty}\n```\n")
    assert book.execute("--hung-after=3") != 0
    output = capsys.readouterr().out
    assert "one, code cell 1 (book/one.md, line 10): no output and no computation for 3 s" in output
    assert set(book.notebooks()) == {"two"}


def test_unknown_page_is_refused(book: Book, capsys: pytest.CaptureFixture[str]) -> None:
    assert book.execute("three") != 0
    assert "no such page: three. The pages are: index, one, two" in capsys.readouterr().out


@pytest.mark.parametrize("stop", [signal.SIGINT, signal.SIGTERM, signal.SIGKILL])
def test_stopped_build_goes_on_where_it_was(book: Book, tmp_path: Path, stop: signal.Signals) -> None:
    gate = tmp_path / "gate"
    waiting = f"import time\nwhile not Path({str(gate)!r}).exists(): time.sleep(0.1)\nprint(6 * 7)"
    book.edit("two", "print(6 * 7)", waiting)
    process = WarmProcess("dexterity_study.page.build", *book.arguments)
    wait_for(lambda: set(book.notebooks()) == {"one"} and "two" in book.log.read_text())
    kernels = psutil.Process(process.pid).children(recursive=True)
    assert kernels
    assert build.main(book.arguments) == 3  # while another one builds
    process.kill(stop)
    assert process.end(timeout=60)[0] != 0
    wait_for(lambda: not any(kernel.is_running() for kernel in kernels))
    assert set(book.notebooks()) == {"one"}
    book.executed()

    gate.touch()
    assert book.execute() == 0
    assert book.executed() == ["two"]
    after = book.notebooks()
    for file in (tmp_path / "_build" / "executed").iterdir():
        file.unlink()
    assert book.execute() == 0
    assert book.notebooks() == after


def test_the_kernel_is_the_environments_own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """jupyter-book#1126, #1291, #2140: a kernel of the user's, whose interpreter is gone, was started."""
    folder = tmp_path / "kernels" / "python3"
    folder.mkdir(parents=True)
    command = ["/gone/bin/python", "-m", "ipykernel_launcher", "-f", "{connection_file}"]
    foreign = {"argv": command, "display_name": "Python 3", "language": "python"}
    (folder / "kernel.json").write_text(json.dumps(foreign), encoding="utf-8")
    monkeypatch.setenv("JUPYTER_DATA_DIR", str(tmp_path))
    manager = Execution(nbformat.v4.new_notebook(), hung_after=60).create_kernel_manager()
    assert manager.format_kernel_cmd()[0] == sys.executable
