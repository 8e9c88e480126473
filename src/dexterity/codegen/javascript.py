"""JavaScript modules of exact indices."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Mapping

from dexterity import checks
from dexterity.codegen.heading import heading
from dexterity.codegen.printing import JAVASCRIPT, template
from dexterity.derivation import Derivation
from dexterity.elimination import LAGUERRE_STEPS, LAGUERRE_TOLERANCE, laguerre_step
from dexterity.program import Program

__all__ = ["assembled", "function", "javascript_module", "literal"]


@checks.arguments(derivation=checks.Instance(Derivation))
def javascript_module(derivation: Derivation) -> str:
    """Return an ECMAScript module that exports ``value(q)`` and a description, ``about``.

    Raises
    ------
    ValueError
        If the chain has lengths without a value, or the index is zero everywhere or has no JavaScript form.
    """
    derivation.require_computable()
    if derivation.kind == "closed":
        computation = function("ofAngles", derivation.value)
    elif derivation.kind == "spectral":
        computation = template("spectral.js.in").substitute(
            steps=LAGUERRE_STEPS,
            tolerance=LAGUERRE_TOLERANCE,
            bidiagonal=function("bidiagonal", derivation.bidiagonal_with_sum),
            step=function("laguerreStep", laguerre_step(derivation.size)),
            combination=function("combination", derivation.combination),
        )
    else:
        raise ValueError(f"{derivation.not_recorded}. It has no JavaScript form")
    turning = [kind == "revolute" for kind in derivation.chain.kinds]
    computation = template("turned.js.in").substitute(turning=literal(turning)) + computation
    about = {
        "chain": derivation.chain.name,
        "index": derivation.index.name,
        "frame": derivation.index.frame,
        "joints": derivation.chain.joint_names,
        "matters": derivation.matters,
    }
    return assembled(heading(derivation), about, derivation.chain.joints, computation)


def assembled(lines: Iterable[str], about: Mapping[str, object], joints: int, computation: str) -> str:
    """Return a module from its heading, its description, and code that defines ``compute(q)``, an array."""
    return template("module.js.in").substitute(
        heading="\n".join(f"// {line}".rstrip() for line in lines),
        about=literal(about),
        joints=joints,
        computation=computation,
    )


def literal(value: object) -> str:
    """Return what JSON can say as an expression of ECMAScript that is also safe within a page.

    Raises
    ------
    ValueError
        If a number is not finite.
    """
    text = json.dumps(value, ensure_ascii=False, indent=2, allow_nan=False)
    # No end of a script; and a key of this name would set a prototype, unless it is computed. Within a string
    # the quotation mark in front of it would be escaped.
    return re.sub(r'(?<!\\)"__proto__":', '["__proto__"]:', text.replace("<", "\\u003c"))


def function(name: str, program: Program) -> str:
    """Return a function of an array that runs a program and returns an array."""
    statements = [
        *(f"const {q} = input[{program.inputs.index(q)}];" for q in program.used_inputs),
        *(f"const {symbol} = {JAVASCRIPT.doprint(expression)};" for symbol, expression in program.steps),
        f"return [{', '.join(JAVASCRIPT.doprint(output) for output in program.outputs)}];",
    ]
    body = "\n".join(f"  {statement}" for statement in statements)
    return f"function {name}(input) {{\n{body}\n}}\n"
