"""What a generated C file needs at most: operations for a configuration, stack, and memory for code.

The numbers stand in the headers of the files, and tests hold compilers to them.

Examples
--------
>>> import sympy
>>> from dexterity.codegen.costs import Costs, costs
>>> from dexterity.program import Recorder
>>> x, y = sympy.symbols("x y", real=True)
>>> record = Recorder()
>>> costs(record.program((x, y), [sympy.sqrt(x * y + 1), sympy.sin(x)]))
Costs(arithmetic=2, roots=1, sine_cosines=1, exponentials=0)
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import astuple, dataclass

import sympy

from dexterity import operations
from dexterity.codegen.c_file import LANES
from dexterity.codegen.printing import with_angles_paired
from dexterity.program import Program

__all__ = ["Costs", "costs", "memory"]


@dataclass(frozen=True)
class Costs:
    """Operations for one configuration.

    Attributes
    ----------
    arithmetic
        Additions, multiplications and divisions.
    roots
        Square roots.
    sine_cosines
        Sines with their cosines.
    exponentials
        Exponentials and logarithms.
    """

    arithmetic: int = 0
    roots: int = 0
    sine_cosines: int = 0
    exponentials: int = 0

    def __add__(self, other: Costs) -> Costs:
        return Costs(
            self.arithmetic + other.arithmetic,
            self.roots + other.roots,
            self.sine_cosines + other.sine_cosines,
            self.exponentials + other.exponentials,
        )

    def __mul__(self, times: int) -> Costs:
        return Costs(*(number * times for number in astuple(self)))

    def __str__(self) -> str:
        words = (
            f"{self.arithmetic} additions, multiplications and divisions, {self.roots} square roots, "
            f"{self.sine_cosines} sines with cosines"
        )
        return f"{words}, {self.exponentials} exponentials and logarithms" if self.exponentials else words


def costs(program: Program) -> Costs:
    """Count the operations of a program, each step once."""
    arithmetic = roots = angles = exponentials = 0
    for item in with_angles_paired(program):
        if len(item) == 3:
            angles += 1
            continue
        _, expression = item
        # An exponential counts as a multiplication there.
        arithmetic += operations.count([expression]).total - len(expression.atoms(sympy.exp))
        roots += sum(1 for power in expression.atoms(sympy.Pow) if power.exp.is_Rational and power.exp.q == 2)
        exponentials += len(expression.atoms(sympy.exp, sympy.log))
    return Costs(arithmetic - roots, roots, angles, exponentials)


_BYTES_OF_CODE = 16
"""Code for an operation, at most, on 64-bit processors with -Os."""

_FIXED = 4096
"""Code of the loops and checks around the programs, and of elementary functions."""

_FRAMES = 1024
"""Stack of the functions themselves."""


def memory(programs: Iterable[Program], rows: int, number_bytes: int, constants: int, prefix: str) -> str:
    """Say how much memory a file needs at most, compiled with -Os.

    Parameters
    ----------
    programs
        Programs that are written out.
    rows
        Rows of numbers, one for each configuration side by side, that lie on the stack at a time.
    number_bytes
        Size of a number.
    constants
        Numbers of tables.
    prefix
        What macros of the file begin with.
    """
    programs = list(programs)
    needed = sum(map(costs, programs), Costs())
    operations_in_all = needed.arithmetic + needed.roots + 8 * (needed.sine_cosines + needed.exponentials)
    outputs = sum(len(program.inputs) + len(program.outputs) for program in programs)
    code = _FIXED + _BYTES_OF_CODE * (operations_in_all + outputs) + number_bytes * constants
    # Compilers reorder steps, and keep more values at a time than the order of the steps asks for.
    spilled = 4 * max(map(_live, programs))
    stack, least = (_FRAMES + number_bytes * (lanes * rows + spilled) for lanes in (LANES, 1))
    return (
        f"Memory with -Os: at most {code} bytes of code and constants, none that is written; "
        f"stack at most {stack} bytes, {least} where {prefix}LANES is 1"
    )


def _live(program: Program) -> int:
    """Largest number of values that are needed later on, at any step."""
    live: set[sympy.Symbol] = set().union(*(output.free_symbols for output in program.outputs))
    most = len(live)
    for symbol, expression in reversed(program.steps):
        live = (live - {symbol}) | expression.free_symbols
        most = max(most, len(live))
    return most
