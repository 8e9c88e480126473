"""A claim in a space-filling design of readings: whether it holds in each, in which share, and what that turns on.

A design varies all that a paper leaves open at once. A row is one reading and one repetition, which is a draw of data
and weights; the repetitions of a reading are judged together, by the rule of the claim.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
from scipy.stats import chi2_contingency

CHANCE = 0.01
"""Chance, over all factors together, below which the readings are said to differ by a factor."""

_MOST_LEVELS, _NAMED = 6, 2


@dataclass(frozen=True)
class DesignShare:
    """Readings of a design in which a claim holds.

    Attributes
    ----------
    holds
        Whether the claim holds, at least in shape, by reading.
    factors
        What each reading has of each factor that was varied: a row for each reading, a column for each factor.
    """

    holds: pd.Series
    factors: pd.DataFrame | None = None

    def __post_init__(self) -> None:
        if self.holds.empty or self.holds.dtype != bool or self.holds.index.has_duplicates:
            raise ValueError(f"holds needs one truth value for each reading; it is {self.holds}")

    @classmethod
    def of(
        cls,
        values: pd.Series | pd.DataFrame,
        judged: Callable[[Any], bool],
        factors: pd.DataFrame | None = None,
    ) -> DesignShare:
        """Judge the repetitions of each reading together.

        Parameters
        ----------
        values
            A value for each reading and repetition, indexed by both in this order; a column for each part or case
            where a claim has several. A loop that does not end has the value infinity.
        judged
            Whether the claim holds for the values of one reading.
        factors
            What each reading has of each factor.

        Raises
        ------
        ValueError
            If the index has not two levels, or occurs twice, or a value is missing.
        """
        if values.index.nlevels != 2 or values.index.has_duplicates:
            raise ValueError(
                "values of a design need one row for each reading and repetition, indexed by both"
            )
        if np.any(values.isna()):
            raise ValueError("a value of the design is missing; where a loop does not end it is infinity")
        outcomes = {number: judged(own) for number, own in values.groupby(level=0)}
        return cls(pd.Series(outcomes, dtype=bool), factors)

    def __and__(self, other: DesignShare) -> DesignShare:
        """Return the readings in which two claims hold at once; ValueError if the designs differ."""
        if not self.holds.index.equals(other.holds.index):
            raise ValueError("the claims are judged in different readings")
        return DesignShare(self.holds & other.holds, self.factors)

    def __str__(self) -> str:
        text = f"Holds in {self.count} of {self.readings} readings of the design ({self.share:.0%})"
        by = "" if self.factors is None else self.turns_on()
        return f"{text}. It turns on {by}" if by else text

    @property
    def count(self) -> int:
        """Number of readings in which the claim holds."""
        return int(self.holds.sum())

    @property
    def readings(self) -> int:
        """Number of readings."""
        return len(self.holds)

    @property
    def share(self) -> float:
        """Share of the readings in which the claim holds."""
        return self.count / self.readings

    def by_factor(self) -> pd.DataFrame:
        """Compare the readings by what was varied; numbers with many values are cut in two at their median.

        Returns
        -------
        Rows by factor and level, factors that matter most first: the share in which the claim holds, the number of
        readings, and the chance of such differences if the factor did not matter.

        Raises
        ------
        ValueError
            If it is not said what the readings have of the factors.
        """
        rows = []
        for name, own in self._varied.loc[self.holds.index].items():
            level = levels(own)
            table = pd.crosstab(level, self.holds)
            chance = chi2_contingency(table).pvalue if min(table.shape) > 1 else 1.0
            for value, part in self.holds.groupby(level, sort=True):
                rows.append(
                    {
                        "factor": name,
                        "level": value,
                        "share": part.mean(),
                        "readings": len(part),
                        "chance": chance,
                    }
                )
        frame = pd.DataFrame(rows).sort_values("chance", kind="stable")
        return frame.set_index(["factor", "level"])

    def turns_on(self) -> str:
        """Return in words the one or two factors that matter most, of those beyond chance; empty if there is none."""
        compared = self.by_factor()
        limit = CHANCE / self._varied.shape[1]
        parts = []
        for name, own in compared[compared["chance"] < limit].groupby(level="factor", sort=False):
            shares = own["share"].droplevel("factor").items()
            parts.append(
                f"{str(name).replace('_', ' ')} ({', '.join(f'{level}: {share:.0%}' for level, share in shares)})"
            )
        return " and ".join(parts[:_NAMED])

    @property
    def _varied(self) -> pd.DataFrame:
        if self.factors is None:
            raise ValueError("it is not said what the readings have of the factors that were varied")
        return self.factors


def levels(values: pd.Series) -> pd.Series:
    """Return the level of a factor that each reading has, as a text."""
    if not pd.api.types.is_numeric_dtype(values) or values.nunique() <= _MOST_LEVELS:
        return values.map(lambda value: f"{value:g}" if isinstance(value, float) else str(value))
    median = values.median()
    return (values > median).map({False: f"to {median:.3g}", True: f"above {median:.3g}"})
