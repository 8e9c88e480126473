"""Measurements on a real crane, repeated on cranes that are only simulated and differ from their model.

Source: Rouvinen (1999), section 4.6, Tables 4.2 and 4.3, Figs. 4.22–4.25. The sizes of the differences are
assumptions of the ledger; they were set before any comparison. Lengths are in [m].
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping

import numpy as np
import torch
from torch import Tensor

from dexterity import crane
from dexterity.crane import positioning
from dexterity.crane.existing import Differences, existing_crane, joint_forces
from dexterity.crane.positioning import GeneticInverseOptions, Task
from dexterity_study.crane.cases import CRANE, PAPER, Made, Rows, Values, seeded
from dexterity_study.engine.experiment import experiment

POINTS: tuple[tuple[float, float], ...] = tuple((x, y) for x in (2.2, 3.0, 3.8) for y in (1.75, 0.95, 0.15))
"""The nine measured points x, y, column by column from the top; an assumption of the ledger."""

PAYLOADS, READING_STEP = (0.0, 86.0, 172.0), 0.0005
"""Payloads [kg] and accuracy of the measurements, settings of the paper."""

_SAGS = ("nothing", "network", "structure")
WAYS = ("nothing, genetic", "network, genetic", *(f"{sag}, closed form" for sag in _SAGS))
"""Source of the predicted sag, and solver of the rigid crane; the first two ways are the thesis's."""

_EMPTY = (1, 1, 3, 3, 4)  # the way whose tip without payload is the point reached

REFERENCES = ("target", "point reached")
"""Points from which errors are measured, in Tables 4.2 and 4.3."""

ZEROED = "play, zeroed in the middle"
DIFFERENCES: Mapping[str, tuple[tuple[str, ...], float]] = {
    "nothing": (("play",), 0.0),
    **{part: ((part,), 1.0) for part in ("misalignment", "play", "stiffness")},
    ZEROED: (("play",), 1.0),
    "sensors": (("stroke_step", "reading_step"), 1.0),
    "all": ((), 1.0),
    "all, half as large": ((), 0.5),
    "all, twice as large": ((), 2.0),
}
"""What simulated cranes differ in from their model (all, if nothing is named), and by how many times its size.

Zeroed: the model was set right, empty, at the middle point, so that only a change of side matters.
"""


@experiment(keys=("point", "payload"), **CRANE)
def model(seed: int) -> Rows:
    """Jib and jib cylinder of the model at the measured points, and errors of the structure's loop on itself."""
    task = positioning.thesis_task(POINTS, PAYLOADS)
    exact = positioning.uncompensated(task).strokes
    same = existing_crane(Differences(), seeded(seed))
    columns = {
        "jib_angle": crane.posture(exact).jib,
        "jib_cylinder": joint_forces(exact, task.payload).rods[:, 1],
        "structure": (task.targets - same.reading(_by_structure(task), task.payload)).norm(dim=-1),
    }
    for i, payload in enumerate(task.payload):
        metrics = {name: column[i] for name, column in columns.items()}
        yield {"point": i // len(PAYLOADS) + 1, "payload": payload.item(), **metrics}


@experiment(
    seeds=20,
    keys=("crane", "point"),
    arrays=("network_error", "errors", "means"),
    smoke={"cranes": 2, "epochs": 20, "generations": 100},
    assumes=tuple(f"crane-existing-{name}" for name in ("misalignment", "play", "stiffness", "sensors")),
    rtol=1e-3,
    atol=1e-6,
    **PAPER,
)
def measurements(
    seed: int, reading: Values, cranes: int = 3, epochs: int = 200, generations: int = 1000
) -> Made:
    """Readings on cranes that one controller drives open loop: one network and one run of the genetic algorithm.

    Rows say whether a crane is better off without compensation: by the thesis's way with all differences, and in
    closed form with play alone. Arrays: `network_error` (payloads), mean distance of the network's sag from the
    structure's; `errors` (cranes, ways, points, payloads, 2), target less reading with all differences; `means`
    (cranes, differences, references, ways), mean distances.
    """
    task, options = positioning.thesis_task(POINTS, PAYLOADS), GeneticInverseOptions(generations=generations)
    strokes, network_error = _controller(task, 1000 + seed, epochs, options)
    rows, errors, means = [], [], []
    for i in range(cranes):
        read = {name: _errors(task, strokes, name, reading, cranes * seed + i) for name in DIFFERENCES}
        near = {name: distances(own, "target").mean(axis=-1) for name, own in read.items()}
        harmed = {name: near[name][2] < near[name][3] for name in ("play", ZEROED)}
        harmed["all"] = near["all"][0] < near["all"][1]
        rows += [
            {"crane": i, "point": at + 1, **{name: where[at] for name, where in harmed.items()}}
            for at in range(len(POINTS))
        ]
        errors.append(read["all"])
        means.append([[distances(own, to).mean((1, 2)) for to in REFERENCES] for own in read.values()])
    arrays = {"network_error": network_error.numpy(), "errors": errors, "means": means}
    return rows, {name: np.array(array, dtype=np.float32) for name, array in arrays.items()}


def from_reference(errors: np.ndarray, reference: str) -> np.ndarray:
    """Return errors (…, ways, points, payloads, 2) from the target as measured from a reference."""
    return errors if reference == "target" else errors - errors[..., _EMPTY, :, :1, :]


def distances(errors: np.ndarray, reference: str) -> np.ndarray:
    """Return the distances (…, ways, points, payloads) from a reference that belong to errors from the target."""
    return np.linalg.norm(from_reference(errors, reference), axis=-1)


def _controller(task: Task, seed: int, epochs: int, options: GeneticInverseOptions) -> tuple[Tensor, Tensor]:
    """Strokes of all ways (ways · N, 3), and the network's mean distance from the structure's sag (payloads)."""
    random = seeded(seed)
    sag = positioning.network_sag(positioning.correction_network(crane.training_set(), random, epochs=epochs))
    # Each point is searched once without sag, and from there once with the sag of each payload.
    empty = positioning.thesis_task(POINTS, PAYLOADS[:1])
    found = positioning.genetic_inverse(empty, empty.targets, random, options).strokes
    first = found.repeat_interleave(len(PAYLOADS), dim=0)
    aims = task.targets - sag(first, task.payload)
    onwards = dataclasses.replace(task, starts=first)
    second = positioning.genetic_inverse(onwards, aims, random, options).strokes
    exact = positioning.uncompensated(task).strokes
    closed = positioning.compensate(task, sag).strokes
    strokes = torch.cat([first, second, exact, closed, _by_structure(task)])
    away = sag(exact, task.payload) - crane.deflection(exact, task.payload)
    return strokes, away.norm(dim=-1).reshape(len(POINTS), -1).mean(0)


def _by_structure(task: Task) -> Tensor:
    return positioning.compensate(task, positioning.linear_sag(), corrections=10, tolerance=1e-7).strokes


def _errors(task: Task, strokes: Tensor, name: str, reading: Values, seed: int) -> np.ndarray:
    """Target less reading (ways, points, payloads, 2) on the crane of a seed with some differences."""
    sizes = {part: reading[f"crane-existing-{part}"] for part in ("misalignment", "play", "stiffness")}
    sizes |= {"stroke_step": reading["crane-existing-sensors"], "reading_step": READING_STEP}
    parts, size = DIFFERENCES[name]
    differences = Differences(**{part: size * sizes[part] for part in parts or sizes})
    existing = existing_crane(differences, seeded(seed))
    if name == ZEROED:
        existing = existing.zeroed(crane.inverse(POINTS[len(POINTS) // 2]).strokes)
    read = existing.reading(strokes, task.payload.repeat(len(WAYS)))
    return (task.targets.repeat(len(WAYS), 1) - read).reshape(len(WAYS), len(POINTS), -1, 2).numpy()
