"""Networks that stand in for dexterity indices: made, trained, judged, and exported."""

from dexterity.networks import (
    baselines,
    design,
    domain,
    export,
    feed_forward,
    growth,
    levenberg_marquardt,
    network,
    problem,
    pruning,
    radial_basis,
    recipes,
    trials,
    validation,
    worst_case,
)
from dexterity.networks.files import NetworkFileError, load, load_shipped, save, shipped

__all__ = [
    "NetworkFileError",
    "baselines",
    "design",
    "domain",
    "export",
    "feed_forward",
    "growth",
    "levenberg_marquardt",
    "load",
    "load_shipped",
    "network",
    "problem",
    "pruning",
    "radial_basis",
    "recipes",
    "save",
    "shipped",
    "trials",
    "validation",
    "worst_case",
]
