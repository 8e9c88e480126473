"""ECMAScript modules of any straight-line programs: each program becomes one exported function of numbers.

A :class:`dexterity.program.Program` can be used in a page or in node this way, without a second copy of its
formulas.

Examples
--------
>>> import sympy
>>> from dexterity.codegen.ecmascript import Exported, program_module
>>> from dexterity.program import Recorder
>>> x, y = sympy.symbols("x y", real=True)
>>> record = Recorder()
>>> program = record.program((x, y), [sympy.sqrt(x**2 + y**2)])
>>> distance = Exported(program, (), "Distance from the origin [m].")
>>> source = program_module(["A length."], {}, {"distance": distance})
>>> "export function distance(input)" in source
True
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from math import prod

from dexterity import checks
from dexterity.codegen.heading import printable
from dexterity.codegen.javascript import function, literal
from dexterity.codegen.names import require_javascript_name
from dexterity.codegen.printing import template
from dexterity.program import Program

__all__ = ["Exported", "exports", "program_module"]


@dataclass(frozen=True)
class Exported:
    """A program as an exported function.

    Attributes
    ----------
    program
        What is computed. The function takes its inputs as an array, which may be nested.
    shape
        Of the nested arrays that are returned, row by row; a plain number for ``()``.
    says
        What the function takes and returns, with units.
    """

    program: Program
    shape: tuple[int, ...]
    says: str


@checks.arguments(
    lines=checks.Each(checks.Instance(str)),
    about=checks.Instance(Mapping),
    functions=checks.Named(checks.Instance(Exported)),
    code=checks.Instance(str),
)
def program_module(
    lines: Iterable[str], about: Mapping[str, object], functions: Mapping[str, Exported], code: str = ""
) -> str:
    """Return an ECMAScript module that exports functions of arrays of finite numbers, and ``about``.

    Parameters
    ----------
    lines
        What the module is, for its head.
    about
        What it exports as its description, in what JSON can say.
    functions
        Programs by the names of their functions.
    code
        Further ECMAScript code, which may call the functions.

    Raises
    ------
    ValueError
        If a name is no name in ECMAScript, or a shape does not hold as many numbers as a program returns.
    """
    printed = "\n".join(exports(name, exported) for name, exported in functions.items())
    return assembled_module(lines, about, printed, code)


def assembled_module(
    lines: Iterable[str], about: Mapping[str, object], functions: str, code: str = ""
) -> str:
    """Return a module from its head, its description, and functions that are printed already."""
    return template("programs.js.in").substitute(
        heading="\n".join(f"// {line}".rstrip() for line in printable(lines)),
        about=literal(about),
        functions=functions,
        code=code,
    )


@checks.arguments(exported=checks.Instance(Exported))
def exports(name: str, exported: Exported) -> str:
    """Return one exported function; it needs what the module of :func:`program_module` defines."""
    require_javascript_name(name)
    outputs = len(exported.program.outputs)
    if prod(exported.shape) != outputs:
        raise ValueError(f"{name} has the shape {exported.shape}, and its program has {outputs} outputs")
    comment = "\n".join(f"// {line}" for line in printable([exported.says]))
    compute = function(f"compute_{name}", exported.program)
    count = len(exported.program.inputs)
    return (
        f"{compute}\n{comment}\nexport function {name}(input) {{\n"
        f"  return shaped(compute_{name}(numbers(input, {count})), {list(exported.shape)});\n}}\n"
    )
