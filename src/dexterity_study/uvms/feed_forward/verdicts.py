"""Verdicts on the feed-forward networks of paper A."""

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
from dexterity_study.uvms.feed_forward.experiment import AS_PRINTED, GOALS, LIMIT, TRAINED_ON
from dexterity_study.uvms.unprinted import design_values, ends_of_loops, in_design, whole_loops

FAST_TOOL = "velocity-limits=tool-1.5"
"""The reading of the ledger with a fitted rate of the tool."""


def verdicts(evidence: Evidence) -> Iterator[Verdict]:
    """Judge the claims of the chapter."""
    on = Judge("sotiropoulos2016")
    formulas = evidence["formulas"].where().iloc[0]
    yield on("hidden-activation", formulas["values"], "The printed form of tanh γ overflows for large γ.")
    yield on("output-layer", formulas["values"], "The D_H of Eq. 16 is the X_H of Eq. 15.")
    yield on("levenberg-marquardt-step", formulas["step"], "A step, compared with the printed formula.")
    limits = {"μ = 1e-9": formulas["small_damping"], "μ = 1e12": formulas["large_damping"]}
    note = "Relative deviation of the step from either limit; less than a per cent counts."
    ours = ", ".join(f"{deviation:.0e} at {name}" for name, deviation in limits.items())
    yield on("damping-limits", {name: bool(d < 0.01) for name, d in limits.items()}, note, ours=ours)
    yield from _on_the_loop(on, evidence)
    yield from _on_sizes(on, evidence)
    times = evidence["training_times"].where().pivot(index="rows", columns="neurons", values="median")
    taus = [kendalltau(own.index, own).statistic for table in (times, times.T) for _, own in table.items()]
    yield on(
        "training-time-grows",
        np.median(taus),
        f"Median of Kendall's τ, {with_range(taus, '{:.2f}')}, of a step's time with the rows and with the neurons, the "
        f"other held. A step takes {1e3 * times.to_numpy().min():.2g} to {1e3 * times.to_numpy().max():.3g} ms.",
    )


def acceptance(evidence: Evidence) -> Iterator[Acceptance]:
    """Figures that must hold for the book to be accepted.

    The limits of the networks guard the stored evidence: they are medians seen before, rounded up, and judge no claim.
    """
    for metric in ("values", "step"):
        deviation = float(evidence["formulas"].values(metric).max())
        yield Acceptance(f"{metric}, against the printed formula", deviation, 1e-10)
    for index, limits in {"w": (0.0015, 0.003), "KCI": (0.022, 0.03)}.items():
        for metric, limit in zip(("between", "fresh"), limits, strict=True):
            median = networks(evidence, index, TRAINED_ON)[metric].median()
            yield Acceptance(f"{index}, printed size, median of the largest error, {metric}", median, limit)


def _on_the_loop(on: Judge, evidence: Evidence) -> Iterator[Verdict]:
    loops = {index: ends(evidence, index) for index in GOALS}
    needed = {index: end["neurons"].where(end["passes"], np.inf) for index, end in loops.items()}
    # The loops of this chapter are cut for KCI; those of the chapter on readings go to the printed limit.
    to_the_limit = whole_loops("KCI", "feed-forward")
    w, kci = (end.query("reading == 'chosen'") for end in (loops["w"], to_the_limit))
    whole = {"w": needed["w"], "KCI": to_the_limit["neurons"].where(to_the_limit["passes"], np.inf)}
    at_smallest = pd.concat([_ends_at_the_smallest(own, "reading") for own in whole.values()])
    in_readings = [_ends_at_the_smallest(ends_of_loops(index), "number") for index in GOALS]
    yield on(
        "feed-forward-design-loop",
        at_smallest,
        "Loops, for both indices, that end at the smallest size at which any of them passes. The first network that passes "
        f"depends on the initial weights; for w such networks have {with_range(w['fresh'], '{:.2%}')} on fresh points.",
        ours=f"{at_smallest['chosen'].sum()} of {len(at_smallest['chosen'])}",
        design=in_design(on, "feed-forward-design-loop", in_readings[0] & in_readings[1]),
    )
    printed_sizes = evidence["printed_sizes"].where(None, kind=AS_PRINTED).set_index(["reading", "seed"])
    for index, end in (("w", w), ("KCI", kci)):
        name, trained = f"feed-forward-{index.lower()}", networks(evidence, index, TRAINED_ON)
        note = f"{end['passes'].sum()} of {len(end)} loops end with a network that passes."
        if index == "KCI":
            note += f" With the fitted tool rate, which is no evidence, they end at {_neurons(to_the_limit.loc[[FAST_TOOL]])}."
        yield on(
            f"{name}-neurons",
            whole[index],
            note,
            unit="neurons",
            ours=_neurons(end),
            design=in_design(on, f"{name}-neurons", ends_of_loops(index)),
        )
        yield on(
            f"{name}-error",
            printed_sizes["testing_error"][printed_sizes["index"] == index],
            f"Networks of the printed size, as printed. Trained on, {with_range(trained['testing_error'], '{:.2%}')} on the "
            f"test set and {with_range(trained['fresh'], '{:.2%}')} on fresh points.",
            form="{:.2%}",
            design=in_design(on, f"{name}-error", design_values(f"{index}_ff_printed_error")),
        )
    more = {name: needed["KCI"][name] > needed["w"][name] for name in needed["w"].index.unique("reading")}
    cut = loops["KCI"]
    yield on(
        "kci-needs-more-neurons",
        by_reading(more),
        f"Loops that were cut at {cut['neurons'].max()} neurons; {cut['passes'].sum()} of {len(cut)} had ended by then. All loops "
        f"for w had, with {with_range(loops['w']['neurons'], '{:g}')} neurons.",
        design=in_design(on, "kci-needs-more-neurons", ends_of_loops("KCI") > ends_of_loops("w")),
    )


def _neurons(end: pd.DataFrame) -> str:
    """Return the neurons at which loops end, and how many go to the limit and find nothing."""
    passed, failed = end["neurons"][end["passes"]], end["neurons"][~end["passes"]]
    parts = [with_range(passed, "{:g}")] if len(passed) else []
    parts += [f"none up to {failed.max():g} in {len(failed)} of {len(end)}"] if len(failed) else []
    return "; ".join(parts) + " neurons" * (len(failed) == 0)


def _on_sizes(on: Judge, evidence: Evidence) -> Iterator[Verdict]:
    printed, trained = (
        evidence["sizes"].by_seed("testing_error", over="neurons", index="w", kind=kind)
        for kind in (AS_PRINTED, TRAINED_ON)
    )
    middle = printed[[6, 7]].min(axis=1)
    beyond = DesignShare.of(ends_of_loops("w"), lambda ends: bool(np.median(ends) > 5))
    yield on(
        "four-and-five-neurons-good",
        {f"{n} neurons": LIMIT < printed[n].median() < middle.median() for n in (4, 5)},
        "Good has to mean above E and yet below six and seven neurons: had four passed E, the printed loop would have ended "
        f"there. Our loops for w end with {with_range(ends(evidence, 'w')['neurons'].xs('chosen'), '{:g}')} neurons. They go beyond "
        f"five in {beyond.count} of the {beyond.readings} readings of the design.",
        ours=_listed(printed[[4, 5, 6, 7]]),
    )
    ended = np.mean(networks(evidence, "w", AS_PRINTED)["mean_square_error"] <= GOALS["w"])
    yield on(
        "six-and-seven-neurons-worse",
        ((middle > printed[8]) & (printed[[4, 5]].max(axis=1) < middle)).to_numpy(),
        f"The printed goal ends {ended:.0%} of the trainings with eight neurons, and more neurons then gain nothing; "
        f"without a goal eight have {trained[8].median():.2%}.",
        ours=_listed(printed[[6, 7, 8]]),
    )
    again = evidence["restarts"].where()["testing_error"]
    rises = (np.diff(trained, axis=1) > 0).mean()
    yield on(
        "initial-weights-decide",
        [bool(again.max() >= 2 * again.min())],
        f"The largest error of {len(again)} restarts on the same data is {again.max() / again.min():.1f} times the "
        f"smallest; twice counts as strongly. With one neuron more the error rises in {rises:.0%} of the cases.",
        ours=with_range(again, "{:.2%}"),
    )
    fresh = evidence["printed_sizes"].by_seed("fresh", over="neurons", index="w", kind=TRAINED_ON)
    holds = (fresh.iloc[:, 0] <= fresh.iloc[:, 1:].min(axis=1)).to_numpy()
    note = "Error on fresh points by number of neurons, trained on."
    yield on("few-neurons-generalise", holds, note, ours=_listed(fresh))


def _listed(errors: pd.DataFrame) -> str:
    return ", ".join(f"{neurons}: {with_range(own, '{:.2%}')}" for neurons, own in errors.items())


def _ends_at_the_smallest(neurons: pd.Series, level: str) -> pd.Series:
    """Return whether loops end at the smallest size at which any of the same reading does."""
    return (neurons == neurons.groupby(level=level).transform("min")) & (neurons < np.inf)


def ends(evidence: Evidence, index: str) -> pd.DataFrame:
    """Return where the loops ended, by reading and seed, and what the networks that they return are worth."""
    last = evidence["loop"].where(None, index=index).groupby(["reading", "seed"], sort=False).last()
    return last.assign(passes=last["testing_error"] <= LIMIT)


def networks(evidence: Evidence, index: str, kind: str) -> pd.DataFrame:
    """Return the rows of networks of the printed size."""
    rows = evidence["printed_sizes"].where(index=index, kind=kind)
    return rows[rows["neurons"] == rows["neurons"].min()]
