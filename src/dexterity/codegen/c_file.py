"""What all generated C files have in common: their names, their numbers, and the functions that they share.

A file is written for numbers of double precision; one of single precision is the same text with other
types, literals, and constants. All that it defines at file scope begins with its name.

Examples
--------
>>> from dexterity.codegen.c_file import CFile
>>> file = CFile("arm", "float")
>>> "static inline void arm_sine_cosine(double x" in file.sine_cosine()
True
>>> files = file.files("header", "code")
>>> sorted(files)
['arm.c', 'arm.h']
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Literal, TypeAlias, get_args

import mpmath
import numpy as np
import sympy
from numpy.typing import NDArray
from sympy import Symbol

from dexterity.codegen.names import require_c_name
from dexterity.codegen.printing import C, number, template, with_angles_paired
from dexterity.codegen.single_precision import in_single_precision
from dexterity.program import Program

__all__ = ["LANES", "NOT_FINITE", "CFile", "Precision", "commented", "table"]

Precision: TypeAlias = Literal["double", "float"]
"""Type of all numbers of a C file."""

NOT_FINITE = 3
"""Error that the functions of a file return for a NaN or an infinity."""


@dataclass(frozen=True)
class _Format:
    """What a type of numbers needs: its bits, and constants that fit its range and its digits.

    Attributes
    ----------
    bits, mantissa, bias
        Width of a number, of the stored part of its mantissa, and what is added to its exponent.
    half
        Half of an exponent at which powers of two are certainly zero or infinite.
    power_terms
        Terms of the polynomial for a power of two.
    sine_terms
        Terms of the polynomials for sine and cosine beyond the first.
    parts
        Bits of the three parts of π/2.
    range
        Largest angle whose number of quarter turns times each part is exact.
    """

    bits: int
    mantissa: int
    bias: int
    half: int
    power_terms: int
    sine_terms: int
    parts: tuple[int, int, int]
    range: float


_FORMATS: dict[Precision, _Format] = {
    "double": _Format(64, 52, 1023, 550, 12, 7, (33, 33, 53), 1e5),
    "float": _Format(32, 23, 127, 80, 7, 4, (16, 16, 24), 400.0),
}

LANES = 16
"""Configurations that a file works on side by side."""

_TURN = 8
"""Revolute joints beyond this angle [rad] are brought into one turn first: more than any single turn."""


@dataclass(frozen=True)
class CFile:
    """A C file in the making.

    Parameters
    ----------
    name
        What all its names begin with.
    precision
        ``"double"`` or ``"float"``.

    Raises
    ------
    TypeError, ValueError
        If the name cannot be used in C and C++, or the precision is unknown.
    """

    name: str
    precision: Precision = "double"

    def __post_init__(self) -> None:
        require_c_name(self.name)
        if self.precision not in get_args(Precision):
            raise ValueError(f"precision is {self.precision!r}; {get_args(Precision)} are known")

    @property
    def number_bytes(self) -> int:
        """Size of a number [bytes]."""
        return self._format.bits // 8

    @property
    def epsilon(self) -> float:
        """Largest relative rounding error of a number."""
        return 2.0 ** -(self._format.mantissa + 1)

    @property
    def _format(self) -> _Format:
        return _FORMATS[self.precision]

    def fill(self, template_name: str, **parts: object) -> str:
        """Return a template with its parts; ``p`` and ``P`` begin the names of functions and of macros."""
        names = {"name": self.name, "p": f"{self.name}_", "P": f"{self.name.upper()}_"}
        return template(template_name).substitute(names, **parts)

    def files(self, header: str, code: str) -> dict[str, str]:
        """Return the texts of a header and of the file that includes it, by their names."""
        beginning = f"/* What this file computes, and how its functions are called: {self.name}.h */\n"
        included = f'#include "{self.name}.h"\n'
        return {
            f"{self.name}.h": self._in_precision(header),
            f"{self.name}.c": beginning + self._in_precision(included + _INCLUDES + self._preamble() + code),
        }

    def standalone(self, header: str, code: str) -> str:
        """Return one file that needs no other, the header's text at its beginning."""
        return self._in_precision(header + _INCLUDES + self._preamble() + code)

    def _in_precision(self, code: str) -> str:
        return code if self.precision == "double" else in_single_precision(code)

    def _preamble(self) -> str:
        return self.fill("preamble.c.in", lanes=LANES, **self.patterns())

    def patterns(self) -> dict[str, object]:
        """Return the bits of some numbers, as templates take them."""
        bits = self._format.bits
        patterns = {
            "magnitude": (1 << (bits - 1)) - 1,
            "turn_bits": self._pattern(_TURN),
            "infinity_bits": self._pattern(np.inf),
        }
        return {"bits": bits} | {name: f"UINT{bits}_C({pattern:#x})" for name, pattern in patterns.items()}

    def _pattern(self, x: float) -> int:
        if self.precision == "float":
            return int(np.float32(x).view(np.uint32))
        return int(np.float64(x).view(np.uint64))

    def lay_out(self, turning: Sequence[int], values_too: bool) -> str:
        """Return the C function that lays configurations side by side, revolute joints within one turn.

        Parameters
        ----------
        turning
            1 for each revolute joint, 0 for each prismatic one.
        values_too
            Whether the joint values as they are follow the angles within one turn.
        """
        raw = (
            "  for (int j = 0; j < $n; ++j)\n    for (int l = 0; l < lanes; ++l)\n"
            "      in[$n + j][l] = q[l*$n + j];\n"
        ).replace("$n", f"{self.name.upper()}_JOINTS")
        return self.fill(
            "lay_out.c.in",
            one_turn=self.one_turn(),
            turning="{" + ", ".join(map(str, turning)) + "}",
            then_raw=", then as they are" if values_too else "",
            raw=raw if values_too else "",
        )

    # ---- programs ----------------------------------------------------------------------------------

    def loop(self, function: str, program: Program) -> str:
        """Return a C function that runs a program on configurations side by side."""
        unused = "" if program.used_inputs else "  (void)in;\n"
        statements = [
            *(f"const double {q} = in[{program.inputs.index(q)}][l];" for q in program.used_inputs),
            *self._statements(program),
            *(f"out[{i}][l] = {_as_number(output)};" for i, output in enumerate(program.outputs)),
        ]
        body = "\n".join(f"    {statement}" for statement in statements)
        rows = f"double (*{self.name.upper()}_RESTRICT %s)[{self.name.upper()}_LANES]"
        return (
            f"static void {self.name}_{function}(int lanes, {rows % 'in'},\n    {rows % 'out'})\n"
            f"{{\n{unused}  for (int l = 0; l < lanes; ++l) {{\n{body}\n  }}\n}}\n"
        )

    def _statements(self, program: Program) -> list[str]:
        statements = []
        for place, item in enumerate(with_angles_paired(program)):
            if len(item) == 2:
                symbol, expression = item
                statements.append(f"const double {symbol} = {_as_number(expression)};")
            else:
                angle, sine, cosine = (x or Symbol(f"unused{place}") for x in item)
                statements.append(f"double {sine}, {cosine};")
                statements.append(f"{self.name}_sine_cosine({C.doprint(angle)}, &{sine}, &{cosine});")
        return statements

    # ---- elementary functions ----------------------------------------------------------------------

    def sine_cosine(self) -> str:
        """Return the C function for a sine with its cosine.

        Angles are reduced by π/2 in three parts. Beyond ±π/4 nothing is left, and there the first term that
        the Taylor polynomials leave out is below half a rounding error.
        """
        z, terms = Symbol("z"), self._format.sine_terms
        sine = sum((-1) ** (k % 2) * z ** (k - 1) / sympy.factorial(2 * k + 1) for k in range(1, terms + 1))
        cosine = sum((-1) ** (k % 2) * z ** (k - 2) / sympy.factorial(2 * k) for k in range(2, terms + 2))
        return self.fill(
            "sine_cosine.c.in",
            range=repr(self._format.range),
            quarter_turns=repr(float(2 / mpmath.pi)),
            **{f"part{i}": repr(part) for i, part in enumerate(self._quarter_turn())},
            sine=_horner(sine, z),
            cosine=_horner(cosine, z),
        )

    def one_turn(self) -> str:
        """Return the C functions that find large angles and bring them into one turn, 2π in three parts."""
        return self.fill(
            "one_turn.c.in",
            turn=_TURN,
            range=repr(self._format.range),
            turns=repr(float(1 / (2 * mpmath.pi))),
            **{f"turn{i}": repr(4 * part) for i, part in enumerate(self._quarter_turn())},
            **self.patterns(),
        )

    def _quarter_turn(self) -> list[float]:
        """Return π/2 in three parts.

        The first two have so few bits that their products with the number of quarter turns are exact
        (Cody & Waite, 1980).
        """
        with mpmath.workprec(200):
            parts, rest = [], mpmath.pi / 2
            for bits in self._format.parts:
                parts.append(_rounded(rest, bits))
                rest -= parts[-1]
        return parts

    def power_of_two(self) -> str:
        """Return the C function for 2 to a power: whole numbers in the exponent's bits, a polynomial between.

        The polynomial interpolates in Chebyshev's points, and is off by less than half a rounding error
        within ±1/2.
        """
        own = self._format
        with mpmath.workprec(200):
            coefficients = mpmath.chebyfit(lambda r: mpmath.mpf(2) ** r, [-0.5, 0.5], own.power_terms)
        return self.fill(
            "power_of_two.c.in",
            bits=own.bits,
            bias=own.bias,
            mantissa=own.mantissa,
            half=own.half,
            most=repr(2.0 * own.half),
            power=_nested([float(c) for c in coefficients], "r"),
        )


_INCLUDES = "#include <math.h>\n#include <stdint.h>\n#include <string.h>\n\n"


def table(rows: NDArray[np.float64]) -> str:
    """Return numbers (..., n) as the initial value of a C array, with all their digits.

    Raises
    ------
    ValueError
        If a number is not finite.
    """
    parts = map(table, rows) if rows.ndim > 1 else map(number, rows.tolist())
    return "{" + ", ".join(parts) + "}"


def commented(lines: Iterable[str]) -> str:
    """Return lines as those within a comment."""
    return "\n".join(f" * {line}".rstrip() for line in lines)


def _as_number(expression: sympy.Expr) -> str:
    """Return an expression in C; a whole number has a point, so that it has the type of the others."""
    if expression.is_Number and expression.is_finite:
        return number(float(expression))
    return str(C.doprint(expression))


def _rounded(x: mpmath.mpf, bits: int) -> float:
    with mpmath.workprec(bits):
        return float(+x)


def _horner(polynomial: sympy.Expr, z: Symbol) -> str:
    """Nested form with the coefficients rounded to doubles."""
    return _nested([float(c) for c in sympy.Poly(polynomial, z).all_coeffs()], str(z))


def _nested(coefficients: Sequence[float], variable: str) -> str:
    """Polynomial, its coefficients from the highest power down."""
    text = repr(coefficients[0])
    for coefficient in coefficients[1:]:
        text = f"{coefficient!r} + {variable}*({text})"
    return text
