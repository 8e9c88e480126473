"""Figures, tables and scenes of the chapter on indices and ellipsoids."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import torch
from matplotlib.figure import Figure

from dexterity import robots, scenes
from dexterity.indices import Ellipsoid, Index, force_ellipsoid, normalise, velocity_ellipsoid
from dexterity.scenes.colors import COLORS
from dexterity_study.engine.evidence import Evidence
from dexterity_study.engine.table import Table
from dexterity_study.page.markup import Markup
from dexterity_study.page.numbers import with_range
from dexterity_study.page.tables import over_seeds, show
from dexterity_study.uvms.indices.experiment import MOTIONS, ONES, VEHICLE_LOCKED
from dexterity_study.uvms.kinematics.experiment import FRAMES
from dexterity_study.uvms.kinematics.show import changes_by_joint, vehicle_scene

POSTURE = torch.tensor(np.radians([0, 0, 0, 0, 0, 0, 25, 35, -80, 20, 30, 0]))


def velocity_scene() -> scenes.Scene:
    """Set the velocity ellipsoids of the whole UVMS and of the arm alone, and the ball inside the latter."""
    whole = velocity_ellipsoid(robots.uvms().geometric_jacobian(POSTURE), "translational")
    arm, _ = _of_the_arm()
    return _ellipsoid_scene(
        "Velocity ellipsoids: whole UVMS, arm alone, and the ball inside",
        (whole, "velocity, whole UVMS", "blue", 0.3),
        (arm, "velocity, arm alone", "orange", 0.3),
        (Ellipsoid(arm.axes, arm.semi_axes[-1:].expand(3)), "ball inside", "bluish green", 0.3),
    )


def force_scene() -> scenes.Scene:
    """Set the velocity ellipsoid and the force ellipsoid of the arm alone."""
    speed, force = _of_the_arm()
    title = "The arm alone: velocity ellipsoid and force ellipsoid"
    return _ellipsoid_scene(
        title, (speed, "velocity", "orange", 0.3), (force, "force", "reddish purple", 0.06)
    )


def _ellipsoid_scene(title: str, *ellipsoids: tuple[Ellipsoid, str, str, float]) -> scenes.Scene:
    scene = vehicle_scene(title, POSTURE, axes=False)
    tool = robots.uvms().forward(POSTURE)[:3, 3]
    for ellipsoid, name, color, scale in ellipsoids:
        scene.add_ellipsoid(ellipsoid, tool, name=name, color=color, scale=scale)
    return scene


def semi_axes() -> Markup:
    """Set the semi-axes of both ellipsoids of the arm alone."""
    speed, force = _of_the_arm()
    lengths = {"speed": speed.semi_axes, "force": force.semi_axes}
    return show(pd.DataFrame(lengths, index=["fastest axis", "middle axis", "slowest axis"]), "{:.2f}")


def _of_the_arm() -> tuple[Ellipsoid, Ellipsoid]:
    J = normalise(robots.uvms().geometric_jacobian(POSTURE), VEHICLE_LOCKED, ONES)
    return velocity_ellipsoid(J, "translational"), force_ellipsoid(J, "translational")


def motions(table: Table) -> Figure:
    """Draw w and KCI along the three motions."""
    fig, axes = plt.subplots(2, 3, figsize=(7.5, 4.6), sharex="col")
    angle, w, kci = (table.array(name)[0] for name in ("angle", "w", "kci"))
    for i, ((above, below), (name, motion)) in enumerate(zip(axes.T, MOTIONS.items(), strict=True)):
        above.plot(angle[i], w[i])
        below.plot(angle[i], kci[i], color=COLORS["vermillion"])
        above.set(title=name, ylim=(0, None))
        below.set(xlabel=f"{robots.uvms().joint_names[motion.joint]} [degree]", ylim=(0, None))
    axes[0, 0].set_ylabel("w")
    axes[1, 0].set_ylabel("KCI, spatial")
    return fig


def singularity_scene() -> scenes.Scene:
    """Move the pitch through the singularity of the whole UVMS and back."""
    motion = MOTIONS["UVMS, pitch"]
    sweep = motion.configurations(motion.angles(60))
    scene = vehicle_scene("The pitch passes through a singularity of the UVMS", sweep[0], height=480)
    scene.add_path(robots.uvms().forward(sweep)[:, :3, 3], name="tool path")
    scene.animate("uvms", torch.cat([sweep, sweep.flip(0)]))
    return scene


def frames_along_y() -> Figure:
    """Draw both indices in three frames while the vehicle starts at different places along y."""
    q = torch.zeros(121, 12)
    q[:, 1] = torch.linspace(-3, 3, 121)
    fig, (left, right) = plt.subplots(1, 2, figsize=(7.5, 3.2))
    for name, ax in (("manipulability", left), ("kinematic_conditioning", right)):
        for frame in FRAMES:
            line = "--" if frame == "geometric" else "-"
            ax.plot(q[:, 1], Index(name, frame).bind(robots.uvms())(q), line, label=frame)
        ax.set(xlabel="vehicle starts at y [m]", ylim=(0, None))
    left.set(ylabel="w", ylim=(0, 16))
    right.set_ylabel("KCI")
    right.legend()
    return fig


def agreement(stored: Evidence) -> Markup:
    """Set Kendall's τ between pairs of rankings."""
    return show(over_seeds(stored["rankings"].where(), "pair", {"tau": "Kendall's τ"}, "{:.2f}"))


def changes_of_kci(stored: Evidence) -> Figure:
    """Draw by how much each joint alone changes KCI, in the spatial and in the body frame."""
    frames = {"spatial": "chosen", "body": "which-jacobian=body"}
    return changes_by_joint(stored["changes_of_kci"], "KCI", "frame", frames)


def kci_at_home(stored: Evidence) -> Markup:
    """Set KCI at home in three frames, and its range while the vehicle starts elsewhere."""
    rows = stored["conditioning"].where()
    values = {str(frame): with_range(rows[f"home_{frame}"], "{:.3f}") for frame in FRAMES}
    values["spatial, lowest with the vehicle within 2 m"] = f"{rows['lowest'].min():.3f}"
    values["spatial, highest with the vehicle within 2 m"] = f"{rows['highest'].max():.3f}"
    return show(pd.Series(values, name="KCI at home"))
