"""Verdicts on the worked example and the data of paper C."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator

import numpy as np
import pandas as pd

from dexterity.workspace.reachability import LINK_NAMES
from dexterity_study.claims.judge import Judge, by_reading
from dexterity_study.claims.ledger import load_paper
from dexterity_study.claims.outcome import Acceptance, Verdict
from dexterity_study.engine.evidence import Evidence
from dexterity_study.workspace.data.experiment import SAME

UNIFORM = 0.01
"""Distance from the uniform distribution, beyond what chance makes of it, up to which draws are called uniform."""

MIDDLE = "sine of the middle angle"

VELOCITIES = {
    "fanuc-first-velocity": (0, slice(0, 3)),
    "fanuc-second-velocity": (1, slice(0, 3)),
    "fanuc-third-velocity": (2, slice(0, 2)),
    "fanuc-third-velocity-upwards": (2, slice(2, 3)),
    "fanuc-fifth-velocity": (4, slice(0, 3)),
    "fanuc-first-angular-velocity": (0, slice(3, 6)),
}
"""Joint, and rows of its column of the Jacobian."""


def verdicts(evidence: Evidence) -> Iterator[Verdict]:
    """Judge the claims of the chapter."""
    on = Judge("liao2018")
    yield from _on_the_fanuc(on, evidence)
    yield from _on_maps_to_learn(on, evidence)
    yield from _on_the_sets(on, evidence)


def acceptance(evidence: Evidence) -> Iterator[Acceptance]:
    """Figures that must hold for the book to be accepted."""
    rule, shares = evidence["rule"].where().iloc[0], evidence["influence"].where().set_index("columns")
    yield Acceptance("poses on which rule and branches disagree", rule["disagreements"], 0)
    yield Acceptance("poses that are lost or won as the tool turns", rule["turned"], 0)
    yield Acceptance("what the label needs of the angles", shares["label"]["three angles"], 0)
    yield Acceptance("what being kept needs of friction", shares["kept"][["viscous", "coulomb"]].max(), 0)


def _on_the_fanuc(on: Judge, evidence: Evidence) -> Iterator[Verdict]:
    fanuc, row = evidence["fanuc"], evidence["fanuc"].where().iloc[0]
    J, central = fanuc.array("jacobian")[0], fanuc.array("central")[0].min()
    for claim, (joint, rows) in VELOCITIES.items():
        ours = (np.round(J[rows, joint], 12) + 0.0).tolist()
        note = "Exact, from the published parameters of the arm."
        yield on(claim, ours if len(ours) > 1 else ours[0], note, form="{:g}")
    printed = np.reshape(on.printed("fanuc-rotation-difference"), (3, 3))
    off = (np.argwhere(np.abs(fanuc.array("pose")[0, :3, :3] - printed) > 1e-6) + 1).tolist()
    yield on.misprint(
        "fanuc-rotation-difference",
        "The rotation at zero is the identity, whose derivative is skew and has a diagonal of zeros. The angular "
        "velocity that Eq. 7 prints for this joint needs a zero there too.",
        f"{len(off)} of 9 entries off, at {', '.join(f'({row}, {column})' for row, column in off)}",
    )
    sideways = np.abs(J[[0, 2], 0]).max() / abs(J[1, 0])
    yield on("fanuc-first-joint-sideways", sideways, "The tool point is straight ahead of the first axis.")
    moves = (np.abs(J[:3]).max(0) > SAME).tolist()
    cases = {f"joint {joint}": moved == (joint in (1, 2, 3, 5)) for joint, moved in enumerate(moves, 1)}
    ours = f"joints {', '.join(str(joint) for joint, moved in enumerate(moves, 1) if moved)} move it"
    note = "The axes of the other joints pass through the tool point."
    yield on("fanuc-moving-joints", cases, note, ours=ours)
    limit = (
        "Largest error of central differences at their best step. With the paper's step, forwards, it is "
        f"{row['printed_step']:.0e}, from rounding."
    )
    yield on("pose-difference", central, limit)
    yield on("angular-velocity", central, f"{limit} Only the skew part of the difference counts.")
    note = (
        "Eq. 5 lacks the rates, which Eq. 6 has, and joint 1 with its row. With each derivative times its rate the sum "
        "is the derivative of the pose."
    )
    yield on.misprint("sum-of-derivatives", note, f"within {row['sum']:.0e} with the rates")


def _on_maps_to_learn(on: Judge, evidence: Evidence) -> Iterator[Verdict]:
    rule = evidence["rule"].where().iloc[0]
    plain = in_reach(evidence)["redraw=0"]
    note = (
        "A left inverse would tell these configurations apart. Inverse kinematics gives one of them, and is a right "
        "inverse where poses are in reach."
    )
    ours = f"{rule['eight']:.1%} of the poses in reach have eight configurations"
    yield on("forward-has-left-inverse", [bool(rule["eight"] == 0)], note, ours=ours)
    note = "Of the poses that the sampler draws. For this family position decides, and orientation never."
    ours = f"{1 - plain:.0%} of the poses are out of reach"
    yield on("forward-not-onto", [bool(plain < 1)], note, ours=ours)
    note = "It is a function only if a branch is named, which the sampler does and the paper does not."
    ours = f"{rule['jacobians']:.1%} of the poses in reach have eight Jacobians"
    yield on.underspecified("jacobian-of-a-pose", note, ours)
    note = (
        f"The first map is an exact rule of two lines, with {rule['disagreements']} disagreements in {rule['tried']:,} "
        "poses. The second as printed has no pose to depend on, and needs one and a branch."
    )
    cases = {
        "a map for what is in reach": bool(rule["disagreements"] == 0),
        "a Jacobian of manipulator and answer": bool(rule["jacobians"] == 0),
    }
    yield on("two-steps", cases, note)


def _on_the_sets(on: Judge, evidence: Evidence) -> Iterator[Verdict]:
    facts = evidence["files"].where(columns="all")
    chance = 2 / math.sqrt(facts["samples"].max())
    far = uniformity(evidence)
    largest = far.drop(columns=MIDDLE).max(axis=1)
    even = (largest < UNIFORM + chance).to_dict()
    kept = {"labels": even["labels"], "Jacobians": even["Jacobians"]}
    yield on(
        "sampler-is-uniform",
        by_reading({"chosen": kept, "redraw=0": kept | {"labels": even["labels, nothing redrawn"]}}),
        f"Of the rows that are kept; draws are uniform by construction. Largest distance of a column: "
        f"{', '.join(f'{name}: {value:.3f}' for name, value in largest.items())}. Orientations are not uniform either: the "
        f"{MIDDLE} is {far[MIDDLE].iloc[0]:.2f} from uniform.",
        ours=", ".join(f"{name}: {'yes' if held else 'no'}" for name, held in kept.items()),
    )
    yield on.out_of_scope(
        "sampler-purposes", "Only the sets that the paper's networks are trained on are made here."
    )
    shares, implied = in_reach(evidence), implied_shares()
    redrawn, plain = (
        sum(low <= shares[reading] <= high for low, high in implied.values())
        for reading in ("chosen", "redraw=0")
    )
    yield on.underspecified(
        "class-balance",
        f"The figure has no numbers. Of the {len(implied)} rows of Table VI {redrawn} and {plain} fit these shares; most "
        f"fit {np.median([sum(bounds) / 2 for bounds in implied.values()]):.0%}, which the paper does not mention.",
        f"{shares['chosen']:.1%} in reach, {shares['redraw=0']:.1%} if nothing is redrawn",
    )
    maps = evidence["maps"].where()
    lengths = maps[maps["quantity"].isin(LINK_NAMES)].groupby("map")["determination"]
    ranges = lengths.agg(lambda own: f"{own.min():.2f} to {own.max():.2f}")
    for claim, name in (("map-of-features", "features"), ("map-of-jacobians", "Jacobians")):
        yield on.underspecified(
            claim,
            "No settings are printed, and the text does not say what is to be seen. Ten neighbours on our map predict "
            f"the lengths with this R²; on a map of uniform noise they predict its columns with {ranges['noise']}.",
            ranges[name],
        )


def in_reach(evidence: Evidence) -> pd.Series:
    """Return the share of poses in reach of the training set with dynamics, by reading."""
    return evidence["files"].values("mean_target", file="conf_dyna, train", columns="all").droplevel("seed")


def uniformity(evidence: Evidence) -> pd.DataFrame:
    """Return the largest distance of a column from the uniform distribution, by set and by group of columns."""
    sources = {
        "labels, nothing redrawn": ("redraw=0", "conf, train"),
        "labels": ("chosen", "conf, train"),
        "Jacobians": ("chosen", "jacob, train"),
    }
    rows = {
        name: evidence["files"].where(reading, file=file).set_index("columns")["distance"].dropna()
        for name, (reading, file) in sources.items()
    }
    return pd.DataFrame(rows).T[["links", "position", "angles", MIDDLE]]


def implied_shares() -> dict[str, tuple[float, float]]:
    """Return the shares of poses in reach that JSC, precision and recall of the rows of Table VI allow, by method.

    JSC is the share of right answers; with precision p, recall r and share s of poses in reach,
    1 − JSC = s (1 − 2 r + r / p). The rounding of the three allows an interval.
    """
    paper = load_paper("liao2018")
    found = {}
    for claim in paper.claims:
        kind, _, method = claim.id.partition("-")
        if kind == "retrieval":
            right = paper.claim(f"confidence-{method}")
            printed = (paper.printed(right.id)[0], *paper.printed(claim.id))
            off = (right.rounding, claim.rounding, claim.rounding)
            corners = itertools.product(*((v - o, min(1, v + o)) for v, o in zip(printed, off, strict=True)))
            shares = [(1 - j) / (1 - 2 * r + r / p) for j, p, r in corners]
            name = " ".join(NAMES.get(word, word) for word in method.split("-"))
            found[name] = min(shares), max(shares)
    return found


NAMES = {"svm": "SVM", "xgboost": "XGBoost", "lightgbm": "LightGBM", "bayes": "Bayes", "gaussian": "Gaussian"}
