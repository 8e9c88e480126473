"""C files of exact indices: standard C, which every compiler takes, also as C++ and for small processors.

A file needs ``math.h``, ``stdint.h`` and ``string.h`` alone. Configurations are worked on sixteen at a time,
side by side, in loops without branches or calls, which a compiler turns into vector instructions; sines and
cosines are computed in place for that reason. The results do not depend on flags such as ``-ffast-math``.

Examples
--------
>>> import dexterity as dx
>>> from dexterity.codegen.c99 import c_files
>>> from dexterity.derivation import derive
>>> derivation = derive(dx.robots.puma560(), dx.indices.Index("manipulability"))
>>> files = c_files(derivation, name="puma_w")
>>> "int puma_w_gradient(const double *q, double *value, double *gradient);" in files["puma_w.h"]
True
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from dexterity import checks, store
from dexterity.codegen.c_file import CFile, Precision, table
from dexterity.codegen.costs import Costs, costs, memory
from dexterity.codegen.heading import geometry, heading, printable
from dexterity.codegen.names import words
from dexterity.codegen.reference import references
from dexterity.derivation import Derivation, SymbolicChain
from dexterity.elimination import LAGUERRE_STEPS, LAGUERRE_TOLERANCE, laguerre_step
from dexterity.indices import Index
from dexterity.program import Program

__all__ = ["ZERO", "c_files", "c_source", "function_name"]

ZERO = 1e-14
"""A ratio of singular values below it is a singularity seen through rounding."""

_SWEEPS = 30
"""Rounds of Jacobi's rotations for the singular vectors, at most."""


def function_name(chain: SymbolicChain, index: Index, precision: Precision = "double") -> str:
    """Name that the functions of a file begin with, unless a caller chooses one.

    It consists of the chain's and the index's name, the frame, and eight digits that distinguish the chain's
    geometry and all limits: two variants never have one name.
    """
    key = store.content_key(chain.numbers(), index, precision)[:8]
    suffix = ("f32",) if precision == "float" else ()
    return words(chain.name, index.name, index.frame, *suffix, key)


@checks.arguments(derivation=checks.Instance(Derivation))
def c_source(derivation: Derivation, name: str | None = None, precision: Precision = "double") -> str:
    """Return one C file, without a header, that computes an index and its gradient.

    Parameters and errors are those of :func:`dexterity.codegen.c_files`.
    """
    file, header, code = _parts(derivation, name, precision)
    return file.standalone(header, code)


def c_files(
    derivation: Derivation, name: str | None = None, precision: Precision = "double"
) -> dict[str, str]:
    """Return a header and a C file that compute an index and its gradient, by their file names.

    Parameters
    ----------
    derivation
        What is computed.
    name
        What all names in the files begin with; by default :func:`function_name`.
    precision
        Type of all numbers: ``"double"``, or ``"float"`` for processors without doubles.

    Raises
    ------
    TypeError, ValueError
        If the name cannot be used in C and C++, the precision is unknown, a number is not finite or too
        large for it, the chain has lengths without a value, or the index is zero everywhere or has no C form.
    """
    file, header, code = _parts(derivation, name, precision)
    return file.files(header, code)


def _parts(derivation: Derivation, name: str | None, precision: Precision) -> tuple[CFile, str, str]:
    derivation.require_computable()
    file = CFile(
        function_name(derivation.chain, derivation.index, precision) if name is None else name, precision
    )
    computation, joints = _computation(derivation, file), derivation.chain.joints
    values_too = bool(derivation.values_as_given)
    turning = [int(kind == "revolute") for kind in derivation.chain.kinds]
    rows = references(derivation)
    code = file.fill(
        "file.c.in",
        elementary=file.elementary(computation.code),
        lay_out=file.lay_out(turning, values_too),
        computation=computation.code,
        inputs=f"{2 if values_too else 1}*{file.name.upper()}_JOINTS",
        rows=table(rows.q.ravel()),
        values=table(rows.values),
        gradients=table(rows.gradients.ravel()),
        tolerance=1e-9 if precision == "double" else 1e-3,
        **file.patterns(),
    )
    lines = [
        *heading(derivation, epsilon=file.epsilon),
        *printable(
            [
                f"Worst case for a value: {computation.value}.",
                f"Worst case for a value and its gradient: {computation.gradient}.",
                _memory(file, computation, joints, values_too),
            ]
        ),
        *geometry(derivation.chain),
    ]
    functions = file.fill("index_functions.h.in", joints=joints)
    return file, file.header(lines, joints, computation.code, functions), code


def _memory(file: CFile, computation: _Computation, joints: int, values_too: bool) -> str:
    rows = (2 if values_too else 1) * joints + 1 + joints + computation.rows
    constants = 4 * (2 * joints + 1)
    return memory(computation.programs, rows, file.number_bytes, constants, f"{file.name.upper()}_")


@dataclass(frozen=True)
class _Computation:
    """C functions ``value`` and ``value_and_gradient`` of configurations side by side.

    Attributes
    ----------
    code
        Their text.
    value, gradient
        Operations that the two functions need at most.
    programs
        What is written out.
    rows
        Rows of numbers on the stack at a time, beside inputs and outputs.
    """

    code: str
    value: Costs
    gradient: Costs
    programs: Sequence[Program]
    rows: int


def _computation(derivation: Derivation, file: CFile) -> _Computation:
    if derivation.kind == "closed":
        return _closed(derivation, file)
    if derivation.kind == "spectral":
        return _spectral(derivation, file)
    raise ValueError(f'{derivation.not_recorded}. It has no C form; backend="torch" computes it')


def _closed(derivation: Derivation, file: CFile) -> _Computation:
    programs = {"value": derivation.value, "value_and_gradient": derivation.value_and_gradient}
    code = "\n".join(file.loop(name, program) for name, program in programs.items())
    value, gradient = map(costs, programs.values())
    return _Computation(code, value, gradient, [*programs.values()], 0)


def _spectral(derivation: Derivation, file: CFile) -> _Computation:
    m, single = derivation.size, file.precision == "float"
    programs = {
        "bidiagonal": derivation.bidiagonal_with_sum,
        "laguerre_step": laguerre_step(m),
        "combination": derivation.combination,
        "triangle": derivation.triangle,
        "gradient_of_vectors": derivation.spectral_gradient,
    }
    loops = {name: file.loop(name, program) for name, program in programs.items()}
    code = file.fill(
        "spectral.c.in",
        size=m,
        squares=2 * m - 1,
        entries=m * (m + 1) // 2,
        zero=1e-6 if single else ZERO,
        steps=LAGUERRE_STEPS,
        sweeps=_SWEEPS,
        tolerance=1e-5 if single else LAGUERRE_TOLERANCE,
        rounding=2e-7 if single else 1e-15,
        nothing=1e-30 if single else 1e-300,
        step=loops.pop("laguerre_step"),
        gradient=loops.pop("gradient_of_vectors"),
        **loops,
    )
    needed = {name: costs(program) for name, program in programs.items()}
    steps = needed["laguerre_step"] * (2 * LAGUERRE_STEPS)
    value = needed["bidiagonal"] + steps + needed["combination"] + Costs(roots=2)
    pairs = m * (m - 1) // 2 * _SWEEPS
    rotations = Costs(arithmetic=18 * m + 20, roots=3) * pairs
    vectors = Costs(arithmetic=24 * m * m, roots=6)
    gradient = value + needed["triangle"] + rotations + vectors + needed["gradient_of_vectors"]
    rows = m * (m + 1) // 2 + 2 * m * m + 12 * m + derivation.chain.joints + 12
    return _Computation(code, value, gradient, [*programs.values()], rows)
