"""Figures, tables and scenes of the chapter on indices and ellipsoids."""

from __future__ import annotations

from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import torch
from matplotlib.figure import Figure

from dexterity import robots, scenes
from dexterity.indices import Ellipsoid, Frame, Index, normalise, velocity_ellipsoid
from dexterity.scenes.colors import COLORS
from dexterity_study.engine.evidence import Evidence
from dexterity_study.engine.table import Table
from dexterity_study.page import figures
from dexterity_study.page.markup import Markup
from dexterity_study.page.tables import over_seeds, show
from dexterity_study.uvms.indices import kink
from dexterity_study.uvms.indices.experiment import MOTIONS, ONES, VEHICLE_LOCKED
from dexterity_study.uvms.kinematics.show import changes_by_joint, vehicle_scene

POSTURE = torch.tensor(np.radians([0, 0, 0, 0, 0, 0, 25, 35, -80, 20, 30, 0]))


def velocity_scene() -> scenes.Scene:
    """Set the velocity ellipsoids of the whole UVMS and of the arm alone, and the ball inside the latter."""
    whole = velocity_ellipsoid(robots.uvms().geometric_jacobian(POSTURE), "translational")
    arm = velocity_ellipsoid(
        normalise(robots.uvms().geometric_jacobian(POSTURE), VEHICLE_LOCKED, ONES), "translational"
    )
    return _ellipsoid_scene(
        "Velocity ellipsoids: whole UVMS, arm alone, and the ball inside",
        (whole, "velocity, whole UVMS", "blue", 0.3),
        (arm, "velocity, arm alone", "orange", 0.3),
        (Ellipsoid(arm.axes, arm.semi_axes[-1:].expand(3)), "ball inside", "bluish green", 0.3),
    )


def _ellipsoid_scene(title: str, *ellipsoids: tuple[Ellipsoid, str, str, float]) -> scenes.Scene:
    scene = vehicle_scene(title, POSTURE, axes=False, height=320)
    tool = robots.uvms().forward(POSTURE)[:3, 3]
    for ellipsoid, name, color, scale in ellipsoids:
        scene.add_ellipsoid(ellipsoid, tool, name=name, color=color, scale=scale)
    return scene


def motions(table: Table) -> Figure:
    """Draw w and KCI along the three motions, each as a share of its largest value."""
    titles = {
        "arm, elbow": "elbow, vehicle locked",
        "UVMS, elbow": "elbow, vehicle free",
        "UVMS, roll": "roll of the vehicle",
    }
    fig, panels = plt.subplots(2, figsize=(figures.WIDTH, 3.6), sharex=True)
    for ax, name in zip(panels, ("w", "kci"), strict=True):
        for values, motion, line in zip(table.array(name)[0], MOTIONS, ("-", "--", "-."), strict=True):
            angle = np.linspace(-90, 90, len(values))
            ax.plot(angle, values / values.max(), line, label=titles[motion] if name == "w" else None)
        ax.set(ylabel=f"{'w' if name == 'w' else 'KCI'} / its largest", ylim=(0, 1.05))
    panels[1].set(xlabel="joint angle from the middle posture [°]", xticks=range(-90, 91, 45))
    fig.legend(loc="outside upper center", ncols=2)
    return fig


def frames_along_y() -> Figure:
    """Draw both indices in two frames while the vehicle starts at different places along y."""
    q = torch.zeros(121, 12)
    q[:, 1] = torch.linspace(-3, 3, 121)
    titles: dict[Frame, str] = {"spatial": "world's origin (paper)", "geometric": "tool"}
    fig, panels = plt.subplots(2, figsize=(figures.WIDTH, 3.4), sharex=True)
    for ax, name in zip(panels, ("manipulability", "kinematic_conditioning"), strict=True):
        for (frame, title), line in zip(titles.items(), ("-", "--"), strict=True):
            label = title if ax is panels[0] else None
            ax.plot(q[:, 1], Index(name, frame).bind(robots.uvms())(q), line, label=label)
        ax.set(ylim=(0, None))
    panels[0].set(ylabel="w", ylim=(0, 16))
    panels[1].set(ylabel="KCI", xlabel="place of the vehicle along y [m]")
    fig.legend(title="index taken about", loc="outside upper center", ncols=2)
    return fig


def agreement(stored: Table, live: Table) -> Markup:
    """Set Kendall's τ between pairs of rankings, over the stored seeds and of a live run."""
    titles = {
        "w against the largest speed of the tool point": "w and the largest speed of the tool",
        "spatial KCI against accuracy of the tool": "spatial KCI and the accuracy of the tool",
        "geometric KCI against accuracy of the tool": "geometric KCI and the accuracy of the tool",
        "KCI, spatial against geometric frame": "spatial KCI and geometric KCI",
        "w, unit joint limits against a slow vehicle": "w with unit joint limits and with a slow vehicle",
    }
    frame = over_seeds(stored.where(), "pair", {"tau": "Kendall's $τ$, stored"}, "{:.2f}")
    frame["live"] = live.where().set_index("pair")["tau"]
    return show(
        frame.loc[list(titles)].rename(index=titles).rename_axis("rankings that are compared"), "{:.2f}"
    )


def changes_of_kci(stored: Evidence) -> Figure:
    """Draw by how much each joint alone changes KCI, about the world's origin and about the tool."""
    frames = {"world's origin (paper)": "chosen", "tool": "which-jacobian=body"}
    return changes_by_joint(stored["changes_of_kci"], "KCI", "KCI is taken about", frames)


def kink_line(at: torch.Tensor) -> Figure:
    """Draw KCI and its two smallest singular values along the vehicle's roll through a kink at `at` (12,)."""
    angles, sigma = kink.line(at, 200)
    fig, (top, bottom) = plt.subplots(2, figsize=(figures.WIDTH, 3.2), sharex=True)
    top.plot(angles, sigma[:, 5] / sigma[:, 0], color=COLORS["blue"], label="KCI")
    bottom.plot(angles, sigma[:, 4], "-", color=COLORS["orange"], label="$σ_5$")
    bottom.plot(angles, sigma[:, 5], "--", color=COLORS["blue"], label="$σ_6$")
    top.set(ylabel="KCI")
    bottom.set(ylabel="singular value", xlabel="roll θy of the vehicle [°]")
    fig.legend(loc="outside upper center", ncols=3)
    return fig


def kink_surface(at: torch.Tensor) -> Figure:
    """Draw the two smallest singular values, each over the largest, above the joints that meet at a kink (12,)."""
    sheet = kink.sheet(at, 25)
    x, y = torch.meshgrid(sheet.first_deg, sheet.second_deg, indexing="ij")
    fig = plt.figure(figsize=(figures.WIDTH, 4.0))
    ax = fig.add_subplot(projection="3d", elev=14, azim=-58)
    names = {4: (COLORS["orange"], "$σ_5/σ_1$"), 5: (COLORS["blue"], "$σ_6/σ_1$ = KCI")}
    look: dict[str, Any] = {
        "rcount": 25,
        "ccount": 25,
        "linewidth": 0.4,
        "edgecolor": "#808080",
        "shade": False,
    }
    for i, (color, label) in names.items():
        height = (sheet.sigma[..., i] / sheet.sigma[..., 0]).numpy()
        ax.plot_surface(x.numpy(), y.numpy(), height, color=color, label=label, **look)
    ticks = (-15, 0, 15)
    ax.set(xticks=ticks, yticks=ticks, xlabel="θy [°]", ylabel="elbow [°]")
    for axis in (ax.xaxis, ax.yaxis, ax.zaxis):
        axis.set_pane_color((0.0, 0.0, 0.0, 0.0))
    fig.legend(loc="outside upper center", ncols=2)
    return fig
