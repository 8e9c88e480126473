r"""Tables of numbers in files: CSV, JSON and ``.npy``, by a path or from standard input.

Examples
--------
>>> from pathlib import Path
>>> from tempfile import TemporaryDirectory
>>> from dexterity.command.files import table
>>> with TemporaryDirectory() as folder:
...     file = Path(folder, "q.csv")
...     _ = file.write_text("elbow,shoulder,note\n0.5,pi/2,a\n0.6,90deg,b\n")
...     table(file, [("shoulder", "elbow")]).round(4).tolist()
[[1.5708, 0.5], [1.5708, 0.6]]
"""

from __future__ import annotations

import csv
import json
import sys
import tokenize
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dexterity.command.reports import unguarded
from dexterity.typed import number

__all__ = ["table"]

STDIN = Path("-")
"""File that stands for standard input."""


def table(file: Path, choices: Sequence[Sequence[str]]) -> NDArray[np.float64]:
    """Read the numbers of a file.

    Parameters
    ----------
    file
        ``.npy``; JSON, a list of numbers, of lists or of objects, or an object with such a list as its
        ``rows``; or CSV, with or without a line of names. ``-`` reads JSON or CSV from standard input.
    choices
        Names of columns, in the order that is wanted. Of a file with names, the first choice is read whose
        columns it has; other columns are left out.

    Returns
    -------
    (rows, columns) of a file with names, and the array of one without names in its own shape.

    Raises
    ------
    ValueError
        If the file is no table, its columns are not those wanted, or a value is no finite number; the error
        names the file and the row.
    OSError
        If the file cannot be read.
    """
    if file.suffix.lower() == ".npy":
        return _npy(file)
    content = _text(file)
    if file.suffix.lower() == ".json" or content.lstrip()[:1] in {"[", "{"}:
        return _json(file, content, choices)
    return _csv(file, content, choices)


def _csv(file: Path, content: str, choices: Sequence[Sequence[str]]) -> NDArray[np.float64]:
    lines = [line for line in content.splitlines() if line.strip() and not line.lstrip().startswith("#")]
    if not lines:
        raise ValueError(f"{file} is empty")
    try:
        return _table_of(file, lines, choices)
    except csv.Error as error:
        raise ValueError(f"{file} is no CSV: {error}") from error


def _table_of(file: Path, lines: list[str], choices: Sequence[Sequence[str]]) -> NDArray[np.float64]:
    first = [unguarded(cell.strip()) for cell in next(csv.reader(lines[:1]))]
    if all(_is_number(cell) for cell in first):
        return _finite(_rows(file, lines, None), file)
    chosen = _choice(file, first, choices)
    if len(lines) == 1:
        raise ValueError(f"{file} has a line of names and no rows")
    return _finite(_rows(file, lines[1:], [first.index(name) for name in chosen]), file)


def _rows(file: Path, lines: Sequence[str], columns: Sequence[int] | None) -> NDArray[np.float64]:
    """Read the numbers of some columns, or of all, which then are equally many in each line."""
    try:
        return np.loadtxt(lines, delimiter=",", usecols=columns, ndmin=2, comments=None, quotechar='"')
    except ValueError:
        # Slower; reads pi/2 and 90deg too, and says which line is at fault.
        rows: list[list[float]] = []
        for i, cells in enumerate(csv.reader(lines), 1 if columns is None else 2):
            where = f"{file}, line {i}"
            if columns is None and rows and len(cells) != len(rows[0]):
                raise ValueError(f"{where} has {len(cells)} columns; the first has {len(rows[0])}") from None
            if columns is not None and len(cells) <= max(columns):
                raise ValueError(f"{where} has {len(cells)} columns; {max(columns) + 1} are needed") from None
            chosen = cells if columns is None else [cells[column] for column in columns]
            rows.append([number(cell, where) for cell in chosen])
        return np.array(rows)


def _choice(file: Path, names: Sequence[str], choices: Sequence[Sequence[str]]) -> Sequence[str]:
    chosen = next((choice for choice in choices if set(choice) <= set(names)), None)
    if chosen is None:
        needed = " or ".join(", ".join(choice) for choice in choices)
        raise ValueError(f"{file} has the columns {', '.join(map(str, names))}; {needed} are needed")
    if twice := [name for name in chosen if names.count(name) > 1]:
        raise ValueError(f"{file} has two columns {twice[0]!r}")
    return chosen


def _is_number(cell: str) -> bool:
    try:
        number(cell, "cell")
    except ValueError:
        # No names either: they are refused later, as values that are not finite.
        return cell.lower() in {"nan", "inf", "-inf"}
    return True


def _json(file: Path, content: str, choices: Sequence[Sequence[str]]) -> NDArray[np.float64]:
    try:
        items = json.loads(content)
    except (ValueError, RecursionError) as error:
        raise ValueError(f"{file} is no JSON: {error}") from error
    if isinstance(items, Mapping):
        # What --json prints has its rows in an object.
        items = items.get("rows", [items])
    if not isinstance(items, list) or not items:
        raise ValueError(f"{file} holds no list of rows")
    if isinstance(items[0], Mapping):
        chosen = _choice(file, list(items[0]), choices)
        if i := next(
            (
                i
                for i, item in enumerate(items)
                if not isinstance(item, Mapping) or not set(chosen) <= set(item)
            ),
            0,
        ):
            raise ValueError(f"{file}, row {i + 1} does not hold {', '.join(chosen)}")
        items = [[item[name] for name in chosen] for item in items]
    return _finite(_numbers(items, file), file)


def _numbers(items: Any, file: Path) -> NDArray[np.float64]:
    try:
        array = np.array(items)
    except (ValueError, OverflowError) as error:
        raise ValueError(f"{file} holds rows of different lengths, or a number that is too large") from error
    # Texts and truth values would become numbers in silence.
    if array.dtype.kind not in "iuf" or _holds_truth_value(items):
        raise ValueError(f"{file} holds something else than numbers")
    return array.astype(np.float64)


def _holds_truth_value(items: Any) -> bool:
    return isinstance(items, bool) or (isinstance(items, list) and any(map(_holds_truth_value, items)))


def _npy(file: Path) -> NDArray[np.float64]:
    try:
        array = np.load(file, allow_pickle=False)
    except (ValueError, EOFError, MemoryError, SyntaxError, tokenize.TokenError) as error:
        raise ValueError(f"{file} is no .npy file: {error}") from error
    if not isinstance(array, np.ndarray) or not array.ndim:
        raise ValueError(f"{file} holds no array with rows")
    return _finite(_numbers(array, file), file)


def _finite(values: NDArray[np.float64], file: Path) -> NDArray[np.float64]:
    if not np.isfinite(values).all():
        rows = values.reshape(1, -1) if values.ndim == 1 else values.reshape(len(values), -1)
        bad = int((~np.isfinite(rows)).any(1).argmax())
        raise ValueError(f"{file}, row {bad + 1} holds a value that is not finite")
    return values


def _text(file: Path) -> str:
    try:
        return sys.stdin.read() if file == STDIN else file.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError as error:
        raise ValueError(f"{file} is no text: {error}") from error
