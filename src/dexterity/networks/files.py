"""Files of trained networks: an ``.npz`` without pickle, with a card, and with a checksum at its end.

A file is an archive that numpy reads by itself: the arrays of the network, and a header in JSON that says
what they are. The archive's comment, the last bytes of the file, holds the SHA-256 sum of all bytes before
it, so that no file that was cut or changed is taken for a network. Equal networks make equal files.

Examples
--------
>>> import tempfile
>>> import dexterity as dx
>>> network = dx.networks.load_shipped(dx.networks.shipped()[0])
>>> with tempfile.TemporaryDirectory() as folder:
...     dx.networks.save(network, f"{folder}/network.npz", network.card)
...     dx.networks.load(f"{folder}/network.npz").card == network.card
True
"""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import torch
from torch import Tensor

from dexterity import checks, sealed, store
from dexterity.networks.card import Card
from dexterity.networks.feed_forward import FeedForward
from dexterity.networks.network import Network, View
from dexterity.networks.radial_basis import RadialBasis

__all__ = ["NetworkFileError", "load", "load_shipped", "save", "shipped"]

FORMAT = "dexterity-network"
"""What a header calls itself."""

VERSION = 1
"""Version of the format that is written, and the newest that is read."""

KIND = "network"
"""What a sealed file of this kind says that it holds."""

LARGEST = 1 << 26
"""Bytes that a file may have."""


class NetworkFileError(ValueError):
    """A file holds no network, or not all of it, or one of a later format."""


@checks.arguments(
    network=checks.Instance(Network), path=checks.path, card=checks.OrNone(checks.Instance(Mapping))
)
def save(network: Network, path: str | os.PathLike[str], card: Mapping[str, Any] | None = None) -> None:
    """Write a network to a file; the same network and card make the same bytes.

    Parameters
    ----------
    network
        A feed-forward or radial-basis network, on any device.
    path
        File to write, by custom with the ending ``.npz``; missing folders are created, an older file is
        replaced in one step.
    card
        What is worth knowing of the network: a card, or a mapping of what JSON can say, see
        :class:`dexterity.networks.card.Card`. The network's own card by default.

    Raises
    ------
    TypeError
        If the network is of an unknown kind or the card holds what JSON cannot say.
    ValueError
        If the card holds a NaN or an infinity, or the network has too many weights for a file.
    OSError
        If the file cannot be written.
    """
    content = _encoded(network, network.card if card is None else Card(card))
    if len(content) > LARGEST:
        raise ValueError(f"network needs {len(content)} bytes; a file has {LARGEST} at most")
    store.write_atomically(path, content)


@torch.inference_mode(False)  # its weights serve in every mode
@checks.arguments(path=checks.Instance((str, os.PathLike)))
def load(path: str | os.PathLike[str]) -> Network:
    """Return the network of a file, with its card.

    Nothing in the file is executed, and nothing is read that is larger than the file.

    Raises
    ------
    FileNotFoundError
        If there is no such file.
    NetworkFileError
        If the file is not whole, is no network, or is of a format that came later.
    """
    try:
        content = store.read_bytes(path, LARGEST)
    except ValueError as error:
        raise NetworkFileError(str(error)) from error
    try:
        # On the CPU, whatever torch's default device is.
        with torch.device("cpu"):
            return _network(*sealed.unpacked(content, KIND))
    except (NetworkFileError, sealed.SealedFileError) as error:
        raise NetworkFileError(f"{os.fspath(path)} {error}") from error.__cause__
    except (KeyError, TypeError, ValueError, OverflowError) as error:
        raise NetworkFileError(f"{os.fspath(path)} holds no network that can be built: {error}") from error


def shipped() -> tuple[str, ...]:
    """Return the names of the networks that come with the package, sorted."""
    return tuple(sorted(path.stem for path in (store.data_path() / "networks").glob("*.npz")))


def load_shipped(name: str) -> Network:
    """Return a network that comes with the package, with its card.

    Raises
    ------
    ValueError
        If no network of this name comes with the package.
    """
    checks.choice(name, "name", shipped())
    return load(store.data_path("networks", f"{name}.npz"))


# ---- networks and headers --------------------------------------------------------------------------


def _network(header: Mapping[str, Any], arrays: Mapping[str, np.ndarray]) -> Network:
    if header.get("format") != FORMAT:
        raise NetworkFileError(f"is no network file: its header says {header.get('format')!r}")
    if header.get("version") != VERSION:
        raise NetworkFileError(
            f"has version {header.get('version')!r} of the format; this release reads version {VERSION}"
        )
    weights = dict(arrays)
    if strange := [name for name, array in weights.items() if array.dtype != np.float64]:
        raise ValueError(f"its array {strange[0]} is of {weights[strange[0]].dtype}; float64 is needed")
    view = View(header["joints"], header["inputs"], weights.pop("carriers"))
    kind = checks.choice(header["kind"], "kind", _KINDS)
    network = _KINDS[kind](view, weights, **header["options"])
    network.card = header["card"]
    return network


def _feed_forward(view: View, arrays: Mapping[str, np.ndarray], readout: Any) -> Network:
    return FeedForward(view, readout, arrays)


_KINDS: Mapping[str, Callable[..., Network]] = {"feed-forward": _feed_forward, "radial-basis": RadialBasis}


def _header(network: Network, card: Card) -> dict[str, Any]:
    return {
        "format": FORMAT,
        "version": VERSION,
        **_kind(network),
        "joints": network.joints,
        "inputs": list(network.inputs),
        "card": card.to_dict(),
    }


def _kind(network: Network) -> dict[str, Any]:
    if isinstance(network, FeedForward):
        return {"kind": "feed-forward", "options": {"readout": network.readout}}
    if isinstance(network, RadialBasis):
        return {"kind": "radial-basis", "options": {}}
    raise TypeError(f"network is a {type(network).__name__}; FeedForward and RadialBasis can be saved")


# ---- bytes -----------------------------------------------------------------------------------------


def _encoded(network: Network, card: Card) -> bytes:
    state: Mapping[str, Tensor] = network.state_dict()
    arrays = {name.removeprefix("view."): state[name].cpu().numpy() for name in sorted(state)}
    return sealed.packed(KIND, _header(network, card), arrays)
