"""What readings of paper A's unprinted settings have on its claims, for all chapters of the part.

A loop that ends at its limit has found no network: its number of neurons, and its spread, is infinity here.
"""

from __future__ import annotations

from functools import cache

import numpy as np
import pandas as pd

from dexterity_study.claims.design import DesignShare
from dexterity_study.claims.judge import Judge
from dexterity_study.engine.evidence import Evidence
from dexterity_study.uvms.reconstruction.experiment import DESIGN_SEED, FACTORS, FIRST

READINGS = 256
"""Points of the sequence that the design is a part of."""

_IN_THE_LEDGER = {
    "chosen": "chosen",
    "high shoulder": "base-link-height=0.3",
    "fast tool": "velocity-limits=tool-1.5",
    "slow vehicle": "velocity-limits=slow-vehicle",
}
"""Readings of the ledger for which whole loops were run, by their names in the chapter."""


def in_design(on: Judge, claim: str, values: pd.Series | pd.DataFrame) -> DesignShare:
    """Judge a claim in each reading of the space-filling design, by what was varied."""
    return on.in_design(claim, values, factors())


def design() -> pd.DataFrame:
    """Return the rows of the space-filling design by reading and repetition, each reading with a first spread."""
    rows = _stored()["design"].where().set_index(["number", "repetition"]).sort_index()
    return rows.assign(first_spread=first_spreads()[rows.index.get_level_values("number")])


@cache
def _stored() -> Evidence:
    """Return the evidence of the chapter, whose files are read once for all verdicts."""
    return Evidence("uvms.reconstruction")


def first_spreads() -> np.ndarray:
    """Return a first spread of the radial-basis loops for each reading of the sequence, every one equally often."""
    return np.random.default_rng(DESIGN_SEED).permutation(np.repeat(FIRST, READINGS // len(FIRST)))


def factors() -> pd.DataFrame:
    """Return what each reading of the design has of each factor: a row for each, by its number."""
    return design()[[*(factor.name for factor in FACTORS), "first_spread"]].groupby(level="number").first()


def design_values(metric: str) -> pd.Series:
    """Return a metric of the space-filling design, indexed by number of the reading and by repetition."""
    return design()[metric]


def ends_of_loops(index: str, rows: pd.DataFrame | None = None) -> pd.Series:
    """Return the neurons at which the printed feed-forward loop for an index ends.

    Parameters
    ----------
    index
        "w" or "KCI".
    rows
        Rows of an experiment on readings; those of the design unless given.
    """
    rows = design() if rows is None else rows
    return rows[f"{index}_ff_neurons"].astype(float).where(rows[f"{index}_ff_passes"].astype(bool), np.inf)


def ends_of_growth(index: str, metric: str = "neurons", rows: pd.DataFrame | None = None) -> pd.Series:
    """Return where the radial-basis loop for an index ends that begins with the first spread of its reading.

    Parameters
    ----------
    index
        "w" or "KCI".
    metric
        "neurons" or "spread" at the end.
    rows
        Rows of an experiment on readings, with a column `first_spread`; those of the design unless given.
    """
    rows = design() if rows is None else rows
    found = pd.Series(np.inf, rows.index)
    for first in FIRST:
        # Where no reading ends from this spread, there is no column of spreads.
        ended = (rows["first_spread"] == first) & (rows[f"{index}_rb_neurons_from_{first:g}"] > 0)
        found = found.mask(ended, rows.get(f"{index}_rb_{metric}_from_{first:g}"))
    return found


def whole_loops(index: str, kind: str) -> pd.DataFrame:
    """Return the last step of each loop that went to its end or to the printed limit, by reading of the ledger and seed.

    Parameters
    ----------
    index
        "w" or "KCI".
    kind
        "feed-forward" or "radial basis".
    """
    rows = _stored()["loops"].where(index=index, kind=kind)
    return (
        rows.assign(reading=rows["case"].map(_IN_THE_LEDGER)).groupby(["reading", "seed"], sort=False).last()
    )
