"""Verdicts on the radial-basis networks of paper A."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pandas as pd
from scipy.stats import kendalltau

from dexterity_study.claims.design import DesignShare
from dexterity_study.claims.judge import Judge, by_reading
from dexterity_study.claims.outcome import Acceptance, Verdict
from dexterity_study.engine.evidence import Evidence
from dexterity_study.page.numbers import with_range
from dexterity_study.uvms.feed_forward.experiment import INDICES, LIMIT
from dexterity_study.uvms.radial_basis.experiment import LEVELS
from dexterity_study.uvms.reconstruction.experiment import PRINTED
from dexterity_study.uvms.unprinted import design_values, ends_of_growth, in_design, whole_loops


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
    yield Acceptance("smallest testing error for w at any spread", smallest(evidence, "w").max(), LIMIT)


def _on_equations(on: Judge, evidence: Evidence) -> Iterator[Verdict]:
    neurons = evidence["hidden_neurons"]
    note = "Largest deviation of hidden neurons from the formula."
    yield on("radial-basis-activation", neurons.values("deviation"), note)
    printed = evidence["printed_form"].values("testing_error")
    constant = evidence["constants"].values("testing_error", index="w")
    counted = Evidence("uvms.cost")["counts"].where(what="radial-basis KCI").set_index("form")
    with_norm, without = (
        int(counted["multiplications"][form] / counted["neurons"][form]) for form in ("norm", "printed")
    )
    each = int(on.printed("radial-basis-kci-split")[1] / counted["neurons"]["norm"])
    yield on.misprint(
        "radial-basis-hidden-layer",
        "The plain sum of the differences depends on a configuration only through the sum of its joints, whereas the "
        "paper's text on the spread speaks of a distance. A norm is missing; with it the testing error for w is "
        f"{smallest(evidence, 'w').median():.2%}. The paper's own count has {each} multiplications per neuron. With the norm "
        f"there are {with_norm} for eleven inputs, without it {without}: the authors computed with a norm.",
        f"{printed.median():.2%}; a constant has {constant.median():.2%}",
    )
    note = (
        "Answer at the spread itself; the printed bias is rounded up, so that a half is missed by a little."
    )
    yield on("half-at-spread", neurons.values("at_spread"), note, form="{:.4f}")
    goals, thresholds = (
        on.printed(f"radial-basis-{name}") for name in ("training-error-goals", "error-thresholds")
    )
    ordered = {name: high > low for name, high, low in zip(INDICES, thresholds, goals, strict=True)}
    yield on("threshold-above-goal", ordered, "The table says so.")


def _on_the_loop(on: Judge, evidence: Evidence) -> Iterator[Verdict]:
    table, fewest, kci = evidence["loop"], _fewest(evidence), smallest(evidence, "KCI")
    loop, success, passes_kci = table.where(), table.values("success"), bool((kci < LIMIT).mean() > 0.5)
    yield on(
        "radial-basis-design-loop",
        by_reading(
            {str(name): [own.mean() > 0.5, passes_kci] for name, own in success.groupby(level="reading")}
        ),
        "The loop for w stops at the first spread that passes and not at the best one: over all spreads "
        f"{fewest.median():.0f} neurons are enough. A network of the same size with random centres has "
        f"a testing error of {loop['random_centres'].median():.2%}; the loop's has {loop['testing_error'].median():.2%}.",
        ours=f"w: {loop['success'].sum()} of {len(loop)} loops pass, KCI: {(kci < LIMIT).sum()} of {len(kci)}",
        design=in_design(
            on,
            "radial-basis-design-loop",
            pd.DataFrame({index: ends_of_growth(index) < np.inf for index in INDICES}),
        ),
    )
    raised = whole_loops("w", "radial basis").loc[["base-link-height=0.3"], "neurons"]
    yield on(
        "radial-basis-w-neurons",
        pd.concat([table.values("neurons"), raised]),
        "Neurons at which the printed loop for w stops; this depends on the first spread, the step, and the draw. With a "
        f"shoulder of 0.3 m, which is fitted, it is {with_range(raised, '{:.0f}')}. "
        f"The smallest network over all spreads has {with_range(fewest, '{:g}')}.",
        form="{:g}",
        unit="neurons",
        design=in_design(on, "radial-basis-w-neurons", ends_of_growth("w")),
    )
    yield on(
        "radial-basis-w-error",
        table.values("testing_error"),
        f"The loop stops when this holds; on fresh points it is {with_range(loop['fresh'], '{:.2%}')}. "
        f"With more neurons {smallest(evidence, 'w').median():.2%} is reached.",
        form="{:.2%}",
        design=in_design(on, "radial-basis-w-error", design_values("w_rb_best")),
    )
    smooth = DesignShare.of(design_values("KCI_kinks"), lambda share: bool(np.max(share) == 0))
    yield on(
        "radial-basis-kci-error",
        kci,
        f"Smallest testing error of all sizes up to {growth_of(evidence, 'KCI')['neurons'].max():g} neurons and all "
        "spreads. With unit limits KCI has kinks where the two smallest singular values meet, and smooth units round them "
        f"off. In {smooth.count} of the {smooth.readings} readings of the design there are none.",
        form="{:.1%}",
        design=in_design(on, "radial-basis-kci-error", design_values("KCI_rb_best")),
    )


def _on_spreads(on: Judge, evidence: Evidence) -> Iterator[Verdict]:
    w, kci = growth_of(evidence, "w"), growth_of(evidence, "KCI")
    best_w, best_kci = _best_spreads(w), _best_spreads(kci)
    passes = smallest(evidence, "KCI") < LIMIT
    yield on(
        "radial-basis-kci-spread",
        best_kci.where(passes, np.inf),
        f"Spread of the smallest network that passes; one does for {passes.sum()} of {len(passes)} seeds. The smallest testing "
        f"error is found at a spread of {with_range(best_kci, '{:g}')}.",
        form="{:g}",
        ours="" if passes.any() else "no network passes",
        design=in_design(on, "radial-basis-kci-spread", ends_of_growth("KCI", "spread")),
    )
    both = ends_of_growth("KCI", "spread"), ends_of_growth("w", "spread")
    yield on(
        "kci-needs-larger-spread",
        (best_kci > best_w).to_numpy(),
        "Spread of the smallest network that passes or, where none does, of the smallest testing error. In the design: spread "
        "at which the loop ends, for both indices.",
        ours=f"{best_kci.median():g} against {best_w.median():g}",
        design=in_design(on, "kci-needs-larger-spread", (both[0] > both[1]) & np.isfinite(both[0])),
    )
    medians = w.groupby("spread")[["smallest", "active"]].median()
    widths = medians["smallest"].iloc[[0, len(medians) // 2, -1]].map("{:.2%}".format)
    yield on(
        "larger-spread-generalises",
        w.groupby("seed").apply(lambda own: kendalltau(own["spread"], -own["smallest"]).statistic),
        f"Kendall's τ between spread and smallest testing error for w, which is {', '.join(widths)} at the narrowest, a "
        "middle and the widest spread. The share of neurons that answer a half or more goes from "
        f"{medians['active'].iloc[0]:.0%} to {medians['active'].iloc[-1]:.0%}.",
        form="{:.2f}",
    )
    starts = kci["spread"].where(kci["needed_0.05"] > 0).groupby(kci["seed"]).min()
    note = "Smallest spread, of those tried, at which some network is below five per cent."
    yield on("near-misses-start-at-spread", starts, note, form="{:g}")
    wide = kci[kci["spread"] > on.printed("near-misses-start-at-spread")].groupby("seed")["smallest"].min()
    yield on(
        "near-misses-error",
        wide,
        f"Smallest testing error at spreads above 1.5. In the design: {PRINTED['KCI'][1]} neurons at the printed spread.",
        form="{:.1%}",
        design=in_design(on, "near-misses-error", design_values("KCI_rb_printed_error")),
    )
    errors = evidence["lifted_limit"].where().set_index("neurons")["testing_error"]
    yield on(
        "neuron-limit-blocks-near-misses",
        [bool(errors.min() < LIMIT)],
        "One seed at the printed spread; with the study's neuron limit it is "
        f"{errors.loc[: kci['neurons'].max()].iloc[-1]:.1%}. In the design: E is reached at the printed spread, with more "
        f"neurons than the largest network that the paper accepts, {on.printed('radial-basis-w-neurons'):g}.",
        ours=f"{errors.min():.1%} with up to {errors.index.max()} neurons",
        design=in_design(
            on,
            "neuron-limit-blocks-near-misses",
            design_values("KCI_rb_at_printed_spread") > on.printed("radial-basis-w-neurons"),
        ),
    )


def _on_sizes(on: Judge, evidence: Evidence) -> Iterator[Verdict]:
    pairs = needed_by_both(evidence)
    trained = evidence["feed_forward"].where(index="KCI")
    yield on(
        "radial-basis-larger-than-feed-forward",
        {f"{level:.1%}": bool(own.median() > other.median()) for level, (own, other) in pairs.items()},
        "Cases: testing errors that both kinds reach for w. For KCI the radial-basis networks have "
        f"{smallest(evidence, 'KCI').median():.1%}, feed-forward networks of {trained['neurons'].max()} neurons "
        f"{trained['testing_error'].median():.1%}. But wide units answer everywhere, not in a small region only.",
        ours="; ".join(
            f"{level:.1%}: {own.median():g} against {other.median():g}"
            for level, (own, other) in pairs.items()
        ),
    )
    spaces = evidence["input_spaces"].where().replace({"neurons": {0: np.inf}})
    by_range, by_joints = spaces[spaces["joints"] == 7], spaces[spaces["half_range_deg"] == 15]
    yield on(
        "larger-input-space-more-neurons",
        [
            kendalltau(own[varied], own["neurons"]).statistic
            for varied, cases in (("half_range_deg", by_range), ("joints", by_joints))
            for _, own in cases.groupby("seed")
        ],
        "Kendall's τ between the fewest neurons for w to a testing error of 1 % and the range of the joints, and the "
        "number of joints.",
        form="{:.2f}",
    )


def growth_of(evidence: Evidence, index: str) -> pd.DataFrame:
    """Return the rows of the networks grown for an index."""
    return evidence["growth"].where(index=index)


def smallest(evidence: Evidence, index: str) -> pd.Series:
    """Return the smallest testing error of all networks grown for an index, by seed."""
    return growth_of(evidence, index).groupby("seed")["smallest"].min()


def needed_by_both(evidence: Evidence) -> dict[float, tuple[pd.Series, pd.Series]]:
    """Return the neurons that both kinds of networks take for w, by the errors that both reach and a constant does not."""
    both, constant = {}, evidence["constants"].where(index="w")["testing_error"].min()
    trained = evidence["feed_forward"].where(index="w")
    for level in (level for level in LEVELS if level < constant):
        radial = _fewest(evidence, level)
        other = trained[trained["testing_error"] < level].groupby("seed")["neurons"].min()
        if (len(radial), len(other)) == (len(smallest(evidence, "w")), trained["seed"].nunique()):
            both[level] = (radial, other)
    return both


def _fewest(evidence: Evidence, level: float = LIMIT) -> pd.Series:
    """Return the fewest neurons for w below an error at any spread, by seed."""
    rows, needed = growth_of(evidence, "w"), f"needed_{level:g}"
    return rows[rows[needed] > 0].groupby("seed")[needed].min()


def _best_spreads(rows: pd.DataFrame) -> pd.Series:
    """Return the spread of the smallest network that passes, or else of the smallest testing error, by seed."""
    size = rows[f"needed_{LIMIT:g}"].replace(0, np.nan)
    score = size if size.notna().any() else rows["smallest"]
    return rows.loc[score.groupby(rows["seed"]).idxmin()].set_index("seed")["spread"]
