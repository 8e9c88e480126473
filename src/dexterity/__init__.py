"""Exact and learned kinematics of manipulators.

Quantities are SI and radians in float64; leading axes are batch axes; twists are ordered [v; ω];
``T_a_b`` maps coordinates in frame b to frame a.

==================================  ==================================================================
``Chain``                           a serial robot: from screws, Denavit–Hartenberg rows or a URDF
``robots``                          the robots of the package, and robot files
``spatial``                         poses, twists, rotations
``Index``, ``indices``              dexterity indices and ellipsoids
``tasks``                           the index that serves a task, and rankings by it
``inverse_kinematics``              configurations at a pose, null-space motion
``collision``                       distances of bodies on a robot and around it
``symbolic``, ``codegen``           exact indices compiled, and their source code
``sampling``, ``search``            spaces of configurations; optima in them
``reach``                           reach maps and base placement
``networks``                        learned stand-ins for indices, with cards
``docking``, ``workspace``, ``crane``  the systems of three papers
``scenes``, ``timing``              pictures in 3-D, measured times
==================================  ==================================================================

Modules are imported when they are first used, so that a program pays for the parts that it uses alone.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from dexterity import lazy

if TYPE_CHECKING:
    from dexterity import (
        chain,
        codegen,
        collision,
        crane,
        docking,
        indices,
        inverse_kinematics,
        networks,
        reach,
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
    from dexterity.chain import Chain
    from dexterity.indices import Index

__version__ = "0.1.0"

__all__ = [
    "Chain",
    "Index",
    "chain",
    "codegen",
    "collision",
    "crane",
    "docking",
    "indices",
    "inverse_kinematics",
    "networks",
    "reach",
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

# Hidden from type checkers, for whom every name would otherwise be of one type.
if not TYPE_CHECKING:
    _CLASSES = {"Chain": "dexterity.chain", "Index": "dexterity.indices"}
    _submodule, __dir__ = lazy.submodules(__name__, __all__)

    def __getattr__(name: str) -> Any:
        if name in _CLASSES:
            return getattr(import_module(_CLASSES[name]), name)
        return _submodule(name)
