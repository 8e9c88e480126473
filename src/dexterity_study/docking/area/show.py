"""Figures and tables of the chapter on the area manipulability."""

from __future__ import annotations

import matplotlib.pyplot as plt
import pandas as pd
from matplotlib.figure import Figure
from torch import Tensor

from dexterity.scenes.colors import COLORS
from dexterity_study.claims.ledger import load_paper
from dexterity_study.docking.area.experiment import ANGLES, COMPARED
from dexterity_study.docking.area.verdicts import matches
from dexterity_study.docking.cases import ARMS
from dexterity_study.engine.evidence import Evidence
from dexterity_study.engine.table import Table
from dexterity_study.page.markup import Markup
from dexterity_study.page.tables import show

AREA = (-0.2, 0.2, -0.2, 0.2)


def at_corners(w: Tensor) -> Markup:
    """Set the largest w [m³] at the four corners (4), in the order of `docking.square`."""
    return show(pd.Series(w.numpy(), list("KLNM"), name="largest w [m³]"), "{:.4f}")


def by_arm(table: Table) -> pd.DataFrame:
    """Return the rows of both arms under their names."""
    rows = {arm: table.where(reading) for arm, reading in ARMS.items()}
    return pd.concat(rows, names=["arm"]).reset_index("arm").drop(columns=["reading", "seed"])


def angles(stored: Evidence) -> Markup:
    """Set by how much the angles of Table 4 miss the nearest branch, and the corner."""
    rows = by_arm(stored["angles"]).sort_values("corner", kind="stable").set_index(["corner", "arm"])
    columns = [*(ANGLES[i] for i in COMPARED), "off the corner [m]"]
    rows = rows.rename(columns={"off": columns[-1]})[columns]
    return show(rows.assign(match=matches(rows)), "{:.4f}")


def runs(stored: Evidence) -> Markup:
    """Set the area manipulability at the poses of Table 3, and the largest w at any pose."""
    rows = by_arm(stored["runs"]).pivot(index="arm", columns="run", values="area")[::-1]
    rows["largest possible"] = by_arm(stored["closed_form"]).set_index("arm")["cap"]
    printed = load_paper("sotiropoulos2011").printed("area-manipulability-of-runs")
    return show(pd.concat([pd.DataFrame([printed], index=["printed"], columns=rows.columns[:-1]), rows]))


def maps(stored: Evidence) -> Figure:
    """Draw the largest w over the task area for both arms, at the first pose and at the ill-placed one."""
    fig, panels = plt.subplots(2, 2, figsize=(6.8, 6), sharex=True, sharey=True)
    for row, (arm, reading) in zip(panels, ARMS.items(), strict=True):
        cap = stored["closed_form"].where(reading)["cap"].item()
        maps = stored["maps"].array("w", reading)[0]
        for ax, w, title in zip(row, maps, ("first run", "ill placed"), strict=True):
            image = ax.imshow(w.T, origin="lower", extent=AREA, vmin=0, vmax=cap)
            ax.contour(w.T, levels=[1e-9], extent=AREA, colors=COLORS["vermillion"])
            ax.set(title=f"{arm} arm, {title}", xlabel="x [m]", ylabel="y [m]")
            ax.label_outer()
        fig.colorbar(image, ax=row, label="largest w [m³]")
    return fig


def control_points(stored: Evidence, live: Table) -> Markup:
    """Set how much of what control points promise holds inside the area, by their number."""
    rows = pd.concat([by_arm(stored["control_points"]), live.where().assign(arm="stated, live")])
    rows = 100 * rows.set_index(["arm", "points"])[["kept", "worst", "dead"]]
    return show(rows.set_axis(["kept, median [%]", "kept, worst [%]", "poses with a dead spot [%]"], axis=1))
