r"""What a survey may have missed: estimates and bounds from what its own draws saw how often.

Where N independent draws (or starts at each pose) saw :math:`f_1` cells once and :math:`f_2` twice, about
:math:`f_1 (f_1 - 1) / (2 (f_2 + 1))` were seen by none (Chao 1987), a lower bound where some are harder to
see than others. A share that is k of m in a random sample is at most the upper end of Clopper and Pearson's
interval. A survey in closed form misses nothing.

Examples
--------
>>> from dexterity.reach import missed
>>> round(missed.largest_share(0, 300), 4)
0.0099
>>> missed.unseen([1] * 20 + [2] * 50 + [5] * 1000)
3.7254901960784315

References
----------
Chao (1987), Estimating the population size for capture-recapture data with unequal catchability,
Biometrics 43.
Clopper & Pearson (1934), Biometrika 26. Good (1953), Biometrika 40.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.stats import beta

from dexterity import checks

__all__ = ["CONFIDENCE", "Missed", "largest_share", "unseen"]

CONFIDENCE = 0.95
"""How sure an upper bound is."""


@dataclass(frozen=True)
class Missed:
    """What a map may lack.

    Attributes
    ----------
    estimate
        Expected number of poses, among those looked at, that are in reach though the map says otherwise.
    upper
        Number that this does not exceed, with a confidence of 95 %, in the sense that `basis` states; None
        where there is no such bound.
    share
        Upper bound, with the same confidence, of the share of configurations, drawn uniformly within the
        limits, whose pose the map lacks; None where no configurations were drawn.
    basis
        Where the numbers come from and what they mean, in a sentence or two.
    """

    estimate: float
    upper: float | None
    share: float | None
    basis: str

    def __post_init__(self) -> None:
        checks.fields(
            self,
            estimate=checks.Real(least=0.0),
            upper=checks.OrNone(checks.Real(least=0.0)),
            share=checks.OrNone(checks.Real(least=0.0, most=1.0)),
            basis=checks.Name(),
        )


def largest_share(hits: int, trials: int, confidence: float = CONFIDENCE) -> float:
    """Return the upper end of Clopper and Pearson's one-sided interval of a share; 1 without any trial.

    Raises
    ------
    ValueError
        If there are fewer trials than hits, or the confidence is not between 0 and 1.
    """
    trials = checks.whole(trials, "trials", least=0)
    hits = checks.whole(hits, "hits", least=0, most=trials)
    level = checks.real(confidence, "confidence", above=0.0, below=1.0)
    return 1.0 if hits == trials else float(beta.ppf(level, hits + 1, trials - hits))


def unseen(times: ArrayLike) -> float:
    """Return Chao's estimate of how many cells no draw saw, from how often each of the others was seen.

    Parameters
    ----------
    times
        How often cells were seen; zeros do not count.
    """
    seen = np.asarray(times)
    once, twice = int((seen == 1).sum()), int((seen == 2).sum())
    return once * (once - 1) / (2 * (twice + 1))
