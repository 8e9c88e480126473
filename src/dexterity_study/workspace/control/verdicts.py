"""Verdicts on the control loop of paper C, by the gain that a Jacobian needs and not by its error at a chosen gain."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
import pandas as pd

from dexterity_study.claims.judge import Judge
from dexterity_study.claims.outcome import Acceptance, Verdict
from dexterity_study.engine.evidence import Evidence
from dexterity_study.engine.readings import Reading
from dexterity_study.workspace.control.experiment import EXACT
from dexterity_study.workspace.puma.experiment import FEEDBACK, FINE
from dexterity_study.workspace.puma.verdicts import worst_of_maps

READING: Mapping[str, Any] = Reading.chosen("liao2018")

LIMITS = {"a tenth": 0.1, "a hundredth": 0.01}
"""Largest distances from the circle, in shares of its radius, to which a loop is held."""

LONGER = {"rotation": "rotation, longer training", "plane": "plane, longer training"}
"""Names of the networks of the maps, which are trained on more rows and for more epochs."""


def verdicts(evidence: Evidence, of_puma: Evidence | None = None) -> Iterator[Verdict]:
    """Judge the claims of the chapter; the loop at the chosen gain and the maps are evidence of the PUMA's."""
    on, puma = Judge("liao2018"), of_puma or Evidence("workspace.puma")
    needed = needed_gains(evidence, puma)
    networks = needed.loc[["rotation", LONGER["rotation"]]]
    in_loop = {
        f"{name} of the radius, {training}": bool(gain <= networks["largest gain"].loc[row])
        for name in LIMITS
        for row, training in zip(networks.index, ("shorter training", "longer training"), strict=True)
        for gain in [networks.loc[row, name]]
    }
    told = "; ".join(
        f"{row}: {' and '.join(f'{gain:.2g}' if gain < math.inf else 'none' for gain in needed.loc[row, list(LIMITS)])}"
        for row in needed.index
    )
    note = (
        f"Smallest gains [1/s] with which the tool stays within {' and '.join(LIMITS)} of the radius: {told}. With the "
        f"network of rotation matrices the loop runs to its end up to a gain of {networks['largest gain'].max():g}."
    )
    precise = bool(worst_of_maps(puma)["error"]["rotation"] <= READING["varies-slightly"][1])
    yield on("jacobian-is-useful", in_loop | {"for manipulability": precise}, note)
    note = f"{note} Forward kinematics, which closes the loop, is all that the exact Jacobian needs."
    yield on("rate-control-through-the-pose", in_loop, note)
    radius, loops = READING["rate-control-path"][0], puma["loops"]
    largest, fine = (loops.values("largest", case=case) for case in (FEEDBACK, FINE))
    holds = (loops.values("ended", case=FEEDBACK) == "on time") & (largest <= LIMITS["a hundredth"] * radius)
    note = (
        "Largest distance with the exact Jacobian, within a hundredth of the radius. It is the error of Euler's "
        f"steps: steps of fourth order, ten times as long, leave {1e3 * fine['chosen'].max():.1g} mm."
    )
    yield on("rate-control-scheme", holds, note, ours=f"{1e3 * largest['chosen'].max():.2g} mm")
    yield on.not_run(
        "rate-control-by-angles",
        "No such network is made, here or in the paper. With the angles at hand the Jacobian is a product of known frames.",
    )


def acceptance(evidence: Evidence) -> Iterator[Acceptance]:
    """Figures that must hold for the book to be accepted: the exact loop's error times its gain hardly varies."""
    product = products(evidence).loc[EXACT].to_numpy(dtype=float)
    ratio = float(product.max() / product.min())
    yield Acceptance("exact loop: largest over smallest error times gain", ratio, 1.5)


def products(evidence: Evidence) -> pd.DataFrame:
    """Return the largest distance from the circle times the gain [m/s], by Jacobian and gain; infinite if a run ended."""
    rows = evidence["gains"].where()
    largest = rows["largest"].astype(float).where(rows["ended"] == "on time", math.inf)
    table = rows.assign(product=largest * rows["gain"].astype(float))
    return table.pivot(index="jacobian", columns="gain", values="product").loc[rows["jacobian"].unique()]


def needed_gains(evidence: Evidence, puma: Evidence) -> pd.DataFrame:
    """Return the smallest gains [1/s] that hold the tool within each limit, and the largest with which a run ended on time.

    The last rows are the networks of the maps, which are trained longer. They were run at the gain of the ledger
    only: their product of error and gain, which hardly depends on the gain, is divided by the limit.
    """
    radius, table = READING["rate-control-path"][0], products(evidence)
    gains = table.columns.to_numpy(dtype=float)
    rows = {
        str(name): {
            **{
                limit: smallest_gain(gains, own.to_numpy() / gains, share * radius)
                for limit, share in LIMITS.items()
            },
            "largest gain": float(gains[np.isfinite(own.to_numpy())].max()),
        }
        for name, own in table.iterrows()
    }
    for name, product in longer_products(puma).items():
        held = {limit: product / (share * radius) for limit, share in LIMITS.items()}
        rows[LONGER[str(name)]] = {**held, "largest gain": rows[str(name)]["largest gain"]}
    return pd.DataFrame.from_dict(rows, orient="index")


def longer_products(puma: Evidence) -> pd.Series:
    """Return error times gain [m/s] of the networks that are trained longer, by what they take."""
    loops = puma["learned"].where(case=FEEDBACK).set_index("network")
    largest = loops["largest"].astype(float).where(loops["ended"] == "on time", math.inf)
    return largest * READING["rate-control-path"][3]


def smallest_gain(gains: np.ndarray, errors: np.ndarray, limit: float) -> float:
    """Return the smallest gain with which an error is within a limit.

    Parameters
    ----------
    gains
        (n,) rising, positive [1/s].
    errors
        (n,) largest distances with these gains [m], infinite for a run that ended early.
    limit
        Largest distance that is allowed [m].

    Returns
    -------
    The gain [1/s]: between two that were run along a straight line of the logarithms, below all of them in proportion
    to the error; infinity if no error is within the limit.
    """
    within = np.flatnonzero(errors <= limit)
    if len(within) == 0:
        return math.inf
    first = within[0]
    if first == 0:
        return float(gains[0] * errors[0] / limit)
    if math.isinf(errors[first - 1]):
        return float(gains[first])
    high, low = np.log(errors[first - 1]), np.log(errors[first])
    part = (high - math.log(limit)) / (high - low)
    return float(np.exp(np.log(gains[first - 1]) + part * np.log(gains[first] / gains[first - 1])))
