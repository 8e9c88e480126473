"""Generated and compiled code that is stored for the next time, in a folder that no other user can change.

Each entry lies beside the SHA-256 of its content. An entry that is damaged in any way counts as missing, so
that it is made again. Code is never loaded from the stored file, but from a copy of the content that was
checked.

Examples
--------
>>> import os, tempfile
>>> from dexterity.codegen import cache
>>> os.environ["DEXTERITY_CACHE"] = tempfile.mkdtemp()
>>> cache.write("example.c", b"int x;")
>>> cache.read("example.c")
b'int x;'
>>> del os.environ["DEXTERITY_CACHE"]
"""

from __future__ import annotations

import hashlib
import os
import re
import shutil
import stat
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from dexterity import store

__all__ = ["cache_folder", "naming_the_cache", "private_folder", "read", "sweep", "write"]

_LARGEST = 2**28
"""Bytes of an entry at most; a larger file is no entry."""

_DAY = 86_400.0
"""Age after which files that an interrupted process left behind are removed [s]."""


def cache_folder() -> Path:
    """Folder of generated and compiled code: ``$DEXTERITY_CACHE``, or ``dexterity`` in the user's cache."""
    if named := os.environ.get("DEXTERITY_CACHE"):
        return Path(named).expanduser().resolve()
    shared = Path(os.environ.get("XDG_CACHE_HOME", ""))
    return (shared if shared.is_absolute() else _home() / ".cache") / "dexterity"


def _home() -> Path:
    if (home := Path.home()).is_absolute():
        return home
    import pwd  # on systems with a variable HOME, which may be empty

    return Path(pwd.getpwuid(os.getuid()).pw_dir)


def private_folder() -> Path:
    """Return the folder of entries within :func:`cache_folder`, made if needed, for this user alone.

    If others could write to it, what it holds is discarded first.

    Raises
    ------
    PermissionError
        If the folder belongs to another user, or is a link.
    OSError
        If it cannot be made.
    """
    folder = cache_folder() / "code"
    with naming_the_cache():
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        found = folder.lstat()
        if hasattr(os, "geteuid"):
            if stat.S_ISLNK(found.st_mode) or found.st_uid != os.geteuid():
                raise PermissionError(
                    f"the cache folder {folder} is a link or belongs to another user, who could put foreign "
                    "code into it; delete it, or name another one by the environment variable DEXTERITY_CACHE"
                )
            if stat.S_IMODE(found.st_mode) & 0o077:
                folder.chmod(0o700)
                if stat.S_IMODE(found.st_mode) & 0o022:
                    _discard(folder)
    return folder


def _discard(folder: Path) -> None:
    for path in folder.iterdir():
        if path.is_dir() and not path.is_symlink():
            shutil.rmtree(path)
        else:
            path.unlink()


def read(name: str) -> bytes | None:
    """Return the content of an entry; None if it is missing or damaged.

    Raises
    ------
    OSError
        If the folder cannot be used; see :func:`private_folder`.
    """
    folder = private_folder()
    content, digest = _content(folder / name), _content(folder / f"{name}.sha256")
    if content is None or digest != _digest(content):
        return None
    return content


def _content(path: Path) -> bytes | None:
    """Return what a regular file holds; None for links, pipes, folders and what cannot be read."""
    flags = os.O_RDONLY | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0)
    try:
        with os.fdopen(os.open(path, flags), "rb") as file:
            found = os.fstat(file.fileno())
            if not stat.S_ISREG(found.st_mode) or found.st_size > _LARGEST:
                return None
            return file.read()
    except OSError:
        return None


def write(name: str, content: bytes) -> None:
    """Store an entry in place of what stood there.

    Raises
    ------
    OSError
        If the folder cannot be used or written.
    """
    folder = private_folder()
    with naming_the_cache():
        for path, text in ((folder / name, content), (folder / f"{name}.sha256", _digest(content))):
            if path.is_dir() and not path.is_symlink():
                shutil.rmtree(path)
            store.write_atomically(path, text)


def _digest(content: bytes) -> bytes:
    return hashlib.sha256(content).hexdigest().encode()


def sweep() -> None:
    """Remove what processes that were killed have left in the folder more than a day ago."""
    for path in private_folder().iterdir():
        if re.fullmatch(r"\.(compiling-|loading-).*|\..*\.tmp", path.name):
            with suppress(OSError):  # another process may be removing it
                if time.time() - path.lstat().st_mtime > _DAY:
                    shutil.rmtree(path) if path.is_dir() else path.unlink()


@contextmanager
def naming_the_cache() -> Iterator[None]:
    """Say which folder it is that cannot be written, and how to choose another."""
    try:
        yield
    except OSError as error:
        if error.strerror is None:  # it names the folder already
            raise
        raise OSError(
            f"the cache folder {cache_folder()} cannot be written ({error.strerror}); "
            "the environment variable DEXTERITY_CACHE names another"
        ) from error
