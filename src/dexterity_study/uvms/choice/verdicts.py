"""Verdicts on which network to use."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pandas as pd

from dexterity import operations
from dexterity_study.claims.judge import Judge, by_reading
from dexterity_study.claims.outcome import Acceptance, Verdict
from dexterity_study.engine.evidence import Evidence
from dexterity_study.uvms.choice.experiment import KINDS
from dexterity_study.uvms.feed_forward.experiment import AS_PRINTED
from dexterity_study.uvms.feed_forward.verdicts import ends, networks
from dexterity_study.uvms.unprinted import design_values, in_design


def verdicts(evidence: Evidence) -> Iterator[Verdict]:
    """Judge the claims of the chapter."""
    on = Judge("sotiropoulos2016")
    limit = on.printed("feed-forward-within-two-per-cent")
    yield from _on_networks(on, evidence, limit)
    yield from _on_pruning(on, evidence)
    yield from _on_other_systems(on, evidence, limit)
    counts = evidence["cards"].where(index="w", kind="feed-forward").iloc[0]
    yield on.out_of_scope(
        "networks-in-hardware",
        "No hardware is built here. The neurons of a network are independent of each other, which suits hardware; the exact "
        f"w takes {counts['exact_operations'] / counts['operations']:.1f} times the operations of its network.",
    )


def acceptance(evidence: Evidence) -> Iterator[Acceptance]:
    """Figures that must hold for the book to be accepted."""
    for index, metric, limit in (("w", "sampled", 0.0025), ("KCI", "worst", 0.01)):
        value = evidence["judged"].values(metric, index=index, what="feed-forward").iloc[0]
        yield Acceptance(f"error of the shipped network for {index}, {metric}", float(value), limit)


def _on_networks(on: Judge, evidence: Evidence, limit: float) -> Iterator[Verdict]:
    judged = evidence["judged"].where()
    shipped = judged[judged["what"].isin(KINDS)]
    for kind in KINDS:
        own = shipped[shipped["what"] == kind]
        errors = {"chosen": own["worst"], "what-two-per-cent-means=test-set": own["sampled"]}
        yield on(
            f"{kind}-within-two-per-cent",
            by_reading({reading: each.to_numpy() <= limit for reading, each in errors.items()}),
            "Worst case by ascent, as far as a search tells, of networks that were chosen for their worst case and have other "
            "training sets than the paper's; in the other reading, the largest error on drawn points.",
            ours="; ".join(
                f"{name}: {worst:.2%}" for name, worst in zip(own["index"], own["worst"], strict=True)
            ),
        )
    constant = evidence["judged"].where(what="constant").set_index("index")["sampled"]
    tested = Evidence("uvms.radial_basis")["constants"].by_seed("testing_error", over="index").median()
    yield on(
        "two-per-cent-acceptable",
        by_reading(
            {
                "chosen": (constant > limit).to_numpy(),
                "what-two-per-cent-means=test-set": (tested > limit).to_numpy(),
            }
        ),
        "An error of this size leaves something to tell configurations by where the best constant has a larger one. For KCI it "
        "is small compared with the range. For w it is not: on the paper's space w hardly varies, and the error hides most of "
        "its differences.",
        ours=", ".join(f"a constant for {index}: {error:.1%}" for index, error in constant.items()),
        design=in_design(
            on,
            "two-per-cent-acceptable",
            pd.DataFrame({index: design_values(f"{index}_constant") > limit for index in constant.index}),
        ),
    )
    times = speeds(evidence).xs("feed-forward", level="kind")
    yield on(
        "feed-forward-is-the-choice",
        dict(times["faster"]),
        "Faster than the exact index, both in C, quartiles apart. Among networks it is the choice. But the exact index, "
        "compiled from its derivation, needs no data, has no error, holds for all joint values, and gives gradients.",
        ours=", ".join(f"{index}: exact / network {ratio}" for index, ratio in times["ratio"].items()),
    )
    yield on.underspecified(
        "planner-closer-to-real-time",
        "A planner gains most by vectorised and compiled code, with a network or with the exact index. The paper does not say "
        "which planner it means, and how much of its time goes into indices.",
    )


def _on_pruning(on: Judge, evidence: Evidence) -> Iterator[Verdict]:
    rows = evidence["pruned"].where()
    limit = on.printed("radial-basis-within-two-per-cent")
    removed = rows.assign(share=1 - rows["after"] / rows["before"], within=rows["allowed"] <= limit)
    by_index = removed.groupby("index", sort=False)
    yield on(
        "pruning-helps-radial-basis",
        {index: bool((own["within"] & (own["share"] > 0)).any()) for index, own in by_index},
        "Cases: indices for which networks of the paper's size lose neurons and stay within E. They were grown at given "
        "spreads, at which fewer neurons reach E too, and pruned by the test set that accepts them. For KCI none is within E; "
        f"these networks lose {by_index['share'].median()['KCI']:.0%} of the neurons while the error grows by at most a tenth.",
        ours=", ".join(f"{own['share'].median():.0%} of the neurons ({index})" for index, own in by_index),
    )
    pruned = {index: own["operations"] for index, own in by_index}
    small = ends(Evidence("uvms.feed_forward"), "w").xs("chosen")
    inputs = int(Evidence("uvms.sampling")["values"].where(index="w")["inputs"].iloc[0].count(" ")) + 1
    loops = [
        operations.feed_forward(inputs, int(neurons)).total for neurons in small["neurons"][small["passes"]]
    ]
    printed = rows[rows["index"] == "KCI"]["feed_forward_operations"].median()
    yield on(
        "pruning-does-not-close-the-gap",
        {"w": bool(pruned["w"].median() > np.median(loops)), "KCI": bool(pruned["KCI"].min() > printed)},
        "Operations by the paper's rules. For w both kinds are within E: the median pruned network against the median network "
        "with which the printed feed-forward loop ends. For KCI the smallest pruned network, which is less accurate, against "
        "the paper's feed-forward network.",
        ours=f"{pruned['w'].median():.0f} against {np.median(loops):.0f} operations (w), {pruned['KCI'].min():.0f} against "
        f"{printed:.0f} (KCI)",
    )


def _on_other_systems(on: Judge, evidence: Evidence, limit: float) -> Iterator[Verdict]:
    rows = evidence["elsewhere"].where()
    names = rows["system"] + ", " + rows["index"]
    medians = rows["error"].groupby([rows["claim"], names], sort=False).median()
    errors = {str(claim): own.droplevel("claim") for claim, own in medians.groupby(level="claim")}
    within = {
        claim: {str(name): bool(e <= limit) for name, e in own.items()} for claim, own in errors.items()
    }
    learned = Evidence("uvms.feed_forward")
    own_uvms = {
        f"the paper's UVMS as printed, {index}": bool(
            networks(learned, index, AS_PRINTED)["testing_error"].median() <= limit
        )
        for index in ("w", "KCI")
    }
    cases = own_uvms | within["any-uvms"]
    failing = [name for name, holds in cases.items() if not holds]
    yield on(
        "any-uvms",
        cases,
        "Cases: systems and indices whose feed-forward networks of the paper's sizes are within E. All kinds cannot be tried. "
        "The paper's own system is trained as printed. The others have arms about random postures, vehicles at the origin and "
        "a training of our own, which makes them easier.",
        ours=f"{sum(cases.values())} of {len(cases)} within {limit:.0%}"
        + (f", but not {'; '.join(failing)}" if failing else ""),
    )
    library = within["library-of-indices"]
    yield on(
        "library-of-indices",
        library,
        "w and KCI with other limits and in another frame, and w of a fixed arm, whose ranges meet singularities; an index is "
        "zero there, and a relative error has no meaning.",
        ours=f"{sum(library.values())} of {len(library)} within {limit:.0%}, {_span(errors['library-of-indices'])}",
    )
    for claim, open_end in {
        "space-robots": "A base that floats freely moves as its arm does, by conservation of momentum, so that its Jacobian "
        "depends on masses; the paper does not say whether its base is driven. For a driven one with pitch and roll active",
        "mobile-robots": "Wheels that roll bind velocities and not positions, so that no joint can be held in their place; the "
        "paper names no mobile robot. For a vehicle whose missing directions have a rate limit of zero, in a plane",
    }.items():
        holds = within[claim].values()
        note = f"{open_end}, {sum(holds)} of {len(holds)} networks are within {limit:.0%}."
        yield on.underspecified(claim, note, _span(errors[claim]))


def _span(medians: pd.Series) -> str:
    """Write the range of median errors; one beyond the index itself says no more than that."""
    low, high = medians.min(), medians.max()
    return f"medians {low:.1%} to {high:.1%}" if high <= 1 else f"medians {low:.1%} to more than 100%"


def speeds(evidence: Evidence) -> pd.DataFrame:
    """Return the time of the exact index over that of each shipped network, and whether the network is faster."""
    cards = evidence["cards"].where().set_index(["index", "kind"])
    slower, faster = cards["exact_2"] < cards["network_0"], cards["exact_0"] > cards["network_2"]
    ratio = (cards["exact_1"] / cards["network_1"]).map("{:.2f}".format)
    return cards.assign(faster=faster, ratio=ratio.where(slower | faster, "indistinguishable"))
