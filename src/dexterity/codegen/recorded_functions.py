"""Recorded functions of torch printed as an ECMAScript module.

Examples
--------
>>> import torch
>>> from dexterity.codegen.recorded_functions import Recorded, recorded_module
>>> from dexterity.codegen.recording import record
>>> norm = record(lambda x: torch.hypot(x[0], x[1])[None], torch.tensor([3.0, 4.0]).double())
>>> source = recorded_module(["A length."], {}, {"norm": Recorded(norm, "Of two numbers.")})
>>> "export function norm" in source
True
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from dexterity import checks
from dexterity.codegen.ecmascript import assembled_module
from dexterity.codegen.heading import printable
from dexterity.codegen.names import require_javascript_name
from dexterity.codegen.printing import template
from dexterity.codegen.tape import ELEMENT, INPUT, SOLVE, Number, Recording

__all__ = ["Recorded", "recorded_module"]


@dataclass(frozen=True)
class Recorded:
    """A recording as a function that a module exports.

    Attributes
    ----------
    recording
        What is computed. The function takes its inputs as an array, which may be nested, and returns nested
        arrays of the recorded result's shape.
    says
        What the function takes and returns, with units.
    """

    recording: Recording
    says: str


@checks.arguments(
    lines=checks.Each(checks.Instance(str)),
    about=checks.Instance(Mapping),
    functions=checks.Named(checks.Instance(Recorded)),
    code=checks.Instance(str),
)
def recorded_module(
    lines: Iterable[str], about: Mapping[str, object], functions: Mapping[str, Recorded], code: str = ""
) -> str:
    """Return an ECMAScript module that exports functions of arrays of finite numbers, and ``about``.

    A function throws a RangeError where the recorded conditions do not hold. Within the module
    ``compute_name(numbers)`` does the same on plain arrays, and returns undefined there.

    Parameters
    ----------
    lines
        What the module is, for its head.
    about
        What it exports as its description, in what JSON can say.
    functions
        Recordings by the names of their functions.
    code
        Further ECMAScript code, which may call the functions.

    Raises
    ------
    ValueError
        If a name is no name in ECMAScript.
    """
    printed = "\n".join(_exported(name, function) for name, function in functions.items())
    return assembled_module(lines, about, template("recorded.js.in").substitute(functions=printed), code)


_FORMS: Mapping[str, str] = {
    "add": "({} + {})", "sub": "({} - {})", "mul": "({} * {})", "div": "({} / {})", "pow": "({} ** {})",
    "neg": "(-{})", "eq": "({} === {})", "ne": "({} !== {})", "lt": "({} < {})", "le": "({} <= {})",
    "gt": "({} > {})", "ge": "({} >= {})", "and": "({} && {})", "or": "({} || {})", "not": "(!{})",
    "where": "({} ? {} : {})", "number": "Number({})", "round": "rounded({})",
    "remainder": "remainder({}, {})",
    **{
        name: f"Math.{name}({{}})"
        for name in ("abs", "sign", "floor", "sqrt", "exp", "tanh", "sin", "cos", "acos")
    },
    **{name: f"Math.{name}({{}}, {{}})" for name in ("atan2", "hypot", "min", "max")},
}  # fmt: skip
_LONGEST = 120  # characters of an expression that is put where it is used


def _exported(name: str, function: Recorded) -> str:
    require_javascript_name(name)
    recording = function.recording
    comment = "\n".join(f"// {line}" for line in printable([function.says]))
    return (
        f"function compute_{name}(input) {{\n{_body(recording)}}}\n\n"
        f"{comment}\nexport function {name}(input) {{\n"
        f"  const values = compute_{name}(numbers(input, {recording.inputs}));\n"
        f"  if (values === undefined) {{\n"
        f'    throw new RangeError("input is beyond where {name} is defined");\n'
        f"  }}\n  return shaped(values, {list(recording.shape)});\n}}\n"
    )


def _body(recording: Recording) -> str:
    """Statements of a recording's operations, those that are used once put where they are used."""
    rows, wanted = recording.tape.rows, [place for place, _ in recording.conditions]
    uses, needed = Counter(wanted) + Counter(recording.outputs), set()
    for place in range(len(rows) - 1, -1, -1):
        if uses[place]:
            needed.add(place)
            uses.update(_arguments(rows[place]))
    texts: dict[int, str] = {}
    lines = []
    for place in sorted(needed):
        text, inline = _text(rows[place], texts)
        if inline or (uses[place] == 1 and len(text) <= _LONGEST):
            texts[place] = text
        else:
            texts[place] = f"x{place}"
            lines.append(f"  const x{place} = {text};\n")
    conditions = [_condition(texts[place], value) for place, value in recording.conditions]
    if conditions:
        # Errors come first in the recorded function; what was computed in spite of them does no harm.
        lines.append(f"  if (!({' && '.join(conditions)})) {{\n    return undefined;\n  }}\n")
    return "".join(lines) + f"  return [{', '.join(texts[place] for place in recording.outputs)}];\n"


def _arguments(row: tuple[object, ...]) -> list[int]:
    name, *arguments = row
    if name in (None, INPUT):
        return []
    return arguments[1:] if name == SOLVE else arguments[:1] if name == ELEMENT else arguments  # type: ignore[return-value]


def _text(row: tuple[object, ...], texts: Mapping[int, str]) -> tuple[str, bool]:
    """Expression of a place, and whether it is as short as a name."""
    name, *arguments = row
    if name is None:
        return _literal(arguments[0]), True  # type: ignore[arg-type]
    if name == INPUT:
        return f"input[{arguments[0]}]", True
    own = [texts[place] for place in _arguments(row)]
    if name == SOLVE:
        return f"solve({arguments[0]}, [{', '.join(own)}])", False
    if name == ELEMENT:
        return f"{own[0]}[{arguments[1]}]", True
    return _FORMS[str(name)].format(*own), False


def _literal(value: Number) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if math.isnan(value):
        return "NaN"
    text = "Infinity" if math.isinf(value) else repr(abs(value))
    return f"(-{text})" if math.copysign(1, value) < 0 else text


def _condition(text: str, value: Number) -> str:
    if isinstance(value, bool):
        return text if value else f"!{text}"
    return f"{text} === {_literal(value)}"
