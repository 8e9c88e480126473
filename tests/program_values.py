"""Programs run by numpy, so that what they compute can be compared with what numpy computes otherwise."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache

import numpy as np
import sympy
from numpy.typing import ArrayLike, NDArray
from sympy import Symbol

from dexterity.program import Program


def values_of(program: Program, inputs: Mapping[Symbol, ArrayLike]) -> NDArray[np.float64]:
    """Outputs (..., outputs) of a program from inputs (...) by symbol; lengths may be among them."""
    arrays = np.broadcast_arrays(*(np.asarray(value, dtype=float) for value in inputs.values()))
    outputs = _numpy_function(program, tuple(inputs))(*arrays)
    return np.stack([np.broadcast_to(np.asarray(x, dtype=float), arrays[0].shape) for x in outputs], axis=-1)


@cache
def _numpy_function(program: Program, symbols: tuple[Symbol, ...]) -> Callable[..., list[ArrayLike]]:
    return sympy.lambdify(
        symbols,
        program.outputs,
        modules=[{"copysign": np.copysign}, "numpy"],
        cse=lambda _: (list(program.steps), list(program.outputs)),
    )
