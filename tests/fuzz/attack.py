"""One function, one bad argument: what becomes of it. As a script, it tries all and lists what is wrong."""

from __future__ import annotations

import contextlib
import dataclasses
import inspect
import math
import os
import re
import signal
import sys
import warnings
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import torch
from beartype.roar import BeartypeCallHintViolation
from entries import entry
from good_values import folder
from mutations import Mutation, mutations
from samples import SAMPLES

SECONDS = 10  # of this process


class Case(NamedTuple):
    """A sample, the argument that is exchanged, and what it is exchanged for."""

    sample: str
    parameter: str
    mutation: Mutation

    def __repr__(self) -> str:
        return f"{self.sample}({self.parameter}: {self.mutation.name})"


def cases(sample: str) -> Iterator[Case]:
    """Yield every mutation of every argument of a sample, and of those that it leaves at their defaults."""
    values = {name: make() for name, make in SAMPLES[sample].items()}
    function = entry(sample.partition(" ")[0], values.pop("self", None))
    for parameter, (_, default) in _parameters(function).items():
        if parameter in values or default is not inspect.Parameter.empty:
            for mutation in mutations(values.get(parameter, default)):
                yield Case(sample, parameter, mutation)


def _parameters(function: Callable[..., Any]) -> dict[str, tuple[Any, Any]]:
    parameters = inspect.signature(function).parameters
    return {name: (parameter.kind, parameter.default) for name, parameter in parameters.items()}


def called(sample: str, mutated: Mapping[str, Any]) -> Any:
    """Return what a function answers to its good arguments, but for those that are mutated."""
    values = {name: make() for name, make in SAMPLES[sample].items()} | mutated
    function = entry(sample.partition(" ")[0], values.pop("self", None))
    several = [
        name for name, (kind, _) in _parameters(function).items() if kind is inspect.Parameter.VAR_POSITIONAL
    ]
    if not several:
        return _whole(function(**values))
    before = [values.pop(name) for name in _parameters(function) if name in values and name not in several]
    return _whole(function(*before, *(values[name] for name in several)))


def _whole(answer: Any) -> Any:
    return tuple(answer) if isinstance(answer, Iterator) else answer


def fault(case: Case) -> str:
    """Return what is wrong with the answer to a case; nothing if all is well.

    Good is an error that names the argument, or an answer: the plain one where the argument means the same.
    In tests, annotations of the derivation are checked in front of its own errors, see ``tests/conftest.py``.
    """
    given, untouched = case.mutation.value(), case.mutation.value()
    try:
        with quiet(), at_most(SECONDS):
            answer = called(case.sample, {case.parameter: given})
    except TimeoutError:
        return f"took more than {SECONDS} s"
    except (ValueError, TypeError, BeartypeCallHintViolation) as error:
        if case.mutation.is_same:
            return f"refused: {error}"
        # Where two arguments do not fit each other, either may be named.
        named = any(_names(error, name) for name in _named(case)) or _is_of_file(error, case, given)
        return "" if named else f"not named: {_short(error)}"
    except OSError as error:
        return "" if _is_of_file(error, case, given) else _short(error)
    except Exception as error:
        return _short(error)
    if isinstance(given, np.ndarray) and not same(given, untouched):
        return "the caller's array changed"
    if case.mutation.is_bad:
        return "accepted"
    return "another answer" if case.mutation.is_same and not same(answer, plain_answer(case.sample)) else ""


def _is_of_file(error: Exception, case: Case, given: Any) -> bool:
    return case.parameter in ("path", "folder", "source") and str(given) in str(error)


def _short(error: Exception) -> str:
    return f"{type(error).__name__}: {error}"


def _named(case: Case) -> set[str]:
    return {*SAMPLES[case.sample], case.parameter}


def _names(error: Exception, parameter: str) -> bool:
    return bool(re.search(rf"(?<![A-Za-z]){re.escape(parameter)}(?![A-Za-z])", str(error)))


@contextlib.contextmanager
def quiet() -> Iterator[None]:
    """Hear nothing, and leave what is written in a folder that goes."""
    with (
        warnings.catch_warnings(),
        np.errstate(all="ignore"),
        contextlib.chdir(folder()),
        Path(os.devnull).open("w") as nothing,
        contextlib.redirect_stdout(nothing),
        contextlib.redirect_stderr(nothing),
    ):
        warnings.simplefilter("ignore")
        yield


@contextlib.contextmanager
def at_most(seconds: int) -> Iterator[None]:
    """Raise TimeoutError where it computes longer, in the main thread."""

    def end(*_: object) -> None:
        raise TimeoutError

    before = signal.signal(signal.SIGPROF, end)
    signal.setitimer(signal.ITIMER_PROF, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
        signal.signal(signal.SIGPROF, before)


def same(one: Any, other: Any) -> bool:
    """Whether two answers are the same, numbers to rounding."""
    if isinstance(one, torch.Tensor) and isinstance(other, torch.Tensor):
        one, other = one.detach(), other.detach()
        if one.dtype == torch.bool or not one.is_floating_point():
            return torch.equal(one, other)
        return one.shape == other.shape and torch.allclose(one, other, rtol=1e-9, atol=1e-9, equal_nan=True)
    if isinstance(one, torch.Tensor) != isinstance(other, torch.Tensor):
        return same(torch.as_tensor(one), torch.as_tensor(other))
    if isinstance(one, np.ndarray) and isinstance(other, np.ndarray):
        return one.dtype == other.dtype and np.array_equal(one, other, equal_nan=one.dtype.kind == "f")
    if isinstance(one, (tuple, list)) and isinstance(other, (tuple, list)):
        return len(one) == len(other) and all(map(same, one, other))
    if isinstance(one, float) and isinstance(other, float):
        return math.isclose(one, other, rel_tol=1e-9, abs_tol=1e-9) or (math.isnan(one) and math.isnan(other))
    if isinstance(one, Mapping) and isinstance(other, Mapping):
        return one.keys() == other.keys() and all(same(one[key], other[key]) for key in one)
    if dataclasses.is_dataclass(one) and type(one) is type(other):
        return all(
            same(getattr(one, field.name), getattr(other, field.name))
            for field in dataclasses.fields(one)
            if field.compare
        )
    if isinstance(one, (int, str)):
        return bool(one == other)
    return type(one) is type(other)


@cache
def plain_answer(sample: str) -> Any:
    """Return what a function answers to its good arguments."""
    with quiet():
        return called(sample, {})


def main(*beginnings: str) -> None:
    """Try all samples whose names begin with one of some texts."""
    tried, wrong = 0, Counter[str]()
    for sample in SAMPLES:
        if sample.startswith(beginnings or ("",)):
            for case in cases(sample):
                tried += 1
                if said := fault(case):
                    wrong[sample] += 1
                    sys.stdout.write(f"{case}: {said[:150]}\n")
    sys.stdout.write(f"{sum(wrong.values())} of {tried}: {dict(wrong)}\n")


if __name__ == "__main__":
    main(*sys.argv[1:])
