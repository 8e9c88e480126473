"""The live instrument of part I: joints and base of the vehicle, both indices exactly and by the shipped networks."""

from __future__ import annotations

from collections.abc import Mapping
from typing import cast

import numpy as np
import torch
from scipy import optimize

from dexterity import networks, robots, sampling, symbolic, tasks
from dexterity.codegen import pose
from dexterity.indices import Index
from dexterity.networks import domain_export, export
from dexterity.networks.domain import Guarded
from dexterity.sampling import TaskSector
from dexterity_study.page.instrument import Choice, Drawing, Instrument, Readout, Slider, script_beside
from dexterity_study.uvms.indices.experiment import MOTIONS

INDICES = {"w": "manipulability", "kci": "kinematic_conditioning"}
"""Indices by their names in the script."""

TITLES = {"w": "w", "kci": "KCI"}
"""What the reader calls them."""

KINDS = {"FeedForward": "feed-forward", "RadialBasis": "radial-basis"}
"""Networks by the ends of their names in the script."""

SAMPLES = 1000
"""Configurations of the space of KCI's networks among which one is ranked."""

ELLIPSE_SCALE = 0.25
"""Length in the drawing of a speed of 1 m/s [m]."""


def instrument() -> Instrument:
    """Return the instrument, its presets and ranks computed now."""
    return Instrument(
        title="Dexterity of the vehicle-manipulator: exact indices and networks",
        hint="Drag a circle in a drawing, move a slider, or begin with a preset. Where do the networks stop being right?",
        controls=[*_sliders(), Choice("task", "task", list(tasks.TASKS))],
        readouts={
            "Manipulability w": _readouts("w"),
            "KCI about the world origin": _readouts("kci"),
            "KCI about the tool": [Readout("kciTool", "exact", digits=4)],
            f"Task, among {SAMPLES:,} samples": [
                Readout("taskIndex", "its index"),
                Readout("taskRank", "better than", "%"),
            ],
        },
        drawings=[
            Drawing("side", "Side view: y to the right, z upwards", (-1.35, 2.25, -1.1, 1.1)),
            Drawing("top", "Top view: y to the right, x downwards", (-1.35, 2.25, -1.1, 1.1)),
        ],
        modules=_modules(),
        script=script_beside(__package__),
        presets={name: dict(zip(_names(), q, strict=True)) for name, q in presets().items()},
        data={
            "joints": list(_names()),
            "vehicle": list(robots.describe("uvms").vehicle_size or ()),
            "ellipseScale": ELLIPSE_SCALE,
            "taskPoint": list(cast(TaskSector, sampling.uvms_space("kinematic_conditioning")).task_point),
            "indexOfTask": {task.name: task.index for task in tasks.TASKS.values()},
            "samples": {name: np.sort(values).round(9).tolist() for name, values in _sampled().items()},
        },
    )


def presets() -> Mapping[str, list[float]]:
    """Return joint values: reference, best in the trained space, worst case found for a network, and a singularity."""
    found = {"Reference": [0.0] * 12}
    found |= {f"Best {title}": best(name) for name, title in TITLES.items()}
    for name, title in TITLES.items():
        shipped = [networks.load_shipped(_file(INDICES[name], kind)) for kind in KINDS.values()]
        worst = max(shipped, key=lambda network: network.card["worst_case"]["error"])
        found[f"Worst found: {title}, {KINDS[worst.card['kind']]}"] = list(worst.card["worst_case"]["q"])
    motion = MOTIONS["UVMS, roll"]
    sweep = motion.configurations(motion.angles(181))
    w = Index("manipulability").bind(robots.uvms())(sweep)
    return found | {"Singularity": sweep[int(w.argmin())].tolist()}


def best(name: str) -> list[float]:
    """Climb to a configuration with a large index in the space that its networks were trained on.

    Parameters
    ----------
    name
        One of :data:`INDICES`.
    """
    space, index = sampling.uvms_space(INDICES[name]), Index(INDICES[name]).bind(robots.uvms())

    def falls(u: np.ndarray) -> tuple[float, np.ndarray]:
        unit = torch.tensor(u, requires_grad=True)
        value = -index(space.from_unit(unit))
        value.backward()
        return value.item(), unit.grad.numpy()  # type: ignore[union-attr]

    q = sampling.sobol(space, SAMPLES, 0)
    start = space.to_unit(q[int(index(q).argmax())]).numpy().clip(0, 1)
    climbed = optimize.minimize(falls, start, jac=True, method="L-BFGS-B", bounds=[(0, 1)] * len(start))
    return space.from_unit(torch.from_numpy(climbed.x)).tolist()


def guarded(name: str, kind: str) -> Guarded:
    """Return a shipped network with the space that it was trained on, by the names of :data:`INDICES` and `KINDS`."""
    index = INDICES[name]
    return Guarded(networks.load_shipped(_file(index, KINDS[kind])), sampling.uvms_space(index))


def _file(index: str, kind: str) -> str:
    return f"uvms-{index.replace('_', '-')}-{kind}"


def _names() -> tuple[str, ...]:
    return tuple(f"q{joint}" for joint in range(1, 13))


def _sliders() -> list[Slider]:
    chain = robots.uvms()
    made = []
    for name, joint, kind in zip(_names(), chain.joint_names, chain.kinds, strict=True):
        if kind == "prismatic":
            made.append(Slider(name, joint, "m", -1.0, 1.0, 0.01, 0.0))
        else:
            made.append(Slider(name, joint, "°", -np.pi, np.pi, np.radians(0.5), 0.0))
    return made


def _readouts(name: str) -> list[Readout]:
    shown = [Readout(name, "exact", digits=4)]
    for kind, title in KINDS.items():
        shown += [
            Readout(f"{name}{kind}", title, digits=4),
            Readout(f"{name}{kind}Error", "its error", "%", digits=2, floor=1e-5),
        ]
    return [*shown, Readout(f"{name}Inside", "in trained space")]


def _modules() -> dict[str, str]:
    chain = robots.uvms()
    indices = {name: Index(index) for name, index in INDICES.items()}
    indices["kciTool"] = Index("kinematic_conditioning", "geometric")
    modules = {
        name: symbolic.javascript_module(symbolic.derive(chain, index)) for name, index in indices.items()
    }
    for name in INDICES:
        for kind in KINDS:
            network = guarded(name, kind)
            modules[f"{name}{kind}"] = export.javascript_module(network.network)
        modules[f"{name}Space"] = domain_export.javascript_module(network)
    return modules | {"kinematics": pose.javascript_module(chain)}


def _sampled() -> Mapping[str, np.ndarray]:
    """Return the values of both indices at configurations of the space of KCI's networks."""
    q = sampling.sobol(sampling.uvms_space("kinematic_conditioning"), SAMPLES, 0)
    return {name: Index(index).bind(robots.uvms())(q).numpy() for name, index in INDICES.items()}
