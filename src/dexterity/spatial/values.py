"""What a caller gives becomes a float64 tensor, or an error that names it.

Shapes and types are always checked. Values are checked once, where they enter, and only where Python can
read them: not while torch traces a function (``torch.compile``, ``torch.export``), transforms it
(``torch.func.vmap``, ``jvp`` …) or works without values (device ``meta``). There a NaN passes through.

Examples
--------
>>> import torch
>>> from dexterity.spatial import to_float64
>>> to_float64([1, 2], "speed").dtype
torch.float64
>>> to_float64([1, float("nan")], "speed")
Traceback (most recent call last):
ValueError: speed is not finite: it holds NaN or an infinity
>>> torch.func.vmap(lambda x: 2 * to_float64(x, "x"))(torch.ones(2)).tolist()
[2.0, 2.0]
>>> from dexterity.spatial import batch_of, common_batch, value_and_gradient
>>> batch_of([[1, 2]], "points", (3,))
Traceback (most recent call last):
ValueError: points has shape (1, 2); (..., 3) is needed
>>> common_batch(poses=(5, 1), points=(4,))
torch.Size([5, 4])
>>> value_and_gradient(lambda q: q.square().sum(-1), torch.ones(1, 2, dtype=torch.float64))[1].tolist()
[[2.0, 2.0]]
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any, TypeAlias

import numpy as np
import torch
from jaxtyping import Float64
from numpy.typing import NDArray
from torch import Tensor

__all__ = [
    "TensorLike",
    "are_readable",
    "batch_of",
    "common_batch",
    "differentiation",
    "require_finite_result",
    "require_joints",
    "to_extended_float64",
    "to_float64",
    "value_and_gradient",
]

TensorLike: TypeAlias = Tensor | NDArray[Any] | Sequence[Any] | float | int
"""Real numbers as a tensor, a numpy array, a nested sequence of numbers or tensors, or a number."""


@contextmanager
def differentiation() -> Iterator[None]:
    """Let torch differentiate what is computed inside, in whatever mode the caller is.

    Tensors of the caller's inference mode must be cloned inside before they take part.
    """
    with torch.inference_mode(False), torch.enable_grad():
        yield


def value_and_gradient(
    f: Callable[[Tensor], Tensor], x: Float64[Tensor, "*batch n"], name: str = "f"
) -> tuple[Tensor, Float64[Tensor, "*batch n"]]:
    """Values of a function of each row by itself, and its derivatives by the row, in whatever mode of torch.

    Parameters
    ----------
    f
        Values (...) of rows (..., n), which torch can differentiate.
    x
        (..., n) where.
    name
        What the caller calls the function; used in the error.

    Raises
    ------
    ValueError
        If torch cannot differentiate the function.
    """
    with differentiation():
        x = x.detach().clone().requires_grad_()
        value = f(x)
        if not value.requires_grad:
            raise ValueError(f"{name} cannot be differentiated by torch")
        (gradient,) = torch.autograd.grad(value.sum(), x)
    return value.detach(), gradient


def to_float64(value: TensorLike, name: str) -> Float64[Tensor, "..."]:
    """Raise real numbers to a float64 tensor on the device they are on.

    Parameters
    ----------
    value
        Tensor, array, nested sequence of numbers, arrays or tensors, or number. Integers and floats of every
        precision are raised to float64. Arrays may be read-only or run backwards. Sequences of tensors
        that require gradients pass them on.
    name
        What the caller calls it; used in the error.

    Raises
    ------
    ValueError
        If an element is NaN or infinite.
    TypeError
        If the elements are not real numbers (booleans and complex numbers are none), the array is masked, or
        the tensor is sparse.
    """
    tensor = as_float64(value, name)
    if are_readable(tensor) and not torch.isfinite(tensor).all():
        raise ValueError(f"{name} is not finite: it holds NaN or an infinity")
    return tensor


def to_extended_float64(value: TensorLike, name: str) -> Float64[Tensor, "..."]:
    """Raise real numbers to a float64 tensor as :func:`to_float64` does, infinities allowed.

    Raises
    ------
    ValueError
        If an element is NaN.
    TypeError
        As :func:`to_float64`.
    """
    tensor = as_float64(value, name)
    if are_readable(tensor) and tensor.isnan().any():
        raise ValueError(f"{name} holds NaN")
    return tensor


def batch_of(value: TensorLike, name: str, shape: tuple[int, ...]) -> Float64[Tensor, "..."]:
    """Raise real numbers to a float64 tensor as :func:`to_float64` does, and make sure of its last axes.

    Parameters
    ----------
    value
        Any number of leading batch axes, and the last axes.
    name
        What the caller calls it; used in the error.
    shape
        Lengths of the last axes, such as ``(3,)`` for points and ``(4, 4)`` for poses.

    Raises
    ------
    ValueError
        If the last axes are others, or an element is NaN or infinite.
    TypeError
        As :func:`to_float64`.
    """
    tensor = to_float64(value, name)
    if tuple(tensor.shape[-len(shape) :]) != shape:
        wanted = ", ".join(map(str, shape))
        raise ValueError(f"{name} has shape {tuple(tensor.shape)}; (..., {wanted}) is needed")
    return tensor


def common_batch(**batches: Sequence[int]) -> torch.Size:
    """Return the batch axes that arguments have together, by their names.

    Raises
    ------
    ValueError
        If they do not broadcast.
    """
    try:
        return torch.broadcast_shapes(*batches.values())
    except RuntimeError as error:
        *names, last = batches
        axes = " and ".join(str(tuple(batch)) for batch in batches.values())
        raise ValueError(
            f"{', '.join(names)} and {last} have batch axes {axes}, which do not broadcast"
        ) from error


def on_one_device(**tensors: Tensor) -> tuple[Tensor, ...]:
    """Bring tensors on the CPU, where numbers and arrays are, to the device of the others.

    Raises
    ------
    ValueError
        If two lie on different devices, none of which is the CPU; the error names both.
    """
    elsewhere = {name: tensor.device for name, tensor in tensors.items() if not tensor.is_cpu}
    if not elsewhere:
        return tuple(tensors.values())
    first, device = next(iter(elsewhere.items()))
    for name, other in elsewhere.items():
        if other != device:
            raise ValueError(
                f"{first} is on the device {device} and {name} on {other}; bring them together by to()"
            )
    return tuple(tensor.to(device) for tensor in tensors.values())


def on_cpu(
    value: TensorLike, name: str, read: Callable[[TensorLike, str], Tensor] = to_float64
) -> Float64[Tensor, "..."]:
    """Read numbers that describe something, such as limits, or that go where only the CPU can compute.

    They land on the CPU, whatever the default device of torch is, and whatever device they are on.

    Parameters
    ----------
    value, name
        As for :func:`to_float64`.
    read
        What reads them.

    Raises
    ------
    ValueError
        If they have no values to read, as on the device ``meta``, or as `read`.
    TypeError
        As `read`.
    """
    with torch.device("cpu"):
        tensor = read(value, name)
    if tensor.is_meta:
        raise ValueError(f"{name} is on the device meta, which holds no values")
    return tensor.cpu()


def beside(
    value: TensorLike,
    name: str,
    other: Tensor,
    read: Callable[[TensorLike, str], Tensor] = to_float64,
) -> Float64[Tensor, "..."]:
    """Read numbers that go with another tensor, and bring them to its device.

    Raises
    ------
    ValueError
        If they have no values and the other tensor has some, or as `read`.
    TypeError
        As `read`.
    """
    tensor = read(value, name)
    if tensor.is_meta and not other.is_meta:
        raise ValueError(f"{name} is on the device meta, which holds no values")
    return tensor.to(other.device)


def require_values(tensor: Tensor, name: str) -> Tensor:
    """Return a tensor whose values decide how something is computed, else refuse it by name.

    Raises
    ------
    TypeError
        If torch traces or maps the caller over a batch, or the device has no values.
    """
    inside = tensor
    functorch = torch._C._functorch
    while not torch.compiler.is_compiling() and functorch.is_gradtrackingtensor(inside):
        inside = functorch.get_unwrapped(inside)  # derivatives leave values as they are
    if not are_readable(inside):
        raise TypeError(
            f"{name} has no values here, and values decide how it is solved: torch.compile, torch.export, "
            "torch.func.vmap and the device meta are not possible; give a batch"
        )
    return tensor


def are_readable(tensor: Tensor) -> bool:
    """Whether Python can read the values of a tensor, and so a check can look at them.

    They cannot be read while torch compiles or exports a function, inside its function transforms, and on the
    device ``meta``.
    """
    if torch.compiler.is_compiling():
        return False
    return not (tensor.is_meta or torch._C._functorch.is_functorch_wrapped_tensor(tensor))


def require_finite_result(result: Tensor, name: str) -> Float64[Tensor, "..."]:
    """Return a result if it is finite; else the argument was so large that float64 cannot hold it.

    Raises
    ------
    ValueError
        If an element is NaN or infinite.
    """
    if are_readable(result) and not torch.isfinite(result).all():
        raise ValueError(f"{name} is so large that the result overflows float64")
    return result


def require_joints(q: Tensor, joints: int, owner: str) -> Float64[Tensor, "*batch n"]:
    """Return joint values as they are if their last axis is the number of joints.

    Parameters
    ----------
    q
        (..., n) joint values, [rad] or [m].
    joints
        Number of joints n.
    owner
        Whose joints they are, such as ``"chain"``; used in the error.

    Raises
    ------
    ValueError
        If the last axis is not the number of joints.
    """
    if q.shape[-1:] != (joints,):
        raise ValueError(f"q has shape {tuple(q.shape)}; the {owner} has {joints} joints: (..., {joints})")
    return q


def as_float64(value: TensorLike, name: str) -> Tensor:
    """Raise real numbers to a float64 tensor; NaN and infinities pass."""
    if isinstance(value, Tensor):
        return _tensor_as_float64(value, name)
    if torch.compiler.is_compiling():
        return torch.as_tensor(value, dtype=torch.float64)  # numpy is not traced
    if isinstance(value, list | tuple) and _holds(value, Tensor):
        return _stacked(value, name)
    if isinstance(value, np.ma.MaskedArray) or (
        isinstance(value, list | tuple) and _holds(value, np.ma.MaskedArray)
    ):
        raise TypeError(f"{name} is a masked array; fill it first, with filled()")
    try:
        array = np.asarray(value)
    except (TypeError, ValueError, OverflowError, RuntimeError) as error:
        raise TypeError(f"{name} cannot be read as an array of numbers: {error}") from error
    if array.dtype.kind in "bc":
        raise TypeError(f"{name} holds torch.{array.dtype} values; real numbers are needed")
    if array.dtype.kind not in "iuf":
        raise TypeError(f"{name} cannot be read as an array of numbers: it holds {array.dtype.name} values")
    array = array.astype(np.float64, copy=False)
    # torch refuses arrays that run backwards and warns about those that cannot be written to.
    if not array.flags.writeable or any(stride < 0 for stride in array.strides):
        array = array.copy(order="C")
    return torch.as_tensor(array)


def _tensor_as_float64(tensor: Tensor, name: str) -> Tensor:
    if tensor.is_nested:
        raise TypeError(f"{name} is a nested tensor; rows of one length are needed")
    if tensor.dtype == torch.float64 and tensor.layout == torch.strided:
        return _plain(tensor)
    if tensor.layout != torch.strided:
        raise TypeError(f"{name} is a tensor of layout {tensor.layout}; call to_dense() first")
    if tensor.is_complex() or tensor.dtype == torch.bool or tensor.is_quantized:
        raise TypeError(f"{name} holds {tensor.dtype} values; real numbers are needed")
    return _plain(tensor.to(torch.float64))


def _plain(tensor: Tensor) -> Tensor:
    """Return a tensor whose memory holds its values, not their negatives as a conjugate's imaginary part."""
    return tensor if torch.compiler.is_compiling() or not tensor.is_neg() else tensor.resolve_neg()


def _holds(value: Sequence[Any], kind: type) -> bool:
    return any(
        isinstance(part, kind) or (isinstance(part, list | tuple) and _holds(part, kind)) for part in value
    )


def _stacked(value: Sequence[Any], name: str) -> Tensor:
    """Stack a sequence with tensors in it, so that their gradients are passed on."""
    parts = [as_float64(part, name) for part in value]
    device = next(part.device for part, given in zip(parts, value, strict=True) if _has_device(given))
    try:
        return torch.stack([part.to(device) for part in parts])
    except RuntimeError as error:
        raise TypeError(f"{name} cannot be read as an array of numbers: {error}") from error


def _has_device(value: Any) -> bool:
    return isinstance(value, Tensor) or (isinstance(value, list | tuple) and _holds(value, Tensor))
