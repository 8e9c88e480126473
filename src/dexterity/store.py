"""Content keys, atomic files, and the place where the package's data lies.

A content key names a value by what it is: equal values have equal keys in every process and on every
machine, and values that a computation could tell apart have different ones. Results are remembered
under such keys.

Examples
--------
>>> from dexterity import store
>>> store.content_key("puma560", 1.0) == store.content_key("puma560", 1)
False
>>> store.data_path("robots", "puma560.toml").is_file()
True
"""

import contextlib
import dataclasses
import functools
import hashlib
import itertools
import math
import os
import secrets
import stat
import struct
import time
import tomllib
from collections.abc import Iterator, Mapping
from enum import Enum
from pathlib import Path
from typing import Any

import numpy as np
import torch

PACKAGE = Path(__file__).resolve().parent
"""Folder of the modules of this package."""


def repository() -> Path | None:
    """Return the root of the source tree that this package runs from.

    Returns
    -------
    The folder with `pyproject.toml`, or None when the package is installed from a wheel.
    """
    root = PACKAGE.parents[1]
    in_source_tree = not (PACKAGE / "_data").exists() and (root / "pyproject.toml").is_file()
    return root if in_source_tree else None


def data_path(*parts: str) -> Path:
    """Return the path of a data file or folder, from the source tree or from an installed wheel.

    Parameters
    ----------
    parts
        Names of folders and of a file below `data/`, such as `"robots", "puma560.toml"`; none for
        `data/` itself.

    Raises
    ------
    FileNotFoundError
        If there is no such file or folder.
    """
    root = repository()
    path = (root / "data" if root else PACKAGE / "_data").joinpath(*parts)
    if not path.exists():
        raise FileNotFoundError(f"there is no data file {'/'.join(parts) or 'data'!r}: {path} does not exist")
    return path


def read_toml(path: str | os.PathLike[str]) -> dict[str, Any]:
    """Read a TOML file, which may begin with a byte order mark.

    Raises
    ------
    FileNotFoundError
        If there is no such file.
    ValueError
        If it is no file, is larger than 16 MB, has a line of more than 10 000 characters, is nested too
        deeply, or is no TOML in UTF-8; the error names the file.
    """
    content, path = read_bytes(path, _LARGEST_TOML), Path(path)
    try:
        text = content.decode("utf-8-sig")
        # A key of very many parts takes tomllib minutes.
        for number, line in enumerate(text.splitlines(), start=1):
            if len(line) > _LONGEST_LINE:
                raise ValueError(f"line {number} has more than {_LONGEST_LINE} characters")
        return tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        raise ValueError(f"{path.name} cannot be read as TOML: {error}") from error


_LARGEST_TOML, _LONGEST_LINE = 16_000_000, 10_000


def read_bytes(path: str | os.PathLike[str], largest: int | None = None) -> bytes:
    """Return the content of a plain file.

    Parameters
    ----------
    path
        The file.
    largest
        Bytes that are read at most; None for no limit.

    Raises
    ------
    FileNotFoundError
        If there is no such file.
    ValueError
        If it is a folder, a pipe or the like, has more bytes, or no file can have its name, which is told.
    """
    try:
        found = Path(path).stat()
    except ValueError as error:
        raise ValueError(f"{os.fspath(path)!r} names no file: {error}") from error
    if not stat.S_ISREG(found.st_mode):
        raise ValueError(f"{os.fspath(path)} is no plain file")
    if largest is not None and found.st_size > largest:
        raise ValueError(f"{os.fspath(path)} has {found.st_size} bytes; at most {largest} are read")
    return Path(path).read_bytes()


def write_atomically(path: str | os.PathLike[str], content: str | bytes) -> None:
    """Write a whole file or nothing, and replace an older one in a single step.

    A reader sees the old content or the new, never a part. Missing parent folders are created. When
    writing fails, the older file is as it was and no part of the new one is left behind.

    Parameters
    ----------
    path
        File to write.
    content
        Text, written as UTF-8 with its line ends kept, or bytes.

    Raises
    ------
    TypeError
        If `content` is neither text nor bytes.
    OSError
        If the file cannot be written.
    """
    if not isinstance(content, str | bytes):
        raise TypeError(f"content is {type(content).__name__}; write_atomically writes str or bytes")
    if Path(path).is_dir():
        raise IsADirectoryError(f"{os.fspath(path)} is a folder; a file was to take its place")
    with _written({Path(path): content.encode() if isinstance(content, str) else content}) as temporaries:
        for target, temporary in temporaries.items():
            temporary.replace(target)


@contextlib.contextmanager
def _written(contents: Mapping[Path, bytes]) -> Iterator[dict[Path, Path]]:
    """Write contents whole to files beside their targets; what is left of them at the end is removed."""
    temporaries: dict[Path, Path] = {}
    try:
        for target, content in contents.items():
            target.parent.mkdir(parents=True, exist_ok=True)
            # In the same folder, because a replacement is atomic only within one file system.
            temporaries[target] = target.with_name(f".{secrets.token_hex(8)}.tmp")
            with temporaries[target].open("xb") as file:
                file.write(content)
                file.flush()
                os.fsync(file.fileno())
        yield temporaries
    finally:
        for target, temporary in temporaries.items():
            temporary.unlink(missing_ok=True)
            _sweep(target.parent.resolve())


@functools.cache
def _sweep(folder: Path) -> None:
    """Remove what writers that were killed more than a day ago have left, once for each folder."""
    for leftover in folder.glob(f".{'[0-9a-f]' * 16}.tmp"):
        with contextlib.suppress(OSError):
            if leftover.stat().st_mtime < time.time() - _A_DAY:
                leftover.unlink()


_A_DAY = 86_400.0


def write_set(
    folder: str | os.PathLike[str], sums: str, files: Mapping[str, str | bytes]
) -> tuple[Path, ...]:
    """Write files that belong together, so that a reader notices where a writing was stopped halfway.

    All are written beside their places before the first one takes it: where the disk is full or a name is
    taken by a folder, an older set stays as it was. Then an older list of checksums is removed, and the new
    one takes its place last, in the format of ``sha256sum``. Missing folders are created.

    Parameters
    ----------
    folder
        Where to.
    sums
        Name of the list.
    files
        Contents by name.

    Returns
    -------
    The files, in the order of their names in `files`.

    Raises
    ------
    ValueError
        If a name is none of a file in the folder, such as ``"../x"``.
    OSError
        If a file cannot be written.
    """
    root = Path(folder)
    encoded = {name: text.encode() if isinstance(text, str) else text for name, text in files.items()}
    if strange := [name for name in (*files, sums) if Path(name).name != name or name in ("", "..")]:
        raise ValueError(f"files holds {strange[0]!r}, which is no name of a file in the folder")
    listed = "".join(f"{_sum(content)}  {name}\n" for name, content in encoded.items())
    contents = {root / name: content for name, content in {**encoded, sums: listed.encode()}.items()}
    for target in contents:
        if target.is_dir():
            raise IsADirectoryError(f"{target} is a folder; a file was to take its place")
    with _written(contents) as temporaries:
        (root / sums).unlink(missing_ok=True)
        for target, temporary in temporaries.items():
            temporary.replace(target)
    return tuple(root / name for name in files)


def read_set(folder: str | os.PathLike[str], sums: str) -> dict[str, bytes]:
    """Return the contents of files that :func:`write_set` wrote, by name.

    Raises
    ------
    FileNotFoundError
        If a file or the list of checksums is missing.
    ValueError
        If a file does not have the checksum that the list gives, or the list is none.
    """
    root, contents = Path(folder), dict[str, bytes]()
    for line in read_bytes(root / sums).decode(errors="replace").splitlines():
        expected, _, name = line.partition("  ")
        if not name or Path(name).name != name:
            raise ValueError(f"{root / sums} is no list of checksums: it holds {line[:80]!r}")
        contents[name] = read_bytes(root / name)
        if _sum(contents[name]) != expected:
            raise ValueError(
                f"{root / name} is not the file that {sums} was written for; write the set again"
            )
    return contents


def _sum(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()


def content_key(*parts: object) -> str:
    """Name values by their content.

    Types are part of the content: 1, 1.0, True and "1" have four different keys, and so have a list and
    a tuple. The order of a mapping does not count. A float counts by its bits, except that every NaN is
    the same; arrays and tensors by dtype, shape and bytes (not by device or memory layout); dataclasses
    by qualified name and fields; enumerations by qualified name and member.

    Parameters
    ----------
    parts
        None, bool, int, float, str, bytes, numpy scalars and arrays, dense torch tensors, enumerations,
        and tuples, lists, mappings and dataclasses of these.

    Returns
    -------
    Sixteen hexadecimal digits.

    Raises
    ------
    TypeError
        If a part, or something within it, is of another type.
    """
    return hashlib.sha256(_canonical(parts)).hexdigest()[:16]


def _canonical(value: object) -> bytes:
    """Encode a value so that no other value has the same encoding: each piece carries its tag and length."""
    if isinstance(value, Enum):
        return _tagged("enum", _qualified_name(value), value.name.encode())
    if isinstance(value, Mapping):
        items = sorted((_canonical(key), _canonical(item)) for key, item in value.items())
        return _tagged("mapping", *itertools.chain.from_iterable(items))
    if isinstance(value, np.ndarray | np.generic):
        return _canonical_array(value)
    if isinstance(value, torch.Tensor):
        return _canonical_tensor(value)
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        fields = ((field.name, getattr(value, field.name)) for field in dataclasses.fields(value))
        return _tagged("dataclass", _qualified_name(value), *map(_canonical, fields))
    return _canonical_builtin(value)


def _canonical_builtin(value: object) -> bytes:
    """Encode a built-in value; by its exact type, since a subclass may mean something else."""
    kind = type(value).__name__
    if value is None:
        return _tagged(kind)
    if type(value) is tuple or type(value) is list:
        return _tagged(kind, *map(_canonical, value))
    if type(value) is bool or type(value) is int:
        return _tagged(kind, str(value).encode())
    if type(value) is float:
        return _tagged(kind, b"nan" if math.isnan(value) else struct.pack(">d", value))
    if type(value) is str:
        return _tagged(kind, value.encode("utf-8", "surrogatepass"))
    if type(value) is bytes:
        return _tagged(kind, value)
    raise TypeError(f"content_key cannot name a value of type {_qualified_name(value).decode()}")


def _canonical_array(array: np.ndarray | np.generic) -> bytes:
    # Other kinds (objects, records, dates) hold more than their bytes and their dtype's short name say.
    if array.dtype.kind not in "biufcSU":
        raise TypeError(f"content_key cannot name an array of dtype {array.dtype}")
    tag = "array" if isinstance(array, np.ndarray) else "scalar"
    return _tagged(tag, array.dtype.str.encode(), repr(array.shape).encode(), array.tobytes())


def _canonical_tensor(tensor: torch.Tensor) -> bytes:
    if tensor.layout is not torch.strided or tensor.is_quantized:
        raise TypeError(
            f"content_key cannot name a tensor of layout {tensor.layout} and dtype {tensor.dtype}"
        )
    dense = tensor.detach().cpu().resolve_conj().resolve_neg().contiguous()
    content = dense.flatten().view(torch.uint8).numpy().tobytes()
    return _tagged("tensor", str(tensor.dtype).encode(), repr(tuple(tensor.shape)).encode(), content)


def _qualified_name(value: object) -> bytes:
    return f"{type(value).__module__}.{type(value).__qualname__}".encode()


def _tagged(tag: str, *pieces: bytes) -> bytes:
    return b"".join(b"%d:%b" % (len(piece), piece) for piece in (tag.encode(), *pieces)) + b";"
