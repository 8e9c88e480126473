"""``dexterity robots`` and ``indices``: what there is, and what one of them is.

Examples
--------
>>> from dexterity.command import listing
>>> "puma560" in listing.robots().columns["robot"]
True
>>> listing.measure("kci").columns["value"][0]
'kinematic_conditioning'
"""

from __future__ import annotations

import math

import dexterity as dx
from dexterity.chain import Chain
from dexterity.command.reports import Cell, Report

__all__ = ["indices", "joints", "measure", "robots"]


def robots() -> Report:
    """Robots of the package: name, joints, source."""
    descriptions = {name: dx.robots.describe(name) for name in dx.robots.names()}
    return Report(
        {
            "robot": list(descriptions),
            "joints": [dx.robots.load(name).joints for name in descriptions],
            "source": [description.source for description in descriptions.values()],
        }
    )


def joints(chain: Chain) -> Report:
    """Joints of a robot, with limits and rates; tool pose at home."""
    prismatic = [bool(screw[3:].abs().max() == 0) for screw in chain.screws]
    position = [round(value, 9) + 0.0 for value in chain.home[:3, 3].tolist()]
    rpy = [round(value, 9) + 0.0 for value in dx.spatial.rpy(chain.home).tolist()]
    return Report(
        {
            "joint": list(chain.joint_names),
            "kind": ["prismatic" if straight else "revolute" for straight in prismatic],
            "lower": [_limit(value) for value in chain.lower.tolist()],
            "upper": [_limit(value) for value in chain.upper.tolist()],
            "rate": chain.rates.tolist(),
        },
        {"robot": chain.name, "tool at zero, x y z (m)": position, "roll pitch yaw (rad)": rpy},
    )


def _limit(value: float) -> float | None:
    return value if math.isfinite(value) else None


def indices() -> Report:
    """All indices: name, aliases, title, bounds, which end is the good one, and what each needs."""
    measures = [dx.indices.describe(name) for name in dx.indices.names()]
    return Report(
        {
            "index": [measure.name for measure in measures],
            "aliases": [", ".join(measure.aliases) for measure in measures],
            "range": [f"{measure.bounds[0]:g} to {measure.bounds[1]:g}" for measure in measures],
            "better": ["larger" if measure.larger_is_better else "smaller" for measure in measures],
            "needs": [", ".join(sorted(measure.needs)) for measure in measures],
            "title": [measure.title for measure in measures],
        }
    )


def measure(name: str) -> Report:
    """One index: what it is, what it means, and where it comes from.

    Raises
    ------
    ValueError
        If no index is called that; all are listed.
    """
    found = dx.indices.describe(name)
    entries: dict[str, Cell] = {
        "name": found.name,
        "aliases": ", ".join(found.aliases),
        "title": found.title,
        "formula": found.formula,
        "unit": found.unit,
        "range": f"{found.bounds[0]:g} to {found.bounds[1]:g}",
        "better": "larger" if found.larger_is_better else "smaller",
        "needs": ", ".join(sorted(found.needs)),
        "meaning": found.meaning,
        "references": "; ".join(found.references),
    }
    return Report({"entry": list(entries), "value": list(entries.values())})
