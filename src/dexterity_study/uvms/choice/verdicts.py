"""Verdicts on which network to use."""

from __future__ import annotations

from collections.abc import Iterator

import pandas as pd

from dexterity_study.claims.judge import Judge
from dexterity_study.claims.outcome import Acceptance, Verdict
from dexterity_study.engine.evidence import Evidence
from dexterity_study.uvms.choice.experiment import KINDS


def verdicts(evidence: Evidence) -> Iterator[Verdict]:
    """Judge the claims of the chapter."""
    on = Judge("sotiropoulos2016")
    limit = on.printed("all-networks-within-two-per-cent")
    yield from _on_networks(on, evidence, limit)
    yield from _on_pruning(on, evidence)
    rows = evidence["elsewhere"].where()
    systems = rows.groupby(["claim", "system", "index"], sort=False)["error"].median()
    for claim, note in {
        "any-uvms": "The paper's numbers of neurons, for arms about random postures, on vehicles at the origin.",
        "library-of-indices": "w and KCI with other limits and in another frame, and w of a fixed arm, whose ranges meet "
        "singularities; an index is zero there, and a relative error has no meaning.",
        "space-robots": "Pitch and roll are active in all vehicles of this package.",
        "mobile-robots": "A direction that the vehicle lacks has a rate limit of zero.",
    }.items():
        medians = systems[claim]
        cases = {", ".join(names): bool(error <= limit) for names, error in medians.items()}
        span = f"medians {medians.min():.1%} to {medians.max():.1%}"
        yield on(claim, cases, note, ours=f"{sum(cases.values())} of {len(cases)} within {limit:.0%}, {span}")
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
    worst = dict(zip(shipped["what"] + ", " + shipped["index"], shipped["worst"], strict=True))
    yield on(
        "all-networks-within-two-per-cent",
        {name: error <= limit for name, error in worst.items()},
        "Worst case by ascent, as far as a search tells, of networks that were chosen for their worst case and have other "
        "training sets than the paper's.",
        ours="; ".join(f"{name}: {error:.2%}" for name, error in worst.items()),
    )
    constant = evidence["judged"].where(what="constant").set_index("index")["sampled"]
    yield on(
        "two-per-cent-acceptable",
        {index: bool(error > 2 * limit) for index, error in constant.items()},
        "A constant has an error above twice the accepted one. On the paper's space w hardly varies, and an error of this "
        "size hides most of its differences; for KCI it is small compared with the range.",
        ours=", ".join(f"a constant for {index}: {error:.1%}" for index, error in constant.items()),
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
    removed = (1 - rows["after"] / rows["before"]).groupby(rows["index"], sort=False).median()
    gaps = (rows["operations"] / rows["feed_forward_operations"]).groupby(rows["index"], sort=False).min()
    yield on(
        "pruning-helps-radial-basis",
        {index: bool(share >= 0.1) for index, share in removed.items()},
        "A tenth of the neurons or more, median over the spreads, while the testing error stays within E or, where E was "
        "not reached, within a tenth more than it was.",
        ours=", ".join(f"{share:.0%} of the neurons ({index})" for index, share in removed.items()),
    )
    yield on(
        "pruning-does-not-close-the-gap",
        {index: bool(gap >= 1.5) for index, gap in gaps.items()},
        "Operations of the smallest pruned network, by the paper's rules, are at least 1.5 times those of the paper's "
        "feed-forward network. For w at this error a feed-forward network could be smaller too.",
        ours=", ".join(f"{gap:.1f} times the operations ({index})" for index, gap in gaps.items()),
    )


def speeds(evidence: Evidence) -> pd.DataFrame:
    """Return the time of the exact index over that of each shipped network, and whether the network is faster."""
    cards = evidence["cards"].where().set_index(["index", "kind"])
    slower, faster = cards["exact_2"] < cards["network_0"], cards["exact_0"] > cards["network_2"]
    ratio = (cards["exact_1"] / cards["network_1"]).map("{:.2f}".format)
    return cards.assign(faster=faster, ratio=ratio.where(slower | faster, "indistinguishable"))
