"""What make starts ends with make, builds do not meet, and an environment of another tree serves this one."""

import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import psutil
import pytest

from dexterity import store

ROOT = store.repository()
STUB = """
import os, sys, time
from pathlib import Path
print("of", Path(__file__).parents[3].name, flush=True)
Path("pid").write_text(str(os.getpid()))
time.sleep(0 if len(sys.argv) > 1 else 600)
"""
"""In place of the build of the book; a page by name takes no time."""

pytestmark = pytest.mark.skipif(
    ROOT is None or shutil.which("make") is None or shutil.which("setpriv") is None,
    reason="needs the source tree, make and setpriv",
)


@pytest.fixture
def tree(tmp_path: Path) -> Path:
    """A tree with this Makefile and a package of the book's name."""
    assert ROOT
    shutil.copy2(ROOT / "Makefile", tmp_path)
    for name in ("environment.lock", "pyproject.toml"):
        (tmp_path / name).touch()
    (tmp_path / "tests").mkdir()
    package = tmp_path / "src" / "dexterity_study" / "page"
    package.mkdir(parents=True)
    (package.parent / "__init__.py").touch()
    (package / "__init__.py").touch()
    (package / "build.py").write_text(STUB)
    return tmp_path


def make(tree: Path, *arguments: str) -> "subprocess.Popen[str]":
    stamps = [f"--old-file={sys.prefix}/{name}" for name in (".book", ".all")]
    kept = {name: value for name, value in os.environ.items() if not name.startswith(("MAKE", "MFLAGS"))}
    command = ["make", *arguments, f"VENV={sys.prefix}", *stamps]
    return subprocess.Popen(
        command, cwd=tree, env=kept, stdout=subprocess.PIPE, text=True, start_new_session=True
    )


@pytest.fixture
def building(tree: Path) -> Iterator[tuple["subprocess.Popen[str]", psutil.Process]]:
    started = make(tree, "book")
    end = time.monotonic() + 60
    while not (tree / "pid").exists() or not (tree / "pid").read_text():
        assert time.monotonic() < end
        time.sleep(0.05)
    yield started, psutil.Process(int((tree / "pid").read_text()))
    started.kill()
    started.communicate()


@pytest.mark.parametrize("stop", [signal.SIGKILL, signal.SIGTERM])
def test_what_make_has_started_ends_with_make(building, stop):
    started, build = building
    assert build.is_running()
    os.kill(started.pid, stop)
    started.wait(timeout=30)
    psutil.wait_procs([build], timeout=10)
    assert not build.is_running()


def test_an_environment_that_was_made_for_another_tree_serves_this_one(tree):
    # The environment of the tests is another tree's, and has that tree's packages installed.
    shown, _ = make(tree, "chapter", "CH=index").communicate(timeout=60)
    assert shown.splitlines()[-1] == f"of {tree.name}"


def test_what_is_being_built_is_not_removed(tree):
    (tree / "_build").mkdir()
    hold = (
        "import fcntl, os, time; fcntl.flock(os.open('_build', 0), 2); print(1, flush=True); time.sleep(600)"
    )
    holder = subprocess.Popen([sys.executable, "-c", hold], cwd=tree, stdout=subprocess.PIPE, text=True)
    assert holder.stdout
    holder.stdout.readline()
    refused = make(tree, "clean")
    shown, _ = refused.communicate(timeout=60)
    assert refused.returncode != 0
    assert "Another process works in _build" in shown
    holder.kill()
    holder.communicate()
    allowed = make(tree, "clean")
    allowed.communicate(timeout=60)
    assert allowed.returncode == 0
    assert not (tree / "_build").exists()
