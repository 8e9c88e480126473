"""How long things take beside each other: measured in one run, on one thread, told with their quartiles.

A time says little by itself. All ways are measured in turn, again and again, so that what else the
machine does hits all alike, and what is told is the ratio of two medians; where the quartiles overlap
there is none to tell.

Examples
--------
>>> from dexterity.timing.measurement import Timing, ratio
>>> short = Timing.from_times("exact", 1, [1.0, 1.0, 1.25])
>>> long = Timing.from_times("network", 1, [2.0, 2.0, 2.25])
>>> ratio(long, short)
Ratio(value=2.0, distinguishable=True)
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from torch.utils.benchmark import Timer, set_torch_threads
from torch.utils.benchmark.utils.timer import timer as wall_clock

from dexterity import checks

__all__ = ["Ratio", "Timing", "Way", "measure", "ratio", "three_digits"]


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

    Raises
    ------
    ValueError, TypeError
        If the name is blank or not printable, a number is none, or it is negative or not finite.
    """

    name: str
    configurations: int
    lower: float
    median: float
    upper: float

    def __post_init__(self) -> None:
        time = checks.Real(least=0)
        checks.fields(
            self, name=checks.Name(), configurations=checks.Whole(1), lower=time, median=time, upper=time
        )

    @classmethod
    def from_times(cls, name: str, configurations: int, times: Sequence[float]) -> Timing:
        """Take the quartiles of times [s] that the computation took for all its configurations.

        Raises
        ------
        ValueError
            If there is no time, a time is negative or not finite, or `configurations` is not positive.
        """
        configurations = checks.whole(configurations, "configurations", least=1)
        if isinstance(times, (str, bytes)) or not isinstance(times, Iterable):
            raise TypeError(f"times is {checks.shown(times)}; times [s] are needed")
        times = [checks.real(time, f"times[{i}] of {name!r}", infinite=True) for i, time in enumerate(times)]
        if not times or not np.isfinite(times).all() or min(times) < 0:
            raise ValueError(f"times of {name!r} are {times}; finite ones, at least one, are needed")
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
        return three_digits(self.value) if self.distinguishable else "indistinguishable"


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
    if not isinstance(ways, Iterable):
        raise TypeError(f"ways is {checks.shown(ways)}; ways to compute something are needed")
    ways = tuple(checks.instance(way, "ways", Way) for way in ways)
    names = [way.name for way in ways]
    if not ways or len(set(names)) < len(names):
        raise ValueError(f"ways are named {names}; at least one, each with a name of its own, is needed")
    for way in ways:
        checks.function(way.compute, f"compute of {way.name!r}")
        if checks.whole(way.configurations, f"configurations of {way.name!r}") < 1:
            raise ValueError(f"{way.name!r} has {way.configurations} configurations; at least 1 is needed")
    rounds = checks.whole(rounds, "rounds", least=1)
    # Counts of blocks are no floats beyond some hours.
    seconds = checks.real(seconds, "seconds", above=0, most=86_400)
    checks.function(clock, "clock")

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


@checks.arguments(timing=checks.Instance(Timing), reference=checks.Instance(Timing))
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


def three_digits(value: float) -> str:
    """Write a number to three digits."""
    return f"{value:,.0f}" if value >= 100 else f"{value:#.3g}".rstrip(".")
