"""Random inputs of the instruments for docking and for the crane, and what the package says of them."""

import base64
import html
import json
import math
import re
import zlib
from collections.abc import Mapping
from typing import Any

import numpy as np
import torch
from built_book import html_file
from torch import Tensor

from dexterity import crane, docking
from dexterity.crane import positioning
from dexterity.crane.positioning import Task
from dexterity.crane.positioning.export import Networks, task_at
from dexterity.crane.shape import bars
from dexterity.networks.feed_forward import FeedForward
from dexterity.networks.network import View
from dexterity_study.crane.positioning import instrument as positioned
from dexterity_study.docking import cases
from dexterity_study.docking.area import instrument as docked

CONFIGURATIONS = 200

Cases = tuple[list[dict[str, Any]], Mapping[str, Any]]


def docking_cases() -> Cases:
    """Poses on the block, for both arms."""
    random = np.random.default_rng(1)
    poses = torch.from_numpy(
        random.uniform([-0.7, -0.7, 0.2, -math.pi], [0.7, 0.7, 0.25, math.pi], (CONFIGURATIONS, 4))
    )
    arms = [list(docked.problems())[i % 2] for i in range(CONFIGURATIONS)]
    inputs = [
        {**dict(zip(("x", "y", "z", "heading"), pose, strict=True)), "arm": arm}
        for pose, arm in zip(poses.tolist(), arms, strict=True)
    ]
    rows = [_docked(docked.problems()[arm], pose) for arm, pose in zip(arms, poses, strict=True)]
    return inputs, {name: [row[name] for row in rows] for name in rows[0]}


def _docked(problem: docking.DockingProblem, pose: Tensor) -> dict[str, Any]:
    w = docking.largest_manipulability(problem.arm, pose, docking.square(0.2, docked.PER_SIDE))
    corners = docking.largest_manipulability(problem.arm, pose, list(cases.CORNERS.values()))
    return {
        "map": w.tolist(),
        "area": problem.area_manipulability(pose).item(),
        "dead": (w == 0).double().mean().item(),
        "median": w.median().item(),
        "distance": problem.distance(pose).item(),
        "fitness": problem.fitness(pose).item(),
        "allowed": "yes" if problem.allows(pose) else "no",
        **dict(zip(cases.CORNERS, corners.tolist(), strict=True)),
    }


def crane_cases() -> Cases:
    """Strokes and payloads that the crane has."""
    random, machine, own = np.random.default_rng(1), crane.patu655(), _networks_of_the_page()
    strokes = torch.from_numpy(random.uniform(machine.lower, machine.upper, (CONFIGURATIONS, 3)))
    payload = torch.from_numpy(random.uniform(0, machine.rating, CONFIGURATIONS))
    inputs = [
        {**dict(zip(("s1", "s2", "s3"), row, strict=True)), "payload": mass, "magnified": "10 times"}
        for row, mass in zip(strokes.tolist(), payload.tolist(), strict=True)
    ]
    tip, sag, shape = crane.tip_position(strokes), crane.deflection(strokes, payload), bars(strokes)
    task = task_at(strokes, payload, machine)
    return inputs, {
        "x": tip[:, 0].tolist(),
        "y": tip[:, 1].tolist(),
        "sagX": sag[:, 0].tolist(),
        "sagY": sag[:, 1].tolist(),
        "sag": sag.norm(dim=-1).tolist(),
        "bars": torch.stack([shape.ends, shape.loaded(payload, 10.0)], dim=1).tolist(),
        **{name: _distances(name, task, own) for name in positioned.METHODS},
    }


def _networks_of_the_page() -> Networks:
    """Networks as they were trained when the page was made: another training rounds otherwise."""
    page = html.unescape(html_file("crane/positioning").read_text(encoding="utf-8"))
    packed = re.search(r'<script id="settings" type="text/plain">([^<]*)</script>', page)
    assert packed, "the page has no instrument"
    arrays = json.loads(zlib.decompress(base64.b64decode(packed[1])))["data"]["networks"]
    own = {
        name: FeedForward(
            View(4, range(4)),
            "identity",
            {key: torch.tensor(x, dtype=torch.float64) for key, x in parts.items()},
        )
        for name, parts in arrays.items()
    }
    return positioned.with_rates(**own)


def _distances(method: str, task: Task, own: Networks) -> list[float]:
    """Distances of the loaded tip from its targets after a method, NaN where it has no answer."""
    if method != "compensation":
        return positioning.errors(task, positioned.placement(method, task, own)).distance.tolist()
    distances = []
    for i in range(len(task)):
        one = slice(i, i + 1)
        alone = Task(task.targets[one], task.payload[one], task.starts[one], task.crane)
        try:
            placement = positioned.placement(method, alone, own)
        except ValueError:
            distances.append(math.nan)
        else:
            distances.append(positioning.errors(alone, placement).distance.item())
    return distances
