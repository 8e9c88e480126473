"""Figures, tables and scenes of the chapter on the kinematics."""

from __future__ import annotations

from collections.abc import Mapping

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import torch
from matplotlib.figure import Figure
from torch import Tensor

from dexterity import robots, scenes
from dexterity.chain import Chain
from dexterity_study.engine.evidence import Evidence
from dexterity_study.engine.table import Table
from dexterity_study.page.markup import Markup
from dexterity_study.page.tables import show, with_range


def screws(chain: Chain) -> Markup:
    """Set the screws of a chain."""
    frame = pd.DataFrame(chain.screws, index=chain.joint_names, columns=["vx", "vy", "vz", "ωx", "ωy", "ωz"])
    return show(frame.assign(kind=chain.kinds), "{:g}")


def vehicle_scene(title: str, q: Tensor, *, axes: bool = True, **options: int) -> scenes.Scene:
    """Set the vehicle with its arm in a configuration, and the box of its body."""
    scene = scenes.Scene(title, **options)
    scene.add_chain(robots.uvms(), q, name="uvms", axes=axes)
    scene.add_box(robots.describe("uvms").vehicle_size or (), on="uvms", joint=6, name="vehicle")
    return scene


def reference_scene() -> scenes.Scene:
    """Set the vehicle at its reference configuration, with a slider for each joint."""
    scene = vehicle_scene("The UVMS at its reference configuration, with sliders", torch.zeros(12))
    scene.add_sliders("uvms")
    return scene


def deviations(table: Table) -> Markup:
    """Set the largest deviations, with their range over the seeds."""
    titles = {
        "forward": "tool pose against scipy.linalg.expm",
        "spatial": "spatial Jacobian against central differences",
        "body": "body Jacobian against central differences",
        "geometric": "geometric Jacobian against central differences",
        "printed": "Eq. 6 as printed against the spatial Jacobian",
        "spatial_last_joint": "spatial Jacobian when the last joint turns",
        "body_last_joint": "body Jacobian when the last joint turns",
    }
    rows = table.where()
    cells = {title: with_range(rows[name], "{:.1e}") for name, title in titles.items()}
    return show(pd.Series(cells, name="largest deviation"))


def changes_of_w(stored: Evidence) -> Figure:
    """Draw by how much each joint alone changes w, for three sets of velocity limits."""
    sets = {
        "unit": "chosen",
        "slow vehicle": "velocity-limits=rov",
        "slow heave": "velocity-limits=slow-heave",
    }
    return changes_by_joint(stored["changes_of_w"], "w", "velocity limits", sets)


def changes_by_joint(table: Table, index: str, legend: str, readings: Mapping[str, str]) -> Figure:
    """Draw by how much each joint alone changes an index, for some readings by their titles."""
    fig, ax = plt.subplots(figsize=(7, 3.6))
    shifts = np.linspace(-0.2, 0.2, len(readings))
    for shift, (title, reading) in zip(shifts, readings.items(), strict=True):
        change = table.where(reading).groupby("joint")["change"].max()
        ax.plot(np.arange(12) + shift, np.maximum(change, 1e-17), "o", label=title)
    ax.axhspan(1e-17, 1e-13, color="0.9", zorder=0)
    ax.text(11.4, 3e-14, "rounding", ha="right", va="top", color="0.35")
    ax.set(yscale="log", ylim=(1e-17, 10), ylabel=f"largest relative change of {index}")
    ax.set(xticks=range(12), xticklabels=robots.uvms().joint_names, xlabel="joint that is redrawn")
    ax.legend(title=legend, loc="center left", bbox_to_anchor=(0.4, 0.45))
    return fig


def w_at_home(stored: Evidence) -> Markup:
    """Set w at the reference configuration, for each reading of the lengths."""
    return show(stored["at_home"].where(None).set_index("reading")["w"].rename("w at home"), "{:.2f}")
