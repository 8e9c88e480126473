"""Verdicts on the kinematics of paper A."""

from __future__ import annotations

from collections.abc import Iterator

from dexterity_study.claims.judge import Judge
from dexterity_study.claims.outcome import Acceptance, Verdict
from dexterity_study.engine.evidence import Evidence

BASE, LAST = range(4), 11
"""Joints that are said to leave w alone: the first four, and the last."""


def verdicts(evidence: Evidence) -> Iterator[Verdict]:
    """Judge the claims of the chapter."""
    on = Judge("sotiropoulos2016")
    formulas, home = evidence["formulas"], evidence["at_home"]
    twist, forward = formulas.values("twist"), formulas.values("forward")
    yield on(
        "revolute-twist",
        twist,
        "The exponential of a joint's twist leaves every point of its axis in place [m].",
    )
    yield on("prismatic-twist", twist, "The exponential of a joint's twist is the plain translation [m].")
    yield on("twelve-joints", formulas.values("joints"), "Vehicle and arm are one chain.", form="{:g}")
    yield on(
        "vehicle-euler-xyz",
        forward,
        "Rotations about the moved axes x, y, z in this order are what Eq. 3 computes.",
    )
    yield on(
        "product-of-exponentials", forward, "Deviation from the product of matrix exponentials of scipy."
    )
    yield on("home-pose", home.values("deviation"), "Deviation of the tool pose at home from Eq. 4.")
    yield on(
        "jacobian-maps-rates",
        evidence["tool_velocity"].values("deviation"),
        "The spatial Jacobian gives the twist of the tool body about the world's origin; its linear rows miss the "
        "velocity of the tool point by this much [m/s] for unit joint rates. Those of the geometric Jacobian are it.",
    )
    where = formulas.where()
    yield on.misprint(
        "jacobian-columns",
        "With g_st(0) inside the adjoint the columns differ from the derivative of Eq. 3, and w would change by up to "
        f"{where['printed_base_change'].max():.0%} under θ1 to θ4, against the paper's own base invariance; without it "
        f"they agree to {where['spatial'].max():.0e}.",
        f"off by {where['printed'].max():.2g}",
    )
    yield on(
        "last-joint-irrelevant",
        formulas.values("spatial_last_joint"),
        "Change of the spatial Jacobian when θ12 alone is redrawn; the body Jacobian changes by up to "
        f"{where['body_last_joint'].max():.2g}.",
    )
    changes = (
        evidence["changes_of_w"]
        .where(None)
        .pivot_table(index=["reading", "seed"], columns="joint", values="change", sort=False)
    )
    largest = changes[list(BASE)].max(axis="columns")
    slow_heave = changes.loc["velocity-limits=slow-heave"][BASE[-1]].max()
    yield on(
        "w-base-invariant",
        largest,
        f"With heave five times slower than sway, w changes by up to {slow_heave:.0%} under θ4: the invariance under θ4 "
        "needs equal velocity limits in y and z, which the paper does not say. That under θ1 to θ3 needs nothing.",
    )
    inner = changes.drop(columns=[*BASE, LAST])
    only_these = (inner.min(axis="columns") > 1e-3) & (changes[[*BASE, LAST]].max(axis="columns") < 1e-9)
    yield on(
        "w-seven-joints",
        only_these,
        "Smallest and largest of the changes by θ5 to θ11, each redrawn alone. With unequal translation limits θ4 is an "
        "eighth.",
        ours=f"{inner.loc['chosen'].to_numpy().min():.1%} to {inner.loc['chosen'].to_numpy().max():.1%}",
    )


def acceptance(evidence: Evidence) -> Iterator[Acceptance]:
    """Figures that must hold for the book to be accepted."""
    formulas, changes = evidence["formulas"].where(), evidence["changes_of_w"]
    yield Acceptance("forward kinematics against scipy.linalg.expm", formulas["forward"].max(), 1e-12)
    for frame in ("spatial", "body", "geometric"):
        yield Acceptance(f"{frame} Jacobian against central differences", formulas[frame].max(), 1e-8)
    still = [
        changes.where(reading, joint=joint)["change"].max()
        for reading in ("chosen", "velocity-limits=rov")
        for joint in (*BASE, LAST)
    ]
    yield Acceptance("relative change of w under θ1–θ4 and θ12, equal translation limits", max(still), 1e-12)
    moved = changes.where("velocity-limits=slow-heave", joint=BASE[-1])["change"].min()
    yield Acceptance("counter-example: θ4 leaves w alone with unequal limits", 0.01 / moved, 1.0)
