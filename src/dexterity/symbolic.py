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

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Sequence
from functools import cached_property
from typing import Any, Literal, Protocol, TypeAlias, get_args, overload, runtime_checkable

import numpy as np
import torch
from jaxtyping import Float64
from numpy.typing import NDArray
from torch import Tensor
from torch.autograd import forward_ad

from dexterity import checks, spatial
from dexterity.chain import Chain
from dexterity.codegen import CompilationFailed, c_source, javascript_module
from dexterity.codegen.c99 import ZERO
from dexterity.codegen.engine import InC, cached_c_source
from dexterity.codegen.torch_code import TensorFunction, torch_function
from dexterity.derivation import Derivation, SymbolicChain, derive
from dexterity.elimination import LAGUERRE_STEPS, LAGUERRE_TOLERANCE, laguerre_step
from dexterity.indices import Index, require_not_zero_everywhere
from dexterity.indices.jacobians import with_finite_powers
from dexterity.indices.reach_of_rows import general_configurations
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


def compile_index(
    chain: Chain | SymbolicChain, index: Index | str, backend: Backend = "torch", threads: int = 1
) -> CompiledIndex:
    """Return an index as a fast function of the chain's joint values.

    Parameters
    ----------
    chain
        A chain, all lengths numbers.
    index
        Name, frame, rows and limits; or a name or alias alone, such as ``"kci"``, for all that by default:
        the spatial frame, all rows, the chain's rates. ``Index("kci", "geometric")`` is about the tool.
    backend
        ``"torch"``: needs nothing else and runs on every device. ``"inductor"``: the same through
        ``torch.compile``, which needs a C++ compiler. ``"c"``: on the CPU, fastest for one configuration
        and for many; needs a C compiler, and is compiled once for each chain, index and processor: in
        seconds, but in more than a minute for the guaranteed speed of seven joints over six rows.
    threads
        Number of threads that share the configurations of a call, for ``"c"``. The others use those of torch:
        see ``torch.set_num_threads``.

    Raises
    ------
    ValueError
        If the backend is unknown, more than one thread is asked for where torch computes, the rates do not
        fit the chain, lengths have no value, or the index is zero everywhere, as with fewer joints than rows;
        rows that the chain can serve are named then. In C also if the program would be too large, as that of
        the guaranteed speed of twelve joints over six rows.
    TypeError
        If `chain` is no chain or `index` no index.
    CompilationFailed
        If a compiler is missing or fails.
    OSError
        If the folder for compiled code cannot be written.
    """
    checks.choice(backend, "backend", get_args(Backend))
    symbolic = SymbolicChain.of(chain)
    if not isinstance(index, Index | str):
        raise TypeError(f"index is {index!r}; an Index is needed, such as Index('manipulability')")
    checks.whole(threads, "threads", least=1)
    if threads > 1 and backend != "c":
        raise ValueError(
            f"threads is {threads}; backend {backend!r} uses those of torch, see torch.set_num_threads; "
            'backend "c" takes a number of its own'
        )
    index = Index(index) if isinstance(index, str) else index
    numeric = chain if isinstance(chain, Chain) else symbolic.numeric()
    require_not_zero_everywhere(index, numeric)
    if backend == "c":
        engine: Engine = InC(symbolic, index, threads)
    else:
        engine = _in_torch(derive(symbolic, index), numeric, backend)
    return CompiledIndex(numeric, symbolic, index, backend, engine, threads)


class CompiledIndex:
    """An index of a chain, compiled; :func:`compile_index` makes it.

    It is called as what :meth:`dexterity.indices.Index.bind` returns is; but one configuration as an array
    of numpy doubles gives a numpy number, in C after about a microsecond. It is differentiable by torch in
    every way. First derivatives in reverse mode are compiled. Where torch traces, maps or differentiates in
    another way (second derivatives, forward mode, ``torch.func``, ``torch.compile``), the plain index
    computes.

    Where w is zero, its minimum, its gradient is zero or that of one side; that of KCI is zero there. Where
    the smallest or the largest singular value repeats, KCI has one-sided derivatives only, and the gradient
    lies between them. At a singularity, a velocity ratio along a direction that can still be reached is
    between its values beside and at the singularity.

    It can be pickled; where it is loaded it is compiled again, in C from the cache.
    """

    def __init__(
        self,
        numeric: Chain,
        chain: SymbolicChain,
        index: Index,
        backend: Backend,
        engine: Engine,
        threads: int = 1,
    ) -> None:
        self._numeric = numeric
        self._chain = chain
        self._index = index
        self._backend = backend
        self._engine = engine
        self._threads = threads
        self._plain = index.bind(numeric)

    def __repr__(self) -> str:
        return f"CompiledIndex({self._index!r} of {self._chain.name!r}, backend {self._backend!r})"

    def __reduce__(self) -> tuple[Any, ...]:
        return compile_index, (self._numeric, self._index, self._backend, self._threads)

    @property
    def chain(self) -> SymbolicChain:
        """Chain that was compiled."""
        return self._chain

    @property
    def index(self) -> Index:
        """Index that was compiled."""
        return self._index

    @property
    def backend(self) -> Backend:
        """What computes."""
        return self._backend

    @overload
    def __call__(self, q: NDArray[Any]) -> Any: ...

    @overload
    def __call__(self, q: TensorLike) -> Float64[Tensor, "*batch"]: ...

    def __call__(self, q: TensorLike) -> Any:
        """Value of the index.

        Parameters
        ----------
        q
            (..., n) joint values, [rad] for revolute and [m] for prismatic joints.

        Returns
        -------
        Values (...); for one configuration as a numpy array of doubles a number of numpy, in C at the least
        cost that a call has.

        Raises
        ------
        ValueError
            If the last axis of `q` is not the number of joints, or `q` is not finite.
        """
        if type(q) is np.ndarray and q.ndim == 1 and q.dtype == _FLOAT64:
            if isinstance(self._engine, InC):
                return self._engine.row(q)
            return self(self._configurations(q)).numpy()[()]
        q = self._configurations(q)
        if _transformed(q):
            return self._plain(q)
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
        Values (...) and gradients (..., n), per [rad] or [m]: tensors without a
        gradient of their own. For torch's differentiation call the index itself.

        Raises
        ------
        ValueError
            If the last axis of `q` is not the number of joints, or `q` is not finite.
        """
        q = self._configurations(q)
        if _transformed(q):
            gradients = torch.func.grad(lambda x: self._plain(x).sum())(q)
            return self._plain(q), gradients
        return self._engine.values_and_gradients(q.detach())

    def _configurations(self, q: TensorLike) -> Tensor:
        # The engines refuse what is not finite; a look at it here would cost more than one index in C.
        if not (isinstance(q, Tensor) and q.dtype is torch.float64 and _is_dense(q)):
            q = spatial.to_float64(q, "q")
        return spatial.require_joints(q, self._chain.joints, "chain")

    def plain_gradient(self, q: Tensor) -> Tensor:
        """Gradient of the plain index, which torch can differentiate again, at `q` that requires one."""
        with torch.enable_grad():
            (gradient,) = torch.autograd.grad(
                self._plain(q).sum(), q, create_graph=True, materialize_grads=True
            )
        return gradient


_FLOAT64 = np.dtype(np.float64)


def _is_dense(q: Tensor) -> bool:
    return q.layout is torch.strided and not q.is_nested


def _transformed(q: Tensor) -> bool:
    """Whether torch traces, maps or differentiates in forward mode: nothing compiled can follow it."""
    return not spatial.are_readable(q) or (
        forward_ad._current_level >= 0 and forward_ad.unpack_dual(q).tangent is not None
    )


class _Differentiable(torch.autograd.Function):
    """The value with its gradient for torch's own differentiation."""

    @staticmethod
    def forward(ctx: Any, q: Tensor, index: CompiledIndex) -> Tensor:
        values, gradients = index.value_and_gradient(q)
        ctx.save_for_backward(q, gradients)
        ctx.index = index
        return values

    @staticmethod
    def backward(ctx: Any, weights: Tensor) -> tuple[Tensor, None]:
        q, gradients = ctx.saved_tensors
        if torch.is_grad_enabled():  # the gradient is to be differentiated
            gradients = ctx.index.plain_gradient(q)
        return weights[..., None] * gradients, None


@runtime_checkable
class Engine(Protocol):
    """What computes an index."""

    def values(self, q: Tensor) -> Tensor:
        """Values (...) of configurations (..., n)."""

    def values_and_gradients(self, q: Tensor) -> tuple[Tensor, Tensor]:
        """Values (...) and gradients (..., n) of configurations (..., n)."""


# ---- in torch --------------------------------------------------------------------------------------


def _in_torch(derivation: Derivation, chain: Chain, backend: Backend) -> Engine:
    inductor = backend == "inductor"
    engine: Engine
    if derivation.kind == "numeric":
        engine = _PlainInTorch(derivation.index.bind(chain))
    elif derivation.kind == "closed":
        engine = _ClosedInTorch(derivation, inductor)
    else:
        engine = _SpectralInTorch(derivation, inductor)
    if not inductor:
        _require_agreement(engine, derivation.index, chain)
        return engine
    from torch._dynamo.exc import BackendCompilerFailed  # its import takes most of a second

    try:
        _require_agreement(engine, derivation.index, chain)
    except BackendCompilerFailed as error:
        raise CompilationFailed(
            f'torch.compile failed, as it does without a C++ compiler ({error}); backend="torch" needs none'
        ) from error
    return engine


def _require_agreement(engine: Engine, index: Index, chain: Chain) -> None:
    """Make sure that what was derived is the index, at configurations in general position."""
    q = general_configurations(chain)
    values, plain = engine.values(q), index.bind(chain)(q)
    finite = plain[plain.isfinite()]
    scale = float(finite.abs().max()) if len(finite) else 0.0
    if not torch.isclose(values, plain, rtol=1e-6, atol=1e-9 * scale).all():
        raise ValueError(
            f"{index!r} cannot be compiled for {chain.name}: recorded it is {values.tolist()}, and evaluated "
            f"{plain.tolist()}. Choose rows that the chain can serve, or mend how the measure is recorded"
        )


class _PlainInTorch:
    """Evaluates the measure itself, for one that is not recorded."""

    def __init__(self, plain: Callable[[TensorLike], Tensor]) -> None:
        self._plain = plain

    def values(self, q: Tensor) -> Tensor:
        with torch.no_grad():
            return self._plain(q)

    def values_and_gradients(self, q: Tensor) -> tuple[Tensor, Tensor]:
        rows = spatial.to_float64(q.detach(), "q").reshape(-1, q.shape[-1])
        pieces = [spatial.value_and_gradient(self._plain, piece) for piece in rows.split(_PIECE)]
        values, gradients = (torch.cat(parts) for parts in zip(*pieces, strict=True))
        return values.reshape(q.shape[:-1]), gradients.reshape(q.shape)


_PIECE = 8192  # configurations worked on at a time on the CPU: what a step reads is still in its cache


class _InTorch(ABC):
    """Runs programs on the joints' columns, on the CPU in pieces; gradients are never fused."""

    def __init__(self, derivation: Derivation, inductor: bool) -> None:
        self._derivation = derivation
        self._inductor = inductor
        self._turning = [kind == "revolute" for kind in derivation.chain.kinds]

    def values(self, q: Tensor) -> Tensor:
        return torch.cat([self._values(columns) for columns in self._columns(q)]).reshape(q.shape[:-1])

    def values_and_gradients(self, q: Tensor) -> tuple[Tensor, Tensor]:
        pieces = [self._values_and_gradients(columns) for columns in self._columns(q)]
        values, gradients = (torch.cat(parts) for parts in zip(*pieces, strict=True))
        return values.reshape(q.shape[:-1]), gradients.reshape(q.shape)

    def _columns(self, q: Tensor) -> Iterator[list[Tensor]]:
        """Columns of joint values, angles in one turn; then as they are given where limits need them."""
        rows = with_finite_powers(spatial.to_float64(q.detach(), "q"), "q").reshape(-1, q.shape[-1])
        in_pieces = rows.is_cpu and not self._inductor
        for piece in rows.split(_PIECE if in_pieces else max(len(rows), 1)):
            given = piece.T.contiguous()
            # Angles of parallel joints are added: large ones would cost the sum its digits.
            reduced = torch.where(given.abs() > math.pi, torch.atan2(given.sin(), given.cos()), given)
            columns = [
                angle if turns else value
                for turns, angle, value in zip(self._turning, reduced, given, strict=True)
            ]
            yield [*columns, *given] if self._derivation.values_as_given else columns

    @abstractmethod
    def _values(self, columns: Sequence[Tensor]) -> Tensor:
        """Values (N,) from one column (N,) a joint."""

    @abstractmethod
    def _values_and_gradients(self, columns: Sequence[Tensor]) -> tuple[Tensor, Tensor]:
        """Values (N,) and gradients (N, n)."""


class _ClosedInTorch(_InTorch):
    @cached_property
    def _value(self) -> TensorFunction:
        return torch_function(self._derivation.value, self._inductor)

    @cached_property
    def _gradient(self) -> TensorFunction:
        return torch_function(self._derivation.value_and_gradient)

    def _values(self, columns: Sequence[Tensor]) -> Tensor:
        return self._value(columns)[0]

    def _values_and_gradients(self, columns: Sequence[Tensor]) -> tuple[Tensor, Tensor]:
        value, *derivatives = self._gradient(columns)
        return value, torch.stack(derivatives, dim=-1)


class _SpectralInTorch(_InTorch):
    @cached_property
    def _bidiagonal(self) -> TensorFunction:
        return torch_function(self._derivation.bidiagonal_with_sum, self._inductor)

    @cached_property
    def _step(self) -> TensorFunction:
        return torch_function(laguerre_step(self._derivation.size), self._inductor)

    @cached_property
    def _combination(self) -> TensorFunction:
        return torch_function(self._derivation.combination)

    @cached_property
    def _triangle(self) -> TensorFunction:
        return torch_function(self._derivation.triangle)

    @cached_property
    def _gradient(self) -> TensorFunction:
        return torch_function(self._derivation.spectral_gradient)

    def _values(self, columns: Sequence[Tensor]) -> Tensor:
        return self._combined(columns)[0]

    def _combined(self, columns: Sequence[Tensor]) -> list[Tensor]:
        """Value, its derivatives by the smallest and the largest singular value, and the ratio of these."""
        *squares, total = self._bidiagonal(columns)
        smallest = self._extreme_root(squares, side=-1.0, start=0.0)
        largest = self._extreme_root(squares, side=1.0, start=1.0)
        # Where nothing moves at all the largest is zero as well.
        ratio = torch.where(largest > 0, smallest / largest, 0.0).sqrt()
        longest = (torch.where(largest > 0, largest, 1.0) * total).sqrt()
        return [*self._combination([ratio * longest, longest]), ratio]

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
        values, by_smallest, by_largest, ratio = self._combined(columns)
        m = self._derivation.size
        rows, places = torch.tril_indices(m, m, device=values.device)
        L = values.new_zeros(len(values), m, m)
        L[:, rows, places] = torch.stack(self._triangle(columns), dim=-1)
        left, _, right = torch.linalg.svd(L)
        # What counts as a singularity has its minimum: the gradient is zero.
        regular = ratio > ZERO
        a = torch.where(regular, by_smallest, 0.0) * left[:, :, -1].T
        c = torch.where(regular, by_largest, 0.0) * left[:, :, 0].T
        vectors = torch.cat([a, right[:, -1].T, c, right[:, 0].T])
        derivatives = self._gradient([*columns, *vectors])
        return values, torch.stack(derivatives, dim=-1)
