"""The cache of executed chapters, which by itself does not see a change in the source."""

import shutil
from pathlib import Path

from dexterity import store
from dexterity.report.sources import tree_key
from dexterity.report.study import scale

__all__ = ["refresh"]

_NOTE = ".source-key"
_DATABASE = "global.db"


def refresh(folder: Path) -> bool:
    """Empty an execution cache unless it was filled from the present source at the present scale.

    The folder is created if it is missing, and notes what it will be filled from.

    Parameters
    ----------
    folder
        The cache.

    Returns
    -------
    Whether the cache was emptied.

    Raises
    ------
    ValueError
        If the folder holds something else than an execution cache.
    """
    note = folder / _NOTE
    key = store.content_key(tree_key(), scale())
    if note.is_file() and note.read_text(encoding="utf-8") == key:
        return False
    content = list(folder.iterdir()) if folder.exists() else []
    if content and not (note.exists() or (folder / _DATABASE).exists()):
        raise ValueError(f"{folder} is not an execution cache; nothing is deleted")
    for entry in content:
        if entry.is_dir() and not entry.is_symlink():
            shutil.rmtree(entry)
        else:
            entry.unlink()
    store.write_atomically(note, key)
    return True
