"""Verdicts on what paper B leaves for later: more points, a hovering vehicle, a vertical surface."""

from __future__ import annotations

from collections.abc import Iterator

import pandas as pd
from scipy.stats import kendalltau

from dexterity_study.claims.judge import Judge
from dexterity_study.claims.outcome import Acceptance, Verdict
from dexterity_study.docking.search.experiment import NEAR
from dexterity_study.engine.evidence import Evidence


def verdicts(evidence: Evidence) -> Iterator[Verdict]:
    """Judge the claims of the chapter; the method extends easily if the median genetic run comes near the optimum."""
    on = Judge("sotiropoulos2011")
    rate = evidence["rates"].where().set_index("points")["rate"]
    few, *_, many = rate.index
    note = (
        f"Kendall's τ; {many} points take {rate[few] / rate[many]:.0f} times as long as {few}, on one core."
    )
    yield on("more-points-are-slower", [kendalltau(rate.index, -rate).statistic], note, form="{:.2f}")
    medians = shares(evidence).groupby(["reading", "face", "tilt"], sort=False).median()
    top, side = (medians["chosen"][face].min() for face in ("top", "side"))
    yield on(
        "hovering-and-vertical",
        medians >= NEAR,
        f"Tilts and the side at which the median genetic run comes to {NEAR:.0%} of the best; two more variables, or another "
        "face with its own limits, are all that has to be added.",
        ours=f"{top:.0%} of the best (roll and pitch, worst tilt), {side:.0%} (side)",
    )


def acceptance(evidence: Evidence) -> Iterator[Acceptance]:
    """Figures that must hold for the book to be accepted."""
    for best in evidence["optimum"].where(None).to_dict("records"):
        name = f"difference of two methods, {best['reading']}, {best['face']}, tilt {best['tilt']:g}"
        yield Acceptance(name, abs(best["evolved"] / best["value"] - 1), 0.02)


def shares(evidence: Evidence) -> pd.Series:
    """Return the fitness of the genetic runs beside the best, by reading, face, tilt and seed."""
    names = ["reading", "face", "tilt"]
    best = evidence["optimum"].where(None).set_index(names)[["value", "evolved"]].max(axis="columns")
    runs = evidence["genetic"].where(None).set_index(names)
    return (runs["fitness"] / best.loc[runs.index].to_numpy()).rename("share")
