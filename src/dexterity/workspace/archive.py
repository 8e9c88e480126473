"""Named arrays and a header in one file: an ``.npz`` without pickle, written as a whole or not at all.

Examples
--------
>>> import tempfile
>>> import torch
>>> from dexterity.workspace.archive import read_archive, write_archive
>>> with tempfile.TemporaryDirectory() as folder:
...     write_archive(
...         f"{folder}/arm.npz", {"arm": "PUMA 560"}, {"links": torch.ones(4)}
...     )
...     read_archive(f"{folder}/arm.npz")[0]
{'arm': 'PUMA 560'}
"""

from __future__ import annotations

import io
import json
import os
import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import torch
from torch import Tensor

from dexterity import store

__all__ = ["ArchiveError", "read_archive", "write_archive"]

_HEADER = "header"


class ArchiveError(ValueError):
    """A file is no archive, not all of one, or one of something else."""


def write_archive(
    path: str | os.PathLike[str], header: Mapping[str, Any], tensors: Mapping[str, Tensor]
) -> None:
    """Write tensors under their names, and a header that JSON can say.

    Raises
    ------
    ValueError
        If a tensor has the name that the header takes, or the header holds a NaN.
    TypeError
        If JSON cannot say the header.
    OSError
        If the file cannot be written.
    """
    if _HEADER in tensors:
        raise ValueError(f"tensors hold {_HEADER!r}, which is the header's name")
    text = json.dumps(header, ensure_ascii=False, allow_nan=False, sort_keys=True)
    arrays = {name: tensor.detach().cpu().numpy() for name, tensor in tensors.items()}
    content = io.BytesIO()
    np.savez(content, allow_pickle=False, **{_HEADER: np.frombuffer(text.encode(), np.uint8)}, **arrays)
    store.write_atomically(path, content.getvalue())


def read_archive(path: str | os.PathLike[str]) -> tuple[dict[str, Any], dict[str, Tensor]]:
    """Return the header and the tensors of a file; nothing in it is executed.

    Raises
    ------
    FileNotFoundError
        If there is no such file.
    ArchiveError
        If the file is not whole or is no archive.
    """
    content = Path(path).read_bytes()
    try:
        with np.load(io.BytesIO(content), allow_pickle=False) as archive:
            arrays = {name: archive[name] for name in archive.files}
        header = json.loads(arrays.pop(_HEADER).tobytes())
    except (zipfile.BadZipFile, EOFError, KeyError, TypeError, ValueError, AttributeError) as error:
        raise ArchiveError(f"{os.fspath(path)} cannot be read as an archive of arrays: {error}") from error
    if not isinstance(header, dict):
        raise ArchiveError(f"{os.fspath(path)} has a header that is a {type(header).__name__}")
    return header, {name: torch.from_numpy(array) for name, array in arrays.items()}
