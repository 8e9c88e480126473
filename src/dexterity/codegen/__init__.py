"""Code to take on board, generated from derivations: C99 with a header, JavaScript and torch.

Examples
--------
>>> import dexterity as dx
>>> derivation = dx.symbolic.derive(dx.robots.puma560(), dx.Index("manipulability"))
>>> sorted(dx.codegen.c_files(derivation, name="puma_w"))
['puma_w.c', 'puma_w.h']
"""

from typing import TYPE_CHECKING

from dexterity import lazy
from dexterity.codegen.c99 import c_source
from dexterity.codegen.javascript import javascript_module
from dexterity.codegen.library import CompilationFailed
from dexterity.codegen.on_board import c_files, write_c

if TYPE_CHECKING:
    from dexterity.codegen import ecmascript, pose, recorded_functions, recording, tape

__all__ = [
    "CompilationFailed",
    "c_files",
    "c_source",
    "ecmascript",
    "javascript_module",
    "pose",
    "recorded_functions",
    "recording",
    "tape",
    "write_c",
]

# Hidden from type checkers, for whom every name would otherwise be a module.
if not TYPE_CHECKING:
    __getattr__, __dir__ = lazy.submodules(__name__, __all__)
