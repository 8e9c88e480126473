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

import hashlib
import importlib.metadata
from collections.abc import Mapping
from dataclasses import dataclass

from dexterity import store
from dexterity.codegen.angles import needs_values, with_angles_apart
from dexterity.codegen.c_file import NOT_FINITE, CFile, Precision, commented, table
from dexterity.codegen.costs import Costs, costs
from dexterity.codegen.heading import geometry, heading
from dexterity.codegen.names import words
from dexterity.codegen.reference import references
from dexterity.derivation import Derivation, SymbolicChain
from dexterity.elimination import LAGUERRE_STEPS, LAGUERRE_TOLERANCE, laguerre_step
from dexterity.indices import Index
from dexterity.program import Program

__all__ = ["ZERO", "c_files", "c_source", "function_name"]

ZERO = 1e-14
"""A KCI below it is a singularity seen through rounding."""

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


def c_source(derivation: Derivation, name: str | None = None, precision: Precision = "double") -> str:
    """Return one C file, without a header, that computes an index and its gradient.

    Parameters and errors are those of :func:`c_files`.
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
        large for it, or the chain has lengths without a value or too few joints for the index.
    """
    file, header, code = _parts(derivation, name, precision)
    return file.files(header, code)


def _parts(derivation: Derivation, name: str | None, precision: Precision) -> tuple[CFile, str, str]:
    derivation.chain.require_computable(derivation.index.name)
    file = CFile(
        function_name(derivation.chain, derivation.index, precision) if name is None else name, precision
    )
    computation = _COMPUTATIONS[derivation.index.name](derivation, file)
    joints, inputs = derivation.chain.joints, computation.inputs(file)
    turning = [int(kind == "revolute") for kind in derivation.chain.kinds]
    rows = references(derivation)
    code = file.fill(
        "file.c.in",
        sine_cosine=file.sine_cosine() if "_sine_cosine(" in computation.code else "",
        lay_out=file.lay_out(turning, computation.values_too),
        computation=computation.code,
        inputs=inputs,
        rows=table(rows.q.ravel()),
        values=table(rows.values),
        gradients=table(rows.gradients.ravel()),
        tolerance=1e-9 if precision == "double" else 1e-3,
        **file.patterns(),
    )
    lines = [
        *heading(derivation, epsilon=file.epsilon),
        f"Worst case for a value: {computation.value}.",
        f"Worst case for a value and its gradient: {computation.gradient}.",
        *geometry(derivation.chain),
    ]
    header = file.fill(
        "header.h.in",
        heading=commented(lines),
        joints=joints,
        version=importlib.metadata.version("dexterity-study"),
        sha256=hashlib.sha256(computation.code.encode()).hexdigest(),
        not_finite=NOT_FINITE,
        more_errors="",
        functions=file.fill("index_functions.h.in", joints=joints),
    )
    return file, header, code


@dataclass(frozen=True)
class _Computation:
    """C functions ``value`` and ``value_and_gradient`` of configurations side by side.

    Attributes
    ----------
    code
        Their text.
    values_too
        Whether they take the joint values beside the angles within one turn.
    value, gradient
        Operations that the two functions need at most.
    """

    code: str
    values_too: bool
    value: Costs
    gradient: Costs

    def inputs(self, file: CFile) -> str:
        return f"{2 if self.values_too else 1}*{file.name.upper()}_JOINTS"


def _manipulability(derivation: Derivation, file: CFile) -> _Computation:
    programs, values_too = _with_angles(
        derivation,
        {"value": derivation.manipulability, "value_and_gradient": derivation.manipulability_gradient},
    )
    code = "\n".join(file.loop(name, program) for name, program in programs.items())
    return _Computation(code, values_too, *map(costs, programs.values()))


def _conditioning(derivation: Derivation, file: CFile) -> _Computation:
    programs, values_too = _with_angles(
        derivation,
        {
            "bidiagonal": derivation.bidiagonal,
            "triangle": derivation.triangle,
            "conditioning_gradient": derivation.conditioning_gradient,
        },
    )
    step = laguerre_step(6)
    single = file.precision == "float"
    code = file.fill(
        "conditioning.c.in",
        inputs=f"{2 if values_too else 1}*{file.name.upper()}_JOINTS",
        zero=1e-6 if single else ZERO,
        steps=LAGUERRE_STEPS,
        sweeps=_SWEEPS,
        tolerance=1e-5 if single else LAGUERRE_TOLERANCE,
        rounding=2e-7 if single else 1e-15,
        nothing=1e-30 if single else 1e-300,
        bidiagonal=file.loop("bidiagonal", programs["bidiagonal"]),
        triangle=file.loop("triangle", programs["triangle"]),
        step=file.loop("laguerre_step", step),
        gradient=file.loop("conditioning_gradient", programs["conditioning_gradient"]),
    )
    value = costs(programs["bidiagonal"]) + costs(step) * (2 * LAGUERRE_STEPS)
    rotations = Costs(arithmetic=118, roots=3) * (15 * _SWEEPS)
    gradient = value + costs(programs["triangle"]) + rotations + costs(programs["conditioning_gradient"])
    return _Computation(code, values_too, value, gradient)


_COMPUTATIONS = {"manipulability": _manipulability, "kinematic_conditioning": _conditioning}


def _with_angles(derivation: Derivation, programs: Mapping[str, Program]) -> tuple[dict[str, Program], bool]:
    """Let programs take angles within one turn, and the joint values beside them where one needs these."""
    turning = [kind == "revolute" for kind in derivation.chain.kinds]
    if not any(needs_values(program, turning) for program in programs.values()):
        return dict(programs), False
    return {name: with_angles_apart(program, turning) for name, program in programs.items()}, True
