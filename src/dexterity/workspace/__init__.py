"""What an arm reaches, learned from samples and exactly: paper C.

Examples
--------
>>> import dexterity as dx
>>> links = [0.15, 0.43, 0.43, 0.02]
>>> dx.workspace.reachable(links, [[0.5, 0.0, 0.25], [1.0, 0.0, 0.0]]).tolist()
[True, False]
"""

from typing import TYPE_CHECKING

from dexterity import lazy
from dexterity.workspace.reachability import reachable

if TYPE_CHECKING:
    from dexterity.workspace import (
        archive,
        closed_form,
        compiled,
        dataset,
        dynamics,
        export,
        jacobian_net,
        maps,
        reachability,
        resolved_rate,
        training,
    )

__all__ = [
    "archive",
    "closed_form",
    "compiled",
    "dataset",
    "dynamics",
    "export",
    "jacobian_net",
    "maps",
    "reachability",
    "reachable",
    "resolved_rate",
    "training",
]

# Hidden from type checkers, for whom every name would otherwise be a module.
if not TYPE_CHECKING:
    __getattr__, __dir__ = lazy.submodules(__name__, __all__)
