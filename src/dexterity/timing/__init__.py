"""How long things take beside each other, how many instructions they need, and on which machine.

Examples
--------
>>> from dexterity.timing import Way, measure, ratio
>>> ways = [Way(f"sum of {n}", lambda n=n: sum(range(n)), 1) for n in (9, 9999)]
>>> short, long = measure(ways, rounds=2, seconds=0.01)
>>> ratio(long, short).value > 1
True
"""

from typing import TYPE_CHECKING

from dexterity import lazy
from dexterity.timing.machine import Machine, conditions, processor, versions
from dexterity.timing.measurement import Ratio, Timing, Way, measure, ratio
from dexterity.timing.tables import readable, table, to_csv, to_markdown, write

if TYPE_CHECKING:
    from dexterity.timing import instructions

__all__ = [
    "Machine",
    "Ratio",
    "Timing",
    "Way",
    "conditions",
    "instructions",
    "measure",
    "processor",
    "ratio",
    "readable",
    "table",
    "to_csv",
    "to_markdown",
    "versions",
    "write",
]

# Hidden from type checkers, for whom every name would otherwise be a module.
if not TYPE_CHECKING:
    __getattr__, __dir__ = lazy.submodules(__name__, __all__)
