"""Public functions, constructors and methods of the package that take arguments, by their shortest names."""

from __future__ import annotations

import enum
import inspect
from collections import deque
from collections.abc import Callable, Iterator
from functools import cache
from importlib import import_module
from types import ModuleType
from typing import Any

import dexterity

FURTHER = ("command", "operations", "urdf")
"""Public modules that no list of names leads to."""


def public() -> dict[str, Any]:
    """Functions and classes that lists of names lead to, by their shortest name, without ``dexterity``."""
    found: dict[int, tuple[str, Any]] = {}
    seen: set[str] = set()
    waiting = deque([("", dexterity), *((name, import_module(f"dexterity.{name}")) for name in FURTHER)])
    while waiting:
        path, module = waiting.popleft()
        if module.__name__ in seen:
            continue
        seen.add(module.__name__)
        for name in module.__all__:
            value = getattr(module, name)
            called = f"{path}.{name}".removeprefix(".")
            if isinstance(value, ModuleType):
                waiting.append((called, value))
            elif callable(value) and _is_own(value):
                found.setdefault(id(value), (called, value))
    return dict(found.values())


@cache
def entries() -> dict[str, Callable[..., Any]]:
    """What takes arguments: functions, constructors, methods."""
    classes = {value: name for name, value in public().items() if inspect.isclass(value)}
    return {
        name: value
        for called, owner in public().items()
        for name, value in (_of_class(called, owner, classes) if owner in classes else [(called, owner)])
        if inspect.signature(value).parameters
    }


def entry(name: str, owner: Any = None) -> Callable[..., Any]:
    """Return an entry by its name, a method of its `owner`."""
    *path, last = name.split(".")
    if owner is not None:
        return getattr(owner, last)
    value: Any = dexterity
    for part in (*path, last):
        value = import_module(f"dexterity.{part}") if part in FURTHER else getattr(value, part)
    return value


def is_record(value: Any) -> bool:
    """Whether a class only holds what functions return, and checks nothing: a named tuple, a dataclass."""
    plain = hasattr(value, "_fields") or hasattr(value, "__dataclass_fields__")
    return inspect.isclass(value) and plain and not hasattr(value, "__post_init__")


def _is_own(value: Any) -> bool:
    return str(getattr(value, "__module__", "")).startswith("dexterity.")


def _of_class(called: str, owner: type, public: dict[type, str]) -> Iterator[tuple[str, Callable[..., Any]]]:
    if not (
        issubclass(owner, (BaseException, enum.Enum)) or _is_protocol(owner) or inspect.isabstract(owner)
    ):
        yield called, owner
    if _is_protocol(owner):
        return
    for part in owner.__mro__:
        # What a public class inherits from another one stands there.
        if part is owner or (_is_own(part) and part not in public):
            for name, member in vars(part).items():
                if name == "__call__" or not name.startswith("_"):
                    if isinstance(member, (classmethod, staticmethod)):
                        yield f"{called}.{name}", getattr(owner, name)
                    elif inspect.isfunction(member) and len(inspect.signature(member).parameters) > 1:
                        yield f"{called}.{name}", member


def _is_protocol(owner: type) -> bool:
    return bool(getattr(owner, "_is_protocol", False))
