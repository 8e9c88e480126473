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

import hashlib
import io
import json
import os
import struct
import zipfile
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from torch import Tensor

from dexterity import store
from dexterity.networks.feed_forward import FeedForward
from dexterity.networks.network import Network, View
from dexterity.networks.radial_basis import RadialBasis

__all__ = ["NetworkFileError", "load", "load_shipped", "save", "shipped"]

FORMAT = "dexterity-network"
"""What a header calls itself."""

VERSION = 1
"""Version of the format that is written, and the newest that is read."""

COMMENT = b"dexterity network, sha256 "
"""What stands before the checksum at the end of a file."""


class NetworkFileError(ValueError):
    """A file holds no network, or not all of it, or one of a later format."""


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
        What is worth knowing of the network, in what JSON can say: numbers, texts, truth values, None, and
        lists and mappings of these. The network's own card by default.

    Raises
    ------
    TypeError
        If the network is of an unknown kind or the card holds what JSON cannot say.
    ValueError
        If the card holds a NaN or an infinity.
    OSError
        If the file cannot be written.
    """
    store.write_atomically(path, _encoded(network, network.card if card is None else card))


def load(path: str | os.PathLike[str]) -> Network:
    """Return the network of a file, with its card.

    Nothing in the file is executed.

    Raises
    ------
    FileNotFoundError
        If there is no such file.
    NetworkFileError
        If the file is not whole, is no network, or is of a format that came later.
    """
    content = Path(path).read_bytes()
    try:
        header, arrays = _decoded(content)
        return _network(header, arrays)
    except NetworkFileError as error:
        raise NetworkFileError(f"{os.fspath(path)} {error}") from error.__cause__
    except (KeyError, TypeError, ValueError) as error:
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
    if name not in shipped():
        raise ValueError(f"name is {name!r}; these networks come with the package: {list(shipped())}")
    return load(store.data_path("networks", f"{name}.npz"))


# ---- networks and headers --------------------------------------------------------------------------


def _network(header: Mapping[str, Any], arrays: Mapping[str, np.ndarray]) -> Network:
    if header.get("format") != FORMAT:
        raise NetworkFileError(f"is no network file: its header says {header.get('format')!r}")
    if header["version"] != VERSION:
        raise NetworkFileError(
            f"has version {header['version']} of the format; this release reads version {VERSION}"
        )
    own = dict(arrays)
    view = View(header["joints"], header["inputs"], own.pop("carriers"))
    build = _KINDS[header["kind"]]
    network = build(view, own, **header["options"])
    if not isinstance(header["card"], dict):
        raise ValueError(f"its card is a {type(header['card']).__name__}")
    network.card = header["card"]
    return network


def _feed_forward(view: View, arrays: Mapping[str, np.ndarray], readout: Any) -> Network:
    return FeedForward(view, readout, arrays)


_KINDS: Mapping[str, Callable[..., Network]] = {"feed-forward": _feed_forward, "radial-basis": RadialBasis}


def _header(network: Network, card: Mapping[str, Any]) -> dict[str, Any]:
    return {
        "format": FORMAT,
        "version": VERSION,
        **_kind(network),
        "joints": network.joints,
        "inputs": list(network.inputs),
        "card": card,
    }


def _kind(network: Network) -> dict[str, Any]:
    if isinstance(network, FeedForward):
        return {"kind": "feed-forward", "options": {"readout": network.readout}}
    if isinstance(network, RadialBasis):
        return {"kind": "radial-basis", "options": {}}
    if isinstance(network, RadialBasis):
        return {"kind": "radial-basis", "options": {}}
    raise TypeError(f"network is a {type(network).__name__}; FeedForward and RadialBasis can be saved")


# ---- bytes -----------------------------------------------------------------------------------------


def _encoded(network: Network, card: Mapping[str, Any]) -> bytes:
    header = json.dumps(_header(network, card), ensure_ascii=False, allow_nan=False, sort_keys=True)
    arrays = {"header": np.frombuffer(header.encode(), dtype=np.uint8)}
    state: Mapping[str, Tensor] = network.state_dict()
    for name in sorted(state):
        arrays[name.removeprefix("view.")] = state[name].cpu().numpy()
    archive = io.BytesIO()
    np.savez(archive, allow_pickle=False, **arrays)
    # The archive ends with the length of its comment, which is empty so far.
    content = archive.getvalue()[:-2] + struct.pack("<H", len(COMMENT) + 2 * hashlib.sha256().digest_size)
    return content + _checksum(content)


def _checksum(content: bytes) -> bytes:
    return COMMENT + hashlib.sha256(content).hexdigest().encode()


def _decoded(content: bytes) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
    """Header and arrays of a file's bytes, once the checksum has shown that they are whole."""
    body, end = content[: -len(_checksum(b""))], content[-len(_checksum(b"")) :]
    if not end.startswith(COMMENT):
        raise NetworkFileError("is no network file, or its end is missing: it does not end in a checksum")
    if end != _checksum(body):
        raise NetworkFileError("is corrupted: its content does not have the checksum that it ends in")
    try:
        with np.load(io.BytesIO(content), allow_pickle=False) as archive:
            arrays = {name: archive[name] for name in archive.files}
        return json.loads(arrays.pop("header").tobytes()), arrays
    except (zipfile.BadZipFile, EOFError, KeyError, ValueError) as error:
        raise NetworkFileError(f"cannot be read as an archive of arrays: {error}") from error
