"""How long things take beside each other: measured in one run, on one thread, told with their quartiles.

A time says little by itself. All ways are measured in turn, again and again, so that what else the
machine does hits all alike, and what is told is the ratio of two medians; where the quartiles overlap
there is none to tell.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
from torch.utils.benchmark import Timer, set_torch_threads
from torch.utils.benchmark.utils.timer import timer as wall_clock

from dexterity.report.machine import processor, versions
from dexterity.store import write_atomically

__all__ = [
    "Ratio",
    "Timing",
    "Way",
    "conditions",
    "measure",
    "ratio",
    "readable",
    "table",
    "to_csv",
    "to_markdown",
    "write",
]

_NANOSECONDS = 1e9


@dataclass(frozen=True)
class Way:
    """A way to compute something for a number of configurations.

    Attributes
    ----------
    name
        What it is called in tables: its language, its batching, and the frame where that matters.
    compute
        Does all of it once; what it returns is thrown away.
    configurations
        How many configurations that is.
    """

    name: str
    compute: Callable[[], object]
    configurations: int


@dataclass(frozen=True)
class Timing:
    """Median and quartiles of the time that a way takes, [s] per configuration.

    Attributes
    ----------
    name, configurations
        Those of the way.
    lower, median, upper
        First, second and third quartile [s].
    """

    name: str
    configurations: int
    lower: float
    median: float
    upper: float

    @classmethod
    def from_times(cls, name: str, configurations: int, times: Sequence[float]) -> Timing:
        """Take the quartiles of times [s] that the computation took for all its configurations.

        Raises
        ------
        ValueError
            If there is no time, a time is negative or not finite, or `configurations` is not positive.
        """
        if configurations < 1:
            raise ValueError(f"configurations is {configurations}; at least 1 is needed")
        if not times or not np.isfinite(times).all() or min(times) < 0:
            raise ValueError(f"times of {name!r} are {list(times)}; finite ones, at least one, are needed")
        lower, median, upper = np.quantile(times, [0.25, 0.5, 0.75]) / configurations
        return cls(name, configurations, float(lower), float(median), float(upper))


@dataclass(frozen=True)
class Ratio:
    """Median of one time over the median of another.

    Attributes
    ----------
    value
        The ratio.
    distinguishable
        Whether the quartiles of the two lie apart. If not, the ratio says nothing, and is written so.
    """

    value: float
    distinguishable: bool

    def __str__(self) -> str:
        return _three_digits(self.value) if self.distinguishable else "indistinguishable"


def measure(
    ways: Iterable[Way], rounds: int = 5, seconds: float = 0.1, clock: Callable[[], float] = wall_clock
) -> tuple[Timing, ...]:
    """Time each way once a round, one after the other, on one thread of torch.

    Each is called once before the first round, untimed. Threads of other libraries are set by their own
    environment variables, before they are imported. On a GPU a time ends when the device is done.

    Parameters
    ----------
    ways
        What to time.
    rounds
        How often each gets its turn.
    seconds
        How long a turn takes at least [s]; what takes longer runs to its end.
    clock
        What tells the time [s]; ``time.process_time`` leaves out what others do on the machine.

    Returns
    -------
    A timing for each way, in their order.

    Raises
    ------
    ValueError
        If there is no way, two have the same name, one has no configurations, or `rounds` or `seconds` is
        not positive.
    """
    ways = tuple(ways)
    names = [way.name for way in ways]
    if not ways or len(set(names)) < len(names):
        raise ValueError(f"ways are named {names}; at least one, each with a name of its own, is needed")
    for way in ways:
        if way.configurations < 1:
            raise ValueError(f"{way.name!r} has {way.configurations} configurations; at least 1 is needed")
    if rounds < 1 or not seconds > 0:
        raise ValueError(f"rounds is {rounds} and seconds is {seconds}; positive ones are needed")

    timers = [
        Timer("compute()", timer=clock, globals={"compute": way.compute}, num_threads=1) for way in ways
    ]
    times: list[list[float]] = [[] for _ in ways]
    with set_torch_threads(1):
        for way in ways:
            way.compute()
        for _ in range(rounds):
            for timer, taken in zip(timers, times, strict=True):
                taken += timer.blocked_autorange(min_run_time=seconds).times
    return tuple(
        Timing.from_times(way.name, way.configurations, taken) for way, taken in zip(ways, times, strict=True)
    )


def ratio(timing: Timing, reference: Timing) -> Ratio:
    """Divide the median of a timing by that of a reference.

    Raises
    ------
    ValueError
        If the reference took no time.
    """
    if not reference.median > 0:
        raise ValueError(f"the reference {reference.name!r} took {reference.median} s")
    apart = timing.lower > reference.upper or timing.upper < reference.lower
    return Ratio(timing.median / reference.median, apart)


def table(timings: Sequence[Timing], reference: str) -> pd.DataFrame:
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
    ValueError
        If no timing, or more than one, has the reference's name.
    """
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
    return pd.DataFrame(columns, index=pd.Index([timing.name for timing in timings], name="way"))


def readable(table: pd.DataFrame) -> pd.DataFrame:
    """Write the numbers of a table to three digits, for a page.

    Parameters
    ----------
    table
        What :func:`table` returns, or several of them with further levels of the index.
    """
    ratios = zip(table["ratio"], table["distinguishable"], strict=True)
    quartiles = zip(table["lower"], table["upper"], strict=True)
    return pd.DataFrame(
        {
            "configurations": [f"{number:,}" for number in table["configurations"]],
            "median [ns]": [_three_digits(median) for median in table["median"]],
            "quartiles [ns]": [f"{_three_digits(a)}–{_three_digits(b)}" for a, b in quartiles],
            # The reference beside itself is one, and not indistinguishable.
            "ratio": ["1" if value == 1 else str(Ratio(value, apart)) for value, apart in ratios],
        },
        index=table.index,
    )


def conditions(*distributions: str) -> dict[str, str]:
    """Tell what times depend on: the processor, the threads that `measure` uses, and versions.

    Parameters
    ----------
    distributions
        Installed distributions beside Python, torch and numpy, such as ``"pin"``.

    Raises
    ------
    importlib.metadata.PackageNotFoundError
        If one is not installed.
    """
    return {"processor": processor(), "threads": "1"} | versions("torch", "numpy", *distributions)


def to_csv(table: pd.DataFrame, conditions: Mapping[str, str]) -> str:
    """Write a table as CSV, below its conditions in lines that begin with ``#``.

    ``pandas.read_csv(..., comment="#")`` reads it; times are in nanoseconds to six digits.

    Raises
    ------
    ValueError
        If a name holds a ``#``.
    """
    rows = table.to_csv(float_format="%.6g", lineterminator="\n")
    if "#" in rows:
        raise ValueError("a name in the table holds a #, after which a reader sees a comment")
    return "".join(f"# {key}: {value}\n" for key, value in conditions.items()) + rows


def to_markdown(table: pd.DataFrame, conditions: Mapping[str, str], title: str) -> str:
    """Write a table as Markdown below its title, its conditions at the end."""
    texts = readable(table).reset_index()
    lines = [list(texts.columns), ["---"] * len(texts.columns), *texts.to_numpy().tolist()]
    rows = "\n".join(
        "| " + " | ".join(str(text).replace("|", r"\|") for text in line) + " |" for line in lines
    )
    measured = ", ".join(f"{key} {value}" for key, value in conditions.items())
    return f"{title}\n\n{rows}\n\nMeasured with: {measured}.\n"


def write(stem: Path, table: pd.DataFrame, conditions: Mapping[str, str], title: str) -> None:
    """Write a table into `stem`.csv and `stem`.md, each as a whole.

    Raises
    ------
    ValueError
        If a name holds a ``#``.
    OSError
        If a file cannot be written.
    """
    write_atomically(stem.with_name(f"{stem.name}.csv"), to_csv(table, conditions))
    write_atomically(stem.with_name(f"{stem.name}.md"), to_markdown(table, conditions, title))


def _three_digits(value: float) -> str:
    return f"{value:,.0f}" if value >= 100 else f"{value:#.3g}".rstrip(".")
