"""Answers of the command: one table of values, shown for reading, or written as CSV or JSON.

Examples
--------
>>> from dexterity.command.reports import Report
>>> report = Report({"configuration": [0, 1], "w": [0.25, float("inf")]}, {"robot": "puma560"})
>>> print(report.as_csv(), end="")
configuration,w
0,0.25
1,inf
>>> print(report.as_json(), end="")
{"robot": "puma560", "rows": [{"configuration": 0, "w": 0.25}, {"configuration": 1, "w": "Infinity"}]}
"""

from __future__ import annotations

import csv
import io
import json
import math
import re
import sys
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum
from pathlib import Path
from typing import TypeAlias

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table
from rich.text import Text

__all__ = ["Cell", "Form", "Report", "check_output", "guarded", "require_file", "say", "unguarded"]

Cell: TypeAlias = str | int | float | bool | None

WIDTH = 160
"""Letters in a line where the output is no terminal."""

MOST_ROWS = 60
"""Rows of a table for reading; CSV and JSON have all of them."""


class Form(Enum):
    """How a report is printed."""

    TABLE = "table"
    CSV = "csv"
    JSON = "json"


@dataclass(frozen=True)
class Report:
    """Columns of equal length, and facts that hold for all rows.

    Attributes
    ----------
    columns
        Values by the name of the column.
    facts
        Values by name, such as the robot and the unit: lines above a table, entries of the JSON object.
        CSV leaves them out.
    """

    columns: Mapping[str, Sequence[Cell]]
    facts: Mapping[str, Cell | Sequence[Cell]] = field(default_factory=dict)

    def rows(self) -> Iterator[tuple[Cell, ...]]:
        """Go through the rows."""
        return zip(*self.columns.values(), strict=True)

    def as_csv(self) -> str:
        """Return a line of names and a line for each row, with all digits; no text begins as a formula."""
        file = io.StringIO()
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(map(_plain, self.columns))
        writer.writerows(map(_plain, row) for row in self.rows())
        return file.getvalue()

    def as_json(self) -> str:
        """Return one object: the facts, and ``rows`` with an object for each row.

        JSON has no infinite numbers; they are the texts ``"Infinity"``, ``"-Infinity"`` and ``"NaN"``.
        """
        names = list(self.columns)
        rows = [dict(zip(names, map(_in_json, row), strict=True)) for row in self.rows()]
        facts = {
            name: _in_json(value) if isinstance(value, Cell) else [_in_json(item) for item in value]
            for name, value in self.facts.items()
        }
        return json.dumps({**facts, "rows": rows}, ensure_ascii=False, allow_nan=False) + "\n"

    def show(self) -> None:
        """Print the table, four digits to a number, at most 60 rows of it."""
        # A pipe has no width that a table would have to fit into.
        console = Console(highlight=False, width=None if sys.stdout.isatty() else WIDTH)
        for name, value in self.facts.items():
            console.print(Text(f"{name}: {_shown(value)}"), soft_wrap=True)
        rows = list(self.rows())
        if not rows:
            return
        table = Table(box=SIMPLE_HEAD, pad_edge=False)
        for i, name in enumerate(self.columns):
            numbers = all(isinstance(row[i], int | float) or row[i] is None for row in rows)
            # Names of joints and files are data: no markup in them.
            table.add_column(
                Text(name), justify="right" if numbers else "left", no_wrap=numbers, overflow="fold"
            )
        for row in rows[:MOST_ROWS]:
            table.add_row(*(Text(_shown(cell)) for cell in row))
        console.print(table)
        if len(rows) > MOST_ROWS:
            console.print(f"{len(rows) - MOST_ROWS} more rows; --csv prints all {len(rows)}")

    def give(self, form: Form, output: Path | None) -> None:
        """Print the report, or write it whole to a file whose suffix names its form."""
        if output is not None:
            # Imported here, because it brings torch.
            from dexterity import store

            store.write_atomically(output, self.as_json() if _form_of(output) is Form.JSON else self.as_csv())
            say(f"{output}: {_counted(len(list(self.rows())), 'row')} written")
        elif form is Form.TABLE:
            self.show()
        else:
            sys.stdout.write(self.as_csv() if form is Form.CSV else self.as_json())


def say(text: str) -> None:
    """Print a line beside the answer: to standard error, so that CSV and JSON stay what they are."""
    sys.stderr.write(f"{text}\n")


def check_output(output: Path | None) -> None:
    """Refuse a file that could not be written, before anything is computed.

    Raises
    ------
    ValueError
        If the suffix is not ``.csv`` or ``.json``, or its folder does not exist or cannot be written to.
    """
    if output is not None:
        _form_of(output)
        _require_folder("--output", output)


def require_file(name: str, file: Path, suffix: str) -> None:
    """Refuse a file that could not be written, before hours of work.

    Raises
    ------
    ValueError
        If its name does not end in the suffix, or its folder does not exist or cannot be written to; the
        error begins with `name`.
    """
    if file.suffix.lower() != suffix:
        raise ValueError(f"{name} is {str(file)!r}; a name that ends in {suffix} is needed")
    _require_folder(name, file)


def _require_folder(name: str, file: Path) -> None:
    folder = file.absolute().parent
    if not folder.is_dir():
        raise ValueError(f"{name} is {str(file)!r}; the folder {folder} does not exist")
    if file.is_dir():
        raise ValueError(f"{name} is {str(file)!r}, which is a folder")
    try:
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise ValueError(
            f"{name} is {str(file)!r}; nothing can be written to {folder}: {error.strerror}"
        ) from error


def _form_of(output: Path) -> Form:
    forms = {".csv": Form.CSV, ".json": Form.JSON}
    if output.suffix.lower() not in forms:
        raise ValueError(f"--output is {str(output)!r}; a name that ends in .csv or .json is needed")
    return forms[output.suffix.lower()]


def _plain(cell: Cell) -> Cell:
    if isinstance(cell, bool):
        return str(cell).lower()
    return guarded(cell) if isinstance(cell, str) else cell


_FORMULA = re.compile(r"'*[=+\-@\t\r]")


def guarded(text: str) -> str:
    """Put an apostrophe before a text that a spreadsheet would take for a formula and compute."""
    return f"'{text}" if _FORMULA.match(text) else text


def unguarded(text: str) -> str:
    """Return the text that :func:`guarded` was given."""
    return text[1:] if text.startswith("'") and _FORMULA.match(text) else text


def _in_json(cell: Cell) -> Cell:
    if isinstance(cell, float) and not math.isfinite(cell):
        return "NaN" if math.isnan(cell) else "Infinity" if cell > 0 else "-Infinity"
    return cell


def _shown(value: Cell | Sequence[Cell]) -> str:
    if value is None:
        return ""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        # No -0 where a value is a rounded zero.
        return f"{value + 0.0:.4g}"
    if isinstance(value, str | int):
        # Names and cards come from files: no letter of theirs moves the cursor.
        return "".join(c if c.isprintable() or c == "\n" else " " for c in str(value))
    return ", ".join(_shown(item) for item in value)


def _counted(count: int, noun: str) -> str:
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"
