"""C sources compiled on demand with the system's compiler, loaded, and kept for the next time."""

from __future__ import annotations

import ctypes
import os
import shutil
import subprocess
import tempfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from torch import Tensor

from dexterity import store
from dexterity.codegen.c_file import NOT_FINITE

__all__ = [
    "CompilationFailed",
    "RowFunction",
    "cache_folder",
    "cached_source",
    "compiled_library",
    "plain_memory",
]

FLAGS = ("-std=c99", "-O3", "-ffp-contract=fast", "-fno-math-errno", "-fno-trapping-math", "-fPIC", "-shared")
"""Flags that gcc and clang know. None changes what a NaN or an infinity is."""

TUNING = ("-march=native", "-mprefer-vector-width=512")
"""Flags for the processor that this runs on, left out where the compiler refuses them."""


class CompilationFailed(RuntimeError):  # noqa: N818  # as it reads in an except clause
    """There is no compiler, or it refused its work."""


def cache_folder() -> Path:
    """Folder of generated and compiled code: ``$DEXTERITY_CACHE``, or ``dexterity`` in the user's cache."""
    if named := os.environ.get("DEXTERITY_CACHE"):
        return Path(named)
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "dexterity"


def cached_source(key: str, make: Callable[[], str]) -> str:
    """Return a generated source by its content key, made only if it is not there yet.

    Raises
    ------
    OSError
        If the cache folder cannot be written.
    """
    path = cache_folder() / f"{key}.c"
    if path.is_file():
        return path.read_text(encoding="utf-8")
    source = make()
    with _naming_the_cache():
        store.write_atomically(path, source)
    return source


def compiled_library(source: str) -> ctypes.CDLL:
    """Compile a C source, unless that was done before, and load it.

    Parameters
    ----------
    source
        Text of a C99 file that needs nothing but ``math.h``.

    Raises
    ------
    CompilationFailed
        If there is no C compiler (named by ``$CC``, or ``cc``, ``gcc``, ``clang``), or it fails.
    OSError
        If the cache folder cannot be written.
    """
    compiler = _compiler()
    tuning, target = _target(compiler)
    path = cache_folder() / f"{store.content_key(source, FLAGS, tuning, target)}.so"
    if not path.exists():
        _compile(compiler, (*FLAGS, *tuning), source, path)
    return ctypes.CDLL(str(path))


class RowFunction:
    """A function of a compiled file that takes rows of joint values, called on tensors.

    Parameters
    ----------
    library, name
        Where it is.
    joints
        Numbers in a row.
    results
        How many arrays it writes.
    """

    def __init__(self, library: ctypes.CDLL, name: str, joints: int, results: int) -> None:
        self._function = getattr(library, name)
        self._joints = joints
        pointer, size = ctypes.c_void_p, ctypes.c_size_t
        self._function.argtypes = [pointer, size, size, *[pointer] * results]

    def __call__(self, rows: Tensor, *results: int) -> None:
        """Run on rows in plain memory, and write to the addresses of `results`.

        Raises
        ------
        ValueError
            If a row holds a NaN or an infinity.
        """
        error = self._function(rows.data_ptr(), rows.numel() // self._joints, self._joints, *results)
        if error == NOT_FINITE:
            raise ValueError("q is not finite: it holds NaN or an infinity")
        if error:
            raise RuntimeError(f"the compiled function returned error {error}")

    def values(self, q: Tensor) -> Tensor:
        """Values (...) of joint values (..., n), where they are, by a function with one result a row.

        Raises
        ------
        ValueError
            If a row holds a NaN or an infinity.
        """
        rows = plain_memory(q)
        values = rows.new_empty(q.shape[:-1])
        self(rows, values.data_ptr())
        return values if q.is_cpu else values.to(q.device)


def plain_memory(q: Tensor) -> Tensor:
    """Return a tensor that lies on the CPU in its order and without gaps; itself if it does already."""
    # What is to be avoided for a single configuration: each call of torch takes longer than the function.
    return q if q.is_cpu and q.is_contiguous() else q.detach().cpu().contiguous()


def _compiler() -> list[str]:
    named = os.environ.get("CC")
    for command in [named.split()] if named else [["cc"], ["gcc"], ["clang"]]:
        if shutil.which(command[0]):
            return command
    raise CompilationFailed(
        f"there is no C compiler ({f'CC is {named!r}' if named else 'cc, gcc and clang were tried'}): "
        'install one, or use backend="torch", which needs none'
    )


def _target(compiler: Sequence[str]) -> tuple[tuple[str, ...], str]:
    """Return the flags that the compiler takes, and what it defines then: versions, processor's abilities."""
    for tuning in (TUNING, ()):
        run = _run([*compiler, *tuning, "-dM", "-E", "-x", "c", os.devnull])
        if run.returncode == 0:
            return tuning, run.stdout
    raise CompilationFailed(f"{compiler[0]} does not compile an empty file: {_last_lines(run.stderr)}")


def _compile(compiler: Sequence[str], flags: Sequence[str], source: str, path: Path) -> None:
    """Compile into a folder of its own beside `path`, then put the whole file in its place."""
    with _naming_the_cache():
        path.parent.mkdir(parents=True, exist_ok=True)
        workplace = tempfile.TemporaryDirectory(dir=path.parent, prefix=".compiling-")
    with workplace as folder:
        code, result = Path(folder, "index.c"), Path(folder, "index.so")
        code.write_text(source, encoding="utf-8")
        run = _run([*compiler, *flags, str(code), "-o", str(result), "-lm"])
        if run.returncode != 0 or not result.exists():
            raise CompilationFailed(
                f"{compiler[0]} failed with status {run.returncode}: {_last_lines(run.stderr)}"
            )
        result.replace(path)


@contextmanager
def _naming_the_cache() -> Iterator[None]:
    """Say which folder it is that cannot be written, and how to choose another."""
    try:
        yield
    except OSError as error:
        raise OSError(
            f"the cache folder {cache_folder()} cannot be written ({error.strerror}); "
            "the environment variable DEXTERITY_CACHE names another"
        ) from error


def _run(command: Sequence[str]) -> subprocess.CompletedProcess[str]:
    try:
        return subprocess.run(command, capture_output=True, text=True, check=False)  # noqa: S603
    except OSError as error:
        raise CompilationFailed(f"{command[0]} cannot be run: {error}") from error


def _last_lines(text: str) -> str:
    return "\n".join(text.strip().splitlines()[-20:]) or "it printed nothing"
