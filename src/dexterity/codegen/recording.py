"""Functions of torch recorded number by number, so that they can be printed in another language.

A function is run once on sample numbers, and every operation that they take part in is written down for each
number. Nothing is left of tensors, of batches or of a derivative that the function asks torch for. Where the
function looks at a number, to raise an error or to leave out a step, the recording keeps the condition: it
stands for the function where all conditions are as they were for the sample.

Loops over numbers that are not known beforehand cannot be recorded, and neither can what leaves torch, by
``tolist`` or ``numpy``.

Examples
--------
>>> import torch
>>> from dexterity.codegen.recording import record
>>> recording = record(lambda x: torch.hypot(x[0], x[1])[None], torch.tensor([3.0, 4.0]).double())
>>> len(recording.outputs)
1
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import torch
from torch import Tensor
from torch.overrides import TorchFunctionMode
from torch.utils._python_dispatch import TorchDispatchMode
from torch.utils._pytree import tree_leaves

from dexterity import checks
from dexterity.codegen.scalar_operations import Operations
from dexterity.codegen.tape import Number, Recording, Tape

__all__ = ["record"]


@checks.arguments(function=checks.function, samples=checks.Each(checks.Instance(Tensor)))
def record(function: Callable[..., Tensor], *samples: Tensor) -> Recording:
    """Record a function of tensors.

    Parameters
    ----------
    function
        Of tensors like the samples, for a tensor.
    samples
        Numbers for which it does what is to be recorded. One after the other, their elements are the inputs
        of the recording; the elements of the result are its outputs.

    Raises
    ------
    NotImplementedError
        If the function uses an operation of torch that is not known here.
    """
    tape = Tape()
    recorder = _Recorder(tape)
    count = 0
    samples = tuple(sample.detach().clone() for sample in samples)
    for sample in samples:
        places = [tape.input(number) for number in range(count, count + sample.numel())]
        recorder.write(sample, torch.tensor(places).reshape(sample.shape))
        count += sample.numel()
    with _OneHotByComparison(), recorder:
        result = function(*samples)
    outputs = recorder.read(result).flatten().tolist()
    return Recording(count, tape, tuple(recorder.conditions.items()), tuple(outputs), tuple(result.shape))


class _OneHotByComparison(TorchFunctionMode):
    """Has no number looked at where only its place is wanted."""

    def __torch_function__(
        self, func: Any, types: Any, args: tuple[Any, ...] = (), kwargs: dict[str, Any] | None = None
    ) -> Any:
        if func is torch.nn.functional.one_hot:
            places, count = args
            return (places[..., None] == torch.arange(count)).long()
        return func(*args, **(kwargs or {}))


class _Recorder(TorchDispatchMode):
    """Keeps, beside the memory of every tensor that depends on the samples, the places on the tape.

    That views share memory is then no concern of this class.
    """

    def __init__(self, tape: Tape) -> None:
        super().__init__()  # type: ignore[no-untyped-call]
        self.conditions: dict[int, Number] = {}
        self._tape = tape
        self._operations = Operations(tape, self.read, self._looked_at)
        self._places: dict[int, Tensor] = {}
        self._alive: list[Tensor] = []

    def __torch_dispatch__(
        self, func: Any, types: Any, args: tuple[Any, ...] = (), kwargs: dict[str, Any] | None = None
    ) -> Any:
        kwargs = kwargs or {}
        if not any(self._knows(part) for part in tree_leaves((args, kwargs))):
            return func(*args, **kwargs)
        name = func._schema.name.removeprefix("aten::")
        if name == "_local_scalar_dense":
            return self._looked_at(args[0]).item()
        if func._schema.is_mutable:
            places = self._operations(name.removesuffix("_"), args, kwargs)
            self.write(args[0], places.expand(args[0].shape))
            return func(*args, **kwargs)
        result = func(*args, **kwargs)
        fresh = [part for part in tree_leaves(result) if isinstance(part, Tensor) and not self._knows(part)]
        # Views have the memory of what they show.
        if fresh and not self._operations.ignores(name):
            self.write(fresh[0], self._operations(name, args, kwargs))
        return result

    def read(self, tensor: Tensor) -> Tensor:
        """Return the places of a tensor's elements."""
        if self._knows(tensor):
            return self._shown(tensor)
        places = [self._tape.constant(value) for value in tensor.detach().flatten().tolist()]
        return torch.tensor(places, dtype=torch.long).reshape(tensor.shape)

    def write(self, tensor: Tensor, places: Tensor) -> None:
        """Put places beside the memory of a tensor."""
        if not self._knows(tensor):
            memory = tensor.untyped_storage()
            flat = torch.empty(0, dtype=tensor.dtype).set_(memory)
            self._places[memory._cdata] = self.read(flat)
            self._alive.append(tensor)
        self._shown(tensor).copy_(places)

    def _knows(self, tensor: Any) -> bool:
        return isinstance(tensor, Tensor) and tensor.untyped_storage()._cdata in self._places

    def _shown(self, tensor: Tensor) -> Tensor:
        beside = self._places[tensor.untyped_storage()._cdata]
        return beside.as_strided(tensor.shape, tensor.stride(), tensor.storage_offset())

    def _looked_at(self, tensor: Tensor) -> Tensor:
        """Return a tensor whose numbers are used as numbers, from here on a condition."""
        for place, value in zip(self.read(tensor).flatten().tolist(), tensor.flatten().tolist(), strict=True):
            if self._tape.value(place) is None:
                self.conditions[place] = value
        return tensor
