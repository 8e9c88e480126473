"""Exact indices computed by compiled C, called on tensors and on single rows of numpy.

Examples
--------
>>> import numpy as np
>>> import dexterity as dx
>>> from dexterity.codegen.engine import InC
>>> from dexterity.derivation import SymbolicChain
>>> chain = SymbolicChain.from_chain(dx.robots.puma560())
>>> engine = InC(chain, dx.indices.Index("manipulability"))
>>> bool(engine.row(np.array([0.0, 0.5, 0.25, 0.0, 0.5, 0.0])) > 0)
True
"""

from __future__ import annotations

import ctypes
import importlib.metadata
import math
from concurrent.futures import ThreadPoolExecutor
from ctypes import byref, c_double
from functools import cache, cached_property
from pathlib import Path

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from dexterity import checks, store
from dexterity.chain import Chain
from dexterity.codegen.c99 import c_source, function_name
from dexterity.codegen.c_file import LANES
from dexterity.codegen.library import RowFunction, cached_source, compiled_library, plain_memory
from dexterity.derivation import SymbolicChain, derive
from dexterity.indices import Index
from dexterity.indices.jacobians import with_finite_powers

__all__ = ["InC", "cached_c_source"]


_PIECE = 2048
"""Configurations for which another thread pays, at least."""


class InC:
    """Calls a compiled C file.

    Parameters
    ----------
    chain, index
        What is computed.
    threads
        Number of threads that share the configurations of a call.

    Raises
    ------
    CompilationFailed
        If a compiler is missing or fails, or what it made is wrong.
    OSError
        If the folder for compiled code cannot be written.
    """

    def __init__(self, chain: SymbolicChain, index: Index, threads: int = 1) -> None:
        name = function_name(chain, index)
        library = compiled_library(cached_c_source(chain, index))
        self._joints = chain.joints
        self._threads = threads
        self._batch = RowFunction(library, f"{name}_batch", chain.joints, results=1)
        self._gradient_batch = RowFunction(library, f"{name}_gradient_batch", chain.joints, results=2)
        self._row = _row_function(library, name)

    def values(self, q: Tensor) -> Tensor:
        """Values (...) of configurations (..., n)."""
        rows = plain_memory(q)
        values = rows.new_empty(q.shape[:-1])
        self._run(self._batch, rows, (values, 1))
        _require_numbers(rows, values)
        return values if q.is_cpu else values.to(q.device)

    def values_and_gradients(self, q: Tensor) -> tuple[Tensor, Tensor]:
        """Values (...) and gradients (..., n) of configurations (..., n)."""
        rows = plain_memory(q)
        values, gradients = rows.new_empty(q.shape[:-1]), torch.empty_like(rows)
        self._run(self._gradient_batch, rows, (values, 1), (gradients, self._joints))
        _require_numbers(rows, values, gradients)
        return (values, gradients) if q.is_cpu else (values.to(q.device), gradients.to(q.device))

    def _run(self, function: RowFunction, rows: Tensor, *results: tuple[Tensor, int]) -> None:
        """Fill results, tensors with so many numbers for each row, in as many threads as pay."""
        count = rows.numel() // self._joints
        pieces = min(self._threads, count // _PIECE)
        if pieces <= 1:
            function(rows, *(result.data_ptr() for result, _ in results))
            return
        flat = rows.reshape(count, self._joints)
        # Whole blocks that C works on side by side: no result depends on the threads.
        size = -(-count // (pieces * LANES)) * LANES

        def work(start: int) -> None:
            addresses = (result.data_ptr() + 8 * width * start for result, width in results)
            function(flat[start : start + size], *addresses, first=start)

        # Calls of C run side by side: ctypes lets other threads go on meanwhile.
        for _ in self._pool.map(work, range(0, count, size)):
            pass

    @cached_property
    def _pool(self) -> ThreadPoolExecutor:
        return ThreadPoolExecutor(self._threads, thread_name_prefix="dexterity")

    def row(self, q: NDArray[np.float64]) -> np.float64:
        """Value of one configuration (n,), at the least cost that a call from Python has.

        Raises
        ------
        ValueError
            If `q` has another shape, is not finite, or is so large that there is no value.
        """
        if q.shape != (self._joints,):
            raise ValueError(f"q has shape {q.shape}; the chain has {self._joints} joints")
        value = c_double()
        # A copy in order and without gaps, at an address that ctypes takes as it is.
        if self._row(q.tobytes(), byref(value)):
            raise ValueError("q is not finite: it holds NaN or an infinity")
        if not math.isfinite(value.value):
            _require_numbers(torch.from_numpy(q.copy()), torch.tensor(value.value))
        return np.float64(value.value)


def _require_numbers(q: Tensor, *results: Tensor) -> None:
    """Refuse joint values so large that results are infinite or NaN, which a sum tells at little cost."""
    if not all(result.sum().isfinite() for result in results):
        with_finite_powers(q, "q")


def _row_function(library: ctypes.CDLL, name: str) -> ctypes._NamedFuncPointer:
    function = getattr(library, name)
    function.argtypes = [ctypes.c_char_p, ctypes.c_void_p]
    return function


@checks.arguments(chain=checks.Instance((Chain, SymbolicChain)), index=checks.Instance(Index))
def cached_c_source(chain: Chain | SymbolicChain, index: Index) -> str:
    """Return the C99 file of an index, derived only if the cache of generated code does not hold it.

    Raises
    ------
    ValueError
        If the chain has lengths without a value, or the index is zero everywhere or has no C form.
    OSError
        If the folder for generated code cannot be written.
    """
    chain = SymbolicChain.of(chain)
    key = store.content_key(chain.numbers(), index, _generator_key(store.PACKAGE))
    return cached_source(key, lambda: c_source(derive(chain, index)))


@cache
def _generator_key(package: Path) -> str:
    """Name the code that generates sources: all modules and templates of the package, and sympy's version."""
    paths = sorted(path for path in package.rglob("*") if path.suffix in (".py", ".in"))
    contents = {path.relative_to(package).as_posix(): path.read_bytes() for path in paths}
    return store.content_key(contents, importlib.metadata.version("sympy"))
