"""What the outputs of a page depend on: its code cells, the sources that they import, data, locks, Python."""

import ast
import hashlib
import json
import sys
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

from nbformat import NotebookNode

import dexterity
import dexterity_study
from dexterity import store
from dexterity_study.engine import sources

_PACKAGES = {module.__name__: Path(module.__path__[0]) for module in (dexterity, dexterity_study)}
_ROOT = _PACKAGES["dexterity"].parents[1]


def page_key(name: str, notebook: NotebookNode) -> str:
    """Digest everything that can change the outputs of a page."""
    code = "\n".join(cell.source for cell in notebook.cells if cell.cell_type == "code")
    parts = {
        "cells": [[cell.source, cell.metadata] for cell in notebook.cells if cell.cell_type == "code"],
        "files": dependencies(name, code),
        "python": sys.version_info[:2],
    }
    return hashlib.sha256(json.dumps(parts, sort_keys=True).encode()).hexdigest()


def dependencies(name: str, code: str) -> dict[str, str]:
    """Digest the files that a page depends on.

    A page with results of its own depends on these, on the modules that it imports, on the chapters that it names, and on
    the results of those that these modules name, as a verdict that rests on another chapter does; the start page and the
    scorecard depend on all that there is.
    """
    chapters = {name.replace("/", "."), *_texts(code)} & set(_chapters())
    if name.replace("/", ".") not in chapters:
        return {**_modules(tuple(_PACKAGES)), **_data("results/"), **_recorded_runs()}
    own = {module for chapter in chapters for module in _inside(f"dexterity_study.{chapter}")}
    modules = tuple(sorted(imported_modules(code) | own))
    read = chapters | _chapters_named_in(modules)
    results = (f"results/{chapter.replace('.', '/')}/" for chapter in read)
    return {
        **_modules(modules),
        **_data(*results),
        **{run: state for run, state in _recorded_runs().items() if run.rpartition(".")[0] in read},
    }


@cache
def _chapters_named_in(modules: tuple[str, ...]) -> set[str]:
    """Return the chapters that modules, or what they import from the study, name in their code."""
    imported = {module for name in modules for module in sources.closure(name)}
    texts = (_texts(_file(one).read_text("utf-8")) for one in imported if one.startswith("dexterity_study."))
    return set().union(*texts) & set(_chapters())


@cache
def _recorded_runs() -> dict[str, str]:
    """Digest what the lock of the evidence records of each experiment, such as `uvms.tasks.rankings`."""
    file = _ROOT / "pytask.lock"
    runs = store.read_toml(file)["task"] if file.is_file() else []
    recorded: dict[str, list[Any]] = {}
    for run in runs:
        recorded.setdefault(run["id"].partition("[")[0], []).append(run)
    return {
        name: hashlib.sha256(json.dumps(entries).encode()).hexdigest() for name, entries in recorded.items()
    }


@cache
def _chapters() -> tuple[str, ...]:
    """Name the chapters with stored results, such as `"uvms.tasks"`."""
    folders = store.data_path("results").glob("*/*/")
    return tuple(".".join(folder.parts[-2:]) for folder in folders if folder.is_dir())


def _texts(code: str) -> set[str]:
    try:
        tree = ast.parse(code)
    except SyntaxError:
        return set()
    return {
        node.value
        for node in ast.walk(tree)
        if isinstance(node, ast.Constant) and isinstance(node.value, str)
    }


def imported_modules(code: str) -> set[str]:
    """Return the modules of the library and the study that the cells of a page import.

    Cells that are not plain Python may import anything, so they count as importing both packages.
    """
    try:
        tree = ast.parse(code)
    except SyntaxError:
        return set(_PACKAGES)
    names = (
        name
        for node in ast.walk(tree)
        if isinstance(node, ast.Import | ast.ImportFrom)
        for name in _imported_names(node)
    )
    return {_module(name) for name in names if name.partition(".")[0] in _PACKAGES}


def _imported_names(node: ast.Import | ast.ImportFrom) -> list[str]:
    names = [alias.name for alias in node.names]
    return names if isinstance(node, ast.Import) else [f"{node.module}.{name}" for name in names]


def _module(name: str) -> str:
    """Return a dotted name if it is a module, else the module that it is an attribute of."""
    package, *parts = name.split(".")
    path = _PACKAGES[package].joinpath(*parts)
    is_module = path.is_dir() or path.with_suffix(".py").is_file()
    return name if is_module or not parts else _module(name.rpartition(".")[0])


def _inside(package: str) -> Iterator[str]:
    """Name the modules of a package; none if there is no such package."""
    root, *parts = package.split(".")
    for file in sorted(_PACKAGES[root].joinpath(*parts).rglob("*.py")):
        yield ".".join((root, *file.relative_to(_PACKAGES[root]).with_suffix("").parts)).removesuffix(
            ".__init__"
        )


@cache
def _modules(names: tuple[str, ...]) -> dict[str, str]:
    """Digest modules with all that they import, the engine that reads results, and what lies beside modules.

    A package as such hands on its modules when they are first used, so it stands for all of them.
    """
    wanted = {inner for name in names for inner in (_inside(name) if name in _PACKAGES else [name])}
    imported = {module for name in wanted for module in sources.closure(name)}
    engine = set(_inside("dexterity_study.engine"))
    code = {module: sources.fingerprint(_file(module)) for module in imported | engine}
    return {**code, **_files_beside_modules()}


def _file(module: str) -> Path:
    root, *parts = module.split(".")
    path = _PACKAGES[root].joinpath(*parts)
    return path / "__init__.py" if path.is_dir() else path.with_suffix(".py")


@cache
def _files_beside_modules() -> dict[str, str]:
    return {
        f"{name}/{file.relative_to(folder).as_posix()}": _digest(file)
        for name, folder in _PACKAGES.items()
        for file in folder.rglob("*")
        if file.is_file() and file.suffix not in (".py", ".pyc")
    }


def _data(*results: str) -> dict[str, str]:
    """Digest the data and the lock of the environment; of stored results only some."""
    return {
        file: digest
        for file, digest in _data_files().items()
        if not file.startswith("results/") or file.startswith(results)
    }


@cache
def _data_files() -> dict[str, str]:
    folder, lock = store.data_path(), _ROOT / "environment.lock"
    files = {
        file.relative_to(folder).as_posix(): file for file in sorted(folder.rglob("*")) if file.is_file()
    }
    if lock.is_file():
        files[lock.name] = lock
    return {name: _digest(file) for name, file in files.items()}


def _digest(file: Path) -> str:
    return hashlib.sha256(file.read_bytes()).hexdigest()
