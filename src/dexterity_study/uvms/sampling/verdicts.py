"""Verdicts on the data sets of paper A."""

from __future__ import annotations

from collections.abc import Iterator

from dexterity_study.claims.judge import Judge
from dexterity_study.claims.outcome import Acceptance, Verdict
from dexterity_study.engine.evidence import Evidence
from dexterity_study.page.numbers import with_range
from dexterity_study.uvms.feed_forward.experiment import AS_PRINTED
from dexterity_study.uvms.sampling.experiment import FROM_VEHICLE

TURNED = "base-position-without-rotation=turned"


def verdicts(evidence: Evidence) -> Iterator[Verdict]:
    """Judge the claims of the chapter."""
    on = Judge("sotiropoulos2016")
    inputs = evidence["values"].where().set_index("index")["inputs"]
    for index, printed, why in (
        ("w", range(5, 12), "Unit limits; with unequal limits of the translations θ4 would be among them."),
        ("KCI", range(1, 12), "The derivation of the spatial KCI uses every joint but the last."),
    ):
        differs = float(inputs[index] != " ".join(map(str, printed)))
        note = f"Found by derivation. {why}"
        yield on(f"data-set-{index.lower()}", differs, note, ours=f"θ {inputs[index]}")
    area = evidence["search_area"]
    assumed, turned = area.where().iloc[0], area.where(TURNED).iloc[0]
    yield on(
        "search-area-keeps-task-reachable",
        area.values("reachable") == 1,
        "Whether the arm can be bent to the task point from all configurations. If the base of the turned vehicle is in "
        f"the area, {turned['reachable']:.0%} reach. If the area is applied before the vehicle turns, as assumed, the base "
        f"is {assumed['nearest']:.2g} to {assumed['farthest']:.3g} m away.",
        ours=f"{assumed['reachable']:.0%} of the configurations",
    )
    errors = {
        index: evidence["training_sets"].by_seed("fresh", over="rows", index=index, method="grid")
        for index in ("w", "KCI")
    }
    w, kci = (e.le(1.25 * e.iloc[:, -1], axis="index").idxmax(axis="columns") for e in errors.values())
    yield on.out_of_scope(
        "kci-needs-more-data",
        "It says what the authors did, and no size is printed. Ours are the fewest rows tried that give an error within a "
        "quarter of what the most rows give.",
        f"{with_range(kci, '{:g}')} rows against {with_range(w, '{:g}')}",
    )
    limit = min(on.printed("feed-forward-testing-error-limit"))
    cases = evidence["extensions"].where().groupby(["index", "network", "half_width", "neurons"])["fresh"]
    medians, ranges = cases.median(), cases.apply(with_range, form="{:.2g}")
    of_w = medians["w", AS_PRINTED].groupby("half_width").min()
    (widest, most), error = ranges["w", AS_PRINTED].index[-1], ranges["w", AS_PRINTED].iloc[-1]
    yield on(
        "whole-space-possible",
        {f"±{deg:g}°": bool(of_w[deg] <= limit) for deg in of_w.index[-2:]},
        f"Cases: some network keeps its largest relative error for w within {limit:g}. The widest such range is "
        f"±{of_w[of_w <= limit].index.max():g}°. For ±{widest:g}° the error of {most} neurons is {error}.",
    )
    printed, better = (ranges["KCI", network].iloc[-1] for network in (AS_PRINTED, FROM_VEHICLE))
    far, neurons = medians["KCI", FROM_VEHICLE].index[-1]
    of_kci = medians["KCI"].xs(far, level="half_width")
    yield on(
        "any-task-point",
        {"w": errors["w"].iloc[:, -1].median() <= limit, "KCI": bool((of_kci <= limit).any())},
        "Cases: indices. w does not depend on the task point, so that nothing need be extended. For KCI the vehicle was "
        f"anywhere within ±{far:g} m. The largest relative error of networks as printed is then {printed}; of {neurons} "
        f"neurons with the world's origin in the vehicle frame as input and a cone as readout, {better}.",
    )


def acceptance(evidence: Evidence) -> Iterator[Acceptance]:
    """Figures that must hold for the book to be accepted."""
    turned = evidence["search_area"].where(TURNED)["reachable"].min()
    yield Acceptance("share that cannot reach with the turned base in the area", 1 - turned, 0.0)
