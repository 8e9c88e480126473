"""Verdicts on the indices and ellipsoids of paper A."""

from __future__ import annotations

from collections.abc import Iterator

from dexterity_study.claims.judge import Judge, by_reading
from dexterity_study.claims.outcome import Acceptance, Verdict
from dexterity_study.engine.evidence import Evidence
from dexterity_study.uvms.kinematics.verdicts import BASE, LAST, by_joint

RANDOM = "configurations-compared=random"
NEAR_HOME = "configurations-compared=near-home"
"""Readings in which random configurations are compared, and not those that hold the tool in one pose."""


def verdicts(evidence: Evidence) -> Iterator[Verdict]:
    """Judge the claims of the chapter."""
    on = Judge("sotiropoulos2016")
    formulas = evidence["formulas"]
    taus = evidence["rankings"].by_seed("tau", over="pair")
    determinant, reciprocal = formulas.values("determinant"), formulas.values("reciprocal")
    tau = taus["KCI, tool rates of 1 m/s against 0.1 m/s"].median()
    note = (
        "With limits that carry units neither index depends on the unit of length; with tool rates of one KCI does "
        f"(τ = {tau:.2f} between metres and decimetres)."
    )
    yield on("normalised-jacobian", formulas.values("unit_free"), note)
    yield on("w-product-of-singular-values", determinant, "Relative deviation from Eq. 8.")
    note = "Relative deviation from Eq. 9; close to a singularity the determinant has half of the digits."
    yield on("w-root-determinant", determinant, note)
    left = evidence["motions"].where(motion="UVMS, roll")["speed_left"]
    yield on("zero-w-loses-directions", left, "Speed left along the direction that the whole UVMS loses.")
    fastest, slowest, near_home = (
        taus[f"w against the {speed}"]
        for speed in (
            "largest speed of the tool point",
            "smallest speed of the tool point",
            "largest speed of the tool point, near home",
        )
    )
    at_rest = Evidence("uvms.tasks")["agreement"].by_seed("tau", over="pair")
    yield on(
        "w-means-speed",
        by_reading({"chosen": at_rest["w, largest speed"], RANDOM: fastest, NEAR_HOME: near_home}),
        f"Kendall's τ of w with the largest speed of the tool point is {at_rest['w, largest speed'].median():.2f} among "
        f"configurations that hold the tool where it is. It is {fastest.median():.2f} among random ones within ±60°, and "
        f"{near_home.median():.2f} within ±15°; with the smallest speed it is {slowest.median():.2f} within ±60°. w is the volume of an ellipsoid and not its longest axis.",
        form="{:.2f}",
    )
    outside = f"{formulas.where()['outside'].max():.0e}"
    note = "A 6 × 12 matrix has no eigenvectors. With left singular vectors no velocity of unit joint rates leaves the ellipsoid"
    yield on.underspecified("ellipsoid-axes", f"{note} by more than this.", outside)
    yield on("w-ellipsoid-volume", formulas.values("volume"), "Relative range of the ratio, which is π³/6.")
    yield on(
        "force-ellipsoid-reciprocal", reciprocal, "Reciprocal semi-axes by duality of twists and wrenches."
    )
    note = "Speed times force is one along each principal axis: what is gained in speed is lost in force."
    yield on("major-axis-fast-minor-axis-strong", reciprocal < 1e-9, note)
    note = "True of the linear rows of the geometric Jacobian. Those of the paper's, the spatial one, move another point."
    yield on.underspecified("translational-ellipsoid", note)
    yield on("kci-ratio", formulas.values("condition"), "Deviation from one over numpy's condition number.")
    conditioning = evidence["conditioning"].where()
    note = (
        "KCI of the vehicle alone at home about the world's origin, less one: its Jacobian is the identity."
    )
    yield on("kci-one-is-isotropic", conditioning["vehicle_alone"] - 1, note)
    geometric = "which-jacobian=geometric"
    of_frame = {
        "chosen": at_rest["spatial KCI, accuracy"],
        geometric: at_rest["geometric KCI, accuracy"],
        RANDOM: taus["spatial KCI against accuracy of the tool"],
        f"{RANDOM}+{geometric}": taus["geometric KCI against accuracy of the tool"],
        NEAR_HOME: taus["spatial KCI against accuracy of the tool, near home"],
        f"{NEAR_HOME}+{geometric}": taus["geometric KCI against accuracy of the tool, near home"],
    }
    sets = Evidence("uvms.tasks")["candidate_sets"]
    about = {
        name: sets.where(name, set="tool at rest", index="spatial KCI").set_index("seed")["tau"]
        for name in sets.readings
        if name != "chosen"
    }
    of_frame |= about
    lowest, highest = (of(own.median() for own in about.values()) for of in (min, max))
    yield on(
        "kci-means-accuracy",
        by_reading(of_frame),
        "Kendall's τ of KCI with the smallness of the tool error that small joint errors cause. In the spatial and in the "
        f"geometric frame it is {of_frame['chosen'].median():.2f} and {of_frame[geometric].median():.2f} among configurations "
        f"that hold the tool, {of_frame[RANDOM].median():.2f} and {of_frame[f'{RANDOM}+{geometric}'].median():.2f} among random "
        f"ones; about other origins the spatial one goes from {lowest:.2f} to {highest:.2f}. KCI grades how evenly errors "
        "spread, and only through that how large they are.",
        form="{:.2f}",
    )
    changes = by_joint(evidence["changes_of_kci"])
    unequal = f"else up to {conditioning['body_last_joint_unequal'].max():.0%}"
    note = f"In the spatial frame always; in the body frame only while tool rates are equal within a block ({unequal})."
    yield on("kci-last-joint-irrelevant", changes[LAST], note)
    others = changes.drop(columns=LAST)
    chosen = others.loc["chosen"].to_numpy()
    yield on(
        "kci-eleven-joints",
        others.min(axis="columns") > 1e-3,
        "Smallest and largest change by one joint, about a fixed world origin. The choice of that origin alone moves KCI at "
        f"home from {conditioning['lowest'].min():.2f} to {conditioning['highest'].max():.2f}; in the body frame θ1 to θ4 "
        "change nothing.",
        ours=f"{chosen.min():.0%} to {chosen.max():.0%}",
    )


def acceptance(evidence: Evidence) -> Iterator[Acceptance]:
    """Figures that must hold for the book to be accepted."""
    formulas, changes = evidence["formulas"].where(), by_joint(evidence["changes_of_kci"])
    yield Acceptance("w by Eq. 8 against Eq. 9, relative", formulas["determinant"].max(), 1e-9)
    yield Acceptance("w from frame to frame, relative", formulas["w_frame"].max(), 1e-12)
    yield Acceptance("spatial KCI under θ12, relative", changes.loc["chosen"][LAST].max(), 1e-12)
    still = changes.loc["which-jacobian=body"][BASE].to_numpy().max()
    yield Acceptance("body KCI under θ1–θ4, relative", still, 1e-12)
    smallest = evidence["motions"].where().set_index("motion")["smallest_w"]
    yield Acceptance("w of the arm with its elbow straight", smallest["arm, elbow"], 1e-12)
    yield Acceptance("w of the UVMS at its singularity", smallest["UVMS, roll"], 1e-12)
