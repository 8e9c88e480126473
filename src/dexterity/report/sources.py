"""What a result was made from: the code that a study uses, the data, and the pins of what the code imports.

Imports are followed through the files on disk; nothing is imported. A module counts with its syntax tree,
docstrings removed, so that a result outlives an edit of prose and no other.
"""

import ast
import re
import sys
from collections.abc import Iterable, Iterator
from importlib.util import resolve_name
from pathlib import Path

from dexterity import store
from dexterity.report.pins import counted_pins

__all__ = ["last_change", "lock_hash", "source_key", "tree_key"]

_PACKAGE = "dexterity"
_REPORT = "dexterity.report"
# Results are what the key is for, and papers are what results are compared with, after the fact.
_DATA_LEFT_OUT = ("papers", "results")


def source_key(module_name: str) -> str:
    """Name everything in this package that a module's results depend on.

    That is the module itself and every module of the package that it imports, directly or through others,
    at its top or inside a function, except `dexterity.report`; the data files, except papers and results;
    and, in a source tree, the pins of `environment.lock` on which these modules' other imports depend, see
    `dexterity.report.pins.counted_pins`. The `__init__` of a package on the way to a module counts,
    but not what it imports and lists, unless a name is taken from it.

    Parameters
    ----------
    module_name
        Full name, such as `"dexterity.studies.uvms.kinematics"`.

    Returns
    -------
    Sixteen hexadecimal digits.

    Raises
    ------
    ModuleNotFoundError
        If the module, or one of the package on the way, has no file.

    Notes
    -----
    A module imported by a computed name is not seen. Syntax trees, and so the keys, differ between minor
    versions of Python.
    """
    trees = _syntax_trees(module_name)
    code = {name: _code_of(tree) for name, tree in trees.items()}
    return store.content_key(code, _contents(_data_files()), _pins(trees.values()))


def last_change(module_name: str) -> float:
    """Return when the newest of the files that `source_key` looks at was changed, [s] since the epoch.

    The lock is one of them, whichever of its pins count.
    """
    modules = map(_file_of, _syntax_trees(module_name))
    lock = filter(None, [_lock_file()])
    return max(file.stat().st_mtime for file in (*modules, *_data_files().values(), *lock))


def lock_hash() -> str | None:
    """Return a key of the environment's lock; None where there is no lock, as in an installed wheel."""
    lock = _lock_file()
    return store.content_key(lock.read_bytes()) if lock else None


def tree_key() -> str:
    """Name every byte of the package, of the data and of the lock, docstrings and papers included."""
    folders = (store.PACKAGE, store.data_path())
    return store.content_key([_contents(_files_below(folder)) for folder in folders], lock_hash())


def _lock_file() -> Path | None:
    root = store.repository()
    return lock if root and (lock := root / "environment.lock").is_file() else None


def _pins(trees: Iterable[ast.Module]) -> dict[str, str] | None:
    lock = _lock_file()
    return counted_pins(lock.read_text("utf-8"), set().union(*map(_foreign, trees))) if lock else None


def _foreign(tree: ast.Module) -> set[str]:
    """Top-level names, neither this package's nor Python's, that a module imports anywhere."""
    names = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
            names.add(node.module)
    return {name.partition(".")[0] for name in names} - {_PACKAGE} - sys.stdlib_module_names


def _syntax_trees(module_name: str) -> dict[str, ast.Module]:
    """Return the syntax trees of all modules that count, by their names."""
    trees: dict[str, ast.Module] = {}
    waiting = [module_name]
    while waiting:
        name = waiting.pop()
        if name not in trees and not _is_within(name, _REPORT):
            trees[name] = _parse(name)
            waiting.extend(_imports(name, trees[name]))
    on_the_way = {package for name in trees for package in _packages_above(name)}
    return trees | {name: _without_listing(_parse(name)) for name in on_the_way - trees.keys()}


def _without_listing(package: ast.Module) -> ast.Module:
    """Leave out what a package imports and `__all__`, which do nothing for a module inside of it."""
    package.body = [node for node in package.body if not _lists(node)]
    return package


def _lists(node: ast.stmt) -> bool:
    if isinstance(node, ast.Assign):
        return any(isinstance(target, ast.Name) and target.id == "__all__" for target in node.targets)
    return isinstance(node, ast.Import | ast.ImportFrom)


def _imports(module_name: str, tree: ast.Module) -> Iterator[str]:
    """Yield the modules of this package that an `import` anywhere in a module gives it access to."""
    is_package = _file_of(module_name).name == "__init__.py"
    package = module_name if is_package else module_name.rpartition(".")[0]
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            for alias in node.names:
                # Without `as` the name that is bound is the outermost package's.
                names = [alias.name, *(() if alias.asname else _packages_above(alias.name))]
                yield from (name for name in names if _is_within(name, _PACKAGE))
        elif isinstance(node, ast.ImportFrom):
            source = resolve_name("." * node.level + (node.module or ""), package)
            if _is_within(source, _PACKAGE):
                members = [f"{source}.{alias.name}" for alias in node.names]
                yield from (member if _find_file(member) else source for member in members)


def _is_within(name: str, package: str) -> bool:
    return name == package or name.startswith(f"{package}.")


def _packages_above(name: str) -> list[str]:
    parts = name.split(".")
    return [".".join(parts[:count]) for count in range(1, len(parts))]


def _parse(module_name: str) -> ast.Module:
    return ast.parse(_file_of(module_name).read_bytes(), filename=module_name)


def _file_of(module_name: str) -> Path:
    file = _find_file(module_name)
    if file is None:
        raise ModuleNotFoundError(f"module {module_name!r} has no file in the package", name=module_name)
    return file


def _find_file(module_name: str) -> Path | None:
    place = store.PACKAGE.joinpath(*module_name.split(".")[1:])
    candidates = (place / "__init__.py", place.with_name(f"{place.name}.py"))
    return next((candidate for candidate in candidates if candidate.is_file()), None)


def _code_of(tree: ast.Module) -> str:
    return ast.dump(_WithoutDocstrings().visit(tree))


class _WithoutDocstrings(ast.NodeTransformer):
    """Drops every statement that is only a text; none of them does anything."""

    def visit_Expr(self, node: ast.Expr) -> ast.Expr | None:
        is_text = isinstance(node.value, ast.Constant) and isinstance(node.value.value, str)
        return None if is_text else node


def _data_files() -> dict[str, Path]:
    files = _files_below(store.data_path())
    return {name: file for name, file in files.items() if name.split("/")[0] not in _DATA_LEFT_OUT}


def _files_below(folder: Path) -> dict[str, Path]:
    """Return the files of a folder by their portable names, without hidden and compiled ones."""
    names = {path.relative_to(folder).as_posix(): path for path in folder.rglob("*") if path.is_file()}
    return {name: path for name, path in names.items() if not re.search(r"(^|/)(\.|__pycache__/)", name)}


def _contents(files: dict[str, Path]) -> dict[str, bytes]:
    return {name: file.read_bytes() for name, file in files.items()}
