"""Trials that were finished, stored so that a design that was killed goes on where it was.

A trial is one training, or several that were trained together. Its key names everything that it came from,
the source of what trains included, so that what is stored can never be taken for something else.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Any

import torch

from dexterity import store
from dexterity.networks import files
from dexterity.networks.files import NetworkFileError
from dexterity.networks.network import Network

__all__ = ["TrialStore", "source_key"]


@dataclass(frozen=True)
class TrialStore:
    """A folder of finished trials, each in the file of its network.

    Processes may share it: a file is written as a whole or not at all, and two that finish the same trial
    write the same.

    Attributes
    ----------
    folder
        It is made when the first trial is stored.
    """

    folder: Path

    def get(self, key: str) -> Network | None:
        """Return the network of a trial, with its record as the card.

        Returns
        -------
        The network, or None if the trial is not there or its file is damaged or of something else: such a
        trial is to be done again, and is replaced when it is stored.
        """
        try:
            network = files.load(self._path(key))
        except (FileNotFoundError, NetworkFileError):
            return None
        return network if network.card.get("trial") == key else None

    def put(self, key: str, network: Network, record: Mapping[str, Any]) -> None:
        """Store a trial.

        Parameters
        ----------
        key
            What :func:`dexterity.store.content_key` calls all that it came from.
        network
            What came out.
        record
            What else is to be known of it, in what JSON can say.

        Raises
        ------
        TypeError, ValueError
            If JSON cannot say what the record holds.
        OSError
            If the file cannot be written.
        """
        files.save(network, self._path(key), {**record, "trial": key})

    def _path(self, key: str) -> Path:
        return self.folder / f"{key}.npz"


def source_key(modules: Iterable[ModuleType]) -> str:
    """Name the source of modules, and the version of torch that they run on.

    Raises
    ------
    ValueError
        If a module has no file.
    """
    sources = {}
    for module in modules:
        file = getattr(module, "__file__", None)
        if file is None:
            raise ValueError(f"modules hold {module.__name__}, which has no file")
        sources[module.__name__] = Path(file).read_bytes()
    return store.content_key(sources, str(torch.__version__))
