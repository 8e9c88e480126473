"""Angles within one turn: which values of a program are used as angles only, and by how much they may change.

A revolute joint's value may be large, and so may a sum of several. Sines and cosines keep their digits if
each value is brought into one turn before it is added. What depends on the value itself, such as a distance
to a joint limit, must still see the value as it is.

Examples
--------
>>> import sympy
>>> from dexterity.codegen.angles import with_angles_apart
>>> from dexterity.program import Recorder
>>> a, b = sympy.symbols("a b", real=True)
>>> record = Recorder("t")
>>> program = record.program((a, b), [record(sympy.sin(record(a + b))), record((1 - b) * a)])
>>> apart = with_angles_apart(program, [True, True])
>>> apart.inputs
(angle_a, angle_b, a, b)
>>> apart.steps
((angle_t0, angle_a + angle_b), (t1, sin(angle_t0)), (t2, a*(1 - b)))
"""

from __future__ import annotations

from collections.abc import Sequence

import sympy
from sympy import Expr, Symbol

from dexterity.program import Program

__all__ = ["needs_values", "with_angles_apart"]


def with_angles_apart(program: Program, turning: Sequence[bool]) -> Program:
    """Return a program that takes two values of each joint: one within a turn, and the value itself.

    Parameters
    ----------
    program
        Program whose first inputs are the joint values.
    turning
        Whether each joint is revolute; for as many inputs as there are joints.

    Returns
    -------
    Program with inputs ``angle_q`` for each joint q, then the inputs of `program`. Sines and cosines of
    joint values, and of sums of them, take the first; all else takes the second.
    """
    joints = program.inputs[: len(turning)]
    angles = {q: Symbol(f"angle_{q}", real=True) for q in joints}
    periodic = {q for q, turns in zip(joints, turning, strict=True) if turns}
    for symbol, expression in program.steps:
        if _is_sum_of(expression, periodic):
            angles[symbol] = Symbol(f"angle_{symbol}", real=True)
            periodic.add(symbol)

    steps: list[tuple[Symbol, Expr]] = []
    for symbol, expression in program.steps:
        if symbol in periodic:
            steps.append((angles[symbol], expression.xreplace(angles)))
        if isinstance(expression, sympy.sin | sympy.cos) and _is_sum_of(expression.args[0], periodic):
            expression = expression.xreplace(angles)
        steps.append((symbol, expression))
    doubled = Program((*(angles[q] for q in joints), *program.inputs), tuple(steps), ())
    return doubled.leading_to(program.outputs)


def needs_values(program: Program, turning: Sequence[bool]) -> bool:
    """Whether a program uses a revolute joint's value other than as an angle."""
    joints = program.inputs[: len(turning)]
    used = with_angles_apart(program, turning).used_inputs
    return any(turns and q in used for q, turns in zip(joints, turning, strict=True))


def _is_sum_of(expression: Expr, symbols: set[Symbol]) -> bool:
    """Whether an expression is a sum of whole multiples of symbols, which have the period of an angle."""
    coefficients = expression.as_coefficients_dict()
    return all(
        (term == 1 and coefficient == 0) or (term in symbols and coefficient.is_Integer)
        for term, coefficient in coefficients.items()
    )
