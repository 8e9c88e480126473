r"""C sources compiled on demand with the system's compiler, loaded, and stored for the next time.

Examples
--------
>>> from dexterity.codegen.library import compiled_library
>>> compiled_library("int twice(int x);\nint twice(int x) { return 2*x; }\n").twice(21)
42
"""

from __future__ import annotations

import ctypes
import os
import platform
import re
import tempfile
from collections.abc import Callable
from functools import cache
from pathlib import Path

from torch import Tensor

from dexterity import store
from dexterity.codegen import cache as entries
from dexterity.codegen import compiler
from dexterity.codegen.c_file import NOT_FINITE
from dexterity.codegen.cache import cache_folder
from dexterity.codegen.compiler import CompilationFailed

__all__ = [
    "CompilationFailed",
    "RowFunction",
    "cache_folder",
    "cached_source",
    "compiled_library",
    "plain_memory",
]

FLAGS = (
    "-std=c99", "-fno-fast-math", "-fno-unsafe-math-optimizations", "-O3", "-ffp-contract=fast",
    "-fno-math-errno", "-fno-trapping-math", "-fPIC", "-shared",
)  # fmt: skip
"""Flags that gcc and clang know. None changes what a NaN or an infinity is.

What ``$CC`` may say of fast math is taken back: a library that gcc links with it rounds the denormal numbers
of the whole process that loads it to zero.
"""

TUNING = ("-march=native", "-mprefer-vector-width=512")
"""Flags for the processor that this runs on, left out where the compiler refuses them."""


def cached_source(key: str, make: Callable[[], str]) -> str:
    """Return a generated source by its content key, made only if it is not there yet, or damaged.

    Raises
    ------
    OSError
        If the cache folder cannot be used or written.
    """
    if (content := entries.read(f"{key}.c")) is not None:
        return content.decode("utf-8")
    source = make()
    entries.write(f"{key}.c", source.encode("utf-8"))
    return source


def compiled_library(source: str) -> ctypes.CDLL:
    """Compile a C source, unless that was done before, and load it.

    If the source brings a self-test, it is run: a library that does not pass is never used.

    Parameters
    ----------
    source
        Text of a C99 file that needs nothing but the C library.

    Raises
    ------
    CompilationFailed
        If there is no C compiler (named by ``$CC``, or ``cc``, ``gcc``, ``clang``), it fails, or what it
        made does not compute what the source was derived from.
    OSError
        If the cache folder cannot be used or written.
    """
    name = f"{store.content_key(source, FLAGS, os.environ.get('CC', ''), _processor())}.so"
    content = entries.read(name)
    if content is not None and (library := _working(content, source)) is not None:
        return library
    words = compiler.command()
    entries.sweep()
    content, flags = _compiled(words, source)
    library = _working(content, source)
    if library is None:
        raise CompilationFailed(
            f"what {words[0]} made with {' '.join((*words[1:], *flags))} cannot be loaded, or does not "
            "compute what it was derived from; it was not stored"
        )
    entries.write(name, content)
    return library


@cache
def _processor() -> str:
    """Name the processor by what it can do, since compiled code may use all of that."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8", errors="replace").splitlines()
        abilities = sorted({line for line in lines if line.startswith(("flags", "Features", "model name"))})
    except OSError:
        abilities = [platform.processor()]
    return "\n".join([platform.system(), platform.machine(), *abilities])


def _compiled(words: list[str], source: str) -> tuple[bytes, tuple[str, ...]]:
    """Return a compiled library, and the flags that it was made with; the tuning ones if they are known."""
    with entries.naming_the_cache():
        workplace = tempfile.TemporaryDirectory(dir=entries.private_folder(), prefix=".compiling-")
    with workplace as folder:
        code, result = Path(folder, "index.c"), Path(folder, "index.so")
        with entries.naming_the_cache():
            code.write_text(source, encoding="utf-8")
        flags = (*FLAGS, *(TUNING if _knows(words, TUNING) else ()))
        compiler.run([*words, *flags, str(code), "-o", str(result), "-lm"])
        if not result.is_file():
            raise CompilationFailed(f"{words[0]} ended without an error, and without a library")
        return result.read_bytes(), flags


def _knows(words: list[str], flags: tuple[str, ...]) -> bool:
    empty = ("-E", "-x", "c", os.devnull)
    try:
        compiler.run([*words, *flags, *empty])
    except CompilationFailed:
        return False
    return True


def _working(content: bytes, source: str) -> ctypes.CDLL | None:
    """Return a library that can be loaded and passes the self-tests of its source, else None."""
    try:
        library = _loaded(content)
        tests = re.findall(r"^int (\w+_selftest)\(void\);$", source, flags=re.MULTILINE)
        return library if all(getattr(library, test)() == 0 for test in tests) else None
    except (OSError, AttributeError):
        return None


@cache
def _loaded(content: bytes) -> ctypes.CDLL:
    """Load a library from a copy of its content, which nobody else can change and which is then removed."""
    error = OSError("no folder")
    for parent in (entries.private_folder(), None):
        try:
            with tempfile.TemporaryDirectory(dir=parent, prefix=".loading-") as folder:
                path = Path(folder, "index.so")
                path.write_bytes(content)
                return ctypes.CDLL(str(path))
        except OSError as failure:  # not writable, full, or nothing may be run from it
            error = failure
    raise error


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

    def __call__(self, rows: Tensor, *results: int, first: int = 0) -> None:
        """Run on rows in plain memory, and write to the addresses of `results`.

        Parameters
        ----------
        rows
            (..., n) joint values.
        results
            Addresses of the arrays to write.
        first
            Number of the first row, for the error.

        Raises
        ------
        ValueError
            If a row holds a NaN or an infinity.
        """
        error = self._function(rows.data_ptr(), rows.numel() // self._joints, self._joints, *results)
        if error == NOT_FINITE:
            finite = rows.reshape(-1, self._joints).isfinite().all(-1)
            where = f", first in row {first + int(finite.int().argmin())}" if len(finite) > 1 else ""
            raise ValueError(f"q is not finite: it holds NaN or an infinity{where}")
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
    if q.is_cpu and q.is_contiguous() and not q.is_neg():
        return q
    return q.detach().cpu().resolve_neg().contiguous()
