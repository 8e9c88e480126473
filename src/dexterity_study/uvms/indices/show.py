"""Figures, tables and scenes of the chapter on indices and ellipsoids."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
import torch
from matplotlib.figure import Figure

from dexterity import robots, scenes
from dexterity.indices import Ellipsoid, Frame, Index, normalise, velocity_ellipsoid
from dexterity_study.engine.evidence import Evidence
from dexterity_study.engine.table import Table
from dexterity_study.page import figures
from dexterity_study.page.markup import Markup
from dexterity_study.page.tables import over_seeds, show
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
    scene = vehicle_scene(title, POSTURE, axes=False)
    tool = robots.uvms().forward(POSTURE)[:3, 3]
    for ellipsoid, name, color, scale in ellipsoids:
        scene.add_ellipsoid(ellipsoid, tool, name=name, color=color, scale=scale)
    return scene


def motions(table: Table) -> Figure:
    """Draw w and KCI along the three motions, each as a share of its largest value."""
    titles = {
        "arm, elbow": "elbow, vehicle locked",
        "UVMS, elbow": "elbow, vehicle free",
        "UVMS, pitch": "pitch of the vehicle",
    }
    fig, panels = plt.subplots(2, figsize=(figures.WIDTH, 4.4), sharex=True)
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
    fig, panels = plt.subplots(2, figsize=(figures.WIDTH, 3.8), sharex=True)
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
