"""Small copies of the repository in which `make book` is tried, with the environment of the tests."""

import os
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

from built_book import REPOSITORY

# Options of an outer make would hold for the inner one too.
_OF_AN_OUTER_MAKE = ("MAKEFLAGS", "MAKELEVEL", "MFLAGS", "MAKEOVERRIDES")

_HEADER = """---
file_format: mystnb
kernelspec:
  name: python3
---

"""


@dataclass(frozen=True)
class Build:
    """How a build ended."""

    exit_code: int
    output: str
    page: str


def make_copy(folder: Path, chapter: str) -> Path:
    """Set up a book of one chapter, built by this repository's rules and settings.

    The packages that it uses are the installed ones, unless the copy gets a `src` of its own.
    """
    folder.mkdir(parents=True)
    for name in ("Makefile", "_config.yml", "environment.lock", "pyproject.toml"):
        shutil.copy2(REPOSITORY / name, folder)
    book = folder / "book"
    shutil.copytree(REPOSITORY / "book" / "assets", book / "assets")
    shutil.copy2(REPOSITORY / "book" / "references.bib", book)
    (book / "_toc.yml").write_text("format: jb-book\nroot: index\n", encoding="utf-8")
    (book / "index.md").write_text(_HEADER + chapter, encoding="utf-8")
    return folder


def add_source(folder: Path) -> None:
    """Give a copy the packages and their data, to be edited."""
    unwanted = shutil.ignore_patterns("__pycache__")
    for name in ("src", "data"):
        shutil.copytree(REPOSITORY / name, folder / name, ignore=unwanted)


def make_book(folder: Path) -> Build:
    """Run `make book` in a copy; the environment stands as it is, so that nothing is installed."""
    kept = {name: value for name, value in os.environ.items() if name not in _OF_AN_OUTER_MAKE}
    environment = {**kept, "PYTHONPATH": str(folder / "src"), "DEXTERITY_SCALE": "smoke"}
    stamps = (f"--old-file={sys.prefix}/{name}" for name in (".book", ".all"))
    command = ["make", "book", f"VENV={sys.prefix}", *stamps]
    done = subprocess.run(
        command, cwd=folder, env=environment, capture_output=True, text=True, timeout=300, check=False
    )
    page = folder / "_build" / "html" / "index.html"
    shown = page.read_text(encoding="utf-8") if page.is_file() else ""
    return Build(done.returncode, done.stdout + done.stderr, shown)
