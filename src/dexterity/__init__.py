"""Exact and learned kinematics of manipulators.

Quantities are SI and radians in float64; leading axes are batch axes; twists are ordered [v; ω];
``T_a_b`` maps coordinates in frame b to frame a.

Modules are imported when they are first used, so that a program pays for the parts that it uses alone.
"""

from importlib import import_module
from types import ModuleType
from typing import TYPE_CHECKING

from dexterity.chain import Chain

if TYPE_CHECKING:
    from dexterity import (
        crane,
        docking,
        indices,
        inverse_kinematics,
        networks,
        robots,
        sampling,
        scenes,
        search,
        spatial,
        symbolic,
        tasks,
        timing,
        workspace,
    )

__version__ = "0.1.0"

__all__ = [
    "Chain",
    "crane",
    "docking",
    "indices",
    "inverse_kinematics",
    "networks",
    "robots",
    "sampling",
    "scenes",
    "search",
    "spatial",
    "symbolic",
    "tasks",
    "timing",
    "workspace",
]

# Hidden from type checkers, for whom every name would otherwise be a module.
if not TYPE_CHECKING:

    def __getattr__(name: str) -> ModuleType:
        if name in __all__:
            return import_module(f"{__name__}.{name}")
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")

    def __dir__() -> list[str]:
        return sorted({*globals(), *__all__})
