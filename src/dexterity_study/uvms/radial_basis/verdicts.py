"""Verdicts on the radial-basis networks of paper A."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pandas as pd
from scipy.stats import kendalltau

from dexterity_study.claims.judge import Judge
from dexterity_study.claims.outcome import Acceptance, Verdict
from dexterity_study.engine.evidence import Evidence
from dexterity_study.page.tables import with_range
from dexterity_study.uvms.radial_basis.experiment import INDICES, LEVELS, NEAR, PASS


def verdicts(evidence: Evidence) -> Iterator[Verdict]:
    """Judge the claims of the chapter."""
    on = Judge("sotiropoulos2016")
    yield from _on_equations(on, evidence)
    yield from _on_the_loop(on, evidence)
    yield from _on_spreads(on, evidence)
    yield from _on_sizes(on, evidence)


def acceptance(evidence: Evidence) -> Iterator[Acceptance]:
    """Figures that must hold for the book to be accepted."""
    deviation = evidence["hidden_neurons"].values("deviation").max()
    yield Acceptance("deviation of hidden neurons from Eqs. 17 and 18", deviation, 1e-12)
    smallest = growth_of(evidence, "w").groupby("seed")["smallest"].min().max()
    yield Acceptance("smallest testing error for w at any spread", smallest, PASS)


def _on_equations(on: Judge, evidence: Evidence) -> Iterator[Verdict]:
    neurons = evidence["hidden_neurons"]
    yield on(
        "radial-basis-activation",
        neurons.values("deviation"),
        "Largest deviation of hidden neurons from the formula.",
    )
    printed = evidence["printed_form"].values("testing_error")
    constant = evidence["constants"].values("testing_error", index="w")
    smallest = growth_of(evidence, "w").groupby("seed")["smallest"].min()
    yield on.misprint(
        "radial-basis-hidden-layer",
        "The plain sum of the differences depends on a configuration only through the sum of its joints, whereas the "
        "paper's text on the spread speaks of a distance. A norm is missing; with it the testing error for w is "
        f"{smallest.median():.2%}.",
        f"{printed.median():.2%}; a constant has {constant.median():.2%}",
    )
    yield on(
        "half-at-spread",
        neurons.values("at_spread"),
        "Answer at the spread itself; the printed bias is rounded up, so that a half is missed by a little.",
        form="{:.4f}",
    )
    goals, thresholds = (
        on.printed(f"radial-basis-{name}") for name in ("training-error-goals", "error-thresholds")
    )
    ordered = {name: high > low for name, high, low in zip(INDICES, thresholds, goals, strict=True)}
    yield on("threshold-above-goal", ordered, "The table says so.")


def _on_the_loop(on: Judge, evidence: Evidence) -> Iterator[Verdict]:
    loop, kci = evidence["loop"], growth_of(evidence, "KCI")
    neurons, random = loop.values("neurons"), loop.where()["random_centres"]
    kci_errors = kci.groupby("seed")["smallest"].min()
    yield on(
        "radial-basis-design-loop",
        {
            "w": loop.where()["success"].mean() > 0.5,
            "KCI": bool((kci_errors < PASS).mean() > 0.5),
        },
        "The loop for w stops at the first spread that passes and not at the best one: over all spreads "
        f"{_fewest(evidence).median():.0f} neurons are enough. A network of the same size with random centres has "
        f"a testing error of {random.median():.2%}; the loop's has {loop.where()['testing_error'].median():.2%}.",
    )
    yield on(
        "radial-basis-w-neurons",
        neurons,
        "Neurons at which the printed loop for w stops; this depends on the first spread, the step, and the draw. "
        f"The smallest network over all spreads has {with_range(_fewest(evidence), '{:g}')}.",
        form="{:g}",
        unit="neurons",
    )
    yield on(
        "radial-basis-w-error",
        loop.values("testing_error"),
        f"The loop stops when this holds; on fresh points it is {with_range(loop.where()['fresh'], '{:.2%}')}. "
        f"With more neurons {growth_of(evidence, 'w').groupby('seed')['smallest'].min().median():.2%} is reached.",
        form="{:.2%}",
    )
    yield on(
        "radial-basis-kci-error",
        kci_errors,
        f"Smallest testing error of all sizes up to {kci['neurons'].max():g} neurons and all spreads. KCI has kinks "
        "where the two smallest singular values meet, and smooth units round them off.",
        form="{:.1%}",
    )


def _on_spreads(on: Judge, evidence: Evidence) -> Iterator[Verdict]:
    w, kci = growth_of(evidence, "w"), growth_of(evidence, "KCI")
    best = {"w": _best_spreads(w), "KCI": _best_spreads(kci)}
    passes = bool((kci.groupby("seed")["smallest"].min() < PASS).mean() > 0.5)
    what = "the smallest network that passes" if passes else "the smallest testing error; no spread passes"
    if passes:
        yield on("radial-basis-kci-spread", best["KCI"], f"Spread of {what}.", form="{:g}")
    else:
        yield on.not_run(
            "radial-basis-kci-spread",
            "No network for KCI passes, so that the loop has no spread to return. The smallest testing error is "
            f"found at a spread of {with_range(best['KCI'], '{:g}')}.",
        )
    yield on(
        "kci-needs-larger-spread",
        (best["KCI"] > best["w"]).to_numpy(),
        f"Spread of the smallest network that passes for w, and for KCI of {what}.",
        ours=f"{best['KCI'].median():g} against {best['w'].median():g}",
    )
    taus = w.groupby("seed").apply(lambda own: kendalltau(own["spread"], -own["smallest"]).statistic)
    medians = w.groupby("spread")[["smallest", "active"]].median()
    widths = medians.iloc[[0, len(medians) // 2, -1]]["smallest"]
    yield on(
        "larger-spread-generalises",
        taus,
        "Kendall's τ between spread and smallest testing error for w, which is "
        f"{', '.join(f'{error:.2%}' for error in widths)} at the narrowest, a middle and the widest spread. The share "
        f"of neurons that answer a half or more goes from {medians['active'].iloc[0]:.0%} to "
        f"{medians['active'].iloc[-1]:.0%}.",
        form="{:.2f}",
    )
    near = kci[kci["smallest"] < NEAR].groupby("seed")["spread"].min()
    starts = near.reindex(kci["seed"].unique(), fill_value=np.nan)
    yield on(
        "near-misses-start-at-spread",
        starts,
        "Smallest spread, of those tried, at which some network is below five per cent.",
        form="{:g}",
    )
    wide = kci[kci["spread"] > on.printed("near-misses-start-at-spread")].groupby("seed")["smallest"].min()
    yield on("near-misses-error", wide, "Smallest testing error at spreads above 1.5.", form="{:.1%}")
    long = evidence["lifted_limit"].where()
    at_limit = long[long["neurons"] <= kci["neurons"].max()]["testing_error"].iloc[-1]
    yield on(
        "neuron-limit-blocks-near-misses",
        [bool(long["testing_error"].min() < PASS)],
        f"One seed at the printed spread; with the study's neuron limit it is {at_limit:.1%}. The units are smooth, and "
        "KCI has kinks where its two smallest singular values meet.",
        ours=f"{long['testing_error'].min():.1%} with up to {long['neurons'].max()} neurons",
    )


def _on_sizes(on: Judge, evidence: Evidence) -> Iterator[Verdict]:
    pairs = needed_by_both(evidence)
    kci = growth_of(evidence, "KCI").groupby("seed")["smallest"].min()
    feed_forward = evidence["feed_forward"].where(index="KCI")
    yield on(
        "radial-basis-larger-than-feed-forward",
        {f"{level:.1%}": bool(own.median() > other.median()) for level, (own, other) in pairs.items()},
        f"Cases: testing errors that both kinds reach for w. For KCI the radial-basis networks have {kci.median():.1%}, "
        f"feed-forward networks of {feed_forward['neurons'].max()} neurons "
        f"{feed_forward['testing_error'].median():.1%}. But wide units answer everywhere, not in a small region only.",
        ours="; ".join(
            f"{level:.1%}: {a.median():g} against {b.median():g}" for level, (a, b) in pairs.items()
        ),
    )
    spaces = evidence["input_spaces"].where()
    taus = []
    for _, own in spaces.groupby("seed"):
        for column, fixed in (
            ("half_range_deg", own["joints"] == 7),
            ("joints", own["half_range_deg"] == 15),
        ):
            cases = own[fixed]
            taus.append(kendalltau(cases[column], cases["neurons"].replace(0, np.inf)).statistic)
    yield on(
        "larger-input-space-more-neurons",
        taus,
        "Kendall's τ between the fewest neurons for w to a testing error of 1 % and the range of the joints, and the "
        "number of joints.",
        form="{:.2f}",
    )


# ---- numbers that verdicts and figures share -------------------------------------------------------


def growth_of(evidence: Evidence, index: str) -> pd.DataFrame:
    """Return the rows of the networks grown for an index."""
    return evidence["growth"].where(index=index)


def needed_by_both(evidence: Evidence) -> dict[float, tuple[pd.Series, pd.Series]]:
    """Return the neurons that both kinds of networks take for w, by the errors that both reach and a constant does not."""
    both = {}
    constant = evidence["constants"].where(index="w")["testing_error"].min()
    trained = evidence["feed_forward"].where(index="w")
    for level in LEVELS:
        radial = _fewest(evidence, level)
        other = trained[trained["testing_error"] < level].groupby("seed")["neurons"].min()
        reached = len(radial) == growth_of(evidence, "w")["seed"].nunique()
        if level < constant and reached and len(other) == trained["seed"].nunique():
            both[level] = (radial, other)
    return both


def _fewest(evidence: Evidence, level: float = PASS) -> pd.Series:
    """Return the fewest neurons for w below an error at any spread, by seed."""
    rows = growth_of(evidence, "w")
    needed = f"needed_{level:g}"
    return rows[rows[needed] > 0].groupby("seed")[needed].min()


def _best_spreads(rows: pd.DataFrame) -> pd.Series:
    """Return the spread of the smallest network that passes, or else of the smallest testing error, by seed."""
    size = rows[f"needed_{PASS:g}"].replace(0, np.nan)
    score = size if size.notna().any() else rows["smallest"]
    return rows.loc[score.groupby(rows["seed"]).idxmin()].set_index("seed")["spread"]
