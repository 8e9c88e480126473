"""How long things take beside each other, how many instructions they need, and on which machine."""

from dexterity.timing.machine import Machine, conditions, processor, versions
from dexterity.timing.measurement import Ratio, Timing, Way, measure, ratio
from dexterity.timing.tables import readable, table, to_csv, to_markdown, write

__all__ = [
    "Machine",
    "Ratio",
    "Timing",
    "Way",
    "conditions",
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
