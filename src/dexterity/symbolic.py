"""Exact indices compiled: the functions that :meth:`dexterity.indices.Index.bind` returns, only faster.

A chain is derived once, in sines and cosines of its joints; the derivation is printed in the language of a
backend, and comes back as a function on batches of configurations, with gradients.

Examples
--------
>>> import dexterity as dx
>>> puma, index = dx.robots.puma560(), dx.indices.Index("manipulability")
>>> w = dx.symbolic.compile_index(puma, index)
>>> value, gradient = w.value_and_gradient(q := [0.0, 0.5, 0.25, 0.0, 0.5, 0.0])
>>> gradient.shape, bool((value - index.bind(puma)(q)).abs() < 1e-12)
(torch.Size([6]), True)
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence
from functools import cached_property
from typing import Any, Literal, Protocol, TypeAlias, get_args, runtime_checkable

import torch
from jaxtyping import Float64
from torch import Tensor
from torch.autograd.function import once_differentiable

from dexterity import spatial
from dexterity.chain import Chain
from dexterity.codegen import CompilationFailed, c_source, javascript_module
from dexterity.codegen.c99 import ZERO
from dexterity.codegen.engine import InC, cached_c_source
from dexterity.codegen.torch_code import TensorFunction, torch_function
from dexterity.derivation import Derivation, SymbolicChain, derive
from dexterity.elimination import LAGUERRE_STEPS, LAGUERRE_TOLERANCE, laguerre_step
from dexterity.indices import Index
from dexterity.spatial import TensorLike

__all__ = [
    "Backend",
    "CompilationFailed",
    "CompiledIndex",
    "Derivation",
    "Engine",
    "SymbolicChain",
    "c_source",
    "cached_c_source",
    "compile_index",
    "derive",
    "javascript_module",
]

Backend: TypeAlias = Literal["torch", "inductor", "c"]
"""What computes, torch step by step, torch through ``torch.compile``, or compiled C."""


def compile_index(chain: Chain | SymbolicChain, index: Index, backend: Backend = "torch") -> CompiledIndex:
    """Return an index as a fast function of the chain's joint values.

    Parameters
    ----------
    chain
        A chain of at least six joints, all lengths numbers.
    index
        Name, frame and limits.
    backend
        ``"torch"``: needs nothing else and runs on every device. ``"inductor"``: the same through
        ``torch.compile``, which needs a C++ compiler. ``"c"``: on the CPU, fastest for one configuration
        and for many; needs a C compiler, and is compiled once for each chain, index and processor.

    Raises
    ------
    ValueError
        If the backend is unknown, the rates do not fit the chain, lengths have no value, or the chain has
        fewer than six joints, which makes either index zero everywhere.
    CompilationFailed
        If a compiler is missing or fails.
    OSError
        If the folder for compiled code cannot be written.
    """
    if backend not in get_args(Backend):
        raise ValueError(f"backend is {backend!r}; {get_args(Backend)} are known")
    chain = chain if isinstance(chain, SymbolicChain) else SymbolicChain.from_chain(chain)
    chain.require_computable(index.name)
    engine = InC(chain, index) if backend == "c" else _in_torch(derive(chain, index), backend)
    return CompiledIndex(chain, index, engine)


class CompiledIndex:
    """An index of a chain, compiled; :func:`compile_index` makes it.

    It is called as what :meth:`dexterity.indices.Index.bind` returns is, and differentiable by torch once.
    Where w is zero, its minimum, its gradient is zero or that of one side; that of KCI is zero there. Where
    the smallest or the largest singular value repeats, KCI has one-sided derivatives only, and the gradient
    lies between them.
    """

    def __init__(self, chain: SymbolicChain, index: Index, engine: Engine) -> None:
        self._chain = chain
        self._index = index
        self._engine = engine

    def __repr__(self) -> str:
        return f"CompiledIndex({self._index.name!r} of {self._chain.name!r}, {self._index.frame} frame)"

    @property
    def chain(self) -> SymbolicChain:
        """Chain that was compiled."""
        return self._chain

    @property
    def index(self) -> Index:
        """Index that was compiled."""
        return self._index

    def __call__(self, q: TensorLike) -> Float64[Tensor, "*batch"]:
        """Value of the index.

        Parameters
        ----------
        q
            (..., n) joint values, [rad] for revolute and [m] for prismatic joints.

        Raises
        ------
        ValueError
            If the last axis of `q` is not the number of joints, or `q` is not finite.
        """
        q = self._configurations(q)
        if q.requires_grad and torch.is_grad_enabled():
            return _Differentiable.apply(q, self)  # type: ignore[no-untyped-call]
        return self._engine.values(q)

    def value_and_gradient(
        self, q: TensorLike
    ) -> tuple[Float64[Tensor, "*batch"], Float64[Tensor, "*batch n"]]:
        """Value of the index and its derivatives by the joint values.

        Parameters
        ----------
        q
            (..., n) joint values, [rad] or [m].

        Returns
        -------
        Values (...) and gradients (..., n), per [rad] or [m]. Neither remembers where it came from: for
        torch's own differentiation call the index itself.

        Raises
        ------
        ValueError
            If the last axis of `q` is not the number of joints, or `q` is not finite.
        """
        q = self._configurations(q).detach()
        return self._engine.values_and_gradients(q)

    def _configurations(self, q: TensorLike) -> Tensor:
        # The engines refuse what is not finite; a look at it here would cost more than one index in C.
        if not (isinstance(q, Tensor) and q.dtype is torch.float64):
            q = spatial.to_float64(q, "q")
        return spatial.require_joints(q, self._chain.joints, "chain")


class _Differentiable(torch.autograd.Function):
    """The value with its gradient for torch's own differentiation."""

    @staticmethod
    def forward(ctx: Any, q: Tensor, index: CompiledIndex) -> Tensor:
        values, gradients = index.value_and_gradient(q)
        ctx.save_for_backward(gradients)
        return values

    @staticmethod
    @once_differentiable
    def backward(ctx: Any, weights: Tensor) -> tuple[Tensor, None]:
        (gradients,) = ctx.saved_tensors
        return weights[..., None] * gradients, None


@runtime_checkable
class Engine(Protocol):
    """What computes an index."""

    def values(self, q: Tensor) -> Tensor:
        """Values (...) of configurations (..., n)."""

    def values_and_gradients(self, q: Tensor) -> tuple[Tensor, Tensor]:
        """Values (...) and gradients (..., n) of configurations (..., n)."""


# ---- in torch --------------------------------------------------------------------------------------


def _in_torch(derivation: Derivation, backend: Backend) -> Engine:
    engines = {"manipulability": _ManipulabilityInTorch, "kinematic_conditioning": _ConditioningInTorch}
    engine = engines[derivation.index.name](derivation, inductor=backend == "inductor")
    if backend == "inductor":
        from torch._dynamo.exc import BackendCompilerFailed  # its import takes most of a second

        try:
            engine.values(torch.zeros(8, derivation.chain.joints, dtype=torch.float64))
        except BackendCompilerFailed as error:
            raise CompilationFailed(
                f"torch.compile failed, as it does without a C++ compiler ({error}); "
                'backend="torch" needs none'
            ) from error
    return engine


_PIECE = 8192  # configurations worked on at a time on the CPU: what a step reads is still in its cache


class _InTorch(ABC):
    """Runs programs on the joints' columns, on the CPU in pieces; gradients are never fused."""

    def __init__(self, derivation: Derivation, inductor: bool) -> None:
        self._derivation = derivation
        self._inductor = inductor

    def values(self, q: Tensor) -> Tensor:
        return torch.cat([self._values(columns) for columns in self._columns(q)]).reshape(q.shape[:-1])

    def values_and_gradients(self, q: Tensor) -> tuple[Tensor, Tensor]:
        pieces = [self._values_and_gradients(columns) for columns in self._columns(q)]
        values, gradients = (torch.cat(parts) for parts in zip(*pieces, strict=True))
        return values.reshape(q.shape[:-1]), gradients.reshape(q.shape)

    def _columns(self, q: Tensor) -> Iterator[tuple[Tensor, ...]]:
        rows = spatial.to_float64(q.detach(), "q").reshape(-1, q.shape[-1])
        in_pieces = rows.is_cpu and not self._inductor
        for piece in rows.split(_PIECE if in_pieces else max(len(rows), 1)):
            yield piece.T.contiguous().unbind()

    @abstractmethod
    def _values(self, columns: Sequence[Tensor]) -> Tensor:
        """Values (N,) from one column (N,) a joint."""

    @abstractmethod
    def _values_and_gradients(self, columns: Sequence[Tensor]) -> tuple[Tensor, Tensor]:
        """Values (N,) and gradients (N, n)."""


class _ManipulabilityInTorch(_InTorch):
    @cached_property
    def _value(self) -> TensorFunction:
        return torch_function(self._derivation.manipulability, self._inductor)

    @cached_property
    def _gradient(self) -> TensorFunction:
        return torch_function(self._derivation.manipulability_gradient)

    def _values(self, columns: Sequence[Tensor]) -> Tensor:
        return self._value(columns)[0]

    def _values_and_gradients(self, columns: Sequence[Tensor]) -> tuple[Tensor, Tensor]:
        value, *derivatives = self._gradient(columns)
        return value, torch.stack(derivatives, dim=-1)


class _ConditioningInTorch(_InTorch):
    @cached_property
    def _bidiagonal(self) -> TensorFunction:
        return torch_function(self._derivation.bidiagonal, self._inductor)

    @cached_property
    def _step(self) -> TensorFunction:
        return torch_function(laguerre_step(6), self._inductor)

    @cached_property
    def _triangle(self) -> TensorFunction:
        return torch_function(self._derivation.triangle)

    @cached_property
    def _gradient(self) -> TensorFunction:
        return torch_function(self._derivation.conditioning_gradient)

    def _values(self, columns: Sequence[Tensor]) -> Tensor:
        squares = self._bidiagonal(columns)
        smallest = self._extreme_root(squares, side=-1.0, start=0.0)
        largest = self._extreme_root(squares, side=1.0, start=1.0)
        return torch.where(largest > 0, smallest / largest, 0.0).sqrt()

    def _extreme_root(self, squares: Sequence[Tensor], side: float, start: float) -> Tensor:
        """Roots of the bidiagonal form's polynomial nearest to `start`, on one side of all of them."""
        y, sides = torch.full_like(squares[0], start), torch.full_like(squares[0], side)
        for _ in range(LAGUERRE_STEPS):
            (step,) = self._step([y, sides, *squares])
            y = y - step
            if not (step.abs() > LAGUERRE_TOLERANCE * y).any():
                break
        return y.clamp(min=0)

    def _values_and_gradients(self, columns: Sequence[Tensor]) -> tuple[Tensor, Tensor]:
        values = self._values(columns)
        rows, places = torch.tril_indices(6, 6, device=values.device)
        L = values.new_zeros(len(values), 6, 6)
        L[:, rows, places] = torch.stack(self._triangle(columns), dim=-1)
        vectors, sigma, _ = torch.linalg.svd(L)
        weights = torch.where(values > ZERO, values.sqrt(), 0.0)[:, None, None]
        scaled = vectors * weights / torch.where(sigma > 0, sigma, 1.0)[:, None, :]
        smallest, largest = scaled[..., -1].T, scaled[..., 0].T
        derivatives = self._gradient([*columns, *smallest.contiguous(), *largest.contiguous()])
        return values, torch.stack(derivatives, dim=-1)
