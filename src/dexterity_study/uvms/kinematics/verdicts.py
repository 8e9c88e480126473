"""Verdicts on the kinematics of paper A."""

from __future__ import annotations

from collections.abc import Iterator

import pandas as pd

from dexterity_study.claims.judge import Judge, by_reading
from dexterity_study.claims.outcome import Acceptance, Verdict
from dexterity_study.engine.evidence import Evidence
from dexterity_study.engine.table import Table
from dexterity_study.uvms.kinematics.experiment import FRAMES

BASE, LAST = list(range(4)), 11
"""Joints that are said to leave w alone: the first four, and the last."""


def by_joint(table: Table) -> pd.DataFrame:
    """Return changes of an index, a row for each reading and seed and a column for each joint."""
    return table.where(None).pivot_table(
        index=["reading", "seed"], columns="joint", values="change", sort=False
    )


def verdicts(evidence: Evidence) -> Iterator[Verdict]:
    """Judge the claims of the chapter."""
    on = Judge("sotiropoulos2016")
    formulas = evidence["formulas"]
    where = formulas.where()
    twist, forward = formulas.values("twist"), formulas.values("forward")
    yield on(
        "revolute-twist", twist, "The exponential of a twist leaves every point of its axis in place [m]."
    )
    yield on("prismatic-twist", twist, "The exponential of a joint's twist is the plain translation [m].")
    yield on("twelve-joints", formulas.values("joints"), "Vehicle and arm are one chain.", form="{:g}")
    yield on("vehicle-euler-xyz", forward, "Eq. 3 rotates about the moved axes x, y, z in this order.")
    yield on("product-of-exponentials", forward, "Deviation from the product of scipy's matrix exponentials.")
    home = evidence["at_home"].values("deviation")
    yield on("home-pose", home, "Deviation of the tool pose at home from Eq. 4.")
    missed = evidence["tool_velocity"].where()["deviation"]
    yield on(
        "jacobian-maps-rates",
        by_reading({"chosen": where["spatial"], "which-jacobian=geometric": missed}),
        "As the twist of the tool body about the world's origin, which the symbol stands for, it is right. As the velocity "
        f"of the tool point, of which the text speaks, the linear rows miss by up to {missed.max():.2g} m/s for unit joint "
        "rates; those of the geometric Jacobian are that velocity.",
    )
    counts = Evidence("uvms.cost")["counts"].where(what="Jacobian").set_index("form")["operations"]
    yield on.misprint(
        "jacobian-columns",
        "With g_st(0) inside the adjoint the columns differ from the derivative of Eq. 3, and w would change by up to "
        f"{where['printed_base_change'].max():.0%} under θ1 to θ4, against the paper's own base invariance; without it "
        f"they agree to {where['spatial'].max():.0e}. The paper counts {on.printed('jacobian-operations'):.0f} operations. As "
        f"printed the entries take {counts['written out, as printed in Eq. 6']:.0f}, without g_st(0) "
        f"{counts['written out']:.0f} (with l1 = 0 {counts['written out, as printed in Eq. 6, l1 = 0']:.0f} and "
        f"{counts['written out, l1 = 0']:.0f}): the authors computed the right Jacobian.",
        f"off by {where['printed'].max():.2g}",
    )
    body = f"the body Jacobian changes by up to {where['body_last_joint'].max():.2g}"
    note = f"Change of the spatial Jacobian when θ12 alone is redrawn; {body}."
    yield on("last-joint-irrelevant", formulas.values("spatial_last_joint"), note)
    changes = by_joint(evidence["changes_of_w"])
    slow_heave = changes.loc["velocity-limits=slow-heave"][3].max()
    note = (
        f"With z five times slower than y, w changes by up to {slow_heave:.0%} under θ4 (angles within ±60°): the invariance under θ4 "
        "needs equal velocity limits in y and z, which the paper does not say. That under θ1 to θ3 needs nothing."
    )
    yield on("w-base-invariant", changes[BASE].max(axis="columns"), note)
    inner = changes.drop(columns=[*BASE, LAST])
    chosen = inner.loc["chosen"].to_numpy()
    only_these = (inner.min(axis="columns") > 1e-3) & (changes[[*BASE, LAST]].max(axis="columns") < 1e-9)
    note = "Smallest and largest change by one of θ5 to θ11. With unequal translation limits θ4 is an eighth."
    yield on("w-seven-joints", only_these, note, ours=f"{chosen.min():.1%} to {chosen.max():.1%}")


def acceptance(evidence: Evidence) -> Iterator[Acceptance]:
    """Figures that must hold for the book to be accepted."""
    formulas, changes = evidence["formulas"].where(), by_joint(evidence["changes_of_w"])
    yield Acceptance("forward kinematics against scipy.linalg.expm", formulas["forward"].max(), 1e-12)
    for frame in FRAMES:
        yield Acceptance(f"{frame} Jacobian against central differences", formulas[frame].max(), 1e-8)
    still = changes.loc[["chosen", "velocity-limits=rov"], [*BASE, LAST]].to_numpy().max()
    yield Acceptance("relative change of w under θ1–θ4 and θ12, equal translation limits", still, 1e-12)
    moved = changes.loc["velocity-limits=slow-heave"][3].min()
    yield Acceptance("counter-example: θ4 leaves w alone with unequal limits", 0.01 / moved, 1.0)
