"""Networks that stand in for dexterity indices: made, trained, judged, and exported.

Examples
--------
>>> import dexterity as dx
>>> network = dx.networks.load_shipped("uvms-manipulability-feed-forward")
>>> w = dx.indices.Index("manipulability").bind(dx.robots.uvms())
>>> q = [0.0, 0.0, 0.0, 0.0, 0.1, -0.1, 0.0, 0.1, 0.2, 0.1, -0.1, 0.0]
>>> bool(abs(network(q) / w(q) - 1) < 0.002)
True
"""

from dexterity.networks import (
    baselines,
    card,
    design,
    domain,
    domain_export,
    export,
    feed_forward,
    growth,
    levenberg_marquardt,
    network,
    normal_equations,
    problem,
    pruning,
    radial_basis,
    recipes,
    train,
    validation,
    worst_case,
)
from dexterity.networks.files import NetworkFileError, load, load_shipped, save, shipped

__all__ = [
    "NetworkFileError",
    "baselines",
    "card",
    "design",
    "domain",
    "domain_export",
    "export",
    "feed_forward",
    "growth",
    "levenberg_marquardt",
    "load",
    "load_shipped",
    "network",
    "normal_equations",
    "problem",
    "pruning",
    "radial_basis",
    "recipes",
    "save",
    "shipped",
    "train",
    "validation",
    "worst_case",
]
