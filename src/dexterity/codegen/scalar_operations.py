"""Operations of torch on tensors as scalar operations on a tape.

Tensors are given as tensors of the same shape that hold places on the tape.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Sequence
from typing import Any

import torch
from torch import Tensor

from dexterity.codegen.tape import Tape

__all__ = ["Operations"]

_ELEMENTWISE = {
    "mul": "mul", "div": "div", "remainder": "remainder", "atan2": "atan2", "hypot": "hypot",
    "minimum": "min", "maximum": "max", "clamp_min": "max", "clamp_max": "min", "eq": "eq", "ne": "ne",
    "lt": "lt", "le": "le", "gt": "gt", "ge": "ge", "logical_and": "and", "logical_or": "or",
    "logical_not": "not", "bitwise_and": "and", "bitwise_or": "or", "bitwise_not": "not", "where": "where",
    "neg": "neg", "abs": "abs", "sign": "sign", "sgn": "sign", "floor": "floor", "round": "round",
    "sqrt": "sqrt", "exp": "exp", "tanh": "tanh", "sin": "sin", "cos": "cos", "acos": "acos",
}  # fmt: skip
_FOLDS = {"sum": "add", "prod": "mul", "amax": "max", "amin": "min", "any": "or", "all": "and"}
_MOVES = ("clone", "repeat", "flip", "roll", "diagonal_copy", "_unsafe_view", "lift_fresh", "alias_copy")
_CONSTANT = (
    "zeros_like", "ones_like", "full_like", "empty_like", "new_zeros", "new_ones", "new_full", "new_empty",
    "new_empty_strided", "eye",
)  # fmt: skip


class Operations:
    """Operations of torch by their name.

    Parameters
    ----------
    tape
        Where they are written down.
    read
        Returns the places of a tensor's elements.
    looked_at
        Returns a tensor after noting that its numbers are used as numbers.
    """

    def __init__(
        self, tape: Tape, read: Callable[[Tensor], Tensor], looked_at: Callable[[Tensor], Tensor]
    ) -> None:
        self._tape, self._read, self._looked_at = tape, read, looked_at

    def ignores(self, name: str) -> bool:
        """Whether an operation returns constants, whatever it is given."""
        return name in _CONSTANT

    def __call__(self, name: str, args: tuple[Any, ...], kwargs: dict[str, Any]) -> Tensor:
        """Return the places of the first result of an operation.

        Raises
        ------
        NotImplementedError
            If it is not known.
        """
        if name in _ELEMENTWISE:
            return self._each(_ELEMENTWISE[name], *args)
        if name in _FOLDS:
            return self._fold(_FOLDS[name], *args, **kwargs)
        if name in _MOVES:
            return self._moved(name, *args, **kwargs)
        method = getattr(self, f"_op_{name.strip('_')}", None)
        if method is None:
            raise NotImplementedError(f"torch's {name} cannot be recorded")
        places: Tensor = method(*args, **kwargs)
        return places

    def _of(self, part: Any) -> Tensor:
        return self._read(part) if isinstance(part, Tensor) else torch.tensor(self._tape.constant(part))

    def _each(self, name: str, *parts: Any) -> Tensor:
        """Apply an operator element by element, shapes broadcast."""
        places = torch.broadcast_tensors(*(self._of(part) for part in parts))
        return self._applied(name, *places)

    def _applied(self, name: str, *places: Tensor) -> Tensor:
        rows = zip(*(each.flatten().tolist() for each in places), strict=True)
        done = [self._tape.apply(name, *row) for row in rows]
        return torch.tensor(done, dtype=torch.long).reshape(places[0].shape)

    def _numbers(self, part: Tensor) -> Tensor:
        """Places of a tensor that is reckoned with; truth values count as 0 and 1."""
        return self._applied("number", self._read(part)) if part.dtype == torch.bool else self._read(part)

    # ---- sums and other folds ----

    def _fold(
        self, name: str, part: Tensor, dim: int | Sequence[int] | None = None, keepdim: bool = False, **_: Any
    ) -> Tensor:
        """Fold axes, all of them if none is named, one element after the other."""
        places = self._read(part) if name in ("and", "or") else self._numbers(part)
        return self._folded(name, places, dim, keepdim)

    def _folded(self, name: str, places: Tensor, dim: Any, keepdim: bool) -> Tensor:
        axes = [dim] if isinstance(dim, int) else list(dim or range(places.ndim))
        axes = [axis % places.ndim for axis in axes]
        kept = [axis for axis in range(places.ndim) if axis not in axes]
        rows = places.permute([*kept, *axes]).reshape(*(places.shape[axis] for axis in kept), -1)
        done = functools.reduce(lambda so_far, column: self._applied(name, so_far, column), rows.unbind(-1))
        return done.reshape([1 if i in axes else n for i, n in enumerate(places.shape)]) if keepdim else done

    def _op_mean(self, part: Tensor, dim: Any = None, keepdim: bool = False, **_: Any) -> Tensor:
        total = self._fold("add", part, dim, keepdim)
        count = self._tape.constant(float(part.numel() // max(total.numel(), 1)))
        return self._applied("div", total, torch.full_like(total, count))

    def _op_linalg_vector_norm(
        self, part: Tensor, order: float = 2, dim: Any = None, keepdim: bool = False, **_: Any
    ) -> Tensor:
        if order != 2:
            raise NotImplementedError(f"a norm of order {order} cannot be recorded")
        squares = self._each("mul", part, part)
        return self._applied("sqrt", self._folded("add", squares, dim, keepdim))

    def _op_max(self, part: Tensor) -> Tensor:
        return self._fold("max", part)

    def _op_min(self, part: Tensor) -> Tensor:
        return self._fold("min", part)

    # ---- element by element ----

    def _op_add(self, one: Any, other: Any, alpha: float = 1) -> Tensor:
        return self._each("add", one, other) if alpha == 1 else self._scaled("add", one, other, alpha)

    def _op_sub(self, one: Any, other: Any, alpha: float = 1) -> Tensor:
        return self._each("sub", one, other) if alpha == 1 else self._scaled("sub", one, other, alpha)

    def _op_rsub(self, one: Any, other: Any, alpha: float = 1) -> Tensor:
        return self._op_sub(other, one, alpha)

    def _scaled(self, name: str, one: Any, other: Any, alpha: float) -> Tensor:
        return self._applied(name, *torch.broadcast_tensors(self._of(one), self._each("mul", other, alpha)))

    def _op_pow(self, base: Any, exponent: Any) -> Tensor:
        if isinstance(exponent, Tensor) or not isinstance(base, Tensor):
            return self._each("pow", base, exponent)
        if exponent == 2:
            return self._each("mul", base, base)
        return self._each("sqrt", base) if exponent == 0.5 else self._each("pow", base, exponent)

    def _op_reciprocal(self, part: Tensor) -> Tensor:
        return self._each("div", 1.0, part)

    def _op_isnan(self, part: Tensor) -> Tensor:
        return self._each("ne", part, part)

    def _op_nan_to_num(self, part: Tensor, nan: float | None = None, *_: Any, **__: Any) -> Tensor:
        places = self._read(part)
        zero = torch.full_like(places, self._tape.constant(nan or 0.0))
        return self._applied("where", self._applied("ne", places, places), zero, places)

    def _op_clamp(self, part: Tensor, lower: Any = None, upper: Any = None) -> Tensor:
        places = self._of(part)
        for name, limit in (("max", lower), ("min", upper)):
            if limit is not None:
                places = self._applied(name, *torch.broadcast_tensors(places, self._of(limit)))
        return places

    def _op_masked_fill(self, part: Tensor, mask: Tensor, value: Any) -> Tensor:
        return self._each("where", mask, value, part)

    def _op_to_copy(self, part: Tensor, dtype: torch.dtype | None = None, **_: Any) -> Tensor:
        if dtype is not None and part.is_floating_point() and not dtype.is_floating_point:
            raise NotImplementedError(f"a conversion from {part.dtype} to {dtype} cannot be recorded")
        return self._read(part) if dtype in (None, torch.bool) else self._numbers(part)

    # ---- places moved ----

    def _moved(self, name: str, part: Tensor, *args: Any, **_: Any) -> Tensor:
        """Move places as elements are moved; layouts in memory, which keywords name, do not matter."""
        places: Tensor = getattr(torch.ops.aten, name)(self._read(part), *args)
        return places

    def _op_copy(self, part: Tensor, source: Tensor, *_: Any) -> Tensor:
        return self._op_to_copy(source, part.dtype)

    def _op_fill(self, _: Tensor, value: Any) -> Tensor:
        return self._of(value)

    def _op_zero(self, _: Tensor) -> Tensor:
        return self._of(0.0)

    def _op_cat(self, parts: Sequence[Tensor], dim: int = 0) -> Tensor:
        return torch.cat([self._read(part) for part in parts], dim)

    def _op_stack(self, parts: Sequence[Tensor], dim: int = 0) -> Tensor:
        return torch.stack([self._read(part) for part in parts], dim)

    def _op_index(self, part: Tensor, indices: Sequence[Tensor | None]) -> Tensor:
        chosen = [None if index is None else self._looked_at(index) for index in indices]
        places: Tensor = torch.ops.aten.index(self._read(part), chosen)
        return places

    def _op_index_put(
        self, part: Tensor, indices: Sequence[Tensor | None], values: Tensor, accumulate: bool = False
    ) -> Tensor:
        if accumulate:
            raise NotImplementedError("an index_put that adds cannot be recorded")
        chosen = [None if index is None else self._looked_at(index) for index in indices]
        places: Tensor = torch.ops.aten.index_put(self._read(part).clone(), chosen, self._read(values))
        return places

    def _op_nonzero(self, part: Tensor) -> Tensor:
        return self._read(self._looked_at(part).nonzero())

    def _op_repeat_interleave(self, part: Tensor, *args: Any, **kwargs: Any) -> Tensor:
        return torch.repeat_interleave(self._read(part), *args, **kwargs)

    def _op_index_select(self, part: Tensor, dim: int, index: Tensor) -> Tensor:
        return self._read(part).index_select(dim, self._looked_at(index))

    def _op_constant_pad_nd(self, part: Tensor, pad: list[int], value: float = 0.0) -> Tensor:
        return torch.constant_pad_nd(self._read(part), pad, self._tape.constant(float(value)))

    def _op_select_backward(self, part: Tensor, sizes: list[int], dim: int, index: int) -> Tensor:
        whole = torch.full(sizes, self._tape.constant(0.0))
        whole.select(dim, index).copy_(self._read(part))
        return whole

    def _op_slice_backward(
        self, part: Tensor, sizes: list[int], dim: int, start: int, end: int, step: int
    ) -> Tensor:
        whole = torch.full(sizes, self._tape.constant(0.0))
        torch.ops.aten.slice(whole, dim, start, end, step).copy_(self._read(part))
        return whole

    # ---- matrices ----

    def _op_mm(self, one: Tensor, other: Tensor) -> Tensor:
        left, right = self._read(one), self._read(other)
        products = self._applied("mul", *torch.broadcast_tensors(left[..., None], right[..., None, :, :]))
        return self._folded("add", products, -2, keepdim=False)

    _op_bmm = _op_mm

    def _op_mv(self, one: Tensor, other: Tensor) -> Tensor:
        return self._folded("add", self._each("mul", one, other), -1, keepdim=False)

    _op_dot = _op_mv

    def _op_addmm(
        self, bias: Tensor, one: Tensor, other: Tensor, beta: float = 1, alpha: float = 1
    ) -> Tensor:
        if (beta, alpha) != (1, 1):
            raise NotImplementedError(f"addmm with beta {beta} and alpha {alpha} cannot be recorded")
        product = self._op_mm(one, other)
        return self._applied("add", product, self._read(bias).expand(product.shape))

    def _op_linalg_solve_ex(self, matrix: Tensor, right: Tensor, left: bool = True, **_: Any) -> Tensor:
        if not left or right.ndim != matrix.ndim:
            raise NotImplementedError("only the solution X of A X = B with matrices can be recorded")
        batch, size, places = matrix.shape[:-2], matrix.shape[-1], []
        rows = zip(
            self._read(matrix).reshape(-1, size * size).tolist(),
            self._read(right).reshape(-1, size * right.shape[-1]).tolist(),
            strict=True,
        )
        for one, other in rows:
            places += self._tape.solve(one, other, size)
        return torch.tensor(places).reshape(*batch, size, right.shape[-1])
