"""Tables of the chapter on the control loop, from rows of its experiment."""

from __future__ import annotations

import math

import numpy as np
import pandas as pd

from dexterity_study.engine.evidence import Evidence
from dexterity_study.page.markup import Markup
from dexterity_study.page.tables import show
from dexterity_study.workspace.control.verdicts import LIMITS, LONGER, longer_products, needed_gains, products
from dexterity_study.workspace.puma.experiment import FEEDBACK

NAMES = {
    "exact": "exact",
    "rotation": "rotation matrix",
    "plane": "plane of the arm",
    LONGER["rotation"]: "rotation matrix, longer training",
    LONGER["plane"]: "plane, longer training",
}
"""Jacobians by their names in the rows: the exact one, and what a network takes as input."""


def gains(stored: Evidence, puma: Evidence) -> Markup:
    """Set the error times the gain of each Jacobian, and the gains that meet the limits.

    The last two rows are the networks of the maps, at the one gain that they were run with.
    """
    product, needed = products(stored), needed_gains(stored, puma)
    product = product.where(np.isfinite(product))
    spans = pd.DataFrame({"least": product.min(axis=1), "most": product.max(axis=1)})
    longer = longer_products(puma).rename(index=LONGER)
    spans = pd.concat([spans, pd.DataFrame({"least": longer, "most": longer})])
    wrong = pd.concat(
        [
            stored["gains"].where().groupby("jacobian")["jacobian_error"].median(),
            puma["learned"].where(case=FEEDBACK).set_index("network")["jacobian_error"].rename(index=LONGER),
        ]
    )
    columns = {
        "wrong by [%]": 100 * wrong.astype(float),
        "error × gain: least [mm/s]": 1e3 * spans["least"],
        "most [mm/s]": 1e3 * spans["most"],
        **{f"gain for {name} of the radius [1/s]": needed[name].map(_written) for name in LIMITS},
    }
    table = pd.DataFrame(columns).loc[list(NAMES)].rename(index=NAMES)
    return show(table.rename_axis("Jacobian"), "{:.2g}")


def _written(gain: float) -> str:
    return "none" if math.isinf(gain) else f"{gain:.2g}"
