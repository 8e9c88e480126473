"""One function, one bad argument: what becomes of it. As a script, it tries all and lists what is wrong."""

from __future__ import annotations

import contextlib
import math
import re
import signal
import sys
import warnings
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from functools import cache
from typing import Any, NamedTuple

import numpy as np
import torch
from mutations import Mutation, mutations
from samples import EXAMPLES, Arguments

SECONDS = 20


class Case(NamedTuple):
    """A function, the argument that is exchanged, and what it is exchanged for."""

    name: str
    function: Callable[..., Any]
    arguments: Arguments
    parameter: str
    mutation: Mutation

    def __repr__(self) -> str:
        return f"{self.name}({self.parameter}: {self.mutation.name})"


def cases() -> Iterator[Case]:
    """Yield every mutation of every argument of every example."""
    for name, function, arguments in EXAMPLES:
        for parameter, make in arguments.items():
            for mutation in mutations(make()):
                yield Case(name, function, arguments, parameter, mutation)


def fault(case: Case) -> str:
    """Return what is wrong with the answer to a case; nothing if all is well.

    Good is an error that names the argument, or an answer: the plain one where the argument means the same.
    """
    values = {name: make() for name, make in case.arguments.items()}
    values[case.parameter] = case.mutation.value()
    try:
        with quiet(), at_most(SECONDS):
            answer = case.function(**values)
    except TimeoutError:
        return f"took more than {SECONDS} s"
    except (ValueError, TypeError) as error:
        if case.mutation.is_same:
            return f"refused: {error}"
        # Where two arguments do not fit each other, either may be named.
        named = any(_names(error, parameter) for parameter in case.arguments)
        return "" if named else f"not named: {type(error).__name__}: {error}"
    except Exception as error:
        return f"{type(error).__name__}: {error}"
    if case.mutation.is_bad:
        return "accepted"
    try:
        plain = plain_answer(case.name)
    except Exception as error:
        return f"the good arguments: {type(error).__name__}: {error}"
    if case.mutation.is_same and not same(answer, plain):
        return "another answer"
    return ""


def _names(error: Exception, parameter: str) -> bool:
    return bool(re.search(rf"(?<![A-Za-z]){re.escape(parameter)}(?![A-Za-z])", str(error)))


@contextlib.contextmanager
def quiet() -> Iterator[None]:
    with warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore")
        yield


@contextlib.contextmanager
def at_most(seconds: int) -> Iterator[None]:
    """Raise TimeoutError where it takes longer, in the main thread."""

    def end(*_: object) -> None:
        raise TimeoutError

    before = signal.signal(signal.SIGALRM, end)
    signal.alarm(seconds)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)


def same(one: Any, other: Any) -> bool:
    """Whether two answers are the same, numbers to rounding."""
    if isinstance(one, torch.Tensor) and isinstance(other, torch.Tensor):
        one, other = one.detach(), other.detach()
        if one.dtype == torch.bool or not one.is_floating_point():
            return torch.equal(one, other)
        return one.shape == other.shape and torch.allclose(one, other, rtol=1e-9, atol=1e-9, equal_nan=True)
    if isinstance(one, (tuple, list)) and isinstance(other, (tuple, list)):
        return len(one) == len(other) and all(map(same, one, other))
    if isinstance(one, float) and isinstance(other, float):
        return math.isclose(one, other, rel_tol=1e-9, abs_tol=1e-9) or (math.isnan(one) and math.isnan(other))
    if isinstance(one, (int, str, Mapping)):
        return bool(one == other)
    return type(one) is type(other)


@cache
def plain_answer(name: str) -> Any:
    """Return what a function answers to its good arguments."""
    function, arguments = next((function, arguments) for key, function, arguments in EXAMPLES if key == name)
    with quiet():
        return function(**{key: make() for key, make in arguments.items()})


def main(only: str) -> None:
    """Try all functions whose names begin with a text."""
    tried, wrong = 0, Counter[str]()
    for case in cases():
        if case.name.startswith(only):
            tried += 1
            if said := fault(case):
                wrong[case.name] += 1
                sys.stdout.write(f"{case}: {said[:150]}\n")
    sys.stdout.write(f"{sum(wrong.values())} of {tried}: {dict(wrong)}\n")


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else "")
