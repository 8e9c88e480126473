"""Verdicts on the maps of the PUMA 560 of paper C."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import pandas as pd

from dexterity_study.claims.judge import Judge
from dexterity_study.claims.outcome import Acceptance, Verdict
from dexterity_study.engine.evidence import Evidence
from dexterity_study.engine.readings import Reading
from dexterity_study.workspace.puma.experiment import ALIGNED, NOTIONS, RANDOM

READING: Mapping[str, Any] = Reading.chosen("liao2018")


def verdicts(evidence: Evidence) -> Iterator[Verdict]:
    """Judge the claims of the chapter."""
    on = Judge("liao2018")
    yield from _on_notions(on, evidence["notions"].where().set_index("arm"))
    yield from _on_maps(on, evidence)


def acceptance(evidence: Evidence) -> Iterator[Acceptance]:  # noqa: ARG001
    """Figures that must hold for the book to be accepted; there are none."""
    yield from ()


def worst_of_maps(evidence: Evidence) -> pd.DataFrame:
    """Return the smallest intersection over union of both classes and maps, and the larger error of w, by network."""
    rows = evidence["learned"].where()
    groups = rows[rows["case"].isin((ALIGNED, RANDOM))].groupby("network", sort=False)
    overlap = groups[["reached", "unreached"]].min().min(axis=1)
    return pd.DataFrame({"overlap": overlap, "error": groups["median_error"].max()})


def _on_notions(on: Judge, arms: pd.DataFrame) -> Iterator[Verdict]:
    volumes = arms[list(NOTIONS)].astype(float)
    neither = volumes.loc["neither"]
    order = volumes.loc["limits and tool", ["reachable", "total_orientation", "dexterous"]]
    alike = bool((neither == neither.iloc[0]).all())
    note = (
        f"Without limits or a tool all are {neither['reachable']:.2g} m³; with both they are "
        f"{', '.join(f'{size:.2g}' for size in order)} m³ (reachable, within 45° of down, dexterous)."
    )
    apart = bool((order.diff().iloc[1:] < 0).all())
    yield on("five-notions", {"one without limits or a tool": alike, "apart with both": apart}, note)
    parted = bool((arms["mean_share"].iloc[1:] < 1).all())
    note = (
        "The paper's arms have every orientation wherever they reach, so that one picture in space shows all."
    )
    cases = {"with limits or a tool": parted, "the paper's arms": not alike}
    yield on("six-dimensions-undrawable", cases, note)
    yield on.not_run("workspace-functions", "The paper's library was not run; ours has all five notions.")


def _on_maps(on: Judge, evidence: Evidence) -> Iterator[Verdict]:
    worst = worst_of_maps(evidence)
    least, most = READING["varies-slightly"]
    fits, precise = worst["overlap"] >= least, worst["error"] <= most
    in_reach = evidence["exact"].where()["share_reached"].iloc[0]
    overlap = ", ".join(f"{name}: {value:.3f}" for name, value in worst["overlap"].items())
    error = ", ".join(f"{name}: {value:.2%}" for name, value in worst["error"].items())
    note = (
        "The paper's networks were not trained at their size, so that its figure is not drawn again. Our networks have a "
        f"smallest intersection over union of {overlap}, and an error of w of {error}."
    )
    yield on.not_run("puma-maps-alike", note)
    note = (
        f"Smallest intersection over union of two networks of ours. {in_reach:.0%} of the cube are in reach, so that the "
        "cells out of reach decide. The confidence draws the workspace, the Jacobian has no part in it."
    )
    yield on("workspace-from-jacobian", fits.to_dict(), note, ours=overlap)
    note = "Median error of w of two networks of ours, in shares of its largest value."
    yield on("manipulability-from-estimate", precise.to_dict(), note, ours=error)
