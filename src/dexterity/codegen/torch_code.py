"""Programs as functions of torch tensors."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeAlias

import sympy
import torch
from sympy import Expr
from sympy.printing.pytorch import TorchPrinter
from torch import Tensor

from dexterity.program import Program

__all__ = ["TensorFunction", "torch_function"]

TensorFunction: TypeAlias = Callable[[Sequence[Tensor]], list[Tensor]]
"""Takes one tensor for each input of a program, all of one shape, and returns one for each output."""


def torch_function(program: Program, inductor: bool = False) -> TensorFunction:
    """Turn a program into a function that runs its steps on tensors of any one shape.

    Parameters
    ----------
    program
        Program to run.
    inductor
        Whether ``torch.compile`` fuses the steps, at the first call and for all shapes.
    """
    used = [program.inputs.index(symbol) for symbol in program.used_inputs]
    compute = sympy.lambdify(
        program.used_inputs,
        program.outputs,
        modules=[{"copysign": _copysign, "select": _select}, torch],
        printer=_Printer({"fully_qualified_modules": False}),
        cse=lambda _: (list(program.steps), list(program.outputs)),
    )
    if inductor:
        compute = torch.compile(compute, dynamic=True, fullgraph=True)

    def run(inputs: Sequence[Tensor]) -> list[Tensor]:
        outputs = compute(*(inputs[i] for i in used))
        return [x if isinstance(x, Tensor) else torch.full_like(inputs[0], x) for x in outputs]

    return run


class _Printer(TorchPrinter):  # type: ignore[misc]
    """Numbers with all their digits; sympy prints fifteen."""

    def _print_Float(self, number: Expr) -> str:
        return repr(float(number))

    def _print_copysign(self, expression: Expr) -> str:
        return f"copysign({', '.join(map(self._print, expression.args))})"

    def _print_select(self, expression: Expr) -> str:
        return f"select({', '.join(map(self._print, expression.args))})"

    def _print_Infinity(self, _: Expr) -> str:
        return "inf"

    def _print_NegativeInfinity(self, _: Expr) -> str:
        return "-inf"


def _copysign(magnitude: Tensor | float, sign: Tensor) -> Tensor:
    return torch.where(sign < 0, -1.0, 1.0) * magnitude


def _select(decides: Tensor, positive: Tensor | float, otherwise: Tensor | float) -> Tensor:
    one, other = (
        torch.as_tensor(x, dtype=decides.dtype, device=decides.device) for x in (positive, otherwise)
    )
    return torch.where(decides > 0, one, other)
