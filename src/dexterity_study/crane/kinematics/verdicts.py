"""Verdicts on the rigid crane of paper D."""

from __future__ import annotations

from collections.abc import Iterator

from dexterity_study.claims.judge import Judge
from dexterity_study.claims.outcome import Acceptance, Verdict
from dexterity_study.crane.kinematics.experiment import NANOMETRE
from dexterity_study.engine.evidence import Evidence
from dexterity_study.page.numbers import with_range

SEVERAL = 20.0
"""Millimetres of the tip for a millimetre of a stroke that are called several centimetres."""


def verdicts(evidence: Evidence) -> Iterator[Verdict]:
    """Judge the claims of the chapter."""
    on = Judge("rouvinen1999")
    yield from _on_the_tip(on, evidence)
    yield from _on_the_inverse(on, evidence)
    yield from _on_the_extension(on, evidence)


def acceptance(evidence: Evidence) -> Iterator[Acceptance]:
    """Figures that must hold for the book to be accepted."""
    for name, experiment, metric in (
        ("lengths of the lift linkage, relative", "formulas", "lift"),
        ("lengths of the jib linkage, relative", "formulas", "jib"),
        ("tip from the product of the transforms, as a share of the reach", "formulas", "transforms"),
        ("least extension beyond a shorter one that reaches [m]", "working_area", "excess"),
        ("tip of the rigid crane from strokes of the inverse [m]", "inverse", "round_trip"),
    ):
        yield Acceptance(name, evidence[experiment].values(metric).max(), NANOMETRE)


def _on_the_tip(on: Judge, evidence: Evidence) -> Iterator[Verdict]:
    formulas, gains = evidence["formulas"], evidence["gains"]
    note = "Largest relative miss of the cylinder's length at any posture."
    yield on("crane-lift-angle", formulas.values("lift"), note)
    note = "Largest relative miss of the lengths of cylinder, crank and coupler."
    yield on("crane-jib-angle", formulas.values("jib"), note)
    note = f"Largest distance from the plane's two rotations, as a share of the reach. The third axis of frame 5 points down in the plane, so that −0.008 is up; taken for down, the tip is {1e3 * formulas.where()['downwards'].max():.0f} mm off."
    yield on("crane-transforms", formulas.values("transforms"), note)
    lift, jib = (gains.values("largest", of=name) >= SEVERAL for name in ("lift", "jib"))
    gain = gains.where().groupby("of")["median"].median()
    note = f"A millimetre of the lift cylinder moves the tip by {gain['lift']:.0f} mm in the median, a millimetre of the jib cylinder by {gain['jib']:.0f} mm; at the test points by up to {gains.where()['at_tests'].max():.0f} mm."
    yield on("crane-amplification", lift | jib, note)


def _on_the_inverse(on: Judge, evidence: Evidence) -> Iterator[Verdict]:
    area, inverse = evidence["working_area"], evidence["inverse"]
    chosen, rows = area.where().iloc[0], inverse.where()
    note = f"The range of extensions that reach a point is {chosen['span_median']:.2f} m in the median; a tenth of the points have less than {chosen['span_first_decile']:.2f} m, a tenth more than {chosen['span_last_decile']:.2f} m."
    ours = f"{chosen['several']:.0%} of the working area has several extensions"
    yield on("crane-redundant", area.values("several") > 0.5, note, ours=ours)
    note = f"Not for this crane: with an extension given, or the least one, the strokes follow by the law of cosines, and no posture with the elbow up is lost. The other way to bend is its mirror image; {with_range(100 * rows['elbow_down'], '{:.0f}')} % of random strokes have it."
    missed = (inverse.values("round_trip") >= NANOMETRE) | (inverse.values("lost") > 0)
    yield on(
        "crane-no-closed-form", missed, note, ours=f"closed form within {rows['round_trip'].max():.0e} m"
    )
    note = f"Given the extension, there are two ways to bend the elbow; the cylinders have both for {with_range(100 * rows['pairs'], '{:.0f}')} % of random strokes, and never more."
    two = (inverse.values("most") == 2) & (inverse.values("pairs") > 0)
    yield on(
        "crane-one-joint-given", two, note, ours=f"{rows['most'].max()} pairs of lift and jib stroke at most"
    )


def _on_the_extension(on: Judge, evidence: Evidence) -> Iterator[Verdict]:
    area, rules = evidence["working_area"], evidence["rules"].where().set_index("circle")
    chosen, folded, outer = area.where().iloc[0], rules.loc["folded"], rules.drop("folded")
    overlooked = area.where(None)[["overlooked", "jib_stroke"]].to_numpy()
    shares = " and ".join(
        f"{share:.1%} of the area with a jib stroke of {s2:g} m" for share, s2 in overlooked
    )
    note = f"A closed form gives it: a search through all extensions finds none that is shorter. It overlooks {shares}; with the shorter stroke the arms do not fold all the way."
    least = (area.values("excess") < NANOMETRE) & (area.values("overlooked") == 0)
    yield on("crane-least-extension", least, note, ours=f"{chosen['excess']:.0e} m longer than the search's")
    note = "With the radii that the linkage gives. An extension is needed inside the first, outside the third, and outside the second below the lift arm's lowest line."
    ours = f"wrong in {chosen['disagreement']:.2g} of the working area"
    yield on("crane-three-circles", area.values("disagreement") == 0, note, ours=ours)
    note = f"As printed it gives extensions that are wrong by up to {rules['by_squares'].max():.1f} m. The thesis's own rule for the extension is that of the square of a sum, (r + s₃)²."
    yield on.misprint("crane-circle", note)
    note = f"The listing's shorter stroke makes it longer. It is least, {chosen['inner_least']:.4f} m, at {chosen['inner_least_at']:.3f} m, where the arms are folded. The printed radius belongs to no end."
    yield on("crane-inner-radius", area.values("inner_at_end"), note, form="{:.3f}", unit="m")
    printed = on.printed("crane-inner-radius")
    off = max(abs(folded[end] / printed - 1) for end in ("smallest", "largest"))
    note = f"Where the circle decides, the rule gives {1e3 * (printed - folded['largest']):.0f} to {1e3 * (printed - folded['smallest']):.0f} mm too much. Its limit on x leaves no point of the circle out. Below the lift arm's lowest line the second circle asks for more."
    yield on("crane-inner-rule", off, note)
    note = f"The extension slides beside the line from the joint, so that the reach grows by a little less than the stroke: the rule stops up to {1e3 * (outer['radius'] - outer['smallest']).max():.1f} mm short of the point."
    yield on("crane-extension-rule", (outer["smallest"] / outer["radius"] - 1).abs().max(), note)
