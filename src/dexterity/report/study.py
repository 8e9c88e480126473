"""What a study offers, how one is found by its name, and the scale it runs at."""

import importlib
import os
from collections.abc import Mapping
from typing import Any, Literal, Protocol, cast, get_args, runtime_checkable

from dexterity.report.claims import Acceptance, Verdict

__all__ = ["Scale", "Study", "load_study", "module_name", "scale"]

Scale = Literal["smoke", "book", "full"]


@runtime_checkable
class Study(Protocol):
    """A module below `dexterity.studies`: a frozen config in, a frozen result out.

    `Config` and `Result` are frozen dataclasses, `Config` of primitives alone. `CONFIGS` holds a config
    for each scale. The same config gives the same result, for equal source and on the same machine.
    A study may say by `JUDGED_AS_STORED = True` that its stored result is what verdicts go by.
    """

    Config: type[Any]
    Result: type[Any]
    CONFIGS: Mapping[str, Any]

    def run(self, config: Any) -> Any:
        """Do the work."""
        ...

    def verdicts(self, result: Any) -> tuple[Verdict, ...]:
        """Judge each claim that a ledger gives to this study."""
        ...

    def acceptance(self, result: Any) -> tuple[Acceptance, ...]:
        """Return the figures that must hold for the result to be accepted."""
        ...


def scale() -> Scale:
    """Return the scale that studies run at: `DEXTERITY_SCALE`, or "book".

    Raises
    ------
    ValueError
        If the variable is set to anything but smoke, book or full.
    """
    value = os.environ.get("DEXTERITY_SCALE", "book")
    if value not in get_args(Scale):
        raise ValueError(f"DEXTERITY_SCALE is {value!r}; it must be one of {', '.join(get_args(Scale))}")
    return cast(Scale, value)


def module_name(study_name: str) -> str:
    """Return the full name of a study's module."""
    return f"dexterity.studies.{study_name}"


def load_study(study_name: str) -> Study:
    """Import a study.

    Parameters
    ----------
    study_name
        Part and chapter, such as `"uvms.kinematics"`.

    Raises
    ------
    ValueError
        If there is no such study.
    TypeError
        If the module does not offer what a study offers.
    """
    name = module_name(study_name)
    try:
        module = importlib.import_module(name)
    except ModuleNotFoundError as error:
        if error.name is None or not f"{name}.".startswith(f"{error.name}."):
            raise
        raise ValueError(f"there is no study {study_name!r}") from error
    missing = [member for member in _MEMBERS if not hasattr(module, member)]
    if missing:
        raise TypeError(f"study {study_name} lacks {', '.join(missing)}")
    return cast(Study, module)


_MEMBERS = ("Config", "Result", "CONFIGS", "run", "verdicts", "acceptance")
