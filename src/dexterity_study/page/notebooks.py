"""Pages as notebooks: what decides that a page has to be executed again, and where its outputs are kept.

An executed notebook carries the key of what it was made from: its code cells, the sources that they import, the
data and the lock. Prose is no part of the key; an edit of prose renews the text around the stored outputs.
"""

import ast
import hashlib
import json
import sys
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import nbformat
import yaml
from myst_nb.core.read import is_myst_markdown_notebook, read_myst_markdown_notebook
from myst_parser.config.main import MdParserConfig
from nbformat import NotebookNode
from sphinx_external_toc.parsing import parse_toc_yaml

import dexterity
import dexterity_study
from dexterity import store

PACKAGES = {"dexterity": dexterity, "dexterity_study": dexterity_study}


@dataclass(frozen=True)
class Layout:
    """Folders and files of a build.

    Attributes
    ----------
    book, config
        Folder of the pages with its `_toc.yml`, and the settings of the book.
    output
        Folder of everything that is built.
    """

    book: Path
    config: Path
    output: Path

    @property
    def html(self) -> Path:
        return self.output / "html"

    @property
    def notebooks(self) -> Path:
        return self.output / "notebooks"

    @property
    def durations(self) -> Path:
        return self.output / "durations.json"

    def source(self, page: str) -> Path:
        return self.book / f"{page}.md"

    def executed(self, page: str) -> Path:
        return self.notebooks / f"{page}.ipynb"

    def pages(self) -> list[str]:
        """Return the pages of the table of contents, in its order."""
        return list(parse_toc_yaml(self.book / "_toc.yml"))


@dataclass(frozen=True)
class Page:
    """A page with code cells.

    Attributes
    ----------
    name
        Path below the book's folder, without suffix.
    notebook
        Prose and code cells, without outputs.
    lines
        Line of the source at which each cell begins.
    key
        Digest of everything that can change the outputs.
    """

    name: str
    notebook: NotebookNode
    lines: tuple[int, ...]
    key: str


def read_pages(layout: Layout, names: Iterable[str]) -> list[Page]:
    """Read those of the named pages that have code cells."""
    settings = yaml.safe_load(layout.config.read_text("utf-8"))
    extensions = settings["sphinx"]["config"]["myst_enable_extensions"]
    syntax = MdParserConfig(enable_extensions=set(extensions))
    return list(_read_pages(layout, names, syntax))


def _read_pages(layout: Layout, names: Iterable[str], syntax: MdParserConfig) -> Iterator[Page]:
    for name in names:
        text = layout.source(name).read_text("utf-8")
        if not is_myst_markdown_notebook(text):
            continue
        notebook = read_myst_markdown_notebook(
            text, config=syntax, add_source_map=True, path=layout.source(name)
        )
        lines = tuple(line + 1 for line in notebook.metadata.pop("source_map"))
        for number, cell in enumerate(notebook.cells):
            cell.id = f"cell-{number}"  # nbformat draws it otherwise
        yield Page(name, notebook, lines, _key(name, notebook))


# ---- what outputs depend on ----


def _key(name: str, notebook: NotebookNode) -> str:
    # A chapter depends on what it imports and on its own results; any other page may list what there is in the study.
    is_chapter = any(file.startswith(_results(name)) for file in _data_files())
    modules = imported_modules(notebook) if is_chapter else set(PACKAGES)
    parts = {
        "cells": [[cell.source, cell.metadata] for cell in notebook.cells if cell.cell_type == "code"],
        "sources": {file: digest for module in modules for file, digest in fingerprint(module).items()},
        "data": {
            file: digest
            for file, digest in _data_files().items()
            if not is_chapter or not file.startswith("results/") or file.startswith(_results(name))
        },
        "python": sys.version_info[:2],
    }
    return hashlib.sha256(json.dumps(parts, sort_keys=True).encode()).hexdigest()


def _results(name: str) -> str:
    return f"results/{name}/"


def imported_modules(notebook: NotebookNode) -> set[str]:
    """Return the modules of the library and the study that the cells of a notebook import.

    Cells that are not plain Python may import anything, so they count as importing both packages.
    """
    code = "\n".join(cell.source for cell in notebook.cells if cell.cell_type == "code")
    try:
        tree = ast.parse(code)
    except SyntaxError:
        return set(PACKAGES)
    return {
        _module(name)
        for node in ast.walk(tree)
        if isinstance(node, ast.Import | ast.ImportFrom)
        for name in _imported_names(node)
        if name.partition(".")[0] in PACKAGES
    }


def _imported_names(node: ast.Import | ast.ImportFrom) -> list[str]:
    names = [alias.name for alias in node.names]
    return names if isinstance(node, ast.Import) else [f"{node.module}.{name}" for name in names]


def _module(name: str) -> str:
    """Return a dotted name if it is a module, else the module that it is an attribute of."""
    package, *parts = name.split(".")
    path = Path(PACKAGES[package].__path__[0], *parts)
    is_module = path.is_dir() or path.with_suffix(".py").is_file()
    return name if is_module or not parts else _module(name.rpartition(".")[0])


@cache
def fingerprint(module: str) -> dict[str, str]:
    """Digest the sources of a module and of all that it imports, without comments and docstrings.

    Every module counts as imported.
    """
    return {
        f"{package}/{file.relative_to(folder).as_posix()}": hashlib.sha256(_code(file)).hexdigest()
        for package, root in PACKAGES.items()
        for folder in map(Path, root.__path__)
        for file in sorted(folder.rglob("*"))
        if file.is_file() and "__pycache__" not in file.parts
    }


def _code(file: Path) -> bytes:
    if file.suffix != ".py":
        return file.read_bytes()
    tree = ast.parse(file.read_bytes())
    for node in ast.walk(tree):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef) and (
            ast.get_docstring(node, clean=False) is not None
        ):
            node.body = node.body[1:]
    return ast.dump(tree).encode()


@cache
def _data_files() -> dict[str, str]:
    """Digest the data and the lock."""
    folder = store.data_path()
    files = {file.relative_to(folder).as_posix(): file for file in folder.rglob("*") if file.is_file()}
    root = store.repository()
    if root is not None:
        files["environment.lock"] = root / "environment.lock"
    return {name: hashlib.sha256(file.read_bytes()).hexdigest() for name, file in sorted(files.items())}


# ---- executed notebooks ----


def read_executed(layout: Layout, page: Page) -> NotebookNode | None:
    """Return the stored outputs with the page's present prose, or None if they are of another key."""
    try:
        stored = nbformat.read(layout.executed(page.name), as_version=4)
    except (FileNotFoundError, nbformat.reader.NotJSONError):
        return None
    if stored.metadata.get("dexterity", {}).get("key") != page.key:
        return None
    outputs = iter([cell for cell in stored.cells if cell.cell_type == "code"])
    notebook = nbformat.from_dict(page.notebook)
    for cell in notebook.cells:
        if cell.cell_type == "code":
            executed = next(outputs)
            cell.outputs, cell.execution_count = executed.outputs, executed.execution_count
    notebook.metadata.update(stored.metadata)
    return notebook


def write_executed(layout: Layout, page: Page, notebook: NotebookNode) -> None:
    """Write an executed notebook with its key, if that changes the file."""
    notebook.metadata = nbformat.from_dict(_metadata(page, notebook.metadata))
    text = nbformat.writes(notebook) + "\n"
    path = layout.executed(page.name)
    if not path.is_file() or path.read_text("utf-8") != text:
        path.parent.mkdir(parents=True, exist_ok=True)
        store.write_atomically(path, text)


def _metadata(page: Page, executed: dict[str, Any]) -> dict[str, Any]:
    kept = {name: executed[name] for name in ("language_info", "widgets") if name in executed}
    kernel = {"name": "python3", "display_name": "Python 3", "language": "python"}
    return {"kernelspec": kernel, **kept, "dexterity": {"page": page.name, "key": page.key}}


def remove_strays(layout: Layout, pages: Iterable[Page]) -> None:
    """Remove the executed notebooks of pages that are no longer in the book."""
    wanted = {layout.executed(page.name) for page in pages}
    for file in layout.notebooks.rglob("*.ipynb"):
        if file not in wanted:
            file.unlink()
