"""Figures and tables of the chapter on the area manipulability."""

from __future__ import annotations

import matplotlib.pyplot as plt
import pandas as pd
from matplotlib.figure import Figure

from dexterity.scenes.colors import COLORS
from dexterity_study.claims.ledger import load_paper
from dexterity_study.docking.area.experiment import ANGLES, COMPARED
from dexterity_study.docking.area.verdicts import matches
from dexterity_study.docking.cases import ARMS, CORNERS
from dexterity_study.engine.evidence import Evidence
from dexterity_study.engine.table import Table
from dexterity_study.page import figures
from dexterity_study.page.markup import Markup
from dexterity_study.page.tables import show

AREA = (-0.2, 0.2, -0.2, 0.2)
_PLATE = {"facecolor": "#E6E6E6", "edgecolor": "none", "pad": 1.5}
ARM_COLORS = {"stated": COLORS["blue"], "fitted": COLORS["vermillion"]}


def by_arm(table: Table) -> pd.DataFrame:
    """Return the rows of both arms under their names."""
    rows = {arm: table.where(reading) for arm, reading in ARMS.items()}
    return pd.concat(rows, names=["arm"]).reset_index("arm").drop(columns=["reading", "seed"])


def runs(stored: Evidence) -> Figure:
    """Draw the area manipulability at the poses of Table 3, printed and ours, and the largest possible w."""
    printed = load_paper("sotiropoulos2011").printed("area-manipulability-of-runs")
    ours = by_arm(stored["runs"]).pivot(index="run", columns="arm", values="area")
    caps = by_arm(stored["closed_form"]).set_index("arm")["cap"]
    fig, ax = plt.subplots(figsize=(figures.WIDTH, 3.4))
    bars = ax.bar(ours.index, printed, color="#808080", width=0.5, label="printed")
    for (arm, color), shift in zip(ARM_COLORS.items(), (-0.1, 0.1), strict=True):
        ax.plot(ours.index + shift, ours[arm], "o", color=color, clip_on=False, label=f"ours, {arm} arm")
    for arm, color in ARM_COLORS.items():
        ax.axhline(caps[arm], color=color, ls="--", label=f"maximum, {arm} arm")
    ax.set(xlabel="run of Table 3", ylabel="area manipulability [m³]", xticks=ours.index, ylim=(0, 0.2))
    ax.grid(visible=False, axis="x")
    fig.legend(handles=[bars, *ax.lines], loc="outside upper center", ncols=2)
    return fig


def angles(stored: Evidence) -> Markup:
    """Set how many angles of Table 4 match the nearest branch, and how far they put the tool off the corner."""
    rows = by_arm(stored["angles"]).set_index(["corner", "arm"])
    misses = rows[[ANGLES[i] for i in COMPARED]].astype(float)
    table = pd.DataFrame(
        {
            "angles that match, of 5": matches(rows).where(misses.notna().any(axis=1)).astype(float),
            "largest difference [rad]": misses.abs().max(axis=1),
            "tool off the corner [mm]": 1e3 * rows["off"],
        }
    )
    table = pd.concat({f"{arm} arm": table.xs(arm, level="arm") for arm in ARMS}, axis=1)
    forms = dict(zip(table.columns, 2 * ["{:.0f}", "{:.3f}", "{:.1f}"], strict=True))
    return show(table, forms=forms)


def maps(stored: Evidence) -> Figure:
    """Draw the largest w over the task area for both arms, at the first pose and at the ill-placed one."""
    fig, panels = plt.subplots(2, 2, figsize=(figures.WIDTH, 4.8), sharex=True, sharey=True)
    cap = max(stored["closed_form"].where(reading)["cap"].item() for reading in ARMS.values())
    for row, (arm, reading) in zip(panels, ARMS.items(), strict=True):
        maps = stored["maps"].array("w", reading)[0]
        for ax, w, title in zip(row, maps, ("first run", "ill placed"), strict=True):
            image = ax.imshow(w.T, origin="lower", extent=AREA, vmin=0, vmax=cap)
            ax.contour(w.T, levels=[1e-9], extent=AREA, colors=COLORS["vermillion"])
            for corner, (x, y, _) in CORNERS.items():
                ax.text(0.82 * x, 0.82 * y, corner, ha="center", va="center", bbox=_PLATE)
            ax.set(title=title if arm == "stated" else "", xlabel="x [m]", ylabel=f"{arm} arm\ny [m]")
            ax.set(xticks=[-0.2, 0, 0.2], yticks=[-0.2, 0, 0.2])
            ax.grid(visible=False)
            ax.label_outer()
    fig.colorbar(image, ax=panels, location="bottom", label="largest w [m³]", aspect=30)
    return fig


def control_points(stored: Evidence, live: Table) -> Markup:
    """Set how much of what control points promise holds inside the area, by their number, and a live run."""
    heads = {"kept": "value left, median [%]", "dead": "poses with a dead spot [%]"}
    rows = by_arm(stored["control_points"]).pivot(index="points", columns="arm", values=[*heads])
    columns = {
        (f"{arm} arm", head): 100 * rows[metric, arm].astype(float)
        for arm in ARMS
        for metric, head in heads.items()
    }
    dead = 100 * live.where().set_index("points")["dead"].astype(float)
    columns["stated arm", "poses with a dead spot, live [%]"] = dead
    table = pd.DataFrame(columns)[["stated arm", "fitted arm"]].rename_axis("control points")
    return show(table, "{:.1f}", forms={name: "{:.0f}" for name in table.columns if name[1] == heads["kept"]})
