r"""Denavit–Hartenberg tables as CSV: one line a joint, as :mod:`dexterity.robots.description` explains.

Examples
--------
>>> import pathlib, tempfile
>>> from dexterity.robots import dh_table
>>> path = pathlib.Path(tempfile.mkdtemp(), "two.csv")
>>> _ = path.write_text("a,alpha,lower_deg\n0.5,pi/2,-90\n0.4,,\n")
>>> dh_table.read(path, {"a", "alpha", "lower_deg"})["dh"]
[{'a': 0.5, 'alpha': 1.5707963267948966, 'lower_deg': -90.0}, {'a': 0.4}]
"""

from __future__ import annotations

import csv
from collections.abc import Collection
from pathlib import Path
from typing import Any

from dexterity import store, typed

__all__ = ["read"]

_TEXTS = ("name", "kind", "convention")


def read(path: Path, known: Collection[str]) -> dict[str, Any]:
    """Return what a robot file with the same ``[[dh]]`` rows holds; an empty cell is an entry left out.

    Parameters
    ----------
    path
        The file.
    known
        Entries of a row.

    Raises
    ------
    ValueError
        If the file is no text, has no line of known names or no rows, a line has too many or too few cells, a
        cell is no number, or lines name two conventions.
    FileNotFoundError
        If there is no such file.
    """
    lines = [
        line
        for line in store.read_bytes(path).decode("utf-8-sig").splitlines()
        if line.strip() and not line.lstrip().startswith("#")
    ]
    try:
        table = [[cell.strip() for cell in cells] for cells in csv.reader(lines, strict=True)]
    except csv.Error as error:
        raise ValueError(f"it cannot be read as CSV: {error}") from error
    if len(table) < 2:
        raise ValueError("a line of names, such as theta,d,a,alpha, and a line for each joint are needed")
    names = table[0]
    columns = [*_TEXTS, *sorted({*known} - {*_TEXTS})]
    if strange := [name for name in names if name not in columns]:
        raise ValueError(
            f"the first line names {strange[0]!r}; {', '.join(columns)} are known, with commas between them"
        )
    if twice := [name for name in names if names.count(name) > 1]:
        raise ValueError(f"two columns are called {twice[0]!r}")
    rows: list[dict[str, Any]] = []
    for number, cells in enumerate(table[1:], 1):
        if len(cells) != len(names):
            raise ValueError(f"joint {number} has {len(cells)} cells; {len(names)} are named")
        rows.append({
            name: cell if name in _TEXTS else typed.number(cell, f"{name} of joint {number}")
            for name, cell in zip(names, cells, strict=True)
            if cell
        })  # fmt: skip
    conventions = {row.pop("convention") for row in rows if "convention" in row}
    if len(conventions) > 1:
        raise ValueError(f"convention is {' and '.join(sorted(conventions))}; all joints follow one")
    return {"dh": rows, "convention": conventions.pop()} if conventions else {"dh": rows}
