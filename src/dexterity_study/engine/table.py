"""Tidy rows and arrays of an experiment, and their files: CSV, a metric a row, and npz without pickle.

Equal content has equal bytes.
"""

from __future__ import annotations

import csv
import io
import math
import zipfile
from collections.abc import Hashable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pandas as pd

Row = Mapping[str, Any]

_DIGITS = 12


@dataclass(frozen=True)
class Table:
    """Rows and arrays of one experiment, for one or more readings and seeds.

    Attributes
    ----------
    rows
        Columns `reading` and `seed`, the experiment's keys, then its metrics.
    keys
        Names of the experiment's key columns.
    arrays
        Arrays by reading, seed and name.
    """

    rows: pd.DataFrame
    keys: tuple[str, ...]
    arrays: Mapping[tuple[str, int], Mapping[str, np.ndarray]] = field(default_factory=dict)

    @classmethod
    def of_run(
        cls, rows: Iterable[Row], arrays: Mapping[str, Any], *, keys: Sequence[str], reading: str, seed: int
    ) -> Table:
        """Make the table of one run.

        Raises
        ------
        ValueError
            If a row lacks a key, two rows have the same keys, or a value is neither number, truth value nor text.
        """
        listed = [dict(row) for row in rows]
        seen: set[tuple[Hashable, ...]] = set()
        for row in listed:
            if missing := [key for key in keys if key not in row]:
                raise ValueError(f"row {row} lacks the keys {missing}")
            name = tuple(row[key] for key in keys)
            if name in seen:
                raise ValueError(f"two rows have the keys {dict(zip(keys, name, strict=True))}")
            seen.add(name)
        metrics = dict.fromkeys(metric for row in listed for metric in row if metric not in keys)
        plain = [{name: _plain(value) for name, value in row.items()} for row in listed]
        frame = pd.DataFrame(plain, columns=[*keys, *metrics])
        frame.insert(0, "reading", reading)
        frame.insert(1, "seed", seed)
        held = {name: np.asarray(array) for name, array in arrays.items()}
        return cls(frame, tuple(keys), {(reading, seed): held} if held else {})

    @classmethod
    def joined(cls, tables: Sequence[Table]) -> Table:
        """Put tables of one experiment below one another."""
        arrays = {run: held for table in tables for run, held in table.arrays.items()}
        frames = [table.rows for table in tables]
        return cls(pd.concat(frames, ignore_index=True), tables[0].keys, arrays)

    @property
    def seeds(self) -> list[int]:
        """Seeds of the chosen reading."""
        return self.rows.loc[self.rows["reading"] == "chosen", "seed"].drop_duplicates().tolist()

    @property
    def readings(self) -> list[str]:
        """Names of the readings, in the order of the rows."""
        return self.rows["reading"].drop_duplicates().tolist()

    def where(self, reading: str | None = "chosen", **keys: Any) -> pd.DataFrame:
        """Return the rows with these keys, of the chosen reading unless another, or None for all, is named."""
        chosen = self.rows if reading is None else self.rows[self.rows["reading"] == reading]
        for key, value in keys.items():
            if key not in ("seed", *self.keys):
                raise ValueError(f"{key!r} is not a key; keys are {['seed', *self.keys]}")
            chosen = chosen[chosen[key] == value]
        if chosen.empty:
            raise ValueError(f"no row of reading {reading!r} has the keys {keys}")
        return chosen.dropna(axis="columns", how="all")

    def values(self, metric: str, **keys: Any) -> pd.Series:
        """Return a metric over readings and seeds, indexed by both; this is what verdicts are made from.

        Raises
        ------
        ValueError
            If no row has these keys, or a seed has several.
        """
        rows = self.where(None, **keys).set_index(["reading", "seed"])
        if rows.index.has_duplicates:
            raise ValueError(f"keys {keys} leave several rows for a seed; name one of {self.keys} too")
        return rows[metric].dropna()

    def by_seed(self, metric: str, over: str, **keys: Any) -> pd.DataFrame:
        """Return a metric of the chosen reading with a row for each seed and a column for each value of a key."""
        rows = self.where(**keys)
        return rows.pivot(index="seed", columns=over, values=metric)[rows[over].drop_duplicates()]

    def array(self, name: str, reading: str = "chosen") -> np.ndarray:
        """Return an array of all seeds of a reading, stacked along a first axis."""
        held = [arrays[name] for (of, _), arrays in self.arrays.items() if of == reading and name in arrays]
        if not held:
            raise ValueError(f"there is no array {name!r} for reading {reading!r}")
        return np.stack(held)


# ---- files -----------------------------------------------------------------------------------------


def to_csv(table: Table) -> str:
    """Write rows as CSV with a metric a row."""
    file = io.StringIO()
    writer = csv.writer(file, lineterminator="\n")
    names = ["reading", "seed", *table.keys]
    writer.writerow([*names, "metric", "value"])
    for row in table.rows.to_dict("records"):
        for metric in table.rows.columns[len(names) :]:
            if not _is_missing(row[metric]):
                writer.writerow([*(_text(row[name]) for name in names), metric, _text(row[metric])])
    return file.getvalue()


def from_csv(text: str) -> Table:
    """Read what :func:`to_csv` wrote.

    Raises
    ------
    ValueError
        If the text has other columns.
    """
    lines = csv.reader(io.StringIO(text))
    head = next(lines, [])
    if head[:2] != ["reading", "seed"] or head[-2:] != ["metric", "value"]:
        raise ValueError(f"the columns are {head}; reading, seed, keys, metric, value are needed")
    rows: dict[tuple[str, ...], dict[str, Any]] = {}
    for *names, metric, value in lines:
        rows.setdefault(tuple(names), {})[metric] = _value(value)
    keyed = [dict(zip(head, map(_value, names), strict=False)) | metrics for names, metrics in rows.items()]
    metrics = dict.fromkeys(metric for row in rows.values() for metric in row)
    return Table(pd.DataFrame(keyed, columns=[*head[:-2], *metrics]), tuple(head[2:-2]))


def to_npz(arrays: Mapping[str, np.ndarray]) -> bytes:
    """Write arrays as a compressed npz archive with the same bytes for the same arrays."""
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
        for name in sorted(arrays):
            content = io.BytesIO()
            np.lib.format.write_array(content, np.ascontiguousarray(arrays[name]), allow_pickle=False)
            archive.writestr(zipfile.ZipInfo(f"{name}.npy"), content.getvalue(), zipfile.ZIP_DEFLATED, 9)
    return file.getvalue()


def from_npz(content: bytes) -> dict[str, np.ndarray]:
    """Read arrays; nothing is unpickled."""
    with np.load(io.BytesIO(content), allow_pickle=False) as archive:
        return {name: archive[name] for name in archive.files}


def summaries(table: Table) -> Table:
    """Replace arrays by rows with their size, mean, smallest and largest value, as a probe keeps them."""
    rows = [
        {"array": name, "size": array.size, "mean": array.mean(), "min": array.min(), "max": array.max()}
        for held in table.arrays.values()
        for name, array in sorted(held.items())
    ]
    if not rows:
        return table
    keyed = [{**dict.fromkeys(table.keys, "–"), **row} for row in rows]
    frame = pd.DataFrame([{name: _plain(value) for name, value in row.items()} for row in keyed])
    named = table.rows.assign(array="–")
    joined = pd.concat(
        [named, frame.assign(reading="chosen", seed=table.rows["seed"].iloc[0])], ignore_index=True
    )
    names = ["reading", "seed", *table.keys, "array"]
    return Table(joined[[*names, *joined.columns.difference(names, sort=False)]], (*table.keys, "array"))


def _plain(value: object) -> bool | int | float | str | None:
    if isinstance(value, np.generic):
        value = value.item()
    if hasattr(value, "item") and getattr(value, "ndim", None) == 0:
        value = value.item()
    if value is None or isinstance(value, bool | int | float | str):
        return value
    raise ValueError(f"{value!r} is a {type(value).__name__}; a row holds numbers, truth values and texts")


def _is_missing(value: object) -> bool:
    return value is None or (isinstance(value, float) and math.isnan(value))


def _text(value: object) -> str:
    if isinstance(value, bool | np.bool_):
        return str(bool(value)).lower()
    if isinstance(value, float):
        return f"{value:.{_DIGITS}g}"
    return str(value)


def _value(text: str) -> bool | int | float | str:
    if text in ("true", "false"):
        return text == "true"
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            continue
    return text
