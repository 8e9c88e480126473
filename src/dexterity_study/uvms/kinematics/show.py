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
from dexterity_study.page import figures
from dexterity_study.page.markup import Markup
from dexterity_study.page.tables import show, stored_and_live


def screws(chain: Chain) -> Markup:
    """Set the screws of a chain, its joints under the paper's symbols and under their names."""
    symbols = pd.Index([rf"$\theta_{{{n}}}$" for n in range(1, chain.joints + 1)], name="paper")
    frame = pd.DataFrame(
        chain.screws.numpy(), symbols, ["$v_x$", "$v_y$", "$v_z$", "$ω_x$", "$ω_y$", "$ω_z$"]
    )
    frame.insert(0, "name", chain.joint_names)
    return show(frame, "{:.2f}")


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


def deviations(stored: Table, live: Table) -> Markup:
    """Set the largest deviations, with their range over the stored seeds, and of one live run."""
    titles = {
        "forward": "tool pose − scipy.linalg.expm",
        "spatial": "spatial Jacobian − central differences",
        "body": "body Jacobian − central differences",
        "geometric": "geometric Jacobian − central differences",
        "printed": "Eq. 6 as printed − spatial Jacobian",
        "spatial_last_joint": "spatial Jacobian, last joint turned",
        "body_last_joint": "body Jacobian, last joint turned",
    }
    return show(stored_and_live(stored.where(), live.where(), titles, "{:.0e}"))


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
    fig, ax = plt.subplots(figsize=(figures.WIDTH, 3.6))
    shifts = np.linspace(-0.2, 0.2, len(readings))
    for shift, (title, reading) in zip(shifts, readings.items(), strict=True):
        change = table.where(reading).groupby("joint")["change"].max()
        ax.plot(np.arange(12) + shift, np.maximum(change, 1e-17), "o", label=title)
    ax.axhspan(1e-17, 1e-13, color="#E6E6E6", zorder=0)
    ax.set(yscale="log", ylim=(1e-17, 10), ylabel=f"largest relative change of {index}")
    ax.set_xticks(range(12), robots.uvms().joint_names, rotation=60)
    ax.set(xlabel="joint that is redrawn")
    fig.legend(title=legend, loc="outside upper center", ncols=len(readings))
    return fig


def w_at_home(stored: Evidence) -> Markup:
    """Set w at the reference configuration, for each reading of the lengths."""
    return show(stored["at_home"].where(None).set_index("reading")["w"].rename("w at home"), "{:.2f}")
