"""What an arm reaches, learned from samples and exactly: paper C.

Examples
--------
>>> import dexterity as dx
>>> links = [0.15, 0.43, 0.43, 0.02]
>>> dx.workspace.reachable(links, [[0.5, 0.0, 0.25], [1.0, 0.0, 0.0]]).tolist()
[True, False]
"""

from dexterity.workspace.reachability import reachable

__all__ = ["reachable"]
