"""What all generated C files have in common: their names, their numbers, and the functions that they share.

A file is written for numbers of double precision; one of single precision is the same text with other
types, literals, and constants. All that it defines at file scope begins with its name.

Examples
--------
>>> from dexterity.codegen.c_file import CFile
>>> file = CFile("arm", "float")
>>> "static inline void arm_sine_cosine(double x" in file.elementary("arm_sine_cosine(q, &s, &c);")
True
>>> files = file.files("header", "code")
>>> sorted(files)
['arm.c', 'arm.h']
"""

from __future__ import annotations

import hashlib
import importlib.metadata
import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Literal, TypeAlias, get_args

import mpmath
import numpy as np
import sympy
from numpy.typing import NDArray
from sympy import Symbol

from dexterity import checks
from dexterity.codegen.names import require_c_name
from dexterity.codegen.printing import c_printer, number, template, with_angles_paired
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
    power_terms, exponential_terms, logarithm_terms
        Terms of the polynomials for a power of two, an exponential beyond 1 + x, and a logarithm.
    sine_terms
        Terms of the polynomials for sine and cosine beyond the first.
    parts
        Bits of the three parts of π/2.
    range
        Largest angle whose number of quarter turns times each part is exact.
    log_bits
        Bits of the first part of log 2, whose product with any exponent is exact.
    small
        Positive numbers below this one may have lost bits of their mantissa.
    """

    bits: int
    mantissa: int
    bias: int
    half: int
    power_terms: int
    exponential_terms: int
    logarithm_terms: int
    sine_terms: int
    parts: tuple[int, int, int]
    range: float
    log_bits: int
    small: float


_FORMATS: dict[Precision, _Format] = {
    "double": _Format(64, 52, 1023, 550, 12, 12, 8, 7, (33, 33, 53), 1e5, 40, 1e-300),
    "float": _Format(32, 23, 127, 80, 7, 6, 4, 4, (16, 16, 24), 400.0, 15, 1e-30),
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
        checks.choice(self.precision, "precision", get_args(Precision))

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

    def header(
        self, lines: Iterable[str], joints: int, content: str, functions: str, more_errors: str = ""
    ) -> str:
        """Return the text of a header: what a file computes, the checksum of that, errors and functions."""
        return self.fill(
            "header.h.in",
            heading=commented(lines),
            joints=joints,
            version=importlib.metadata.version("dexterity-study"),
            sha256=hashlib.sha256(content.encode()).hexdigest(),
            not_finite=NOT_FINITE,
            more_errors=more_errors,
            functions=functions,
        )

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
        patterns = {
            "magnitude": (1 << (self._format.bits - 1)) - 1,
            "turn_bits": self._pattern(_TURN),
            "infinity_bits": self._pattern(np.inf),
        }
        literals = {name: self._literal(pattern) for name, pattern in patterns.items()}
        return {"bits": self._format.bits, **literals}

    def _literal(self, pattern: int) -> str:
        return f"UINT{self._format.bits}_C({pattern:#x})"

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
            *(f"out[{i}][l] = {self._as_number(output)};" for i, output in enumerate(program.outputs)),
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
                statements.append(f"const double {symbol} = {self._as_number(expression)};")
            else:
                angle, sine, cosine = (x or Symbol(f"unused{place}") for x in item)
                statements.append(f"double {sine}, {cosine};")
                statements.append(f"{self.name}_sine_cosine({self._as_number(angle)}, &{sine}, &{cosine});")
        return statements

    def _as_number(self, expression: sympy.Expr) -> str:
        """Return an expression in C; a whole number has a point, so that it has the type of the others."""
        if expression.is_Number and expression.is_finite:
            return number(float(expression))
        return str(c_printer(f"{self.name}_").doprint(expression))

    # ---- elementary functions ----------------------------------------------------------------------

    def elementary(self, code: str) -> str:
        """Return those C functions for sines, powers and logarithms that some code calls."""
        texts = {
            "sine_cosine": self._sine_cosine,
            "power_of_two": self._power_of_two,
            "exponential": self._exponential,
            "logarithm": self._logarithm,
        }
        called = "".join(text() for name, text in texts.items() if f"{self.name}_{name}(" in code)
        return (self._whole_power() if f"{self.name}_whole_power(" in called else "") + called

    def _sine_cosine(self) -> str:
        """Sine with cosine.

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

    def _power_of_two(self) -> str:
        """2 to a power: whole numbers in the exponent's bits, a polynomial between."""
        power = _fitted(lambda r: mpmath.mpf(2) ** r, [-0.5, 0.5], self._format.power_terms)
        parts = {"most": repr(2.0 * self._format.half), "power": _nested(power, "r")}
        return self.fill("power_of_two.c.in", **parts, **self.patterns())

    def _whole_power(self) -> str:
        own, large = self._format, 1.5 * 2.0**self._format.mantissa
        return self.fill(
            "whole_power.c.in",
            bits=own.bits,
            twice_bias=2 * own.bias,
            mantissa=own.mantissa,
            large=repr(large),
            large_bits=self._literal(self._pattern(large)),
        )

    def _exponential(self) -> str:
        """Exponential: a whole power of two, and 1 + r + r² times a polynomial of what is left."""
        end, own = math.log(2) / 2, self._format
        power = _fitted(lambda r: (mpmath.expm1(r) - r) / r**2, [-end, end], own.exponential_terms)
        return self.fill(
            "exponential.c.in",
            most=repr(2 * own.half * math.log(2)),
            per_log_of_two=repr(1 / math.log(2)),
            power=_nested(power, "r"),
            **self._log_of_two(),
            **self.patterns(),
        )

    def _logarithm(self) -> str:
        """Logarithm: of the whole power of two, and of m = 1 + f, which lies within a factor √2 of 1.

        With s = f/(2 + f) it is 2 artanh s = f - f²/2 + s (f²/2 + s² p(s²)), where f is exact.
        """
        own, most = self._format, ((math.sqrt(2) - 1) / (math.sqrt(2) + 1)) ** 2
        large, lift = 2.0**own.mantissa, own.mantissa + 2
        series = _fitted(
            lambda z: (2 * mpmath.atanh(mpmath.sqrt(z)) / mpmath.sqrt(z) - 2) / z,
            [0, most],
            own.logarithm_terms,
        )
        patterns = {"one": 1.0, "root": math.sqrt(0.5), "large": large, "nan": np.nan}
        return self.fill(
            "logarithm.c.in",
            small=own.small,
            lift=repr(2.0**lift),
            bias=repr(large + own.bias),
            lifted_bias=repr(large + own.bias + lift),
            mantissa=own.mantissa,
            mantissa_bits=self._literal((1 << own.mantissa) - 1),
            series=_nested(series, "z"),
            **{f"{name}_bits": self._literal(self._pattern(x)) for name, x in patterns.items()},
            **self._log_of_two(),
            **self.patterns(),
        )

    def _log_of_two(self) -> dict[str, str]:
        with mpmath.workprec(200):
            first = _rounded(mpmath.log(2), self._format.log_bits)
            return {"log_of_two0": repr(first), "log_of_two1": repr(float(mpmath.log(2) - first))}


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


def _rounded(x: mpmath.mpf, bits: int) -> float:
    with mpmath.workprec(bits):
        return float(+x)


def _fitted(function: Callable[[mpmath.mpf], mpmath.mpf], ends: list[float], terms: int) -> list[float]:
    """Coefficients, from the highest power down, of the polynomial that interpolates in Chebyshev's points.

    With the terms of the formats it is off by less than half a rounding error.
    """
    with mpmath.workprec(200):
        return [float(c) for c in mpmath.chebyfit(function, ends, terms)]


def _horner(polynomial: sympy.Expr, z: Symbol) -> str:
    """Nested form with the coefficients rounded to doubles."""
    return _nested([float(c) for c in sympy.Poly(polynomial, z).all_coeffs()], str(z))


def _nested(coefficients: Sequence[float], variable: str) -> str:
    """Polynomial, its coefficients from the highest power down."""
    text = repr(coefficients[0])
    for coefficient in coefficients[1:]:
        text = f"{coefficient!r} + {variable}*({text})"
    return text
