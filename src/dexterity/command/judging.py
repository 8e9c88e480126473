"""``dexterity validate``: a network judged again, on points and by a search of its own.

Examples
--------
>>> from dexterity.command.judging import validate
>>> report, holds = validate("uvms-manipulability-feed-forward", points=2000, goal=0.5, seed=7)
>>> holds, list(report.columns)
(True, ['error', 'here', 'on the card'])
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import dexterity as dx
from dexterity import checks
from dexterity.command.reports import Cell, Report
from dexterity.networks import Network
from dexterity.networks.worst_case import Search, worst_case

__all__ = ["load", "networks", "validate"]


def networks() -> Report:
    """Networks of the package: name, robot, index, and the largest error on its card."""
    cards = [dx.networks.load_shipped(name).card for name in dx.networks.shipped()]
    return Report(
        {
            "network": list(dx.networks.shipped()),
            "robot": [card.chain().name for card in cards],
            "index": [card.index().name for card in cards],
            "neurons": [card["neurons"] for card in cards],
            "worst case": [card["worst_case"]["error"] for card in cards],
        }
    )


def load(name: str) -> Network:
    """Load a network of the package by its name, or one from a file.

    Raises
    ------
    ValueError
        If the file holds no network, or there is neither a network nor a file of that name.
    """
    shipped = dx.networks.shipped()
    if name in shipped:
        return dx.networks.load_shipped(name)
    if not Path(name).is_file():
        raise ValueError(
            f"network is {name!r}; there is no such file or network: {checks.hint(name, shipped)}"
        )
    return dx.networks.load(name)


def validate(name: str, *, points: int, goal: float | None, seed: int) -> tuple[Report, bool]:
    """Judge a network by the exact index of its card, in the space of its card.

    Parameters
    ----------
    name
        Name of a network of the package, or a file.
    points
        Number of fresh configurations.
    goal
        Largest relative error that is allowed, at the points and at the worst case that is found; without
        one, the points must not exceed the worst case on the card.
    seed
        Seed of the points and of the search.

    Returns
    -------
    The errors found here and those on the card, and whether the goal is met.

    Raises
    ------
    ValueError
        If the file holds no network, or its card lacks the robot, the index or the space.
    OSError
        If the file cannot be read.
    """
    network = load(name)
    card = network.card
    chain, index, space = card.chain(), card.index(), card.space()
    exact = index.bind(chain)
    scale = card.get("errors", {}).get("relative_to")
    data = dx.networks.validation.fresh(exact, space, points, seed)
    errors = dx.networks.judge(network, data, scale)
    worst = worst_case(network, exact, space, Search(samples=points, starts=64), seed, scale).error
    here = {
        "median": errors.median,
        "99 % of the points": errors.percentile_99,
        "largest at a point": errors.maximum,
        "worst case found": worst,
    }
    promised = _promised(card)
    allowed = promised["worst case found"] if goal is None else goal
    reached = errors.maximum if goal is None else max(errors.maximum, worst)
    columns: dict[str, list[Cell]] = {
        "error": list(here),
        "here": list(here.values()),
        "on the card": [promised[key] for key in here],
    }
    facts: dict[str, Cell] = {
        "network": name,
        "robot": chain.name,
        "index": index.title,
        "points": points,
        "allowed": allowed,
        "holds": allowed is not None and reached <= allowed,
    }
    return Report(columns, facts), bool(facts["holds"])


def _promised(card: Mapping[str, Any]) -> dict[str, float | None]:
    errors, worst = card.get("errors", {}), card.get("worst_case", {})
    return {
        "median": errors.get("median"),
        "99 % of the points": errors.get("percentile_99"),
        "largest at a point": errors.get("maximum"),
        "worst case found": worst.get("error"),
    }
