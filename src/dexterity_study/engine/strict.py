"""Strict reading of TOML files into frozen dataclasses: nothing is converted, ignored or filled in."""

import difflib
import re
from collections import Counter
from collections.abc import Callable, Iterable
from datetime import date, datetime
from pathlib import Path
from types import NoneType, UnionType
from typing import Any, Protocol, TypeVar, Union, get_args, get_origin

import cattrs
import cattrs.v

from dexterity import checks, store


class Named(Protocol):
    """An entry of a list, with a name that is unique in it."""

    @property
    def id(self) -> str:
        """Name, unique in its list."""


T = TypeVar("T")
Entry = TypeVar("Entry", bound=Named)


def read_table(file: Path, kind: type[T]) -> T:
    """Read a file that holds one table.

    Raises
    ------
    ValueError
        If the file is not TOML, or a key is missing, unknown or of another type than `kind` declares; the
        message names the file.
    """
    try:
        return _structure(_load(file), kind)
    except ValueError as error:
        raise ValueError(f"{_label(file)}: {error}") from error


def read_entries(file: Path, kind: type[Entry]) -> tuple[Entry, ...]:
    """Read a file that holds one array of tables, named as the file is.

    Raises
    ------
    ValueError
        If the file is not TOML, holds anything else, an entry is not what `kind` declares, or two entries
        have one id; the message names the file and the entry.
    """
    try:
        plain = _load(file)
        if plain.keys() != {file.stem} or not isinstance(plain[file.stem], list):
            raise ValueError(f"has the keys {', '.join(plain) or 'none'}; it must be a list of {file.stem}")
        entries = tuple(_entry(number, entry, kind) for number, entry in enumerate(plain[file.stem], 1))
        require_unique(entry.id for entry in entries)
    except ValueError as error:
        raise ValueError(f"{_label(file)}: {error}") from error
    return entries


def require_id(name: str) -> None:
    """Refuse an id that is not of small letters and digits, joined by hyphens."""
    if not re.fullmatch(r"[a-z0-9]+(-[a-z0-9]+)*", name):
        raise ValueError(f"id is {name!r}; it must be small letters and digits, joined by hyphens")


def require_text(**texts: str) -> None:
    """Refuse texts that are empty."""
    empty = [name for name, text in texts.items() if not text.strip()]
    if empty:
        raise ValueError(f"{', '.join(empty)} must not be empty")


def require_unique(names: Iterable[str]) -> None:
    """Refuse names of which one occurs twice."""
    twice = [name for name, count in Counter(names).items() if count > 1]
    if twice:
        raise ValueError(f"{', '.join(twice)} occurs more than once")


def require_known(name: str, names: Iterable[str], complaint: str) -> None:
    """Refuse a name that is not among others; the message tells the nearest."""
    known = set(names)
    if name not in known:
        nearest = difflib.get_close_matches(name, sorted(known), cutoff=0.0)
        raise ValueError(f"{complaint} {name!r}; the nearest are {', '.join(nearest) or 'none'}")


def _load(file: Path) -> dict[str, Any]:
    return store.read_toml(file)


def _label(file: Path) -> str:
    return f"{file.parent.name}/{file.name}"


def _entry(number: int, plain: object, kind: type[Entry]) -> Entry:
    try:
        return _structure(plain, kind)
    except ValueError as error:
        name = plain.get("id", number) if isinstance(plain, dict) else number
        raise ValueError(f"entry {name!r}: {error}") from error


def _structure(plain: object, kind: type[T]) -> T:
    try:
        return _CONVERTER.structure(plain, kind)
    except cattrs.BaseValidationError as error:
        raise ValueError("; ".join(cattrs.transform_error(error, format_exception=_reason))) from error


def _reason(error: BaseException, kind: Any) -> str:
    return str(error) if isinstance(error, TypeError | ValueError) else cattrs.v.format_exception(error, kind)


def _exactly(kind: type[T]) -> Callable[[Any, object], T]:
    def check(plain: Any, _: object) -> T:
        if type(plain) is not kind:
            raise TypeError(f"{plain!r} is not of type {kind.__name__}")
        return plain

    return check


def _number(plain: Any, _: object) -> float:
    if type(plain) not in (float, int):
        raise TypeError(f"{plain!r} is not a number")
    return checks.real(plain, "a number")


def _tuple(plain: Any, kind: Any) -> tuple[Any, ...]:
    if not isinstance(plain, list):
        raise TypeError(f"{plain!r} is not a list")
    return tuple(_CONVERTER.structure(item, get_args(kind)[0]) for item in plain)


def _union(plain: Any, kind: Any) -> Any:
    """Return the value as the first member of the union that it fits; None stands for an absent key alone."""
    for member in get_args(kind):
        if member is not NoneType:
            try:
                return _CONVERTER.structure(plain, member)
            except (cattrs.BaseValidationError, TypeError):
                continue
    raise TypeError(f"{plain!r} is none of {kind}")


def _has_origin(*origins: Any) -> Callable[[Any], bool]:
    return lambda kind: get_origin(kind) in origins


_CONVERTER = cattrs.Converter(forbid_extra_keys=True)
_CONVERTER.register_structure_hook(float, _number)
for _kind in (bool, int, str, date, datetime):
    _CONVERTER.register_structure_hook(_kind, _exactly(_kind))
_CONVERTER.register_structure_hook_func(_has_origin(tuple), _tuple)
_CONVERTER.register_structure_hook_func(_has_origin(Union, UnionType), _union)
