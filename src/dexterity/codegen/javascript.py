"""JavaScript modules of exact indices."""

from __future__ import annotations

import json

from dexterity.codegen.heading import heading
from dexterity.codegen.printing import JAVASCRIPT, template
from dexterity.derivation import Derivation
from dexterity.elimination import LAGUERRE_STEPS, LAGUERRE_TOLERANCE, laguerre_step
from dexterity.program import Program

__all__ = ["javascript_module"]


def javascript_module(derivation: Derivation) -> str:
    """Return an ECMAScript module that exports ``value(q)`` and a description, ``about``.

    Raises
    ------
    ValueError
        If the chain has lengths without a value, or fewer than six joints.
    """
    derivation.chain.require_computable(derivation.index.name)
    if derivation.index.name == "manipulability":
        computation = _function("compute", derivation.manipulability)
    else:
        computation = template("conditioning.js.in").substitute(
            steps=LAGUERRE_STEPS,
            tolerance=LAGUERRE_TOLERANCE,
            bidiagonal=_function("bidiagonal", derivation.bidiagonal),
            step=_function("laguerreStep", laguerre_step(6)),
        )
    about = {
        "chain": derivation.chain.name,
        "index": derivation.index.name,
        "frame": derivation.index.frame,
        "joints": derivation.chain.joint_names,
        "matters": derivation.matters,
    }
    return template("module.js.in").substitute(
        heading="\n".join(f"// {line}".rstrip() for line in heading(derivation)),
        about=json.dumps(about, ensure_ascii=False, indent=2),
        joints=derivation.chain.joints,
        computation=computation,
    )


def _function(name: str, program: Program) -> str:
    statements = [
        *(f"const {q} = input[{program.inputs.index(q)}];" for q in program.used_inputs),
        *(f"const {symbol} = {JAVASCRIPT.doprint(expression)};" for symbol, expression in program.steps),
        f"return [{', '.join(JAVASCRIPT.doprint(output) for output in program.outputs)}];",
    ]
    body = "\n".join(f"  {statement}" for statement in statements)
    return f"function {name}(input) {{\n{body}\n}}\n"
