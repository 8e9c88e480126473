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

from typing import TYPE_CHECKING

from dexterity import lazy
from dexterity.networks.card import Card
from dexterity.networks.domain import Guarded, OutsideTrainedSpace
from dexterity.networks.feed_forward import FeedForward
from dexterity.networks.files import NetworkFileError, load, load_shipped, save, shipped
from dexterity.networks.judgement import describe
from dexterity.networks.ladder import Effort
from dexterity.networks.learning import Learned, for_index, judge_again
from dexterity.networks.network import Network, View
from dexterity.networks.radial_basis import RadialBasis
from dexterity.networks.recipes import Recipe, prepare
from dexterity.networks.validation import judge
from dexterity.networks.worst_case import Search

if TYPE_CHECKING:
    from dexterity.networks import (
        baselines,
        card,
        card_text,
        comparison,
        design,
        domain,
        domain_export,
        export,
        feed_forward,
        growth,
        judgement,
        ladder,
        learning,
        levenberg_marquardt,
        network,
        normal_equations,
        onnx_models,
        problem,
        pruning,
        radial_basis,
        radial_basis_design,
        recipes,
        rounding,
        spaces,
        train,
        validation,
        worst_case,
    )

__all__ = [
    "Card",
    "Effort",
    "FeedForward",
    "Guarded",
    "Learned",
    "Network",
    "NetworkFileError",
    "OutsideTrainedSpace",
    "RadialBasis",
    "Recipe",
    "Search",
    "View",
    "baselines",
    "card",
    "card_text",
    "comparison",
    "describe",
    "design",
    "domain",
    "domain_export",
    "export",
    "feed_forward",
    "for_index",
    "growth",
    "judge",
    "judge_again",
    "judgement",
    "ladder",
    "learning",
    "levenberg_marquardt",
    "load",
    "load_shipped",
    "network",
    "normal_equations",
    "onnx_models",
    "prepare",
    "problem",
    "pruning",
    "radial_basis",
    "radial_basis_design",
    "recipes",
    "rounding",
    "save",
    "shipped",
    "spaces",
    "train",
    "validation",
    "worst_case",
]

# Hidden from type checkers, for whom every name would otherwise be a module.
if not TYPE_CHECKING:
    __getattr__, __dir__ = lazy.submodules(__name__, __all__)
