"""Files of arrays that are read whole or refused: an ``.npz`` without pickle that ends in its checksum.

A file is an archive that numpy reads by itself: arrays, and a header in JSON that says what they are. The
archive's comment, the last bytes of the file, holds the SHA-256 sum of all bytes before it, so that a file
that was cut or changed is refused. A right checksum does not make the content harmless: members are stored
uncompressed, their sizes are compared with the length of the file before they are read, and
nothing is executed.

Examples
--------
>>> import numpy as np
>>> from dexterity import sealed
>>> content = sealed.packed("grid", {"unit": "m"}, {"x": np.array([0.0, 1.0])})
>>> header, arrays = sealed.unpacked(content, "grid")
>>> header, arrays["x"].tolist()
({'unit': 'm'}, [0.0, 1.0])
"""

from __future__ import annotations

import hashlib
import io
import json
import struct
import tokenize
import zipfile
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["SealedFileError", "packed", "unpacked"]

_HEADER = "header"
_DIGITS = 2 * hashlib.sha256().digest_size


class SealedFileError(ValueError):
    """Content that is no sealed file of the kind asked for, or not all of one."""


def packed(kind: str, header: Mapping[str, Any], arrays: Mapping[str, NDArray[Any]]) -> bytes:
    """Return the bytes of a sealed file; equal contents make equal bytes.

    Parameters
    ----------
    kind
        What the file holds, in a word or two, such as ``"network"``.
    header
        What JSON can say: a mapping of texts to numbers, texts, truth values, None, lists and mappings.
    arrays
        Arrays of numbers, truth values or texts by name.

    Raises
    ------
    TypeError
        If JSON cannot say the header.
    ValueError
        If the header holds a NaN or an infinity, an array has the name ``header``, or holds objects.
    """
    if _HEADER in arrays:
        raise ValueError(f"arrays hold {_HEADER!r}, which is the header's name")
    text = json.dumps(header, ensure_ascii=False, allow_nan=False, sort_keys=True)
    members = {_HEADER: np.frombuffer(text.encode(), dtype=np.uint8), **arrays}
    archive = io.BytesIO()
    np.savez(archive, allow_pickle=False, **members)
    # The archive ends with the length of its comment, which is empty so far.
    body = archive.getvalue()[:-2] + struct.pack("<H", len(_comment(kind)) + _DIGITS)
    return body + _seal(kind, body)


def unpacked(content: bytes, kind: str) -> tuple[dict[str, Any], dict[str, NDArray[Any]]]:
    """Return header and arrays of a sealed file's bytes.

    Raises
    ------
    SealedFileError
        If the content is not whole, is of another kind, or is no archive of plain arrays with a header.
    """
    length = len(_comment(kind)) + _DIGITS
    body, end = content[:-length], content[-length:]
    if not end.startswith(_comment(kind)):
        raise SealedFileError(f"is no {kind} file, or its end is missing: it does not end in a checksum")
    if end != _seal(kind, body):
        raise SealedFileError("is corrupted: its content does not have the checksum that it ends in")
    try:
        _require_plain_members(content)
        with np.load(io.BytesIO(content), allow_pickle=False) as archive:
            arrays = {name: archive[name] for name in archive.files}
        header = json.loads(arrays.pop(_HEADER).tobytes())
    except SealedFileError:
        raise
    except _UNREADABLE as error:
        raise _unreadable(str(error)) from error
    if not isinstance(header, dict):
        raise SealedFileError(
            f"cannot be read as an archive of arrays: its header is a {type(header).__name__}"
        )
    return header, arrays


def _unreadable(reason: str) -> SealedFileError:
    return SealedFileError(f"cannot be read as an archive of arrays: {reason}")


_UNREADABLE = (
    zipfile.BadZipFile, EOFError, KeyError, TypeError, ValueError, AttributeError, OSError, RuntimeError,
    NotImplementedError, MemoryError, RecursionError, SyntaxError, tokenize.TokenError,
)  # fmt: skip


def _comment(kind: str) -> bytes:
    return f"dexterity {kind}, sha256 ".encode()


def _seal(kind: str, body: bytes) -> bytes:
    return _comment(kind) + hashlib.sha256(body).hexdigest().encode()


def _require_plain_members(content: bytes) -> None:
    """Refuse members that would unpack to more than the file holds, and arrays larger than their member."""
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        members = archive.infolist()
        for member in members:
            if member.compress_type != zipfile.ZIP_STORED or member.file_size != member.compress_size:
                raise SealedFileError(
                    f"cannot be read as an archive of arrays: {member.filename} is compressed"
                )
        if sum(member.file_size for member in members) > len(content):
            raise SealedFileError(
                "cannot be read as an archive of arrays: its members are longer than the file"
            )
        for member in members:
            with archive.open(member) as file:
                _require_size(file.read(), member.filename)


def _require_size(stored: bytes, name: str) -> None:
    file = io.BytesIO(stored)
    version = np.lib.format.read_magic(file)
    if version not in ((1, 0), (2, 0)):
        raise _unreadable(f"{name} has version {version}")
    read = np.lib.format.read_array_header_1_0 if version == (1, 0) else np.lib.format.read_array_header_2_0
    shape, _, dtype = read(file)
    if dtype.hasobject:
        raise SealedFileError(
            f"cannot be read as an archive of arrays: Object arrays are no data, {name} is one"
        )
    # In Python's integers, which do not overflow whatever shape a file claims.
    size = dtype.itemsize
    for length in shape:
        size *= length
    if size != len(stored) - file.tell():
        raise SealedFileError(
            f"cannot be read as an archive of arrays: {name} does not hold what its shape says"
        )
