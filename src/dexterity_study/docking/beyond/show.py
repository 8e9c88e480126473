"""Figures and tables of the chapter on more points, a tilted vehicle and a wall."""

from __future__ import annotations

from collections.abc import Sequence

import matplotlib.pyplot as plt
import pandas as pd
from matplotlib.figure import Figure

from dexterity import docking, robots
from dexterity.docking import DockingProblem
from dexterity.scenes.colors import COLORS
from dexterity.search import ZoomOptions
from dexterity_study.docking.beyond.experiment import genetic
from dexterity_study.docking.beyond.verdicts import shares
from dexterity_study.docking.cases import CASES, arm_of
from dexterity_study.docking.search.show import LABELS, STYLES, written
from dexterity_study.engine.evidence import Evidence
from dexterity_study.page.markup import Markup
from dexterity_study.page.tables import show, with_range

POSE = ["x", "y", "z", "roll", "pitch", "psi"]


def points(stored: Evidence) -> Markup:
    """Set the best pose by number of control points, and what it is worth on finer grids."""
    rows = stored["points"].where(None)
    heads = {"at_points": "at the points [m³]", "fine": "on 21 × 21 [m³]", "finest": "on 161 × 161 [m³]"}
    table = pd.DataFrame(
        {"x, y, z [m], ψ [rad]": rows[["x", "y", "z", "psi"]].apply(written, axis="columns")}
    )
    table[[*heads.values()]] = rows[[*heads]]
    table["dead [%]"] = (100 * rows["dead"]).map("{:.2g}".format)
    table.index = [
        f"{LABELS[one]}, {n} points" for one, n in zip(rows["reading"], rows["points"], strict=True)
    ]
    return show(table, "{:.4f}")


def weakest_spots(stored: Evidence, per_side: int = 81) -> Figure:
    """Draw the largest w over the area at the best poses for four and for nine points, and its weakest spot."""
    fig, panels = plt.subplots(2, 2, figsize=(6.8, 6), sharex=True, sharey=True)
    for row, variant in zip(panels, ("stated", "fitted"), strict=True):
        reading = CASES[f"{variant}, or"]
        best = stored["points"].where(reading).set_index("points")
        for ax, count in zip(row, (4, 9), strict=True):
            pose = best[["x", "y", "z", "psi"]].loc[count].to_numpy()
            square = docking.square(0.2, per_side)
            w = docking.largest_manipulability(arm_of(genetic.reading(reading)), pose, square)
            options = {"origin": "lower", "extent": (-0.2, 0.2, -0.2, 0.2), "vmin": 0}
            image = ax.imshow(w.reshape(per_side, per_side).mT, vmax=1.5 * best["at_points"].max(), **options)
            ax.plot(*square[w.argmin(), :2], "o", color=COLORS["vermillion"], clip_on=False)
            ax.set(title=f"{variant} arm, {count} points", xlabel="x [m]", ylabel="y [m]")
            ax.label_outer()
        fig.colorbar(image, ax=row, label="largest w [m³]")
    return fig


def rates(stored: Evidence) -> Markup:
    """Set how many poses a second are rated, by number of control points."""
    rate = stored["rates"].where().set_index("points")["rate"].rename("{} points".format)
    return show(pd.DataFrame({"poses a second": rate, "slower than with 4": rate.iloc[0] / rate}), "{:.3g}")


def by_tilt(stored: Evidence) -> Figure:
    """Draw the best M_a as roll and pitch are set free."""
    fig, ax = plt.subplots(figsize=(6.8, 3.2))
    for case, reading in CASES.items():
        flat = stored["points"].where(reading, points=4)["at_points"]
        hover = stored["optimum"].where(reading, face="top").set_index("tilt")["area_manipulability"]
        best = pd.concat([flat.set_axis([0.0]), hover])
        ax.plot(best.index, best, marker="o", ms=3, label=case, **STYLES[case])
    ax.set(xlabel="largest roll and pitch [rad]", ylabel="best M_a [m³]", ylim=(0, None))
    ax.legend()
    return fig


def optimum(stored: Evidence, face: str) -> Markup:
    """Set the best poses of the extensions on a face, and what genetic runs make of them."""
    best = stored["optimum"].where(None, face=face).set_index(["reading", "face", "tilt"])
    runs = 100 * shares(stored)
    hovers = face == "top"
    scale = 1 / DockingProblem.manipulability_weight if hovers else 1
    table = {
        "x, y, z [m], (roll, pitch,) ψ [rad]": best.reindex(columns=POSE).apply(written, axis="columns"),
        "M_a [m³]": best["area_manipulability"],
        **({} if hovers else {"fitness": best["value"]}),
        "by evolution": best["evolved"] * scale,
        **({"lowest point [mm]": (1e3 * best["lowest"]).map("{:.0f}".format)} if hovers else {}),
        "genetic [% of the best]": [with_range(runs.loc[one], "{:.1f}") for one in best.index],
    }
    names = [f"{LABELS[one]}, tilt to {tilt} rad" if hovers else LABELS[one] for one, _, tilt in best.index]
    return show(pd.DataFrame(table).set_axis(names), "{:.4f}")


def room_to_turn(yaws: Sequence[float]) -> Markup:
    """Search the best pose of the fitted arm before a wall, with more and more room to turn [rad]."""
    options = ZoomOptions(starts=2, stages=60, shrink=0.8)
    rows = {}
    for yaw in yaws:
        arm = robots.docking_arm("fitted")
        problem = DockingProblem(arm, region="or", face="side", yaw=(-yaw, yaw), distance_weight=0.0)
        best = docking.global_docking(problem, [0.1, 0.1, 0.1, 0.2], options)
        rows[f"yaw to {yaw} rad"] = {"M_a [m³]": best.area_manipulability, "ψ [rad]": best.pose[3].item()}
    return show(pd.DataFrame.from_dict(rows, orient="index"))
