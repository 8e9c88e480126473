"""Verdicts on the data sets of paper A."""

from __future__ import annotations

from collections.abc import Iterator

import pandas as pd

from dexterity_study.claims.judge import Judge
from dexterity_study.claims.outcome import Acceptance, Verdict
from dexterity_study.engine.evidence import Evidence
from dexterity_study.page.tables import with_range
from dexterity_study.uvms.sampling.experiment import AS_PRINTED, FROM_VEHICLE


def verdicts(evidence: Evidence) -> Iterator[Verdict]:
    """Judge the claims of the chapter."""
    on = Judge("sotiropoulos2016")
    whys = {
        "w": (
            "5 6 7 8 9 10 11",
            "Unit limits; with unequal limits of the translations θ4 would be among them.",
        ),
        "KCI": (
            "1 2 3 4 5 6 7 8 9 10 11",
            "The derivation of the spatial KCI uses every joint but the last.",
        ),
    }
    for index, (printed, why) in whys.items():
        inputs = evidence["values"].where(index=index)["inputs"].iloc[0]
        same = 0.0 if inputs == printed else 1.0
        yield on(f"data-set-{index.lower()}", same, f"Found by derivation. {why}", ours=f"θ {inputs}")
    area = evidence["search_area"]
    assumed, turned = area.where().iloc[0], area.where("base-position-without-rotation=turned").iloc[0]
    yield on(
        "search-area-keeps-task-reachable",
        area.values("reachable") == 1,
        "Whether the arm can be bent to the task point from all configurations. If the base of the turned vehicle is in "
        f"the area, {turned['reachable']:.0%} reach. If the area is applied before the vehicle turns, as assumed, the base "
        f"is {assumed['nearest']:.2g} to {assumed['farthest']:.3g} m away.",
        ours=f"{assumed['reachable']:.0%} of the configurations",
    )
    w, kci = (_rows_needed(evidence, index) for index in ("w", "KCI"))
    yield on(
        "kci-needs-more-data",
        (kci >= 2 * w).to_numpy(),
        "Seeds in which KCI needs at least twice the rows. The sizes are not printed, so the rows are the fewest "
        "tried that either network needs for an error within a quarter of what the most rows give.",
        ours=f"{with_range(kci, '{:g}')} rows against {with_range(w, '{:g}')}",
    )
    yield from _on_extensions(on, evidence)


def _on_extensions(on: Judge, evidence: Evidence) -> Iterator[Verdict]:
    limit = min(on.printed("feed-forward-testing-error-limit"))
    rows = evidence["extensions"].where()
    errors = rows.groupby(["index", "network", "half_width", "neurons"])["fresh"]
    medians, ranges = errors.median(), errors.apply(with_range, form="{:.2g}")
    of_w = medians["w", AS_PRINTED].groupby("half_width").min()
    widest, last = of_w[of_w <= limit].index.max(), ranges["w", AS_PRINTED].index[-1]
    yield on(
        "whole-space-possible",
        {f"±{deg:g}°": bool(of_w[deg] <= limit) for deg in of_w.index[-2:]},
        f"Cases: some network keeps its largest relative error for w within {limit:g}. The widest such range is ±{widest:g}°. "
        f"For ±{last[0]:g}° the error of {last[1]} neurons is {ranges['w', AS_PRINTED][last]}.",
    )
    of_kci = {network: medians["KCI", network].index[-1] for network in (AS_PRINTED, FROM_VEHICLE)}
    far, neurons = of_kci[FROM_VEHICLE]
    as_printed, better = (ranges["KCI", network][last] for network, last in of_kci.items())
    own = evidence["training_sets"].where(index="w", method="grid").groupby("rows")["fresh"].median()
    yield on(
        "any-task-point",
        {
            "w": own.iloc[-1] <= limit,
            "KCI": bool((medians["KCI"].xs(far, level="half_width") <= limit).any()),
        },
        "Cases: indices. w does not depend on the task point, so that nothing need be extended. For KCI the vehicle was "
        f"anywhere within ±{far:g} m. The largest relative error of networks as printed is then {as_printed}; of {neurons} "
        f"neurons with the world's origin in the vehicle frame as input and a cone as readout, {better}.",
    )


def acceptance(evidence: Evidence) -> Iterator[Acceptance]:
    """Figures that must hold for the book to be accepted."""
    area = evidence["search_area"]
    turned = area.where("base-position-without-rotation=turned")["reachable"].min()
    yield Acceptance("share that cannot reach with the turned base in the area", 1 - turned, 0.0)
    yield Acceptance("wrist off the task point [m]", area.where(None)["reaching_error"].max(), 1e-7)


def _rows_needed(evidence: Evidence, index: str) -> pd.Series:
    errors = evidence["training_sets"].by_seed("fresh", over="rows", index=index, method="grid")
    return errors.le(1.25 * errors.iloc[:, -1], axis="index").idxmax(axis="columns")
