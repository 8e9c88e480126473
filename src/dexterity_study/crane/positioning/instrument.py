"""The live instrument of the part on the crane: strokes, payload, sag, and where four methods put the tip."""

from __future__ import annotations

from functools import cache
from typing import Any

import torch

from dexterity import crane
from dexterity.crane import positioning
from dexterity.crane.positioning import DescentOptions, Placement, Task
from dexterity.crane.positioning.export import Networks, javascript_module
from dexterity.networks.feed_forward import FeedForward
from dexterity_study.crane.cases import BOX
from dexterity_study.crane.positioning.experiment import DIRECT, GENETIC, INVERSE, MODULAR, trained
from dexterity_study.page.instrument import Choice, Drawing, Instrument, Readout, Slider, script_beside

METHODS = {
    "compensation": "1 aim off",
    "direct": "2 direct network",
    "modular": "3 two networks",
    "inverseNetwork": "4 inverse network",
}
"""Functions of the exported module for the four methods, and what they are called."""

MAGNIFIED = {"10 times": 10.0, "30 times": 30.0, "as it is": 1.0}
"""How the sag may be drawn."""

_STROKES = ("s1", "s2", "s3")


SEED, EPOCHS = 0, 100
"""Training of the networks, that of the live run in the chapter."""


@cache
def networks() -> Networks:
    """Train the networks."""
    return with_rates(*(trained(method, SEED, EPOCHS) for method in (GENETIC, DIRECT, MODULAR, INVERSE)))


def placement(method: str, task: Task, own: Networks) -> Placement:
    """Let one of `METHODS` answer a task, the first with the rigid crane solved in closed form.

    Raises
    ------
    ValueError
        If the rigid crane does not reach where it is to aim.
    """
    if method == "compensation":
        return positioning.compensate(task, positioning.network_sag(own.correction))
    if method == "direct":
        return positioning.descend(task, own.direct, own.direct_options)
    if method == "modular":
        return positioning.descend(task, own.modular, own.modular_options)
    return positioning.by_inverse_network(task, own.inverse)


def instrument() -> Instrument:
    """Return an instrument for the crane's strokes and payload."""
    own, machine = networks(), crane.patu655()
    names = ("lift stroke s₁", "jib stroke s₂", "extension s₃")
    chosen = presets(own)
    first = next(iter(chosen.values()))
    (left, right), (bottom, top) = BOX
    return Instrument(
        title="Strokes, payload, sag, and where four methods put the tip",
        hint="Drag the tip, or change strokes and payload. The four methods try to bring the loaded tip to where "
        "the tip of the rigid crane is.",
        controls=[
            *(
                Slider(name, label, "m", low, high, 0.005, first[name])
                for name, label, low, high in zip(_STROKES, names, machine.lower, machine.upper, strict=True)
            ),
            Slider("payload", "payload", "kg", 0.0, machine.rating, 5.0, first["payload"]),
            Choice("magnified", "sag is drawn", list(MAGNIFIED)),
        ],
        readouts={
            "Rigid tip": [Readout("x", "x", "m", digits=4), Readout("y", "y", "m", digits=4)],
            "Sag": [
                Readout("sagX", "along x", "mm"),
                Readout("sagY", "along y", "mm"),
                Readout("sag", "distance", "mm"),
            ],
            "Tip off its target": [
                *(Readout(name, label, "mm", floor=1e-5) for name, label in METHODS.items()),
                Readout("stopped", "asks beyond a cylinder's end"),
            ],
        },
        drawings=[
            Drawing(
                "side",
                "Side view: the rigid crane (thin) and the loaded one, its sag magnified",
                (left - 1.2, right + 1.2, bottom - 0.6, top + 0.6),
            ),
            Drawing(
                "near",
                "Around the target: where the loaded tip ends without compensation (0) and by methods 1 to 4",
                (-1.25, 1.25, -1.25, 1.25),
            ),
        ],
        modules={"crane": javascript_module(machine, own)},
        script=script_beside(__package__),
        presets=chosen,
        data={"methods": METHODS, "magnified": MAGNIFIED, "networks": arrays(own)},
    )


def arrays(own: Networks) -> dict[str, dict[str, Any]]:
    """Return the numbers of the networks, with which the page can be checked."""
    return {
        name: {
            key: array.tolist() for key, array in getattr(own, name).state_dict().items() if "." not in key
        }
        for name in ("correction", "direct", "modular", "inverse")
    }


def with_rates(
    correction: FeedForward, direct: FeedForward, modular: FeedForward, inverse: FeedForward
) -> Networks:
    """Join networks, and take the chapter's options of the descents."""
    task = positioning.thesis_task()
    direct_options, modular_options = (
        DescentOptions(tolerance=1e-7, rate=positioning.safe_rate(network, task))
        for network in (direct, modular)
    )
    return Networks(correction, direct, modular, inverse, direct_options, modular_options)


def presets(own: Networks) -> dict[str, dict[str, float]]:
    """Return test points of the thesis: of the largest sag, of middle sag, and the worst one of each method."""
    task, machine = positioning.thesis_task(), crane.patu655()
    strokes = crane.inverse(task.targets, crane=machine).strokes
    possible = crane.within_limits(strokes, machine).all(-1)
    sag = crane.deflection(strokes, task.payload, machine).norm(dim=-1).where(possible, torch.nan)

    def at(point: int) -> dict[str, float]:
        # Rounding must not put a stroke beyond an end.
        inside = [
            min(max(value, low), high)
            for value, low, high in zip(strokes[point].tolist(), machine.lower, machine.upper, strict=True)
        ]
        return dict(zip(_STROKES, inside, strict=True)) | {"payload": task.payload[point].item()}

    worst: dict[int, list[str]] = {}
    for name in METHODS:
        point = positioning.errors(task, placement(name, task, own)).distance.where(possible, 0.0).argmax()
        worst.setdefault(int(point), []).append(METHODS[name][0])
    return {
        "Largest sag": at(int(sag.nan_to_num(0.0).argmax())),
        "Middle sag": at(int((sag - sag.nanmedian()).abs().nan_to_num(torch.inf).argmin())),
        **{f"Worst of method {' and '.join(methods)}": at(point) for point, methods in worst.items()},
    }
