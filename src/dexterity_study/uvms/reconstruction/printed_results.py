"""The results that paper A prints of its four networks, and the readings in which they come out."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import reduce
from operator import and_

import numpy as np
import pandas as pd

from dexterity_study.claims.design import DesignShare
from dexterity_study.claims.judge import HALF, Judge
from dexterity_study.uvms.feed_forward.experiment import LIMIT
from dexterity_study.uvms.reconstruction.experiment import PRINTED
from dexterity_study.uvms.unprinted import ends_of_growth, ends_of_loops, factors

Rows = pd.DataFrame


@dataclass(frozen=True)
class PrintedResult:
    """Something that a reading bears out, or does not.

    Attributes
    ----------
    title
        Words for tables and figures.
    values
        What rows have on it: truth values, of which half have to be true, or what the rule of the claim judges.
    claim
        Claim whose rule is asked; none for truth values.
    """

    title: str
    values: Callable[[Rows], pd.Series]
    claim: str = ""

    def share(self, rows: Rows) -> DesignShare:
        """Return the readings of the design in which it comes out."""
        values = self.values(rows)
        if self.claim:
            return Judge("sotiropoulos2016").in_design(self.claim, values, factors())
        return DesignShare.of(values, lambda own: bool(np.mean(own) >= HALF), factors())


RESULTS = (
    PrintedResult("w: no constant passes", lambda rows: rows["w_constant"] > LIMIT),
    PrintedResult(
        "w: loop ends near 8 sigmoids", lambda rows: ends_of_loops("w", rows), "feed-forward-w-neurons"
    ),
    PrintedResult(
        "w: 8 sigmoids pass, trained to the goal", lambda rows: rows["w_ff_printed_error"] <= LIMIT
    ),
    PrintedResult(
        "w: loop ends near 149 RBF units",
        lambda rows: ends_of_growth("w", rows=rows),
        "radial-basis-w-neurons",
    ),
    PrintedResult(
        "KCI: loop ends near 25 sigmoids", lambda rows: ends_of_loops("KCI", rows), "feed-forward-kci-neurons"
    ),
    PrintedResult(
        "KCI: 25 sigmoids pass, trained to the goal", lambda rows: rows["KCI_ff_printed_error"] <= LIMIT
    ),
    PrintedResult("KCI: 25 sigmoids pass, trained further", lambda rows: rows["KCI_ff_error"] <= LIMIT),
    PrintedResult(
        "KCI: loop ends near a spread of 8.9",
        lambda rows: ends_of_growth("KCI", "spread", rows),
        "radial-basis-kci-spread",
    ),
    PrintedResult(
        "KCI: 142 RBF units of spread 8.9 pass",
        lambda rows: units_at_printed_spread(rows) <= PRINTED["KCI"][1],
    ),
)
"""What is asked of a reading."""


def units_at_printed_spread(rows: Rows) -> pd.Series:
    """Return the neurons that pass the test for KCI at the printed spread; infinity where none do."""
    return rows["KCI_rb_at_printed_spread"].astype(float).replace(0, np.inf)


def come_out(rows: Rows) -> pd.DataFrame:
    """Return which result comes out in which reading: a row for each reading, a column for each title."""
    return pd.DataFrame({one.title: one.share(rows).holds for one in RESULTS})


def all_at_once(rows: Rows) -> DesignShare:
    """Return the readings in which every result comes out."""
    return reduce(and_, (one.share(rows) for one in RESULTS))
