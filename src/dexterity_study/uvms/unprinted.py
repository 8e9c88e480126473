"""What the design of readings in the chapter on unprinted settings has on the claims of other chapters."""

from __future__ import annotations

import numpy as np
import pandas as pd

from dexterity_study.claims.design import DesignShare
from dexterity_study.claims.judge import Judge
from dexterity_study.engine.evidence import Evidence
from dexterity_study.uvms.reconstruction.experiment import FACTORS


def in_design(on: Judge, claim: str, values: pd.Series | pd.DataFrame) -> DesignShare:
    """Judge a claim in each reading of the space-filling design, by what was varied."""
    return on.in_design(claim, values, factors())


def factors() -> pd.DataFrame:
    """Return what each reading of the design has of each factor: a row for each, by its number."""
    rows = _rows()[[factor.name for factor in FACTORS]]
    return rows.groupby(level="number").first()


def design_values(metric: str) -> pd.Series:
    """Return a metric of the space-filling design, indexed by number of the reading and by repetition."""
    return _rows()[metric]


def ends_of_loops(index: str) -> pd.Series:
    """Return the neurons at which the printed feed-forward loop for an index ends; infinity where it does not.

    Parameters
    ----------
    index
        "w" or "KCI".
    """
    rows = _rows()
    return rows[f"{index}_ff_neurons"].where(rows[f"{index}_ff_passes"].astype(bool), np.inf)


def ends_of_growth(index: str, metric: str = "neurons") -> pd.Series:
    """Return where the radial-basis loop for an index ends that begins with the smallest spread.

    Parameters
    ----------
    index
        "w" or "KCI".
    metric
        "neurons" or "spread" at the end; infinity where no network passes at any spread.
    """
    rows = _rows()
    ended = rows[f"{index}_rb_neurons_from_0.1"] > 0
    return rows.get(f"{index}_rb_{metric}_from_0.1", pd.Series(np.inf, rows.index)).where(ended, np.inf)


def _rows() -> pd.DataFrame:
    return Evidence("uvms.reconstruction")["design"].rows.set_index(["number", "repetition"])
