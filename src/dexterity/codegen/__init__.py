"""Code generated from derivations: C99, JavaScript and torch."""

from dexterity.codegen.c99 import c_source
from dexterity.codegen.javascript import javascript_module
from dexterity.codegen.library import CompilationFailed

__all__ = ["CompilationFailed", "c_source", "javascript_module"]
