"""What is put in the place of a good argument: the same in another form, and what no function can take."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import torch


class Mutation(NamedTuple):
    """A value in the place of a good one.

    Attributes
    ----------
    name
        What was done.
    value
        Makes the value.
    is_same
        Whether it means the same, so that the answer has to be the same.
    is_bad
        Whether no function can make sense of it.
    """

    name: str
    value: Callable[[], Any]
    is_same: bool = False
    is_bad: bool = False


class Odd:
    """An object of a class that nobody knows."""


_ANYTHING_ELSE = (
    Mutation("an object", Odd, is_bad=True),
    Mutation("a mapping", lambda: {"a": 1}, is_bad=True),
    Mutation("bytes", lambda: b"abc", is_bad=True),
    Mutation("a complex number", lambda: 1j, is_bad=True),
    Mutation("a class", lambda: Odd, is_bad=True),
)


def mutations(value: Any) -> Iterator[Mutation]:
    """Yield mutations of a good value."""
    if isinstance(value, np.ndarray):
        yield from _of_array(value)
    elif isinstance(value, bool):
        yield from (
            Mutation("text", lambda: "yes", is_bad=True),
            Mutation("nan", lambda: math.nan, is_bad=True),
        )
        yield Mutation("numpy", lambda: np.bool_(value), is_same=True)
    elif isinstance(value, int):
        yield from _of_number(value)
        yield Mutation("a half", lambda: value + 0.5, is_bad=True)
        yield Mutation("numpy", lambda: np.int64(value), is_same=True)
    elif isinstance(value, float):
        yield from _of_number(value)
        yield Mutation("numpy", lambda: np.float64(value), is_same=True)
        yield Mutation("a tensor", lambda: torch.tensor(value, dtype=torch.float64), is_same=True)
    elif isinstance(value, str):
        for bad in ("", "nonsense", "a\x00b", "\ud800", " "):
            yield Mutation(repr(bad), lambda bad=bad: bad)
        yield Mutation("a number", lambda: 3, is_bad=True)
        yield Mutation("several texts", lambda: np.array([value, value]), is_bad=True)
    elif type(value) in (tuple, list):
        if value:
            yield Mutation("nan", lambda: type(value)([math.nan] * len(value)), is_bad=True)
            holds_text = any(isinstance(part, str) for part in value)
            yield Mutation("texts", lambda: type(value)(["x"] * len(value)), is_bad=not holds_text)
        yield Mutation("empty", lambda: type(value)())
        yield Mutation("a number", lambda: math.nan, is_bad=True)
    elif isinstance(value, Path):
        yield Mutation("another file", lambda: value.with_name("nonsense"))
        yield Mutation("as text", lambda: str(value), is_same=True)
        yield Mutation("a number", lambda: 3, is_bad=True)
    elif value is not None:
        yield Mutation("a number", lambda: 3, is_bad=True)
        yield Mutation("text", lambda: "x", is_bad=True)
    for other in _ANYTHING_ELSE:
        # A class can be called, as a function can. What may be None or a switch may be a function as well.
        if not (
            (other.name == "a class" and (callable(value) or value is None or isinstance(value, bool)))
            or (other.name == "a mapping" and (value is None or isinstance(value, Mapping)))
        ):
            yield other


def _of_number(value: float) -> Iterator[Mutation]:
    for bad in (math.nan, math.inf, -math.inf, 10**400, -1, 0, 1e300):
        yield Mutation(f"{bad:.3g}" if abs(bad) < 1e308 else "huge", lambda bad=bad: bad)
    yield Mutation("nan", lambda: math.nan, is_bad=True)
    yield Mutation("True", lambda: True)
    yield Mutation("text", lambda: "3", is_bad=True)
    yield Mutation("an array", lambda: np.full(3, value), is_bad=False)
    yield Mutation("a list", lambda: [value, None], is_bad=True)
    yield Mutation("without a value", lambda: torch.tensor(value).to("meta"))


def _of_array(value: np.ndarray) -> Iterator[Mutation]:
    yield Mutation("a tensor", lambda: torch.tensor(value), is_same=True)
    yield Mutation("a list", value.tolist, is_same=True)
    yield Mutation("backwards", lambda: np.ascontiguousarray(value[::-1])[::-1], is_same=True)
    yield Mutation("columns first", lambda: np.asfortranarray(value), is_same=True)
    yield Mutation("read only", lambda: _read_only(value), is_same=True)
    yield Mutation("big endian", lambda: value.astype(">f8"), is_same=True)
    yield Mutation("with a gradient", lambda: torch.tensor(value, requires_grad=True), is_same=True)
    yield Mutation("negated in place", lambda: torch._neg_view(torch.tensor(-value)), is_same=True)
    yield Mutation("a list of tensors", lambda: [*torch.tensor(value)], is_same=True)
    yield Mutation("sparse", lambda: torch.tensor(value).to_sparse(), is_bad=True)
    yield Mutation("without values", lambda: torch.tensor(value).to("meta"))
    yield Mutation("a view", lambda: np.repeat(value[..., None], 2, axis=-1)[..., 0], is_same=True)
    yield Mutation("in float32", lambda: value.astype(np.float32))
    yield Mutation("in float16", lambda: value.astype(np.float16))
    yield Mutation("in bfloat16", lambda: torch.tensor(value, dtype=torch.bfloat16))
    yield Mutation("in whole numbers", lambda: value.astype(int))
    for bad in (math.nan, math.inf, -math.inf):
        yield Mutation(f"with {bad}", lambda bad=bad: _with_first(value, bad), is_bad=math.isnan(bad))
    yield Mutation("huge", lambda: np.full_like(value, 1e300))
    yield Mutation("tiny", lambda: np.full_like(value, 1e-310))
    yield Mutation("zero", lambda: np.zeros_like(value))
    yield Mutation("negative", lambda: -value)
    yield Mutation("one more axis", lambda: value[None])
    yield Mutation("one more number", lambda: np.concatenate([value, value[..., :1]], axis=-1))
    yield Mutation("one number less", lambda: value[..., :-1])
    yield Mutation("no number", lambda: value[..., :0])
    yield Mutation("a single number", lambda: 1.0)
    yield Mutation("nothing", lambda: np.zeros(0))
    yield Mutation("complex", lambda: value + 1j, is_bad=True)
    yield Mutation("booleans", lambda: value > 0, is_bad=True)
    yield Mutation("texts", lambda: value.astype(str), is_bad=True)
    yield Mutation("objects", lambda: np.full(value.shape, None), is_bad=True)
    yield Mutation(
        "masked", lambda: np.ma.masked_array(value, mask=np.ones_like(value, dtype=bool)), is_bad=True
    )
    yield Mutation("dates", lambda: value.astype("datetime64[s]"), is_bad=True)
    yield Mutation("a ragged list", lambda: [value.tolist(), [1.0]], is_bad=True)
    yield Mutation("text", lambda: "123456", is_bad=True)
    yield Mutation("a set", lambda: set(value.ravel().tolist()), is_bad=True)
    yield Mutation("a huge number", lambda: [10**400] * value.shape[-1], is_bad=True)


def _read_only(value: np.ndarray) -> np.ndarray:
    copy = value.copy()
    copy.flags.writeable = False
    return copy


def _with_first(value: np.ndarray, bad: float) -> np.ndarray:
    copy = value.astype(float).copy()
    copy.reshape(-1)[0] = bad
    return copy
