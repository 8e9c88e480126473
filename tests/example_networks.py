"""Networks of every kind with random weights: on the joints alone, or on the world's origin as well."""

from collections.abc import Mapping

import numpy as np
import torch

import dexterity as dx
from dexterity.networks.feed_forward import FeedForward, Readout
from dexterity.networks.network import Network, View
from dexterity.networks.radial_basis import RadialBasis

UVMS = dx.robots.uvms()
JOINTS = UVMS.joints
PLAIN = View(JOINTS, [4, 5, 7, 8, 10])
CARRIED = View(JOINTS, [6, 8, 9], UVMS.screws[:6])
READOUTS: tuple[Readout, ...] = ("identity", "reciprocal", "logarithm", "cone", "triple")


def random_configurations(rng: np.random.Generator, rows: int) -> torch.Tensor:
    """Configurations (rows, 12) within one radian or metre."""
    return torch.from_numpy(rng.uniform(-1, 1, (rows, JOINTS)))


def feed_forward(rng: np.random.Generator, readout: Readout, view: View = PLAIN, neurons: int = 5) -> Network:
    """Return a network scaled to values between 1 and 2."""
    q, values = random_configurations(rng, 64), torch.from_numpy(rng.uniform(1, 2, 64))
    seed = torch.Generator().manual_seed(int(rng.integers(1 << 31)))
    return FeedForward.untrained(view, neurons, q, values, seed, readout)


def radial_basis(rng: np.random.Generator, view: View = PLAIN, neurons: int = 6) -> Network:
    """Return a network with its centres among what is seen, and values of either sign."""
    scale = rng.uniform(0.5, 2, view.width)
    arrays = {
        "centres": view(random_configurations(rng, neurons)).numpy() * scale,
        "spread": 1.3,
        "output_weights": rng.normal(size=neurons),
        "output_bias": rng.normal(),
        "input_scale": scale,
    }
    return RadialBasis(view, arrays)


def examples() -> Mapping[str, Network]:
    """Every kind with every readout, on both views."""
    rng = np.random.default_rng(4)
    networks: dict[str, Network] = {}
    for seen, view in {"joints": PLAIN, "origin and joints": CARRIED}.items():
        for readout in READOUTS:
            networks[f"{readout}, {seen}"] = feed_forward(rng, readout, view)
        networks[f"radial basis, {seen}"] = radial_basis(rng, view)
    return networks
