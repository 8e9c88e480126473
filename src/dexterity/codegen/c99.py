"""Standalone C99 files of exact indices.

A file needs ``math.h`` alone. Configurations are worked on sixteen at a time, side by side, in loops without
branches or calls, which a compiler turns into vector instructions; sines and cosines are computed in place
for that reason.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence

import mpmath
import sympy
from sympy import Symbol

from dexterity.codegen.heading import heading
from dexterity.codegen.printing import C, template, with_angles_paired
from dexterity.derivation import Derivation
from dexterity.elimination import LAGUERRE_STEPS, LAGUERRE_TOLERANCE, laguerre_step
from dexterity.program import Program

__all__ = [
    "NOT_FINITE",
    "ZERO",
    "c_source",
    "commented",
    "function_name",
    "loop",
    "power_of_two",
    "sine_cosine",
]


NOT_FINITE = 3
"""What the functions of a file return for a NaN or an infinity."""

ZERO = 1e-14
"""A KCI below it is a singularity seen through rounding."""


def function_name(chain: str, index: str) -> str:
    """Name that the functions of a file begin with: letters, digits and underscores of chain and index."""
    words = f"{chain} {index}"
    name = re.sub(r"[^a-z0-9]+", "_", words.lower()).strip("_")
    return name if name[0].isalpha() else f"chain_{name}"


def c_source(derivation: Derivation) -> str:
    """Return a C99 file that computes an index and its gradient.

    Raises
    ------
    ValueError
        If the chain has lengths without a value, or fewer than six joints.
    """
    derivation.chain.require_computable(derivation.index.name)
    computation = _COMPUTATIONS[derivation.index.name](derivation)
    parts = {
        "heading": commented(heading(derivation)),
        "name": function_name(derivation.chain.name, derivation.index.name),
        "not_finite": NOT_FINITE,
        "joints": derivation.chain.joints,
        "turning": ", ".join(str(int(kind == "revolute")) for kind in derivation.chain.kinds),
        "sine_cosine": sine_cosine() if "sine_cosine(" in computation else "",
        "computation": computation,
    }
    return template("file.c.in").substitute(parts)


def commented(lines: Iterable[str]) -> str:
    """Return lines as those within a comment."""
    return "\n".join(f" * {line}".rstrip() for line in lines)


def _manipulability(derivation: Derivation) -> str:
    value = loop("index_value", derivation.manipulability)
    return value + "\n" + loop("index_gradient", derivation.manipulability_gradient)


def _conditioning(derivation: Derivation) -> str:
    return template("conditioning.c.in").substitute(
        zero=ZERO,
        steps=LAGUERRE_STEPS,
        tolerance=LAGUERRE_TOLERANCE,
        bidiagonal=loop("bidiagonal", derivation.bidiagonal),
        triangle=loop("triangle", derivation.triangle),
        step=loop("laguerre_step", laguerre_step(6)),
        gradient=loop("conditioning_gradient", derivation.conditioning_gradient),
    )


_COMPUTATIONS = {"manipulability": _manipulability, "kinematic_conditioning": _conditioning}


def loop(name: str, program: Program) -> str:
    """Return a C function that runs a program on configurations side by side."""
    unused = "" if program.used_inputs else "  (void)in;\n"
    statements = [
        *(f"const double {q} = in[{program.inputs.index(q)}][l];" for q in program.used_inputs),
        *_statements(program),
        *(f"out[{i}][l] = {C.doprint(output)};" for i, output in enumerate(program.outputs)),
    ]
    body = "\n".join(f"    {statement}" for statement in statements)
    return (
        f"static void {name}(int lanes, double (*restrict in)[LANES], double (*restrict out)[LANES])\n"
        f"{{\n{unused}  for (int l = 0; l < lanes; ++l) {{\n{body}\n  }}\n}}\n"
    )


def _statements(program: Program) -> list[str]:
    statements = []
    for number, item in enumerate(with_angles_paired(program)):
        if len(item) == 2:
            symbol, expression = item
            statements.append(f"const double {symbol} = {C.doprint(expression)};")
        else:
            angle, sine, cosine = (x or Symbol(f"unused{number}") for x in item)
            statements.append(f"double {sine}, {cosine};")
            statements.append(f"sine_cosine({C.doprint(angle)}, &{sine}, &{cosine});")
    return statements


def sine_cosine() -> str:
    """Return the C function for a sine and a cosine: reduction by π/2 in three parts, Taylor polynomials.

    The first two parts of π/2 have 33 bits, so that their products with the number of quarter turns, which
    has at most 17, are exact (Cody & Waite, 1980). Beyond ±π/4 nothing is left, and there the first term
    that the polynomials leave out is below half a rounding error.
    """
    with mpmath.workprec(200):
        parts, rest = [], mpmath.pi / 2
        for bits in (33, 33, 53):
            parts.append(_rounded(rest, bits))
            rest -= parts[-1]
        quarter_turns = float(2 / mpmath.pi)
    z = Symbol("z")
    sine = sum((-1) ** (k % 2) * z ** (k - 1) / sympy.factorial(2 * k + 1) for k in range(1, 8))
    cosine = sum((-1) ** (k % 2) * z ** (k - 2) / sympy.factorial(2 * k) for k in range(2, 9))
    return template("sine_cosine.c.in").substitute(
        quarter_turns=repr(quarter_turns),
        part0=repr(parts[0]), part1=repr(parts[1]), part2=repr(parts[2]),
        sine=_horner(sine, z), cosine=_horner(cosine, z),
    )  # fmt: skip


def power_of_two() -> str:
    """Return the C function for 2 to a power: whole numbers in the exponent's bits, a polynomial between.

    The polynomial of degree 11 interpolates in Chebyshev's points, and is off by 2e-17 within ±1/2.
    """
    with mpmath.workprec(200):
        coefficients = mpmath.chebyfit(lambda r: mpmath.mpf(2) ** r, [-0.5, 0.5], 12)
    return template("power_of_two.c.in").substitute(power=_nested([float(c) for c in coefficients], "r"))


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
