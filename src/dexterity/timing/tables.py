"""Tables of timings beside a reference, for a page and for files.

Examples
--------
>>> from dexterity.timing import Timing, table
>>> timings = [
...     Timing("exact", 1, 1e-9, 2e-9, 3e-9),
...     Timing("network", 1, 4e-9, 6e-9, 7e-9),
... ]
>>> list(table(timings, reference="exact").index)
['exact', 'network']
"""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from dexterity import checks
from dexterity.store import write_set
from dexterity.timing.measurement import Ratio, Timing, ratio, three_digits

if TYPE_CHECKING:
    import pandas

__all__ = ["readable", "table", "to_csv", "to_markdown", "write"]

_NANOSECONDS = 1e9


@checks.arguments(timings=checks.Each(checks.Instance(Timing)))
def table(timings: Sequence[Timing], reference: str) -> pandas.DataFrame:
    """Set timings beside a reference, one row for each under its name.

    Parameters
    ----------
    timings
        Timings of one run.
    reference
        Name of the one that the others are compared with.

    Returns
    -------
    Columns configurations; lower, median, upper [ns] per configuration; ratio of the medians to the
    reference's; distinguishable, which is false where the quartiles overlap.

    Raises
    ------
    ImportError
        If pandas is missing.
    ValueError
        If no timing, or more than one, has the reference's name.
    """
    checks.name(reference, "reference")
    found = [timing for timing in timings if timing.name == reference]
    if len(found) != 1:
        names = [timing.name for timing in timings]
        raise ValueError(f"reference is {reference!r}; one of the timings must have that name: {names}")
    ratios = [ratio(timing, found[0]) for timing in timings]
    columns = {
        "configurations": [timing.configurations for timing in timings],
        "lower": [timing.lower * _NANOSECONDS for timing in timings],
        "median": [timing.median * _NANOSECONDS for timing in timings],
        "upper": [timing.upper * _NANOSECONDS for timing in timings],
        "ratio": [ratio.value for ratio in ratios],
        "distinguishable": [ratio.distinguishable for ratio in ratios],
    }
    pandas = _pandas()
    return pandas.DataFrame(columns, index=pandas.Index([timing.name for timing in timings], name="way"))


def readable(table: pandas.DataFrame) -> pandas.DataFrame:
    """Write the numbers of a table to three digits, for a page.

    Parameters
    ----------
    table
        What :func:`table` returns, or several of them with further levels of the index.
    """
    checks.instance(table, "table", _pandas().DataFrame)
    ratios = zip(table["ratio"], table["distinguishable"], strict=True)
    quartiles = zip(table["lower"], table["upper"], strict=True)
    return _pandas().DataFrame(
        {
            "configurations": [f"{number:,}" for number in table["configurations"]],
            "median [ns]": [three_digits(median) for median in table["median"]],
            "quartiles [ns]": [f"{three_digits(a)}–{three_digits(b)}" for a, b in quartiles],
            # The reference beside itself is one, and not indistinguishable.
            "ratio": ["1" if value == 1 else str(Ratio(value, apart)) for value, apart in ratios],
        },
        index=table.index,
    )


@checks.arguments(conditions=checks.Instance(Mapping))
def to_csv(table: pandas.DataFrame, conditions: Mapping[str, str]) -> str:
    """Write a table as CSV, below its conditions in lines that begin with ``#``.

    ``pandas.read_csv(..., comment="#")`` reads it; times are in nanoseconds to six digits.

    Raises
    ------
    ValueError
        If a name holds a ``#``, or begins as a formula does.
    """
    checks.instance(table, "table", _pandas().DataFrame)
    rows = table.to_csv(float_format="%.6g", lineterminator="\n")
    if "#" in rows:
        raise ValueError("a name in the table holds a #, after which a reader sees a comment")
    if formulas := [
        name for row in table.index for name in _names(row) if name.startswith(("=", "+", "-", "@"))
    ]:
        raise ValueError(f"a name in the table is {formulas[0]!r}, which a spreadsheet would compute")
    return "".join(f"# {_line(f'{key}: {value}')}\n" for key, value in conditions.items()) + rows


@checks.arguments(conditions=checks.Instance(Mapping), title=checks.name)
def to_markdown(table: pandas.DataFrame, conditions: Mapping[str, str], title: str) -> str:
    """Write a table as Markdown below its title, its conditions at the end."""
    texts = readable(table).reset_index()
    lines = [list(texts.columns), ["---"] * len(texts.columns), *texts.to_numpy().tolist()]
    rows = "\n".join("| " + " | ".join(_inert(str(text)) for text in line) + " |" for line in lines)
    measured = ", ".join(_inert(f"{key} {value}") for key, value in conditions.items())
    return f"{_inert(title)}\n\n{rows}\n\nMeasured with: {measured}.\n"


def _names(row: Hashable) -> list[str]:
    return [part for part in (row if isinstance(row, tuple) else (row,)) if isinstance(part, str)]


def _line(text: str) -> str:
    """Return a text without line ends and other letters that do not print."""
    return "".join(c if c.isprintable() else " " for c in text)


def _inert(text: str) -> str:
    """Return a text that is neither the end of a cell nor markup to a browser."""
    plain = _line(text).replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")
    return plain.replace("\\", r"\\").replace("|", r"\|")


@checks.arguments(stem=checks.path, conditions=checks.Instance(Mapping), title=checks.name)
def write(stem: Path, table: pandas.DataFrame, conditions: Mapping[str, str], title: str) -> None:
    """Write a table into `stem`.csv and `stem`.md as one set, with their checksums in `stem`.sha256.

    Raises
    ------
    ValueError
        If a name holds a ``#``, or begins as a formula does.
    OSError
        If a file cannot be written.
    """
    stem = Path(stem)
    texts = {"csv": to_csv(table, conditions), "md": to_markdown(table, conditions, title)}
    write_set(
        stem.parent, f"{stem.name}.sha256", {f"{stem.name}.{ending}": text for ending, text in texts.items()}
    )


def _pandas() -> Any:
    try:
        import pandas
    except ImportError as error:
        raise ImportError("tables of timings need pandas: pip install dexterity-study[timing]") from error
    return pandas
