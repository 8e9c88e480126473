"""The live instrument of part III: what an arm of the family reaches, by the exact rule and by two networks."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import cache

import torch

from dexterity import sampling
from dexterity.chain import Chain
from dexterity.codegen import pose
from dexterity.networks import domain_export
from dexterity.workspace import dataset, export, maps, training
from dexterity.workspace.export import Confidence
from dexterity.workspace.jacobian_net import Architecture, Inputs
from dexterity.workspace.reachability import LINK_NAMES
from dexterity_study.page.instrument import Choice, Drawing, Instrument, Readout, Slider, script_beside
from dexterity_study.workspace.puma.experiment import LINKS

NETWORKS: Mapping[str, tuple[Inputs, int, int]] = {
    "plane network": ("plane", 60_000, 10),
    "rotation network": ("rotation", 160_000, 14),
}
"""What each network takes, and the samples and epochs that it is trained with when the page is made."""

EXTENT = (-0.45, 0.95, -0.95, 0.95)
"""Section that is shown: distance from the first axis, and height above its foot [m]."""

CELL = 0.05
"""Side of the cells in which rule and network are compared [m]."""

THRESHOLD = 0.5
"""Confidence from which on a network counts a pose as in reach."""


def instrument() -> Instrument:
    """Return the instrument, with both networks trained now."""
    return Instrument(
        title="What an arm reaches: the exact rule and two networks",
        hint="Drag the tool, or change the arm and the pose. The plane network takes links, distance from axis 1 and height; "
        "the rotation network takes links, position and rotation matrix.",
        controls=[
            *(
                Slider(name, label, "m", 0.0, 0.6, 0.005, start)
                for name, label, start in zip(LINK_NAMES, ("d₃", "d₄", "a₂", "a₃"), LINKS, strict=True)
            ),
            Slider("radius", "distance", "m", 0.0, EXTENT[1], 0.005, 0.3),
            Slider("height", "height", "m", EXTENT[2], EXTENT[3], 0.005, 0.2),
            Slider("azimuth", "azimuth", "°", -math.pi, math.pi, math.radians(1), 0.0),
            *(
                Slider(f"turn{axis}", f"tool {axis}", "°", -math.pi, math.pi, math.radians(1), 0.0)
                for axis in "xyz"
            ),
            Choice("network", "map of", list(NETWORKS)),
        ],
        readouts={
            "Exact rule": [
                Readout("reach", "in reach"),
                Readout("margin", "margin", "m²", digits=2),
                Readout("w", "w", "m³"),
            ],
            "Confidence": [
                *(Readout(inputs, title, "%") for title, (inputs, _, _) in NETWORKS.items()),
                Readout("trained", "in trained space"),
            ],
            "Map, within the trained space": [
                Readout("invented", "network only", "%", digits=2),
                Readout("missed", "rule only", "%", digits=2),
            ],
        },
        drawings=[
            Drawing(
                "section",
                "Section through axis 1 and the tool. Blue: in reach by both; red: by the network only; purple: by the rule only; dashed: trained space",
                EXTENT,
            ),
        ],
        modules={
            "arm": export.javascript_module(),
            "free": pose.javascript_module(free_body()),
            "space": domain_export.space_module(trained_space()),
            **{NETWORKS[title][0]: export.confidence_module(confidence(title)) for title in NETWORKS},
        },
        script=script_beside(__package__),
        presets=presets(),
        data={
            "networks": {title: inputs for title, (inputs, _, _) in NETWORKS.items()},
            "links": LINK_NAMES,
            "threshold": THRESHOLD,
            "extent": EXTENT,
            "cell": CELL,
            "trained": maps.TRAINED_HALF_SIDE,
        },
    )


def presets() -> Mapping[str, Mapping[str, float]]:
    """Return arms and poses to begin with; the edge is where the PUMA's rule has its margin of zero."""

    def of(links: tuple[float, ...], radius: float, height: float) -> dict[str, float]:
        return {**dict(zip(LINK_NAMES, links, strict=True)), "radius": radius, "height": height}

    d3, d4, a2, a3 = LINKS
    outer = a2 + math.hypot(a3, d4)
    return {
        "PUMA 560": of(LINKS, 0.3, 0.2),
        "PUMA, fully stretched": of(LINKS, math.sqrt(0.5 * outer**2 + d3**2), math.sqrt(0.5) * outer),
        "PUMA, near axis 1": of(LINKS, d3, 0.2),
        "A shorter arm": of((0.1, 0.15, 0.3, 0.05), 0.25, 0.1),
        "A long upper arm": of((0.05, 0.1, 0.5, 0.0), 0.3, 0.1),
    }


def free_body() -> Chain:
    """Return a body that moves along x, y, z and turns about x, y, z: its pose is that of a tool."""
    return Chain(torch.eye(6, dtype=torch.float64), torch.eye(4, dtype=torch.float64), name="tool")


def trained_space() -> sampling.Box:
    """Return the space of links and position that the networks are trained on."""
    side = maps.TRAINED_HALF_SIDE
    return sampling.Box([0.0] * 4 + [-side] * 3, [dataset.LARGEST_LENGTH] * 4 + [side] * 3)


@cache
def confidence(title: str) -> Confidence:
    """Train one of :data:`NETWORKS`, smaller than in the chapter and with fewer samples; return its confidence."""
    inputs, samples, epochs = NETWORKS[title]
    architecture = Architecture(confidence=(64, 64), estimation=())
    jacobians = dataset.jacobian_data(5_000, seed=2, dynamics=False)  # the scaling is fitted to them
    network = training.network_for(architecture, inputs, "tool", jacobians, seed=0)
    rows = training.confidence_rows(network, dataset.confidence_data(samples, seed=1))
    options = training.Options(training.epochs(confidence=epochs), rate=3e-3, batch=512, validation=0.02)
    return Confidence.of(training.train(network, {"confidence": rows}, options, seed=0).network)
