"""Tensors and a header in a sealed file, written as a whole or not at all, see :mod:`dexterity.sealed`.

Examples
--------
>>> import tempfile
>>> import torch
>>> from dexterity.workspace.archive import read_archive, write_archive
>>> with tempfile.TemporaryDirectory() as folder:
...     write_archive(
...         f"{folder}/arm.npz", "arm", {"arm": "PUMA 560"}, {"links": torch.ones(4)}
...     )
...     read_archive(f"{folder}/arm.npz", "arm")[0]
{'arm': 'PUMA 560'}
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import Any

import torch
from torch import Tensor

from dexterity import checks, sealed, store

__all__ = ["ArchiveError", "read_archive", "require_like", "write_archive"]


class ArchiveError(ValueError):
    """A file is no archive, not all of one, or one of something else."""


@checks.arguments(
    path=checks.path,
    kind=checks.name,
    header=checks.Instance(Mapping),
    tensors=checks.Named(checks.Instance(Tensor)),
)
def write_archive(
    path: str | os.PathLike[str], kind: str, header: Mapping[str, Any], tensors: Mapping[str, Tensor]
) -> None:
    """Write tensors under their names, and a header that JSON can say.

    Parameters
    ----------
    path
        File to write.
    kind
        What the file holds, in a word or two.
    header, tensors
        Its content.

    Raises
    ------
    ValueError
        If a tensor has the name that the header takes, or the header holds a NaN.
    TypeError
        If JSON cannot say the header.
    OSError
        If the file cannot be written.
    """
    arrays = {name: tensor.detach().cpu().numpy() for name, tensor in tensors.items()}
    store.write_atomically(path, sealed.packed(kind, header, arrays))


@checks.arguments(path=checks.path, kind=checks.name)
def read_archive(path: str | os.PathLike[str], kind: str) -> tuple[dict[str, Any], dict[str, Tensor]]:
    """Return the header and the tensors of a file; nothing in it is executed.

    Raises
    ------
    FileNotFoundError
        If there is no such file.
    ArchiveError
        If the file is not whole, is of another kind, or is no archive.
    """
    try:
        content = store.read_bytes(path)
    except ValueError as error:
        raise ArchiveError(str(error)) from error
    try:
        header, arrays = sealed.unpacked(content, kind)
        return header, {name: torch.from_numpy(array) for name, array in arrays.items()}
    except (sealed.SealedFileError, TypeError) as error:
        raise ArchiveError(f"{os.fspath(path)} {error}") from error


def require_like(tensors: Mapping[str, Tensor], wanted: Mapping[str, Tensor]) -> None:
    """Refuse tensors that have not the names, shapes and dtypes of others, or are not finite.

    Raises
    ------
    ArchiveError
        If a tensor is missing, not wanted, of another shape or dtype, or not finite.
    """
    if other := sorted(tensors.keys() ^ wanted.keys()):
        raise ArchiveError(f"it lacks or has in excess: {', '.join(other)}")
    for name, tensor in tensors.items():
        like = wanted[name]
        if tensor.shape != like.shape or tensor.dtype != like.dtype:
            raise ArchiveError(
                f"{name} is {tensor.dtype} of shape {tuple(tensor.shape)}; "
                f"{like.dtype} of shape {tuple(like.shape)} is needed"
            )
        if not tensor.isfinite().all():
            raise ArchiveError(f"{name} is not finite")
