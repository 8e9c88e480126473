"""Search for the best point of a space.

By ascent along the gradient from many starts (`extremes`), by grids that need neither luck nor gradients
(`zoom_search`), and by the genetic algorithm of paper B.

Examples
--------
>>> import dexterity as dx
>>> few = dx.search.ZoomOptions(starts=2, stages=60)
>>> found = dx.search.zoom_search(
...     lambda x: -(x**2).sum(-1), [-1, -1], [2, 2], [0.25, 0.25], few
... )
>>> [abs(round(x, 3)) for x in found.point.tolist()]
[0.0, 0.0]
"""

from dexterity.search.extremes import Extreme, Extremes, extremes
from dexterity.search.genetic import GeneticOptions, GeneticSearch, genetic_search
from dexterity.search.zoom import ZoomOptions, ZoomSearch, zoom_search

__all__ = [
    "Extreme",
    "Extremes",
    "GeneticOptions",
    "GeneticSearch",
    "ZoomOptions",
    "ZoomSearch",
    "extremes",
    "genetic_search",
    "zoom_search",
]
