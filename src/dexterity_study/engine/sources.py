"""The source files that a module runs: itself and all that it imports, each named by what its code does.

A file's fingerprint leaves out comments and docstrings, so that prose changes nothing. The engine itself is
left out too: it computes nothing, and what it hands to an experiment are parameters of the task.
"""

from __future__ import annotations

import ast
import hashlib
import importlib.util
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from types import MappingProxyType

import grimp

import dexterity
import dexterity_study

_ENGINE = "dexterity_study.engine"
_PACKAGES = {module.__name__: Path(module.__file__ or "").parent for module in (dexterity, dexterity_study)}


@cache
def closure(module: str) -> Mapping[str, Path]:
    """Return the files of a module and of everything that it imports from the two packages, by module name.

    Raises
    ------
    ValueError
        If there is no such module.
    """
    graph = _graph()
    if module not in graph.modules:
        raise ValueError(f"there is no module {module!r} in {', '.join(_PACKAGES)}")
    names = {module, *graph.find_upstream_modules(module)}
    return MappingProxyType({name: _file(name) for name in sorted(names) if _is_counted(name)})


def imported_distributions(module: str) -> set[str]:
    """Return the top-level names outside of the two packages that a module's closure imports."""
    graph = _graph()
    names = {name for inside in closure(module) for name in graph.find_modules_directly_imported_by(inside)}
    return {name for name in names if name.partition(".")[0] not in _PACKAGES}


def fingerprint(file: Path) -> str:
    """Name what the code of a file does: comments, docstrings and layout do not count."""
    status = file.stat()
    return _fingerprint(file, status.st_mtime_ns, status.st_size)


@cache
def _fingerprint(file: Path, changed: int, size: int) -> str:  # noqa: ARG001 -- a changed file is read again
    tree = ast.parse(file.read_text(encoding="utf-8"))
    for node in ast.walk(tree):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
            # A text that stands alone does nothing, be it a docstring or the description of a constant.
            node.body = [child for child in node.body if not _is_text(child)] or [ast.Pass()]
    return hashlib.sha256(_written(tree).encode()).hexdigest()[:16]


def _written(tree: object) -> str:
    """Write a syntax tree the same way under every version of Python, as :func:`ast.dump` of 3.11 does."""
    if isinstance(tree, list):
        return f"[{', '.join(map(_written, tree))}]"
    if not isinstance(tree, ast.AST):
        return repr(tree)
    fields = [
        f"{name}={_written(value)}"
        for name, value in ast.iter_fields(tree)
        if not (value is None and getattr(type(tree), name, ...) is None)
        # Later versions have this field too.
        and not (name == "type_params" and value == [])
    ]
    return f"{type(tree).__name__}({', '.join(fields)})"


def _is_counted(module: str) -> bool:
    return module.partition(".")[0] in _PACKAGES and not f"{module}.".startswith(f"{_ENGINE}.")


def _is_text(node: ast.stmt) -> bool:
    return (
        isinstance(node, ast.Expr)
        and isinstance(node.value, ast.Constant)
        and isinstance(node.value.value, str)
    )


@cache
def _graph() -> grimp.ImportGraph:
    return grimp.build_graph(*_PACKAGES, include_external_packages=True, cache_dir=None)


def _file(module: str) -> Path:
    spec = importlib.util.find_spec(module)
    if spec is None or spec.origin is None:
        raise ValueError(f"module {module!r} has no file")
    return Path(spec.origin)
