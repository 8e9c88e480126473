"""Declared checks of options and arguments: whole numbers, real numbers, names, choices.

A check is declared once, with the class of a value's kind, and applied by :func:`fields` to the fields of a
dataclass, or by the functions :func:`whole`, :func:`real`, :func:`name`, … to an argument. An error names the
argument, what it was, and what is needed. A value of another kind is a TypeError, and one out of range a
ValueError.

Examples
--------
>>> import numpy as np
>>> from dexterity import checks
>>> checks.whole(np.int64(3), "count", least=1)
3
>>> checks.whole(2.5, "count", least=1)
Traceback (most recent call last):
    ...
TypeError: count is 2.5; a whole number of at least 1 is needed
>>> checks.choice("manipulabilty", "index", ("manipulability", "isotropy"))
Traceback (most recent call last):
    ...
ValueError: index is 'manipulabilty'; did you mean 'manipulability'? One of manipulability, isotropy is needed
"""

from __future__ import annotations

import difflib
import functools
import inspect
import math
import numbers
import operator
import os
import re
import reprlib
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ParamSpec, TypeAlias, TypeVar

__all__ = [
    "Check",
    "Choice",
    "Each",
    "Flag",
    "Instance",
    "Name",
    "Named",
    "OrNone",
    "Real",
    "Whole",
    "arguments",
    "choice",
    "fields",
    "flag",
    "function",
    "hint",
    "identifier",
    "instance",
    "name",
    "names",
    "path",
    "positive",
    "real",
    "seed",
    "shown",
    "thread_count",
    "whole",
]

_Kind = TypeVar("_Kind")
_P = ParamSpec("_P")
_R = TypeVar("_R")


Check: TypeAlias = Callable[[Any, str], Any]
"""Takes a value and its name, and returns the value in its plain Python type, or raises."""


def fields(options: Any, /, **declared: Check) -> None:
    """Check fields of a frozen dataclass from its `__post_init__`, and store them in their plain types.

    Parameters
    ----------
    options
        The instance.
    declared
        A check for each field.

    Raises
    ------
    TypeError, ValueError
        As the checks; the error names the field.
    """
    for field, check in declared.items():
        object.__setattr__(options, field, check(getattr(options, field), field))


@dataclass(frozen=True)
class Whole:
    """A whole number within bounds. Those of numpy and torch are taken; booleans and floats are refused.

    Attributes
    ----------
    least, most
        Bounds, which are included; None for no bound.
    odd
        Whether the number must be odd.
    """

    least: int | None = None
    most: int | None = None
    odd: bool = False

    def __call__(self, value: Any, name: str) -> int:
        """Return the number as an int."""
        plain = _without_wrapper(value)
        try:
            if isinstance(plain, bool) or _has_axes(plain):
                raise TypeError
            number = operator.index(plain)
        except (TypeError, RuntimeError):  # torch's, of a tensor without memory
            raise TypeError(f"{name} is {shown(value)}; {self._needed()} is needed") from None
        if number.bit_length() > 63:
            raise ValueError(f"{name} is {shown(number)}; {self._needed()} is needed, in 64 bits")
        low = self.least is not None and number < self.least
        if low or (self.most is not None and number > self.most) or (self.odd and number % 2 == 0):
            raise ValueError(f"{name} is {shown(number)}; {self._needed()} is needed")
        return number

    def _needed(self) -> str:
        kind = "an odd number" if self.odd else "a whole number"
        if self.least is None:
            return kind if self.most is None else f"{kind} of at most {self.most}"
        return f"{kind} of at least {self.least}" + ("" if self.most is None else f" and at most {self.most}")


@dataclass(frozen=True)
class Real:
    """A real number within bounds. NaN is refused; infinities are refused unless they are declared.

    Attributes
    ----------
    least, most
        Bounds, which are included; None for no bound.
    above, below
        Bounds, which are excluded; None for no bound.
    infinite
        Whether infinities are taken.
    """

    least: float | None = None
    most: float | None = None
    above: float | None = None
    below: float | None = None
    infinite: bool = False

    def __call__(self, value: Any, name: str) -> float:
        """Return the number as a float."""
        plain = _without_wrapper(value)
        if isinstance(plain, bool) or not isinstance(plain, numbers.Real):
            raise TypeError(f"{name} is {shown(value)}; {self._needed()} is needed")
        try:
            number = float(plain)
        except OverflowError:
            number = math.nan
        if math.isnan(number) or (math.isinf(number) and not self.infinite) or not self._holds(number):
            raise ValueError(f"{name} is {shown(plain)}; {self._needed()} is needed")
        return number

    def _holds(self, number: float) -> bool:
        return (
            (self.least is None or number >= self.least)
            and (self.most is None or number <= self.most)
            and (self.above is None or number > self.above)
            and (self.below is None or number < self.below)
        )

    def _needed(self) -> str:
        bounds = [
            f"{word} {bound:g}"
            for word, bound in (
                ("at least", self.least),
                ("above", self.above),
                ("at most", self.most),
                ("below", self.below),
            )
            if bound is not None
        ]
        return " ".join(["a number" if self.infinite else "a finite number", " and ".join(bounds)]).strip()


@dataclass(frozen=True)
class Name:
    """Printable text that is not blank: no control characters, no line breaks, nothing invisible."""

    def __call__(self, value: Any, name: str) -> str:
        """Return the text."""
        if not isinstance(value, str):
            raise TypeError(f"{name} is {shown(value)}; text is needed")
        if not value.strip() or not value.isprintable():
            raise ValueError(f"{name} is {shown(value)}; printable text that is not blank is needed")
        return str(value)


@dataclass(frozen=True)
class Choice:
    """One of several texts.

    Attributes
    ----------
    known
        The texts.
    """

    known: Sequence[str]

    def __call__(self, value: Any, name: str) -> str:
        """Return the text."""
        if not isinstance(value, str):
            raise TypeError(f"{name} is {shown(value)}; one of {_listed(self.known)} is needed")
        if value not in self.known:
            raise ValueError(f"{name} is {shown(value)}; {hint(value, self.known)}")
        return value


@dataclass(frozen=True)
class Flag:
    """True or False; numpy's booleans are taken, numbers are refused."""

    def __call__(self, value: Any, name: str) -> bool:
        """Return the boolean."""
        plain = _without_wrapper(value)
        if not isinstance(plain, bool):
            raise TypeError(f"{name} is {shown(value)}; True or False is needed")
        return plain


@dataclass(frozen=True)
class Instance:
    """An instance of a class.

    Attributes
    ----------
    kind
        The class, or several.
    """

    kind: type[Any] | tuple[type[Any], ...]

    def __call__(self, value: Any, name: str) -> Any:
        """Return the value."""
        if not isinstance(value, self.kind):
            kinds = self.kind if isinstance(self.kind, tuple) else (self.kind,)
            wanted = " or ".join(kind.__name__ for kind in kinds)
            raise TypeError(f"{name} is {shown(value)}; {wanted} is needed")
        return value


@dataclass(frozen=True)
class OrNone:
    """None, or what another check takes.

    Attributes
    ----------
    check
        The other check.
    """

    check: Check

    def __call__(self, value: Any, name: str) -> Any:
        """Return None or the checked value."""
        return None if value is None else self.check(value, name)


@dataclass(frozen=True)
class Each:
    """A sequence, not a text, of values that another check takes; it becomes a tuple.

    Attributes
    ----------
    check
        The check of a value.
    """

    check: Check

    def __call__(self, value: Any, name: str) -> tuple[Any, ...]:
        """Return the checked values."""
        if isinstance(value, (str, bytes, Mapping)) or not isinstance(value, Iterable):
            raise TypeError(f"{name} is {shown(value)}; a sequence is needed")
        return tuple(self.check(each, f"{name}[{i}]") for i, each in enumerate(value))


@dataclass(frozen=True)
class Named:
    """A mapping from texts to values that another check takes.

    Attributes
    ----------
    check
        The check of a value.
    """

    check: Check

    def __call__(self, value: Any, name: str) -> dict[str, Any]:
        """Return the checked values by their names."""
        if not isinstance(value, Mapping) or not all(isinstance(key, str) for key in value):
            raise TypeError(f"{name} is {shown(value)}; a mapping from texts is needed")
        return {key: self.check(each, f"{name}[{key!r}]") for key, each in value.items()}


# ---- arguments -------------------------------------------------------------------------------------


def whole(value: Any, name: str, least: int | None = None, most: int | None = None) -> int:
    """Return a whole number as an int; bounds and errors are those of :class:`Whole`."""
    return Whole(least, most)(value, name)


def real(
    value: Any,
    name: str,
    *,
    least: float | None = None,
    most: float | None = None,
    above: float | None = None,
    below: float | None = None,
    infinite: bool = False,
) -> float:
    """Return a real number as a float; bounds and errors are those of :class:`Real`."""
    return Real(least, most, above, below, infinite)(value, name)


def positive(value: Any, name: str) -> float:
    """Return a finite number above 0 as a float; errors are those of :class:`Real`."""
    return Real(above=0)(value, name)


def seed(value: Any, name: str = "seed") -> int:
    """Return a seed that every generator takes, a whole number from 0 to 2⁶³ − 1, as an int."""
    return Whole(0, 2**63 - 1)(value, name)


def name(value: Any, called: str) -> str:
    """Return printable text for the argument `called`; errors are those of :class:`Name`."""
    return Name()(value, called)


def thread_count(value: Any, name: str) -> int:
    """Return a number of threads: of all processors that this process may use for None.

    Raises
    ------
    TypeError
        If it is no whole number.
    ValueError
        If it is below 1.
    """
    if value is not None:
        return whole(value, name, least=1)
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def names(value: Any, called: str, count: int | None = None) -> tuple[str, ...]:
    """Return different names as a tuple.

    Parameters
    ----------
    value
        The names, in any sequence but a text.
    called
        What the argument is called.
    count
        How many are needed; None for any number.

    Raises
    ------
    TypeError
        If `value` is a text or no sequence, or a name is no text.
    ValueError
        If a name is not printable or is there twice, or the number of names is another one.
    """
    if isinstance(value, (str, bytes, Mapping)) or not isinstance(value, Iterable):
        raise TypeError(f"{called} is {shown(value)}; a sequence of names is needed")
    checked = tuple(name(each, f"{called}[{i}]") for i, each in enumerate(value))
    if count is not None and len(checked) != count:
        raise ValueError(f"{called} holds {len(checked)} names; {count} are needed")
    if twice := [each for each in checked if checked.count(each) > 1]:
        raise ValueError(f"{called} holds {twice[0]!r} more than once")
    return checked


def choice(value: Any, name: str, known: Iterable[str]) -> str:
    """Return one of the known texts; errors are those of :class:`Choice` and name the nearest one."""
    return Choice(tuple(known))(value, name)


def hint(value: str, known: Iterable[str], listed: Iterable[str] | None = None) -> str:
    """Return what an error tells of an unknown text: up to three known ones that are like it, and all.

    Parameters
    ----------
    value
        The text.
    known
        All texts that would do. Their case does not matter to the likeness.
    listed
        What is listed in place of all that are known.
    """
    folded = {text.casefold(): text for text in known}
    near = [repr(folded[text]) for text in difflib.get_close_matches(value.casefold(), folded, 3, _ALIKE)]
    question = f"did you mean {' or '.join(near)}? One" if near else "one"
    return f"{question} of {_listed(folded.values() if listed is None else listed)} is needed"


_ALIKE = 0.5  # share of letters that two names have in common, in their order


def _listed(texts: Iterable[str]) -> str:
    return ", ".join(texts) or "(there are none)"


def flag(value: Any, name: str) -> bool:
    """Return True or False; errors are those of :class:`Flag`."""
    return Flag()(value, name)


def function(value: Any, name: str) -> Callable[..., Any]:
    """Return what can be called.

    Raises
    ------
    TypeError
        If the value cannot be called.
    """
    if not callable(value):
        raise TypeError(f"{name} is {shown(value)}; a function is needed")
    return value


def path(value: Any, name: str) -> str | os.PathLike[str]:
    """Return a path of a file or folder, as text or as an object with a path.

    Raises
    ------
    TypeError
        If the value is neither.
    ValueError
        If the path is empty, or holds what no path can hold.
    """
    text = os.fspath(value) if isinstance(value, os.PathLike) else value
    if not isinstance(text, str):
        raise TypeError(f"{name} is {shown(value)}; a path is needed")
    try:
        if not text or b"\0" in os.fsencode(text):
            raise ValueError
    except ValueError:  # of which an error of encoding is one
        raise ValueError(f"{name} is {shown(text)}; a path is needed") from None
    return value


def identifier(value: Any, name: str) -> str:
    """Return what can name a function in C, C++ and ECMAScript: letters, digits, underscores, no keyword.

    Raises
    ------
    TypeError
        If the value is no text.
    ValueError
        If it is no such name.
    """
    if not isinstance(value, str):
        raise TypeError(f"{name} is {shown(value)}; text is needed")
    if not re.fullmatch(r"[A-Za-z]\w*", value, flags=re.ASCII):
        raise ValueError(
            f"{name} is {shown(value)}; letters, digits and underscores, a letter first, are needed"
        )
    if value in _KEYWORDS:
        raise ValueError(f"{name} is {value!r}, a word of C, C++ or ECMAScript; another name is needed")
    return value


_WORDS = (
    "alignas alignof and asm auto await bitand bitor bool break case catch char class compl concept const "
    "consteval constexpr constinit continue debugger decltype default delete do double else enum eval "
    "explicit export extends extern false final finally float for friend function goto if implements "
    "import in inline instanceof int interface let long main mutable namespace new noexcept not null "
    "nullptr operator or override package private protected public register reinterpret requires restrict "
    "return short signed sizeof static struct super switch template this throw true try typedef typeid "
    "typename typeof undefined union unsigned using var virtual void volatile while with xor yield"
)
_KEYWORDS = frozenset(_WORDS.split())


def arguments(**declared: Check) -> Callable[[Callable[_P, _R]], Callable[_P, _R]]:
    """Check arguments of a function before each call, and pass them on in their plain types.

    Parameters
    ----------
    declared
        A check for each argument. An argument that is left at its default is not checked.

    Raises
    ------
    TypeError, ValueError
        By the function, as the checks; the error names the argument.

    Examples
    --------
    >>> from dexterity import checks
    >>> @checks.arguments(count=checks.Whole(least=1))
    ... def row(count):
    ...     return [0.0] * count
    >>> row(2.5)
    Traceback (most recent call last):
        ...
    TypeError: count is 2.5; a whole number of at least 1 is needed
    """

    def decorate(function: Callable[_P, _R]) -> Callable[_P, _R]:
        signature = inspect.signature(function)

        @functools.wraps(function)
        def checked(*args: _P.args, **kwargs: _P.kwargs) -> _R:
            given = signature.bind(*args, **kwargs)
            for name, check in declared.items():
                if name in given.arguments:
                    given.arguments[name] = check(given.arguments[name], name)
            return function(*given.args, **given.kwargs)

        return checked

    return decorate


def instance(value: Any, name: str, kind: type[_Kind]) -> _Kind:
    """Return an instance of a class; errors are those of :class:`Instance`."""
    checked: _Kind = Instance(kind)(value, name)
    return checked


def shown(value: Any) -> str:
    """Return a value as an error shows it: short, on one line, whatever it is."""
    if _has_axes(value):
        return f"an array of shape {tuple(value.shape)}"
    return " ".join(_Short().repr(value).split())


class _Short(reprlib.Repr):
    def __init__(self) -> None:
        super().__init__()
        self.maxstring = self.maxother = 80

    def repr_int(self, x: int, level: int) -> str:  # noqa: ARG002  # it is given by the base class
        # repr of an integer of thousands of digits is an error by itself.
        return repr(x) if x.bit_length() <= 128 else f"a whole number of {x.bit_length()} bits"


def _without_wrapper(value: Any) -> Any:
    """Return the Python number that a numpy scalar or a tensor without axes holds, else the value."""
    if getattr(value, "ndim", None) == 0 and hasattr(value, "item"):
        try:
            return value.item()
        except (RuntimeError, ValueError, TypeError):  # a tensor without memory
            return value
    return value


def _has_axes(value: Any) -> bool:
    return bool(getattr(value, "ndim", 0))
