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
Costs(arithmetic=2, roots=1, sine_cosines=1)
"""

from __future__ import annotations

from dataclasses import dataclass

import sympy

from dexterity import operations
from dexterity.codegen.printing import with_angles_paired
from dexterity.program import Program

__all__ = ["Costs", "costs"]


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
    """

    arithmetic: int = 0
    roots: int = 0
    sine_cosines: int = 0

    def __add__(self, other: Costs) -> Costs:
        return Costs(
            self.arithmetic + other.arithmetic,
            self.roots + other.roots,
            self.sine_cosines + other.sine_cosines,
        )

    def __mul__(self, times: int) -> Costs:
        return Costs(self.arithmetic * times, self.roots * times, self.sine_cosines * times)

    def __str__(self) -> str:
        return (
            f"{self.arithmetic} additions, multiplications and divisions, {self.roots} square roots, "
            f"{self.sine_cosines} sines with cosines"
        )


def costs(program: Program) -> Costs:
    """Count the operations of a program, each step once."""
    arithmetic = roots = angles = 0
    for item in with_angles_paired(program):
        if len(item) == 3:
            angles += 1
            continue
        _, expression = item
        arithmetic += operations.count([expression]).total
        roots += sum(1 for power in expression.atoms(sympy.Pow) if power.exp.is_Rational and power.exp.q == 2)
    return Costs(arithmetic - roots, roots, angles)
