"""Search for the best point of a box: the genetic algorithm of paper B, and grids that need no luck."""

from dexterity.search.genetic import GeneticOptions, GeneticSearch, genetic_search
from dexterity.search.zoom import ZoomOptions, ZoomSearch, zoom_search

__all__ = [
    "GeneticOptions",
    "GeneticSearch",
    "ZoomOptions",
    "ZoomSearch",
    "genetic_search",
    "zoom_search",
]
