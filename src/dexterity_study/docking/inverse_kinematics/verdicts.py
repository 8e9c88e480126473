"""Verdicts on the inverse kinematics of paper B."""

from __future__ import annotations

from collections.abc import Iterator

from dexterity_study.claims.judge import Judge
from dexterity_study.claims.outcome import Acceptance, Verdict
from dexterity_study.docking.inverse_kinematics.experiment import SAME
from dexterity_study.engine.evidence import Evidence

ERROR = 1e-9


def verdicts(evidence: Evidence) -> Iterator[Verdict]:
    """Judge the claims of the chapter; what is solved, on all poses of both arms."""
    on = Judge("sotiropoulos2011")
    trips = evidence["round_trips"].where().set_index("arm")
    own, border = trips.loc[["stated", "fitted"]], evidence["border"].where().iloc[0]
    yield on(
        "paden-kahan",
        {
            "every branch reaches its pose": bool((own["pose_error"] < ERROR).all()),
            "every configuration is found": bool((own["found"] == 1).all()),
            "subproblems 1 to 3 suffice": evidence["three_subproblems"].where()["difference"].item() < SAME,
        },
        "So for the stated arm. The fitted one has its plane beside the first axis, and needs a fourth, which "
        "brings a point onto a plane.",
    )
    values = own["values_of_w"]
    yield on(
        "eight-solutions",
        {"eight": bool((own["branches_8"] > 0.99).all()), "each with its own w": bool((values == 8).any())},
        "A pose that is reached at all has eight where limits are left aside. But the two of the wrist have the same "
        f"w, and in the stated arm so do the two of the shoulder: {values['stated']} different w at most, "
        f"{values['fitted']} in the fitted arm.",
    )
    yield on(
        "solutions-are-discrete",
        {"inside the workspace": border["near"] > SAME, "at its border": border["at_border"] > SAME},
        f"Two branches of the elbow are {border['inside']:.1f} rad apart inside and {border['near']:.0e} rad at "
        f"{border['near_by']:.0e} m from the border. Each changes steadily with the pose, and where the arm is "
        "stretched they meet and go over into each other.",
    )


def acceptance(evidence: Evidence) -> Iterator[Acceptance]:
    """Figures that must hold for the book to be accepted."""
    difference = evidence["three_subproblems"].where()["difference"].item()
    yield Acceptance("difference to what subproblems 1 to 3 give [rad]", difference, SAME)
    trips = evidence["round_trips"].where()
    yield Acceptance("largest error of a branch", trips["pose_error"].max(), 10 * ERROR)
    yield Acceptance("share of configurations that are not found", 1 - trips["found"].min(), 0.0)
    yield Acceptance("share of poses out of reach that are not flagged", 1 - trips["refused"].min(), 0.0)
