"""Names in generated code: what a caller may choose, and what a file calls itself if no name is chosen.

All that a C file defines at file scope begins with its name, so that files of several indices can be linked
together or included in one another.

Examples
--------
>>> from dexterity.codegen import names
>>> names.words("Panda, left arm", "manipulability")
'panda_left_arm_manipulability'
>>> names.require_c_name("sqrt")
Traceback (most recent call last):
    ...
ValueError: name is 'sqrt', which libraries of C use themselves; choose another, such as 'sqrt_index'
"""

from __future__ import annotations

import re
from importlib.resources import files

from dexterity import checks

__all__ = ["require_c_name", "require_javascript_name", "words"]

_LONGEST = 80
"""Letters of a text within a name; compilers distinguish names by some hundred letters."""


def words(*texts: str) -> str:
    """Return texts as one name: their ASCII letters and digits in lower case, underscores between them."""
    parts = (re.sub(r"[^a-z0-9]+", "_", text.lower()).strip("_")[:_LONGEST] for text in texts)
    name = "_".join(part for part in parts if part)
    return name if name[:1].isalpha() else f"chain_{name}"


def require_c_name(name: str) -> str:
    """Return a name if C and C++ files can use it for their functions.

    Raises
    ------
    TypeError
        If the name is no text.
    ValueError
        If it has other characters than ASCII letters, digits and underscores, does not begin with a letter,
        or is a word of C or C++ or of their libraries.
    """
    checks.identifier(name, "name")
    if name in _C:
        raise ValueError(
            f"name is {name!r}, which libraries of C use themselves; choose another, such as '{name}_index'"
        )
    return name


def require_javascript_name(name: str) -> str:
    """Return a name if an ECMAScript module can export a function under it.

    Raises
    ------
    TypeError
        If the name is no text.
    ValueError
        If it has other characters than ASCII letters, digits and underscores, does not begin with a letter,
        or is a word of the language or of the module's own code.
    """
    checks.identifier(name, "name")
    if name in _JAVASCRIPT:
        raise ValueError(
            f"name is {name!r}, which the module uses itself; choose another, such as '{name}_of_q'"
        )
    return name


def _names(file: str) -> frozenset[str]:
    lines = files("dexterity.codegen").joinpath("templates", file).read_text(encoding="utf-8").splitlines()
    return frozenset(" ".join(line for line in lines if not line.startswith("#")).split())


_C = _names("names_of_c.in")
_JAVASCRIPT = _names("names_of_javascript.in")
